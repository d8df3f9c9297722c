//! What presence is learned from: sightings of families in recordings whose truth is known, each labelled by that truth.
//!
//! A family counts as there if a planted effect of it acts at its place, however weak. It counts neither way where the truth takes
//! its name for another form of something, or says that it goes with something.

use rayon::prelude::*;
use serde::Serialize;

use super::TrialError;
use super::blind::Drawing;
use super::kin::TO_BE_NAMED;
use super::planted::Log;
use super::rates::{Reliability, calibration_error, reliability};
use super::verdict::{Truth, Verdict};
use super::world::{WorldTrial, truth_of};
use crate::diagnosis::presence::SURE;
use crate::diagnosis::presence::calibration::{Calibration, Example};
use crate::diagnosis::{Rest, Sighting, sightings};
use crate::effect::{Effect, registry};
use crate::model::{self, ModelError, Preset};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;
use crate::simulation::simulate;

/// The strongest effect in a twin, as a share of the torque.
const STRONGEST: f64 = 0.2;
/// Of complete answers so many may be said to be incomplete by their remainder; those whose remainder has a law come on top.
const FALSE_FLAGS: f64 = 0.06;

/// A recording with what the data say of every family, and whether it is there.
#[derive(Debug, Clone, Serialize)]
pub struct Labelled {
    /// What it is called: its seed, or its file.
    pub name: String,
    /// Who made it.
    pub source: Source,
    /// Whether everything in it is in the catalogue.
    pub known: bool,
    /// What was seen, with its label; `None` counts neither way.
    pub sightings: Vec<(Sighting, Option<bool>)>,
    /// What is left.
    pub rest: Rest,
}

/// Who made a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Our own formulas.
    Formulas,
    /// The world of rigid bodies.
    World,
    /// A real log with planted effects.
    Planted,
}

/// How a map does on recordings that it has not learned from.
#[derive(Debug, Clone, Serialize)]
pub struct Quality {
    /// Which recordings; `None` is all.
    pub source: Option<Source>,
    /// How many sightings were tested.
    pub sightings: usize,
    /// How many of them were there.
    pub present: usize,
    /// Probability that one that is there has a higher presence than one that is not.
    pub auc: f64,
    /// Mean distance between presence and the share that is there, over ten classes.
    pub calibration_error: Option<f64>,
    /// Sightings of at least 90 %, and how many of them are there.
    pub sure: [usize; 2],
    /// Those of at least 3 % of the torque that are there, and how many of them have at least 90 % and 50 %.
    pub strong: [usize; 3],
    /// The classes.
    pub reliability: Vec<Reliability>,
    /// Recordings that are complete, and how many of them are flagged.
    pub complete: [usize; 2],
    /// Recordings with something outside the catalogue, and how many of them are flagged.
    pub incomplete: [usize; 2],
}

impl Labelled {
    /// What the data say of a recording whose truth is known.
    ///
    /// # Errors
    /// [`TrialError`] if a rigid body does not fit it, or it was stopped.
    pub fn of(
        source: Source,
        name: String,
        recording: &Recording,
        split: &Split,
        truth: &Truth,
        monitor: &Monitor,
    ) -> Result<Self, TrialError> {
        let body = model::fit(&Preset::RigidBody.model(recording)?, recording, split, &Monitor::new())?;
        monitor.check()?;
        let (seen, rest) = sightings(&body, recording, split, &Monitor::new())?;
        let sightings = seen
            .into_iter()
            .map(|sighting| {
                let label = label(truth, &sighting);
                (sighting, label)
            })
            .collect();
        let known = !truth.planted.iter().any(|planted| planted.unknown);
        Ok(Labelled { name, source, known, sightings, rest })
    }

    /// A blind draw of our own formulas.
    ///
    /// # Errors
    /// As [`Labelled::of`].
    pub fn of_draw(seed: u64, monitor: &Monitor) -> Result<Self, TrialError> {
        let case = Drawing::default().case(seed);
        let recording = simulate(&case.scenario, &Monitor::new())?;
        let (split, truth) = (Split::automatic(&recording), truth_of(&recording, "formulas", true)?);
        Labelled::of(Source::Formulas, seed.to_string(), &recording, &split, &truth, monitor)
    }

    /// A world.
    ///
    /// # Errors
    /// As [`Labelled::of`].
    pub fn of_world(seed: u64, monitor: &Monitor) -> Result<Self, TrialError> {
        let (recording, truth) = WorldTrial::draw(seed, None)?.simulated()?;
        Labelled::of(Source::World, seed.to_string(), &recording, &Split::automatic(&recording), &truth, monitor)
    }

    /// A twin of a real log.
    ///
    /// # Errors
    /// As [`Labelled::of`], and if nothing can be planted into the log.
    pub fn of_twin(log: &Log, seed: u64, monitor: &Monitor) -> Result<Self, TrialError> {
        let case = log.twin(seed, STRONGEST, &Monitor::new())?;
        Labelled::of(Source::Planted, case.name.clone(), &case.recording, &case.split, &case.truth, monitor)
    }

    /// What is left or doubtful of each joint, as a share of its torque.
    fn remainders(&self, map: &Calibration) -> impl Iterator<Item = f64> {
        let of_joint = |joint| map.remainder_on(&self.rest, self.sightings.iter().map(|(sighting, _)| sighting), joint);
        (0..self.rest.share.len()).map(of_joint)
    }

    /// Whether the answer is said not to be complete on some joint.
    fn is_flagged(&self, map: &Calibration) -> bool {
        let mut remainders = self.remainders(map).enumerate();
        remainders.any(|(joint, remainder)| !map.is_complete(&self.rest, remainder, joint))
    }
}

/// Whether a sighting is there.
fn label(truth: &Truth, sighting: &Sighting) -> Option<bool> {
    let joint = sighting.joint.map(|joint| joint + 1);
    let is_member = |effect: &Effect| effect.family == sighting.family;
    let here = truth.planted.iter().filter(|planted| !planted.unknown && planted.joint == joint);
    let mut own = here.filter(|planted| registry::find(&planted.effect).is_ok_and(is_member)).peekable();
    if own.peek().is_some() {
        return own.any(|planted| !planted.absorbed && !planted.assumed).then_some(true);
    }
    let members = registry::ALL.iter().filter(|effect| is_member(effect));
    let best = members.map(|effect| truth.judge(effect.id, joint)).max()?;
    (best < Verdict::Beside).then_some(false)
}

/// Labels many recordings, as many at a time as there are cores. One in which a planted fault of the readings left too few samples to
/// fit a rigid body is passed over.
///
/// # Errors
/// [`TrialError`] of the first that fails otherwise.
pub fn label_all<T: Send + Sync>(
    cases: &[T],
    monitor: &Monitor,
    labelled: impl Fn(&T) -> Result<Labelled, TrialError> + Sync,
) -> Result<Vec<Labelled>, TrialError> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let one = |case: &T| {
        monitor.check()?;
        let labelled = match labelled(case) {
            Ok(labelled) => Some(labelled),
            Err(TrialError::Model(ModelError::TooFewSamples { .. })) => None,
            Err(error) => return Err(error),
        };
        let count = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        monitor.report(count as f32 / cases.len() as f32, "diagnosing recordings whose truth is known")?;
        Ok(labelled)
    };
    let labelled = cases.par_iter().map(one).collect::<Result<Vec<_>, TrialError>>()?;
    Ok(labelled.into_iter().flatten().collect())
}

/// Learns a map from all of these, with the share of a joint's torque from which on an answer is not complete.
pub fn learn(labelled: &[&Labelled]) -> Calibration {
    let examples = examples(labelled);
    let mut map = Calibration::learn(&examples.iter().collect::<Vec<_>>());
    // What a real log leaves is in its twins too, so they are not complete.
    let complete = labelled.iter().filter(|one| one.known && one.source != Source::Planted);
    let mut left: Vec<f64> = complete.map(|one| one.remainders(&map).fold(0.0, f64::max)).collect();
    left.sort_by(f64::total_cmp);
    let place = ((1.0 - FALSE_FLAGS) * left.len() as f64) as usize;
    map.remainder = left.get(place).or(left.last()).copied().unwrap_or(f64::INFINITY);
    map
}

/// How maps do that were learned on nine tenths of the recordings, on the tenth that each has not seen.
pub fn cross_validate(labelled: &[Labelled]) -> Vec<Quality> {
    const FOLDS: usize = 10;
    let maps: Vec<Calibration> = (0..FOLDS)
        .into_par_iter()
        .map(|fold| {
            let others = labelled.iter().enumerate().filter(|(number, _)| number % FOLDS != fold);
            learn(&others.map(|(_, one)| one).collect::<Vec<_>>())
        })
        .collect();
    let tested = |source: Option<Source>| -> Quality {
        let cases = labelled.iter().enumerate().filter(|(_, one)| source.is_none_or(|source| one.source == source));
        let cases: Vec<(&Labelled, &Calibration)> = cases.map(|(number, one)| (one, &maps[number % FOLDS])).collect();
        Quality::of(source, &cases)
    };
    let mut sources: Vec<Source> = labelled.iter().map(|one| one.source).collect();
    sources.sort_unstable();
    sources.dedup();
    sources.into_iter().map(Some).chain([None]).map(tested).collect()
}

impl Quality {
    /// Of recordings, each with the map that judges it.
    fn of(source: Option<Source>, cases: &[(&Labelled, &Calibration)]) -> Quality {
        let judged: Vec<(f64, bool, f64)> = cases
            .iter()
            .flat_map(|(one, map)| {
                one.sightings
                    .iter()
                    .filter_map(|(sighting, label)| Some((map.presence(sighting), (*label)?, sighting.share)))
            })
            .collect();
        let pairs: Vec<(f64, bool)> = judged.iter().map(|(presence, is_there, _)| (*presence, *is_there)).collect();
        let reliability = reliability(&pairs);
        let at_least = |least: f64| judged.iter().filter(move |(presence, ..)| *presence >= least);
        let is_strong = |(_, is_there, share): &&(f64, bool, f64)| *is_there && *share >= TO_BE_NAMED;
        let flags = |known: bool| {
            let of_kind = cases.iter().filter(|(one, _)| one.known == known);
            [of_kind.clone().count(), of_kind.filter(|(one, map)| one.is_flagged(map)).count()]
        };
        Quality {
            source,
            sightings: pairs.len(),
            present: pairs.iter().filter(|(_, is_there)| *is_there).count(),
            auc: auc(&pairs),
            calibration_error: calibration_error(&reliability),
            sure: [at_least(SURE).count(), at_least(SURE).filter(|(_, is_there, _)| *is_there).count()],
            strong: [
                judged.iter().filter(is_strong).count(),
                at_least(SURE).filter(is_strong).count(),
                at_least(0.5).filter(is_strong).count(),
            ],
            reliability,
            complete: flags(true),
            incomplete: flags(false),
        }
    }
}

/// Probability that one that is there has a higher presence than one that is not; ties count half.
fn auc(pairs: &[(f64, bool)]) -> f64 {
    let mut sorted = pairs.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut below, mut wins) = (0.0, 0.0);
    for tied in sorted.chunk_by(|a, b| a.0 == b.0) {
        let there = tied.iter().filter(|(_, is_there)| *is_there).count() as f64;
        let not = tied.len() as f64 - there;
        wins += there * (below + 0.5 * not);
        below += not;
    }
    let there = pairs.iter().filter(|(_, is_there)| *is_there).count() as f64;
    wins / (there * below)
}

fn examples(labelled: &[&Labelled]) -> Vec<Example> {
    let of_one = |(recording, one): (usize, &&Labelled)| {
        let example = |(sighting, label): &(Sighting, Option<bool>)| {
            let present = (*label)?;
            sighting.possible.then_some(Example { family: sighting.family, clues: sighting.clues, present, recording })
        };
        one.sightings.iter().filter_map(example).collect::<Vec<_>>()
    };
    labelled.iter().enumerate().flat_map(of_one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_under_the_curve_counts_pairs() {
        assert_eq!(auc(&[(0.1, false), (0.2, false), (0.8, true), (0.9, true)]), 1.0);
        assert_eq!(auc(&[(0.1, true), (0.2, false), (0.8, true), (0.9, false)]), 0.25);
        assert_eq!(auc(&[(0.5, true), (0.5, false)]), 0.5);
    }

    /// A draw with Coulomb friction: its family is there, no other dry form beside it counts, all else is not.
    #[test]
    fn sightings_are_labelled_by_the_truth() {
        let seed = (1..).find(|&seed| {
            let case = Drawing::default().case(seed);
            case.hidden == 1 && case.scenario.effects[0].effect == "coulomb-friction"
        });
        let labelled = Labelled::of_draw(seed.unwrap(), &Monitor::new()).unwrap();
        let there: Vec<&Sighting> =
            labelled.sightings.iter().filter(|(_, label)| *label == Some(true)).map(|(sighting, _)| sighting).collect();
        assert!(
            !there.is_empty() && there.iter().all(|one| one.family == crate::effect::Family::DryFriction && one.found)
        );
        assert!(labelled.sightings.iter().filter(|(_, label)| *label == Some(false)).count() > 10);
        assert!(there.iter().all(|one| one.clues.iter().all(|clue| clue.is_finite())));
    }
}
