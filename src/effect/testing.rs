//! A short motion of three joints to compute effects on, and the comparison with a formula.

use super::*;
use crate::arm::Arm;
use crate::signals::Signals;

pub(crate) struct Sample {
    pub(crate) arm: Arm,
    pub(crate) trajectory: Trajectory,
    pub(crate) kinds: Vec<JointKind>,
    load: Load,
}

/// A parabola in time that changes its sign.
fn load(joint: usize, time: f64) -> f64 {
    40.0 * (time - 0.07) * (time - 0.15) + 0.03 * (joint as f64 - 1.0)
}

impl Sample {
    /// Positions, velocities (0 among them) and accelerations of either sign; they need not fit together.
    pub(crate) fn new() -> Self {
        let signal = |scale: f64, shift: f64| {
            Signals::from_fn(3, 21, |joint, t| scale * (t as f64 - 10.0 + shift + joint as f64))
        };
        let time: Vec<f64> = (0..21).map(|t| 0.01 * t as f64).collect();
        let (q, qd, qdd) = (signal(0.13, 0.4), signal(0.21, 0.0), signal(-0.7, 0.3));
        let arm = Arm::uniform(3);
        let torque = Signals::from_fn(3, 21, |joint, t| load(joint, time[t]));
        let turned_gravity = arm.turned_gravity_along(&q);
        let of_arm = arm.clone();
        // What the arm lacks of that load is the same however it moves, so that slopes are the arm's.
        let mut lack = torque;
        lack.add(&arm.inverse_dynamics_along(&q, &qd, &qdd), -1.0);
        let body = move |motion: &Trajectory| {
            let mut torque = of_arm.inverse_dynamics_along(&motion.q, &motion.qd, &motion.qdd);
            torque.add(&lack, 1.0);
            torque
        };
        let channels = Channels { time, q, qd, qdd, tau: Signals::zeros(3, 21) };
        let trajectory = Trajectory::new("", channels).unwrap();
        let load = Load::by(body, turned_gravity, Some(arm.lumped_parameters()), &trajectory);
        Sample { arm, trajectory, kinds: vec![JointKind::Revolute; 3], load }
    }

    /// dτ/dt of the load.
    pub(crate) fn load_rate(&self, joint: usize) -> impl Iterator<Item = f64> {
        let slope = move |&time: &f64| (load(joint, time + 1e-3) - load(joint, time - 1e-3)) / 2e-3;
        self.trajectory.time.iter().map(slope)
    }

    pub(crate) fn motion(&self) -> Motion<'_> {
        Motion {
            trajectory: &self.trajectory,
            kinds: &self.kinds,
            posture: self.arm.posture,
            gravity: self.arm.gravity,
            arm: Some(&self.arm),
            chain: None,
            load: Some(&self.load),
            reversal_widths: &[],
        }
    }
}

/// Checks that on joint 1 (from 0) the torque is that of a formula of q, q̇, q̈, and that other joints feel nothing.
pub(crate) fn assert_is(effect: &Effect, parameters: &[f64], formula: impl Fn(f64, f64, f64) -> f64) {
    let sample = Sample::new();
    let torque = effect.torque(&sample.motion(), 1, parameters).unwrap();
    let Channels { q, qd, qdd, .. } = &*sample.trajectory;
    for t in 0..sample.trajectory.len() {
        let expected = formula(q[1][t], qd[1][t], qdd[1][t]);
        assert!((torque[1][t] - expected).abs() < 1e-12, "{} is not {expected}", torque[1][t]);
    }
    assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
}

/// The same for a formula of the load, q and q̇; without a load the effect must say what it lacks.
pub(crate) fn assert_depends_on_load(effect: &Effect, parameters: &[f64], formula: impl Fn(f64, f64, f64) -> f64) {
    let sample = Sample::new();
    let torque = effect.torque(&sample.motion(), 1, parameters).unwrap();
    let Channels { q, qd, time, .. } = &*sample.trajectory;
    for t in 0..sample.trajectory.len() {
        let expected = formula(load(1, time[t]), q[1][t], qd[1][t]);
        assert!((torque[1][t] - expected).abs() < 1e-12, "{} is not {expected}", torque[1][t]);
    }
    assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
    let lacking = effect.columns(&Motion { load: None, ..sample.motion() }, 1, &[]).unwrap_err().to_string();
    assert!(lacking.contains("rigid body"), "{lacking}");
}
