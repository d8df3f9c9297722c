//! The two bars at the top: the tools, and the way through the screens with the highlighted next step.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{
    Align, Button, Color32, CursorIcon, KeyboardShortcut, Label, Layout, PopupCloseBehavior, RichText, ScrollArea,
    Sense, Stroke, Ui, WidgetInfo,
};

use super::actions::BEGIN_ANEW;
use super::frame::Shell;
use super::keys;
use super::primary::primary;
use crate::app::desk::{Desk, Order};
use crate::app::screen::NextStep;
use crate::app::theme::{self, BODY, GAP, Palette};
use crate::app::widgets::is_narrow;
use crate::recording::read::READABLE;
use crate::session::Command;

/// With less room than this only the tools stand in their bar \[points\].
const ROOM_FOR_NAME: f32 = 700.0;

pub fn tools(ui: &mut Ui, shell: &mut Shell) {
    let desk = &mut shell.desk;
    ui.horizontal(|ui| {
        // The title bar has the name, too.
        if ui.available_width() > ROOM_FOR_NAME {
            name(ui, desk);
            ui.add_space(GAP);
        }
        let keys = keys::text(ui, &keys::OPEN);
        let open = format!("Open recordings ({READABLE}) with {keys}, or drop them on the window");
        if ui.button("Open…").on_hover_text(open).clicked() {
            desk.orders.push(Order::OpenDialog);
        }
        let save = format!("Save the session ({})", keys::text(ui, &keys::SAVE));
        let full = desk.session.recording.is_some();
        if ui.add_enabled(full, Button::new("Save…")).on_hover_text(save).clicked() {
            desk.orders.push(Order::SaveDialog);
        }
        step_button(ui, desk, "Undo", shell.undo, &keys::UNDO, Order::Undo);
        step_button(ui, desk, "Redo", shell.redo, &keys::REDO, Order::Redo);
        let count = desk.session.all_models().count();
        let models =
            format!("Name, compare, use and delete the models of this session ({})", keys::text(ui, &keys::MODELS));
        let button = Button::new(format!("Models ({count})")).selected(shell.has_models_open);
        if ui.add_enabled(count > 0, button).on_hover_text(models).clicked() {
            desk.orders.push(Order::Models(!shell.has_models_open));
        }
        let hint = "Short lessons on these screens: predict, do, see why";
        let lessons = Button::new("Lessons").selected(desk.session.study.is_some());
        if ui.add(lessons).on_hover_text(hint).clicked() {
            desk.orders.push(Order::Lessons(true));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
            let menu = MenuButton::new("View").config(stays).ui(ui, |ui| {
                let height = ui.ctx().content_rect().height() - 60.0;
                let scroll = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
                scroll.show(ui, |ui| view(ui, desk));
            });
            menu.0.on_hover_text("Panels, theme, contrast, size of text");
            let all = format!("Find any command by its name ({})", keys::text(ui, &keys::PALETTE));
            if ui.button("Commands").on_hover_text(all).clicked() {
                desk.orders.push(Order::Palette(true));
            }
        });
    });
}

/// The name of the program, which leads back to where one begins; not while something is at work.
fn name(ui: &mut Ui, desk: &mut Desk) {
    let name = Label::new(RichText::new("Torquescope").size(BODY + 2.0).color(Palette::in_ui(ui).text));
    if desk.session.recording.is_none() || desk.busy.is_some() {
        ui.add(name);
        return;
    }
    let name = ui.add(name.sense(Sense::click()));
    name.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, "Torquescope"));
    if name.on_hover_cursor(CursorIcon::PointingHand).on_hover_text(BEGIN_ANEW).clicked() {
        desk.run(Command::BeginAnew);
    }
}

/// Undo or redo: `change` is what it is about. While something is at work, the session stays as it is.
fn step_button(ui: &mut Ui, desk: &mut Desk, name: &str, change: Option<&str>, key: &KeyboardShortcut, order: Order) {
    let what = change.map_or(format!("Nothing to {}", name.to_lowercase()), |change| format!("{name}: {change}"));
    let text = format!("{what} ({})", keys::text(ui, key));
    let why_not =
        desk.busy.filter(|_| change.is_some()).map_or(what, |busy| format!("“{}” is still at work", busy.name));
    let button = ui.add_enabled(change.is_some() && desk.busy.is_none(), Button::new(name));
    if button.on_hover_text(text).on_disabled_hover_text(why_not).clicked() {
        desk.orders.push(order);
    }
}

/// Theme, contrast, size of text.
fn view(ui: &mut Ui, desk: &mut Desk) {
    let dark = ui.visuals().dark_mode;
    for (name, value) in [("Dark", true), ("Light", false)] {
        if ui.radio(dark == value, name).clicked() && dark != value {
            desk.orders.push(Order::ToggleTheme);
        }
    }
    let mut high = theme::is_high_contrast(ui.ctx());
    if ui.checkbox(&mut high, "High contrast").changed() {
        desk.orders.push(Order::HighContrast(high));
    }
    ui.separator();
    let percent = (100.0 * ui.ctx().zoom_factor()).round() as u32;
    ui.label("Size of text");
    ui.horizontal(|ui| {
        for size in [80, 100, 125, 150, 200] {
            if ui.selectable_label(percent == size, format!("{size} %")).clicked() {
                desk.orders.push(Order::TextScale(size as f32 / 100.0));
            }
        }
    });
    ui.separator();
    ui.label("Panels of this screen");
    for (name, mut shown) in desk.panels.panels() {
        if ui.checkbox(&mut shown, name).changed() {
            desk.panels.set_shown(name, shown);
        }
    }
    if ui.button("Put them back").on_hover_text("Every panel where it stood at first").clicked() {
        desk.orders.push(Order::ResetPanels);
    }
    ui.separator();
    if ui.button(format!("Keyboard shortcuts ({})", keys::text(ui, &keys::LIST))).clicked() {
        desk.orders.push(Order::KeyList(true));
    }
}

/// The screens, left to right, and the next step. Where there is no room for all names in a line, they stand in two.
pub fn way(ui: &mut Ui, shell: &mut Shell) {
    let next = shell.next();
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            next_step(ui, shell, next.as_ref());
            ui.with_layout(Layout::left_to_right(Align::Center).with_main_wrap(true), |ui| {
                ui.spacing_mut().item_spacing.x = 3.0;
                ui.spacing_mut().button_padding.x = if is_narrow(ui) { 5.0 } else { 7.0 };
                steps(ui, shell, next.as_ref());
            });
        });
    });
}

fn steps(ui: &mut Ui, shell: &mut Shell, next: Option<&NextStep>) {
    let palette = Palette::in_ui(ui);
    let leads_to = next.and_then(|next| if let Order::Show(screen) = next.order { Some(screen) } else { None });
    for (number, (about, screen)) in shell.screens.iter().enumerate() {
        let current = shell.screens.shown() == about;
        let is_next = leads_to == Some(about);
        let done = screen.is_done(shell.desk.session);
        let color = match (current || is_next, done) {
            (true, _) => palette.accent,
            (_, true) => palette.text,
            _ => palette.weak,
        };
        if number > 0 {
            ui.label(RichText::new("›").color(palette.weak));
        }
        let mark = if done && !current { "✔ " } else { "" };
        let text = RichText::new(format!("{mark}{}", about.title)).color(color);
        let mut button = Button::new(text).selected(current);
        if !current {
            button = button.fill(Color32::TRANSPARENT);
        }
        let stroke = if is_next { Stroke::new(1.0, palette.accent) } else { Stroke::NONE };
        let hint = format!("{}: {} (Ctrl+{})", about.title, about.purpose, number + 1);
        let response = ui.add(button.stroke(stroke)).on_hover_text(hint);
        response.widget_info(|| WidgetInfo {
            current_text_value: done.then(|| "done".to_owned()),
            ..WidgetInfo::selected(egui::Role::Button, true, current, about.title)
        });
        if response.clicked() {
            shell.desk.orders.push(Order::Show(about));
        }
    }
    ui.label(RichText::new("›").color(palette.weak));
    export(ui, shell, next.is_some_and(|next| matches!(next.order, Order::Export(_))));
}

fn next_step(ui: &mut Ui, shell: &mut Shell, next: Option<&NextStep>) {
    let palette = Palette::in_ui(ui);
    let Some(next) = next else {
        let (text, color) = match (shell.screens.withhold(shell.desk.session), shell.exported) {
            (true, _) => ("place your bet", palette.accent),
            (false, true) => ("✔ the way is done", palette.good),
            (false, false) => ("go on in the lesson", palette.accent),
        };
        ui.label(RichText::new(text).color(color));
        return;
    };
    let text = if is_narrow(ui) { "Next →".to_owned() } else { format!("Next: {} →", next.label) };
    let button = primary(ui, shell.desk.busy.is_none() && !shell.is_covered, &text);
    let name = format!("Next: {}", next.label);
    button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &name));
    let hint = format!("{}. {} ({})", next.label, next.why, keys::text(ui, &keys::NEXT));
    if button.on_hover_text(&hint).on_disabled_hover_text("Something is at work; see below").clicked() {
        shell.desk.orders.push(next.order.clone());
    }
}

/// The end of the way: plots, a report, a model or data as files.
fn export(ui: &mut Ui, shell: &mut Shell, is_next: bool) {
    let palette = Palette::in_ui(ui);
    let done = shell.exported;
    let color = match (is_next, done) {
        (true, _) => palette.accent,
        (_, true) => palette.text,
        _ => palette.weak,
    };
    let name = if done { "✔ Export" } else { "Export" };
    let stroke = if is_next { Stroke::new(1.0, palette.accent) } else { Stroke::NONE };
    let button = Button::new(RichText::new(name).color(color)).fill(Color32::TRANSPARENT).stroke(stroke);
    let response = ui.add(button);
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, "Export"));
    let hint = format!(
        "The plots of this screen, a report, a model as code or in a robot's file, or the data ({})",
        keys::text(ui, &keys::EXPORT)
    );
    if response.on_hover_text(hint).clicked() {
        shell.desk.orders.push(Order::Export(None));
    }
}
