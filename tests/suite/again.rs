//! What a report ends with: the commands in it lead to the same model, with the same error.

use std::path::Path;
use std::process::Command as Process;

use serde_json::Value;
use torquescope::arm::{Arm, Posture};
use torquescope::model::learned::LearnedPreset;
use torquescope::prelude::*;
use torquescope::recording::write::to_csv_bytes;
use torquescope::session::again;
use torquescope::simulation::Level;

use crate::runner::succeeds;

/// A small recording in files that a shell has to be told of with care, and a session that read it so.
fn opened(folder: &Path, options: ReadOptions) -> Session {
    let motion = Excitation::PaperPointToPoint { trajectories: 4, duration: 4.0, samples: 80, range: 2.0 };
    let recording = simulate(&Scenario { motion, ..Scenario::embedded() }, &Monitor::new()).unwrap();
    let paths: Vec<_> = (1..=4).map(|run| folder.join(format!("an arm's run {run}.csv"))).collect();
    for (path, run) in paths.iter().zip(&recording.trajectories) {
        std::fs::write(path, to_csv_bytes(run)).unwrap();
    }
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/own_stribeck.toml");
    let load = run(Command::LoadEffect { path: own.into() }, &Session::default());
    run(Command::open(paths, options, HoldOut::named(vec!["an arm's run 2".to_owned()])), &load)
}

fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).unwrap()
}

fn add(effect: &str, joints: &[usize], session: &Session) -> Session {
    run(Command::AddEffect { effect: effect.to_owned(), joints: joints.to_vec() }, session)
}

/// Types the commands into a shell; what each of them told, as JSON.
fn typed(lines: &[String], folder: &Path) -> Vec<Value> {
    let elsewhere = folder.join("elsewhere");
    std::fs::create_dir_all(&elsewhere).unwrap();
    let as_json = |line: &String| {
        let tells = line.starts_with("torquescope train") || line.starts_with("torquescope diagnose");
        if tells { format!("{line} --json | tr -d '\\n'\necho") } else { line.clone() }
    };
    let script: String = lines.iter().map(|line| as_json(line) + "\n").collect();
    let program = Path::new(env!("CARGO_BIN_EXE_torquescope")).parent().unwrap();
    let paths = std::env::join_paths([program.to_owned(), "/usr/bin".into(), "/bin".into()]).unwrap();
    let shell = Process::new("sh").arg("-ec").arg(&script).current_dir(&elsewhere).env("PATH", paths).output().unwrap();
    assert!(shell.status.success(), "{script}\n{}", String::from_utf8_lossy(&shell.stderr));
    let told = String::from_utf8(shell.stdout).unwrap();
    told.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

/// Holds what was told against the session.
fn assert_same(told: &Value, key: &str, session: &Session) {
    let own = session.current().unwrap().evaluation.held_out_nmse();
    let other: Vec<f64> =
        told[key].as_array().unwrap().iter().map(|joint| joint.as_f64().or(joint["nmse"].as_f64()).unwrap()).collect();
    assert_eq!(own.len(), other.len());
    for (own, other) in own.iter().zip(&other) {
        assert!((own - other).abs() <= 1e-9 * own, "{own}, not {other}: {told}");
    }
}

#[test]
fn a_log_is_read_set_right_modelled_and_diagnosed_again() {
    let folder = tempfile::tempdir().unwrap();
    let mapping = "q=q*,qd=-,qdd=-,tau=tau*,time=time".parse().unwrap();
    let arm = Arm { posture: Posture::DOWN, ..Scenario::embedded().arm };
    let options = ReadOptions {
        mapping: Some(mapping),
        zero: Some(Posture::DOWN),
        arm: Some(arm),
        low_pass_hz: Some(12.5),
        encoders: Some(torquescope::recording::encoders::Side::Link),
        ..ReadOptions::default()
    };
    let session = opened(folder.path(), options);
    let session = run(Command::SetRight(vec!["sign-torque@2".parse().unwrap()]), &session);
    let session = run(Command::ChoosePreset(Preset::StatedArm), &session);
    let asked = run(Command::Diagnose, &session);
    let session = add("stribeck-friction", &[0, 2], &asked);
    let session = Session { report: asked.report.clone(), ..add("torque-offset", &[1], &session) };
    let lines = again(&session);
    let told = typed(&lines, folder.path());
    assert_eq!(told.len(), 2, "{lines:#?}");
    assert_same(&told[0], "held_out", &session);
    assert_same(&told[1], "held_out_nmse", &asked);
}

#[test]
fn networks_are_trained_again() {
    let folder = tempfile::tempdir().unwrap();
    let session = opened(folder.path(), ReadOptions { zero: Some(Posture::RIGHT), ..ReadOptions::default() });
    let mut plan = Plan::default();
    plan.layers.hidden = vec![8];
    (plan.options.epochs, plan.options.seed, plan.smoothness) = (3, 5, 2.0);
    (plan.options.schedule, plan.normalise) = (torquescope::training::schedule::Schedule::Constant, true);
    let plan = Box::new(plan);
    let trained = run(Command::TrainPreset { preset: LearnedPreset::DelanFriction, plan }, &session);
    let lines = again(&trained);
    assert_same(&typed(&lines, folder.path())[0], "held_out", &trained);
    // Whose networks went on from others can't be had in one go, which is said.
    let longer = add("viscous-friction", &[0], &trained);
    assert!(again(&longer).iter().any(|line| line.starts_with("# Its networks went on")), "{:#?}", again(&longer));
}

/// Simulated recordings are simulated again; what is sealed stays so.
#[test]
fn what_is_simulated_is_simulated_again() {
    let folder = tempfile::tempdir().unwrap();
    let mystery = run(Command::DrawMystery { level: Level::Easy, seed: 3 }, &Session::default());
    assert_same(&typed(&again(&mystery), folder.path())[0], "held_out", &mystery);
    let motion = Excitation::PaperPointToPoint { trajectories: 4, duration: 4.0, samples: 80, range: 2.0 };
    let own = Scenario { motion, name: "my arm".to_owned(), ..Scenario::embedded() };
    let shut = run(Command::Simulate(Box::new(own)), &Session::default());
    let lines = again(&shut).join("\n");
    assert!(lines.contains("Open the seal") && !lines.contains("coulomb"), "{lines}");
    let open = run(Command::OpenSeal, &shut);
    assert_same(&typed(&again(&open), folder.path())[0], "held_out", &open);

    // Where it comes from is in the file of a session, but not what is sealed.
    for (session, is_told) in [(&shut, false), (&open, true), (&mystery, true)] {
        let file = folder.path().join("mine.torquescope");
        torquescope::session::file::save(&file, &session.clone().into()).unwrap();
        let restored = run(Command::Restore { path: file }, &Session::default());
        assert_eq!(restored.source.is_some(), is_told);
        assert_eq!(again(&restored) == again(session), is_told);
    }
    succeeds(&["report", "mine.torquescope", "-o", "report.md"], folder.path());
    let page = std::fs::read_to_string(folder.path().join("report.md")).unwrap();
    assert!(page.contains("torquescope simulate --mystery=easy --seed 3"), "{page}");
}
