//! Effects of one's own, and formulas that the program proposes for what nobody named.

use std::path::Path;

use serde_json::Value;
use torquescope::arm::Arm;
use torquescope::diagnosis::proposal::{Nature, Proposals, propose};
use torquescope::effect::{own, registry};
use torquescope::model::{self, Evaluation, Preset};
use torquescope::progress::Monitor;
use torquescope::recording::split::Split;
use torquescope::recording::write::to_npz_bytes;
use torquescope::recording::{Recording, Trajectory};
use torquescope::simulation::{Excitation, Scenario, simulate};

use crate::runner::{fails, json, succeeds};

const STRIBECK: &str = "examples/own_stribeck.toml";

fn example(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// An arm of two joints without any effect, 30 s at 100 Hz, with a torque that is planted sample by sample.
fn planted(law: impl Fn(&Trajectory, usize) -> [f64; 2]) -> Recording {
    let motion = Excitation::SuperposedSines {
        trajectories: 4,
        duration: 12.0,
        rate: 100.0,
        sines: 5,
        lowest_frequency: 0.1,
        highest_frequency: 1.0,
        space: vec![[-1.5, 1.5]; 2],
    };
    let scenario =
        Scenario { arm: Arm::uniform(2), motion, effects: Vec::new(), torque_noise: 0.01, ..Scenario::embedded() };
    let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
    for run in &mut recording.trajectories {
        let added: Vec<[f64; 2]> = (0..run.len()).map(|sample| law(run, sample)).collect();
        let mut channels = run.channels_mut();
        for joint in 0..2 {
            channels.tau[joint].iter_mut().zip(&added).for_each(|(tau, added)| *tau += added[joint]);
        }
    }
    recording
}

fn proposals(recording: &Recording) -> Proposals {
    let (split, monitor) = (Split::automatic(recording), Monitor::new());
    let model = Preset::RigidBody.model(recording).unwrap();
    let body = model::fit(&model, recording, &split, &monitor).unwrap();
    propose(&body, recording, &split, &monitor).unwrap()
}

fn save(recording: &Recording, folder: &Path) {
    std::fs::write(folder.join("arm.npz"), to_npz_bytes(recording).unwrap()).unwrap();
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

fn held_out(answer: &Value) -> Vec<f64> {
    answer["held_out"].as_array().unwrap().iter().map(|joint| joint["nmse"].as_f64().unwrap()).collect()
}

/// The same law, written by hand, has the same parameters, intervals and errors.
#[test]
fn an_own_law_is_fitted_as_the_built_in_one() {
    let text = std::fs::read_to_string(example(STRIBECK)).unwrap();
    let own = own::load(&text).unwrap();
    let built_in = registry::find("stribeck-friction").unwrap();
    let mut scenario = Scenario { arm: Arm::uniform(2), effects: Vec::new(), ..Scenario::embedded() };
    scenario.effects = scenario.hide_by_strength("stribeck-friction", &[1], 0.15).unwrap();
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let split = Split::automatic(&recording);
    let body = Preset::RigidBody.model(&recording).unwrap();
    let [one, other] = [own, built_in].map(|effect| {
        let model = body.with_effect(effect, &[1]).unwrap();
        let fitted = model::fit(&model, &recording, &split, &Monitor::new()).unwrap();
        let errors = Evaluation::of(&fitted, &recording, &split).unwrap().held_out_nmse();
        (fitted.parameters, errors)
    });
    let close = |one: f64, other: f64| (one - other).abs() <= 1e-6 * one.abs().max(other.abs());
    assert!(one.0.len() == other.0.len() && one.0.len() > 5);
    for (one, other) in one.0.iter().zip(&other.0) {
        assert_eq!(one.unit, other.unit);
        assert!(close(one.value, other.value), "{one:?} {other:?}");
        let [[low, high], [lower, higher]] = [one, other].map(|parameter| parameter.interval.unwrap());
        assert!(close(low, lower) && close(high, higher), "{one:?} {other:?}");
    }
    assert!(one.1.iter().zip(&other.1).all(|(one, other)| close(*one, *other)), "{:?} {:?}", one.1, other.1);
}

/// A law that no effect has: proposed first, adopted, fitted, saved, and used where its file is not.
#[test]
fn an_unknown_law_is_proposed_adopted_and_lowers_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    save(&planted(|run, t| [0.0, 0.8 * run.q[0][t].sin() * run.qd[1][t] * run.qd[1][t].abs()]), at);
    let answer = json(&["propose", "arm.npz", "--json"], at);
    let [remainder, first] = [&answer["remainders"][1], &answer["formulas"][0]];
    assert_eq!((&remainder["nature"], &first["joint"]), (&"static".into(), &2.into()), "{answer:#}");
    assert_eq!(first["formula"], "sin(q1) * qd2 * abs(qd2)", "{answer:#}");
    let interval = numbers(&first["interval"]);
    assert!(interval[0] < 0.8 && 0.8 < interval[1] && interval[1] - interval[0] < 0.1, "{first:#}");
    assert!(first["share"].as_f64().unwrap() > 0.8 && first["stability"].as_f64().unwrap() > 0.9, "{first:#}");
    assert_eq!((&first["unit"], &first["known"]), (&"N m s²/rad²".into(), &Value::Null));
    let order: Vec<&str> =
        remainder["order"].as_array().unwrap().iter().map(|step| step["channel"].as_str().unwrap()).collect();
    assert!(order.len() >= 2 && order[..2].contains(&"q1") && order[..2].contains(&"qd2"), "{order:?}");

    let told = succeeds(&["propose", "arm.npz", "--adopt", "1", "-o", "law.toml"], at);
    assert!(told.contains("--add own-sin-q1-qd2-abs-qd2@2"), "{told}");
    let before = held_out(&json(&["train", "arm.npz", "--json"], at));
    let add = ["--effect-file", "law.toml", "--add", "own-sin-q1-qd2-abs-qd2@2"];
    // In whichever order the options stand.
    let after = json(
        &[&["train", "arm.npz", "--json", "-o", "model.json"][..], &[add[2], add[3], add[0], add[1]]].concat(),
        at,
    );
    assert!(held_out(&after)[1] < 0.2 * before[1], "{before:?} {after:#}");
    let factor =
        after["parameters"].as_array().unwrap().iter().find(|parameter| parameter["name"] == "factor").unwrap();
    assert!((factor["value"].as_f64().unwrap() - 0.8).abs() < 0.04, "{factor:#}");
    let report = json(&["diagnose", "arm.npz", "--effect-file", "law.toml", "--json"], at);
    assert_eq!(report["effects"][0]["effect"], "own-sin-q1-qd2-abs-qd2", "{report:#}");
    let catalogue = succeeds(&["effects", "own-sin-q1-qd2-abs-qd2", "--effect-file", "law.toml"], at);
    assert!(catalogue.contains("tau = factor * sin(q1) * qd2 * abs(qd2)"), "{catalogue}");

    // Another machine has the model, not the file.
    std::fs::remove_file(at.join("law.toml")).unwrap();
    let elsewhere = json(&["evaluate", "arm.npz", "--model", "model.json", "--json"], at);
    assert!(elsewhere.to_string().contains("nmse"), "{elsewhere:#}");
    succeeds(&["predict", "arm.npz", "--model", "model.json", "-o", "torques.csv"], at);
    let table = std::fs::read_to_string(at.join("torques.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains("own-sin-q1-qd2-abs-qd2@2"));
}

/// A spring between two joints acts on both.
#[test]
fn a_spring_across_two_joints_is_proposed_on_both() {
    let recording = planted(|run, t| [3.0 * (run.q[0][t] + run.q[1][t]); 2]);
    let found = proposals(&recording);
    for joint in 0..2 {
        let formula = found.formulas.iter().find(|formula| formula.joint == joint).expect("one is proposed");
        assert_eq!(formula.formula, "(q1 + q2)", "{found:#?}");
        assert!((formula.value - 3.0).abs() < 0.3 && formula.unit == "N m/rad", "{formula:#?}");
    }
}

/// What the catalogue has is said to be that.
#[test]
fn a_proposal_that_the_catalogue_has_is_called_by_its_name() {
    let found = proposals(&planted(|run, t| [1.5 * run.qd[0][t], 0.0]));
    assert_eq!((found.formulas[0].formula.as_str(), found.formulas[0].joint), ("qd1", 0), "{found:#?}");
    assert_eq!(found.formulas[0].known, Some(registry::find("viscous-friction").unwrap()));
    assert_eq!(found.remainders[1].nature, Nature::Noise, "{found:#?}");
}

#[test]
fn noise_has_no_formula_and_a_remainder_of_its_own_state_has_a_memory() {
    let noise = proposals(&planted(|_, _| [0.0; 2]));
    assert!(noise.formulas.is_empty(), "{noise:#?}");
    assert!(noise.remainders.iter().all(|remainder| remainder.nature == Nature::Noise), "{noise:#?}");
    // A beat that has nothing to do with where the arm is, slow enough to pass the filter.
    let swinging = proposals(&planted(|run, t| [0.0, 0.6 * (9.7 * run.time[t]).sin()]));
    assert!(swinging.formulas.is_empty(), "{swinging:#?}");
    assert_eq!(swinging.remainders[1].nature, Nature::Memory, "{swinging:#?}");
}

#[test]
fn files_that_are_no_effect_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let good = std::fs::read_to_string(example(STRIBECK)).unwrap();
    std::fs::write(at.join("typo.toml"), good.replace("column = \"direction\"", "column = \"sgn(qd)\"")).unwrap();
    std::fs::write(at.join("taken.toml"), good.replace("own-stribeck", "cogging")).unwrap();
    std::fs::write(at.join("one.toml"), &good).unwrap();
    std::fs::write(at.join("other.toml"), good.replace("min = 0.0", "min = 0.1")).unwrap();
    let cases: [(&[&str], &[&str]); 5] = [
        (&["--effect-file", "typo.toml"], &["typo.toml: line 19, column 11", "there is no function `sgn`"]),
        (&["--effect-file", "taken.toml"], &["taken.toml", "`cogging` already", "another id"]),
        (
            &["--effect-file", "one.toml", "--effect-file", "other.toml"],
            &["other.toml", "another id, such as `own-stribeck-2`"],
        ),
        (&["--effect-file", "none.toml"], &["can't read the effect none.toml"]),
        (&["--effect-file", "one.toml", "--add", "own@2"], &["no effect `own`", "own-stribeck"]),
    ];
    for (options, words) in cases {
        let message = fails(&[&["train", "arm.npz"], options].concat(), at, 2);
        assert!(words.iter().all(|word| message.contains(word)), "{options:?}: {message}");
    }
    let listed = succeeds(&["effects", "--effect-file", "one.toml"], at);
    assert!(listed.contains("own-stribeck") && listed.contains("coulomb-friction"), "{listed}");
}
