use clap::Args;
use serde::Serialize;

use super::super::table::{number, table};
use crate::app::headless::{FrameTimes, frame_times};
use crate::cli::progress;
use crate::model::learned::LearnedPreset;
use crate::session::{Command, Session};
use crate::simulation::extrapolation::Stretch;
use crate::simulation::{Excitation, Scenario};
use crate::training::fit::Plan;

/// Measure how long the window takes for a frame, on a recording of three joints and 532,000 samples, while a network trains.
///
/// Every screen is drawn at 1600x1000 for 240 frames: at rest, while zooming in, while moving the view and the cursor. What
/// counts is the CPU time of the window's own thread, from input to triangles, without the picture.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench ui")]
pub struct Ui {
    /// Samples of each joint.
    #[arg(long, default_value_t = 532_000)]
    samples: usize,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    screens: Vec<Row>,
    first_frame_ms: f64,
    peak_mib: f64,
}

#[derive(Serialize)]
struct Row {
    screen: &'static str,
    /// Samples of all joints and channels that are loaded.
    points: usize,
    median_ms: f64,
    p99_ms: f64,
}

impl Ui {
    /// Simulates, trains in the background, draws, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let session = loaded(self.samples)?;
        let points =
            session.recording.as_ref().map_or(0, |recording| 6 * recording.joint_count() * recording.sample_count());
        let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: Box::new(Plan::default()) };
        let FrameTimes { first_ms, screens } = frame_times(session, train)?;
        let row = |(screen, mut times): (&'static str, Vec<f64>)| {
            times.sort_by(f64::total_cmp);
            let quantile = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
            Row { screen, points, median_ms: quantile(0.5), p99_ms: quantile(0.99) }
        };
        let screens = screens.into_iter().map(row).collect();
        let answer = Answer { screens, first_frame_ms: first_ms, peak_mib: peak_mib() };
        if self.json {
            println!("{}", serde_json::to_string_pretty(&answer)?);
            return Ok(());
        }
        let cells =
            |row: &Row| vec![row.screen.to_owned(), row.points.to_string(), number(row.median_ms), number(row.p99_ms)];
        let rows: Vec<Vec<String>> = answer.screens.iter().map(cells).collect();
        println!("{}", table(&["screen", "points", "median ms", "p99 ms"], &rows));
        println!("first frame {:.0} ms, peak memory {:.0} MiB", answer.first_frame_ms, answer.peak_mib);
        Ok(())
    }
}

/// One long run with a repaired model, diagnosed and tested outside its data.
fn loaded(samples: usize) -> anyhow::Result<Session> {
    const RATE: f64 = 1000.0;
    let mut scenario = Scenario { name: "long run".to_owned(), ..Scenario::embedded() };
    if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut scenario.motion {
        (*trajectories, *duration, *rate) = (1, samples as f64 / RATE, RATE);
    }
    let mut session = progress::run(Command::Simulate(Box::new(scenario)), &Session::default())?;
    let add = |effect: &str, joints: Vec<usize>| Command::AddEffect { effect: effect.to_owned(), joints };
    session = progress::run(add("coulomb-friction", vec![0]), &session)?;
    let steps = session.ladder.clone();
    session = progress::run(Command::Extrapolate { steps, stretch: Stretch::Speed }, &session)?;
    progress::run(Command::Diagnose, &session)
}

/// Most memory that the process ever had, as the system counts it; NaN where the system does not say.
fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).map_or(f64::NAN, |kib| kib / 1024.0)
}
