//! What stands above a plot: its title, and the legend with the values at the cursor. A click on a name hides what it names,
//! a double click shows it alone.

use egui::epaint::Shape;
use egui::{Align2, FontId, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use super::linked::Window;
use super::screen::Screen;
use super::{PanelView, Tools};
use crate::app::theme::SMALL;
use crate::figure::mark::{Entry, Key};
use crate::figure::{Axis, ticks};

/// Between entries of the legend \[points\].
const BETWEEN: f32 = 12.0;
/// Between a key and its name \[points\].
const BESIDE: f32 = 4.0;

/// What is known when the header is drawn.
pub struct Header<'a> {
    /// Where it stands.
    pub room: Rect,
    /// Its left and right end are those of the plot.
    pub plot: Rect,
    /// Where the cursor stands.
    pub cursor: Option<f64>,
    /// The values under the pointer, which take the legend's place.
    pub hovered: Option<[f64; 2]>,
    /// The panel with all its marks.
    pub of: &'a PanelView<'a>,
}

/// A value in the unit of an axis.
pub fn with_value(axis: &Axis, value: f64) -> String {
    format!("{} {}", ticks::number(value), axis.unit).trim().to_owned()
}

impl Header<'_> {
    pub fn show(&self, ui: &mut Ui, tools: &Tools, window: &mut Window) {
        let panel = &self.of.panel;
        let painter = ui.painter().with_clip_rect(self.room);
        let y = self.room.center().y - 1.0;
        let mut title = panel.heading();
        if let Some([from, to]) = window.measured {
            title = format!("{title}   Δ {}", with_value(&panel.x, to - from));
        }
        let font = FontId::proportional(SMALL + 0.5);
        let title = painter.text(pos2(self.plot.left(), y), Align2::LEFT_CENTER, title, font, tools.palette.text);
        let font = FontId::proportional(SMALL);
        if let Some([x, value]) = self.hovered {
            let text = format!("{}, {}", with_value(&panel.x, x), with_value(&panel.y, value));
            painter.text(pos2(self.plot.right(), y), Align2::RIGHT_CENTER, text, font, tools.palette.weak);
            return;
        }
        let entries = panel.legend();
        let with_values: Vec<String> = entries.iter().map(|entry| self.text(entry, window)).collect();
        let names: Vec<String> = entries.iter().map(|entry| entry.name.to_owned()).collect();
        let key = Key::WIDTH as f32 * SMALL + BESIDE;
        let width = |text: &String| painter.layout_no_wrap(text.clone(), font.clone(), tools.palette.weak).size().x;
        let needed: f32 = with_values.iter().map(|text| key + width(text) + BETWEEN).sum();
        let fits = needed < self.plot.right() - title.right() + 4.0;
        let mut right = self.plot.right();
        for (entry, text) in entries.iter().zip(if fits { with_values } else { names }).rev() {
            let left = right - width(&text) - key;
            if left < title.right() + 8.0 {
                break;
            }
            let rect = Rect::from_x_y_ranges(left..=right, self.room.y_range());
            self.entry(ui, tools, window, rect, (entry, entries.len() == 1), &text);
            right = left - BETWEEN;
        }
    }

    /// A name with its value at the cursor, or mean and RMS of what is measured.
    fn text(&self, entry: &Entry, window: &Window) -> String {
        let marks = || self.of.panel.marks.iter().filter(|mark| mark.entry().is_some_and(|own| own.name == entry.name));
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
        let middle = rect.center().y - 1.0;
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
