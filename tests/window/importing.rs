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
