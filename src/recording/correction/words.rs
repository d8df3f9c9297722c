//! A correction in words: what is wrong with a log that needs it.

use std::f64::consts::PI;

use super::text::direction;
use super::{Correction, Counted, Part};
use crate::recording::joints_text;

/// Factors that have a name; within a hundredth.
const NAMED: [(f64, &str); 3] =
    [(180.0 / PI, "degrees"), (60.0 / (2.0 * PI), "revolutions a minute"), (1000.0, "thousandths")];

impl Part {
    /// What it is called: its noun, and whether that is a plural.
    fn noun(self) -> (&'static str, bool) {
        match self {
            Part::All => ("all channels", true),
            Part::Motion => ("the motion", false),
            Part::Position => ("the position", false),
            Part::Rates => ("velocity and acceleration", true),
            Part::Velocity => ("the velocity", false),
            Part::Acceleration => ("the acceleration", false),
            Part::Torque => ("the torque", false),
        }
    }
}

impl Correction {
    /// What is wrong with a log that needs it, as part of a sentence: `the torque of joint 2 has the other sign`.
    pub fn fault(&self) -> String {
        match self {
            Correction::Zero { angle } => match direction(*angle) {
                Some(side @ ("left" | "right")) => format!("the first link points to the {side} at q = 0"),
                Some(way) => format!("the first link points {way} at q = 0"),
                None => format!("the first link stands at {:.0}° from the right at q = 0", angle.to_degrees()),
            },
            Correction::Offset { joints, angles } => {
                let degrees: Vec<String> = angles.iter().map(|angle| format!("{:.0}°", angle.to_degrees())).collect();
                let verb = if angles.len() == 1 { "lacks" } else { "lack" };
                format!("{} {verb} to the angle of {}", degrees.join(", "), joints_text(joints))
            }
            Correction::Sign { part: Part::All, joints } if joints.len() == 1 => {
                format!("{} turns the other way", joints_text(joints))
            }
            Correction::Sign { part: Part::All, joints } => format!("{} turn the other way", joints_text(joints)),
            Correction::Sign { part, joints } => {
                let (noun, is_plural) = part.noun();
                let verb = if is_plural { "have" } else { "has" };
                format!("{noun} of {} {verb} the other sign", joints_text(joints))
            }
            Correction::Order { part, order } => {
                let numbers: Vec<String> = order.iter().map(|joint| (joint + 1).to_string()).collect();
                let (noun, is_plural) = if *part == Part::All { ("motion and torque", true) } else { part.noun() };
                let verb = if is_plural { "stand" } else { "stands" };
                format!("{noun} of joint 1, 2, … {verb} in column {}", numbers.join(", "))
            }
            Correction::Angles(Counted::Absolute) => {
                "angles are counted from one direction for all links, not from the link before".to_owned()
            }
            Correction::Angles(Counted::Relative) => {
                "angles are differences of the joints' angles, not the joints' angles".to_owned()
            }
            Correction::Factor { part, joints, factors } => {
                let mut times: Vec<String> = factors.iter().map(|factor| multiple(1.0 / factor)).collect();
                times.dedup();
                let verb = if part.noun().1 { "are" } else { "is" };
                format!("{} of {} {verb} {} times too large", part.noun().0, joints_text(joints), times.join(", "))
            }
            Correction::Delay { part, seconds } => {
                let (verb, when) =
                    (if part.noun().1 { "come" } else { "comes" }, if *seconds > 0.0 { "late" } else { "early" });
                format!("{} {verb} {:.4} s {when}", part.noun().0, seconds.abs())
            }
            Correction::Play { joint, play } => format!(
                "the angle of {} is that of its motor, before a gear that has {:.2}° of play",
                joints_text(&[*joint]),
                play.gap.to_degrees()
            ),
        }
    }
}

/// A multiple, with its name if it has one.
fn multiple(factor: f64) -> String {
    let named = NAMED.iter().find(|(known, _)| (factor / known - 1.0).abs() < 0.01);
    let digits = if factor.abs() < 1.0 {
        4
    } else if factor.abs() < 100.0 {
        2
    } else {
        1
    };
    let number = format!("{factor:.digits$}");
    let number =
        if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.').to_owned() } else { number };
    named.map_or(number.clone(), |(_, name)| format!("{number} ({name})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_says_what_is_wrong() {
        for (text, words) in [
            ("zero=down", "the first link points down at q = 0"),
            ("zero=left", "the first link points to the left at q = 0"),
            ("zero=37.5", "the first link stands at 38° from the right at q = 0"),
            ("zero@2=90", "90° lacks to the angle of joint 2"),
            ("sign-torque@1,2", "the torque of joints 1, 2 has the other sign"),
            ("sign@2", "joint 2 turns the other way"),
            ("order-torque=2,1", "the torque of joint 1, 2, … stands in column 2, 1"),
            ("factor-motion@1=0.01", "the motion of joint 1 is 100 times too large"),
            ("factor-rates@1=0.0174532925", "velocity and acceleration of joint 1 are 57.3 (degrees) times too large"),
            ("delay-torque=0.02", "the torque comes 0.0200 s late"),
            ("delay-rates=-0.01", "velocity and acceleration come 0.0100 s early"),
            ("play@2=0.3,0.12,0.04", "the angle of joint 2 is that of its motor, before a gear that has 0.30° of play"),
        ] {
            assert_eq!(text.parse::<Correction>().unwrap().fault(), words);
        }
    }

    #[test]
    fn a_multiple_has_as_many_digits_as_it_needs() {
        let texts = [0.12345, 1.5, 99.994, 100.04, 1234.56].map(multiple);
        assert_eq!(texts, ["0.1235", "1.5", "99.99", "100", "1234.6"]);
    }
}
