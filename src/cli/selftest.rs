use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;

use super::{output_folder, progress};
use crate::selftest::{self, Effort, MEASURES, Measure, Taken, opener, window};

/// Try to break the program, and count: what `tests/SCOREBOARD.md` promises, measured here.
///
/// Damaged and crafted files are opened, faults are planted into clean logs, commands and windows are killed, jobs panic. Nothing outside of a
/// folder of its own is written. The short way takes about a minute; --long takes as many cases as the scoreboard asks for.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope selftest
  torquescope selftest logs faults --long --json
  torquescope selftest documents --cases 50 --seed 7")]
pub struct Selftest {
    /// Which measures to take; all without it.
    #[arg(value_parser = measure)]
    measures: Vec<&'static Measure>,
    /// As many cases as the scoreboard asks for: hours.
    #[arg(long)]
    long: bool,
    /// At most so many cases in each part of a measure.
    #[arg(long, value_name = "N")]
    cases: Option<usize>,
    /// Seed of all that is random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Keep damaged files that were opened as they should not in this folder.
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    /// Be the process that opens files for another one.
    #[arg(long, hide = true)]
    opener: bool,
    /// Be the process that works in the window for another one.
    #[arg(long, hide = true, value_name = "TASK")]
    window: Option<window::Task>,
}

fn measure(id: &str) -> Result<&'static Measure, String> {
    let known = MEASURES.iter().map(|measure| measure.id).collect::<Vec<_>>();
    let found = MEASURES.into_iter().find(|measure| measure.id == id);
    found.ok_or_else(|| format!("there is no measure `{id}`; known are: {}", known.join(", ")))
}

impl Selftest {
    /// Takes the measures and prints them. A broken promise is a failure.
    pub fn run(&self) -> anyhow::Result<()> {
        if self.opener {
            return opener::serve().context("the process that opens files lost its line");
        }
        if let Some(task) = &self.window {
            return window::serve(task).context("the process that works in the window ended");
        }
        let measures = if self.measures.is_empty() { MEASURES.to_vec() } else { self.measures.clone() };
        self.keep.as_deref().map_or(Ok(()), output_folder)?;
        let effort = Effort { long: self.long, most: self.cases, seed: self.seed, keep: self.keep.clone() };
        let taken = progress::watch("selftest", move |monitor| selftest::take(&measures, &effort, monitor))?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&taken)?);
        } else {
            taken.iter().for_each(print);
        }
        let broken: Vec<&str> = taken.iter().filter(|taken| !taken.passed).map(|taken| taken.measure).collect();
        if broken.is_empty() { Ok(()) } else { bail!("promises that are not kept: {}", broken.join(", ")) }
    }
}

/// So many broken promises of one measure are told.
const TOLD: usize = 10;

fn print(taken: &Taken) {
    let verdict = if taken.passed { "passed" } else { "FAILED" };
    println!("{verdict}  {}: {} cases in {:.0} s", taken.measure, taken.score.cases, taken.seconds);
    println!("        {}", taken.promise);
    for (what, count) in &taken.score.counts {
        println!("        {count:>6}  {what}");
    }
    taken.score.left_out.iter().for_each(|what| println!("        left out: {what}"));
    taken.score.broken.iter().take(TOLD).for_each(|broken| println!("        broken: {broken}"));
    let more = taken.score.broken.len().saturating_sub(TOLD);
    if more > 0 {
        println!("        and {more} more");
    }
}
