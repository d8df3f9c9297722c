//! A control that changes what is computed clears what no longer belongs to it.

use super::*;
use torquescope::app::Shown;
use torquescope::simulation::extrapolation::Stretch;

fn is_there(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

/// Curves over speed are none over range, nor are their numbers.
#[test]
fn what_was_computed_over_speed_is_not_shown_over_range() {
    let mut window = window(support::extrapolated(), &extrapolation::ABOUT, Theme::Light);
    let is_shown =
        |window: &Window| is_there(window, "Error over speed") || is_there(window, "Error (nMSE) of all joints");
    assert!(is_shown(&window));
    let printed = window.state_mut().figure().panels.len();
    window.get_by_role_and_label(Role::RadioButton, "Wider").click();
    settle(&mut window);
    assert!(!is_shown(&window) && is_there(&window, "Nothing was computed yet over range"));
    assert!(!is_there(&window, "goes from an error"));
    assert_eq!(window.state_mut().figure().panels.len(), printed - 1, "nor is it printed");
    window.get_by_role_and_label(Role::RadioButton, "Faster").click();
    settle(&mut window);
    assert!(is_shown(&window), "it was not thrown away");
    let sweep = window.state().session().sweep.clone().unwrap();
    assert_eq!(sweep.stretch, Stretch::Speed);
}

/// The curve of a model goes with it.
#[test]
fn a_deleted_model_has_no_curve() {
    let mut window = window(support::extrapolated(), &extrapolation::ABOUT, Theme::Light);
    let names = |window: &Window| -> Vec<String> {
        let sweep = window.state().session().sweep.clone().unwrap();
        sweep.curves.iter().map(|curve| curve.model.clone()).collect()
    };
    assert_eq!(names(&window).len(), 2);
    window.state_mut().order(Order::run(Command::GoTo { step: 0 }));
    settle(&mut window);
    let deleted = "rigid body + Coulomb 1, 2";
    window.state_mut().order(Order::run(Command::Delete { name: deleted.into() }));
    settle(&mut window);
    assert_eq!(names(&window), ["rigid body"]);
}

/// What failed with another experiment is not said of this one.
#[test]
fn what_was_said_of_another_experiment_is_gone() {
    let mut window = window(Session::default(), &experiment::ABOUT, Theme::Light);
    let shown = |name: &str| Shown { experiment: name.to_owned(), ..Shown::default() };
    window.state_mut().order(Order::Experiment(shown("no/such/experiment.toml")));
    settle(&mut window);
    assert!(is_there(&window, "no/such/experiment.toml"));
    let problem = "can't be read";
    let said = |window: &Window| is_there(window, problem) || is_there(window, "No such file");
    assert!(said(&window));
    window.state_mut().order(Order::Experiment(support::experiment()));
    settle(&mut window);
    assert!(!said(&window));
}

/// A report was made among the effects that were known then.
#[test]
fn a_report_ends_with_a_new_effect_of_ones_own() {
    let mut window = window(diagnosed(), &diagnose::ABOUT, Theme::Light);
    assert!(window.state().session().report.is_some());
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/plate_drag.toml");
    window.state_mut().order(Order::open(vec![path]));
    settle(&mut window);
    assert!(window.state().session().report.is_none() && is_there(&window, "What does the model lack?"));
    click(&mut window, "Undo");
    assert!(window.state().session().report.is_some());
}
