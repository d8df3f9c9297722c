//! What a step can ask of a state of the arm that a student made.

use serde::Deserialize;

use crate::arm::Arm;
use crate::session::study::Pose;

/// Something that a state of the arm is to fulfil. Joints are counted from 1 in files.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseWish {
    /// Gravity makes hardly any torque at a joint.
    NoGravity {
        /// Which.
        joint: usize,
        /// So little \[N m\].
        below: f64,
    },
    /// Gravity makes a good deal of torque at a joint, so that the arm does not just stand upright.
    Gravity {
        /// Which.
        joint: usize,
        /// So much at least \[N m\].
        above: f64,
    },
    /// Of the three parts, the Coriolis torque is the largest at a joint.
    MostlyCoriolis {
        /// Which.
        joint: usize,
    },
    /// A joint that does not accelerate needs inertial torque all the same.
    CoupledInertia {
        /// Which.
        joint: usize,
        /// So much at least \[N m\].
        above: f64,
    },
}

/// The parts of the torque at a state, one value for each joint \[N m\].
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// H(q) q̈
    pub inertial: Vec<f64>,
    /// c(q, q̇)
    pub coriolis: Vec<f64>,
    /// g(q)
    pub gravity: Vec<f64>,
}

impl Parts {
    /// Of an arm in a state; `None` if the state is of another arm or is no state.
    pub fn of(arm: &Arm, pose: &Pose) -> Option<Parts> {
        let Pose { q, qd, qdd } = pose;
        let fits =
            |values: &Vec<f64>| values.len() == arm.joint_count() && values.iter().all(|value| value.is_finite());
        if ![q, qd, qdd].into_iter().all(fits) {
            return None;
        }
        let mass = arm.mass_matrix(q);
        let row = |joint: usize| (0..qdd.len()).map(|other| mass[(joint, other)] * qdd[other]).sum();
        let inertial = (0..qdd.len()).map(row).collect();
        Some(Parts { inertial, coriolis: arm.coriolis(q, qd), gravity: arm.gravity_torque(q) })
    }
}

impl PoseWish {
    /// Whether a state of an arm fulfils it; else what lacks.
    pub(super) fn check(&self, arm: &Arm, pose: &Pose) -> Result<(), String> {
        let parts = Parts::of(arm, pose).ok_or("this is no state of the arm")?;
        let at = |values: &[f64], joint: usize| values.get(joint - 1).map_or(f64::NAN, |value| value.abs());
        let number = self.joint();
        if !(1..=arm.joint_count()).contains(&number) {
            return Err(format!("the arm has no joint {number}"));
        }
        let [inertial, coriolis, gravity] =
            [&parts.inertial, &parts.coriolis, &parts.gravity].map(|part| at(part, number));
        let (is_so, what) = match self {
            PoseWish::NoGravity { below, .. } => {
                (gravity <= *below, format!("gravity makes {gravity:.2} N m at joint {number}"))
            }
            PoseWish::Gravity { above, .. } => {
                (gravity >= *above, format!("gravity makes only {gravity:.2} N m at joint {number}"))
            }
            PoseWish::MostlyCoriolis { .. } => {
                let largest = inertial.max(gravity);
                (coriolis > largest, format!("at joint {number}, {largest:.2} N m stand against {coriolis:.2} N m"))
            }
            PoseWish::CoupledInertia { above, .. } => {
                let is_still = at(&pose.qdd, number) < 1e-9;
                let what = if is_still { "needs only" } else { "accelerates itself, and needs" };
                (is_still && inertial >= *above, format!("joint {number} {what} {inertial:.2} N m of inertial torque"))
            }
        };
        if is_so { Ok(()) } else { Err(what) }
    }

    fn joint(&self) -> usize {
        match self {
            PoseWish::NoGravity { joint, .. }
            | PoseWish::Gravity { joint, .. }
            | PoseWish::MostlyCoriolis { joint }
            | PoseWish::CoupledInertia { joint, .. } => *joint,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum of one rod hangs without torque, and needs m g l / 2 when it lies.
    #[test]
    fn gravity_is_judged_by_the_arm() {
        let arm = Arm::uniform(1);
        let turned = |angle: f64| Pose { q: vec![angle - arm.posture.zero_angle], qd: vec![0.0], qdd: vec![0.0] };
        let none = PoseWish::NoGravity { joint: 1, below: 0.1 };
        assert!(none.check(&arm, &turned(-std::f64::consts::FRAC_PI_2)).is_ok());
        assert_eq!(none.check(&arm, &turned(0.0)).unwrap_err(), "gravity makes 4.91 N m at joint 1");
        assert!(PoseWish::Gravity { joint: 1, above: 4.9 }.check(&arm, &turned(0.0)).is_ok());
        assert!(none.check(&arm, &Pose::default()).is_err());
        assert!(PoseWish::NoGravity { joint: 0, below: 1.0 }.check(&arm, &turned(0.0)).is_err());
    }

    /// The parts add up to what the arm needs.
    #[test]
    fn parts_add_up() {
        let arm = Arm::uniform(3);
        let pose = Pose { q: vec![0.3, -1.0, 0.7], qd: vec![1.0, 2.0, -0.5], qdd: vec![-2.0, 0.4, 3.0] };
        let (parts, whole) = (Parts::of(&arm, &pose).unwrap(), arm.inverse_dynamics(&pose.q, &pose.qd, &pose.qdd));
        for joint in 0..3 {
            let sum = parts.inertial[joint] + parts.coriolis[joint] + parts.gravity[joint];
            assert!((sum - whole[joint]).abs() < 1e-12);
        }
    }
}
