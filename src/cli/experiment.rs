use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::{Args, Subcommand};
use serde_json::json;

use super::choice::one_of;
use super::failure::OrUsage;
use super::figure::{FORMATS, FigureLook};
use super::table::{number, numbers, table};
use super::{output_folder, progress, write_file};
use crate::experiment::figures::{NamedFigure, figures};
use crate::experiment::run::{State, duration_text, state, training_record};
use crate::experiment::summary::above_paper;
use crate::experiment::{Cell, Experiment, Report, Row, Shard, Store, catalogue, plan, run, summarise};
use crate::figure::{Format, files};

/// Run data × models × seeds, and hold the errors against the paper's.
#[derive(Subcommand)]
pub enum ExperimentCommand {
    Run(Run),
    Status(Status),
    Collect(Collect),
    Figures(Figures),
    List(List),
}

/// Which experiment, and where its results are.
#[derive(Args, Clone)]
struct Which {
    /// Name of a built-in experiment (see `experiment list`), or a TOML file.
    experiment: String,
    /// The small version: less training, fewer seeds and test sets.
    #[arg(long)]
    quick: bool,
    /// Only these models.
    #[arg(long, value_name = "MODEL", num_args = 1..)]
    only: Vec<String>,
    /// Folder of the results; experiments share what they have in common.
    #[arg(long, default_value = "experiments")]
    out: PathBuf,
    /// Folder of the recordings that the experiment asks for.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

/// Run what is not done yet. A stopped run goes on where it was; several may work on one folder.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope experiment run table-2 --quick
  torquescope experiment run dfki --data LOGS --only rigid-body
  torquescope experiment run table-2 --shard 1/4")]
pub struct Run {
    #[command(flatten)]
    which: Which,
    /// Take only every n-th cell, from the k-th on: for jobs on several machines that share the folder.
    #[arg(long, value_name = "K/N", default_value = "1/1")]
    shard: Shard,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// Tell what is done, what is being done and what failed.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope experiment status table-2 --quick")]
pub struct Status {
    #[command(flatten)]
    which: Which,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// Join the results that are there.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope experiment collect table-2 --csv table.csv")]
pub struct Collect {
    #[command(flatten)]
    which: Which,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    /// Save it as CSV too.
    #[arg(long, value_name = "TABLE.csv")]
    csv: Option<PathBuf>,
}

/// Draw what was run: trajectories, torques and their parts, curves, motions, errors.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope experiment figures velocity --format svg pdf -o figures")]
pub struct Figures {
    #[command(flatten)]
    which: Which,
    /// Only figures whose name contains this: trajectories, torques, curve, motions, errors.
    #[arg(long, value_name = "NAME")]
    figure: Option<String>,
    /// Kinds of files.
    #[arg(long, value_name = "KIND", value_parser = one_of(FORMATS), num_args = 1.., default_values = ["svg", "csv"])]
    format: Vec<Format>,
    #[command(flatten)]
    look: FigureLook,
    /// Folder of the files, EXPERIMENT-FIGURE.KIND each.
    #[arg(short, long, value_name = "DIR", default_value = "figures")]
    output: PathBuf,
}

/// List the built-in experiments.
#[derive(Args)]
pub struct List {}

impl ExperimentCommand {
    /// Does what was asked for.
    pub fn run(&self) -> anyhow::Result<()> {
        match self {
            ExperimentCommand::Run(command) => command.run(),
            ExperimentCommand::Status(command) => command.run(),
            ExperimentCommand::Collect(command) => command.run(),
            ExperimentCommand::Figures(command) => command.run(),
            ExperimentCommand::List(_) => list(),
        }
    }
}

impl Which {
    fn experiment(&self) -> anyhow::Result<Experiment> {
        let experiment = catalogue::open(&self.experiment).or_usage()?.only(&self.only).or_usage()?;
        Ok(if self.quick { experiment.quick() } else { experiment })
    }

    /// What to do where nothing is there: the other version may be.
    fn advice(&self) -> anyhow::Result<String> {
        let other = Which { quick: !self.quick, ..self.clone() };
        let (_, cells, store) = other.cells()?;
        let found =
            cells.iter().map(|cell| state(&store, cell)).filter(|state| matches!(state, Ok(State::Done))).count();
        Ok(match (found, self.quick) {
            (0, false) => format!("run `experiment run {}` first, or name its folder with --out", self.experiment),
            (0, true) => {
                format!("run `experiment run {} --quick` first, or name its folder with --out", self.experiment)
            }
            (1, false) => "1 cell of the quick version is there: add --quick".to_owned(),
            (1, true) => "1 cell of the whole version is there: leave out --quick".to_owned(),
            (found, false) => format!("{found} cells of the quick version are there: add --quick"),
            (found, true) => format!("{found} cells of the whole version are there: leave out --quick"),
        })
    }

    fn cells(&self) -> anyhow::Result<(Experiment, Vec<Cell>, Store)> {
        let experiment = self.experiment()?;
        if let Some(folder) = self.data.as_deref().filter(|folder| !folder.is_dir()) {
            return Err(anyhow!("--data: there is no folder {}", folder.display())).or_usage();
        }
        let cells = plan(&experiment, self.data.as_deref())?;
        Ok((experiment, cells, Store::new(&self.out)))
    }
}

impl Run {
    fn run(&self) -> anyhow::Result<()> {
        let (experiment, cells, store) = self.which.cells()?;
        output_folder(&self.which.out)?;
        let (data, shard) = (self.which.data.clone(), self.shard);
        let work = (experiment.clone(), store.clone());
        let report =
            progress::watch("experiment", move |monitor| run(&work.0, &work.1, data.as_deref(), shard, monitor))?;
        for problem in &report.damaged {
            progress::remark(format_args!("warning: {problem}"));
        }
        if self.json {
            // One object on standard output: either the results, or why some are missing.
            tell(&report)?;
        }
        print(&experiment, &summarise(&experiment, &cells, &store)?, self.json)?;
        tell(&report)
    }
}

/// What is not in the table.
fn tell(report: &Report) -> anyhow::Result<()> {
    if report.elsewhere > 0 {
        progress::remark(format_args!(
            "{} cells are being done elsewhere: `experiment collect` joins them when they are there",
            report.elsewhere
        ));
    }
    if report.failed.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> =
        report.failed.iter().map(|(model, seed, reason)| format!("{model}, seed {}: {reason}", seed + 1)).collect();
    bail!("{} cells could not be done:\n{}", lines.len(), lines.join("\n"))
}

impl Status {
    fn run(&self) -> anyhow::Result<()> {
        let (_, cells, store) = self.which.cells()?;
        let states = cells.iter().map(|cell| Ok((cell, state(&store, cell)?))).collect::<anyhow::Result<Vec<_>>>()?;
        if self.json {
            let cell = |(cell, state): &(&Cell, State)| json!({ "model": cell.model.name, "seed": cell.seed + 1, "key": cell.key, "state": state });
            println!(
                "{}",
                serde_json::to_string_pretty(&json!({ "cells": states.iter().map(cell).collect::<Vec<_>>() }))?
            );
            return Ok(());
        }
        let mut rows = Vec::new();
        for (cell, state) in &states {
            // Its state tells if it is damaged.
            let record = training_record(&store, cell).ok().flatten();
            let text = match state {
                State::Done => "done".to_owned(),
                State::Running(owner) => format!("process {} on {}", owner.process, owner.host),
                State::Failed(reason) => format!("failed: {reason}"),
                State::Damaged(problem) => problem.clone(),
                State::Open => "open".to_owned(),
            };
            let time = record.as_ref().map_or(String::new(), |record| duration_text(record.seconds));
            let named = record.map_or(String::new(), |record| match record.verdict {
                Some(verdict) if record.named.is_empty() => format!("nothing ({verdict})"),
                _ => record.named.join(" "),
            });
            rows.push(vec![cell.model.name.clone(), (cell.seed + 1).to_string(), time, text, cell.key.clone(), named]);
        }
        println!("{}", table(&["model", "seed", "trained in", " state", " folder", " named by the diagnosis"], &rows));
        let done = states.iter().filter(|(_, state)| *state == State::Done).count();
        println!("\n{done} of {} cells are done", states.len());
        if done == 0 {
            println!("{}", self.which.advice()?);
        }
        Ok(())
    }
}

impl Collect {
    fn run(&self) -> anyhow::Result<()> {
        let (experiment, cells, store) = self.which.cells()?;
        let rows = summarise(&experiment, &cells, &store)?;
        if rows.is_empty() {
            bail!("nothing of it is in {}: {}", self.which.out.display(), self.which.advice()?);
        }
        print(&experiment, &rows, self.json)?;
        match &self.csv {
            Some(path) => write_file(path, &csv(&rows)?),
            None => Ok(()),
        }
    }
}

impl Figures {
    fn run(&self) -> anyhow::Result<()> {
        let experiment = self.which.experiment()?;
        let (store, data, wanted) = (Store::new(&self.which.out), self.which.data.clone(), self.figure.clone());
        let work = experiment.clone();
        let all = progress::watch("figures", move |monitor| {
            figures(&work, &store, data.as_deref(), wanted.as_deref(), monitor)
        })?;
        if all.is_empty() {
            bail!("there is nothing to draw: {}, or ask for another figure", self.which.advice()?);
        }
        let (_, cells, store) = self.which.cells()?;
        if !cells.iter().any(|cell| matches!(state(&store, cell), Ok(State::Done))) {
            eprintln!("Only the data are drawn, since no model is there: {}.", self.which.advice()?);
        }
        output_folder(&self.output)?;
        let style = self.look.style();
        let stem = Path::new(&experiment.name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        for NamedFigure { name, figure } in &all {
            for format in &self.format {
                let path = self.output.join(format!("{stem}-{name}.{}", format.ending()));
                for (path, bytes) in files(figure, *format, &style, &path)? {
                    write_file(&path, &bytes)?;
                    progress::told(path.display());
                }
            }
        }
        Ok(())
    }
}

fn list() -> anyhow::Result<()> {
    for (name, _) in catalogue::ALL {
        let experiment = catalogue::find(name)?;
        println!("{name}: {}\n    {}", experiment.title, experiment.description.trim().replace('\n', "\n    "));
    }
    Ok(())
}

fn print(experiment: &Experiment, rows: &[Row], as_json: bool) -> anyhow::Result<()> {
    if as_json {
        println!("{}", serde_json::to_string_pretty(&json!({ "cells": rows }))?);
        return Ok(());
    }
    println!("{}\n", experiment.title);
    let mut lines = Vec::new();
    for row in rows {
        let beside = |value: Option<f64>, quantity: &str| {
            let Some(value) = value else { return "–".to_owned() };
            let half = row.interval.get(quantity).and_then(|ends| Some(ends[1].as_f64()? - value));
            let own = half.map_or(number(value), |half| format!("{} ± {}", number(value), number(half)));
            match row.paper.get(quantity) {
                Some(paper) => format!("{own} ({}, × {:.2})", number(*paper), value / paper),
                None => own,
            }
        };
        lines.push(vec![
            row.model.clone(),
            row.test_set.clone(),
            row.seeds.to_string(),
            beside(Some(row.nmse_torque), "nmse_torque"),
            beside(row.nmse_inertial, "nmse_inertial"),
            beside(row.nmse_coriolis, "nmse_coriolis"),
            beside(row.nmse_gravity, "nmse_gravity"),
            numbers(&row.mse_joint),
            format!("{:.4}", row.r2),
            row.band_coverage.map_or(String::new(), |share| format!("{:.0} %", 100.0 * share)),
        ]);
    }
    let mse = format!("MSE by joint [{}]", rows.first().map_or("", |row| row.mse_unit));
    let header =
        ["model", " test set", "seeds", "nMSE torque", "inertial", "Coriolis", "gravity", &mse, "R²", "in band"];
    println!("{}", table(&header, &lines));
    println!(
        "\nMean over seeds ± half of its 95 % interval; in brackets the paper's value, and ours as a multiple of it."
    );
    let (above, count) = above_paper(rows);
    match above.len() {
        0 if count > 0 => println!("All {count} values that the paper has too are at or below the paper's."),
        0 => {}
        some => println!("{some} of {count} values are above the paper's: {}.", above.join("; ")),
    }
    for model in experiment.models.iter().filter(|model| !model.note.is_empty()) {
        println!("{}: {}", model.name, model.note);
    }
    Ok(())
}

fn csv(rows: &[Row]) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["model", "test_set", "curve", "x", "seeds", "quantity", "mean", "low", "high", "paper"])?;
    for row in rows {
        let (curve, x) = row
            .point
            .as_ref()
            .map_or((String::new(), String::new()), |point| (point.curve.clone(), point.x.to_string()));
        let mut line = |quantity: String, value: Option<f64>, ends: Option<&serde_json::Value>| -> anyhow::Result<()> {
            let Some(value) = value else { return Ok(()) };
            let end =
                |index: usize| ends.and_then(|ends| ends[index].as_f64()).map_or(String::new(), |end| end.to_string());
            let paper = row.paper.get(&quantity).map_or(String::new(), f64::to_string);
            writer.write_record([
                &row.model,
                &row.test_set,
                &curve,
                &x,
                &row.seeds.to_string(),
                &quantity,
                &value.to_string(),
                &end(0),
                &end(1),
                &paper,
            ])?;
            Ok(())
        };
        for (name, value) in [
            ("nmse_torque", Some(row.nmse_torque)),
            ("nmse_inertial", row.nmse_inertial),
            ("nmse_coriolis", row.nmse_coriolis),
            ("nmse_gravity", row.nmse_gravity),
            ("r2", Some(row.r2)),
        ] {
            line(name.to_owned(), value, row.interval.get(name))?;
        }
        for (joint, value) in row.mse_joint.iter().enumerate() {
            line(format!("mse_joint_{joint}"), Some(*value), row.interval.get("mse_joint").map(|ends| &ends[joint]))?;
        }
    }
    Ok(writer.into_inner()?)
}
