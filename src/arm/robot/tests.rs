use std::f64::consts::FRAC_PI_2;

use super::*;
use crate::arm::GRAVITY;

const ARM: &str = r#"<robot name="r">
      <joint name="tool" type="fixed"><origin xyz="0 0 1"/><parent link="l4"/><child link="t"/></joint>
      <joint name="j3" type="prismatic"><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.4 0.5"/><axis xyz="0 1 1"/><parent link="l2"/><child link="l3"/></joint>
      <joint name="j1" type="revolute"><origin xyz="0 0 0.4" rpy="0.2 0 0"/><axis xyz="0 0 1"/><parent link="base"/><child link="l1"/></joint>
      <joint name="plate" type="fixed"><origin xyz="0.3 0 0" rpy="0 0.7 0"/><parent link="l1"/><child link="p"/></joint>
      <joint name="j2" type="continuous"><origin xyz="0 0.1 0"/><axis xyz="1 0 0"/><parent link="p"/><child link="l2"/></joint>
      <joint name="j4" type="revolute"><origin xyz="0.5 0 0"/><axis xyz="0 1 1"/><parent link="l3"/><child link="l4"/></joint>
      <joint name="finger" type="prismatic"><mimic joint="j3"/><parent link="l4"/><child link="f"/></joint>
      <link name="l1"/>
      <link name="p"><inertial><mass value="0.4"/><origin xyz="0 0.1 0"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="l2"><inertial><mass value="2"/><origin xyz="0.1 0 -0.2" rpy="0.1 0.2 0.3"/><inertia ixx="0.3" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="-0.02"/></inertial></link>
      <link name="t"><inertial><mass value="1.5"/><origin xyz="0.3 -0.2 0.4"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>
    </robot>"#;

/// The same arm, by hand: the order of its parts is that of the tree, rotations are said otherwise, axes come by classes.
const SAME: &str = r#"<mujoco model="r">
  <compiler angle="radian" eulerseq="XYZ"/>
  <option gravity="0 0 -9.81"/>
  <default>
    <joint axis="0 1 1"/>
    <default class="upright"><joint axis="0 0 1"/><default class="across"><joint axis="1 0 0"/></default></default>
    <default class="rail"><joint type="slide"/></default>
  </default>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="l1" pos="0 0 0.4" axisangle="1 0 0 0.2" childclass="upright">
      <joint name="j1"/>
      <geom size="0.1"/>
      <body name="p" pos="0.3 0 0" quat="0.9393727128473789 0 0.3428978074554514 0">
        <inertial pos="0 0.1 0" mass="0.4" diaginertia="0.1 0.1 0.1"/>
        <body name="l2" pos="0 0 0">
          <joint name="j2" pos="0 0.1 0" class="across"/>
          <inertial pos="0.1 0.1 -0.2" euler="0.1 0.2 0.3" mass="2" fullinertia="0.3 0.2 0.25 0.01 0 -0.02"/>
          <body name="l3" pos="0.1 0.3 0.3" euler="0.3 -0.4 0.5" childclass="rail">
            <joint name="j3"/>
            <body name="l4" pos="0.5 0 0" childclass="main">
              <joint name="j4" type="hinge"/>
              <body name="t" pos="0 0 1"><inertial pos="0.3 -0.2 0.4" mass="1.5" diaginertia="0 0 0"/></body>
              <body name="f"><joint name="finger" type="slide"/></body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="finger" joint2="j3"/></equality>
  <actuator><motor joint="j1"/></actuator>
</mujoco>"#;

fn torque(regressor: &Regressor, parameters: &[f64], state: [[f64; 4]; 3]) -> [f64; 4] {
    let mut torque = [0.0; 4];
    regressor.torque(&state[0], &state[1], &state[2], parameters, &mut torque);
    torque
}

const STATE: [[f64; 4]; 3] = [[0.4, -0.9, 0.25, 1.3], [1.0, -0.5, 0.3, 2.0], [-2.0, 1.0, 4.0, 3.0]];

/// The weight of a point on the last link by its height, which is worked out from the numbers of the file.
#[test]
fn weight_is_the_slope_of_height() {
    let arm = SerialArm::parse(ARM).unwrap();
    let names: Vec<&str> = arm.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!((names, arm.sliding()), (vec!["j1", "j2", "j3", "j4"], vec![false, false, true, false]));
    let parts = |joint: usize| arm.joints[joint].parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>();
    assert_eq!((parts(0), parts(3)), (vec!["l1", "p"], vec!["l4", "t", "f"]));
    let pose = |xyz: [f64; 3], [r, p, y]: [f64; 3]| {
        Isometry3::from_parts(Vector3::from(xyz).into(), UnitQuaternion::from_euler_angles(r, p, y))
    };
    let height = |q: &[f64; 4]| {
        let turn = |axis: [f64; 3], by: f64| Isometry3::rotation(Vector3::from(axis).normalize() * by);
        let frame = pose([0.0, 0.0, 0.4], [0.2, 0.0, 0.0])
            * turn([0.0, 0.0, 1.0], q[0])
            * pose([0.3, 0.0, 0.0], [0.0, 0.7, 0.0])
            * pose([0.0, 0.1, 0.0], [0.0; 3])
            * turn([1.0, 0.0, 0.0], q[1])
            * pose([0.1, 0.2, 0.3], [0.3, -0.4, 0.5])
            * Isometry3::from(nalgebra::Translation3::from(Vector3::new(0.0, 1.0, 1.0).normalize() * q[2]))
            * pose([0.5, 0.0, 0.0], [0.0; 3])
            * turn([0.0, 1.0, 1.0], q[3])
            * pose([0.0, 0.0, 1.0], [0.0; 3]);
        (frame * nalgebra::Point3::new(0.3, -0.2, 0.4)).z
    };
    let mut parameters = arm.stated_parameters();
    parameters[..30].fill(0.0);
    let found = torque(&arm.regressor(false), &parameters, [STATE[0], [0.0; 4], [0.0; 4]]);
    for (joint, found) in found.iter().enumerate() {
        let shifted = |by: f64| {
            let mut q = STATE[0];
            q[joint] += by;
            height(&q)
        };
        let slope = 1.5 * GRAVITY * (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
        assert!((found - slope).abs() < 1e-6, "joint {joint}: {found} {slope}");
    }
}

/// Torques of bodies say the same in the frames of the file and in those of the chain, whose base parameters are as many.
#[test]
fn the_chain_moves_as_the_file_does() {
    let arm = SerialArm::parse(ARM).unwrap();
    let (own, chain) = (arm.regressor(false), arm.chain().regressor(&arm.sliding()));
    let states = 120;
    let rows = |regressor: &Regressor| {
        let mut all = Vec::new();
        for number in 0..states {
            let state =
                |phase: f64| std::array::from_fn::<f64, 4, _>(|j| (number as f64 * (1.3 + j as f64) + phase).sin());
            let mut rows = vec![0.0; 160];
            regressor.fill(&state(0.0), &state(1.0), &state(2.0), &mut rows);
            all.extend(rows);
        }
        nalgebra::DMatrix::from_row_slice(4 * states, 40, &all)
    };
    let (own, chain) = (rows(&own), rows(&chain));
    // What the bodies of the file need, the chain can give with other numbers.
    let wanted = &own * nalgebra::DVector::from_vec(arm.stated_parameters());
    let found = chain.clone().svd(true, true).solve(&wanted, 1e-10).unwrap();
    assert!((&chain * found - &wanted).norm() < 1e-9 * wanted.norm());
}

/// What the file states of its bodies makes the same torque in the frames of the chain, exactly.
#[test]
fn the_chain_states_the_bodies_of_the_file() {
    for text in [ARM, SAME] {
        let arm = SerialArm::parse(text).unwrap();
        let chain = arm.chain();
        assert!(chain.states_links() && chain.check().is_ok());
        let own = torque(&arm.regressor(false), &arm.stated_parameters(), STATE);
        let found = torque(&chain.regressor(&arm.sliding()), &chain.stated_parameters(), STATE);
        for (own, found) in own.iter().zip(found) {
            assert!((own - found).abs() < 1e-9 && own.abs() > 0.1, "{own} {found}");
        }
        assert!((arm.mass() - 3.9).abs() < 1e-12);
    }
    let arm = SerialArm::parse(ARM).unwrap();
    assert_eq!(arm.unweighed().collect::<Vec<_>>(), ["l1", "l3", "l4", "f"]);
    let bare = ARM.split("<inertial>").map(|part| part.split("</inertial>").last().unwrap()).collect::<String>();
    assert!(!SerialArm::parse(&bare).unwrap().chain().states_links());
}

/// Joints of either format with the same limits and the same resistance, in the units of each.
#[test]
fn limits_and_resistance_are_those_of_the_file() {
    let urdf = ARM
        .replace(
            "<axis xyz=\"0 0 1\"/>",
            "<axis xyz=\"0 0 1\"/><limit lower=\"-2\" upper=\"1.5\" velocity=\"3\" effort=\"40\"/><dynamics damping=\"0.5\" friction=\"2\"/>",
        )
        .replace("<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" velocity=\"0\" effort=\"7\"/>");
    let stated = |arm: &SerialArm, joint: usize| (arm.joints[joint].limits, arm.joints[joint].resistance);
    let first = Limits { position: Some([-2.0, 1.5]), velocity: Some(3.0), effort: Some(40.0) };
    let resists = Resistance { damping: 0.5, friction: 2.0, ..Resistance::default() };
    let arm = SerialArm::parse(&urdf).unwrap();
    assert_eq!(stated(&arm, 0), (first, resists));
    assert_eq!(stated(&arm, 1).0, Limits { effort: Some(7.0), ..Limits::default() }, "an endless joint has no ends");
    assert_eq!(stated(&arm, 2), (Limits::default(), Resistance::default()));
    assert_eq!(arm.chain().limits(0), first);
    assert_eq!(arm.chain().resistances()[0], resists);

    let joint = |said: &str| SAME.replace("<joint name=\"j1\"/>", &format!("<joint name=\"j1\" {said}/>"));
    let mjcf =
        joint("range=\"-2 1.5\" actuatorfrcrange=\"-40 30\" damping=\"0.5\" frictionloss=\"2\" armature=\"0.1\"");
    let arm = SerialArm::parse(&mjcf).unwrap();
    let with_rotor = Resistance { rotor_inertia: 0.1, ..resists };
    assert_eq!(stated(&arm, 0), (Limits { velocity: None, ..first }, with_rotor));
    // A spring of 3 N m/rad that is at rest at 0.5 rad, or at 90°.
    let spring = |said: &str| {
        let Resistance { stiffness, preload, .. } = stated(&SerialArm::parse(said).unwrap(), 0).1;
        (stiffness, preload)
    };
    let sprung = joint("stiffness=\"3\" springref=\"0.5\"");
    assert_eq!(spring(&sprung), (3.0, -1.5));
    assert_eq!(spring(&joint("stiffness=\"3\"")), (3.0, 0.0));
    let (_, preload) = spring(&sprung.replace("angle=\"radian\" ", "").replace("\"0.5\"", "\"90\""));
    assert!((preload + 3.0 * FRAC_PI_2).abs() < 1e-15);
    let unlimited = SerialArm::parse(&joint("range=\"-2 1.5\" limited=\"false\"")).unwrap();
    assert_eq!(stated(&unlimited, 0).0.position, None);
    let by_word = joint("range=\"-2 1.5\"").replace("<compiler ", "<compiler autolimits=\"false\" ");
    assert_eq!(stated(&SerialArm::parse(&by_word).unwrap(), 0).0.position, None);
    let degrees = joint("range=\"-90 45\"").replace("angle=\"radian\" ", "");
    let [low, high] = stated(&SerialArm::parse(&degrees).unwrap(), 0).0.position.unwrap();
    assert!((low + FRAC_PI_2).abs() < 1e-15 && (high - FRAC_PI_2 / 2.0).abs() < 1e-15);
    let wrong = SerialArm::parse(&joint("damping=\"some\"")).unwrap_err().to_string();
    assert!(wrong.contains("`damping` of <joint> of `j1` is `some`"), "{wrong}");
}

#[test]
fn an_mjcf_is_the_same_arm_as_its_urdf() {
    let [urdf, mjcf] = [ARM, SAME].map(|text| SerialArm::parse(text).unwrap());
    assert_eq!(urdf.sliding(), mjcf.sliding());
    let [one, other] = [&urdf, &mjcf].map(|arm| torque(&arm.regressor(false), &arm.stated_parameters(), STATE));
    for (one, other) in one.iter().zip(other) {
        assert!((one - other).abs() < 1e-9 && one.abs() > 0.1, "{one} {other}");
    }
    let (one, other) = (urdf.chain(), mjcf.chain());
    for (one, other) in one.axes.iter().zip(&other.axes) {
        let pairs = [(one.a, other.a), (one.alpha, other.alpha), (one.d, other.d), (one.theta, other.theta)];
        assert!(pairs.iter().all(|(one, other)| (one - other).abs() < 1e-9), "{one:?} {other:?}");
    }
    let degrees = SAME.replace("angle=\"radian\" ", "").replace("1 0 0 0.2", "1 0 0 11.459155902616466");
    let degrees = degrees.replace("\"0.3 -0.4 0.5\"", "\"17.188733853924695 -22.91831180523293 28.64788975654116\"");
    let turned = SerialArm::parse(&degrees).unwrap();
    assert!((turned.joints[2].frame.to_homogeneous() - mjcf.joints[2].frame.to_homogeneous()).norm() < 1e-12);
}

#[test]
fn joints_that_are_not_asked_for_are_fixed() {
    let some = SerialArm::moving_only(SAME, &["j4".to_owned(), "j1".to_owned()]).unwrap();
    let names: Vec<&str> = some.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["j1", "j4"]);
    assert_eq!(some.joints[0].parts.len(), 4);
}

#[test]
fn what_is_no_arm_is_refused_with_the_remedy() {
    let message = |text: &str| SerialArm::parse(text).unwrap_err().to_string();
    assert!(message("<sdf/>").contains("<sdf>") && message("<robot>").contains("no XML"));
    assert!(message("<robot/>").contains("0 moving joints") && message("<mujoco/>").contains("0 moving joints"));
    let short = message(&ARM.replace("0.1 0.2 0.3\" rpy", "0.1 0.2\" rpy"));
    assert!(short.contains("line 3") && short.contains("`j3` is `0.1 0.2`, but must be 3 finite"), "{short}");
    assert!(message(&ARM.replace("xyz=\"1 0 0\"", "xyz=\"0 0 0\"")).contains("`j2` has an axis of length 0"));
    let hand = ARM
        .replace("<mimic joint=\"j3\"/>", "")
        .replace("<parent link=\"l4\"/><child link=\"f\"/>", "<parent link=\"l1\"/><child link=\"f\"/>");
    assert!(message(&hand).contains("no serial chain"), "{}", message(&hand));
    let circle = ARM.replace("<parent link=\"base\"/>", "<parent link=\"l4\"/>");
    assert!(message(&circle).contains("in circles"));
}

#[test]
fn what_is_not_understood_of_an_mjcf_is_told_with_its_place() {
    let message = |old: &str, new: &str| {
        assert!(SAME.contains(old), "{old}");
        SerialArm::parse(&SAME.replace(old, new)).unwrap_err().to_string()
    };
    for (old, new, told) in [
        ("<light pos=\"0 0 3\"/>", "<include file=\"hand.xml\"/>", "line 10: <include>"),
        ("<geom size=\"0.1\"/>", "<frame pos=\"0 0 1\"/>", "line 13: <frame>"),
        ("<joint name=\"j1\"/>", "<freejoint/>", "fix the base"),
        (
            "<joint name=\"j4\" type=\"hinge\"/>",
            "<joint name=\"j4\" type=\"ball\"/>",
            "`type` of <joint> of `j4` is `ball`",
        ),
        ("<joint name=\"j4\" type=\"hinge\"/>", "<joint name=\"j4\" ref=\"1\"/>", "`ref` of <joint> of `j4` is `1`"),
        ("<joint joint1=\"finger\" joint2=\"j3\"/>", "<weld body1=\"t\"/>", "<weld>"),
        ("eulerseq=\"XYZ\"", "eulerseq=\"XY\"", "line 2: `eulerseq`"),
        ("eulerseq=\"XYZ\"", "coordinate=\"global\"", "`coordinate`"),
        ("quat=\"0.9393727128473789 0 0.3428978074554514 0\"", "quat=\"0 0 0 0\"", "`quat` of <body> of `p`"),
        ("mass=\"1.5\" diaginertia", "diaginertia", "`mass` of <inertial> of `t`"),
    ] {
        let found = message(old, new);
        assert!(found.contains(told), "{found}");
    }
}
