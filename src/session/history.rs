//! Undo and redo: the sessions before and after the current one.

use std::sync::Arc;

use super::{Session, Step};

/// How many steps back are kept.
const DEPTH: usize = 100;

/// The current session and those to go back and forth to.
#[derive(Debug, Clone, Default)]
pub struct History {
    past: Vec<Entry>,
    current: Session,
    future: Vec<Entry>,
}

#[derive(Debug, Clone)]
struct Entry {
    session: Session,
    /// What led from the older to the newer of two neighbours.
    change: String,
}

impl History {
    /// Starts from a session; nothing can be undone.
    pub fn new(session: Session) -> Self {
        History { current: session, ..History::default() }
    }

    /// The session as it is.
    pub fn current(&self) -> &Session {
        &self.current
    }

    /// Takes a new session; `change` says what was done, for the tool tip of undo.
    pub fn push(&mut self, session: Session, change: &str) {
        let old = std::mem::replace(&mut self.current, session);
        self.past.push(Entry { session: old, change: change.to_owned() });
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// What undo would take back; `None` if there is nothing.
    pub fn undo_text(&self) -> Option<&str> {
        self.past.last().map(|entry| entry.change.as_str())
    }

    /// What redo would do again; `None` if there is nothing.
    pub fn redo_text(&self) -> Option<&str> {
        self.future.last().map(|entry| entry.change.as_str())
    }

    /// Every model that was fitted to the current recording and can be gone back to, oldest first.
    pub fn models(&self) -> Vec<Arc<Step>> {
        let mut models: Vec<Arc<Step>> = Vec::new();
        let sessions = self.past.iter().map(|entry| &entry.session).chain([&self.current]);
        for session in sessions.filter(|session| session.has_recording_of(&self.current)) {
            for step in &session.ladder {
                if !models.iter().any(|known| known.generation == step.generation) {
                    models.push(Arc::clone(step));
                }
            }
        }
        models
    }

    /// Goes one step back; nothing happens at the start.
    pub fn undo(&mut self) {
        if let Some(Entry { session, change }) = self.past.pop() {
            let newer = std::mem::replace(&mut self.current, session);
            self.future.push(Entry { session: newer, change });
        }
    }

    /// Goes one step forth again; nothing happens at the end.
    pub fn redo(&mut self) {
        if let Some(Entry { session, change }) = self.future.pop() {
            let older = std::mem::replace(&mut self.current, session);
            self.past.push(Entry { session: older, change });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Preset;

    #[test]
    fn undo_and_redo_go_back_and_forth() {
        let mut history = History::new(Session::default());
        history.push(Session { preset: Preset::StatedArm, ..Session::default() }, "choose the stated arm");
        assert_eq!(history.undo_text(), Some("choose the stated arm"));
        history.undo();
        assert_eq!(history.current().preset, Preset::RigidBody);
        assert_eq!((history.undo_text(), history.redo_text()), (None, Some("choose the stated arm")));
        history.redo();
        assert_eq!(history.current().preset, Preset::StatedArm);
        history.undo();
        history.push(Session::default(), "something else");
        assert_eq!(history.redo_text(), None);
    }
}
