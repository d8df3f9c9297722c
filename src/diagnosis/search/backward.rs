//! Backward elimination: what is no longer worth its price leaves the set.

use rayon::prelude::*;

use super::gates;
use super::state::{MARGIN, Search};

impl Search<'_> {
    /// Takes out what is no longer worth its price, what another effect's formula leaves, or what is no wave along this way; the weakest
    /// first.
    pub(super) fn prune(&mut self) {
        loop {
            let now = self.cost(&self.active);
            let margin = |&group: &usize| {
                if !self.library.groups[group].repeats() || gates::leaves_it(self, &self.active, group).is_some() {
                    return (group, f64::NEG_INFINITY);
                }
                let without: Vec<usize> = self.active.iter().copied().filter(|&other| other != group).collect();
                (group, self.cost(&without) - now - MARGIN * self.price_of(group))
            };
            let margins: Vec<_> = self.active.par_iter().map(margin).collect();
            let weakest = margins.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((group, margin)) if margin < 0.0 => self.active.retain(|&other| other != group),
                _ => return,
            }
        }
    }
}
