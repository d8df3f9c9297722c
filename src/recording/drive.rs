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

/// What a constant of a law is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Constant {
    /// Its name in mapping files.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it says.
    pub about: &'static str,
    /// Whether a drive may have it 0.
    pub may_be_zero: bool,
}

const KP: Constant =
    Constant { name: "kp", unit: "N m/rad", about: "torque of an error of position", may_be_zero: false };
const KD: Constant =
    Constant { name: "kd", unit: "N m s/rad", about: "torque that a velocity takes off", may_be_zero: true };
const KV: Constant =
    Constant { name: "kv", unit: "N m s/rad", about: "torque of an error of velocity", may_be_zero: false };
const KT: Constant =
    Constant { name: "kt", unit: "N m/A", about: "torque of a current, at the motor", may_be_zero: false };
const KE: Constant =
    Constant { name: "ke", unit: "V s/rad", about: "back-EMF of a speed of the motor", may_be_zero: true };
const RESISTANCE: Constant =
    Constant { name: "resistance", unit: "Ω", about: "of the winding, with that of the drive", may_be_zero: false };
const RATIO: Constant = Constant {
    name: "ratio",
    unit: "",
    about: "how often the motor turns while the joint turns once",
    may_be_zero: false,
};

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

impl std::fmt::Display for PerJoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PerJoint::One(value) => write!(f, "{value}"),
            PerJoint::Several(values) => f.write_str(&values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")),
        }
    }
}

impl std::str::FromStr for PerJoint {
    type Err = std::num::ParseFloatError;

    /// A number, or one a joint with commas between them.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let values: Vec<f64> = text.split(',').map(|value| value.trim().parse()).collect::<Result<_, _>>()?;
        Ok(if let [value] = values[..] { PerJoint::One(value) } else { PerJoint::Several(values) })
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
    /// Every law with its name; constants that only the maker of a drive knows are not a number.
    pub fn laws() -> [(&'static str, Drive); 3] {
        let unknown = || PerJoint::One(f64::NAN);
        let number = PerJoint::One;
        [
            ("position command", Drive::Position { kp: unknown(), kd: number(0.0) }),
            ("velocity command", Drive::Velocity { kv: unknown() }),
            ("voltage", Drive::Voltage { kt: unknown(), ke: unknown(), resistance: unknown(), ratio: number(1.0) }),
        ]
    }

    /// What it is a law of, as [`Drive::laws`] calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Drive::Position { .. } => "position command",
            Drive::Velocity { .. } => "velocity command",
            Drive::Voltage { .. } => "voltage",
        }
    }

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
        for (Constant { name, may_be_zero, .. }, constant) in self.constants() {
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

    /// Its constants, and what they are.
    pub fn constants(&self) -> Vec<(Constant, &PerJoint)> {
        match self {
            Drive::Position { kp, kd } => vec![(KP, kp), (KD, kd)],
            Drive::Velocity { kv } => vec![(KV, kv)],
            Drive::Voltage { kt, ke, resistance, ratio } => {
                vec![(KT, kt), (KE, ke), (RESISTANCE, resistance), (RATIO, ratio)]
            }
        }
    }

    /// Its constants, in the same order, to be set.
    pub fn constants_mut(&mut self) -> Vec<&mut PerJoint> {
        match self {
            Drive::Position { kp, kd } => vec![kp, kd],
            Drive::Velocity { kv } => vec![kv],
            Drive::Voltage { kt, ke, resistance, ratio } => vec![kt, ke, resistance, ratio],
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
    fn constants_are_written_as_they_are_read() {
        for text in ["3.5", "1, -2, 0.25"] {
            assert_eq!(text.parse::<PerJoint>().unwrap().to_string(), text);
        }
        assert!("1, two".parse::<PerJoint>().is_err() && "".parse::<PerJoint>().is_err());
        for (name, mut law) in Drive::laws() {
            assert_eq!((law.name(), law.constants().len()), (name, law.clone().constants_mut().len()));
            assert!(law.check_for(2).is_err(), "nobody but its maker knows {name}");
            law.constants_mut().into_iter().for_each(|constant| *constant = PerJoint::One(2.0));
            law.check_for(2).unwrap();
        }
    }

    #[test]
    fn constants_that_can_not_be_are_named() {
        let drive = Drive::Position { kp: PerJoint::Several(vec![1.0, 0.0]), kd: PerJoint::One(0.0) };
        let told = |joints| drive.check_for(joints).unwrap_err().to_string();
        assert!(told(3).contains("`kp` of the drive has 2 numbers for 3 joints"), "{}", told(3));
        assert!(told(2).contains("`kp` of the drive is 0 on joint 2"), "{}", told(2));
    }
}
