//! All lessons, one of which is begun.

use egui::{Button, DragValue, Grid, Modal, RichText, ScrollArea, Ui, WidgetInfo};

use crate::app::desk::Order;
use crate::app::shell::frame::Shell;
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;
use crate::lesson::{Lesson, catalogue};

/// The list, while it is open.
pub struct Choosing {
    lessons: Vec<Lesson>,
    seed: u64,
}

impl Default for Choosing {
    fn default() -> Self {
        Choosing { lessons: catalogue::all().collect(), seed: 1 }
    }
}

/// The list of all lessons, while it is open.
pub fn list(ui: &mut Ui, shell: &mut Shell, place: &mut Option<Choosing>) {
    let Some(mut open) = place.take() else { return };
    let palette = Palette::in_ui(ui);
    let mut is_over = false;
    let room = ui.ctx().content_rect();
    let modal = Modal::new(egui::Id::unique("lessons")).show(ui.ctx(), |ui| {
        ui.set_width((room.width() - 80.0).min(660.0));
        ui.heading("Lessons");
        widgets::weak(
            ui,
            "On the same screens that real work is done on. What you say first is locked in; then you see.",
        );
        ui.add_space(GAP);
        ui.horizontal(|ui| {
            let label = ui.label("Your seed");
            ui.add(DragValue::new(&mut open.seed).range(0..=9_999_999)).labelled_by(label.id);
            widgets::weak(ui, "each has another arm");
        });
        ui.add_space(GAP);
        let height = (room.height() - 220.0).max(80.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            Grid::new("lessons").striped(true).spacing([12.0, 8.0]).show(ui, |ui| {
                for lesson in &open.lessons {
                    let begin = ui.add_enabled(shell.desk.busy.is_none(), Button::new("Begin"));
                    let name = format!("Begin lesson {}", lesson.number);
                    begin.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &name));
                    if begin.clicked() {
                        shell.desk.orders.push(Order::BeginLesson(lesson.id.clone(), open.seed));
                        is_over = true;
                    }
                    ui.label(RichText::new(lesson.number.to_string()).color(palette.weak));
                    ui.vertical(|ui| {
                        ui.set_width(ui.available_width().max(380.0));
                        let title = format!("{} · {} min", lesson.title, lesson.minutes);
                        ui.label(RichText::new(title).color(palette.text));
                        widgets::weak(ui, &lesson.summary);
                    });
                    ui.end_row();
                }
            });
        });
        ui.add_space(GAP);
        is_over |= ui.button("Close").clicked();
    });
    if !is_over && !modal.should_close() {
        *place = Some(open);
    }
}
