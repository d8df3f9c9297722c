//! Models and data leave the window as files, by what the commands `export`, `convert` and `predict` call.

use std::path::{Path, PathBuf};

use super::TorquescopeApp;
use super::desk::{DataOut, ModelOut};
use crate::export::files::{Files, FilesError};
use crate::export::outgoing::{Outgoing, OutgoingError, outgoing};
use crate::export::part::EmptyPart;
use crate::export::recorded::{self, RecordedError};
use crate::export::torques::{self, TorquesError};
use crate::file::absolute;
use crate::progress::{Event, Monitor, Stopped};
use crate::recording::read::parts;
use crate::recording::write::{Form, UnknownForm, WriteError};
use crate::session::{Session, SessionError, Source};
use crate::work::Job;

/// Nothing was written.
#[derive(Debug, thiserror::Error)]
enum OutError {
    #[error(transparent)]
    Model(#[from] OutgoingError),
    #[error(transparent)]
    Session(#[from] SessionError),
    #[error(transparent)]
    Part(#[from] EmptyPart),
    #[error(transparent)]
    Recorded(#[from] RecordedError),
    #[error(transparent)]
    Form(#[from] UnknownForm),
    #[error(transparent)]
    Torques(#[from] TorquesError),
    #[error(transparent)]
    Table(#[from] WriteError),
    #[error(transparent)]
    Files(#[from] FilesError),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl TorquescopeApp {
    /// Writes a model, and tells what its files don't hold.
    pub(super) fn write_model(&mut self, out: ModelOut, ctx: &egui::Context) {
        let session = self.history.current().clone();
        self.write_out(ctx, move |inputs, monitor| {
            let ModelOut { model, wish } = out;
            monitor.report(0.0, "writing the model")?;
            let Outgoing { files, not_held, .. } = outgoing(&model.fitted, &wish, session.recording.as_deref())?;
            write(&files, &inputs, monitor)?;
            let path = absolute(wish.output.as_deref().unwrap_or(Path::new("")));
            if !not_held.is_empty() {
                let lines: Vec<String> = not_held.iter().map(ToString::to_string).collect();
                let name = path.file_name().unwrap_or_default().display();
                monitor.tell(Event::Warning(format!("Not in {name}: {}", lines.join(". "))));
            }
            Ok(path)
        });
    }

    /// Writes the recording or what a model says of it.
    pub(super) fn write_data(&mut self, out: DataOut, ctx: &egui::Context) {
        let session = self.history.current().clone();
        self.write_out(ctx, move |inputs, monitor| {
            let files = data(&session, &out, &monitor.part(0.0..0.9))?;
            write(&files, &inputs, monitor)?;
            Ok(absolute(&out.path))
        });
    }

    /// Makes files and writes them, as a job.
    fn write_out(
        &mut self,
        ctx: &egui::Context,
        work: impl FnOnce(Vec<PathBuf>, &Monitor) -> Result<PathBuf, OutError> + Send + 'static,
    ) {
        let (context, inputs) = (ctx.clone(), self.inputs());
        let wake = move || context.request_repaint();
        self.drawing = Some(Job::spawn("export", wake, move |monitor| work(inputs, monitor)));
    }

    /// What the session was made of: nothing of that is written over.
    fn inputs(&self) -> Vec<PathBuf> {
        let source = self.history.current().source.as_deref();
        let logs = source.and_then(Source::files).unwrap_or_default();
        logs.iter().flat_map(|path| parts(path)).chain(self.filed.file().map(Path::to_owned)).collect()
    }
}

/// The files of data.
fn data(session: &Session, out: &DataOut, monitor: &Monitor) -> Result<Files, OutError> {
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let Some(model) = &out.torques_of else {
        monitor.report(0.0, "writing the recording")?;
        return Ok(recorded::files(&*out.part.cut(recording, &session.split)?, &out.path)?);
    };
    let form = Form::of(&out.path)?.unwrap_or(Form::Npz);
    let stretches = out.part.stretches(recording, &session.split)?;
    let table = torques::table(&model.fitted, recording, &stretches, monitor)?;
    Ok(Files::one(&out.path, table.to_bytes(form)?))
}

/// Writes them, unless it was stopped before.
fn write(files: &Files, inputs: &[PathBuf], monitor: &Monitor) -> Result<(), OutError> {
    files.check(inputs)?;
    // From here on it is not stopped any more.
    monitor.report(0.9, "writing")?;
    Ok(files.write()?)
}
