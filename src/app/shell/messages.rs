//! What the program has to say: notices that stay, toasts that pass, and the hint while files hover over the window.

use egui::{Align, Align2, Area, Button, Frame, Layout, Margin, RichText, Stroke, Ui, WidgetInfo, vec2};

use super::frame::Shell;
use crate::app::desk::{Order, Question, Tone};
use crate::app::keeper::Copy;
use crate::app::theme::{GAP, HEADLINE, Palette};
use crate::app::widgets;

/// How many of the sessions that others left are offered above a screen.
const MOST_COPIES: usize = 3;

/// Notices stand above the screen until they are dismissed.
pub fn notices(ui: &mut Ui, shell: &mut Shell) {
    let palette = Palette::in_ui(ui);
    if !shell.copies_hidden {
        left_behind(ui, shell, palette);
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
                        if let Some((name, order)) = &notice.offer
                            && ui.button(name).clicked()
                        {
                            shell.desk.orders.extend([Order::clone(order), Order::Dismiss(number)]);
                        }
                    });
                });
            });
        });
        ui.add_space(GAP);
    }
}

/// What other windows left behind: what a crash left always, what was closed while there is nothing else to do. It stays where it
/// is until somebody goes on with it or throws it away.
fn left_behind(ui: &mut Ui, shell: &mut Shell, palette: &Palette) {
    let is_empty = shell.desk.session.recording.is_none();
    let is_due = |copy: &&Copy| !copy.note.closed || is_empty;
    let due: Vec<&Copy> = shell.desk.copies.iter().filter(is_due).take(MOST_COPIES).collect();
    if due.is_empty() {
        return;
    }
    let frame = Frame::new()
        .fill(palette.card)
        .stroke(Stroke::new(1.0, palette.accent))
        .corner_radius(6)
        .inner_margin(Margin::symmetric(12, 8));
    frame.show(ui, |ui| {
        for (number, copy) in due.into_iter().enumerate() {
            ui.horizontal_wrapped(|ui| {
                let (name, label) = (&copy.note.name, copy.label());
                ui.label(match copy.note.closed {
                    true => format!("{name} was closed without being saved."),
                    false => format!("The program ended unexpectedly, but {name} was kept."),
                });
                let ready = shell.desk.busy.is_none();
                let go_on = format!("Go on with {label}");
                if ui.add_enabled(ready, Button::new(go_on)).clicked() {
                    shell.desk.orders.push(Order::Recover(copy.path.clone()));
                }
                if ui.button(format!("Throw {name} away")).on_hover_text(&label).clicked() {
                    shell.desk.orders.push(Question::throw_away(copy));
                }
                let hint = "They stay where they are: the next start offers them again, and so does the Data screen";
                if number == 0 && ui.button("Not now").on_hover_text(hint).clicked() {
                    shell.desk.orders.push(Order::HideCopies);
                }
            });
        }
    });
    ui.add_space(GAP);
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
            let (mark, color) = match toast.tone {
                Tone::Info => ("✔ ", palette.good),
                Tone::Warning | Tone::Error => ("", palette.warning),
            };
            let frame = Frame::new()
                .fill(palette.card)
                .stroke(Stroke::new(1.0, color))
                .corner_radius(6)
                .inner_margin(Margin::symmetric(12, 8));
            frame.show(ui, |ui| {
                ui.set_max_width(360.0);
                ui.label(RichText::new(format!("{mark}{}", toast.text)).color(palette.text));
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
