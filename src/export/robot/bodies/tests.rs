//! Masses of links: they can exist, they give the torque, and nothing else of the file changes.

use super::*;
use crate::export::robot::{Format, Spliced, write};
use crate::export::tests::{runs, succeeds};
use crate::model::{Model, RigidBody, fit};
use crate::progress::Monitor;
use crate::recording::split::Split;
use crate::simulation::{Scenario, simulate};

/// An arm in space; `{…}` are inertials.
const URDF: &str = r#"<robot name="arm"> <!-- kept -->
  <link name="base"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="column"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/></joint>
  <link name="column">
    <inertial> <!-- from the drawing -->
      <mass value='3'/>
      <origin rpy="0 0 0.5" xyz="0 0.02 0.1"/>
      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.03"/>
    </inertial>
  </link>
  <joint name="lift" type="continuous"><parent link="column"/><child link="upper"/><origin xyz="0 0.1 0.2" rpy="-1.5707963267948966 0 0"/><axis xyz="0 0 1"/></joint>
  <link name="upper"><inertial><mass value="2"/><origin xyz="0 0 0"/><inertia ixx="0.02" iyy="0.03" izz="0.03"/></inertial></link>
  <joint name="reach" type="continuous"><parent link="upper"/><child link="hand"/><origin xyz="0.5 0 0"/><axis xyz="0 0.6 0.8"/></joint>
  <link name="hand">
    <!-- nothing is known of it -->
  </link>
  <joint name="bolt" type="fixed"><parent link="hand"/><child link="tool"/><origin xyz="0.1 0 0.2"/></joint>
  <link name="tool"><inertial><mass value="0.3"/><origin xyz="0.05 0 0"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>
"#;

const MJCF: &str = r#"<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="column" pos="0 0 0.3">
      <joint name="turn" axis="0 0 1"/> <!-- kept -->
      <inertial pos="0 0.02 0.1" euler="0 0 0.5" mass="3" diaginertia="0.05 0.05 0.03"/>
      <body name="upper" pos="0 0.1 0.2" euler="-1.5707963267948966 0 0">
        <joint name="lift" axis="0 0 1"/>
        <inertial mass="2" pos="0 0 0" fullinertia="0.02 0.03 0.03 0 0 0"/>
        <body name="hand" pos="0.5 0 0">
          <joint name="reach" axis="0 0.6 0.8"/>
          <body name="tool" pos="0.1 0 0.2"><inertial pos="0.05 0 0" mass="0.3" diaginertia="0.001 0.001 0.001"/></body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"#;

/// What moves the arm, with the torque of bodies that are others than the file's: `scale` times their own.
fn recording(scale: f64) -> Recording {
    let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
    recording.trajectories.truncate(3);
    let arm = SerialArm::parse(URDF).unwrap();
    let body = |mass: f64, com: [f64; 3], moments: [f64; 3]| Body {
        mass,
        com: com.into(),
        inertia: nalgebra::Matrix3::from_diagonal(&moments.into()),
    };
    let bodies = [
        body(5.0, [0.05, 0.0, 0.15], [0.08, 0.09, 0.05]),
        body(2.5, [0.25, 0.03, -0.02], [0.015, 0.06, 0.07]),
        body(1.2, [0.02, 0.0, 0.12], [0.012, 0.01, 0.004]),
    ];
    let parameters: Vec<f64> = bodies.iter().flat_map(Body::parameters).map(|value| scale * value).collect();
    let regressor = arm.regressor(false);
    for trajectory in &mut recording.trajectories {
        let states: Vec<[Vec<f64>; 3]> = (0..trajectory.len())
            .map(|sample| [&trajectory.q, &trajectory.qd, &trajectory.qdd].map(|one| one.at(sample).collect()))
            .collect();
        let mut channels = trajectory.channels_mut();
        for (sample, [q, qd, qdd]) in states.iter().enumerate() {
            let mut torque = [0.0; 3];
            regressor.torque(q, qd, qdd, &parameters, &mut torque);
            (0..3).for_each(|joint| channels.tau[joint][sample] = torque[joint]);
        }
    }
    recording.chain = Some(arm.chain());
    recording
}

fn identified(recording: &Recording) -> Fitted {
    let model = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] };
    fit(&model, recording, &Split::automatic(recording), &Monitor::new()).unwrap()
}

fn spliced(fitted: &Fitted, recording: &Recording, format: Format, text: &str) -> Spliced {
    write(fitted, format, text, &[], Some(recording), true).unwrap()
}

/// The text without the values of masses, so that what else is in it can be compared.
fn without_masses(text: &str) -> String {
    let keys = [
        "value",
        "xyz",
        "ixx",
        "ixy",
        "ixz",
        "iyy",
        "iyz",
        "izz",
        "pos",
        "mass",
        "fullinertia",
        "diaginertia",
        "euler",
    ];
    let is_mass = |line: &&str| ["<mass", "<inertia", "<inertial", "<origin rpy"].iter().any(|tag| line.contains(tag));
    let (mass, rest): (Vec<&str>, Vec<&str>) = text.lines().partition(is_mass);
    let mut words = mass.join("\n");
    for key in keys {
        while let Some(start) = words.find(&format!(" {key}=")) {
            let quote = start + key.len() + 2;
            let letter = words[quote..].chars().next().unwrap();
            let end = quote + 1 + words[quote + 1..].find(letter).unwrap() + 1;
            words.replace_range(start..end, "");
        }
    }
    [words, rest.join("\n")].concat()
}

#[test]
fn links_that_can_exist_have_the_torque_that_was_identified() {
    let recording = recording(1.0);
    let fitted = identified(&recording);
    for (format, text) in [(Format::Urdf, URDF), (Format::Mjcf, MJCF)] {
        let spliced = spliced(&fitted, &recording, format, text);
        let weighed = spliced.weighed.as_ref().unwrap();
        // The tool is the heaviest of what the file says of the last joint.
        let names: Vec<&str> = weighed.links.iter().map(|link| link.name.as_str()).collect();
        assert_eq!(names, ["column", "upper", "tool"]);
        assert!(weighed.links.iter().all(|link| link.now.is_possible()));
        let written = SerialArm::parse(&spliced.text).unwrap();
        let of_link = |name: &str| {
            let mut parts = written.joints.iter().flat_map(|joint| &joint.parts);
            parts.find(|part| part.name == name).unwrap().body.unwrap()
        };
        for link in &weighed.links {
            let own = of_link(&link.name);
            assert!((own.mass - link.now.mass).abs() < 1e-12 && (own.com - link.now.com).norm() < 1e-12);
            assert!((own.inertia - link.now.inertia).norm() < 1e-12, "{} {}", own.inertia, link.now.inertia);
        }
        for [free, links] in &weighed.cost {
            assert!(*free < 1e-9 && *links < 1e-4, "{free} {links}");
        }
        // The torque of the file that was written, by its own reader.
        let regressor = written.regressor(false);
        for trajectory in &recording.trajectories {
            let predicted = fitted.predict(trajectory).unwrap().total;
            for sample in (0..trajectory.len()).step_by(50) {
                let [q, qd, qdd] =
                    [&trajectory.q, &trajectory.qd, &trajectory.qdd].map(|one| one.at(sample).collect::<Vec<_>>());
                let mut torque = [0.0; 3];
                regressor.torque(&q, &qd, &qdd, &written.stated_parameters(), &mut torque);
                for joint in 0..3 {
                    let size =
                        recording.trajectories[0].tau[joint].iter().fold(0.0_f64, |most, tau| most.max(tau.abs()));
                    let error = (torque[joint] - predicted[joint][sample]).abs();
                    assert!(error < 0.01 * size, "joint {joint}: {error} of {size}");
                }
            }
        }
        assert_eq!(without_masses(&spliced.text), without_masses(text));
        assert!(!spliced.not_held.iter().any(|one| one.what == "rigid body"));
    }
}

#[test]
fn what_no_link_can_weigh_costs_error_and_is_not_written() {
    let recording = recording(-1.0);
    let fitted = identified(&recording);
    let spliced = spliced(&fitted, &recording, Format::Urdf, URDF);
    let weighed = spliced.weighed.unwrap();
    assert!(weighed.links.iter().all(|link| link.now.is_possible()), "{:?}", weighed.links);
    assert!(weighed.cost[0][1] > 0.5, "{:?}", weighed.cost);
}

#[test]
fn masses_need_a_motion_and_an_arm_that_moves_so() {
    let recording = recording(1.0);
    let fitted = identified(&recording);
    let fails = |text: &str, joints: &[&str], log: Option<&Recording>| {
        let joints: Vec<String> = joints.iter().map(|name| (*name).to_owned()).collect();
        write(&fitted, Format::Urdf, text, &joints, log, true).unwrap_err().to_string()
    };
    assert!(fails(URDF, &[], None).contains("--log"));
    let other = URDF.replace("xyz=\"0 0.6 0.8\"", "xyz=\"1 0 0\"");
    assert!(fails(&other, &[], Some(&recording)).contains("q = 0"), "{}", fails(&other, &[], Some(&recording)));
    assert!(fails(URDF, &["lift", "turn", "reach"], Some(&recording)).contains("turn,lift,reach"));
}

/// The same torque by programs of others: Pinocchio reads the URDF, MuJoCo the MJCF.
#[test]
fn pinocchio_and_mujoco_need_our_torque() {
    const PINOCCHIO: &str = "import json, numpy as np, pinocchio as pin\n\
        model = pin.buildModelFromUrdf('arm.urdf'); data = model.createData()\n\
        model.gravity.linear = np.array([0, 0, -9.81])\n\
        def place(q):\n\
        \x20   return np.concatenate([[v] if model.joints[i + 1].nq == 1 else [np.cos(v), np.sin(v)] for i, v in enumerate(q)])\n\
        for q, qd, qdd, tau in json.load(open('vectors.json')):\n\
        \x20   own = pin.rnea(model, data, place(q), np.array(qd), np.array(qdd))\n\
        \x20   assert np.max(np.abs(own - tau)) < 1e-9, (own, tau)\n";
    const MUJOCO: &str = "import json, numpy as np, mujoco as mj\n\
        model = mj.MjModel.from_xml_path('arm.xml'); data = mj.MjData(model)\n\
        for q, qd, qdd, tau in json.load(open('vectors.json')):\n\
        \x20   data.qpos, data.qvel, data.qacc = q, qd, qdd\n\
        \x20   mj.mj_inverse(model, data)\n\
        \x20   assert np.max(np.abs(data.qfrc_inverse - tau)) < 1e-9, (data.qfrc_inverse, tau)\n";
    let recording = recording(1.0);
    let fitted = identified(&recording);
    let programs =
        [("pinocchio", PINOCCHIO, Format::Urdf, "arm.urdf", URDF), ("mujoco", MUJOCO, Format::Mjcf, "arm.xml", MJCF)];
    for (library, script, format, name, text) in programs {
        if !runs("python3", &["-c", &format!("import numpy, {library}")]) {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let text = spliced(&fitted, &recording, format, text).text;
        let arm = SerialArm::parse(&text).unwrap();
        let (regressor, parameters) = (arm.regressor(false), arm.stated_parameters());
        let state = |number: f64| {
            let three = |phase: f64| [0.0, 1.0, 2.0].map(|joint: f64| (number * (joint + 1.3) + phase).sin());
            let [q, qd, qdd] = [three(0.0), three(1.0), three(2.0)];
            let mut tau = [0.0; 3];
            regressor.torque(&q, &qd, &qdd, &parameters, &mut tau);
            [q, qd, qdd, tau]
        };
        let vectors: Vec<_> = (0..20).map(|number| state(f64::from(number))).collect();
        std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::write(folder.path().join("vectors.json"), serde_json::to_string(&vectors).unwrap()).unwrap();
        succeeds(folder.path(), "python3", &["-c", script]);
    }
}
