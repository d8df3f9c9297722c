//! The parameters of an effect: names, dimensions, bounds, and how each enters the torque.

use std::f64::consts::PI;

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
        /// Where the search starts.
        starts: Starts,
        /// The least value that a motion along this way of the joint can show.
        least_shown: fn(Way) -> f64,
    },
    /// As a measure of faulty readings, which is read off them.
    Reading,
}

/// So many peaks of a periodogram are tried.
pub const MOST_PEAKS: usize = 2;

/// Along which positions a joint moves, and what seems to repeat there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// The least position \[rad or m\].
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// Wave numbers \[1/rad or 1/m\], ascending, at which the torque seems to repeat, faster than those that are tried anyway; 0 for
    /// those that are not there.
    pub peaks: [f64; MOST_PEAKS],
}

impl From<[f64; 2]> for Way {
    fn from([low, high]: [f64; 2]) -> Way {
        Way { low, high, peaks: [0.0; MOST_PEAKS] }
    }
}

/// Values of a shape parameter that are tried first, ascending.
#[derive(Debug, Clone, Copy)]
pub enum Starts {
    /// Positive values, told apart by their ratios.
    Values(&'static [f64]),
    /// Places on the joint's way, as shares of it from its lower end.
    Places(&'static [f64]),
    /// Wave numbers of a torque that repeats with the position, from one and a half periods over the joint's way on: with less, there are
    /// phases at which no crest and no trough comes back, and the wave is told from no spring. Those of [`Way::peaks`] come after them.
    Waves,
}

impl Starts {
    /// The values for a joint that goes this way.
    pub fn values(self, way: impl Into<Way>) -> Vec<f64> {
        let way = way.into();
        let Way { low, high, peaks } = way;
        match self {
            Starts::Values(values) => values.to_vec(),
            Starts::Places(shares) => shares.iter().map(|share| low + share * (high - low)).collect(),
            Starts::Waves => {
                let first = repeated(way).max(LEAST_WAVE);
                let wave = |number: usize| first + number as f64 * half_a_period(way).max(LEAST_WAVE_STEP);
                let beyond = wave(WAVES - 1) + half_a_period(way);
                (0..WAVES).map(wave).chain(peaks.into_iter().filter(|peak| *peak > beyond)).collect()
            }
        }
    }

    /// Between which values a search goes on from one of the [`Self::values`]: its neighbours, or beyond the first and the last.
    pub fn around(self, values: &[f64], value: f64) -> [f64; 2] {
        let near = 1e-3 * self.unit(values, value);
        let below = values.iter().copied().rfind(|&other| other < value - near);
        let above = values.iter().copied().find(|&other| other > value + near);
        match self {
            Starts::Values(_) => [below.unwrap_or(value / BEYOND), above.unwrap_or(value * BEYOND)],
            Starts::Places(_) => {
                let step = mean_step(values);
                [below.unwrap_or(value - step), above.unwrap_or(value + step)]
            }
            Starts::Waves => {
                // Peaks stand alone.
                let step = mean_step(&values[..WAVES.min(values.len())]);
                let close = |other: &f64| (other - value).abs() < 2.0 * step;
                [below.filter(close).unwrap_or(value - step), above.filter(close).unwrap_or(value + step)]
            }
        }
    }

    /// By what a change of a value is measured: the value itself, or how far apart the start values are.
    pub fn unit(self, values: &[f64], value: f64) -> f64 {
        match self {
            Starts::Values(_) | Starts::Waves => value,
            Starts::Places(_) => values.last().zip(values.first()).map_or(1.0, |(last, first)| last - first),
        }
    }

    /// Where a value is on the scale on which it is searched: logarithmic for those that are told apart by their ratios.
    pub fn place(self, value: f64) -> f64 {
        match self {
            Starts::Values(_) => value.ln(),
            Starts::Places(_) | Starts::Waves => value,
        }
    }

    /// The value at a [`Self::place`].
    pub fn value(self, place: f64) -> f64 {
        match self {
            Starts::Values(_) => place.exp(),
            Starts::Places(_) | Starts::Waves => place,
        }
    }
}

fn mean_step(values: &[f64]) -> f64 {
    let all = values.last().zip(values.first()).map_or(0.0, |(last, first)| last - first);
    all / values.len().max(2) as f64
}

/// So many times beyond the first and the last start value a search goes on.
const BEYOND: f64 = 4.0;
/// So many wave numbers are tried first, half a period over the joint's way apart, which is half of what tells two waves apart.
const WAVES: usize = 15;
/// A wave that repeats once a turn is gravity's \[rad⁻¹\].
const LEAST_WAVE: f64 = 2.0;
/// Over ways of more than half a turn they are further apart \[rad⁻¹\], so that as many reach as far.
const LEAST_WAVE_STEP: f64 = 1.0;

impl ParameterSpec {
    /// A factor of a column, of either sign unless bounds are added.
    pub const fn linear(name: &'static str, symbol: &'static str, dimension: Dimension) -> Self {
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        ParameterSpec { name, symbol, dimension, min, max, role: Role::Linear }
    }

    /// A positive shape parameter with the values that are tried first (ascending); any motion can show it.
    pub const fn shape(name: &'static str, symbol: &'static str, dimension: Dimension, grid: &'static [f64]) -> Self {
        let role = Role::Shape { starts: Starts::Values(grid), least_shown: any_motion };
        ParameterSpec { name, symbol, dimension, min: 0.0, max: f64::INFINITY, role }
    }

    /// A position in the shape, with the shares of the joint's way that are tried first (ascending).
    pub const fn place(name: &'static str, symbol: &'static str, shares: &'static [f64]) -> Self {
        let role = Role::Shape { starts: Starts::Places(shares), least_shown: any_place };
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        ParameterSpec { name, symbol, dimension: Dimension::Position, min, max, role }
    }

    /// A wave number in the shape.
    pub const fn wave(name: &'static str, symbol: &'static str) -> Self {
        let role = Role::Shape { starts: Starts::Waves, least_shown: repeated };
        ParameterSpec { name, symbol, dimension: Dimension::WaveNumber, min: 0.0, max: f64::INFINITY, role }
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

    /// With the least value of a shape that a motion along a given way of the joint can show.
    pub const fn shown_from(self, least_shown: fn(Way) -> f64) -> Self {
        let role = match self.role {
            Role::Shape { starts, .. } => Role::Shape { starts, least_shown },
            other => other,
        };
        ParameterSpec { role, ..self }
    }

    /// Whether the value lies within the bounds.
    pub fn admits(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }

    /// The value within the bounds that is nearest.
    pub fn bounded(&self, value: f64) -> f64 {
        value.clamp(self.min, self.max)
    }
}

fn any_motion(_way: Way) -> f64 {
    0.0
}

/// The wave number of half a period over the way.
pub(super) fn half_a_period(way: Way) -> f64 {
    PI / (way.high - way.low).max(f64::MIN_POSITIVE)
}

/// That of one and a half.
fn repeated(way: Way) -> f64 {
    3.0 * half_a_period(way)
}

fn any_place(_way: Way) -> f64 {
    f64::NEG_INFINITY
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
    /// Position per torque.
    Compliance,
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
const NAMED: [Dimension; 16] = [
    Dimension::Torque,
    Dimension::Damping,
    Dimension::Stiffness,
    Dimension::Compliance,
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
            (Compliance, Revolute) => "rad/(N m)",
            (Compliance, Prismatic) => "m/N",
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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn positive_values_are_searched_by_their_ratios() {
        let starts = Starts::Values(&[0.1, 0.2, 0.5]);
        let values = starts.values([-9.0, 9.0]);
        assert_eq!(values, [0.1, 0.2, 0.5]);
        assert_eq!(starts.around(&values, 0.2), [0.1, 0.5]);
        assert_eq!(starts.around(&values, 0.3), [0.2, 0.5]);
        assert_eq!(starts.around(&values, 0.1), [0.025, 0.2]);
        assert_eq!(starts.around(&values, 0.5), [0.2, 2.0]);
        assert!((starts.value(starts.place(0.3)) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn places_lie_on_the_way_of_the_joint_wherever_that_is() {
        let starts = Starts::Places(&[0.5, 0.7, 0.9]);
        let values = starts.values([-3.0, -1.0]);
        for (value, expected) in values.iter().zip([-2.0, -1.6, -1.2]) {
            assert!((value - expected).abs() < 1e-12, "{values:?}");
        }
        let [low, high] = starts.around(&values, values[1]);
        assert_eq!([low, high], [values[0], values[2]]);
        let [low, high] = starts.around(&values, values[2]);
        assert!(low == values[1] && high > values[2] && high < -0.9, "{high}");
        assert_eq!(starts.value(starts.place(-1.3)), -1.3);
    }

    #[test]
    fn waves_begin_where_they_repeat_over_the_way_of_the_joint() {
        let starts = Starts::Waves;
        let short = starts.values([0.1, 0.35]);
        for (value, periods) in short.iter().zip([1.5, 2.0, 2.5]) {
            assert!((value - TAU * periods / 0.25).abs() < 1e-9, "{short:?}");
        }
        // A way of two turns tells slower waves apart; but the slowest is gravity's.
        let long = starts.values([-TAU, TAU]);
        assert_eq!(long[..3], [2.0, 3.0, 4.0]);
        assert_eq!(starts.around(&long, long[1]), [long[0], long[2]]);
        let [below, above] = starts.around(&long, long[14]);
        assert!(below == long[13] && above > long[14] && above < long[14] + 1.0, "{above}");
        let with_peaks = starts.values(Way { peaks: [0.0, 77.0], ..[-TAU, TAU].into() });
        assert_eq!((&with_peaks[..15], with_peaks[15]), (&long[..], 77.0));
        assert_eq!(starts.around(&with_peaks, long[14]), starts.around(&long, long[14]));
        let [below, above] = starts.around(&with_peaks, 77.0);
        assert!((75.9..77.0).contains(&below) && (77.0..78.1).contains(&above), "{below} {above}");
        let ParameterSpec { role: Role::Shape { least_shown, .. }, .. } = ParameterSpec::wave("wave_number", "k")
        else {
            panic!("a wave number is a shape")
        };
        let least = least_shown([0.1, 0.35].into());
        assert!((least - short[0]).abs() < 1e-9 * least, "{least}");
    }
}
