//! Units that the names of columns state, and what they are in SI units.

use super::Channel;
use super::words::is_axis_of_kuka;
use crate::recording::JointKind;

/// A unit that a column's name states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::recording) struct Unit {
    /// As it stands in the name.
    pub text: &'static str,
    /// The channels it can belong to.
    pub channels: &'static [Channel],
    /// SI value of one unit.
    pub factor: f64,
    /// The kind of joint it tells, where it does.
    pub kind: Option<JointKind>,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn unit(text: &'static str, channels: &'static [Channel], factor: f64, kind: Option<JointKind>) -> Unit {
    Unit { text, channels, factor, kind }
}

/// The longer before the shorter ones that they end with.
const UNITS: &[Unit] = {
    use Channel::{Acceleration, Position, Time, Torque, Velocity};
    use JointKind::{Prismatic, Revolute};
    &[
        unit("deg_per_s2", &[Acceleration], DEGREE, Some(Revolute)),
        unit("deg/s^2", &[Acceleration], DEGREE, Some(Revolute)),
        unit("deg/s2", &[Acceleration], DEGREE, Some(Revolute)),
        unit("deg/s²", &[Acceleration], DEGREE, Some(Revolute)),
        unit("rad/s^2", &[Acceleration], 1.0, Some(Revolute)),
        unit("rad/s2", &[Acceleration], 1.0, Some(Revolute)),
        unit("rad/s²", &[Acceleration], 1.0, Some(Revolute)),
        unit("m/s^2", &[Acceleration], 1.0, Some(Prismatic)),
        unit("m/s2", &[Acceleration], 1.0, Some(Prismatic)),
        unit("m/s²", &[Acceleration], 1.0, Some(Prismatic)),
        unit("deg_per_s", &[Velocity], DEGREE, Some(Revolute)),
        unit("rad_per_s", &[Velocity], 1.0, Some(Revolute)),
        unit("deg/s", &[Velocity], DEGREE, Some(Revolute)),
        unit("rad/s", &[Velocity], 1.0, Some(Revolute)),
        unit("mm/s", &[Velocity], 1e-3, Some(Prismatic)),
        unit("m/s", &[Velocity], 1.0, Some(Prismatic)),
        unit("degrees", &[Position], DEGREE, Some(Revolute)),
        unit("deg", &[Position], DEGREE, Some(Revolute)),
        unit("°", &[Position], DEGREE, Some(Revolute)),
        unit("rad", &[Position], 1.0, Some(Revolute)),
        unit("mm", &[Position], 1e-3, Some(Prismatic)),
        unit("mnm", &[Torque], 1e-3, Some(Revolute)),
        unit("knm", &[Torque], 1e3, Some(Revolute)),
        unit("n·m", &[Torque], 1.0, Some(Revolute)),
        unit("n*m", &[Torque], 1.0, Some(Revolute)),
        unit("n m", &[Torque], 1.0, Some(Revolute)),
        unit("nm", &[Torque], 1.0, Some(Revolute)),
        unit("n", &[Torque], 1.0, Some(Prismatic)),
        unit("msec", &[Time], 1e-3, None),
        unit("usec", &[Time], 1e-6, None),
        unit("nsec", &[Time], 1e-9, None),
        unit("sec", &[Time], 1.0, None),
        unit("ms", &[Time], 1e-3, None),
        unit("us", &[Time], 1e-6, None),
        unit("µs", &[Time], 1e-6, None),
        unit("ns", &[Time], 1e-9, None),
        unit("s", &[Time], 1.0, None),
        unit("m", &[Position], 1.0, Some(Prismatic)),
    ]
};

/// The name without the unit that stands at its end, in brackets or after `_`, and that unit.
pub(in crate::recording) fn split_unit(name: &str) -> (&str, Option<Unit>) {
    let name = name.trim();
    // `speed_deg_per_s[2]`: the unit stands before the number of the joint.
    if let Some((array, number)) = name.strip_suffix(']').and_then(|start| start.rsplit_once('['))
        && number.parse::<usize>().is_ok()
    {
        return (name, split_unit(array).1);
    }
    for (open, close) in [('[', ']'), ('(', ')')] {
        let inside = name.strip_suffix(close).and_then(|start| start.rsplit_once(open));
        if let Some((bare, text)) = inside {
            return match unit_named(text) {
                Some(unit) => (bare.trim_end(), Some(unit)),
                None => (name, None),
            };
        }
    }
    let lower = name.to_ascii_lowercase();
    for unit in UNITS.iter().filter(|unit| unit.text.len() > 1) {
        if let Some(bare) = lower.strip_suffix(unit.text).and_then(|start| start.strip_suffix('_')) {
            return (&name[..bare.len()], Some(*unit));
        }
    }
    // The controllers of KUKA count angles in degrees, and their names do not say it.
    (name, unit_named("deg").filter(|_| is_axis_of_kuka(name)))
}

/// Units to choose from for a channel, as people write them; SI for joints that turn first.
pub(super) fn choices(channel: Channel) -> &'static [&'static str] {
    match channel {
        Channel::Time => &["s", "ms", "µs", "ns"],
        Channel::Position => &["rad", "deg", "m", "mm"],
        Channel::Velocity => &["rad/s", "deg/s", "m/s", "mm/s"],
        Channel::Acceleration => &["rad/s²", "deg/s²", "m/s²"],
        Channel::Torque => &["Nm", "mNm", "kNm", "N"],
    }
}

/// The unit with this text.
pub(in crate::recording) fn unit_named(text: &str) -> Option<Unit> {
    let text = text.trim().to_lowercase();
    UNITS.iter().find(|unit| unit.text == text).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_names() {
        for (name, bare, text) in [
            ("q1[deg]", "q1", "deg"),
            ("q1 (deg)", "q1", "deg"),
            ("pos_deg", "pos", "deg"),
            ("vel_deg_per_s", "vel", "deg_per_s"),
            ("time_ms", "time", "ms"),
            ("Zeit [s]", "Zeit", "s"),
            ("tau[mNm]", "tau", "mnm"),
            ("AxisAct_A1", "AxisAct_A1", "deg"),
            ("$AXIS_ACT_MEAS[2]", "$AXIS_ACT_MEAS[2]", "deg"),
            ("AxisAct_A1[rad]", "AxisAct_A1", "rad"),
        ] {
            let (rest, unit) = split_unit(name);
            assert_eq!((rest, unit.map(|unit| unit.text)), (bare, Some(text)));
        }
        for name in ["q[0]", "tau_meas1", "pos", "q_m1", "rad"] {
            assert_eq!(split_unit(name), (name, None));
        }
    }
}
