//! A robot's file states its masses: the model of them, and what is identified held beside it.

use torquescope::arm::robot::SerialArm;
use torquescope::arm::stated::StatedArm;
use torquescope::arm::{Arm, Link, Posture};
use torquescope::diagnosis::{Note, diagnose};
use torquescope::effect::registry;
use torquescope::model::{Fitted, Model, Term, fit};
use torquescope::prelude::*;
use torquescope::recording::mapping::MappingSpec;
use torquescope::recording::read::read;
use torquescope::recording::seal::HiddenEffect;
use torquescope::recording::write::to_csv_bytes;
use torquescope::signals::Signals;
use torquescope::training::components;

use crate::oracle::Oracle;
use crate::outside;

/// A planar arm as an MJCF, the last link behind a body that is fixed to the one before; `said` is said of every joint.
fn mjcf(arm: &Arm, said: &str) -> String {
    let mut text = String::new();
    let mut place = 0.0;
    for (number, link) in arm.links.iter().enumerate() {
        let turned =
            if number == 0 { format!("axisangle=\"0 -1 0 {}\"", arm.posture.zero_angle) } else { String::new() };
        let Link { mass, com, inertia, length } = link;
        // Half of the mass in a body of its own, at the same place: what is fixed is lumped.
        let half = format!("mass=\"{}\" diaginertia=\"0.01 {} 0.02\"", mass / 2.0, inertia / 2.0);
        text += &format!(
            "<body name=\"l{number}\" pos=\"{place} 0 0\" {turned}><joint name=\"j{number}\" axis=\"0 -1 0\" {said}/>\
             <inertial pos=\"{com} 0 0\" {half}/>\
             <body name=\"f{number}\" pos=\"0 0 0.3\"><inertial pos=\"{com} 0 -0.3\" {half}/></body>"
        );
        place = *length;
    }
    let ends = "</body>".repeat(arm.links.len());
    let gravity = arm.gravity;
    format!(
        "<mujoco><compiler angle=\"radian\"/><option gravity=\"0 0 {}\"/><worldbody>{text}{ends}</worldbody></mujoco>",
        -gravity
    )
}

/// The same with a frame at the end of the last link, farther away than the bodies beside the links.
fn with_tool(mjcf: &str, length: f64) -> String {
    let text = mjcf.replace("0 0 0.3\"", "0 0 0.03\"").replace(" 0 -0.3\"", " 0 -0.03\"");
    let end = "</body></body></body></worldbody>";
    text.replace(end, &format!("<body name=\"tool\" pos=\"{length} 0 0\"/>{end}"))
}

/// The same in a URDF, whose gravity is the standard one.
fn urdf(arm: &Arm) -> String {
    let mut text = String::from("<robot name=\"planar\">");
    let (mut place, mut turn) = (0.0, -arm.posture.zero_angle);
    for (number, link) in arm.links.iter().enumerate() {
        let Link { mass, com, inertia, length } = link;
        let before = number.checked_sub(1).map_or("base".to_owned(), |before| format!("l{before}"));
        text += &format!(
            "<joint name=\"j{number}\" type=\"revolute\"><origin xyz=\"{place} 0 0\" rpy=\"0 {turn} 0\"/><axis xyz=\"0 -1 0\"/>\
             <parent link=\"{before}\"/><child link=\"l{number}\"/></joint><link name=\"l{number}\"><inertial><mass \
             value=\"{mass}\"/><origin xyz=\"{com} 0 0\"/><inertia ixx=\"0.1\" iyy=\"{inertia}\" izz=\"0.1\"/></inertial></link>"
        );
        (place, turn) = (*length, 0.0);
    }
    text + "</robot>"
}

/// Pinocchio's torque (by the closed form that equals it) for ten arms each, read from their files.
#[test]
fn a_file_states_the_torque_that_pinocchio_needs() {
    let of = |n: usize| outside::references().into_iter().map(move |folder| (n, folder));
    for (n, folder) in [1, 2, 3, 5, 7].into_iter().flat_map(of) {
        let mut reference = Oracle::open(&folder.join(format!("arm/oracle_planar_n{n}.npz")));
        let [m, l, r, inertia, gravity, phi0, set] =
            ["m", "l", "r", "I", "gravity", "phi0", "set"].map(|name| reference.array(name));
        let [q, qd, qdd, expected] = ["q", "qd", "qdd", "tau"].map(|name| reference.array(name));
        let largest = expected.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let arm = |set: usize| {
            let links =
                (set * n..(set + 1) * n).map(|i| Link { mass: m[i], length: l[i], com: r[i], inertia: inertia[i] });
            Arm {
                links: links.collect(),
                gravity: gravity[set],
                posture: Posture { zero_angle: phi0[set], ..Posture::RIGHT },
            }
        };
        let texts: Vec<[String; 2]> = (0..10).map(|set| [mjcf(&arm(set), ""), urdf(&arm(set))]).collect();
        for (sample, &set) in set.iter().enumerate() {
            let state = sample * n..(sample + 1) * n;
            for text in &texts[set as usize] {
                if text.starts_with("<robot") && (gravity[set as usize] - 9.81).abs() > 1e-12 {
                    continue;
                }
                let arm = SerialArm::parse(text).unwrap();
                let chain = arm.chain();
                let mut found = vec![0.0; n];
                let regressor = chain.regressor(&arm.sliding());
                let [q, qd, qdd] = [&q, &qd, &qdd].map(|values| &values[state.clone()]);
                regressor.torque(q, qd, qdd, &chain.stated_parameters(), &mut found);
                for (found, expected) in found.iter().zip(&expected[state.clone()]) {
                    assert!(
                        (found - expected).abs() <= 1e-9 * largest,
                        "{n} joints, sample {sample}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// A recording of the embedded arm whose axes and masses a file states, with `said` of each joint.
fn stated(said: &str) -> Recording {
    let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
    let arm = SerialArm::parse(&mjcf(&Scenario::embedded().arm, said)).unwrap();
    Recording { chain: Some(arm.chain()), stated_arm: None, posture: None, ..recording }
}

fn fitted(model: &Model, recording: &Recording) -> Fitted {
    fit(model, recording, &Split::automatic(recording), &Monitor::new()).unwrap()
}

fn assert_same(one: &Signals, other: &Signals, tolerance: f64) {
    for (one, other) in one.iter().flatten().zip(other.iter().flatten()) {
        assert!((one - other).abs() < tolerance, "{one} {other}");
    }
}

/// The model as stated has the torque of the planar arm that states the same, part by part, and what resists is a term of its own.
#[test]
fn the_stated_model_is_the_arm_of_the_file() {
    let recording = stated("armature=\"0.2\" damping=\"0.5\" frictionloss=\"1.5\"");
    let run = &recording.trajectories[0];
    let model = Preset::StatedArm.model(&recording).unwrap();
    let labels: Vec<String> = model.terms.iter().map(Term::label).collect();
    assert_eq!(labels, ["stated rigid body", "stated resistance of joints"]);
    let of_file = fitted(&model, &recording);
    assert!(of_file.parameters.is_empty(), "nothing is identified");
    let planar = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
    let of_arm = fitted(&Preset::StatedArm.model(&planar).unwrap(), &planar);
    let (one, other) = (of_file.predict(run).unwrap(), of_arm.predict(run).unwrap());
    assert_same(&one.terms[0], &other.terms[0], 1e-9);
    let parts = |fitted: &Fitted| components(fitted, run).unwrap();
    for ((name, one), (_, other)) in parts(&of_file).iter().zip(&parts(&of_arm)).take(3) {
        assert_same(one, other, 1e-8);
        assert!(one.iter().flatten().any(|torque| torque.abs() > 1e-3), "{name}");
    }
    let resists = Signals::from_fn(3, run.len(), |joint, t| {
        let (qd, qdd) = (run.qd[joint][t], run.qdd[joint][t]);
        0.2 * qdd + 0.5 * qd + if qd == 0.0 { 0.0 } else { 1.5 * qd.signum() }
    });
    assert_same(&one.terms[1], &resists, 1e-9);
    let again = Fitted::from_json(&of_file.to_json()).unwrap();
    assert_eq!(again, of_file);
    assert_same(&again.predict(run).unwrap().total, &one.total, 1e-12);
}

/// Where the arm is as its file says, identification finds the base parameters that the file states, and its friction; where a link
/// is not, the parameters that it is in lie outside.
#[test]
fn what_is_identified_stands_beside_what_is_stated() {
    let mut recording = stated("armature=\"0.2\" damping=\"0.5\" frictionloss=\"1.5\"");
    let of_file = fitted(&Preset::StatedArm.model(&recording).unwrap(), &recording);
    for run in &mut recording.trajectories {
        let torque = of_file.predict(run).unwrap().total;
        let noise = |t: usize, joint: usize| 0.01 * ((t as f64 + 0.3 * joint as f64) * 78.233).sin();
        let mut tau = run.channels_mut().tau;
        for joint in 0..3 {
            tau[joint].iter_mut().enumerate().for_each(|(t, tau)| *tau = torque[joint][t] + noise(t, joint));
        }
    }
    let mut model = Preset::RigidBody.model(&recording).unwrap();
    for id in ["viscous-friction", "coulomb-friction", "rotor-inertia"] {
        model = model.with_effect(registry::find(id).unwrap(), &[0, 1, 2]).unwrap();
    }
    let identified = fitted(&model, &recording);
    let compared: Vec<_> = identified.parameters.iter().filter(|own| own.stated.is_some()).collect();
    assert!(compared.len() > 12, "{}", compared.len());
    for own in &compared {
        let stated = own.stated.unwrap();
        assert!((own.value - stated).abs() < 0.02 * stated.abs().max(0.5), "{}: {} {stated}", own.name, own.value);
    }
    let named = |name: &str, joint: usize| {
        compared.iter().find(|own| own.name == name && own.joint == Some(joint)).map(|own| own.stated.unwrap())
    };
    let (damping, friction) = (named("viscous_coefficient", 1).unwrap(), named("coulomb_torque", 2).unwrap());
    assert!((damping - 0.5).abs() < 1e-6 && (friction - 1.5).abs() < 1e-6, "{damping} {friction}");
    // Nothing is stated of an offset, nor of how dry friction would depend on the load.
    let mut more = model.clone();
    for id in ["torque-offset", "load-friction"] {
        more = more.with_effect(registry::find(id).unwrap(), &[1]).unwrap();
    }
    let parameters = fitted(&more, &recording).parameters;
    let of = |name: &str| parameters.iter().find(|own| own.name == name).unwrap().stated;
    assert_eq!((of("offset"), of("load_friction_ratio")), (None, None));

    let mut heavier = recording.clone();
    let chain = heavier.chain.as_mut().unwrap();
    let link = chain.axes[2].stated.as_mut().unwrap().link.as_mut().unwrap();
    link.iter_mut().for_each(|value| *value *= 1.3);
    let off = fitted(&model, &heavier);
    let told = off.beside_stated().unwrap();
    assert!(told.contains("lie outside") && told.contains('3'), "{told}");
    let friction = off.parameters.iter().filter(|own| own.name == "coulomb_torque");
    assert!(friction.clone().count() == 3 && friction.clone().all(|own| own.contradicts_stated().is_some()));
}

/// A log that is read with the file of a planar arm is one of a planar arm: its links, its posture, and what resists its joints.
#[test]
fn the_file_of_a_planar_arm_makes_a_planar_arm() {
    let scenario = Scenario::embedded();
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    std::fs::write(&log, to_csv_bytes(&recording.trajectories[0])).unwrap();
    let with_end = |said: &str| {
        let last = scenario.arm.links.last().unwrap().length;
        with_tool(&mjcf(&scenario.arm, said), last)
    };
    let file = SerialArm::parse(&with_end("damping=\"0.5\" stiffness=\"2\" springref=\"0.25\"")).unwrap();
    let mapping = Some(MappingSpec::default().with_axes_of(&file).unwrap());
    let read = read(&[log], &ReadOptions { mapping, ..ReadOptions::default() }, &Monitor::new()).unwrap();
    assert!(read.recording.spatial().is_none() && read.recording.states_arm());
    let arm = read.recording.stated_arm.as_ref().unwrap();
    for (own, link) in arm.links.iter().zip(&scenario.arm.links) {
        for (own, link) in
            [(own.mass, link.mass), (own.length, link.length), (own.com, link.com), (own.inertia, link.inertia)]
        {
            assert!((own - link).abs() < 1e-9, "{own} {link}");
        }
    }
    let (own, posture) = (read.recording.assumed_posture(), scenario.arm.posture);
    assert!((own.zero_angle - posture.zero_angle).abs() < 1e-9 && own.sign() == posture.sign());
    // Its springs and its damping are a term of their own.
    let stated = fitted(&Preset::StatedArm.model(&read.recording).unwrap(), &read.recording);
    let run = &read.recording.trajectories[0];
    let resists = Signals::from_fn(3, run.len(), |joint, t| 0.5 * run.qd[joint][t] + 2.0 * (run.q[joint][t] - 0.25));
    assert_same(&stated.predict(run).unwrap().terms[1], &resists, 1e-9);
}

/// In space as in the plane: what the base parameters take up is named beside what the file states, and nothing where they agree.
#[test]
fn a_payload_is_named_beside_masses_that_are_stated_in_space() {
    let embedded = Scenario::embedded();
    let last = embedded.arm.links.last().unwrap().length;
    let chain = SerialArm::parse(&with_tool(&mjcf(&embedded.arm, "armature=\"0.05\""), last)).unwrap().chain();
    let report = |effects: Vec<HiddenEffect>| {
        let recording = simulate(&Scenario { effects, ..embedded.clone() }, &Monitor::new()).unwrap();
        let mut recording = Recording { chain: Some(chain.clone()), stated_arm: None, posture: None, ..recording };
        for run in &mut recording.trajectories {
            let qdd = run.qdd.clone();
            let mut tau = run.channels_mut().tau;
            for joint in 0..3 {
                tau[joint].iter_mut().zip(&qdd[joint]).for_each(|(tau, qdd)| *tau += 0.05 * qdd);
            }
        }
        let split = Split::automatic(&recording);
        let body = fit(&Preset::RigidBody.model(&recording).unwrap(), &recording, &split, &Monitor::new()).unwrap();
        diagnose(&body, &recording, &split, &Monitor::new()).unwrap()
    };
    let payload = embedded.hide_by_strength("tip-payload", &[0], 0.1).unwrap();
    let truth = payload[0].parameters[0];
    let told = report(payload);
    let named = told.effects.iter().find(|effect| effect.effect.id == "tip-payload");
    let mass = named.unwrap_or_else(|| panic!("{:?}", told.effects)).parameters[0].value;
    assert!((mass / truth - 1.0).abs() < 0.05, "{mass}, not {truth}");
    let told = report(Vec::new());
    assert!(told.effects.iter().all(|effect| effect.effect.id != "tip-payload"), "{:?}", told.effects);
    assert!(!told.notes.contains(&Note::StatedArmDiffers), "{:?}", told.notes);
}

#[test]
fn without_masses_nothing_is_stated() {
    let mut recording = stated("");
    for axis in &mut recording.chain.as_mut().unwrap().axes {
        axis.stated = None;
    }
    assert!(!recording.states_arm());
    assert!(Preset::StatedArm.model(&recording).unwrap_err().to_string().contains("states no arm"));
    let identified = fitted(&Preset::RigidBody.model(&recording).unwrap(), &recording);
    assert!(identified.parameters.iter().all(|own| own.stated.is_none()) && identified.beside_stated().is_none());
    let planar = StatedArm::Planar(Scenario::embedded().arm);
    assert!(planar.can_be_of(3) && !planar.can_be_of(2));
}
