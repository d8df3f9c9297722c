//! What a screen is: a value that owns its memory, draws itself, and says what comes after it.

use egui::Ui;

use super::desk::{About, Desk, Focus, Order};
use crate::figure::Panel;
use crate::progress::Progress;
use crate::session::{Command, Session};

/// A screen of the window. What it remembers from one frame to the next is its own; what it shares with the others is on the
/// [`Desk`].
pub trait Screen {
    /// Draws it. There is what it [`needs`](About::needs).
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk);

    /// What it shows, as figures: the window prints them, and so do files, without a window.
    fn figures(&self, desk: &mut Desk) -> Vec<Panel>;

    /// Whether its work is behind.
    fn is_done(&self, session: &Session) -> bool;

    /// What to do next from here.
    fn next(&self, _session: &Session, _focus: &Focus) -> Next {
        Next::OnTheWay
    }

    /// Whether it keeps an answer back until the user has guessed, so that nothing else may tell it.
    fn withholds(&self, _session: &Session) -> bool {
        false
    }

    /// Whether what this command did is seen here, so that this screen comes to the front.
    fn answers(&self, _command: &Command) -> bool {
        false
    }

    /// Takes notice of an order, whoever carries it out; gives orders of its own for it.
    fn hear(&mut self, _order: &Order) -> Vec<Order> {
        Vec::new()
    }

    /// The session has changed: by a command, or by undo and redo.
    fn follow(&mut self, _before: &Session, _after: &Session, _by: Option<&Command>) {}

    /// Receives what its own jobs have, also while it is not shown.
    fn poll(&mut self) {}

    /// Whether a job of its own is at work.
    fn is_busy(&self) -> bool {
        false
    }

    /// Its job that takes long enough to be told of on every screen: a name, and how far it is.
    fn at_work(&self) -> Option<(&str, Progress)> {
        None
    }

    /// Stops that job.
    fn stop(&mut self) {}
}

/// What comes after a screen.
pub enum Next {
    /// The next screen on the way.
    OnTheWay,
    /// Something to be done here, or another screen.
    Step(NextStep),
    /// The end of the way: to take the plots along.
    Export,
}

/// What to do next, as the highlighted button says it.
pub struct NextStep {
    /// A few words.
    pub label: String,
    /// Why, for the tool tip.
    pub why: &'static str,
    /// What the click does.
    pub order: Order,
}

impl NextStep {
    /// Another screen.
    pub fn show(screen: &'static About) -> Self {
        NextStep { label: screen.title.to_owned(), why: screen.purpose, order: Order::Show(screen) }
    }

    /// A change of the session.
    pub fn run(label: impl Into<String>, why: &'static str, command: Command) -> Self {
        NextStep { label: label.into(), why, order: Order::run(command) }
    }
}
