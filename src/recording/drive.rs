//! The law of a drive: the torque that follows from a command where a log holds no torque.
//!
//! A cheap servo reports its angle and what it was told, nothing else. Its torque is known as well as its law is: what the law lacks
//! (a lag, a limit, a wrong constant) is then in everything that is found, so a finding says what it absorbs.
//! Source of the motor's law: Siciliano, Sciavicco, Villani, Oriolo, Robotics (2009), section 5.2.

use serde::{Deserialize, Serialize};

use super::mapping::Channel;
use crate::signals::Signals;

/// What a drive makes of its command; constants are a number for all joints, or a list with one a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Drive {
    /// The command is a position: τ = kp (q_cmd − q) − kd q̇.
    Position {
        /// Torque of an error of position \[N m/rad\].
        kp: PerJoint,
        /// Torque that a velocity takes off \[N m s/rad\].
        kd: PerJoint,
    },
    /// The command is a velocity: τ = kv (q̇_cmd − q̇).
    Velocity {
        /// Torque of an error of velocity \[N m s/rad\].
        kv: PerJoint,
    },
    /// The command is the voltage of a motor: τ = kt n (u − ke n q̇) / R.
    Voltage {
        /// Torque of a current, at the motor \[N m/A\].
        kt: PerJoint,
        /// Back-EMF of a speed of the motor \[V s/rad\].
        ke: PerJoint,
        /// Of the winding, with that of the drive \[Ω\].
        resistance: PerJoint,
        /// How often the motor turns while the joint turns once.
        ratio: PerJoint,
    },
}

/// A constant of a drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a constant of a drive is a number, or a list with one a joint")]
pub enum PerJoint {
    /// The same for all joints.
    One(f64),
    /// One a joint.
    Several(Vec<f64>),
}

impl PerJoint {
    /// Of a joint; NaN where there is none.
    fn of(&self, joint: usize) -> f64 {
        match self {
            PerJoint::One(value) => *value,
            PerJoint::Several(values) => values.get(joint).copied().unwrap_or(f64::NAN),
        }
    }
}

/// A constant of the law can't be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DriveError {
    /// Another number of joints.
    #[error("`{name}` of the drive has {found} numbers for {joints} joints; give one number, or one a joint")]
    Size {
        /// Which constant.
        name: &'static str,
        /// How many it has.
        found: usize,
        /// How many there are.
        joints: usize,
    },
    /// Not a number that it can be.
    #[error("`{name}` of the drive is {value} on joint {joint}, but must be {must}")]
    Value {
        /// Which constant.
        name: &'static str,
        /// Counted from 1.
        joint: usize,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
}

impl Drive {
    /// The channel whose units its command has; `None` for volts.
    pub fn command(&self) -> Option<Channel> {
        match self {
            Drive::Position { .. } => Some(Channel::Position),
            Drive::Velocity { .. } => Some(Channel::Velocity),
            Drive::Voltage { .. } => None,
        }
    }

    /// Whether its constants can be those of an arm with so many joints.
    ///
    /// # Errors
    /// [`DriveError`] names the first that can't.
    pub fn check_for(&self, joints: usize) -> Result<(), DriveError> {
        for (name, constant, may_be_zero) in self.constants() {
            if let PerJoint::Several(values) = constant
                && values.len() != joints
            {
                return Err(DriveError::Size { name, found: values.len(), joints });
            }
            let is_wrong = |value: f64| !value.is_finite() || (value == 0.0 && !may_be_zero);
            if let Some(joint) = (0..joints).find(|joint| is_wrong(constant.of(*joint))) {
                let must = if may_be_zero { "a finite number" } else { "a finite number other than 0" };
                return Err(DriveError::Value { name, joint: joint + 1, value: constant.of(joint), must });
            }
        }
        Ok(())
    }

    /// Its constants with their names, and whether they may be 0.
    fn constants(&self) -> Vec<(&'static str, &PerJoint, bool)> {
        match self {
            Drive::Position { kp, kd } => vec![("kp", kp, false), ("kd", kd, true)],
            Drive::Velocity { kv } => vec![("kv", kv, false)],
            Drive::Voltage { kt, ke, resistance, ratio } => {
                vec![("kt", kt, false), ("ke", ke, true), ("resistance", resistance, false), ("ratio", ratio, false)]
            }
        }
    }

    /// On a joint, how much torque a unit of command makes, and a unit of position and of velocity take off it.
    fn factors(&self, joint: usize) -> [f64; 3] {
        match self {
            Drive::Position { kp, kd } => [kp.of(joint), kp.of(joint), kd.of(joint)],
            Drive::Velocity { kv } => [kv.of(joint), 0.0, kv.of(joint)],
            Drive::Voltage { kt, ke, resistance, ratio } => {
                let per_volt = kt.of(joint) * ratio.of(joint) / resistance.of(joint);
                [per_volt, 0.0, per_volt * ke.of(joint) * ratio.of(joint)]
            }
        }
    }

    /// The torque \[N m\] that follows from a command in SI units, at these positions and velocities.
    pub fn torque(&self, command: &Signals, q: &Signals, qd: &Signals) -> Signals {
        command.map_each(|joint, command| {
            let [gain, stiffness, damping] = self.factors(joint);
            let motion = q[joint].iter().zip(&qd[joint]);
            command.iter().zip(motion).map(|(u, (q, qd))| gain * u - stiffness * q - damping * qd).collect()
        })
    }

    /// The law, and what it takes from what is found, as two sentences.
    pub fn absorbs(&self, joints: usize) -> [String; 2] {
        let damping = (0..joints).map(|joint| format!("{:.4}", self.factors(joint)[2])).collect::<Vec<_>>().join(", ");
        let (law, constants) = match self {
            Drive::Position { .. } => (
                "kp (q_cmd − q) − kd q̇",
                format!(
                    "An error of kp scales every parameter; one of kd is viscous friction (kd is {damping} N m s/rad); an integral \
                     term that the drive has beside them is missing in the torque."
                ),
            ),
            Drive::Velocity { .. } => (
                "kv (q̇_cmd − q̇)",
                format!(
                    "An error of kv ({damping} N m s/rad) scales every parameter; an integral term that the drive has beside it is \
                     missing in the torque."
                ),
            ),
            Drive::Voltage { .. } => (
                "kt n (u − ke n q̇) / R",
                format!(
                    "An error of kt/R scales every parameter; one of ke is viscous friction: no data tell the two apart (the back-EMF \
                     takes {damping} N m s/rad); the resistance of a warm motor is higher."
                ),
            ),
        };
        let what =
            format!("there is no torque in the log: it follows from the command by the law of the drive, τ = {law}.");
        let remedy = format!("{constants} Lag and limits of the drive are in what is left.");
        [what, remedy]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(value: f64) -> Signals {
        Signals::from_samples(1, &[value])
    }

    /// A motor of 0.05 N m/A and 2 Ω behind a gear of 10 at 12 V: stalled it makes 3 N m, at 24 rad/s nothing.
    #[test]
    fn a_motor_stalls_and_idles_where_its_sheet_says() {
        let number = PerJoint::One;
        let drive = Drive::Voltage { kt: number(0.05), ke: number(0.05), resistance: number(2.0), ratio: number(10.0) };
        assert!((drive.torque(&one(12.0), &one(0.3), &one(0.0))[0][0] - 3.0).abs() < 1e-12);
        assert!(drive.torque(&one(12.0), &one(0.3), &one(24.0))[0][0].abs() < 1e-12);
        assert!(drive.absorbs(1)[1].contains("takes 0.1250 N m s/rad"), "{:?}", drive.absorbs(1));
    }

    #[test]
    fn constants_that_can_not_be_are_named() {
        let drive = Drive::Position { kp: PerJoint::Several(vec![1.0, 0.0]), kd: PerJoint::One(0.0) };
        let told = |joints| drive.check_for(joints).unwrap_err().to_string();
        assert!(told(3).contains("`kp` of the drive has 2 numbers for 3 joints"), "{}", told(3));
        assert!(told(2).contains("`kp` of the drive is 0 on joint 2"), "{}", told(2));
    }
}
