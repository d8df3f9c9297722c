//! Controls that several screens have: which trajectory, which joint, and all of it.

use egui::{ComboBox, Ui};

use super::desk::{Desk, Order, is_held_out};
use crate::recording::Recording;

/// How charts are used.
pub const HINT: &str =
    "Drag: cursor. M+drag: measure. Ctrl+wheel, Ctrl+drag: zoom. Right drag: move. Double click: all.";

/// Lets the user choose a trajectory by name.
pub fn trajectory(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.as_deref() else { return };
    let count = recording.trajectories.len();
    desk.focus.trajectory = desk.focus.trajectory.min(count.saturating_sub(1));
    let name = |index: usize| {
        let part = if is_held_out(desk.session, index) { "held out" } else { "train" };
        format!("{} ({part})", recording.trajectories[index].name)
    };
    let mut chosen = desk.focus.trajectory;
    let label = ui.label("Trajectory");
    let chooser = ComboBox::from_id_salt("trajectory").selected_text(name(chosen)).width(190.0).show_ui(ui, |ui| {
        for index in 0..count {
            ui.selectable_value(&mut chosen, index, name(index));
        }
    });
    chooser.response.labelled_by(label.id);
    desk.focus.show_trajectory(chosen);
}

/// Lets the user choose a joint by name.
pub fn joint(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    desk.focus.joint_of(recording);
    for (joint, info) in recording.joints.iter().enumerate() {
        ui.selectable_value(&mut desk.focus.joint, joint, &info.name);
    }
}

/// All charts show everything again.
pub fn fit(ui: &mut Ui, desk: &mut Desk) {
    let what = "Show everything in all charts (Home); F or a double click does so for one quantity";
    if ui.button("Fit").on_hover_text(what).clicked() {
        desk.orders.push(Order::FitAll);
    }
}
