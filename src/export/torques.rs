//! What a model says of a recording, sample by sample: its torque, what that is made of, and what it leaves.

use crate::model::{Fitted, ModelError, Term};
use crate::progress::{Monitor, Stopped};
use crate::recording::split::Segment;
use crate::recording::table::Table;
use crate::recording::{Recording, Trajectory};
use crate::training::{TrainError, components};

/// The table can't be made.
#[derive(Debug, thiserror::Error)]
pub enum TorquesError {
    /// The recording is of another arm.
    #[error("the model has {model} joints, the recording {recording}: use recordings of its arm")]
    OtherArm {
        /// Of the model.
        model: usize,
        /// Of the recording.
        recording: usize,
    },
    /// A term can't be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A part of it can't.
    #[error(transparent)]
    Parts(#[from] TrainError),
    /// Stopped by the user.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// All columns, stretch after stretch. Whole runs are predicted, since a term may remember what was before a stretch.
///
/// # Errors
/// [`TorquesError`] if the recording is of another arm, or a term can't be computed for it.
pub fn table(
    fitted: &Fitted,
    recording: &Recording,
    stretches: &[Segment],
    monitor: &Monitor,
) -> Result<Table, TorquesError> {
    let [model, found] = [fitted.setting().kinds.len(), recording.joint_count()];
    if model != found {
        return Err(TorquesError::OtherArm { model, recording: found });
    }
    let mut table = Table::default();
    let count = recording.trajectories.len();
    for (number, run) in recording.trajectories.iter().enumerate() {
        let mut own = stretches.iter().filter(|stretch| stretch.trajectory == number).peekable();
        if own.peek().is_none() {
            continue;
        }
        monitor.report(number as f32 / count as f32, &format!("predicting {}", run.name))?;
        let whole = of_run(fitted, number, run)?;
        own.for_each(|stretch| table.extend_rows(&whole, stretch.samples.clone()));
    }
    Ok(table)
}

/// The columns of a run.
fn of_run(fitted: &Fitted, number: usize, run: &Trajectory) -> Result<Table, TorquesError> {
    let prediction = fitted.predict(run)?;
    let mut residual = run.tau.clone();
    residual.add(&prediction.total, -1.0);
    let mut table = Table::default();
    table.extend("trajectory", &vec![number as f64 + 1.0; run.len()]);
    table.extend("time", &run.time);
    table.extend_joints("tau_measured", &run.tau);
    table.extend_joints("tau_predicted", &prediction.total);
    table.extend_joints("tau_residual", &residual);
    for (term, torque) in fitted.model.terms.iter().zip(&prediction.terms) {
        match term {
            // An effect of one joint is zero at all others.
            Term::Effect(effect) if effect.joint.is_some() => {
                let joint = effect.joint.unwrap_or_default();
                table.extend(&format!("{}@{}", effect.effect.id, joint + 1), &torque[joint]);
            }
            Term::Effect(effect) => table.extend_joints(effect.effect.id, torque),
            other => table.extend_joints(&other.label().replace(' ', "-"), torque),
        }
    }
    for (name, torque) in components(fitted, run)? {
        table.extend_joints(name, &torque);
    }
    Ok(table)
}
