//! How likely a family is there once the held-out part was asked.

use nalgebra::{DMatrix, DVector};

use super::presence::calibration::logistic;
use super::report::HeldOut;
use crate::effect::Family;

/// From this presence on the held-out part is not asked: it would hardly change it.
pub const BEYOND_DOUBT: f64 = 0.98;
/// How many clues there are.
const COUNT: usize = 4;
/// What a presence is once the held-out part was asked, in log-odds: a constant, what those of before count, and what t over the held-out
/// pieces and the e-folds of the error in training do: see RESULTS.md, "The ends of runs", "How steadily something is missed" and, how they
/// are learned, "What is held out is asked".
const WEIGHTS: [f64; COUNT] = [-2.08, 0.91, 1.14, 7.6];
/// Beyond this t, to either side, it says little more,
const TELLING_T: f64 = 1.0;
/// this share of what it says below, up to
const LESS_TELLING: f64 = 0.13;
/// this t.
const MOST_TELLING_T: f64 = 3.0;
/// Beyond so many e-folds in training it says less (real effects of logs that leave much reach 0.3 to 1.4, but so does what stands in for
/// something that the catalogue has not),
const TELLING_RISE: f64 = 0.3;
/// this share of what it says below, up to
const LESS_TELLING_RISE: f64 = 0.4;
/// so many.
const MOST_TELLING_RISE: f64 = 0.5;
/// Price of large weights: hardly any, for few are learned from hundreds of examples.
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

/// How likely it was, how steadily it is missed where it is held out, and how much it is missed in training beside all that is named. How
/// much it is missed where it is held out says less: on a long motion that is not like that in training the error may rise many times by
/// what training hardly shows.
fn clues(held_out: &HeldOut) -> [f64; COUNT] {
    let before = held_out.before.min(BEYOND_DOUBT);
    let beyond = held_out.t.clamp(TELLING_T, MOST_TELLING_T) - TELLING_T;
    let steady = held_out.t.clamp(-TELLING_T, TELLING_T) + LESS_TELLING * beyond;
    let rise = held_out.rises_in_training.ln();
    let beyond = rise.clamp(TELLING_RISE, MOST_TELLING_RISE) - TELLING_RISE;
    let in_training = rise.clamp(0.0, TELLING_RISE) + LESS_TELLING_RISE * beyond;
    [1.0, (before / (1.0 - before)).ln(), steady, in_training]
}

/// How likely it is there with what the held-out part says of it.
fn presence(held_out: &HeldOut, weights: [f64; COUNT]) -> f64 {
    let log_odds: f64 = clues(held_out).iter().zip(weights).map(|(clue, weight)| clue * weight).sum();
    (1.0 / (1.0 + (-log_odds).exp())).min(BEYOND_DOUBT)
}

/// The weights of a logistic regression over these, of which it is known whether they are there.
pub fn weights(examples: &[(HeldOut, bool)]) -> [f64; COUNT] {
    let design = DMatrix::from_fn(examples.len(), COUNT, |row, column| clues(&examples[row].0)[column]);
    let present = DVector::from_fn(examples.len(), |row, _| f64::from(u8::from(examples[row].1)));
    let weights = logistic(&design, &present, RIDGE);
    std::array::from_fn(|clue| weights[clue])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held_out(before: f64, rises_in_training: f64, t: f64) -> HeldOut {
        HeldOut { before, rises: rises_in_training, rises_in_training, t }
    }

    fn heard(held_out: HeldOut) -> Option<Heard> {
        Heard::of((Family::Ripple, Some(0)), held_out)
    }

    #[test]
    fn what_is_missed_in_both_parts_is_likelier_and_what_is_not_is_less_likely() {
        let presence = |rises: f64, t: f64| heard(held_out(0.8, rises, t)).unwrap().presence;
        assert!(presence(2.0, 2.0) > 0.9 && presence(1.0, 0.0) < 0.7);
        assert!(presence(1.0, -1.0) < presence(1.0, 0.0) && presence(1.0, 0.0) < presence(1.0, 1.0));
        assert!(presence(1.0, 1.0) < presence(1.5, 1.0));
        let [steep, steeper, steepest] = [1.2, 1.34, 1.6].map(|rises| presence(rises, 1.0));
        assert!(steep < steeper && steeper < steepest && steepest - steeper < steeper - steep);
        let [little, more] = [1.0, 3.0].map(|t| presence(1.0, t) - presence(1.0, t - 1.0));
        assert!(0.0 < more && more < little, "{little} {more}");
        assert_eq!(presence(3.0, 3.0), presence(f64::MAX, 9.0), "more says nothing more");
        assert!(heard(held_out(0.979, 9.0, 9.0)).unwrap().presence <= BEYOND_DOUBT);
    }

    /// Of each kind as many are there as a law says.
    #[test]
    fn a_known_law_is_learned() {
        let law = [-1.0, 1.2, 0.6, 2.0];
        let kinds = [0.55, 0.7, 0.85, 0.95]
            .into_iter()
            .flat_map(|before| [1.0, 1.2, 2.0].map(|rises| (before, rises)))
            .flat_map(|(before, rises)| [-1.0, 0.5, 1.9].map(|t| held_out(before, rises, t)));
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
        assert_eq!(heard(HeldOut { rises: f64::NAN, ..held_out(0.8, 1.5, 1.0) }), None);
    }
}
