//! Torque and columns of the training stretches, prepared alike: what models are fitted to.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::DVector;

use super::equations::{Block, Equations, PreparedColumn};
use super::preparation::Preparation;
use super::reach::reach;
use super::rest::{Counting, blank};
use super::reversal;
use super::terms::{OperatingPoint, Setting};
use super::whitening::Whitening;
use super::working::Working;
use super::{EffectTerm, Model, ModelError, RigidBody, Term, waves};
use crate::effect::{Column, Load, Way};
use crate::recording::split::{Segment, Split};
use crate::recording::{Origin, Recording, Trajectory};
use crate::signals::Signals;

/// Blocks for validation and standard errors are by training stretch if there are at least this many, else by time.
const FEWEST_BLOCKS: usize = 10;
/// Loads that differ by a smaller share (RMS) are the same, as alterations are.
const SAME_LOAD: f64 = 0.01;
/// How many time blocks are cut otherwise, over all stretches.
const TIME_BLOCKS: usize = 16;

/// The data that models are fitted to, filtered, thinned out, cut into blocks; and the point at which columns are taken that
/// depend on what else is in the torque. Nobody changes it: [`Design::at`] gives the same data at another point.
#[derive(Debug, Clone)]
pub struct Design<'a> {
    recording: Cow<'a, Recording>,
    setting: Setting,
    /// Stretches that are kept together in validation.
    blocks: Vec<Block>,
    /// Prepared torque, by trajectory; zero where a sample does not count.
    torque: Vec<Signals>,
    /// Whether a prepared sample counts: `counts[trajectory][joint][sample]`.
    counts: Vec<Vec<Vec<bool>>>,
    preparations: Vec<Preparation>,
    /// Above this \[Hz\] the torque does not follow the motion, so that the preparations end there.
    follows_up_to: Option<f64>,
    ways: Vec<Way>,
    /// ρ₁ of white noise as the preparations leave it.
    noise_correlation: f64,
    point: OperatingPoint,
    /// What the rigid body needs, by trajectory.
    loads: Vec<Option<Load>>,
    /// The prepared columns of a rigid body that is identified: they are the same at every point.
    body: Arc<[PreparedColumn]>,
    /// What is done to all that is prepared.
    whitening: Whitening,
}

/// What is known before any model is.
struct Rough {
    /// Factors of the rigid body.
    body: Vec<f64>,
    /// What it, offsets and the commonest friction leave of the prepared torque, by trajectory.
    left: Vec<Signals>,
}

impl<'a> Design<'a> {
    /// Prepares the training part of a recording.
    ///
    /// # Errors
    /// [`ModelError`] if no planar rigid body fits the recording or the torque never changes.
    pub fn new(recording: &'a Recording, split: &Split) -> Result<Self, ModelError> {
        let mut design = Design::followed(recording, split)?;
        design.setting.reversal_widths = reversal::widths(&design)?;
        design.at_rough_body()
    }

    /// The whole recording as most published identifications take it: all samples of a joint count that are not slower than this
    /// \[rad/s or m/s\], dry friction jumps with the sign of the velocity, and derivatives are those of the reader.
    ///
    /// # Errors
    /// As [`Design::new`].
    pub fn plain(recording: &'a Recording, slowest: f64) -> Result<Self, ModelError> {
        Design::prepared(Setting::of(recording)?, Working::plain(recording), Counting::NotSlower(slowest))?
            .at_rough_body()
    }

    /// In a band that does not reach beyond `highest` \[Hz\], if that is given.
    fn within(recording: &'a Recording, split: &Split, highest: Option<f64>) -> Result<Self, ModelError> {
        Design::prepared(Setting::of(recording)?, Working::of(recording, split, highest), Counting::Moving)
    }

    /// In the band in which the torque follows the motion.
    fn followed(recording: &'a Recording, split: &Split) -> Result<Self, ModelError> {
        let design = Design::within(recording, split, None)?;
        let follows_up_to = match recording.provenance.acceleration {
            Origin::Measured => None,
            Origin::Derived(_) => reach(&design.preparations, &design.counts, &design.torque, &design.rough()?.left),
        };
        let narrower = follows_up_to.map(|highest| Design::within(recording, split, Some(highest))).transpose()?;
        Ok(Design { follows_up_to, ..narrower.unwrap_or(design) })
    }

    fn at_rough_body(mut self) -> Result<Self, ModelError> {
        let rough = self.rough()?;
        self.ways = waves::with_peaks(&self, &rough.left);
        Ok(self.at(OperatingPoint { body: Some(rough.body), ..OperatingPoint::default() }))
    }

    /// [`Design::new`] where body, reversals and what changes other effects are known: those of a model that was fitted elsewhere, and
    /// that predicts the torque, which follows the motion then.
    ///
    /// # Errors
    /// As [`Design::new`].
    pub fn in_setting(recording: &'a Recording, split: &Split, setting: &Setting) -> Result<Self, ModelError> {
        let mut design = Design::within(recording, split, None)?;
        design.setting.reversal_widths.clone_from(&setting.reversal_widths);
        let body = match &setting.body {
            Some(body) => body.clone(),
            None => design.rough()?.body,
        };
        let alterations = setting.alterations.clone();
        Ok(design.at(OperatingPoint { body: Some(body), alterations, ..OperatingPoint::default() }))
    }

    /// Torque, blocks and what counts, before anything is known of the body.
    fn prepared(setting: Setting, working: Working<'a>, counting: Counting) -> Result<Self, ModelError> {
        let Working { recording, split, preparations } = working;
        let mut counts = counting.of_prepared(&recording, &preparations);
        let each = recording.trajectories.iter().zip(&preparations);
        let mut torque: Vec<Signals> =
            each.map(|(trajectory, preparation)| preparation.apply_all(&trajectory.tau)).collect();
        for (trajectory, moving) in counts.iter_mut().enumerate() {
            for (joint, counts) in moving.iter_mut().enumerate() {
                let stretches = split.train_of(joint).iter().filter(|segment| segment.trajectory == trajectory);
                let trains: Vec<_> =
                    stretches.map(|segment| preparations[trajectory].range(&segment.samples)).collect();
                for (sample, counts) in counts.iter_mut().enumerate() {
                    *counts &= trains.iter().any(|range| range.contains(&sample));
                }
                blank(&mut torque[trajectory][joint], counts);
            }
        }
        let blocks = cut_into_blocks(&joined(&split), &preparations);
        let loads = vec![None; recording.trajectories.len()];
        let point = OperatingPoint::default();
        let ways = (0..recording.joint_count()).map(|joint| recording.way(joint).into()).collect();
        let noise_correlation = noise_correlation(&recording, &preparations);
        let body = Arc::new([]);
        let mut design = Design {
            recording,
            setting,
            blocks,
            torque,
            counts,
            preparations,
            follows_up_to: None,
            ways,
            noise_correlation,
            point,
            loads,
            body,
            whitening: Whitening::default(),
        };
        design.body = design.columns_of_body()?;
        if (0..design.joint_count()).all(|joint| design.energy(joint) == 0.0) {
            return Err(ModelError::NothingToLearn(
                "the torque is zero, or no joint moves, in all training samples".to_owned(),
            ));
        }
        Ok(design)
    }

    /// The columns of a rigid body that is identified, prepared.
    fn columns_of_body(&self) -> Result<Arc<[PreparedColumn]>, ModelError> {
        let columns = self.prepare(|trajectory, _| Ok(RigidBody::Identified.columns(&self.setting, trajectory)))?;
        Ok(columns.into())
    }

    /// The same data, whitened; they must not be yet.
    ///
    /// # Errors
    /// [`ModelError`] if the columns of the rigid body can't be computed.
    pub fn whitened(&self, whitening: Whitening) -> Result<Design<'a>, ModelError> {
        let mut design = Design { whitening, ..self.clone() };
        for (torque, counts) in design.torque.iter_mut().zip(&self.counts) {
            for (joint, (values, counts)) in torque.iter_mut().zip(counts).enumerate() {
                design.whitening.apply(joint, values, counts);
            }
        }
        design.body = design.columns_of_body()?;
        Ok(design)
    }

    /// The same data at another point.
    pub fn at(&self, point: OperatingPoint) -> Design<'a> {
        let mut design = Design { point, ..self.clone() };
        let OperatingPoint { body, alterations, .. } = &design.point;
        // At first there is no load at all.
        let is_known = self.loads.iter().any(Option::is_some);
        if !is_known || *body != self.setting.body || *alterations != self.setting.alterations {
            (design.setting.body, design.setting.alterations) = (body.clone(), alterations.clone());
            design.loads =
                self.recording.trajectories.iter().map(|trajectory| design.setting.load(trajectory)).collect();
        }
        design
    }

    /// Whether the load differs from that at another point by a share that matters, on any joint.
    pub fn has_other_loads_than(&self, other: &Design) -> bool {
        let differ = |joint: usize| {
            let (mut change, mut size) = (0.0, 0.0);
            for (one, other) in self.loads.iter().zip(&other.loads) {
                let (Some(one), Some(other)) = (one, other) else { return true };
                for (one, other) in one.torque[joint].iter().zip(&other.torque[joint]) {
                    change += (one - other).powi(2);
                    size += other.powi(2);
                }
            }
            change > (SAME_LOAD * SAME_LOAD) * size
        };
        (0..self.joint_count()).any(differ)
    }

    /// The recording behind it, in a wide band and thinned out.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Prepared torque, by trajectory.
    pub(super) fn torque(&self) -> &[Signals] {
        &self.torque
    }

    /// What torque and columns of each trajectory pass through.
    pub fn preparations(&self) -> &[Preparation] {
        &self.preparations
    }

    /// Up to which frequency the torque follows the motion \[Hz\], where that is less far than the motion alone would have it.
    pub fn follows_up_to(&self) -> Option<f64> {
        self.follows_up_to
    }

    /// The stretches that are kept together in validation, in prepared samples.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// How many joints there are.
    pub fn joint_count(&self) -> usize {
        self.recording.joint_count()
    }

    /// What terms need to know of the recording, at this point.
    pub fn setting(&self) -> &Setting {
        &self.setting
    }

    /// Where columns are taken that depend on what else is in the torque.
    pub fn point(&self) -> &OperatingPoint {
        &self.point
    }

    /// The rigid body, identified beside the commonest friction and offsets so that these do not bias it much.
    fn rough(&self) -> Result<Rough, ModelError> {
        let joints = self.recording.joint_count();
        let mut columns = self.body.to_vec();
        let count = columns.len();
        columns.extend(self.prepare(|trajectory, _| {
            let motion = self.setting.motion(trajectory);
            let common = |joint: usize| {
                let qd = &trajectory.qd[joint];
                [
                    Column::on_joint(joint, qd.iter().map(|_| 1.0)),
                    Column::on_joint(joint, qd.iter().copied()),
                    Column::on_joint(joint, qd.iter().map(|&qd| motion.direction(joint, qd))),
                ]
            };
            Ok((0..joints).flat_map(common).collect())
        })?);
        let equations = self.equations(&columns, &self.torque);
        let mut weights: Vec<f64> = (0..joints).map(|joint| inverse(self.energy(joint))).collect();
        let rough = equations.total(&weights, |_| true).solve().factors;
        weights = self.residual_weights(&equations, &rough);
        let factors = equations.total(&weights, |_| true).solve().factors;
        let mut left = self.torque.clone();
        columns.iter().zip(&factors).for_each(|(column, factor)| column.add_to(&mut left, -factor));
        Ok(Rough { body: factors.iter().take(count).copied().collect(), left })
    }

    /// Σ τ² of a joint over the training samples that count.
    pub fn energy(&self, joint: usize) -> f64 {
        self.squares(&self.torque, joint)
    }

    /// Of torques along the recording of the design, by trajectory, prepared as its own: RMS over that of its own, by joint, where training
    /// samples count; NaN of a joint that never moves.
    pub fn shares_of(&self, torques: &[Signals]) -> Vec<f64> {
        let prepared = |(index, torque): (usize, &Signals)| {
            let mut prepared = self.preparations[index].apply_all(torque);
            (0..prepared.joint_count()).for_each(|joint| self.finish(&mut prepared[joint], index, joint));
            prepared
        };
        let prepared: Vec<Signals> = torques.iter().enumerate().map(prepared).collect();
        (0..self.joint_count()).map(|joint| (self.squares(&prepared, joint) / self.energy(joint)).sqrt()).collect()
    }

    /// The last of preparing what belongs to a joint: only samples that count are seen, and whitened.
    fn finish(&self, values: &mut [f64], trajectory: usize, joint: usize) {
        let counts = &self.counts[trajectory][joint];
        blank(values, counts);
        self.whitening.apply(joint, values, counts);
    }

    /// Sum of squares of a prepared torque in the training blocks.
    fn squares(&self, prepared: &[Signals], joint: usize) -> f64 {
        let of_block = |block: &Block| {
            prepared[block.trajectory][joint][block.samples.clone()].iter().map(|tau| tau * tau).sum::<f64>()
        };
        self.blocks.iter().map(of_block).sum()
    }

    /// How many training samples of a joint count.
    pub fn sample_count(&self, joint: usize) -> usize {
        let counting = |block: &Block| {
            self.counts[block.trajectory][joint][block.samples.clone()].iter().filter(|&&counts| counts).count()
        };
        self.blocks.iter().map(counting).sum()
    }

    /// Prepares columns that are computed for one trajectory at a time.
    ///
    /// # Errors
    /// Those of `columns`.
    pub fn prepare(
        &self,
        columns: impl Fn(&Trajectory, Option<&Load>) -> Result<Vec<Column>, ModelError>,
    ) -> Result<Vec<PreparedColumn>, ModelError> {
        let mut prepared: Vec<PreparedColumn> = Vec::new();
        for (index, trajectory) in self.recording.trajectories.iter().enumerate() {
            let columns = columns(trajectory, self.loads[index].as_ref())?;
            let signals: Vec<&[f64]> =
                columns.iter().flat_map(|column| &column.parts).map(|(_, values)| &values[..]).collect();
            let mut signals = self.preparations[index].apply_each(&signals).into_iter();
            for (number, column) in columns.iter().enumerate() {
                let joints = column.parts.iter().map(|(joint, _)| *joint);
                let parts = joints.zip(signals.by_ref()).map(|(joint, mut values)| {
                    self.finish(&mut values, index, joint);
                    (joint, values)
                });
                if prepared.len() <= number {
                    prepared.push(PreparedColumn { parts: vec![Vec::new(); index] });
                }
                prepared[number].parts.push(parts.collect());
            }
        }
        Ok(prepared)
    }

    /// The torque of terms that are known beforehand, prepared like the rest; `None` if there are none.
    pub(super) fn known_torque(&self, model: &Model) -> Option<Vec<Signals>> {
        let of_trajectory = |(index, trajectory): (usize, &Trajectory)| {
            let known = model.terms.iter().filter_map(|term| term.known_torque(&self.setting, trajectory));
            let torque = known.reduce(|mut sum, own| {
                sum.add(&own, 1.0);
                sum
            })?;
            let mut prepared = self.preparations[index].apply_all(&torque);
            prepared.iter_mut().enumerate().for_each(|(joint, values)| self.finish(values, index, joint));
            Some(prepared)
        };
        self.recording.trajectories.iter().enumerate().map(of_trajectory).collect()
    }

    /// Prepared torque less what the model knows beforehand.
    ///
    /// The column of an effect that changes others holds the change at the value found so far; what that value itself makes of it is
    /// in the columns of the others already, and is laid on top here.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn unexplained_torque(&self, model: &Model) -> Result<Vec<Signals>, ModelError> {
        let mut torque = self.torque.clone();
        if let Some(known) = self.known_torque(model) {
            torque.iter_mut().zip(&known).for_each(|(left, known)| left.add(known, -1.0));
        }
        for alteration in &self.setting.alterations {
            for change in self.prepare(|trajectory, load| {
                Ok(vec![alteration.term.change_of(&self.point.effects, &self.setting, trajectory, load)?])
            })? {
                change.add_to(&mut torque, alteration.linear[0]);
            }
        }
        Ok(torque)
    }

    /// Columns of an effect with these shape parameters, prepared.
    ///
    /// # Errors
    /// [`ModelError`] if the motion lacks what its formula needs.
    pub fn effect_columns(&self, term: &EffectTerm, shape: &[f64]) -> Result<Vec<PreparedColumn>, ModelError> {
        self.prepare(|trajectory, load| {
            let mut columns = term.columns(&self.setting, trajectory, load, shape)?;
            if term.effect.changes_others() {
                columns[0].add(&term.change_of(&self.point.effects, &self.setting, trajectory, load)?, 1.0);
            }
            Ok(columns)
        })
    }

    /// Columns of all terms of a model with these shape parameters, prepared.
    ///
    /// # Errors
    /// As [`Design::effect_columns`].
    pub fn columns(&self, model: &Model, shapes: &[Vec<f64>]) -> Result<Vec<PreparedColumn>, ModelError> {
        let mut columns = Vec::new();
        for (term, shape) in model.terms.iter().zip(shapes) {
            match term {
                Term::RigidBody(RigidBody::Stated(_)) | Term::Resistance(_) | Term::Learned(_) => {}
                Term::RigidBody(RigidBody::Identified) => columns.extend_from_slice(&self.body),
                Term::Effect(effect) => columns.extend(self.effect_columns(effect, shape)?),
            }
        }
        Ok(columns)
    }

    /// The normal equations of these columns against `torque` (prepared, by trajectory).
    pub fn equations(&self, columns: &[PreparedColumn], torque: &[Signals]) -> Equations {
        Equations::new(&self.blocks, self.joint_count(), columns, torque)
    }

    /// 1 / error variance of each joint with these factors of all columns.
    pub fn residual_weights(&self, equations: &Equations, factors: &DVector<f64>) -> Vec<f64> {
        let weight = |joint: usize| {
            let left: f64 =
                (0..equations.block_count()).map(|block| equations.residual_energy(block, joint, factors)).sum();
            let samples = self.sample_count(joint) as f64;
            // An exact fit has no error to weigh by: rounding would decide.
            let floor = 1e-20 * self.energy(joint);
            if samples == 0.0 { 0.0 } else { inverse(left.max(floor) / samples) }
        };
        (0..self.joint_count()).map(weight).collect()
    }

    /// The share of a joint's residual that is structure, from its ρ₁: what goes beyond the resemblance that the filter gives to white
    /// noise.
    pub fn structure(&self, joint: usize, correlation: f64) -> f64 {
        let of_noise = self.whitening.correlation(joint, self.noise_correlation);
        ((correlation - of_noise) / (1.0 - of_noise)).clamp(0.0, 1.0)
    }

    /// The way of the joint at which an effect acts; that of the first for one of the whole arm.
    pub fn way(&self, joint: Option<usize>) -> Way {
        self.ways.get(joint.unwrap_or(0)).copied().unwrap_or([f64::INFINITY, f64::NEG_INFINITY].into())
    }

    /// RMS speed of each block relative to the mean of all, so that slow and fast blocks can be told apart.
    pub fn block_speeds(&self) -> Vec<f64> {
        let joints = self.recording.joint_count();
        let speed = |block: &Block, joint: usize| {
            let preparation = &self.preparations[block.trajectory];
            let qd = &self.recording.trajectories[block.trajectory].qd[joint];
            let range = block.samples.start * preparation.every..(block.samples.end * preparation.every).min(qd.len());
            let cut = &qd[range];
            (cut.iter().map(|qd| qd * qd).sum::<f64>() / cut.len().max(1) as f64).sqrt()
        };
        let mut speeds = vec![0.0; self.blocks.len()];
        for joint in 0..joints {
            let of_joint: Vec<f64> = self.blocks.iter().map(|block| speed(block, joint)).collect();
            let mean = of_joint.iter().sum::<f64>() / of_joint.len() as f64;
            if mean > 0.0 {
                for (sum, value) in speeds.iter_mut().zip(&of_joint) {
                    *sum += value / mean / joints as f64;
                }
            }
        }
        speeds
    }
}

/// 1 / value; 0 for what is not there.
pub(super) fn inverse(value: f64) -> f64 {
    if value > 0.0 { 1.0 / value } else { 0.0 }
}

/// The training stretches; those of one trajectory that only faulty readings part are one. What lies between does not count.
fn joined(split: &Split) -> Vec<Segment> {
    let mut stretches: Vec<Segment> = Vec::new();
    for segment in split.train_of_any() {
        let is_held_out = |samples: Range<usize>| {
            let between = Segment { trajectory: segment.trajectory, samples };
            split.held_out.iter().any(|held| held.meets(&between))
        };
        match stretches.last_mut() {
            Some(last)
                if last.trajectory == segment.trajectory
                    && last.samples.end <= segment.samples.start
                    && !is_held_out(last.samples.end..segment.samples.start) =>
            {
                last.samples.end = segment.samples.end;
            }
            _ => stretches.push(segment),
        }
    }
    stretches
}

fn cut_into_blocks(train: &[Segment], preparations: &[Preparation]) -> Vec<Block> {
    let stretches = train.iter().map(|segment| Block {
        trajectory: segment.trajectory,
        samples: preparations[segment.trajectory].range(&segment.samples),
    });
    if train.len() >= FEWEST_BLOCKS {
        return stretches.collect();
    }
    let total: usize = stretches.clone().map(|stretch| stretch.samples.len()).sum();
    let mut blocks = Vec::new();
    for stretch in stretches {
        let length = stretch.samples.len();
        let pieces = ((TIME_BLOCKS * length) as f64 / total.max(1) as f64).round().max(1.0) as usize;
        for piece in 0..pieces {
            let cut = |part: usize| stretch.samples.start + length * part / pieces;
            blocks.push(Block { trajectory: stretch.trajectory, samples: cut(piece)..cut(piece + 1) });
        }
    }
    blocks
}

/// The mean over all samples that are kept.
fn noise_correlation(recording: &Recording, preparations: &[Preparation]) -> f64 {
    let kept = preparations.iter().zip(&recording.trajectories);
    let kept = kept.map(|(preparation, run)| (preparation, run.len() as f64 / preparation.every as f64));
    let (sum, count) = kept.fold((0.0, 0.0), |(sum, all), (preparation, count)| {
        (sum + count * preparation.noise_correlation(), all + count)
    });
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::sign;
    use crate::progress::Monitor;
    use crate::recording::torque::TorqueFacts;
    use crate::recording::{Channels, Joint, JointKind, Origin, Provenance};
    use crate::simulation::{Scenario, simulate};

    /// What the filter gives to white noise is none, what moves as one is all.
    #[test]
    fn structure_is_what_goes_beyond_the_filter() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let design = Design::new(&recording, &Split::automatic(&recording)).unwrap();
        let of_noise = design.noise_correlation;
        assert_eq!([-1.0, of_noise, 1.0].map(|correlation| design.structure(0, correlation)), [0.0, 0.0, 1.0]);
        assert!((design.structure(0, 0.5 * (1.0 + of_noise)) - 0.5).abs() < 1e-12);
    }

    /// The body of a clean log is the same, whitened or not, and what whitens a joint leaves the others.
    #[test]
    fn whitened_equations_have_the_same_answer() {
        let scenario = Scenario { effects: Vec::new(), torque_noise: 0.0, ..Scenario::embedded() };
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let plain = Design::new(&recording, &Split::automatic(&recording)).unwrap();
        let whitened = plain.whitened(Whitening::new(vec![0.9, 0.0, 0.5])).unwrap();
        let body = |design: &Design| {
            let equations = design.equations(&design.body, &design.torque);
            equations.total(&[1.0; 3], |_| true).solve().factors
        };
        let (expected, factors) = (body(&plain), body(&whitened));
        assert!((&factors - &expected).norm() < 1e-2 * expected.norm(), "{factors} {expected}");
        assert!(whitened.energy(0) < 0.1 * plain.energy(0) && whitened.energy(1) == plain.energy(1));
        assert!(whitened.structure(0, 0.0) > 0.1 && whitened.structure(1, 0.0) == plain.structure(1, 0.0));
    }

    /// Few stretches are cut into parts of about the same length in all, each sample once; many are blocks as they are.
    #[test]
    fn stretches_are_cut_into_blocks_without_a_gap() {
        let blocks = |stretches: &[Range<usize>], every: usize| {
            let segment = |samples: &Range<usize>| Segment { trajectory: 0, samples: samples.clone() };
            let train: Vec<Segment> = stretches.iter().map(segment).collect();
            cut_into_blocks(&train, &[Preparation { time_step: 0.01, cutoff: None, every }])
        };
        let [long, short] = [900, 300];
        let total = long + short;
        let found = blocks(&[0..long, long..total], 1);
        assert_eq!(found.len(), TIME_BLOCKS);
        assert_eq!((found[0].samples.start, found[found.len() - 1].samples.end), (0, total));
        assert!(found.windows(2).all(|pair| pair[0].samples.end == pair[1].samples.start));
        assert_eq!(found.iter().filter(|block| block.samples.end <= long).count(), TIME_BLOCKS * long / total);
        let largest = found.iter().map(|block| block.samples.len()).max().unwrap();
        assert!(found.iter().all(|block| block.samples.len() + 1 >= largest && block.trajectory == 0), "{largest}");
        // One that is short beside the others is a block all the same.
        assert_eq!(blocks(&[0..long, long..long + 1], 1).last().unwrap().samples, long..long + 1);
        // They count what is left of the samples.
        assert_eq!(blocks(std::slice::from_ref(&(0..long)), 3).last().unwrap().samples.end, long / 3);
        let many: Vec<Range<usize>> = (0..FEWEST_BLOCKS).map(|number| 10 * number..10 * number + 7).collect();
        let as_they_are: Vec<_> = blocks(&many, 1).into_iter().map(|block| block.samples).collect();
        assert_eq!(as_they_are, many);
        assert_eq!(blocks(&many[1..], 1).len(), 2 * (FEWEST_BLOCKS - 1), "each is cut in two");
    }

    /// A sliding mass with dry friction that rests between its strokes. At rest dry friction has no direction: a column that
    /// says otherwise leaks through the filter into the strokes, and biases the mass.
    #[test]
    fn the_rough_body_is_exact_where_the_motion_rests() {
        let time: Vec<f64> = (0..4000).map(|t| f64::from(t) * 0.005).collect();
        // Strokes of a second, rests of a second.
        let phase = |t: f64| (t % 2.0 < 1.0).then(|| std::f64::consts::TAU * (t % 1.0));
        let way = |t: f64| if t % 4.0 < 2.0 { 1.0 } else { -1.0 };
        let qd: Vec<f64> = time.iter().map(|&t| phase(t).map_or(0.0, |x| way(t) * (1.0 - x.cos()))).collect();
        let qdd: Vec<f64> =
            time.iter().map(|&t| phase(t).map_or(0.0, |x| way(t) * std::f64::consts::TAU * x.sin())).collect();
        let (mass, friction) = (3.0, 8.0);
        let tau: Vec<f64> = qd.iter().zip(&qdd).map(|(&qd, qdd)| mass * qdd + friction * sign(qd)).collect();
        let alone = |signal: Vec<f64>| Signals::from_joints([signal]).unwrap();
        let travel = |t: f64| {
            phase(t).map_or(0.0, |x| (x - x.sin()) / std::f64::consts::TAU) + if t % 2.0 < 1.0 { 0.0 } else { 1.0 }
        };
        let q: Vec<f64> = time.iter().map(|&t| if t % 4.0 < 2.0 { travel(t) } else { 1.0 - travel(t) }).collect();
        let channels = Channels { q: alone(q), qd: alone(qd), qdd: alone(qdd), tau: alone(tau), time };
        let run = Trajectory::new("strokes", channels).unwrap();
        let recording = Recording {
            name: String::new(),
            joints: vec![Joint { kind: JointKind::Prismatic, ..Joint::numbered(1) }],
            trajectories: vec![run],
            provenance: Provenance { velocity: Origin::Measured, acceleration: Origin::Measured, low_pass_hz: None },
            posture: None,
            stated_arm: None,
            chain: None,
            torque: TorqueFacts::default(),
            encoders: None,
            seal: None,
        };
        let segment = Segment { trajectory: 0, samples: 0..4000 };
        let design = Design::new(&recording, &Split { train: vec![segment], ..Split::default() }).unwrap();
        let body = design.point().body.as_ref().unwrap();
        assert!((body[0] - mass).abs() < 1e-9, "{body:?}");
    }

    /// A joint that is three times as fast in half of the runs, and another that never moves.
    #[test]
    fn blocks_are_slow_or_fast_beside_the_mean() {
        let run = |speed: f64| {
            let time: Vec<f64> = (0..200).map(|t| f64::from(t) * 0.01).collect();
            let rates = Signals::from_fn(2, 200, |joint, _| if joint == 0 { speed } else { 0.0 });
            let q = Signals::from_fn(2, 200, |joint, t| if joint == 0 { speed * time[t] } else { 0.0 });
            let tau = Signals::from_fn(2, 200, |joint, t| (t as f64 * 0.1).sin() + joint as f64);
            let channels = Channels { q, qd: rates, qdd: Signals::zeros(2, 200), tau, time };
            Trajectory::new("run", channels).unwrap()
        };
        let recording = Recording::of_runs((0..10).map(|number| run(if number < 5 { 1.0 } else { 3.0 })).collect());
        let split = Split { train: (0..10).map(|run| stretch(run, 0..200)).collect(), ..Split::default() };
        let design = Design::new(&recording, &split).unwrap();
        let speeds = design.block_speeds();
        assert_eq!(speeds.len(), 10);
        // The mean of the first joint is 2, and the second adds nothing.
        for (number, speed) in speeds.iter().enumerate() {
            let expected = if number < 5 { 0.25 } else { 0.75 };
            assert!((speed - expected).abs() < 1e-9, "{speeds:?}");
        }
        assert!(design.energy(0) > 50.0, "the torque of ten waves: {}", design.energy(0));
    }

    fn stretch(trajectory: usize, samples: Range<usize>) -> Segment {
        Segment { trajectory, samples }
    }

    /// What is at fault of one joint's torque is a gap for that joint, within a block that all joints share.
    #[test]
    fn a_joint_is_learned_from_where_another_one_is_at_fault() {
        let run = |_| {
            let time: Vec<f64> = (0..200).map(|t| f64::from(t) * 0.01).collect();
            let swing =
                |rate: fn(f64) -> f64| Signals::from_fn(2, 200, |joint, t| rate((2 + joint) as f64 * 0.01 * t as f64));
            let channels =
                Channels { q: swing(f64::sin), qd: swing(f64::cos), qdd: swing(f64::sin), tau: swing(f64::cos), time };
            Trajectory::new("run", channels).unwrap()
        };
        let recording = Recording::of_runs((0..10).map(run).collect());
        let whole: Vec<Segment> = (0..10).map(|run| stretch(run, 0..200)).collect();
        let mut clear = whole.clone();
        clear.splice(3..4, [stretch(3, 0..40), stretch(3, 120..200)]);
        let split = Split { train: clear.clone(), train_by_joint: vec![whole.clone(), clear], held_out: Vec::new() };
        let design = Design::new(&recording, &split).unwrap();
        let all = Design::new(&recording, &Split { train: whole, ..Split::default() }).unwrap();
        assert_eq!(design.blocks().len(), 10);
        assert_eq!(design.sample_count(0), all.sample_count(0));
        let lost = all.sample_count(1) - design.sample_count(1);
        assert!(lost > 0 && lost <= 80, "{lost}");
        assert_eq!(design.energy(0), all.energy(0));
    }
}
