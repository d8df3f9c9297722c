//! The window while something is at work: what it is, how far it is, why other things have to wait, and Stop.

use super::*;

/// A simulation that goes on until somebody stops it.
pub(crate) fn endless() -> Command {
    let motion = Excitation::MultiSine {
        trajectories: 400,
        duration: 200.0,
        rate: 200.0,
        harmonics: 5,
        lowest_frequency: 0.1,
        highest_frequency: 1.0,
        max_position: 2.0,
        max_velocity: 3.5,
    };
    Command::Simulate(Box::new(Scenario { name: "slow".into(), motion, ..Scenario::embedded() }))
}

/// The window with something at work that does not end by itself.
pub(crate) fn busy(screen: &'static About, theme: Theme) -> Window {
    let mut window = window(diagnosed(), screen, theme);
    window.state_mut().order(Order::run(endless()));
    window.run_steps(4);
    window
}

/// On every screen one sees what is at work, and can stop it.
#[test]
fn what_is_at_work_is_told_on_every_screen_and_can_be_stopped() {
    let mut window = busy(&data::ABOUT, Theme::Dark);
    for screen in screens::all() {
        window.state_mut().order(Order::Show(screen));
        window.run_steps(3);
        assert!(window.query_by_label_contains("simulate a recording").is_some(), "{}", screen.id);
        assert!(window.query_by_role(Role::ProgressIndicator).is_some(), "{}", screen.id);
        assert!(window.query_by_label("ready").is_none(), "{}", screen.id);
        assert!(is_enabled(&window, "Stop"), "{}", screen.id);
        assert!(!is_enabled(&window, "Undo"), "{}: undo has to wait", screen.id);
    }
    window.get_by_role_and_label(Role::Button, "Stop").click();
    settle(&mut window);
    assert!(window.query_by_label_contains("Stopped: simulate a recording, because you pressed Stop").is_some());
    assert!(window.query_by_label("ready").is_some());
}
