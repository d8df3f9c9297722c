//! The window: `logic` receives and applies, `ui` draws. It sends [`Command`]s, as the command line does, and runs the long
//! ones in a [`Job`].
//!
//! From the ground up: [`theme`], [`plot`] and widgets are what screens are drawn with; `memo` keeps what is derived from the
//! session; `desk` is what all screens share; [`screens`] has one file or folder per screen, each with its own memory; `shell`
//! is what surrounds them. [`headless`] draws the same window without a display.

mod controls;
pub mod desk;
mod dock;
mod fonts;
pub mod headless;
mod icon;
mod keeper;
mod memo;
pub mod plot;
pub mod raster;
mod screen;
pub mod screens;
mod settings;
mod shell;
mod tables;
pub mod theme;
mod widgets;

use std::path::PathBuf;
use std::time::{Duration, Instant};

pub use desk::{About, Order, Shown};
pub use headless::{ScreenshotOptions, plots, screenshot};
pub use settings::Settings;

use crate::figure::Panel;
use crate::progress::{Epoch, Event, Progress};
use crate::recording::read;
use crate::session::{Command, History, Session, file};
use crate::training::Ending;
use crate::training::fit::Plan;
use crate::work::{Job, Outcome};
use desk::{Busy, Desk, Drawing, Focus, Messages, Panels, Tone};
use keeper::{Keeper, Kept};
use memo::Memo;
use screens::Screens;
use shell::{Overlays, Shell};

/// Smallest and largest size of text, relative to the usual.
const TEXT_SCALES: std::ops::RangeInclusive<f32> = 0.8..=2.0;
/// A file dialog that answers "nothing chosen" faster than this was never shown.
const FASTEST_CANCEL: Duration = Duration::from_millis(400);

/// The program's window.
pub struct TorquescopeApp {
    history: History,
    screens: Screens,
    focus: Focus,
    memo: Memo,
    panels: Panels,
    messages: Messages,
    overlays: Overlays,
    /// Whether something of this recording was exported, which is the end of the way.
    exported: bool,
    running: Option<Running>,
    dialog: Option<Dialog>,
    /// The figure that is being written.
    drawing: Option<Job<PathBuf>>,
    keeper: Keeper,
    orders: Vec<Order>,
    /// Where the window is shown, to remember its looks.
    context: Option<egui::Context>,
}

/// A file dialog that is open.
struct Dialog {
    job: Job<Option<Vec<PathBuf>>>,
    begin: Instant,
    asks: Asks,
}

/// What a file dialog is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asks {
    Open,
    Save,
    Export,
}

/// A command at work.
struct Running {
    job: Job<Session>,
    command: Command,
    /// By which plan it trains, if it does.
    plan: Option<Plan>,
    /// What it has told so far.
    progress: Progress,
    epochs: Vec<Epoch>,
    found: Vec<String>,
    /// Whether it was asked to end with what it has.
    finishing: bool,
}

impl Running {
    /// Takes what it has told since the last frame.
    fn hear(&mut self) {
        for event in self.job.events() {
            match event {
                Event::Progress(progress) => self.progress = progress,
                Event::Epoch(epoch) => {
                    // A command that trains twice begins its curve anew.
                    if epoch.epoch <= 1 {
                        self.epochs.clear();
                    }
                    self.epochs.push(epoch);
                }
                Event::Found(found) => self.found = found,
                Event::Done(_) => {}
            }
        }
    }
}

/// Opens the window on a session and returns when it is closed. A command given with it, such as opening a file that was named
/// on the command line, is carried out as soon as the window stands, with its progress shown.
///
/// # Errors
/// What the system says if it gives no window.
pub fn run_window(session: Session, first: Option<Command>) -> anyhow::Result<()> {
    let viewport = egui::ViewportBuilder::default()
        .with_icon(icon::icon().unwrap_or_default())
        .with_title("Torquescope")
        .with_app_id("torquescope")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([960.0, 640.0])
        .with_drag_and_drop(true);
    let options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    let create: eframe::AppCreator = Box::new(move |context| {
        theme::install(&context.egui_ctx);
        let mut app = TorquescopeApp::new(session);
        let kept = context.storage.and_then(|storage| eframe::get_value::<Settings>(storage, eframe::APP_KEY));
        if let Some(settings) = kept {
            app.restore(settings, &context.egui_ctx);
        }
        if let Some(copy) = Keeper::usual_place() {
            app.keep_copy(copy);
        }
        app.orders.extend(first.map(Order::run));
        Ok(Box::new(app))
    });
    eframe::run_native("torquescope", options, create).map_err(|error| {
        anyhow::anyhow!("no window could be opened ({error}): `torquescope --help` lists the commands that need none")
    })
}

impl TorquescopeApp {
    /// The window on this session, at the first screen. The context needs [`theme::install`] first.
    pub fn new(session: Session) -> Self {
        let (mut screens, mut focus) = (Screens::default(), Focus::default());
        screens.follow(&Session::default(), &session, None);
        focus.follow(&Session::default(), &session);
        TorquescopeApp {
            history: History::new(session),
            screens,
            focus,
            memo: Memo::default(),
            panels: Panels::default(),
            messages: Messages::default(),
            overlays: Overlays::default(),
            exported: false,
            running: None,
            dialog: None,
            drawing: None,
            keeper: Keeper::default(),
            orders: Vec::new(),
            context: None,
        }
    }

    /// Keeps a copy of the session in this file after every change, so that a crash costs nothing; a copy that is there
    /// already is offered to the user.
    pub fn keep_copy(&mut self, path: PathBuf) {
        self.keeper = Keeper::with_copy(path);
    }

    /// How the window looks and where its panels are, to be remembered.
    pub fn settings(&self, ctx: &egui::Context) -> Settings {
        Settings::of(ctx, self.panels.layouts())
    }

    /// Lets the window look as it was remembered.
    pub fn restore(&mut self, settings: Settings, ctx: &egui::Context) {
        settings.apply(ctx);
        self.panels.restore(settings.layouts);
    }

    /// The document as it is.
    pub fn session(&self) -> &Session {
        self.history.current()
    }

    /// The screen that is shown.
    pub fn screen(&self) -> &'static About {
        self.screens.shown()
    }

    /// Shows another screen.
    pub fn show_screen(&mut self, screen: &About) {
        self.screens.show(screen);
    }

    /// Shows a part of the trajectory, from 0 to 1, or all of it, with the cursor at a part of it.
    fn look_at(&mut self, part: Option<[f64; 2]>, cursor: f64) {
        let runs = self.history.current().recording.as_ref().map(|recording| &recording.trajectories);
        if let Some(run) = runs.and_then(|runs| runs.get(self.focus.trajectory)) {
            self.focus.look_at(run, part, cursor);
        }
    }

    /// Whether a job is at work.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
            || self.dialog.is_some()
            || self.drawing.is_some()
            || self.keeper.is_busy()
            || self.screens.are_busy()
            || self.memo.is_busy()
    }

    /// Gives an order, as a click would.
    pub fn order(&mut self, order: Order) {
        self.orders.push(order);
    }

    /// Receives what jobs, keys and other programs sent, and carries out the orders of the last frame.
    pub fn receive(&mut self, ctx: &egui::Context) {
        self.poll_job(ctx);
        self.poll_dialog();
        self.poll_drawing(ctx);
        self.poll_keeper(ctx);
        self.screens.poll();
        self.memo.poll();
        let dropped: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        if !dropped.is_empty() {
            self.orders.push(Order::open(dropped));
        }
        self.orders.extend(self.overlays.shortcuts(ctx, self.history.current(), &self.screens, self.exported));
        let scale = ctx.zoom_factor();
        if !TEXT_SCALES.contains(&scale) {
            ctx.set_zoom_factor(scale.clamp(*TEXT_SCALES.start(), *TEXT_SCALES.end()));
        }
        for order in std::mem::take(&mut self.orders) {
            self.carry_out(order, ctx);
        }
    }

    /// What the shown screen shows, as figures, with what is in view.
    pub fn figures(&mut self) -> Vec<Panel> {
        let (session, models) = (self.history.current().clone(), self.history.models());
        let mut desk = Desk {
            session: &session,
            focus: &mut self.focus,
            memo: &mut self.memo,
            panels: &mut self.panels,
            orders: &mut self.orders,
            busy: None,
            models: &models,
        };
        let panels = self.screens.current().figures(&mut desk);
        self.focus.views.seen(panels)
    }

    /// Draws everything.
    pub fn draw(&mut self, ui: &mut egui::Ui) {
        let busy = self.running.as_ref().map(|running| Busy {
            name: running.job.name(),
            progress: &running.progress,
            paused: running.job.is_paused(),
            finishing: running.finishing,
            plan: running.plan.as_ref(),
            epochs: &running.epochs,
            found: &running.found,
        });
        let (session, models) = (self.history.current().clone(), self.history.models());
        self.memo.keep_to(&session);
        let desk = Desk {
            session: &session,
            focus: &mut self.focus,
            memo: &mut self.memo,
            panels: &mut self.panels,
            orders: &mut self.orders,
            busy: busy.as_ref(),
            models: &models,
        };
        let mut shell = Shell {
            desk,
            screens: &mut self.screens,
            messages: &mut self.messages,
            exported: self.exported,
            undo: self.history.undo_text(),
            redo: self.history.redo_text(),
            left_behind: self.keeper.left_behind().is_some(),
        };
        self.overlays.show(ui, &mut shell);
        if !self.orders.is_empty() {
            ui.ctx().request_repaint();
        }
    }

    fn carry_out(&mut self, order: Order, ctx: &egui::Context) {
        for order in self.screens.hear(&order) {
            self.carry_out(order, ctx);
        }
        match order {
            Order::Run(command) => self.run(*command, ctx),
            Order::Show(screen) => self.screens.show(screen),
            // Only screens have to hear of it.
            Order::DrawMystery | Order::PlanTraining(_) | Order::Experiment(_) => (),
            Order::Undo => self.travel("Undo", History::undo),
            Order::Redo => self.travel("Redo", History::redo),
            Order::Stop => {
                if let Some(running) = &mut self.running {
                    running.job.stop("you pressed Stop");
                }
                self.poll_job(ctx);
            }
            Order::Finish => {
                if let Some(running) = &mut self.running {
                    running.job.finish("you asked for it");
                    running.finishing = true;
                }
            }
            Order::Pause(paused) => {
                if let Some(running) = &self.running {
                    running.job.pause(paused);
                }
            }
            Order::ToggleTheme => {
                let dark = ctx.theme() == egui::Theme::Dark;
                ctx.set_theme(if dark { egui::Theme::Light } else { egui::Theme::Dark });
            }
            Order::HighContrast(high) => theme::set_contrast(ctx, high),
            Order::ToggleContrast => theme::set_contrast(ctx, !theme::is_high_contrast(ctx)),
            Order::TextScale(scale) => ctx.set_zoom_factor(scale.clamp(*TEXT_SCALES.start(), *TEXT_SCALES.end())),
            Order::Palette(open) => self.overlays.palette = open.then(Default::default),
            Order::KeyList(open) => self.overlays.key_list = open,
            Order::FitAll => self.focus.views.fit_all(),
            Order::Panel(name, change) => self.panels.change(&name, &change),
            Order::NextPanel => self.panels.focus_next(ctx),
            Order::ResetPanels => self.panels.reset(),
            Order::Save(path) => {
                if self.history.current().recording.is_none() {
                    let text = "There is no recording yet, so there is nothing to save.";
                    self.messages.tell(Tone::Warning, text, "");
                } else {
                    self.keeper.save(path, self.history.current());
                }
            }
            Order::Recover(wanted) => {
                let path = self.keeper.left_behind().map(std::path::Path::to_owned);
                if let Some(path) = path.filter(|_| wanted) {
                    self.run(Command::Restore { path }, ctx);
                } else {
                    self.keeper.decided();
                }
            }
            Order::SaveDialog => self.open_dialog(ctx, Asks::Save),
            Order::OpenDialog => self.open_dialog(ctx, Asks::Open),
            Order::ExportDialog => self.open_dialog(ctx, Asks::Export),
            Order::Export(only) => self.overlays.export(self.history.current(), self.screens.shown(), only),
            Order::Draw(drawing) => self.write_figure(*drawing, ctx),
            Order::Tell(notice) => self.messages.notices.push(notice),
            Order::Dismiss(notice) => self.messages.dismiss(notice),
        }
    }

    /// Undo or redo. Not while a job is at work on the session as it is: its result would take the place of what one went back
    /// to, and what could be done again would be lost.
    fn travel(&mut self, name: &str, step: fn(&mut History)) {
        if let Some(running) = &self.running {
            let text = format!("{name} was not carried out, because “{}” is still at work.", running.job.name());
            self.messages.tell(Tone::Warning, text, "Wait for it, or press Stop in the bar below.");
            return;
        }
        let before = self.history.current().clone();
        step(&mut self.history);
        self.follow(&before, None);
    }

    /// The session has changed: everything that looks at it follows, and a copy is kept.
    fn follow(&mut self, before: &Session, by: Option<&Command>) {
        let after = self.history.current();
        self.memo.keep_to(after);
        self.screens.follow(before, after, by);
        self.focus.follow(before, after);
        self.exported &= before.has_recording_of(after);
        self.keeper.copy(after);
    }

    fn run(&mut self, command: Command, ctx: &egui::Context) {
        if let Some(running) = &self.running {
            let text =
                format!("“{}” was not started, because “{}” is still at work.", command.title(), running.job.name());
            self.messages.tell(Tone::Warning, text, "Wait for it, or press Stop in the bar below.");
            return;
        }
        let session = self.history.current().clone();
        if command.is_quick() {
            match command.run(&session, &crate::progress::Monitor::new()) {
                Ok(session) => self.accept(session, &command, ctx),
                Err(error) => self.fail(&command, error.to_string()),
            }
            return;
        }
        let plan = command.plan(&session).cloned();
        let (context, work) = (ctx.clone(), command.clone());
        let wake = move || context.request_repaint();
        let job = Job::spawn(command.title(), wake, move |monitor| work.run(&session, monitor));
        let progress = Progress::default();
        let (epochs, found) = (Vec::new(), Vec::new());
        self.running = Some(Running { job, command, plan, progress, epochs, found, finishing: false });
    }

    fn poll_job(&mut self, ctx: &egui::Context) {
        let Some(running) = &mut self.running else { return };
        running.hear();
        let Some(outcome) = running.job.poll() else { return };
        let Some(Running { command, .. }) = self.running.take() else { return };
        match outcome {
            Outcome::Done(session) => self.accept(session, &command, ctx),
            Outcome::Failed(message) => self.fail(&command, message),
            Outcome::Stopped(reason) => {
                let text = format!("Stopped: {}, because {reason}. Nothing was changed.", command.title());
                self.messages.tell(Tone::Info, text, "");
            }
            Outcome::Panicked(message) => {
                let text = format!("A defect of the program ended “{}”: {message}.", command.title());
                let remedy = "Your session is as it was. Please report this with what you did.";
                self.messages.tell(Tone::Error, text, remedy);
            }
        }
    }

    fn accept(&mut self, session: Session, command: &Command, ctx: &egui::Context) {
        let before = self.history.current().clone();
        self.messages.forget_what_is_past();
        self.messages.toast(done_text(&before, &session, command), ctx);
        if command.trains(&session)
            && let Some(step) = session.current()
            && let (Some(Ending::Failed(_)), Some(reason)) = (&step.ending, step.early_end())
        {
            let text = format!("Training ended early: {reason}; they are the model now.");
            self.messages.tell(Tone::Warning, text, "Undo brings back the model before it.");
        }
        self.history.push(session, &command.title());
        if matches!(command, Command::Restore { .. }) {
            self.keeper.decided();
        }
        self.follow(&before, Some(command));
    }

    fn fail(&mut self, command: &Command, message: String) {
        let text = format!("Could not {}: {message}.", command.title());
        self.messages.tell(Tone::Error, text, "Nothing was changed.");
    }

    fn poll_keeper(&mut self, ctx: &egui::Context) {
        if self.keeper.is_busy() {
            ctx.request_repaint_after(Duration::from_millis(50));
        }
        match self.keeper.poll() {
            Some(Kept::Saved(path)) => {
                self.messages.toast(format!("Saved: {}.", path.display()), ctx);
            }
            Some(Kept::Failed(message)) => {
                let text = format!("The session was not saved: {message}.");
                self.messages.tell(Tone::Error, text, "Your session is as it was; save it elsewhere.");
            }
            None => (),
        }
    }

    fn write_figure(&mut self, drawing: Drawing, ctx: &egui::Context) {
        let context = ctx.clone();
        let wake = move || context.request_repaint();
        self.drawing = Some(Job::spawn("export", wake, move |_| {
            let Drawing { figure, format, style, path } = drawing;
            let bytes = crate::figure::render(&figure, format, &style).map_err(|error| error.to_string())?;
            match crate::file::write(&path, &bytes) {
                Ok(()) => Ok(path),
                Err(error) => Err(format!("{} can't be written ({error})", path.display())),
            }
        }));
    }

    fn poll_drawing(&mut self, ctx: &egui::Context) {
        let Some(outcome) = self.drawing.as_mut().and_then(Job::poll) else { return };
        self.drawing = None;
        match outcome {
            Outcome::Done(path) => {
                self.messages.toast(format!("Exported: {}.", path.display()), ctx);
                self.exported = true;
            }
            Outcome::Failed(message) | Outcome::Stopped(message) | Outcome::Panicked(message) => {
                let text = format!("Nothing was exported: {message}.");
                self.messages.tell(Tone::Error, text, "Check the folder, or export elsewhere.");
            }
        }
    }

    fn open_dialog(&mut self, ctx: &egui::Context, asks: Asks) {
        if self.dialog.is_some() {
            return;
        }
        let context = ctx.clone();
        let wake = move || context.request_repaint();
        let name = self.history.current().recording.as_ref().map_or("session", |recording| &recording.name);
        let name = format!("{name}.{}", file::ENDING);
        let figure = self.overlays.exporting.as_ref().map_or(String::new(), |exporting| exporting.path.clone());
        let job = Job::spawn("choose files", wake, move |_| {
            let dialog = rfd::FileDialog::new();
            Ok::<_, String>(match asks {
                Asks::Save => {
                    let dialog = dialog.set_title("Save the session").set_file_name(name);
                    dialog.add_filter("sessions", &[file::ENDING]).save_file().map(|path| vec![path])
                }
                Asks::Export => {
                    dialog.set_title("Export plots").set_file_name(figure).save_file().map(|path| vec![path])
                }
                Asks::Open => {
                    let endings: Vec<&str> = read::endings().chain([file::ENDING, "toml"]).collect();
                    let dialog = dialog.set_title("Open recordings, a session or an effect");
                    dialog.add_filter("recordings", &endings).pick_files()
                }
            })
        });
        self.dialog = Some(Dialog { job, begin: Instant::now(), asks });
    }

    fn poll_dialog(&mut self) {
        let Some(dialog) = &mut self.dialog else { return };
        let Some(outcome) = dialog.job.poll() else { return };
        let (at_once, asks) = (dialog.begin.elapsed() < FASTEST_CANCEL, dialog.asks);
        self.dialog = None;
        match outcome {
            Outcome::Done(Some(mut paths)) if !paths.is_empty() => match (asks, &mut self.overlays.exporting) {
                (Asks::Open, _) => self.orders.push(Order::open(paths)),
                (Asks::Save, _) => self.orders.push(Order::Save(paths.remove(0))),
                (Asks::Export, Some(exporting)) => exporting.path = paths[0].display().to_string(),
                (Asks::Export, None) => (),
            },
            Outcome::Done(_) if !at_once => (),
            _ => {
                let text = "This system shows no file dialog.";
                let remedy = match asks {
                    Asks::Export => "Type the path into the field.",
                    _ => "Type the path into the field on the Data screen, or drop the file onto the window.",
                };
                self.messages.tell(Tone::Warning, text, remedy);
                if asks != Asks::Export {
                    self.screens.show(&screens::data::ABOUT);
                }
            }
        }
    }
}

/// What was done, with the change of the error where there is one.
fn done_text(before: &Session, after: &Session, command: &Command) -> String {
    let title = widgets::sentence_case(&command.title());
    let error = |session: &Session| {
        let errors = session.current()?.evaluation.held_out_nmse();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        mean.is_finite().then_some(mean)
    };
    match (error(before), error(after)) {
        (Some(from), Some(to)) if from != to && before.has_recording_of(after) => {
            let percent = plot::ticks::percent;
            format!("{title}: mean held-out error {} → {}.", percent(from), percent(to))
        }
        _ => format!("{title}: done."),
    }
}

impl eframe::App for TorquescopeApp {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.context.get_or_insert_with(|| ctx.clone());
        self.receive(ctx);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if let Some(ctx) = &self.context {
            eframe::set_value(storage, eframe::APP_KEY, &self.settings(ctx));
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.draw(ui);
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.keeper.close();
    }

    fn persist_egui_memory(&self) -> bool {
        false
    }
}
