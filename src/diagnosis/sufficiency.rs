//! Whether data can show an effect at all: asked when the truth is known, to judge a diagnosis by what it could have found.

use super::candidates::Library;
use super::search::{MARGIN, Search};
use crate::effect::registry;
use crate::model::design::Design;
use crate::model::{Fitted, ModelError};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;

/// An effect that is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// Its id in the registry.
    pub effect: String,
    /// The joint (from 0); `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// Its shape parameters.
    pub shape: Vec<f64>,
}

/// How clearly the data show these effects beside `fitted`: at least 1 where the evidence suffices.
///
/// The true set, with its true shapes, is laid against each set that lacks one of its effects or has another one in its place.
/// The smallest evidence for the truth (drop of the weighted squared error, less the price of the parameters) counts, in units
/// of the evidence that a name needs. Effects that the base parameters absorb count where the arm is stated.
///
/// # Errors
/// [`ModelError`] if a column can't be computed, or the work was stopped.
pub fn sufficiency(
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    suspects: &[Suspect],
    monitor: &Monitor,
) -> Result<f64, ModelError> {
    let (library, _) = Library::new(fitted, Design::new(recording, split)?, &registry::sought(), monitor)?;
    let mut search = Search::new(library);
    let mut groups = Vec::new();
    for suspect in suspects {
        let is_it =
            |group: &super::candidates::Group| group.effect.id == suspect.effect && group.joint == suspect.joint;
        let Some(group) = search.library.groups.iter().position(is_it) else { return Ok(0.0) };
        search.reshape(group, suspect.shape.clone())?;
        groups.push(group);
    }
    search.active = groups.clone();
    search.reload()?;
    search.refine_other_forms()?;
    let truth = search.priced_cost(&groups);
    let mut least = f64::INFINITY;
    for &group in &groups {
        if search.is_absorbed(group, &[]) {
            least = if recording.stated_arm.is_some() { least } else { 0.0 };
            continue;
        }
        let without: Vec<usize> = groups.iter().copied().filter(|&other| other != group).collect();
        let price = search.price_of(group);
        least = least.min((search.priced_cost(&without) - truth) / (MARGIN * price));
        for rival in search.rivals(group) {
            // What contains the effect explains as much for a higher price.
            if search.library.groups[rival.group].includes(&search.library.groups[group]) {
                continue;
            }
            let priced = rival.cost + search.price_of_all(&rival.set);
            least = least.min((priced - truth) / (MARGIN * search.price));
        }
    }
    Ok(least)
}
