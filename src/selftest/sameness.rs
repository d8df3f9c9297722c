//! The same seed gives the same bytes: twice, and on any number of threads.

use std::collections::BTreeSet;

use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::effect::{Effect, Stage, registry};
use crate::model::learned::{Layers, LearnedPreset};
use crate::progress::Monitor;
use crate::recording::encoders::Side;
use crate::recording::write::to_npz_bytes;
use crate::session::{Command, Session, SessionError};
use crate::simulation::Scenario;
use crate::training::Options;
use crate::training::fit::{self, Plan};
use crate::trial::TrialError;
use crate::trial::blind::Drawing;

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "sameness",
    promise: "simulation, training and diagnosis give the same bytes from the same seed, twice and on 1, 2, 3 and 4 threads",
    take,
};

const THREADS: [usize; 5] = [1, 1, 2, 3, 4];

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let cases = bench.cases(2, 20);
    let mut score = Score { cases: cases * THREADS.len(), ..Score::default() };
    for case in 0..cases {
        let seed = bench.effort.seed + case as u64;
        let mut seen: [BTreeSet<Vec<u8>>; 4] = Default::default();
        for (number, threads) in THREADS.into_iter().enumerate() {
            bench.report(case * THREADS.len() + number, score.cases, "the same on other threads")?;
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|error| SelftestError::making("threads")(&error))?;
            let (made, late) = pool.install(|| (made(seed, threads), late(seed)));
            let made = made.map_err(|error| SelftestError::making("results")(&error))?;
            let late = late.map_err(|error| SelftestError::making("a diagnosis")(&error))?;
            for (seen, bytes) in seen.iter_mut().zip(made.into_iter().chain([late])) {
                seen.insert(bytes);
            }
        }
        let kinds = ["simulations", "trainings", "diagnoses", "diagnoses of late readings"];
        for (what, seen) in kinds.into_iter().zip(seen) {
            score.count(format!("{what} {}", if seen.len() == 1 { "alike" } else { "that differ" }));
            score.demand(seen.len() == 1, || format!("seed {seed}: {} different {what}", seen.len()));
        }
    }
    Ok(score)
}

/// A recording, a trained model and a diagnosis.
fn made(seed: u64, threads: usize) -> Result<[Vec<u8>; 3], SessionError> {
    let monitor = Monitor::new();
    let effects = Scenario::embedded().effects.into_iter().take(1).collect();
    let simulate = Command::Simulate(Box::new(Scenario { effects, ..seeds::scenario(seed) }));
    let session = simulate.run(&Session::default(), &monitor)?;
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let simulated = to_npz_bytes(recording).unwrap_or_default();
    let options = Options { epochs: 4, batch: 64, threads: Some(threads), seed, ..Options::ours() };
    let plan = Plan { options, layers: Layers { hidden: vec![8], ..Layers::default() }, ..Plan::default() };
    let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: Box::new(plan) };
    let trained = train.run(&session, &monitor)?;
    let trained = trained.current().ok_or(SessionError::NoModel)?;
    let diagnosed = Command::Diagnose.run(&session, &monitor)?;
    let report = serde_json::to_vec(&diagnosed.report).unwrap_or_default();
    Ok([simulated, fit::to_bytes(&trained.fitted)?, report])
}

/// A diagnosis where effects alter others: what was read late is set right for those that the rigid body's load makes, and candidates
/// that share what follows from that load are computed side by side.
fn late(seed: u64) -> Result<Vec<u8>, TrialError> {
    let first = |is_it: fn(&Effect) -> bool| {
        registry::addable().find(|effect| is_it(effect)).map(|effect| effect.id.to_owned())
    };
    let late = first(|effect| matches!(effect.stage, Stage::Reading(..)));
    let of_load = first(|effect| effect.facts.encoder == Some(Side::Motor));
    let only = [late, of_load, first(|effect| effect.facts.everyday)].into_iter().flatten().collect();
    let drawing = Drawing { only, hidden: Some(3), ..Drawing::default() };
    let trial = drawing.case(seed).run(&Monitor::new())?;
    Ok(serde_json::to_vec(&trial.report).unwrap_or_default())
}
