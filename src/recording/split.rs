//! Training and held-out parts of a recording: by trajectory or by time block, never by sample.
//!
//! Neighbouring samples are nearly copies of each other, so a split by sample would hold out nothing. Where velocity or
//! acceleration was derived, a filter has carried each sample into its neighbours: there what it remembers is left out on both
//! sides of each cut between time blocks, and a finding says so.

use serde::{Deserialize, Serialize};

use super::fault::{self, Fault};
use super::finding::{Finding, FindingKind, Place, Severity};
use super::hold_out::{HoldOut, PARTS, is_by_time_block, turns};
use super::segment::filter_memory;
use super::{Recording, Trajectory, glitch};

pub use super::segment::{MEMORY, Segment, Unusable};

/// Which stretches train and which are held out. The two never overlap; torque readings at [`fault`] are in neither, nor is what
/// a filter has carried over the cut between them. Parameters of a joint are estimated from [`Split::train_of`] it, networks learn
/// all joints at once from `train`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, Default)]
pub struct Split {
    /// Used to estimate parameters.
    pub train: Vec<Segment>,
    /// Used only to measure the error.
    pub held_out: Vec<Segment>,
    /// Where the torque of some joints is at fault: what is left of the training part for each joint by itself. Empty where it is
    /// `train` for all of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub train_by_joint: Vec<Vec<Segment>>,
}

/// The recording can't be split as asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SplitError {
    /// A name that no trajectory has.
    #[error("no trajectory is named `{name}`; the recording has: {known}")]
    UnknownTrajectory {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// Everything was held out.
    #[error("all {0} trajectories are held out, so nothing is left to train on: leave out at least one")]
    NothingToTrain(usize),
    /// A part of a recording that has fewer.
    #[error(
        "each of the {turns} trajectories is held out in its turn, so there is no turn {asked}: choose one of 1 to {turns}"
    )]
    NoSuchTurn {
        /// Counted from 1.
        asked: usize,
        /// How many there are.
        turns: usize,
    },
}

/// How many time blocks a recording of few trajectories is cut into, over all of them.
const BLOCKS: usize = 20;
/// Of each five time blocks one is held out, and of the next five that which comes so many later among them: a motion that repeats itself
/// would otherwise be held out in one phase of it alone, which then never trains (EMPS repeats itself after 6.2 s, five blocks of 1.24 s).
const STAGGER: usize = 2;
/// One in so many training stretches tells when a training has learned enough; where there are fewer, one in so many blocks of
/// each.
pub const VALIDATION_SHARE: usize = 10;
/// How many blocks later the next stretch gives its own.
const VALIDATION_TURN: usize = 3;
/// A time block is at least so many times as long as what is left out at each of its ends.
const LONGEST_GUARD: usize = 4;

/// The readings of a recording that are none: [`fault`]s of its torque, and what no motion makes. [`check`] finds them, too.
///
/// [`check`]: super::check::check
pub fn unusable(recording: &Recording) -> Vec<Unusable> {
    unusable_by(fault::find(recording), glitch::places(recording))
}

/// What these faults of the torque and glitches of the motion leave without readings.
pub(super) fn unusable_by(faults: Vec<Fault>, glitches: Vec<Segment>) -> Vec<Unusable> {
    let of_torque = |Fault { joint, stretches, .. }: Fault| {
        stretches.into_iter().map(move |stretch| Unusable { stretch, torque_of: Some(joint) })
    };
    let of_motion = glitches.into_iter().map(|stretch| Unusable { stretch, torque_of: None });
    faults.into_iter().flat_map(of_torque).chain(of_motion).collect()
}

impl Split {
    /// The split that is used when the user does not choose: every fifth trajectory is held out or, with fewer than four
    /// trajectories, one of each five of about twenty time blocks, each time at another place among the five.
    pub fn automatic(recording: &Recording) -> Split {
        Split::in_turn(recording, 0)
    }

    /// [`Split::automatic`] with other trajectories or time blocks held out: those that come so many later in each five (after the
    /// fifth comes the first). After the last of all [`turns`] comes the first.
    pub fn in_turn(recording: &Recording, turn: usize) -> Split {
        Split::of_all(recording, turn).clear_of(recording, &unusable(recording))
    }

    /// The same of all readings, whatever they are.
    fn of_all(recording: &Recording, turn: usize) -> Split {
        let trajectories = &recording.trajectories;
        let (turns, turn) = (turns(recording), turn % turns(recording));
        if !is_by_time_block(recording) {
            let held_out = |index: usize| index % PARTS == (turns - 1 + turn) % turns;
            return Split::by_trajectory(trajectories, held_out);
        }
        let mut split = Split::default();
        for (trajectory, data) in trajectories.iter().enumerate() {
            let TimeBlocks { count, guard } = TimeBlocks::of(recording, trajectory);
            for block in 0..count {
                let samples = data.len() * block / count..data.len() * (block + 1) / count;
                if samples.is_empty() {
                    continue;
                }
                let of_five = (PARTS / 2 + turn + STAGGER * (trajectory + block / PARTS)) % PARTS;
                let part = if block % PARTS == of_five { &mut split.held_out } else { &mut split.train };
                match part.last_mut() {
                    Some(last) if last.trajectory == trajectory && last.samples.end == samples.start => {
                        last.samples.end = samples.end;
                    }
                    _ => part.push(Segment { trajectory, samples }),
                }
            }
            // What ends within the trajectory ends at a cut between the parts.
            for Segment { samples, .. } in
                split.train.iter_mut().chain(&mut split.held_out).filter(|segment| segment.trajectory == trajectory)
            {
                samples.start += if samples.start > 0 { guard } else { 0 };
                samples.end -= if samples.end < data.len() { guard } else { 0 };
            }
        }
        split
    }

    /// What is to be said of [`Split::automatic`]: how much is left out beside its cuts, and why.
    pub fn findings(recording: &Recording) -> Vec<Finding> {
        let count = recording.trajectories.len();
        let guards = (0..count).filter(|_| is_by_time_block(recording)).map(|trajectory| {
            let guard = TimeBlocks::of(recording, trajectory).guard;
            (guard, guard as f64 * recording.trajectories[trajectory].time_step())
        });
        let Some((samples, seconds)) = guards.max_by_key(|(samples, _)| *samples).filter(|(samples, _)| *samples > 0)
        else {
            return Vec::new();
        };
        vec![Finding {
            severity: Severity::Info,
            kind: FindingKind::Guard,
            what: format!(
                "training and held-out time blocks keep {seconds:.3} s ({samples} samples) away from each cut between them: that \
                 far the filter of the derived channels carries one part into the other."
            ),
            place: Place::default(),
            remedy: String::new(),
            set_right: Vec::new(),
        }]
    }

    /// The training part cut in two for models that are trained by epochs: what is learned from, and about a tenth that says
    /// which epoch is the best. So nothing is chosen by the held-out part. With ten stretches and more it is every tenth of
    /// them, with fewer one of ten time blocks of each, apart from the rest as far as a filter carries.
    pub fn with_validation(&self, recording: &Recording) -> [Vec<Segment>; 2] {
        let [mut learned, mut validation] = [Vec::new(), Vec::new()];
        let by_stretch = self.train.len() >= VALIDATION_SHARE;
        for (index, stretch) in self.train.iter().enumerate() {
            if by_stretch {
                let is_validation = index % VALIDATION_SHARE == VALIDATION_SHARE / 2;
                let part = if is_validation { &mut validation } else { &mut learned };
                part.push(stretch.clone());
                continue;
            }
            let Segment { trajectory, samples } = stretch;
            let block = (VALIDATION_SHARE / 2 + index * VALIDATION_TURN) % VALIDATION_SHARE;
            let cut = |block: usize| samples.start + samples.len() * block / VALIDATION_SHARE;
            let (from, to) = (cut(block), cut(block + 1));
            let guard = TimeBlocks::wanted_guard(recording, *trajectory).min((to - from) / LONGEST_GUARD);
            let part = |samples: std::ops::Range<usize>| Segment { trajectory: *trajectory, samples };
            learned.extend([part(samples.start..from.saturating_sub(guard)), part(to + guard..samples.end)]);
            validation.push(part(from + guard..to - guard));
        }
        [learned, validation].map(|part| part.into_iter().filter(|segment| !segment.samples.is_empty()).collect())
    }

    /// Nothing is held out: for parameters that are to be compared with those that others identified from a whole log.
    pub fn whole(recording: &Recording) -> Split {
        Split::by_trajectory(&recording.trajectories, |_| false).clear_of(recording, &unusable(recording))
    }

    /// Holds out what was asked for; `unusable` is what [`unusable`] gives for the recording.
    ///
    /// # Errors
    /// [`SplitError`] if the recording has no such part or name, or nothing is left to train on.
    pub fn as_asked(recording: &Recording, asked: &HoldOut, unusable: &[Unusable]) -> Result<Split, SplitError> {
        let names = match asked {
            HoldOut::Trajectories(names) => names,
            HoldOut::Fifth(turn) if *turn < turns(recording) => {
                return Ok(Split::of_all(recording, *turn).clear_of(recording, unusable));
            }
            HoldOut::Fifth(turn) => {
                return Err(SplitError::NoSuchTurn { asked: turn + 1, turns: turns(recording) });
            }
        };
        let trajectories = &recording.trajectories;
        if let Some(name) = names.iter().find(|name| trajectories.iter().all(|t| &t.name != *name)) {
            let known = trajectories.iter().map(|t| t.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(SplitError::UnknownTrajectory { name: name.clone(), known });
        }
        let split = Split::by_trajectory(trajectories, |index| names.contains(&trajectories[index].name));
        if split.train.is_empty() {
            return Err(SplitError::NothingToTrain(trajectories.len()));
        }
        Ok(split.clear_of(recording, unusable))
    }

    /// Without these readings of the recording that are none, unless nothing would be left to train on.
    #[must_use]
    pub fn clear_of(self, recording: &Recording, unusable: &[Unusable]) -> Split {
        if unusable.is_empty() {
            return self;
        }
        let clear = |segments: &[Segment], concerns: &dyn Fn(usize) -> bool| {
            let concerned = unusable.iter().filter(|unusable| unusable.torque_of.is_none_or(concerns));
            let stretches: Vec<Segment> = concerned.map(|unusable| unusable.stretch.clone()).collect();
            fault::without(recording, &stretches, segments.to_vec())
        };
        let train = clear(&self.train, &|_| true);
        if train.is_empty() {
            return self;
        }
        let is_of_one = unusable.iter().any(|unusable| unusable.torque_of.is_some()) && recording.joint_count() > 1;
        let joints = 0..if is_of_one { recording.joint_count() } else { 0 };
        let train_by_joint = joints.map(|joint| clear(&self.train, &|other| other == joint)).collect();
        Split { train, held_out: clear(&self.held_out, &|_| true), train_by_joint }
    }

    /// What is learned from for a joint, counted from 0, by itself.
    pub fn train_of(&self, joint: usize) -> &[Segment] {
        self.train_by_joint.get(joint).unwrap_or(&self.train)
    }

    /// The training part of any joint: stretches that do not meet, in their order.
    pub fn train_of_any(&self) -> Vec<Segment> {
        if self.train_by_joint.is_empty() {
            return self.train.clone();
        }
        let mut all = self.train_by_joint.concat();
        all.sort_by_key(|segment| (segment.trajectory, segment.samples.start));
        let mut joined: Vec<Segment> = Vec::new();
        for segment in all {
            match joined.last_mut() {
                Some(last) if last.trajectory == segment.trajectory && segment.samples.start <= last.samples.end => {
                    last.samples.end = last.samples.end.max(segment.samples.end);
                }
                _ => joined.push(segment),
            }
        }
        joined
    }

    /// The same parts of a recording that was changed: what becomes of their stretches.
    #[must_use]
    pub fn changed(&self, change: impl Fn(&Segment) -> Option<Segment>) -> Split {
        let all = |segments: &Vec<Segment>| segments.iter().filter_map(&change).collect();
        Split {
            train: all(&self.train),
            held_out: all(&self.held_out),
            train_by_joint: self.train_by_joint.iter().map(all).collect(),
        }
    }

    /// Every stretch of every part.
    pub fn stretches(&self) -> impl Iterator<Item = &Segment> {
        self.train.iter().chain(&self.held_out).chain(self.train_by_joint.iter().flatten())
    }

    fn by_trajectory(trajectories: &[Trajectory], held_out: impl Fn(usize) -> bool) -> Split {
        let mut split = Split::default();
        for (trajectory, data) in trajectories.iter().enumerate() {
            let part = if held_out(trajectory) { &mut split.held_out } else { &mut split.train };
            part.push(Segment { trajectory, samples: 0..data.len() });
        }
        split
    }
}

/// How one trajectory is cut.
struct TimeBlocks {
    /// How many blocks.
    count: usize,
    /// How many samples are left out on either side of a cut between training and held-out blocks.
    guard: usize,
}

impl TimeBlocks {
    fn of(recording: &Recording, trajectory: usize) -> Self {
        let data = &recording.trajectories[trajectory];
        let samples = data.len();
        let most = BLOCKS.div_ceil(recording.trajectories.len());
        let wanted = TimeBlocks::wanted_guard(recording, trajectory);
        // Fewer and longer blocks where the filter remembers long; in a log of a few seconds it is given less than it wants.
        let longest = samples / (LONGEST_GUARD * wanted).max(1);
        let count = if wanted == 0 { most } else { longest.clamp(PARTS.min(most), most) };
        TimeBlocks { count, guard: wanted.min(samples / count / LONGEST_GUARD) }
    }

    /// How many samples a filter of this trajectory remembers.
    fn wanted_guard(recording: &Recording, trajectory: usize) -> usize {
        let step = recording.trajectories[trajectory].time_step();
        let memory = filter_memory(recording, trajectory).filter(|_| step > 0.0);
        memory.map_or(0, |seconds| (seconds / step).round() as usize)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::recording::{Channels, Origin, Provenance};
    use crate::signals::Signals;

    pub fn recording(lengths: &[usize]) -> Recording {
        let trajectory = |(index, &length): (usize, &usize)| {
            let signal = || Signals::zeros(1, length);
            let time = (0..length).map(|sample| sample as f64).collect();
            let name = format!("run {index}");
            Trajectory::new(name, Channels { time, q: signal(), qd: signal(), qdd: signal(), tau: signal() }).unwrap()
        };
        Recording::of_runs(lengths.iter().enumerate().map(trajectory).collect())
    }

    /// One reading of a hundred times the usual size would outweigh all others.
    #[test]
    fn a_reading_that_no_motion_makes_is_in_no_part() {
        let mut recording = recording(&[1000, 1000]);
        for run in &mut recording.trajectories {
            run.channels_mut().tau[0].iter_mut().enumerate().for_each(|(at, tau)| *tau = (0.01 * at as f64).sin());
        }
        let all = Split::automatic(&recording);
        assert_eq!(all.clone().clear_of(&recording, &unusable(&recording)), all);
        recording.trajectories[1].channels_mut().tau[0][500] = 70.0;
        let clear = Split::automatic(&recording);
        let uses = uses(&recording, &clear);
        assert!(uses[1][500] == 0 && uses[1][490] + uses[1][510] == 2 && uses[0].iter().all(|count| *count == 1));
    }

    fn stretch(trajectory: usize, samples: std::ops::Range<usize>) -> Segment {
        Segment { trajectory, samples }
    }

    /// What is none of one joint's torque says nothing against that of the others, and what is none of the motion says it of all.
    #[test]
    fn a_fault_of_one_torque_leaves_the_other_joints_their_samples() {
        let run = |index: usize| {
            let signal = || Signals::from_fn(2, 1000, |joint, at| (0.01 * (joint + 1) as f64 * at as f64).sin());
            let time = (0..1000).map(|at| 0.01 * f64::from(at)).collect();
            let channels = Channels { time, q: signal(), qd: signal(), qdd: signal(), tau: signal() };
            Trajectory::new(format!("run {index}"), channels).unwrap()
        };
        let recording = Recording::of_runs((0..4).map(run).collect());
        let whole = Split::automatic(&recording);
        let none_of = |stretch: Segment, torque_of: Option<usize>| Unusable { stretch, torque_of };
        let unusable = [none_of(stretch(0, 400..500), Some(1)), none_of(stretch(1, 0..100), None)];
        let split = whole.clone().clear_of(&recording, &unusable);
        let [clear, beside, all] = [&split.train, split.train_of(0), split.train_of(1)].map(size);
        assert!(beside > clear && all == clear, "{clear} {beside} {all}");
        assert!(split.train_of(0).contains(&stretch(0, 0..1000)) && !split.train_of(0).contains(&stretch(1, 0..1000)));
        assert_eq!(split.train_of_any(), split.train_of(0));
        assert_eq!((whole.train_of(1), whole.train_of_any()), (&whole.train[..], whole.train.clone()));
        let halved = split.changed(|segment| Some(segment.thinned(2)));
        assert_eq!(size(halved.train_of(0)), beside / 2);
        assert_eq!(halved.stretches().count(), split.stretches().count());
        let motion_only = whole.clone().clear_of(&recording, &unusable[1..]);
        assert!(motion_only.train_by_joint.is_empty() && size(&motion_only.train) < size(&whole.train));
    }

    /// How often each sample is in a part, by trajectory.
    fn uses(recording: &Recording, split: &Split) -> Vec<Vec<usize>> {
        let mut uses: Vec<Vec<usize>> = recording.trajectories.iter().map(|t| vec![0; t.len()]).collect();
        for segment in split.train.iter().chain(&split.held_out) {
            uses[segment.trajectory][segment.samples.clone()].iter_mut().for_each(|count| *count += 1);
        }
        uses
    }

    fn size(part: &[Segment]) -> usize {
        part.iter().map(|segment| segment.samples.len()).sum()
    }

    proptest::proptest! {
        #[test]
        fn every_sample_is_in_exactly_one_part(lengths in proptest::collection::vec(1usize..200, 1..12)) {
            let recording = recording(&lengths);
            let split = Split::automatic(&recording);
            for uses in uses(&recording, &split) {
                proptest::prop_assert!(uses.iter().all(|count| *count == 1));
            }
            proptest::prop_assert!(size(&split.train) > 0 || recording.sample_count() < 5);
        }
    }

    #[test]
    fn about_a_fifth_is_held_out() {
        for lengths in [&[1000][..], &[500, 500], &[400, 300, 300], &[100; 4], &[100; 10], &[100; 23]] {
            let recording = recording(lengths);
            let split = Split::automatic(&recording);
            let share = size(&split.held_out) as f64 / recording.sample_count() as f64;
            assert!((0.12..=0.3).contains(&share), "{lengths:?}: {share}");
        }
    }

    /// The same with an acceleration that a filter of this cut-off \[Hz\] has passed; a sample a hundredth of a second.
    fn filtered(lengths: &[usize], low_pass_hz: f64) -> Recording {
        let mut recording = recording(lengths);
        for run in &mut recording.trajectories {
            run.channels_mut().time.iter_mut().for_each(|time| *time *= 0.01);
        }
        let derived = Origin::Derived("by a filter".into());
        recording.provenance =
            Provenance { acceleration: derived, low_pass_hz: Some(low_pass_hz), ..Provenance::MEASURED };
        recording
    }

    fn gaps(split: &Split) -> Vec<usize> {
        let mut all: Vec<&Segment> = split.train.iter().chain(&split.held_out).collect();
        all.sort_by_key(|segment| (segment.trajectory, segment.samples.start));
        let within = all.windows(2).filter(|pair| pair[0].trajectory == pair[1].trajectory);
        within.map(|pair| pair[1].samples.start - pair[0].samples.end).collect()
    }

    #[test]
    fn what_the_filter_remembers_is_in_neither_part() {
        // One and a half periods of 6 Hz are a quarter of a second, 25 samples.
        let recording = filtered(&[4000, 4000], 6.0);
        let split = Split::automatic(&recording);
        // Of the first ten blocks 2 and 9 are held out, of the second ten 4 and 6; behind 9 nothing is cut.
        assert_eq!(gaps(&split), [50; 7]);
        assert!((0.12..=0.3).contains(&(size(&split.held_out) as f64 / (size(&split.train) as f64))));
        let finding = &Split::findings(&recording)[0];
        assert!(finding.what.contains("0.250 s (25 samples)"), "{}", finding.what);
        assert_eq!(Split::findings(&super::tests::recording(&[4000])), []);
        assert_eq!(Split::findings(&filtered(&[4000; 6], 6.0)), [], "whole trajectories are not cut");
    }

    #[test]
    fn a_filter_that_remembers_long_leaves_longer_blocks_and_a_short_log_is_still_split() {
        let split = Split::automatic(&filtered(&[4000], 1.0));
        assert!(gaps(&split).iter().all(|gap| *gap == 300), "{:?}", gaps(&split));
        assert!(size(&split.held_out) >= 300 && size(&split.train) >= 1200);
        for samples in [5, 20, 60, 200] {
            let split = Split::automatic(&filtered(&[samples], 2.0));
            assert!(size(&split.held_out) > 0 && size(&split.train) > 0, "{samples} samples: {split:?}");
        }
    }

    /// What comes again after five blocks is held out in one phase here and in another there.
    #[test]
    fn a_motion_that_repeats_itself_trains_in_all_its_phases() {
        let recording = recording(&[1000]);
        for turn in 0..PARTS {
            let split = Split::in_turn(&recording, turn);
            let phases = |part: &[Segment]| -> BTreeSet<usize> {
                part.iter().flat_map(|segment| segment.samples.clone()).map(|sample| sample % 250 / 50).collect()
            };
            assert_eq!(phases(&split.train).len(), PARTS, "{split:?}");
            assert!(phases(&split.held_out).len() >= 4, "{split:?}");
        }
        let alike = Split::automatic(&super::tests::recording(&[500, 500]));
        let [first, second] = [0, 1].map(|run| {
            let of_run = alike.held_out.iter().filter(move |segment| segment.trajectory == run);
            of_run.map(|segment| segment.samples.clone()).collect::<Vec<_>>()
        });
        assert_ne!(first, second, "two runs of one motion");
    }

    /// Every stretch is held out in one turn of five.
    #[test]
    fn turns_hold_out_everything_once() {
        for lengths in [&[1000][..], &[500, 300], &[100; 4], &[100; 11]] {
            let recording = recording(lengths);
            let splits: Vec<Split> = (0..turns(&recording)).map(|turn| Split::in_turn(&recording, turn)).collect();
            assert_eq!(splits[0], Split::automatic(&recording));
            let asked = |turn| Split::as_asked(&recording, &HoldOut::Fifth(turn), &unusable(&recording));
            assert!(splits.iter().enumerate().all(|(turn, split)| asked(turn).as_ref() == Ok(split)));
            assert_eq!(Split::in_turn(&recording, splits.len()), splits[0]);
            let held_out: usize = splits.iter().map(|split| size(&split.held_out)).sum();
            assert_eq!(held_out, recording.sample_count(), "{lengths:?}");
        }
    }

    /// What is learned from and what says when to end are parts of the training part, and nothing is in both.
    #[test]
    fn a_tenth_of_the_training_part_chooses_the_epoch() {
        for lengths in [&[1000][..], &[500, 500], &[100; 4], &[100; 10], &[100; 40], &[7]] {
            let recording = recording(lengths);
            let split = Split::automatic(&recording);
            let [learned, validation] = split.with_validation(&recording);
            let both = Split { train: learned.clone(), held_out: validation.clone(), ..Split::default() };
            let trained = uses(&recording, &Split { train: split.train.clone(), ..Split::default() });
            assert_eq!(uses(&recording, &both), trained, "{lengths:?}");
            let share = size(&validation) as f64 / size(&split.train) as f64;
            assert!(size(&split.train) < 10 || (0.07..=0.14).contains(&share), "{lengths:?}: {share}");
        }
        let filtered = filtered(&[4000, 4000], 6.0);
        let [learned, validation] = Split::automatic(&filtered).with_validation(&filtered);
        let gaps = gaps(&Split { train: learned, held_out: validation.clone(), ..Split::default() });
        assert!(!validation.is_empty() && gaps.iter().all(|gap| *gap > 0), "{gaps:?}");
    }

    #[test]
    fn names_decide_what_is_held_out() {
        let recording = recording(&[10, 20, 30]);
        let split = Split::as_asked(&recording, &HoldOut::named(vec!["run 1".into()]), &[]).unwrap();
        assert_eq!(split.held_out, [Segment { trajectory: 1, samples: 0..20 }]);
        assert_eq!(size(&split.train), 40);
        assert!(uses(&recording, &split).iter().flatten().all(|count| *count == 1));
    }

    #[test]
    fn unknown_names_and_nothing_to_train_on_are_errors() {
        let recording = recording(&[10, 20]);
        let as_asked = |names: Vec<String>| Split::as_asked(&recording, &HoldOut::named(names), &[]);
        let error = as_asked(vec!["run 7".into()]).unwrap_err();
        assert_eq!(error.to_string(), "no trajectory is named `run 7`; the recording has: run 0, run 1");
        assert_eq!(as_asked(vec!["run 0".into(), "run 1".into()]), Err(SplitError::NothingToTrain(2)));
        let four = super::tests::recording(&[10; 4]);
        let error = Split::as_asked(&four, &HoldOut::Fifth(4), &[]).unwrap_err();
        assert!(error.to_string().contains("there is no turn 5: choose one of 1 to 4"), "{error}");
    }
}
