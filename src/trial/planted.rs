//! Effects planted into a user's own recording, so that anyone can ask how far to trust the diagnosis on *their* robot.
//!
//! A [`Log`] is diagnosed once as it is. Two kinds of [`Case`] are drawn from it, each by a seed:
//!
//! - [`Log::planted`]: one effect of the catalogue acts on the measured torque (or misreads what was measured), at a stated share of
//!   it, with parameters off the grids of the search. What else is in the log nobody knows: what was named before may be named
//!   again and counts neither way.
//! - [`Log::twin`]: the rigid body and the effects that were named, as they were fitted, are the truth; the noise is what they leave
//!   of the log, moved in time and perhaps turned over, so that it has the colour of this robot's residual but belongs to no
//!   effect. Into that, too, effects are planted.
//!
//! A strength is that within the band in which a diagnosis compares. An effect that a rigid body takes up in training, together with the
//! friction and the offsets that nearly every joint has, or that hardly acts there, is not planted: nobody could find it. A [`Summary`]
//! says how cases fared.

mod score;
mod shown;

use std::collections::BTreeMap;

use rand::seq::{IndexedRandom, IteratorRandom};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

pub use score::{Before, Detection, Fared, Group, Summary, Tried};
use shown::Shown;

use super::foreign::{Name, lacking};
use super::kin::{self, Place};
use super::verdict::{Planted, Truth, Verdict};
use super::{TrialError, answer_of};
use crate::diagnosis::{self, Report};
use crate::effect::{Effect, Family, Load, Motion, registry};
use crate::model::terms::Setting;
use crate::model::{self, EffectTerm, Evaluation, Fitted, Model, Prediction, Preset, Term};
use crate::progress::Monitor;
use crate::recording::split::{Split, unusable};
use crate::recording::{Origin, Recording, Trajectory};
use crate::signals::Signals;
use crate::simulation::{SimulationError, Strength};

/// The strengths that are planted where none are asked for, as shares of the torque.
pub const STRENGTHS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// The class of cases of the log itself, and of its twins.
const PLANTED: &str = "planted";
const TWIN: &str = "twin";
/// Effects that are drawn before a log is given up as one that nothing can be planted into.
const TRIES: usize = 40;
/// What every robot has takes up of an effect that can be found all but at least this share of it.
const LEAST_LEFT: f64 = 0.5;
/// Most effects that are planted into a twin.
const MOST_IN_TWIN: usize = 3;
/// The noise of a twin is moved by at least this share of its run, so that it belongs to another motion.
const LEAST_SHIFT: f64 = 0.1;

/// A user's recording, with what the diagnosis says of it as it is.
pub struct Log {
    recording: Recording,
    split: Split,
    before: Report,
    setting: Setting,
    /// What the rigid body needs, by run.
    loads: Vec<Option<Load>>,
    shown: Shown,
    known: Known,
}

/// What is known of a log where the diagnosis is believed: the truth of its twins.
struct Known {
    planted: Vec<Planted>,
    /// Torque of the body and all effects, by run.
    torque: Vec<Signals>,
    /// What they leave, by run.
    residual: Vec<Signals>,
}

/// An effect that was planted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planting {
    /// Its id.
    pub effect: String,
    /// The joint, from 1; none for the whole arm.
    pub joint: Option<usize>,
    /// RMS of its torque over that of the torque of the joints that feel it.
    pub strength: f64,
    /// Its parameters by name, in SI units.
    pub parameters: BTreeMap<String, f64>,
}

/// A recording into which effects were planted, and what there is to be said of it.
pub struct Case {
    /// What it is, in a word or two.
    pub name: String,
    /// What the diagnosis sees.
    pub recording: Recording,
    /// Which part trains and which is held out.
    pub split: Split,
    /// What is in it. What was named in the log before is [`Planted::assumed`].
    pub truth: Truth,
    /// What was planted.
    pub plantings: Vec<Planting>,
    /// What the diagnosis said of the log before; `None` for a twin, which has no before.
    before: Option<Report>,
}

/// An effect with its place (joint from 0) and parameters.
struct Drawn {
    effect: &'static Effect,
    place: Option<usize>,
    strength: f64,
    parameters: Vec<f64>,
}

impl Drawn {
    /// 0 for an effect of the whole arm, which ignores it.
    fn joint(&self) -> usize {
        self.place.unwrap_or(0)
    }

    fn planting(&self) -> Planting {
        Planting {
            effect: self.effect.id.to_owned(),
            joint: self.place.map(|joint| joint + 1),
            strength: self.strength,
            parameters: kin::parameters(self.effect.id, &self.parameters),
        }
    }
}

/// Which kind of case a seed is drawn for; each has a stream of its own.
#[derive(Clone, Copy)]
enum Kind {
    Planted,
    Twin,
}

impl Kind {
    fn random(self, seed: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(self as u64);
        random
    }
}

impl Log {
    /// Diagnoses a recording as it is, beside a rigid body.
    ///
    /// # Errors
    /// [`TrialError`] if no rigid body fits it or the diagnosis fails.
    pub fn new(recording: Recording, split: Split, monitor: &Monitor) -> Result<Log, TrialError> {
        // The truth of a simulated recording is none of a log.
        let recording = Recording { seal: None, ..recording };
        let model = Preset::RigidBody.model(&recording)?;
        let body = model::fit(&model, &recording, &split, &monitor.part(0.0..0.1))?;
        let shown = Shown::of(&recording, &split)?;
        let before = diagnosis::diagnose(&body, &recording, &split, &monitor.part(0.1..0.9))?;
        let known = Known::of(&model, &before, &recording, &split, &monitor.part(0.9..1.0))?;
        let setting = body.setting().clone();
        let loads = recording.trajectories.iter().map(|trajectory| setting.load(trajectory)).collect();
        Ok(Log { recording, split, before, setting, loads, shown, known })
    }

    /// What is named in it before anything is planted.
    pub fn before(&self) -> Vec<Name> {
        named(&self.before)
    }

    /// The log with one effect planted at a share of the torque; effect, joint and parameters are drawn by the seed.
    ///
    /// # Errors
    /// [`TrialError::NotPlantable`] if nothing can be planted, and if a fit fails or somebody stopped it.
    pub fn planted(&self, seed: u64, strength: f64, monitor: &Monitor) -> Result<Case, TrialError> {
        let drawn = self.draw(strength, &mut Kind::Planted.random(seed), |_, _| true, monitor)?;
        let mut truth = self.truth(PLANTED, self.assumed());
        let mut planted = self.in_words(&drawn);
        let is_it = |name: &Name| planted.judge(&name.effect, name.joint) >= Verdict::Form;
        if self.before().iter().any(is_it) {
            // What was planted then adds to what is there, and nobody knows how much that is.
            planted.parameters.clear();
        }
        // It has to be found however weak it is: that is what is asked.
        truth.planted.push(Planted { strong: true, ..planted });
        let (name, before) = (format!("planted {seed}"), Some(self.before.clone()));
        self.case(name, self.recording.clone(), &[drawn], truth, before)
    }

    /// A twin of the log with up to three effects planted at up to this share of the torque, down to a twentieth of it. None is planted
    /// where the truth has it, or a form of it, already; and no fault of the readings, which the readings show by themselves while
    /// it takes the others with it.
    ///
    /// # Errors
    /// As [`Log::planted`].
    pub fn twin(&self, seed: u64, strongest: f64, monitor: &Monitor) -> Result<Case, TrialError> {
        let mut random = Kind::Twin.random(seed);
        let mut recording = self.recording.clone();
        for (run, trajectory) in recording.trajectories.iter_mut().enumerate() {
            let mut torque = self.known.torque[run].clone();
            let turned = if random.random_bool(0.5) { -1.0 } else { 1.0 };
            torque.add(&moved(&self.known.residual[run], random.random_range(LEAST_SHIFT..=1.0 - LEAST_SHIFT)), turned);
            trajectory.set_torque(torque).map_err(SimulationError::from)?;
        }
        let mut truth = self.truth(TWIN, self.known.planted.clone());
        let mut plantings: Vec<Drawn> = Vec::new();
        for _ in 0..random.random_range(0..=MOST_IN_TWIN) {
            let strength = strongest * 0.05f64.powf(random.random_range(0.0..=1.0));
            let is_new = |effect: &Effect, planted: &Planted| {
                let there = || truth.planted.iter();
                effect.fault().is_none()
                    && there().all(|other| other.judge(&planted.effect, planted.joint) < Verdict::Beside)
                    && there().all(|other| planted.judge(&other.effect, other.joint) < Verdict::Beside)
            };
            let drawn = match self.draw(strength, &mut random, is_new, monitor) {
                // There is no room for more.
                Err(TrialError::NotPlantable { .. }) => break,
                drawn => drawn?,
            };
            truth.planted.push(self.in_words(&drawn));
            plantings.push(drawn);
        }
        // One after the other along the chain.
        plantings.sort_by_key(|drawn| drawn.effect.stage.number());
        self.case(format!("twin {seed}"), recording, &plantings, truth, None)
    }

    fn case(
        &self,
        name: String,
        mut recording: Recording,
        plantings: &[Drawn],
        truth: Truth,
        before: Option<Report>,
    ) -> Result<Case, TrialError> {
        plantings.iter().try_for_each(|drawn| self.plant(drawn, &mut recording))?;
        let split = self.split.clone().clear_of(&recording, &unusable(&recording));
        Ok(Case { name, recording, split, truth, plantings: plantings.iter().map(Drawn::planting).collect(), before })
    }

    fn truth(&self, kind: &str, planted: Vec<Planted>) -> Truth {
        let with_speed = self.recording.provenance.velocity == Origin::Measured;
        Truth { kind: kind.to_owned(), with_speed, planted }
    }

    /// What was named before, which may be there or not.
    fn assumed(&self) -> Vec<Planted> {
        assumed(&self.before(), self.recording.joint_count())
    }

    /// What was planted in the words of the judge.
    fn in_words(&self, drawn: &Drawn) -> Planted {
        let Planting { effect, joint, strength, parameters } = drawn.planting();
        Place { effect: &effect, joint, joints: self.recording.joint_count() }.planted(strength, parameters)
    }

    /// An effect that is `welcome`, makes torque here, and is not taken up by what every robot has. Families take part alike, however
    /// many forms they have.
    fn draw(
        &self,
        strength: f64,
        random: &mut ChaCha8Rng,
        welcome: impl Fn(&Effect, &Planted) -> bool,
        monitor: &Monitor,
    ) -> Result<Drawn, TrialError> {
        let heard = |(run, trajectory): (usize, &Trajectory)| {
            trajectory.clone().with_torque(self.shown.heard(run, &trajectory.tau)).map_err(SimulationError::from)
        };
        let runs: Vec<Trajectory> =
            self.recording.trajectories.iter().enumerate().map(heard).collect::<Result<_, _>>()?;
        for _ in 0..TRIES {
            monitor.check()?;
            let Some(&family) = Family::ALL.choose(random) else { break };
            let members = registry::ALL.iter().copied().filter(|effect| effect.family == family);
            let Some(effect) = members.choose(random) else { continue };
            if effect.lack_in(&self.recording).is_some() {
                continue;
            }
            let joint = random.random_range(0..self.recording.joint_count());
            let Some(&place) = effect.places([joint]).first() else { continue };
            let mut drawn = Drawn { effect, place, strength, parameters: Vec::new() };
            if !welcome(effect, &self.in_words(&drawn)) {
                continue;
            }
            let wanted = Strength { effect, joint: place, share: strength, runs: &runs };
            let Ok(parameters) = wanted.draw(random, |parameters| self.change(effect, place, parameters)) else {
                continue;
            };
            drawn.parameters = parameters;
            if self.left_of(&drawn)? >= LEAST_LEFT {
                return Ok(drawn);
            }
        }
        Err(TrialError::NotPlantable { log: self.recording.name.clone(), tries: TRIES, percent: 100.0 * strength })
    }

    /// What an effect with these parameters makes of the torque of each run, by its formula and within the band.
    fn change(
        &self,
        effect: &Effect,
        place: Option<usize>,
        parameters: &[f64],
    ) -> Result<Vec<Signals>, SimulationError> {
        let joint = place.unwrap_or(0);
        let of_run = |(run, trajectory): (usize, &Trajectory)| {
            if effect.fault().is_none() {
                return Ok(self.shown.heard(run, &effect.torque(&self.motion(run), joint, parameters)?));
            }
            let mut read = trajectory.clone();
            effect.misread(&mut read, joint, parameters);
            let mut error = read.tau.clone();
            error.add(&trajectory.tau, -1.0);
            Ok(self.shown.heard(run, &error))
        };
        self.recording.trajectories.iter().enumerate().map(of_run).collect()
    }

    fn motion(&self, run: usize) -> Motion<'_> {
        Motion { load: self.loads[run].as_ref(), ..self.setting.motion(&self.recording.trajectories[run]) }
    }

    /// Lets an effect act on the torque of a recording of this motion, and on what is read.
    fn plant(&self, drawn: &Drawn, recording: &mut Recording) -> Result<(), TrialError> {
        for (run, trajectory) in recording.trajectories.iter_mut().enumerate() {
            let mut torque = trajectory.tau.clone();
            let acted = drawn.effect.act(&self.motion(run), drawn.joint(), &drawn.parameters, &mut torque);
            acted.map_err(SimulationError::from)?;
            trajectory.set_torque(torque).map_err(SimulationError::from)?;
            drawn.effect.misread(trajectory, drawn.joint(), &drawn.parameters);
        }
        Ok(())
    }

    /// The share of an effect that what every robot has leaves of it.
    fn left_of(&self, drawn: &Drawn) -> Result<f64, TrialError> {
        let mut recording = self.recording.clone();
        self.plant(drawn, &mut recording)?;
        let split = self.split.clone().clear_of(&recording, &unusable(&recording));
        let change = self.change(drawn.effect, drawn.place, &drawn.parameters)?;
        self.shown.left_of(drawn.effect, &change, &recording, &split)
    }
}

impl Known {
    fn of(
        body: &Model,
        report: &Report,
        recording: &Recording,
        split: &Split,
        monitor: &Monitor,
    ) -> Result<Known, TrialError> {
        let fitted = believed(body, report, recording, split, monitor)?;
        let evaluation = Evaluation::of(&fitted, recording, split)?;
        let torque = |term: usize| {
            let of_run = |run: &Prediction| run.terms[term].clone();
            evaluation.predictions.iter().map(of_run).collect::<Vec<Signals>>()
        };
        let joints = recording.joint_count();
        let planted = |(number, term): (usize, &Term)| {
            let Term::Effect(EffectTerm { effect, joint }) = term else { return None };
            let place = Place { effect: effect.id, joint: joint.map(|joint| joint + 1), joints };
            let own = fitted.parameters_of(number).map(|parameter| (parameter.name.clone(), parameter.value));
            Some(place.planted(share(&torque(number), recording), own.collect()))
        };
        Ok(Known {
            planted: fitted.model.terms.iter().enumerate().filter_map(planted).collect(),
            residual: (0..recording.trajectories.len()).map(|run| evaluation.residual(recording, run)).collect(),
            torque: evaluation.predictions.into_iter().map(|prediction| prediction.total).collect(),
        })
    }
}

/// The rigid body with all effects of the report that a model can have and the data can show. What comes out impossible is left out,
/// one term after the other.
fn believed(
    body: &Model,
    report: &Report,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Fitted, TrialError> {
    let addable = report.effects.iter().filter(|named| named.effect.check_addable().is_ok());
    let mut model = body.clone();
    for named in addable {
        model = model.with_effect(named.effect, &named.joints)?;
    }
    loop {
        let fitted = model::fit(&model, recording, split, monitor)?;
        let is_effect = |term: &usize| matches!(model.terms[*term], Term::Effect(_));
        let impossible = fitted.parameters.iter().filter(|parameter| !parameter.identified || !parameter.physical);
        match impossible.map(|parameter| parameter.term).find(is_effect) {
            Some(term) => drop(model.terms.remove(term)),
            None => return Ok(fitted),
        }
    }
}

/// What a report names, with its places.
pub(super) fn named(report: &Report) -> Vec<Name> {
    let at_places = |named: &diagnosis::MissingEffect| {
        let name = |(effect, place): (String, Option<usize>)| {
            let joint = place.map(|joint| joint + 1);
            let confidence = report.presence_of(named, place);
            Name { effect, joint, confidence, form: named.form, verdict: Verdict::Right }
        };
        answer_of(named).into_iter().map(name).collect::<Vec<Name>>()
    };
    report.effects.iter().flat_map(at_places).collect()
}

/// Names in the words of the judge, as what may be there or not.
pub(super) fn assumed(names: &[Name], joints: usize) -> Vec<Planted> {
    let assumed = |name: &Name| {
        let place = Place { effect: &name.effect, joint: name.joint, joints };
        Planted { assumed: true, ..place.planted(0.0, BTreeMap::new()) }
    };
    names.iter().map(assumed).collect()
}

/// RMS of a torque over that of the torque of the joints that feel it.
fn share(torque: &[Signals], recording: &Recording) -> f64 {
    let (mut own, mut all) = (0.0, 0.0);
    for joint in 0..recording.joint_count() {
        let of_joint: f64 = torque.iter().flat_map(|run| &run[joint]).map(|value| value * value).sum();
        if of_joint > 0.0 {
            own += of_joint;
            let measured = recording.trajectories.iter().flat_map(|run| &run.tau[joint]);
            all += measured.map(|value| value * value).sum::<f64>();
        }
    }
    if all > 0.0 { (own / all).sqrt() } else { 0.0 }
}

/// Signals moved by a share of their length; what leaves at the end comes in at the start.
fn moved(signals: &Signals, share: f64) -> Signals {
    let by = (share * signals.sample_count() as f64).round() as usize;
    signals.map_joints(|samples| {
        let mut moved = samples.to_vec();
        moved.rotate_right(by.min(samples.len()));
        moved
    })
}

impl Case {
    /// Asks what a rigid body lacks in it, and judges the answer.
    ///
    /// # Errors
    /// [`TrialError`] if it can't be fitted or diagnosed, or somebody stopped it.
    pub fn run(&self, monitor: &Monitor) -> Result<Tried, TrialError> {
        let (report, seconds) = lacking(&self.recording, &self.split, monitor)?;
        Ok(Tried::new(self, &report, seconds))
    }
}

/// How many cases are drawn from a log, and how strong what is planted there is.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How many effects are planted into the log, one at a time; the strengths take turns.
    pub draws: u64,
    /// How many twins are made.
    pub twins: u64,
    /// First seed: each case has the next one, so that plans whose seeds are closer than their draws share most of them.
    pub seed: u64,
    /// Strengths as shares of the torque, above 0; [`STRENGTHS`] if there are none.
    pub strengths: Vec<f64>,
}

impl Plan {
    /// Diagnoses a recording as it is, then draws all cases and tries them.
    ///
    /// # Errors
    /// [`TrialError`] as [`Log::new`] and [`Plan::run`].
    pub fn of_recording(&self, recording: &Recording, split: &Split, monitor: &Monitor) -> Result<Summary, TrialError> {
        // The recording as it is is one case more.
        let begin = 1.0 / (self.draws + self.twins + 1) as f32;
        let log = Log::new(recording.clone(), split.clone(), &monitor.part(0.0..begin))?;
        self.run(&log, &monitor.part(begin..1.0))
    }

    /// Draws all cases and tries them.
    ///
    /// # Errors
    /// [`TrialError`] as [`Log::planted`] and [`Case::run`].
    pub fn run(&self, log: &Log, monitor: &Monitor) -> Result<Summary, TrialError> {
        let count = self.draws + self.twins;
        let mut tried = Vec::new();
        for number in 0..count {
            let share = |number: u64| number as f32 / count as f32;
            let part = monitor.part(share(number)..share(number + 1));
            part.report(0.0, &format!("case {} of {count}: planting", number + 1))?;
            tried.push(self.case(log, number, &part)?.run(&part)?);
        }
        Ok(Summary::of(log.before(), self.strengths(), tried))
    }

    /// One of its cases, counted from 0: first those that are planted, then the twins.
    ///
    /// # Errors
    /// As [`Log::planted`].
    pub fn case(&self, log: &Log, number: u64, monitor: &Monitor) -> Result<Case, TrialError> {
        let (seed, strengths) = (self.seed.wrapping_add(number), self.strengths());
        if number < self.draws {
            return log.planted(seed, strengths[(number % strengths.len() as u64) as usize], monitor);
        }
        log.twin(seed, strengths.iter().copied().fold(0.0, f64::max), monitor)
    }

    fn strengths(&self) -> &[f64] {
        if self.strengths.is_empty() { &STRENGTHS } else { &self.strengths }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::arm::Arm;
    use crate::recording::hold_out::HoldOut;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// So many runs of two joints, each so long \[s\] and sampled at this rate \[Hz\], with this share of Coulomb friction on the
    /// second joint.
    pub fn with_friction(trajectories: usize, duration: f64, rate: f64, share: f64) -> (Recording, Split) {
        let motion = Excitation::MultiSine {
            trajectories,
            duration,
            rate,
            harmonics: 4,
            lowest_frequency: 0.1,
            highest_frequency: 1.0,
            max_position: 1.5,
            max_velocity: 3.0,
        };
        let bare = Scenario { arm: Arm::uniform(2), motion, effects: Vec::new(), seed: 5, ..Scenario::embedded() };
        let effects = bare.hide_by_strength("coulomb-friction", &[1], share).unwrap();
        let recording = simulate(&Scenario { effects, ..bare }, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        (recording, split)
    }

    fn log() -> Log {
        let (recording, split) = with_friction(6, 5.0, 60.0, 0.08);
        Log::new(recording, split, &Monitor::new()).unwrap()
    }

    /// An effect that was planted, where, and with which parameters.
    fn planted_by(planting: &Planting) -> (&'static Effect, Option<usize>, Vec<f64>) {
        let effect = registry::find(&planting.effect).unwrap();
        let values = effect.parameters.iter().map(|parameter| planting.parameters[parameter.name]);
        (effect, planting.joint.map(|joint| joint - 1), values.collect())
    }

    fn largest(signals: &Signals) -> f64 {
        signals.values().iter().fold(0.0, |most: f64, value| most.max(value.abs()))
    }

    #[test]
    fn what_is_planted_is_the_torque_of_the_effect_at_the_stated_share() {
        let log = log();
        let mut heard = log.recording.clone();
        for (run, trajectory) in heard.trajectories.iter_mut().enumerate() {
            trajectory.set_torque(log.shown.heard(run, &trajectory.tau)).unwrap();
        }
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..24 {
            let strength = STRENGTHS[seed as usize % STRENGTHS.len()];
            let case = log.planted(seed, strength, &Monitor::new()).unwrap();
            let [planting] = &case.plantings[..] else { panic!("one effect is planted") };
            assert_eq!(planting.strength, strength);
            assert_eq!(case.truth.wanted().map(|planted| &planted.effect).collect::<Vec<_>>(), [&planting.effect]);
            let (effect, place, parameters) = planted_by(planting);
            let torque = log.change(effect, place, &parameters).unwrap();
            let stated = share(&torque, &heard) / strength;
            let tolerance = if effect.fault().is_some() { 0.25 } else { 1e-9 };
            assert!((stated - 1.0).abs() < tolerance, "{}: {stated} of the stated share", effect.id);
            let runs = log.recording.trajectories.iter().zip(&case.recording.trajectories);
            for (run, ((before, after), torque)) in runs.zip(&torque).enumerate() {
                let mut change = after.tau.clone();
                change.add(&before.tau, -1.0);
                let mut change = log.shown.heard(run, &change);
                let [of_torque, size] = [&change, torque].map(largest);
                match effect.stage.number() {
                    // A drive also delays the noise, and what is read late leaves the torque as it is.
                    1 => assert!(of_torque > 0.0, "{}", effect.id),
                    2 if effect.fault().is_none() => {
                        assert!(of_torque == 0.0 && after.qd != before.qd, "{}", effect.id)
                    }
                    _ => {
                        change.add(torque, -1.0);
                        assert!(largest(&change) <= 1e-9 * size, "{}: {}", effect.id, largest(&change));
                        assert_eq!(after.q, before.q);
                    }
                }
            }
            seen.insert(effect.id);
        }
        assert!(seen.len() > 10, "{seen:?}");
        assert!(!seen.contains("tip-payload"), "a rigid body takes it up");
    }

    /// Noise of an acceleration that was derived makes a lag of a few milliseconds large, which says nothing to anybody. What every robot
    /// has takes up a payload, and friction only of another family.
    #[test]
    fn what_nobody_could_find_is_not_planted() {
        let log = log();
        let left = |effect: &str, place: Option<usize>, parameters: &[f64]| {
            let effect = registry::find(effect).unwrap();
            log.left_of(&Drawn { effect, place, strength: 0.1, parameters: parameters.to_vec() }).unwrap()
        };
        assert!(left("tip-payload", None, &[0.3]) < 0.1);
        for (effect, parameters) in
            [("coulomb-friction", &[2.0][..]), ("friction-drift", &[2.0, 0.1]), ("offset-drift", &[2.0, 0.1])]
        {
            let left = left(effect, Some(1), parameters);
            assert!(left > LEAST_LEFT, "{effect}: {left}");
        }
        let (recording, _) = with_friction(6, 5.0, 60.0, 0.08);
        let reach = |run: &Trajectory| Trajectory::way(std::slice::from_ref(run), 0)[1];
        let mut farthest: Vec<(f64, &Trajectory)> =
            recording.trajectories.iter().map(|run| (reach(run), run)).collect();
        farthest.sort_by(|a, b| b.0.total_cmp(&a.0));
        let held_out = HoldOut::named(vec![farthest[0].1.name.clone()]);
        let split = Split::as_asked(&recording, &held_out, &[]).unwrap();
        let log = Log::new(recording.clone(), split, &Monitor::new()).unwrap();
        let stop = |position: f64| {
            let (effect, parameters) = (registry::find("upper-stop").unwrap(), vec![50.0, position]);
            log.left_of(&Drawn { effect, place: Some(0), strength: 0.1, parameters }).unwrap()
        };
        let (reached, far) = (farthest[1].0, farthest[0].0);
        assert!(stop(reached - 0.5) > LEAST_LEFT && far > reached, "{far} {reached}: {}", stop(reached - 0.5));
        assert_eq!(stop(reached), 0.0, "it is touched in the held-out part alone");
        let (quickly_read, split) = with_friction(2, 4.0, 400.0, 0.08);
        let shown = Shown::of(&quickly_read, &split).unwrap();
        let samples = quickly_read.trajectories[0].len();
        let quick = Signals::from_fn(2, samples, |_, t| if t % 4 < 2 { 1.0 } else { -1.0 });
        let heard = shown.heard(0, &quick);
        let middle = &heard[0][samples / 4..3 * samples / 4];
        assert!(middle.iter().all(|value| value.abs() < 0.1), "no model is held against 100 Hz");
    }

    #[test]
    fn a_seed_is_a_case() {
        let log = log();
        let planted = |seed| log.planted(seed, 0.1, &Monitor::new()).unwrap();
        assert_eq!((planted(3).recording, planted(3).truth), (planted(3).recording, planted(3).truth));
        assert_ne!(planted(3).plantings, planted(4).plantings);
        let twin = |seed| log.twin(seed, 0.2, &Monitor::new()).unwrap();
        assert_eq!(twin(3).recording, twin(3).recording);
        assert_ne!(twin(3).recording, twin(4).recording);
    }

    /// The torque of a twin is that of its truth and, in another order, what the truth leaves of the log.
    #[test]
    fn the_truth_of_a_twin_sums_up() {
        let log = log();
        let friction = &log.known.planted[0];
        assert_eq!((friction.effect.as_str(), friction.joint, friction.strong), ("coulomb-friction", Some(2), true));
        for (run, trajectory) in log.recording.trajectories.iter().enumerate() {
            let mut left = trajectory.tau.clone();
            left.add(&log.known.torque[run], -1.0);
            left.add(&log.known.residual[run], -1.0);
            assert!(largest(&left) < 1e-9);
        }
        let mut planted_at_all = 0;
        for seed in 0..6 {
            let twin = log.twin(seed, 0.2, &Monitor::new()).unwrap();
            assert_eq!(twin.truth.planted.len(), log.known.planted.len() + twin.plantings.len());
            let add_torque = |planting: &Planting| registry::find(&planting.effect).unwrap().stage.number() == 0;
            if !twin.plantings.iter().all(add_torque) {
                continue;
            }
            planted_at_all += twin.plantings.len();
            for (run, trajectory) in twin.recording.trajectories.iter().enumerate() {
                let mut noise = trajectory.tau.clone();
                noise.add(&log.known.torque[run], -1.0);
                for planting in &twin.plantings {
                    assert!((0.01..=0.2).contains(&planting.strength));
                    let (effect, place, parameters) = planted_by(planting);
                    let torque = effect.torque(&log.motion(run), place.unwrap_or(0), &parameters).unwrap();
                    noise.add(&torque, -1.0);
                }
                for (noise, residual) in noise.iter().zip(&log.known.residual[run]) {
                    let sizes = |values: &[f64]| {
                        let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
                        sizes.sort_by(f64::total_cmp);
                        sizes
                    };
                    assert!(sizes(noise).iter().zip(sizes(residual)).all(|(one, other)| (one - other).abs() < 1e-9));
                    assert!(noise.iter().zip(residual).any(|(one, other)| (one.abs() - other.abs()).abs() > 1e-6));
                }
            }
        }
        assert!(planted_at_all > 0);
    }

    fn coulomb(joint: usize, torque: f64) -> Drawn {
        let effect = registry::find("coulomb-friction").unwrap();
        Drawn { effect, place: Some(joint), strength: 0.2, parameters: vec![torque] }
    }

    fn tried(log: &Log, drawn: Drawn) -> Tried {
        let mut truth = log.truth(PLANTED, log.assumed());
        truth.planted.push(log.in_words(&drawn));
        let case = log.case(String::new(), log.recording.clone(), &[drawn], truth, Some(log.before.clone()));
        case.unwrap().run(&Monitor::new()).unwrap()
    }

    /// What was there before is not found by its name, but by its parameter.
    #[test]
    fn new_friction_is_found_and_more_of_the_old_is_followed() {
        let log = log();
        let names: Vec<(String, Option<usize>)> =
            log.before().into_iter().map(|name| (name.effect, name.joint)).collect();
        assert_eq!(names, [("coulomb-friction".to_owned(), Some(2))]);
        let new = tried(&log, coulomb(0, 3.0));
        assert_eq!((new.detections[0].before, new.detections[0].named), (Before::Absent, Some(Verdict::Right)));
        assert!(new.false_names.is_empty() && new.lost.is_empty(), "{new:?}");
        // Of the friction that was named before nobody knows whether it is right.
        assert_eq!(new.confidences, [(new.detections[0].confidence.unwrap(), true)]);
        let more = tried(&log, coulomb(1, 2.0));
        let Before::There { followed: Some(followed) } = more.detections[0].before else { panic!("{more:?}") };
        assert!((followed - 1.0).abs() < 0.1, "{followed}");
        assert!(more.confidences.is_empty() && more.lost.is_empty(), "{more:?}");
        let summary = Summary::of(log.before(), &[0.1, 0.2], vec![new, more]);
        let Fared { planted, named, there_before, .. } = summary.planted.by_strength[1];
        assert_eq!((planted, named, there_before, summary.twins.cases), (1, 1, 1, 0));
        assert_eq!((summary.planted.by_strength[0].planted, summary.planted.false_names), (0, Some(0.0)));
    }

    /// Nobody knows whether a log lacks friction of which the truth says nothing; a twin does lack it.
    #[test]
    fn a_false_name_of_what_nearly_every_joint_has_is_counted_apart() {
        let log = log();
        for (before, everyday) in [(Some(log.before.clone()), 1), (None, 0)] {
            let truth = log.truth(PLANTED, log.assumed());
            let case = log.case(String::new(), log.recording.clone(), &[coulomb(0, 3.0)], truth, before);
            let tried = case.unwrap().run(&Monitor::new()).unwrap();
            assert_eq!((tried.false_names.len(), tried.everyday), (1, everyday), "{tried:?}");
            let summary = Summary::of(log.before(), &[0.2], vec![tried]);
            assert_eq!(summary.planted.everyday, Some(everyday as f64));
        }
    }

    #[test]
    fn a_log_that_hardly_moves_is_not_planted_into_forever() {
        let mut log = log();
        for trajectory in &mut log.recording.trajectories {
            let still = trajectory.channels_mut();
            for mut signal in [still.q, still.qd, still.qdd, still.tau] {
                signal.values_mut().fill(0.0);
            }
        }
        log.loads.fill(None);
        let error = log.planted(1, 0.1, &Monitor::new()).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains("could be planted") && error.contains("10 %"), "{error}");
        let monitor = Monitor::new();
        monitor.stop("enough");
        assert!(matches!(log.planted(1, 0.1, &monitor), Err(TrialError::Stopped(_))));
    }
}
