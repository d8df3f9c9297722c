use clap::Args;

use super::speed::{self, Report, Speed};
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::network::team::default_threads;

/// How fast networks are trained and asked, and how soon the structured one is as accurate as the paper's.
///
/// Batches of the paper's size on data of its simulated arm. Speeds are of the best epoch, since other programs disturb.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench train
  torquescope bench train --threads 1 --json")]
pub struct Train {
    /// Threads.
    #[arg(long)]
    threads: Option<usize>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

impl Train {
    /// Measures and prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let threads = self.threads.unwrap_or_else(default_threads);
        let report = progress::watch("bench train", move |monitor| speed::report(threads, monitor))?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&report)?);
        } else {
            println!("{}", text(&report));
        }
        Ok(())
    }
}

fn text(report: &Report) -> String {
    let row = |speed: &Speed| {
        vec![
            speed.model.clone(),
            speed.joints.to_string(),
            speed.batch.to_string(),
            speed.hidden.iter().map(usize::to_string).collect::<Vec<_>>().join("×"),
            number(1e3 / speed.wall_ms_per_step),
            number(speed.samples_per_s),
            number(speed.cpu_ms_per_step),
            number(speed.gflops),
            format!("{:.0}", 100.0 * speed.gflops / report.peak_of_all_gflops),
        ]
    };
    let rows: Vec<Vec<String>> = report.models.iter().map(row).collect();
    let header = ["model", "joints", "batch", "hidden", "steps/s", "samples/s", "CPU ms/step", "GFLOP/s", "% of peak"];
    let mut text = table(&header, &rows);
    text += &format!(
        "\n\npeak (f32): one core alone {} GFLOP/s, all threads together {} GFLOP/s",
        number(report.peak_gflops),
        number(report.peak_of_all_gflops)
    );
    for inference in &report.inference {
        text += &format!(
            "\ntorque of {} ({} joints, chunks of {}): {} samples/s, {} ns of CPU time a sample, {} GFLOP/s ({:.0} % of peak)",
            inference.model,
            inference.joints,
            inference.chunk,
            number(inference.samples_per_s),
            number(inference.cpu_ns_per_sample),
            number(inference.gflops),
            100.0 * inference.gflops / report.peak_of_all_gflops
        );
    }
    text += &report.peak_memory_mib.map_or(String::new(), |peak| format!("\npeak memory: {} MiB", number(peak)));
    if let Some(accuracy) = &report.paper_accuracy {
        text += &format!(
            "\nstructured DeLaN at nMSE {} (the paper's is 8.1e-6) after {:.2} s of CPU time, {:.2} s by the clock",
            number(accuracy.nmse),
            accuracy.cpu_s,
            accuracy.wall_s
        );
    }
    text
}
