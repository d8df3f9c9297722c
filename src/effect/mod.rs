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

mod coulomb_friction;
mod joint_spring;
mod rotor_inertia;
mod stribeck_friction;
mod tip_payload;
mod torque_offset;
mod viscous_friction;

use crate::arm::{Arm, Posture};
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

/// What an effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One joint's motion makes torque on that joint.
    Joint,
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
}

impl Dimension {
    /// The SI unit for a joint of this kind.
    pub fn unit(self, kind: JointKind) -> &'static str {
        use Dimension::{Damping, Inertia, Mass, Position, Stiffness, Torque, Velocity};
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

    /// The linear parameters.
    pub fn linear(&self) -> impl Iterator<Item = &'static ParameterSpec> {
        self.parameters.iter().filter(|parameter| matches!(parameter.role, Role::Linear))
    }

    /// The shape parameters with their start values.
    pub fn shapes(&self) -> impl Iterator<Item = (&'static ParameterSpec, &'static [f64])> {
        self.parameters.iter().filter_map(|parameter| match parameter.role {
            Role::Shape { grid } => Some((parameter, grid)),
            Role::Linear => None,
        })
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
    let spec = effect.spec();
    if parameters.len() != spec.parameters.len() {
        let reason = format!("it has {} parameters, {} were given", spec.parameters.len(), parameters.len());
        return Err(NotApplicable { effect: spec.name, reason });
    }
    let (linear, shape) = parameters.split_at(spec.linear().count());
    let mut torque = vec![vec![0.0; motion.trajectory.len()]; motion.trajectory.joint_count()];
    for (column, factor) in effect.columns(motion, joint, shape)?.iter().zip(linear) {
        for (on, values) in &column.parts {
            for (sum, value) in torque[*on].iter_mut().zip(values) {
                *sum += factor * value;
            }
        }
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
    }

    impl Sample {
        /// Positions, velocities (0 among them) and accelerations of either sign; they need not fit together.
        pub(crate) fn new() -> Self {
            let signal = |scale: f64, shift: f64| -> PerJoint {
                (0..3)
                    .map(|joint| (0..21).map(|t| scale * (t as f64 - 10.0 + shift + joint as f64)).collect())
                    .collect()
            };
            let time = (0..21).map(|t| 0.01 * t as f64).collect();
            let (q, qd, qdd) = (signal(0.13, 0.4), signal(0.21, 0.0), signal(-0.7, 0.3));
            let trajectory = Trajectory { name: String::new(), time, q, qd, qdd, tau: Vec::new() };
            Sample { arm: Arm::uniform(3), trajectory, kinds: vec![JointKind::Revolute; 3] }
        }

        pub(crate) fn motion(&self) -> Motion<'_> {
            Motion { trajectory: &self.trajectory, kinds: &self.kinds, posture: self.arm.posture, arm: Some(&self.arm) }
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
