//! Pictures of every screen, light and dark, beside those that somebody has looked at.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test --test window snapshots` draws them anew: look at what changed before you commit it.

use std::sync::Arc;

use egui::{Role, Theme};
use egui_kittest::kittest::Queryable;
use egui_kittest::{SnapshotOptions, SnapshotResults, try_image_snapshot_options};
use torquescope::app::screens::{
    self, compare, data, diagnose, experiment, extrapolation, ladder, model, residuals, train,
};
use torquescope::app::{ExportPage, Order};
use torquescope::session::{Command, Session};

use crate::support::{
    self, SIZE, demonstration, diagnosed, experiment, extrapolated, repaired, run, settle, trained, window,
};

/// Pixels that may differ. Everything is drawn on the CPU in the same way, but `sin` and `cos` of the system may differ in
/// the last bit, and the fitted model with them: a point may move to the next pixel. A control that moves, or a line of
/// text that changes, is far more than this.
const STRAY_PIXELS: usize = 60;

/// A trained session with curves that are told here. The kernels of networks are those of the processor (AVX-512, AVX2 or neither), which
/// round differently: after some epochs lines lie a pixel beside, and another epoch may be the best.
fn told() -> Session {
    let mut session = trained();
    let step = Arc::make_mut(session.ladder.last_mut().expect("it was trained"));
    for epoch in &mut step.history {
        let at = epoch.epoch as f64;
        let from_best = 1e-5 * (at - 22.0).powi(2);
        epoch.loss = 4.0 * (-0.4 * at).exp() + 0.002;
        epoch.validation = Some(2.0 * (-0.5 * at).exp() + 0.0055 + from_best);
        epoch.held_out = Some((-0.6 * at).exp() + 0.0006);
    }
    session
}

#[test]
fn every_screen_looks_as_it_did() {
    let opened = run(Command::OpenSeal, &repaired());
    let nothing_left = run(Command::Diagnose, &repaired());
    let scenes = [
        ("data", &data::ABOUT, demonstration()),
        ("model", &model::ABOUT, repaired()),
        ("model-trained", &model::ABOUT, trained()),
        ("extrapolation", &extrapolation::ABOUT, extrapolated()),
        ("extrapolation-unasked", &extrapolation::ABOUT, demonstration()),
        ("train", &train::ABOUT, told()),
        ("train-unasked", &train::ABOUT, demonstration()),
        ("diagnose-trained", &diagnose::ABOUT, trained()),
        ("compare", &compare::ABOUT, demonstration()),
        ("residuals", &residuals::ABOUT, demonstration()),
        ("diagnose", &diagnose::ABOUT, diagnosed()),
        ("diagnose-nothing", &diagnose::ABOUT, nothing_left),
        ("diagnose-unasked", &diagnose::ABOUT, demonstration()),
        ("ladder", &ladder::ABOUT, opened),
        ("experiment", &experiment::ABOUT, Session::default()),
    ];
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS);
    for (name, screen, session) in scenes {
        for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
            let mut window = window(session.clone(), screen, theme);
            if name == "experiment" {
                window.state_mut().order(Order::Experiment(experiment()));
                settle(&mut window);
            }
            results.add(window.try_snapshot_options(format!("{name}-{suffix}"), &options));
        }
    }
}

/// The questions before something is lost, and what a start offers to go on with.
#[test]
fn questions_and_offers_look_as_they_did() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("swing.csv");
    std::fs::write(&log, crate::swing()).unwrap();
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS);
    for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
        let mut closing = window(diagnosed(), &data::ABOUT, theme);
        crate::lost::close(&mut closing);
        closing.run_steps(4);
        results.add(closing.try_snapshot_options(format!("closing-{suffix}"), &options));
        let mut left = window(diagnosed(), &data::ABOUT, theme);
        left.state_mut().order(Order::run(Command::BeginAnew));
        settle(&mut left);
        crate::lost::close(&mut left);
        left.run_steps(4);
        results.add(left.try_snapshot_options(format!("closing-left-{suffix}"), &options));

        let mut seal = window(repaired(), &ladder::ABOUT, theme);
        crate::click(&mut seal, "Open the seal");
        results.add(seal.try_snapshot_options(format!("seal-{suffix}"), &options));

        let mut first = window(Session::default(), &data::ABOUT, theme);
        first.state_mut().order(Order::open(vec![log.clone()]));
        settle(&mut first);
        let mut start = window(Session::default(), &data::ABOUT, theme);
        let (settings, ctx) = (first.state().settings(&first.ctx), start.ctx.clone());
        start.state_mut().restore(settings, &ctx);
        settle(&mut start);
        results.add(start.try_snapshot_options(format!("start-{suffix}"), &options));
    }
}

/// All screens on one sheet, full, with high contrast.
#[test]
fn every_screen_looks_as_it_did_with_high_contrast() {
    let session = run(Command::Diagnose, &run(Command::OpenSeal, &extrapolated()));
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS * screens::TABLE.len());
    for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
        let mut sheet = Sheet::new();
        for screen in screens::all() {
            let mut window = window(session.clone(), screen, theme);
            window.state_mut().order(Order::HighContrast(true));
            if *screen == experiment::ABOUT {
                window.state_mut().order(Order::Experiment(experiment()));
            }
            settle(&mut window);
            sheet.add(&mut window);
        }
        results.add(try_image_snapshot_options(&sheet.picture, format!("screens-contrast-{suffix}"), &options));
    }
}

/// All screens in a small and in a large window, light and dark, each also with high contrast: one sheet for each.
#[test]
fn screens_look_as_they_did_in_small_and_large_windows() {
    const SIZES: [[f32; 2]; 2] = [[1000.0, 700.0], [1600.0, 1000.0]];
    const LOOKS: [(Theme, bool, &str); 4] = [
        (Theme::Light, false, "light"),
        (Theme::Dark, false, "dark"),
        (Theme::Light, true, "contrast"),
        (Theme::Dark, true, "contrast-dark"),
    ];
    let session = run(Command::Diagnose, &run(Command::OpenSeal, &extrapolated()));
    let count = screens::TABLE.len();
    let mut sheets: Vec<Sheet> = SIZES.iter().flat_map(|size| LOOKS.map(|_| Sheet::of(count, *size))).collect();
    for screen in screens::all() {
        let mut window = window(session.clone(), screen, Theme::Light);
        if *screen == experiment::ABOUT {
            window.state_mut().order(Order::Experiment(experiment()));
        }
        for (number, sheet) in sheets.iter_mut().enumerate() {
            let (size, (theme, has_contrast, _)) = (SIZES[number / LOOKS.len()], LOOKS[number % LOOKS.len()]);
            window.set_size(size.into());
            window.ctx.set_theme(theme);
            window.state_mut().order(Order::HighContrast(has_contrast));
            settle(&mut window);
            sheet.add(&mut window);
        }
    }
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS * count);
    for (number, sheet) in sheets.iter().enumerate() {
        let ([width, _], (.., look)) = (SIZES[number / LOOKS.len()], LOOKS[number % LOOKS.len()]);
        results.add(try_image_snapshot_options(&sheet.picture, format!("screens-{width}-{look}"), &options));
    }
}

/// What four models have learned, and what they leave, beside the truth.
#[test]
fn models_over_each_other_look_as_they_did() {
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS);
    let session = run(Command::OpenSeal, &crate::models::four());
    let mut window = crate::models::show_all(window(session, &model::ABOUT, Theme::Light));
    crate::click(&mut window, "Models (4)");
    crate::click(&mut window, "What it has learned");
    results.add(window.try_snapshot_options("models-learned", &options));
    window.state_mut().order(Order::Show(&residuals::ABOUT));
    settle(&mut window);
    window.get_by_label("plot of rigid body: ↑ velocity [rad/s]").scroll_to_me();
    settle(&mut window);
    results.add(window.try_snapshot_options("models-residuals", &options));
}

/// The dialogs over a screen, on one sheet.
#[test]
fn dialogs_look_as_they_did() {
    let log = "target/swing.csv";
    std::fs::write(log, crate::swing()).unwrap();
    let [encoder, robot] = ["target/encoder.csv", "target/hand.urdf"];
    std::fs::write(encoder, crate::importing::nameless().replacen("when,a,b", "time,q1,tau1", 1)).unwrap();
    std::fs::write(robot, crate::importing::WITH_A_HAND).unwrap();
    let orders = || {
        [
            Order::Export(None),
            Order::AskExport(ExportPage::Model),
            Order::AskExport(ExportPage::Data),
            Order::Models(true),
            Order::Palette(true),
            Order::Import(vec![log.into()], Box::default()),
            Order::Import(vec![encoder.into()], Box::default()),
            Order::Robot { file: robot.into(), logs: Vec::new() },
            Order::Lessons(true),
            Order::KeyList(true),
        ]
    };
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS * orders().len());
    for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
        let mut sheet = Sheet::of(orders().len(), SIZE);
        for order in orders() {
            let mut window = window(repaired(), &compare::ABOUT, theme);
            window.state_mut().order(order);
            settle(&mut window);
            // What was read while it was drawn may have left a scroll bar that is no longer needed.
            window.run_steps(8);
            sheet.add(&mut window);
        }
        results.add(try_image_snapshot_options(&sheet.picture, format!("dialogs-{suffix}"), &options));
    }
}

/// The menu of a plot, with lines of one's own in it.
#[test]
fn the_menu_of_a_plot_looks_as_it_did() {
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS);
    let mut window = window(repaired(), &residuals::ABOUT, Theme::Light);
    let chart = "plot of residual against velocity [N m]";
    crate::charts::write_line(&mut window, chart, 1, "0.5 * sign(qd1)");
    crate::click(&mut window, "Add a line");
    crate::type_into(&mut window, "line of your own 2", "sin(q1) + mg");
    settle(&mut window);
    results.add(window.try_snapshot_options("menu-of-a-plot", &options));
}

/// While something is at work: how far it is may differ from picture to picture, where it stands and what is shut may not.
#[test]
fn a_busy_screen_looks_as_it_did() {
    const PIXELS_OF_PROGRESS: usize = 3000;
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(PIXELS_OF_PROGRESS);
    for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
        let mut busy = crate::busy::busy(&diagnose::ABOUT, theme);
        results.add(busy.try_snapshot_options(format!("busy-{suffix}"), &options));
        busy.get_by_role_and_label(Role::Button, "Stop").click();
        settle(&mut busy);
    }
}

/// Pictures of all screens, two beside each other, half as large as the window: what moves or is missing is still seen.
struct Sheet {
    picture: image::RgbaImage,
    /// Of each picture.
    sides: [u32; 2],
    count: u32,
}

impl Sheet {
    /// Of all screens.
    fn new() -> Self {
        Sheet::of(screens::TABLE.len(), SIZE)
    }

    /// Of so many windows of this size.
    fn of(count: usize, size: [f32; 2]) -> Self {
        let sides = size.map(|side| side as u32 / 2);
        let [width, height] = sides;
        Sheet { picture: image::RgbaImage::new(2 * width, height * count.div_ceil(2) as u32), sides, count: 0 }
    }

    fn add(&mut self, window: &mut support::Window) {
        let [width, height] = self.sides;
        let picture = image::imageops::thumbnail(&window.render().unwrap(), width, height);
        let corner = [self.count % 2 * width, self.count / 2 * height].map(i64::from);
        image::imageops::replace(&mut self.picture, &picture, corner[0], corner[1]);
        self.count += 1;
    }
}

/// All screens on one sheet: empty, and with an error.
#[test]
fn every_screen_looks_as_it_did_when_empty_and_failed() {
    let mut results = SnapshotResults::new();
    let options = SnapshotOptions::new().max_failed_pixels(STRAY_PIXELS * screens::TABLE.len());
    for (theme, suffix) in [(Theme::Light, "light"), (Theme::Dark, "dark")] {
        for (state, session) in [("empty", Session::default()), ("error", demonstration())] {
            let mut sheet = Sheet::new();
            for screen in screens::all() {
                let mut window = window(session.clone(), screen, theme);
                window.run_steps(2);
                if state == "error" {
                    window.state_mut().order(Order::open(vec!["no/such/recording.csv".into()]));
                    settle(&mut window);
                }
                sheet.add(&mut window);
            }
            results.add(try_image_snapshot_options(&sheet.picture, format!("screens-{state}-{suffix}"), &options));
        }
    }
}
