//! The screens, left to right as one goes through them. A new screen is one file and one line in each match here.

mod compare;
mod data;
mod diagnose;
pub(super) mod experiment;
mod extrapolation;
mod ladder;
mod model;
pub(super) mod residuals;
mod train;

pub(super) use compare::TorquePart;
pub(super) use data::covered;

use std::str::FromStr;

use egui::Ui;

use super::state::{Desk, Order};
use super::widgets;
use crate::session::{Command, Session};
use crate::simulation::Scenario;

/// A screen of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Screen {
    /// What was measured.
    Data,
    /// The terms of the model.
    Model,
    /// Models with networks.
    Train,
    /// Measured and predicted torque.
    Compare,
    /// The residual over every state.
    Residuals,
    /// The diagnosis.
    Diagnose,
    /// The error over the steps of the model.
    Ladder,
    /// The error outside the data.
    Extrapolation,
    /// Data × models × seeds.
    Experiment,
}

impl Screen {
    /// All screens, left to right.
    pub const ALL: [Screen; 9] = [
        Screen::Data,
        Screen::Model,
        Screen::Train,
        Screen::Compare,
        Screen::Residuals,
        Screen::Diagnose,
        Screen::Ladder,
        Screen::Extrapolation,
        Screen::Experiment,
    ];

    /// Its name on the command line.
    pub fn id(self) -> &'static str {
        match self {
            Screen::Data => "data",
            Screen::Model => "model",
            Screen::Train => "train",
            Screen::Compare => "compare",
            Screen::Residuals => "residuals",
            Screen::Diagnose => "diagnose",
            Screen::Ladder => "ladder",
            Screen::Extrapolation => "extrapolation",
            Screen::Experiment => "experiment",
        }
    }

    /// Its name in the window.
    pub fn title(self) -> &'static str {
        match self {
            Screen::Data => "Data",
            Screen::Model => "Model",
            Screen::Train => "Train",
            Screen::Compare => "Compare",
            Screen::Residuals => "Where it fails",
            Screen::Diagnose => "What is missing",
            Screen::Ladder => "Ladder",
            Screen::Extrapolation => "Extrapolation",
            Screen::Experiment => "Experiments",
        }
    }

    /// What it is for.
    pub fn purpose(self) -> &'static str {
        match self {
            Screen::Data => "What was measured, and what is odd about it",
            Screen::Model => "What the model adds up, and with which parameters",
            Screen::Train => "Which model, and how its networks learn",
            Screen::Compare => "Measured against predicted torque",
            Screen::Residuals => "What the model leaves, over every state",
            Screen::Diagnose => "Which physical effect the model lacks",
            Screen::Ladder => "How the error fell with every added effect",
            Screen::Extrapolation => "How the error grows outside the data",
            Screen::Experiment => "Many models and seeds, held against the paper",
        }
    }
}

impl FromStr for Screen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Screen::ALL.map(Screen::id).join(", ");
        let found = Screen::ALL.into_iter().find(|screen| screen.id() == text);
        found.ok_or_else(|| format!("there is no screen `{text}`; there are: {known}"))
    }
}

/// Draws the current screen, or what is lacking for it.
pub(super) fn show(ui: &mut Ui, desk: &mut Desk) {
    let screen = desk.state.screen;
    if screen == Screen::Data {
        return data::show(ui, desk);
    }
    // Experiments have data and models of their own.
    if screen == Screen::Experiment {
        return experiment::show(ui, desk);
    }
    if desk.session.recording.is_none() {
        let sentence = "Open a CSV or NPZ recording, drop one here, or begin with the arm of the demonstration.";
        if widgets::empty(ui, "There is no recording yet", sentence, "Simulate the demonstration arm") {
            desk.run(Command::Simulate(Box::new(Scenario::embedded())));
        }
        return;
    }
    if screen == Screen::Train {
        return train::show(ui, desk);
    }
    if desk.session.current().is_none() {
        let sentence = "Fit a rigid body to the recording to see where it fails.";
        if widgets::empty(ui, "There is no model yet", sentence, "Fit a rigid body") {
            desk.run(Command::ChoosePreset(desk.session.preset));
        }
        return;
    }
    match screen {
        Screen::Data | Screen::Train | Screen::Experiment => (),
        Screen::Model => model::show(ui, desk),
        Screen::Compare => compare::show(ui, desk),
        Screen::Residuals => residuals::show(ui, desk),
        Screen::Diagnose => diagnose::show(ui, desk),
        Screen::Ladder => ladder::show(ui, desk),
        Screen::Extrapolation => extrapolation::show(ui, desk),
    }
}

/// Lets the user choose a trajectory by name.
fn trajectory_chooser(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.as_deref() else { return };
    let count = recording.trajectories.len();
    desk.state.trajectory = desk.state.trajectory.min(count.saturating_sub(1));
    let name = |index: usize| {
        let part = if is_held_out(desk.session, index) { "held out" } else { "train" };
        format!("{} ({part})", recording.trajectories[index].name)
    };
    let mut chosen = desk.state.trajectory;
    let label = ui.label("Trajectory");
    let chooser =
        egui::ComboBox::from_id_salt("trajectory").selected_text(name(chosen)).width(190.0).show_ui(ui, |ui| {
            for index in 0..count {
                ui.selectable_value(&mut chosen, index, name(index));
            }
        });
    chooser.response.labelled_by(label.id);
    desk.state.show_trajectory(chosen);
}

/// All charts show everything again.
fn fit_button(ui: &mut Ui, desk: &mut Desk) {
    let what = "Show everything in all charts (Home); F or a double click does so for one quantity";
    if ui.button("Fit").on_hover_text(what).clicked() {
        desk.orders.push(Order::FitAll);
    }
}

/// Whether any of a trajectory is held out and nothing of it trains.
pub(super) fn is_held_out(session: &Session, trajectory: usize) -> bool {
    session.split.held_out.iter().any(|segment| segment.trajectory == trajectory)
        && session.split.train.iter().all(|segment| segment.trajectory != trajectory)
}

/// The held-out stretches of a trajectory, as times.
fn held_out_times(session: &Session, trajectory: usize) -> Vec<[f64; 2]> {
    let Some(data) = session.recording.as_deref().and_then(|recording| recording.trajectories.get(trajectory)) else {
        return Vec::new();
    };
    let of_trajectory = session.split.held_out.iter().filter(|segment| segment.trajectory == trajectory);
    of_trajectory
        .filter_map(|segment| {
            let (first, last) = (segment.samples.start, segment.samples.end.checked_sub(1)?);
            Some([*data.time.get(first)?, *data.time.get(last)?])
        })
        .collect()
}

/// First and last time of a trajectory.
fn time_extent(time: &[f64]) -> [f64; 2] {
    [time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(1.0)]
}
