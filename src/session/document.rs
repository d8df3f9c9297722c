//! The document as a file keeps it: what can be undone and done again, and where one looks.

use std::sync::Arc;

use super::{History, Session, Step};
use crate::effect::Effect;

/// A session with all that belongs to it.
#[derive(Debug, Clone, Default)]
pub struct Document {
    /// The session, and those to go back and forth to.
    pub history: History,
    /// Where one looks.
    pub view: View,
}

impl Document {
    /// The same, in which these effects of one's own are known beside those of the file: they are of the user, and not of a recording.
    #[must_use]
    pub fn knowing(mut self, effects: &[&'static Effect]) -> Self {
        for session in self.history.sessions_mut() {
            let news = effects.iter().filter(|effect| !session.own_effects.contains(effect));
            let news: Vec<&Effect> = news.copied().collect();
            session.own_effects.extend(news);
        }
        self
    }
}

impl From<Session> for Document {
    /// A session that nobody has looked at.
    fn from(session: Session) -> Self {
        Document { history: History::new(session), view: View::default() }
    }
}

/// Where one looks.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// The screen, by its id; empty if none was shown.
    pub screen: String,
    /// Index of the trajectory.
    pub trajectory: usize,
    /// Counted from 0.
    pub joint: usize,
    /// Models that are drawn over the current one.
    pub overlaid: Vec<Arc<Step>>,
    /// Where the panels are, as the window writes it; null if it has written nothing.
    pub layouts: serde_json::Value,
    /// What somebody has set up to be looked at, as the window writes it; null if it has written nothing.
    pub setup: serde_json::Value,
    /// What is in sight of it, as the window writes it; null if it has written nothing.
    pub sight: serde_json::Value,
}

impl View {
    /// Whether somebody finds there what they have set up; where they look, and where the panels are, goes without saying.
    pub fn is_set_up_as(&self, other: &View) -> bool {
        let models = |view: &View| view.overlaid.iter().map(|step| step.generation).collect::<Vec<_>>();
        models(self) == models(other) && self.setup == other.setup
    }

    /// Whether it is the same in everything.
    pub fn is_like(&self, other: &View) -> bool {
        let place = |view: &View| (view.trajectory, view.joint);
        place(self) == place(other)
            && self.screen == other.screen
            && [&self.layouts, &self.sight] == [&other.layouts, &other.sight]
            && self.is_set_up_as(other)
    }
}
