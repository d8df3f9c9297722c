//! Sessions, models, checkpoints, experiments, mappings, arms and robot files that were damaged at random.

use super::damage::damage;
use super::opener::{Kind, Opened, Opener, Request};
use super::seeds::arms::{ARM, MJCF, URDF};
use super::{Bench, Measure, Score, SelftestError, logs};
use crate::file;
use crate::model::learned::{Layers, LearnedPreset};
use crate::progress::Monitor;
use crate::recording::catalogue as mappings;
use crate::recording::write::to_npz_bytes;
use crate::session::{Command, Session, SessionError};
use crate::simulation::Scenario;
use crate::training::Options;
use crate::training::fit::{self, Plan};
use crate::{experiment, session};

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "documents",
    promise: "damaged sessions, models, checkpoints, experiments, mappings, arms and robot files: no panic, none computes over 5 s or takes over \
              64 MiB or four times its size, and no file is changed by opening it",
    take,
};

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let clean = bench.path("clean.npz");
    let files = files(bench)?;
    let cases = bench.cases(300, 1800);
    let mut score = Score { cases, ..Score::default() };
    let mut opener = Opener::new(&bench.program);
    for (kind, name, bytes) in &files {
        let path = bench.path(name);
        file::write(&path, bytes)?;
        let answer = opener.open(&Request { kind: *kind, path, clean: Some(clean.clone()) })?;
        score.demand(matches!(answer.opened, Opened::Accepted(_)), || format!("{name}: {:?}", answer.opened));
    }
    for case in 0..cases {
        bench.report(case, cases, "damaged documents")?;
        let (kind, name, whole) = &files[case % files.len()];
        let bytes = damage(whole, &mut bench.random(case));
        let path = bench.path(&format!("damaged-{name}"));
        file::write(&path, &bytes)?;
        let answer = opener.open(&Request { kind: *kind, path: path.clone(), clean: Some(clean.clone()) })?;
        let before = score.broken.len();
        logs::survived(&mut score, &format!("case {case} ({name})"), &answer, bytes.len() as u64, whole.len() as u64);
        let is_untouched = file::read(&path, file::LARGEST).is_ok_and(|now| now == bytes);
        score.demand(is_untouched, || format!("case {case} ({name}): opening it changed it"));
        if score.broken.len() > before {
            bench.keep(&format!("{case}-{name}"), &bytes)?;
        }
    }
    Ok(score)
}

type Document = (Kind, String, Vec<u8>);

/// One of each kind at least.
fn files(bench: &Bench) -> Result<Vec<Document>, SelftestError> {
    let failed = |error: &dyn std::fmt::Display| SelftestError::making("a session")(error);
    let (session, solved) = worked_on(bench).map_err(|error| failed(&error))?;
    let step = session.current().ok_or_else(|| failed(&"it has no model"))?;
    let recording = session.recording.as_deref().ok_or_else(|| failed(&"it has no recording"))?;
    file::write(&bench.path("clean.npz"), &to_npz_bytes(recording).map_err(|error| failed(&error))?)?;
    let run = step.run.as_ref().ok_or_else(|| failed(&"nothing was trained"))?;
    let bytes = |file: &crate::model::Fitted| fit::to_bytes(file).map_err(|error| failed(&error));
    let mut files: Vec<Document> = vec![
        (Kind::Model, "networks.model".to_owned(), bytes(&step.fitted)?),
        (Kind::Model, "solved.json".to_owned(), bytes(&solved)?),
        (Kind::Checkpoint, "run.npz".to_owned(), run.to_bytes().map_err(|error| failed(&error))?),
        (Kind::Arm, "arm.json".to_owned(), ARM.as_bytes().to_vec()),
        (Kind::Robot, "robot.urdf".to_owned(), URDF.as_bytes().to_vec()),
        (Kind::Robot, "robot.xml".to_owned(), MJCF.as_bytes().to_vec()),
    ];
    let document = session::file::to_bytes(&session.into()).map_err(|error| failed(&error))?;
    // A session holds all the others: it is tried as often as two of them.
    files.extend(["mine", "other"].map(|name| (Kind::Session, format!("{name}.torquescope"), document.clone())));
    let experiments = experiment::catalogue::ALL.iter().take(2);
    files.extend(experiments.map(|(name, text)| (Kind::Experiment, format!("{name}.toml"), text.as_bytes().to_vec())));
    let mappings = mappings::ALL.iter().take(2);
    files.extend(mappings.map(|(name, text)| (Kind::Mapping, format!("map-{name}.toml"), text.as_bytes().to_vec())));
    Ok(files)
}

/// A session with an effect and with networks, and the model before them.
fn worked_on(bench: &Bench) -> Result<(Session, crate::model::Fitted), SessionError> {
    let monitor = Monitor::new();
    let scenario = super::seeds::scenario(bench.effort.seed);
    let simulated = Command::Simulate(Box::new(scenario)).run(&Session::default(), &monitor)?;
    let effect = Scenario::embedded().effects.swap_remove(0).effect;
    let add = Command::AddEffect { effect, joints: vec![0] };
    let solved = add.run(&simulated, &monitor)?;
    let fitted = solved.current().ok_or(SessionError::NoModel)?.fitted.clone();
    let options = Options { epochs: 3, batch: 32, ..Options::ours() };
    let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
    let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: Box::new(plan) };
    Ok((train.run(&solved, &monitor)?, fitted))
}
