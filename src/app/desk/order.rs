//! What a click asks for; carried out before the next frame.

use std::path::PathBuf;
use std::sync::Arc;

use super::about::About;
use super::export_page::ExportPage;
use super::notice::Notice;
use super::panels::Change;
use super::paper::ReportFormat;
use super::question::Question;
use super::shown::Shown;
use crate::arm::robot;
use crate::export::outgoing::Wish;
use crate::export::part::Part;
use crate::figure::{Figure, Format, Style};
use crate::lesson::Act;
use crate::model::Preset;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::ReadOptions;
use crate::session::{Command, Step};

/// What a click asks for; carried out before the next frame.
#[derive(Debug, Clone)]
pub enum Order {
    /// Change the session.
    Run(Box<Command>),
    /// Show a screen.
    Show(&'static About),
    /// Take back the last change.
    Undo,
    /// Do it again.
    Redo,
    /// Stop the running job; nothing of it is kept.
    Stop,
    /// Let the running job end with what it has.
    Finish,
    /// Let the running job wait, or go on.
    Pause(bool),
    /// Between light and dark.
    ToggleTheme,
    /// Simulate an arm in which something is hidden by the next seed.
    DrawMystery,
    /// Choose what is to be trained.
    PlanTraining(Preset),
    /// Save the session into this file; if that would overwrite what somebody else wrote there, it is asked about.
    Save(PathBuf),
    /// Save the session into this file, whatever is there.
    Overwrite(PathBuf),
    /// Save the session into the file that it is from; if there is none, let the user choose.
    SaveAgain,
    /// Let the user choose where to save.
    SaveDialog,
    /// Open a copy that another window left behind.
    Recover(PathBuf),
    /// Throw a copy away that another window left behind.
    ThrowAway(PathBuf),
    /// Say no more of the copies that others left behind. They stay.
    HideCopies,
    /// Close the window, or not.
    Leave(Parting),
    /// Ask before something is done that can't be taken back.
    Ask(Box<Question>),
    /// Look into logs of one arm, and let the user say what their columns are.
    Import(Vec<PathBuf>, Box<ReadOptions>),
    /// Open logs as a mapping file says, or take a file as what it is otherwise.
    OpenBy {
        /// The logs; none for the one that is open.
        logs: Vec<PathBuf>,
        /// What is written in TOML.
        file: PathBuf,
    },
    /// Ask which joints of a robot were recorded.
    Robot {
        /// A URDF or MJCF.
        file: PathBuf,
        /// Logs that are opened first; none for the one that is open.
        logs: Vec<PathBuf>,
    },
    /// Write a mapping file, and remember it for logs of these columns; what it was stays beside it.
    SaveTemplate {
        /// The file.
        path: PathBuf,
        /// What it says.
        text: String,
        /// Names of the columns that it was made for.
        columns: Vec<String>,
    },
    /// Let the user choose files.
    OpenDialog,
    /// More contrast, or as usual.
    HighContrast(bool),
    /// Between high and usual contrast.
    ToggleContrast,
    /// Size of text and everything else, 0.8 to 2.
    TextScale(f32),
    /// Open or close the command palette.
    Palette(bool),
    /// Open or close the table of the session's models.
    Models(bool),
    /// Open or close the list of lessons.
    Lessons(bool),
    /// Begin the lesson of this name, for the student of this seed.
    BeginLesson(String, u64),
    /// Do something in the lesson.
    Lesson(Act),
    /// Open or close the list of shortcuts.
    KeyList(bool),
    /// Look at the results of an experiment.
    Experiment(Shown),
    /// Ask how to export the plots of the screen, or the one of this title.
    Export(Option<String>),
    /// Let the user choose where to export.
    ExportDialog,
    /// Write plots into a file.
    Draw(Box<Drawing>),
    /// Let the user choose the session that is to stand beside this one.
    BesideDialog,
    /// Let the user choose the file of a robot into which a model goes.
    RobotFileDialog,
    /// Ask how to export what this page is about.
    AskExport(ExportPage),
    /// Write a model into files.
    WriteModel(Box<ModelOut>),
    /// Write data into files.
    WriteData(Box<DataOut>),
    /// Write a report.
    Report(Box<Reporting>),
    /// Show, hide or move a panel of the screen.
    Panel(String, Change),
    /// The focus goes to the next panel.
    NextPanel,
    /// Put the panels of the screen back where they stood at first.
    ResetPanels,
    /// All charts show everything.
    FitAll,
    /// Say something.
    Tell(Notice),
    /// Remove a message.
    Dismiss(usize),
}

/// How the window is left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Parting {
    /// Save the session into this file first; a training ends with the best that it has.
    Save(PathBuf),
    /// The next window is offered a copy of it.
    KeepCopy,
    /// Not at all.
    Stay,
}

/// Plots, and the file that shows them.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// What is drawn; `None` for the plots of every screen, a file for each in a folder.
    pub figure: Option<Figure>,
    /// As what.
    pub format: Format,
    /// How.
    pub style: Style,
    /// Where: the file, or the folder.
    pub path: PathBuf,
}

/// A report of the session, and its file.
#[derive(Debug, Clone)]
pub struct Reporting {
    /// As what.
    pub format: ReportFormat,
    /// Where.
    pub path: PathBuf,
    /// A saved session that stands beside it, if one does.
    pub beside: Option<PathBuf>,
}

/// A model, and its files.
#[derive(Debug, Clone)]
pub struct ModelOut {
    /// The model.
    pub model: Arc<Step>,
    /// As what, and where.
    pub wish: Wish,
}

/// Data, and their file.
#[derive(Debug, Clone)]
pub struct DataOut {
    /// The model whose torques are written; `None` for the recording itself.
    pub torques_of: Option<Arc<Step>>,
    /// Of which part.
    pub part: Part,
    /// Where; the ending says as what.
    pub path: PathBuf,
}

impl Order {
    /// Change the session.
    pub fn run(command: Command) -> Self {
        Order::Run(Box::new(command))
    }

    /// Open these files as one recording, by a mapping file if there is one among them, or a single one as what it is otherwise: a
    /// saved session, a mapping or the robot's file (URDF, MJCF) of the log that is open, an effect of one's own.
    pub fn open(mut paths: Vec<PathBuf>) -> Self {
        if let Some(place) = paths.iter().position(|path| robot::is_named_like_one(path)) {
            return Order::Robot { file: paths.remove(place), logs: paths };
        }
        let is_toml = |path: &PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        match paths.iter().position(is_toml) {
            Some(place) => Order::OpenBy { file: paths.remove(place), logs: paths },
            None => Order::run(Command::open(paths, ReadOptions::default(), HoldOut::default())),
        }
    }
}
