//! The command line: the same commands as in the window, without a window. One file per command.
//!
//! Results go to standard output, as text or with `--json` as JSON; progress and remarks go to standard error. Exit codes: 0
//! done, 1 failed, 2 wrong usage. With `--json` a failure is an object with its `reason` and `code`.

#[macro_use]
mod terminal;

mod bench;
mod choice;
mod columns;
mod completions;
mod convert;
mod data;
mod demo;
mod diagnose;
mod effects;
mod evaluate;
mod experiment;
mod export;
mod extrapolate;
mod failure;
mod figure;
mod gallery;
mod inspect;
mod lesson;
mod man;
mod of_part;
mod open;
mod predict;
mod progress;
mod propose;
mod pupil;
mod report;
mod saved;
mod screenshot;
mod seal;
mod selftest;
mod simulate;
mod table;
mod train;
mod truth;
mod world;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::file;
use crate::recording::read::parts;
use failure::OrUsage;
use table::TableFile;

/// Finds the physical effect that a robot arm's dynamics model is missing.
///
/// Without a command the window opens, on the given files, on a saved session, or on an embedded arm with a hidden effect.
#[derive(Parser)]
#[command(name = "torquescope", version, args_conflicts_with_subcommands = true, after_help = AFTER_HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// Print results and errors only: no progress, no remarks.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Write the tables that are printed into a file as well: Markdown, LaTeX (booktabs) or CSV, as its ending says (.md, .tex, .csv).
    #[arg(long, global = true, value_name = "FILE")]
    table: Option<PathBuf>,
    #[command(flatten)]
    window: open::Open,
}

const AFTER_HELP: &str = "Examples:
  torquescope
  torquescope gallery/sticky-shoulder
  torquescope my-log.csv --zero down
  torquescope mine.torquescope
  torquescope demo

Exit codes: 0 done, 1 failed, 2 wrong usage (of commands, options, their values, and the files that options name).
With --json a failure is told as an object with its reason and code.";

#[derive(Subcommand)]
enum Command {
    Open(open::Open),
    Demo(demo::Demo),
    Gallery(gallery::GalleryCommand),
    Simulate(simulate::Simulate),
    Inspect(inspect::Inspect),
    Convert(convert::Convert),
    Columns(columns::Columns),
    Diagnose(diagnose::Diagnose),
    Propose(propose::Propose),
    Train(train::Train),
    Evaluate(evaluate::Evaluate),
    Extrapolate(extrapolate::Extrapolate),
    Predict(predict::Predict),
    Export(export::Export),
    Report(report::ReportCommand),
    Effects(effects::Effects),
    #[command(subcommand)]
    Experiment(experiment::ExperimentCommand),
    Figure(figure::FigureCommand),
    Screenshot(screenshot::Screenshot),
    Lesson(lesson::LessonCommand),
    #[command(subcommand)]
    Seal(seal::SealCommand),
    #[command(subcommand)]
    Bench(bench::Bench),
    Selftest(selftest::Selftest),
    Completions(completions::Completions),
    Man(man::Man),
}

/// Runs what the arguments ask for.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = arguments.into_iter().collect();
    let as_json = words.iter().any(|word| word == "--json");
    let arguments = match Arguments::try_parse_from(&words).and_then(open::refuse_mistyped_command) {
        Ok(arguments) => arguments,
        Err(error) => return failure::tell_parsing(&error, as_json),
    };
    if arguments.quiet {
        progress::be_quiet();
    }
    match arguments.run_with_table(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::tell(&error, as_json),
    }
}

impl Arguments {
    /// Runs, and writes the tables that were printed if that was asked for.
    fn run_with_table(&self, words: &[OsString]) -> anyhow::Result<()> {
        let Some(path) = &self.table else { return self.run() };
        if words.iter().any(|word| word == "--json") {
            return Err(anyhow::anyhow!("--table: with --json no tables are printed, leave one of them out"))
                .or_usage();
        }
        let others = words.iter().map(Path::new).filter(|word| *word != path.as_path());
        let named = words.iter().filter(|word| Path::new(word) == path.as_path()).count();
        if named > 1 || others.flat_map(parts).any(|other| file::is_same(&other, path)) {
            return Err(anyhow::anyhow!(
                "--table {}: the command reads or writes this file itself; name another one",
                path.display()
            ))
            .or_usage();
        }
        let tables = TableFile::keep(path)?;
        self.run()?;
        tables.write()
    }

    fn run(&self) -> anyhow::Result<()> {
        let opens_window = match &self.command {
            None | Some(Command::Open(_)) => true,
            Some(Command::Lesson(command)) => command.opens_window(),
            _ => false,
        };
        if !opens_window {
            // As other commands do, it ends when nobody reads on: `… | head`. The window must not, by whatever it talks to.
            sigpipe::reset();
        }
        match &self.command {
            None => self.window.run(),
            Some(Command::Open(command)) => command.run(),
            Some(Command::Demo(command)) => command.run(),
            Some(Command::Gallery(command)) => command.run(),
            Some(Command::Simulate(command)) => command.run(),
            Some(Command::Inspect(command)) => command.run(),
            Some(Command::Convert(command)) => command.run(),
            Some(Command::Columns(command)) => command.run(),
            Some(Command::Diagnose(command)) => command.run(),
            Some(Command::Propose(command)) => command.run(),
            Some(Command::Train(command)) => command.run(),
            Some(Command::Evaluate(command)) => command.run(),
            Some(Command::Extrapolate(command)) => command.run(),
            Some(Command::Predict(command)) => command.run(),
            Some(Command::Export(command)) => command.run(),
            Some(Command::Report(command)) => command.run(),
            Some(Command::Effects(command)) => command.run(),
            Some(Command::Experiment(command)) => command.run(),
            Some(Command::Figure(command)) => command.run(),
            Some(Command::Screenshot(command)) => command.run(),
            Some(Command::Lesson(command)) => command.run(),
            Some(Command::Seal(command)) => command.run(),
            Some(Command::Bench(command)) => command.run(),
            Some(Command::Selftest(command)) => command.run(),
            Some(Command::Completions(command)) => command.run(),
            Some(Command::Man(command)) => command.run(),
        }
    }
}

/// Where a result is written; standard output if not given.
fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    use anyhow::Context;
    file::write(path, bytes)
        .with_context(|| format!("can't write {}: check the folder and its permissions", path.display()))
}

/// Names the folder that results go into, before anything is written there.
fn tell_folder(path: &Path) {
    progress::remark(format_args!("the results go into the folder {}", file::absolute(path).display()));
}

/// A folder that results go to, named, and made if it is not there.
fn output_folder(path: &Path) -> anyhow::Result<()> {
    use anyhow::Context;
    tell_folder(path);
    file::make_folder(path).with_context(|| format!("can't make the folder {}", path.display()))
}

#[cfg(test)]
mod tests {
    use clap::{Command, CommandFactory};

    use super::*;

    /// All commands that do something, by their full names.
    fn leaves() -> Vec<(String, Command)> {
        fn collect(name: &str, command: &Command, leaves: &mut Vec<(String, Command)>) {
            if !command.has_subcommands() {
                leaves.push((name.to_owned(), command.clone()));
            }
            for inner in command.get_subcommands() {
                collect(&format!("{name} {}", inner.get_name()), inner, leaves);
            }
        }
        let mut leaves = Vec::new();
        collect("torquescope", &Arguments::command(), &mut leaves);
        leaves
    }

    #[test]
    fn the_arguments_fit_each_other() {
        Arguments::command().debug_assert();
    }

    /// As a shell cuts them: what stands in single quotes is one word.
    fn shell_words(line: &str) -> Vec<String> {
        let mut words = vec![String::new()];
        for (index, part) in line.split('\'').enumerate() {
            let is_quoted = index % 2 == 1;
            for letter in part.chars() {
                match words.last_mut() {
                    Some(word) if is_quoted || !letter.is_whitespace() => word.push(letter),
                    _ => words.push(String::new()),
                }
            }
        }
        words.retain(|word| !word.is_empty());
        words
    }

    #[test]
    fn every_command_has_examples_that_can_be_parsed() {
        let top = ("torquescope".to_owned(), Arguments::command());
        for (name, command) in leaves().into_iter().chain([top]) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<&str> = help.lines().filter_map(|line| line.strip_prefix("  ")).collect();
            assert!(!examples.is_empty() || name.ends_with(" list"), "{name} has no example");
            for example in examples {
                let words = shell_words(example.split('#').next().unwrap_or_default());
                assert!(example.starts_with(&name), "{name}: {example}");
                let parsed = Arguments::try_parse_from(words);
                assert!(
                    parsed.is_ok(),
                    "{example}: {}",
                    parsed.err().map(|error| error.to_string()).unwrap_or_default()
                );
            }
        }
    }

    #[test]
    fn only_options_of_training_stand_under_its_heading() {
        let training: Vec<String> = <data::Training as clap::Args>::augment_args(Command::new("training"))
            .get_arguments()
            .map(|argument| argument.get_id().to_string())
            .collect();
        for (name, command) in leaves() {
            for argument in command.get_arguments() {
                let is_training = training.contains(&argument.get_id().to_string());
                let is_there = argument.get_help_heading() == Some(data::TRAINING);
                assert!(is_training || !is_there, "{name}: {}", argument.get_id());
            }
        }
    }

    /// What is written without being told where is not offered to be committed.
    #[test]
    fn folders_of_results_are_ignored() {
        let ignored = include_str!("../../.gitignore");
        let mut folders = Vec::new();
        for (_, command) in leaves() {
            let outputs =
                command.get_arguments().filter(|argument| ["out", "output"].contains(&argument.get_id().as_str()));
            folders.extend(outputs.flat_map(|output| output.get_default_values().to_vec()));
        }
        assert!(folders.len() >= 3, "{folders:?}");
        for folder in folders {
            let line = format!("/{}", folder.to_string_lossy());
            assert!(ignored.lines().any(|other| other == line), ".gitignore lacks {line}");
        }
    }
}
