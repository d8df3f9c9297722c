//! Is the log set up right? As a user asks it, and on logs that others made.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use torquescope::arm::Posture;
use torquescope::diagnosis::setup;
use torquescope::progress::Monitor;
use torquescope::recording::catalogue;
use torquescope::recording::check::check;
use torquescope::recording::correction::Correction;
use torquescope::recording::finding::{Finding, FindingKind};
use torquescope::recording::read::{ReadOptions, read};
use torquescope::recording::{Origin, Recording};

use crate::outside::real_logs;

fn succeeds(arguments: &[&str], folder: &Path) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_torquescope")).args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(arguments: &[&str], folder: &Path) -> Value {
    serde_json::from_str(&succeeds(arguments, folder)).unwrap()
}

/// What the findings propose to set right.
fn proposed(answer: &Value) -> Vec<&str> {
    let findings = answer["findings"].as_array().unwrap().iter();
    findings
        .filter_map(|finding| finding["set_right"].as_array())
        .flatten()
        .map(|text| text.as_str().unwrap())
        .collect()
}

/// A log whose torques of joints 2 and 3 stand in each other's column: told before everything else, set right by the option that
/// was proposed, and diagnosed as if nothing had been.
#[test]
fn a_wrong_set_up_is_told_by_inspect_and_diagnose_and_set_right_by_an_option() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let effects = ["--effect", "coulomb-friction@1=2.0"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &effects].concat(), folder);
    let wrong = ["x.npz", "--set-right", "order-torque=1,3,2"];
    let right = [wrong.as_slice(), &["--set-right", "order-torque=1,3,2"]].concat();

    let inspect = |reading: &[&str]| json(&[["inspect", "--json"].as_slice(), reading].concat(), folder);
    assert_eq!(proposed(&inspect(&["x.npz"])), Vec::<&str>::new());
    assert_eq!(proposed(&inspect(&wrong)), ["order-torque=1,3,2"]);
    assert_eq!(proposed(&inspect(&right)), Vec::<&str>::new());

    let text = succeeds(&[["diagnose"].as_slice(), &wrong].concat(), folder);
    let first = text.lines().next().unwrap();
    assert!(first.starts_with("error: as the log is set up, a rigid body leaves"), "{first}");
    assert!(first.contains("Set it right with `--set-right order-torque=1,3,2`"), "{first}");
    let answer = json(&[["diagnose", "--json"].as_slice(), &wrong].concat(), folder);
    assert_eq!(proposed(&answer), ["order-torque=1,3,2"]);
    let answer = json(&[["diagnose", "--json"].as_slice(), &right].concat(), folder);
    assert_eq!(answer["effects"][0]["effect"], "coulomb-friction");
    assert_eq!(proposed(&answer), Vec::<&str>::new());
}

/// A log without a clock: its rate is what makes q̇ the slope of q, and where it is not one the rate is asked for.
#[test]
fn the_rate_of_a_log_without_a_clock_follows_from_its_velocity() {
    let folder = tempfile::tempdir().unwrap();
    let log = |velocity: fn(f64) -> f64| {
        let row = |sample: u32| {
            let t = 0.004 * f64::from(sample);
            format!("{},{},{}\n", (2.0 * t).sin(), velocity(t), (3.0 * t).cos())
        };
        let path = folder.path().join("log.csv");
        std::fs::write(&path, format!("q1,qd1,tau1\n{}", (0..800).map(row).collect::<String>())).unwrap();
        read(&[path], &ReadOptions::default(), &Monitor::new())
    };
    let import = log(|t| 2.0 * (2.0 * t).cos()).unwrap();
    assert!((import.recording.trajectories[0].time_step() / 0.004 - 1.0).abs() < 1e-3);
    assert!(import.findings.iter().any(|finding| finding.what.contains("the rate of 250.0 Hz follows from q and q̇")));
    let message = log(|t| (17.0 * t).cos()).unwrap_err().to_string();
    assert!(message.contains("state the sampling rate"), "{message}");
}

/// A logger that counts milliseconds without saying so, as libfranka's does: the motion says it. What is named in seconds stays so.
#[test]
fn a_clock_in_other_units_is_known_by_the_motion() {
    let folder = tempfile::tempdir().unwrap();
    let log = |name: &str, in_a_second: f64| {
        let row = |sample: u32| {
            let t = 0.001 * f64::from(sample);
            format!("{},{},{},{}\n", in_a_second * t, (2.0 * t).sin(), 2.0 * (2.0 * t).cos(), (3.0 * t).cos())
        };
        let path = folder.path().join("log.csv");
        let rows: String = (0..3000).map(row).collect();
        std::fs::write(&path, format!("{name},q[0],dq[0],tau_J[0]\n{rows}")).unwrap();
        read(&[path], &ReadOptions::default(), &Monitor::new()).unwrap()
    };
    let says = |findings: &[Finding], unit: &str| {
        findings.iter().any(|finding| finding.what.contains(&format!("is in {unit}, by how q and q̇ change")))
    };
    for (in_a_second, unit) in [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")] {
        let import = log("time", in_a_second);
        assert!((import.recording.trajectories[0].time_step() / 0.001 - 1.0).abs() < 1e-6, "{unit}");
        assert!(says(&import.findings, unit), "{:#?}", import.findings);
        assert!(!import.findings.iter().any(|finding| finding.kind == FindingKind::VelocityMismatch));
    }
    assert!(log("time", 1.0).findings.iter().all(|finding| finding.kind != FindingKind::TimeUnit));
    let named = log("time[s]", 1e3);
    assert!(named.recording.trajectories[0].time_step() > 0.9 && !says(&named.findings, "milliseconds"));
}

fn told(recording: &Recording) -> Vec<String> {
    let found = setup::check(recording, &check(recording).findings, &Monitor::new()).unwrap();
    found.iter().flat_map(|finding| &finding.set_right).map(Correction::to_string).collect()
}

fn log(paths: &[PathBuf], mapping: Option<&str>, zero: Option<Posture>) -> Recording {
    let mapping = mapping.map(|name| catalogue::mapping(name).unwrap());
    read(paths, &ReadOptions { mapping, zero, ..ReadOptions::default() }, &Monitor::new()).unwrap().recording
}

fn with_mistake(recording: &Recording, mistake: &str) -> Recording {
    let mut wrong = recording.clone();
    mistake.parse::<Correction>().unwrap().apply(&mut wrong).unwrap();
    wrong
}

#[test]
fn the_double_pendulum_hangs_although_nothing_says_so() {
    let Some(folder) = real_logs("dfki-double-pendulum") else { return };
    let paths = ["a0-00", "a0-01", "a0-02", "a0-03"].map(|name| folder.join(format!("{name}.csv")));
    assert_eq!(told(&log(&paths, None, None)), ["zero=down"]);
    let hanging = log(&paths, None, Some(Posture::DOWN));
    // The gear of its first joint has play; without it nothing is wrong.
    let found = told(&hanging);
    let [Correction::Play { joint: 0, play }] = found.iter().map(|text| text.parse().unwrap()).collect::<Vec<_>>()[..]
    else {
        panic!("{found:?}");
    };
    assert!((0.15..0.3).contains(&play.gap.to_degrees()) && (0.1..0.2).contains(&play.friction), "{found:?}");
    assert_eq!(told(&with_mistake(&hanging, &found[0])), Vec::<String>::new());
    assert_eq!(told(&with_mistake(&hanging, "sign-motion@2")), ["sign-motion@2"]);
    assert_eq!(told(&with_mistake(&hanging, "order-torque=2,1")), ["order-torque=2,1"]);
}

/// Six axes whose places are not stated are no planar arm, and no mistake of that arm is looked for.
#[test]
fn six_axes_that_are_not_stated_are_told() {
    let Some(folder) = real_logs("ur10-rosbag") else { return };
    let path = [folder.join("ur10_exciting_trajectory.db3")];
    let unstated = log(&path, None, None);
    let findings = check(&unstated).findings;
    assert!(findings.iter().any(|finding| finding.what.starts_with("6 axes are taken for those of a planar arm")));
    assert_eq!(told(&unstated), Vec::<String>::new());
    let stated = check(&log(&path, Some("ur10"), None)).findings;
    assert!(!stated.iter().any(|finding| finding.what.contains("planar arm")), "{stated:?}");
}

/// Mistakes in a log in space, and what sets them right.
const IN_SPACE: [(&str, &str); 12] = [
    ("zero@2=-90", "zero@2=90"),
    ("sign-motion@2", "sign-motion@2"),
    ("sign@3", "sign@3"),
    ("sign-torque@2", "sign-torque@2"),
    ("sign-torque@1,2,3,4,5,6", "sign-torque@1,2,3,4,5,6"),
    ("order-torque=1,3,2,4,5,6", "order-torque=1,3,2,4,5,6"),
    ("order-motion=2,1,3,4,5,6", "order-motion=2,1,3,4,5,6"),
    ("order=1,3,2,4,5,6", "order=1,3,2,4,5,6"),
    ("factor-motion@3=100", "factor-motion@3=0.01"),
    ("delay-torque=-0.2", "delay-torque=0.2"),
    ("factor-velocity@1,2,3,4,5,6=57.295779513", "factor-velocity@1,2,3,4,5,6=0.017453293"),
    ("factor-velocity@1,2,3,4,5,6=0.1", "factor-velocity@1,2,3,4,5,6=10"),
];

/// Whether it is that correction; a factor is searched for, and comes out within two per cent.
fn is_nearly(found: &str, right: &str) -> bool {
    let parts = |text: &str| text.split_once('=').map(|(what, value)| (what.to_owned(), value.parse::<f64>().ok()));
    match (parts(found), parts(right)) {
        (Some((what, Some(found))), Some((expected, Some(right)))) if what.starts_with("factor") => {
            what == expected && (found / right - 1.0).abs() < 0.02
        }
        _ => found == right,
    }
}

#[test]
#[ignore = "measures: clean logs of real arms and of another engine, and mistakes in logs in space"]
fn rates_on_logs_of_others() {
    let real = |folder: &str, files: &[&str]| -> Option<Vec<PathBuf>> {
        let folder = real_logs(folder)?;
        Some(files.iter().map(|file| folder.join(file)).collect())
    };
    let tx40 =
        real_logs("tx40").map(|f| vec![PathBuf::from(format!("{0}/pos_read_data.csv+{0}/curr_data.csv", f.display()))]);
    let logs = [
        ("emps", real("emps", &["DATA_EMPS.mat"]), Some("emps"), None),
        ("dfki 00", real("dfki-double-pendulum", &["a0-00.csv"]), None, Some(Posture::DOWN)),
        ("dfki 01", real("dfki-double-pendulum", &["a0-01.csv"]), None, Some(Posture::DOWN)),
        ("dfki 02", real("dfki-double-pendulum", &["a0-02.csv"]), None, Some(Posture::DOWN)),
        ("dfki 03", real("dfki-double-pendulum", &["a0-03.csv"]), None, Some(Posture::DOWN)),
        ("dfki 04", real("dfki-double-pendulum", &["a0-04.csv"]), None, Some(Posture::DOWN)),
        ("dfki 11", real("dfki-double-pendulum", &["a0-11.csv"]), None, Some(Posture::DOWN)),
        ("kr300 a", real("kuka-kr300", &["run-a.mat"]), Some("kuka-kr300"), None),
        ("kr300 b", real("kuka-kr300", &["run-b.mat"]), Some("kuka-kr300"), None),
        ("characters", real("delan-characters", &["character_data.pickle"]), None, None),
        ("ur10", real("ur10-rosbag", &["ur10_exciting_trajectory.db3"]), Some("ur10"), None),
        ("ur10 v", real("ur10-rosbag", &["validation_trajectory.db3"]), Some("ur10"), None),
        ("tx40", tx40, Some("tx40"), None),
    ];
    for (name, paths, mapping, zero) in logs {
        let Some(paths) = paths else { continue };
        let mapping = mapping.map(|name| catalogue::mapping(name).unwrap());
        let options = ReadOptions { mapping, zero, ..ReadOptions::default() };
        let Ok(import) = read(&paths, &options, &Monitor::new()) else {
            println!("{name}: not read");
            continue;
        };
        let begin = std::time::Instant::now();
        println!("clean {name}: {:?}, {:.2} s", told(&import.recording), begin.elapsed().as_secs_f64());
        if import.recording.chain.is_some() && import.recording.joint_count() == 6 {
            let provenance = &import.recording.provenance;
            for (mistake, right) in IN_SPACE {
                // What is derived is wrong with that from which it is derived.
                let derives = |origin: &Origin| mistake.starts_with("factor-velocity") && *origin != Origin::Measured;
                if derives(&provenance.velocity) {
                    continue;
                }
                let of_rates = |text: &str| text.replace("velocity", "rates");
                let [mistake, right] = if derives(&provenance.acceleration) {
                    [mistake, right].map(of_rates)
                } else {
                    [mistake, right].map(str::to_owned)
                };
                let begin = std::time::Instant::now();
                let found = told(&with_mistake(&import.recording, &mistake)).join(" ");
                let verdict = if is_nearly(&found, &right) { "ok" } else { "--" };
                println!("{name} {verdict} {mistake}: {found}, {:.2} s", begin.elapsed().as_secs_f64());
            }
        }
    }
    let Some(world) = real_logs("../world") else { return };
    for number in 0..40 {
        let truth = std::fs::read_to_string(world.join(format!("{number:03}.json"))).unwrap();
        let truth: Value = serde_json::from_str(&truth).unwrap();
        let zero = match truth["zero"].as_str().unwrap() {
            "down" => Posture::DOWN,
            "up" => Posture::UP,
            _ => Posture::RIGHT,
        };
        let recording = log(&[world.join(format!("{number:03}.npz"))], None, Some(zero));
        let begin = std::time::Instant::now();
        println!("world {number}: {:?}, {:.2} s", told(&recording), begin.elapsed().as_secs_f64());
        if number % 20 < 3 {
            let joints: Vec<String> = (1..=recording.joint_count()).map(|joint| joint.to_string()).collect();
            let mistakes =
                ["zero=left".to_owned(), "zero=37".to_owned(), "sign-motion@2".to_owned(), "sign-torque@1".to_owned()];
            let others = [format!("sign-torque@{}", joints.join(",")), "angles=relative".to_owned()];
            for mistake in mistakes.iter().chain(&others) {
                println!("    {mistake}: {:?}", told(&with_mistake(&recording, mistake)));
            }
        }
    }
}
