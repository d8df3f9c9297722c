//! Pictures of every screen, light and dark, beside those that somebody has looked at.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test --test snapshots` draws them anew: look at what changed before you commit it.

#![allow(clippy::unwrap_used)] // a test fails where something is not as it should be

mod support;

use egui::Theme;
use egui_kittest::{SnapshotOptions, SnapshotResults};
use support::{demonstration, diagnosed, experiment, extrapolated, repaired, run, settle, trained, window};
use torquescope::app::{Order, Screen};
use torquescope::session::{Command, Session};

/// Pixels that may differ. Everything is drawn on the CPU in the same way, but `sin` and `cos` of the system may differ in
/// the last bit, and the fitted model with them: a point may move to the next pixel. A control that moves, or a line of
/// text that changes, is far more than this.
const STRAY_PIXELS: usize = 60;

#[test]
fn every_screen_looks_as_it_did() {
    let opened = run(Command::OpenSeal, &repaired());
    let nothing_left = run(Command::Diagnose, &repaired());
    let scenes = [
        ("data", Screen::Data, demonstration()),
        ("model", Screen::Model, repaired()),
        ("model-trained", Screen::Model, trained()),
        ("extrapolation", Screen::Extrapolation, extrapolated()),
        ("extrapolation-unasked", Screen::Extrapolation, demonstration()),
        ("train", Screen::Train, trained()),
        ("train-unasked", Screen::Train, demonstration()),
        ("diagnose-trained", Screen::Diagnose, trained()),
        ("compare", Screen::Compare, demonstration()),
        ("residuals", Screen::Residuals, demonstration()),
        ("diagnose", Screen::Diagnose, diagnosed()),
        ("diagnose-nothing", Screen::Diagnose, nothing_left),
        ("diagnose-unasked", Screen::Diagnose, demonstration()),
        ("ladder", Screen::Ladder, opened),
        ("experiment", Screen::Experiment, Session::default()),
        ("empty", Screen::Data, Session::default()),
        ("error", Screen::Compare, Session::default()),
    ];
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS);
    for (name, screen, session) in scenes {
        for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
            let mut window = window(session.clone(), screen, theme);
            window.run_steps(2);
            if name == "error" {
                let missing = ["no/such/recording.csv".into()].to_vec();
                window.state_mut().order(Order::open(missing));
                settle(&mut window);
            }
            if name == "experiment" {
                window.state_mut().order(Order::Experiment(experiment()));
                settle(&mut window);
            }
            results.add(window.try_snapshot_options(format!("{name}-{suffix}"), &options));
        }
    }
}
