//! The program as a user calls it: arguments in, text, JSON, files and exit codes out.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::runner::{fails, json, succeeds, torquescope};

/// A recording with 2 N m of Coulomb friction hidden in joint 1 and 0.7 N m in joint 2.
fn hidden_friction(folder: &Path) {
    let effects = ["--effect", "coulomb-friction@1=2.0", "--effect", "coulomb-friction@2=0.7"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &effects].concat(), folder);
}

/// The drawings of a screen are figures as its plots are: as vectors, as pixels, and the same bytes every time.
#[test]
fn drawings_are_written_without_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (screen, title, word) in [("compare", "the arm", "link 3"), ("model", "structure", "rigid body")] {
        for file in ["one.svg", "two.svg", "one.pdf", "one.png"] {
            succeeds(&["figure", screen, "--only", title, "--dpi", "60", "-o", file], folder);
        }
        let read = |file: &str| std::fs::read(folder.join(file)).unwrap();
        assert!(String::from_utf8(read("one.svg")).unwrap().contains(word), "{title}");
        assert_eq!(read("one.svg"), read("two.svg"));
        assert!(read("one.pdf").starts_with(b"%PDF") && read("one.png").starts_with(b"\x89PNG"));
    }
    let message = fails(&["figure", "compare", "--only", "no such plot", "-o", "x.svg"], folder, 1);
    assert!(message.contains("the arm at t ="), "{message}");
}

#[test]
fn a_hidden_effect_is_diagnosed_with_the_promised_schema() {
    let folder = tempfile::tempdir().unwrap();
    hidden_friction(folder.path());
    let report = json(&["diagnose", "x.npz", "--model", "rigid-body", "--json"], folder.path());
    assert_eq!(report["verdict"], "missing");
    let effect = &report["effects"][0];
    assert_eq!(effect["effect"], "coulomb-friction");
    assert_eq!(effect["joints"], serde_json::json!([1, 2]));
    assert!(effect["presence"].as_f64().unwrap() > 0.9);
    assert!(effect["alternatives"].is_array());
    for (parameter, (joint, truth)) in effect["parameters"].as_array().unwrap().iter().zip([(1, 2.0), (2, 0.7)]) {
        assert_eq!((&parameter["name"], &parameter["joint"]), (&"coulomb_torque".into(), &joint.into()));
        assert_eq!(parameter["unit"], "N m");
        let value = parameter["value"].as_f64().unwrap();
        assert!((value - truth).abs() < 0.05 * truth, "{value}, not {truth}");
        let [low, high] = [0, 1].map(|end| parameter["interval"][end].as_f64().unwrap());
        assert!(low < value && value < high);
    }
    let numbers = |value: &Value| value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    let (before, after) = (numbers(&effect["nmse_before"]), numbers(&effect["nmse_after"]));
    assert_eq!(before, numbers(&report["held_out_nmse"]));
    assert!(after[0] < 0.2 * before[0] && after[1] < 0.2 * before[1]);
    assert_eq!(numbers(&report["noise_floor_nmse"]).len(), 3);
    assert!(report["advice"].as_str().unwrap().contains("Coulomb"));
}

#[test]
fn a_model_is_saved_and_measured_on_another_recording() {
    let folder = tempfile::tempdir().unwrap();
    hidden_friction(folder.path());
    let trained =
        json(&["train", "x.npz", "--add", "coulomb-friction@1,2", "-o", "model.json", "--json"], folder.path());
    assert_eq!(trained["terms"].as_array().unwrap().len(), 3);
    let other = ["--effect", "coulomb-friction@1=2.0", "--effect", "coulomb-friction@2=0.7", "--seed", "9"];
    succeeds(&[["simulate", "-o", "y.npz"].as_slice(), &other].concat(), folder.path());
    let measured = json(&["evaluate", "y.npz", "--model", "model.json", "--rollout", "--json"], folder.path());
    assert!(measured["mean_r2"].as_f64().unwrap() > 0.999);
    let off = measured["rollout"]["error"].as_array().unwrap().iter().map(|joint| joint.as_f64().unwrap());
    assert!(off.clone().count() == 3 && off.clone().all(|off| off < 0.1), "{measured}");
    let text = succeeds(&["evaluate", "y.npz", "--model", "model.json", "--rollout"], folder.path());
    assert!(text.contains("RMS of q off after 0.25 s of simulation, from 24 states, by joint [rad]"), "{text}");
    let report = json(&["diagnose", "y.npz", "--model", "model.json", "--json"], folder.path());
    assert_eq!(report["verdict"], "nothing-missing");
}

/// Mean, least and greatest over seeds; the held-out runs choose none of them.
#[test]
fn several_seeds_are_trained_and_told_together() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "--joints", "2", "--motion", "paper", "--trajectories", "8", "-o", "x.npz"], at);
    let options = ["--model", "structured-delan", "--epochs", "2", "--batch", "64", "--hidden", "4", "--seeds", "3"];
    let trained = json(&[["train", "x.npz", "--json"].as_slice(), &options].concat(), at);
    let seeds = trained["seeds"].as_array().unwrap();
    assert_eq!(seeds.iter().map(|seed| seed["seed"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 1, 2]);
    let joints = trained["held_out_nmse_of_seeds"].as_array().unwrap();
    assert_eq!(joints.len(), 2);
    for (joint, spread) in joints.iter().enumerate() {
        let errors = seeds.iter().map(|seed| seed["held_out"][joint]["nmse"].as_f64().unwrap());
        let mean = errors.sum::<f64>() / 3.0;
        assert!((spread["mean"].as_f64().unwrap() / mean - 1.0).abs() < 1e-12);
        assert!(spread["least"].as_f64() < spread["greatest"].as_f64());
    }
    let validation = |history: &Value| history.as_array().unwrap().last().unwrap()["validation"].as_f64().unwrap();
    let best = seeds.iter().map(|seed| validation(&seed["history"])).fold(f64::INFINITY, f64::min);
    assert_eq!(validation(&trained["history"]), best, "the one that is kept is the best by validation");
    assert!(fails(&["train", "x.npz", "--seeds", "2"], at, 1).contains("nothing to train"));
}

/// A figure of many plots has as many pixels an inch as fit, unless somebody asked for more.
#[test]
fn a_tall_figure_is_drawn_with_the_pixels_that_fit() {
    let folder = tempfile::tempdir().unwrap();
    let tall = ["figure", "residuals", "--size", "one-column", "-o", "tall.png"];
    succeeds(&tall, folder.path());
    assert!(std::fs::read(folder.path().join("tall.png")).unwrap().starts_with(b"\x89PNG"));
    let message = fails(&[&tall[..], &["--dpi", "1200"]].concat(), folder.path(), 1);
    assert!(message.contains("another resolution"), "{message}");
}

/// The lines of a table whose first words are these.
fn rows_of<'t>(table: &'t str, name: &str) -> Vec<&'t str> {
    table.lines().filter(|line| line.contains(name)).collect()
}

/// A recording is written as it was understood, whole or in parts, and read back the same; what can't be written so is told.
#[test]
fn a_recording_is_converted_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "--joints", "2", "-o", "arm.npz"], at);
    let of = |path: &str| json(&["inspect", path, "--json"], at);
    let runs = |told: &serde_json::Value| told["trajectories"].as_array().unwrap().clone();
    let whole = of("arm.npz");
    let message = fails(&["convert", "arm.npz", "-o", "arm.csv"], at, 2);
    assert!(
        message.contains(&format!("it has {} runs", runs(&whole).len())) && message.contains("-o arm"),
        "{message}"
    );
    let unknown = fails(&["convert", "arm.npz", "-o", "arm.xlsx"], at, 2);
    assert!(unknown.contains("nothing is written as .xlsx") && unknown.contains("or name a folder"), "{unknown}");
    assert!(fails(&["simulate", "-o", "arm.txt"], at, 2).contains("nothing is written as .txt"));
    for other in ["arm.parquet", "arm.mcap"] {
        let said = succeeds(&["convert", "arm.npz", "-o", other], at);
        assert!(said.contains("left out: ") && said.contains("the seal"), "{said}");
        assert_eq!(runs(&of(other)).len(), runs(&whole).len(), "{other}");
    }
    assert_eq!(of("arm.parquet")["samples"], whole["samples"]);
    assert!(fails(&["predict", "arm.npz", "-o", "torques.xlsx"], at, 2).contains("nothing is written as .xlsx"));
    assert!(fails(&["convert", "arm.npz", "-o", "arm.npz"], at, 2).contains("name another file"));
    succeeds(&["convert", "arm.npz", "-o", "all"], at);
    let files: Vec<_> = std::fs::read_dir(at.join("all")).unwrap().map(|file| file.unwrap().path()).collect();
    assert_eq!(files.len(), runs(&whole).len());
    let one = succeeds(&["inspect", files[0].to_str().unwrap()], at);
    assert!(one.contains("2 joints"), "{one}");
    // Both parts together are all of it, but for what lies beside the cuts.
    let samples = |part: &str| {
        let file = format!("{part}.npz");
        succeeds(&["convert", "arm.npz", "--part", part, "-o", &file], at);
        of(&file)["samples"].as_u64().unwrap()
    };
    let [training, held_out] = ["training", "held-out"].map(samples);
    assert!(training > held_out && held_out > 0 && training + held_out <= whole["samples"].as_u64().unwrap());
    // To the bit, by way of text.
    let first = |folder: &str| {
        let mut files: Vec<_> = std::fs::read_dir(at.join(folder)).unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        std::fs::read(&files[0]).unwrap()
    };
    let mut csv: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();
    csv.sort_unstable();
    succeeds(&["convert", csv[0], "-o", "again"], at);
    assert_eq!(first("again"), first("all"));
}

/// What is predicted of a part are rows of what is predicted of all, also where a term remembers what was before; the residual is what
/// was measured less what was predicted.
#[test]
fn a_part_is_predicted_as_the_whole_is() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let hidden = ["--joints", "2", "--effect", "coulomb-friction@1", "--trajectories", "2"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &hidden].concat(), at);
    succeeds(&["train", "x.npz", "--add", "dahl-hysteresis@2", "-o", "model.json"], at);
    let table = |part: &[&str]| {
        succeeds(&[["predict", "x.npz", "--model", "model.json", "-o", "t.csv"].as_slice(), part].concat(), at);
        std::fs::read_to_string(at.join("t.csv")).unwrap()
    };
    let whole = table(&[]);
    let rows: std::collections::BTreeSet<&str> = whole.lines().collect();
    for part in ["training", "held-out"] {
        let own = table(&["--part", part]);
        assert!(own.lines().count() > 100 && own.lines().count() < rows.len(), "{part}");
        assert!(own.lines().all(|line| rows.contains(line)), "{part}");
    }
    let names: Vec<&str> = whole.lines().next().unwrap().split(',').collect();
    let columns = ["tau_measured2", "tau_predicted2", "tau_residual2"];
    let places = columns.map(|name| names.iter().position(|other| *other == name).unwrap());
    for line in whole.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [measured, predicted, residual] = places.map(|place| cells[place].parse::<f64>().unwrap());
        assert_eq!(residual, measured - predicted);
    }
    assert!(fails(&["predict", "x.npz", "--part", "half", "-o", "t.csv"], at, 2).contains("held-out"));
}

/// Of a robot with a hand the joints that move are named; what there is not is told with what there is.
#[test]
fn of_a_robot_with_a_hand_the_joints_of_the_arm_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let joint = |name: &str, kind: &str, links: [&str; 2]| {
        let [parent, child] = links;
        format!(
            "<link name=\"{child}\"/><joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"0.5 0 0\"/><axis xyz=\"0 -1 0\"/></joint>"
        )
    };
    let arm = joint("one", "revolute", ["base", "upper"]) + &joint("two", "revolute", ["upper", "fore"]);
    let hand = joint("left", "prismatic", ["fore", "l"]) + &joint("right", "prismatic", ["fore", "r"]);
    std::fs::write(at.join("r.urdf"), format!("<robot name=\"r\"><link name=\"base\"/>{arm}{hand}</robot>")).unwrap();
    succeeds(&["simulate", "--joints", "2", "-o", "arm.npz"], at);
    let inspect = ["inspect", "arm.npz", "--arm", "r.urdf"];
    assert!(fails(&inspect, at, 2).contains("--arm-joints"));
    let wrong = fails(&[&inspect[..], &["--arm-joints", "one,elbow"]].concat(), at, 2);
    assert!(wrong.contains("no moving joint `elbow`; there are: one, two, left, right"), "{wrong}");
    succeeds(&[&inspect[..], &["--arm-joints", "one,two"]].concat(), at);
}

/// What a command prints as tables it also writes, as the ending of the file says.
#[test]
fn tables_are_written_as_their_ending_says() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "--joints", "2", "-o", "arm.npz"], at);
    let written = |file: &str| {
        let told = succeeds(&["train", "arm.npz", "--add", "coulomb-friction", "--table", file], at);
        assert!(told.contains("held-out data:\njoint"), "it is printed as well: {told}");
        std::fs::read_to_string(at.join(file)).unwrap()
    };
    let tex = written("t.tex");
    assert!(tex.contains("\\usepackage{booktabs}") && tex.contains("\\caption{held-out data}"), "{tex}");
    assert_eq!((tex.matches("\\toprule").count(), tex.matches("\\end{table}").count()), (3, 3), "{tex}");
    let markdown = written("t.md");
    assert!(markdown.contains("**training data**\n\n| joint | MSE [(N m)²] | nMSE | R² |"), "{markdown}");
    assert!(written("t.csv").starts_with("term,parameter,joint,value,95 % interval,"));
    let refused = |arguments: &[&str], told: &str| {
        let message = fails(arguments, at, 2);
        assert!(message.contains(told), "{message}");
    };
    refused(&["inspect", "arm.npz", "--table", "t.docx"], ".md, .tex, .csv");
    let output = torquescope(&["inspect", "arm.npz", "--json", "--table", "none.md"], at).output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.code() == Some(2) && told.contains("no tables are printed"), "{told}");
    assert!(!at.join("none.md").exists());
    std::fs::write(at.join("log.csv"), "time,q,tau\n0,1,2\n").unwrap();
    refused(&["inspect", "./log.csv", "--table", "log.csv"], "name another one");
    refused(&["convert", "arm.npz", "-o", "x.csv", "--table", "x.csv"], "name another one");
    assert!(std::fs::read_to_string(at.join("log.csv")).unwrap().starts_with("time,"));
}

/// A robot's file that states masses and limits: its arm is a model, and what exceeds its limits is found.
#[test]
fn a_robot_file_states_a_model_and_limits() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "--joints", "2", "-o", "arm.npz"], at);
    let urdf = |effort: f64| {
        let joint = |name: &str, link: &str, place: f64, parent: &str| {
            format!(
                "<joint name=\"{name}\" type=\"revolute\"><origin xyz=\"{place} 0 0\"/><axis xyz=\"0 -1 0\"/><parent \
                 link=\"{parent}\"/><child link=\"{link}\"/><limit lower=\"-20\" upper=\"20\" effort=\"{effort}\" \
                 velocity=\"100\"/></joint><link name=\"{link}\"><inertial><mass value=\"1\"/><origin xyz=\"0.5 0 0\"/><inertia \
                 ixx=\"0\" iyy=\"0.08333333333333333\" izz=\"0\"/></inertial></link>"
            )
        };
        format!("<robot name=\"r\">{}{}</robot>", joint("a", "one", 0.0, "base"), joint("b", "two", 1.0, "one"))
    };
    std::fs::write(at.join("r.urdf"), urdf(1e3)).unwrap();
    let errors = |of: &[&str]| json(&[&["evaluate", "arm.npz", "--json"], of].concat(), at)["joints"].clone();
    let close = |one: &Value, other: &Value| {
        let of = |value: &Value| [0, 1].map(|joint| value[joint]["nmse"].as_f64().unwrap());
        of(one).into_iter().zip(of(other)).all(|(one, other)| (one - other).abs() < 1e-9 + 1e-6 * other)
    };
    let stated = errors(&["--arm", "r.urdf", "--model", "stated-arm"]);
    assert!(close(&stated, &errors(&["--model", "stated-arm"])), "the simulated arm is that of the file: {stated}");
    let told = succeeds(&["train", "arm.npz", "--arm", "r.urdf"], at);
    assert!(told.contains("as stated") && told.contains("that are stated"), "{told}");
    let told = succeeds(&["inspect", "arm.npz", "--arm", "r.urdf", "--table", "limits.md"], at);
    assert!(told.contains("as the robot's file states:\njoint") && told.contains("`stated-arm`"), "{told}");
    assert!(!told.contains("beyond the limit"), "{told}");
    assert!(std::fs::read_to_string(at.join("limits.md")).unwrap().contains("| mass [kg] |"));
    std::fs::write(at.join("weak.urdf"), urdf(1.0)).unwrap();
    let told = succeeds(&["inspect", "arm.npz", "--arm", "weak.urdf"], at);
    assert!(told.contains("warning: τ of joint 1 is") && told.contains("beyond the limit of 1.0000 N m"), "{told}");
}

/// The numbers of a series of a figure.
fn values<'t>(table: &'t str, series: &str) -> Vec<&'t str> {
    table.lines().filter_map(|line| line.split_once(&format!(",{series},"))).map(|(_, numbers)| numbers).collect()
}

/// Of which trajectory, time, joint and models a figure is, and what it shows, is asked for; what there is not is told with what
/// there is.
#[test]
fn a_figure_is_of_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "--embedded", "-o", "arm.npz"], at);
    let table = |of: &[&str]| {
        succeeds(&[&["figure", "compare", "arm.npz", "-o", "a.csv"], of].concat(), at);
        std::fs::read_to_string(at.join("a.csv")).unwrap()
    };
    let torque = ["--only", "joint 1: torque"];
    let first = table(&torque);
    let range = table(&[&torque[..], &["--trajectory", "2", "--range", "2..2.5"]].concat());
    assert_eq!(range, table(&[&torque[..], &["--trajectory", "run 2", "--range", "2..2.5"]].concat()));
    assert_ne!(table(&[&torque[..], &["--trajectory", "2"]].concat()), first, "of another trajectory");
    let (all, few) = (rows_of(&first, "measured").len(), rows_of(&range, "measured").len());
    assert!((40..60).contains(&few) && all > 10 * few, "half a second of {all} samples: {few}");
    // What a check box of the window shows.
    assert!(table(&["--show", "components", "--only", "joint 1"]).contains("Coriolis"));
    let gravity = table(&["--show", "components=gravity", "--only", "joint 1: gravity"]);
    assert!(gravity.contains("joint 1: gravity") && !gravity.contains("Coriolis"));
    assert!(table(&["--formula", "2 * tau1", "--only", "2 * tau1"]).contains("2 * tau1"));
    let two = table(&["--formula", "tau1; 3 * tau1", "--only", "tau1; 3 * tau1"]);
    assert_eq!(values(&two, "3 * tau1").len(), values(&two, "tau1").len());
    // A line of one's own in a chart of the screen.
    let residual = ["--only", "joint 1: residual", "--line", "joint 1: residual", "tau1 - predicted1"];
    let own = table(&residual);
    let residual = values(&own, "τ − τ̂");
    assert!(residual.len() > 100 && values(&own, "tau1 - predicted1") == residual);
    // In the order in which they were named.
    let order = table(&["--only", "joint 2: residual", "--only", "joint 1: torque"]);
    assert!(order.find("joint 2: residual") < order.find("joint 1: torque"));
    assert!(order.find("joint 1: torque").is_some());
    let wrong = [
        (["--trajectory", "nine"], "12 `run 12`"),
        (["--range", "50..60"], "from 0.000 to 7.990 s"),
        (["--range", "5..2"], "like 2..5.5"),
        (["--joint", "4"], "the arm has 3"),
        (["--models", "DeLaN"], "1 `rigid body`"),
        (["--formula", "tau7"], "no channel `tau7`"),
        (["--show", "components=weight"], "components=gravity"),
    ];
    for (option, told) in wrong {
        let message = fails(&[&["figure", "compare", "arm.npz", "-o", "b.svg"], &option[..]].concat(), at, 2);
        assert!(message.contains(told), "{message}");
    }
    for (chart, formula, told) in [("joint 9", "tau1", "joint 3: residual"), ("joint 1", "tau8", "no channel `tau8`")] {
        let line = ["figure", "compare", "arm.npz", "-o", "b.svg", "--line", chart, formula];
        let message = fails(&line, at, 2);
        assert!(message.contains(told), "{message}");
    }
    assert!(!at.join("b.svg").exists());
}

/// Trainings that differ by their seed are saved as a session, and its models are drawn together: the error outside the data as a
/// band, learning curves with bands, a grid with a row for each joint and a column for each model.
#[test]
fn models_of_a_saved_session_are_drawn_together() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "--embedded", "-o", "arm.npz"], at);
    let train = ["train", "arm.npz", "--model", "ff-nn", "--hidden", "4", "--epochs", "2"];
    succeeds(&[&train[..], &["--seeds", "3", "-o", "seeds.torquescope"]].concat(), at);
    let table = |of: &[&str]| {
        succeeds(&[&["figure"], of, &["-o", "a.csv"]].concat(), at);
        std::fs::read_to_string(at.join("a.csv")).unwrap()
    };
    let sweep = table(&["extrapolation", "seeds.torquescope", "--models", "all", "--only", "error"]);
    assert!(!rows_of(&sweep, "FF-NN, 3 trainings").is_empty() && !rows_of(&sweep, "rigid body").is_empty(), "{sweep}");
    assert!(!sweep.contains("seed 1"), "the seeds are one band: {sweep}");
    // A seed brings the others of its training along.
    assert!(table(&["extrapolation", "seeds.torquescope", "--models", "FF-NN"]).contains("FF-NN, 3 trainings"));
    assert!(table(&["train", "seeds.torquescope", "--only", "errors"]).contains("mean of 3 seeds"));
    let errors = table(&["ladder", "seeds.torquescope", "--models", "rigid body,FF-NN, seed 1"]);
    assert!(
        errors.contains("FF-NN, seed 1") || rows_of(&errors, "bar").len() == 6,
        "two models of three joints: {errors}"
    );
    let grid = ["figure", "compare", "seeds.torquescope", "--models", "1,2", "--show", "grid", "-o", "grid.svg"];
    succeeds(&grid, at);
    let svg = std::fs::read_to_string(at.join("grid.svg")).unwrap();
    let plots: Vec<(&str, &str)> = svg
        .split("<clipPath")
        .skip(1)
        .map(|plot| {
            let value = |key: &str| plot.split_once(&format!(" {key}=\"")).unwrap().1.split('"').next().unwrap();
            (value("x"), value("y"))
        })
        .collect();
    assert_eq!(plots.len(), 6, "three joints, two models");
    assert!(plots[0].1 == plots[1].1 && plots[0].0 == plots[2].0 && plots[0].0 != plots[1].0, "{plots:?}");
    let limits: Vec<&str> = svg
        .split("data-y=\"")
        .skip(1)
        .map(|rest| rest.split_once("from").unwrap().1.split("label").next().unwrap())
        .collect();
    let ends = |text: &str| text.split("high").next().unwrap().to_owned();
    assert_eq!(ends(limits[0]), ends(limits[1]), "the plots of a row have the same limits");
    assert_ne!(ends(limits[0]), ends(limits[2]), "another joint has its own");
    // Every screen is as it was asked for.
    succeeds(
        &["figure", "all", "seeds.torquescope", "--models", "1,2", "--show", "grid", "--format", "csv", "-o", "all"],
        at,
    );
    let compare = std::fs::read_to_string(at.join("all/compare.csv")).unwrap();
    assert!(compare.contains("joint 3: FF-NN") && !compare.contains("joint 3: torque"));
    let message = fails(&["train", "arm.npz", "--plain", "-o", "plain.torquescope"], at, 2);
    assert!(message.contains("makes no session"), "{message}");
}

/// Columns, letters, fonts and greys of a figure are asked for; an SVG brings only the letters along that it has.
#[test]
fn a_figure_is_made_for_a_paper() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let figure = ["figure", "compare", "--only", "torque"];
    let look = ["--columns", "3", "--letters", "--font", "serif", "--font-size", "9", "--height", "30"];
    succeeds(&[&figure[..], &look, &["--shared-legend", "--theme", "grey", "-o", "a.svg"]].concat(), at);
    let svg = std::fs::read_to_string(at.join("a.svg")).unwrap();
    assert!(svg.contains("(a) joint 1: torque") && svg.contains("(c) joint 3: torque"), "{}", &svg[..2000]);
    assert!(svg.contains("DejaVu Serif") && svg.contains("font-size=\"9"));
    assert_eq!(svg.matches(">predicted τ̂").count(), 1, "one legend for all");
    let top = |text: &str| svg[..svg.find(text).unwrap()].rfind(" y=\"").map(|at| svg[at + 4..at + 9].to_owned());
    assert_eq!(top("(a) joint 1"), top("(c) joint 3"), "they stand beside each other");
    let font = svg.split("base64,").nth(1).unwrap().split(')').next().unwrap();
    assert!(font.len() < 40_000, "the font takes {} bytes", font.len());
    // Every colour is a grey.
    for color in svg.split("=\"#").skip(1).map(|rest| &rest[..6]) {
        assert!(color[..2] == color[2..4] && color[2..4] == color[4..], "{color}");
    }
    fails(&[&figure[..], &["--columns", "5", "-o", "b.svg"]].concat(), at, 2);
    // All screens in one go: those that have such plots.
    succeeds(&["figure", "all", "--only", "torque", "--format", "csv", "-o", "all"], at);
    let names = std::fs::read_dir(at.join("all")).unwrap().map(|file| file.unwrap().path());
    let tables = names.filter(|path| path.extension().is_some_and(|ending| ending == "csv")).count();
    assert!(at.join("all/compare.csv").exists() && (2..9).contains(&tables), "{tables} tables");
    assert!(at.join("all/compare.tex").exists() && at.join("all/compare_plot.py").exists());
}

#[test]
fn a_network_is_trained_saved_measured_and_taken_apart() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let motion = ["--joints", "2", "--motion", "paper", "--trajectories", "20", "--noise", "0"];
    let effect = ["--effect", "viscous-friction@1=1.5"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &motion, &effect].concat(), at);
    let options = ["--model", "structured-delan", "--add", "viscous-friction@1", "--epochs", "16", "--batch", "64"];
    let trained = json(&[["train", "x.npz", "-o", "net.model", "--json"].as_slice(), &options].concat(), at);
    assert_eq!(trained["terms"], serde_json::json!(["structured Lagrangian", "viscous friction, joint 1"]));
    assert_eq!(trained["history"].as_array().unwrap().len(), 16);
    let damping = trained["parameters"][0]["value"].as_f64().unwrap();
    assert!((damping - 1.5).abs() < 0.05, "{damping}");

    let measured = json(&["evaluate", "x.npz", "--model", "net.model", "--open-seal", "--json"], at);
    assert!(measured["mean_r2"].as_f64().unwrap() > 0.99, "{measured}");
    assert_eq!(measured["components"].as_array().unwrap().len(), 3);
    let beside_truth = &measured["parameters"][0];
    assert_eq!(beside_truth["parameter"], "viscous_coefficient");
    assert_eq!((beside_truth["joint"].as_u64(), beside_truth["truth"].as_f64()), (Some(1), Some(1.5)));
    assert_eq!(beside_truth["value"].as_f64(), Some(damping));
    let share = |joint: usize| measured["terms"][1]["share"][joint].as_f64().unwrap();
    assert!(share(0) > 0.01 && share(0) < 1.0 && share(1) == 0.0, "{}", measured["terms"]);
    let told = json(&["export", "network", "net.model", "--log", "x.npz", "-o", "network", "--json"], at);
    assert_eq!((told["files"].as_array().unwrap().len(), told["left_out"].as_array().unwrap().len()), (6, 0), "{told}");
    assert!(std::fs::read_to_string(at.join("network/effects.py")).unwrap().contains("viscous_friction"), "{told}");
    assert!(fails(&["export", "python", "net.model", "-o", "arm.py"], at, 2).contains("export network"));
    assert!(fails(&["export", "network", "net.model"], at, 2).contains("-o network"));
    succeeds(&["predict", "x.npz", "--model", "net.model", "-o", "torque.csv"], at);
    let table = std::fs::read_to_string(at.join("torque.csv")).unwrap();
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| {
        let place = names.iter().position(|other| *other == name);
        let place = place.unwrap_or_else(|| panic!("{name} is not among {names:?}"));
        let value = |line: &str| line.split(',').nth(place).unwrap().parse::<f64>().unwrap();
        table.lines().skip(1).map(value).collect::<Vec<f64>>()
    };
    for name in ["tau_measured1", "viscous-friction@1", "gravity2", "mass_eigenvalue1", "potential_energy"] {
        column(name);
    }
    // What hangs together does so in the file too: H is symmetric, and its eigenvalues sum to its trace.
    let [h_11, h_12, h_21, h_22] = ["mass_matrix1", "mass_matrix2", "mass_matrix3", "mass_matrix4"].map(column);
    let [least, most] = ["mass_eigenvalue1", "mass_eigenvalue2"].map(column);
    for t in 0..h_11.len() {
        assert!((h_12[t] - h_21[t]).abs() < 1e-9 * h_11[t]);
        assert!((h_11[t] + h_22[t] - least[t] - most[t]).abs() < 1e-9 * h_11[t]);
    }
    let spectrum = &measured["mass_eigenvalues"];
    let smallest = least.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((spectrum["smallest"].as_f64().unwrap() / smallest - 1.0).abs() < 1e-6 && spectrum["not_positive"] == 0.0);
    assert_eq!(column("power").len(), h_11.len());
    assert_eq!(table.lines().count(), 1 + 20 * 400);

    let report = json(&["diagnose", "x.npz", "--model", "structured-delan", "--epochs", "1", "--json"], at);
    assert_eq!(report["effects"][0]["effect"], "viscous-friction", "{report}");
    assert_eq!(report["effects"][0]["joints"], serde_json::json!([1]));
    let message = fails(&["train", "x.npz", "--model", "ff-nn", "--learning-rate", "1e6", "--batch", "64"], at, 2);
    assert!(message.contains("learning rate"), "{message}");
    let message = fails(&["train", "x.npz", "--model", "ff-nn", "--batch", "100000"], at, 1);
    assert!(message.contains("fewer than a batch"), "{message}");
}

/// A killed training goes on from its checkpoint and ends in the same file as one that was left alone.
#[test]
fn a_killed_training_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let motion = ["--joints", "2", "--motion", "paper", "--trajectories", "10", "--noise", "0"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &motion].concat(), at);
    let settings =
        ["--hidden", "16,16", "--epochs", "30", "--batch", "64", "--activation", "silu", "--optimiser", "soap"];
    // What was asked for is in the checkpoint, the effects too.
    let model = ["--model", "structured-delan", "--add", "viscous-friction@1,2"];
    let train = [["train", "x.npz"].as_slice(), &model, &settings].concat();
    succeeds(&[train.as_slice(), &["-o", "whole.model"]].concat(), at);
    let arguments = [train.as_slice(), &["-o", "never.model", "--checkpoint", "run.npz"]].concat();
    let mut child = Command::new(env!("CARGO_BIN_EXE_torquescope")).args(arguments).current_dir(at).spawn().unwrap();
    while !at.join("run.npz").exists() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!at.join("never.model").exists(), "it ended before it was killed");
    succeeds(&["train", "x.npz", "--resume", "run.npz", "-o", "resumed.model", "--threads", "1"], at);
    let bytes = |name| std::fs::read(at.join(name)).unwrap();
    assert!(bytes("whole.model") == bytes("resumed.model"));
    let answer = json(&["evaluate", "x.npz", "--model", "resumed.model", "--json"], at);
    assert!(answer.to_string().contains("viscous friction, joint 2"), "{answer}");

    let resume = |more: &[&str]| fails(&[&["train", "x.npz", "--resume", "run.npz"], more].concat(), at, 2);
    let message = resume(&["--model", "ff-nn"]);
    assert!(message.contains("another model") && message.contains("FF-NN"), "{message}");
    let message = resume(&["--learning-rate", "0.5"]);
    assert!(message.contains("another rate"), "{message}");
    std::fs::write(at.join("run.npz"), &bytes("run.npz")[..1000]).unwrap();
    assert!(resume(&[]).contains("not a trained model or checkpoint"));
    let message = fails(&["train", "x.npz", "--resume", "whole.model"], at, 2);
    assert!(message.contains("a trained model, but the checkpoint of a training is needed"), "{message}");
    let message = fails(&["train", "x.npz", "--resume", "none.npz"], at, 2);
    assert!(message.contains("none.npz"), "{message}");
    let message = fails(&[train.as_slice(), &["--checkpoint", "no/such/folder"]].concat(), at, 1);
    assert!(message.contains("can't write the checkpoint no/such/folder"), "{message}");
}

/// Settings that can't work are refused; those that lead nowhere end with a reason and the best weights so far.
#[test]
fn bad_settings_of_training_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let motion = ["--joints", "2", "--motion", "paper", "--trajectories", "6", "--noise", "0"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &motion].concat(), at);
    let train = |more: &[&'static str]| {
        [["train", "x.npz", "--model", "black-box-delan", "--batch", "64", "--epochs", "40"].as_slice(), more].concat()
    };
    let cases: [(&[&str], &str); 8] = [
        (&["--learning-rate", "0"], "the learning rate is 0"),
        (&["--learning-rate", "1e6"], "the learning rate is 1000000"),
        (&["--hidden", "0"], "0 is not in 1..=4096"),
        (&["--hidden", "64,x"], "invalid value 'x'"),
        (&["--activation", "relu"], "possible values: tanh, sigmoid, softplus, silu"),
        (&["--schedule", "linear"], "possible values: constant, cosine, one-cycle"),
        (&["--precision", "f16"], "possible values: f32, f64"),
        (&["--threads", "0"], "the number of threads is 0"),
    ];
    for (options, words) in cases {
        let message = fails(&train(options), at, 2);
        assert!(message.contains(words), "{options:?}: {message}");
    }
    let wild = ["--learning-rate", "3", "--hidden", "16", "--activation", "tanh", "-o", "best.model"];
    let message = fails(&train(&wild), at, 1);
    assert!(message.contains("training ended early: the loss") && message.contains("best.model"), "{message}");
    let measured = json(&["evaluate", "x.npz", "--model", "best.model", "--json"], at);
    assert!(measured["joints"][0]["nmse"].as_f64().unwrap().is_finite());

    // Data of another arm, and data in which nothing happens.
    succeeds(&["simulate", "-o", "one.npz", "--joints", "1", "--trajectories", "4"], at);
    let message = fails(&["evaluate", "one.npz", "--model", "best.model"], at, 1);
    assert!(message.contains("the model has 2 joints, the recording 1"), "{message}");
    let message = fails(&["predict", "one.npz", "--model", "best.model", "-o", "torque.csv"], at, 1);
    assert!(message.contains("the model has 2 joints, the recording 1"), "{message}");
    let still = |t: i32| format!("{},{},3\n", f64::from(t) * 0.01, (f64::from(t) * 0.02).sin());
    std::fs::write(at.join("still.csv"), "time,q1,tau1\n".to_owned() + &(0..2000).map(still).collect::<String>())
        .unwrap();
    let message = fails(&["train", "still.csv", "--model", "ff-nn"], at, 1);
    assert!(message.contains("the torque of joint 1 is always 3 N m"), "{message}");

    // All settings at once, as a model that is saved and used.
    let all =
        ["--recipe", "paper", "--features", "raw", "--normalise", "true", "--precision", "f64", "--hidden", "8,8"];
    let more =
        ["--learning-rate", "1e-2", "--schedule", "one-cycle", "--goal", "1.1", "--training-seed", "3", "--json"];
    let trained = json(&train(&[all.as_slice(), &more].concat()), at);
    let history = trained["history"].as_array().unwrap();
    assert!(history.len() < 40 && history.last().unwrap()["validation"].as_f64().unwrap() <= 1.1, "{history:?}");
}

#[test]
fn inspect_tells_what_a_file_holds_and_keeps_the_seal_closed() {
    let folder = tempfile::tempdir().unwrap();
    hidden_friction(folder.path());
    let answer = json(&["inspect", "x.npz", "--json"], folder.path());
    assert_eq!((&answer["samples"], &answer["sealed"]), (&9600.into(), &true.into()));
    assert_eq!(answer["joints"].as_array().unwrap().len(), 3);
    assert_eq!(answer["provenance"]["acceleration"], "measured");
    assert!(!succeeds(&["inspect", "x.npz"], folder.path()).contains("coulomb"));
    assert!(!String::from_utf8_lossy(&std::fs::read(folder.path().join("x.npz")).unwrap()).contains("coulomb"));
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.npz", "b.npz"] {
        succeeds(&["simulate", "--mystery", "--seed", "5", "-o", name], folder.path());
    }
    let bytes = |name| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("a.npz") == bytes("b.npz"));
}

/// A result never takes the place of what it is made of.
#[test]
fn inputs_are_refused_as_outputs() {
    let folder = tempfile::tempdir().unwrap();
    hidden_friction(folder.path());
    let names =
        std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let log = names.into_iter().find(|name| name.ends_with(".npz")).unwrap();
    let before = std::fs::read(folder.path().join(&log)).unwrap();
    let other_way = format!("./{log}");
    for command in
        [&["predict", &log, "-o", &log][..], &["predict", &log, "-o", &other_way], &["train", &log, "-o", &log]]
    {
        let message = fails(command, folder.path(), 2);
        assert!(message.contains("can't be written over it: name another file"), "{command:?}: {message}");
    }
    assert_eq!(std::fs::read(folder.path().join(&log)).unwrap(), before);
    let names = std::fs::read_dir(folder.path()).unwrap().count();
    succeeds(&["predict", &log, "-o", "torques.npz"], folder.path());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), names + 1, "nothing is left beside it");
}

#[test]
fn every_command_has_help() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["simulate", "inspect", "train", "evaluate", "diagnose", "demo", "screenshot", "bench", "effects"] {
        let help = succeeds(&[command, "--help"], folder.path());
        assert!(help.contains("Usage: torquescope") && help.len() > 200, "{command}: {help}");
    }
    let help = succeeds(&["screenshot", "--help"], folder.path());
    assert!(help.contains("- residuals:") && help.contains("Examples:"), "{help}");
    // Lines are wrapped to the width of the terminal.
    let help = succeeds(&["train", "-h"], folder.path()).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("[possible values: ours, thorough, paper]"), "{help}");
}

/// What is wrong with a recording, or goes wrong at work.
#[test]
fn bad_input_ends_with_1_and_says_what_where_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).unwrap();
    write("empty.csv", "");
    write("text.csv", "time,q1,tau1\n0,0,0\n0.01,oops,0\n0.02,0,0\n");
    write("picture.csv", "\u{89}PNG\r\n");
    std::fs::write(at.join("picture.npz"), b"\x89PNG\r\n\x1a\n0000").unwrap();
    write("columns.csv", "time,a,b\n0,1,2\n0.01,1,2\n0.02,1,2\n");
    let cases: [(&[&str], &[&str]); 7] = [
        (&["inspect", "missing.csv"], &["missing.csv"]),
        (&["missing.csv"], &["missing.csv"]),
        (&["inspect", "empty.csv"], &["empty.csv", "empty"]),
        (&["inspect", "text.csv"], &["text.csv", "line 3", "q1"]),
        (&["inspect", "picture.npz"], &["picture.npz", "PNG"]),
        (&["inspect", "columns.csv"], &["columns.csv", "a", "b", "q="]),
        (&["inspect", "columns.csv", "--map", "emps"], &["columns.csv"]),
    ];
    for (arguments, words) in cases {
        let message = fails(arguments, at, 1);
        for word in words {
            assert!(message.contains(word), "{arguments:?} does not say `{word}`: {message}");
        }
    }
}

/// What is wrong with the command line, or with a file that one of its options names.
#[test]
fn wrong_usage_ends_with_2_and_says_what_is_possible() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    hidden_friction(at);
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).unwrap();
    write("negative.json", r#"{"links": [{"mass": -1, "length": 1, "com": 0.5, "inertia": 0.1}]}"#);
    write("none.json", r#"{"links": []}"#);
    write("typo.json", r#"{"links": [{"mas": 1, "length": 1, "com": 0.5, "inertia": 0.1}]}"#);
    write("broken.json", "{\"torquescope_model\": 1, \"fitted\": {}}");
    let cases: [(&[&str], &[&str]); 28] = [
        (&["diagnose"], &["Usage"]),
        (&["diagnoze"], &["unrecognized subcommand 'diagnoze'", "diagnose"]),
        (&["diagnoze", "x.npz"], &["unrecognized subcommand 'diagnoze'", "diagnose"]),
        (&["simulate", "--nonsense", "-o", "y.npz"], &["Usage"]),
        (&["inspect", "x.npz", "--zero", "left"], &["down", "right", "up"]),
        (&["simulate", "--joints", "0", "-o", "y.npz"], &["1..=7"]),
        (&["simulate", "--arm", "missing.json", "-o", "y.npz"], &["missing.json"]),
        (&["simulate", "--arm", "negative.json", "-o", "y.npz"], &["negative.json", "link 1", "mass", "-1"]),
        (&["simulate", "--arm", "none.json", "-o", "y.npz"], &["none.json", "1 to 7"]),
        (&["simulate", "--arm", "typo.json", "-o", "y.npz"], &["typo.json", "mas"]),
        (&["simulate", "--scenario", "missing.json", "-o", "y.npz"], &["missing.json"]),
        (&["simulate", "--effect", "magic@1", "-o", "y.npz"], &["magic", "coulomb-friction"]),
        (&["simulate", "--effect", "coulomb-friction@0", "-o", "y.npz"], &["counted from 1"]),
        (&["simulate", "--effect", "coulomb-friction@4", "-o", "y.npz"], &["joint 4", "1 to 3"]),
        (&["simulate", "--effect", "coulomb-friction@1=-2", "-o", "y.npz"], &["coulomb_torque", "-2"]),
        (&["diagnose", "x.npz", "--model", "black-magic"], &["black-magic", "rigid-body"]),
        (&["evaluate", "x.npz", "--model", "broken.json"], &["broken.json"]),
        (&["train", "x.npz", "--plain", "--model", "structured-delan"], &["--plain", "networks"]),
        (&["simulate", "--world", "--part", "backlash@0", "-o", "y.npz"], &["`0` is not a joint", "counted from 1"]),
        (&["evaluate", "x.npz", "--add", "magic"], &["magic", "coulomb-friction"]),
        (&["evaluate", "x.npz", "--add", "viscous-friction@4"], &["joint 4", "1 to 3"]),
        (&["inspect", "x.npz", "--map", "pander"], &["pander", "emps, kuka-kr300, panda, sarcos, tx40, ur10"]),
        (&["effects", "magic"], &["magic", "coulomb-friction"]),
        (&["experiment", "run", "magic"], &["magic", "table-2"]),
        (&["experiment", "run", "dfki", "--data", "missing"], &["--data", "no folder missing"]),
        (&["inspect", "x.npz", "--held-out", "missing.csv"], &["--held-out", "no file missing.csv"]),
        (&["inspect", "x.npz", "--arm", "missing.json"], &["missing.json"]),
        (&["inspect", "x.npz", "--rate", "0"], &["the sampling rate is 0"]),
    ];
    for (arguments, words) in cases {
        let message = fails(arguments, at, 2);
        for word in words {
            assert!(message.contains(word), "{arguments:?} does not say `{word}`: {message}");
        }
        assert!(message.matches("there is no effect").count() <= 1, "told twice: {message}");
    }
    assert!(!at.join("y.npz").exists(), "a failed simulation left a file");
}

/// What stands in a file is shown to people and obeyed by no terminal.
#[test]
fn names_in_files_do_nothing_to_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), "time,a,b\u{9b}31m\n0,1,2\n1,2,3\n").unwrap();
    let message = fails(&["inspect", "log.csv"], folder.path(), 1);
    assert!(message.contains("`b\\u009b31m`") && !message.contains('\u{9b}'), "{message:?}");
}

/// Programs that read the results are told in their language why there are none.
#[test]
fn a_failure_is_told_as_json_too() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code, word) in [
        (["inspect", "missing.csv", "--json"], 1, "missing.csv"),
        (["effects", "magic", "--json"], 2, "magic"),
        (["inspect", "--nonsense", "--json"], 2, "--nonsense"),
    ] {
        let output = torquescope(&arguments, folder.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(told["code"], code);
        let reason = told["reason"].as_str().unwrap();
        assert!(reason.contains(word) && !reason.contains("Usage"), "{reason}");
        assert!(String::from_utf8_lossy(&output.stderr).contains(word));
    }
}

#[test]
fn folders_of_results_are_named_first_unless_asked_to_be_quiet() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let experiment = r#"
        title = "small"
        description = "one link"
        seeds = 1
        [data.simulation]
        arm = { links = [{ mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 }] }
        motion = { kind = "paper-point-to-point", trajectories = 3, duration = 4.0, samples = 50, range = 3.0 }
        [[model]]
        name = "rigid-body"
        preset = "rigid-body"
        [[test]]
        name = "iid"
    "#;
    std::fs::write(at.join("small.toml"), experiment).unwrap();
    let commands: [(&[&str], &str); 3] = [
        (&["demo", "--no-pictures"], "torquescope-demo"),
        (&["experiment", "run", "small.toml"], "experiments"),
        (&["experiment", "figures", "small.toml", "--figure", "errors"], "figures"),
    ];
    for (arguments, output) in commands {
        let told = torquescope(arguments, at).output().unwrap();
        let remarks = String::from_utf8(told.stderr).unwrap();
        assert!(told.status.success(), "{arguments:?}: {remarks}");
        let path = at.canonicalize().unwrap().join(output);
        assert!(remarks.lines().next().unwrap().contains(&path.display().to_string()), "{arguments:?}: {remarks}");
        assert!(path.is_dir());
        let quiet = torquescope(&[arguments, &["--quiet"]].concat(), at).output().unwrap();
        assert!(quiet.status.success() && quiet.stderr.is_empty());
    }
    let saved = torquescope(&["simulate", "-o", "x.npz", "--quiet"], at).output().unwrap();
    assert!(saved.status.success() && saved.stdout.is_empty() && saved.stderr.is_empty());
}

#[test]
fn the_catalogue_of_effects_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let all = json(&["effects", "--json"], folder.path());
    let list = succeeds(&["effects"], folder.path());
    assert_eq!(all.as_array().unwrap().len(), torquescope::effect::registry::ALL.len());
    for effect in all.as_array().unwrap() {
        assert!(list.contains(effect["id"].as_str().unwrap()) && list.contains(effect["formula"].as_str().unwrap()));
        assert!(!effect["source"].as_str().unwrap().is_empty() && !effect["parameters"].as_array().unwrap().is_empty());
    }
    let one = json(&["effects", "stribeck-friction", "--json"], folder.path());
    assert!(all.as_array().unwrap().contains(&one));
    let velocity = &one["parameters"][2];
    assert_eq!((&velocity["unit"], &velocity["unit_prismatic"]), (&"rad/s".into(), &"m/s".into()));
    assert_eq!((&velocity["role"], velocity["max"].as_f64()), (&"shape".into(), Some(10.0)));
    assert!(one["parameters"][0]["max"].is_null(), "a friction torque has no upper bound");
    let text = succeeds(&["effects", "stribeck-friction"], folder.path());
    for word in
        ["exp(-(qd / v_s)^2)", "Bittencourt", "stribeck_velocity", "v_s", "sought from", "Contains coulomb-friction"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
}

/// A session is drawn as it was saved: with the model that its user had made.
#[test]
fn a_saved_session_is_drawn() {
    use torquescope::progress::Monitor;
    use torquescope::session::{Command, Session, file};
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    hidden_friction(at);
    let run = |command: Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
    let open = Command::open(vec![at.join("x.npz")], Default::default(), Default::default());
    let add = Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0] };
    let plain = run(open, &Session::default());
    let session = run(add, &plain);
    for (name, session) in [("plain", plain), ("mine", session)] {
        std::fs::write(at.join(format!("{name}.torquescope")), file::to_bytes(&session.into()).unwrap()).unwrap();
    }
    succeeds(&["report", "plain.torquescope", "mine.torquescope", "-o", "compare.html"], at);
    let page = std::fs::read_to_string(at.join("compare.html")).unwrap();
    assert!(page.contains("<h1>plain beside mine</h1>") && page.matches("class=\"beside\"").count() > 5, "{page}");
    let three = ["report", "mine.torquescope", "plain.torquescope", "x.npz", "-o", "c.html"];
    assert!(fails(&three, at, 2).contains("two beside each other"));
    let picture = ["screenshot", "mine.torquescope", "--screen", "ladder", "-o", "ladder.png"];
    succeeds(&[&picture[..], &["--panel", "What was found", "--over", "models", "--contrast"]].concat(), at);
    let message = fails(&[&picture[..], &["--panel", "No such panel"]].concat(), at, 1);
    assert!(message.contains("has no panel `No such panel`; it has: Steps, What was found, The truth"), "{message}");
    assert!(std::fs::read(at.join("ladder.png")).unwrap().starts_with(b"\x89PNG"));
    succeeds(&["figure", "ladder", "mine.torquescope", "-o", "ladder.csv"], at);
    let table = std::fs::read_to_string(at.join("ladder.csv")).unwrap();
    assert!(table.contains("Coulomb 1"), "{table}");
    assert!(!table.contains("Coulomb 1, 2"), "what its user had not added was added: {table}");
    let message = fails(&["figure", "ladder", "mine.torquescope", "--zero", "down", "-o", "x.csv"], at, 2);
    assert!(message.contains("leave out"), "{message}");
}

#[test]
fn shells_and_manuals_know_all_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let script = succeeds(&["completions", shell], folder.path());
        for word in ["diagnose", "residuals", "thorough"] {
            assert!(script.contains(word), "{shell} does not know {word}");
        }
    }
    assert!(succeeds(&["man"], folder.path()).contains(".TH torquescope 1"));
    succeeds(&["man", "-o", "man1"], folder.path());
    for page in ["torquescope.1", "torquescope-train.1", "torquescope-experiment-run.1"] {
        let text = std::fs::read_to_string(folder.path().join("man1").join(page)).unwrap();
        assert!(text.contains(".TH") && text.contains("Examples"), "{page}");
    }
}

/// As in `… | head`, which reads no further.
#[cfg(unix)]
#[test]
fn output_that_nobody_reads_ends_it_quietly() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_torquescope"));
    let command = command.args(["experiment", "list"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Parts are put into a world by their names, on joints that can have them.
#[test]
fn parts_of_a_world_have_names() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let world = ["simulate", "--world", "-o", "x.npz", "--joints", "2", "--trajectories", "1", "--duration", "2"];
    let with = |part: &'static str| [&world[..], &["--part", part]].concat();
    let parts = ["--part", "payload", "--strength", "0.05", "--save-scenario", "x.toml"];
    succeeds(&[&with("backlash@2")[..], &parts].concat(), at);
    let scenario = std::fs::read_to_string(at.join("x.toml")).unwrap();
    assert!(scenario.contains("kind = \"elastic-gear\"") && scenario.contains("kind = \"tip-load\""), "{scenario}");
    assert!(succeeds(&["seal", "open", "x.npz"], at).contains("payload-picked-up"));
    assert!(fails(&with("rotor@1"), at, 2).contains("can't be on joint 1: choose a joint from 2 to 2"));
    assert!(fails(&with("magic"), at, 2).contains("there is no part `magic`"));
    assert!(fails(&with("cable@1"), at, 2).contains("it is of the whole arm"));
}

/// What a file costs in the window is measured, and a lesson is drawn at any of its steps.
#[test]
fn the_window_is_measured_and_a_lesson_is_drawn_at_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(&["simulate", "-o", "x.npz", "--joints", "2", "--trajectories", "2", "--duration", "2"], at);
    let measured = json(&["bench", "ui", "--open", "x.npz", "--seconds", "0.3", "--json"], at);
    let number = |name: &str| measured[name].as_f64().unwrap();
    assert!(number("seen_s") > 0.0 && number("whole_s") >= number("seen_s"), "{measured}");
    let data = 400.0 * 9.0 * 8.0 / 1024.0 / 1024.0;
    assert!((number("data_mib") - data).abs() < 0.01 * data, "{measured}");
    assert!(number("pictures_per_s") > 1.0 && number("played_percent_of_a_core") > 0.0, "{measured}");
    let picture = ["screenshot", "--screen", "ladder", "--lesson", "6", "--step", "done", "-o", "done.png"];
    succeeds(&picture, at);
    assert!(
        fails(&["screenshot", "--screen", "data", "--lesson", "6", "--step", "x", "-o", "x.png"], at, 1)
            .contains("add")
    );
}

/// How far to trust the diagnosis on one's own log: what is planted there is found, and names stay where it is looked at otherwise.
#[test]
fn a_log_is_planted_into_and_looked_at_in_other_ways() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let small = ["--joints", "2", "--trajectories", "3", "--duration", "6", "--effect", "coulomb-friction@2=1.5"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &small].concat(), at);
    let bench = ["bench", "planted", "x.npz", "--draws", "2", "--twins", "1", "--strengths", "0.1,0.2"];
    let planted = json(&[&bench[..], &["--json"]].concat(), at);
    assert_eq!(planted["before"][0]["effect"], "coulomb-friction");
    let cases = planted["cases"].as_array().unwrap();
    let strengths: Vec<f64> =
        cases.iter().take(2).map(|case| case["detections"][0]["strength"].as_f64().unwrap()).collect();
    assert_eq!((cases.len(), strengths), (3, vec![0.1, 0.2]));
    assert_eq!(cases[2]["kind"], "twin");
    assert_eq!(planted["planted"]["cases"], 2);
    let count = |row: &Value| row["planted"].as_u64().unwrap() + row["there_before"].as_u64().unwrap();
    let rows = planted["planted"]["by_strength"].as_array().unwrap();
    assert_eq!(rows.iter().map(count).collect::<Vec<_>>(), [1, 1]);
    assert!(fails(&["bench", "planted", "x.npz", "--strengths", "5"], at, 2).contains("0.05 is 5 %"));

    let stability = json(&["bench", "stability", "x.npz", "--json"], at);
    let friction = &stability["names"][0];
    assert_eq!((&friction["effect"], &friction["joint"]), (&"coulomb-friction".into(), &2.into()));
    assert!(friction["in_some_form"].as_f64().unwrap() >= 0.8, "{stability}");
    assert_eq!(stability["variants"].as_array().unwrap().len(), 5);
}

/// A model out of the house: as code, in the robot's file, as a report.
#[test]
fn a_model_leaves_as_code_in_a_robot_file_and_as_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let hidden = ["--joints", "2", "--effect", "coulomb-friction@1", "--trajectories", "5"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &hidden].concat(), at);
    succeeds(&["train", "x.npz", "--add", "coulomb-friction", "--add", "dahl-hysteresis@2", "-o", "model.json"], at);
    let told = json(&["export", "c", "model.json", "--log", "x.npz", "-o", "code/arm.c", "--json"], at);
    assert_eq!(told["files"].as_array().unwrap().len(), 3, "{told}");
    assert!(told["left_out"][0]["share"].as_f64().unwrap() < 0.5 && at.join("code/arm_test.c").exists(), "{told}");
    let message = fails(&["export", "c", "x.npz", "-o", "arm.c"], at, 2);
    assert!(message.contains("model"), "{message}");
    assert!(fails(&["export", "c", "model.json", "--smooth", "0", "-o", "arm.c"], at, 2).contains("above 0"));

    let robot = "<robot name=\"r\">\n  <joint name=\"a\" type=\"revolute\"><dynamics damping=\"1\"/></joint>\n  \
                 <joint name=\"b\" type=\"revolute\"/>\n</robot>\n";
    std::fs::write(at.join("r.urdf"), robot).unwrap();
    let told = json(&["export", "urdf", "model.json", "--into", "r.urdf", "--log", "x.npz", "--json"], at);
    let written = std::fs::read_to_string(at.join("r.urdf")).unwrap();
    assert!(written.contains(" damping=\"1\"/></joint>") && written.matches("friction=\"").count() >= 1, "{written}");
    assert!(
        written.ends_with("</joint>\n</robot>\n")
            || written.ends_with("<joint name=\"b\" type=\"revolute\"/>\n</robot>\n"),
        "{written}"
    );
    assert_eq!(std::fs::read_to_string(at.join("r.urdf.bak")).unwrap(), robot);
    assert!(told["not_held"].as_array().unwrap().iter().any(|one| one["what"] == "rigid body"), "{told}");
    assert!(fails(&["export", "mjcf", "model.json", "--into", "r.urdf"], at, 2).contains("<robot>"));
    masses_go_into_a_robot_file(at);

    succeeds(&["report", "x.npz", "-o", "report.html"], at);
    let page = std::fs::read_to_string(at.join("report.html")).unwrap();
    assert!(page.contains("Coulomb friction, joint 1") && page.contains("torquescope diagnose x.npz"));
    succeeds(&["report", "x.npz", "-o", "report.pdf"], at);
    assert!(std::fs::read(at.join("report.pdf")).unwrap().starts_with(b"%PDF"));
    succeeds(&["figure", "compare", "x.npz", "--only", "torque", "-o", "t.csv"], at);
    assert!(std::fs::read_to_string(at.join("t_plot.py")).unwrap().contains("TABLE = \"t.csv\""));
    assert!(std::fs::read_to_string(at.join("t.tex")).unwrap().contains("All numbers are in t.csv"));
}

/// A session that was saved with two models stands wherever a model does, and in place of recordings: its current model, or the one
/// that is named.
#[test]
fn a_saved_session_is_taken_where_a_model_is() {
    use torquescope::progress::Monitor;
    use torquescope::session::{Command, Session, file};
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let hidden = ["--joints", "2", "--effect", "coulomb-friction@1", "--trajectories", "5"];
    succeeds(&[["simulate", "-o", "x.npz"].as_slice(), &hidden].concat(), at);
    let run = |command: Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
    let plain = run(Command::open(vec![at.join("x.npz")], Default::default(), Default::default()), &Session::default());
    let added = run(Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0] }, &plain);
    std::fs::write(at.join("mine.torquescope"), file::to_bytes(&added.into()).unwrap()).unwrap();
    let (body, friction) = ("rigid body", "rigid body + Coulomb 1");

    let code = |more: &[&str]| {
        succeeds(&[["export", "python", "mine.torquescope", "-o", "arm.py"].as_slice(), more].concat(), at);
        std::fs::read_to_string(at.join("arm.py")).unwrap()
    };
    assert!(code(&[]).contains("Coulomb") && !code(&["--of", body]).contains("Coulomb"));
    // By the recording of the session, as by the same one from its file.
    assert_eq!(code(&["--of", friction]), code(&["--of", friction, "--log", "x.npz"]));
    let urdf = "<robot name=\"r\"><joint name=\"a\" type=\"revolute\"/><joint name=\"b\" type=\"revolute\"/></robot>";
    std::fs::write(at.join("r.urdf"), urdf).unwrap();
    let told = json(&["export", "urdf", "mine.torquescope", "--into", "r.urdf", "-o", "own.urdf", "--json"], at);
    assert!(told["not_held"][0]["share"].as_f64().unwrap() > 0.1, "the session has the recording: {told}");

    let wrong = fails(&["export", "c", "mine.torquescope", "--of", "delan", "-o", "arm.c"], at, 2);
    assert!(wrong.contains("“delan”") && wrong.contains(&format!("“{body}”, “{friction}”")), "{wrong}");
    succeeds(&["train", "x.npz", "-o", "model.json"], at);
    assert!(fails(&["export", "c", "model.json", "--of", body, "-o", "arm.c"], at, 2).contains("leave it out"));
    assert!(fails(&["evaluate", "x.npz", "--of", body], at, 2).contains("none is given"));

    let error = |arguments: &[&str]| {
        let told = json(&[["evaluate", "--json"].as_slice(), arguments].concat(), at);
        told["joints"][0]["nmse"].as_f64().unwrap()
    };
    let beside = |name: &str| error(&["x.npz", "--model", "mine.torquescope", "--of", name]);
    assert_eq!(error(&["x.npz", "--model", "mine.torquescope"]), beside(friction));
    assert_eq!(error(&["x.npz", "--model", "model.json"]), beside(body));
    assert!(beside(friction) < 0.2 * beside(body));
    let inside = |name: &str| error(&["mine.torquescope", "--of", name]);
    assert_eq!(error(&["mine.torquescope"]), inside(friction));
    assert_eq!(error(&["mine.torquescope", "--model", "rigid-body"]), inside(body));
    assert_eq!(error(&["x.npz"]), inside(body), "both on what is held out");
    let columns = |arguments: &[&str]| {
        succeeds(&[["predict", "-o", "torques.csv"].as_slice(), arguments].concat(), at);
        let table = std::fs::read_to_string(at.join("torques.csv")).unwrap();
        table.lines().next().unwrap().to_owned()
    };
    assert!(columns(&["mine.torquescope"]).contains("coulomb-friction@1"));
    assert!(!columns(&["x.npz", "--model", "mine.torquescope", "--of", body]).contains("coulomb-friction"));
    let message = fails(&["evaluate", "mine.torquescope", "--zero", "down"], at, 2);
    assert!(message.contains("leave out --map, --zero"), "{message}");
}

/// The planar arm of two joints that `model.json` was identified on, by its MJCF, and by the URDF into which its masses go.
fn masses_go_into_a_robot_file(at: &Path) {
    let urdf = "<robot name=\"r\">\n  <joint name=\"a\" type=\"revolute\"><child link=\"one\"/><axis xyz=\"0 -1 0\"/></joint>\n  \
                <link name=\"one\"/>\n  <!-- kept -->\n  <joint name=\"b\" type=\"revolute\"><parent link=\"one\"/><child link=\"two\"/>\
                <origin xyz=\"1 0 0\"/><axis xyz=\"0 -1 0\"/></joint>\n  <link name=\"two\"/>\n</robot>\n";
    let mjcf = "<mujoco><worldbody><body><joint name=\"a\" axis=\"0 -1 0\"/><body pos=\"1 0 0\"><joint name=\"b\" axis=\"0 -1 0\"/></body></body>\
                </worldbody></mujoco>";
    std::fs::write(at.join("arm.urdf"), urdf).unwrap();
    std::fs::write(at.join("arm.xml"), mjcf).unwrap();
    let open = |arm: &str| json(&["evaluate", "x.npz", "--arm", arm, "--json"], at)["joints"].clone();
    let [one, other] = [open("arm.urdf"), open("arm.xml")];
    assert_eq!(one, other, "the same axes give the same body");
    let export = ["export", "urdf", "model.json", "--into", "arm.urdf", "--inertials", "-o", "own.urdf"];
    assert!(fails(&export, at, 2).contains("--log"));
    let told = json(&[export.as_slice(), &["--log", "x.npz", "--json"]].concat(), at);
    let written = std::fs::read_to_string(at.join("own.urdf")).unwrap();
    assert!(written.contains("<!-- kept -->") && written.matches("<inertial>").count() == 2, "{written}");
    assert!(told["links"][1]["now"]["mass"].as_f64().unwrap() > 0.0, "{told}");
    for joint in told["cost"].as_array().unwrap() {
        let [free, links] = ["nmse_identified", "nmse_of_links"].map(|key| joint[key].as_f64().unwrap());
        assert!(links < free + 0.01, "{told}");
    }
}

/// A desktop that knows both files opens sessions with the program: one names the type that the other one defines.
#[test]
fn the_desktop_knows_sessions_by_their_ending() {
    let read =
        |name: &str| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)).unwrap();
    let (desktop, types) = (read("torquescope.desktop"), read("torquescope.xml"));
    let types = roxmltree::Document::parse(&types).unwrap();
    let of = |tag: &str, attribute: &str| {
        let node = types.descendants().find(|node| node.tag_name().name() == tag).unwrap();
        node.attribute(attribute).unwrap().to_owned()
    };
    assert_eq!(of("glob", "pattern"), format!("*.{}", torquescope::session::file::ENDING));
    assert!(desktop.lines().any(|line| line == format!("MimeType={};", of("mime-type", "type"))), "{desktop}");
    assert!(desktop.lines().any(|line| line == "Exec=torquescope %F"), "it is given the files");
    assert!(desktop.lines().any(|line| line == format!("Icon={}", of("icon", "name"))));
}
