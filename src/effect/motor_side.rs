//! What the arm does where its links are not where the encoders of their motors say.

use super::*;
use crate::signals::Signals;

/// How far the link of a joint is behind its motor, per unit of a parameter, with both rates.
pub(super) struct Behind {
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
}

impl Behind {
    /// What the rigid body needs more on all joints, per unit of the parameter, at first order: its links are behind.
    pub(super) fn column(&self, motion: &Motion, joint: usize) -> Result<Column, Lack> {
        let slopes = motion.load()?.slopes(motion.trajectory, joint);
        let pairs = [
            (&slopes.position, &self.position),
            (&slopes.velocity, &self.velocity),
            (&slopes.acceleration, &self.acceleration),
        ];
        let change = |joint: usize, sample: usize| {
            -pairs.iter().map(|(slope, behind)| slope[joint][sample] * behind[sample]).sum::<f64>()
        };
        Ok(Column::on_all(Signals::from_fn(motion.trajectory.joint_count(), motion.trajectory.len(), change)))
    }
}
