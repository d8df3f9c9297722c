//! The highlighted button. There is one at a time: the next step, or the answer that a question suggests. Screens have none, so that
//! nothing on them competes with it.

use egui::{Button, Response, RichText, Stroke, Ui};

use crate::app::theme::Palette;

/// The highlighted button.
pub fn primary(ui: &mut Ui, enabled: bool, text: &str) -> Response {
    let palette = Palette::in_ui(ui);
    let button = Button::new(RichText::new(text).color(palette.on_accent)).fill(palette.accent).stroke(Stroke::NONE);
    ui.add_enabled(enabled, button)
}
