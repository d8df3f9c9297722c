//! How one begins: three cards on the first screen, and another recording beside the one that is there.

use torquescope::progress::Monitor;
use torquescope::recording::gallery;
use torquescope::recording::write::to_npz_bytes;
use torquescope::simulation::simulate;

use super::*;

/// The arm and its effect, a log, the lessons; with a recording they are gone.
#[test]
fn three_cards_lead_to_a_mystery_a_log_and_the_lessons() {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    let tops =
        ["Find what hides in this arm", "Open your log", "Learn"].map(|title| window.get_by_label(title).rect().top());
    assert!(tops.iter().all(|top| (top - tops[0]).abs() < 1.0), "they stand side by side: {tops:?}");
    assert!(window.query_by_role_and_label(Role::Image, "the arm of the demonstration").is_some());
    assert!(is_enabled(&window, "Open a log…"));
    click(&mut window, "Choose a lesson");
    assert!(window.query_by_label("Begin lesson 1").is_some());
    click(&mut window, "Close");
    click(&mut window, "Another effect, drawn by chance");
    assert_eq!(window.state().session().recording.as_ref().unwrap().name, "mystery 7");
    assert!(window.query_by_label("Open your log").is_none());
}

/// The name of the program, or a button beside the path of a file, leads back to where one begins; undo brings back what was there.
#[test]
fn one_can_begin_anew_from_anywhere() {
    let mut window = window(support::repaired(), &compare::ABOUT, Theme::Dark);
    let name = window.state().session().recording.as_ref().unwrap().name.clone();
    click(&mut window, "Torquescope");
    assert!(window.state().session().recording.is_none() && window.query_by_label("Open your log").is_some());
    click(&mut window, "Undo");
    assert_eq!(window.state().session().recording.as_ref().unwrap().name, name);
    window.state_mut().order(Order::Show(&data::ABOUT));
    settle(&mut window);
    click(&mut window, "Recordings to try…");
    click(&mut window, gallery::all()[0].told.title.as_str());
    assert!(window.state().session().recording.is_some());
}

/// One trains on one recording and looks at another: both are drawn in one plot, and no model is fitted to the other.
#[test]
fn another_recording_is_looked_at_beside_the_one_that_was_trained_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.npz");
    let motion = Excitation::PaperPointToPoint { trajectories: 4, duration: 3.0, samples: 90, range: 1.0 };
    let other = Scenario { motion, seed: 3, ..Scenario::embedded() };
    std::fs::write(&path, to_npz_bytes(&simulate(&other, &Monitor::new()).unwrap()).unwrap()).unwrap();
    let mut window = window(support::repaired(), &data::ABOUT, Theme::Light);
    let model = window.state().session().current().unwrap().fitted.clone();
    let runs = |window: &Window| window.state().session().recording.as_ref().unwrap().trajectories.len();
    let before = runs(&window);
    window.get_by_role_and_label(Role::TextInput, "Path of a file").focus();
    window.run_steps(2);
    window.event(egui::Event::Text(path.display().to_string()));
    window.run_steps(2);
    click(&mut window, "Look at it beside");
    assert_eq!(runs(&window), before + 4);
    assert_eq!(window.state().session().current().unwrap().fitted, model, "it is held against it, not fitted to it");
    window.state_mut().order(Order::Show(&compare::ABOUT));
    settle(&mut window);
    let names = |window: &mut Window, title: &str| -> Vec<String> {
        let panels = window.state_mut().figure().panels;
        let panel = panels.iter().find(|panel| panel.title == title).unwrap();
        panel.legend().iter().map(|entry| entry.name.to_owned()).collect()
    };
    let torques = names(&mut window, "joint 1: torque");
    assert_eq!(torques.len(), 4, "measured and predicted, of both: {torques:?}");
    assert!(torques.iter().filter(|name| name.starts_with("measured τ")).count() == 2, "{torques:?}");
    assert_eq!(names(&mut window, "joint 1: residual").len(), 2);
    window.get_by_role_and_label(Role::ComboBox, "over it").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "none").click();
    settle(&mut window);
    assert_eq!(names(&mut window, "joint 1: torque"), ["measured τ", "predicted τ̂"]);
    click(&mut window, "Undo");
    assert_eq!(runs(&window), before);
}

/// The gallery stands below the ways to begin; a card opens its recording, whose story is then told.
#[test]
fn a_card_of_the_gallery_opens_a_recording_with_its_story() {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    for sample in gallery::all() {
        assert!(is_enabled(&window, &sample.told.title), "{}", sample.name);
    }
    let sample = &gallery::all()[2];
    window.get_by_role_and_label(Role::Button, &sample.told.title).click_accesskit();
    settle(&mut window);
    let recording = window.state().session().recording.clone().unwrap();
    assert_eq!((recording.name.as_str(), recording.seal.is_some()), (sample.told.title.as_str(), true));
    assert!(window.query_by_label("The story").is_some() && window.query_by_label(&sample.told.story).is_some());
    assert!(window.query_by_label("Recordings to try").is_none());
}
