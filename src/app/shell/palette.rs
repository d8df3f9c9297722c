//! The command palette: every command by its name.

use egui::{Key, RichText, ScrollArea, TextEdit, Ui, WidgetInfo};

use super::actions;
use super::frame::Shell;
use super::hanging::hanging;
use crate::app::desk::Order;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;

/// What was typed, and which line is chosen.
#[derive(Debug, Default)]
pub struct CommandPalette {
    text: String,
    chosen: usize,
}

pub fn show(ui: &mut Ui, shell: &mut Shell, place: &mut Option<CommandPalette>) {
    let Some(mut open) = place.take() else { return };
    let palette = Palette::in_ui(ui);
    let words: Vec<String> = open.text.to_lowercase().split_whitespace().map(str::to_owned).collect();
    let mut found = actions::all(shell);
    found.retain(|action| {
        let name = action.name.to_lowercase();
        words.iter().all(|word| name.contains(word))
    });
    let moved = ui.input_mut(|input| {
        let mut pressed = |key| i32::from(input.consume_key(egui::Modifiers::NONE, key));
        pressed(Key::ArrowDown) - pressed(Key::ArrowUp)
    });
    open.chosen = open.chosen.saturating_add_signed(moved as isize).min(found.len().saturating_sub(1));
    let entered = ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Enter));
    let mut clicked = None;
    let room = ui.ctx().content_rect();
    let modal = hanging("command palette").show(ui.ctx(), |ui| {
        ui.set_width((room.width() - 80.0).min(520.0));
        let edit = TextEdit::singleline(&mut open.text).hint_text("Type a command").desired_width(f32::INFINITY);
        let edit = ui.add(edit);
        edit.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, true, "Command"));
        if edit.changed() {
            open.chosen = 0;
        }
        let is_typed = edit.changed();
        edit.request_focus();
        ui.add_space(GAP);
        if found.is_empty() {
            widgets::weak(ui, "No command has all these words in its name.");
        }
        let height = (room.height() - 180.0).clamp(80.0, 380.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            for (number, action) in found.iter().enumerate() {
                let chosen = number == open.chosen;
                let keys = RichText::new(action.keys).size(SMALL).color(palette.weak);
                let width = ui.available_width();
                let button =
                    egui::Button::selectable(chosen, &action.name).right_text(keys).min_size(egui::vec2(width, 0.0));
                let line = ui.add(button);
                line.widget_info(|| WidgetInfo::selected(egui::Role::Button, true, chosen, &action.name));
                // What is typed leaves another list, whose chosen line has to be seen too.
                if chosen && (moved != 0 || is_typed) {
                    line.scroll_to_me(None);
                }
                if line.clicked() {
                    clicked = Some(number);
                }
            }
        });
    });
    if entered && !found.is_empty() {
        clicked = Some(open.chosen);
    }
    match clicked {
        Some(number) => {
            if let Some(action) = found.into_iter().nth(number) {
                shell.desk.orders.extend([Order::Palette(false), action.order]);
            }
        }
        None if modal.should_close() => (),
        None => *place = Some(open),
    }
}
