//! What surrounds every screen: the way through, messages, status and shortcuts.

use egui::{
    Align, Button, CentralPanel, Frame, Key, KeyboardShortcut, Layout, Margin, Modifiers, Panel, ProgressBar, RichText,
    Stroke, Ui,
};

use super::plot::ticks::percent;
use super::screens::{self, Screen};
use super::state::{Busy, Desk, Order, Tone};
use super::theme::{BODY, GAP, GROUP, Palette, SMALL};
use super::widgets;

const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
const STOP: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::Escape);
const THEME: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::T);

/// The orders that were given by keys.
pub fn shortcuts(ctx: &egui::Context) -> Vec<Order> {
    let mut orders = Vec::new();
    // Redo by Ctrl+Shift+Z has to be asked for first: Ctrl+Z would match it too.
    let general = [
        (REDO_TOO, Order::Redo),
        (REDO, Order::Redo),
        (UNDO, Order::Undo),
        (OPEN, Order::OpenDialog),
        (STOP, Order::Stop),
        (THEME, Order::ToggleTheme),
    ];
    // While text is typed, undo is the text's own.
    let typing = ctx.text_edit_focused();
    let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];
    ctx.input_mut(|input| {
        for (shortcut, order) in general {
            if !typing && input.consume_shortcut(&shortcut) {
                orders.push(order);
            }
        }
        for (key, screen) in keys.into_iter().zip(Screen::ALL) {
            if input.consume_shortcut(&KeyboardShortcut::new(Modifiers::COMMAND, key)) {
                orders.push(Order::Show(screen));
            }
        }
    });
    orders
}

/// Draws the whole window.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    let bar = Frame::new().fill(palette.card).inner_margin(Margin::symmetric(14, 8));
    Panel::top("way").frame(bar).exact_size(46.0).resizable(false).show(ui, |ui| top_bar(ui, desk));
    let bar = Frame::new().fill(palette.card).inner_margin(Margin::symmetric(14, 4));
    Panel::bottom("status").frame(bar).exact_size(32.0).resizable(false).show(ui, |ui| status_bar(ui, desk));
    let ground = Frame::new().fill(palette.background).inner_margin(Margin::same(GROUP as i8));
    CentralPanel::default().frame(ground).show(ui, |ui| {
        notices(ui, desk);
        screens::show(ui, desk);
    });
    drop_hint(ui);
}

fn top_bar(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    ui.horizontal_centered(|ui| {
        ui.label(RichText::new("Torquescope").size(BODY + 2.0).color(palette.text));
        ui.add_space(GROUP);
        let next = Screen::next(desk.session, desk.state.screen);
        for (number, screen) in Screen::ALL.into_iter().enumerate() {
            if number > 0 {
                ui.label(RichText::new("›").color(palette.weak));
            }
            let current = desk.state.screen == screen;
            let is_next = next == Some(screen);
            let color = if current || is_next { palette.accent } else { palette.weak };
            let mark = if is_next { "  →" } else { "" };
            let mut button =
                Button::new(RichText::new(format!("{}{mark}", screen.title())).color(color)).selected(current);
            if !current {
                button = button.fill(egui::Color32::TRANSPARENT);
            }
            let stroke = if is_next { Stroke::new(1.0, palette.accent) } else { Stroke::NONE };
            let shortcut = format!("{} (Ctrl+{})", screen.purpose(), number + 1);
            let response = ui.add(button.stroke(stroke)).on_hover_text(shortcut);
            response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, current, screen.title()));
            if response.clicked() {
                desk.orders.push(Order::Show(screen));
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let dark = ui.visuals().dark_mode;
            let theme = if dark { "Light" } else { "Dark" };
            if ui.button(theme).on_hover_text("Change between light and dark (Ctrl+T)").clicked() {
                desk.orders.push(Order::ToggleTheme);
            }
            let text = desk.redo.map_or("Nothing to redo".to_owned(), |change| format!("Redo: {change} (Ctrl+Y)"));
            if ui
                .add_enabled(desk.redo.is_some(), Button::new("Redo"))
                .on_hover_text(&text)
                .on_disabled_hover_text(&text)
                .clicked()
            {
                desk.orders.push(Order::Redo);
            }
            let text = desk.undo.map_or("Nothing to undo".to_owned(), |change| format!("Undo: {change} (Ctrl+Z)"));
            if ui
                .add_enabled(desk.undo.is_some(), Button::new("Undo"))
                .on_hover_text(&text)
                .on_disabled_hover_text(&text)
                .clicked()
            {
                desk.orders.push(Order::Undo);
            }
            if ui.button("Open…").on_hover_text("Open recordings, CSV or NPZ (Ctrl+O), or drop them here").clicked() {
                desk.orders.push(Order::OpenDialog);
            }
        });
    });
}

fn status_bar(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    ui.horizontal_centered(|ui| {
        let small = |text: String| RichText::new(text).size(SMALL).color(palette.weak);
        match desk.session.recording.as_deref() {
            None => drop(ui.label(small("no recording".into()))),
            Some(recording) => {
                let joints = recording.joint_count();
                let joints = if joints == 1 { "1 joint".to_owned() } else { format!("{joints} joints") };
                let samples = thousands(recording.sample_count());
                ui.label(small(format!("{} · {joints} · {samples} samples", recording.name)));
            }
        }
        if let Some(step) = desk.session.current() {
            ui.separator();
            let terms: Vec<String> = step.fitted.model.terms.iter().map(crate::model::Term::label).collect();
            let shown =
                if terms.len() > 2 { format!("{} + {} effects", terms[0], terms.len() - 1) } else { terms.join(" + ") };
            ui.label(small(format!("model: {shown}"))).on_hover_text(terms.join(" + "));
            ui.separator();
            let errors: Vec<String> = step.evaluation.held_out_nmse().into_iter().map(percent).collect();
            ui.label(small(format!("held-out error by joint (nMSE): {}", errors.join(" · "))));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let Some(Busy { name, progress, paused, .. }) = desk.busy else {
                ui.label(small("ready".into()));
                return;
            };
            if ui.add(Button::new("Stop").small()).on_hover_text("Stop this; nothing is changed (Esc)").clicked() {
                desk.orders.push(Order::Stop);
            }
            ui.add(ProgressBar::new(progress.fraction).desired_width(160.0).desired_height(8.0));
            let name = if *paused { format!("paused: {name}") } else { name.clone() };
            let activity = if progress.activity.is_empty() { name } else { format!("{name}: {}", progress.activity) };
            ui.add(egui::Label::new(RichText::new(activity).size(SMALL).color(palette.text)).truncate());
        });
    });
}

/// Messages stand above the screen until they are dismissed.
fn notices(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    for (number, notice) in desk.state.notices.iter().enumerate() {
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
                    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                    if button.on_hover_text("Dismiss").clicked() {
                        desk.orders.push(Order::Dismiss(number));
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

/// While files hover over the window: what happens when they are dropped.
fn drop_hint(ui: &mut Ui) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let palette = Palette::in_ui(ui);
    let rect = ui.ctx().content_rect();
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint"));
    let painter = ui.ctx().layer_painter(layer);
    painter.rect_filled(rect, 0, palette.background.gamma_multiply(0.85));
    let font = egui::FontId::proportional(super::theme::HEADLINE);
    painter.text(rect.center(), egui::Align2::CENTER_CENTER, "Drop to open as one recording", font, palette.accent);
}

/// 12345 as `12 345`.
pub fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}
