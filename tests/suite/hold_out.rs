//! What acts in the held-out part alone is found once another part is held out: by the command, by the option, and by the lines that
//! make a session anew.

use std::path::{Path, PathBuf};

use torquescope::arm::Posture;
use torquescope::diagnosis::Note;
use torquescope::model::learned::{Layers, LearnedPreset};
use torquescope::prelude::*;
use torquescope::session::again;
use torquescope::training::Options;

use crate::contact;
use crate::runner::{fails, json};

fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).unwrap()
}

fn written(folder: &Path) -> PathBuf {
    let path = folder.join("bumper.csv");
    std::fs::write(&path, contact::log()).unwrap();
    path
}

fn opened(folder: &Path, held_out: HoldOut) -> Session {
    let options = ReadOptions { zero: Some(Posture::DOWN), ..ReadOptions::default() };
    run(Command::open(vec![written(folder)], options, held_out), &Session::default())
}

fn diagnosed(session: &Session) -> (Session, Vec<&'static str>) {
    let session = run(Command::Diagnose, session);
    let names = session.report.as_ref().unwrap().effects.iter().map(|named| named.effect.id).collect();
    (session, names)
}

#[test]
fn a_bumper_that_is_met_where_it_is_held_out_is_found_with_another_part_held_out() {
    let folder = tempfile::tempdir().unwrap();
    let (first, names) = diagnosed(&opened(folder.path(), HoldOut::default()));
    let report = first.report.as_ref().unwrap();
    assert!(!names.contains(&"lower-stop"), "{names:?}");
    assert_eq!(report.notes[0], Note::FailsOnHeldOut { joints: vec![0] }, "{}", report.advice());
    assert!(report.advice().contains("--held-out-fifth"), "{}", report.advice());

    let held_out = &first.source.as_ref().unwrap().held_out;
    let next = held_out.next(first.recording.as_ref().unwrap()).unwrap();
    let other = run(Command::HoldOut(next.clone()), &first);
    assert_eq!(other.source.as_ref().unwrap().held_out, next);
    let (other, names) = diagnosed(&other);
    assert!(names.contains(&"lower-stop"), "{names:?}: {}", other.report.as_ref().unwrap().advice());
    assert!(!other.report.as_ref().unwrap().fails_on_held_out());
    let named = other.report.as_ref().unwrap().effects.iter().find(|named| named.effect.id == "lower-stop").unwrap();
    for (name, truth) in [("stop_stiffness", contact::STIFFNESS), ("stop_position", contact::STOP)] {
        let parameter = named.parameters.iter().find(|parameter| parameter.name == name).unwrap();
        assert!((parameter.value - truth).abs() < 0.02 * truth.abs(), "{name}: {}", parameter.value);
    }
    let add = Command::AddEffect { effect: "lower-stop".to_owned(), joints: vec![0] };
    let repaired = run(add, &other);
    let errors = [&first, &repaired].map(|session| session.current().unwrap().evaluation.all_held_out.nmse);
    assert!(errors[0] > 0.5 && errors[1] < 1e-4, "{errors:?}");

    let told = json(&["diagnose", "bumper.csv", "--zero", "down", "--held-out-fifth", "2", "--json"], folder.path());
    let told: Vec<&str> =
        told["effects"].as_array().unwrap().iter().map(|named| named["effect"].as_str().unwrap()).collect();
    assert_eq!(told, names);
    let lines = again(&other);
    assert!(lines.iter().any(|line| line.contains("--held-out-fifth 2")), "{lines:?}");
}

#[test]
fn the_ladder_is_made_anew_and_other_models_are_gone() {
    let folder = tempfile::tempdir().unwrap();
    let rigid = opened(folder.path(), HoldOut::default());
    let options = Options { epochs: 2, batch: 100, ..Options::ours() };
    let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
    let trained = run(Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(plan) }, &rigid);
    let mine = run(Command::Rename { name: "FF-NN".to_owned(), to: "mine".to_owned() }, &trained);
    let names = |session: &Session| session.all_models().map(|step| step.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&mine), ["rigid body", "mine"]);
    let other = run(Command::HoldOut(HoldOut::Fifth(3)), &mine);
    assert_eq!(names(&other), ["mine"], "what is not on the ladder learned from what is held out now");
    let (old, new) = (mine.current().unwrap(), other.current().unwrap());
    assert_ne!(old.generation, new.generation);
    assert_eq!(old.run.as_ref().unwrap().plan, new.run.as_ref().unwrap().plan);
    assert_ne!(old.evaluation.held_out_nmse(), new.evaluation.held_out_nmse());
    assert_eq!(names(&mine), ["rigid body", "mine"], "undo has them");

    let none = Command::HoldOut(HoldOut::named(vec!["elsewhere".to_owned()])).run(&mine, &Monitor::new()).unwrap_err();
    assert!(none.to_string().contains("no trajectory is named `elsewhere`"), "{none}");
}

#[test]
fn a_fifth_that_there_is_not_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let log = written(folder.path());
    let message = fails(&["diagnose", "bumper.csv", "--held-out-fifth", "6"], folder.path(), 2);
    assert!(message.contains("1..=5"), "{message}");
    let both = ["diagnose", "bumper.csv", "--held-out-fifth", "2", "--held-out", "bumper"];
    assert!(fails(&both, folder.path(), 2).contains("cannot be used with"));
    for name in ["b", "c", "d"] {
        std::fs::copy(&log, folder.path().join(format!("{name}.csv"))).unwrap();
    }
    let four = ["inspect", "bumper.csv", "b.csv", "c.csv", "d.csv", "--held-out-fifth", "5"];
    let message = fails(&four, folder.path(), 2);
    assert!(message.contains("there is no turn 5: choose one of 1 to 4"), "{message}");
}
