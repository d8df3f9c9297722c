//! The window: `logic` receives and applies, `ui` draws. It sends [`Command`]s, as the command line does, and runs the long
//! ones in a [`Job`].
//!
//! From the ground up: [`theme`], [`plot`] and widgets are what screens are drawn with; `memo` keeps what is derived from the
//! session; `desk` is what all screens share; [`screens`] has one file or folder per screen, each with its own memory; `shell`
//! is what surrounds them. [`headless`] draws the same window without a display, [`pace`] measures how quick it is,
//! [`hand`] works in it.

mod controls;
pub mod desk;
mod dock;
mod facts;
mod filed;
mod fonts;
mod formula;
mod glossary;
pub mod hand;
pub mod headless;
mod icon;
mod keeper;
mod leaving;
mod looking;
mod math;
mod memo;
mod outgoing;
pub mod pace;
pub mod plot;
pub mod raster;
mod report;
mod screen;
pub mod screens;
mod settings;
mod shell;
mod tables;
pub mod theme;
mod widgets;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use egui::ViewportCommand;
use serde_json::json;

pub use desk::{About, ExportPage, Order, Parting, ReportFormat, Shown};
pub use headless::{ScreenshotOptions, plots, screenshot};
pub use keeper::Locks;
pub use looking::{Looking, LookingError};
pub use report::{ReportError, Side, comparison, report};
pub use settings::Settings;

use crate::figure::{Figure, Format};
use crate::lesson::{self, Acted, LessonError};
use crate::progress::{Epoch, Event, Monitor, Progress, Stopped};
use crate::recording::hold_out::HoldOut;
use crate::recording::mapping::MappingSpec;
use crate::recording::read::{self, ReadOptions};
use crate::session::file::{self, Opened};
use crate::session::{Command, History, Session, SessionError, View, runs};
use crate::training::Ending;
use crate::training::fit::Plan;
use crate::work::{Job, Outcome};
use desk::{
    Busy, Desk, Drawing, Focus, Messages, Overlaid, Panels, Question, Recent, Recents, Reporting, Templates, Tone,
};
use filed::Filed;
use keeper::Keeper;
use leaving::Leaving;
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
    /// What was done in the lesson, and is being judged.
    judging: Option<Job<Acted>>,
    keeper: Keeper,
    filed: Filed,
    recent: Recents,
    templates: Templates,
    /// Whether nobody wants to hear of what other windows left behind.
    copies_hidden: bool,
    /// How the window is being closed, once that was decided.
    leaving: Option<Leaving>,
    /// What stands in the title bar.
    title: String,
    /// Whether somebody worked on the document, and would lose that; found once a frame.
    unsaved: Vec<String>,
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
    /// Another saved session, to stand beside this one in a report.
    Beside,
    /// The file of a robot, into which a model goes.
    Robot,
}

impl Asks {
    /// Whether a field of the dialog of exports takes the answer.
    fn is_of_export(self) -> bool {
        matches!(self, Asks::Export | Asks::Beside | Asks::Robot)
    }
}

/// What a command gives.
enum Given {
    /// The session after it.
    Session(Box<Session>),
    /// What a file holds.
    Opened(Box<Opened>),
    /// Why the columns of a log could not be guessed.
    Unmapped(String),
}

/// A command at work.
struct Running {
    job: Job<Given>,
    command: Command,
    /// By which plan it trains, if it does.
    plan: Option<Plan>,
    /// What it has told so far.
    progress: Progress,
    epochs: Vec<Epoch>,
    found: Vec<String>,
    /// What did not succeed, although it goes on.
    warnings: Vec<String>,
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
                Event::Warning(warning) => self.warnings.push(warning),
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
        if let Some(folder) = Keeper::usual_place() {
            app.keep_copies(folder, Locks::default());
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
        focus.follow(&Session::default(), &session, None);
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
            judging: None,
            keeper: Keeper::default(),
            filed: Filed::default(),
            recent: Recents::default(),
            templates: Templates::default(),
            copies_hidden: false,
            leaving: None,
            title: String::new(),
            unsaved: Vec::new(),
            orders: Vec::new(),
            context: None,
        }
    }

    /// Keeps a copy of the session in this folder after every change, so that neither a crash nor a closed window costs anything;
    /// copies that others left there are offered to the user.
    pub fn keep_copies(&mut self, folder: PathBuf, locks: Locks) {
        match Keeper::with_copies(folder.clone(), locks) {
            Ok(keeper) => {
                self.keeper = keeper;
                if self.keeper.lacks_locks() {
                    let text = format!("The recovery copies are where no file can be locked: {}.", folder.display());
                    let remedy = "Of a window that crashed on this machine you are offered the copy all the same; one that another \
                                  machine left has to be opened there.";
                    self.messages.tell(Tone::Info, text, remedy);
                }
            }
            Err(error) => {
                let text = format!("No recovery copies can be kept in {}: {error}.", folder.display());
                self.messages.tell(Tone::Warning, text, "Save often, and check the folder's permissions.");
            }
        }
    }

    /// How the window looks, where its panels are and what was opened of late, to be remembered.
    pub fn settings(&self, ctx: &egui::Context) -> Settings {
        Settings::of(ctx, self.panels.layouts(), self.recent.clone(), self.templates.clone())
    }

    /// Lets the window look as it was remembered.
    pub fn restore(&mut self, settings: Settings, ctx: &egui::Context) {
        settings.apply(ctx);
        self.panels.restore(settings.layouts);
        self.recent = settings.recent;
        self.templates = settings.templates;
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
            || self.judging.is_some()
            || self.keeper.is_busy()
            || self.screens.busy().is_some()
            || self.memo.is_busy()
            || self.overlays.is_busy()
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
        self.poll_judging(ctx);
        self.poll_leaving();
        self.poll_keeper(ctx);
        self.screens.poll();
        self.memo.poll();
        let dropped: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        if !dropped.is_empty() {
            self.orders.push(Order::open(dropped));
        }
        self.orders.extend(self.overlays.shortcuts(
            ctx,
            self.history.current(),
            &self.focus,
            &self.screens,
            self.exported,
        ));
        let scale = ctx.zoom_factor();
        if !TEXT_SCALES.contains(&scale) {
            ctx.set_zoom_factor(scale.clamp(*TEXT_SCALES.start(), *TEXT_SCALES.end()));
        }
        for order in std::mem::take(&mut self.orders) {
            self.carry_out(order, ctx);
        }
        // Nobody sets up anything more before the next frame is drawn.
        let set_up = self.set_up();
        self.unsaved = self.filed.unsaved(&self.history, &set_up);
        self.hear_closing(ctx);
        self.keep_what_is_set_up(&set_up, ctx);
        let title = self.filed.title(self.history.current(), !self.unsaved.is_empty());
        if self.title != title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// What the shown screen shows, as a figure, with what is in view.
    pub fn figure(&mut self) -> Figure {
        self.at_desk(|screens, desk| {
            let panels = screens.figures(desk);
            Figure { panels: desk.focus.views.seen(panels), columns: screens.columns(desk) }
        })
    }

    /// Lets the screens do something while nothing is drawn.
    fn at_desk<T>(&mut self, act: impl FnOnce(&mut Screens, &mut Desk) -> T) -> T {
        let session = self.history.current().clone();
        let mut desk = Desk {
            session: &session,
            focus: &mut self.focus,
            memo: &mut self.memo,
            panels: &mut self.panels,
            orders: &mut self.orders,
            busy: None,
            copies: self.keeper.left_behind(),
            recent: self.recent.all(),
            templates: &self.templates,
        };
        act(&mut self.screens, &mut desk)
    }

    /// The figure of every screen that has one, as it is now, and where it is written in a folder.
    ///
    /// # Errors
    /// If it was stopped.
    pub fn pages(
        &mut self,
        format: Format,
        folder: &Path,
        monitor: &Monitor,
    ) -> Result<Vec<(PathBuf, Figure)>, Stopped> {
        let mut pages = Vec::new();
        for (number, screen) in screens::all().enumerate() {
            let done = number as f32 / screens::TABLE.len() as f32;
            monitor.report(done, &format!("asking {}", screen.title))?;
            self.show_screen(screen);
            let figure = self.figure();
            if !figure.panels.is_empty() {
                pages.push((folder.join(format!("{}.{}", screen.id, format.ending())), figure));
            }
        }
        Ok(pages)
    }

    /// Draws everything.
    pub fn draw(&mut self, ui: &mut egui::Ui) {
        let at_work = self.at_work();
        let busy = self.running.as_ref().map(|running| Busy {
            name: running.job.name(),
            progress: &running.progress,
            paused: running.job.is_paused(),
            finishing: running.finishing,
            plan: running.plan.as_ref(),
            epochs: &running.epochs,
            found: &running.found,
        });
        let session = self.history.current().clone();
        self.memo.keep_to(&session);
        let mut desk = Desk {
            session: &session,
            focus: &mut self.focus,
            memo: &mut self.memo,
            panels: &mut self.panels,
            orders: &mut self.orders,
            busy: busy.as_ref(),
            copies: self.keeper.left_behind(),
            recent: self.recent.all(),
            templates: &self.templates,
        };
        formula::prepare_later(ui.ctx(), &mut desk);
        let drawing = self.drawing.as_ref().map(|job| (job.name(), job.progress()));
        let aside = drawing.or_else(|| self.screens.at_work()).map(|(name, progress)| (name.to_owned(), progress));
        let mut shell = Shell {
            desk,
            screens: &mut self.screens,
            messages: &mut self.messages,
            exported: self.exported,
            undo: self.history.undo_text(),
            redo: self.history.redo_text(),
            copies_hidden: self.copies_hidden,
            filed: &self.filed,
            has_models_open: self.overlays.models.is_some(),
            unsaved: &self.unsaved,
            aside,
            at_work,
            is_covered: self.overlays.cover(),
            is_leaving: self.leaving.is_some(),
        };
        self.overlays.show(ui, &mut shell);
        let is_alone = !self.is_busy();
        let is_sketch = self.focus.film.end_frame(is_alone);
        ui.ctx().tessellation_options_mut(|options| options.feathering = !is_sketch);
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
                match (&mut self.running, &mut self.drawing) {
                    (Some(running), _) => running.job.stop("you pressed Stop"),
                    (None, Some(drawing)) => drawing.stop("you pressed Stop"),
                    (None, None) => self.screens.stop(),
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
            Order::Models(open) => self.overlays.models = open.then(Default::default),
            Order::KeyList(open) => self.overlays.key_list = open,
            Order::Lessons(open) => self.overlays.lessons(open, self.history.current().study.is_some()),
            Order::BeginLesson(name, seed) => {
                self.judge(ctx, move |_| lesson::begin(&lesson::catalogue::find(&name)?, seed, now()))
            }
            Order::Lesson(act) => self.judge(ctx, move |session| lesson::act(session, &act, now())),
            Order::FitAll => self.focus.views.fit_all(),
            Order::Panel(name, change) => self.panels.change(&name, &change),
            Order::NextPanel => self.panels.focus_next(ctx),
            Order::ResetPanels => self.panels.reset(),
            Order::Save(path) => match self.filed.would_overwrite(&path) {
                Some(what) => self.overlays.asking = Some(overwriting(path, &what)),
                None => self.save(path),
            },
            Order::Overwrite(path) => self.save(path),
            Order::SaveAgain => match self.filed.file() {
                Some(path) => self.carry_out(Order::Save(path.to_owned()), ctx),
                None => self.open_dialog(ctx, Asks::Save),
            },
            Order::Recover(copy) => self.recover(copy, ctx),
            Order::ThrowAway(copy) => self.keeper.throw_away(&copy),
            Order::HideCopies => self.copies_hidden = true,
            Order::Leave(parting) => self.leave(parting, ctx),
            Order::Ask(question) => self.overlays.asking = Some(*question),
            Order::SaveDialog => self.open_dialog(ctx, Asks::Save),
            Order::OpenDialog => self.open_dialog(ctx, Asks::Open),
            Order::ExportDialog => self.open_dialog(ctx, Asks::Export),
            Order::BesideDialog => self.open_dialog(ctx, Asks::Beside),
            Order::Export(only) => self.overlays.export(self.history.current(), self.screens.shown(), only),
            Order::Draw(drawing) => self.write_figure(*drawing, ctx),
            Order::AskExport(page) => self.overlays.ask_export(self.history.current(), self.screens.shown(), page),
            Order::RobotFileDialog => self.open_dialog(ctx, Asks::Robot),
            Order::WriteModel(out) => self.write_model(*out, ctx),
            Order::WriteData(out) => self.write_data(*out, ctx),
            Order::Report(reporting) => self.write_report(*reporting, ctx),
            Order::Import(paths, options) => self.overlays.import(paths, *options, ctx),
            Order::OpenBy { logs, file } => self.open_by(logs, file, ctx),
            Order::Robot { file, logs } => {
                if !logs.is_empty() {
                    self.run(Command::open(logs, ReadOptions::default(), HoldOut::default()), ctx);
                }
                self.overlays.ask_arm(file, ctx);
            }
            Order::SaveTemplate { path, text, columns } => {
                self.templates.add(columns, &path);
                self.write_text(path, text, ctx);
            }
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
        self.keep_copy();
    }

    /// The session has changed: everything that looks at it follows.
    fn follow(&mut self, before: &Session, by: Option<&Command>) {
        let after = self.history.current();
        self.memo.keep_to(after);
        self.screens.follow(before, after, by);
        if let Some(screen) = self.overlays.lesson.follow(before, after) {
            self.screens.show(screen);
        }
        self.focus.follow(before, after, by);
        self.exported &= before.has_recording_of(after);
    }

    fn keep_copy(&mut self) {
        let document = self.document();
        let note = self.note(&document, false);
        let left = self.left_beside(document.history.current().generation);
        let left = left.map(|(generation, _)| generation).collect();
        self.keeper.copy(document, note, left);
    }

    /// What somebody has set up is in the copy, too, as soon as the pointer lets go of it.
    fn keep_what_is_set_up(&mut self, set_up: &View, ctx: &egui::Context) {
        let is_settled = !ctx.input(|input| input.pointer.any_down());
        if is_settled && self.keeper.lacks(self.history.current(), set_up) {
            self.keep_copy();
        }
    }

    fn save(&mut self, path: PathBuf) {
        let document = self.document();
        if document.history.current().recording.is_none() {
            let text = "There is no recording yet, so there is nothing to save.";
            self.messages.tell(Tone::Warning, text, "");
        } else {
            self.keeper.save(path, document);
        }
    }

    /// Opens what another window left behind. It stays there until it is in the copy of this one.
    fn recover(&mut self, copy: PathBuf, ctx: &egui::Context) {
        if self.running.is_none() && !self.keeper.take(&copy) {
            let text = "The copy was not opened, because another window has it or it was thrown away.";
            self.messages.tell(Tone::Warning, text, "");
            return;
        }
        self.run(Command::Restore { path: copy }, ctx);
    }

    /// Where one looks.
    fn view(&self) -> View {
        View {
            screen: self.screens.shown().id.to_owned(),
            trajectory: self.focus.trajectory,
            joint: self.focus.joint,
            layouts: serde_json::to_value(self.panels.layouts()).unwrap_or_default(),
            sight: json!({ "focus": self.focus.in_sight(), "screens": self.screens.setup() }),
            ..self.set_up()
        }
    }

    /// What somebody has set up to be looked at.
    fn set_up(&self) -> View {
        let models = || self.history.current().all_models();
        let shown = |shown| models().find(|model| model.generation == shown).cloned();
        let overlaid = self.focus.overlaid.shown().filter_map(shown).collect();
        View { overlaid, setup: self.focus.setup(), ..View::default() }
    }

    /// Looks where somebody looked.
    fn look(&mut self, mut view: View) {
        if let Ok(screen) = screens::find(&view.screen) {
            self.screens.show(screen);
            self.focus.show_trajectory(view.trajectory);
            self.focus.joint = view.joint;
        }
        self.focus.overlaid = Overlaid::of(view.overlaid.iter().map(|model| model.generation));
        if let Some(recording) = &self.history.current().recording {
            self.focus.look_as(view.setup, view.sight["focus"].take(), recording);
        }
        // What another program wrote there is passed over.
        self.screens.set_up(serde_json::from_value(view.sight["screens"].take()).unwrap_or_default());
        if let Ok(layouts) = serde_json::from_value(view.layouts) {
            self.panels.restore(layouts);
        }
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
            match command.run(&session, &Monitor::new()) {
                Ok(session) => self.accept(Given::Session(Box::new(session)), &command, ctx),
                Err(error) => self.fail(&command, error.to_string()),
            }
            return;
        }
        let plan = command.plan(&session).cloned();
        let checkpoint_file = plan.is_some().then(|| self.keeper.begin_training()).flatten();
        let session = Session { checkpoint_file, ..session };
        let (context, work) = (ctx.clone(), command.clone());
        let wake = move || context.request_repaint();
        let job = Job::spawn(command.title(), wake, move |monitor| match &work {
            Command::Restore { path } => {
                let Opened { document, mark, instead } = file::open(path, monitor)?;
                let document = document.knowing(&session.own_effects);
                Ok(Given::Opened(Box::new(Opened { document, mark, instead })))
            }
            _ => match work.run(&session, monitor) {
                Err(SessionError::Read(problem)) if problem.is_about_columns() => {
                    Ok(Given::Unmapped(problem.to_string()))
                }
                given => given.map(Box::new).map(Given::Session),
            },
        });
        let progress = Progress::default();
        let (epochs, found, warnings) = (Vec::new(), Vec::new(), Vec::new());
        self.running = Some(Running { job, command, plan, progress, epochs, found, warnings, finishing: false });
    }

    fn poll_job(&mut self, ctx: &egui::Context) {
        let Some(running) = &mut self.running else { return };
        let outcome = running.job.poll();
        // After that: nothing is missed of what it told just before its end.
        running.hear();
        for warning in running.warnings.drain(..) {
            self.messages.tell(Tone::Warning, widgets::sentence_case(&warning) + ".", "");
        }
        let Some(outcome) = outcome else { return };
        let Some(Running { command, plan, .. }) = self.running.take() else { return };
        let is_done = matches!(outcome, Outcome::Done(_));
        match outcome {
            Outcome::Done(given) => self.accept(given, &command, ctx),
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
        if !is_done && matches!(command, Command::Restore { .. }) {
            self.keeper.give_back();
        }
        // A window that is being closed leaves the training to the next one.
        if plan.is_some() && !matches!(self.leaving, Some(Leaving::Decided)) {
            self.keeper.end_training();
        }
    }

    fn accept(&mut self, given: Given, command: &Command, ctx: &egui::Context) {
        let before = self.history.current().clone();
        self.messages.forget_what_is_past();
        match given {
            Given::Session(session) => self.accept_session(*session, &before, command, ctx),
            Given::Opened(opened) => self.accept_opened(*opened, &before, command, ctx),
            Given::Unmapped(problem) => {
                self.fail(command, problem);
                return self.ask_for_columns(command);
            }
        }
        self.recent_of(command);
    }

    fn accept_session(&mut self, session: Session, before: &Session, command: &Command, ctx: &egui::Context) {
        // Where it kept itself while it was at work concerns nobody any more.
        let session = Session { checkpoint_file: None, ..session };
        if !matches!(command, Command::BetFirst(_) | Command::PlaceBet(_) | Command::Learn(_)) {
            let (tone, text) = done_text(before, &session, command);
            self.messages.toast(tone, text, ctx);
        }
        if command.trains(&session)
            && let Some(step) = session.current()
            && let (Some(Ending::Failed(_)), Some(reason)) = (&step.ending, step.early_end())
        {
            let text = format!("Training ended early: {reason}; they are the model now.");
            self.messages.tell(Tone::Warning, text, "Undo brings back the model before it.");
        }
        if command.begins_anew() {
            self.filed.leave(&self.history, &self.set_up());
            self.filed.begin(true, session.generation);
        }
        match command.is_final() {
            true => self.history.settle(session),
            false => self.history.push(session, &command.title()),
        }
        self.follow(before, Some(command));
        self.keep_copy();
    }

    fn accept_opened(&mut self, opened: Opened, before: &Session, command: &Command, ctx: &egui::Context) {
        let Command::Restore { path } = command else { return };
        let Opened { document, mark, instead } = opened;
        self.filed.leave(&self.history, &self.set_up());
        self.history.open(document.history, &command.title());
        let generation = self.history.current().generation;
        let copy = self.keeper.taken().filter(|copy| copy.path == *path).cloned();
        let (tone, text) = done_text(before, self.history.current(), command);
        self.messages.toast(tone, text, ctx);
        self.follow(before, Some(command));
        self.look(document.view);
        match &copy {
            Some(_) => {
                self.filed.begin(false, generation);
                self.keeper.restored(generation);
            }
            // What is left of a file is in none.
            None if crate::file::owner(path).is_some() => self.filed.begin(false, generation),
            None => self.filed.is_in(path, mark, instead.is_none().then(|| (generation, self.set_up()))),
        }
        self.keep_copy();
        if let Some(run) = copy.and_then(|copy| copy.run()) {
            self.offer_training(&run);
        }
    }

    /// A training was at work when its window ended: it can go on. Its checkpoint goes with the copy that was restored, so it is
    /// taken over first.
    fn offer_training(&mut self, path: &Path) {
        let run = match runs::load(path) {
            Ok(run) => Arc::new(run),
            Err(error) => {
                let text = format!("A training was at work on this session, but {error}.");
                return self.messages.tell(Tone::Warning, text, "Start it anew.");
            }
        };
        if let Some(own) = self.keeper.begin_training() {
            // Should this fail, the answer to the question comes before the next end.
            let _ = runs::save(&run, &own);
        }
        let done = run.checkpoint.epoch;
        self.overlays.asking = Some(Question {
            title: "Go on with the training?".to_owned(),
            text: format!("When this session was left, a training was at work. Its checkpoint has {done} epochs."),
            choices: vec![(format!("Go on from epoch {done}"), Order::run(Command::Resume(run)))],
            otherwise: "Not now".to_owned(),
        });
    }

    /// Remembers what a command opened, for the next start.
    fn recent_of(&mut self, command: &Command) {
        // A copy that was restored is gone by then.
        let is_copy = matches!(command, Command::Restore { .. }) && self.filed.file().is_none();
        if let Some(newest) = Recent::of(command).filter(|_| !is_copy) {
            self.recent.add(newest);
        }
    }

    /// Remembers a file that was saved.
    fn remember(&mut self, path: &Path) {
        if let Some(newest) = Recent::of(&Command::Restore { path: path.to_owned() }) {
            self.recent.add(newest);
        }
    }

    fn fail(&mut self, command: &Command, message: String) {
        let text = format!("Could not {}: {message}.", command.title());
        self.messages.tell(Tone::Error, text, "Nothing was changed.");
    }

    /// The columns of a log could not be guessed: somebody may know what they are.
    fn ask_for_columns(&mut self, command: &Command) {
        if let Command::Open { paths, options, .. } = command {
            let text = if paths.len() == 1 { "Say what its columns are…" } else { "Say what their columns are…" };
            self.messages.offer(text, Order::Import(paths.clone(), Box::new(options.clone())));
        }
    }

    /// Opens logs by a mapping: those that come with it, else the one that the assistant looks into, else those that are open. What
    /// is no mapping is an effect of one's own.
    fn open_by(&mut self, logs: Vec<PathBuf>, file: PathBuf, ctx: &egui::Context) {
        let text = crate::file::read_text(&file).unwrap_or_default();
        if !MappingSpec::is_meant_by(&text) {
            return self.run(Command::LoadEffect { path: file }, ctx);
        }
        let spec = match MappingSpec::from_toml(&text) {
            Ok(spec) => spec,
            Err(error) => {
                let text = format!("{} can't be used: {error}.", file.display());
                return self.messages.tell(Tone::Error, text, "Mend it there, and open it again. Nothing was changed.");
            }
        };
        let by_it = |options: &ReadOptions| options.clone().by(spec.clone());
        let looked_into = self.overlays.importing.take().map(|open| open.opening(spec.clone()));
        let source = self.history.current().source.clone();
        let again = || source.as_ref().and_then(|source| Command::read_again(source, by_it(&source.options)));
        let command = match logs.is_empty() {
            true => looked_into.or_else(again),
            false => Some(Command::open(logs, by_it(&ReadOptions::default()), HoldOut::default())),
        };
        match command {
            Some(command) => self.run(command, ctx),
            None => {
                let text = format!("{} says what the columns of a log are, and no log is open.", file.display());
                self.messages.tell(Tone::Warning, text, "Open the log first, or drop both onto the window at once.");
            }
        }
    }

    fn write_figure(&mut self, drawing: Drawing, ctx: &egui::Context) {
        let context = ctx.clone();
        let wake = move || context.request_repaint();
        let (session, screens, focus) = (self.history.current().clone(), self.screens.copy(), self.focus.clone());
        self.drawing = Some(Job::spawn("export", wake, move |monitor| {
            let Drawing { figure, format, style, path } = drawing;
            let is_folder = figure.is_none();
            let figures = match figure {
                Some(figure) => vec![(path.clone(), figure)],
                None => {
                    let mut app = TorquescopeApp { screens, focus, ..TorquescopeApp::new(session) };
                    app.pages(format, &path, &monitor.part(0.0..0.5)).map_err(|stopped| stopped.to_string())?
                }
            };
            let mut files = Vec::new();
            for (number, (path, figure)) in figures.iter().enumerate() {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let done = 0.5 + 0.4 * number as f32 / figures.len() as f32;
                monitor.report(done, &format!("drawing {name}")).map_err(|stopped| stopped.to_string())?;
                let drawn = crate::figure::files_that_fit(figure, format, &style, path);
                let (drawn, fewer) = drawn.map_err(|error| error.to_string())?;
                if let Some(dpi) = fewer {
                    monitor.tell(Event::Warning(format!("{name} has {dpi} pixels an inch: more would be too many")));
                }
                files.extend(drawn);
            }
            // From here on it is not stopped any more: either all files are there, or none.
            monitor.report(0.9, "writing").map_err(|stopped| stopped.to_string())?;
            if is_folder {
                std::fs::create_dir_all(&path)
                    .map_err(|error| format!("{} can't be made ({error})", path.display()))?;
            }
            for (path, bytes) in files {
                crate::file::write(&path, &bytes)
                    .map_err(|error| format!("{} can't be written ({error})", path.display()))?;
            }
            Ok::<_, String>(path)
        }));
    }

    fn write_text(&mut self, path: PathBuf, text: String, ctx: &egui::Context) {
        let context = ctx.clone();
        let wake = move || context.request_repaint();
        self.drawing =
            Some(Job::spawn("write", wake, move |_| match crate::file::write_keeping_old(&path, text.as_bytes()) {
                Ok(()) => Ok(crate::file::absolute(&path)),
                Err(error) => Err(format!("{} can't be written ({error})", path.display())),
            }));
    }

    /// Writes the report of the session, or of it beside another one that was saved.
    fn write_report(&mut self, reporting: Reporting, ctx: &egui::Context) {
        let context = ctx.clone();
        let wake = move || context.request_repaint();
        let session = self.history.reported();
        let name = self.filed.name(&session);
        self.drawing = Some(Job::spawn("report", wake, move |monitor| {
            let Reporting { format, path, beside } = reporting;
            let page = match beside {
                None => report(&session, format, monitor),
                Some(file) => {
                    let opened = file::open(&file, &monitor.part(0.0..0.2)).map_err(|error| error.to_string())?;
                    let beside = opened.document.knowing(&session.own_effects).history.reported();
                    let other = file.file_stem().unwrap_or_default().to_string_lossy();
                    let sides = [(name.as_str(), &session), (&*other, &beside)];
                    comparison(sides, format, &monitor.part(0.2..1.0))
                }
            };
            let page = page.map_err(|error| error.to_string())?;
            match crate::file::write(&path, &page) {
                Ok(()) => Ok(crate::file::absolute(&path)),
                Err(error) => Err(format!("{} can't be written ({error})", path.display())),
            }
        }));
    }

    /// Lets a lesson judge what was done in it; what is to be written down follows.
    fn judge(
        &mut self,
        ctx: &egui::Context,
        work: impl FnOnce(&Session) -> Result<Acted, LessonError> + Send + 'static,
    ) {
        if self.judging.is_some() {
            return;
        }
        let (context, session) = (ctx.clone(), self.history.current().clone());
        let wake = move || context.request_repaint();
        self.judging = Some(Job::spawn("judge the lesson", wake, move |_| work(&session)));
    }

    fn poll_judging(&mut self, ctx: &egui::Context) {
        let Some(outcome) = self.judging.as_mut().and_then(Job::poll) else { return };
        self.judging = None;
        self.overlays.lesson.lacks = None;
        match outcome {
            Outcome::Done(Acted { command, lacks }) => {
                self.run(command, ctx);
                self.overlays.lesson.lacks = lacks;
            }
            Outcome::Failed(message) | Outcome::Stopped(message) | Outcome::Panicked(message) => {
                self.overlays.lesson.lacks = Some(message);
            }
        }
    }

    fn poll_drawing(&mut self, ctx: &egui::Context) {
        let Some(job) = &mut self.drawing else { return };
        // All that it told before its end is there once its end is.
        let outcome = job.poll();
        for event in job.events() {
            if let Event::Warning(text) = event {
                self.messages.tell(Tone::Warning, format!("{text}."), "");
            }
        }
        let Some(outcome) = outcome else { return };
        self.drawing = None;
        match outcome {
            Outcome::Done(path) => {
                self.messages.toast(Tone::Info, format!("Exported: {}.", path.display()), ctx);
                self.exported = true;
            }
            Outcome::Stopped(reason) => {
                self.messages.tell(Tone::Info, format!("Nothing was exported, because {reason}."), "");
            }
            Outcome::Failed(message) | Outcome::Panicked(message) => {
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
        let name = self.proposed_file();
        let exported = self.overlays.exporting.as_ref().map_or(String::new(), |exporting| exporting.path().to_owned());
        let job = Job::spawn("choose files", wake, move |_| {
            let dialog = rfd::FileDialog::new();
            Ok::<_, String>(match asks {
                Asks::Save => {
                    let dialog = dialog.set_title("Save the session").set_file_name(name);
                    dialog.add_filter("sessions", &[file::ENDING]).save_file().map(|path| vec![path])
                }
                Asks::Export => dialog.set_title("Export").set_file_name(exported).save_file().map(|path| vec![path]),
                Asks::Beside => {
                    let dialog = dialog.set_title("Choose the other session");
                    dialog.add_filter("sessions", &[file::ENDING]).pick_file().map(|path| vec![path])
                }
                Asks::Robot => {
                    let dialog = dialog.set_title("Choose the robot's file");
                    dialog.add_filter("robots", &["urdf", "xml"]).pick_file().map(|path| vec![path])
                }
                Asks::Open => {
                    let endings: Vec<&str> = read::endings().chain([file::ENDING, "toml", "urdf", "xml"]).collect();
                    let dialog = dialog.set_title("Open recordings, a session, a mapping, a robot or an effect");
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
                // Whether to overwrite a file the system has asked, but not whether somebody else has changed it meanwhile.
                (Asks::Save, _) => {
                    let path = paths.remove(0);
                    let is_known = self.filed.knows(&path);
                    self.orders.push(if is_known { Order::Save(path) } else { Order::Overwrite(path) });
                }
                (Asks::Export, Some(exporting)) => exporting.set_path(&paths[0]),
                (Asks::Beside, Some(exporting)) => exporting.set_beside(&paths[0]),
                (Asks::Robot, Some(exporting)) => exporting.set_robot(&paths[0]),
                (Asks::Export | Asks::Beside | Asks::Robot, None) => (),
            },
            Outcome::Done(_) if !at_once => (),
            _ => {
                let text = "This system shows no file dialog.";
                let remedy = match asks.is_of_export() {
                    true => "Type the path into the field.",
                    false => "Type the path into the field on the Data screen, or drop the file onto the window.",
                };
                self.messages.tell(Tone::Warning, text, remedy);
                if !asks.is_of_export() {
                    self.screens.show(&screens::data::ABOUT);
                }
            }
        }
    }
}

/// What the clock says \[s since 1970\].
pub fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

/// Before a file is overwritten that is not as this window knows it.
fn overwriting(path: PathBuf, what: &str) -> Question {
    let (name, old) = (path.file_name().unwrap_or_default().to_string_lossy(), crate::file::old(&path));
    Question {
        title: format!("Overwrite {name}?"),
        text: format!("{what} What it is now stays beside it as {}.", old.file_name().unwrap_or_default().display()),
        choices: vec![
            ("Overwrite it".to_owned(), Order::Overwrite(path)),
            ("Save elsewhere…".to_owned(), Order::SaveDialog),
        ],
        otherwise: "Cancel".to_owned(),
    }
}

/// What was done, to which model, and how its error changed; an error that rose is no good news.
fn done_text(before: &Session, after: &Session, command: &Command) -> (Tone, String) {
    let title = widgets::sentence_case(&command.title());
    let error = |session: &Session| {
        let errors = session.current()?.evaluation.held_out_nmse();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        mean.is_finite().then_some(mean)
    };
    match (error(before), error(after), after.current()) {
        (Some(from), Some(to), Some(step)) if from != to && before.has_recording_of(after) => {
            let percent = plot::ticks::percent;
            let tone = if to < from { Tone::Info } else { Tone::Warning };
            let verb = if to < from { "fell" } else { "rose" };
            let (from, to, name) = (percent(from), percent(to), &step.name);
            (tone, format!("{title}: mean held-out error {verb} {from} → {to} ({name})."))
        }
        _ => (Tone::Info, format!("{title}: done.")),
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

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.close();
    }

    fn persist_egui_memory(&self) -> bool {
        false
    }
}
