//! What was opened and saved of late.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::file;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::ReadOptions;
use crate::session::Command;

/// How many are remembered.
const MOST: usize = 8;

/// A session, or a recording and how it was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recent {
    paths: Vec<PathBuf>,
    /// How it was read, and what was held out, as JSON; empty for a session.
    reading: String,
}

/// What was opened and saved of late, the newest first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Recents(Vec<Recent>);

impl Recent {
    /// What a command opened; `None` if it opened nothing.
    pub fn of(command: &Command) -> Option<Recent> {
        let absolute = |path: &PathBuf| file::absolute(path);
        match command {
            Command::Restore { path } => Some(Recent { paths: vec![absolute(path)], reading: String::new() }),
            Command::Open { paths, options, held_out } => {
                let reading = serde_json::to_string(&(options, held_out)).unwrap_or_default();
                // Files that belong together (`q.npy+tau.npy`) are one path here, which need not be one of the system.
                let is_there = paths.iter().all(|path| path.exists());
                let paths = if is_there { paths.iter().map(absolute).collect() } else { paths.clone() };
                Some(Recent { paths, reading })
            }
            _ => None,
        }
    }

    /// Opens it again as it was opened.
    pub fn open(&self) -> Command {
        let (options, held_out) = serde_json::from_str::<(ReadOptions, HoldOut)>(&self.reading).unwrap_or_default();
        Command::open(self.paths.clone(), options, held_out)
    }

    /// Its first file's name, and how many more there are.
    pub fn name(&self) -> String {
        let name = self.paths.first().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
        match self.paths.len() {
            0 | 1 => name.into_owned(),
            count => format!("{name} and {} more", count - 1),
        }
    }

    /// Where it is.
    pub fn place(&self) -> String {
        self.paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join("\n")
    }
}

impl Recents {
    /// The newest first.
    pub fn all(&self) -> &[Recent] {
        &self.0
    }

    /// Remembers something as the newest.
    pub fn add(&mut self, newest: Recent) {
        self.0.retain(|other| other.paths != newest.paths);
        self.0.insert(0, newest);
        self.0.truncate(MOST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_opened_is_opened_again_in_the_same_way() {
        let options = ReadOptions { rate_hz: Some(250.0), ..ReadOptions::default() };
        let opened =
            Command::open(vec!["a.csv".into(), "b.csv".into()], options.clone(), HoldOut::named(vec!["b".to_owned()]));
        let recent = Recent::of(&opened).unwrap();
        assert_eq!((recent.name().as_str(), recent.open().title()), ("a.csv and 1 more", opened.title()));
        let Command::Open { options: again, held_out, .. } = recent.open() else { panic!("it is a recording") };
        assert_eq!((again, held_out), (options, HoldOut::named(vec!["b".to_owned()])));
        let session = Recent::of(&Command::Restore { path: "mine.torquescope".into() }).unwrap();
        assert!(matches!(session.open(), Command::Restore { path } if path.is_absolute()));
        assert_eq!(Recent::of(&Command::Diagnose), None);
    }

    #[test]
    fn the_newest_stands_first_and_each_once() {
        let mut recents = Recents::default();
        let recent =
            |name: &str| Recent::of(&Command::Restore { path: format!("/{name}.torquescope").into() }).unwrap();
        ["a", "b", "a"].iter().for_each(|name| recents.add(recent(name)));
        assert_eq!(recents.all(), [recent("a"), recent("b")]);
        (0..20).for_each(|number| recents.add(recent(&number.to_string())));
        assert_eq!((recents.all().len(), &recents.all()[0]), (MOST, &recent("19")));
    }
}
