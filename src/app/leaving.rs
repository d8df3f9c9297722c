//! How the window is closed: what runs is ended and what is unsaved is saved, as the user says; without an answer it stays open.

use std::path::PathBuf;

use egui::{Context, ViewportCommand};

use super::TorquescopeApp;
use super::desk::{Parting, Tone};
use super::keeper::{Kept, Note};
use crate::session::{Document, Generation, file};

/// What is done before the window closes.
pub enum Leaving {
    /// The training ends with the best that it has; what then is there goes into this file.
    Finishing(PathBuf),
    /// The document is being saved.
    Saving,
    /// Nothing any more.
    Decided,
}

impl TorquescopeApp {
    /// What is at work, in words.
    pub(super) fn at_work(&self) -> Option<String> {
        let running = self.running.as_ref().map(|running| match running.epochs.last() {
            Some(epoch) => format!("“{}” (epoch {} of {})", running.job.name(), epoch.epoch, epoch.epochs),
            None => format!("“{}”", running.job.name()),
        });
        let drawing = || Some(format!("“{}”", self.drawing.as_ref()?.name()));
        running.or_else(|| Some(format!("“{}”", self.screens.busy()?.title))).or_else(drawing)
    }

    /// Somebody closes the window: unless all is saved and at rest, that is asked about first.
    pub(super) fn hear_closing(&mut self, ctx: &Context) {
        let asked = ctx.input(|input| input.viewport().close_requested());
        if !asked
            || matches!(self.leaving, Some(Leaving::Decided))
            || (self.at_work().is_none() && self.unsaved.is_empty())
        {
            return;
        }
        ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        // A window that is minimised would ask where nobody sees it.
        ctx.send_viewport_cmd(ViewportCommand::Minimized(false));
        ctx.send_viewport_cmd(ViewportCommand::Focus);
        if self.leaving.is_none() {
            let path = self.filed.file().map_or_else(|| self.proposed_file().into(), PathBuf::from);
            self.overlays.ask_closing(path.display().to_string());
        }
    }

    /// A name for the file of a document that has none yet.
    pub(super) fn proposed_file(&self) -> String {
        let name = self.filed.name(self.document().history.current());
        let plain = |letter: char| if letter.is_alphanumeric() { letter } else { '-' };
        let name: String = name.chars().map(plain).collect();
        format!("{}.{}", if name.is_empty() { "session" } else { &name }, file::ENDING)
    }

    /// Leaves as the user said.
    pub(super) fn leave(&mut self, parting: Parting, ctx: &Context) {
        match parting {
            Parting::Stay => self.stay(),
            Parting::KeepCopy => {
                if let Some(running) = &mut self.running {
                    running.job.stop("you closed the window");
                }
                self.decide(ctx);
            }
            Parting::Save(path) => {
                let trains = self.running.as_ref().is_some_and(|running| running.plan.is_some());
                if let Some(running) = &mut self.running {
                    match trains {
                        true => running.job.finish("you closed the window"),
                        false => running.job.stop("you closed the window"),
                    }
                    running.finishing = trains;
                }
                self.leaving = Some(Leaving::Finishing(path));
            }
        }
    }

    /// The window stays open after all.
    fn stay(&mut self) {
        self.leaving = None;
        self.overlays.closing = None;
    }

    fn decide(&mut self, ctx: &Context) {
        self.leaving = Some(Leaving::Decided);
        self.overlays.closing = None;
        ctx.send_viewport_cmd(ViewportCommand::Close);
    }

    /// Goes on with leaving, once what it waits for is there.
    pub(super) fn poll_leaving(&mut self) {
        if self.running.is_none()
            && let Some(Leaving::Finishing(path)) = &self.leaving
        {
            let path = path.clone();
            self.leaving = Some(Leaving::Saving);
            self.keeper.save(path, self.document());
        }
    }

    pub(super) fn poll_keeper(&mut self, ctx: &Context) {
        if self.keeper.is_busy() {
            ctx.request_repaint_after(std::time::Duration::from_millis(50));
        }
        match self.keeper.poll() {
            Some(Kept::Saved { path, mark, saved }) => {
                self.filed.is_in(&path, mark, Some(saved));
                self.remember(&path);
                self.messages.toast(Tone::Info, format!("Saved: {}.", path.display()), ctx);
                if matches!(self.leaving, Some(Leaving::Saving)) {
                    self.decide(ctx);
                }
            }
            Some(Kept::Failed(message)) => {
                self.stay();
                let text = format!("The session was not saved: {message}.");
                self.messages.tell(Tone::Error, text, "Your session is as it was; save it elsewhere.");
            }
            Some(Kept::NoCopy(message)) => {
                let text = format!("There is no recovery copy of this session: {message}.");
                self.messages.tell(
                    Tone::Warning,
                    text,
                    "It is tried again after every change; until then, save often.",
                );
            }
            None => (),
        }
    }

    /// All that a file keeps; where there is no recording now, it stands where there was one last.
    pub(super) fn document(&self) -> Document {
        Document { history: self.history.clone().to_recording(), view: self.view() }
    }

    /// What is told of a copy of this document.
    pub(super) fn note(&self, document: &Document, closed: bool) -> Note {
        let name = self.filed.name(document.history.current());
        let has_work = !self.filed.unsaved(&self.history, &self.set_up()).is_empty();
        Note { name, has_work, closed, owner: None }
    }

    /// What is in no file, and can't be in one of this session either: a document is of one recording, so that what undo leads back to
    /// needs others.
    pub(super) fn left_beside(&self, session: Generation) -> impl Iterator<Item = (Generation, &str)> {
        self.filed.left(&self.history).filter(move |(generation, _)| *generation != session)
    }

    /// These, each as a document of its own with its name.
    pub(super) fn documents_beside(&self, session: Generation) -> impl Iterator<Item = (Document, &str)> {
        self.left_beside(session).map(|(generation, name)| {
            (Document { history: self.history.clone().back_to(generation), view: self.view() }, name)
        })
    }

    /// The window is closed: what no file has is left for the next one.
    pub(super) fn close(&mut self) {
        let document = self.document();
        let session = document.history.current();
        let note = self.note(&document, true);
        let is_saved = self.filed.is_saved(session, &self.set_up());
        let aside = self.documents_beside(session.generation).map(|(document, name)| {
            (document, Note { name: name.to_owned(), has_work: true, closed: true, owner: None })
        });
        let aside: Vec<(Document, Note)> = aside.collect();
        self.keeper.close((session.recording.is_some() && !is_saved).then_some((document, note)), &aside);
    }
}
