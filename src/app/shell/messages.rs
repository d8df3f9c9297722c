//! What the program has to say: notices that stay, toasts that pass, and the hint while files hover over the window.

use egui::{Align, Align2, Area, Button, Frame, Layout, Margin, RichText, Stroke, Ui, WidgetInfo, vec2};

use super::frame::Shell;
use crate::app::desk::{Order, Tone};
use crate::app::theme::{GAP, HEADLINE, Palette};
use crate::app::widgets;

/// Notices stand above the screen until they are dismissed.
pub fn notices(ui: &mut Ui, shell: &mut Shell) {
    let palette = Palette::in_ui(ui);
    if shell.left_behind {
        let frame = Frame::new()
            .fill(palette.card)
            .stroke(Stroke::new(1.0, palette.accent))
            .corner_radius(6)
            .inner_margin(Margin::symmetric(12, 8));
        frame.show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.label("The program ended unexpectedly the last time. Its session was kept.");
                if widgets::primary(ui, shell.desk.busy.is_none(), "Restore it").clicked() {
                    shell.desk.orders.push(Order::Recover(true));
                }
                if ui.button("Leave it").clicked() {
                    shell.desk.orders.push(Order::Recover(false));
                }
            });
        });
        ui.add_space(GAP);
    }
    for (number, notice) in shell.messages.notices.iter().enumerate() {
        let (word, color) = match notice.tone {
            Tone::Info => ("Note", palette.accent),
            Tone::Warning => ("Careful", palette.warning),
            Tone::Error => ("Error", palette.error),
        };
        let frame = Frame::new()
            .fill(palette.card)
            .stroke(Stroke::new(1.0, color))
            .corner_radius(6)
            .inner_margin(Margin::symmetric(12, 8));
        frame.show(ui, |ui| {
            ui.horizontal(|ui| {
                widgets::chip(ui, word, color);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let name = format!("Dismiss message {}", number + 1);
                    let button = ui.add(Button::new("×").small());
                    button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &name));
                    if button.on_hover_text("Dismiss").clicked() {
                        shell.desk.orders.push(Order::Dismiss(number));
                    }
                    ui.with_layout(Layout::left_to_right(Align::Center).with_main_wrap(true), |ui| {
                        ui.label(&notice.text);
                        if !notice.remedy.is_empty() {
                            widgets::weak(ui, &notice.remedy);
                        }
                    });
                });
            });
        });
        ui.add_space(GAP);
    }
}

/// What was just done, in a corner, for a few seconds.
pub fn toasts(ui: &mut Ui, shell: &mut Shell) {
    let now = ui.input(|input| input.time);
    shell.messages.toasts.retain(|toast| toast.until > now);
    let Some(first) = shell.messages.toasts.iter().map(|toast| toast.until).reduce(f64::min) else { return };
    let palette = Palette::in_ui(ui);
    let area =
        Area::new(egui::Id::unique("toasts")).anchor(Align2::RIGHT_BOTTOM, vec2(-16.0, -44.0)).interactable(false);
    area.show(ui.ctx(), |ui| {
        for toast in &shell.messages.toasts {
            let frame = Frame::new()
                .fill(palette.card)
                .stroke(Stroke::new(1.0, palette.good))
                .corner_radius(6)
                .inner_margin(Margin::symmetric(12, 8));
            frame.show(ui, |ui| {
                ui.set_max_width(360.0);
                ui.label(RichText::new(format!("✔ {}", toast.text)).color(palette.text));
            });
        }
    });
    ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64((first - now).max(0.01)));
}

/// While files hover over the window: what happens when they are dropped.
pub fn drop_hint(ui: &mut Ui) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let palette = Palette::in_ui(ui);
    let rect = ui.ctx().content_rect();
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint"));
    let painter = ui.ctx().layer_painter(layer);
    painter.rect_filled(rect, 0, palette.background.gamma_multiply(0.85));
    let font = egui::FontId::proportional(HEADLINE);
    painter.text(rect.center(), Align2::CENTER_CENTER, "Drop to open as one recording", font, palette.accent);
}
