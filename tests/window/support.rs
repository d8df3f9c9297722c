//! The window in a test: the real app, drawn on the CPU, driven through its accessible names.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use egui::TexturesDelta;
use egui_kittest::{Harness, TestRenderer};
use torquescope::app::raster::Raster;
use torquescope::app::{About, Shown, TorquescopeApp, theme};
use torquescope::arm::Arm;
use torquescope::experiment::{self, Shard, Store, catalogue};
use torquescope::model::learned::LearnedPreset;
use torquescope::progress::Monitor;
use torquescope::session::{Command, Session};
use torquescope::simulation::extrapolation::Stretch;
use torquescope::simulation::{Excitation, Scenario};
use torquescope::training::fit::Plan;

/// The window under test.
pub type Window = Harness<'static, TorquescopeApp>;

/// Size of the window in tests \[points\].
pub const SIZE: [f32; 2] = [1280.0, 800.0];

#[derive(Default)]
struct CpuRenderer(Raster);

impl TestRenderer for CpuRenderer {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        self.0.update_textures(delta);
    }

    fn render(&mut self, ctx: &egui::Context, output: &egui::FullOutput) -> Result<image::RgbaImage, String> {
        let scale = output.pixels_per_point;
        let size = (ctx.content_rect().size() * scale).round();
        let primitives = ctx.tessellate(output.shapes.clone(), scale);
        let ground = ctx.global_style().visuals.panel_fill;
        let picture = self.0.paint(&primitives, [size.x as usize, size.y as usize], scale, ground);
        image::RgbaImage::from_raw(picture.width as u32, picture.height as u32, picture.rgba)
            .ok_or_else(|| "the picture has a wrong size".to_owned())
    }
}

/// The window on a session and screen, with all that is derived for drawing.
pub fn window(session: Session, screen: &'static About, theme: egui::Theme) -> Window {
    let mut app = TorquescopeApp::new(session);
    app.show_screen(screen);
    let mut window = Harness::builder()
        .with_size(SIZE)
        .with_theme(theme)
        .with_max_steps(16)
        .with_render_cursor(false)
        .with_context_setup(theme::install)
        .renderer(CpuRenderer::default())
        .build_eframe(|_| app);
    settle(&mut window);
    window
}

/// A guard against jobs that never end, out of reach of a machine that is merely busy.
const PATIENCE: Duration = Duration::from_secs(1800);

/// Steps until no job is at work.
pub fn settle(window: &mut Window) {
    window.run_steps(3);
    step_until(window, "every job ended", |window| !window.state().is_busy());
    window.run_steps(3);
}

/// Steps until something is so.
pub fn step_until(window: &mut Window, what: &str, is_so: impl Fn(&Window) -> bool) {
    let begin = Instant::now();
    while !is_so(window) {
        assert!(begin.elapsed() < PATIENCE, "waited in vain until {what}");
        std::thread::sleep(Duration::from_millis(5));
        window.step();
    }
}

/// The demonstration arm with its first model; made once.
pub fn demonstration() -> Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    SESSION.get_or_init(|| run(Command::Simulate(Box::new(Scenario::embedded())), &Session::default())).clone()
}

/// The session after a command.
pub fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).expect("the command works")
}

/// A plan that takes a moment.
pub fn short_plan(epochs: u64) -> Plan {
    let mut plan = Plan::default();
    (plan.options.epochs, plan.options.batch) = (epochs, 64);
    plan
}

/// A small arm with friction, with its rigid body; made once.
pub fn small() -> Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    let simulated = || {
        let motion = Excitation::PaperPointToPoint { trajectories: 12, duration: 4.0, samples: 100, range: 2.0 };
        let scenario = Scenario {
            name: "small arm".into(),
            arm: Arm::uniform(2),
            motion,
            effects: Vec::new(),
            ..Scenario::embedded()
        };
        run(Command::Simulate(Box::new(scenario)), &Session::default())
    };
    SESSION.get_or_init(simulated).clone()
}

/// The small arm with a structured DeLaN; made once.
pub fn trained() -> Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    let plan = Box::new(short_plan(24));
    let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan };
    SESSION.get_or_init(|| run(train, &small())).clone()
}

/// The demonstration arm, diagnosed; made once.
pub fn diagnosed() -> Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    SESSION.get_or_init(|| run(Command::Diagnose, &demonstration())).clone()
}

/// The demonstration arm with everything added that the diagnosis names; made once.
pub fn repaired() -> Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    let repair = || {
        let mut session = diagnosed();
        let report = session.report.clone().expect("it was diagnosed");
        for effect in &report.effects {
            let command = Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() };
            session = run(command, &session);
        }
        session
    };
    SESSION.get_or_init(repair).clone()
}

/// The repaired arm and the one before, faster than in the data.
pub fn extrapolated() -> Session {
    let session = repaired();
    run(Command::Extrapolate { steps: session.ladder.clone(), stretch: Stretch::Speed }, &session)
}

/// An experiment on a small arm with friction, whose models are solved for at once.
pub const EXPERIMENT: &str = r#"
title = "A small arm with friction"
description = "Two links and viscous friction, with and without the effect."
seeds = 3

[data.simulation]
arm = { links = [
    { mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 },
    { mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 },
] }
effects = [{ effect = "viscous-friction@1", parameters = [0.8] }]
torque_noise = 0.01
motion = { kind = "paper-point-to-point", trajectories = 10, duration = 4.0, samples = 100, range = 3.0 }

[[model]]
name = "rigid-body"
preset = "rigid-body"

[[model]]
name = "with-friction"
preset = "rigid-body"
effects = ["viscous-friction@1"]

[[test]]
name = "iid"

[[test]]
name = "fast"
simulation = { speed_scale = 2.0 }

[[curve]]
name = "speed"
key = "speed_scale"
axis = "times as fast"
values = [1.0, 1.5, 2.0, 2.5, 3.0]
"#;

/// That experiment with its results, in a folder whose name stands in the pictures; made once.
pub fn experiment() -> Shown {
    static SHOWN: OnceLock<Shown> = OnceLock::new();
    let run = || {
        let (folder, file) = ("target/small-experiment", "target/small-experiment/arm.toml");
        // What an earlier test left there is of another program.
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).expect("the folder can be made");
        std::fs::write(file, EXPERIMENT).expect("the file can be written");
        let experiment = catalogue::open(file).expect("it is an experiment");
        let store = Store::new(folder);
        let report = experiment::run(&experiment, &store, None, Shard::default(), &Monitor::new()).expect("it runs");
        assert_eq!((report.done, report.failed.len()), (6, 0));
        Shown { experiment: file.to_owned(), results: folder.to_owned(), quick: false, ..Shown::default() }
    };
    SHOWN.get_or_init(run).clone()
}
