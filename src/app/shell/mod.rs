//! What surrounds every screen: the tools, the way through, messages and status.

mod actions;
mod bar;
mod export;
mod keys;
mod messages;
mod palette;
mod status;

use egui::{CentralPanel, Frame, Margin, Panel, Ui};

pub use export::Exporting;
pub use keys::shortcuts;
pub use palette::CommandPalette;

use super::screens;
use super::state::Desk;
use super::theme::{GROUP, Palette};

/// Draws the whole window.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    let bar = |x, y| Frame::new().fill(palette.card).inner_margin(Margin::symmetric(x, y));
    Panel::top("tools").frame(bar(14, 4)).resizable(false).show(ui, |ui| bar::tools(ui, desk));
    Panel::top("way").frame(bar(14, 5)).resizable(false).show(ui, |ui| bar::way(ui, desk));
    Panel::bottom("status").frame(bar(14, 4)).resizable(false).show(ui, |ui| status::show(ui, desk));
    let room = if is_narrow(ui) { GROUP / 2.0 } else { GROUP };
    let ground = Frame::new().fill(palette.background).inner_margin(Margin::same(room as i8));
    CentralPanel::default().frame(ground).show(ui, |ui| {
        messages::notices(ui, desk);
        screens::show(ui, desk);
    });
    export::show(ui, desk);
    messages::toasts(ui, desk);
    messages::drop_hint(ui);
    palette::show(ui, desk);
    keys::list(ui, desk);
}

/// Whether the window, at this size of text, has no room for long names side by side.
pub fn is_narrow(ui: &Ui) -> bool {
    ui.ctx().content_rect().width() < 1100.0
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
