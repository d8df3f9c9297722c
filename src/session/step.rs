//! A step of the ladder: a model that is identified or trained on the session's recording, and measured.

use std::sync::Arc;

use super::error::SessionError;
use super::runs::Keeper;
use super::{Generation, Session, Step, default_name};
use crate::model::{self, Evaluation, Fitted, Model};
use crate::progress::Monitor;
use crate::training::fit::{KeepRun, Trained};
use crate::training::{self, Ending, TrainError};

/// Identifies or trains a model and measures it. With `before`, networks start from its weights.
pub(super) fn step(
    model: Model,
    before: Option<&Fitted>,
    session: &Session,
    monitor: &Monitor,
) -> Result<Arc<Step>, SessionError> {
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    if model.is_learned() {
        return trained(session, monitor, &mut |keep| {
            training::fit::fit(&model, recording, &session.split, &session.plan, before, monitor, keep)
        });
    }
    let fitted = model::fit(&model, recording, &session.split, monitor)?;
    let evaluation = Evaluation::of(&fitted, recording, &session.split)?;
    let (generation, name) = (Generation::next(), default_name(&model));
    let (history, ending, rollout, run) = (Vec::new(), None, None, None);
    Ok(Arc::new(Step { generation, name, fitted, evaluation, history, ending, rollout, run }))
}

/// Follows a training, keeps its checkpoint, and measures what it gives.
pub(super) fn trained(
    session: &Session,
    monitor: &Monitor,
    train: &mut dyn FnMut(&mut KeepRun) -> Result<Trained, TrainError>,
) -> Result<Arc<Step>, SessionError> {
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let mut keeper = Keeper::new(session.checkpoint_file.as_deref())?;
    let Trained { fitted, ending, history, run } = train(&mut |run| keeper.epoch(run, monitor))?;
    keeper.end(&run, monitor);
    if let (Ending::Failed(reason), true) = (&ending, history.is_empty()) {
        return Err(SessionError::TrainingFailed(reason.clone()));
    }
    let evaluation = Evaluation::of(&fitted, recording, &session.split)?;
    let (generation, name) = (Generation::next(), default_name(&fitted.model));
    let (ending, rollout, run) = (Some(ending), None, Some(Arc::new(run)));
    Ok(Arc::new(Step { generation, name, fitted, evaluation, history, ending, rollout, run }))
}
