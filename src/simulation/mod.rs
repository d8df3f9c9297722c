//! Stub.
use crate::{progress::Monitor, recording::Recording};
/// Stub.
#[derive(Debug, Clone)]
pub struct Scenario;
/// Stub.
#[derive(Debug, thiserror::Error)]
#[error("stub")]
pub struct SimulationError;
/// Stub.
pub fn simulate(_scenario: &Scenario, _monitor: &Monitor) -> Result<Recording, SimulationError> {
    Err(SimulationError)
}
