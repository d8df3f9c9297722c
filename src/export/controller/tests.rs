use std::process::Command;

use super::tape::Step;
use super::*;
use crate::effect::registry;
use crate::export::tests::{runs, succeeds};
use crate::model::{Model, RigidBody, fit};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;
use crate::simulation::{Scenario, simulate};

/// What the tape gives at one state, computed step after step.
fn played(tape: &Tape, states: &Trajectory, t: usize) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    let of = |values: &[f64], value: &Value| match value {
        Value::Number(number) => *number,
        Value::Step(place) => values[*place],
    };
    for step in &tape.steps {
        let value = match step {
            Step::Constant(place) => tape.constants[*place].value,
            Step::Channel(Quantity::Position, joint) => states.q[*joint][t],
            Step::Channel(Quantity::Velocity, joint) => states.qd[*joint][t],
            Step::Channel(_, joint) => states.qdd[*joint][t],
            Step::OfOne(name, value) => {
                let x = of(&values, value);
                match *name {
                    "-" => -x,
                    "sin" => x.sin(),
                    "cos" => x.cos(),
                    "tanh" => x.tanh(),
                    "exp" => x.exp(),
                    "abs" => x.abs(),
                    "sign" => crate::effect::sign(x),
                    other => panic!("{other} is not expected"),
                }
            }
            Step::OfTwo(name, left, right) => {
                let (a, b) = (of(&values, left), of(&values, right));
                match *name {
                    "+" => a + b,
                    "-" => a - b,
                    "*" => a * b,
                    "/" => a / b,
                    "pow" => a.powf(b),
                    "min" => a.min(b),
                    "max" => a.max(b),
                    other => panic!("{other} is not expected"),
                }
            }
        };
        values.push(value);
    }
    tape.outcome.iter().map(|value| of(&values, value)).collect()
}

fn recording() -> Recording {
    let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
    recording.trajectories.truncate(3);
    recording
}

/// A model with these effects, each on joint 2, identified from the embedded recording.
fn fitted(recording: &Recording, effects: &[&str]) -> Fitted {
    let start = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] };
    let add = |model: Model, id: &&str| model.with_effect(registry::find(id).unwrap(), &[1]).unwrap();
    let model = effects.iter().fold(start, add);
    fit(&model, recording, &Split::automatic(recording), &Monitor::new()).unwrap()
}

const WISH: Wish = Wish { name: "arm_torque", width: 0.02, motion: None };

/// The tape gives the model's torque, with every effect that a model can have, and says which are not on it.
#[test]
fn every_effect_is_on_the_tape_or_told_to_be_left_out() {
    let recording = recording();
    let mut left = Vec::new();
    let groups: Vec<Vec<&str>> = registry::addable().map(|effect| vec![effect.id]).collect();
    for ids in groups {
        let fitted = fitted(&recording, &ids);
        let (tape, kept, left_out) = taken_down(&fitted, &WISH).unwrap();
        let vectors = Vectors::of(&kept, &WISH).unwrap();
        for t in 0..vectors.states.len() {
            for (joint, value) in played(&tape, &vectors.states, t).into_iter().enumerate() {
                let expected = vectors.torque[joint][t];
                assert!(
                    (value - expected).abs() < 1e-8 * expected.abs().max(10.0),
                    "{ids:?}: {value} is not {expected}"
                );
            }
        }
        left.extend(left_out.into_iter().map(|out| fitted.model.terms[out.term].clone()));
    }
    let names: Vec<&str> = left
        .iter()
        .filter_map(|term| if let Term::Effect(placed) = term { Some(placed.effect.id) } else { None })
        .collect();
    for id in ["dahl-hysteresis", "derivative-delay", "offset-drift", "lugre-friction"] {
        assert!(names.contains(&id), "{id} can't be written: {names:?}");
    }
    for id in ["tip-payload", "base-tilt", "com-offset", "stribeck-friction", "friction-coupling"] {
        assert!(!names.contains(&id), "{id} can be written");
    }
}

/// Writes the files of a language into a folder.
fn folder_with(code: &Code) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for Written { name, text } in &code.files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

const MIXED: [&str; 7] = [
    "stribeck-friction",
    "viscous-friction",
    "load-friction",
    "base-tilt",
    "concave-friction",
    "dead-zone",
    "upper-stop",
];

#[test]
fn the_generated_c_passes_its_vectors() {
    if !runs("cc", &["--version"]) {
        return;
    }
    let recording = recording();
    let code = write(&fitted(&recording, &MIXED), Language::C, &WISH).unwrap();
    let folder = folder_with(&code);
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-o", "test"];
    succeeds(folder.path(), "cc", &[&strict[..], &["arm_torque.c", "arm_torque_test.c", "-lm"]].concat());
    succeeds(folder.path(), "./test", &[]);
    // The test can fail: another mass, and it does.
    let source = folder.path().join("arm_torque.c");
    let text = std::fs::read_to_string(&source).unwrap();
    std::fs::write(&source, text.replace("K11 = ", "K11 = 1.0 + ")).unwrap();
    succeeds(folder.path(), "cc", &[&strict[..], &["arm_torque.c", "arm_torque_test.c", "-lm"]].concat());
    assert!(!Command::new("./test").current_dir(folder.path()).status().unwrap().success());
}

#[test]
fn the_generated_cpp_passes_its_vectors() {
    if !runs("c++", &["--version"]) {
        return;
    }
    let motion = recording();
    let wish = Wish { motion: motion.trajectories.first(), ..WISH };
    let code = write(&fitted(&motion, &MIXED), Language::Cpp, &wish).unwrap();
    let folder = folder_with(&code);
    succeeds(folder.path(), "c++", &["-std=c++11", "-Wall", "-Wextra", "-Werror", "-o", "test", "arm_torque_test.cpp"]);
    succeeds(folder.path(), "./test", &[]);
}

#[test]
fn the_generated_python_passes_its_vectors() {
    if !runs("python3", &["-c", "import numpy"]) {
        return;
    }
    let recording = recording();
    let code = write(&fitted(&recording, &MIXED), Language::Python, &WISH).unwrap();
    succeeds(folder_with(&code).path(), "python3", &["arm_torque_test.py"]);
}

#[test]
fn the_generated_matlab_passes_its_vectors() {
    if !runs("octave-cli", &["--version"]) {
        return;
    }
    let recording = recording();
    let code = write(&fitted(&recording, &MIXED), Language::Matlab, &WISH).unwrap();
    succeeds(folder_with(&code).path(), "octave-cli", &["--quiet", "arm_torque_test.m"]);
}

#[test]
fn parameters_stand_under_their_joints_and_what_is_missing_is_told() {
    let recording = recording();
    let model = fitted(&recording, &["coulomb-friction", "dahl-hysteresis"]);
    let code = write(&model, Language::Ros2, &WISH).unwrap();
    let text = &code.files[0].text;
    assert!(text.contains("    arm_torque:\n      joints: [\"joint_1\", \"joint_2\", \"joint_3\"]"), "{text}");
    assert!(text.contains("        coulomb_friction_joint_2:\n"), "{text}");
    assert!(text.contains("# LEFT OUT: hysteresis (Dahl), joint 2"), "{text}");
    assert_eq!(code.left_out.len(), 1);
}

#[test]
fn what_can_not_be_written_is_refused_with_the_remedy() {
    let recording = recording();
    let model = fitted(&recording, &[]);
    let message = |wish: Wish| write(&model, Language::C, &wish).unwrap_err().to_string();
    assert!(message(Wish { width: 0.0, ..WISH }).contains("above 0"));
    assert!(message(Wish { name: "2arm", ..WISH }).contains("begin with a letter"));
}
