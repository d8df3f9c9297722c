//! Searches for tests.

use super::Search;
use crate::diagnosis::candidates::Library;
use crate::effect::{Effect, registry};
use crate::model::design::Design;
use crate::model::{self, Preset};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;

/// A search for these effects that has come to its end.
pub fn searched<'a>(recording: &'a Recording, effects: &[&str]) -> Search<'a> {
    let split = Split::automatic(recording);
    let body = Preset::RigidBody.model(recording).unwrap();
    let body = model::fit(&body, recording, &split, &Monitor::new()).unwrap();
    let effects: Vec<&'static Effect> = effects.iter().map(|id| registry::find(id).unwrap()).collect();
    let design = Design::new(recording, &split).unwrap();
    let (library, _) = Library::new(&body, design, &effects, &Monitor::new()).unwrap();
    let mut search = Search::new(library);
    search.run(&Monitor::new()).unwrap();
    search
}

/// What the search has found.
pub fn found(search: &Search) -> Vec<(&'static str, Option<usize>)> {
    let groups = search.active.iter().map(|&group| &search.library.groups[group]);
    groups.map(|group| (group.effect.id, group.joint)).collect()
}

/// The candidate of an effect on a joint.
pub fn group(search: &Search, id: &str, joint: usize) -> usize {
    let mut groups = search.library.groups.iter();
    groups.position(|group| group.effect.id == id && group.joint == Some(joint)).unwrap()
}
