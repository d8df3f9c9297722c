//! What stands along an axis: its quantity, how values are placed, and its numbers.

use super::ticks;

/// What stands along an axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// How values are placed.
    pub scale: Scale,
    /// The shown range, in the values' own unit; `None` shows everything with a margin.
    pub range: Option<[f64; 2]>,
    /// Axes of the same name here show the same range in a window: who zooms one zooms all.
    pub link: Option<String>,
}

/// How values are placed along an axis.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; what is not positive is left out.
    Logarithmic,
    /// The n-th name stands at n, from 0.
    Names(Vec<String>),
}

impl Axis {
    /// An even axis over everything.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Axis { label: label.into(), unit: unit.into(), ..Axis::default() }
    }

    /// An axis of names, the first at 0.
    pub fn names(label: impl Into<String>, names: Vec<String>) -> Self {
        let range = Some([-0.5, names.len() as f64 - 0.5]);
        Axis { label: label.into(), scale: Scale::Names(names), range, ..Axis::default() }
    }

    /// The same with powers of ten at equal distances.
    #[must_use]
    pub fn logarithmic(mut self) -> Self {
        self.scale = Scale::Logarithmic;
        self
    }

    /// The same over this range only.
    #[must_use]
    pub fn range(mut self, range: [f64; 2]) -> Self {
        self.range = Some(range);
        self
    }

    /// The same, linked with all axes of this name.
    #[must_use]
    pub fn linked(mut self, name: impl ToString) -> Self {
        self.link = Some(name.to_string());
        self
    }

    /// A value in the axis' own measure: the decimal logarithm on a logarithmic axis, NaN where there is none.
    pub fn measure(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic if value > 0.0 => value.log10(),
            Scale::Logarithmic => f64::NAN,
            Scale::Linear | Scale::Names(_) => value,
        }
    }

    /// The value at a place in the axis' own measure.
    pub fn value(&self, measured: f64) -> f64 {
        if self.scale == Scale::Logarithmic { 10f64.powf(measured) } else { measured }
    }

    /// About `count` round numbers of a range, given in the axis' own measure: where they stand, and what they say.
    pub fn ticks(&self, range: [f64; 2], count: usize) -> Vec<(f64, String)> {
        match &self.scale {
            Scale::Linear => {
                let ticks = ticks::linear(range, count);
                let labels = ticks::labels(&ticks);
                ticks.into_iter().zip(labels).collect()
            }
            Scale::Logarithmic => ticks::logarithmic(range, count),
            Scale::Names(names) => names.iter().enumerate().map(|(at, name)| (at as f64, name.clone())).collect(),
        }
    }

    /// Label and unit: `torque [N m]`.
    pub fn title(&self) -> String {
        with_unit(&self.label, &self.unit)
    }
}

/// `torque [N m]`.
pub fn with_unit(label: &str, unit: &str) -> String {
    if unit.is_empty() { label.to_owned() } else { format!("{label} [{unit}]") }
}
