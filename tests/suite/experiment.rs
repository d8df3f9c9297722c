//! Experiments as a user, or a cluster, runs them: processes on one folder, some of which die.

use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::runner;

/// Six cells of a pendulum; the networks take about a second each.
const TINY: &str = r#"
title = "tiny"
description = "a pendulum"
seeds = 3

[data.simulation]
arm = { links = [{ mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 }] }
motion = { kind = "paper-point-to-point", trajectories = 10, duration = 4.0, samples = 100, range = 3.0 }

[[model]]
name = "rigid-body"
preset = "rigid-body"

[[model]]
name = "network"
preset = "ff-nn"
training = { epochs = 60, batch = 100, hidden = [16] }

[[test]]
name = "iid"

[[curve]]
name = "speed"
key = "speed_scale"
axis = "times as fast"
values = [1.0, 2.0]

[quick]
seeds = 1
epochs = 2
"#;

fn of_experiment<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    [&["experiment"], arguments].concat()
}

fn torquescope(arguments: &[&str], folder: &Path) -> Command {
    runner::torquescope(&of_experiment(arguments), folder)
}

fn succeeds(arguments: &[&str], folder: &Path) -> String {
    runner::succeeds(&of_experiment(arguments), folder)
}

fn json(arguments: &[&str], folder: &Path) -> Value {
    runner::json(&of_experiment(arguments), folder)
}

fn states(folder: &Path, out: &str) -> Vec<Value> {
    let status = json(&["status", "tiny.toml", "--out", out, "--json"], folder);
    status["cells"].as_array().unwrap().iter().map(|cell| cell["state"].clone()).collect()
}

/// A guard against what never comes, out of reach of a machine that is merely busy.
const PATIENCE: Duration = Duration::from_secs(1800);

fn wait_until(what: &str, mut met: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !met() {
        assert!(begin.elapsed() < PATIENCE, "waited in vain until {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn shards_of_which_one_is_killed_give_the_table_of_one_process() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("tiny.toml"), TINY).unwrap();
    let whole = json(&["run", "tiny.toml", "--out", "whole", "--json"], folder);

    let shard = |number: &str| -> Child {
        torquescope(&["run", "tiny.toml", "--out", "parts", "--shard", number], folder).spawn().unwrap()
    };
    // The second shard begins with a network. It is killed while it trains it: its claim stays behind.
    let mut killed = shard("2/2");
    let claims = || {
        let cells = std::fs::read_dir(folder.join("parts/cells")).into_iter().flatten();
        cells.filter(|cell| cell.as_ref().is_ok_and(|cell| cell.path().join("claim-1").exists())).count()
    };
    wait_until("the shard works", || claims() == 1);
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert_eq!(claims(), 1);
    let before = states(folder, "parts");
    assert!(
        before.contains(&"open".into()) && !before.iter().any(|state| state.get("running").is_some()),
        "{before:?}"
    );

    let mut both = [shard("1/2"), shard("2/2")];
    assert!(both.iter_mut().all(|shard| shard.wait().unwrap().success()));
    assert!(states(folder, "parts").iter().all(|state| state == "done"));
    assert_eq!(json(&["collect", "tiny.toml", "--out", "parts", "--json"], folder), whole);
    assert_eq!(claims(), 0);
}

#[test]
fn only_what_changed_is_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = |text: &str| {
        std::fs::write(folder.join("tiny.toml"), text).unwrap();
        json(&["run", "tiny.toml", "--quick", "--json"], folder)
    };
    let trained = || -> Vec<(std::path::PathBuf, std::time::SystemTime)> {
        let cells = std::fs::read_dir(folder.join("experiments/cells")).unwrap().map(|cell| cell.unwrap().path());
        let mut times: Vec<_> =
            cells.map(|cell| (cell.clone(), cell.join("model-1").metadata().unwrap().modified().unwrap())).collect();
        times.sort();
        times
    };
    let first = run(TINY);
    let before = trained();
    assert_eq!(before.len(), 2);
    assert_eq!(run(TINY), first);
    assert_eq!(trained(), before);

    // Another test set needs no training.
    let more = run(&TINY.replace("[1.0, 2.0]", "[1.0, 2.0, 3.0]"));
    assert_eq!(trained(), before);
    assert_eq!(more["cells"].as_array().unwrap().len(), first["cells"].as_array().unwrap().len() + 2);

    // Another network does, and the rigid body does not.
    run(&TINY.replace("hidden = [16]", "hidden = [8]"));
    let after = trained();
    assert_eq!(after.len(), 3);
    assert!(before.iter().all(|cell| after.contains(cell)));
}

/// A file of a finished cell that is not whole is named and done again; it does not count as done.
#[test]
fn damaged_results_are_named_and_done_again() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("tiny.toml"), TINY).unwrap();
    let whole = json(&["run", "tiny.toml", "--quick", "--json"], folder);
    let files = |begin: &str| {
        let cells = std::fs::read_dir(folder.join("experiments/cells")).unwrap().map(|cell| cell.unwrap().path());
        let files = cells.flat_map(|cell| std::fs::read_dir(cell).unwrap()).map(|file| file.unwrap().path());
        let mut files: Vec<_> =
            files.filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with(begin)).collect();
        files.sort();
        files
    };
    for begin in ["test-", "training.json", "model-1"] {
        let damaged = files(begin).remove(0);
        std::fs::write(&damaged, "").unwrap();
        let status = succeeds(&["status", "tiny.toml", "--quick"], folder);
        assert!(status.contains("is damaged") && status.contains("1 of 2 cells are done"), "{status}");
        let output = torquescope(&["run", "tiny.toml", "--quick", "--json"], folder).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        let name = damaged.file_name().unwrap().to_str().unwrap();
        assert!(output.status.success() && said.contains(name) && said.contains("is damaged"), "{begin}: {said}");
        let again: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(again, whole, "{begin}");
    }
}

#[test]
fn the_table_has_the_promised_schema() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = TINY
        .replace("seeds = 1", "seeds = 2")
        .replace("title", "paper_table = 2\ntitle")
        .replace("\"network\"", "\"ff-nn\"");
    std::fs::write(folder.join("tiny.toml"), text).unwrap();
    let table = json(&["run", "tiny.toml", "--quick", "--json"], folder);
    let cells = table["cells"].as_array().unwrap();
    let cell = cells.iter().find(|cell| cell["model"] == "ff-nn" && cell["test_set"] == "iid").unwrap();
    assert_eq!(cell["seeds"], 2);
    for quantity in ["nmse_torque", "nmse_inertial", "nmse_gravity", "r2"] {
        let mean = cell[quantity].as_f64().unwrap();
        let [low, high] = [0, 1].map(|end| cell["interval"][quantity][end].as_f64().unwrap());
        assert!(low <= mean && mean <= high, "{quantity}: {low} {mean} {high}");
    }
    // A pendulum has no Coriolis torque.
    assert!(cell["nmse_coriolis"].is_null());
    assert_eq!(cell["mse_joint"].as_array().unwrap().len(), 1);
    assert_eq!(cell["paper"]["nmse_torque"], 0.0037);
    let body = cells.iter().find(|cell| cell["model"] == "rigid-body" && cell["test_set"] == "speed 2").unwrap();
    assert!(body["nmse_torque"].as_f64().unwrap() < 1e-20);
    assert_eq!((&body["curve"], &body["x"]), (&"speed".into(), &2.0.into()));

    let csv = folder.join("table.csv");
    succeeds(&["collect", "tiny.toml", "--quick", "--csv", "table.csv"], folder);
    assert!(std::fs::read_to_string(csv).unwrap().contains("ff-nn,iid,,,2,nmse_torque,"));
}

/// Every kind of figure is drawn out of what was run, and nothing is trained for it.
#[test]
fn figures_are_made_of_what_was_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("tiny.toml"), TINY.replace("title", "paper_table = 2\ntitle")).unwrap();
    let nothing = torquescope(&["figures", "tiny.toml", "--quick", "--figure", "errors"], folder).output().unwrap();
    let said = String::from_utf8_lossy(&nothing.stderr).into_owned();
    assert!(said.contains("nothing to draw: run `experiment run tiny.toml --quick` first"), "{said}");
    json(&["run", "tiny.toml", "--json"], folder);
    let written = succeeds(&["figures", "tiny.toml", "--format", "svg", "pdf", "csv", "-o", "pictures"], folder);
    for name in ["trajectories", "motions", "torques-iid", "curve-speed", "errors"] {
        for ending in ["svg", "pdf", "csv"] {
            let file = format!("pictures/tiny-{name}.{ending}");
            assert!(written.contains(&file), "{file} is not among\n{written}");
            assert!(std::fs::metadata(folder.join(&file)).unwrap().len() > 80, "{file}");
        }
    }
    let csv = |name: &str| std::fs::read_to_string(folder.join(format!("pictures/tiny-{name}.csv"))).unwrap();
    // The numbers are those of the table.
    let table = json(&["collect", "tiny.toml", "--json"], folder);
    let cells = table["cells"].as_array().unwrap();
    let of =
        |model: &str, set: &str| cells.iter().find(|cell| cell["model"] == model && cell["test_set"] == set).unwrap();
    let field = |name: &str, begin: &str, column: usize| -> f64 {
        let text = csv(name);
        let line = text.lines().find(|line| line.contains(begin)).unwrap_or_else(|| panic!("{begin} in {text}"));
        line.split(',').nth(column).unwrap().parse().unwrap()
    };
    assert_eq!(field("curve-speed", "line,network,2,", 4), of("network", "speed 2")["nmse_torque"].as_f64().unwrap());
    let mse = of("network", "iid")["mse_joint"][0].as_f64().unwrap();
    assert!((field("errors", "bar,network,", 4) / mse - 1.0).abs() < 1e-12);
    // Its tip is a metre from its joint.
    let (x, z) = (field("trajectories", "line,run 1", 3), field("trajectories", "line,run 1", 4));
    assert!((x.hypot(z) - 1.0).abs() < 1e-9);
    assert!(csv("torques-iid").contains("joint 1: gravity,line,exact,"));
}

/// The paper's tables on real arms, on small files in the layout of the published ones.
#[test]
fn the_papers_last_tables_run_on_files_of_the_published_layout() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let of = |table: &str| json(&["run", table, "--quick", "--only", "ff-nn", "--data", ".", "--json"], at);
    let values = |count: usize| (0..count).map(|n| (n as f64 * 0.7).sin()).collect::<Vec<f64>>();

    // Rollouts × samples × 3 joints at 1 kHz, of which the first 1,000 samples are left out; accelerations are derived.
    for name in ["training", "test_iid", "test_transfer_1", "test_transfer_2", "test_transfer_3"] {
        std::fs::write(at.join(format!("Sines_{name}.npz")), finger_robot(3, 2000)).unwrap();
    }
    let cells = of("paper-table-3");
    let sets: Vec<&str> =
        cells["cells"].as_array().unwrap().iter().map(|cell| cell["test_set"].as_str().unwrap()).collect();
    assert_eq!(sets, ["iid", "non-iid-0", "non-iid-1", "non-iid-2"]);
    assert_eq!(cells["cells"][0]["mse_joint"].as_array().unwrap().len(), 3);

    // Samples × 5 joints.
    for (file, samples) in [("flasks-200ml-400ml.mat", 3000), ("flasks-300ml.mat", 1000)] {
        let signals = ["q", "qd", "qdd", "tau"].map(|name| (name, [samples, 5], values(5 * samples)));
        std::fs::write(at.join(file), matlab(&signals)).unwrap();
    }
    let cells = of("paper-table-4");
    let cell = |set: usize| &cells["cells"][set];
    assert_eq!((&cell(0)["test_set"], &cell(1)["test_set"]), (&"iid".into(), &"non-iid".into()));
    assert_eq!(cell(1)["mse_joint"].as_array().unwrap().len(), 5);
    assert_eq!(cell(0)["paper"]["r2"], 0.9936);
}

/// An NPZ as the finger robot's data set has it: rollouts of a smooth motion.
fn finger_robot(rollouts: usize, samples: usize) -> Vec<u8> {
    use std::io::Write;
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let names = ["angles", "velocities", "torques"].map(|name| format!("measured_{name}"));
    for (number, name) in names.into_iter().chain(["constrained_torques".into(), "desired_torques".into()]).enumerate()
    {
        let shape = [rollouts, samples, 3];
        let wave = |n: usize| ((n / 3) as f64 * 2e-3 + number as f64 + (n % 3) as f64).sin() as f32;
        let bytes = (0..shape.iter().product()).flat_map(|n| wave(n).to_le_bytes());
        archive.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(&torquescope::recording::npy::encode("<f4", &shape, bytes)).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A MATLAB file of version 5 with these matrices.
fn matlab(matrices: &[(&str, [usize; 2], Vec<f64>)]) -> Vec<u8> {
    let element = |kind: u32, content: &[u8]| {
        let mut bytes = [kind.to_le_bytes(), (content.len() as u32).to_le_bytes()].concat();
        bytes.extend(content);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let words = |values: [usize; 2]| values.map(|value| (value as u32).to_le_bytes()).concat();
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    for (name, sizes, values) in matrices {
        let numbers: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let parts =
            [element(6, &words([6, 0])), element(5, &words(*sizes)), element(1, name.as_bytes()), element(9, &numbers)];
        bytes.extend(element(14, &parts.concat()));
    }
    bytes
}

/// After a quick run the commands on the whole experiment say what to add, instead of finding nothing.
#[test]
fn what_a_quick_run_left_is_told_to_who_asks_for_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("tiny.toml"), TINY).unwrap();
    let ask = |arguments: &[&str]| {
        let output = torquescope(arguments, folder).output().unwrap();
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        (output.status.code(), said)
    };
    let (code, said) = ask(&["collect", "tiny.toml"]);
    assert!(
        code == Some(1) && said.contains("nothing of it is in experiments: run `experiment run tiny.toml`"),
        "{said}"
    );
    // Other first weights than those of the whole, so that they share no cell but the rigid body's.
    succeeds(&["run", "tiny.toml", "--quick", "--only", "network"], folder);
    let only = ["--only", "network"];
    let (code, said) = ask(&[&["status", "tiny.toml"][..], &only].concat());
    assert!(code == Some(0) && said.contains("1 cell of the quick version is there: add --quick"), "{said}");
    let (code, said) = ask(&[&["collect", "tiny.toml"][..], &only].concat());
    assert!(code == Some(1) && said.contains("1 cell of the quick version is there: add --quick"), "{said}");
    let (code, said) = ask(&[&["figures", "tiny.toml", "--figure", "errors"][..], &only].concat());
    assert!(code == Some(1) && said.contains("1 cell of the quick version is there: add --quick"), "{said}");
    let (code, said) = ask(&[&["figures", "tiny.toml", "--figure", "motions"][..], &only].concat());
    assert!(code == Some(0) && said.contains("Only the data are drawn"), "{said}");
    assert_eq!(ask(&[&["collect", "tiny.toml", "--quick"][..], &only].concat()).0, Some(0));
}

#[test]
fn what_can_not_be_done_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let fails = |arguments: &[&str]| {
        let output = torquescope(arguments, folder).output().unwrap();
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(fails(&["run", "table-7"]).contains("there is no experiment `table-7`; built in: table-2"));
    std::fs::write(folder.join("bad.toml"), TINY.replace("seeds = 3", "sheds = 3")).unwrap();
    let message = fails(&["run", "bad.toml"]);
    assert!(
        message.contains("bad.toml") && message.contains("line 4") && message.contains("unknown field `sheds`"),
        "{message}"
    );
    let text = TINY.replace("preset = \"ff-nn\"", "preset = \"ff-nn\"\neffects = [\"coulomb-friction@7\"]");
    std::fs::write(folder.join("wrong.toml"), text).unwrap();
    let output = torquescope(&["run", "wrong.toml", "--quick"], folder).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("network, seed 1: Coulomb friction is to act on joint 7, but the arm has 1"), "{message}");
    // The other model has its row all the same.
    assert!(String::from_utf8(output.stdout).unwrap().contains("rigid-body"));
    assert!(
        succeeds(&["status", "wrong.toml", "--quick"], folder)
            .contains("failed: Coulomb friction is to act on joint 7")
    );
    std::fs::write(folder.join("away.toml"), "title = \"t\"\ndescription = \"d\"\nseeds = 1\n[data]\nrecordings = [{ file = \"a.csv\" }]\n[[model]]\nname = \"r\"\npreset = \"rigid-body\"\n[[test]]\nname = \"iid\"\nrecordings = [{ file = \"b.csv\" }]\n").unwrap();
    assert!(fails(&["run", "away.toml"]).contains("give their folder with --data"));
    assert!(fails(&["run", "away.toml", "--data", "."]).contains("a.csv"));
}

/// The template of a Slurm array, with the variables that Slurm sets, does what the shards do.
#[test]
fn the_slurm_template_runs_its_shard() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("tiny.toml"), TINY).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cluster/slurm.sh");
    for task in ["1", "2"] {
        let mut command = Command::new("sh");
        command.arg(&script).args(["tiny.toml", "--quick"]).current_dir(folder);
        command.env("TORQUESCOPE", env!("CARGO_BIN_EXE_torquescope"));
        command.env("SLURM_ARRAY_TASK_ID", task).env("SLURM_ARRAY_TASK_COUNT", "2");
        assert!(command.output().unwrap().status.success());
        let status = json(&["status", "tiny.toml", "--quick", "--json"], folder);
        let done = status["cells"].as_array().unwrap().iter().filter(|cell| cell["state"] == "done").count();
        assert_eq!(done.to_string(), task);
    }
}
