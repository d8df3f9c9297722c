//! What is asked to be held out of a recording, before it is known which stretches of it that makes.

use serde::{Deserialize, Serialize};

use super::Recording;

/// One in so many parts is held out.
pub(super) const PARTS: usize = 5;
/// With fewer trajectories than this the parts are time blocks.
const FEWEST_TRAJECTORIES: usize = 4;

/// What is to be held out. In files it is a number or a list of names.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Written")]
pub enum HoldOut {
    /// Every fifth trajectory or, with fewer than four trajectories, one of each five of about twenty time blocks; in which of their
    /// [`turns`], counted from 0.
    Fifth(usize),
    /// The trajectories with these names.
    Trajectories(Vec<String>),
}

/// It as files have it.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Fifth(usize),
    Trajectories(Vec<String>),
}

/// A number of a fifth that there is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("there are {PARTS} fifths to hold out, counted from 0; none has the number {0}")]
pub struct NoSuchFifth(usize);

impl TryFrom<Written> for HoldOut {
    type Error = NoSuchFifth;

    fn try_from(written: Written) -> Result<Self, NoSuchFifth> {
        match written {
            Written::Fifth(turn) if turn < PARTS => Ok(HoldOut::Fifth(turn)),
            Written::Fifth(turn) => Err(NoSuchFifth(turn)),
            Written::Trajectories(names) => Ok(HoldOut::named(names)),
        }
    }
}

/// What is held out when nobody chooses.
impl Default for HoldOut {
    fn default() -> Self {
        HoldOut::Fifth(0)
    }
}

impl HoldOut {
    /// The trajectories with these names; with none, what is held out when nobody chooses.
    pub fn named(names: Vec<String>) -> Self {
        if names.is_empty() { HoldOut::default() } else { HoldOut::Trajectories(names) }
    }

    /// The part of this recording whose turn comes next, until each was held out once; `None` also where trajectories were named.
    pub fn next(&self, recording: &Recording) -> Option<Self> {
        match self {
            HoldOut::Fifth(turn) => (turn + 1 < turns(recording)).then_some(HoldOut::Fifth(turn + 1)),
            HoldOut::Trajectories(_) => None,
        }
    }
}

/// How many turns there are until all of a recording was held out once.
pub fn turns(recording: &Recording) -> usize {
    if is_by_time_block(recording) { PARTS } else { recording.trajectories.len().min(PARTS) }
}

/// Whether a recording has so few trajectories that parts of them are held out where none is named.
pub fn is_by_time_block(recording: &Recording) -> bool {
    recording.trajectories.len() < FEWEST_TRAJECTORIES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::split::tests::recording;

    #[test]
    fn files_have_a_number_or_names() {
        for (text, held_out) in [
            ("[]", HoldOut::default()),
            ("0", HoldOut::default()),
            ("4", HoldOut::Fifth(4)),
            (r#"["a"]"#, HoldOut::Trajectories(vec!["a".to_owned()])),
        ] {
            let read: HoldOut = serde_json::from_str(text).unwrap();
            assert_eq!(read, held_out);
            assert_eq!(serde_json::from_str::<HoldOut>(&serde_json::to_string(&read).unwrap()).unwrap(), read);
        }
        let refused = serde_json::from_str::<HoldOut>("5").unwrap_err().to_string();
        assert!(refused.contains("none has the number 5"), "{refused}");
    }

    #[test]
    fn each_part_has_its_turn_once() {
        for (runs, count) in [(1, 5), (3, 5), (4, 4), (12, 5)] {
            let recording = recording(&vec![100; runs]);
            let all = std::iter::successors(Some(HoldOut::default()), |turn| turn.next(&recording));
            assert_eq!(all.count(), count, "{runs} trajectories");
        }
        assert_eq!(HoldOut::named(vec!["run 0".to_owned()]).next(&recording(&[100; 6])), None);
    }
}
