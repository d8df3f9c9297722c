//! The torque as the sum of its parts, each in the colour of its line: pointing at one lights its line in all charts.

use egui::Ui;

use super::parts::Part;
use crate::app::theme::Palette;
use crate::app::{math, widgets};

/// Shows the sum; gives the name of the part that is pointed at.
pub fn show<'a>(ui: &mut Ui, parts: &'a [Part]) -> Option<&'a str> {
    let palette = Palette::in_ui(ui);
    let mut lit = None;
    ui.horizontal_wrapped(|ui| {
        math::show(ui, r"\hat\tau =", "τ̂ =", palette.weak);
        let own = parts.iter().enumerate().filter(|(_, part)| part.own.is_some());
        for (place, (number, part)) in own.enumerate() {
            if place > 0 {
                math::show(ui, "+", "+", palette.weak);
            }
            // In a sum a part does not say again that it is a torque.
            let [tex, plain] = part.formula;
            let tex = tex.strip_prefix(r"\tau = ").unwrap_or(tex);
            let plain = plain.strip_prefix("tau = ").unwrap_or(plain);
            let shown = math::show(ui, tex, &widgets::formula(plain), palette.nth(number).0);
            if shown.on_hover_text(&part.name).hovered() {
                lit = Some(part.name.as_str());
            }
        }
    });
    lit
}
