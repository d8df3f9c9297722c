//! How much of the torque each term of the model carries.

use crate::app::memo::Question;
use crate::session::Session;

/// How much of the torque a term carries on one joint.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// Its root mean square \[N m\].
    pub rms: f64,
    /// The same as a part of that of the measured torque.
    pub part: f64,
}

/// How much each term carries on each joint, over all of the recording: `shares[term][joint]`.
#[derive(Clone, PartialEq)]
pub struct Shares;

impl Question for Shares {
    type Answer = Vec<Vec<Share>>;

    fn answer(&self, session: &Session) -> Result<Vec<Vec<Share>>, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.current().ok_or("there is no model")?;
        let square = |torque: &[f64]| torque.iter().map(|value| value * value).sum::<f64>();
        let samples = recording.sample_count().max(1) as f64;
        let share = |term: usize, joint: usize| {
            let of_term = step.evaluation.predictions.iter().map(|run| square(&run.terms[term][joint])).sum::<f64>();
            let measured = recording.trajectories.iter().map(|run| square(&run.tau[joint])).sum::<f64>();
            Share { rms: (of_term / samples).sqrt(), part: (of_term / measured).sqrt() }
        };
        let joints = recording.joint_count();
        let terms = 0..step.fitted.model.terms.len();
        Ok(terms.map(|term| (0..joints).map(|joint| share(term, joint)).collect()).collect())
    }
}
