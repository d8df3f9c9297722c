//! What a plot offers to a right click: its limits as numbers, lines of one's own, values to be copied, and its export. While it has
//! the focus the keys L, C and E do the same.

use egui::style::StyleModifier;
use egui::{DragValue, Grid, Id, Key, Popup, PopupCloseBehavior, Role, Ui, WidgetInfo};

use super::linked::Window;
use super::own::OwnLines;
use super::screen::value;
use super::view::{values_at, values_in};
use super::{Shown, export};
use crate::figure::{Axis, Scale, ticks, with_unit};

/// A drag over the width of the field changes a limit by about so much of what is seen.
const STEPS: f64 = 300.0;

/// The menu, while it is open. A cursor has values; of a panel that knows none, what is under the pointer.
pub fn show(ui: &Ui, shown: &Shown, window: &mut Window, own: &mut OwnLines, cursor: Option<Option<f64>>) {
    let Shown { response, panel, .. } = shown;
    let id = Id::unique(("menu of a plot", ui.scope_id(), &panel.title));
    let is_open = Popup::is_id_open(ui.ctx(), id);
    let pointed = (!panel.bare).then(|| place_under_pointer(ui, shown, id.with("place"), is_open)).flatten();
    let (values, whose) = match cursor {
        Some(cursor) => (cursor.map_or_else(Vec::new, |at| values_at(panel, at)), "at the cursor"),
        None => (pointed.map_or_else(Vec::new, |at| values_in(panel, at)), "under the pointer"),
    };
    let copy = || {
        let lines = std::iter::once(panel.heading()).chain(values.iter().cloned());
        ui.ctx().copy_text(lines.collect::<Vec<_>>().join("\n"));
    };
    let pressed = |key| response.has_focus() && ui.input(|input| input.key_pressed(key));
    if pressed(Key::E) {
        export::ask(ui, &panel.title);
    }
    if pressed(Key::C) && !values.is_empty() {
        copy();
    }
    let mut menu = Popup::context_menu(response).id(id).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    // Fields look like fields, and buttons like buttons.
    menu = menu.style(StyleModifier::default());
    if !panel.bare && pressed(Key::L) {
        Popup::open_id(ui.ctx(), id);
    }
    if Popup::position_of_id(ui.ctx(), id).is_none() {
        menu = menu.at_position(shown.plot.left_top());
    }
    menu.show(|ui| {
        if !panel.bare {
            limits(ui, shown, window);
            ui.separator();
            own.edit(ui, panel);
        }
        if !values.is_empty() && ui.button(format!("Copy the values {whose} (C)")).clicked() {
            copy();
            ui.close();
        }
        if ui.button("Export this plot… (E)").clicked() {
            export::ask(ui, &panel.title);
            ui.close();
        }
    });
}

/// What is under the pointer, and while the menu is open what was when it opened.
fn place_under_pointer(ui: &Ui, shown: &Shown, id: Id, is_open: bool) -> Option<[f64; 2]> {
    let now = shown.response.hover_pos().map(|at| value(&shown.place(), at));
    if !is_open {
        ui.data_mut(|data| data.insert_temp(id, now));
        return now;
    }
    ui.data(|data| data.get_temp(id)).flatten()
}

/// From where to where both axes are seen, to be typed.
fn limits(ui: &mut Ui, shown: &Shown, window: &mut Window) {
    ui.label("Limits (L)");
    Grid::new("limits").num_columns(3).show(ui, |ui| {
        let panel = &shown.panel;
        for (letter, axis, seen) in [("x", &panel.x, shown.ranges[0]), ("y", &panel.y, shown.ranges[1])] {
            if matches!(axis.scale, Scale::Names(_)) {
                continue;
            }
            ui.label(with_unit(letter, &axis.unit));
            if let Some(limits) = typed(ui, letter, axis, seen.map(|end| axis.value(end))) {
                match letter {
                    "x" => window.range = Some(limits),
                    _ => drop(window.heights.insert(panel.title.clone(), limits.map(|end| axis.measure(end)))),
                }
            }
            ui.end_row();
        }
    });
    if ui.button("Show everything (F)").clicked() {
        *window = Window::default();
        ui.close();
    }
}

/// Both ends of an axis; one that is typed beyond the other takes it along. `None` while nobody changes them.
fn typed(ui: &mut Ui, letter: &str, axis: &Axis, [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
    let width = to - from;
    let lowest = if axis.scale == Scale::Logarithmic { f64::MIN_POSITIVE } else { f64::NEG_INFINITY };
    let mut field = |word: &str, end: &mut f64| {
        let field = DragValue::new(end).range(lowest..=f64::INFINITY).speed(width / STEPS).update_while_editing(false);
        let field = ui.add(field.custom_formatter(|value, _| ticks::number(value)));
        let spoken = format!("{letter} {word}");
        field.widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, &spoken));
        field.changed()
    };
    let (lower, upper) = (field("from", &mut from), field("to", &mut to));
    if lower && from >= to {
        to = from + width;
    } else if upper && from >= to {
        from = to - width;
    }
    ((lower || upper) && axis.measure(from) < axis.measure(to)).then_some([from, to])
}
