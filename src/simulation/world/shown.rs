//! How much of what something does could not be said by a rigid body and by what nearly every joint has.
//!
//! Along some motions a cable or a liquid does what other masses, a constant and friction would do. Whatever a diagnosis then says
//! of it, nobody can ask of it to say that something unknown is there.

use nalgebra::{DMatrix, DVector};

use crate::arm::regressor;
use crate::arm::{Arm, Posture};
use crate::effect::sign;
use crate::recording::{Channels, Trajectory};
use crate::signals::Signals;

/// So many moments of a recording are looked at, evenly spread.
const MOMENTS: usize = 2000;
/// A direction in which columns are less than this share of the strongest one is none.
const RANK: f64 = 1e-9;
/// What is fitted on each joint alone: q̈, q̇, its sign, 1.
const OWN: usize = 4;

/// RMS of what is left of this torque \[N m\] by joint when all lumped parameters of the arm, the weight of masses beside its links, and
/// on each joint the inertia of a rotor, viscous and Coulomb friction and a constant were fitted to it along these runs, by least
/// squares over all joints, each in units of its own torque.
pub(super) fn left(arm: &Arm, runs: &[Trajectory], torque: &[Signals]) -> Vec<f64> {
    let joints = arm.joint_count();
    let lumped = regressor::parameter_count(joints);
    let samples: usize = runs.iter().map(Trajectory::len).sum();
    let moments: Vec<(usize, usize)> = runs
        .iter()
        .enumerate()
        .flat_map(|(run, trajectory)| (0..trajectory.len()).map(move |sample| (run, sample)))
        .step_by(samples.div_ceil(MOMENTS).max(1))
        .collect();
    let scale = |joint: usize| {
        let squares = moments.iter().map(|&(run, sample)| torque[run][joint][sample].powi(2)).sum::<f64>();
        (squares / moments.len() as f64).sqrt()
    };
    let scales: Vec<f64> = (0..joints).map(scale).collect();
    let turned = Posture { zero_angle: arm.posture.zero_angle + std::f64::consts::FRAC_PI_2, ..arm.posture };
    let mut columns = DMatrix::zeros(moments.len() * joints, lumped + joints + OWN * joints);
    let mut wanted = DVector::zeros(moments.len() * joints);
    let [mut body, mut beside] = [(); 2].map(|()| vec![0.0; joints * lumped]);
    for (moment, &(run, sample)) in moments.iter().enumerate() {
        let Channels { q, qd, qdd, .. } = &*runs[run];
        let at = |signals: &Signals| signals.at(sample).collect::<Vec<f64>>();
        let [q, qd, qdd] = [at(q), at(qd), at(qdd)];
        regressor::fill(arm.posture, arm.gravity, &q, &qd, &qdd, &mut body);
        regressor::fill(turned, arm.gravity, &q, &qd, &qdd, &mut beside);
        for joint in 0..joints {
            let weight = if scales[joint] > 0.0 { 1.0 / scales[joint] } else { 0.0 };
            let row = moment * joints + joint;
            let of_body = &body[joint * lumped..(joint + 1) * lumped];
            let weights_beside = &beside[(joint + 1) * lumped - joints..(joint + 1) * lumped];
            for (column, value) in of_body.iter().chain(weights_beside).enumerate() {
                columns[(row, column)] = weight * value;
            }
            for (own, value) in [qdd[joint], qd[joint], sign(qd[joint]), 1.0].into_iter().enumerate() {
                columns[(row, lumped + joints + OWN * joint + own)] = weight * value;
            }
            wanted[row] = weight * torque[run][joint][sample];
        }
    }
    for mut column in columns.column_iter_mut() {
        let length = column.norm();
        column /= if length > 0.0 { length } else { 1.0 };
    }
    let decomposed = columns.clone().svd(true, true);
    let rest = match decomposed.solve(&wanted, RANK) {
        Ok(factors) => wanted - columns * factors,
        Err(_) => wanted,
    };
    let left_on = |joint: usize| {
        let squares = rest.iter().skip(joint).step_by(joints).map(|value| value * value).sum::<f64>();
        scales[joint] * (squares / moments.len() as f64).sqrt()
    };
    (0..joints).map(left_on).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Link;
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    fn rms(runs: &[Signals], joint: usize) -> f64 {
        let squares: Vec<f64> = runs.iter().flat_map(|run| &run[joint]).map(|value| value * value).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    /// Nothing is left of another arm's torque with friction and a constant; of a torque that turns back and forth with time all is.
    #[test]
    fn what_a_body_and_friction_do_leaves_nothing() {
        let scenario = Scenario { effects: Vec::new(), ..Scenario::embedded() };
        let arm = &scenario.arm;
        let runs = simulate(&scenario, &Monitor::new()).unwrap().trajectories;
        let heavier = Arm {
            links: arm.links.iter().map(|link| Link { mass: 1.3 * link.mass, ..*link }).collect(),
            posture: Posture { zero_angle: arm.posture.zero_angle + 0.2, ..arm.posture },
            ..arm.clone()
        };
        let everyday = |run: &Trajectory| {
            let torque = heavier.inverse_dynamics_along(&run.q, &run.qd, &run.qdd);
            torque.map_each(|joint, torque| {
                let with_friction = |(value, &qd): (&f64, &f64)| value + 0.4 * qd + 0.3 * sign(qd) - 0.7;
                torque.iter().zip(&run.qd[joint]).map(with_friction).collect()
            })
        };
        let odd = |run: &Trajectory| {
            Signals::from_fn(arm.joint_count(), run.len(), |_, sample| (20.0 * run.time[sample]).sin())
        };
        let [everyday, odd]: [Vec<Signals>; 2] = [runs.iter().map(everyday).collect(), runs.iter().map(odd).collect()];
        let left_of = |torque: &[Signals]| left(arm, &runs, torque);
        for joint in 0..arm.joint_count() {
            assert!(left_of(&everyday)[joint] < 1e-6 * rms(&everyday, joint), "{:?}", left_of(&everyday));
            assert!(left_of(&odd)[joint] > 0.9 * rms(&odd, joint), "{:?}", left_of(&odd));
        }
        let still: Vec<Signals> = odd.iter().map(|run| run.map(|_| 0.0)).collect();
        assert_eq!(left_of(&still), vec![0.0; arm.joint_count()]);
    }
}
