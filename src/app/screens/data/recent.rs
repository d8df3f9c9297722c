//! What one can go on with: what other windows left behind, and what was opened and saved of late.

use egui::{Align, Button, Layout, Ui, WidgetInfo};

use crate::app::desk::{Desk, Order, Question};
use crate::app::widgets;

/// The list, unless there is nothing in it.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    if desk.copies.is_empty() && desk.recent.is_empty() {
        return;
    }
    let idle = desk.busy.is_none();
    widgets::card(ui, "Go on with", |ui| {
        for copy in desk.copies {
            let label = copy.label();
            // A row, no higher than its buttons.
            let row = |ui: &mut Ui| {
                let throw = ui.add(Button::new("×").small());
                let spoken = format!("Throw away {label}");
                throw.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &spoken));
                if throw.on_hover_text(&spoken).clicked() {
                    desk.orders.push(Question::throw_away(copy));
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    let go_on = ui.add_enabled(idle, Button::new(&label).truncate());
                    if go_on.on_hover_text("It is in no file").clicked() {
                        desk.orders.push(Order::Recover(copy.path.clone()));
                    }
                });
            };
            ui.horizontal(|ui| ui.with_layout(Layout::right_to_left(Align::Center), row));
        }
        for recent in desk.recent {
            let open = ui.add_enabled(idle, Button::new(recent.name()).truncate());
            if open.on_hover_text(recent.place()).clicked() {
                desk.orders.push(Order::run(recent.open()));
            }
        }
    });
}
