//! Blind draws: arm, motion, noise, sensors, effects, strengths and joints come from a seed; the diagnosis sees the recording.

use std::collections::BTreeMap;
use std::time::Instant;

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::foreign::judged_names;
use super::kin::{Place, TO_BE_NAMED};
use super::verdict::Truth;
use super::{Answer, TrialError, answer_of};
use crate::arm::{Arm, GRAVITY, Link, Posture};
use crate::diagnosis::{Report, Suspect, Verdict, diagnose_among, sufficiency};
use crate::effect::{Effect, registry};
use crate::model::{self, Preset};
use crate::progress::Monitor;
use crate::recording::seal::HiddenEffect;
use crate::recording::split::Split;
use crate::simulation::{Excitation, Scenario, simulate};

/// How many effects the draws hide, in turn; the last of them is left out of the candidates.
const TURNS: [usize; 8] = [0, 1, 2, 0, 1, 2, 3, 1];
/// Tries for each effect that is to be hidden: some draws are impossible, such as an end stop out of reach.
const TRIES: usize = 20;

/// How recordings are drawn. Of every eight draws two hide nothing, two hide one effect, two hide two, one hides three, and in one
/// the single hidden effect is left out of the candidates, so that it is unknown.
#[derive(Debug, Clone, Default)]
pub struct Drawing {
    /// Hide always this many effects (0 to 3), all of them known.
    pub hidden: Option<usize>,
    /// Leave the hidden effect out of the candidates in every draw.
    pub unknown: bool,
    /// Hide only these effects; all of the catalogue if empty.
    pub only: Vec<String>,
    /// The embedded arm and kind of motion, exact accelerations and 2 % noise in every draw.
    pub embedded: bool,
}

/// One draw: what is simulated, and who may be named.
pub struct Case {
    /// Its seed.
    pub seed: u64,
    /// The arm, its motion, its sensors, and what is hidden.
    pub scenario: Scenario,
    /// Whom the diagnosis may name.
    pub candidates: Vec<&'static Effect>,
    /// How many effects are hidden.
    pub hidden: usize,
    /// Whether they are not among the candidates.
    pub unknown: bool,
}

/// What the diagnosis said of a case, beside what there is to be said.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Seed of the draw.
    pub seed: u64,
    /// What was simulated.
    pub scenario: Scenario,
    /// How many effects are hidden.
    pub hidden: usize,
    /// Whether they were not among the candidates.
    pub unknown: bool,
    /// What the seal says is hidden.
    pub truth: Vec<HiddenEffect>,
    /// What the diagnosis says is missing.
    pub report: Report,
    /// How clearly the data show the truth, by [`sufficiency`].
    pub sufficiency: f64,
    /// How long the diagnosis took \[s\].
    pub seconds: f64,
    /// Samples of the recording.
    pub samples: usize,
}

impl Drawing {
    /// The case of a seed.
    pub fn case(&self, seed: u64) -> Case {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        // The scenario has streams of its own with the same seed.
        random.set_stream(u64::MAX);
        let mut scenario = Scenario { seed, effects: Vec::new(), ..Scenario::embedded() };
        if !self.embedded {
            vary(&mut scenario, &mut random);
        }
        let turn = (seed % TURNS.len() as u64) as usize;
        let wants_unknown = self.unknown || (self.hidden.is_none() && turn + 1 == TURNS.len());
        let wanted = if wants_unknown { 1 } else { self.hidden.unwrap_or(TURNS[turn]) };
        let pool = self.pool(&scenario, wants_unknown);
        let hidden = hide(&mut scenario, wanted, &pool, &mut random);
        let unknown = wants_unknown && hidden > 0;
        let is_known = |effect: &&'static Effect| {
            let stands_for =
                |hidden: &HiddenEffect| registry::find(&hidden.effect).is_ok_and(|hidden| is_related(effect, hidden));
            !unknown || !scenario.effects.iter().any(stands_for)
        };
        let candidates = registry::sought().into_iter().filter(is_known).collect();
        Case { seed, scenario, candidates, hidden, unknown }
    }

    /// What may be hidden. A fault of the readings is found in them, without any candidate: it can't be unknown.
    fn pool(&self, scenario: &Scenario, unknown: bool) -> Vec<&'static Effect> {
        let all = if unknown { registry::sought() } else { registry::ALL.to_vec() };
        all.into_iter()
            .filter(|effect| self.only.is_empty() || self.only.iter().any(|id| id == effect.id))
            .filter(|effect| scenario.stated || !effect.facts.absorbed_by_body)
            .collect()
    }
}

/// Another arm, motion, noise and sensors.
fn vary(scenario: &mut Scenario, random: &mut ChaCha8Rng) {
    let joints: usize = random.random_range(2..=5);
    let link = |number: usize, random: &mut ChaCha8Rng| {
        let length: f64 = random.random_range(0.2..0.6);
        let mass = random.random_range(1.0..4.0) * 0.7f64.powi(number as i32);
        let inertia = mass * length * length / 12.0 * random.random_range(0.7..1.3);
        Link { mass, length, com: length * random.random_range(0.3..0.6), inertia }
    };
    let posture = *[Posture::UP, Posture::RIGHT, Posture::DOWN].choose(random).unwrap_or(&Posture::UP);
    scenario.arm = Arm { links: (0..joints).map(|number| link(number, random)).collect(), gravity: GRAVITY, posture };
    scenario.torque_noise = 0.005 * 10f64.powf(random.random_range(0.0..1.0));
    scenario.encoder_resolution = random.random_bool(0.35).then_some(1e-4);
    scenario.stated = random.random_bool(0.5);
    scenario.motion = if random.random_bool(0.2) {
        Excitation::PaperPointToPoint { trajectories: 30, duration: 4.0, samples: 400, range: 3.0 }
    } else {
        Excitation::MultiSine {
            trajectories: random.random_range(6..=20),
            duration: random.random_range(5.0..10.0),
            rate: 100.0,
            harmonics: random.random_range(3..=7),
            lowest_frequency: 0.1,
            highest_frequency: random.random_range(0.6..1.5),
            max_position: random.random_range(1.5..2.8),
            max_velocity: random.random_range(2.0..5.0),
        }
    };
}

/// Hides different effects of 3 to 20 % of the torque, each on one joint or two, until there are `count`; none beside one that it
/// is related to. Gives how many there are.
fn hide(scenario: &mut Scenario, count: usize, pool: &[&'static Effect], random: &mut ChaCha8Rng) -> usize {
    let joints = scenario.arm.joint_count();
    let mut hidden: Vec<HiddenEffect> = Vec::new();
    let mut named: Vec<&Effect> = Vec::new();
    for _ in 0..TRIES * count {
        if named.len() == count {
            break;
        }
        let Some(&effect) = pool.choose(random) else { break };
        if named.iter().any(|other| is_related(effect, other)) {
            continue;
        }
        let first = random.random_range(0..joints);
        let places = if random.random_bool(0.3) { vec![first, (first + 1) % joints] } else { vec![first] };
        let strength = 0.03 * (0.2f64 / 0.03).powf(random.random_range(0.0..1.0));
        if let Ok(drawn) = scenario.hide_by_strength(effect.id, &places, strength) {
            hidden.extend(drawn);
            named.push(effect);
        }
    }
    scenario.effects = hidden;
    named.len()
}

/// Whether two effects are the same, one includes the other, or one can stand for the other, alone or in a sum.
fn is_related(one: &Effect, other: &Effect) -> bool {
    let holds = |one: &Effect, other: &Effect| {
        one.contains(other) || one.facts.look_alikes.iter().any(|others| others.effects.contains(&other.id))
    };
    one == other || holds(one, other) || holds(other, one)
}

impl Case {
    /// Simulates the recording, lets the diagnosis say what a rigid body lacks there, and then opens the seal.
    ///
    /// # Errors
    /// [`TrialError`] if one of these can't be done.
    pub fn run(self, monitor: &Monitor) -> Result<Trial, TrialError> {
        let Case { seed, scenario, candidates, hidden, unknown } = self;
        let recording = simulate(&scenario, monitor)?;
        let split = Split::automatic(&recording);
        let body = model::fit(&Preset::RigidBody.model(&recording)?, &recording, &split, monitor)?;
        let begin = Instant::now();
        let report = diagnose_among(&candidates, &body, &recording, &split, monitor)?;
        let seconds = begin.elapsed().as_secs_f64();
        // Only now, after the diagnosis has spoken, is the seal opened.
        let truth = match &recording.seal {
            Some(seal) => seal.open()?.effects,
            None => Vec::new(),
        };
        let suspects: Vec<Suspect> = truth.iter().flat_map(suspects).collect();
        let sufficiency = sufficiency(&body, &recording, &split, &suspects, monitor)?;
        let samples = recording.sample_count();
        Ok(Trial { seed, scenario, hidden, unknown, truth, report, sufficiency, seconds, samples })
    }
}

impl Trial {
    /// All that there is to be named.
    pub fn expected(&self) -> Answer {
        self.truth.iter().flat_map(names_of).collect()
    }

    /// All that was named.
    pub fn given(&self) -> Answer {
        self.report.effects.iter().flat_map(answer_of).collect()
    }

    /// Whether all effects and all their joints were named and nothing else.
    pub fn is_exact(&self) -> bool {
        self.expected() == self.given()
    }

    /// Whether the diagnosis says that there is more than it names.
    pub fn is_flagged(&self) -> bool {
        !self.report.unexplained_joints.is_empty() || self.report.verdict == Verdict::UnknownEffect
    }

    /// Whether the true set, with its true shapes, beats each set that lacks one of its effects or has another one, or two everyday
    /// ones, in its place by what a name needs.
    pub fn suffices(&self) -> bool {
        self.sufficiency >= 1.0
    }

    /// How sure each name is at each of its places, and whether what it says to be there is: a presence speaks of a family on a joint,
    /// so that another form of what is hidden there is right.
    pub fn confidences(&self) -> Vec<(f64, bool)> {
        let truth = self.as_judged();
        let names = self.report.effects.iter().flat_map(|named| judged_names(named, &self.report, &truth));
        names.map(|name| (name.confidence, name.verdict.is_good())).collect()
    }

    /// What is hidden, as a judge of single names takes it. What is no candidate has its kin too.
    fn as_judged(&self) -> Truth {
        let joints = self.scenario.arm.joint_count();
        let planted = |(effect, joint): &(String, Option<usize>)| {
            let place = Place { effect, joint: joint.map(|joint| joint + 1), joints };
            place.planted(TO_BE_NAMED, BTreeMap::new())
        };
        let planted = self.expected().iter().map(planted).collect();
        Truth { kind: String::new(), with_speed: false, planted }
    }
}

/// What a hidden effect is to be named: itself, or the sum of others that no data tell it from.
pub(super) fn names_of(hidden: &HiddenEffect) -> Answer {
    let sum = registry::find(&hidden.effect).ok().and_then(Effect::sum);
    match sum {
        Some(parts) => parts.iter().map(|part| ((*part).to_owned(), hidden.joint)).collect(),
        None => Answer::from([(hidden.effect.clone(), hidden.joint)]),
    }
}

/// What the columns of candidates have to show of a hidden effect. A fault of the readings is none of them: it is found there or not.
fn suspects(hidden: &HiddenEffect) -> Vec<Suspect> {
    let Ok(effect) = registry::find(&hidden.effect) else { return Vec::new() };
    if effect.fault().is_some() {
        return Vec::new();
    }
    let suspect = |(effect, joint): (String, Option<usize>)| {
        // The parts of a sum have no shapes.
        let linear = registry::find(&effect).map_or(0, |effect| effect.linear().count());
        let own = if effect == hidden.effect { hidden.parameters.get(linear..).unwrap_or_default() } else { &[] };
        Suspect { effect, joint, shape: own.to_vec() }
    };
    names_of(hidden).into_iter().map(suspect).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_effect_of_the_catalogue_is_hidden_by_some_draw() {
        let stated = Scenario { stated: true, ..Scenario::embedded() };
        let all: BTreeSet<&str> = registry::ALL.iter().map(|effect| effect.id).collect();
        let pool: BTreeSet<&str> = Drawing::default().pool(&stated, false).iter().map(|effect| effect.id).collect();
        assert_eq!(pool, all);
        // And each of them can be: on the embedded arm one of a few seeds finds a place for it.
        for id in all {
            let drawing = Drawing { hidden: Some(1), only: vec![id.to_owned()], embedded: true, ..Drawing::default() };
            let case = (0..8).map(|seed| drawing.case(seed)).find(|case| case.hidden == 1);
            let case = case.unwrap_or_else(|| panic!("{id} is never hidden"));
            assert!(case.scenario.effects.iter().all(|hidden| hidden.effect == id), "{id}");
        }
    }

    #[test]
    fn turns_hide_none_to_three_and_one_that_is_unknown() {
        let cases: Vec<Case> =
            (8..16).map(|seed| Drawing { embedded: true, ..Drawing::default() }.case(seed)).collect();
        assert_eq!(cases.iter().map(|case| case.hidden).collect::<Vec<_>>(), TURNS);
        let unknown: Vec<bool> = cases.iter().map(|case| case.unknown).collect();
        assert_eq!(unknown, [false, false, false, false, false, false, false, true]);
        let hidden = &cases[7].scenario.effects[0].effect;
        assert!(cases[7].candidates.iter().all(|candidate| candidate.id != hidden));
    }

    #[test]
    fn no_effect_is_hidden_beside_one_that_it_is_related_to() {
        let spec = |id: &str| registry::find(id).unwrap();
        assert!(is_related(spec("asymmetric-friction"), spec("torque-offset")));
        assert!(is_related(spec("torque-offset"), spec("asymmetric-friction")));
        assert!(!is_related(spec("viscous-friction"), spec("torque-offset")));
    }

    #[test]
    fn an_effect_that_is_a_sum_counts_as_its_parts() {
        let hidden = HiddenEffect { effect: "asymmetric-friction".into(), joint: Some(1), parameters: vec![1.0, 2.0] };
        let expected = ["coulomb-friction", "torque-offset"].map(|id| (id.to_owned(), Some(1)));
        assert_eq!(names_of(&hidden), Answer::from(expected));
        assert!(suspects(&hidden).iter().all(|suspect| suspect.shape.is_empty()));
    }

    /// The embedded arm with one effect of this share of the torque on joint 2, and with noise of this share.
    fn case(id: &str, strength: f64, torque_noise: f64) -> Case {
        let mut scenario =
            Scenario { seed: 11, torque_noise, stated: false, effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { trajectories, duration, .. } = &mut scenario.motion {
            (*trajectories, *duration) = (10, 6.0);
        }
        scenario.effects = scenario.hide_by_strength(id, &[1], strength).unwrap();
        Case { seed: 0, scenario, candidates: registry::sought(), hidden: 1, unknown: false }
    }

    fn trial(id: &str, strength: f64, torque_noise: f64) -> Trial {
        case(id, strength, torque_noise).run(&Monitor::new()).unwrap()
    }

    /// A presence speaks of a family on a joint: Coulomb friction says that dry friction is there, but it is not the answer.
    #[test]
    fn a_name_is_as_sure_as_the_presence_of_its_family() {
        let mut case = case("stribeck-friction", 0.1, 0.02);
        case.candidates = vec![registry::find("coulomb-friction").unwrap()];
        let mut trial = case.run(&Monitor::new()).unwrap();
        assert!(!trial.is_exact() && trial.confidences().iter().all(|(_, is_there)| *is_there), "{:?}", trial.given());
        assert_eq!(trial.confidences().len(), 1);
        // On another joint it would be false.
        trial.truth[0].joint = Some(0);
        assert!(!trial.confidences()[0].1);
    }

    /// A clear effect is enough evidence for its name; one that drowns in noise, or is absorbed by the body, is not.
    #[test]
    fn evidence_suffices_for_what_the_data_show() {
        let clear = trial("coulomb-friction", 0.08, 0.02);
        assert!(clear.suffices() && clear.is_exact() && !clear.is_flagged(), "{}", clear.sufficiency);
        assert!(!trial("coulomb-friction", 0.003, 0.1).suffices());
        assert!(!trial("tip-payload", 0.08, 0.02).suffices());
    }

    /// A power of the speed alone is named where Coulomb and viscous friction together, which have as many parameters, explain clearly less;
    /// where they explain the same, the evidence suffices for neither.
    #[test]
    fn two_everyday_effects_for_an_odd_one_are_laid_beside_it() {
        let clear = trial("concave-friction", 0.1, 0.02);
        assert!(clear.suffices() && clear.is_exact(), "{} {:?}", clear.sufficiency, clear.given());
        // It is there, beyond doubt, but noise drowns what tells it from the two.
        let close = trial("concave-friction", 0.03, 0.1);
        assert!(close.sufficiency < 1.0 && !close.is_exact(), "{} {:?}", close.sufficiency, close.given());
        assert!(!close.given().is_empty(), "something rubs there");
    }
}
