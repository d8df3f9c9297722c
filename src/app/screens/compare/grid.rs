//! All joints and all models that are shown, side by side: a row for each joint, whose plots have the same limits, and a column for
//! each model.

use std::sync::Arc;

use egui::{ComboBox, ScrollArea, Ui};

use super::asked::Residual;
use super::figures::{UNDER, over_time};
use crate::app::desk::{Desk, held_out_times, time_extent};
use crate::app::plot::{PanelView, series};
use crate::figure::mark::Line;
use crate::figure::{Ink, Panel, Shared};
use crate::session::Step;
use crate::signals::Signals;
use crate::statistics::ends;

/// Least height and width of a chart \[points\].
const LEAST_HEIGHT: f32 = 150.0;
const LEAST_WIDTH: f32 = 230.0;
/// Between the rows, and below them \[points\].
const BETWEEN: f32 = 6.0;
/// As finely as this the lines are looked at for what they reach.
const COLUMNS: usize = 1000;

/// What is drawn of each joint and model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// What the model leaves.
    Residual,
    /// Measured and predicted torque.
    Torque,
}

impl Cell {
    /// All, the usual one first.
    pub const ALL: [Cell; 2] = [Cell::Residual, Cell::Torque];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Cell::Residual => "residual",
            Cell::Torque => "torque",
        }
    }

    /// The one of this name, or the usual one.
    pub fn of(name: Option<&str>) -> Cell {
        Cell::ALL.into_iter().find(|cell| name == Some(cell.name())).unwrap_or(Cell::Residual)
    }

    /// Lets the user choose whether there is a grid, and of what.
    pub fn choose(ui: &mut Ui, grid: &mut Option<Cell>) {
        let name = |cell: Option<Cell>| cell.map_or("none", Cell::name);
        let label = ui.label("Grid");
        let chooser = ComboBox::from_id_salt("grid").selected_text(name(*grid)).width(80.0).show_ui(ui, |ui| {
            for cell in [None].into_iter().chain(Cell::ALL.map(Some)) {
                ui.selectable_value(grid, cell, name(cell));
            }
        });
        let what = "A row for each joint, a column for each model that is shown, with the same limits along a row";
        chooser.response.labelled_by(label.id).on_hover_text(what);
    }
}

/// How the residuals of a model are asked for: at once, or by a thread.
type Ask<'a> = &'a dyn Fn(&mut Desk, Residual) -> Option<Arc<Signals>>;

/// The rows of the grid; a model of which the residual is not known yet has no lines.
pub fn panels(desk: &mut Desk, cell: Cell, ask: Ask) -> Vec<Vec<Panel>> {
    let Some(recording) = desk.session.recording.clone() else { return Vec::new() };
    let trajectory = desk.focus.trajectory;
    let mut models = Vec::new();
    for step in desk.shown_models() {
        let residual = ask(desk, Residual { trajectory, model: step.generation });
        models.push((step, residual));
    }
    let run = &recording.trajectories[trajectory];
    let held_out = held_out_times(desk.session, trajectory);
    let time = series::time(&recording, trajectory);
    let line = |name: &str, values: Shared<f64>, ink: Ink| Line::new(name, time.clone(), values, ink).sampled();
    let row = |joint: usize| -> Vec<Panel> {
        let info = &recording.joints[joint];
        let panel = |(step, residual): &(Arc<Step>, Option<Arc<Signals>>)| {
            let panel = over_time(info, &step.name, time_extent(&run.time), &held_out);
            match cell {
                Cell::Residual => {
                    let residual = residual.as_ref().map(|own| Shared::of(own, move |own| &own[joint]));
                    panel.with_all(residual.map(|own| line("τ − τ̂", own, Ink::Residual)))
                }
                Cell::Torque => {
                    let measured = line("measured τ", series::torque(&recording, trajectory, joint), Ink::Measured);
                    let predicted = series::predicted(step, trajectory, joint);
                    panel.with(measured.width(UNDER)).with(line("predicted τ̂", predicted, Ink::Predicted))
                }
            }
        };
        models.iter().map(panel).collect()
    };
    let rows = (0..recording.joint_count()).map(row);
    rows.map(|row| with_the_same_limits(row, desk)).collect()
}

/// Plots that show the same range upward: all that is in view of any of them.
fn with_the_same_limits(mut row: Vec<Panel>, desk: &mut Desk) -> Vec<Panel> {
    let mut range = |panel: &Panel| {
        let panel = desk.focus.views.own.onto(panel.clone());
        let (window, _) = desk.focus.views.of_panel(&panel);
        window.of(&panel).ranges(COLUMNS, &mut desk.memo.decimator)[1]
    };
    // One without lines has nothing to say yet.
    let [low, high] = ends(row.iter().filter(|panel| !panel.legend().is_empty()).flat_map(&mut range));
    for panel in &mut row {
        panel.y.range = (low < high).then_some([low, high]);
    }
    row
}

/// The grid in the window.
pub fn show(ui: &mut Ui, desk: &mut Desk, cell: Cell) {
    let ctx = ui.ctx().clone();
    let rows = panels(desk, cell, &|desk, question| desk.memo.later(&ctx, desk.session, question)?.ok());
    let (models, count) = (rows.first().map_or(0, Vec::len).max(1), rows.len().max(1) as f32);
    let height = (ui.available_height() / count - BETWEEN).max(LEAST_HEIGHT);
    let width = ui.available_width().max(models as f32 * LEAST_WIDTH);
    // What has no room beside each other is scrolled to.
    ScrollArea::horizontal().id_salt("grid").show(ui, |ui| {
        ui.set_width(width);
        for row in rows {
            ui.columns(models, |columns| {
                for (ui, panel) in columns.iter_mut().zip(row) {
                    let view = PanelView::new(panel).cursor(&mut desk.focus.cursor).height(height);
                    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
                }
            });
        }
    });
}
