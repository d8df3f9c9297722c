//! Where it fails: the residual of one joint over every state, in frequency and in its own past, and its worst moments.
//!
//! A region that is marked in one view is lit in all others and on the time line.

mod moments;
mod table;
mod views;

use egui::{Align, Layout, RichText, Ui, vec2};

pub use table::{Brush, Quantity, Spectra, Table};

use crate::app::dock::{self, Part};
use crate::app::plot::{Along, Chart, Decimator};
use crate::app::shell::{is_narrow, thousands};
use crate::app::state::Desk;
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::widgets;

/// Least height of the time line \[points\].
const LEAST_TIME_LINE: f32 = 90.0;

const PANELS: Part = Part::Stack(&[
    (3.2, Part::Beside(&[(4.0, Part::Panel("Views", grid)), (1.0, Part::Panel("Worst moments", worst))])),
    (1.0, Part::Panel("Time line", time_line)),
]);

/// What is marked, and of what the map is.
#[derive(Debug)]
pub struct Looking {
    pub brush: Option<Brush>,
    /// The states of the map.
    pub map: [Quantity; 2],
}

impl Default for Looking {
    fn default() -> Self {
        Looking { brush: None, map: [Quantity::Position, Quantity::Velocity] }
    }
}

pub(super) fn show(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    desk.state.joint = desk.state.joint.min(recording.joint_count().saturating_sub(1));
    let narrow = is_narrow(ui);
    let sentence = "Measured minus predicted torque. Noise looks the same everywhere; a missing effect has a shape.";
    widgets::headline(ui, "Where the model fails", if narrow { "" } else { sentence });
    let (joint, held_out) = (desk.state.joint, desk.state.held_out_only);
    ui.horizontal_wrapped(|ui| {
        for (joint, info) in recording.joints.iter().enumerate() {
            ui.selectable_value(&mut desk.state.joint, joint, &info.name);
        }
        ui.add_space(GROUP);
        ui.selectable_value(&mut desk.state.held_out_only, true, "Held-out data");
        ui.selectable_value(&mut desk.state.held_out_only, false, "Training data");
        ui.add_space(GROUP);
        super::fit_button(ui, desk);
        if desk.state.looking.brush.is_some() && ui.button("Unmark").clicked() {
            desk.state.looking.brush = None;
        }
        if !narrow {
            let text = "Drag in a view to mark a region: others light it, spectra follow it. Line: mean, band: ± one deviation.";
            ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
        }
    });
    if (joint, held_out) != (desk.state.joint, desk.state.held_out_only) {
        // A region of one joint's states means nothing to another.
        desk.state.looking.brush = None;
        desk.state.views.fit(Along::WholeTime);
    }
    ui.add_space(4.0);
    if desk.state.table(desk.session).len() == 0 {
        widgets::card(ui, "", |ui| widgets::weak(ui, "No samples in this part of the data: look at the other part."));
        return;
    }
    dock::show(ui, desk, "residuals", &PANELS);
}

/// Units of the shown joint.
fn unit(desk: &Desk) -> [&'static str; 4] {
    let joints = desk.session.recording.iter().flat_map(|recording| &recording.joints);
    joints.map(|joint| joint.kind).nth(desk.state.joint).unwrap_or_default().units()
}

fn worst(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    let (table, unit) = (desk.state.table(desk.session), unit(desk));
    moments::show(ui, desk, &recording, &table, unit[3]);
}

/// All views, two beside each other where there is room.
fn grid(ui: &mut Ui, desk: &mut Desk) {
    let (table, unit) = (desk.state.table(desk.session), unit(desk));
    let lit = desk.state.lit(&table);
    let marked = desk.state.marked(ui.ctx(), &table);
    let shown = views::Shown { table: &table, lit: &lit, marked: marked.as_deref(), unit };
    let columns = if ui.available_width() > 640.0 { 2 } else { 1 };
    let width = (ui.available_width() - GAP * (columns as f32 - 1.0)) / columns as f32;
    let size = vec2(width, (ui.available_height() / 2.0 - GAP).clamp(250.0, 400.0));
    for row in views::ALL.chunks(columns) {
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            for view in row {
                ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
                    ui.set_width(size.x);
                    views::show(ui, desk, *view, &shown, size.y);
                });
            }
        });
    }
}

/// The residual over the time of all segments, with what is marked and where the cursor is.
fn time_line(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    let (table, [.., unit]) = (desk.state.table(desk.session), unit(desk));
    let lit = desk.state.lit(&table);
    let (time, residual) = (table.column(Quantity::Time), table.column(Quantity::Residual));
    let extent = [time[0], time[time.len() - 1].max(time[0] + 1e-9)];
    let mut cursor = moments::row_at_cursor(desk, &table).map(|row| time[row]);
    let before = cursor;
    let marked = if lit.is_empty() { String::new() } else { format!(": {} samples marked", thousands(lit.len())) };
    let chart = Chart::new(format!("time line{marked}"), unit, extent)
        .x_axis("time t, all trajectories end to end", "s")
        .height((ui.available_height() - 4.0).clamp(LEAST_TIME_LINE, 300.0))
        .lit(table.stretches(&lit))
        .line("τ − τ̂", time, residual, (palette.residual, &[]))
        .cursor(&mut cursor);
    chart.show(ui, desk.state.views.of(Along::WholeTime), &mut desk.state.decimator);
    if cursor != before
        && let Some(at) = cursor
    {
        moments::jump(desk, &table, crate::app::plot::chart::nearest(time, at));
    }
}

/// The decimation of lines that live for one frame only.
fn fleeting() -> Decimator {
    Decimator::default()
}
