//! Stub.
use super::{Posture, Recording, check::Finding, mapping::Mapping};
use crate::progress::Monitor;
use std::path::PathBuf;
/// Stub.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// Stub.
    pub zero: Option<Posture>,
}
/// Stub.
#[derive(Debug, thiserror::Error)]
#[error("stub")]
pub struct ReadError;
/// Stub.
pub struct Import {
    /// Stub.
    pub recording: Recording,
    /// Stub.
    pub findings: Vec<Finding>,
    /// Stub.
    pub mapping: Mapping,
}
/// Stub.
pub fn read(_paths: &[PathBuf], _options: &ReadOptions, _monitor: &Monitor) -> Result<Import, ReadError> {
    Err(ReadError)
}
