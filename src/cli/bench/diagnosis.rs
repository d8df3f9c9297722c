use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::arm::{Arm, GRAVITY, Link, Posture};
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::cli::write_file;
use crate::diagnosis::{MissingEffect, Report, Suspect, Verdict, diagnose_among, sufficiency};
use crate::effect::{Effect, registry};
use crate::figure;
use crate::progress::Monitor;
use crate::recording::seal::{HiddenEffect, Truth};
use crate::session::{Command, Session, SessionError};
use crate::simulation::{Excitation, Scenario};

/// How many effects the draws hide, in turn; the last of them is left out of the candidates.
const TURNS: [usize; 8] = [0, 1, 2, 0, 1, 2, 3, 1];

/// How often the diagnosis is right on blind draws: arm, motion, noise, sensors, effects, strengths and joints are random.
///
/// The diagnosis sees the recording only; the seal is opened afterwards to score it. A draw is exact if all effects and all
/// their joints are named and nothing else. Of every eight draws two hide nothing, two hide one effect, two hide two, one
/// hides three, and in one the single hidden effect is left out of the candidates, so that it is unknown.
///
/// The evidence suffices if the true set, with its true shapes, beats each set that lacks one of its effects or has another
/// one in its place by what a name needs: 1.5 ln(samples) for each parameter. Rates are about draws where it does; those about
/// all draws are beside them.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench diagnosis --draws 40
  torquescope bench diagnosis --draws 200 --seed 110000 --figures figures
  torquescope bench diagnosis --draws 80 --unknown --list")]
pub struct Diagnosis {
    /// How many recordings.
    #[arg(long, default_value_t = 40)]
    draws: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Hide always this many effects (0 to 3), all of them known.
    #[arg(long, value_parser = clap::value_parser!(u8).range(0..=3))]
    hidden: Option<u8>,
    /// Leave the hidden effect out of the candidates in every draw.
    #[arg(long, conflicts_with = "hidden")]
    unknown: bool,
    /// Hide only these effects.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// The embedded arm and kind of motion, exact accelerations and 2 % noise in every draw.
    #[arg(long)]
    embedded: bool,
    /// Tell every draw that was not exact, and every unknown one.
    #[arg(long)]
    list: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    /// Save the confusion matrix and the reliability diagram in this folder, as SVG and CSV.
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
}

/// The rates, as shares of the draws that they are about; `None` without such draws.
#[derive(Debug, Clone, Serialize)]
struct Rates {
    draws: u64,
    /// Draws of known effects, or of none, answered exactly.
    exact: Option<f64>,
    /// The same of all draws, also where the evidence does not suffice.
    exact_of_all: Option<f64>,
    /// Share of the draws with hidden effects where the evidence suffices.
    sufficient: Option<f64>,
    /// Of the draws without a hidden effect.
    silent: Option<f64>,
    one: Option<f64>,
    two: Option<f64>,
    three: Option<f64>,
    /// The first named effect is a hidden one, on a joint of its own.
    first_right: Option<f64>,
    /// Of the draws whose effect is not among the candidates.
    unknown_flagged: Option<f64>,
    /// Of the same: everything that was named has a confidence below one half.
    unknown_doubted: Option<f64>,
    /// Of the exact answers: flagged although nothing is unknown.
    false_flags: Option<f64>,
    /// True parameters inside their 95 % intervals, of the exact answers.
    coverage: Option<f64>,
    /// Median, of the exact answers.
    error_over_noise_floor: Option<f64>,
    /// Mean distance between confidence and share of right names, over ten classes of confidence.
    calibration_error: Option<f64>,
    seconds_per_recording: f64,
    samples_per_recording: f64,
    by_effect: BTreeMap<&'static str, EffectRates>,
    /// Classes of confidence with the share of names that were right, where effects were unknown too.
    reliability: Vec<Reliability>,
    /// How often each hidden effect (outer) was named what (inner) on one of its joints.
    confusion: BTreeMap<String, BTreeMap<String, u64>>,
}

/// Names that were given about the same confidence.
#[derive(Debug, Clone, Serialize)]
struct Reliability {
    /// Mean confidence.
    confidence: f64,
    /// Share that was right.
    right: f64,
    names: usize,
}

#[derive(Debug, Clone, Default, Serialize)]
struct EffectRates {
    /// How often it was hidden while it was a candidate.
    hidden: u64,
    /// How often it was then named on exactly its joints.
    named: u64,
    /// How often it was named where it was not, while all hidden effects were candidates.
    named_falsely: u64,
}

/// One recording: what is simulated and who may be named.
struct Case {
    scenario: Scenario,
    candidates: Vec<&'static Effect>,
    hidden: usize,
    unknown: bool,
}

#[derive(Default)]
struct Score {
    exact: [Vec<bool>; 4],
    exact_of_all: Vec<bool>,
    sufficient: Vec<bool>,
    first: Vec<bool>,
    flagged: Vec<bool>,
    doubted: Vec<bool>,
    false_flags: Vec<bool>,
    covered: Vec<bool>,
    ratios: Vec<f64>,
    confidences: Vec<(f64, bool)>,
    confusion: BTreeMap<String, BTreeMap<String, u64>>,
    seconds: f64,
    samples: f64,
    by_effect: BTreeMap<&'static str, EffectRates>,
    told: Vec<String>,
}

/// Effects with the places where they act.
type Answer = BTreeSet<(String, Option<usize>)>;

impl Diagnosis {
    pub(super) fn run(&self) -> anyhow::Result<()> {
        for id in &self.only {
            registry::find(id)?;
        }
        let (draws, seed) = (self.draws, self.seed);
        let draw = self.drawing();
        let score = progress::watch("bench diagnosis", move |monitor| {
            let mut score = Score::default();
            for number in 0..draws {
                monitor.report(number as f32 / draws as f32, "drawing and diagnosing").map_err(SessionError::from)?;
                score.add(&draw(seed + number), seed + number, monitor)?;
            }
            Ok::<Score, SessionError>(score)
        })?;
        let rates = score.rates(draws);
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rates)?);
        } else {
            print(&rates);
        }
        if let Some(folder) = &self.figures {
            save_figures(&score, folder)?;
        }
        if self.list {
            score.told.iter().for_each(|draw| eprintln!("{draw}"));
        }
        Ok(())
    }

    /// How a case is drawn from its seed.
    fn drawing(&self) -> impl Fn(u64) -> Case + Send + 'static {
        let (hidden, all_unknown, embedded, only) = (self.hidden, self.unknown, self.embedded, self.only.clone());
        move |seed| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            // The scenario has streams of its own with the same seed.
            random.set_stream(u64::MAX);
            let mut scenario = Scenario { seed, effects: Vec::new(), ..Scenario::embedded() };
            if !embedded {
                vary(&mut scenario, &mut random);
            }
            let turn = (seed % TURNS.len() as u64) as usize;
            let unknown = all_unknown || (hidden.is_none() && turn + 1 == TURNS.len());
            let count = if unknown { 1 } else { hidden.map_or(TURNS[turn], usize::from) };
            hide(&mut scenario, count, &only, &mut random);
            let is_candidate = |effect: &&'static Effect| {
                let stands_for = |hidden: &HiddenEffect| {
                    registry::find(&hidden.effect)
                        .is_ok_and(|hidden| hidden == *effect || effect.contains(hidden) || hidden.looks_like(effect))
                };
                !unknown || !scenario.effects.iter().any(stands_for)
            };
            let candidates = registry::sought().into_iter().filter(is_candidate).collect();
            Case { scenario, candidates, hidden: count, unknown }
        }
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

/// Hides `count` different effects of 3 to 20 % of the torque, each on one joint or two; none beside one that includes it or is another form of
/// it.
fn hide(scenario: &mut Scenario, count: usize, only: &[String], random: &mut ChaCha8Rng) {
    let joints = scenario.arm.joint_count();
    let pool: Vec<&Effect> = registry::sought()
        .into_iter()
        .filter(|effect| only.is_empty() || only.iter().any(|id| id == effect.id))
        .filter(|effect| scenario.stated || !effect.facts.absorbed_by_body)
        .collect();
    let mut hidden: Vec<HiddenEffect> = Vec::new();
    let mut named: Vec<&Effect> = Vec::new();
    // Some draws are impossible (an end stop out of reach), so there are more tries than effects.
    for _ in 0..20 * count {
        if named.len() == count {
            break;
        }
        let Some(&effect) = pool.choose(random) else { break };
        let is_related = |other: &&Effect| {
            *other == effect || other.contains(effect) || effect.contains(other) || effect.looks_like(other)
        };
        if named.iter().any(is_related) {
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
}

fn suspect(hidden: &HiddenEffect) -> Suspect {
    let linear = registry::find(&hidden.effect).map_or(0, |effect| effect.linear().count());
    let shape = hidden.parameters.iter().skip(linear).copied().collect();
    Suspect { effect: hidden.effect.clone(), joint: hidden.joint, shape }
}

fn true_answer(truth: &Truth) -> Answer {
    truth.effects.iter().map(|hidden| (hidden.effect.clone(), hidden.joint)).collect()
}

fn answer_of(named: &MissingEffect) -> Answer {
    let places = registry::find(&named.effect).map(|effect| effect.places(named.joints.iter().copied()));
    places.unwrap_or_default().into_iter().map(|place| (named.effect.clone(), place)).collect()
}

impl Score {
    fn add(&mut self, case: &Case, seed: u64, monitor: &Monitor) -> Result<(), SessionError> {
        let session = Command::Simulate(Box::new(case.scenario.clone())).run(&Session::default(), monitor)?;
        let (Some(recording), Some(current)) = (&session.recording, session.current()) else { return Ok(()) };
        let begin = Instant::now();
        let report = diagnose_among(&case.candidates, &current.fitted, recording, &session.split, monitor)?;
        self.seconds += begin.elapsed().as_secs_f64();
        self.samples += recording.trajectories.iter().map(|trajectory| trajectory.len() as f64).sum::<f64>();
        // Only now, after the diagnosis has spoken, is the seal opened.
        let opened = Command::OpenSeal.run(&session, monitor)?;
        let Some(truth) = &opened.truth else { return Ok(()) };
        let expected = true_answer(truth);
        let suspects: Vec<Suspect> = truth.effects.iter().map(suspect).collect();
        let sufficiency = sufficiency(&current.fitted, recording, &session.split, &suspects, monitor)?;
        let suffices = sufficiency >= 1.0;
        let given: Answer = report.effects.iter().flat_map(answer_of).collect();
        let flagged = !report.unexplained_joints.is_empty() || report.verdict == Verdict::UnknownEffect;
        let exact = expected == given;
        if case.unknown || !exact {
            self.told.push(format!("{}; sufficiency {sufficiency:.2}", tell(case, seed, &expected, &report)));
        }
        if case.hidden > 0 {
            self.sufficient.push(suffices);
        }
        if !case.unknown {
            self.exact_of_all.push(exact);
        }
        let is_right = |named: &MissingEffect| answer_of(named).is_subset(&expected);
        self.confidences.extend(report.effects.iter().map(|named| (named.confidence, is_right(named))));
        if !suffices {
            return Ok(());
        }
        self.confuse(&expected, &given);
        if case.unknown {
            self.flagged.push(flagged);
            self.doubted.push(report.effects.iter().all(|named| named.confidence < 0.5));
            return Ok(());
        }
        self.exact[case.hidden].push(exact);
        if case.hidden > 0 {
            self.first.push(report.effects.first().is_some_and(|first| !answer_of(first).is_disjoint(&expected)));
        }
        self.count_effects(&expected, &given);
        if exact {
            self.false_flags.push(flagged);
            truth.effects.iter().for_each(|hidden| self.check_intervals(hidden, &report));
            if let (Some(last), Some(floor)) = (report.effects.last(), &report.noise_floor_nmse) {
                self.ratios.push(last.nmse_after.iter().sum::<f64>() / floor.iter().sum::<f64>());
            }
        }
        Ok(())
    }

    fn count_effects(&mut self, expected: &Answer, given: &Answer) {
        for id in registry::sought().iter().map(|effect| effect.id) {
            let places = |answer: &Answer| -> BTreeSet<Option<usize>> {
                answer.iter().filter(|(effect, _)| effect == id).map(|(_, place)| *place).collect()
            };
            let (expected, given) = (places(expected), places(given));
            let rates = self.by_effect.entry(id).or_default();
            rates.hidden += u64::from(!expected.is_empty());
            rates.named += u64::from(!expected.is_empty() && expected == given);
            rates.named_falsely += u64::from(!given.is_subset(&expected));
        }
    }

    /// Counts what each hidden effect was named on its joints.
    fn confuse(&mut self, expected: &Answer, given: &Answer) {
        for (hidden, place) in expected {
            let row = self.confusion.entry(hidden.clone()).or_default();
            let mut names: Vec<&String> =
                given.iter().filter(|(_, other)| other == place).map(|(name, _)| name).collect();
            // Beside other hidden effects of the joint only the right name counts for this one, if it is there.
            if names.contains(&hidden) {
                names = vec![hidden];
            }
            names.retain(|name| *name == hidden || !expected.contains(&((*name).clone(), *place)));
            if names.is_empty() {
                *row.entry("nothing".to_owned()).or_default() += 1;
            }
            names.into_iter().for_each(|name| *row.entry(name.clone()).or_default() += 1);
        }
    }

    /// Whether the true parameters lie inside their intervals.
    fn check_intervals(&mut self, hidden: &HiddenEffect, report: &Report) {
        let Ok(effect) = registry::find(&hidden.effect) else { return };
        for (spec, &value) in effect.parameters.iter().zip(&hidden.parameters) {
            let named = report.effects.iter().filter(|named| named.effect == hidden.effect);
            let estimates = named.flat_map(|named| &named.parameters);
            let found = estimates.filter(|estimate| estimate.name == spec.name && estimate.joint == hidden.joint);
            let intervals = found.filter_map(|estimate| estimate.interval);
            self.covered.extend(intervals.map(|[low, high]| (low..=high).contains(&value)));
        }
    }

    fn rates(&self, draws: u64) -> Rates {
        let all: Vec<bool> = self.exact.iter().flatten().copied().collect();
        let mut ratios = self.ratios.clone();
        ratios.sort_by(f64::total_cmp);
        let reliability = reliability(&self.confidences);
        Rates {
            draws,
            exact: share(&all),
            exact_of_all: share(&self.exact_of_all),
            sufficient: share(&self.sufficient),
            silent: share(&self.exact[0]),
            one: share(&self.exact[1]),
            two: share(&self.exact[2]),
            three: share(&self.exact[3]),
            first_right: share(&self.first),
            unknown_flagged: share(&self.flagged),
            unknown_doubted: share(&self.doubted),
            false_flags: share(&self.false_flags),
            coverage: share(&self.covered),
            error_over_noise_floor: ratios.get(ratios.len() / 2).copied(),
            calibration_error: calibration_error(&reliability),
            seconds_per_recording: self.seconds / draws.max(1) as f64,
            samples_per_recording: self.samples / draws.max(1) as f64,
            by_effect: self.by_effect.clone(),
            reliability,
            confusion: self.confusion.clone(),
        }
    }
}

fn save_figures(score: &Score, folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let hidden: Vec<String> = score.confusion.keys().cloned().collect();
    let named: BTreeSet<&String> = score.confusion.values().flat_map(BTreeMap::keys).collect();
    let named: Vec<String> = named.into_iter().cloned().collect();
    let count = |row: &String, column: &String| score.confusion[row].get(column).map_or(0, |&count| count as usize);
    let row = |hidden: &String| named.iter().map(|named| count(hidden, named)).collect();
    let counts: Vec<Vec<usize>> = hidden.iter().map(row).collect();
    let figures = [
        ("confusion", figure::diagnosis::confusion(&hidden, &named, &counts)),
        ("reliability", figure::diagnosis::reliability(&score.confidences, 10)),
    ];
    for (name, drawn) in figures {
        for (ending, format) in [("svg", figure::Format::Svg), ("csv", figure::Format::Csv)] {
            let path = folder.join(name).with_extension(ending);
            write_file(&path, &figure::render(&drawn, format, &figure::Style::default())?)?;
            eprintln!("saved {}", path.display());
        }
    }
    Ok(())
}

fn share(hits: &[bool]) -> Option<f64> {
    let count = hits.iter().filter(|&&hit| hit).count();
    (!hits.is_empty()).then(|| count as f64 / hits.len() as f64)
}

/// The names in ten classes of confidence.
fn reliability(confidences: &[(f64, bool)]) -> Vec<Reliability> {
    let class_of = |confidence: f64| ((confidence * 10.0) as usize).min(9);
    let of_class = |class: usize| {
        let names: Vec<&(f64, bool)> =
            confidences.iter().filter(|(confidence, _)| class_of(*confidence) == class).collect();
        let count = names.len() as f64;
        (!names.is_empty()).then(|| Reliability {
            confidence: names.iter().map(|(confidence, _)| confidence).sum::<f64>() / count,
            right: names.iter().filter(|(_, right)| *right).count() as f64 / count,
            names: names.len(),
        })
    };
    (0..10).filter_map(of_class).collect()
}

fn calibration_error(classes: &[Reliability]) -> Option<f64> {
    let names: usize = classes.iter().map(|class| class.names).sum();
    let distance: f64 = classes.iter().map(|class| class.names as f64 * (class.confidence - class.right).abs()).sum();
    (names > 0).then(|| distance / names as f64)
}

/// One draw in a line.
fn tell(case: &Case, seed: u64, expected: &Answer, report: &Report) -> String {
    let place = |place: &Option<usize>| place.map_or("all".to_owned(), |joint| (joint + 1).to_string());
    let hidden: Vec<String> = expected.iter().map(|(effect, joint)| format!("{effect}@{}", place(joint))).collect();
    let named = |named: &MissingEffect| {
        let joints: Vec<String> = answer_of(named).iter().map(|(_, joint)| place(joint)).collect();
        let alternatives = named.alternatives.join("|");
        format!("{}@{} {:.2} [{alternatives}]", named.effect, joints.join(","), named.confidence)
    };
    let named: Vec<String> = report.effects.iter().map(named).collect();
    let Scenario { arm, torque_noise, encoder_resolution, motion, stated, .. } = &case.scenario;
    let missed = report
        .ranking
        .iter()
        .filter(|candidate| !candidate.accepted && expected.contains(&(candidate.effect.clone(), candidate.joint)));
    let missed: Vec<String> = missed
        .map(|candidate| format!("{}@{}: {}", candidate.effect, place(&candidate.joint), candidate.reason))
        .collect();
    format!(
        "seed {seed}{}: {} joints, {}, noise {:.1} %{}{}; hidden {}; named {}; left on {:?}; {}",
        if case.unknown { " (unknown)" } else { "" },
        arm.joint_count(),
        if matches!(motion, Excitation::MultiSine { .. }) { "sines" } else { "point to point" },
        100.0 * torque_noise,
        if encoder_resolution.is_some() { ", encoders" } else { "" },
        if *stated { ", stated" } else { "" },
        hidden.join(" "),
        named.join("; "),
        report.unexplained_joints.iter().map(|joint| joint + 1).collect::<Vec<_>>(),
        missed.join("; "),
    )
}

fn print(rates: &Rates) {
    let percent = |share: Option<f64>| share.map_or("–".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    let plain = |value: Option<f64>| value.map_or("–".to_owned(), number);
    let rows = [
        ("exact", percent(rates.exact)),
        ("exact, of all draws", percent(rates.exact_of_all)),
        ("evidence suffices", percent(rates.sufficient)),
        ("silent where nothing is hidden", percent(rates.silent)),
        ("exact, one effect", percent(rates.one)),
        ("exact, two effects", percent(rates.two)),
        ("exact, three effects", percent(rates.three)),
        ("first named is right", percent(rates.first_right)),
        ("unknown effect flagged", percent(rates.unknown_flagged)),
        ("unknown effect: all names doubted", percent(rates.unknown_doubted)),
        ("flagged although exact", percent(rates.false_flags)),
        ("95 % interval holds truth", percent(rates.coverage)),
        ("error / noise floor", plain(rates.error_over_noise_floor)),
        ("calibration error", plain(rates.calibration_error)),
        ("s each", number(rates.seconds_per_recording)),
        ("samples each", number(rates.samples_per_recording)),
    ];
    let cells: Vec<Vec<String>> = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect();
    println!("{}\n", table(&[&format!("{} draws", rates.draws), "rate"], &cells));
    let of_effect = |(id, rates): (&&str, &EffectRates)| {
        vec![(*id).to_owned(), rates.hidden.to_string(), rates.named.to_string(), rates.named_falsely.to_string()]
    };
    let cells: Vec<Vec<String>> = rates.by_effect.iter().map(of_effect).collect();
    println!("{}\n", table(&["effect", "hidden", "named", "named falsely"], &cells));
    let of_class = |class: &Reliability| vec![number(class.confidence), number(class.right), class.names.to_string()];
    let cells: Vec<Vec<String>> = rates.reliability.iter().map(of_class).collect();
    println!("{}", table(&["confidence", "right", "names"], &cells));
}
