//! What is odd about a recording, said before anybody trains on it.
//!
//! Each is a [`Finding`], which never changes the data.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::catalogue;
use super::differentiate::{
    central_difference, default_cutoff, default_cutoff_of_positions, low_pass, low_pass_together,
};
use super::fault::{self, Fault, FaultKind};
use super::finding::{Finding, FindingKind, Place, Severity};
use super::glitch;
use super::limits;
use super::segment::{Segment, Unusable};
use super::split::unusable_by;
use super::trajectory::Pick;
use super::{JointKind, Origin, Provenance, Recording, Trajectory};
use crate::statistics::integral;

/// A step longer than this many median steps is a gap: derivatives and internal states can't be followed across it.
pub const GAP_STEPS: f64 = 5.0;
/// Fewer samples than this in all are too few to tell effects apart.
const FEW_SAMPLES: usize = 200;
/// From so many axes on an arm is taken to be one in space.
const MANY_AXES: usize = 6;
/// A revolute joint that moves further than this \[rad\] is more likely to be given in degrees.
pub(crate) const FAR: f64 = 15.0;
/// A filter that takes more than this part of a motion away is no filter of its noise.
const MOST_LOST: f64 = 0.5;
/// Longest median step \[s\] that is believed.
const LONGEST_STEP: f64 = 0.5;
/// Shortest median step \[s\] that is believed.
const SHORTEST_STEP: f64 = 1e-5;
/// Largest lag that is looked for \[samples\].
const LONGEST_LAG: usize = 20;

/// A torque that is cut off this near to the effort that is stated is cut off there.
const SAME_LIMIT: f64 = 0.02;

/// What [`check`] found.
#[derive(Debug)]
pub struct Checked {
    /// What is to be said.
    pub findings: Vec<Finding>,
    /// The readings that are none, as [`unusable`](super::split::unusable) gives them.
    pub unusable: Vec<Unusable>,
}

/// All that is odd about a recording that keeps its promises ([`Recording::verify`]); worst first. It looks at gaps,
/// uneven or unbelievable time steps, constant channels, stuck or cut off torque, derivatives that disagree, degrees, readings that
/// no motion makes, limits of the robot that are exceeded, and too little data.
pub fn check(recording: &Recording) -> Checked {
    let mut findings = Vec::new();
    few_samples(recording, &mut findings);
    not_planar(recording, &mut findings);
    clock(recording, &mut findings);
    let joints = (0..recording.joint_count()).into_par_iter();
    let (of_joints, faults) =
        rayon::join(|| joints.map(|joint| of_joint(recording, joint)).collect::<Vec<_>>(), || fault::find(recording));
    let mut glitches = Vec::new();
    for (found, places) in of_joints {
        findings.extend(found);
        glitches.extend(places);
    }
    findings.extend(faults.iter().map(|fault| faulty(recording, fault)));
    findings.extend(limits::find(recording));
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Checked { findings, unusable: unusable_by(faults, glitches) }
}

fn of_joint(recording: &Recording, joint: usize) -> (Vec<Finding>, Vec<Segment>) {
    let mut findings = Vec::new();
    constant(recording, joint, &mut findings);
    degrees(recording, joint, &mut findings);
    derivatives(recording, joint, &mut findings);
    let (glitches, places) = glitch::find(recording, joint);
    findings.extend(glitches);
    (findings, places)
}

fn few_samples(recording: &Recording, findings: &mut Vec<Finding>) {
    let count = recording.sample_count();
    if count < FEW_SAMPLES {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::FewSamples,
            what: format!("the recording has only {count} samples."),
            place: Place::default(),
            remedy: format!("Record at least {FEW_SAMPLES}, better some thousand, of varied motion."),
            set_right: Vec::new(),
        });
    }
}

/// Arms of many axes are hardly ever planar, and nothing says that this one is.
fn not_planar(recording: &Recording, findings: &mut Vec<Finding>) {
    let Recording { chain: None, stated_arm: None, .. } = recording else { return };
    let joints = recording.joint_count();
    if joints >= MANY_AXES && recording.joints.iter().all(|joint| joint.kind == JointKind::Revolute) {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::NotPlanar,
            what: format!(
                "{joints} axes are taken for those of a planar arm, all parallel, because nothing says where they are; robots \
                 with so many are hardly ever planar."
            ),
            place: Place::default(),
            remedy: format!(
                "Take the axes from the robot's file (URDF or MJCF: `--arm`; in the window open it, or drop it there) or from a \
                 mapping (a table `arm`{}), or state the links of a planar arm with `--arm`.",
                match catalogue::with_axes(joints) {
                    Some((name, robot)) => format!("; that of {robot} comes with the program: `--map {name}`, or *Columns…*"),
                    None => ", as `--map ur10` has one".to_owned(),
                }
            ),
            set_right: Vec::new(),
        });
    }
}

fn clock(recording: &Recording, findings: &mut Vec<Finding>) {
    let mut uneven = Vec::new();
    for (index, trajectory) in recording.trajectories.iter().enumerate() {
        let median = trajectory.time_step();
        let place = Place { trajectory: Some(index), ..Place::default() };
        let steps = || trajectory.time.windows(2).map(|pair| pair[1] - pair[0]);
        for (at, step) in steps().enumerate().filter(|(_, step)| *step > GAP_STEPS * median) {
            findings.push(Finding {
                severity: Severity::Warning,
                kind: FindingKind::TimeGap,
                what: format!("`{}` has a gap of {step:.4} s after sample {at}.", trajectory.name),
                place: Place { samples: Some(at..at + 2), ..place.clone() },
                remedy: "Cut the trajectory there.".to_owned(),
                set_right: Vec::new(),
            });
        }
        let differs = |step: f64, by: f64| (step / median - 1.0).abs() > by && step <= GAP_STEPS * median;
        let off = steps().filter(|step| differs(*step, 0.2)).count();
        let mut odd = steps().enumerate().filter(|(_, step)| differs(*step, 0.4));
        if off * 100 > trajectory.len() {
            uneven.push((off as f64 / trajectory.len() as f64, trajectory.name.as_str(), place));
        } else if let Some((at, step)) = odd.next() {
            findings.push(odd_step(&trajectory.name, at, step / median, odd.count() + 1, place));
        }
    }
    if let Some((share, name, place)) = uneven.iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::UnevenTime,
            what: format!(
                "{} of {} trajectories have uneven time steps; in `{name}` {:.0} % differ by more than a fifth from the median.",
                uneven.len(),
                recording.trajectories.len(),
                100.0 * share
            ),
            place: place.clone(),
            remedy: "Derivatives use the actual times; the cut-off of filters holds for the median step.".to_owned(),
            set_right: Vec::new(),
        });
    }
    let steps = recording.trajectories.iter().map(Trajectory::time_step).filter(|step| *step > 0.0);
    if let Some(step) = steps.reduce(f64::max).filter(|step| !(SHORTEST_STEP..=LONGEST_STEP).contains(step)) {
        let unit = if step > LONGEST_STEP { "milliseconds or smaller" } else { "larger than seconds" };
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::TimeUnit,
            what: format!("the median time step is {step} s, which hardly is a robot's; the unit may be {unit}."),
            place: Place::default(),
            remedy: "Name the unit in the column, such as `time[ms]`, and read the file again.".to_owned(),
            set_right: Vec::new(),
        });
    }
}

/// Of a clock that else is even.
fn odd_step(name: &str, at: usize, times: f64, count: usize, place: Place) -> Finding {
    let others = if count == 1 { String::new() } else { format!(", and {} more are as odd", count - 1) };
    Finding {
        severity: Severity::Info,
        kind: FindingKind::UnevenTime,
        what: format!(
            "the time step of `{name}` after sample {at} is {times:.2} times the usual one{others}: samples may be missing there."
        ),
        place: Place { samples: Some(at..at + 2), ..place },
        remedy: "Derivatives use the actual times.".to_owned(),
        set_right: Vec::new(),
    }
}

fn constant(recording: &Recording, joint: usize, findings: &mut Vec<Finding>) {
    let channels: [(&str, Pick); 4] = [("q", |t| &t.q), ("q̇", |t| &t.qd), ("q̈", |t| &t.qdd), ("τ", |t| &t.tau)];
    let still: Vec<&str> = channels
        .iter()
        .filter(|(_, channel)| {
            let mut values = recording.trajectories.iter().flat_map(|t| &channel(t)[joint]);
            let first = values.next();
            values.all(|value| Some(value) == first)
        })
        .map(|(name, _)| *name)
        .collect();
    if still.is_empty() {
        return;
    }
    findings.push(Finding {
        severity: Severity::Warning,
        kind: FindingKind::Constant,
        what: format!("{} of {} never changes.", still.join(", "), recording.joints[joint].name),
        place: Place::joint(joint),
        remedy: "Nothing can be learned from it: check the mapping, or record a motion of this joint.".to_owned(),
        set_right: Vec::new(),
    });
}

fn faulty(recording: &Recording, fault: &Fault) -> Finding {
    let name = &recording.joints[fault.joint].name;
    let share = 100.0 * fault.sample_count() as f64 / recording.sample_count() as f64;
    let (kind, what) = match fault.kind {
        FaultKind::Stuck => {
            let count = fault.stretches.len();
            let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
            (FindingKind::Stuck, format!("τ of {name} stands still {times} while the joint moves"))
        }
        FaultKind::Saturated => {
            let limit = fault.parameters(recording)[0];
            let stated = recording.chain.as_ref().and_then(|chain| chain.limits(fault.joint).effort);
            let is_it = stated.is_some_and(|stated| (limit.abs() / stated - 1.0).abs() < SAME_LIMIT);
            let why = if is_it { ", the most that the robot's file allows" } else { "" };
            (FindingKind::Saturated, format!("τ of {name} is cut off at {limit:.4}{why}"))
        }
    };
    let first = fault.stretches.first();
    Finding {
        severity: Severity::Warning,
        kind,
        what: format!("{what}, in {share:.1} % of the samples."),
        place: Place {
            trajectory: first.map(|stretch| stretch.trajectory),
            samples: first.map(|stretch| stretch.samples.clone()),
            ..Place::joint(fault.joint)
        },
        remedy:
            "These samples and some around them count in no error and train no network, and the joint learns nothing from them; \
             check the sensor and its range."
                .to_owned(),
        set_right: Vec::new(),
    }
}

fn degrees(recording: &Recording, joint: usize, findings: &mut Vec<Finding>) {
    if recording.joints[joint].kind != JointKind::Revolute {
        return;
    }
    let furthest = recording.trajectories.iter().flat_map(|t| &t.q[joint]).fold(0.0, |far: f64, q| far.max(q.abs()));
    if furthest > FAR {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::Degrees,
            what: format!("q of {} reaches {furthest:.1} rad, which looks like degrees.", recording.joints[joint].name),
            place: Place::joint(joint),
            remedy: "If it is, name the unit in the column, such as `q1[deg]`, and read the file again.".to_owned(),
            set_right: Vec::new(),
        });
    }
}

fn derivatives(recording: &Recording, joint: usize, findings: &mut Vec<Finding>) {
    let Provenance { velocity, acceleration, .. } = &recording.provenance;
    let comparisons: [(&Origin, FindingKind, [&str; 3], Pick, Pick); 2] = [
        (velocity, FindingKind::VelocityMismatch, ["q̇", "dq/dt", "qd"], |t| &t.q, |t| &t.qd),
        (acceleration, FindingKind::AccelerationMismatch, ["q̈", "dq̇/dt", "qdd"], |t| &t.qd, |t| &t.qdd),
    ];
    for (origin, kind, [name, slope, key], signal, stated) in comparisons {
        if *origin != Origin::Measured {
            findings.extend(flattened(recording, joint, [name, slope, key], signal, stated));
            continue;
        }
        let complaint = Comparison::of(recording, joint, signal, stated).and_then(|found| found.complaint(slope));
        if let Some((severity, complaint)) = complaint {
            findings.push(Finding {
                severity,
                kind,
                what: format!("{name} of {} {complaint}.", recording.joints[joint].name),
                place: Place::joint(joint),
                remedy: format!("Check unit, sign, gear ratio and mapping of the column, or derive it with `{key}=-`."),
                set_right: Vec::new(),
            });
        }
    }
}

/// What is to be said of a derivative whose filter takes most of the motion away.
fn flattened(
    recording: &Recording,
    joint: usize,
    [name, slope, key]: [&str; 3],
    signal: Pick,
    derived: Pick,
) -> Option<Finding> {
    let share = recording.trajectories.iter().fold([0.0; 2], |[lost, whole], trajectory| {
        let about_mean = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| value - mean).collect::<Vec<_>>()
        };
        let travelled = integral(&derived(trajectory)[joint], &trajectory.time);
        let moved = about_mean(&signal(trajectory)[joint]);
        let left = moved.iter().zip(about_mean(&travelled)).map(|(moved, told)| (moved - told).powi(2));
        [lost + left.sum::<f64>(), whole + moved.iter().map(|value| value * value).sum::<f64>()]
    });
    let lost = share[0] / share[1];
    // What is lost of a joint that is held still is noise, and so is its slope.
    let moves = || {
        recording.trajectories.iter().any(|trajectory| {
            let cutoff = default_cutoff_of_positions(&trajectory.q, &trajectory.time);
            let raw = central_difference(&signal(trajectory)[joint], &trajectory.time);
            let smooth = low_pass(&raw, trajectory.time_step(), cutoff);
            let power = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
            let noise: f64 = raw.iter().zip(&smooth).map(|(raw, smooth)| (raw - smooth).powi(2)).sum();
            power(&smooth) > noise * noise_passed(cutoff * trajectory.time_step())
        })
    };
    (lost > MOST_LOST && moves()).then(|| Finding {
        severity: Severity::Warning,
        kind: FindingKind::Flattened,
        what: format!(
            "the filter of {slope} takes {:.0} % of the motion of {} away: what is left in {name} is not its motion.",
            (100.0 * lost).min(100.0),
            recording.joints[joint].name
        ),
        place: Place::joint(joint),
        remedy: format!(
            "Take a higher cut-off (--low-pass) or a narrower Gaussian (--gaussian), or neither: it follows from the motion then. \
             Or map a column with {name} (`{key}=`)."
        ),
        set_right: Vec::new(),
    })
}

/// So many times the noise that a filter lets through must a motion have to be one.
const ABOVE_NOISE: f64 = 4.0;

/// What a low-pass at this share of the sampling rate lets through of the power of differentiated white noise, with a margin; at
/// most all that it holds back. Of central differences, sin²(2πf), the part below the cut-off is 16π²/3 of its cube.
fn noise_passed(share: f64) -> f64 {
    (ABOVE_NOISE * 16.0 * PI * PI / 3.0 * share.powi(3)).min(1.0)
}

/// How a stated derivative relates to the one computed, over all trajectories.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Comparison {
    /// Stated = factor × computed, after the lag is taken out.
    pub factor: f64,
    /// By how many samples the stated one comes late.
    pub lag: isize,
    /// The same in s.
    pub lag_seconds: f64,
    /// Share of the stated derivative's power that the computed one explains, lag taken out.
    pub agreement: f64,
    /// The same without taking the lag out.
    agreement_at_once: f64,
}

impl Comparison {
    /// `None` where there is too little motion or data to tell.
    pub fn of(recording: &Recording, joint: usize, signal: Pick, stated: Pick) -> Option<Comparison> {
        let margin = LONGEST_LAG;
        // By lag, from the latest on: Σ computed · stated, Σ computed².
        let [mut products, mut powers] = [[0.0; 2 * LONGEST_LAG + 1]; 2];
        let (mut stated_power, mut noise_power) = (0.0, 0.0);
        let (mut step, mut passed) = (0.0, 0.0f64);
        for trajectory in recording.trajectories.iter().filter(|t| t.len() > 4 * margin) {
            step = trajectory.time_step();
            let cutoff = default_cutoff(&trajectory.q, &trajectory.qd, step);
            passed = passed.max(noise_passed(cutoff * step));
            let raw = central_difference(&signal(trajectory)[joint], &trajectory.time);
            let smooth = low_pass_together(&[&raw, &stated(trajectory)[joint]], step, cutoff);
            let [computed, stated] = &smooth[..] else { continue };
            let inner = margin..trajectory.len() - margin;
            for sample in inner {
                stated_power += stated[sample].powi(2);
                noise_power += (raw[sample] - computed[sample]).powi(2);
                // All lags go along together, which the processor does at once.
                let around = &computed[sample - margin..=sample + margin];
                for ((value, product), power) in around.iter().zip(&mut products).zip(&mut powers) {
                    *product += value * stated[sample];
                    *power += value * value;
                }
            }
        }
        // A joint that was held still has noise only, which follows nothing; one that moves has more than noise lets through.
        if powers[margin] <= noise_power * passed {
            return None;
        }
        let agreement = |at: usize| products[at].powi(2) / (powers[at] * stated_power);
        let lag = |at: usize| margin as isize - at as isize;
        let best = (0..products.len())
            .rev()
            .max_by(|a, b| agreement(*a).total_cmp(&agreement(*b)).then(lag(*b).abs().cmp(&lag(*a).abs())))?;
        let found = Comparison {
            factor: products[best] / powers[best],
            lag: lag(best),
            lag_seconds: lag(best) as f64 * step,
            agreement: agreement(best),
            agreement_at_once: agreement(margin),
        };
        (found.agreement.is_finite() && found.factor.is_finite()).then_some(found)
    }

    /// Whether there is a lag: taking it out removes a good part of what was unexplained.
    pub fn is_late(&self) -> bool {
        self.lag.abs() >= 2 && 1.0 - self.agreement < 0.6 * (1.0 - self.agreement_at_once)
    }

    /// What is wrong, in words that go on after the name of the channel; `None` if the two agree.
    fn complaint(&self, slope: &str) -> Option<(Severity, String)> {
        let Comparison { factor, lag, lag_seconds, agreement, .. } = *self;
        if agreement < 0.7 {
            let severity = if agreement < 0.3 { Severity::Error } else { Severity::Warning };
            let percent = 100.0 * agreement;
            return Some((severity, format!("does not follow {slope}: only {percent:.0} % of it is explained")));
        }
        let mut parts = Vec::new();
        let mut severity = Severity::Warning;
        if (factor - 1.0).abs() > 0.1 {
            let readings = [(180.0 / PI, "degrees"), (PI / 180.0, "degrees"), (-1.0, "the other sign")];
            let likely = readings.iter().find(|(known, _)| (factor / known - 1.0).abs() < 0.1);
            let likely = likely.map_or(String::new(), |(_, name)| format!(" (it looks like {name})"));
            parts.push(format!("is {factor:.3} times {slope}{likely}"));
            if (factor - 1.0).abs() > 0.5 {
                severity = Severity::Error;
            }
        }
        if self.is_late() {
            let direction = if lag > 0 { "behind" } else { "ahead of" };
            parts.push(format!("is {} samples ({:.4} s) {direction} {slope}", lag.abs(), lag_seconds.abs()));
        }
        (!parts.is_empty()).then(|| (severity, parts.join(" and ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;
    use crate::recording::differentiate::derivative;
    use crate::signals::Signals;

    /// One joint that swings; q̇ = `factor` times the truth, `lag` samples late, likewise q̈.
    fn swinging(factor: f64, lag: f64) -> Recording {
        let step = 0.002;
        let time: Vec<f64> = (0..3000).map(|sample| sample as f64 * step).collect();
        let wave = |t: f64| (3.0 * t).sin() + 0.5 * (7.0 * t).cos();
        let speed = |t: f64| 3.0 * (3.0 * t).cos() - 3.5 * (7.0 * t).sin();
        let growth = |t: f64| -9.0 * (3.0 * t).sin() - 24.5 * (7.0 * t).cos();
        let sampled = |f: &dyn Fn(f64) -> f64| Signals::from_fn(1, time.len(), |_, sample| f(time[sample]));
        let channels = Channels {
            q: sampled(&wave),
            qd: sampled(&|t| factor * speed(t - lag * step)),
            qdd: sampled(&|t| factor * growth(t - lag * step)),
            tau: sampled(&growth),
            time,
        };
        Recording::of_runs(vec![Trajectory::new("swing", channels).unwrap()])
    }

    fn kinds(recording: &Recording) -> Vec<FindingKind> {
        check(recording).findings.into_iter().map(|finding| finding.kind).collect()
    }

    #[test]
    fn a_clean_recording_has_no_findings() {
        assert_eq!(check(&swinging(1.0, 0.0)).findings, []);
    }

    #[test]
    fn a_velocity_of_another_unit_sign_or_moment_is_told_with_factor_and_lag() {
        for (factor, lag, words) in [
            (180.0 / PI, 0.0, "looks like degrees"),
            (-1.0, 0.0, "other sign"),
            (0.5, 0.0, "0.500 times"),
            (1.0, 8.0, "8 samples (0.0160 s) behind"),
            (1.0, -5.0, "5 samples (0.0100 s) ahead"),
        ] {
            let found = check(&swinging(factor, lag)).findings;
            let velocity = found.iter().find(|f| f.kind == FindingKind::VelocityMismatch).unwrap();
            assert!(velocity.what.contains(words), "{}", velocity.what);
        }
    }

    #[test]
    fn a_filter_that_takes_the_motion_away_is_told() {
        let derived = |cutoff: f64| {
            let mut recording = swinging(1.0, 0.0);
            for trajectory in &mut recording.trajectories {
                let Channels { time, q, qd, tau, .. } = Channels::clone(trajectory);
                let qdd = qd.map_joints(|joint| derivative(joint, &time, cutoff));
                *trajectory = Trajectory::new("swing", Channels { time, q, qd, qdd, tau }).unwrap();
            }
            recording.provenance.acceleration = Origin::Derived(String::new());
            recording
        };
        assert_eq!(kinds(&derived(20.0)), []);
        assert_eq!(kinds(&derived(0.05)), [FindingKind::Flattened]);
    }

    /// Whoever splits a recording without its check leaves out the same readings.
    #[test]
    fn what_is_unusable_is_the_same_with_findings_and_without() {
        let mut recording = swinging(1.0, 0.0);
        let run = recording.trajectories[0].channels_mut();
        let (mut qd, mut tau) = (run.qd, run.tau);
        qd[0].copy_within(400..430, 1000);
        tau[0][2000..2100].fill(0.0);
        tau[0][500] = 1e4;
        let unusable = check(&recording).unusable;
        for sample in [500, 1010, 2050] {
            assert!(unusable.iter().any(|place| place.stretch.samples.contains(&sample)), "{sample}: {unusable:?}");
        }
        assert_eq!(crate::recording::split::unusable(&recording), unusable);
    }

    #[test]
    fn a_joint_that_was_held_still_raises_no_alarm_about_its_noise() {
        let mut recording = swinging(1.0, 0.0);
        let noise = |salt: f64| move |sample: usize| ((sample as f64 * salt).sin() * 43758.5453).fract() - 0.5;
        let mut run = recording.trajectories[0].channels_mut();
        for (signal, salt, size) in
            [(&mut run.q, 12.9898, 1e-4), (&mut run.qd, 78.233, 1e-2), (&mut run.qdd, 37.719, 1.0)]
        {
            signal[0].iter_mut().enumerate().for_each(|(sample, value)| *value = size * noise(salt)(sample));
        }
        assert_eq!(kinds(&recording), []);
    }

    /// Encoder noise that buries dq/dt between two samples does not hide that q̇ is wrong.
    #[test]
    fn a_joint_that_moves_under_much_noise_is_not_held_still() {
        let mut recording = swinging(0.1, 0.0);
        let noise = |sample: usize| ((sample as f64 * 12.9898).sin() * 43758.5453).fract() - 0.5;
        let mut run = recording.trajectories[0].channels_mut();
        run.q[0].iter_mut().enumerate().for_each(|(sample, q)| *q += 0.1 * noise(sample));
        let found = check(&recording).findings;
        let velocity = found.iter().find(|finding| finding.kind == FindingKind::VelocityMismatch).unwrap();
        assert!(velocity.what.contains("0.1"), "{}", velocity.what);
    }

    #[test]
    fn an_acceleration_that_is_something_else_is_told() {
        let mut recording = swinging(1.0, 0.0);
        let run = recording.trajectories[0].channels_mut();
        let mut qdd = run.qdd;
        qdd[0].iter_mut().zip(&run.q[0]).for_each(|(qdd, q)| *qdd = (q * 91.0).sin());
        assert_eq!(kinds(&recording), [FindingKind::AccelerationMismatch]);
    }

    #[test]
    fn gaps_constants_degrees_few_samples_and_odd_clocks_are_told() {
        let mut recording = swinging(1.0, 0.0);
        recording.trajectories[0].channels_mut().time.iter_mut().skip(1500).for_each(|t| *t += 1.0);
        assert_eq!(kinds(&recording), [FindingKind::TimeGap]);

        let mut recording = swinging(1.0, 0.0);
        recording.trajectories[0].channels_mut().time.iter_mut().skip(1500).for_each(|t| *t += 0.002);
        let missing = &check(&recording).findings[0];
        assert_eq!((missing.kind, missing.place.samples.clone()), (FindingKind::UnevenTime, Some(1499..1501)));
        assert!(missing.what.contains("2.00 times the usual"), "{}", missing.what);

        let mut recording = swinging(1.0, 0.0);
        recording.trajectories[0].channels_mut().tau[0].fill(0.0);
        assert_eq!(kinds(&recording), [FindingKind::Constant]);

        let mut recording = swinging(1.0, 0.0);
        let run = recording.trajectories[0].channels_mut();
        for mut signal in [run.q, run.qd, run.qdd] {
            signal.values_mut().iter_mut().for_each(|value| *value *= 57.3);
        }
        assert_eq!(kinds(&recording), [FindingKind::Degrees]);

        let mut recording = swinging(1.0, 0.0);
        recording.trajectories = vec![recording.trajectories[0].slice(0..50)];
        assert_eq!(kinds(&recording), [FindingKind::FewSamples]);

        let mut recording = swinging(1.0, 0.0);
        recording.trajectories[0].channels_mut().time.iter_mut().for_each(|t| *t *= 1000.0);
        assert!(kinds(&recording).contains(&FindingKind::TimeUnit));
    }

    /// A clock in milliseconds that nobody named, and one of days.
    #[test]
    fn a_step_that_is_hardly_a_robots_is_told_with_its_likely_unit() {
        let told = |factor: f64| {
            let mut recording = swinging(1.0, 0.0);
            let time = recording.trajectories[0].time.iter().map(|time| factor * time).collect();
            let run = &recording.trajectories[0];
            let channels =
                Channels { time, q: run.q.clone(), qd: run.qd.clone(), qdd: run.qdd.clone(), tau: run.tau.clone() };
            recording.trajectories[0] = Trajectory::new("swing", channels).unwrap();
            let of_unit = |finding: Finding| (finding.kind == FindingKind::TimeUnit).then_some(finding.what);
            check(&recording).findings.into_iter().find_map(of_unit)
        };
        assert!(told(1000.0).is_some_and(|what| what.ends_with("milliseconds or smaller.")));
        assert!(told(1e-6).is_some_and(|what| what.ends_with("larger than seconds.")));
        assert_eq!(told(1.0), None);
    }

    /// What agrees badly is an error, what agrees half a warning, and a wrong factor is worse the wronger it is.
    #[test]
    fn complaints_weigh_as_much_as_what_is_wrong() {
        let of = |agreement, factor| {
            let at_once = agreement;
            Comparison { factor, lag: 0, lag_seconds: 0.0, agreement, agreement_at_once: at_once }.complaint("dq/dt")
        };
        let severity = |agreement, factor| of(agreement, factor).map(|(severity, _)| severity);
        assert_eq!((severity(0.29, 1.0), severity(0.31, 1.0)), (Some(Severity::Error), Some(Severity::Warning)));
        assert_eq!((severity(0.71, 1.0), severity(0.99, 1.09)), (None, None));
        assert_eq!((severity(0.99, 1.2), severity(0.99, 1.6)), (Some(Severity::Warning), Some(Severity::Error)));
        assert!(of(0.29, 1.0).is_some_and(|(_, text)| text.contains("only 29 % of it is explained")));
        assert!(of(0.99, 180.0 / PI).is_some_and(|(_, text)| text.ends_with("(it looks like degrees)")));
    }
}
