//! What a screen is: a value that owns its memory, draws itself, and says what comes after it.

use egui::Ui;
use serde_json::Value;

use super::desk::{About, Desk, Focus, Order};
use crate::figure::Panel;
use crate::progress::Progress;
use crate::session::{Command, Session};

/// A screen of the window. What it remembers from one frame to the next is its own; what it shares with the others is on the
/// [`Desk`].
pub trait Screen: Send {
    /// Draws it. There is what it [`needs`](About::needs).
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk);

    /// What it shows, as figures: the window prints them, and so do files, without a window.
    fn figures(&self, desk: &mut Desk) -> Vec<Panel>;

    /// How many of its figures stand beside each other where nobody says.
    fn columns(&self, _desk: &Desk) -> usize {
        1
    }

    /// What it shows in another way than at first if somebody asks for it by name.
    fn switches<'a>(&'a mut self, _desk: &mut Desk) -> Vec<Switch<'a>> {
        Vec::new()
    }

    /// The same screen as it looks now, without its jobs: a thread asks it for its figures.
    fn copy(&self) -> Box<dyn Screen>;

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

    /// How it is set up, as a file of the session keeps it; null if there is nothing to keep.
    fn setup(&self) -> Value {
        Value::Null
    }

    /// Is set up as a file tells; what another program wrote there is passed over.
    fn set_up(&mut self, _setup: Value) {}

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

/// Something that a screen shows in another way than at first, by name: a check box or a chooser of the window, and what
/// `figure --show` asks for.
pub struct Switch<'a> {
    /// Its name.
    pub name: &'static str,
    /// What can stand behind its name as in `name=value`; where nothing can, the name is all.
    pub values: Vec<String>,
    turn: Turn<'a>,
}

/// Shows it, with what stands behind its name.
type Turn<'a> = Box<dyn FnOnce(Option<&str>) + 'a>;

impl<'a> Switch<'a> {
    /// What is shown or not.
    pub fn on(name: &'static str, shown: &'a mut bool) -> Self {
        Switch::that(name, || *shown = true)
    }

    /// What does something.
    pub fn that(name: &'static str, turn: impl FnOnce() + 'a) -> Self {
        Switch { name, values: Vec::new(), turn: Box::new(|_| turn()) }
    }

    /// What one of several values can be chosen for, or none.
    pub fn one_of(
        name: &'static str,
        values: impl IntoIterator<Item = impl Into<String>>,
        turn: impl FnOnce(Option<&str>) + 'a,
    ) -> Self {
        Switch { name, values: values.into_iter().map(Into::into).collect(), turn: Box::new(turn) }
    }

    /// All that can be asked for of it: `grid`, `grid=torque`.
    pub fn words(&self) -> Vec<String> {
        let with_value = self.values.iter().map(|value| format!("{}={value}", self.name));
        [self.name.to_owned()].into_iter().chain(with_value).collect()
    }

    /// Turns it, if it is what is asked for; whether it is.
    pub fn turn(self, asked: &str) -> bool {
        let value = asked.strip_prefix(self.name);
        match value.map(|rest| rest.strip_prefix('=')) {
            Some(None) if asked == self.name => (self.turn)(None),
            Some(Some(value)) if self.values.iter().any(|known| known == value) => (self.turn)(Some(value)),
            _ => return false,
        }
        true
    }
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
