//! Physical effects: one file each, all behind one trait, all in one [`registry`].
//!
//! The simulator, the models, the diagnosis, the lessons and the help text read the same file. To add an effect, copy
//! the file that is nearest to it and add one line to the registry.
//!
//! The torque of every effect has the form
//!
//! ```text
//! τ = Σₖ θₖ · φₖ(motion; shape)
//! ```
//!
//! with linear parameters θ (a friction torque, a stiffness) and shape parameters (a Stribeck velocity). An effect gives
//! the columns φ; whoever fits it solves for θ by least squares and searches the shape. A column is computed along a whole
//! trajectory, so effects with an inner state (hysteresis, lag) can simulate it.

pub mod registry;

mod actuator_lag;
mod asymmetric_friction;
mod backlash;
mod base_tilt;
mod bouc_wen_hysteresis;
mod cogging;
mod com_offset;
mod coulomb_friction;
mod dahl_hysteresis;
mod dead_zone;
mod derivative_delay;
mod end_stop;
mod friction_coupling;
mod friction_drift;
mod friction_warm_up;
mod hardening_spring;
mod inertia_coupling;
mod joint_elasticity;
mod joint_spring;
mod load_friction;
mod lugre_friction;
mod maxwell_slip;
mod offset_drift;
mod position_friction;
mod quadratic_drag;
mod rotor_inertia;
mod stribeck_friction;
mod stuck_channel;
mod tip_payload;
mod torque_coupling;
mod torque_gain;
mod torque_offset;
mod torque_saturation;
mod viscous_friction;

use std::fmt;
use std::sync::Arc;

use crate::arm::{Arm, Posture};
use crate::recording::differentiate::central_difference;
use crate::recording::fault::FaultKind;
use crate::recording::{JointKind, PerJoint, Trajectory};

/// A physical effect that adds to the joint torque.
pub trait Effect: Send + Sync {
    /// Everything about it that does not depend on data.
    fn spec(&self) -> &'static Spec;

    /// One column per linear parameter, in the order of the spec: the torque that the parameter's unit value causes.
    ///
    /// `joint` counts from 0 and is ignored by effects of the whole arm. `shape` holds the shape parameters in the order
    /// of the spec.
    ///
    /// # Errors
    /// [`NotApplicable`] if the motion lacks what the formula needs.
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, NotApplicable>;

    /// Whether it needs [`Motion::load`], which changes with the rigid body's parameters.
    fn depends_on_load(&self) -> bool {
        false
    }

    /// What it does in truth, for simulations, to the torque of the arm and of the effects before it in the registry. Most
    /// add their columns; a formula that is a first order acts as what it stands for.
    ///
    /// # Errors
    /// [`NotApplicable`] as [`Effect::columns`], and if there are too few or too many parameters.
    fn act(
        &self,
        motion: &Motion,
        joint: usize,
        parameters: &[f64],
        torque: &mut PerJoint,
    ) -> Result<(), NotApplicable> {
        let [linear, shape] = self.spec().parted(parameters)?;
        for (column, factor) in self.columns(motion, joint, shape)?.iter().zip(linear) {
            column.add_to(torque, *factor);
        }
        Ok(())
    }

    /// What becomes of the torque of the effects before it, on its joint, where it has these linear parameters. Nothing, for
    /// most.
    fn pass(&self, _torque: &mut Vec<f64>, _time: &[f64], _linear: &[f64]) {}

    /// Makes the motion that is read the true one, where it has these linear parameters. Most leave it as it is.
    fn set_right(&self, _motion: &mut Trajectory, _linear: &[f64]) {}

    /// What it does to the readings of all sensors, noise included. Nothing, for most.
    fn misread(&self, _reading: &mut Trajectory, _joint: usize, _parameters: &[f64]) {}

    /// The least values of the shape parameters that a motion through these positions of the joint (ascending) can show. Less
    /// than half a period of a wave over the position can't be told from a spring.
    fn least_shape(&self, positions: &[f64]) -> Vec<f64> {
        let range = positions.last().zip(positions.first()).map_or(0.0, |(last, first)| last - first);
        let least = |(parameter, _): (&ParameterSpec, _)| match parameter.dimension {
            Dimension::WaveNumber => parameter.min.max(std::f64::consts::PI / range.max(f64::MIN_POSITIVE)),
            _ => parameter.min,
        };
        self.spec().shapes().map(least).collect()
    }

    /// Whether its torque is not quite in proportion to its only linear parameter, so that the column is taken at the value
    /// found so far. `columns` then gets that value as the only entry of `shape`, and no entry before one was found.
    fn follows_its_parameter(&self) -> bool {
        false
    }

    /// Whether it, with these linear parameters, is no more than what the formula of another effect on the same joint leaves.
    fn is_left_by(&self, _own: &[f64], _other: &str, _others: &[f64]) -> bool {
        false
    }

    /// The fault of the torque readings that it is, if it is one. The readings show it by themselves, so it is found there
    /// and has no columns.
    fn fault(&self) -> Option<FaultKind> {
        None
    }
}

/// What an effect is told of the motion.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Position, velocity, acceleration; the torque in it is not to be read.
    pub trajectory: &'a Trajectory,
    /// What each joint does.
    pub kinds: &'a [JointKind],
    /// Where q = 0 points and which way q grows.
    pub posture: Posture,
    /// The arm's geometry, where it is known.
    pub arm: Option<&'a Arm>,
    /// What the rigid body needs, where it is known.
    pub load: Option<&'a Load>,
}

/// What the rigid body needs along one trajectory, for effects that depend on it: friction under load, errors of the torque
/// reading. It comes from a rigid body, never from the measured torque, or the effects would explain the torque by itself.
#[derive(Clone)]
pub struct Load {
    /// Torque of the rigid body \[N m\].
    pub torque: PerJoint,
    /// Derivative of its gravity torque by the zero angle of the posture \[N m/rad\].
    pub turned_gravity: PerJoint,
    /// Its lumped parameters, if it is a planar arm; see [`crate::arm::regressor`].
    pub lumped: Option<Vec<f64>>,
    /// Its torque \[N m\] along any other trajectory.
    pub body: Arc<dyn Fn(&Trajectory) -> PerJoint + Send + Sync>,
}

impl fmt::Debug for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Load").field("torque", &self.torque).finish_non_exhaustive()
    }
}

impl Load {
    /// The load of a known arm.
    pub fn of_arm(arm: &Arm, trajectory: &Trajectory) -> Load {
        let turned_gravity = arm.turned_gravity_along(&trajectory.q);
        let (arm, lumped) = (arm.clone(), arm.lumped_parameters());
        let body =
            move |trajectory: &Trajectory| arm.inverse_dynamics_along(&trajectory.q, &trajectory.qd, &trajectory.qdd);
        Load::by(body, turned_gravity, Some(lumped), trajectory)
    }

    /// The load of a rigid body that gives its torque along any trajectory.
    pub fn by(
        body: impl Fn(&Trajectory) -> PerJoint + Send + Sync + 'static,
        turned_gravity: PerJoint,
        lumped: Option<Vec<f64>>,
        trajectory: &Trajectory,
    ) -> Load {
        Load { torque: body(trajectory), turned_gravity, lumped, body: Arc::new(body) }
    }
}

impl Motion<'_> {
    /// The load, for the effect with this spec.
    fn load(&self, spec: &'static Spec) -> Result<&Load, NotApplicable> {
        let reason = "it needs the torque of a rigid body: choose the preset `rigid-body`".to_owned();
        self.load.ok_or(NotApplicable { effect: spec.name, reason })
    }

    /// A joint behind the one before it, for the effect of a pair with this spec.
    fn pair(&self, spec: &'static Spec, joint: usize) -> Result<[usize; 2], NotApplicable> {
        let reason = "it needs two neighbouring joints".to_owned();
        match joint.checked_sub(1) {
            Some(before) if joint < self.trajectory.joint_count() => Ok([before, joint]),
            _ => Err(NotApplicable { effect: spec.name, reason }),
        }
    }
}

/// Torque over one trajectory, only at the joints where it is not zero by construction.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Joint (from 0) and its torque, one value per sample.
    pub parts: Vec<(usize, Vec<f64>)>,
}

impl Column {
    /// A column that acts on one joint: `value` for each sample.
    pub fn on_joint(joint: usize, values: impl Iterator<Item = f64>) -> Self {
        Column { parts: vec![(joint, values.collect())] }
    }

    /// A column that acts on all joints.
    pub fn on_all(torque: PerJoint) -> Self {
        Column { parts: torque.into_iter().enumerate().collect() }
    }

    /// Adds `factor` times another column, on the joints where this one acts.
    pub fn add(&mut self, other: &Column, factor: f64) {
        for (joint, values) in &other.parts {
            if let Some((_, sums)) = self.parts.iter_mut().find(|(own, _)| own == joint) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += factor * value;
                }
            }
        }
    }

    /// Adds `factor` times the column to the torque of all joints.
    fn add_to(&self, torque: &mut PerJoint, factor: f64) {
        for (joint, values) in &self.parts {
            for (sum, value) in torque[*joint].iter_mut().zip(values) {
                *sum += factor * value;
            }
        }
    }
}

/// An effect can't be computed for this motion.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{effect} can't be computed: {reason}")]
pub struct NotApplicable {
    /// Name of the effect.
    pub effect: &'static str,
    /// What is lacking and how to give it.
    pub reason: String,
}

impl NotApplicable {
    /// The effect with this spec is a fault of the readings.
    fn in_readings(spec: &'static Spec) -> Self {
        let reason = "readings that show it are left out of every fit and every error, so there is nothing to add";
        NotApplicable { effect: spec.name, reason: reason.to_owned() }
    }
}

/// The data of an effect: its texts, parameters and bounds.
#[derive(Debug)]
pub struct Spec {
    /// Stable name for files and the command line, such as `coulomb-friction`.
    pub id: &'static str,
    /// Name for people, such as `Coulomb friction`.
    pub name: &'static str,
    /// Formula in plain text.
    pub formula: &'static str,
    /// Formula in TeX.
    pub typeset: &'static str,
    /// What it is and where it comes from, in a sentence or two.
    pub description: &'static str,
    /// What its residual looks like, and in which view.
    pub fingerprint: &'static str,
    /// What base parameters or a learned Lagrangian can absorb of it.
    pub absorbed: &'static str,
    /// What usual data can hardly tell from it, so that whoever names it must name these too.
    pub look_alikes: &'static [LookAlike],
    /// Where the formula stands.
    pub source: &'static str,
    /// One joint or the whole arm.
    pub scope: Scope,
    /// The state over which its residual shows best.
    pub axis: Axis,
    /// Linear parameters first, then shape parameters.
    pub parameters: &'static [ParameterSpec],
    /// Ids of effects whose columns this one contains, so that it replaces them.
    pub includes: &'static [&'static str],
}

/// Effects that together do nearly what another one does.
#[derive(Debug)]
pub struct LookAlike {
    /// Their ids; on the same joint.
    pub effects: &'static [&'static str],
    /// The data that tell, a sentence.
    pub told_by: &'static str,
}

/// What tells models of hysteresis from each other.
const PRE_SLIDING: &str = "Many small reversals, of less than the breakaway distance, at different speeds.";

/// What an effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One joint's motion makes torque on that joint.
    Joint,
    /// A joint and the one before it; the later one names the pair.
    Pair,
    /// The whole arm.
    Arm,
}

/// A state to draw a residual over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// t
    Time,
    /// q
    Position,
    /// q̇
    Velocity,
    /// q̈
    Acceleration,
}

/// One parameter of an effect.
#[derive(Debug)]
pub struct ParameterSpec {
    /// Name for files and tables, such as `coulomb_torque`.
    pub name: &'static str,
    /// Symbol for formulas and axes.
    pub symbol: &'static str,
    /// Its dimension; the unit depends on the joint's kind.
    pub dimension: Dimension,
    /// Smallest value that makes physical sense.
    pub min: f64,
    /// Largest value that makes physical sense.
    pub max: f64,
    /// How the parameter enters.
    pub role: Role,
}

/// How a parameter enters the torque.
#[derive(Debug)]
pub enum Role {
    /// As a factor of its column.
    Linear,
    /// In the shape of the columns; these values are tried first, then the best is refined.
    Shape {
        /// Start values, ascending.
        grid: &'static [f64],
    },
    /// As a measure of faulty readings, which is read off them.
    Reading,
}

/// Physical dimension of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Torque or force.
    Torque,
    /// Torque per velocity.
    Damping,
    /// Torque per position.
    Stiffness,
    /// Torque per acceleration.
    Inertia,
    /// Mass.
    Mass,
    /// Position.
    Position,
    /// Velocity.
    Velocity,
    /// Torque per velocity squared.
    QuadraticDamping,
    /// Torque per position cubed.
    CubicStiffness,
    /// Torque per time.
    TorqueRate,
    /// Radians of a wave per position.
    WaveNumber,
    /// Angle, whatever the joint does.
    Angle,
    /// Time.
    Time,
    /// Time squared.
    TimeSquared,
    /// A number without unit.
    Ratio,
}

impl Dimension {
    /// The SI unit for a joint of this kind.
    pub fn unit(self, kind: JointKind) -> &'static str {
        use Dimension::*;
        use JointKind::{Prismatic, Revolute};
        match (self, kind) {
            (Torque, Revolute) => "N m",
            (Torque, Prismatic) => "N",
            (Damping, Revolute) => "N m s/rad",
            (Damping, Prismatic) => "N s/m",
            (Stiffness, Revolute) => "N m/rad",
            (Stiffness, Prismatic) => "N/m",
            (Inertia, Revolute) => "kg m²",
            (Inertia, Prismatic) | (Mass, _) => "kg",
            (Position, Revolute) => "rad",
            (Position, Prismatic) => "m",
            (Velocity, Revolute) => "rad/s",
            (Velocity, Prismatic) => "m/s",
            (QuadraticDamping, Revolute) => "N m s²/rad²",
            (QuadraticDamping, Prismatic) => "N s²/m²",
            (CubicStiffness, Revolute) => "N m/rad³",
            (CubicStiffness, Prismatic) => "N/m³",
            (TorqueRate, Revolute) => "N m/s",
            (TorqueRate, Prismatic) => "N/s",
            (WaveNumber, Revolute) => "rad/rad",
            (WaveNumber, Prismatic) => "rad/m",
            (Angle, _) => "rad",
            (Time, _) => "s",
            (TimeSquared, _) => "s²",
            (Ratio, _) => "1",
        }
    }
}

/// The parameters of an effect are not what its spec asks for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// Too few or too many.
    #[error("{effect} takes the parameters {expected}, in this order; {given} were given")]
    Count {
        /// Name of the effect.
        effect: &'static str,
        /// Names of its parameters.
        expected: String,
        /// How many there were.
        given: usize,
    },
    /// One lies outside its bounds.
    #[error("{parameter} of {effect} is {value}, but must be a finite number between {min} and {max}")]
    Bounds {
        /// Name of the effect.
        effect: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Smallest that makes physical sense.
        min: f64,
        /// Largest that makes physical sense.
        max: f64,
    },
}

impl Spec {
    /// Whether each of the two alone does nearly what the other does.
    pub fn looks_like(&self, other: &Spec) -> bool {
        self.look_alikes.iter().any(|look_alike| look_alike.effects == [other.id])
    }

    /// Checks that these are as many parameters as the effect has, each within its bounds.
    ///
    /// # Errors
    /// [`ParameterError`] names the first that is not.
    pub fn check_parameters(&self, parameters: &[f64]) -> Result<(), ParameterError> {
        if parameters.len() != self.parameters.len() {
            let names: Vec<_> = self.parameters.iter().map(|parameter| parameter.name).collect();
            let expected = names.join(", ");
            return Err(ParameterError::Count { effect: self.name, expected, given: parameters.len() });
        }
        for (spec, &value) in self.parameters.iter().zip(parameters) {
            if !value.is_finite() || !(spec.min..=spec.max).contains(&value) {
                let ParameterSpec { name: parameter, min, max, .. } = *spec;
                return Err(ParameterError::Bounds { effect: self.name, parameter, value, min, max });
            }
        }
        Ok(())
    }

    /// Where the effect acts if it is to act on `joints` (from 0); `None` stands for the whole arm. For the pair of the
    /// first joint, which has none before it, its pair with the second is taken.
    pub fn places(&self, joints: impl IntoIterator<Item = usize>) -> Vec<Option<usize>> {
        let joints = joints.into_iter();
        match self.scope {
            Scope::Arm => vec![None],
            Scope::Joint => joints.map(Some).collect(),
            Scope::Pair => {
                let mut places: Vec<_> = joints.map(|joint| Some(joint.max(1))).collect();
                places.sort_unstable();
                places.dedup();
                places
            }
        }
    }

    /// The linear parameters.
    pub fn linear(&self) -> impl Iterator<Item = &'static ParameterSpec> {
        self.parameters.iter().filter(|parameter| matches!(parameter.role, Role::Linear))
    }

    /// The shape parameters with their start values.
    pub fn shapes(&self) -> impl Iterator<Item = (&'static ParameterSpec, &'static [f64])> {
        self.parameters.iter().filter_map(|parameter| match parameter.role {
            Role::Shape { grid } => Some((parameter, grid)),
            Role::Linear | Role::Reading => None,
        })
    }

    /// Linear and shape parameters among all.
    fn parted<'a>(&self, parameters: &'a [f64]) -> Result<[&'a [f64]; 2], NotApplicable> {
        if parameters.len() != self.parameters.len() {
            let reason = format!("it has {} parameters, {} were given", self.parameters.len(), parameters.len());
            return Err(NotApplicable { effect: self.name, reason });
        }
        let (linear, shape) = parameters.split_at(self.linear().count());
        Ok([linear, shape])
    }
}

/// The torque of an effect with given parameters (in the order of its spec): Σ θₖ φₖ, for all joints.
///
/// # Errors
/// [`NotApplicable`] as [`Effect::columns`], and if there are too few or too many parameters.
pub fn torque(
    effect: &dyn Effect,
    motion: &Motion,
    joint: usize,
    parameters: &[f64],
) -> Result<PerJoint, NotApplicable> {
    let [linear, shape] = effect.spec().parted(parameters)?;
    let mut torque = vec![vec![0.0; motion.trajectory.len()]; motion.trajectory.joint_count()];
    for (column, factor) in effect.columns(motion, joint, shape)?.iter().zip(linear) {
        column.add_to(&mut torque, *factor);
    }
    Ok(torque)
}

#[cfg(test)]
pub(crate) mod testing {
    //! A short motion of three joints to compute effects on, and the comparison with a formula.

    use super::*;

    pub(crate) struct Sample {
        pub(crate) arm: Arm,
        pub(crate) trajectory: Trajectory,
        pub(crate) kinds: Vec<JointKind>,
        load: Load,
    }

    /// A parabola in time that changes its sign.
    fn load(joint: usize, time: f64) -> f64 {
        40.0 * (time - 0.07) * (time - 0.15) + 0.03 * (joint as f64 - 1.0)
    }

    impl Sample {
        /// Positions, velocities (0 among them) and accelerations of either sign; they need not fit together.
        pub(crate) fn new() -> Self {
            let signal = |scale: f64, shift: f64| -> PerJoint {
                (0..3)
                    .map(|joint| (0..21).map(|t| scale * (t as f64 - 10.0 + shift + joint as f64)).collect())
                    .collect()
            };
            let time: Vec<f64> = (0..21).map(|t| 0.01 * t as f64).collect();
            let (q, qd, qdd) = (signal(0.13, 0.4), signal(0.21, 0.0), signal(-0.7, 0.3));
            let arm = Arm::uniform(3);
            let torque = (0..3).map(|joint| time.iter().map(|&time| load(joint, time)).collect()).collect();
            let turned_gravity = arm.turned_gravity_along(&q);
            let of_arm = arm.clone();
            let body = move |motion: &Trajectory| of_arm.inverse_dynamics_along(&motion.q, &motion.qd, &motion.qdd);
            let load = Load { torque, turned_gravity, lumped: Some(arm.lumped_parameters()), body: Arc::new(body) };
            let trajectory = Trajectory { name: String::new(), time, q, qd, qdd, tau: Vec::new() };
            Sample { arm, trajectory, kinds: vec![JointKind::Revolute; 3], load }
        }

        /// dτ/dt of the load.
        pub(crate) fn load_rate(&self, joint: usize) -> impl Iterator<Item = f64> {
            let slope = move |&time: &f64| (load(joint, time + 1e-3) - load(joint, time - 1e-3)) / 2e-3;
            self.trajectory.time.iter().map(slope)
        }

        pub(crate) fn motion(&self) -> Motion<'_> {
            Motion {
                trajectory: &self.trajectory,
                kinds: &self.kinds,
                posture: self.arm.posture,
                arm: Some(&self.arm),
                load: Some(&self.load),
            }
        }
    }

    /// Checks that on joint 1 (from 0) the torque is that of a formula of q, q̇, q̈, and that other joints feel nothing.
    pub(crate) fn assert_is(effect: &dyn Effect, parameters: &[f64], formula: impl Fn(f64, f64, f64) -> f64) {
        let sample = Sample::new();
        let torque = torque(effect, &sample.motion(), 1, parameters).unwrap();
        let Trajectory { q, qd, qdd, .. } = &sample.trajectory;
        for t in 0..sample.trajectory.len() {
            let expected = formula(q[1][t], qd[1][t], qdd[1][t]);
            assert!((torque[1][t] - expected).abs() < 1e-12, "{} is not {expected}", torque[1][t]);
        }
        assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
    }

    /// The same for a formula of the load, q and q̇; without a load the effect must say what it lacks.
    pub(crate) fn assert_depends_on_load(
        effect: &dyn Effect,
        parameters: &[f64],
        formula: impl Fn(f64, f64, f64) -> f64,
    ) {
        let sample = Sample::new();
        let torque = torque(effect, &sample.motion(), 1, parameters).unwrap();
        let Trajectory { q, qd, time, .. } = &sample.trajectory;
        for t in 0..sample.trajectory.len() {
            let expected = formula(load(1, time[t]), q[1][t], qd[1][t]);
            assert!((torque[1][t] - expected).abs() < 1e-12, "{} is not {expected}", torque[1][t]);
        }
        assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
        let lacking = effect.columns(&Motion { load: None, ..sample.motion() }, 1, &[]).unwrap_err().to_string();
        assert!(lacking.contains("rigid body"), "{lacking}");
    }
}

#[cfg(test)]
mod tests {
    use super::testing::Sample;
    use super::*;

    #[test]
    fn parameters_are_counted_and_kept_in_bounds() {
        let spec = registry::find("stribeck-friction").unwrap().spec();
        assert_eq!(spec.check_parameters(&[1.0, 0.5, 0.1]), Ok(()));
        assert_eq!(
            spec.check_parameters(&[1.0]).unwrap_err().to_string(),
            "Stribeck friction takes the parameters coulomb_torque, stribeck_torque, stribeck_velocity, in this order; 1 were \
             given"
        );
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let message = spec.check_parameters(&[1.0, wrong, 0.1]).unwrap_err().to_string();
            assert!(message.starts_with("stribeck_torque of Stribeck friction is"), "{message}");
        }
        let sample = Sample::new();
        let effect = registry::find("viscous-friction").unwrap();
        assert!(torque(effect, &sample.motion(), 0, &[]).unwrap_err().to_string().contains("1 parameters, 0 were"));
    }

    #[test]
    fn units_follow_the_kind_of_joint() {
        assert_eq!(Dimension::Stiffness.unit(JointKind::Revolute), "N m/rad");
        assert_eq!(Dimension::Stiffness.unit(JointKind::Prismatic), "N/m");
        assert_eq!(Dimension::Mass.unit(JointKind::Revolute), "kg");
    }
}
