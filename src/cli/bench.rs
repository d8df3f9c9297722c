//! Measurements that take longer than tests may: rates of right answers on simulated draws, errors and speed of models.

mod calibrate;
mod diagnosis;
mod held_out;
mod planted;
mod rates;
mod read;
mod recipe;
mod recordings;
mod speed;
mod stability;
mod stuck;
mod train;
mod ui;

use clap::Subcommand;

/// Measure how good the program is.
#[derive(Subcommand)]
pub enum Bench {
    Calibrate(calibrate::Calibrate),
    Diagnosis(diagnosis::Diagnosis),
    HeldOut(held_out::HeldOutBench),
    Planted(planted::Planted),
    Stability(stability::StabilityBench),
    Read(read::Read),
    Recipe(recipe::RecipeBench),
    Stuck(stuck::Stuck),
    Train(train::Train),
    Ui(ui::Ui),
}

impl Bench {
    /// Runs the benchmark.
    pub fn run(&self) -> anyhow::Result<()> {
        match self {
            Bench::Calibrate(bench) => bench.run(),
            Bench::Diagnosis(bench) => match &bench.recordings {
                Some(folder) => recordings::run(folder, bench.json, bench.list),
                None if bench.world => bench.run_worlds(),
                None => bench.run(),
            },
            Bench::HeldOut(bench) => bench.run(),
            Bench::Planted(bench) => bench.run(),
            Bench::Stability(bench) => bench.run(),
            Bench::Read(bench) => bench.run(),
            Bench::Recipe(bench) => bench.run(),
            Bench::Stuck(bench) => bench.run(),
            Bench::Train(bench) => bench.run(),
            Bench::Ui(bench) => bench.run(),
        }
    }
}
