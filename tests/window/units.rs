//! A joint that slides is spoken of in N, m and m/s, one that turns in N m, rad and rad/s, also on the same arm.

use super::*;

/// The log of a joint that turns and one that slides.
fn mixed() -> String {
    let mut text = "time [s],q1 [rad],q2 [m],tau1 [N m],tau2 [N]\n".to_owned();
    for sample in 0..3000 {
        let t = f64::from(sample) * 0.01;
        let (turn, slide) = (t.sin() + 0.3 * (2.3 * t).sin(), 0.4 * (1.3 * t).cos());
        let (load, force) = (2.0 * turn.cos() - 0.3 * t.sin(), -3.0 * slide + 0.4 * (1.3 * t).sin());
        text += &format!("{t},{turn},{slide},{load},{force}\n");
    }
    text
}

/// Every name of a control, plot or text that speaks of a unit.
fn spoken(window: &Window) -> Vec<String> {
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    nodes.filter_map(|node| node.label().or_else(|| node.value())).collect()
}

#[test]
fn a_joint_that_slides_has_its_own_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mixed.csv");
    std::fs::write(&path, mixed()).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    window.state_mut().order(Order::open(vec![path]));
    settle(&mut window);
    let of_joint = |window: &mut Window, joint: usize| {
        click(window, &format!("joint {joint}"));
        spoken(window).into_iter().filter(|text| text.starts_with("plot of")).collect::<Vec<String>>().join("; ")
    };
    let turns = of_joint(&mut window, 1);
    for unit in ["position q [rad]", "velocity q̇ [rad/s]", "acceleration q̈ [rad/s²]", "torque τ [N m]"] {
        assert!(turns.contains(unit), "{unit}: {turns}");
    }
    let slides = of_joint(&mut window, 2);
    for unit in ["position q [m]", "velocity q̇ [m/s]", "acceleration q̈ [m/s²]", "force τ [N]"] {
        assert!(slides.contains(unit), "{unit}: {slides}");
    }
}

/// Also in every plot and sentence about its model.
#[test]
fn a_model_of_a_sliding_joint_is_in_its_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("slide.csv");
    let columns: Vec<String> =
        mixed().lines().map(|line| line.split(',').step_by(2).collect::<Vec<_>>().join(",")).collect();
    std::fs::write(&path, columns.join("\n").replace("q2", "q1").replace("tau2", "tau1")).unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    window.state_mut().order(Order::open(vec![path]));
    settle(&mut window);
    assert!(window.state().session().current().is_some(), "a model was fitted");
    for command in [Command::Diagnose, Command::AddEffect { effect: "viscous-friction".to_owned(), joints: vec![0] }] {
        window.state_mut().order(Order::run(command));
        settle(&mut window);
    }
    assert_eq!(window.state().session().ladder.len(), 2);
    for screen in screens::all().filter(|screen| **screen != experiment::ABOUT) {
        window.state_mut().order(Order::Show(screen));
        settle(&mut window);
        let texts = spoken(&window);
        let plot_of_torque = |text: &&String| text.starts_with("plot of") && text.contains("torque");
        assert_eq!(texts.iter().find(plot_of_torque), None, "{}: what slides is moved by a force", screen.id);
        assert!(!texts.iter().any(|text| text.contains("point at q = 0")), "what slides points nowhere");
        let wrong = |text: &&String| ["N m", "rad"].iter().any(|unit| text.contains(unit));
        assert_eq!(texts.iter().find(wrong), None, "{}", screen.id);
    }
}
