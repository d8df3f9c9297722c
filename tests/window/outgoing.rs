//! A model and data leave the window, as the commands write them from the session that it saved.

use std::collections::BTreeMap;

use super::*;

/// Opens a page of the dialog of exports and chooses something there.
pub fn ask(window: &mut Window, page: ExportPage, choice: &str) {
    window.state_mut().order(Order::AskExport(page));
    settle(window);
    window.get_by_role_and_label(Role::RadioButton, choice).click();
    window.run_steps(3);
}

/// Writes what the open dialog asks about.
fn write(window: &mut Window, to: &Path) {
    type_into(window, "File", to.display());
    window.get_by_role_and_label(Role::Button, "Write the file").click();
    settle(window);
    assert!(window.query_by_label("Write the file").is_none(), "the dialog is closed");
}

/// What a command writes in a folder.
fn command(arguments: &[&str], folder: &Path) {
    let output =
        std::process::Command::new(env!("CARGO_BIN_EXE_torquescope")).args(arguments).current_dir(folder).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// The files of a folder.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap());
    files.map(|file| (file.file_name().into_string().unwrap(), std::fs::read(file.path()).unwrap())).collect()
}

const ROBOT: &str = "<robot name=\"r\">\n  <joint name=\"a\" type=\"revolute\"/>\n  <joint name=\"b\" type=\"revolute\"/>\n  \
                     <joint name=\"c\" type=\"revolute\"/>\n</robot>\n";

#[test]
fn a_model_and_data_leave_as_by_commands() {
    let folder = tempfile::tempdir().unwrap();
    let [own, theirs] = ["own", "theirs"].map(|name| folder.path().join(name));
    [&own, &theirs].into_iter().for_each(|folder| std::fs::create_dir(folder).unwrap());
    std::fs::write(folder.path().join("r.urdf"), ROBOT).unwrap();
    let add = Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0] };
    let mut window = window(run(add, &demonstration()), &compare::ABOUT, Theme::Light);
    window.state_mut().order(Order::Save(folder.path().join("mine.torquescope")));
    settle(&mut window);

    ask(&mut window, ExportPage::Model, "C");
    assert!(window.query_by_role_and_label(Role::RadioButton, "network weights").is_none(), "it has no network");
    write(&mut window, &own.join("arm.c"));
    command(&["export", "c", "../mine.torquescope", "-o", "arm.c"], &theirs);
    assert_eq!(contents(&own).len(), 3);

    ask(&mut window, ExportPage::Model, "URDF");
    assert!(window.get_by_role_and_label(Role::Button, "Write the file").accesskit_node().is_disabled());
    type_into(&mut window, "The robot's own file", folder.path().join("r.urdf").display());
    write(&mut window, &own.join("arm.urdf"));
    command(&["export", "urdf", "../mine.torquescope", "--into", "../r.urdf", "-o", "arm.urdf"], &theirs);
    assert!(std::fs::read_to_string(own.join("arm.urdf")).unwrap().contains("friction="));
    assert!(window.query_by_label_contains("Not in arm.urdf: rigid body, ").is_some());
    assert!(window.query_by_label_contains("% of the torque (RMS)").is_some());

    ask(&mut window, ExportPage::Data, "held-out part");
    write(&mut window, &own.join("held-out.npz"));
    command(&["convert", "../mine.torquescope", "--part", "held-out", "-o", "held-out.npz"], &theirs);
    ask(&mut window, ExportPage::Data, "Torques of a model");
    write(&mut window, &own.join("torques.csv"));
    command(&["predict", "../mine.torquescope", "-o", "torques.csv"], &theirs);
    let table = std::fs::read_to_string(own.join("torques.csv")).unwrap();
    let head = table.lines().next().unwrap();
    assert!(["tau_residual3", "coulomb-friction@1", "gravity2"].iter().all(|column| head.contains(column)), "{head}");

    let (own_files, their_files) = (contents(&own), contents(&theirs));
    assert_eq!(own_files.keys().collect::<Vec<_>>(), their_files.keys().collect::<Vec<_>>());
    for (name, bytes) in &own_files {
        assert!(Some(bytes) == their_files.get(name), "{name} is not what the command writes");
    }
    several_runs_and_inputs(&mut window, folder.path());
}

/// A CSV of several runs is a folder; what the session was made of is not written over.
fn several_runs_and_inputs(window: &mut Window, folder: &Path) {
    ask(window, ExportPage::Data, "CSV");
    assert!(window.query_by_label_contains("a folder of this name gets one for each").is_some());
    write(window, &folder.join("runs.csv"));
    let runs = window.state().session().recording.as_ref().unwrap().trajectories.len();
    assert_eq!(contents(&folder.join("runs")).len(), runs);

    let log = folder.join("own/held-out.npz");
    let before = std::fs::read(&log).unwrap();
    window.state_mut().order(Order::open(vec![log.clone()]));
    settle(window);
    ask(window, ExportPage::Data, "NPZ");
    write(window, &log);
    assert!(window.query_by_label_contains("can't be written over it: name another file").is_some());
    assert_eq!(std::fs::read(&log).unwrap(), before);
}
