//! From clues to a probability: a logistic map that was learned where the truth is known.
//!
//! The map lies in `assets/presence.json` and is made by `torquescope bench calibrate`, which says on what it was learned and how it
//! does on what it has not seen. What it learns from is not our formulas alone: the worlds of another engine and effects planted into
//! real logs count as well, since a map of simulated noise is mute on real one, and raw evidence is right in half of the cases where
//! it says 90 %.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::{CLUES, Rest, Sighting};
use crate::effect::Family;

/// The map that the program uses.
const LEARNED: &str = include_str!("../../../assets/presence.json");
/// Price of large weights, of clues in units of their spread: what little data say must not decide.
const RIDGE: f64 = 1.0;
/// A family's own weight is half of its intercept, so that it is priced fourfold.
const OWN: f64 = 0.5;
/// Newton steps at most, and the largest change of a weight in one.
const STEPS: usize = 60;
const LONGEST: f64 = 3.0;
/// No probability is nearer to 0 or 1: there is never so much to learn from.
const NEAREST: f64 = 0.01;

/// Presence and completeness from clues.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The command that made it.
    pub command: String,
    /// On how many sightings of how many recordings it was learned.
    pub sightings: usize,
    /// How many recordings these came from.
    pub recordings: usize,
    /// Weight of each clue, by its name, and the constant.
    pub clues: BTreeMap<String, f64>,
    /// The constant.
    pub constant: f64,
    /// What is added for each family.
    pub families: BTreeMap<Family, f64>,
    /// From this share of a joint's torque (RMS) on, what is left or doubtful there means that the answer is not complete.
    pub remainder: f64,
}

/// One sighting of which it is known whether the family was there.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// The family.
    pub family: Family,
    /// The clues, in the order of [`CLUES`].
    pub clues: [f64; CLUES.len()],
    /// Whether it was there.
    pub present: bool,
    /// Which recording it comes from: examples of one recording are learned or tested together.
    pub recording: usize,
}

impl Calibration {
    /// The map that the program uses.
    ///
    /// # Panics
    /// Never: a test reads the file.
    pub fn learned() -> &'static Calibration {
        static READ: OnceLock<Calibration> = OnceLock::new();
        READ.get_or_init(|| {
            serde_json::from_str(LEARNED).unwrap_or_else(|problem| panic!("assets/presence.json: {problem}"))
        })
    }

    /// Probability that the family of a sighting is there. None that is not [possible](Sighting::possible) is.
    pub fn presence(&self, sighting: &Sighting) -> f64 {
        if sighting.possible { self.probability(sighting.family, &sighting.clues) } else { 0.0 }
    }

    /// The same from the clues alone.
    pub fn probability(&self, family: Family, clues: &[f64; CLUES.len()]) -> f64 {
        let weight = |(name, value): (&&str, &f64)| self.clues.get(*name).copied().unwrap_or(0.0) * value;
        let own = self.families.get(&family).copied().unwrap_or(0.0);
        let sum = self.constant + own + CLUES.iter().zip(clues).map(weight).sum::<f64>();
        (1.0 / (1.0 + (-sum).exp())).clamp(NEAREST, 1.0 - NEAREST)
    }

    /// How much of a joint's torque (RMS, as a share) is left beside noise, or rests on families that carry evidence and are yet not
    /// likely.
    ///
    /// Source: √(U² + C²) of a comparison of six measures on 140 arms of another engine, where it told the incomplete from the
    /// complete best.
    pub fn remainder_on<'a>(&self, rest: &Rest, seen: impl IntoIterator<Item = &'a Sighting>, joint: usize) -> f64 {
        let coloured = rest.share[joint].powi(2) * (1.0 - rest.whiteness[joint]);
        coloured.sqrt().hypot(self.doubtful_on(seen, joint))
    }

    /// How much of it rests on such families.
    pub fn doubtful_on<'a>(&self, seen: impl IntoIterator<Item = &'a Sighting>, joint: usize) -> f64 {
        let is_doubtful = |one: &&Sighting| one.acts_on(joint) && one.is_doubtful(self.presence(one));
        seen.into_iter().filter(is_doubtful).map(|one| one.unique * one.unique).sum::<f64>().sqrt()
    }

    /// Whether an answer is complete that leaves this remainder on a joint: it is small, and what is left has no law.
    pub fn is_complete(&self, rest: &Rest, remainder: f64, joint: usize) -> bool {
        remainder <= self.remainder && !rest.has_law(joint)
    }

    /// Learns the weights from examples; the other fields are the caller's.
    pub fn learn(examples: &[&Example]) -> Calibration {
        let count = examples.len();
        let present = DVector::from_fn(count, |row, _| f64::from(u8::from(examples[row].present)));
        let families: Vec<Family> = Family::ALL.to_vec();
        let [means, spreads] = moments(examples);
        let width = 1 + CLUES.len() + families.len();
        let design = DMatrix::from_fn(count, width, |row, column| match column.checked_sub(1) {
            None => 1.0,
            Some(clue) if clue < CLUES.len() => (examples[row].clues[clue] - means[clue]) / spreads[clue],
            Some(own) => OWN * f64::from(u8::from(examples[row].family == families[own - CLUES.len()])),
        });
        let weights = logistic(&design, &present, RIDGE);
        let clues: Vec<f64> = (0..CLUES.len()).map(|clue| weights[1 + clue] / spreads[clue]).collect();
        let shift: f64 = clues.iter().zip(&means).map(|(weight, mean)| weight * mean).sum();
        let recordings: std::collections::BTreeSet<usize> = examples.iter().map(|example| example.recording).collect();
        Calibration {
            command: String::new(),
            sightings: count,
            recordings: recordings.len(),
            constant: weights[0] - shift,
            clues: CLUES.iter().map(|name| (*name).to_owned()).zip(clues).collect(),
            families: families
                .iter()
                .enumerate()
                .map(|(own, &family)| (family, OWN * weights[1 + CLUES.len() + own]))
                .collect(),
            remainder: f64::INFINITY,
        }
    }
}

/// Mean and spread of each clue.
fn moments(examples: &[&Example]) -> [Vec<f64>; 2] {
    let count = examples.len().max(1) as f64;
    let mean = |clue: usize| examples.iter().map(|example| example.clues[clue]).sum::<f64>() / count;
    let means: Vec<f64> = (0..CLUES.len()).map(mean).collect();
    let spread = |clue: usize| {
        let squares = examples.iter().map(|example| (example.clues[clue] - means[clue]).powi(2));
        (squares.sum::<f64>() / count).sqrt().max(1e-9)
    };
    let spreads = (0..CLUES.len()).map(spread).collect();
    [means, spreads]
}

/// Weights of a logistic regression with a price (`ridge`) on all but the first, by Newton's method.
pub(crate) fn logistic(design: &DMatrix<f64>, present: &DVector<f64>, ridge: f64) -> DVector<f64> {
    let width = design.ncols();
    let price = DVector::from_fn(width, |column, _| if column == 0 { 0.0 } else { ridge });
    let mut weights = DVector::<f64>::zeros(width);
    for _ in 0..STEPS {
        let likely = (design * &weights).map(|sum| 1.0 / (1.0 + (-sum.clamp(-30.0, 30.0)).exp()));
        let slope = design.transpose() * (&likely - present) + price.component_mul(&weights);
        let bend = likely.map(|p| p * (1.0 - p) + 1e-9);
        let weighted = DMatrix::from_fn(design.nrows(), width, |row, column| design[(row, column)] * bend[row]);
        let curvature = weighted.transpose() * design + DMatrix::from_diagonal(&price.add_scalar(1e-9));
        let Some(step) = curvature.cholesky().map(|root| root.solve(&slope)) else { break };
        let longest = step.amax();
        weights -= step * (LONGEST / longest.max(1e-12)).min(1.0);
        if longest < 1e-7 {
            break;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_of_the_program_can_be_read_and_knows_every_clue() {
        let map = Calibration::learned();
        assert!(CLUES.iter().all(|name| map.clues.contains_key(*name)), "{:?}", map.clues);
        assert!(map.sightings > 1000 && map.recordings > 100 && map.remainder.is_finite(), "{map:?}");
        assert!(map.command.starts_with("torquescope bench calibrate"), "{}", map.command);
    }

    /// Clues drawn at random, presence by a known law: the law comes back, and what was learned is calibrated.
    #[test]
    fn a_known_law_is_learned() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let law = |family: Family, clues: &[f64; CLUES.len()]| {
            let own = if family == Family::Lag { -1.5 } else { 0.5 };
            1.0 / (1.0 + (-(own + 2.0 * clues[0] - clues[3])).exp())
        };
        let mut examples = Vec::new();
        for recording in 0..4000 {
            let clues = std::array::from_fn(|_| random.random_range(-2.0..2.0));
            let family = if recording % 2 == 0 { Family::Lag } else { Family::Spring };
            let present = random.random_range(0.0..1.0) < law(family, &clues);
            examples.push(Example { family, clues, present, recording });
        }
        let learned = Calibration::learn(&examples.iter().collect::<Vec<_>>());
        let weight = |clue: usize| learned.clues[CLUES[clue]];
        assert!((weight(0) - 2.0).abs() < 0.2 && (weight(3) + 1.0).abs() < 0.15, "{learned:?}");
        assert!((1..CLUES.len()).filter(|&clue| clue != 3).all(|clue| weight(clue).abs() < 0.15), "{learned:?}");
        let wrong = |example: &Example| {
            (learned.probability(example.family, &example.clues) - law(example.family, &example.clues)).abs()
        };
        assert!(examples.iter().map(wrong).sum::<f64>() / 4000.0 < 0.03);
    }

    #[test]
    fn a_small_remainder_is_complete_unless_it_has_a_law() {
        let map = Calibration { remainder: 0.05, ..Calibration::learned().clone() };
        let rest = |share: f64, predicted: f64| Rest {
            share: vec![share],
            before: vec![1.0],
            whiteness: vec![0.75],
            predicted: vec![predicted],
        };
        let noise = rest(0.1, 0.0);
        assert!((map.remainder_on(&noise, std::iter::empty(), 0) - 0.05).abs() < 1e-12, "a quarter of it has a colour");
        assert!(map.is_complete(&noise, 0.04, 0) && !map.is_complete(&noise, 0.06, 0));
        assert!(!map.is_complete(&rest(0.1, 0.6), 0.04, 0), "most of it can be predicted");
        assert!(map.is_complete(&rest(0.01, 0.6), 0.01, 0) && map.is_complete(&rest(0.1, 0.4), 0.04, 0));
    }
}
