//! Undo and redo: the sessions before and after the current one.
//!
//! What was seen or said can't be taken back: an opened seal stays open in all of them, a placed bet stays placed, and the journal of
//! a lesson stays as it is.

use super::{Generation, Session};

/// How many steps back are kept.
const DEPTH: usize = 100;

/// The current session and those to go back and forth to.
#[derive(Debug, Clone, Default)]
pub struct History {
    pub(super) past: Vec<Entry>,
    pub(super) current: Session,
    /// The next one last.
    pub(super) future: Vec<Entry>,
}

/// A session that can be gone to.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub session: Session,
    /// What led from the older to the newer of two neighbours.
    pub change: String,
}

impl History {
    /// Starts from a session; nothing can be undone.
    pub fn new(session: Session) -> Self {
        History { current: session, ..History::default() }
    }

    /// Sessions in their order, what led from each to the next, and which is the current one; `None` if these do not fit.
    pub(super) fn of(mut sessions: Vec<Session>, changes: Vec<String>, current: usize) -> Option<Self> {
        if sessions.len() != changes.len() + 1 || sessions.len() > 2 * DEPTH + 1 || current >= sessions.len() {
            return None;
        }
        let entry = |(session, change)| Entry { session, change };
        let future = sessions.split_off(current + 1).into_iter().zip(changes[current..].to_vec()).map(entry);
        let future = future.rev().collect();
        let current = sessions.pop()?;
        let past = sessions.into_iter().zip(changes).map(entry).collect();
        Some(History { past, current, future })
    }

    /// The session as it is.
    pub fn current(&self) -> &Session {
        &self.current
    }

    /// The current session, with what was found on the way to its model: a step that is added makes a diagnosis out of date, but a
    /// report tells of it.
    pub fn reported(&self) -> Session {
        let current = &self.current;
        let is_on_the_way = |session: &&Session| {
            let model = session.current().map(|step| step.generation);
            session.has_recording_of(current) && current.ladder.iter().any(|step| Some(step.generation) == model)
        };
        let past = self.past.iter().rev().map(|entry| &entry.session).filter(is_on_the_way);
        let found = std::iter::once(current).chain(past).find_map(|session| session.report.clone());
        Session { report: found, ..current.clone() }
    }

    /// Takes a new session; `change` says what was done, for the tool tip of undo.
    pub fn push(&mut self, session: Session, change: &str) {
        let session = self.with_opened_seal(session);
        let old = std::mem::replace(&mut self.current, session);
        self.remember([Entry { session: old, change: change.to_owned() }]);
        self.future.clear();
        self.carry_study();
    }

    /// Takes a session with its own past and future, such as a file gave it: undo goes back in its past, and then to what was
    /// before it. `change` says what was done.
    pub fn open(&mut self, mut other: History, change: &str) {
        for session in other.sessions_mut() {
            *session = self.with_opened_seal(std::mem::take(session));
        }
        let old = std::mem::replace(&mut self.current, other.current);
        self.remember([Entry { session: old, change: change.to_owned() }]);
        self.remember(other.past);
        self.future = other.future;
    }

    /// Takes the current session after a change that can't be undone, and carries it into all others: the truth of a seal that
    /// was opened, the bets on a recording.
    pub fn settle(&mut self, session: Session) {
        self.current = session.clone();
        for other in self.sessions_mut() {
            let truth = if other.has_seal_of(&session) { session.truth.clone() } else { other.truth.clone() };
            let bets = if other.has_recording_of(&session) { session.bets.clone() } else { other.bets.clone() };
            if truth != other.truth || bets != other.bets {
                *other = Session { truth, bets, generation: Generation::next(), ..std::mem::take(other) };
            }
        }
        self.carry_study();
    }

    /// The journal of the current session's lesson is that of all sessions in which the lesson is taken.
    fn carry_study(&mut self) {
        let Some(study) = self.current.study.clone() else { return };
        for other in self.sessions_mut() {
            if other.study.as_ref().is_some_and(|known| known.is_same_course(&study) && *known != study) {
                *other =
                    Session { study: Some(study.clone()), generation: Generation::next(), ..std::mem::take(other) };
            }
        }
    }

    fn remember(&mut self, entries: impl IntoIterator<Item = Entry>) {
        self.past.extend(entries);
        let spare = self.past.len().saturating_sub(DEPTH);
        self.past.drain(..spare);
    }

    /// A session whose seal is open if any of these has the same one open.
    fn with_opened_seal(&self, session: Session) -> Session {
        let all = self.past.iter().chain(&self.future).map(|entry| &entry.session).chain([&self.current]);
        let opened = all.filter(|other| other.has_seal_of(&session)).find_map(|other| other.truth.clone());
        Session { truth: opened.or(session.truth.clone()), ..session }
    }

    pub(super) fn sessions_mut(&mut self) -> impl Iterator<Item = &mut Session> {
        let others = self.past.iter_mut().chain(&mut self.future).map(|entry| &mut entry.session);
        others.chain([&mut self.current])
    }

    /// What undo would take back; `None` if there is nothing.
    pub fn undo_text(&self) -> Option<&str> {
        self.past.last().map(|entry| entry.change.as_str())
    }

    /// What redo would do again; `None` if there is nothing.
    pub fn redo_text(&self) -> Option<&str> {
        self.future.last().map(|entry| entry.change.as_str())
    }

    /// Whether undo leads back to this session, and it is of another recording: a file of the current one does not keep it.
    pub fn left_behind(&self, generation: Generation) -> bool {
        let is_it = |session: &Session| session.generation == generation && !session.has_recording_of(&self.current);
        self.past.iter().any(|entry| is_it(&entry.session))
    }

    /// Goes back to this session, if undo leads there.
    pub fn back_to(self, generation: Generation) -> Self {
        self.back_until(|session| session.generation == generation)
    }

    /// Goes back to the last session that has a recording, if one has.
    pub fn to_recording(self) -> Self {
        self.back_until(|session| session.recording.is_some())
    }

    fn back_until(mut self, is_there: impl Fn(&Session) -> bool) -> Self {
        if self.past.iter().any(|entry| is_there(&entry.session)) {
            while !is_there(&self.current) {
                self.undo();
            }
        }
        self
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
    use crate::progress::Monitor;
    use crate::session::Command;
    use crate::simulation::{Excitation, Scenario};

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

    #[test]
    fn what_was_opened_brings_its_own_past_before_that_of_the_window() {
        let named = |preset| Session { preset, ..Session::default() };
        let mut file = History::new(named(Preset::RigidBody));
        file.push(named(Preset::StatedArm), "in the file");
        let mut history = History::default();
        history.open(file, "open the file");
        assert_eq!((history.undo_text(), history.current().preset), (Some("in the file"), Preset::StatedArm));
        history.undo();
        assert_eq!(history.undo_text(), Some("open the file"));
        history.undo();
        assert_eq!((history.undo_text(), history.redo_text()), (None, Some("open the file")));
    }

    /// Neither by undo, nor by simulating the same once more.
    #[test]
    fn a_seal_stays_open() {
        let motion = Excitation::PaperPointToPoint { trajectories: 4, duration: 4.0, samples: 60, range: 2.0 };
        let simulate = Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }));
        let run = |command: &Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
        let first = run(&simulate, &Session::default());
        let mut history = History::new(first.clone());
        history.push(run(&Command::ChoosePreset(Preset::StatedArm), &first), "choose the stated arm");
        let generation = history.current().generation;
        history.settle(run(&Command::OpenSeal, history.current()));
        assert!(history.current().truth.is_some() && history.current().generation != generation);
        history.undo();
        assert!(history.current().truth.is_some() && history.undo_text().is_none(), "opening it was no step");
        history.push(run(&simulate, history.current()), "simulate");
        assert!(history.current().truth.is_some(), "the same arm again");
    }
}
