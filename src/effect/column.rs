//! Torque over a trajectory, where it acts.

use crate::signals::Signals;

/// Torque over one trajectory, only at the joints where it is not zero by construction.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Joint (from 0) and its torque, one value per sample.
    pub parts: Vec<(usize, Vec<f64>)>,
}

impl Column {
    /// A column that acts on one joint: `value` for each sample.
    pub fn on_joint(joint: usize, values: impl Iterator<Item = f64>) -> Self {
        Column { parts: vec![(joint, values.collect())] }
    }

    /// A column that acts on all joints.
    pub fn on_all(torque: Signals) -> Self {
        Column { parts: torque.iter().map(<[f64]>::to_vec).enumerate().collect() }
    }

    /// Adds `factor` times another column, on the joints where this one acts.
    pub fn add(&mut self, other: &Column, factor: f64) {
        for (joint, values) in &other.parts {
            if let Some((_, sums)) = self.parts.iter_mut().find(|(own, _)| own == joint) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += factor * value;
                }
            }
        }
    }

    /// Adds `factor` times the column to the torque of all joints.
    pub fn add_to(&self, torque: &mut Signals, factor: f64) {
        for (joint, values) in &self.parts {
            for (sum, value) in torque[*joint].iter_mut().zip(values) {
                *sum += factor * value;
            }
        }
    }
}
