//! What a session was worth, from its journal alone.

use serde::Serialize;

use super::act::LessonError;
use super::catalogue;
use super::course::Course;
use super::file::Lesson;
use crate::session::Session;
use crate::session::study::{Deed, Study};

/// What a session was worth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Grade {
    /// Id of the lesson.
    pub lesson: String,
    /// Its title.
    pub title: String,
    /// The student's seed.
    pub seed: u64,
    /// What was earned.
    pub points: f64,
    /// What could be earned.
    pub most: f64,
    /// Whether the last step was done.
    pub finished: bool,
    /// Whether it was finished with points enough, and nothing was changed by hand.
    pub passed: bool,
    /// From the first entry of the journal to the last \[s\].
    pub seconds: u64,
    /// How often an answer was tried.
    pub tries: usize,
    /// In how many steps one gave up.
    pub gave_up: usize,
    /// What in the session is not as the program wrote it; `None` if nothing was found.
    pub tampered: Option<String>,
    /// Whether the lesson is one that comes with this program, as it is there.
    pub as_published: bool,
    /// Of each step that can earn something.
    pub steps: Vec<StepGrade>,
}

/// What a step was worth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepGrade {
    /// Its id.
    pub step: String,
    /// What was earned.
    pub points: f64,
    /// What could be earned.
    pub most: f64,
    /// How often an answer was tried.
    pub tries: usize,
}

/// Grades a session, and makes its recordings anew to see whether they are those of the student's seed, which takes a moment.
///
/// # Errors
/// [`LessonError`] if no lesson was taken in it, or its lesson can't be read.
pub fn verified(session: &Session) -> Result<Grade, LessonError> {
    let mut grade = grade(session)?;
    let study = session.study.as_deref().ok_or(LessonError::NoLesson)?;
    if grade.tampered.is_none() {
        grade.tampered = foreign_recording(&Lesson::read(&study.source)?, study)?;
        grade.passed &= grade.tampered.is_none();
    }
    Ok(grade)
}

/// Grades a session by its journal.
///
/// # Errors
/// [`LessonError`] if no lesson was taken in it, or its lesson can't be read.
pub fn grade(session: &Session) -> Result<Grade, LessonError> {
    let study = session.study.as_deref().ok_or(LessonError::NoLesson)?;
    let lesson = Lesson::read(&study.source)?;
    let course = Course::of(&lesson, study);
    let earning = || lesson.steps.iter().zip(&course.steps).filter(|(step, _)| step.most_points() > 0.0);
    let steps: Vec<StepGrade> = earning()
        .map(|(step, progress)| StepGrade {
            step: step.id.clone(),
            points: progress.points(step),
            most: step.most_points(),
            tries: progress.tries,
        })
        .collect();
    let points = steps.iter().map(|step| step.points).sum::<f64>();
    let most = lesson.most_points();
    let changed = study.first_changed();
    let tampered = changed.map(|place| format!("entry {} of the journal is not as it was written", place + 1));
    let finished = course.is_finished(&lesson);
    let times = || study.journal().iter().map(|entry| entry.note.at);
    Ok(Grade {
        seed: study.seed,
        points,
        most,
        finished,
        passed: finished && tampered.is_none() && points >= lesson.pass * most,
        seconds: times().max().unwrap_or(0).saturating_sub(times().min().unwrap_or(0)),
        tries: course.steps.iter().map(|progress| progress.tries).sum(),
        gave_up: course.steps.iter().filter(|progress| progress.gave_up).count(),
        tampered,
        as_published: catalogue::all().any(|known| known.source == lesson.source),
        steps,
        lesson: lesson.id,
        title: lesson.title,
    })
}

/// A recording that is not the one of the seed.
fn foreign_recording(lesson: &Lesson, study: &Study) -> Result<Option<String>, LessonError> {
    let mut known: Vec<(&str, String)> = Vec::new();
    for entry in study.journal() {
        let Deed::SetUp { case, recording } = &entry.note.deed else { continue };
        if !known.iter().any(|(name, _)| name == case) {
            let Some(of_lesson) = lesson.cases.get(case.as_str()) else {
                return Ok(Some(format!("the lesson has no case `{case}`")));
            };
            known.push((case.as_str(), of_lesson.fingerprint(study.seed)?));
        }
        if known.iter().any(|(name, mark)| name == case && mark != recording) {
            return Ok(Some(format!("the recording of `{case}` is not that of seed {}", study.seed)));
        }
    }
    Ok(None)
}
