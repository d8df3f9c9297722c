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
        let slopes = motion.load()?.slopes(joint);
        let pairs = [
            (&slopes.position, &self.position),
            (&slopes.velocity, &self.velocity),
            (&slopes.acceleration, &self.acceleration),
        ];
        let mut change = Signals::zeros(motion.trajectory.joint_count(), motion.trajectory.len());
        for (slope, behind) in pairs {
            for (change, slope) in change.iter_mut().zip(slope.iter()) {
                let parts = change.iter_mut().zip(slope.iter().zip(behind));
                parts.for_each(|(change, (slope, behind))| *change -= slope * behind);
            }
        }
        Ok(Column::on_all(change))
    }
}
