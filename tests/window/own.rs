//! Effects of one's own in the window: loaded, offered, and adopted from what the remainder proposes.

use std::path::{Path, PathBuf};

use egui::Theme;
use egui_kittest::kittest::Queryable;
use torquescope::app::Order;
use torquescope::app::screens::{diagnose, model};
use torquescope::arm::Arm;
use torquescope::progress::Monitor;
use torquescope::recording::hold_out::HoldOut;
use torquescope::recording::read::ReadOptions;
use torquescope::recording::write::to_npz_bytes;
use torquescope::session::{Command, Session};
use torquescope::simulation::{Excitation, Scenario, simulate};

use super::support::{run, settle, small, window};

/// An arm of two joints, on the second of which acts what no effect of the catalogue is.
fn with_unknown_law(folder: &Path) -> Session {
    let motion = Excitation::PaperPointToPoint { trajectories: 12, duration: 4.0, samples: 100, range: 2.0 };
    let scenario = Scenario { arm: Arm::uniform(2), motion, effects: Vec::new(), ..Scenario::embedded() };
    let mut recording = simulate(&scenario, &Monitor::new()).expect("it is simulated");
    recording.seal = None;
    for run in &mut recording.trajectories {
        let law: Vec<f64> = (0..run.len()).map(|t| run.q[0][t].sin() * run.qd[1][t] * run.qd[1][t].abs()).collect();
        run.channels_mut().tau[1].iter_mut().zip(law).for_each(|(tau, law)| *tau += 0.8 * law);
    }
    let path = folder.join("law.npz");
    std::fs::write(&path, to_npz_bytes(&recording).expect("it has a form")).expect("it is written");
    run(Command::open(vec![path], ReadOptions::default(), HoldOut::default()), &Session::default())
}

#[test]
fn what_the_remainder_proposes_is_adopted_by_a_click() {
    let folder = tempfile::tempdir().expect("there is a folder");
    let session = run(Command::Diagnose, &with_unknown_law(folder.path()));
    let mut window = window(session, &diagnose::ABOUT, Theme::Light);
    let before = window.state().session().current().expect("there is a model").evaluation.held_out[1].nmse;
    window.state_mut().order(Order::run(Command::Propose));
    settle(&mut window);
    let proposals = window.state().session().proposals.clone().expect("it was asked");
    assert_eq!(proposals.formulas[0].formula, "sin(q1) * qd2 * abs(qd2)", "{proposals:?}");
    window.get_by_label("Adopt sin(q1) * qd2 * abs(qd2), joint 2").click_accesskit();
    settle(&mut window);
    let session = window.state().session();
    assert_eq!((session.own_effects.len(), session.ladder.len()), (1, 2));
    let after = session.current().expect("there is a model").evaluation.held_out[1].nmse;
    assert!(after < 0.2 * before, "{before} -> {after}");
    assert!(session.proposals.is_none(), "they were of the model before");
}

#[test]
fn an_effect_file_is_opened_as_any_other_and_offered() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/plate_drag.toml");
    let mut window = window(small(), &model::ABOUT, Theme::Light);
    window.state_mut().order(Order::open(vec![path]));
    settle(&mut window);
    assert_eq!(window.state().session().own_effects[0].name, "drag of the plate");
    window.get_by_label("Effect").click();
    window.run_steps(3);
    assert!(window.query_by_label("drag of the plate").is_some(), "the list has it");
}
