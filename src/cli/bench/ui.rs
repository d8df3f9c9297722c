use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use serde::{Deserialize, Serialize};

use super::super::table::{number, table};
use crate::app::pace::{FrameTimes, Opening, frame_times, opened_and_played};
use crate::cli::{progress, write_file};
use crate::model::learned::LearnedPreset;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::ReadOptions;
use crate::recording::write;
use crate::selftest::memory;
use crate::session::{Command, Session};
use crate::simulation::extrapolation::Stretch;
use crate::simulation::{Excitation, Scenario};
use crate::training::fit::Plan;

/// Measure how quick the window is with a recording of three joints and 532,000 samples: when its file is on the screen, what memory
/// that takes, what the arm costs while it plays, and how long frames take while a network trains.
///
/// The file is opened by another process of this program, so that its memory is that of the window alone: from the order to open it
/// until a picture shows it, reading and the first model included. The arm plays on Compare at 1600x1000, drawn as often as the
/// window asks for, at most 60 times a second, by a renderer without a GPU; CPU time is that of the whole process.
///
/// Then every screen is drawn at 1600x1000 for 240 frames: at rest, while zooming in, while moving the view and the cursor. What
/// counts there is the CPU time of the window's own thread, from input to triangles, without the picture.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench ui
  torquescope bench ui --samples 500000 --json
  torquescope bench ui --open my-log.npz")]
pub struct Ui {
    /// Samples of each joint.
    #[arg(long, default_value_t = 532_000)]
    samples: usize,
    /// Only open this recording, and play it.
    #[arg(long, value_name = "RECORDING", conflicts_with = "samples")]
    open: Option<PathBuf>,
    /// How long the arm plays [s].
    #[arg(long, default_value_t = 5.0)]
    seconds: f64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    opened: Opened,
    screens: Vec<Row>,
    first_frame_ms: f64,
    peak_mib: Option<f64>,
}

/// A file that was opened and played.
#[derive(Serialize, Deserialize)]
struct Opened {
    /// Until a picture shows it, and until everything on that screen is there.
    seen_s: f64,
    whole_s: f64,
    /// Time and all channels of the recording as numbers of eight bytes.
    data_mib: f64,
    /// Most memory that the process ever had.
    peak_mib: Option<f64>,
    /// While the arm plays: pictures, and CPU time over the time that passed, of all threads and of the window's own up to triangles.
    pictures_per_s: f64,
    played_percent_of_a_core: f64,
    of_it_window_percent: f64,
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
    /// Opens and plays; simulates, trains in the background, draws; prints.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(path) = &self.open {
            let opened = Opened::measured(path, self.seconds)?;
            return match self.json {
                true => print_json(&opened),
                false => {
                    println!("{}", opened.text());
                    Ok(())
                }
            };
        }
        let session = loaded(self.samples)?;
        let opened = self.opened_elsewhere(&session)?;
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
        let answer = Answer { opened, screens, first_frame_ms: first_ms, peak_mib: peak_mib() };
        if self.json {
            return print_json(&answer);
        }
        let cells =
            |row: &Row| vec![row.screen.to_owned(), row.points.to_string(), number(row.median_ms), number(row.p99_ms)];
        let rows: Vec<Vec<String>> = answer.screens.iter().map(cells).collect();
        println!("{}", table(&["screen", "points", "median ms", "p99 ms"], &rows));
        println!("first frame {:.0} ms, peak memory {} MiB", answer.first_frame_ms, whole(answer.peak_mib));
        println!("{}", answer.opened.text());
        Ok(())
    }

    /// The recording as a file, opened and played by a process that has made none of it.
    fn opened_elsewhere(&self, session: &Session) -> anyhow::Result<Opened> {
        let folder = tempfile::tempdir().context("no folder can be made for the recording")?;
        let path = folder.path().join("long run.npz");
        let recording = session.recording.as_deref().context("nothing was simulated")?;
        write_file(&path, &write::to_npz_bytes(recording)?)?;
        let mut program = std::process::Command::new(std::env::current_exe()?);
        program.args(["bench", "ui", "--quiet", "--json", "--seconds", &self.seconds.to_string(), "--open"]).arg(&path);
        let output = program.stderr(std::process::Stdio::inherit()).output()?;
        anyhow::ensure!(output.status.success(), "the window that was to open the file ended: {}", output.status);
        serde_json::from_slice(&output.stdout).context("the window that opened the file told something else")
    }
}

impl Opened {
    fn measured(path: &Path, seconds: f64) -> anyhow::Result<Self> {
        let open = Command::open(vec![path.to_owned()], ReadOptions::default(), HoldOut::default());
        let Opening { seen_s, whole_s, pictures_per_s, played_share, window_share, numbers } =
            opened_and_played(open, seconds)?;
        Ok(Opened {
            seen_s,
            whole_s,
            data_mib: 8.0 * numbers as f64 / MIB,
            peak_mib: peak_mib(),
            pictures_per_s,
            played_percent_of_a_core: 100.0 * played_share,
            of_it_window_percent: 100.0 * window_share,
        })
    }

    fn text(&self) -> String {
        format!(
            "on the screen after {:.2} s, all of it after {:.2} s; peak memory {} MiB, of data {:.0} MiB\n\
             playing the arm: {:.0} pictures a second, {:.0} % of a core (up to triangles {:.0} %)",
            self.seen_s,
            self.whole_s,
            whole(self.peak_mib),
            self.data_mib,
            self.pictures_per_s,
            self.played_percent_of_a_core,
            self.of_it_window_percent
        )
    }
}

fn whole(value: Option<f64>) -> String {
    value.map_or("?".to_owned(), |value| format!("{value:.0}"))
}

fn print_json(answer: &impl Serialize) -> anyhow::Result<()> {
    println!("{}", serde_json::to_string_pretty(answer)?);
    Ok(())
}

/// One long run as it is simulated.
pub(super) fn long_run(samples: usize) -> anyhow::Result<Session> {
    const RATE: f64 = 1000.0;
    let mut scenario = Scenario { name: "long run".to_owned(), ..Scenario::embedded() };
    if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut scenario.motion {
        (*trajectories, *duration, *rate) = (1, samples as f64 / RATE, RATE);
    }
    progress::run(Command::Simulate(Box::new(scenario)), &Session::default())
}

/// One long run with a repaired model, diagnosed and tested outside its data.
fn loaded(samples: usize) -> anyhow::Result<Session> {
    let mut session = long_run(samples)?;
    let add = |effect: &str, joints: Vec<usize>| Command::AddEffect { effect: effect.to_owned(), joints };
    session = progress::run(add("coulomb-friction", vec![0]), &session)?;
    let steps = session.ladder.clone();
    session = progress::run(Command::Extrapolate { steps, stretch: Stretch::Speed }, &session)?;
    progress::run(Command::Diagnose, &session)
}

const MIB: f64 = 1024.0 * 1024.0;

/// Most memory that the process ever had; `None` where the system does not say.
fn peak_mib() -> Option<f64> {
    memory::most().map(|bytes| bytes as f64 / MIB)
}
