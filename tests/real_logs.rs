//! Trials on logs of real robots. They are not part of the repository: where they are absent, the tests say so and pass.

#![allow(clippy::unwrap_used)] // a test fails where something is not as it should be

use std::path::PathBuf;

use torquescope::arm::Posture;
use torquescope::diagnosis::Verdict;
use torquescope::model::Preset;
use torquescope::progress::Monitor;
use torquescope::recording::read::ReadOptions;
use torquescope::session::{Command, Session};

/// The folder of real logs: `TORQUESCOPE_REAL_DATA`, or `../shared/real` beside the repository.
fn real_data(folder: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/real");
    let root = std::env::var_os("TORQUESCOPE_REAL_DATA").map_or_else(beside, PathBuf::from);
    let path = root.join(folder);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: there is no {}", path.display());
    None
}

fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).unwrap()
}

#[test]
fn on_the_double_pendulum_friction_of_both_joints_is_the_first_missing_effect() {
    let Some(folder) = real_data("dfki-double-pendulum") else { return };
    let paths = ["a0-00", "a0-01", "a0-02", "a0-03", "a0-04", "a0-11"].map(|name| folder.join(format!("{name}.csv")));
    let open = Command::Open {
        paths: paths.to_vec(),
        options: ReadOptions { zero: Some(Posture::DOWN), ..ReadOptions::default() },
        held_out: vec!["a0-04".into(), "a0-11".into()],
    };
    let session = run(Command::Diagnose, &run(open, &Session::default()));
    assert_eq!(session.preset, Preset::RigidBody);
    let report = session.report.as_ref().unwrap();
    assert!(matches!(report.verdict, Verdict::Missing | Verdict::Ambiguous), "{}", report.advice);
    let first = &report.effects[0];
    let family = ["viscous-friction", "coulomb-friction", "stribeck-friction"];
    assert!(family.contains(&first.effect.as_str()), "{} was named first", first.effect);
    assert_eq!(first.joints, [0, 1]);

    let mut repaired = session.clone();
    for effect in &report.effects {
        let add = Command::AddEffect { effect: effect.effect.clone(), joints: effect.joints.clone() };
        repaired = run(add, &repaired);
    }
    let r2 = |session: &Session| -> Vec<f64> {
        session.current().unwrap().evaluation.held_out.iter().map(|joint| joint.r2).collect()
    };
    let (before, after) = (r2(&session), r2(&repaired));
    assert!(after[0] > before[0] + 0.3 && after[1] > 0.92, "held-out R² {before:?} -> {after:?}");
}
