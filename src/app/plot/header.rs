//! What stands above a plot: its title, and the legend with the values at the cursor. A click on a name hides what it names,
//! a double click shows it alone.

use egui::epaint::Shape;
use egui::{Align2, Color32, FontId, Rangef, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use super::linked::Window;
use super::screen::Screen;
use super::view::TOP;
use super::{PanelView, Tools};
use crate::app::theme::SMALL;
use crate::figure::mark::{Entry, Key};
use crate::figure::{Axis, Panel, Scale, ticks};

/// Between entries of the legend \[points\].
const BETWEEN: f32 = 12.0;
/// Between a key and its name \[points\].
const BESIDE: f32 = 4.0;

/// Height of a row behind the first \[points\].
const ROW: f32 = 15.0;
/// Between the title and the legend \[points\].
const BEHIND_TITLE: f32 = 8.0;

/// What is known when the header is drawn.
pub struct Header<'a> {
    /// Where it stands.
    pub room: Rect,
    /// Its left and right end are those of the plot.
    pub plot: Rect,
    /// Where the cursor stands.
    pub cursor: Option<f64>,
    /// The panel with all its marks.
    pub of: &'a PanelView<'a>,
}

/// A value in the unit of an axis, or the name that stands there.
pub fn with_value(axis: &Axis, value: f64) -> String {
    if let Scale::Names(names) = &axis.scale {
        return names.get(value.round().max(0.0) as usize).cloned().unwrap_or_default();
    }
    format!("{} {}", ticks::number(value), axis.unit).trim().to_owned()
}

/// What stands at the left: what the panel shows, and what is measured.
fn title(panel: &Panel, window: &Window) -> String {
    match window.measured {
        Some([from, to]) => format!("{}   Δ {}", panel.heading(), with_value(&panel.x, to - from)),
        None => panel.heading(),
    }
}

fn width_of(ui: &Ui, text: &str, size: f32) -> f32 {
    ui.painter().layout_no_wrap(text.to_owned(), FontId::proportional(size), Color32::PLACEHOLDER).size().x
}

fn key_width(key: Key) -> f32 {
    key.width() as f32 * SMALL + BESIDE
}

/// The entries of the legend in rows, all of them: the first stands beside the title, unless there is no room for any.
fn rows(ui: &Ui, panel: &Panel, window: &Window, width: f32) -> Vec<Vec<usize>> {
    let mut used = width_of(ui, &title(panel, window), SMALL + 0.5) + BEHIND_TITLE;
    let mut rows = vec![Vec::new()];
    for (number, entry) in panel.legend().iter().enumerate() {
        let needed = key_width(entry.key) + width_of(ui, entry.name, SMALL);
        if used + needed > width && used > 0.0 {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += needed + BETWEEN;
        if let Some(row) = rows.last_mut() {
            row.push(number);
        }
    }
    rows
}

/// How much more than one row the header needs over a plot of this width \[points\].
pub fn more_rows(ui: &Ui, panel: &Panel, window: &Window, width: f32) -> f32 {
    ROW * (rows(ui, panel, window, width).len() - 1) as f32
}

/// The names of a row; one that is too long by itself, as far as there is room.
fn names(ui: &Ui, row: &[&Entry], room: f32) -> Vec<String> {
    let mut names: Vec<String> = row.iter().map(|entry| entry.name.to_owned()).collect();
    if let ([name], [entry]) = (names.as_mut_slice(), row) {
        while key_width(entry.key) + width_of(ui, name, SMALL) > room && name.chars().count() > 2 {
            name.pop();
            name.pop();
            name.push('…');
        }
    }
    names
}

impl Header<'_> {
    pub fn show(&self, ui: &mut Ui, tools: &Tools, window: &mut Window) {
        let panel = &self.of.panel;
        let painter = ui.painter().with_clip_rect(self.room);
        let rows = rows(ui, panel, window, self.plot.width());
        let first = self.room.bottom() - ROW * (rows.len() - 1) as f32 - 0.5 * TOP - 1.0;
        let title = title(panel, window);
        let font = FontId::proportional(SMALL + 0.5);
        let at = pos2(self.plot.left(), first);
        let title = painter.text(at, Align2::LEFT_CENTER, title, font, tools.palette.text);
        let entries = panel.legend();
        let room =
            |row: usize| self.plot.right() - if row == 0 { title.right() + BEHIND_TITLE } else { self.plot.left() };
        let with_values: Vec<String> = entries.iter().map(|entry| self.text(entry, window)).collect();
        let width =
            |entry: &usize| key_width(entries[*entry].key) + width_of(ui, &with_values[*entry], SMALL) + BETWEEN;
        let fits = |(number, row): (usize, &Vec<usize>)| row.iter().map(width).sum::<f32>() < room(number) + BETWEEN;
        // All have their values, or none: what is left out of some would look like what has none.
        let has_values = rows.iter().enumerate().all(fits);
        for (number, row) in rows.iter().enumerate() {
            let texts: Vec<String> = match has_values {
                true => row.iter().map(|entry| with_values[*entry].clone()).collect(),
                false => names(ui, &row.iter().map(|entry| &entries[*entry]).collect::<Vec<_>>(), room(number)),
            };
            let y = first + ROW * number as f32;
            let height = Rangef::new(y - 0.5 * ROW, y + 0.5 * ROW);
            let mut right = self.plot.right();
            for (entry, text) in row.iter().zip(texts).rev() {
                let left = right - width_of(ui, &text, SMALL) - key_width(entries[*entry].key);
                let rect = Rect::from_x_y_ranges(Rangef::new(left, right), height);
                self.entry(ui, tools, window, rect, (&entries[*entry], entries.len() == 1), &text);
                right = left - BETWEEN;
            }
        }
    }

    /// A name with its value at the cursor, or mean and RMS of what is measured. What stands for several lines has none.
    fn text(&self, entry: &Entry, window: &Window) -> String {
        let marks = || self.of.panel.marks.iter().filter(|mark| mark.name() == entry.name);
        if let Some([mean, rms]) =
            window.measured.and_then(|between| marks().find_map(|mark| mark.mean_and_rms(between)))
        {
            return format!("{} mean {}, RMS {}", entry.name, ticks::number(mean), ticks::number(rms));
        }
        match self.cursor.and_then(|at| marks().find_map(|mark| mark.value_at(at))) {
            Some(value) => format!("{} {}", entry.name, ticks::number(value)),
            None => entry.name.to_owned(),
        }
    }

    fn entry(
        &self,
        ui: &mut Ui,
        tools: &Tools,
        window: &mut Window,
        rect: Rect,
        (entry, alone): (&Entry, bool),
        text: &str,
    ) {
        let palette = tools.palette;
        let title = &self.of.panel.title;
        let id = ui.scope_id().with(("legend", title, entry.name));
        let is_shown = !window.hidden.contains(entry.name);
        // The only line of a plot is not to be hidden.
        let sense = if alone && is_shown { Sense::hover() } else { Sense::click() };
        let response = ui.interact(rect, id, sense);
        if sense.senses_click() {
            let spoken = format!("{} in {title}", entry.name);
            response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, is_shown, &spoken));
        }
        let middle = rect.center().y;
        let mut shapes: Vec<Shape> = Vec::new();
        if is_shown {
            let mut screen = Screen::new(ui, &tools.colours, &tools.decimator, &mut shapes);
            entry.key.draw(&mut screen, [f64::from(rect.left()), f64::from(middle)]);
        }
        let painter = ui.painter().with_clip_rect(self.room);
        painter.extend(shapes);
        let color = if response.hovered() && sense.senses_click() && is_shown { palette.text } else { palette.weak };
        let font = FontId::proportional(SMALL);
        let text = painter.text(pos2(rect.right(), middle), Align2::RIGHT_CENTER, text, font, color);
        if !is_shown {
            painter.hline(text.x_range(), text.center().y + 1.0, Stroke::new(1.0, palette.weak));
        }
        if response.has_focus() {
            painter.rect_stroke(
                rect.expand2(vec2(2.0, -2.0)),
                2,
                Stroke::new(1.0, palette.accent),
                egui::StrokeKind::Inside,
            );
        }
        if response.double_clicked() {
            self.show_alone(window, entry.name);
        } else if response.clicked() && !window.hidden.remove(entry.name) {
            window.hidden.insert(entry.name.to_owned());
        }
        if sense.senses_click() {
            response.on_hover_text("Click: hide or show. Double click: this one alone, or all.");
        }
    }

    /// Hides all others; all are shown if they are hidden already. The first click of the two has hidden or shown it.
    fn show_alone(&self, window: &mut Window, name: &str) {
        let names = self.of.panel.legend().into_iter().map(|entry| entry.name.to_owned());
        let others: Vec<String> = names.filter(|other| other != name).collect();
        let was_alone = others.iter().all(|other| window.hidden.contains(other));
        window.hidden.remove(name);
        for other in others {
            if was_alone {
                window.hidden.remove(&other);
            } else {
                window.hidden.insert(other);
            }
        }
    }
}
