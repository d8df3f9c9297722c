//! What a plot offers to a right click: its limits as numbers, the values at the cursor to be copied, and its export. While it has
//! the focus the keys L, C and E do the same.

use egui::{DragValue, Grid, Id, Key, Popup, PopupCloseBehavior, Role, Ui, WidgetInfo};

use super::linked::Window;
use super::view::values_at;
use super::{Shown, export};
use crate::figure::{Axis, Scale, ticks, with_unit};

/// A drag over the width of the field changes a limit by about so much of what is seen.
const STEPS: f64 = 300.0;

/// The menu, while it is open; a cursor has values.
pub fn show(ui: &Ui, shown: &Shown, window: &mut Window, cursor: Option<f64>) {
    let Shown { response, panel, .. } = shown;
    let values = || cursor.map(|at| values_at(panel, at)).filter(|values| !values.is_empty());
    let copy = |values: Vec<String>| {
        let lines = std::iter::once(panel.heading()).chain(values);
        ui.ctx().copy_text(lines.collect::<Vec<_>>().join("\n"));
    };
    let pressed = |key| response.has_focus() && ui.input(|input| input.key_pressed(key));
    if pressed(Key::E) {
        export::ask(ui, &panel.title);
    }
    if pressed(Key::C)
        && let Some(values) = values()
    {
        copy(values);
    }
    let id = Id::unique(("menu of a plot", ui.scope_id(), &panel.title));
    let mut menu = Popup::context_menu(response).id(id).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
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
        }
        if let Some(values) = values()
            && ui.button("Copy the values at the cursor (C)").clicked()
        {
            copy(values);
            ui.close();
        }
        if ui.button("Export this plot… (E)").clicked() {
            export::ask(ui, &panel.title);
            ui.close();
        }
    });
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
