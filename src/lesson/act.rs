//! What is done in a lesson, as commands of the session.

use super::case::Case;
use super::catalogue::UnknownLesson;
use super::course::Course;
use super::file::{Asked, Choice, Lesson, LessonFileError, MASS_ANSWERS, Offer, Right, Stage, Step, Task};
use super::number;
use crate::model::Preset;
use crate::recording::seal::HiddenEffect;
use crate::session::study::{self, Answer, Deed, Note, SetUp, Study};
use crate::session::{Command, Session};
use crate::simulation::SimulationError;

/// What somebody does in a lesson.
#[derive(Debug, Clone, PartialEq)]
pub enum Act {
    /// On to the next step.
    GoOn,
    /// Locks a prediction in, or tries an answer.
    Answer {
        /// Which.
        answer: Answer,
        /// How sure one is, 0 to 1; where nobody asks, it is not looked at.
        confidence: f64,
    },
    /// Leaves a step without an answer.
    GiveUp,
    /// Holds predictions against what is so.
    Reveal,
    /// Does what is offered beside the text, by its place among the offers.
    Offer(usize),
    /// Brings the recording of the step again.
    Again,
}

/// It can't be done now.
#[derive(Debug, thiserror::Error)]
pub enum LessonError {
    /// The session has no lesson.
    #[error("no lesson is taken in this session: begin one first")]
    NoLesson,
    /// The lesson can't be read.
    #[error(transparent)]
    File(#[from] LessonFileError),
    /// There is no such lesson.
    #[error(transparent)]
    Unknown(#[from] UnknownLesson),
    /// A case can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Something comes before it.
    #[error("{0}")]
    NotYet(String),
    /// It is no answer to what is asked.
    #[error("that is no answer to what the step asks")]
    NoAnswer,
}

/// What an act leads to.
#[derive(Debug)]
pub struct Acted {
    /// The command by which the lesson goes on.
    pub command: Command,
    /// What lacks of what the step wants, in words, if something does.
    pub lacks: Option<String>,
}

/// What begins a lesson for the student of this seed, at this time \[s since 1970\].
///
/// # Errors
/// [`LessonError::Simulation`] if its first recording can't be made.
pub fn begin(lesson: &Lesson, seed: u64, at: u64) -> Result<Acted, LessonError> {
    let study = Study::new(lesson.source.clone(), seed);
    Ok(Acted { command: enter(lesson, &study, 0, at, true)?, lacks: None })
}

/// The command by which a lesson goes on; the session's lesson is read from the session.
///
/// # Errors
/// [`LessonError`] says what comes before it. What was only tried in vain is no error: it is written down, too.
pub fn act(session: &Session, act: &Act, at: u64) -> Result<Acted, LessonError> {
    let study = session.study.as_deref().ok_or(LessonError::NoLesson)?;
    let lesson = Lesson::read(&study.source)?;
    let course = Course::of(&lesson, study);
    let now = Now { session, study, step: &lesson.steps[course.place], lesson: &lesson, course: &course, at };
    let command = match act {
        Act::Answer { answer, confidence } => return now.answer(answer, *confidence),
        Act::GoOn => now.go_on(),
        Act::GiveUp if course.may_give_up(now.lesson) => Ok(now.note(Deed::GaveUp)),
        Act::GiveUp => Err(LessonError::NotYet("try it some more times first".to_owned())),
        Act::Reveal => now.reveal(),
        Act::Offer(place) => now.offer(*place),
        Act::Again => now.again(),
    };
    Ok(Acted { command: command?, lacks: None })
}

/// What is right in the step that was begun last, where that is a choice or a number.
///
/// # Errors
/// [`LessonError::NotYet`] while it can't be told, [`LessonError::NoAnswer`] where nothing of the kind is asked.
pub fn right_answer(session: &Session) -> Result<Answer, LessonError> {
    let study = session.study.as_deref().ok_or(LessonError::NoLesson)?;
    let lesson = Lesson::read(&study.source)?;
    let course = Course::of(&lesson, study);
    let now = Now { session, study, step: &lesson.steps[course.place], lesson: &lesson, course: &course, at: 0 };
    now.right(now.step, now.case())
}

/// Begins a step.
fn enter(lesson: &Lesson, study: &Study, place: usize, at: u64, is_first: bool) -> Result<Command, LessonError> {
    let step = &lesson.steps[place];
    let began = Note { at, step: step.id.clone(), deed: Deed::Began, locks: step.locks.clone() };
    let case = step.case.as_deref().and_then(|name| lesson.cases.get(name).map(|case| case.set_up(name, study.seed)));
    let case = case.transpose()?;
    if case.is_none() && !is_first {
        return Ok(Command::Learn(vec![began]));
    }
    let begins = is_first.then(|| study.clone());
    Ok(Command::SetUp(Box::new(SetUp { begins, note: Some(began), case })))
}

/// Where somebody is.
struct Now<'a> {
    session: &'a Session,
    study: &'a Study,
    lesson: &'a Lesson,
    course: &'a Course,
    step: &'a Step,
    at: u64,
}

impl Now<'_> {
    fn written(&self, deed: Deed) -> Note {
        Note { at: self.at, step: self.step.id.clone(), deed, locks: self.step.locks.clone() }
    }

    fn note(&self, deed: Deed) -> Command {
        Command::Learn(vec![self.written(deed)])
    }

    fn go_on(&self) -> Result<Command, LessonError> {
        if !self.course.may_go_on(self.lesson) {
            return Err(LessonError::NotYet("the step asks for something first".to_owned()));
        }
        let next = self.course.place + 1;
        if next == self.lesson.steps.len() {
            return Err(LessonError::NotYet("the lesson is at its end".to_owned()));
        }
        enter(self.lesson, self.study, next, self.at, false)
    }

    fn answer(&self, answer: &Answer, confidence: f64) -> Result<Acted, LessonError> {
        if self.step.stage == Stage::Predict {
            return Ok(Acted { command: self.predict(answer, confidence)?, lacks: None });
        }
        let (right, lacks) = match (&self.step.task, answer) {
            (Task::Choice(_), Answer::Choice(_)) => (self.right(self.step, self.case())? == *answer, None),
            (Task::Number(asked), Answer::Number(said)) => {
                let right = asked.is.value(self.session).map_err(LessonError::NotYet)?;
                (number::score(*said, right, asked.within) >= 1.0, None)
            }
            (Task::Pose(_), Answer::Pose(_)) | (Task::Want(_), Answer::Session) => {
                let lacks = self.lacks(answer)?;
                (lacks.is_none(), lacks)
            }
            _ => return Err(LessonError::NoAnswer),
        };
        Ok(Acted { command: self.note(Deed::Tried { answer: answer.clone(), right }), lacks })
    }

    fn predict(&self, answer: &Answer, confidence: f64) -> Result<Command, LessonError> {
        if self.course.here().predicted.is_some() {
            return Err(LessonError::NotYet("it is locked in, and stays as it is".to_owned()));
        }
        let confidence = match (&self.step.task, answer) {
            (Task::Choice(choice), Answer::Choice(said)) if choice.options.contains(said) => {
                choice.confidence.then_some(confidence.clamp(0.0, 1.0))
            }
            (Task::Number(_), Answer::Number(said)) if said.is_finite() => None,
            _ => return Err(LessonError::NoAnswer),
        };
        Ok(self.note(Deed::Predicted { answer: answer.clone(), confidence }))
    }

    /// What is right in a step that was done with the recording of this case.
    fn right(&self, step: &Step, case: Option<&Case>) -> Result<Answer, LessonError> {
        match &step.task {
            Task::Choice(choice) => self.right_choice(choice, case).map(Answer::Choice),
            Task::Number(asked) => asked.is.value(self.session).map(Answer::Number).map_err(LessonError::NotYet),
            _ => Err(LessonError::NoAnswer),
        }
    }

    /// What lacks of what the step wants; `None` if it is fulfilled.
    fn lacks(&self, answer: &Answer) -> Result<Option<String>, LessonError> {
        let recording = self.session.recording.as_deref();
        let is_of_case = |(_, mark): &(String, String)| recording.is_some_and(|it| study::fingerprint(it) == *mark);
        // With a recording of one's own, that of a case before is no matter.
        let is_own = recording.is_some_and(|recording| recording.seal.is_none());
        if self.course.case.as_ref().is_some_and(|case| !is_of_case(case) && !is_own) {
            return Ok(Some("this is not the recording of the lesson: press Bring the recording again".to_owned()));
        }
        Ok(match (&self.step.task, answer) {
            (Task::Pose(wishes), Answer::Pose(pose)) => {
                let arm = recording.and_then(|recording| recording.stated_arm.as_ref());
                let arm = arm.ok_or_else(|| LessonError::NotYet("there is no arm".to_owned()))?;
                wishes.iter().find_map(|wish| wish.check(arm, pose).err())
            }
            (Task::Want(wishes), Answer::Session) => {
                let hidden = self.hidden(self.case())?;
                wishes.iter().find_map(|wish| wish.check(self.session, &hidden).err())
            }
            _ => return Err(LessonError::NoAnswer),
        })
    }

    /// The case whose recording was brought last.
    fn case(&self) -> Option<&Case> {
        self.course.case.as_ref().and_then(|(name, _)| self.lesson.cases.get(name.as_str()))
    }

    /// What is to be found in the recording of a case.
    fn hidden(&self, case: Option<&Case>) -> Result<Vec<HiddenEffect>, LessonError> {
        let making = case.map(|case| case.making(self.study.seed)).transpose()?;
        Ok(making.map_or_else(Vec::new, |making| making.hidden()))
    }

    fn right_choice(&self, choice: &Choice, case: Option<&Case>) -> Result<String, LessonError> {
        let first = self.hidden(case)?.into_iter().next();
        let missing = || LessonError::NotYet("nothing is there yet by which it could be judged".to_owned());
        match &choice.right {
            Right::Is(right) => Ok(right.clone()),
            Right::HiddenEffect => first.map(|hidden| hidden.effect).ok_or_else(missing),
            Right::HiddenJoint => {
                first.and_then(|hidden| hidden.joint).map(|joint| (joint + 1).to_string()).ok_or_else(missing)
            }
            Right::Fault(place) => {
                let faults = case.map(|case| case.faults(self.study.seed)).unwrap_or_default();
                faults.get(*place).map(ToString::to_string).ok_or_else(missing)
            }
            Right::MassPositive => {
                let is_positive = number::is_mass_positive(self.session).map_err(LessonError::NotYet)?;
                Ok(MASS_ANSWERS[usize::from(!is_positive)].to_owned())
            }
            Right::BestModel => best(choice, |preset| number::held_out_error(self.session, preset)),
            Right::BestAt { stretch, at } => {
                best(choice, |preset| number::error_at(self.session, preset, *stretch, *at))
            }
        }
    }

    /// All predictions that the step reveals and that were not revealed before.
    fn reveal(&self) -> Result<Command, LessonError> {
        let Task::Reveal(all) = &self.step.task else { return Err(LessonError::NoAnswer) };
        let mut notes = Vec::new();
        for (step, progress) in self.lesson.steps.iter().zip(&self.course.steps) {
            let (Some((said, confidence)), None) = (&progress.predicted, &progress.revealed) else { continue };
            if !all.contains(&step.id) {
                continue;
            }
            let case = progress.case.as_ref().and_then(|name| self.lesson.cases.get(name.as_str()));
            let right = self.right(step, case)?;
            let score = match (&step.task, said, &right) {
                (Task::Choice(choice), said, right) => score(choice, said == right, *confidence),
                (Task::Number(Asked { within, .. }), Answer::Number(said), Answer::Number(right)) => {
                    number::score(*said, *right, *within)
                }
                _ => return Err(LessonError::NoAnswer),
            };
            notes.push(self.written(Deed::Revealed { of: step.id.clone(), right, score }));
        }
        match notes.is_empty() {
            true => Err(LessonError::NotYet("all is revealed".to_owned())),
            false => Ok(Command::Learn(notes)),
        }
    }

    fn offer(&self, place: usize) -> Result<Command, LessonError> {
        Ok(match self.step.offers.get(place).ok_or(LessonError::NoAnswer)? {
            Offer::SetRight(correction) => Command::SetRight(vec![correction.clone()]),
            Offer::Train(preset) => Command::Make { presets: vec![*preset] },
            Offer::Extrapolate(stretch) => {
                Command::Extrapolate { steps: self.session.all_models().cloned().collect(), stretch: *stretch }
            }
            Offer::Record(case) => self.bring(case)?,
        })
    }

    fn again(&self) -> Result<Command, LessonError> {
        let case = self.course.case.as_ref().map(|(name, _)| name.clone());
        self.bring(&case.ok_or_else(|| LessonError::NotYet("this lesson brings no recording".to_owned()))?)
    }

    fn bring(&self, name: &str) -> Result<Command, LessonError> {
        let case = self.lesson.cases.get(name).ok_or(LessonError::NoAnswer)?.set_up(name, self.study.seed)?;
        Ok(Command::SetUp(Box::new(SetUp { begins: None, note: None, case: Some(case) })))
    }
}

/// The model among the options, by its preset, whose error is the least.
fn best(choice: &Choice, error: impl Fn(Preset) -> Result<f64, String>) -> Result<String, LessonError> {
    let mut best: Option<(f64, &String)> = None;
    for option in &choice.options {
        let preset = Preset::ALL.into_iter().find(|preset| preset.id() == option);
        let error = error(preset.ok_or(LessonError::NoAnswer)?).map_err(LessonError::NotYet)?;
        if best.is_none_or(|(least, _)| error < least) {
            best = Some((error, option));
        }
    }
    best.map(|(_, option)| option.clone()).ok_or(LessonError::NoAnswer)
}

/// The quadratic (Brier) score of a prediction among several answers, 1 at best and 0 at worst: what one is sure of stands on one's choice,
/// the rest on all others alike. It is proper: who says honestly how sure he is has the most to expect.
fn score(choice: &Choice, is_right: bool, confidence: Option<f64>) -> f64 {
    let Some(sure) = confidence else { return if is_right { 1.0 } else { 0.0 } };
    let others = (choice.options.len() - 1) as f64;
    let rest = (1.0 - sure) / others;
    let squares = match is_right {
        true => (1.0 - sure).powi(2) + others * rest * rest,
        false => (1.0 - rest).powi(2) + sure * sure + (others - 1.0) * rest * rest,
    };
    1.0 - 0.5 * squares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever one believes, no other confidence has more to expect than the honest one.
    #[test]
    fn honesty_pays() {
        for count in [2, 3, 6] {
            let options = (0..count).map(|number| number.to_string()).collect();
            let choice = Choice { options, right: Right::HiddenEffect, confidence: true };
            assert_eq!([true, false].map(|right| score(&choice, right, Some(1.0))), [1.0, 0.0]);
            for belief in [0.5, 0.7, 0.9] {
                let expected = |said: f64| {
                    belief * score(&choice, true, Some(said)) + (1.0 - belief) * score(&choice, false, Some(said))
                };
                for said in (0..=20).map(|step| f64::from(step) / 20.0) {
                    assert!(expected(said) <= expected(belief) + 1e-12, "{count} answers, {belief} and {said}");
                }
            }
        }
    }
}
