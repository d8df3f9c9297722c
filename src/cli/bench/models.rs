use std::collections::HashMap;

use anyhow::Context;
use clap::Args;
use serde::Serialize;

use crate::cli::data::Training;
use crate::cli::progress;
use crate::cli::table::{number, numbers, table};
use crate::model::learned::LearnedPreset;
use crate::model::{Fitted, Preset};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::{Segment, Split};
use crate::session::SessionError;
use crate::simulation::{Excitation, Scenario, simulate};
use crate::training::components;
use crate::training::fit::{Plan, fit};

/// The paper's table 2, as published.
const PAPER: &str = include_str!("../../../assets/paper/table-2.csv");
/// Test sets of the paper's simulated experiment: name, speed, range of angles \[rad\].
const TEST_SETS: [(&str, f64, f64); 3] = [("iid", 1.0, 3.0), ("non-iid-0", 2.5, 3.0), ("non-iid-1", 1.0, 10.0)];
/// Torque and its three components.
const QUANTITIES: [&str; 4] = ["torque", "inertial", "coriolis", "gravity"];

/// The five models of the paper on its simulated arm: errors of torque and components, beside the paper's.
///
/// Test sets: iid; non-iid-0, the same trajectories 2.5 times as fast; non-iid-1, angles up to 10 rad.
#[derive(Args)]
pub struct Models {
    #[command(flatten)]
    training: Training,
    /// Only this model.
    #[arg(long, value_parser = parse_preset)]
    only: Option<LearnedPreset>,
    /// How many seeds, each with training data and first weights of its own.
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// Trajectories of each test set; the paper has 3, which is a small set.
    #[arg(long, default_value_t = 100)]
    test_trajectories: usize,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

fn parse_preset(text: &str) -> Result<LearnedPreset, String> {
    let known = || LearnedPreset::ALL.map(LearnedPreset::id).join(", ");
    LearnedPreset::parse(text).ok_or_else(|| format!("there is no model `{text}`; known: {}", known()))
}

/// One model on one test set, means over the seeds.
#[derive(Debug, Clone, Serialize)]
struct Cell {
    model: &'static str,
    test_set: &'static str,
    seeds: u64,
    nmse_torque: f64,
    nmse_inertial: f64,
    nmse_coriolis: f64,
    nmse_gravity: f64,
    mse_joint: Vec<f64>,
    r2: f64,
    /// The paper's values by quantity, as far as printed.
    paper: HashMap<String, f64>,
}

/// Errors of one trained model on one test set.
struct Errors {
    nmse: [f64; 4],
    mse_joint: Vec<f64>,
    r2: f64,
}

impl Models {
    /// Trains, measures, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let presets: Vec<LearnedPreset> =
            LearnedPreset::ALL.into_iter().filter(|preset| self.only.is_none_or(|only| only == *preset)).collect();
        let mut cells = Vec::new();
        for preset in presets {
            let (plan, seeds, count) = (self.training.plan(), self.seeds, self.test_trajectories);
            let runs: Vec<Vec<Errors>> = progress::watch(preset.title(), move |monitor| {
                (0..seeds).map(|seed| one_seed(preset, &plan, seed, count, monitor)).collect::<anyhow::Result<Vec<_>>>()
            })?;
            cells.extend((0..TEST_SETS.len()).map(|set| cell(preset, set, &runs)));
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&serde_json::json!({ "cells": cells }))?);
            return Ok(());
        }
        let row = |cell: &Cell| {
            let beside = |value: f64, quantity: &str| match cell.paper.get(quantity) {
                Some(paper) => format!("{} ({})", number(value), number(*paper)),
                None => number(value),
            };
            vec![
                cell.model.to_owned(),
                cell.test_set.to_owned(),
                beside(cell.nmse_torque, "nmse_torque"),
                beside(cell.nmse_inertial, "nmse_inertial"),
                beside(cell.nmse_coriolis, "nmse_coriolis"),
                beside(cell.nmse_gravity, "nmse_gravity"),
                numbers(&cell.mse_joint),
                format!("{:.4}", cell.r2),
            ]
        };
        let rows: Vec<Vec<String>> = cells.iter().map(row).collect();
        let header =
            ["model", " test set", "nMSE torque", "inertial", "Coriolis", "gravity", "MSE by joint [(N m)²]", "R²"];
        println!("{}\n\nIn brackets: the paper. Mean over {} seeds.", table(&header, &rows), self.seeds);
        Ok(())
    }
}

fn one_seed(
    preset: LearnedPreset,
    plan: &Plan,
    seed: u64,
    test_trajectories: usize,
    monitor: &Monitor,
) -> anyhow::Result<Vec<Errors>> {
    let recording = simulate(&Scenario::paper(1 + seed), monitor).map_err(SessionError::from)?;
    let all = |recording: &Recording| -> Vec<Segment> {
        let trajectories = recording.trajectories.iter().enumerate();
        trajectories.map(|(trajectory, data)| Segment { trajectory, samples: 0..data.len() }).collect()
    };
    let split = Split { train: all(&recording), held_out: Vec::new() };
    let model = Preset::Learned(preset).model(&recording)?;
    let mut plan = plan.clone();
    plan.options.seed = seed;
    let trained = fit(&model, &recording, &split, &plan, None, monitor, &mut |_, _| {})?;
    let test = |(_, speed, range): (&str, f64, f64)| -> anyhow::Result<Errors> {
        let motion =
            Excitation::PaperPointToPoint { trajectories: test_trajectories, duration: 4.0, samples: 400, range };
        // iid and non-iid-0 are the same paths at two speeds; no training set has this seed.
        let scenario = Scenario { motion, speed_scale: speed, ..Scenario::paper(1_000_000 + seed) };
        errors(&trained.fitted, &simulate(&scenario, monitor).map_err(SessionError::from)?)
    };
    TEST_SETS.into_iter().map(test).collect()
}

fn errors(fitted: &Fitted, recording: &Recording) -> anyhow::Result<Errors> {
    let arm = recording.stated_arm.as_ref().context("the simulation states its arm")?;
    let joints = recording.joint_count();
    let mut squares = [[0.0; 2]; 4];
    let mut by_joint = vec![[0.0; 3]; joints];
    for trajectory in &recording.trajectories {
        let torque = fitted.predict(trajectory)?.total;
        let own = components(fitted, trajectory)?;
        let parts = arm.components_along(&trajectory.q, &trajectory.qd, &trajectory.qdd);
        let component = |name: &str| own.iter().find(|(other, _)| *other == name).map(|(_, torque)| torque);
        let exact = [&trajectory.tau, &parts.inertial, &parts.coriolis, &parts.gravity];
        for (index, exact) in exact.into_iter().enumerate() {
            let estimate = if index == 0 { Some(&torque) } else { component(QUANTITIES[index]) };
            for (exact, estimate) in exact.iter().flatten().zip(estimate.into_iter().flatten().flatten()) {
                squares[index][0] += (exact - estimate).powi(2);
                squares[index][1] += exact * exact;
            }
        }
        for (joint, sums) in by_joint.iter_mut().enumerate() {
            for (exact, estimate) in trajectory.tau[joint].iter().zip(&torque[joint]) {
                sums[0] += (exact - estimate).powi(2);
                sums[1] += exact;
                sums[2] += exact * exact;
            }
        }
    }
    let samples = recording.sample_count() as f64;
    let error: f64 = by_joint.iter().map(|sums| sums[0]).sum();
    let spread: f64 = by_joint.iter().map(|sums| sums[2] - sums[1] * sums[1] / samples).sum();
    Ok(Errors {
        nmse: squares.map(|[error, energy]| error / energy),
        mse_joint: by_joint.iter().map(|sums| sums[0] / samples).collect(),
        r2: 1.0 - error / spread,
    })
}

fn cell(preset: LearnedPreset, set: usize, runs: &[Vec<Errors>]) -> Cell {
    let mean =
        |value: &dyn Fn(&Errors) -> f64| runs.iter().map(|sets| value(&sets[set])).sum::<f64>() / runs.len() as f64;
    let joints = runs.first().map_or(0, |sets| sets[set].mse_joint.len());
    let test_set = TEST_SETS[set].0;
    let published = PAPER.lines().filter_map(|line| {
        let mut fields = line.split(',');
        let of_cell = fields.next() == Some(test_set) && fields.next() == Some(preset.id());
        if of_cell { Some((fields.next()?.to_owned(), fields.next()?.parse().ok()?)) } else { None }
    });
    Cell {
        model: preset.id(),
        test_set,
        seeds: runs.len() as u64,
        nmse_torque: mean(&|errors| errors.nmse[0]),
        nmse_inertial: mean(&|errors| errors.nmse[1]),
        nmse_coriolis: mean(&|errors| errors.nmse[2]),
        nmse_gravity: mean(&|errors| errors.nmse[3]),
        mse_joint: (0..joints).map(|joint| mean(&|errors| errors.mse_joint[joint])).collect(),
        r2: mean(&|errors| errors.r2),
        paper: published.collect(),
    }
}
