//! The screens, left to right as one goes through them. A new screen is one file or folder and one line in [`TABLE`].

pub mod compare;
pub mod data;
pub mod diagnose;
pub mod experiment;
pub mod extrapolation;
pub mod ladder;
pub mod model;
pub mod residuals;
pub mod train;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use egui::Ui;
use serde_json::Value;

use super::desk::{About, Desk, Needs, Order};
use super::screen::Screen;
use super::{formula, widgets};
use crate::figure::Panel;
use crate::progress::Progress;
use crate::recording::read::READABLE;
use crate::session::{Command, Session};
use crate::simulation::Scenario;
use crate::work::message_of;

/// A screen of the window.
pub struct Row {
    /// Its names and place.
    pub about: &'static About,
    open: fn() -> Box<dyn Screen>,
}

/// Every screen, left to right.
pub static TABLE: &[Row] = &[
    Row { about: &data::ABOUT, open: || Box::<data::Data>::default() },
    Row { about: &model::ABOUT, open: || Box::<model::Terms>::default() },
    Row { about: &train::ABOUT, open: || Box::<train::Train>::default() },
    Row { about: &compare::ABOUT, open: || Box::<compare::Compare>::default() },
    Row { about: &residuals::ABOUT, open: || Box::<residuals::Residuals>::default() },
    Row { about: &diagnose::ABOUT, open: || Box::<diagnose::Diagnose>::default() },
    Row { about: &ladder::ABOUT, open: || Box::<ladder::Ladder>::default() },
    Row { about: &extrapolation::ABOUT, open: || Box::<extrapolation::Extrapolation>::default() },
    Row { about: &experiment::ABOUT, open: || Box::<experiment::Experiments>::default() },
];

/// What is known of every screen, left to right.
pub fn all() -> impl Iterator<Item = &'static About> {
    TABLE.iter().map(|row| row.about)
}

/// No screen has this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no screen `{id}`; there are: {known}")]
pub struct UnknownScreen {
    /// What was asked for.
    pub id: String,
    /// What there is.
    pub known: String,
}

/// The screen with this name.
///
/// # Errors
/// [`UnknownScreen`] lists the names that exist.
pub fn find(id: &str) -> Result<&'static About, UnknownScreen> {
    all().find(|about| about.id == id).ok_or_else(|| UnknownScreen {
        id: id.to_owned(),
        known: all().map(|about| about.id).collect::<Vec<_>>().join(", "),
    })
}

/// All screens of a window, each with its memory, and which of them is shown.
pub(super) struct Screens {
    /// As in [`TABLE`].
    open: Vec<Box<dyn Screen>>,
    /// Place in [`TABLE`].
    shown: usize,
    /// Of each screen, why it could not be drawn; the others are drawn all the same.
    broken: Vec<Option<String>>,
}

impl Default for Screens {
    fn default() -> Self {
        let open: Vec<_> = TABLE.iter().map(|row| (row.open)()).collect();
        Screens { broken: vec![None; open.len()], open, shown: 0 }
    }
}

impl Screens {
    /// Which screen is shown.
    pub fn shown(&self) -> &'static About {
        TABLE[self.shown].about
    }

    /// The screen that is shown.
    pub fn current(&self) -> &dyn Screen {
        self.open[self.shown].as_ref()
    }

    /// What the shown screen shows, as figures; none if a defect of the program is in the way.
    pub fn figures(&mut self, desk: &mut Desk) -> Vec<Panel> {
        formula::prepare_now(desk);
        self.guarded(desk, |screen, desk| screen.figures(desk)).unwrap_or_default()
    }

    /// How many of them stand beside each other where nobody says.
    pub fn columns(&self, desk: &Desk) -> usize {
        self.current().columns(desk)
    }

    /// The same screens as they look now, without their jobs.
    pub fn copy(&self) -> Screens {
        let open = self.open.iter().map(|screen| screen.copy()).collect();
        Screens { open, shown: self.shown, broken: self.broken.clone() }
    }

    /// Shows what is asked for by name on all screens that know it.
    ///
    /// # Errors
    /// All that can be asked for, if none does.
    pub fn turn(&mut self, desk: &mut Desk, asked: &str, of: impl Fn(&About) -> bool) -> Result<(), Vec<String>> {
        let (mut known, mut is_known) = (Vec::new(), false);
        for (_, screen) in all().zip(&mut self.open).filter(|(about, _)| of(about)) {
            for switch in screen.switches(desk) {
                known.extend(switch.words());
                is_known |= switch.turn(asked);
            }
        }
        if is_known { Ok(()) } else { Err(known) }
    }

    /// Lets the shown screen do something. If that breaks, it is a defect of the program that ends this screen, and neither the
    /// window nor the work in it: the screen begins anew when the session changes, or somebody asks for it.
    fn guarded<T>(&mut self, desk: &mut Desk, act: impl FnOnce(&mut dyn Screen, &mut Desk) -> T) -> Option<T> {
        let screen = self.open[self.shown].as_mut();
        let outcome = catch_unwind(AssertUnwindSafe(|| act(screen, desk)));
        let broken = outcome.as_ref().err().map(|panic| message_of(panic.as_ref()));
        if broken.is_some() {
            let mut anew = (TABLE[self.shown].open)();
            anew.follow(&Session::default(), desk.session, None);
            self.open[self.shown] = anew;
            self.broken[self.shown] = broken;
        }
        outcome.ok()
    }

    /// Shows a screen.
    pub fn show(&mut self, screen: &About) {
        self.shown = all().position(|about| about == screen).unwrap_or(self.shown);
    }

    /// The screen that follows the shown one on the way, behind the last one the first.
    pub fn next_on_the_way(&self) -> &'static About {
        let later = all().skip(self.shown + 1).find(|about| about.on_the_way);
        later.unwrap_or(TABLE[0].about)
    }

    /// Every screen and what is known of it.
    pub fn iter(&self) -> impl Iterator<Item = (&'static About, &dyn Screen)> {
        all().zip(self.open.iter().map(Box::as_ref))
    }

    /// How they are set up, by their ids.
    pub fn setup(&self) -> BTreeMap<String, Value> {
        self.iter().map(|(about, screen)| (about.id.to_owned(), screen.setup())).collect()
    }

    /// Sets them up as a file tells.
    pub fn set_up(&mut self, mut setup: BTreeMap<String, Value>) {
        for (about, screen) in all().zip(&mut self.open) {
            screen.set_up(setup.remove(about.id).unwrap_or_default());
        }
    }

    /// Whether one of them keeps an answer back.
    pub fn withhold(&self, session: &Session) -> bool {
        self.open.iter().any(|screen| screen.withholds(session))
    }

    /// A screen of which a job is at work, if there is one.
    pub fn busy(&self) -> Option<&'static About> {
        self.iter().find(|(_, screen)| screen.is_busy()).map(|(about, _)| about)
    }

    /// The long job of a screen, if there is one: its name, and how far it is.
    pub fn at_work(&self) -> Option<(&str, Progress)> {
        self.iter().find_map(|(_, screen)| screen.at_work())
    }

    /// Stops the one that [`Screens::at_work`] tells of.
    pub fn stop(&mut self) {
        if let Some(screen) = self.open.iter_mut().find(|screen| screen.at_work().is_some()) {
            screen.stop();
        }
    }

    /// Lets all receive what their jobs have.
    pub fn poll(&mut self) {
        self.open.iter_mut().for_each(|screen| screen.poll());
    }

    /// Lets all hear an order; what they order for it is given back.
    pub fn hear(&mut self, order: &Order) -> Vec<Order> {
        self.open.iter_mut().flat_map(|screen| screen.hear(order)).collect()
    }

    /// The session has changed. The screen that shows what a command did comes to the front.
    pub fn follow(&mut self, before: &Session, after: &Session, by: Option<&Command>) {
        self.open.iter_mut().for_each(|screen| screen.follow(before, after, by));
        self.broken.fill(None);
        let answers = by.and_then(|command| self.open.iter().position(|screen| screen.answers(command)));
        self.shown = answers.unwrap_or(self.shown);
    }

    /// Draws the shown screen, or what is lacking for it.
    pub fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let needs = self.shown().needs;
        if needs != Needs::Nothing && desk.session.recording.is_none() {
            let sentence =
                format!("Open a recording ({READABLE}), drop one here, or begin with the arm of the demonstration.");
            if widgets::empty(ui, "There is no recording yet", &sentence, "Simulate the demonstration arm") {
                desk.run(Command::Simulate(Box::new(Scenario::embedded())));
            }
            return;
        }
        if needs == Needs::Model && desk.session.current().is_none() {
            let sentence = "Fit a rigid body to the recording to see where it fails.";
            if widgets::empty(ui, "There is no model yet", sentence, "Fit a rigid body") {
                desk.run(Command::ChoosePreset(desk.session.preset));
            }
            return;
        }
        if let Some(reason) = &self.broken[self.shown] {
            let title = "A defect of the program ended this screen";
            let sentence = format!(
                "{reason}.\nYour session is as it was, and the other screens work. Please report this with what you did."
            );
            if widgets::empty(ui, title, &sentence, "Draw it again") {
                self.broken[self.shown] = None;
            }
            return;
        }
        self.guarded(desk, |screen, desk| screen.ui(ui, desk));
    }
}
