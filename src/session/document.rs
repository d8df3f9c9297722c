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
}
