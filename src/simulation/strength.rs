//! Parameters with which an effect has a wanted strength on a motion: shapes and proportions are drawn, the size follows.

use rand::{Rng, RngExt};

use super::SimulationError;
use crate::effect::{Effect, ParameterSpec, Starts};
use crate::recording::Trajectory;
use crate::recording::fault::FaultKind;
use crate::signals::Signals;

/// Steps in which the size of a fault is found.
const BISECTIONS: usize = 30;
/// A grid of shapes whose least value the motion can't show is gone on with so far beyond what it can show.
const BEYOND: f64 = 2.0;

/// An effect that is to have a strength on a motion.
#[derive(Debug, Clone, Copy)]
pub struct Strength<'a> {
    /// Which.
    pub effect: &'static Effect,
    /// Its joint (from 0); `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// RMS of its torque over that of the torque of the joints that feel it.
    pub share: f64,
    /// The motion, with the torque that the strength is measured by.
    pub runs: &'a [Trajectory],
}

impl Strength<'_> {
    /// Parameters with this strength, in the order of the specification. `torque` gives what the effect makes of the torque of
    /// each run with given parameters, which may lie outside their bounds.
    ///
    /// # Errors
    /// [`SimulationError`] if the effect makes no torque here or its parameters would lie outside their bounds, and those of
    /// `torque`.
    pub fn draw(
        &self,
        random: &mut impl Rng,
        torque: impl Fn(&[f64]) -> Result<Vec<Signals>, SimulationError>,
    ) -> Result<Vec<f64>, SimulationError> {
        let parameters = match self.effect.fault() {
            Some(kind) => self.of_fault(kind, random, torque)?,
            None => self.of_torque(random, torque)?,
        };
        self.effect.check_parameters(&parameters)?;
        Ok(parameters)
    }

    fn of_torque(
        &self,
        random: &mut impl Rng,
        torque: impl Fn(&[f64]) -> Result<Vec<Signals>, SimulationError>,
    ) -> Result<Vec<f64>, SimulationError> {
        let Strength { effect, runs, .. } = *self;
        let way = Trajectory::way(runs, self.joint.unwrap_or(0));
        let shapes = effect.shapes().zip(effect.least_shape(way));
        let shape: Vec<f64> =
            shapes.map(|((_, starts), least)| draw_shape(starts, &starts.values(way), least, random)).collect();
        let with = |linear: Vec<f64>| -> Vec<f64> { linear.into_iter().chain(shape.iter().copied()).collect() };
        let norm_with = |linear| Ok::<f64, SimulationError>(norm(torque(&with(linear))?.iter().flatten().flatten()));

        let count = effect.linear().count();
        let alone = |index| (0..count).map(|other| if other == index { 1.0 } else { 0.0 }).collect();
        let sizes = (0..count).map(|index| norm_with(alone(index))).collect::<Result<Vec<_>, _>>()?;
        if sizes.contains(&0.0) {
            return Err(self.no_torque());
        }
        // How much is a lot differs for a torque and a stiffness, but not for two torques: what is drawn is measured by the
        // column of the first parameter that has the same dimension.
        let size_of = |dimension| {
            let alike = effect.linear().zip(&sizes).find(|(parameter, _)| parameter.dimension == dimension);
            alike.map_or(1.0, |(_, size)| *size)
        };
        let drawn: Vec<f64> =
            effect.linear().map(|parameter| draw_share(parameter, random) / size_of(parameter.dimension)).collect();
        // It is measured by the torque of the joints that feel it.
        let torque = torque(&with(drawn.clone()))?;
        let feels = |joint: &usize| torque.iter().any(|run| run[*joint].iter().any(|value| *value != 0.0));
        let joints = runs.first().map_or(0, Trajectory::joint_count);
        let feeling: Vec<usize> = (0..joints).filter(feels).collect();
        let wanted = self.share * norm(runs.iter().flat_map(|run| feeling.iter().flat_map(|joint| &run.tau[*joint])));
        let factor = wanted / norm(torque.iter().flatten().flatten());
        if !(factor.is_finite() && factor > 0.0) {
            return Err(self.no_torque());
        }
        Ok(with(drawn.into_iter().map(|parameter| factor * parameter).collect()))
    }

    /// A fault of the readings that changes them by the wanted share; its first parameter is found by bisection.
    fn of_fault(
        &self,
        kind: FaultKind,
        random: &mut impl Rng,
        change: impl Fn(&[f64]) -> Result<Vec<Signals>, SimulationError>,
    ) -> Result<Vec<f64>, SimulationError> {
        let readings = || self.runs.iter().flat_map(|run| &run.tau[self.joint.unwrap_or(0)]);
        let largest = readings().fold(0.0, |most: f64, tau| most.max(tau.abs()));
        let (mut weak, mut strong, others) = match kind {
            FaultKind::Saturated => (largest, 0.0, Vec::new()),
            FaultKind::Stuck => {
                let period = random.random_range(1.5..=3.0);
                (0.0, 0.8 * period, vec![period])
            }
        };
        let of_joint = norm(readings());
        let parameters = |first: f64| -> Vec<f64> { std::iter::once(first).chain(others.iter().copied()).collect() };
        let share = |first: f64| -> Result<f64, SimulationError> {
            Ok(norm(change(&parameters(first))?.iter().flatten().flatten()) / of_joint)
        };
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (weak + strong);
            if share(middle)? < self.share { weak = middle } else { strong = middle }
        }
        let reached = share(strong)? / self.share;
        if !(0.8..=1.25).contains(&reached) {
            return Err(self.no_torque());
        }
        Ok(parameters(strong))
    }

    fn no_torque(&self) -> SimulationError {
        SimulationError::NoTorque { effect: self.effect.name, joint: self.joint }
    }
}

/// Between the values that a search would try first, not below what the motion can show; evenly on the scale of the search.
fn draw_shape(starts: Starts, values: &[f64], least: f64, random: &mut impl Rng) -> f64 {
    let (first, last) = (values.first().copied().unwrap_or(1.0), values.last().copied().unwrap_or(1.0));
    let first = first.max(least);
    let last = if first > last { BEYOND * first } else { last };
    let share: f64 = random.random_range(0.0..=1.0);
    let [first, last] = [first, last].map(|value| starts.place(value));
    starts.value(first + (last - first) * share)
}

/// A third to the whole of a typical size, of either sign where the parameter may be negative.
fn draw_share(parameter: &ParameterSpec, random: &mut impl Rng) -> f64 {
    let share = random.random_range(0.3..=1.0);
    if parameter.min < 0.0 && random.random_bool(0.5) { -share } else { share }
}

fn norm<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().map(|value| value * value).sum::<f64>().sqrt()
}
