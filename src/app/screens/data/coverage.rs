//! Where there are data, and how fast they change: what a model can't have a say about, and what it can't follow.

use egui::{RichText, Ui};

use super::figures;
use crate::app::desk::Desk;
use crate::app::memo::Question;
use crate::app::plot::PanelView;
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::figure::Panel;
use crate::figure::mark::{Cells, Shades};
use crate::recording::Recording;
use crate::recording::spectrum;
use crate::recording::split::Split;
use crate::session::Session;

/// Columns and rows.
const SIZE: [usize; 2] = [40, 30];

/// How many training samples each place of position and velocity of a joint has.
#[derive(Clone, PartialEq)]
struct Coverage {
    joint: usize,
}

impl Question for Coverage {
    type Answer = Cells;

    fn answer(&self, session: &Session) -> Result<Cells, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        Ok(covered(recording, &session.split, self.joint))
    }
}

/// Frequency \[Hz\] and power of the measured torque.
#[derive(Clone, PartialEq)]
struct TorqueSpectrum {
    trajectory: usize,
    joint: usize,
}

impl Question for TorqueSpectrum {
    type Answer = Vec<[f64; 2]>;

    fn answer(&self, session: &Session) -> Result<Vec<[f64; 2]>, String> {
        let runs = session.recording.as_ref().map(|recording| &recording.trajectories);
        let run = runs.and_then(|runs| runs.get(self.trajectory)).ok_or("there is no such trajectory")?;
        Ok(spectrum::power(&[&run.tau[self.joint]], run.time_step()))
    }
}

/// How many training samples each place of position and velocity of a joint has; NaN where there is none.
fn covered(recording: &Recording, split: &Split, joint: usize) -> Cells {
    let runs =
        || split.train.iter().map(|segment| (&recording.trajectories[segment.trajectory], segment.samples.clone()));
    let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for run in &recording.trajectories {
        for (ends, signal) in ends.iter_mut().zip([&run.q[joint], &run.qd[joint]]) {
            for value in signal {
                *ends = [ends[0].min(*value), ends[1].max(*value)];
            }
        }
    }
    for ends in &mut ends {
        if ends[0] >= ends[1] {
            *ends = [ends[0] - 0.5, ends[0] + 0.5];
        }
    }
    let cell = |value: f64, axis: usize| {
        let share = (value - ends[axis][0]) / (ends[axis][1] - ends[axis][0]);
        ((share * SIZE[axis] as f64) as usize).min(SIZE[axis] - 1)
    };
    let mut values = vec![f64::NAN; SIZE[0] * SIZE[1]];
    for (run, samples) in runs() {
        for (q, qd) in run.q[joint][samples.clone()].iter().zip(&run.qd[joint][samples]) {
            let value = &mut values[cell(*qd, 1) * SIZE[0] + cell(*q, 0)];
            *value = if value.is_nan() { 1.0 } else { *value + 1.0 };
        }
    }
    Cells {
        size: SIZE,
        extent: ends,
        values: values.into(),
        shades: Shades::Amount,
        unit: "samples",
        scale: String::new(),
        most: None,
    }
    .with_scale()
}

/// What is shown here, as figures.
pub fn figures(desk: &mut Desk, recording: &Recording) -> Vec<Panel> {
    let (session, trajectory, joint) = (desk.session, desk.focus.trajectory, desk.focus.joint);
    let mut panels = Vec::new();
    for joint in 0..recording.joint_count() {
        let cells = desk.memo.now(session, Coverage { joint });
        panels.extend(cells.map(|cells| figures::coverage(recording, joint, &cells)));
    }
    let power = desk.memo.now(session, TorqueSpectrum { trajectory, joint });
    panels.extend(power.ok().and_then(|power| figures::spectrum(recording, joint, &power)));
    panels
}

pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else {
        widgets::weak(ui, "There is no recording yet.");
        return;
    };
    density(ui, desk, &recording);
    torque_spectrum(ui, desk, &recording);
}

fn density(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "Coverage of the training data", |ui| {
        let joints: Vec<usize> = (0..recording.joint_count()).collect();
        let columns = if ui.available_width() > 560.0 { joints.len().clamp(1, 3) } else { 1 };
        for row in joints.chunks(columns) {
            ui.columns(columns, |columns| {
                for (ui, &joint) in columns.iter_mut().zip(row) {
                    let answer = desk.memo.later(ui.ctx(), desk.session, Coverage { joint });
                    let Some(Ok(cells)) = answer else { continue };
                    let view = PanelView::new(figures::coverage(recording, joint, &cells)).height(190.0);
                    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
                }
            });
        }
        let text = "How often each position and velocity was recorded. Where it is empty, the model has no say: it extrapolates.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
}

/// The power of the chosen trajectory's torque.
fn torque_spectrum(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    let (trajectory, joint) = (desk.focus.trajectory, desk.focus.joint_of(recording));
    let answer = desk.memo.later(ui.ctx(), desk.session, TorqueSpectrum { trajectory, joint });
    let Some(Ok(spectrum)) = answer else { return };
    widgets::card(ui, &format!("Power spectrum of the {}", recording.joints[joint].kind.effort()), |ui| {
        let Some(panel) = figures::spectrum(recording, joint, &spectrum) else {
            widgets::weak(ui, "The trajectory is too short for a spectrum.");
            return;
        };
        PanelView::new(panel).height(170.0).show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        let text = "Motion is at the left, noise is the flat part at the right; a peak between them is a vibration.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
}
