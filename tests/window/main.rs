//! Clicks, types and drops through the real widgets, found by the names that a screen reader speaks.

#![allow(clippy::unwrap_used)] // a test fails where something is not as it should be

mod begin;
mod busy;
mod care;
mod charts;
#[path = "../suite/contact.rs"]
mod contact;
mod importing;
mod legends;
mod lessons;
mod looks;
mod lost;
mod models;
mod outgoing;
mod own;
mod played;
mod readable;
mod snapshots;
mod stale;
mod support;
mod undo;
mod units;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Key, Modifiers, Role, Theme};
use egui_kittest::kittest::{NodeT, Queryable};
use support::{Window, demonstration, diagnosed, run, settle, short_plan, small, step_until, trained, window};
use torquescope::app::screens::{
    self, compare, data, diagnose, experiment, extrapolation, ladder, model, residuals, train,
};
use torquescope::app::{About, ExportPage, Locks, Order, Shown, theme};
use torquescope::arm::Posture;
use torquescope::recording::hold_out::HoldOut;
use torquescope::recording::read::ReadOptions;
use torquescope::session::{Command, Session};
use torquescope::simulation::{Excitation, Level, Scenario};

fn click(window: &mut Window, name: &str) {
    window.get_by_role_and_label(Role::Button, name).scroll_to_me();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, name).click();
    settle(window);
}

/// Types a text into a field, in place of what stands there.
fn type_into(window: &mut Window, field: &str, text: impl std::fmt::Display) {
    window.get_by_role_and_label(Role::TextInput, field).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(text.to_string()));
    window.run_steps(2);
}

/// Writes the plots that the open dialog lists into a file.
fn export_to(window: &mut Window, path: &Path, format: &str) {
    settle(window);
    window.get_by_role_and_label(Role::RadioButton, format).click();
    window.run_steps(2);
    type_into(window, "File", path.display());
    window.get_by_role_and_label(Role::Button, "Write the file").click();
    settle(window);
    let closed = window.query_by_label("Write the file").is_none();
    let answered =
        ["Exported: ", "Nothing was exported"].iter().any(|text| window.query_by_label_contains(text).is_some());
    assert!(closed && answered);
}

/// Whoever clicks nothing but the highlighted next step arrives at a repaired model and the opened seal, within two minutes.
#[test]
fn a_newcomer_finds_the_hidden_effect() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    let mut steps = Vec::new();
    let mut first_error = None;
    while window.query_by_label_contains("the way is done").is_none() {
        assert!(steps.len() < 20, "the way does not end: {steps:?}");
        let next = window
            .get_by(|node| node.role() == Role::Button && node.label().is_some_and(|name| name.starts_with("Next: ")));
        steps.push(next.accesskit_node().label().unwrap().trim_start_matches("Next: ").to_owned());
        next.click();
        settle(&mut window);
        let errors = || window.state().session().current().unwrap().evaluation.held_out_nmse();
        first_error.get_or_insert_with(errors);
        if steps.last().is_some_and(|step| step == "Add Coulomb friction") {
            assert!(window.state().session().truth.is_none(), "the seal is closed until the user opens it");
        }
        if steps.last().is_some_and(|step| step == "Open the seal") {
            assert!(window.state().session().truth.is_none(), "it is asked about first");
            click(&mut window, "Open it");
            assert!(window.query_by_label_contains("Held-out error by joint fell from").is_some());
            assert!(window.query_by_label_contains("hidden effect found: Coulomb friction").is_some());
            assert_eq!(window.get_all_by_label("inside the interval").count(), 2);
        }
        if steps.last().is_some_and(|step| step == "Export") {
            export_to(&mut window, &folder.path().join("way.pdf"), "PDF");
        }
    }
    let way = [
        "Demonstration arm",
        "Model",
        "Compare",
        "Where it fails",
        "What is missing",
        "Diagnose",
        "Add Coulomb friction",
        "Diagnose again",
        "Ladder",
        "Open the seal",
        "Extrapolation",
        "Go faster",
        "Export",
    ];
    assert_eq!(steps, way);
    let (before, after) =
        (first_error.unwrap(), window.state().session().current().unwrap().evaluation.held_out_nmse());
    assert!(after[0] < 0.1 * before[0] && after[1] < 0.1 * before[1], "{before:?} -> {after:?}");
    assert!(std::fs::read(folder.path().join("way.pdf")).unwrap().starts_with(b"%PDF"));
}

/// A log whose torques stand in each other's columns: the next step says so, one click sets it right, undo takes it back.
#[test]
fn a_wrong_set_up_is_the_next_step() {
    let swapped = run(Command::SetRight(vec!["order-torque=2,1".parse().unwrap()]), &small());
    let mut window = window(swapped, &data::ABOUT, Theme::Dark);
    let error = |window: &Window| window.state().session().current().unwrap().evaluation.held_out_nmse()[1];
    let wrong = error(&window);
    assert!(window.query_by_label_contains("as the log is set up, a rigid body leaves").is_some());
    click(&mut window, "Next: Set right: the torque of joint 1, 2, … stands in column 2, 1");
    assert!(error(&window) < 0.1 * wrong, "{wrong} -> {}", error(&window));
    assert!(window.query_by_label_contains("Next: Set right").is_none());
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(error(&window), wrong);
    click(&mut window, "Set right");
    assert!(error(&window) < 0.1 * wrong, "the button beside the finding does the same");
}

/// What acts where nothing is learned has its next step, after which it is found; the Data screen says what is held out, and undo takes
/// it back.
#[test]
fn a_contact_in_the_held_out_part_alone_is_found_by_the_next_steps() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("bumper.csv");
    std::fs::write(&log, contact::log()).unwrap();
    let options = ReadOptions { zero: Some(Posture::DOWN), ..ReadOptions::default() };
    let session = run(Command::open(vec![log], options, HoldOut::default()), &Session::default());
    let mut window = window(session, &diagnose::ABOUT, Theme::Light);
    for step in ["Diagnose", "Hold out another part", "Diagnose", "Add lower end stop"] {
        click(&mut window, &format!("Next: {step}"));
    }
    let session = window.state().session();
    assert_eq!((session.ladder.len(), &session.source.as_ref().unwrap().held_out), (2, &HoldOut::Fifth(1)));
    assert!(session.current().unwrap().evaluation.all_held_out.nmse < 1e-4);
    window.state_mut().order(Order::Show(&data::ABOUT));
    settle(&mut window);
    let fifth = |number: usize| format!("Hold out fifth {number}");
    let is_on = |window: &Window, number: usize| {
        let toggled = window.get_by_role_and_label(Role::RadioButton, &fifth(number)).accesskit_node().toggled();
        format!("{toggled:?}").contains("True")
    };
    assert!(is_on(&window, 2) && !is_on(&window, 1));
    window.get_by_role_and_label(Role::RadioButton, &fifth(4)).scroll_to_me();
    settle(&mut window);
    window.get_by_role_and_label(Role::RadioButton, &fifth(4)).click();
    settle(&mut window);
    assert_eq!(window.state().session().source.as_ref().unwrap().held_out, HoldOut::Fifth(3));
    assert_eq!(window.state().session().ladder.len(), 2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(window.state().session().source.as_ref().unwrap().held_out, HoldOut::Fifth(1));
}

/// A screen's plots, also those behind another tab, and one plot alone are written; the same twice gives the same bytes.
#[test]
fn plots_are_exported_from_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    let whole = |window: &mut Window, name: &str, format: &str| {
        window.key_press_modifiers(Modifiers::COMMAND, Key::E);
        window.run_steps(3);
        export_to(window, &folder.path().join(name), format);
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let numbers = String::from_utf8(whole(&mut window, "all.csv", "CSV: the numbers")).unwrap();
    for title in ["joint 1: torque", "joint 3: residual", "joint 2: τ̂"] {
        assert!(numbers.contains(title), "{title}");
    }
    let (one, two) = (whole(&mut window, "a.svg", "SVG"), whole(&mut window, "b.svg", "SVG"));
    assert!(one.starts_with(b"<svg") && one == two);
    window.get_by_label("plot of joint 2: torque [N m]").focus();
    window.run_steps(2);
    window.key_press(Key::E);
    window.run_steps(4);
    export_to(&mut window, &folder.path().join("one.csv"), "CSV: the numbers");
    let numbers = std::fs::read_to_string(folder.path().join("one.csv")).unwrap();
    assert!(numbers.contains("joint 2: torque") && !numbers.contains("joint 1: torque"));
    // What can't be written is said.
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(3);
    export_to(&mut window, &folder.path().join("no/such/folder.png"), "PNG");
    assert!(window.query_by_label_contains("Nothing was exported").is_some());
}

/// Drags by the pointer, as a hand does: down, over, up.
fn drag(window: &mut Window, from: egui::Pos2, to: egui::Pos2) {
    window.drag_at(from);
    window.run_steps(2);
    window.hover_at(from + 0.5 * (to - from));
    window.run_steps(2);
    window.hover_at(to);
    window.run_steps(3);
    window.drop_at(to);
    window.run_steps(4);
}

/// A panel is dragged elsewhere by its tab, and stands there when the program starts again; the menu hides it and puts it back.
#[test]
fn panels_are_rearranged_and_stay() {
    let mut first = window(demonstration(), &compare::ABOUT, Theme::Dark);
    first.run_steps(2);
    let place = |window: &Window, name: &str| window.get_by_role_and_label(Role::Button, name).rect();
    let before = place(&first, "At the cursor");
    let target = place(&first, "Torques");
    assert!(before.left() > target.left() + 400.0, "it stands at the right");
    drag(&mut first, before.center(), target.center());
    let after = place(&first, "At the cursor");
    assert!(after.left() < target.left() + 400.0, "{before:?} -> {after:?}");
    let kept = serde_json::to_string(&first.state().settings(&first.ctx)).unwrap();

    let mut second = window(demonstration(), &compare::ABOUT, Theme::Dark);
    let ctx = second.ctx.clone();
    second.state_mut().restore(serde_json::from_str(&kept).unwrap(), &ctx);
    second.run_steps(3);
    assert_eq!(place(&second, "At the cursor"), after);
    click(&mut second, "View");
    second.get_by_role_and_label(Role::CheckBox, "At the cursor").click();
    second.run_steps(3);
    assert!(second.query_by_role_and_label(Role::Button, "At the cursor").is_none());
    second.get_by_role_and_label(Role::Button, "Put them back").click();
    second.run_steps(4);
    assert_eq!(place(&second, "At the cursor"), before);
}

/// The torque is taken apart, with the truth once the seal is open; time plays by itself.
#[test]
fn the_torque_is_decomposed_and_time_plays() {
    let opened = run(Command::OpenSeal, &support::repaired());
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(opened, &compare::ABOUT, Theme::Light);
    window.get_by_role_and_label(Role::CheckBox, "Decompose").click();
    settle(&mut window);
    assert!(window.query_by_label("plot of joint 1: decomposition [N m]").is_some());
    window.get_by_label("plot of joint 1: decomposition [N m]").focus();
    window.run_steps(2);
    window.key_press(Key::E);
    window.run_steps(4);
    export_to(&mut window, &folder.path().join("parts.csv"), "CSV: the numbers");
    let numbers = std::fs::read_to_string(folder.path().join("parts.csv")).unwrap();
    for part in ["inertial", "Coriolis", "gravity", "Coulomb friction, joint 1"] {
        assert!(numbers.contains(part), "{part}");
    }
    let time = |window: &Window| {
        let slider = window.get_by_role_and_label(Role::Slider, "time cursor");
        slider.accesskit_node().numeric_value().unwrap()
    };
    let before = time(&window);
    click(&mut window, "▶ Play");
    window.run_steps(10);
    assert!(time(&window) > before + 0.1, "{before} -> {}", time(&window));
    click(&mut window, "Pause");
    let stopped = time(&window);
    window.run_steps(5);
    assert_eq!(time(&window), stopped);
}

/// The ends of links and the discs of masses are dragged.
#[test]
fn the_arm_is_edited_by_hand_and_simulated() {
    let mut window = window(demonstration(), &data::ABOUT, Theme::Dark);
    click(&mut window, "Simulate your own");
    let tip = window.get_by_label("drag the length of link 3").rect().center();
    drag(&mut window, tip, tip + egui::vec2(30.0, -5.0));
    let disc = window.get_by_label("drag the mass of link 1").rect().center();
    drag(&mut window, disc, disc - egui::vec2(0.0, 40.0));
    // The first link is drawn where it points at q = 0.
    let above = |window: &Window| {
        let end = |label: &str| window.get_by_label(label).rect().center();
        end("drag the mass of link 1") - end("drag the length of link 1")
    };
    window.get_by_role_and_label(Role::Button, "left").click_accesskit();
    window.run_steps(4);
    assert!(above(&window).x > 5.0 && above(&window).y.abs() < 1.0, "{:?}", above(&window));
    window.get_by_role_and_label(Role::SpinButton, "angle at q = 0").scroll_to_me();
    window.run_steps(4);
    enter(&mut window, "angle at q = 0", "135");
    assert!(above(&window).x > 5.0 && above(&window).y > 5.0, "it points up to the left: {:?}", above(&window));
    window.get_by_role_and_label(Role::Button, "Simulate").click_accesskit();
    settle(&mut window);
    let arm = window.state().session().recording.as_ref().unwrap().stated_arm.clone().unwrap();
    let before = Scenario::embedded().arm;
    assert!(arm.links[2].length > 1.05 * before.links[2].length, "{:?}", arm.links[2]);
    assert!(arm.links[0].mass > 1.3 * before.links[0].mass, "{:?}", arm.links[0]);
    assert_eq!(arm.links[1], before.links[1]);
    assert!((arm.posture.zero_angle - 135f64.to_radians()).abs() < 1e-9, "{:?}", arm.posture);
}

/// More than one effect is hidden, as by the command line; the seal knows them all.
#[test]
fn several_effects_are_hidden_in_one_arm() {
    let mut window = window(demonstration(), &data::ABOUT, Theme::Dark);
    click(&mut window, "Simulate your own");
    window.get_by_role_and_label(Role::Button, "Hide another effect").click_accesskit();
    window.run_steps(4);
    let choosers: Vec<_> = window.get_all_by_role_and_label(Role::ComboBox, "Hidden effect").collect();
    assert_eq!(choosers.len(), 2);
    choosers[1].click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, "viscous friction").click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, "down").click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, "Simulate").click_accesskit();
    settle(&mut window);
    window.state_mut().order(Order::run(Command::OpenSeal));
    settle(&mut window);
    let posture = window.state().session().recording.as_ref().unwrap().posture;
    assert_eq!(posture, Some(torquescope::arm::Posture::DOWN));
    let truth = window.state().session().truth.clone().unwrap();
    let hidden: Vec<&str> = truth.effects.iter().map(|hidden| hidden.effect.as_str()).collect();
    assert_eq!(hidden, ["coulomb-friction", "viscous-friction"]);
    window.get_by_label("hide no Coulomb friction (1)").click_accesskit();
    window.run_steps(4);
    assert_eq!(window.get_all_by_role_and_label(Role::ComboBox, "Hidden effect").count(), 1);
}

/// A servo moves the arm in a world of rigid bodies, where parts are hidden; it can be stopped, and the seal tells what they did.
#[test]
fn parts_are_hidden_in_a_world_of_rigid_bodies() {
    let mut window = window(demonstration(), &data::ABOUT, Theme::Dark);
    click(&mut window, "Simulate your own");
    window.get_by_role_and_label(Role::RadioButton, "rigid bodies").click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::RadioButton, "on the motors").click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, "Simulate").click_accesskit();
    window.run_steps(3);
    assert!(window.query_by_role(Role::ProgressIndicator).is_some());
    window.get_by_role_and_label(Role::Button, "Stop").click_accesskit();
    settle(&mut window);
    assert!(window.query_by_label_contains("Stopped: simulate a world of rigid bodies").is_some());
    assert_eq!(window.state().session().recording, demonstration().recording);
    for (field, number) in [("Runs", "2"), ("Seconds of each", "2")] {
        enter(&mut window, field, number);
    }
    window.get_by_role_and_label(Role::Button, "Hide another part").click_accesskit();
    window.run_steps(4);
    let choosers: Vec<_> = window.get_all_by_role_and_label(Role::ComboBox, "Hidden part").collect();
    choosers[1].click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, "payload that is picked up and put down").click_accesskit();
    window.run_steps(4);
    window.get_by_role_and_label(Role::Button, "Simulate").click_accesskit();
    settle(&mut window);
    window.state_mut().order(Order::run(Command::OpenSeal));
    settle(&mut window);
    let truth = window.state().session().truth.clone().unwrap();
    let causes: Vec<(&str, Option<usize>)> =
        truth.causes.iter().map(|cause| (cause.effect.as_str(), cause.joint)).collect();
    for (effect, joint) in
        [("rotor-inertia", Some(0)), ("motor-side-elasticity", Some(0)), ("payload-picked-up", Some(0))]
    {
        assert!(causes.contains(&(effect, joint)), "{effect}: {causes:?}");
    }
}

/// The bars of a step lead back to it.
#[test]
fn a_step_is_gone_back_to_by_its_bars() {
    let mut window = window(support::repaired(), &ladder::ABOUT, Theme::Dark);
    window.run_steps(2);
    click(&mut window, "bars of step 1");
    assert_eq!(window.state().session().ladder.len(), 1);
    click(&mut window, "Undo");
    assert_eq!(window.state().session().ladder.len(), 2);
}

#[test]
fn terms_are_edited_by_their_cards_and_undone() {
    let mut window = window(support::repaired(), &model::ABOUT, Theme::Light);
    let labels = |window: &Window| -> Vec<String> {
        let step = window.state().session().current().unwrap().clone();
        step.fitted.model.terms.iter().map(torquescope::model::Term::label).collect()
    };
    let whole = labels(&window);
    assert_eq!(whole.len(), 3);
    click(&mut window, "Switch off: Coulomb friction, joint 2");
    assert_eq!((labels(&window).len(), window.state().session().set_aside.len()), (2, 1));
    click(&mut window, "Switch on: Coulomb friction, joint 2");
    assert_eq!(labels(&window), whole);
    click(&mut window, "Move down: Coulomb friction, joint 1");
    assert_eq!(labels(&window), [&whole[0], &whole[2], &whole[1]].map(String::clone));
    click(&mut window, "Undo");
    assert_eq!(labels(&window), whole);
    click(&mut window, "Remove: Coulomb friction, joint 1");
    assert_eq!(labels(&window).len(), 2);
    assert!(window.state().session().set_aside.is_empty());
}

#[test]
fn any_command_is_found_by_its_name() {
    let mut window = window(demonstration(), &data::ABOUT, Theme::Dark);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.event(egui::Event::Text("viscous joint 3".to_owned()));
    window.run_steps(3);
    window.key_press(Key::Enter);
    settle(&mut window);
    let step = window.state().session().current().unwrap().clone();
    assert_eq!(step.name, "rigid body + viscous 3");
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    window.run_steps(3);
    window.event(egui::Event::Text("no such thing".to_owned()));
    window.run_steps(3);
    assert!(window.query_by_label_contains("No command has all these words").is_some());
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label_contains("No command has all these words").is_none());
    window.key_press(Key::F1);
    window.run_steps(3);
    assert!(window.query_by_label("Keyboard and mouse").is_some());
    click(&mut window, "Close");
    assert!(window.query_by_label("Keyboard and mouse").is_none());
}

/// Faults of the readings are no terms: nothing offers to add them.
#[test]
fn faults_of_readings_are_not_offered_as_terms() {
    let mut window = window(demonstration(), &model::ABOUT, Theme::Dark);
    for fault in ["stuck torque channel", "torque saturation"] {
        window.key_press_modifiers(Modifiers::COMMAND, Key::P);
        window.run_steps(3);
        window.event(egui::Event::Text(format!("add {fault}")));
        window.run_steps(3);
        assert!(window.query_by_label_contains("No command has all these words").is_some(), "{fault}");
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
    window.get_by_label("Effect").click();
    window.run_steps(3);
    assert!(window.query_by_label("viscous friction").is_some(), "the list is open");
    assert!(window.query_by_label("stuck torque channel").is_none());
}

#[test]
fn undo_and_redo_by_button_and_key() {
    let mut window = window(diagnosed(), &diagnose::ABOUT, Theme::Light);
    click(&mut window, "Add Coulomb friction");
    assert_eq!(window.state().session().ladder.len(), 2);
    click(&mut window, "Undo");
    assert_eq!(window.state().session().ladder.len(), 1);
    click(&mut window, "Redo");
    assert_eq!(window.state().session().ladder.len(), 2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(window.state().session().ladder.len(), 1);
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut window);
    assert_eq!(window.state().session().ladder.len(), 2);
    click(&mut window, "Remove the last step");
    assert_eq!(window.state().session().ladder.len(), 1);
}

/// Effects are planted by a job of its own, which another recording or Stop ends; a job of a minute is not waited for here.
#[test]
fn planting_effects_can_be_stopped_and_ends_with_its_recording() {
    let mut window = window(diagnosed(), &diagnose::ABOUT, Theme::Light);
    for stop in [true, false] {
        window.get_by_label("Plant effects").click();
        step_until(&mut window, "effects are planted", |window| window.query_by_label("Plant effects").is_none());
        assert!(window.state().is_busy());
        match stop {
            true => window.get_by_label("Stop").click(),
            false => window
                .state_mut()
                .order(Order::run(Command::Simulate(Box::new(Scenario { seed: 5, ..Scenario::embedded() })))),
        }
        settle(&mut window);
    }
    window.state_mut().order(Order::run(Command::Diagnose));
    settle(&mut window);
    assert!(window.query_by_label("Plant effects").is_some(), "nothing is known of the other recording");
}

#[test]
fn theme_contrast_and_size_of_text_change_and_back() {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    click(&mut window, "View");
    window.get_by_role_and_label(Role::RadioButton, "Light").click();
    settle(&mut window);
    assert_eq!(window.ctx.theme(), Theme::Light);
    window.get_by_role_and_label(Role::CheckBox, "High contrast").click();
    settle(&mut window);
    assert!(theme::is_high_contrast(&window.ctx));
    window.get_by_role_and_label(Role::CheckBox, "High contrast").click();
    settle(&mut window);
    assert!(!theme::is_high_contrast(&window.ctx));
    window.get_by_label("150 %").click();
    settle(&mut window);
    assert_eq!(window.ctx.zoom_factor(), 1.5);
    window.key_press_modifiers(Modifiers::COMMAND, Key::T);
    settle(&mut window);
    assert_eq!(window.ctx.theme(), Theme::Dark);
}

#[test]
fn stop_answers_at_once_and_changes_nothing() {
    let mut window = window(demonstration(), &data::ABOUT, Theme::Dark);
    let motion = Excitation::MultiSine {
        trajectories: 40,
        duration: 200.0,
        rate: 200.0,
        harmonics: 5,
        lowest_frequency: 0.1,
        highest_frequency: 1.0,
        max_position: 2.0,
        max_velocity: 3.5,
    };
    let slow = Command::Simulate(Box::new(Scenario { name: "slow".into(), motion, ..Scenario::embedded() }));
    window.state_mut().order(Order::run(slow.clone()));
    window.run_steps(2);
    assert!(window.state().is_busy());
    window.state_mut().order(Order::run(slow));
    window.run_steps(2);
    assert!(window.query_by_label_contains("was not started").is_some(), "a second job is refused visibly");
    window.get_by_role_and_label(Role::Button, "Stop").click();
    window.run_steps(3);
    assert!(!window.state().is_busy());
    assert!(window.query_by_label_contains("Stopped: simulate a recording").is_some());
    assert_eq!(window.state().session().recording.as_ref().unwrap().name, "three-joint demo");
}

#[test]
fn an_error_stays_until_it_is_dismissed() {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    window.get_by_role_and_label(Role::TextInput, "Path of a file").focus();
    window.step();
    window.get_by_role_and_label(Role::TextInput, "Path of a file").type_text("no/such/log.csv");
    window.run_steps(2);
    click(&mut window, "Open this file");
    assert!(window.query_by_label_contains("Could not open log.csv").is_some());
    assert!(window.query_by_label_contains("os error").is_none(), "the system's number tells people nothing");
    click(&mut window, "Compare");
    assert!(window.query_by_label_contains("Could not open log.csv").is_some(), "it survives a change of screens");
    click(&mut window, "Dismiss message 1");
    assert!(window.query_by_label_contains("Could not open log.csv").is_none());
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// The log of a pendulum with viscous friction.
fn swing() -> String {
    let mut text = "time,q1,qd1,qdd1,tau1\n".to_owned();
    for sample in 0..2000 {
        let t = f64::from(sample) * 0.01;
        let (q, qd, qdd) = (t.sin(), t.cos(), -t.sin());
        text += &format!("{t},{q},{qd},{qdd},{}\n", 0.3 * qdd + 2.0 * q.cos() + 0.2 * qd);
    }
    text
}

#[test]
fn a_dropped_file_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("swing.csv");
    std::fs::write(&path, swing()).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    window.input_mut().dropped_files.push(Arc::new(Dropped(path)));
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!((recording.joint_count(), recording.sample_count()), (1, 2000));
    // The file does not say where q = 0 points; the window asks, and reads it again.
    window.get_by_label_contains("The file does not say");
    click(&mut window, "Down");
    let posture = window.state().session().recording.as_ref().unwrap().posture;
    assert_eq!(posture, Some(torquescope::arm::Posture::DOWN));
}

#[test]
fn a_mystery_is_drawn() {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    click(&mut window, "Draw a mystery");
    assert_eq!(window.state().session().recording.as_ref().unwrap().name, "mystery 7");
    window.get_by_role_and_label(Role::ComboBox, "Level").click();
    window.run_steps(3);
    click(&mut window, "easy");
    click(&mut window, "Draw a mystery");
    assert_eq!(window.state().session().recording.as_ref().unwrap().name, "mystery 8 (easy)");
}

/// Types a number into a field, as a user would: Tab to it, type, Enter.
fn enter(window: &mut Window, field: &str, number: &str) {
    window.get_by_role_and_label(Role::SpinButton, field).focus();
    window.run_steps(2);
    window.event(egui::Event::Text(number.to_owned()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
}

fn is_enabled(window: &Window, button: &str) -> bool {
    !window.get_by_role_and_label(Role::Button, button).accesskit_node().is_disabled()
}

/// Steps until the running training has an epoch.
fn wait_for_an_epoch(window: &mut Window) {
    step_until(window, "an epoch is done", |window| window.query_by_label("samples/s").is_some());
}

#[test]
fn networks_are_trained_by_clicks() {
    let session = Session { plan: short_plan(50), ..small() };
    let mut window = window(session, &train::ABOUT, Theme::Dark);
    assert!(window.query_by_label_contains("solved for at once, not trained").is_some());
    window.get_by_role_and_label(Role::RadioButton, "structured DeLaN").click();
    window.run_steps(2);
    assert!(!is_enabled(&window, "Train on"), "there is nothing to go on from");
    enter(&mut window, "Epochs", "0");
    assert!(window.query_by_label_contains("the number of epochs is 0, but must be at least 1").is_some());
    assert!(!is_enabled(&window, "Start training"));
    enter(&mut window, "Epochs", "3");
    click(&mut window, "Start training");
    assert!(
        window.query_by_label("plot of errors").is_some() && window.query_by_label("plot of learning rate").is_some()
    );
    assert!(window.query_by_label_contains("All 3 epochs are done").is_some());
    let first = window.state().session().current().unwrap().clone();
    assert_eq!(first.history.len(), 3);
    click(&mut window, "Train on");
    let second = window.state().session().current().unwrap().clone();
    assert!(second.history[0].loss < 0.5 * first.history[0].loss, "it begins where the first run ended");
    assert_eq!(window.state().session().ladder.len(), 1);
    click(&mut window, "Undo");
    click(&mut window, "Undo");
    assert!(!window.state().session().current().unwrap().fitted.model.is_learned());
    assert!(window.query_by_label_contains("It is the current model").is_some(), "the panel follows");
}

#[test]
fn a_long_training_is_paused_thrown_away_and_kept() {
    let mut window = window(Session { plan: short_plan(1_000_000), ..small() }, &train::ABOUT, Theme::Light);
    window.get_by_role_and_label(Role::RadioButton, "FF-NN").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Start training").click();
    wait_for_an_epoch(&mut window);
    assert!(!is_enabled(&window, "Start training"));
    window.get_by_role_and_label(Role::Button, "Pause").click();
    window.run_steps(3);
    assert!(window.query_by_label("Paused").is_some());
    window.get_by_role_and_label(Role::Button, "Throw away").click();
    settle(&mut window);
    assert!(!window.state().session().current().unwrap().fitted.model.is_learned());
    window.get_by_role_and_label(Role::Button, "Start training").click();
    window.run_steps(2);
    wait_for_an_epoch(&mut window);
    window.get_by_role_and_label(Role::Button, "Stop and keep the best").click();
    settle(&mut window);
    let step = window.state().session().current().unwrap().clone();
    assert!(step.fitted.model.is_learned() && !step.history.is_empty() && step.history.len() < 1_000_000);
    assert!(window.query_by_label_contains("because you asked for it").is_some());
}

/// A stopped training goes on, and any training of the list can become the model again.
#[test]
fn trainings_are_resumed_and_chosen_from() {
    let mut window = window(Session { plan: short_plan(40), ..small() }, &train::ABOUT, Theme::Dark);
    window.get_by_role_and_label(Role::RadioButton, "structured DeLaN").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Start training").click();
    wait_for_an_epoch(&mut window);
    window.get_by_role_and_label(Role::Button, "Stop and keep the best").click();
    settle(&mut window);
    let epochs = |window: &Window| window.state().session().current().unwrap().history.len();
    let first = epochs(&window);
    assert!((1..40).contains(&first));
    click(&mut window, "Resume");
    assert_eq!(epochs(&window), 40);
    assert!(window.query_by_role_and_label(Role::Button, "Resume").is_none(), "it is at its end");
    click(&mut window, "Models (3)");
    click(&mut window, "Use structured DeLaN");
    assert_eq!(epochs(&window), first);
    assert_eq!(models::names(&window), ["rigid body", "structured DeLaN", "structured DeLaN (2)"]);
}

/// A trained model is diagnosed as any other.
#[test]
fn a_trained_model_leads_to_a_diagnosis() {
    let mut window = window(trained(), &ladder::ABOUT, Theme::Dark);
    click(&mut window, "Diagnose again");
    assert_eq!(window.state().screen(), &diagnose::ABOUT);
    if window.state().session().report.is_none() {
        click(&mut window, "Diagnose");
    }
    assert!(window.state().session().report.is_some());
    assert!(window.state().session().current().unwrap().fitted.model.is_learned());
}

/// An experiment runs in the window as it does on the command line: Stop keeps what is done, Run goes on.
#[test]
fn an_experiment_is_run_stopped_and_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("arm.toml");
    let shown = || Shown {
        experiment: file.to_string_lossy().into_owned(),
        results: folder.path().to_string_lossy().into_owned(),
        quick: false,
        data: String::new(),
    };
    std::fs::write(&file, support::EXPERIMENT).unwrap();
    let mut window = window(Session::default(), &experiment::ABOUT, Theme::Light);
    window.state_mut().order(Order::Experiment(shown()));
    settle(&mut window);
    assert!(window.query_by_label("Cells: 0 of 6 are done").is_some());
    click(&mut window, "Run");
    assert!(window.query_by_label("Cells: 6 of 6 are done").is_some());
    assert!(window.query_by_label("6 cells done, 0 were there before.").is_some());
    assert!(window.query_by_label("plot of nMSE of the torque, logarithmic").is_some());
    assert!(window.state().session().recording.is_none(), "the session is not touched");

    // A network that learns for ever is stopped; the cells before it stay.
    let endless = "[[model]]\nname = \"network\"\npreset = \"ff-nn\"\ntraining = { epochs = 1000000, batch = 100 }\n\n";
    std::fs::write(&file, support::EXPERIMENT.replacen("[[test]]", &format!("{endless}[[test]]"), 1)).unwrap();
    click(&mut window, "Look again");
    assert!(window.query_by_label("Cells: 6 of 9 are done").is_some());
    window.get_by_role_and_label(Role::Button, "Run").click();
    step_until(&mut window, "something is trained", |window| {
        window.query_all_by_label_contains("epoch").next().is_some()
    });
    assert!(is_enabled(&window, "Stop the run"));
    // It is told on every screen, and can be stopped there.
    window.state_mut().order(Order::Show(&data::ABOUT));
    window.run_steps(3);
    assert!(window.query_by_label_contains("experiment: cell").is_some());
    assert!(window.query_by_label("ready").is_none());
    window.get_by_role_and_label(Role::Button, "Stop").click();
    settle(&mut window);
    assert!(window.query_by_label("ready").is_some());
    window.state_mut().order(Order::Show(&experiment::ABOUT));
    settle(&mut window);
    assert!(window.query_by_label_contains("Stopped. Cells that are done stay").is_some());
    assert!(window.query_by_label("Cells: 6 of 9 are done").is_some());

    std::fs::write(&file, "title = 1").unwrap();
    click(&mut window, "Look again");
    assert!(window.query_by_label_contains("invalid type: integer `1`, expected a string").is_some());
}

#[test]
fn empty_screens_offer_a_way_on() {
    // Experiments have data of their own, so their screen is never empty.
    for screen in screens::all().filter(|screen| **screen != experiment::ABOUT) {
        let mut window = window(Session::default(), screen, Theme::Dark);
        click(&mut window, "Simulate the demonstration arm");
        assert!(window.state().session().current().is_some(), "{}", screen.id);
    }
}

/// The cursor follows a drag in a chart and the arrow keys, in all charts at once.
#[test]
fn the_time_cursor_moves_by_drag_and_key() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    let shown = |window: &Window| {
        let slider = window.get_by_role_and_label(Role::Slider, "time cursor");
        slider.accesskit_node().numeric_value().unwrap()
    };
    let first = shown(&window);
    let chart = window.get_by_label("plot of joint 1: torque [N m]").rect();
    window.drag_at(chart.center());
    window.run_steps(2);
    window.drop_at(chart.center() + egui::vec2(150.0, 0.0));
    window.run_steps(3);
    let dragged = shown(&window);
    assert!(dragged > first + 0.5, "{first} -> {dragged}");
    window.get_by_label("plot of joint 1: torque [N m]").focus();
    window.run_steps(2);
    window.key_press(Key::ArrowRight);
    window.run_steps(3);
    let stepped = shown(&window);
    assert!(stepped > dragged && stepped < dragged + 0.2, "{dragged} -> {stepped}");
}

/// A region that is marked in one view is lit in the others and on the time line; the list of worst moments moves the cursor.
#[test]
fn a_marked_region_is_lit_and_a_worst_moment_is_jumped_to() {
    let mut window = window(demonstration(), &residuals::ABOUT, Theme::Dark);
    let chart = window.get_by_label("plot of residual against velocity [N m]").rect();
    let at = |x: f32, y: f32| chart.center() + egui::vec2(x * chart.width(), y * chart.height());
    window.drag_at(at(-0.3, -0.4));
    window.step();
    window.hover_at(at(-0.05, 0.4));
    window.run_steps(2);
    window.drop_at(at(-0.05, 0.4));
    window.run_steps(3);
    assert!(window.query_by_label_contains("samples marked").is_some(), "the time line says how many");
    click(&mut window, "Unmark");
    assert!(window.query_by_label_contains("samples marked").is_none());
    click(&mut window, "worst moment 3");
    let step = window.state().session().current().unwrap().clone();
    click(&mut window, "See it in Compare");
    assert_eq!(window.state().screen(), &compare::ABOUT);
    let time = window.get_by_role_and_label(Role::Slider, "time cursor").accesskit_node().numeric_value().unwrap();
    let recording = window.state().session().recording.clone().unwrap();
    let sizes = |run: usize| {
        let sample = (time * 100.0).round() as usize;
        (recording.trajectories[run].tau[0][sample] - step.evaluation.predictions[run].total[0][sample]).abs()
    };
    assert!([4, 9].into_iter().any(|run| sizes(run) > 3.3), "the cursor is at a large residual: {time}");
}

/// In lesson mode the answer is hidden until a guess is locked in.
#[test]
fn one_bets_before_the_answer() {
    let mut window = window(demonstration(), &diagnose::ABOUT, Theme::Light);
    window.get_by_role(Role::CheckBox).click();
    settle(&mut window);
    click(&mut window, "Diagnose");
    assert!(window.query_by_label_contains("The model lacks").is_none());
    assert!(window.query_by_label("place your bet").is_some());
    click(&mut window, "Viscous friction");
    assert!(window.query_by_label_contains("The model lacks Coulomb friction").is_some());
    assert!(window.query_by_label("not what the data say").is_some());
}

/// Two cursors measure a stretch.
#[test]
fn alt_and_drag_measure() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    let chart = window.get_by_label("plot of joint 1: torque [N m]").rect();
    let before = window.render().unwrap();
    window.event(egui::Event::ModifiersChanged(Modifiers::ALT));
    window.drag_at(chart.center() - egui::vec2(100.0, 0.0));
    window.step();
    window.hover_at(chart.center() + egui::vec2(100.0, 0.0));
    window.run_steps(2);
    window.drop_at(chart.center() + egui::vec2(100.0, 0.0));
    window.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    window.run_steps(3);
    let after = window.render().unwrap();
    let changed = before.pixels().zip(after.pixels()).filter(|(one, other)| one != other).count();
    assert!(changed > 30_000, "the stretch is shaded in every linked chart: {changed}");
}

#[test]
fn errors_are_sorted_by_a_click_and_models_overlaid() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    let sort = |window: &mut Window| click(window, "sort by the error of joint 2");
    click(&mut window, "Errors by trajectory");
    sort(&mut window);
    let runs = |window: &Window| -> Vec<f32> {
        ["run 1", "run 5", "run 9"].map(|name| window.get_by_role_and_label(Role::Button, name).rect().top()).to_vec()
    };
    let down = runs(&window);
    sort(&mut window);
    let up = runs(&window);
    assert!((0..3).any(|run| (down[run] - up[run]).abs() > 20.0), "{down:?} {up:?}");
}

/// Thousands of random clicks, drags, keys and drops find no panic, and there is still a recording.
#[test]
fn a_monkey_breaks_nothing() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut window = window(diagnosed(), &data::ABOUT, Theme::Dark);
    // An experiment that it begins writes where nobody looks.
    let results = tempfile::tempdir().unwrap();
    let shown = Shown { results: results.path().to_str().unwrap().to_owned(), ..Shown::default() };
    window.state_mut().order(Order::Experiment(shown));
    window.state_mut().order(Order::Show(&data::ABOUT));
    window.run_steps(2);
    let keys = [Key::Tab, Key::Enter, Key::ArrowRight, Key::ArrowLeft, Key::Space, Key::Escape, Key::Z, Key::Y, Key::E];
    let folder = tempfile::tempdir().unwrap();
    let files = [("good.csv", swing()), ("bad.csv", "q1,tau1\n1,what\n".to_owned())].map(|(name, text)| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    });
    for _ in 0..2000 {
        // What the last event opened is drawn before anything else happens to it; the export dialog takes two frames.
        window.run_steps(2);
        if window.query_by_label("Write the file").is_some() {
            // It must not leave files where the test runs.
            window.key_press(Key::Escape);
            window.run_steps(2);
            assert!(window.query_by_label("Write the file").is_none(), "Escape closes the dialog");
        }
        let at = egui::pos2(random.random_range(0.0..support::SIZE[0]), random.random_range(0.0..support::SIZE[1]));
        match random.random_range(0..10) {
            0 => window.key_press_modifiers(Modifiers::COMMAND, keys[random.random_range(6..keys.len())]),
            1 => window.key_press(keys[random.random_range(0..6)]),
            2 => {
                let screen = screens::TABLE[random.random_range(0..screens::TABLE.len())].about;
                window.get_by_role_and_label(Role::Button, screen.title).click();
            }
            3 => {
                window.drag_at(at);
                window.step();
                window.drop_at(at + egui::vec2(random.random_range(-200.0..200.0), 0.0));
            }
            4 if random.random_range(0..20) == 0 => {
                let path = files[random.random_range(0..files.len())].clone();
                window.input_mut().dropped_files.push(Arc::new(Dropped(path)));
            }
            // The file dialog is the system's, not ours to click.
            _ if at.y < 34.0 && at.x < 340.0 => continue,
            4 => window.key_press_modifiers(Modifiers::COMMAND, Key::P),
            5 => window.event(egui::Event::Text("a3 e".chars().skip(random.random_range(0..3)).take(1).collect())),
            _ => {
                window.drag_at(at);
                window.drop_at(at);
            }
        }
        window.step();
        if window.state().session().recording.is_none() {
            // It began anew: undo brings back what was there.
            window.state_mut().order(Order::Undo);
            window.run_steps(2);
        }
        assert!(window.state().session().recording.is_some());
    }
    // What it began may take hours: a training, and beside it an experiment.
    for _ in 0..3 {
        window.state_mut().order(Order::Stop);
        window.run_steps(2);
    }
    settle(&mut window);
}
