//! A lesson taken without a window, by somebody who knows what is right and does what the program proposes: for pictures of it.

use anyhow::bail;

use super::progress;
use crate::lesson::{Act, Course, Lesson, Task, Wish, act, right_answer};
use crate::session::study::Answer;
use crate::session::{Command, Session};

/// Names the end of a lesson, after its last step.
const DONE: &str = "done";

/// Takes the lesson of a session up to where the step of this name begins, or to its end.
pub fn reach(mut session: Session, wanted: &str) -> anyhow::Result<Session> {
    let Some(study) = session.study.clone() else { bail!("no lesson is taken in this session") };
    let lesson = Lesson::read(&study.source)?;
    if wanted != DONE && lesson.step(wanted).is_none() {
        let names: Vec<&str> = lesson.steps.iter().map(|step| step.id.as_str()).collect();
        bail!("the lesson has no step `{wanted}`; it has: {}, {DONE}", names.join(", "));
    }
    loop {
        let Some(study) = session.study.clone() else { bail!("the lesson is over") };
        let step = &lesson.steps[Course::of(&lesson, &study).place];
        if step.id == wanted {
            return Ok(session);
        }
        session = done(session, &step.task)?;
        if step.id == lesson.steps[lesson.steps.len() - 1].id {
            return Ok(session);
        }
        session = acted(&session, &Act::GoOn)?;
    }
}

/// What a step asks for is done.
fn done(session: Session, task: &Task) -> anyhow::Result<Session> {
    let answer = match task {
        Task::Read => return Ok(session),
        Task::Reveal(_) => return acted(&session, &Act::Reveal),
        Task::Pose(_) => bail!("an arm that is posed by hand can't be posed without a window"),
        Task::Choice(_) | Task::Number(_) => right_answer(&session)?,
        Task::Want(_) => Answer::Session,
    };
    let session = match task {
        Task::Want(wishes) => fulfilled(session, wishes)?,
        _ => session,
    };
    acted(&session, &Act::Answer { answer, confidence: 0.8 })
}

/// What the diagnosis names is added, and the seal is opened if that is wanted.
fn fulfilled(mut session: Session, wishes: &[Wish]) -> anyhow::Result<Session> {
    let repairs = |wish: &Wish| matches!(wish, Wish::HasHidden | Wish::ErrorWithin(_) | Wish::ErrorFell(_));
    if wishes.iter().any(repairs) {
        session = progress::run(Command::Diagnose, &session)?;
        for effect in session.report.clone().iter().flat_map(|report| &report.effects) {
            let (effect, joints) = (effect.effect.id.to_owned(), effect.joints.clone());
            session = progress::run(Command::AddEffect { effect, joints }, &session)?;
        }
    }
    if wishes.iter().any(|wish| matches!(wish, Wish::SealOpen)) {
        session = progress::run(Command::OpenSeal, &session)?;
    }
    Ok(session)
}

fn acted(session: &Session, what: &Act) -> anyhow::Result<Session> {
    let acted = act(session, what, 0)?;
    if let Some(lacks) = acted.lacks {
        bail!("the lesson does not go on: {lacks}");
    }
    progress::run(acted.command, session)
}
