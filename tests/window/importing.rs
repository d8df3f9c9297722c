//! The import assistant: a log whose columns nobody can guess is opened all the same, and its template is what the command line takes.

use torquescope::model::Preset;
use torquescope::recording::mapping::MappingSpec;
use torquescope::recording::torque::TorqueFact;

use super::*;

/// A swing of one joint, under names that say nothing; the angle in degrees, the torque with the other sign.
pub fn nameless() -> String {
    let row = |sample: u32| {
        let t = 0.01 * f64::from(sample);
        format!("{t},{},{}\n", (2.0 * t).sin().to_degrees(), -3.0 * (2.0 * t).sin())
    };
    format!("when,a,b\n{}", (0..400).map(row).collect::<String>())
}

/// Chooses an entry of a list that belongs to a column.
fn choose(window: &mut Window, list: &str, entry: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, entry).click();
    window.run_steps(4);
}

#[test]
fn a_log_without_names_is_opened_by_saying_what_its_columns_are() {
    let folder = tempfile::tempdir().unwrap();
    let [log, template] = ["swing.csv", "swing.toml"].map(|name| folder.path().join(name));
    std::fs::write(&log, nameless()).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::open(vec![log]));
    settle(&mut window);
    click(&mut window, "Say what its columns are…");
    assert!(window.query_by_label("What is in this log?").is_some());
    assert!(!is_enabled(&window, "Open it so") && window.query_by_label("No column is taken for position.").is_some());
    choose(&mut window, "quantity of when", "time");
    choose(&mut window, "quantity of a", "position");
    choose(&mut window, "unit of a", "deg");
    choose(&mut window, "quantity of b", "torque");
    window.get_by_role_and_label(Role::CheckBox, "turn the sign of b").click();
    window.run_steps(3);
    assert!(
        window.query_by_label("b: torque of joint 1").is_some()
            || window.query_by_label_contains("torque of joint 1").is_some()
    );
    type_into(&mut window, "Template for logs like this one", template.display());
    click(&mut window, "Save as template");
    let saved = MappingSpec::from_toml(&std::fs::read_to_string(&template).unwrap()).unwrap();
    assert_eq!((saved.q.unwrap(), saved.tau.unwrap()), (vec!["a".to_owned()], vec!["b".to_owned()]));
    click(&mut window, "Open it so");
    let recording = window.state().session().recording.clone().unwrap();
    let run = &recording.trajectories[0];
    for (q, tau) in run.q[0].iter().zip(&run.tau[0]) {
        assert!((tau - 3.0 * q).abs() < 1e-9, "in rad, and turned: {q}, {tau}");
    }
    assert!(window.query_by_label("What is in this log?").is_none());
}

/// A template that was saved is offered for the next log with the same columns, and only for such a one.
#[test]
fn a_template_is_offered_again_for_logs_of_the_same_columns() {
    let folder = tempfile::tempdir().unwrap();
    let [log, next, other, template] =
        ["swing.csv", "next.csv", "other.csv", "swing.toml"].map(|name| folder.path().join(name));
    std::fs::write(&log, nameless()).unwrap();
    std::fs::write(&next, nameless()).unwrap();
    std::fs::write(&other, nameless().replacen("when", "then", 1)).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    let import = |window: &mut Window, path: &std::path::Path| {
        window.state_mut().order(Order::Import(vec![path.to_owned()], Box::default()));
        settle(window);
    };
    import(&mut window, &log);
    choose(&mut window, "quantity of when", "time");
    choose(&mut window, "quantity of a", "position");
    choose(&mut window, "quantity of b", "torque");
    click(&mut window, "Without friction");
    click(&mut window, "Save as template");
    settle(&mut window);
    let saved = MappingSpec::from_toml(&std::fs::read_to_string(&template).unwrap()).unwrap();
    assert!(saved.torque.has(TorqueFact::WithoutFriction));
    click(&mut window, "Cancel");
    import(&mut window, &other);
    assert!(window.query_by_label_contains("Open it as in").is_none());
    click(&mut window, "Cancel");
    import(&mut window, &next);
    click(&mut window, "Open it as in swing.toml");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!((recording.name.as_str(), recording.torque.has(TorqueFact::WithoutFriction)), ("next", true));
}

/// What is derived is seen raw and behind its filter, which can be set; the log is read so, and the template says so.
#[test]
fn the_filter_of_what_is_derived_is_seen_and_set() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("swing.csv");
    std::fs::write(&log, nameless()).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::Import(vec![log], Box::default()));
    settle(&mut window);
    assert!(window.query_by_label_contains("derived, behind a low-pass").is_none(), "nothing is a position yet");
    choose(&mut window, "quantity of when", "time");
    choose(&mut window, "quantity of a", "position");
    choose(&mut window, "unit of a", "deg");
    choose(&mut window, "quantity of b", "torque");
    assert!(window.query_by_label_contains("Velocity and acceleration are derived, behind a low-pass").is_some());
    assert!(window.query_by_label_contains("0: as suits the motion, 6 Hz").is_some());
    let field = window.get_by_role_and_label(Role::SpinButton, "cut-off of derived channels");
    field.scroll_to_me();
    window.run_steps(4);
    enter(&mut window, "cut-off of derived channels", "2.5");
    settle(&mut window);
    assert!(window.query_by_label_contains("0: as suits the motion").is_none());
    assert!(window.query_by_label("plot of velocity of joint 1, derived [rad/s]").is_some());
    assert!(window.query_by_label("low-pass 2.5 Hz in velocity of joint 1, derived").is_some());
    click(&mut window, "Open it so");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!(recording.provenance.low_pass_hz, Some(2.5));
}

/// Six motors of a TX40 in motion: their angles in one file, their currents in the other, all under the same names.
fn motors(folder: &Path) -> Vec<PathBuf> {
    let names = (1..=6).map(|joint| format!("Joint_{joint}")).collect::<Vec<_>>().join(",");
    let table = |scale: f64, phase: f64| {
        let value = |sample: u32, joint: u32| {
            let t = f64::from(sample) / 5000.0;
            scale * ((5.0 + f64::from(joint)) * t + phase).sin()
        };
        let row = |sample| (1..=6).map(|joint| value(sample, joint).to_string()).collect::<Vec<_>>().join(",") + "\n";
        format!("{names}\n{}", (0..10_000).map(row).collect::<String>())
    };
    [("pos_read_data.csv", table(20.0, 0.0)), ("curr_data.csv", table(1.0, 0.4))]
        .map(|(name, text)| {
            let path = folder.join(name);
            std::fs::write(&path, text).unwrap();
            path
        })
        .into()
}

/// Whoever opens files with channels of the same samples says so, and is offered the mapping of the program that fits them.
#[test]
fn a_mapping_of_the_program_is_offered_for_logs_that_it_fits() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::open(motors(folder.path())));
    settle(&mut window);
    click(&mut window, "Say what their columns are…");
    settle(&mut window);
    assert!(window.query_by_label("Open it as tx40").is_none(), "one file alone has no torques");
    window.get_by_role_and_label(Role::RadioButton, "a part of the channels").click();
    settle(&mut window);
    click(&mut window, "Open it as tx40");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!((recording.joint_count(), recording.trajectories.len()), (6, 1));
    assert!(recording.chain.is_some() && window.query_by_label("What is in this log?").is_none());
}

/// A mapping file is dropped with its log, onto the assistant, or onto the log that is open; alone it says what it is. An effect of
/// one's own is told from it.
#[test]
fn a_mapping_file_is_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let [log, mapping, wrong] = ["swing.csv", "degrees.toml", "wrong.toml"].map(|name| folder.path().join(name));
    std::fs::write(&log, nameless()).unwrap();
    let text = |unit: &str| {
        format!("time = \"when\"\n[q]\ncolumns = \"a\"\nfactor = {unit}\n[tau]\ncolumns = \"b\"\nfactor = -1\n")
    };
    std::fs::write(&mapping, text("0.017453292519943295")).unwrap();
    std::fs::write(&wrong, text("\"deg\"").replace("columns", "colums")).unwrap();
    let largest = |window: &Window| {
        let recording = window.state().session().recording.clone().unwrap();
        recording.trajectories[0].q[0].iter().fold(0.0, |most: f64, q| most.max(q.abs()))
    };
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    let drop = |window: &mut Window, paths: &[&PathBuf]| {
        window.state_mut().order(Order::open(paths.iter().map(|path| (*path).clone()).collect()));
        settle(window);
    };
    drop(&mut window, &[&mapping]);
    assert!(window.query_by_label_contains("says what the columns of a log are, and no log is open").is_some());
    drop(&mut window, &[&log]);
    click(&mut window, "Say what its columns are…");
    settle(&mut window);
    drop(&mut window, &[&mapping]);
    assert!((largest(&window) - 1.0).abs() < 1e-3 && window.query_by_label("What is in this log?").is_none());
    // The log that is open is read anew.
    std::fs::write(&mapping, text("0.0349065850398866")).unwrap();
    drop(&mut window, &[&mapping]);
    assert!((largest(&window) - 2.0).abs() < 1e-3);
    drop(&mut window, &[&wrong]);
    assert!(window.query_by_label_contains("wrong.toml can't be used").is_some());
    std::fs::write(&mapping, text("0.017453292519943295")).unwrap();
    drop(&mut window, &[&mapping, &log]);
    assert!((largest(&window) - 1.0).abs() < 1e-3, "both at once");
    let effect = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_stribeck.toml");
    drop(&mut window, &[&effect]);
    assert_eq!(window.state().session().own_effects.len(), 1);
}

/// A robot of one turning joint, whose hand has two fingers.
pub const WITH_A_HAND: &str = r#"<robot name="r">
  <link name="base"/><link name="arm"><inertial><mass value="1.5"/><origin xyz="0.25 0 0"/><inertia ixx="0" iyy="0.03" izz="0.03"/></inertial></link><link name="left"/><link name="right"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/><limit lower="-2.5" upper="2.5" velocity="12" effort="40"/></joint>
  <joint name="finger_left" type="prismatic"><parent link="arm"/><child link="left"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>
  <joint name="finger_right" type="prismatic"><parent link="arm"/><child link="right"/><origin xyz="0.5 0 0"/><axis xyz="0 -1 0"/></joint>
</robot>"#;

/// The file of a robot that is dropped onto a log shows its arm and asks which of its joints were recorded: the first arm that has as many
/// is chosen.
#[test]
fn the_axes_of_a_robot_file_are_taken() {
    let folder = tempfile::tempdir().unwrap();
    let [log, robot, wrong] = ["swing.csv", "robot.urdf", "wrong.urdf"].map(|name| folder.path().join(name));
    std::fs::write(&log, swing()).unwrap();
    std::fs::write(&robot, WITH_A_HAND).unwrap();
    std::fs::write(&wrong, WITH_A_HAND.replace("<robot", "<arm").replace("</robot", "</arm")).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    let open = |window: &mut Window, paths: &[&PathBuf]| {
        window.state_mut().order(Order::open(paths.iter().map(|path| (*path).clone()).collect()));
        settle(window);
    };
    open(&mut window, &[&robot]);
    assert!(window.query_by_label_contains("Open a log of this arm first").is_some());
    assert!(!is_enabled(&window, "Take these axes"));
    click(&mut window, "Cancel");
    open(&mut window, &[&wrong]);
    assert!(window.query_by_label_contains("It begins with <arm>").is_some());
    click(&mut window, "Cancel");
    open(&mut window, &[&log]);
    assert!(window.state().session().recording.as_ref().unwrap().chain.is_none());
    open(&mut window, &[&robot]);
    assert!(window.query_by_label("the arm of the file at q = 0").is_some());
    choose(&mut window, "From the base to", "finger_left (2 joints)");
    assert!(window.query_by_label_contains("The log has 1 joint, and 2 are ticked").is_some());
    assert!(!is_enabled(&window, "Take these axes"));
    choose(&mut window, "From the base to", "shoulder (1 joint)");
    click(&mut window, "Take these axes");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!(recording.chain.as_ref().map(|chain| chain.axes.len()), Some(1));
    // What its links weigh is stated, so the stated arm is a model of this log.
    let stated = window.state().session().presets_without_model().any(|preset| preset == Preset::StatedArm);
    assert!(recording.states_arm() && stated);
    // Both at once; the fingers stood still.
    open(&mut window, &[&log, &robot]);
    click(&mut window, "Take these axes");
    settle(&mut window);
    assert!(window.query_by_label("Which joints of this robot were recorded?").is_none());
}

/// A servo that reports its angle and what it was told: the law of its drive is stated in the assistant, and what it absorbs is said.
#[test]
fn a_log_without_torque_is_opened_by_the_law_of_its_drive() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("servo.csv");
    let row = |sample: u32| {
        let t = 0.01 * f64::from(sample);
        let (q, qd) = ((2.0 * t).sin(), 2.0 * (2.0 * t).cos());
        format!("{t},{q},{qd},{}\n", (q + 0.1 * (3.0 * t).cos()).to_degrees())
    };
    let rows: String = (0..400).map(row).collect();
    std::fs::write(&log, format!("time,q1,qd1,\"q_cmd1[deg]\"\n{rows}")).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::open(vec![log]));
    settle(&mut window);
    click(&mut window, "Say what its columns are…");
    settle(&mut window);
    choose(&mut window, "how the torque is known", "from a position command");
    assert!(window.query_by_label_contains("command of joint 1").is_some() && !is_enabled(&window, "Open it so"));
    assert!(window.query_by_label_contains("An error of kp").is_none());
    type_into(&mut window, "kp [N m/rad]", "20");
    type_into(&mut window, "kd [N m s/rad]", "0.5");
    window.run_steps(3);
    assert!(window.query_by_label_contains("one of kd is viscous friction (kd is 0.5000").is_some());
    click(&mut window, "Open it so");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    let run = &recording.trajectories[0];
    for (sample, tau) in run.tau[0].iter().enumerate() {
        let (t, qd) = (run.time[sample], run.qd[0][sample]);
        let expected = 20.0 * 0.1 * (3.0 * t).cos() - 0.5 * qd;
        assert!((tau - expected).abs() < 1e-6, "{tau}, not {expected}");
    }
    // Whoever looks again finds the law as it was stated.
    click(&mut window, "Columns…");
    settle(&mut window);
    assert!(window.query_all_by_label_contains("(kd is 0.5000").count() > 1, "on Data and in the dialog");
    assert!(is_enabled(&window, "Open it so"));
}

/// What stands in a log of its messages.
const JOINT_STATE: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
    ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

/// A message of one joint, as ROS 2 writes it; measured at this time [s].
fn joint_state(time: f64, q: f64, tau: f64) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    let align = |bytes: &mut Vec<u8>, to: usize| bytes.resize(4 + (bytes.len() - 4).next_multiple_of(to), 0);
    bytes.extend((time.floor() as i32).to_le_bytes());
    bytes.extend((((time - time.floor()) * 1e9) as u32).to_le_bytes());
    let text = |bytes: &mut Vec<u8>, text: &str| {
        align(bytes, 4);
        bytes.extend((text.len() as u32 + 1).to_le_bytes());
        bytes.extend(text.bytes().chain([0]));
    };
    text(&mut bytes, "");
    align(&mut bytes, 4);
    bytes.extend(1u32.to_le_bytes());
    text(&mut bytes, "elbow");
    for values in [&[q][..], &[], &[tau]] {
        align(&mut bytes, 4);
        bytes.extend((values.len() as u32).to_le_bytes());
        for value in values {
            align(&mut bytes, 8);
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

/// An MCAP log of these topics, each with its amplitude; it received their messages half a second after they were measured.
fn topics(of: &[(&str, f64)]) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().create(&mut file).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.as_bytes()).unwrap();
    let channels: Vec<u16> =
        of.iter().map(|(topic, _)| writer.add_channel(schema, topic, "cdr", &Default::default()).unwrap()).collect();
    for sample in 0..400u32 {
        for (channel_id, (_, amplitude)) in channels.iter().copied().zip(of) {
            let time = 10.0 + 0.01 * f64::from(sample);
            let log_time = ((time + 0.5) * 1e9) as u64;
            let q = amplitude * (2.0 * time).sin();
            let header =
                mcap::records::MessageHeader { channel_id, sequence: sample, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &joint_state(time, q, 3.0 * q)).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

/// Of a log with several topics one is chosen; how far its clock is from that of the log is told, and the template names it.
#[test]
fn the_topic_of_a_log_of_messages_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let [log, template] = ["two.mcap", "two.toml"].map(|name| folder.path().join(name));
    std::fs::write(&log, topics(&[("/left", 1.0), ("/right", 2.0)])).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::Import(vec![log], Box::default()));
    settle(&mut window);
    assert!(window.query_by_label_contains("the clock of the log is 500.000 ms ahead").is_some());
    choose(&mut window, "Topic", "/right (sensor_msgs/msg/JointState, 400 messages)");
    settle(&mut window);
    type_into(&mut window, "Template for logs like this one", template.display());
    click(&mut window, "Save as template");
    let saved = MappingSpec::from_toml(&std::fs::read_to_string(&template).unwrap()).unwrap();
    assert_eq!(saved.topic, Some(vec!["/right".to_owned()]));
    click(&mut window, "Open it so");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    let largest = recording.trajectories[0].q[0].iter().fold(0.0, |most: f64, q| most.max(q.abs()));
    assert!((largest - 2.0).abs() < 1e-2 && recording.joints[0].name == "elbow", "{largest}");
}

/// The cut-off that the noise of a log asks for is told with its reason, and taken by a click.
#[test]
fn the_noise_of_a_log_proposes_a_filter() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("noisy.csv");
    let row = |sample: u32| {
        let t = 0.01 * f64::from(sample);
        // Noise that no seed is needed for.
        let noise = 1e-3 * ((78.233 * f64::from(sample * sample % 9973)).sin() * 43758.5453).fract();
        format!("{t},{},{}\n", (2.0 * t).sin() + noise, -3.0 * (2.0 * t).sin())
    };
    std::fs::write(&log, format!("time,q1,tau1\n{}", (0..4000).map(row).collect::<String>())).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::Import(vec![log], Box::default()));
    settle(&mut window);
    assert!(window.query_by_label_contains("as the noise asks for: motion stands out of the noise up to").is_some());
    let button = window.get_by_label_contains("Take ");
    let hertz: f64 = button.accesskit_node().label().unwrap().split(' ').nth(1).unwrap().parse().unwrap();
    assert!((0.5..4.0).contains(&hertz), "{hertz}");
    button.scroll_to_me();
    window.run_steps(4);
    window.get_by_label_contains("Take ").click();
    window.run_steps(4);
    click(&mut window, "Open it so");
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!(recording.provenance.low_pass_hz, Some(hertz));
}
