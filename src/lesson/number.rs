//! The numbers that a step can ask for, computed from the session or stated in the lesson.

use serde::Deserialize;

use super::wish::mean_error;
use crate::model::Preset;
use crate::model::learned::LearnedPreset;
use crate::session::{Kept, Session, Step};
use crate::simulation::extrapolation::Stretch;
use crate::training::components;
use crate::training::inside::{Balance, power};

/// A number that is right.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Number {
    /// This one.
    Stated(f64),
    /// How many times the mean held-out error of the newest model of one kind is that of another.
    ErrorRatio {
        /// The one above the line.
        of: Preset,
        /// The one below it.
        to: Preset,
    },
    /// The error of the newest model of a kind outside the data: nMSE \[%\].
    ErrorAt {
        /// Which kind.
        of: Preset,
        /// In which way the motion leaves the data.
        stretch: Stretch,
        /// How far: times the speed, range or load of the data.
        at: f64,
    },
    /// How many times the mean held-out error of the first model of the ladder is that of the current one.
    ErrorFall,
    /// The energy that was put into the first run and, by the current model's kinetic and potential energy, is not there at its
    /// end \[J\].
    EnergyLost,
}

impl Number {
    /// Its value; else what is to be done before it can be told.
    pub(super) fn value(&self, session: &Session) -> Result<f64, String> {
        match self {
            Number::Stated(value) => Ok(*value),
            Number::ErrorRatio { of, to } => Ok(held_out_error(session, *of)? / held_out_error(session, *to)?),
            Number::ErrorAt { of, stretch, at } => Ok(100.0 * error_at(session, *of, *stretch, *at)?),
            Number::EnergyLost => energy_lost(session),
            Number::ErrorFall => match (session.ladder.first(), session.current()) {
                (Some(first), Some(last)) => Ok(mean_error(first) / mean_error(last)),
                _ => Err("there is no model yet".to_owned()),
            },
        }
    }
}

/// The newest model of a kind.
fn newest(session: &Session, preset: Preset) -> Result<&Step, String> {
    let made = session.models.iter().rev().find(|kept| kept.preset == preset);
    let step = made.and_then(Kept::step).ok_or_else(|| format!("there is no {} yet: make it first", preset.title()))?;
    Ok(step.as_ref())
}

/// Mean nMSE of the newest model of a kind on held-out data.
pub(super) fn held_out_error(session: &Session, of: Preset) -> Result<f64, String> {
    newest(session, of).map(mean_error)
}

/// nMSE of the newest model of a kind outside the data.
pub(super) fn error_at(session: &Session, of: Preset, stretch: Stretch, at: f64) -> Result<f64, String> {
    let model = newest(session, of)?;
    let sweep = session.sweep.as_ref().filter(|sweep| sweep.stretch == stretch);
    let curve = sweep.and_then(|sweep| sweep.curves.iter().find(|curve| curve.model == model.name));
    let points = &curve.ok_or_else(|| format!("{} was not extrapolated in {} yet", model.name, stretch.name()))?.points;
    let point = points.iter().find(|point| (point.scale - at).abs() < 1e-6);
    point.map(|point| point.overall).ok_or_else(|| format!("the curve has no point at {at} times"))
}

/// Whether the mass matrix that the newest structured DeLaN has learned is positive definite wherever the recording went.
pub(super) fn is_mass_positive(session: &Session) -> Result<bool, String> {
    let step = newest(session, Preset::Learned(LearnedPreset::StructuredDelan))?;
    let runs = session.recording.iter().flat_map(|recording| &recording.trajectories);
    for run in runs {
        let parts = components(&step.fitted, run).map_err(|error| error.to_string())?;
        // They are in ascending order.
        let least = parts.iter().find(|(name, _)| *name == "mass_eigenvalue").and_then(|(_, all)| all.iter().next());
        if least.is_some_and(|least| least.iter().any(|value| *value <= 0.0)) {
            return Ok(false);
        }
    }
    Ok(true)
}

fn energy_lost(session: &Session) -> Result<f64, String> {
    let run = session.recording.as_ref().and_then(|recording| recording.trajectories.first());
    let (Some(run), Some(step)) = (run, session.current()) else { return Err("there is no model yet".to_owned()) };
    let balance = Balance::of_model(&step.fitted, run).map_err(|error| error.to_string())?;
    balance.lost(&power(&run.tau, run), &run.time).last().copied().ok_or_else(|| "the run is empty".to_owned())
}

/// What a number is worth beside the right one: all within `within` times it, half within the square of that.
pub(super) fn score(said: f64, right: f64, within: f64) -> f64 {
    // Also where one of them is 0 or of the other sign.
    let off = if said == right { 0.0 } else { (said / right).ln().abs() };
    match off / within.ln() {
        off if off <= 1.0 => 1.0,
        off if off <= 2.0 => 0.5,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_may_be_off_by_a_factor() {
        let worth = |said| score(said, 4.0, 1.25);
        assert_eq!([4.0, 4.9, 3.3, 5.5, 6.5, 0.0, -4.0].map(worth), [1.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0]);
        assert_eq!((score(0.0, 0.0, 1.1), score(1.0, 0.0, 1.1)), (1.0, 0.0));
    }
}
