//! The import assistant: a log whose columns nobody can guess is opened all the same, and its template is what the command line takes.

use torquescope::recording::mapping::MappingSpec;
use torquescope::recording::torque::TorqueFact;

use super::*;

/// A swing of one joint, under names that say nothing; the angle in degrees, the torque with the other sign.
fn nameless() -> String {
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
        window.state_mut().order(Order::Import(path.to_owned(), Box::default()));
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
