use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use serde::Serialize;

use super::ui::long_run;
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::file;
use crate::progress::Monitor;
use crate::recording::read::{ReadOptions, read};
use crate::recording::write::{self, Form};
use crate::selftest::memory;

/// Goals for 532,000 samples of three joints on two cores \[s\]; none for what is younger than they are.
const GOALS: [(Form, f64); 3] = [(Form::Npz, 1.0), (Form::Csv, 2.0), (Form::Mcap, 3.0)];
const MIB: f64 = 1024.0 * 1024.0;

/// Measure how long files of every form take to be read, and what memory that takes.
///
/// A recording of three joints is simulated and written; each file is read again, as often as is asked for, and the median counts.
/// Memory is the most that is taken beside what was there before, as a multiple of the arrays that are read.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench read
  torquescope bench read --samples 100000 --times 3 --json")]
pub struct Read {
    /// Samples of each joint.
    #[arg(long, default_value_t = 532_000)]
    samples: usize,
    /// How often each file is read.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    times: u64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Row {
    form: &'static str,
    file_mib: f64,
    /// Median.
    seconds: f64,
    goal_s: Option<f64>,
    /// Of what was read, numbers of eight bytes.
    data_mib: f64,
    /// The most beside what was there before; `None` where the system does not tell.
    memory_mib: Option<f64>,
}

impl Read {
    /// Simulates, writes, reads, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let recording = long_run(self.samples)?.recording.context("nothing was simulated")?;
        let folder = tempfile::tempdir().context("no folder can be made for the recordings")?;
        let mut rows = Vec::new();
        for form in Form::ALL {
            progress::told(format_args!("{} …", form.ending()));
            let path = folder.path().join(format!("long run.{}", form.ending()));
            let bytes = write::to_bytes(&recording, form)?;
            file::write(&path, &bytes)?;
            let file_mib = bytes.len() as f64 / MIB;
            drop(bytes);
            rows.push(self.measured(form, &path, file_mib)?);
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rows)?);
            return Ok(());
        }
        let optional = |value: Option<f64>| value.map_or("–".to_owned(), number);
        let cells = |row: &Row| {
            let times = row.memory_mib.map(|memory| memory / row.data_mib);
            let [file, seconds] = [row.file_mib, row.seconds].map(number);
            vec![row.form.to_owned(), file, seconds, optional(row.goal_s), optional(row.memory_mib), optional(times)]
        };
        let rows: Vec<Vec<String>> = rows.iter().map(cells).collect();
        println!("{}", table(&["form", "file MiB", "s", "goal s", "memory MiB", "times the data"], &rows));
        Ok(())
    }

    fn measured(&self, form: Form, path: &Path, file_mib: f64) -> anyhow::Result<Row> {
        let paths = [path.to_owned()];
        let mut seconds = Vec::new();
        let (mut most, mut data_mib) = (None::<f64>, 0.0);
        for _ in 0..self.times {
            let before = memory::start();
            let start = Instant::now();
            let import = read(&paths, &ReadOptions::default(), &Monitor::new())?;
            seconds.push(start.elapsed().as_secs_f64());
            let taken = before.zip(memory::most()).map(|(before, most)| most.saturating_sub(before) as f64 / MIB);
            most = taken.map(|taken| taken.max(most.unwrap_or(0.0)));
            let recording = import.recording;
            let numbers = recording.sample_count() * (1 + 4 * recording.joint_count());
            data_mib = 8.0 * numbers as f64 / MIB;
        }
        seconds.sort_by(f64::total_cmp);
        let goal_s = GOALS.iter().find(|(own, _)| *own == form).map(|(_, goal)| *goal);
        let seconds = seconds[seconds.len() / 2];
        Ok(Row { form: form.ending(), file_mib, seconds, goal_s, data_mib, memory_mib: most })
    }
}
