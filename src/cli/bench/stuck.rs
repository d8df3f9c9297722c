use clap::Args;
use serde::Serialize;

use crate::cli::data::Training;
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::model::learned::LearnedPreset;
use crate::model::{self, Evaluation, Preset};
use crate::progress::Monitor;
use crate::recording::split::Split;
use crate::session::SessionError;
use crate::simulation::{Scenario, SimulationError, simulate};
use crate::statistics::median;
use crate::training::fit::{Plan, fit};

/// A training is stuck if its error is more than so many times the median of its kind.
const STUCK: f64 = 3.0;
/// So many are not to be, for a live demonstration.
const WANTED: f64 = 0.99;

/// How often a training of structured DeLaN gets stuck, on mysteries and on the arm of the demonstration without its friction.
///
/// Each seed draws arm, motion, noise and first weights. The error is the held-out nMSE over that of the identified rigid body, so that
/// a mystery with a strong effect, which neither can learn, counts as one with a weak one. A hundred seeds take a quarter of an hour.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench stuck
  torquescope bench stuck --seeds 10 --epochs 30 --json")]
pub struct Stuck {
    /// How many seeds of each kind.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// The first of them; defaults were chosen on seeds from 200 on.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u64).range(..=1_000_000))]
    first: u64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    training: Training,
}

/// One kind of data.
#[derive(Debug, Clone, Serialize)]
struct Row {
    data: &'static str,
    /// Of the error, which is relative to that of the rigid body.
    median: f64,
    /// The largest.
    most: f64,
    /// Share of the trainings that are not stuck.
    free: f64,
    /// The seeds of the others.
    stuck: Vec<u64>,
}

/// What a seed gives.
type Draw = fn(u64) -> Result<Scenario, SimulationError>;

const KINDS: [(&str, Draw); 2] = [
    ("mysteries", Scenario::mystery),
    ("the clean arm", |seed| Ok(Scenario { effects: Vec::new(), seed, ..Scenario::embedded() })),
];

impl Stuck {
    /// Trains, measures, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let (plan, seeds, first) = (self.training.plan()?, self.seeds, self.first);
        let rows = progress::watch("bench stuck", move |monitor| {
            let mut rows = Vec::new();
            for (place, (data, draw)) in KINDS.into_iter().enumerate() {
                let mut errors = Vec::new();
                for seed in 0..seeds {
                    let done = (place as u64 * seeds + seed) as f32 / (KINDS.len() as u64 * seeds) as f32;
                    monitor.report(done, data).map_err(SessionError::from)?;
                    errors.push(relative_error(&draw(first + seed).map_err(SessionError::from)?, &plan)?);
                }
                rows.push(Row::of(data, first, &errors));
            }
            Ok::<_, anyhow::Error>(rows)
        })?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&serde_json::json!({ "seeds": seeds, "data": rows }))?);
            return Ok(());
        }
        let line = |row: &Row| {
            let stuck: Vec<String> = row.stuck.iter().map(u64::to_string).collect();
            let free = format!("{:.1} %", 100.0 * row.free);
            vec![row.data.to_owned(), number(row.median), number(row.most), free, stuck.join(" ")]
        };
        let header = ["data", "median", "largest", "not stuck", " stuck seeds"];
        println!("{}", table(&header, &rows.iter().map(line).collect::<Vec<_>>()));
        let verdict = if rows.iter().all(|row| row.free >= WANTED) { "as wanted" } else { "fewer than wanted" };
        println!(
            "\nHeld-out nMSE over that of the rigid body; stuck: above {STUCK} times the median. {verdict}: 99 % free."
        );
        Ok(())
    }
}

/// Held-out nMSE of a structured DeLaN over that of the rigid body, means of the joints.
fn relative_error(scenario: &Scenario, plan: &Plan) -> anyhow::Result<f64> {
    let recording = simulate(scenario, &Monitor::new()).map_err(SessionError::from)?;
    let split = Split::automatic(&recording);
    let mut plan = plan.clone();
    plan.options.seed = scenario.seed;
    let network = plan.shaped(&Preset::Learned(LearnedPreset::StructuredDelan).model(&recording)?);
    let trained = fit(&network, &recording, &split, &plan, None, &Monitor::new(), &mut |_| {})?.fitted;
    let body = model::fit(&Preset::RigidBody.model(&recording)?, &recording, &split, &Monitor::new())?;
    let error = |fitted| Ok::<f64, anyhow::Error>(mean(&Evaluation::of(fitted, &recording, &split)?));
    Ok(error(&trained)? / error(&body)?)
}

fn mean(evaluation: &Evaluation) -> f64 {
    let errors = evaluation.held_out_nmse();
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

impl Row {
    /// Of the errors of the seeds from the first on.
    fn of(data: &'static str, first: u64, errors: &[f64]) -> Row {
        let middle = median(errors.iter().copied().filter(|error| error.is_finite()).collect()).unwrap_or(f64::NAN);
        // What is no number is stuck, too.
        let is_free = |error: &f64| *error <= STUCK * middle;
        let stuck: Vec<u64> =
            (first..).zip(errors).filter(|(_, error)| !is_free(error)).map(|(seed, _)| seed).collect();
        let free = 1.0 - stuck.len() as f64 / errors.len().max(1) as f64;
        Row { data, median: middle, most: errors.iter().copied().fold(0.0, f64::max), free, stuck }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_training_far_above_the_median_is_stuck() {
        let row = Row::of("data", 0, &[1.0, 1.2, 0.9, 3.5, 2.9, 1.0, f64::NAN, 1.1]);
        assert_eq!(row.stuck, [3, 6]);
        assert_eq!((row.free, row.most), (0.75, 3.5));
    }
}
