//! Measurements that take longer than tests may: rates of right answers on simulated draws.

mod models;
mod speed;
mod train;

use clap::{Args, Subcommand};
use serde::Serialize;

use super::progress;
use super::table::{number, table};
use crate::diagnosis::{Report, Verdict};
use crate::effect::{Scope, registry};
use crate::progress::Monitor;
use crate::recording::seal::{HiddenEffect, Truth};
use crate::session::{Command, Session, SessionError};
use crate::simulation::Scenario;

/// Measure how good the program is.
#[derive(Subcommand)]
pub enum Bench {
    Diagnosis(Diagnosis),
    Models(models::Models),
    Train(train::Train),
}

impl Bench {
    /// Runs the benchmark.
    pub fn run(&self) -> anyhow::Result<()> {
        match self {
            Bench::Diagnosis(bench) => bench.run(),
            Bench::Models(bench) => bench.run(),
            Bench::Train(bench) => bench.run(),
        }
    }
}

/// How often the diagnosis is right on simulated three-joint arms with one hidden effect, or none.
///
/// For each effect and each strength, `--draws` recordings are simulated with other motion, noise and place; the diagnosis
/// sees the recording only, and the seal is opened afterwards to score it.
#[derive(Args)]
pub struct Diagnosis {
    /// Recordings for each effect and strength.
    #[arg(long, default_value_t = 5)]
    draws: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Strengths: RMS of the effect's torque as a fraction of the joint's torque.
    #[arg(long, value_delimiter = ',', default_values_t = [0.03, 0.1, 0.2])]
    strengths: Vec<f64>,
    /// Torque noise, as a fraction of each joint's torque RMS.
    #[arg(long, default_value_t = 0.02)]
    noise: f64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    /// Id of the hidden effect, or `none`.
    hidden: String,
    /// Strength, 0 for none.
    strength: f64,
    draws: u64,
    /// The right effect is named first (nothing, where nothing is hidden).
    first_right: u64,
    /// Exactly the hidden effect is named, on exactly its joints.
    exact: u64,
    /// True parameters inside their 95 % intervals.
    covered: u64,
    /// Parameters whose interval was checked.
    intervals: u64,
    /// Median of held-out nMSE after adding, over the noise floor.
    error_over_noise_floor: f64,
    seconds_per_recording: f64,
}

impl Diagnosis {
    fn run(&self) -> anyhow::Result<()> {
        let mut cases: Vec<(Option<&'static str>, f64)> = vec![(None, 0.0)];
        for effect in registry::ALL {
            cases.extend(self.strengths.iter().map(|&strength| (Some(effect.spec().id), strength)));
        }
        let (draws, seed, noise) = (self.draws, self.seed, self.noise);
        let rows: Vec<Row> = progress::watch("bench diagnosis", move |monitor| {
            let row = |(index, (effect, strength)): (usize, (Option<&'static str>, f64))| {
                monitor
                    .report(index as f32 / cases.len() as f32, effect.unwrap_or("none"))
                    .map_err(SessionError::from)?;
                // Every row has seeds of its own, so that no draw is counted twice.
                row(effect, strength, seed + draws * index as u64, draws, noise, monitor)
            };
            cases.iter().copied().enumerate().map(row).collect::<Result<Vec<_>, SessionError>>()
        })?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rows)?);
            return Ok(());
        }
        let percent = |part: u64, whole: u64| if whole == 0 { "–".to_owned() } else { format!("{part}/{whole}") };
        let cells: Vec<Vec<String>> = rows
            .iter()
            .map(|row| {
                vec![
                    row.hidden.clone(),
                    if row.strength > 0.0 { format!("{:.0} %", 100.0 * row.strength) } else { "–".to_owned() },
                    percent(row.first_right, row.draws),
                    percent(row.exact, row.draws),
                    percent(row.covered, row.intervals),
                    number(row.error_over_noise_floor),
                    number(row.seconds_per_recording),
                ]
            })
            .collect();
        let header = [
            "hidden",
            "strength",
            "first right",
            "exact",
            "95 % interval holds truth",
            "error / noise floor",
            "s each",
        ];
        println!("{}", table(&header, &cells));
        let sum = |part: fn(&Row) -> u64| rows.iter().map(part).sum::<u64>();
        println!(
            "\nfirst right {} of {}, exact {} of {}, truth inside the 95 % interval {} of {}",
            sum(|row| row.first_right),
            sum(|row| row.draws),
            sum(|row| row.exact),
            sum(|row| row.draws),
            sum(|row| row.covered),
            sum(|row| row.intervals)
        );
        Ok(())
    }
}

fn row(
    effect: Option<&str>,
    strength: f64,
    seed: u64,
    draws: u64,
    noise: f64,
    monitor: &Monitor,
) -> Result<Row, SessionError> {
    let mut row = Row {
        hidden: effect.unwrap_or("none").to_owned(),
        strength,
        draws,
        first_right: 0,
        exact: 0,
        covered: 0,
        intervals: 0,
        error_over_noise_floor: f64::NAN,
        seconds_per_recording: 0.0,
    };
    let mut ratios = Vec::new();
    for draw in 0..draws {
        monitor.check()?;
        let scenario = scenario(effect, strength, seed + draw, noise)?;
        let recorded = Command::Simulate(Box::new(scenario)).run(&Session::default(), monitor)?;
        let begin = std::time::Instant::now();
        let diagnosed = Command::Diagnose.run(&recorded, monitor)?;
        row.seconds_per_recording += begin.elapsed().as_secs_f64() / draws as f64;
        // Only now, after the diagnosis has spoken, is the seal opened.
        let opened = Command::OpenSeal.run(&diagnosed, monitor)?;
        let (Some(report), Some(truth)) = (&opened.report, &opened.truth) else { continue };
        score(&mut row, report, truth);
        if let (Some(last), Some(floor)) = (report.effects.last(), &report.noise_floor_nmse) {
            let ratio = last.nmse_after.iter().sum::<f64>() / floor.iter().sum::<f64>();
            ratios.push(ratio);
        }
    }
    ratios.sort_by(f64::total_cmp);
    row.error_over_noise_floor = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
    Ok(row)
}

/// The embedded arm, moved anew for each seed; the effect on one joint, or on two for every third seed.
fn scenario(effect: Option<&str>, strength: f64, seed: u64, noise: f64) -> Result<Scenario, SessionError> {
    let mut scenario = Scenario { seed, torque_noise: noise, effects: Vec::new(), ..Scenario::embedded() };
    if let Some(effect) = effect {
        let first = seed as usize % 3;
        let joints = if seed.is_multiple_of(3) { vec![first, (first + 1) % 3] } else { vec![first] };
        scenario.effects = scenario.hide_by_strength(effect, &joints, strength)?;
    }
    Ok(scenario)
}

fn score(row: &mut Row, report: &Report, truth: &Truth) {
    let Some(first) = truth.effects.first() else {
        let silent = u64::from(report.verdict == Verdict::NothingMissing && report.effects.is_empty());
        row.first_right += silent;
        row.exact += silent;
        return;
    };
    let named_first = report.effects.first().is_some_and(|named| named.effect == first.effect);
    row.first_right += u64::from(named_first);
    let whole_arm = registry::find(&first.effect).is_ok_and(|effect| effect.spec().scope == Scope::Arm);
    let mut joints: Vec<usize> = truth.effects.iter().filter_map(|effect| effect.joint).collect();
    joints.sort_unstable();
    let exact = named_first && report.effects.len() == 1 && (whole_arm || report.effects[0].joints == joints);
    row.exact += u64::from(exact);
    if exact {
        for hidden in &truth.effects {
            let (covered, intervals) = coverage(hidden, report);
            row.covered += covered;
            row.intervals += intervals;
        }
    }
}

/// How many of the true parameters lie inside their intervals, and how many intervals there are.
fn coverage(hidden: &HiddenEffect, report: &Report) -> (u64, u64) {
    let Ok(effect) = registry::find(&hidden.effect) else { return (0, 0) };
    let mut counts = (0, 0);
    for (spec, &value) in effect.spec().parameters.iter().zip(&hidden.parameters) {
        let estimates = report.effects.iter().flat_map(|effect| &effect.parameters);
        let found = estimates.filter(|estimate| estimate.name == spec.name && estimate.joint == hidden.joint);
        for [low, high] in found.filter_map(|estimate| estimate.interval) {
            counts.1 += 1;
            counts.0 += u64::from((low..=high).contains(&value));
        }
    }
    counts
}
