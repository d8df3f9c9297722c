//! Writes MCAP logs: joint states in chunks, as rosbag2 does.

use ::mcap::Compression;

use super::message::names;
use crate::recording::{Trajectory, write};
use crate::selftest::SelftestError;

/// A run as a log whose chunks are packed in this way.
pub fn joint_states(run: &Trajectory, compression: Option<Compression>) -> Result<Vec<u8>, SelftestError> {
    let names = names(run);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    write::joint_states(std::slice::from_ref(run), &names, compression)
        .map_err(|error| SelftestError::making("a log of messages")(&error))
}
