//! How quick the window is: how long its frames take, when a file is on the screen, and what an arm costs that is played.

use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use cpu_time::{ProcessTime, ThreadTime};
use egui::{FullOutput, Pos2, RawInput, Rect, ViewportId, vec2};

use super::headless::PATIENCE;
use super::raster::Raster;
use super::screens::compare;
use super::theme;
use super::{Order, TorquescopeApp, screens};
use crate::session::{Command, Session};

/// Size of the measured window \[points, pixels\].
pub(super) const SIZE: [usize; 2] = [1600, 1000];
/// How often a screen shows a picture \[s\].
const REFRESH: f64 = 1.0 / 60.0;
/// Why nothing is measured.
pub(super) const NO_CLOCK: &str = "this system does not tell the CPU time of a thread";

/// A frame at this time \[s\], in which this happens.
pub(super) fn run(ctx: &egui::Context, app: &mut TorquescopeApp, time: f64, events: Vec<egui::Event>) -> FullOutput {
    let size = Rect::from_min_size(Pos2::ZERO, vec2(SIZE[0] as f32, SIZE[1] as f32));
    let input = RawInput { screen_rect: Some(size), time: Some(time), events, ..RawInput::default() };
    ctx.run_ui(input, |ui| {
        app.receive(ui.ctx());
        app.draw(ui);
    })
}

/// CPU time of frames \[ms\].
pub struct FrameTimes {
    /// Of the first frame, with fonts and everything that a start needs.
    pub first_ms: f64,
    /// By screen, in the order in which they were drawn.
    pub screens: Vec<(&'static str, Vec<f64>)>,
}

/// Frames of each screen: at rest, zooming, moving.
const FRAMES: [usize; 3] = [40, 100, 100];
/// The part of the time that the deepest zoom of the measurement shows.
const DEEPEST: f64 = 1e-3;

/// Draws every screen over and over, as if someone zoomed and moved the view, while `background` is at work; the time is that
/// of this thread alone, from input to triangles.
///
/// # Errors
/// If the background work does not begin.
pub fn frame_times(session: Session, background: Command) -> anyhow::Result<FrameTimes> {
    let mut time = 0.0;
    let mut frame = |ctx: &egui::Context, app: &mut TorquescopeApp| -> anyhow::Result<f64> {
        time += REFRESH;
        let begin = ThreadTime::try_now().context(NO_CLOCK)?;
        let mut output = run(ctx, app, time, Vec::new());
        output.textures_delta.clear();
        std::hint::black_box(ctx.tessellate(output.shapes, output.pixels_per_point));
        Ok(1e3 * begin.elapsed().as_secs_f64())
    };
    let begin = ThreadTime::try_now().context(NO_CLOCK)?;
    let ctx = egui::Context::default();
    theme::install(&ctx);
    let mut app = TorquescopeApp::new(session);
    frame(&ctx, &mut app)?;
    let first_ms = 1e3 * begin.elapsed().as_secs_f64();
    app.order(Order::run(background));
    frame(&ctx, &mut app)?;
    if !app.is_busy() {
        bail!("the background work did not begin");
    }
    let mut measured = Vec::new();
    for screen in screens::all() {
        app.show_screen(screen);
        app.look_at(None, 0.0);
        let mut times = Vec::new();
        for number in 0..FRAMES.iter().sum() {
            let (zoomed, moved) = (number.saturating_sub(FRAMES[0]), number.saturating_sub(FRAMES[0] + FRAMES[1]));
            let width = DEEPEST.powf((zoomed.min(FRAMES[1]) as f64) / FRAMES[1] as f64);
            let from = (1.0 - width) * (0.3 + 0.3 * moved as f64 / FRAMES[2] as f64);
            let range = (zoomed > 0).then_some([from, from + width]);
            app.look_at(range, from + 0.5 * width);
            times.push(frame(&ctx, &mut app)?);
        }
        measured.push((screen.id, times));
    }
    app.order(Order::Stop);
    frame(&ctx, &mut app)?;
    Ok(FrameTimes { first_ms, screens: measured })
}

/// What a file costs that is opened and played.
#[derive(Debug, Clone, Copy)]
pub struct Opening {
    /// How many numbers the recording has: its time and all channels.
    pub numbers: usize,
    /// From the order to open it until the first picture that shows it \[s\].
    pub seen_s: f64,
    /// Until everything on that screen is there \[s\].
    pub whole_s: f64,
    /// Pictures in a second, while the arm is played.
    pub pictures_per_s: f64,
    /// CPU time of the whole program meanwhile, over the time that passed: 1 is one core.
    pub played_share: f64,
    /// The part of it that the window's own thread takes from input to triangles; the rest is the picture, and other threads.
    pub window_share: f64,
}

/// Opens something in an empty window as a user does, draws every frame as a picture, and then plays the arm for so many seconds,
/// as often as the window asks to be drawn, at most 60 times a second. Pictures are those of [`Raster`], which stands for a
/// renderer without a GPU.
///
/// # Errors
/// If it can't be opened, or holds nothing that could be played.
pub fn opened_and_played(open: Command, seconds: f64) -> anyhow::Result<Opening> {
    let begin = Instant::now();
    let mut watched = Watched::new(begin);
    watched.app.order(Order::run(open));
    watched.until("there is a recording", |app| app.session().recording.is_some() || !app.is_busy())?;
    if watched.app.session().current().is_none() {
        bail!("nothing was opened that has a model: `torquescope inspect` tells why");
    }
    let seen_s = begin.elapsed().as_secs_f64();
    watched.until("everything is there", |app| !app.is_busy())?;
    let whole_s = begin.elapsed().as_secs_f64();
    watched.app.show_screen(&compare::ABOUT);
    watched.until("the arm is there", |app| !app.is_busy())?;
    watched.app.focus.is_playing = true;
    watched.frame()?;
    let (start, all) = (Instant::now(), ProcessTime::try_now().context(NO_CLOCK)?);
    let (mut pictures, mut window) = (0, 0.0);
    while start.elapsed().as_secs_f64() < seconds {
        let (own, wish) = watched.frame()?;
        (pictures, window) = (pictures + 1, window + own);
        watched.wait(wish, start + Duration::from_secs_f64(seconds));
    }
    let passed = start.elapsed().as_secs_f64();
    let recording = watched.app.session().recording.clone();
    let numbers = recording.map_or(0, |recording| (4 * recording.joint_count() + 1) * recording.sample_count());
    Ok(Opening {
        numbers,
        seen_s,
        whole_s,
        pictures_per_s: f64::from(pictures) / passed,
        played_share: all.elapsed().as_secs_f64() / passed,
        window_share: window / passed,
    })
}

/// A window of which every frame becomes a picture.
struct Watched {
    ctx: egui::Context,
    app: TorquescopeApp,
    raster: Raster,
    begin: Instant,
    /// When the window asked to be drawn, from whichever thread.
    wishes: Receiver<Instant>,
}

impl Watched {
    fn new(begin: Instant) -> Self {
        let ctx = egui::Context::default();
        theme::install(&ctx);
        let (asked, wishes) = mpsc::channel();
        ctx.set_request_repaint_callback(move |wish| {
            // Who no longer waits needs no answer.
            let _ = asked.send(Instant::now() + wish.delay.min(PATIENCE));
        });
        Watched { ctx, app: TorquescopeApp::new(Session::default()), raster: Raster::default(), begin, wishes }
    }

    /// A frame and its picture: the CPU time of this thread from input to triangles \[s\], and after which time the window wants to
    /// be drawn again.
    fn frame(&mut self) -> anyhow::Result<(f64, Duration)> {
        let own = ThreadTime::try_now().context(NO_CLOCK)?;
        let mut output = run(&self.ctx, &mut self.app, self.begin.elapsed().as_secs_f64(), Vec::new());
        let wish = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::ZERO, |root| root.repaint_delay);
        let triangles = self.ctx.tessellate(output.shapes, output.pixels_per_point);
        let own = own.elapsed().as_secs_f64();
        self.raster.update_textures(&mut output.textures_delta);
        let ground = self.ctx.global_style().visuals.panel_fill;
        std::hint::black_box(self.raster.paint(&triangles, SIZE, output.pixels_per_point, ground));
        Ok((own, wish))
    }

    /// Waits as a real screen does: until the window asks to be drawn, and for the screen's next picture.
    fn wait(&self, wish: Duration, latest: Instant) {
        let mut next = latest.min(Instant::now() + wish.min(PATIENCE));
        while let Ok(asked) = self.wishes.recv_timeout(next.saturating_duration_since(Instant::now())) {
            next = next.min(asked);
        }
        let since = self.begin.elapsed().as_secs_f64();
        std::thread::sleep(Duration::from_secs_f64(REFRESH - since % REFRESH));
    }

    /// Frames until something is so, and a picture that shows it.
    fn until(&mut self, what: &str, is_so: impl Fn(&TorquescopeApp) -> bool) -> anyhow::Result<()> {
        let latest = Instant::now() + PATIENCE;
        loop {
            let (_, wish) = self.frame()?;
            if is_so(&self.app) && self.app.orders.is_empty() {
                return Ok(());
            }
            if Instant::now() > latest {
                bail!("it was waited in vain until {what}");
            }
            self.wait(wish, latest);
        }
    }
}
