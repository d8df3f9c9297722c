//! Controls that several screens have: which trajectory, which joint, and all of it.

use std::time::Duration;

use egui::{ComboBox, Ui};

use super::desk::{Desk, Order, is_held_out};
use crate::recording::Recording;

/// How charts are used.
pub const HINT: &str = "Drag: cursor. Ctrl+wheel, Ctrl+drag: zoom. Right click: limits, lines, export. F1: all keys.";

/// The most that time goes on in a frame \[s\].
const LONGEST_STEP: f64 = 0.5;

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

/// Lets the user choose another trajectory that is drawn over the shown one.
pub fn beside(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.as_deref() else { return };
    let (count, shown) = (recording.trajectories.len(), desk.focus.trajectory);
    desk.focus.beside.take_if(|other| *other >= count || *other == shown);
    if count < 2 {
        return;
    }
    let name = |index: Option<usize>| index.map_or("none", |index| recording.trajectories[index].name.as_str());
    let label = ui.label("over it");
    let chooser = ComboBox::from_id_salt("beside").selected_text(name(desk.focus.beside)).width(110.0);
    let chooser = chooser.show_ui(ui, |ui| {
        ui.selectable_value(&mut desk.focus.beside, None, name(None));
        for index in (0..count).filter(|index| *index != shown) {
            ui.selectable_value(&mut desk.focus.beside, Some(index), name(Some(index)));
        }
    });
    let what = "Another trajectory in the same charts, paler and dotted, from the same beginning";
    chooser.response.labelled_by(label.id).on_hover_text(what);
}

/// Lets the user choose a joint by name.
pub fn joint(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    desk.focus.joint_of(recording);
    for (joint, info) in recording.joints.iter().enumerate() {
        ui.selectable_value(&mut desk.focus.joint, joint, &info.name);
    }
}

/// Lets time go on, or stand: a button of this name while it stands.
pub fn play(ui: &mut Ui, desk: &mut Desk, name: &str, what: &str) {
    let name = if desk.focus.is_playing { "Pause" } else { name };
    if ui.button(name).on_hover_text(what).clicked() {
        desk.focus.is_playing = !desk.focus.is_playing;
    }
}

/// While it plays, time goes on by what has passed since the last frame. Before anything is drawn, so that all of it shows the
/// same moment.
pub fn let_time_pass(ui: &Ui, desk: &mut Desk, recording: &Recording) {
    // No prediction: the next frame is asked for after a time, and comes sooner where something else moves.
    desk.focus.play(recording, f64::from(ui.input(|input| input.unstable_dt)).min(LONGEST_STEP));
    if desk.focus.is_playing {
        // A frame that is asked for comes sooner, by the time that egui thinks it takes.
        let sooner = Duration::from_secs_f32(ui.input(|input| input.predicted_dt));
        let due = desk.focus.film.due(ui.ctx().cumulative_frame_nr());
        ui.ctx().request_repaint_after(due + sooner);
    }
}

/// All charts show everything again.
pub fn fit(ui: &mut Ui, desk: &mut Desk) {
    let what = "Show everything in all charts (Home); F or a double click does so for one quantity";
    if ui.button("Fit").on_hover_text(what).clicked() {
        desk.orders.push(Order::FitAll);
    }
}
