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
use super::least_squares::NormalEquations;
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

/// For each joint the root of its speed, its sign, then its smooth directions.
fn directions(design: &Design, tops: &[f64]) -> Result<Vec<PreparedColumn>, ModelError> {
    design.prepare(|trajectory, _| {
        let of_joint = |(joint, &top): (usize, &f64)| {
            let qd = &trajectory.qd[joint];
            let root = Column::on_joint(joint, qd.iter().map(|&qd| sign(qd) * qd.abs().sqrt()));
            let jump = Column::on_joint(joint, qd.iter().map(|&qd| sign(qd)));
            let smooth = move |share: &f64| {
                let width = share * top;
                Column::on_joint(joint, qd.iter().map(move |qd| (qd / width).tanh()))
            };
            [root, jump].into_iter().chain(WIDTHS.iter().map(smooth)).collect::<Vec<_>>()
        };
        Ok(tops.par_iter().enumerate().flat_map_iter(of_joint).collect())
    })
}

/// How the dry friction of a joint is told while its width is searched.
#[derive(Clone, Copy, Default)]
struct Way {
    /// Which direction; 0 is the sign.
    direction: usize,
    /// Whether a root of the speed stands beside it.
    rooted: bool,
}

/// The search for the best direction of each joint.
///
/// Friction that grows as a power of the speed rises steeply where a reversal is rounded off: without a root of the speed beside
/// it, a wide direction imitates it. But a falling root imitates the fall of Stribeck's friction, and asks for a wide direction
/// itself: only one that rises is taken.
struct Choice<'a> {
    base: usize,
    /// Of all columns.
    count: usize,
    equations: Equations,
    design: &'a Design<'a>,
}

impl Choice<'_> {
    /// The column of a joint's root; its directions follow.
    fn root(&self, joint: usize) -> usize {
        self.base + joint * (WIDTHS.len() + 2)
    }

    fn chosen(&self, ways: &[Way]) -> Vec<usize> {
        let of_joint = |(joint, way): (usize, &Way)| {
            let root = self.root(joint);
            way.rooted.then_some(root).into_iter().chain([root + 1 + way.direction])
        };
        (0..self.base).chain(ways.iter().enumerate().flat_map(of_joint)).collect()
    }

    fn best(&self) -> Vec<usize> {
        let joints = self.design.joint_count();
        let mut ways = vec![Way::default(); joints];
        let mut weights: Vec<f64> =
            (0..joints).map(|joint| super::design::inverse(self.design.energy(joint))).collect();
        for _ in 0..ROUNDS {
            weights = self.weights(&weights, &ways);
            let whole = self.equations.total(&weights, |_| true);
            for joint in 0..joints {
                let tries: Vec<(f64, Way)> =
                    (0..=WIDTHS.len()).map(|direction| self.cost(&whole, &ways, joint, direction)).collect();
                let best = (0..tries.len()).min_by(|&a, &b| tries[a].0.total_cmp(&tries[b].0)).unwrap_or(0);
                // A residual weighs 1 for each sample of its joint.
                let needed = LEAST_GAIN * self.design.sample_count(joint) as f64;
                ways[joint] = if tries[0].0 - tries[best].0 > needed { tries[best].1 } else { tries[0].1 };
            }
        }
        ways.iter().map(|way| way.direction).collect()
    }

    /// What is left with a direction of one joint, beside a root of its speed if that rises.
    fn cost(&self, whole: &NormalEquations, ways: &[Way], joint: usize, direction: usize) -> (f64, Way) {
        let with = |rooted: bool| {
            let mut ways = ways.to_vec();
            ways[joint] = Way { direction, rooted };
            let chosen = self.chosen(&ways);
            let solution = whole.select(&chosen).solve();
            let mut factors = chosen.iter().zip(&solution.factors);
            let rises = factors.any(|(&column, &factor)| column == self.root(joint) && factor > 0.0);
            (rises, solution.residual_energy)
        };
        let (rooted, cost) = with(true);
        (if rooted { cost } else { with(false).1 }, Way { direction, rooted })
    }

    /// Factors of all columns with these ways.
    fn factors(&self, ways: &[Way], weights: &[f64]) -> DVector<f64> {
        let chosen = self.chosen(ways);
        let solution = self.equations.total(weights, |_| true).select(&chosen).solve();
        let mut factors = DVector::zeros(self.count);
        for (&column, &factor) in chosen.iter().zip(&solution.factors) {
            factors[column] = factor;
        }
        factors
    }

    /// 1 / error variance of each joint with these ways.
    fn weights(&self, before: &[f64], ways: &[Way]) -> Vec<f64> {
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

    /// A recording with friction on joint 2 that depends on its speed.
    fn log(friction: impl Fn(f64) -> f64) -> Recording {
        let mut scenario = Scenario { effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { trajectories, duration, .. } = &mut scenario.motion {
            (*trajectories, *duration) = (6, 6.0);
        }
        let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
        for trajectory in &mut recording.trajectories {
            let torque: Vec<f64> = trajectory.qd[1].iter().map(|&qd| friction(qd)).collect();
            let mut channels = trajectory.channels_mut();
            channels.tau[1].iter_mut().zip(torque).for_each(|(tau, torque)| *tau += torque);
        }
        recording
    }

    fn widths_of(recording: &Recording) -> Vec<f64> {
        let design = Design::new(recording, &Split::automatic(recording)).unwrap();
        design.setting().reversal_widths.clone()
    }

    #[test]
    fn the_width_of_a_reversal_is_found_and_a_jump_stays_a_jump() {
        for (width, low, high) in [(0.1, 0.06, 0.16), (1e-6, 0.0, 0.0)] {
            let found = widths_of(&log(|qd| 2.0 * (qd / width).tanh()));
            assert!((low..=high).contains(&found[1]), "{width}: {found:?}");
            assert_eq!(found[0], 0.0, "nothing rubs on joint 1");
        }
    }

    /// Neither is rounded off: a power of the speed rises steeply, and Stribeck's friction falls.
    #[test]
    fn the_shape_of_a_friction_over_the_speed_is_not_taken_for_a_wide_reversal() {
        let power = |qd: f64| 2.0 * sign(qd) * qd.abs().powf(0.45);
        let falling = |qd: f64| sign(qd) * (1.0 + 1.5 * (-(qd / 0.5).powi(2)).exp());
        let both = |qd: f64| power(qd) + 1.5 * sign(qd);
        for (what, found) in
            [("power", widths_of(&log(power))), ("fall", widths_of(&log(falling))), ("both", widths_of(&log(both)))]
        {
            assert_eq!(found[1], 0.0, "{what}");
        }
    }
}
