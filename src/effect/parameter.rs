//! The parameters of an effect: names, dimensions, bounds, and how each enters the torque.

use crate::recording::JointKind;

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
        /// The least value that a motion through these positions of the joint (ascending) can show.
        least_shown: fn(&[f64]) -> f64,
    },
    /// As a measure of faulty readings, which is read off them.
    Reading,
}

impl ParameterSpec {
    /// A factor of a column, of either sign unless bounds are added.
    pub const fn linear(name: &'static str, symbol: &'static str, dimension: Dimension) -> Self {
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        ParameterSpec { name, symbol, dimension, min, max, role: Role::Linear }
    }

    /// A positive shape parameter with the values that are tried first (ascending); any motion can show it.
    pub const fn shape(name: &'static str, symbol: &'static str, dimension: Dimension, grid: &'static [f64]) -> Self {
        let role = Role::Shape { grid, least_shown: any_motion };
        ParameterSpec { name, symbol, dimension, min: 0.0, max: f64::INFINITY, role }
    }

    /// A measure of faulty readings, not negative.
    pub const fn reading(name: &'static str, symbol: &'static str, dimension: Dimension) -> Self {
        ParameterSpec { name, symbol, dimension, min: 0.0, max: f64::INFINITY, role: Role::Reading }
    }

    /// With the smallest value that makes physical sense.
    pub const fn at_least(self, min: f64) -> Self {
        ParameterSpec { min, ..self }
    }

    /// With the smallest and the largest value that make physical sense.
    pub const fn between(self, min: f64, max: f64) -> Self {
        ParameterSpec { min, max, ..self }
    }

    /// With the least value of a shape that a motion through given positions of the joint (ascending) can show.
    pub const fn shown_from(self, least_shown: fn(&[f64]) -> f64) -> Self {
        let role = match self.role {
            Role::Shape { grid, .. } => Role::Shape { grid, least_shown },
            other => other,
        };
        ParameterSpec { role, ..self }
    }

    /// Whether the value lies within the bounds.
    pub fn admits(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

fn any_motion(_positions: &[f64]) -> f64 {
    0.0
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
    /// Anything else, by its unit, whatever the joint does.
    Stated(&'static str),
}

/// All dimensions that have a name.
const NAMED: [Dimension; 15] = [
    Dimension::Torque,
    Dimension::Damping,
    Dimension::Stiffness,
    Dimension::Inertia,
    Dimension::Mass,
    Dimension::Position,
    Dimension::Velocity,
    Dimension::QuadraticDamping,
    Dimension::CubicStiffness,
    Dimension::TorqueRate,
    Dimension::WaveNumber,
    Dimension::Angle,
    Dimension::Time,
    Dimension::TimeSquared,
    Dimension::Ratio,
];

impl Dimension {
    /// The dimension of which this is the unit on a revolute joint.
    pub fn of_unit(unit: &str) -> Dimension {
        let is_it = |dimension: &Dimension| dimension.unit(JointKind::Revolute) == unit;
        NAMED.into_iter().find(is_it).unwrap_or_else(|| Dimension::Stated(Box::leak(unit.to_owned().into_boxed_str())))
    }

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
            (Stated(unit), _) => unit,
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
