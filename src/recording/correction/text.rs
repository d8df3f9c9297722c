//! A correction as people write it: what, `@` the joints it is about, `=` its values.

use std::fmt;
use std::str::FromStr;

use super::{Correction, Counted, Part, Play};
use crate::recording::joints_in;

/// The text is no correction.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{text}` {problem}; corrections are zero=down (right, up, left or degrees), zero@2=90, sign-torque@2, sign-motion@2, sign@2, \
     order-torque=2,1, order-motion=2,1, order=2,1, angles=absolute, angles=relative, factor-velocity@1,2=0.1 (motion, position, \
     rates, acceleration, torque), delay-torque=0.02 (position, rates, velocity, acceleration), play@1=0.3,0.12,0.04 (degrees, \
     friction before the gear, seconds to cross)"
)]
pub struct CorrectionTextError {
    /// What was written.
    text: String,
    /// What is wrong with it.
    problem: &'static str,
}

/// Directions of the first link at q = 0, in degrees from +x towards +z.
pub(super) const DIRECTIONS: [(&str, f64); 4] = [("right", 0.0), ("up", 90.0), ("left", 180.0), ("down", -90.0)];

impl Part {
    const ALL: [(Part, &'static str); 7] = [
        (Part::All, "all"),
        (Part::Motion, "motion"),
        (Part::Position, "position"),
        (Part::Rates, "rates"),
        (Part::Velocity, "velocity"),
        (Part::Acceleration, "acceleration"),
        (Part::Torque, "torque"),
    ];

    fn id(self) -> &'static str {
        Part::ALL.iter().find(|(part, _)| *part == self).map_or("", |(_, id)| id)
    }
}

/// A number without digits that say nothing.
fn short(value: f64) -> String {
    let rounded = (1e9 * value).round() / 1e9;
    if rounded == 0.0 { "0".to_owned() } else { rounded.to_string() }
}

/// One value a joint, or one for all.
fn values(values: &[f64]) -> String {
    let is_one = values.iter().all(|value| *value == values[0]);
    list(if is_one { &values[..values.len().min(1)] } else { values }, |value| short(*value))
}

fn list<T>(values: &[T], text: impl Fn(&T) -> String) -> String {
    values.iter().map(text).collect::<Vec<_>>().join(",")
}

fn numbers(joints: &[usize]) -> String {
    list(joints, |joint| (joint + 1).to_string())
}

impl fmt::Display for Correction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |what: &str, part: &Part| match part {
            Part::All => what.to_owned(),
            part => format!("{what}-{}", part.id()),
        };
        match self {
            Correction::Zero { angle } => match direction(*angle) {
                Some(name) => write!(f, "zero={name}"),
                None => write!(f, "zero={}", short(angle.to_degrees())),
            },
            Correction::Offset { joints, angles } => {
                let degrees: Vec<f64> = angles.iter().map(|angle| angle.to_degrees()).collect();
                write!(f, "zero@{}={}", numbers(joints), values(&degrees))
            }
            Correction::Sign { part, joints } => write!(f, "{}@{}", of("sign", part), numbers(joints)),
            Correction::Order { part, order } => write!(f, "{}={}", of("order", part), numbers(order)),
            Correction::Angles(Counted::Absolute) => f.write_str("angles=absolute"),
            Correction::Angles(Counted::Relative) => f.write_str("angles=relative"),
            Correction::Factor { part, joints, factors } => {
                write!(f, "{}@{}={}", of("factor", part), numbers(joints), values(factors))
            }
            Correction::Delay { part, seconds } => write!(f, "{}={}", of("delay", part), short(*seconds)),
            Correction::Play { joint, play } => {
                let values = [play.gap.to_degrees(), play.friction, play.crossing_time];
                write!(f, "play@{}={}", joint + 1, list(&values, |value| short(*value)))
            }
        }
    }
}

/// Its name, if the angle \[rad\] is one of the four directions.
pub(super) fn direction(angle: f64) -> Option<&'static str> {
    let is_there = |degrees: f64| {
        let turns = (angle.to_degrees() - degrees) / 360.0;
        (turns - turns.round()).abs() < 1e-9
    };
    DIRECTIONS.iter().find(|(_, degrees)| is_there(*degrees)).map(|(name, _)| *name)
}

impl FromStr for Correction {
    type Err = CorrectionTextError;

    fn from_str(text: &str) -> Result<Self, CorrectionTextError> {
        let wrong = |problem| CorrectionTextError { text: text.to_owned(), problem };
        let (head, value) = text.split_once('=').map_or((text, None), |(head, value)| (head, Some(value.trim())));
        let (name, joints) = head.split_once('@').map_or((head, None), |(name, joints)| (name, Some(joints)));
        let (what, part) = name.trim().split_once('-').map_or((name.trim(), "all"), |(what, part)| (what, part));
        let part = Part::ALL.iter().find(|(_, id)| *id == part).map(|(part, _)| *part);
        let part = part.ok_or_else(|| wrong("names no channels"))?;
        let value = || value.ok_or_else(|| wrong("has no value"));
        let joint_list = |text| joints_in(text).map_err(|_| wrong("has joints that are no numbers from 1"));
        let joints = || joint_list(joints.ok_or_else(|| wrong("names no joints"))?);
        let values = || value_list(value()?).ok_or_else(|| wrong("has a value that is not a finite number"));
        let single = || match values()?[..] {
            [value] => Ok(value),
            _ => Err(wrong("has several values")),
        };
        // One value stands for all joints.
        let of_joints = || {
            let (joints, values) = (joints()?, values()?);
            match values[..] {
                [value] => Ok((vec![value; joints.len()], joints)),
                _ if values.len() == joints.len() => Ok((values, joints)),
                _ => Err(wrong("has not as many values as joints")),
            }
        };
        match (what, part) {
            ("zero", Part::All) if head.contains('@') => {
                let (degrees, joints) = of_joints()?;
                Ok(Correction::Offset { joints, angles: degrees.into_iter().map(f64::to_radians).collect() })
            }
            ("zero", Part::All) => {
                let named = DIRECTIONS.iter().find(|(name, _)| Some(*name) == value().ok());
                let degrees = named.map_or_else(single, |(_, degrees)| Ok(*degrees))?;
                Ok(Correction::Zero { angle: degrees.to_radians() })
            }
            ("sign", part) => Ok(Correction::Sign { part, joints: joints()? }),
            ("order", part) => Ok(Correction::Order { part, order: joint_list(value()?)? }),
            ("angles", Part::All) => match value()? {
                "absolute" => Ok(Correction::Angles(Counted::Absolute)),
                "relative" => Ok(Correction::Angles(Counted::Relative)),
                _ => Err(wrong("is neither absolute nor relative")),
            },
            ("factor", part) => {
                let (factors, joints) = of_joints()?;
                if factors.contains(&0.0) {
                    return Err(wrong("has the factor 0, which leaves nothing"));
                }
                Ok(Correction::Factor { part, joints, factors })
            }
            ("delay", Part::All) => Err(wrong("delays all channels, which changes nothing")),
            ("delay", part) => Ok(Correction::Delay { part, seconds: single()? }),
            ("play", Part::All) => {
                let ([joint], [gap, friction, crossing_time]) = (&joints()?[..], &values()?[..]) else {
                    return Err(wrong(
                        "needs one joint and three values: the gap in degrees, the friction before the gear and the crossing time",
                    ));
                };
                if *crossing_time <= 0.0 {
                    return Err(wrong("has a crossing time that is not above 0"));
                }
                let play = Play { gap: gap.to_radians(), friction: *friction, crossing_time: *crossing_time };
                Ok(Correction::Play { joint: *joint, play })
            }
            _ => Err(wrong("is unknown")),
        }
    }
}

fn value_list(text: &str) -> Option<Vec<f64>> {
    let finite = |number: &str| number.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    text.split(',').map(finite).collect()
}

impl TryFrom<String> for Correction {
    type Error = CorrectionTextError;

    fn try_from(text: String) -> Result<Self, CorrectionTextError> {
        text.parse()
    }
}

impl From<Correction> for String {
    fn from(correction: Correction) -> String {
        correction.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        for text in [
            "zero=down",
            "zero=left",
            "zero=37.5",
            "zero@2,3=90,-45",
            "sign-torque@1,2",
            "sign-motion@2",
            "sign@3",
            "order-torque=2,1,3",
            "order=3,2,1",
            "angles=absolute",
            "angles=relative",
            "factor-motion@1,2=0.01,-0.02",
            "factor-velocity@1=57.295779513",
            "delay-torque=0.024",
            "delay-rates=-0.01",
            "play@2=0.3,0.12,0.04",
        ] {
            let correction: Correction = text.parse().unwrap();
            assert_eq!(correction.to_string(), text);
            let json = serde_json::to_string(&correction).unwrap();
            assert_eq!(json, format!("\"{text}\""));
            assert_eq!(serde_json::from_str::<Correction>(&json).unwrap().to_string(), text);
        }
        let all: Correction = "factor-velocity@1,2=0.1".parse().unwrap();
        assert_eq!(all.to_string(), "factor-velocity@1,2=0.1");
        assert_eq!(all, Correction::Factor { part: Part::Velocity, joints: vec![0, 1], factors: vec![0.1; 2] });
    }

    #[test]
    fn what_is_no_correction_is_told_with_what_it_could_be() {
        for (text, words) in [
            ("zero", "has no value"),
            ("zero=north", "not a finite number"),
            ("sign-torque", "names no joints"),
            ("sign-torque@0", "no numbers from 1"),
            ("sign-colour@1", "names no channels"),
            ("order=a,b", "no numbers from 1"),
            ("angles=odd", "neither absolute nor relative"),
            ("factor-velocity@1,2=1,2,3", "as many values as joints"),
            ("factor-velocity@1=0", "leaves nothing"),
            ("delay=0.1", "changes nothing"),
            ("play@1,2=0.3,0.12,0.04", "needs one joint and three values"),
            ("play@1=0.3", "needs one joint and three values"),
            ("play@1=0.3,0.12,0", "is not above 0"),
            ("delay-torque=NaN", "not a finite number"),
            ("turn", "is unknown"),
        ] {
            let error = text.parse::<Correction>().unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("order-torque=2,1"), "{text}: {error}");
        }
    }
}
