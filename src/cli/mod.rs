//! The command line: the same commands as in the window, without a window. One file per command.
//!
//! Results go to standard output, as text or with `--json` as JSON; progress goes to standard error if it is a terminal.
//! Exit codes: 0 done, 1 failed, 2 wrong usage.

mod bench;
mod data;
mod demo;
mod diagnose;
mod evaluate;
mod experiment;
mod extrapolate;
mod figure;
mod inspect;
mod predict;
mod progress;
mod screenshot;
mod simulate;
mod table;
mod train;
mod truth;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::app;
use crate::session::Session;

/// Finds the physical effect that a robot arm's dynamics model is missing.
///
/// Without a command the window opens, on the given files or on an embedded arm with a hidden effect.
#[derive(Parser)]
#[command(name = "torquescope", version, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    data: data::OptionalData,
}

#[derive(Subcommand)]
enum Command {
    Simulate(simulate::Simulate),
    Inspect(inspect::Inspect),
    Train(train::Train),
    Evaluate(evaluate::Evaluate),
    Extrapolate(extrapolate::Extrapolate),
    Predict(predict::Predict),
    Diagnose(diagnose::Diagnose),
    #[command(subcommand)]
    Experiment(experiment::ExperimentCommand),
    Demo(demo::Demo),
    Screenshot(screenshot::Screenshot),
    Figure(figure::FigureCommand),
    #[command(subcommand)]
    Bench(bench::Bench),
}

/// Runs what the arguments ask for.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are no failures; clap knows which code is due. A closed pipe is not worth a message.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    if arguments.command.is_some() {
        // As other commands do, it ends when nobody reads on: `… | head`. The window must not, by whatever it talks to.
        sigpipe::reset();
    }
    let result = match arguments.command {
        None => open_window(&arguments.data),
        Some(Command::Simulate(command)) => command.run(),
        Some(Command::Inspect(command)) => command.run(),
        Some(Command::Train(command)) => command.run(),
        Some(Command::Evaluate(command)) => command.run(),
        Some(Command::Extrapolate(command)) => command.run(),
        Some(Command::Predict(command)) => command.run(),
        Some(Command::Diagnose(command)) => command.run(),
        Some(Command::Experiment(command)) => command.run(),
        Some(Command::Demo(command)) => command.run(),
        Some(Command::Screenshot(command)) => command.run(),
        Some(Command::Figure(command)) => command.run(),
        Some(Command::Bench(command)) => command.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn open_window(data: &data::OptionalData) -> anyhow::Result<()> {
    app::run_window(Session::default(), Some(data.command()?))
}

/// Where a result is written; standard output if not given.
fn write_file(path: &PathBuf, bytes: &[u8]) -> anyhow::Result<()> {
    use anyhow::Context;
    std::fs::write(path, bytes)
        .with_context(|| format!("can't write {}: check the folder and its permissions", path.display()))
}
