//! Which physical effect is missing: from a model and measurements, name it with evidence, and never cry wolf.

mod report;

pub use report::{Candidate, Evidence, MissingEffect, Report, Verdict};

use crate::model::{Fitted, ModelError};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;

/// Looks for what `fitted` lacks.
///
/// # Errors
/// [`ModelError`].
pub fn diagnose(
    _fitted: &Fitted,
    _recording: &Recording,
    _split: &Split,
    _monitor: &Monitor,
) -> Result<Report, ModelError> {
    todo!()
}
