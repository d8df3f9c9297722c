//! The signals of a recording and of a model as data of marks, shared and not copied.

use std::sync::Arc;

use crate::figure::Shared;
use crate::recording::{Recording, Trajectory};
use crate::session::Step;

/// Time of a trajectory \[s\].
pub fn time(recording: &Arc<Recording>, run: usize) -> Shared<f64> {
    Shared::of(recording, move |recording| &recording.trajectories[run].time)
}

/// A signal of a trajectory.
pub fn signal(
    recording: &Arc<Recording>,
    run: usize,
    of: impl Fn(&Trajectory) -> &[f64] + Send + Sync + 'static,
) -> Shared<f64> {
    Shared::of(recording, move |recording| of(&recording.trajectories[run]))
}

/// Measured torque of a joint.
pub fn torque(recording: &Arc<Recording>, run: usize, joint: usize) -> Shared<f64> {
    signal(recording, run, move |run| &run.tau[joint])
}

/// Torque that a model predicts.
pub fn predicted(step: &Arc<Step>, run: usize, joint: usize) -> Shared<f64> {
    Shared::of(step, move |step| &step.evaluation.predictions[run].total[joint])
}

/// Torque of one term of a model.
pub fn term(step: &Arc<Step>, run: usize, term: usize, joint: usize) -> Shared<f64> {
    Shared::of(step, move |step| &step.evaluation.predictions[run].terms[term][joint])
}

/// The unit of a spectral density of what has this unit: power for each Hz.
pub fn density(unit: &str) -> String {
    if unit.contains(' ') { format!("({unit})²/Hz") } else { format!("{unit}²/Hz") }
}
