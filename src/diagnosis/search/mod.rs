//! The search for the set of missing effects.
//!
//! [`forward`]: of all candidates the one with the best evidence is tried; it must pass every gate of [`gates`]. Then effects
//! that others made superfluous leave again ([`backward`] elimination), and each one is swapped for a rival if that explains
//! more for its price ([`swap`]); [`shape`] refines the shape of each beside the others; last, friction that the other joints have is
//! looked for once more ([`common`]). Whoever has judged the set asks whether common friction does as well as [`odd`] forms of it. The model's own parameters (the base
//! parameters above all) are estimated anew with every candidate: a biased rigid body hides effects and fakes others.

mod backward;
mod common;
mod forward;
pub(super) mod gates;
mod left_out;
mod odd;
mod shape;
mod state;
mod swap;
#[cfg(test)]
pub(super) mod testing;

pub use gates::FEWEST_BLOCKS;
pub use odd::odds_of_form;
pub use state::{CLOSE, MARGIN, Search, Unseen};
pub use swap::Rival;

use super::report::Refusal;
use crate::model::ModelError;
use crate::progress::{Event, Monitor};

/// Most effects that one diagnosis names, over all joints.
const MOST_EFFECTS: usize = 24;
/// Most rounds of the search, each with a better rigid body.
const LOAD_ROUNDS: usize = 3;

impl Search<'_> {
    /// Runs the search to its end. Candidates that had evidence but failed a gate come back with the reason.
    ///
    /// The effects that were found correct the rigid body, and with it the candidates that depend on its torque; so the search
    /// goes on until they change nothing.
    ///
    /// # Errors
    /// [`ModelError`] if it was stopped or a column can't be computed.
    pub fn run(&mut self, monitor: &Monitor) -> Result<Vec<(usize, Refusal)>, ModelError> {
        let mut refused: Vec<(usize, Refusal)> = Vec::new();
        for round in 0..LOAD_ROUNDS {
            let before = self.active.clone();
            refused.clear();
            for step in 0..MOST_EFFECTS {
                monitor.report(0.45 + 0.1 * round as f32 + 0.004 * step as f32, "searching for missing effects")?;
                let found = self.next_best(&mut refused)?.map_or_else(|| self.best_pair(&refused), |group| vec![group]);
                if found.is_empty() {
                    break;
                }
                for &group in &found {
                    self.active = self.with(group);
                }
                if found.iter().any(|&group| self.library.groups[group].effect.facts.depends_on_load) {
                    // Each time the error of the load shrinks by the strength of the effect.
                    for _ in 0..LOAD_ROUNDS {
                        self.reload()?;
                    }
                }
                self.settle()?;
                self.follow()?;
                let groups = self.active.iter().map(|&group| &self.library.groups[group]);
                monitor.tell(Event::Found(groups.map(|group| group.effect.placed(group.joint)).collect()));
            }
            if self.active == before {
                break;
            }
            self.refine_other_forms()?;
            self.reload()?;
            self.settle()?;
            // The next round is not to explain what no candidate explains.
            if self.weigh_by_remainder() {
                self.settle()?;
            }
        }
        for _ in 0..LOAD_ROUNDS {
            if !self.weigh_by_remainder() {
                break;
            }
            self.settle()?;
        }
        if self.simplify() {
            self.refine_found()?;
        }
        self.complete();
        refused.retain(|(group, _)| !self.active.contains(group));
        Ok(refused)
    }

    /// Settles the set after a change: superfluous effects leave, rivals that explain more take over, shapes are refined
    /// beside the others.
    fn settle(&mut self) -> Result<(), ModelError> {
        self.prune();
        self.swap();
        self.refine_found()
    }
}
