//! Another part of the recording held out. A model can't be measured on what it learned from, so each is identified anew.

use std::sync::Arc;

use super::error::SessionError;
use super::step::step;
use super::{Session, Source, Step};
use crate::progress::Monitor;
use crate::recording::hold_out::HoldOut;
use crate::recording::split::{Split, unusable};

/// The session with this held out and its ladder identified or trained anew, step by step. Models that are not on it are gone.
pub(super) fn hold_out(session: &Session, asked: &HoldOut, monitor: &Monitor) -> Result<Session, SessionError> {
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let split = Split::as_asked(recording, asked, &unusable(recording))?;
    let source = session.source.as_deref().map(|source| Source { held_out: asked.clone(), ..source.clone() });
    let (models, ladder, source) = (Vec::new(), Vec::new(), source.map(Arc::new));
    let (report, proposals, sweep) = (None, None, None);
    let mut other = Session { split, source, models, ladder, report, proposals, sweep, ..session.clone() };
    let count = session.ladder.len() as f32;
    for (number, old) in session.ladder.iter().enumerate() {
        let part = monitor.part(number as f32 / count..(number + 1) as f32 / count);
        let new = anew(old, &other, &part)?;
        other.ladder.push(new);
    }
    Ok(other)
}

/// A step of the ladder as the next one of this session, under its name.
fn anew(old: &Step, session: &Session, monitor: &Monitor) -> Result<Arc<Step>, SessionError> {
    let plan = old.run.as_ref().map_or_else(|| session.plan.clone(), |run| run.plan.clone());
    let planned = Session { plan, ..session.clone() };
    let before = old.run.as_ref().filter(|run| run.is_warm).and_then(|_| session.current());
    let mut new = step(old.fitted.model.clone(), before.map(|step| &step.fitted), &planned, monitor)?;
    Arc::make_mut(&mut new).name.clone_from(&old.name);
    Ok(new)
}
