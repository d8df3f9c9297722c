//! What the other joints have: friction that most of them show is looked for once more on those where the search did not find it.
//!
//! Motors and gears of an arm are mostly of one make, so that what its other joints have is likely on this one, too. On one joint
//! alone dry friction and friction that grows with speed may each pass for the other.
//!
//! Source: of n joints k have it, so one more has it with probability (k + 1)/(n + 2): the rule of succession, Laplace, Essai
//! philosophique sur les probabilités (1814).

use super::Search;
use super::gates;
use crate::effect::Family;

impl Search<'_> {
    /// Adds such friction where its evidence and the other joints together speak for it.
    pub(super) fn complete(&mut self) {
        let families = self.common_families();
        for joint in 0..self.weights.len() {
            for &family in &families {
                let odds = self.odds_of(family, Some(joint));
                if odds <= 1.0 || self.shows(family, joint) {
                    continue;
                }
                let sets = self.sets_with(family, joint).into_iter().map(|set| (self.priced_cost(&set), set));
                let Some((cost, set)) = sets.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
                if cost - 2.0 * odds.ln() < self.priced_cost(&self.active) {
                    self.active = set;
                }
            }
        }
    }

    /// The sets with the common form of a family on a joint. Beside it an odd form of the other kind of friction may have nothing left to
    /// say that the common one does not.
    fn sets_with(&self, family: Family, joint: usize) -> Vec<Vec<usize>> {
        let groups = &self.library.groups;
        let is_here = |group: usize| groups[group].joint == Some(joint);
        let commons = self.common().filter(|&group| is_here(group) && self.is_open(group));
        let (forms, commons): (Vec<usize>, Vec<usize>) =
            commons.partition(|&group| groups[group].effect.family == family);
        let mut sets = Vec::new();
        for form in forms {
            sets.push(self.with(form));
            for &common in &commons {
                let other = groups[common].effect.family;
                let stays = |&group: &usize| !is_here(group) || groups[group].effect.family != other;
                let rest: Vec<usize> = self.active.iter().copied().filter(stays).collect();
                if rest.len() < self.active.len() {
                    sets.push(rest.into_iter().chain([common, form]).collect());
                }
            }
        }
        sets.retain(|set: &Vec<usize>| gates::are_new_ones_physical(self, set));
        sets
    }

    /// Whether a group is of such friction, and most of the other joints have it.
    pub fn is_usual(&self, group: usize) -> bool {
        let groups = &self.library.groups;
        let (family, joint) = (groups[group].effect.family, groups[group].joint);
        self.common().any(|common| groups[common].effect.family == family) && self.odds_of(family, joint) > 1.0
    }

    /// The candidates of friction that nearly every joint has.
    pub(super) fn common(&self) -> impl Iterator<Item = usize> {
        let groups = &self.library.groups;
        (0..groups.len()).filter(|&group| groups[group].effect.is_common_friction())
    }

    /// Their families.
    pub(super) fn common_families(&self) -> Vec<Family> {
        let mut families: Vec<Family> = self.common().map(|group| self.library.groups[group].effect.family).collect();
        families.sort_unstable();
        families.dedup();
        families
    }

    /// Odds that a joint has something of a family, from the other joints alone.
    pub(super) fn odds_of(&self, family: Family, joint: Option<usize>) -> f64 {
        let others: Vec<usize> = (0..self.weights.len()).filter(|&other| Some(other) != joint).collect();
        let having = others.iter().filter(|&&other| self.shows(family, other)).count();
        (having as f64 + 1.0) / ((others.len() - having) as f64 + 1.0)
    }

    /// Whether something of a family was found on a joint.
    pub(super) fn shows(&self, family: Family, joint: usize) -> bool {
        let mut groups = self.active.iter().map(|&group| &self.library.groups[group]);
        groups.any(|group| group.effect.family == family && group.joint == Some(joint))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{group, searched};
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    /// Coulomb friction is hidden on joints 1 and 2 of three: it is usual on the third, but its data have none.
    #[test]
    fn what_the_others_have_is_usual_and_yet_not_invented() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let search = searched(&recording, &["coulomb-friction", "viscous-friction", "joint-spring"]);
        let group = |id: &str, joint: usize| group(&search, id, joint);
        let found: Vec<usize> = (0..2).map(|joint| group("coulomb-friction", joint)).collect();
        assert!(search.active.len() == 2 && found.iter().all(|group| search.active.contains(group)));
        assert!(search.is_usual(group("coulomb-friction", 2)));
        for (id, joint) in [("coulomb-friction", 0), ("viscous-friction", 2), ("joint-spring", 2)] {
            assert!(!search.is_usual(group(id, joint)), "{id} on joint {}", joint + 1);
        }
    }
}
