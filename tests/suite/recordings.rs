//! Recordings through the front door: real logs, logs that people make, and broken ones.

use std::io::Write as _;
use std::path::PathBuf;

use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;
use torquescope::arm::{Arm, Posture};
use torquescope::progress::Monitor;
use torquescope::recording::encoders::Side;
use torquescope::recording::finding::{Finding, FindingKind, Place};
use torquescope::recording::read::{Import, ReadError, ReadOptions, preview, read};
use torquescope::recording::seal::Seal;
use torquescope::recording::torque::TorqueFacts;
use torquescope::recording::write::{to_csv_bytes, to_npz_bytes};
use torquescope::recording::{Channels, Joint, JointKind, Origin, Provenance, Recording, Trajectory};
use torquescope::signals::Signals;

use crate::outside::real_logs;

/// A folder that holds one file with these bytes.
fn file(name: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn read_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let (_folder, path) = file(name, bytes);
    read(&[path], options, &Monitor::new())
}

fn options(mapping: &str) -> ReadOptions {
    ReadOptions { mapping: Some(mapping.parse().unwrap()), ..ReadOptions::default() }
}

fn problem(name: &str, bytes: &[u8]) -> String {
    read_bytes(name, bytes, &ReadOptions::default()).unwrap_err().to_string()
}

/// An NPY array of f64.
fn npy(shape: &str, values: &[f64]) -> Vec<u8> {
    npy_of("<f8", shape, &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
}

fn npy_of(element: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{element}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(data);
    bytes
}

fn archive(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    use std::io::Write;
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        writer.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// A clean log of one joint as CSV; `row` may change each row.
fn log(samples: usize, row: impl Fn(usize, String) -> String) -> Vec<u8> {
    let mut text = "time,q1,qd1,tau1\n".to_owned();
    for sample in 0..samples {
        let t = sample as f64 * 0.01;
        let values = [t, (2.0 * t).sin(), 2.0 * (2.0 * t).cos(), (2.0 * t).sin() - 0.3];
        text += &row(sample, values.map(|value| value.to_string()).join(","));
        text += "\n";
    }
    text.into_bytes()
}

fn kinds(import: &Import) -> Vec<FindingKind> {
    import.findings.iter().map(|finding| finding.kind).collect()
}

// ── real logs ──

#[test]
fn a_real_double_pendulum_reads_at_once_and_of_one_angle_it_is_told_that_it_came_late() {
    let Some(folder) = real_logs("dfki-double-pendulum") else { return };
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "csv"));
    paths.sort();
    let options = ReadOptions { zero: Some(Posture::DOWN), ..ReadOptions::default() };
    let Import { recording, findings, mapping, .. } = read(&paths, &options, &Monitor::new()).unwrap();
    recording.verify().unwrap();
    assert_eq!(recording.joint_count(), 2);
    assert_eq!(recording.trajectories.len(), paths.len());
    assert_eq!(recording.trajectories[0].name, "a0-00");
    // 4997 rows, less the ends where the filter of q̈ sees one side only: 0.7 periods of 6.19 Hz are 57 samples.
    assert_eq!(recording.trajectories[0].len(), 4997 - 2 * 57);
    assert!((recording.trajectories[0].time_step() - 0.002).abs() < 1e-6);
    assert_eq!(mapping.q, ["pos_meas1", "pos_meas2"]);
    assert_eq!(mapping.tau, ["tau_meas1", "tau_meas2"]);
    assert_eq!(recording.provenance.velocity, Origin::Measured);
    assert!(
        matches!(&recording.provenance.acceleration, Origin::Derived(how) if how.contains("cut-off 6 to 6.185 Hz"))
    );
    assert_eq!(recording.posture, Some(Posture::DOWN));
    for finding in &findings {
        println!("{:?}: {finding}", finding.severity);
    }
    // One angle of joint 2 was read 0.7 ms late: its two slopes are −16.8 and −7.4 rad/s where all around are −12.5.
    let (late, others): (Vec<&Finding>, Vec<&Finding>) =
        findings.iter().partition(|finding| finding.kind == FindingKind::Contradiction);
    assert!(matches!(late[..], [Finding { place: Place { trajectory: Some(4), joint: Some(1), .. }, .. }]), "{late:?}");
    let harmless = [FindingKind::Alternatives, FindingKind::UnevenTime];
    assert!(others.iter().all(|finding| harmless.contains(&finding.kind)), "{others:?}");

    let filtered = options_with_posture("q=pos_filt*,qd=vel_filt*,tau=tau_meas*,time=time");
    assert_eq!(read(&paths[..1], &filtered, &Monitor::new()).unwrap().mapping.q, ["pos_filt1", "pos_filt2"]);
}

#[test]
fn the_characters_of_delan_open_as_they_are() {
    let Some(folder) = real_logs("delan-characters") else { return };
    let path = folder.join("character_data.pickle");
    let Import { recording, mapping, .. } = read(&[path], &ReadOptions::default(), &Monitor::new()).unwrap();
    assert_eq!((recording.joint_count(), recording.trajectories.len(), recording.sample_count()), (2, 20, 2913));
    assert_eq!((mapping.time.as_deref(), &mapping.q[..]), (Some("t"), &["qp[0]".to_owned(), "qp[1]".to_owned()][..]));
    assert_eq!(mapping.tau, ["tau[0]", "tau[1]"]);
    assert!(recording.trajectories.iter().any(|run| run.name == "character_data#e"), "runs have the names of the file");
    assert_eq!(recording.provenance, Provenance::MEASURED);
    assert!(recording.trajectories.iter().all(|run| (run.time_step() - 0.04).abs() < 0.01));
}

#[test]
fn pickles_are_told_from_text_and_their_names() {
    let four = include_bytes!("../data/log4.pickle");
    let import = read_bytes("log.pkl", four, &ReadOptions::default()).unwrap();
    assert_eq!((import.mapping.q.len(), import.recording.sample_count() > 30), (2, true));
    let zero = include_bytes!("../data/log0.pickle");
    assert_eq!(
        read_bytes("log", zero, &ReadOptions::default()).unwrap().recording.trajectories,
        import.recording.trajectories
    );
    assert!(problem("log.csv", four).contains("holds a Python pickle"));
    let other = problem("log.pickle", b"\x80\x03cos\nsystem\nX\x04\0\0\0true\x85R.");
    assert!(other.contains("`os.system`") && other.contains("numpy.savez"), "{other}");
    assert!(problem("log.pickle", b"time,q1\n0,1\n").contains(".pickle, but it holds text"));
}

fn options_with_posture(mapping: &str) -> ReadOptions {
    ReadOptions { zero: Some(Posture::DOWN), ..options(mapping) }
}

#[test]
fn real_files_that_lack_something_say_what_they_have() {
    for (path, words) in [
        ("emps/DATA_EMPS.mat", "may take as factor: `gtau`, `kp`, `kv`"),
        ("ur10-rosbag/validation_trajectory.db3", "trajectory_msgs/msg/JointTrajectory"),
        ("tx40/curr_data.csv", "`Joint_1`"),
        ("tx40/LICENSE", "license"),
    ] {
        let (folder, name) = path.split_once('/').unwrap();
        let Some(folder) = real_logs(folder) else { continue };
        let error = read(&[folder.join(name)], &ReadOptions::default(), &Monitor::new()).unwrap_err().to_string();
        println!("{error}\n");
        assert!(error.to_lowercase().contains(&words.to_lowercase()), "{path}: {error}");
    }
}

// ── logs that people make ──

#[test]
fn a_finger_robot_archive_of_many_runs_reads_by_its_published_layout() {
    let (runs, samples, joints) = (4, 300, 3);
    let value =
        |run: usize, sample: usize, joint: usize| ((run + 1) as f64 * sample as f64 * 0.004 + joint as f64).sin();
    let speed = |run: usize, sample: usize, joint: usize| {
        (run + 1) as f64 * 4.0 * ((run + 1) as f64 * sample as f64 * 0.004 + joint as f64).cos()
    };
    let cube = |f: &dyn Fn(usize, usize, usize) -> f64| {
        let values = (0..runs).flat_map(|r| (0..samples).flat_map(move |s| (0..joints).map(move |j| (r, s, j))));
        let data: Vec<u8> = values.flat_map(|(r, s, j)| (f(r, s, j) as f32).to_le_bytes()).collect();
        npy_of("<f4", &format!("({runs}, {samples}, {joints})"), &data)
    };
    let bytes = archive(&[
        ("measured_angles.npy", cube(&value)),
        ("measured_velocities.npy", cube(&speed)),
        ("measured_torques.npy", cube(&value)),
        ("constrained_torques.npy", cube(&|r, s, j| value(r, s, j) + 100.0)),
        ("desired_torques.npy", cube(&value)),
        ("index.npy", npy("(4,)", &[0.0, 1.0, 2.0, 3.0])),
    ]);
    // Without a clock the rate follows from angles and speeds, and that is said.
    let guessed = read_bytes("Sines_full.npz", &bytes, &ReadOptions::default()).unwrap();
    assert!((guessed.recording.trajectories[0].time_step() - 0.001).abs() < 1e-6);
    assert!(guessed.findings.iter().any(|finding| finding.what.contains("there is no clock; the rate of 1000.0 Hz")));

    let options = ReadOptions { rate_hz: Some(1000.0), ..options("tau=constrained_torques") };
    let import = read_bytes("Sines_full.npz", &bytes, &options).unwrap();
    let recording = &import.recording;
    assert_eq!((recording.joint_count(), recording.trajectories.len()), (3, 4));
    assert_eq!(recording.trajectories[2].name, "Sines_full#3");
    for (run, trajectory) in recording.trajectories.iter().enumerate() {
        // The ends, where the filter of q̈ sees one side only, are left out.
        let start = (trajectory.time[0] / 0.001).round() as usize;
        assert_eq!(trajectory.time[9], (start + 9) as f64 * 0.001);
        assert_eq!(trajectory.q[1][7], f64::from(value(run, start + 7, 1) as f32));
        assert_eq!(trajectory.tau[2][99], f64::from((value(run, start + 99, 2) + 100.0) as f32));
    }
    assert_eq!(kinds(&import), [FindingKind::PassedOver]);

    // The same arrays as files of a folder.
    let folder = tempfile::tempdir().unwrap();
    let arrays = folder.path().join("Sines_full");
    std::fs::create_dir(&arrays).unwrap();
    let mut archived = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    archived.extract(&arrays).unwrap();
    std::fs::write(arrays.join("README.md"), "sines").unwrap();
    let from_folder = read(&[arrays], &options, &Monitor::new()).unwrap();
    assert_eq!(from_folder.recording, import.recording);
    let empty = read(&[folder.path().to_owned()], &options, &Monitor::new()).unwrap_err().to_string();
    assert!(empty.contains("a folder without a log"), "{empty}");
}

#[test]
fn arrays_in_files_of_their_own_stand_side_by_side() {
    let wave = |phase: f64| (0..600).map(|sample| (f64::from(sample) * 0.01 + phase).sin()).collect::<Vec<f64>>();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("q.npy"), npy("(300, 2)", &wave(0.0))).unwrap();
    std::fs::write(path("tau.npy"), npy("(300, 2)", &wave(1.0))).unwrap();
    let both = PathBuf::from(format!("{}+{}", path("q.npy").display(), path("tau.npy").display()));
    let options = ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    let import = read(&[both], &options, &Monitor::new()).unwrap();
    assert_eq!(import.mapping.q, ["q[0]", "q[1]"]);
    assert_eq!(import.mapping.tau, ["tau[0]", "tau[1]"]);
    assert_eq!(import.recording.joint_count(), 2);
    let whole = ReadOptions { rate_hz: Some(50.0), ..self::options("q=log[0],tau=log[1]") };
    assert_eq!(read_bytes("log.npy", &npy("(300, 2)", &wave(0.0)), &whole).unwrap().recording.joint_count(), 1);
    assert!(problem("q.npy", &npy("(300, 2)", &wave(0.0)[..500])).contains("array `q`: the array is damaged"));
    assert!(problem("q.npz", &npy("(2,)", &[0.0; 2])).contains("rename it"));
    let small = ReadOptions { largest: 3000, ..options };
    assert!(read(&[path("q.npy")], &small, &Monitor::new()).unwrap_err().to_string().contains("limit"));
}

#[test]
fn plain_archives_pass_over_what_is_no_sample_and_refuse_objects() {
    let wave: Vec<f64> = (0..600).map(|sample| (f64::from(sample) * 0.01).sin()).collect();
    let time: Vec<f64> = (0..300).map(|sample| f64::from(sample) * 0.02).collect();
    let two = |name| (name, npy("(300, 2)", &wave));
    let objects = || npy_of("|O", "(20,)", b"\x80\x03]q\x00.");
    let bytes = archive(&[
        ("t.npy", npy("(300,)", &time)),
        two("qp.npy"),
        two("tau.npy"),
        ("mass_matrix.npy", npy("(300, 2, 2)", &[wave.clone(), wave.clone()].concat())),
        ("labels.npy", objects()),
        ("notes.txt", b"hello".to_vec()),
    ]);
    let import = read_bytes("plain.npz", &bytes, &ReadOptions::default()).unwrap();
    assert_eq!(import.mapping.q, ["qp[0]", "qp[1]"]);
    let passed_over = import.findings.iter().find(|finding| finding.kind == FindingKind::PassedOver).unwrap();
    for part in ["labels", "Python objects", "mass_matrix", "notes.txt"] {
        assert!(passed_over.what.contains(part), "{}", passed_over.what);
    }

    let bytes = archive(&[("q.npy", objects()), two("tau.npy"), ("t.npy", npy("(300,)", &time))]);
    let error = problem("objects.npz", &bytes);
    assert!(error.contains("no position") && error.contains("Python objects"), "{error}");
    let stepped = archive(&[two("q.npy"), two("tau.npy"), ("dt.npy", npy("()", &[0.02]))]);
    let import = read_bytes("stepped.npz", &stepped, &ReadOptions::default()).unwrap();
    assert!((import.recording.trajectories[0].time_step() - 0.02).abs() < 1e-12);
    let vast: Vec<f64> = (0..300).map(|sample| if sample % 2 == 0 { 1e308 } else { -1e308 }).collect();
    let beyond =
        archive(&[("q.npy", npy("(300,)", &vast)), ("tau.npy", npy("(300,)", &vast)), ("t.npy", npy("(300,)", &time))]);
    assert!(problem("beyond.npz", &beyond).contains("check its units"));
    let excel = archive(&[("xl/workbook.xml", b"<x/>".to_vec())]);
    assert!(problem("book", &excel).contains("no array of samples"));
}

#[test]
fn missing_values_and_gaps_cut_the_trajectory_and_are_told() {
    let bytes = log(400, |sample, row| match sample {
        100..=104 => row.replacen(&row[row.rfind(',').unwrap()..], ",nan", 1),
        200.. => {
            let (time, rest) = row.split_once(',').unwrap();
            format!("{},{rest}", time.parse::<f64>().unwrap() + 3.0)
        }
        _ => row,
    });
    let import = read_bytes("log.csv", &bytes, &ReadOptions::default()).unwrap();
    let lengths: Vec<usize> = import.recording.trajectories.iter().map(Trajectory::len).collect();
    // Each stretch loses 0.7 periods of 6 Hz at both ends, where the filter of q̈ sees one side only.
    assert_eq!(lengths, [100 - 2 * 12, 95 - 2 * 12, 200 - 2 * 12]);
    assert_eq!(import.recording.trajectories[1].name, "log#2");
    assert_eq!(kinds(&import), [FindingKind::NonFinite, FindingKind::TimeGap]);
    assert!(import.findings[0].what.contains("5 of 400") && import.findings[0].what.contains("line 102"));
    assert!(import.findings[1].what.contains("line 202"), "{}", import.findings[1]);
    let sparse =
        log(400, |sample, row| if sample % 4 > 0 { format!("{},", row.rsplit_once(',').unwrap().0) } else { row });
    assert!(problem("log.csv", &sparse).contains("one clock"));
}

#[test]
fn faults_that_can_not_be_read_around_are_errors_with_place_and_remedy() {
    let cases: [(Vec<u8>, &[&str]); 8] = [
        (
            log(50, |s, row| if s == 20 { row.replacen("0.2,", "0.19,", 1) } else { row }),
            &["line 22", "0.19", "delete"],
        ),
        (log(50, |s, row| if s == 20 { row.replacen("0.2,", "0.1,", 1) } else { row }), &["line 22", "0.1 s"]),
        (
            log(50, |s, row| if s == 20 { row.replacen("0.2,", "0.2,oops", 1) } else { row }),
            &["line 22", "`q1`", "`oops"],
        ),
        (log(50, |s, row| if s == 20 { row + ",7" } else { row }), &["line 22", "5 cells"]),
        (log(50, |_, row| format!("{},nan", row.rsplit_once(',').unwrap().0)), &["`tau1`", "no finite number"]),
        (log(2, |_, row| row), &["a run needs 3 samples"]),
        (log(0, |_, row| row), &["no sample"]),
        (Vec::new(), &["empty"]),
    ];
    for (bytes, words) in cases {
        let error = problem("log.csv", &bytes);
        assert!(error.starts_with("log.csv: ") && words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn units_in_names_are_converted_and_told() {
    let bytes = String::from_utf8(log(400, |_, row| row)).unwrap();
    let bytes = bytes.replace("time,q1,qd1,tau1", "time[ms],q1[deg],qd1[deg/s],tau1[mNm]");
    let import = read_bytes("log.csv", bytes.as_bytes(), &ReadOptions::default()).unwrap();
    let trajectory = &import.recording.trajectories[0];
    assert!((trajectory.time[100] - 0.001).abs() < 1e-15);
    assert!((trajectory.q[0][100] - 2.0f64.sin().to_radians()).abs() < 1e-15);
    assert!((trajectory.tau[0][0] - -0.3e-3).abs() < 1e-15);
    assert!(kinds(&import).contains(&FindingKind::Converted));
    let sliding = bytes.replace("time[ms],q1[deg],qd1[deg/s],tau1[mNm]", "time[s],q1[m],qd1[m/s],force1[N]");
    let import = read_bytes("log.csv", sliding.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(import.recording.joints[0].kind, JointKind::Prismatic);
}

#[test]
fn what_is_missing_is_derived_and_its_provenance_says_how() {
    let bytes = log(1000, |_, row| row);
    let import = read_bytes("log.csv", &bytes, &options("qd=-")).unwrap();
    assert!(matches!(&import.recording.provenance.velocity, Origin::Derived(how) if how.contains("difference of q,")));
    let trajectory = &import.recording.trajectories[0];
    for sample in 50..950 {
        let t = trajectory.time[sample];
        assert!((trajectory.qd[0][sample] - 2.0 * (2.0 * t).cos()).abs() < 1e-3);
        assert!((trajectory.qdd[0][sample] + 4.0 * (2.0 * t).sin()).abs() < 5e-3);
    }
    let slow = ReadOptions { low_pass_hz: Some(3.5), ..ReadOptions::default() };
    let import = read_bytes("log.csv", &bytes, &slow).unwrap();
    assert_eq!(import.recording.provenance.velocity, Origin::Measured);
    assert!(
        matches!(&import.recording.provenance.acceleration, Origin::Derived(how) if how.contains("cut-off 3.5 Hz"))
    );
    let by_rate = ReadOptions { rate_hz: Some(50.0), ..options("time=-") };
    let import = read_bytes("log.csv", &bytes, &by_rate).unwrap();
    let time = &import.recording.trajectories[0].time;
    assert!((time[100] - time[0] - 100.0 / 50.0).abs() < 1e-12);
    let unused = ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    assert_eq!(kinds(&read_bytes("log.csv", &bytes, &unused).unwrap()), [FindingKind::PassedOver]);
    let wrong = ReadOptions { low_pass_hz: Some(-1.0), ..ReadOptions::default() };
    assert!(read_bytes("log.csv", &bytes, &wrong).unwrap_err().to_string().contains("-1"));
}

#[test]
fn several_files_become_trajectories_of_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let clean = log(300, |_, row| row);
    let first = write("a.csv", &clean);
    let second = write("b.csv", &clean);
    let same_name = write("other/a.csv", &clean);
    let read_all = |paths: &[PathBuf]| read(paths, &ReadOptions::default(), &Monitor::new());
    let import = read_all(&[first.clone(), second, same_name]).unwrap();
    let names: Vec<&str> = import.recording.trajectories.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "a (2)"]);
    assert_eq!(import.recording.name, "a and 2 more");

    let other = write("other.csv", b"time,pos1,pos2,tau1,tau2\n0,1,2,3,4\n1,2,3,4,5\n2,3,4,5,6\n");
    let error = read_all(&[first.clone(), other]).unwrap_err().to_string();
    assert!(error.contains("other.csv") && error.contains("`q1`"), "{error}");
    let own = write("own.npz", &to_npz_bytes(&import.recording).unwrap());
    assert!(read_all(&[first, own]).unwrap_err().to_string().contains("read it alone"));
    assert!(matches!(read_all(&[]), Err(ReadError::NoFile)));
    let absent = read_all(&[folder.path().join("absent.csv")]).unwrap_err().to_string();
    assert!(absent.contains("absent.csv can't be read"), "{absent}");
}

#[test]
fn columns_are_told_for_a_mapping_by_hand_and_limits_hold() {
    let bytes = log(300, |_, row| row);
    let (_folder, path) = file("log.csv", &bytes);
    let names = preview(&path, &ReadOptions::default(), &Monitor::new()).unwrap().names();
    assert_eq!(names, ["time", "q1", "qd1", "tau1"]);
    let small = ReadOptions { largest: 1000, ..ReadOptions::default() };
    assert!(read_bytes("log.csv", &bytes, &small).unwrap_err().to_string().contains("limit"));
    let zeros = archive(&[("q.npy", npy("(100000,)", &[0.0; 100_000]))]);
    assert!(zeros.len() < 10_000, "a small file that unpacks to much");
    let limit = ReadOptions { largest: 100_000, ..ReadOptions::default() };
    assert!(read_bytes("log.npz", &zeros, &limit).unwrap_err().to_string().contains("unpacked"));
}

#[test]
fn a_stop_ends_the_reading() {
    let (_folder, path) = file("log.csv", &log(300, |_, row| row));
    let monitor = Monitor::new();
    monitor.stop("enough");
    assert!(matches!(read(&[path], &ReadOptions::default(), &monitor), Err(ReadError::Stopped(_))));
}

// ── our own files ──

fn sample_recording() -> Recording {
    let run = |name: &str, samples: usize| {
        let time: Vec<f64> = (0..samples).map(|sample| sample as f64 * 0.01 + 1e-9).collect();
        let wave =
            |speed: f64| Signals::from_fn(2, samples, |joint, sample| (speed * time[sample] + joint as f64).sin());
        let (q, qd, qdd, tau) = (wave(1.0), wave(2.0), wave(3.0), wave(4.0));
        Trajectory::new(name, Channels { time, q, qd, qdd, tau }).unwrap()
    };
    Recording {
        name: "Übung 1".into(),
        joints: vec![Joint::numbered(1), Joint { name: "slide".into(), kind: JointKind::Prismatic }],
        trajectories: vec![run("first", 40), run("second", 1), run("third", 25)],
        provenance: Provenance { acceleration: Origin::Derived("somehow".into()), ..Provenance::MEASURED },
        posture: Some(Posture::DOWN),
        stated_arm: Some(Arm::uniform(2)),
        chain: None,
        torque: TorqueFacts::default(),
        encoders: None,
        seal: Some(Seal::from_bytes(vec![1, 2, 3])),
    }
}

#[test]
fn a_newer_layout_and_a_wrong_one_are_told() {
    let bytes = to_npz_bytes(&sample_recording()).unwrap();
    let with_manifest = |change: &dyn Fn(String) -> String| {
        use std::io::Read;
        let mut old = zip::ZipArchive::new(std::io::Cursor::new(bytes.clone())).unwrap();
        let mut entries = Vec::new();
        for index in 0..old.len() {
            let mut entry = old.by_index(index).unwrap();
            let mut content = Vec::new();
            entry.read_to_end(&mut content).unwrap();
            let name = entry.name().unwrap().into_owned();
            if name == "torquescope.json" {
                content = change(String::from_utf8(content).unwrap()).into_bytes();
            }
            entries.push((name, content));
        }
        let entries: Vec<(&str, Vec<u8>)> = entries.iter().map(|(n, c)| (n.as_str(), c.clone())).collect();
        problem("own.npz", &archive(&entries))
    };
    let error = with_manifest(&|text| text.replace("\"format\": 1", "\"format\": 7, \"new\": true"));
    assert!(error.contains("version 7") && error.contains("newer program"), "{error}");
    assert!(with_manifest(&|_| "{".into()).contains("damaged"));
    assert!(with_manifest(&|text| text.replacen("\"name\"", "\"x\": 1, \"name\"", 1)).contains("unknown field"));
    let error = with_manifest(&|text| text.replace("\"second\",", ""));
    assert!(error.contains("`trajectory`"), "{error}");
}

#[test]
fn broken_promises_are_not_written() {
    let mut recording = sample_recording();
    recording.joints.pop();
    let error = to_npz_bytes(&recording).unwrap_err().to_string();
    assert!(error.contains("`first`: q has 2 joints, but 1 are needed"), "{error}");
    let mut recording = sample_recording();
    recording.trajectories[0].channels_mut().time[5] = 0.0;
    assert!(to_npz_bytes(&recording).unwrap_err().to_string().contains("sample 5"));
    let mut recording = sample_recording();
    recording.trajectories[2].channels_mut().qdd[1][3] = f64::NAN;
    assert!(to_npz_bytes(&recording).unwrap_err().to_string().contains("qdd of joint 2 is NaN at sample 3"));
}

#[test]
fn a_trajectory_reads_back_from_csv() {
    let original = sample_recording();
    let import = read_bytes("first.csv", &to_csv_bytes(&original.trajectories[0]), &ReadOptions::default()).unwrap();
    assert_eq!(import.recording.trajectories, [original.trajectories[0].clone()]);
}

fn any_recording() -> impl Strategy<Value = Recording> {
    let value = prop_oneof![
        any::<f64>().prop_filter("finite", |value| value.is_finite()),
        Just(-0.0),
        Just(f64::MIN_POSITIVE / 3.0),
        -10.0..10.0,
    ];
    let shape = (1usize..8, prop::collection::vec(1usize..20, 1..5));
    shape.prop_flat_map(move |(joints, lengths)| {
        let count: usize = lengths.iter().sum();
        let values = prop::collection::vec(value.clone(), count * joints * 4);
        let steps = prop::collection::vec(1e-6..10.0f64, count);
        let names = prop::collection::vec(".{0,12}", lengths.len() + joints);
        (
            Just(joints),
            Just(lengths),
            values,
            steps,
            names,
            any::<[bool; 4]>(),
            prop::collection::vec(any::<u8>(), 0..99),
        )
            .prop_map(|(joints, lengths, values, steps, names, flags, sealed)| {
                let mut values = values.into_iter();
                let mut steps = steps.into_iter();
                let mut names = names.into_iter();
                let mut channel = |length: usize| Signals::from_fn(joints, length, |_, _| values.next().unwrap());
                let trajectories = lengths.iter().map(|&length| {
                    let time = steps
                        .by_ref()
                        .take(length)
                        .scan(0.0, |t, step| {
                            *t += step;
                            Some(*t)
                        })
                        .collect();
                    let (q, qd, qdd, tau) = (channel(length), channel(length), channel(length), channel(length));
                    Trajectory::new(names.next().unwrap(), Channels { time, q, qd, qdd, tau }).unwrap()
                });
                let trajectories = trajectories.collect();
                let kind = |flag| if flag { JointKind::Prismatic } else { JointKind::Revolute };
                let joints = names.enumerate().map(|(i, name)| Joint { name, kind: kind(flags[i % 4]) }).collect();
                let origin = |flag| if flag { Origin::Measured } else { Origin::Derived("dérivé, \"10 Hz\"".into()) };
                Recording {
                    name: "proptest".into(),
                    joints,
                    trajectories,
                    provenance: Provenance {
                        velocity: origin(flags[0]),
                        acceleration: origin(flags[1]),
                        low_pass_hz: flags[0].then_some(6.5),
                    },
                    posture: flags[2].then_some(Posture { zero_angle: 0.1 + 0.2, ..Posture::UP }),
                    stated_arm: flags[3].then(|| Arm::uniform(3)),
                    chain: None,
                    torque: TorqueFacts::default(),
                    encoders: flags[1].then_some(Side::Motor),
                    seal: flags[0].then_some(Seal::from_bytes(sealed)),
                }
            })
    })
}

fn bits(recording: &Recording) -> Vec<u64> {
    let all = recording.trajectories.iter().flat_map(|t| {
        let channels = [&t.q, &t.qd, &t.qdd, &t.tau].into_iter().flatten().flatten();
        channels.chain(&t.time).map(|value| value.to_bits())
    });
    all.collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn what_is_written_reads_back_bit_by_bit(recording in any_recording()) {
        let bytes = to_npz_bytes(&recording).unwrap();
        prop_assert_eq!(&bytes, &to_npz_bytes(&recording).unwrap());
        let import = read_bytes("own.npz", &bytes, &ReadOptions::default()).unwrap();
        prop_assert_eq!(bits(&import.recording), bits(&recording));
        prop_assert_eq!(import.recording, recording);
    }
}

// ── broken files ──

/// Reads bytes that may be anything: it must return, and an error must say something.
fn survive(name: &str, bytes: &[u8]) -> bool {
    match read_bytes(name, bytes, &ReadOptions::default()) {
        Ok(import) => {
            import.recording.verify().unwrap();
            true
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with(name) && message.len() > name.len() + 20, "{message}");
            false
        }
    }
}

fn plain_archive() -> Vec<u8> {
    let time: Vec<f64> = (0..300).map(|sample| f64::from(sample) * 0.02).collect();
    let wave: Vec<f64> = (0..600).map(|sample| (f64::from(sample) * 0.01).sin()).collect();
    archive(&[("t.npy", npy("(300,)", &time)), ("q.npy", npy("(300, 2)", &wave)), ("tau.npy", npy("(300, 2)", &wave))])
}

#[test]
fn truncated_archives_are_errors() {
    for bytes in [to_npz_bytes(&sample_recording()).unwrap(), plain_archive()] {
        assert!(survive("log.npz", &bytes));
        for end in (0..bytes.len()).step_by(23).chain(bytes.len() - 60..bytes.len()) {
            assert!(!survive("log.npz", &bytes[..end]), "cut at {end}");
        }
    }
}

#[test]
fn flipped_bits_never_pass_unseen_into_the_samples() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let original = sample_recording();
    for (bytes, own) in [(to_npz_bytes(&original).unwrap(), true), (plain_archive(), false)] {
        let mut still_read = 0;
        for _ in 0..300 {
            let mut damaged = bytes.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..damaged.len());
                damaged[at] ^= 1 << random.random_range(0..8);
            }
            if !survive("log.npz", &damaged) {
                continue;
            }
            still_read += 1;
            if own {
                // Bits that nobody looks at (dates, permissions) may flip; the checksums guard all others.
                let import = read_bytes("log.npz", &damaged, &ReadOptions::default()).unwrap();
                assert_eq!(bits(&import.recording), bits(&original));
            }
        }
        println!("{still_read} of 300 archives with flipped bits were read all the same");
    }
}

#[test]
fn damaged_text_is_an_error_or_a_whole_recording() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let bytes = log(60, |_, row| row);
    for end in 0..bytes.len() {
        survive("log.csv", &bytes[..end]);
    }
    for _ in 0..300 {
        let mut damaged = bytes.clone();
        let at = random.random_range(0..damaged.len());
        damaged[at] = random.random();
        survive("log.csv", &damaged);
    }
    for length in [1, 10, 1000, 20_000] {
        let mut noise = vec![0; length];
        random.fill_bytes(&mut noise);
        survive("log", &noise);
        survive("log.npz", &[b"PK\x03\x04".to_vec(), noise].concat());
    }
}

#[test]
fn archives_with_sound_checksums_and_lying_arrays_are_errors() {
    let samples: Vec<f64> = (0..300).map(f64::from).collect();
    for shape in ["(1000000000000, 2)", "(18446744073709551615, 18446744073709551615)", "(299,)", "(-300,)", "(", ""] {
        let bytes = archive(&[("q.npy", npy(shape, &samples)), ("tau.npy", npy("(300,)", &samples))]);
        let error = problem("lying.npz", &bytes);
        assert!(error.contains("`q`") && error.contains("damaged"), "{shape}: {error}");
    }
    let uneven = archive(&[("q.npy", npy("(300,)", &samples)), ("tau.npy", npy("(299,)", &samples[..299]))]);
    let error = problem("uneven.npz", &uneven);
    assert!(error.contains("no torque") && error.contains("(its shape is [299])"), "{error}");
    let huge = || npy("(1099511627776, 1048576, 0)", &[]);
    assert!(problem("huge.npz", &archive(&[("q.npy", huge()), ("tau.npy", huge())])).contains("no array of samples"));
    let none = archive(&[("q.npy", npy("(0, 2)", &[])), ("tau.npy", npy("(0, 2)", &[]))]);
    assert!(problem("none.npz", &none).contains("no array of samples"));
}

// ── Parquet ──

#[test]
fn a_log_of_lerobot_opens_without_a_mapping() {
    for bytes in [&include_bytes!("../data/log.parquet")[..], include_bytes!("../data/log2.parquet")] {
        let import = read_bytes("log.parquet", bytes, &ReadOptions::default()).unwrap();
        assert_eq!(import.mapping.q, ["observation.state[0]", "observation.state[1]"]);
        assert_eq!(import.mapping.tau, ["observation.effort[0]", "observation.effort[1]"]);
        assert_eq!((import.mapping.time.as_deref(), import.recording.joint_count()), (Some("timestamp"), 2));
        assert!(kinds(&import).contains(&FindingKind::NonFinite), "a list is missing in the second episode");
        assert!(import.recording.trajectories.iter().all(|run| run.len() <= 30), "episodes are runs");
        assert!(problem("log.csv", bytes).contains("holds a Parquet file"));
        for end in (0..bytes.len()).step_by(97) {
            assert!(!survive("log.parquet", &bytes[..end]), "cut at {end}");
        }
    }
    assert!(problem("log.parquet", b"time,q1\n0,1\n").contains(".parquet, but it holds text"));
}

// ── JSON and gzip ──

/// [`log`] as one object a sample.
fn json_lines(samples: usize) -> String {
    let csv = String::from_utf8(log(samples, |_, row| row)).unwrap();
    let line = |row: &str| {
        let cells: Vec<&str> = row.split(',').collect();
        format!(
            "{{\"time\":{},\"q\":[{}],\"state\":{{\"qd\":[{}]}},\"tau\":[{}]}}\n",
            cells[0], cells[1], cells[2], cells[3]
        )
    };
    csv.lines().skip(1).map(line).collect()
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn json_lines_and_packed_files_are_the_same_recording() {
    let plain = read_bytes("log.csv", &log(300, |_, row| row), &ReadOptions::default()).unwrap();
    let csv = log(300, |_, row| row);
    for (name, bytes) in [
        ("log.jsonl", json_lines(300).into_bytes()),
        ("log.csv.gz", packed(&csv)),
        ("log.gz", packed(json_lines(300).as_bytes())),
    ] {
        let import = read_bytes(name, &bytes, &ReadOptions::default()).unwrap();
        assert_eq!(import.recording.trajectories[0].tau, plain.recording.trajectories[0].tau, "{name}");
        assert_eq!(import.recording.trajectories[0].qd, plain.recording.trajectories[0].qd, "{name}");
    }
    assert!(problem("log.npz.gz", &packed(&csv)).contains(".npz, but it holds text"));
}

#[test]
fn damaged_json_and_packed_files_are_errors() {
    let whole = json_lines(60);
    for end in (1..whole.len() - 1).step_by(11) {
        // A text may end between two lines.
        if !whole[..end].ends_with('\n') && !whole[..end].ends_with('}') {
            assert!(!survive("log.jsonl", &whole.as_bytes()[..end]), "cut at {end}");
        }
    }
    let whole = packed(&log(300, |_, row| row));
    for end in (2..whole.len()).step_by(17) {
        assert!(!survive("log.csv.gz", &whole[..end]), "cut at {end}");
    }
    assert!(problem("log.csv.gz", &whole[..whole.len() / 2]).contains("damaged after"));
    assert!(problem("log.csv.gz", &packed(&whole)).contains("packed with gzip twice"));
    let bomb = packed(&vec![b'1'; 200 << 20]);
    assert!(problem("log.csv.gz", &bomb).contains("unpacked it takes more than"));
}

// ── names ──

#[test]
fn names_of_loggers_are_understood_and_currents_are_no_torque() {
    let renamed = |names: &str| {
        let text = String::from_utf8(log(300, |_, row| row)).unwrap();
        text.replacen("time,q1,qd1,tau1", names, 1).into_bytes()
    };
    let rtde =
        read_bytes("ur.csv", &renamed("timestamp,actual_q_0,actual_qd_0,target_moment_0"), &ReadOptions::default())
            .unwrap();
    assert_eq!((rtde.mapping.q, rtde.mapping.tau), (vec!["actual_q_0".to_owned()], vec!["target_moment_0".to_owned()]));
    let franka = read_bytes("fr3.csv", &renamed("time,q[0],dq[0],tau_J[0]"), &ReadOptions::default()).unwrap();
    assert_eq!((franka.mapping.qd, franka.mapping.tau), (Some(vec!["dq[0]".to_owned()]), vec!["tau_J[0]".to_owned()]));
    let names = "time,$AXIS_ACT[1],$VEL_AXIS_ACT[1],$TORQUE_AXIS_ACT[1]";
    let kuka = read_bytes("kr.csv", &renamed(names), &ReadOptions::default()).unwrap().mapping;
    assert_eq!((kuka.q, kuka.tau), (vec!["$AXIS_ACT[1]".to_owned()], vec!["$TORQUE_AXIS_ACT[1]".to_owned()]));
    assert_eq!(kuka.qd, Some(vec!["$VEL_AXIS_ACT[1]".to_owned()]));
    let names = "time,AIPos.A1,vel.A1,torque.A1";
    let sensor = read_bytes("rsi.csv", &renamed(names), &ReadOptions::default()).unwrap().mapping;
    assert_eq!(sensor.q, ["AIPos.A1"]);
    let amperes = renamed("timestamp,actual_q_0,actual_qd_0,actual_current_0");
    let message = problem("ur.csv", &amperes);
    assert!(message.contains("`actual_current_0` is a current") && message.contains("factor"), "{message}");
    let import = read_bytes("ur.csv", &amperes, &options("tau=actual_current_*")).unwrap();
    assert!(kinds(&import).contains(&FindingKind::Amperes));
}

/// What fuzzing found (`tests/fuzz`) is read, or refused with what is wrong; in a build for tests, where numbers that overflow panic.
#[test]
fn what_fuzzing_found_stays_mended() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/found");
    let files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(!files.is_empty());
    for path in files {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let Err(refusal) = read(&[path], &ReadOptions::default(), &Monitor::new()) else { continue };
        assert!(refusal.to_string().contains(&name), "{refusal}");
    }
}
