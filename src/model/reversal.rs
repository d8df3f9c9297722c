//! How fast a joint must move before its dry friction has its full size.
//!
//! Friction that jumps with the sign of the velocity is right on a prescribed motion. A real joint sticks at its reversals, its
//! bristles bend, and its velocity is read with noise: what a jump leaves there draws false effects. So each joint has one width v₀,
//! and in every form of dry friction tanh(q̇/v₀) stands for the sign. It is the one that explains the torque best beside the
//! rigid body and the commonest friction.
//!
//! Source: the regularised Coulomb friction of Andersson, Söderberg and Björklund, Tribology International 40 (2007) 580.

use nalgebra::DVector;
use rayon::prelude::*;

use super::design::Design;
use super::equations::{Equations, PreparedColumn};
use super::{ModelError, RigidBody};
use crate::effect::{Column, sign};
use crate::recording::differentiate::central_difference;

/// Widths that are tried, as shares of the joint's highest speed.
const WIDTHS: [f64; 9] = [0.002, 0.003, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.03, 0.045];
/// A width must explain this share of what a jump leaves of the joint's torque. Set on two real logs: EMPS, where 3.3 % is no
/// gain on held-out data, and TX40, where from 5 % on it divides the held-out error by ten.
const LEAST_GAIN: f64 = 0.035;
/// A wider reversal is so many times as wide.
const WIDER: f64 = 2.5;
/// Rounds over all joints, since they share the rigid body.
const ROUNDS: usize = 2;

/// The width of each joint \[rad/s or m/s\]; 0 where friction jumps, or is not there.
///
/// # Errors
/// [`ModelError`] if a column can't be computed.
pub fn widths(design: &Design) -> Result<Vec<f64>, ModelError> {
    let joints = design.joint_count();
    let tops: Vec<f64> = (0..joints).map(|joint| design.recording().top_speed(joint)).collect();
    let mut columns =
        design.prepare(|trajectory, _| Ok(RigidBody::Identified.columns(design.setting(), trajectory)))?;
    columns.extend(design.prepare(|trajectory, _| {
        let linear = |joint: usize| {
            let (q, qd) = (&trajectory.q[joint], &trajectory.qd[joint]);
            [
                Column::on_joint(joint, qd.iter().map(|_| 1.0)),
                Column::on_joint(joint, q.iter().copied()),
                Column::on_joint(joint, qd.iter().copied()),
            ]
        };
        Ok((0..joints).flat_map(linear).collect())
    })?);
    let base = columns.len();
    columns.extend(directions(design, &tops)?);
    let equations = design.equations(&columns, design.torque());
    let choice = Choice { base, count: columns.len(), equations, design };
    let chosen = choice.best();
    Ok(chosen.iter().zip(&tops).map(|(&way, top)| if way == 0 { 0.0 } else { WIDTHS[way - 1] * top }).collect())
}

/// What a width leaves of a reversal: for each joint that has one, what a wider reversal would change, and an earlier one.
///
/// A search takes them as free companions of dry friction, so that a form which is a little wrong at reversals draws nothing else.
///
/// # Errors
/// [`ModelError`] if a column can't be computed.
pub fn companions(design: &Design) -> Result<Vec<PreparedColumn>, ModelError> {
    design.prepare(|trajectory, _| {
        let of_joint = |(joint, &width): (usize, &f64)| {
            let qd = &trajectory.qd[joint];
            let turn = |width: f64| qd.iter().map(move |qd| (qd / width).tanh()).collect::<Vec<f64>>();
            let (own, wider) = (turn(width), turn(WIDER * width));
            let rate = central_difference(&own, &trajectory.time);
            let change = wider.iter().zip(&own).map(|(wider, own)| own - wider).collect::<Vec<f64>>();
            [Column::on_joint(joint, change.into_iter()), Column::on_joint(joint, rate.into_iter())]
        };
        let widths = design.setting().reversal_widths.iter().enumerate();
        Ok(widths.filter(|(_, width)| **width > 0.0).flat_map(of_joint).collect())
    })
}

/// For each joint its sign, then its smooth directions.
fn directions(design: &Design, tops: &[f64]) -> Result<Vec<PreparedColumn>, ModelError> {
    design.prepare(|trajectory, _| {
        let of_joint = |(joint, &top): (usize, &f64)| {
            let qd = &trajectory.qd[joint];
            let jump = Column::on_joint(joint, qd.iter().map(|&qd| sign(qd)));
            let smooth = move |share: &f64| {
                let width = share * top;
                Column::on_joint(joint, qd.iter().map(move |qd| (qd / width).tanh()))
            };
            std::iter::once(jump).chain(WIDTHS.iter().map(smooth)).collect::<Vec<_>>()
        };
        Ok(tops.par_iter().enumerate().flat_map_iter(of_joint).collect())
    })
}

/// The search for the best direction of each joint; 0 is the sign.
struct Choice<'a> {
    base: usize,
    /// Of all columns.
    count: usize,
    equations: Equations,
    design: &'a Design<'a>,
}

impl Choice<'_> {
    fn chosen(&self, ways: &[usize]) -> Vec<usize> {
        let direction = |(joint, way): (usize, &usize)| self.base + joint * (WIDTHS.len() + 1) + way;
        (0..self.base).chain(ways.iter().enumerate().map(direction)).collect()
    }

    fn best(&self) -> Vec<usize> {
        let joints = self.design.joint_count();
        let mut ways = vec![0; joints];
        let mut weights: Vec<f64> =
            (0..joints).map(|joint| super::design::inverse(self.design.energy(joint))).collect();
        for _ in 0..ROUNDS {
            weights = self.weights(&weights, &ways);
            let whole = self.equations.total(&weights, |_| true);
            for joint in 0..joints {
                let cost = |way: usize| {
                    let mut ways = ways.clone();
                    ways[joint] = way;
                    whole.select(&self.chosen(&ways)).solve().residual_energy
                };
                let costs: Vec<f64> = (0..=WIDTHS.len()).map(cost).collect();
                let best = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
                // A residual weighs 1 for each sample of its joint.
                let needed = LEAST_GAIN * self.design.sample_count(joint) as f64;
                ways[joint] = if costs[0] - costs[best] > needed { best } else { 0 };
            }
        }
        ways
    }

    /// Factors of all columns with these directions.
    fn factors(&self, ways: &[usize], weights: &[f64]) -> DVector<f64> {
        let chosen = self.chosen(ways);
        let solution = self.equations.total(weights, |_| true).select(&chosen).solve();
        let mut factors = DVector::zeros(self.count);
        for (&column, &factor) in chosen.iter().zip(&solution.factors) {
            factors[column] = factor;
        }
        factors
    }

    /// 1 / error variance of each joint with these directions.
    fn weights(&self, before: &[f64], ways: &[usize]) -> Vec<f64> {
        self.design.residual_weights(&self.equations, &self.factors(ways, before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::recording::Recording;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// A recording with dry friction on joint 2 that turns round within `width` \[rad/s\].
    fn log(width: f64) -> Recording {
        let mut scenario = Scenario { effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { trajectories, duration, .. } = &mut scenario.motion {
            (*trajectories, *duration) = (6, 6.0);
        }
        let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
        for trajectory in &mut recording.trajectories {
            let friction: Vec<f64> = trajectory.qd[1].iter().map(|qd| 2.0 * (qd / width).tanh()).collect();
            let mut channels = trajectory.channels_mut();
            channels.tau[1].iter_mut().zip(friction).for_each(|(tau, friction)| *tau += friction);
        }
        recording
    }

    #[test]
    fn the_width_of_a_reversal_is_found_and_a_jump_stays_a_jump() {
        for (width, low, high) in [(0.1, 0.06, 0.16), (1e-6, 0.0, 0.0)] {
            let recording = log(width);
            let design = Design::new(&recording, &Split::automatic(&recording)).unwrap();
            let found = design.setting().reversal_widths[1];
            assert!((low..=high).contains(&found), "{width}: {found}");
            assert_eq!(design.setting().reversal_widths[0], 0.0, "nothing rubs on joint 1");
        }
    }
}
