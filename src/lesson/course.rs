//! Where somebody is in a lesson: its journal, read again.

use sha2::{Digest, Sha256};

use super::file::{Lesson, Stage, Step, Task};
use crate::session::study::{Answer, Deed, Study};

/// Where somebody is in a lesson.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Of each step of the lesson, what was done in it.
    pub steps: Vec<Progress>,
    /// Index of the step that was begun last.
    pub place: usize,
    /// The case whose recording was brought last, and by what it is known again.
    pub case: Option<(String, String)>,
}

/// What was done in a step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Progress {
    /// When it was begun \[s since 1970\]; `None` if it was not.
    pub begun: Option<u64>,
    /// What was predicted, and how sure one was.
    pub predicted: Option<(Answer, Option<f64>)>,
    /// The case whose recording was there when it was predicted.
    pub case: Option<String>,
    /// How often an answer was tried.
    pub tries: usize,
    /// The answer that was tried last.
    pub last: Option<Answer>,
    /// Whether one of them was right.
    pub right: bool,
    /// Whether it was left without an answer.
    pub gave_up: bool,
    /// What was revealed of its prediction.
    pub revealed: Option<Revealed>,
}

/// What was revealed of a prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Revealed {
    /// What is so.
    pub right: Answer,
    /// What the prediction was worth, 0 to 1.
    pub score: f64,
}

/// So many tries may fail before a step may be left without an answer.
pub const TRIES_BEFORE_GIVING_UP: usize = 3;

impl Course {
    /// What a journal says of a lesson.
    pub fn of(lesson: &Lesson, study: &Study) -> Course {
        let mut course = Course { steps: vec![Progress::default(); lesson.steps.len()], place: 0, case: None };
        for entry in study.journal() {
            let note = &entry.note;
            let index = |id: &str| lesson.steps.iter().position(|step| step.id == id);
            let Some(place) = index(&note.step) else { continue };
            let step = &mut course.steps[place];
            match &note.deed {
                Deed::Began => {
                    step.begun.get_or_insert(note.at);
                    course.place = place;
                }
                Deed::SetUp { case, recording } => course.case = Some((case.clone(), recording.clone())),
                Deed::Predicted { answer, confidence } => {
                    step.predicted.get_or_insert_with(|| (answer.clone(), *confidence));
                    step.case = course.case.as_ref().map(|(name, _)| name.clone());
                }
                Deed::Tried { answer, right } => {
                    step.tries += 1;
                    step.last = Some(answer.clone());
                    step.right |= right;
                }
                Deed::GaveUp => step.gave_up = true,
                Deed::Revealed { of, right, score } => {
                    if let Some(of) = index(of) {
                        let revealed = Revealed { right: right.clone(), score: *score };
                        course.steps[of].revealed.get_or_insert(revealed);
                    }
                }
            }
        }
        course
    }

    /// What was done in the step that was begun last.
    pub fn here(&self) -> &Progress {
        &self.steps[self.place]
    }

    /// Whether what the step asks for is done, so that one may go on.
    pub fn may_go_on(&self, lesson: &Lesson) -> bool {
        let (step, progress) = (&lesson.steps[self.place], self.here());
        let is_revealed = |of: &String| {
            let place = lesson.steps.iter().position(|step| step.id == *of);
            place.is_some_and(|place| self.steps[place].revealed.is_some())
        };
        match (&step.task, step.stage) {
            (Task::Read, _) => true,
            (_, Stage::Predict) => progress.predicted.is_some(),
            (Task::Reveal(of), _) => of.iter().all(is_revealed) || progress.gave_up,
            _ => progress.right || progress.gave_up,
        }
    }

    /// Whether the last step is done.
    pub fn is_finished(&self, lesson: &Lesson) -> bool {
        self.place + 1 == lesson.steps.len() && self.may_go_on(lesson)
    }

    /// Whether the step may be left without an answer: after some tries, so that nobody is stuck.
    pub fn may_give_up(&self, lesson: &Lesson) -> bool {
        let (progress, step) = (self.here(), &lesson.steps[self.place]);
        !self.may_go_on(lesson)
            && step.stage != Stage::Predict
            && (progress.tries >= TRIES_BEFORE_GIVING_UP || matches!(step.task, Task::Reveal(_)))
    }
}

impl Progress {
    /// What was earned in a step, of its points: each wrong try at a question halves it; what is to be done may be tried as often as one
    /// likes.
    pub fn points(&self, step: &Step) -> f64 {
        let share = match (&step.task, step.stage) {
            (Task::Read | Task::Reveal(_), _) => return 0.0,
            (_, Stage::Predict) => self.revealed.as_ref().map_or(0.0, |revealed| revealed.score),
            _ if !self.right => 0.0,
            (Task::Choice(_) | Task::Number(_), _) => 0.5f64.powi(self.tries as i32 - 1),
            _ => 1.0,
        };
        share * step.points
    }
}

impl Step {
    /// The most that can be earned in it.
    pub fn most_points(&self) -> f64 {
        if matches!(self.task, Task::Read | Task::Reveal(_)) { 0.0 } else { self.points }
    }
}

impl Lesson {
    /// The most that can be earned in it.
    pub fn most_points(&self) -> f64 {
        self.steps.iter().map(Step::most_points).sum()
    }

    /// The seed of a student of a class, by the class's word and the student's number.
    pub fn seed_of(&self, class: &str, student: u16) -> u64 {
        let digest = Sha256::digest(format!("{}/{class}/{student}", self.id));
        // Six digits can be read out in a lecture.
        let number = digest.iter().take(4).fold(0, |number: u64, byte| 256 * number + u64::from(*byte));
        100_000 + number % 900_000
    }
}
