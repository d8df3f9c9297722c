//! Which file the document is in, and what the files that the window read or wrote were then.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::keeper::clock;
use crate::file::{self, Mark, absolute};
use crate::session::{Generation, History, Session, View};

/// Which file the document is in, and what the files that the window read or wrote were then.
#[derive(Default)]
pub struct Filed {
    file: Option<PathBuf>,
    /// The session that is in it, and what was set up to be looked at then.
    saved: Option<(Generation, View)>,
    /// The session that was only opened or simulated so far: nobody loses work with it.
    fresh: Option<Generation>,
    /// What nobody had saved when another document took its place, and what it was called: undo leads back to it.
    left: Vec<(Generation, String)>,
    known: BTreeMap<PathBuf, Mark>,
}

impl Filed {
    /// The document was read from a file, or written into one; what is in it is this session, looked at
    /// like this, or none that is known.
    pub fn is_in(&mut self, path: &Path, mark: Option<Mark>, saved: Option<(Generation, View)>) {
        if let Some((generation, _)) = &saved {
            self.left.retain(|(left, _)| left != generation);
        }
        self.file = Some(path.to_owned());
        // Without a mark there is no such file any more.
        self.saved = saved.filter(|_| mark.is_some());
        match mark {
            Some(mark) => drop(self.known.insert(absolute(path), mark)),
            None => drop(self.known.remove(&absolute(path))),
        }
    }

    /// The document begins anew, and is in no file yet.
    pub fn begin(&mut self, is_fresh: bool, generation: Generation) {
        self.file = None;
        self.saved = None;
        self.fresh = is_fresh.then_some(generation);
    }

    /// Another document takes the place of the one that this history is at.
    pub fn leave(&mut self, history: &History, set_up: &View) {
        // What undo led back to, and was worked on from there, is in the document of what is left now.
        self.left.retain(|(generation, _)| history.left_behind(*generation));
        let session = history.current();
        if self.loses(session, set_up) {
            self.left.push((session.generation, self.name(session)));
        }
    }

    /// What was left before it was saved, and undo leads back to, with what it was called.
    pub fn left<'a>(&'a self, history: &'a History) -> impl Iterator<Item = (Generation, &'a str)> {
        let is_there = |(generation, _): &&(Generation, String)| history.left_behind(*generation);
        self.left.iter().filter(is_there).map(|(generation, name)| (*generation, name.as_str()))
    }

    /// The file of the document.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Whether the session is in its file as it is, with what is set up to be looked at.
    pub fn is_saved(&self, session: &Session, set_up: &View) -> bool {
        let is_same =
            |(generation, view): &(Generation, View)| *generation == session.generation && view.is_set_up_as(set_up);
        self.saved.as_ref().is_some_and(is_same)
    }

    /// What somebody worked on and would lose, in words: the session, and what undo leads back to.
    pub fn unsaved(&self, history: &History, set_up: &View) -> Vec<String> {
        let session = history.current();
        let current =
            self.loses(session, set_up).then(|| format!("{} has changes that are in no file.", self.name(session)));
        let kept = "has changes that are in no file: a copy of it is kept.";
        let left = self.left(history).map(|(_, name)| format!("{name}, to which undo leads back, {kept}"));
        current.into_iter().chain(left).collect()
    }

    /// Whether somebody worked on this session, and would lose that.
    fn loses(&self, session: &Session, set_up: &View) -> bool {
        let is_fresh = self.fresh == Some(session.generation);
        session.recording.is_some() && !is_fresh && !self.is_saved(session, set_up)
    }

    /// Whether the window knows what a file is now: it may write it without a question.
    pub fn knows(&self, path: &Path) -> bool {
        self.known.contains_key(&absolute(path))
    }

    /// What somebody would lose if this file were written; `None` if nothing.
    pub fn would_overwrite(&self, path: &Path) -> Option<String> {
        let now = file::mark(path)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match self.known.get(&absolute(path)) {
            Some(known) if *known == now => None,
            Some(_) => {
                Some(format!("{name} was changed{} by another program since it was opened or saved here.", at(now)))
            }
            None => Some(format!("There is a file {name} already{}.", at(now))),
        }
    }

    /// What the document is called.
    pub fn name(&self, session: &Session) -> String {
        let of_file =
            self.file.as_ref().and_then(|path| path.file_stem()).map(|stem| stem.to_string_lossy().into_owned());
        of_file.or_else(|| Some(session.recording.as_ref()?.name.clone())).unwrap_or_default()
    }

    /// What stands in the title bar: a point before the name means that it is not saved.
    pub fn title(&self, session: &Session, is_unsaved: bool) -> String {
        let mark = if is_unsaved { "• " } else { "" };
        match self.name(session) {
            name if name.is_empty() => format!("{mark}Torquescope"),
            name => format!("{mark}{name} — Torquescope"),
        }
    }
}

fn at(mark: Mark) -> String {
    mark.written().map_or(String::new(), |time| format!(" ({})", clock(time)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_somebody_else_wrote_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.torquescope");
        let (mut filed, session) = (Filed::default(), Session::default());
        assert_eq!(filed.would_overwrite(&path), None, "there is none");
        file::write(&path, b"theirs").unwrap();
        assert!(filed.would_overwrite(&path).is_some_and(|text| text.contains("already")));
        filed.is_in(&path, file::mark(&path), Some((session.generation, View::default())));
        assert!(filed.would_overwrite(&path).is_none() && filed.is_saved(&session, &View::default()));
        file::write(&path, b"theirs again").unwrap();
        assert!(filed.would_overwrite(&path).is_some_and(|text| text.contains("was changed")));
    }
}
