//! Small parts that all screens are made of.

use egui::{
    Align, Color32, Frame, Layout, Margin, Popup, ProgressBar, Response, RichText, SetOpenCommand, Stroke, Ui,
    WidgetText,
};

use super::glossary;
use super::theme::{CHIP, GAP, HEADLINE, Palette, RADIUS, SMALL, TITLE};
use crate::figure::table::{Table, TableFormat};

/// A headline with a sentence below it.
pub fn headline(ui: &mut Ui, title: &str, sentence: &str) {
    let palette = Palette::in_ui(ui);
    ui.label(RichText::new(title).size(HEADLINE).color(palette.text));
    if !sentence.is_empty() {
        glossary::weak(ui, sentence);
    }
    ui.add_space(GAP);
}

/// A group of content with a title.
pub fn card<R>(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui) -> R) -> R {
    let palette = Palette::in_ui(ui);
    let frame = Frame::new()
        .fill(palette.card)
        .stroke(Stroke::new(1.0, palette.border))
        .corner_radius(RADIUS + 2)
        .inner_margin(Margin::symmetric(14, 12));
    let inner = frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        if !title.is_empty() {
            ui.label(RichText::new(title).size(TITLE).color(palette.text));
            ui.add_space(2.0);
        }
        content(ui)
    });
    ui.add_space(GAP - 2.0);
    inner.inner
}

/// How far something is.
pub fn progress(ui: &mut Ui, share: f32, width: f32) {
    let bar = ProgressBar::new(share).desired_width(width).desired_height(8.0).fill(Palette::in_ui(ui).accent);
    ui.add(bar);
}

/// Text of less weight.
pub fn weak(ui: &mut Ui, text: impl Into<String>) -> Response {
    ui.label(RichText::new(text).color(Palette::in_ui(ui).weak))
}

/// A formula of an effect's file in the letters of formulas: `tau_c * sign(qd)` as `τ_c sign(q̇)`.
pub fn formula(plain: &str) -> String {
    let mut text = plain.replace(" * ", " ").replace("^2", "²");
    for (name, letter) in [("tau", "τ"), ("qdd", "q̈"), ("qd", "q̇"), ("omega", "ω"), ("phi", "φ"), ("sigma", "σ")]
    {
        text = text.replace(name, letter);
    }
    text
}

/// With a capital at its beginning.
pub fn sentence_case(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Several things in a sentence: `a, b and c`.
pub fn in_a_sentence(things: &[String]) -> String {
    match things {
        [others @ .., last] if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => things.concat(),
    }
}

/// A word in a coloured frame; the word tells the same as the colour.
pub fn chip(ui: &mut Ui, text: &str, color: Color32) -> Response {
    let frame = Frame::new()
        .fill(color.gamma_multiply(CHIP))
        .stroke(Stroke::new(1.0, color.gamma_multiply(0.6)))
        .corner_radius(4)
        .inner_margin(Margin::symmetric(6, 1));
    frame.show(ui, |ui| ui.label(RichText::new(text).size(SMALL).color(color))).response
}

/// Least and most room between the columns of a table.
const LEAST_BETWEEN: f32 = 4.0;
const MOST_BETWEEN: f32 = 16.0;

/// A table: header, then rows. Numbers are aligned at their right, texts at their left.
pub fn table(ui: &mut Ui, id: &str, header: &[&str], rows: &[Vec<WidgetText>]) {
    let palette = Palette::in_ui(ui);
    let key = ui.scope_id().with((id, header, rows.len()));
    let texts = |row: &Vec<WidgetText>| row.iter().map(|cell| cell.text().to_owned()).collect();
    let table = Table {
        title: String::new(),
        head: header.iter().map(|title| (*title).to_owned()).collect(),
        rows: rows.iter().map(texts).collect(),
    };
    let header: Vec<WidgetText> =
        header.iter().map(|title| RichText::new(*title).size(SMALL).color(palette.weak).into()).collect();
    let width = |cell: &WidgetText| {
        let galley = cell.clone().into_galley(ui, None, f32::INFINITY, egui::TextStyle::Body);
        galley.size().x.ceil()
    };
    // While its numbers change a column keeps the most room that it had: each change of width costs a frame.
    let before: Vec<f32> = ui.data(|data| data.get_temp(key)).unwrap_or_else(|| vec![0.0; header.len()]);
    let widths: Vec<f32> = (0..header.len())
        .map(|column| {
            let cells = rows.iter().filter_map(|row| row.get(column)).chain([&header[column]]);
            cells.map(width).fold(before[column], f32::max)
        })
        .collect();
    ui.data_mut(|data| data.insert_temp(key, widths.clone()));
    let layouts: Vec<Layout> = (0..header.len())
        .map(|column| match table.is_number(column) {
            true => Layout::right_to_left(Align::Center),
            false => Layout::left_to_right(Align::Center),
        })
        .collect();
    // A table that is too wide by itself is scrolled: then there is room enough.
    let free = (ui.available_width() - widths.iter().sum::<f32>()) / header.len().max(1) as f32;
    let spacing = if free < LEAST_BETWEEN { MOST_BETWEEN } else { free.min(MOST_BETWEEN) };
    let grid = egui::Grid::new(id).striped(true).num_columns(header.len()).spacing([spacing, 6.0]);
    let shown = grid.show(ui, |ui| {
        for row in std::iter::once(&header).chain(rows) {
            for (column, cell) in row.iter().enumerate().take(widths.len()) {
                let size = egui::vec2(widths[column], 18.0);
                ui.allocate_ui_with_layout(size, layouts[column], |ui| {
                    ui.set_min_width(size.x);
                    ui.add(egui::Label::new(cell.clone()).extend());
                });
            }
            ui.end_row();
        }
    });
    copied(ui, &shown.response, id, || table);
}

/// The menu of a table, which copies it; a right click anywhere on the table opens it, also on what else is clicked there.
pub fn copied(ui: &Ui, shown: &Response, id: &str, table: impl FnOnce() -> Table) {
    let asked = ui.rect_contains_pointer(shown.rect) && ui.input(|input| input.pointer.secondary_clicked());
    let menu = Popup::context_menu(shown).id(ui.scope_id().with(("menu of a table", id)));
    let menu = menu.open_memory(asked.then_some(SetOpenCommand::Bool(true))).at_pointer_fixed();
    let chosen = menu.show(|ui| {
        let asks = |(format, name, _): &(TableFormat, &str, &str)| {
            ui.button(format!("Copy as {name}")).clicked().then_some(*format)
        };
        TableFormat::ALL.iter().filter_map(asks).last()
    });
    if let Some(format) = chosen.and_then(|chosen| chosen.inner) {
        ui.ctx().copy_text(table().to_text(format));
    }
}

/// What an empty screen says, and its way out.
pub fn empty(ui: &mut Ui, title: &str, sentence: &str, action: &str) -> bool {
    let palette = Palette::in_ui(ui);
    ui.add_space(ui.available_height() * 0.28);
    ui.vertical_centered(|ui| {
        ui.label(RichText::new(title).size(HEADLINE).color(palette.text));
        ui.label(RichText::new(sentence).color(palette.weak));
        ui.add_space(GAP);
        !action.is_empty() && ui.button(action).clicked()
    })
    .inner
}

/// A thin bar that shows a share of 0 to 1.
pub fn share_bar(ui: &mut Ui, share: f64, width: f32, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(width, 10.0), egui::Sense::hover());
    let palette = Palette::in_ui(ui);
    ui.painter().rect_filled(rect, 3, palette.grid);
    let filled = egui::Rect::from_min_size(rect.min, egui::vec2(width * share.clamp(0.0, 1.0) as f32, rect.height()));
    ui.painter().rect_filled(filled, 3, color);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_listed_as_in_a_sentence() {
        let told = |things: &[&str]| in_a_sentence(&things.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(
            [told(&[]), told(&["a"]), told(&["a", "b"]), told(&["a", "b", "c"])],
            ["", "a", "a and b", "a, b and c"]
        );
    }
}
