//! What each term contributes: a torque that is known beforehand, and columns whose factors are to be identified.

use std::borrow::Cow;
use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::least_squares::dot;
use super::{EffectTerm, Model, ModelError, RigidBody, Term};
use crate::arm::chain::{Chain, PER_LINK};
use crate::arm::stated::{Resistance, StatedArm};
use crate::arm::{Arm, GRAVITY, MOST_JOINTS, Posture, regressor};
use crate::effect::{Column, Load, Motion, ParameterSpec};
use crate::recording::{JointKind, Recording, Trajectory};
use crate::signals::Signals;

/// So many samples of a trajectory are one core's work.
const STRETCH: usize = 1 << 14;

/// What a parameter of the rigid body does to a joint counts from this share of the largest element of the regressor on. Less than that
/// is left of axes at nearly right angles (1.5708 in a robot's file), and would need masses of tons to be felt; a fit would give
/// them.
const LEAST_SEEN: f64 = 1e-7;

/// What terms need to know of the recording beside the motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// What each joint does.
    pub kinds: Vec<JointKind>,
    /// Where q = 0 points; right if the recording does not say.
    pub posture: Posture,
    /// The stated arm.
    pub arm: Option<Arm>,
    /// Where the axes of an arm are that is not planar.
    #[serde(default)]
    pub chain: Option<Chain>,
    /// What is stated to resist each joint; empty where nothing is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resistances: Vec<Resistance>,
    /// Whether gravity was taken out of the torque; arm and chain are without weight then.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weightless: bool,
    /// Factors of the identified rigid body, roughly: from them comes the load of effects that depend on it.
    #[serde(default)]
    pub body: Option<Vec<f64>>,
    /// Effects of the model that change what the others do (a lag comes between friction and its reading), roughly.
    #[serde(default)]
    pub alterations: Vec<Alteration>,
    /// The speed \[rad/s or m/s\] within which each joint's dry friction turns round; 0 or none where it jumps.
    #[serde(default)]
    pub reversal_widths: Vec<f64>,
}

/// An effect that changes what the effects before it do, with its linear parameters as they were found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alteration {
    /// The effect.
    pub term: EffectTerm,
    /// Its linear parameters, within their bounds.
    pub linear: Vec<f64>,
}

/// An effect with its parameters as they were found beside others.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The effect.
    pub term: EffectTerm,
    /// Its linear parameters.
    pub linear: Vec<f64>,
    /// Its shape parameters.
    pub shape: Vec<f64>,
}

/// What a search has found so far, roughly: the rigid body, and the effects beside it. Columns that depend on it (friction under
/// load, friction that passes a lag) are taken here.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OperatingPoint {
    /// Factors of the rigid body, from which comes the load; `None` stands for the stated arm.
    pub body: Option<Vec<f64>>,
    /// The effects that are in the torque: they pass through those that change what others do.
    pub effects: Vec<Found>,
    /// Those of them that change what others do, with their parameters within the bounds.
    pub alterations: Vec<Alteration>,
}

impl OperatingPoint {
    /// With this rigid body and these effects.
    pub fn new(body: Option<Vec<f64>>, effects: Vec<Found>) -> Self {
        let alterations = effects.iter().filter_map(Alteration::of).collect();
        OperatingPoint { body, effects, alterations }
    }
}

/// Alterations that differ by a smaller share are the same.
const SAME_ALTERATION: f64 = 0.01;

impl Alteration {
    /// The effect as it was found, if it is one that changes others.
    fn of(found: &Found) -> Option<Alteration> {
        let Found { term, linear, .. } = found;
        if !term.effect.changes_others() {
            return None;
        }
        let bounded = |(parameter, value): (&ParameterSpec, &f64)| parameter.bounded(*value);
        Some(Alteration { term: term.clone(), linear: term.effect.linear().zip(linear).map(bounded).collect() })
    }

    /// Whether both hardly differ.
    fn is_like(&self, other: &Alteration) -> bool {
        let close = |(one, two): (&f64, &f64)| (one - two).abs() <= SAME_ALTERATION * one.abs().max(two.abs());
        self.term == other.term && self.linear.iter().zip(&other.linear).all(close)
    }

    /// Whether both lists have the same effects, with parameters that hardly differ.
    pub(crate) fn are_alike(these: &[Alteration], those: &[Alteration]) -> bool {
        these.len() == those.len() && these.iter().all(|one| those.iter().any(|other| one.is_like(other)))
    }
}

impl Setting {
    /// The setting of a recording.
    ///
    /// # Errors
    /// [`ModelError`] if no planar rigid body fits the recording.
    pub fn of(recording: &Recording) -> Result<Setting, ModelError> {
        let joints = recording.joint_count();
        let kinds: Vec<JointKind> = recording.joints.iter().map(|joint| joint.kind).collect();
        if !(1..=MOST_JOINTS).contains(&joints) {
            return Err(ModelError::JointCount { joints });
        }
        if joints > 1 && kinds.contains(&JointKind::Prismatic) && recording.spatial().is_none() {
            return Err(ModelError::Prismatic { joints });
        }
        if let Some(arm) = &recording.stated_arm
            && arm.joint_count() != joints
        {
            return Err(ModelError::OtherArm { arm: arm.joint_count(), recording: joints });
        }
        let posture = recording.assumed_posture();
        Ok(Setting {
            kinds,
            posture,
            arm: recording.arm_in_torque(),
            chain: recording.chain_in_torque(),
            resistances: recording.chain.as_ref().map(Chain::resistances).unwrap_or_default(),
            weightless: recording.is_weightless(),
            body: None,
            alterations: Vec::new(),
            reversal_widths: Vec::new(),
        })
    }

    /// The arm of which it is stated what its links weigh: about its axes where these are stated, else planar.
    pub fn stated_arm(&self) -> Option<StatedArm> {
        match &self.chain {
            Some(chain) => chain.states_links().then(|| StatedArm::Spatial(chain.clone())),
            None => self.arm.clone().map(StatedArm::Planar),
        }
    }

    /// Gravity in the torque \[m/s²\]: of the stated arm, or the standard, unless it was taken out.
    pub fn gravity(&self) -> f64 {
        let standard = if self.weightless { 0.0 } else { GRAVITY };
        self.arm.as_ref().map_or(standard, |arm| arm.gravity)
    }

    /// What an effect is told.
    pub fn motion<'a>(&'a self, trajectory: &'a Trajectory) -> Motion<'a> {
        Motion {
            trajectory,
            kinds: &self.kinds,
            posture: self.posture,
            gravity: self.gravity(),
            arm: self.arm.as_ref(),
            chain: self.chain.as_ref(),
            load: None,
            reversal_widths: &self.reversal_widths,
        }
    }

    /// What the rigid body needs along a trajectory that is read: by its rough factors, or by the stated arm if there are none.
    pub fn load(&self, trajectory: &Trajectory) -> Option<Load> {
        let trajectory = &self.true_motion(trajectory, |_| true);
        if let Some(factors) = &self.body {
            return Some(self.load_by(factors, trajectory));
        }
        let arm = Arm { posture: self.posture, ..self.arm.clone()? };
        Some(Load::of_arm(&arm, trajectory))
    }

    /// The motion that is read, without what those alterations do to it that `count`.
    fn true_motion<'a>(&self, read: &'a Trajectory, count: impl Fn(&Alteration) -> bool) -> Cow<'a, Trajectory> {
        let mut motion = Cow::Borrowed(read);
        for alteration in self.alterations.iter().filter(|one| one.term.joint.is_none() && count(one)) {
            alteration.term.effect.set_right(motion.to_mut(), &alteration.linear);
        }
        motion
    }

    fn load_by(&self, factors: &[f64], trajectory: &Trajectory) -> Load {
        let is_planar = self.chain.is_none() && !self.kinds.contains(&JointKind::Prismatic);
        let lumped = is_planar.then(|| factors.to_vec());
        let factors = factors.to_vec();
        let sum = move |setting: &Setting, trajectory: &Trajectory| identified_torque(setting, trajectory, &factors);
        let mut still = trajectory.clone();
        let run = still.channels_mut();
        for mut signal in [run.qd, run.qdd] {
            signal.values_mut().fill(0.0);
        }
        let zero_angle = self.posture.zero_angle + std::f64::consts::FRAC_PI_2;
        let chain = self.chain.as_ref().map(Chain::turned);
        let turned = Setting { posture: Posture { zero_angle, ..self.posture }, chain, ..self.clone() };
        let (own, turned_gravity) = (self.clone(), sum(&turned, &still));
        Load::by(move |trajectory| sum(&own, trajectory), turned_gravity, lumped, trajectory)
    }
}

/// Name and unit of one identified factor, and the joint it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// Index of its term.
    pub term: usize,
    /// Name for files and tables.
    pub name: String,
    /// Symbol for formulas.
    pub symbol: String,
    /// The joint (from 0) it belongs to, if to one.
    pub joint: Option<usize>,
    /// SI unit.
    pub unit: &'static str,
    /// Smallest and largest value that makes physical sense.
    pub bounds: [f64; 2],
}

impl RigidBody {
    /// Factors of the identified body; none for a stated one.
    pub(super) fn factors(&self, term: usize, setting: &Setting) -> Vec<Factor> {
        if matches!(self, RigidBody::Stated(_)) {
            return Vec::new();
        }
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        if let Some(chain) = &setting.chain {
            let named = chain.parameter_names().into_iter().enumerate();
            return named
                .map(|(index, name)| {
                    let unit = Chain::parameter_unit(index);
                    Factor { term, symbol: name.clone(), name, joint: None, unit, bounds: free }
                })
                .collect();
        }
        if setting.kinds == [JointKind::Prismatic] {
            let name = "M1".to_owned();
            return vec![Factor { term, symbol: name.clone(), name, joint: None, unit: "kg", bounds: free }];
        }
        let joints = setting.kinds.len();
        let named = regressor::parameter_names(joints).into_iter().enumerate();
        named
            .map(|(index, name)| {
                let unit = regressor::parameter_unit(joints, index);
                Factor { term, symbol: name.clone(), name, joint: None, unit, bounds: free }
            })
            .collect()
    }

    /// Columns of the identified body; none for a stated one.
    pub(super) fn columns(&self, setting: &Setting, trajectory: &Trajectory) -> Vec<Column> {
        match self {
            RigidBody::Stated(_) => Vec::new(),
            RigidBody::Identified if let Some(chain) = &setting.chain => chain_columns(chain, setting, trajectory),
            RigidBody::Identified if setting.kinds == [JointKind::Prismatic] => {
                vec![Column::on_joint(0, trajectory.qdd[0].iter().copied())]
            }
            RigidBody::Identified => regressor_columns(setting, trajectory),
        }
    }

    /// Torque that is known beforehand.
    pub(super) fn known_torque(&self, setting: &Setting, trajectory: &Trajectory) -> Option<Signals> {
        match self {
            RigidBody::Identified => None,
            RigidBody::Stated(StatedArm::Planar(arm)) => {
                let arm = Arm { posture: setting.posture, ..arm.clone() };
                Some(arm.inverse_dynamics_along(&trajectory.q, &trajectory.qd, &trajectory.qdd))
            }
            RigidBody::Stated(StatedArm::Spatial(chain)) => {
                let stated = Setting { chain: Some(chain.clone()), ..setting.clone() };
                Some(identified_torque(&stated, trajectory, &chain.stated_parameters()))
            }
        }
    }
}

impl Term {
    /// Torque that is known beforehand, of terms that have such.
    pub(super) fn known_torque(&self, setting: &Setting, trajectory: &Trajectory) -> Option<Signals> {
        match self {
            Term::RigidBody(body) => body.known_torque(setting, trajectory),
            Term::Resistance(joints) => {
                let motion = setting.motion(trajectory);
                Some(Signals::from_fn(joints.len(), trajectory.len(), |joint, sample| {
                    let state = [&trajectory.q, &trajectory.qd, &trajectory.qdd].map(|channel| channel[joint][sample]);
                    joints[joint].torque(state, motion.direction(joint, state[1]))
                }))
            }
            Term::Effect(_) | Term::Learned(_) => None,
        }
    }
}

/// Torque of the identified rigid body with these factors: its columns times them, without the columns in between.
pub(super) fn identified_torque(setting: &Setting, trajectory: &Trajectory, factors: &[f64]) -> Signals {
    let in_stretch = |number: usize| torque_in(setting, trajectory, stretch(number, trajectory.len()), factors);
    let stretches = trajectory.len().div_ceil(STRETCH).max(1);
    let parts: Vec<Signals> = (0..stretches).into_par_iter().map(in_stretch).collect();
    Signals::joined(&parts).unwrap_or_else(|error| panic!("stretches of one trajectory differ: {error}"))
}

/// The stretch of this number of so many samples.
fn stretch(number: usize, samples: usize) -> Range<usize> {
    let start = number * STRETCH;
    start..(start + STRETCH).min(samples)
}

/// The torque of the identified rigid body in a stretch of the trajectory.
fn torque_in(setting: &Setting, trajectory: &Trajectory, samples: Range<usize>, factors: &[f64]) -> Signals {
    let joints = trajectory.joint_count();
    let mut torque = Signals::zeros(joints, samples.len());
    if let Some(chain) = &setting.chain {
        let regressor = chain.regressor(&sliding(setting));
        along(trajectory, samples, |sample, q, qd, qdd| {
            let mut now = [0.0; MOST_JOINTS];
            regressor.torque(q, qd, qdd, factors, &mut now);
            (0..joints).for_each(|joint| torque[joint][sample] = now[joint]);
        });
    } else if setting.kinds == [JointKind::Prismatic] {
        let mass = factors[0];
        torque[0].iter_mut().zip(&trajectory.qdd[0][samples]).for_each(|(tau, qdd)| *tau = mass * qdd);
    } else {
        let width = regressor::parameter_count(joints);
        let mut rows = vec![0.0; joints * width];
        along(trajectory, samples, |sample, q, qd, qdd| {
            regressor::fill(setting.posture, setting.gravity(), q, qd, qdd, &mut rows);
            for (joint, row) in rows.chunks_exact(width).enumerate() {
                torque[joint][sample] = dot(row, factors);
            }
        });
    }
    torque
}

/// Which joints slide.
fn sliding(setting: &Setting) -> Vec<bool> {
    setting.kinds.iter().map(|kind| *kind == JointKind::Prismatic).collect()
}

/// Each of these samples of a trajectory, counted from the first of them, with q, q̇ and q̈ of all joints side by side.
fn along(trajectory: &Trajectory, samples: Range<usize>, mut at: impl FnMut(usize, &[f64], &[f64], &[f64])) {
    let joints = trajectory.joint_count();
    let mut state = [[0.0; MOST_JOINTS]; 3];
    for (number, sample) in samples.enumerate() {
        for (state, signal) in state.iter_mut().zip([&trajectory.q, &trajectory.qd, &trajectory.qdd]) {
            state.iter_mut().zip(signal.at(sample)).for_each(|(place, value)| *place = value);
        }
        let [q, qd, qdd] = &state;
        at(number, &q[..joints], &qd[..joints], &qdd[..joints]);
    }
}

/// The regressor of the planar arm.
fn regressor_columns(setting: &Setting, trajectory: &Trajectory) -> Vec<Column> {
    let width = regressor::parameter_count(trajectory.joint_count());
    columns_along(trajectory, width, |q, qd, qdd, rows| {
        regressor::fill(setting.posture, setting.gravity(), q, qd, qdd, rows);
    })
}

/// The regressor of an arm in space.
fn chain_columns(chain: &Chain, setting: &Setting, trajectory: &Trajectory) -> Vec<Column> {
    let regressor = chain.regressor(&sliding(setting));
    let width = PER_LINK * trajectory.joint_count();
    columns_along(trajectory, width, |q, qd, qdd, rows| regressor.fill(q, qd, qdd, rows))
}

/// A regressor of `width` parameters along a trajectory, one column each, without the rows that are zero by construction, or as good
/// as that.
fn columns_along(
    trajectory: &Trajectory,
    width: usize,
    fill: impl Fn(&[f64], &[f64], &[f64], &mut [f64]) + Sync,
) -> Vec<Column> {
    let joints = trajectory.joint_count();
    let samples = trajectory.len();
    let mut values = vec![vec![0.0; samples]; joints * width];
    let mut stretches: Vec<Vec<&mut [f64]>> = Vec::new();
    for element in &mut values {
        stretches.resize_with(samples.div_ceil(STRETCH), Vec::new);
        stretches.iter_mut().zip(element.chunks_mut(STRETCH)).for_each(|(stretch, part)| stretch.push(part));
    }
    stretches.into_par_iter().enumerate().for_each(|(number, mut elements)| {
        let mut rows = vec![0.0; joints * width];
        along(trajectory, stretch(number, samples), |sample, q, qd, qdd| {
            fill(q, qd, qdd, &mut rows);
            elements.iter_mut().zip(&rows).for_each(|(element, row)| element[sample] = *row);
        });
    });
    let mut columns: Vec<Column> = (0..width).map(|_| Column { parts: Vec::new() }).collect();
    let largest = |element: &Vec<f64>| element.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let sizes: Vec<f64> = values.par_iter().map(largest).collect();
    let least = LEAST_SEEN * sizes.iter().copied().fold(0.0, f64::max);
    for (index, (element, size)) in values.into_iter().zip(sizes).enumerate() {
        if size > least {
            columns[index % width].parts.push((index / width, element));
        }
    }
    columns
}

impl EffectTerm {
    /// Factors of the effect: its linear parameters.
    pub(super) fn factors(&self, term: usize, setting: &Setting) -> Vec<Factor> {
        let kind = setting.kinds[self.joint.unwrap_or(0)];
        let factor = |parameter: &ParameterSpec| Factor {
            term,
            name: parameter.name.to_owned(),
            symbol: parameter.symbol.to_owned(),
            joint: self.joint,
            unit: parameter.dimension.unit(kind),
            bounds: [parameter.min, parameter.max],
        };
        self.effect.linear().map(factor).collect()
    }

    /// Columns of the effect for these shape parameters, as the setting's alterations leave them.
    ///
    /// # Errors
    /// [`ModelError`] if the motion lacks what its formula needs.
    pub(crate) fn columns(
        &self,
        setting: &Setting,
        trajectory: &Trajectory,
        load: Option<&Load>,
        shape: &[f64],
    ) -> Result<Vec<Column>, ModelError> {
        let is_altered_by = |other: &Alteration| other.term.alters(self);
        let true_motion = setting.true_motion(trajectory, is_altered_by);
        let motion = Motion { load, ..setting.motion(&true_motion) };
        let mut columns = self.effect.columns(&motion, self.joint.unwrap_or(0), shape)?;
        for alteration in setting.alterations.iter().filter(|other| is_altered_by(other)) {
            for (joint, values) in columns.iter_mut().flat_map(|column| &mut column.parts) {
                if alteration.term.joint == Some(*joint) {
                    alteration.term.effect.pass(values, &trajectory.time, &alteration.linear);
                }
            }
        }
        Ok(columns)
    }

    /// Whether this effect, if it is one that changes others, changes that one.
    fn alters(&self, other: &EffectTerm) -> bool {
        let meets = self.joint.is_none() || other.joint.is_none() || self.joint == other.joint;
        meets && self.effect.acts_after(other.effect)
    }

    /// What a bit more of the parameter of this effect, if it is one that changes others, does to the torque of the effects that
    /// were `found`, per unit of the parameter. With it in the column, the parameter follows from all torque that passes the
    /// effect, not from the rigid body's alone.
    pub(super) fn change_of(
        &self,
        found: &[Found],
        setting: &Setting,
        trajectory: &Trajectory,
        load: Option<&Load>,
    ) -> Result<Column, ModelError> {
        let mut change = Column::on_all(Signals::zeros(trajectory.joint_count(), trajectory.len()));
        if let Some(joint) = self.joint {
            change.parts.retain(|(acting, _)| *acting == joint);
        }
        // From one sample ahead to one behind.
        let step = trajectory.time_step();
        let is_own = |alteration: &Alteration| alteration.term == *self;
        let now = setting.alterations.iter().find(|alteration| is_own(alteration)).map_or(0.0, |own| own.linear[0]);
        for (moved, share) in [(step, 0.5 / step), (-step, -0.5 / step)] {
            let mut altered = setting.clone();
            altered.alterations.retain(|alteration| !is_own(alteration));
            altered.alterations.push(Alteration { term: self.clone(), linear: vec![now + moved] });
            for Found { term, linear, shape } in found.iter().filter(|found| self.alters(&found.term)) {
                let others = term.columns(&altered, trajectory, load, shape)?;
                for (other, factor) in others.iter().zip(linear) {
                    change.add(other, share * factor);
                }
            }
        }
        Ok(change)
    }
}

impl Model {
    /// Factors of all terms, in the order of their columns.
    ///
    /// # Errors
    /// [`ModelError`] if a term does not fit the recording.
    pub fn factors(&self, setting: &Setting) -> Result<Vec<Factor>, ModelError> {
        let mut factors = Vec::new();
        for (index, term) in self.terms.iter().enumerate() {
            match term {
                Term::RigidBody(body) => factors.extend(body.factors(index, setting)),
                Term::Resistance(_) | Term::Learned(_) => {}
                Term::Effect(effect) => {
                    let joints = setting.kinds.len();
                    if let Some(joint) = effect.joint.filter(|&joint| joint >= joints) {
                        let effect = effect.effect.name;
                        return Err(ModelError::NoSuchJoint { effect, joint: joint + 1, joints });
                    }
                    factors.extend(effect.factors(index, setting));
                }
            }
        }
        Ok(factors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::effect::registry;

    /// An alteration is the same while its parameters hardly move, whatever the order of the list.
    #[test]
    fn alterations_that_hardly_differ_are_alike() {
        let of = |id: &str, joint, value: f64| Alteration {
            term: EffectTerm { effect: registry::find(id).unwrap(), joint },
            linear: vec![value],
        };
        let lag = |value| of("actuator-lag", Some(0), value);
        assert!(lag(1.0).is_like(&lag(1.0 + 0.9 * SAME_ALTERATION)));
        assert!(!lag(1.0).is_like(&lag(1.0 + 1.1 * SAME_ALTERATION)));
        assert!(!lag(1.0).is_like(&of("actuator-lag", Some(1), 1.0)), "it is on another joint");
        let both = [lag(1.0), of("actuator-lag", Some(1), 2.0)];
        let turned = [both[1].clone(), both[0].clone()];
        assert!(Alteration::are_alike(&both, &turned) && !Alteration::are_alike(&both, &both[..1]));
        assert!(!Alteration::are_alike(&both, &[lag(1.0), lag(2.0)]));
    }
}
