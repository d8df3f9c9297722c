//! What Compare asks of a session, and keeps while nothing changes.

use std::sync::Arc;

use egui::Ui;

use super::arm;
use crate::app::desk::{Desk, time_extent};
use crate::app::memo::Question;
use crate::session::{Generation, Session};
use crate::signals::Signals;

/// Points of the way of the arm's tip.
const TIP_POINTS: usize = 400;

/// Measured minus predicted torque of a model along a trajectory, by joint.
#[derive(Clone, PartialEq)]
pub struct Residual {
    pub trajectory: usize,
    pub model: Generation,
}

impl Question for Residual {
    type Answer = Signals;

    fn answer(&self, session: &Session) -> Result<Signals, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.model).ok_or("there is no such model")?;
        Ok(step.evaluation.residual(recording, self.trajectory))
    }
}

/// Another trajectory, moved to begin with the shown one.
#[derive(Clone, PartialEq)]
pub struct MovedTo {
    pub trajectory: usize,
    pub other: usize,
}

/// Another trajectory as if it began with the shown one.
pub struct Moved {
    /// Its time \[s\].
    pub time: Vec<f64>,
    /// What the current model leaves of it, by joint \[N m or N\].
    pub residual: Signals,
}

impl Question for MovedTo {
    type Answer = Moved;

    fn answer(&self, session: &Session) -> Result<Moved, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.current().ok_or("there is no model")?;
        let run = |index: usize| recording.trajectories.get(index).ok_or("there is no such trajectory");
        let [start, _] = time_extent(&run(self.trajectory)?.time);
        let time = run(self.other)?.since_start().map(|since| start + since).collect();
        Ok(Moved { time, residual: step.evaluation.residual(recording, self.other) })
    }
}

/// What drawing asks of a trajectory in every frame.
#[derive(Clone, PartialEq)]
pub struct Drawn {
    pub trajectory: usize,
}

/// See [`Drawn`].
pub struct Facts {
    /// Measured minus predicted torque by joint.
    pub residual: Signals,
    /// Largest torque of each joint.
    pub largest: Vec<f64>,
    /// Whether a term of the model acts on a joint at all: `acts[term][joint]`.
    pub acts: Vec<Vec<bool>>,
    /// Where the tip of the arm goes \[m\]; nowhere if it slides in the plane.
    pub tip: Vec<[f64; 3]>,
}

impl Question for Drawn {
    type Answer = Facts;

    fn answer(&self, session: &Session) -> Result<Facts, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.current().ok_or("there is no model")?;
        let run = recording.trajectories.get(self.trajectory).ok_or("there is no such trajectory")?;
        let prediction = step.evaluation.predictions.get(self.trajectory).ok_or("it was not predicted")?;
        let largest = |torque: &[f64]| torque.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let acts = |torque: &[f64]| torque.iter().any(|value| *value != 0.0);
        let body = arm::Body::of(recording);
        let tip = |sample: usize| {
            let q: Vec<f64> = run.q.at(sample).collect();
            body.as_ref().map(|body| body.tip(&q))
        };
        Ok(Facts {
            residual: step.evaluation.residual(recording, self.trajectory),
            largest: run.tau.iter().map(largest).collect(),
            acts: prediction.terms.iter().map(|term| term.iter().map(acts).collect()).collect(),
            tip: (0..run.len()).step_by(run.len().div_ceil(TIP_POINTS).max(1)).filter_map(tip).collect(),
        })
    }
}

/// What is asked of the trajectory that is shown; `None` until it is there.
pub fn facts(ui: &Ui, desk: &mut Desk) -> Option<Arc<Facts>> {
    let trajectory = desk.focus.trajectory;
    desk.memo.later(ui.ctx(), desk.session, Drawn { trajectory })?.ok()
}
