//! How likely a family is there once the held-out part was asked.

use nalgebra::{DMatrix, DVector};

use super::presence::calibration::logistic;
use super::report::HeldOut;
use crate::effect::Family;

/// From this presence on the held-out part is not asked: it would hardly change it.
pub const BEYOND_DOUBT: f64 = 0.98;
/// What a presence is once the held-out part was asked, in log-odds: a constant, what those of before count, and what the rise
/// counts that is [`told`]: see RESULTS.md, "What is held out is asked".
const WEIGHTS: [f64; 3] = [-1.104, 1.125, 3.613];
/// Less and more than this says nothing more.
const TELLING: [f64; 2] = [-0.3, 0.5];
/// Price of large weights: hardly any, for three are learned from hundreds of examples.
const RIDGE: f64 = 0.01;

/// What the held-out part says of a family at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heard {
    /// The family.
    pub family: Family,
    /// Its joint, from 0; `None` for the whole arm.
    pub joint: Option<usize>,
    /// How much it is missed.
    pub held_out: HeldOut,
    /// How likely it is there, with that.
    pub presence: f64,
}

impl Heard {
    /// Of a family that was so likely before; `None` if nothing is held out, so that it can't rise.
    pub fn of((family, joint): (Family, Option<usize>), held_out: HeldOut) -> Option<Heard> {
        let presence = presence(&held_out, WEIGHTS);
        (!held_out.rises.is_nan()).then_some(Heard { family, joint, held_out, presence })
    }

    /// At least as likely as before.
    pub fn in_favour(self) -> Heard {
        Heard { presence: self.presence.max(self.held_out.before), ..self }
    }

    /// What was heard of a family at a place.
    pub fn find(heard: &[Heard], family: Family, joint: Option<usize>) -> Option<&Heard> {
        heard.iter().find(|one| (one.family, one.joint) == (family, joint))
    }
}

/// By how many e-folds the squared error rises without it where it is held out, times the root of the number of joints, on which chance
/// has a say each for itself.
fn told(held_out: &HeldOut) -> f64 {
    (held_out.rises.ln() * (held_out.joints as f64).sqrt()).clamp(TELLING[0], TELLING[1])
}

fn clues(held_out: &HeldOut) -> [f64; 3] {
    let before = held_out.before.min(BEYOND_DOUBT);
    [1.0, (before / (1.0 - before)).ln(), told(held_out)]
}

/// How likely it is there with what the held-out part says of it.
fn presence(held_out: &HeldOut, weights: [f64; 3]) -> f64 {
    let log_odds: f64 = clues(held_out).iter().zip(weights).map(|(clue, weight)| clue * weight).sum();
    (1.0 / (1.0 + (-log_odds).exp())).min(BEYOND_DOUBT)
}

/// The weights of a logistic regression over these, of which it is known whether they are there.
pub fn weights(examples: &[(HeldOut, bool)]) -> [f64; 3] {
    let design = DMatrix::from_fn(examples.len(), 3, |row, column| clues(&examples[row].0)[column]);
    let present = DVector::from_fn(examples.len(), |row, _| f64::from(u8::from(examples[row].1)));
    let weights = logistic(&design, &present, RIDGE);
    [weights[0], weights[1], weights[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held_out(before: f64, rises: f64) -> HeldOut {
        HeldOut { before, joints: 1, rises, rises_in_training: 1.5 }
    }

    fn heard(before: f64, rises: f64) -> Option<Heard> {
        Heard::of((Family::Ripple, Some(0)), held_out(before, rises))
    }

    #[test]
    fn what_is_missed_where_it_is_held_out_is_likelier_and_what_is_not_is_less_likely() {
        let presence = |before: f64, rises: f64| heard(before, rises).unwrap().presence;
        assert!(presence(0.8, 2.0) > 0.9 && presence(0.8, 1.0) < 0.8);
        assert!(presence(0.8, 0.9) < presence(0.8, 1.0));
        assert_eq!(presence(0.8, 2.0), presence(0.8, f64::MAX), "more says nothing more");
        assert!(presence(0.979, 9.0) <= BEYOND_DOUBT);
    }

    /// Chance has a say on each joint for itself: what four joints say counts twice.
    #[test]
    fn joints_speak_together() {
        assert_eq!(told(&HeldOut { joints: 4, ..held_out(0.8, 1.1) }), told(&held_out(0.8, 1.1 * 1.1)));
    }

    /// Of each presence and rise as many are there as a law says.
    #[test]
    fn a_known_law_is_learned() {
        let law = [-1.0, 1.2, 3.0];
        let kinds = [0.55, 0.7, 0.85, 0.95]
            .into_iter()
            .flat_map(|before| [0.8, 1.0, 1.2, 1.5].map(|rises| held_out(before, rises)));
        let examples: Vec<(HeldOut, bool)> = kinds
            .flat_map(|held_out| {
                let there = (500.0 * presence(&held_out, law)).round() as usize;
                (0..500).map(move |number| (held_out, number < there))
            })
            .collect();
        for (learned, law) in weights(&examples).iter().zip(law) {
            assert!((learned - law).abs() < 0.15, "{learned} for {law}");
        }
    }

    #[test]
    fn without_a_held_out_part_nothing_is_said() {
        assert_eq!(heard(0.8, f64::NAN), None);
    }
}
