use super::*;
use crate::effect::registry;
use crate::model::{Model, RigidBody, fit};
use crate::progress::Monitor;
use crate::recording::split::Split;
use crate::simulation::{Scenario, simulate};

const URDF: &str = "<?xml version=\"1.0\"?>\n<!-- ours,\tnot to be touched -->\n<robot name='arm'>\n  <link name=\"base\"/>\n  \
<joint type=\"revolute\" name=\"wrist\"><parent link=\"upper\"/><child link=\"hand\"/></joint>\n  \
<joint name=\"shoulder\" type=\"revolute\">\n    <parent link=\"base\"/>\n    <child link=\"lower\"/>\n    \
<dynamics friction='0.1' damping = \"7\"/>  <!-- guessed -->\n  </joint>\n  \
<joint name=\"elbow\" type=\"continuous\">\n    <parent link=\"lower\"/>\n    <child link=\"upper\"/>\n  </joint>\n  \
<joint name=\"bolt\" type=\"fixed\"><parent link=\"hand\"/><child link=\"tool\"/></joint>\n</robot>\n";

const MJCF: &str = "<mujoco>\n  <compiler angle=\"degree\"/>\n  <worldbody><body>\n    <joint name=\"a\" armature=\"1\"/>\n    \
<body><joint/><body><joint name=\"c\" type=\"hinge\" damping=\"3\"/></body></body>\n  </body></worldbody>\n</mujoco>\n";

fn recording() -> Recording {
    let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
    recording.trajectories.truncate(3);
    recording
}

/// The embedded arm with effects on single joints (from 0).
fn fitted(recording: &Recording, effects: &[(&str, usize)]) -> Fitted {
    let start = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] };
    let add =
        |model: Model, (id, joint): &(&str, usize)| model.with_effect(registry::find(id).unwrap(), &[*joint]).unwrap();
    let model = effects.iter().fold(start, add);
    fit(&model, recording, &Split::automatic(recording), &Monitor::new()).unwrap()
}

#[test]
fn only_the_values_change_in_a_urdf() {
    let recording = recording();
    let model = fitted(
        &recording,
        &[
            ("viscous-friction", 0),
            ("coulomb-friction", 0),
            ("coulomb-friction", 1),
            ("coulomb-friction", 2),
            ("rotor-inertia", 1),
        ],
    );
    let value = |term: usize| model.linear_of(term)[0];
    let spliced = write(&model, Format::Urdf, URDF, &[], Some(&recording), false).unwrap();
    let mut expected = URDF.to_owned();
    // What is negative is not possible, so it is told and not written.
    if value(1) >= 0.0 {
        expected = expected.replace("damping = \"7\"", &format!("damping = \"{}\"", value(1)));
    }
    if value(2) >= 0.0 {
        expected = expected.replace("friction='0.1'", &format!("friction='{}'", value(2)));
    }
    if value(3) >= 0.0 {
        let old = "<child link=\"upper\"/>\n";
        let new = format!("<child link=\"upper\"/>\n    <dynamics friction=\"{}\"/>\n", value(3));
        expected = expected.replace(old, &new);
    }
    if value(4) >= 0.0 {
        let old = "<child link=\"hand\"/></joint>";
        let new = format!("<child link=\"hand\"/><dynamics friction=\"{}\"/></joint>", value(4));
        expected = expected.replace(old, &new);
    }
    assert_eq!(spliced.text, expected);
    assert!(value(3) > 0.0, "the friction that the embedded arm hides is found");
    let told: Vec<&str> = spliced.not_held.iter().map(|one| one.what.as_str()).collect();
    assert!(told.contains(&"rigid body") && told.iter().any(|what| what.contains("reflected_inertia")), "{told:?}");
    assert!(spliced.not_held.iter().all(|one| one.share.is_some_and(f64::is_finite)));
}

#[test]
fn an_mjcf_holds_armature_and_springs_in_its_own_units() {
    let recording = recording();
    let model = fitted(&recording, &[("joint-spring", 1), ("rotor-inertia", 0), ("stribeck-friction", 2)]);
    let spliced = write(&model, Format::Mjcf, MJCF, &[], None, false).unwrap();
    let of = |attribute: &str| spliced.written.iter().find(|change| change.attribute == attribute);
    let [stiffness, preload] = [model.linear_of(1)[0], model.linear_of(1)[1]];
    if stiffness >= 0.0 {
        let rest = of("springref").unwrap();
        assert!((rest.value + (preload / stiffness).to_degrees()).abs() < 1e-9 * rest.value.abs().max(1.0));
        assert_eq!(rest.joint, "joint at line 5");
    }
    if let Some(armature) = of("armature") {
        assert_eq!((armature.joint.as_str(), armature.before.as_deref()), ("a", Some("1")));
    }
    assert!(of("frictionloss").is_some_and(|change| change.joint == "c"), "the Coulomb part of Stribeck friction");
    assert!(spliced.not_held.iter().any(|one| one.what.contains("stribeck_torque")));
}

/// What another file of the robot stated of its joints, and this one can't say.
#[test]
fn stated_springs_and_rotors_are_told_where_the_format_has_no_word_for_them() {
    use crate::arm::stated::Resistance;
    let recording = recording();
    let mut model = fitted(&recording, &[]);
    let spring = Resistance { stiffness: 2.0, preload: 0.5, damping: 0.25, ..Resistance::default() };
    let rotor = Resistance { rotor_inertia: 0.1, ..Resistance::default() };
    model.model.terms.push(Term::Resistance(vec![spring, rotor, Resistance::default()]));
    let told = |format: Format, text: &str| {
        let spliced = write(&model, format, text, &[], Some(&recording), false).unwrap();
        let resists = spliced.not_held.into_iter().filter(|one| one.what.starts_with("stated resistance"));
        (spliced.written.len(), resists.collect::<Vec<NotHeld>>())
    };
    let (written, lost) = told(Format::Urdf, URDF);
    assert_eq!(written, 1, "the damping");
    let what: Vec<String> = lost.iter().map(|one| format!("{} {:?}", one.what, one.value)).collect();
    assert_eq!(
        what,
        [
            "stated resistance of joints: spring stiffness, joint 1 Some((2.0, \"N m/rad\"))",
            "stated resistance of joints: torque of the spring at q = 0, joint 1 Some((0.5, \"N m\"))",
            "stated resistance of joints: rotor inertia, joint 2 Some((0.1, \"kg m²\"))",
        ]
    );
    assert!(lost.iter().all(|one| one.share.is_some_and(|share| share > 0.0 && share < 1.0)), "{lost:?}");
    // An MJCF has words for all of it.
    assert_eq!(told(Format::Mjcf, MJCF).1, []);
}

#[test]
fn what_the_file_has_and_the_model_has_not_stays_and_is_told() {
    let recording = recording();
    let model = fitted(&recording, &[]);
    let spliced = write(&model, Format::Mjcf, MJCF, &[], Some(&recording), false).unwrap();
    let stays: Vec<&NotHeld> = spliced.not_held.iter().filter(|one| one.why == STAYS).collect();
    let told: Vec<String> = stays.iter().map(|one| format!("{} {:?}", one.what, one.value)).collect();
    assert_eq!(told, ["armature of a Some((1.0, \"kg m²\"))", "damping of c Some((3.0, \"N m s/rad\"))"]);
    assert!(stays.iter().all(|one| one.share.is_some_and(|share| share > 0.0)));
    assert_eq!(spliced.text, MJCF);
}

#[test]
fn what_can_not_be_spliced_is_told_with_the_remedy() {
    let recording = recording();
    let model = fitted(&recording, &[]);
    let message = |text: &str, joints: &[&str]| {
        let joints: Vec<String> = joints.iter().map(|name| (*name).to_owned()).collect();
        write(&model, Format::Urdf, text, &joints, None, false).unwrap_err().to_string()
    };
    assert!(message("<robot><joint></robot>", &[]).contains("1:"), "{}", message("<robot><joint></robot>", &[]));
    assert!(message(MJCF, &[]).contains("<mujoco>"));
    assert!(message("<robot/>", &[]).contains("no joint"));
    assert!(message(URDF, &["shoulder", "elbow"]).contains("--joints"));
    assert!(
        message(URDF, &["shoulder", "elbow", "bolt"]).contains("no moving joint `bolt`; it has shoulder, elbow, wrist")
    );
    // Nothing grows by entities, and circles end.
    let bomb = "<!DOCTYPE r [<!ENTITY a \"aaaa\">]><robot>&a;</robot>";
    assert!(!message(bomb, &[]).is_empty());
    let joint = |name: &str, from: &str, to: &str| {
        format!("<joint name=\"{name}\" type=\"revolute\"><parent link=\"{from}\"/><child link=\"{to}\"/></joint>")
    };
    let circle = format!("<robot>{}{}</robot>", joint("a", "x", "y"), joint("b", "y", "x"));
    assert!(message(&circle, &[]).contains("2 moving joint"));
}
