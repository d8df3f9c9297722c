//! What surrounds every screen: the tools, the way through, messages and status.

mod actions;
mod ask;
mod bar;
mod data_out;
mod ending;
mod export;
mod filter;
mod flow;
mod frame;
mod hanging;
mod importing;
mod keys;
mod law;
mod lesson;
mod messages;
mod model_out;
mod models;
mod palette;
mod preview;
mod primary;
mod reporting;
mod robot;
mod status;
mod topics;
mod which_model;

use std::path::PathBuf;

use egui::{CentralPanel, Context, Frame, Margin, Panel, Ui};

use ask::Closing;
use export::Exporting;
pub use frame::Shell;
use importing::Importing;
use lesson::LessonPanel;
use models::Models;
use palette::CommandPalette;
use robot::RobotFile;

use super::desk::{About, ExportPage, Focus, Order, Question};
use super::screens::Screens;
use super::theme::{GROUP, Palette};
use super::widgets::is_narrow;
use crate::recording::read::ReadOptions;
use crate::session::Session;

/// What lies over the screens while it is open.
#[derive(Default)]
pub struct Overlays {
    /// Every command by its name.
    pub palette: Option<CommandPalette>,
    /// All models of the session.
    pub models: Option<Models>,
    /// Whether the list of shortcuts is open.
    pub key_list: bool,
    /// How plots, a report, a model or data are exported.
    pub exporting: Option<Exporting>,
    /// What the columns of a log are.
    pub importing: Option<Importing>,
    /// Which joints of a robot's file were recorded.
    pub robot: Option<RobotFile>,
    /// What is asked before it is done.
    pub asking: Option<Question>,
    /// Whether the window is to be closed, and how.
    pub closing: Option<Closing>,
    /// The lesson that is taken, and the list of all.
    pub lesson: LessonPanel,
}

impl Overlays {
    /// Asks how to export the plots of a screen, or one of them.
    pub fn export(&mut self, session: &Session, screen: &About, only: Option<String>) {
        self.exporting = Some(Exporting::new(session, screen, only));
    }

    /// Asks how to export what this page is about.
    pub fn ask_export(&mut self, session: &Session, screen: &About, page: ExportPage) {
        self.exporting = Some(Exporting::at(page, session, screen));
    }

    /// Looks into logs of one arm, to ask what their columns are.
    pub fn import(&mut self, paths: Vec<PathBuf>, options: ReadOptions, ctx: &Context) {
        self.importing = Some(Importing::new(paths, options, ctx));
    }

    /// Asks which joints of a robot's file were recorded.
    pub fn ask_arm(&mut self, path: PathBuf, ctx: &Context) {
        self.robot = Some(RobotFile::new(path, ctx));
    }

    /// Asks whether to close the window; the session would go into this file.
    pub fn ask_closing(&mut self, path: String) {
        self.closing.get_or_insert(Closing { path });
    }

    /// Whether something is drawn for a dialog.
    pub fn is_busy(&self) -> bool {
        self.exporting.as_ref().is_some_and(Exporting::is_busy)
            || self.importing.as_ref().is_some_and(Importing::is_busy)
            || self.robot.as_ref().is_some_and(RobotFile::is_busy)
    }

    /// Opens the list of lessons, or brings back the lesson that was hidden, or closes the list.
    pub fn lessons(&mut self, open: bool, is_taken: bool) {
        if is_taken && self.lesson.hidden {
            self.lesson.hidden = false;
        } else {
            self.lesson.choosing = open.then(Default::default);
        }
    }

    /// Whether a dialog lies over the screens.
    pub fn cover(&self) -> bool {
        let looks_into = self.importing.is_some() || self.robot.is_some();
        let asks = self.asking.is_some() || self.closing.is_some() || self.exporting.is_some() || looks_into;
        asks || self.palette.is_some() || self.key_list || self.lesson.choosing.is_some()
    }

    /// The orders that were given by keys.
    pub fn shortcuts(
        &self,
        ctx: &Context,
        session: &Session,
        focus: &Focus,
        screens: &Screens,
        exported: bool,
    ) -> Vec<Order> {
        let open = keys::Open {
            palette: self.palette.is_some(),
            key_list: self.key_list,
            models: self.models.is_some(),
            exporting: self.exporting.is_some(),
            asking: self.asking.is_some()
                || self.closing.is_some()
                || self.importing.is_some()
                || self.robot.is_some()
                || self.lesson.choosing.is_some(),
        };
        keys::shortcuts(ctx, open, || flow::next(session, focus, screens, exported))
    }

    /// Draws the whole window.
    pub fn show(&mut self, ui: &mut Ui, shell: &mut Shell) {
        let palette = Palette::in_ui(ui);
        let bar = |x, y| Frame::new().fill(palette.card).inner_margin(Margin::symmetric(x, y));
        Panel::top("tools").frame(bar(14, 4)).resizable(false).show(ui, |ui| bar::tools(ui, shell));
        Panel::top("way").frame(bar(14, 5)).resizable(false).show(ui, |ui| bar::way(ui, shell));
        Panel::bottom("status").frame(bar(14, 4)).resizable(false).show(ui, |ui| status::show(ui, shell));
        if let Some(open) = self.models.as_mut().filter(|_| shell.desk.session.recording.is_some()) {
            Panel::bottom("models").frame(bar(14, 6)).resizable(false).show(ui, |ui| models::show(ui, shell, open));
        }
        lesson::show(ui, shell, &mut self.lesson);
        let room = if is_narrow(ui) { GROUP / 2.0 } else { GROUP };
        // The window is cleared with the ground's colour; painting it once more costs as much as all the rest without a graphics card.
        let ground = Frame::new().inner_margin(Margin::same(room as i8));
        CentralPanel::default().frame(ground).show(ui, |ui| {
            messages::notices(ui, shell);
            shell.screens.ui(ui, &mut shell.desk);
        });
        export::show(ui, shell, &mut self.exporting);
        importing::show(ui, shell, &mut self.importing);
        robot::show(ui, shell, &mut self.robot);
        messages::toasts(ui, shell);
        messages::drop_hint(ui);
        palette::show(ui, shell, &mut self.palette);
        keys::list(ui, &mut self.key_list);
        lesson::list(ui, shell, &mut self.lesson.choosing);
        ask::question(ui, shell, &mut self.asking);
        ask::closing(ui, shell, &mut self.closing);
    }
}
