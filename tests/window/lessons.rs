//! Lessons, taken by hand: the list, the panel, what is entered, locked, revealed and graded.

use torquescope::lesson::grade::{Grade, verified};
use torquescope::lesson::right_answer;
use torquescope::recording::seal::Truth;
use torquescope::session::study::Answer;

use super::*;

/// Begins a lesson from the list.
fn begin(number: usize) -> Window {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    click(&mut window, "Lessons");
    click(&mut window, &format!("Begin lesson {number}"));
    window
}

/// Clicks one of the answers, and the button that gives it.
fn answer(window: &mut Window, name: &str, button: &str) {
    window.get_by_role_and_label(Role::RadioButton, name).scroll_to_me();
    window.run_steps(3);
    window.get_by_role_and_label(Role::RadioButton, name).click();
    window.run_steps(2);
    click(window, button);
}

fn go_on(window: &mut Window) {
    click(window, "Go on →");
}

fn is_there(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

fn grade(window: &Window) -> Grade {
    verified(window.state().session()).unwrap()
}

/// What was hidden, as only a test may look at it.
fn truth(window: &Window) -> Truth {
    run(Command::OpenSeal, &Session { study: None, ..window.state().session().clone() }).truth.unwrap().as_ref().clone()
}

/// Adds what is hidden, as the diagnosis offers it or by name.
fn repair(window: &mut Window) {
    for hidden in truth(window).effects {
        let add = Command::AddEffect { effect: hidden.effect, joints: hidden.joint.into_iter().collect() };
        window.state_mut().order(Order::run(add));
        settle(window);
    }
}

/// The name of what is right, as it stands in the panel.
fn right(window: &Window) -> String {
    let Answer::Choice(option) = right_answer(window.state().session()).unwrap() else { panic!("it is no choice") };
    let name =
        torquescope::effect::registry::find(&option).map_or(format!("joint {option}"), |effect| effect.name.to_owned());
    name[..1].to_uppercase() + &name[1..]
}

#[test]
fn a_hidden_effect_is_found_in_a_lesson() {
    let mut window = begin(6);
    assert!(window.state().session().recording.is_some() && window.state().screen() == &compare::ABOUT);
    assert!(is_there(&window, "Lesson 6: Find the hidden effect") && is_there(&window, "Step 1 of 10"));
    go_on(&mut window);
    assert_eq!(window.state().screen(), &residuals::ABOUT);
    // Nothing tells the answer before the bet is placed.
    window.state_mut().order(Order::run(Command::Diagnose));
    settle(&mut window);
    assert!(is_there(&window, "the lesson keeps the diagnosis locked") && window.state().session().report.is_none());
    for _ in 0..2 {
        let name = right(&window);
        answer(&mut window, &name, "Lock it in");
        assert!(is_there(&window, "Locked in: "));
        let entries = window.state().session().study.as_ref().unwrap().journal().len();
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut window);
        window.key_press_modifiers(Modifiers::COMMAND, Key::Y);
        settle(&mut window);
        let study = window.state().session().study.clone().unwrap();
        assert_eq!(study.journal().len(), entries, "undo does not take it back");
        go_on(&mut window);
    }
    click(&mut window, "Check");
    assert!(is_there(&window, "Not yet: the model lacks what is hidden"));
    repair(&mut window);
    click(&mut window, "Check");
    assert!(is_there(&window, "✔ That is right."));
    go_on(&mut window);
    click(&mut window, "Reveal");
    assert!(is_there(&window, "You said: ") && is_there(&window, "It is: "));
    go_on(&mut window);
    click(&mut window, "Open the seal");
    click(&mut window, "Open it");
    click(&mut window, "Check");
    go_on(&mut window);
    answer(&mut window, "The torque sensor is too noisy", "Check");
    assert!(is_there(&window, "Not yet."));
    answer(&mut window, "No choice of masses and lengths gives a torque of that shape", "Check");
    go_on(&mut window);
    let name = right(&window);
    answer(&mut window, &name, "Lock it in");
    go_on(&mut window);
    repair(&mut window);
    click(&mut window, "Check");
    go_on(&mut window);
    click(&mut window, "Reveal");
    assert!(is_there(&window, "the lesson is done") && is_there(&window, "What it was worth"));
    let grade = grade(&window);
    assert!(grade.passed && grade.tampered.is_none() && grade.tries == 6, "{grade:?}");
    // The wrong answer halved the two points of its step.
    let why = grade.steps.iter().find(|step| step.step == "why").unwrap();
    assert_eq!((why.points, why.tries), (1.0, 2));
}

/// Types into a field of numbers.
fn enter(window: &mut Window, name: &str, value: &str) {
    window.get_by_role_and_label(Role::SpinButton, name).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(value.to_owned()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
}

#[test]
fn torque_is_taken_apart_by_hand() {
    let mut window = begin(1);
    assert!(is_there(&window, "gravity torque of joint 1: ") && is_there(&window, "the arm that you pose"));
    let bar = |window: &Window, name: &str| {
        let label = window.get_by_label_contains(name).accesskit_node().label().unwrap();
        label.trim_start_matches(name).trim_end_matches(" N m").replace('−', "-").parse::<f64>().unwrap()
    };
    let before = bar(&window, "gravity torque of joint 1: ");
    let tip = window.get_by_label("turn joint 1").rect().center();
    drag(&mut window, tip, tip + egui::vec2(30.0, 20.0));
    assert_ne!(bar(&window, "gravity torque of joint 1: "), before, "the arm is dragged");
    go_on(&mut window);
    answer(&mut window, "Twice as large", "Lock it in");
    go_on(&mut window);
    answer(&mut window, "Gravity torque, g(q)", "Lock it in");
    go_on(&mut window);
    click(&mut window, "Check");
    assert!(is_there(&window, "Not yet: gravity makes"));
    for (joint, angle) in ["1.2", "-1.2", "0"].into_iter().enumerate() {
        enter(&mut window, &format!("position of joint {}", joint + 1), angle);
    }
    click(&mut window, "Check");
    assert!(is_there(&window, "✔ That is right."));
    go_on(&mut window);
    for (name, value) in [
        ("position of joint 1", "0"),
        ("position of joint 2", "1.5"),
        ("speed of joint 1", "2.5"),
        ("speed of joint 2", "2.5"),
    ] {
        enter(&mut window, name, value);
    }
    let slow = bar(&window, "Coriolis torque of joint 1: ");
    click(&mut window, "Double all speeds");
    let fast = bar(&window, "Coriolis torque of joint 1: ");
    assert!((fast / slow - 4.0).abs() < 0.05, "{slow} -> {fast}");
    click(&mut window, "Check");
    go_on(&mut window);
    click(&mut window, "Reveal");
    assert!(is_there(&window, "It is: four times as large."));
    go_on(&mut window);
    window.get_by_role_and_label(Role::TextInput, "Your number").focus();
    window.run_steps(2);
    window.event(egui::Event::Text("9".to_owned()));
    window.run_steps(2);
    click(&mut window, "Check");
    go_on(&mut window);
    answer(&mut window, "Not zero, in general", "Lock it in");
    go_on(&mut window);
    enter(&mut window, "acceleration of joint 2", "20");
    click(&mut window, "Check");
    go_on(&mut window);
    answer(&mut window, "Those off its diagonal, H₁₂ and H₁₃", "Check");
    go_on(&mut window);
    click(&mut window, "Reveal");
    let grade = grade(&window);
    assert!(grade.passed && grade.finished, "{grade:?}");
    let double = grade.steps.iter().find(|step| step.step == "double").unwrap();
    assert!(double.points < double.most, "what was predicted wrongly costs");
    click(&mut window, "Hide the lesson");
    assert!(!is_there(&window, "Step 11 of 11"));
    click(&mut window, "Lessons");
    assert!(is_there(&window, "Step 11 of 11"));
}
