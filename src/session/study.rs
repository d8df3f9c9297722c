//! A lesson in a session: which one, by which seed, and a journal of what was done in it, step by step. What was done stays done.
//!
//! What a lesson asks and whether an answer is right is no business of the session: `lesson/` reads the files that a [`Study`]
//! carries, and says what is to be written down. Each entry of the journal has a mark that follows from the one before it, so that
//! an entry that was changed, left out or put in later by hand is noticed. As the seal, that is no cryptography: it keeps honest
//! people honest.

use std::fmt::Write;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::recording::Recording;
use crate::recording::correction::Correction;
use crate::simulation::Making;
use crate::training::fit::Plan;

/// A lesson that is taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// The lesson itself.
    pub source: Source,
    /// By which all is drawn that differs from student to student.
    pub seed: u64,
    journal: Vec<Entry>,
}

/// The two files of a lesson, as they were when it was begun.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Its steps and what they ask (TOML).
    pub data: String,
    /// What is read in it, in one language (TOML).
    pub text: String,
}

/// An entry of the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// What it says.
    pub note: Note,
    /// Follows from the note and the mark before it.
    mark: String,
}

/// What was done, when, and in which step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Note {
    /// When \[s since 1970\].
    pub at: u64,
    /// Id of the step.
    pub step: String,
    /// What was done.
    pub deed: Deed,
    /// What is locked from now on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locks: Vec<Lock>,
}

/// What can be done in a lesson.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Deed {
    /// The step was begun.
    Began,
    /// A recording was made for it.
    SetUp {
        /// Name of the case.
        case: String,
        /// By which the recording is known again.
        recording: String,
    },
    /// Something was predicted, and is locked in.
    Predicted {
        /// What.
        answer: Answer,
        /// How sure one was, 0 to 1; `None` where nobody asked.
        confidence: Option<f64>,
    },
    /// An answer was tried.
    Tried {
        /// Which.
        answer: Answer,
        /// Whether it was right.
        right: bool,
    },
    /// The step was left without an answer.
    GaveUp,
    /// A prediction was held against what is so.
    Revealed {
        /// The step in which it was predicted.
        of: String,
        /// What is so.
        right: Answer,
        /// What the prediction was worth, 0 to 1.
        score: f64,
    },
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// One of several, by its name.
    Choice(String),
    /// A number.
    Number(f64),
    /// A state of the arm.
    Pose(Pose),
    /// What stands in the session.
    Session,
}

/// A state of an arm, one value for each joint.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Angles \[rad\].
    pub q: Vec<f64>,
    /// Speeds \[rad/s\].
    pub qd: Vec<f64>,
    /// Accelerations \[rad/s²\].
    pub qdd: Vec<f64>,
}

/// What a lesson can keep locked for a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lock {
    /// The seal.
    Seal,
    /// The diagnosis, and the question what the remainder depends on.
    Diagnosis,
    /// Effects to be added.
    Effects,
    /// Recordings to be opened or simulated.
    Recordings,
}

/// What begins a lesson, or brings the recording of a case.
#[derive(Debug, Clone)]
pub struct SetUp {
    /// The lesson that is begun; `None` within one.
    pub begins: Option<Study>,
    /// What is written down before, such as that a step was begun.
    pub note: Option<Note>,
    /// The case; `None` where a step has no recording of its own.
    pub case: Option<Case>,
}

/// A recording for a lesson.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name in the lesson.
    pub name: String,
    /// How it is made.
    pub making: Making,
    /// What is set wrong in it.
    pub faults: Vec<Correction>,
    /// How networks are to be trained with it; as before if not given.
    pub plan: Option<Plan>,
}

impl Study {
    /// A lesson that was not begun yet.
    pub fn new(source: Source, seed: u64) -> Self {
        Study { source, seed, journal: Vec::new() }
    }

    /// What was done so far, the oldest first.
    pub fn journal(&self) -> &[Entry] {
        &self.journal
    }

    /// The same with one entry more.
    #[must_use]
    pub fn with(&self, note: Note) -> Self {
        let before = self.journal.last().map_or_else(|| self.root(), |last| last.mark.clone());
        let mark = mark(&before, &note);
        let mut longer = self.clone();
        longer.journal.push(Entry { note, mark });
        longer
    }

    /// The same with a deed more in the step that was begun last, whose locks still hold.
    #[must_use]
    pub fn continued(&self, at: u64, deed: Deed) -> Self {
        let last = self.journal.last().map(|entry| &entry.note);
        let (step, locks) = last.map(|note| (note.step.clone(), note.locks.clone())).unwrap_or_default();
        self.with(Note { at, step, deed, locks })
    }

    /// The first entry, counted from 0, that is not as it was written; `None` if all are.
    pub fn first_changed(&self) -> Option<usize> {
        let mut before = self.root();
        for (number, entry) in self.journal.iter().enumerate() {
            if entry.mark != mark(&before, &entry.note) {
                return Some(number);
            }
            before.clone_from(&entry.mark);
        }
        None
    }

    /// Whether two are the same lesson, begun at the same moment.
    pub fn is_same_course(&self, other: &Study) -> bool {
        self.journal.first().map(|entry| &entry.mark) == other.journal.first().map(|entry| &entry.mark)
    }

    /// What the lesson keeps locked now.
    pub fn locks(&self) -> &[Lock] {
        self.journal.last().map_or(&[], |entry| &entry.note.locks)
    }

    /// What the first entry's mark follows from.
    fn root(&self) -> String {
        digest(&[self.source.data.as_bytes(), self.source.text.as_bytes(), &self.seed.to_le_bytes()])
    }
}

impl Lock {
    /// What it keeps locked, in words.
    pub fn words(self) -> &'static str {
        match self {
            Lock::Seal => "the seal",
            Lock::Diagnosis => "the diagnosis",
            Lock::Effects => "the effects",
            Lock::Recordings => "other recordings",
        }
    }
}

impl SetUp {
    /// What it does, for undo and for the status line.
    pub fn title(&self) -> String {
        match (&self.begins, &self.case) {
            (Some(_), _) => "begin the lesson".to_owned(),
            (None, Some(case)) => format!("set up {}", case.making.name()),
            (None, None) => "go on in the lesson".to_owned(),
        }
    }
}

/// By what the recording of a case is known again, also when something in it was set right: by what is sealed in it. Empty for one that
/// was not simulated.
pub fn fingerprint(recording: &Recording) -> String {
    recording.seal.as_ref().map_or(String::new(), |seal| digest(&[seal.as_bytes()]))
}

fn mark(before: &str, note: &Note) -> String {
    // Numbers, texts and lists always have a JSON form.
    digest(&[before.as_bytes(), &serde_json::to_vec(note).unwrap_or_default()])
}

/// SHA-256 of parts that can't run into each other, as text.
fn digest(parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().take(16).fold(String::new(), |mut text, byte| {
        // Writing into a text does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::session::{Command, Document, History, Session, file};
    use crate::simulation::{Excitation, Scenario};

    fn note(step: &str, deed: Deed) -> Note {
        Note { at: 10, step: step.to_owned(), deed, locks: Vec::new() }
    }

    fn study() -> Study {
        let source = Source { data: "d".to_owned(), text: "t".to_owned() };
        let tried = Deed::Tried { answer: Answer::Number(0.1), right: false };
        Study::new(source, 17).with(note("one", Deed::Began)).with(note("one", tried)).with(note("one", Deed::GaveUp))
    }

    #[test]
    fn whatever_is_changed_by_hand_is_noticed() {
        let study = study();
        assert_eq!(study.first_changed(), None);
        let text = serde_json::to_string(&study).unwrap();
        assert_eq!(serde_json::from_str::<Study>(&text).unwrap(), study);
        for (from, to) in [("\"seed\":17", "\"seed\":18"), ("false", "true"), ("0.1", "0.2"), ("\"d\"", "\"e\"")] {
            assert!(text.contains(from), "{text}");
            let changed: Study = serde_json::from_str(&text.replacen(from, to, 1)).unwrap();
            assert!(changed.first_changed().is_some(), "{from} -> {to}");
        }
        for left_out in 0..2 {
            let mut shorter = study.clone();
            shorter.journal.remove(left_out);
            assert_eq!(shorter.first_changed(), Some(left_out));
        }
    }

    fn small() -> Scenario {
        let motion = Excitation::PaperPointToPoint { trajectories: 4, duration: 4.0, samples: 60, range: 2.0 };
        Scenario { motion, ..Scenario::embedded() }
    }

    fn run(command: Command, session: &Session) -> Session {
        command.run(session, &Monitor::new()).unwrap()
    }

    fn begun(locks: Vec<Lock>) -> Session {
        let began = Note { locks, ..note("one", Deed::Began) };
        let case = Case {
            name: "first".to_owned(),
            making: Making::Formulas(Box::new(small())),
            faults: Vec::new(),
            plan: None,
        };
        let begins = Some(Study::new(study().source, 17));
        run(Command::SetUp(Box::new(SetUp { begins, note: Some(began), case: Some(case) })), &Session::default())
    }

    #[test]
    fn what_a_lesson_locks_is_not_carried_out() {
        let session = begun(vec![Lock::Seal, Lock::Diagnosis]);
        for command in [Command::OpenSeal, Command::Diagnose, Command::Propose] {
            let message = command.run(&session, &Monitor::new()).unwrap_err().to_string();
            assert!(message.contains("locked in this step"), "{message}");
        }
        let later = run(Command::Learn(vec![note("two", Deed::Began)]), &session);
        assert!(run(Command::OpenSeal, &later).truth.is_some());
    }

    /// Neither by undo nor by another recording; and it is in the file.
    #[test]
    fn the_journal_stays_as_it_is() {
        let mut history = History::new(begun(Vec::new()));
        let length = |history: &History| history.current().study.as_ref().map(|study| study.journal().len());
        assert_eq!(length(&history), Some(2), "begun, set up");
        history.push(run(Command::Simulate(Box::new(small())), history.current()), "simulate");
        let tried = Deed::Tried { answer: Answer::Session, right: false };
        history.settle(run(Command::Learn(vec![note("one", tried)]), history.current()));
        assert!(history.undo_text().is_some());
        history.undo();
        assert_eq!((length(&history), history.undo_text()), (Some(3), None));
        history.redo();
        assert_eq!(length(&history), Some(3));
        let bytes = file::to_bytes(&Document { history: history.clone(), ..Document::default() }).unwrap();
        let back = file::from_bytes(&bytes, &Monitor::new()).unwrap().history;
        assert_eq!(back.current().study, history.current().study);
    }

    #[test]
    fn a_recording_is_known_again_when_it_is_set_right() {
        let first = begun(Vec::new());
        let mark = |session: &Session| fingerprint(session.recording.as_ref().unwrap());
        let right = run(Command::SetRight(vec!["sign-torque@1".parse().unwrap()]), &first);
        assert_eq!(mark(&right), mark(&first));
        let other = run(Command::Simulate(Box::new(Scenario { seed: 2, ..small() })), &first);
        assert_ne!(mark(&other), mark(&first));
        assert!(right.study.is_some() && other.study.is_some());
    }
}
