//! Measurements that take longer than tests may: rates of right answers on simulated draws, errors and speed of models.

mod diagnosis;
mod models;
mod speed;
mod train;
mod ui;

use clap::Subcommand;

/// Measure how good the program is.
#[derive(Subcommand)]
pub enum Bench {
    Diagnosis(diagnosis::Diagnosis),
    Models(models::Models),
    Train(train::Train),
    Ui(ui::Ui),
}

impl Bench {
    /// Runs the benchmark.
    pub fn run(&self) -> anyhow::Result<()> {
        match self {
            Bench::Diagnosis(bench) => bench.run(),
            Bench::Models(bench) => bench.run(),
            Bench::Train(bench) => bench.run(),
            Bench::Ui(bench) => bench.run(),
        }
    }
}
