//! What the other joints have: friction that most of them show is looked for once more on those where the search did not find it, and
//! its common form is put in the place of odd ones where these have too little to say for themselves.
//!
//! Motors and gears of an arm are mostly of one make, so that what its other joints have is likely on this one, too. On one joint
//! alone dry friction and friction that grows with speed may each pass for the other, and an odd form of one for both.
//!
//! Source: of n joints k have it, so one more has it with probability (k + 1)/(n + 2): the rule of succession, Laplace, Essai
//! philosophique sur les probabilités (1814).

use super::Search;
use super::gates;
use crate::effect::{Effect, Family};
use crate::model::ModelError;

/// Odds of a form that not nearly every joint has, before the data speak.
const RARE: f64 = 0.2;

/// Odds of a form beside the common one of its family, before the data speak.
pub fn odds_of_form(effect: &Effect) -> f64 {
    if effect.facts.everyday { 1.0 } else { RARE }
}

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

    /// Puts common friction in the place of odd forms of it where these are not likelier, or blocks that were left out don't confirm that
    /// they are, and adds what the other joints have; whether any changed.
    ///
    /// A difference of evidence says as much of two forms as `certainty` on their joint, at most 1: where more is left than noise, it may
    /// be that which tells them apart.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn prefer_common(&mut self, certainty: impl Fn(usize) -> f64) -> Result<bool, ModelError> {
        let before = self.active.clone();
        for joint in 0..self.weights.len() {
            let Some((set, odds)) = self.with_common_on(joint) else { continue };
            let worse = certainty(joint) * (self.priced_cost(&set) - self.priced_cost(&self.active));
            if worse < 2.0 * odds.ln() || !gates::is_confirmed(self, &set, &self.active) {
                self.active = set;
            }
        }
        let changed = self.active != before;
        if changed {
            self.refine_found()?;
        }
        Ok(changed)
    }

    /// The set with common friction in the place of all odd forms on a joint, and the odds for it before the data speak; `None` if there
    /// are none, if one has no common form among the candidates, or if the parameters of these are impossible.
    fn with_common_on(&self, joint: usize) -> Option<(Vec<usize>, f64)> {
        let groups = &self.library.groups;
        let families = self.common_families();
        let is_odd = |group: &usize| {
            let group = &groups[*group];
            group.joint == Some(joint) && families.contains(&group.effect.family) && !group.effect.is_common()
        };
        let (odd, mut set): (Vec<usize>, Vec<usize>) = self.active.iter().copied().partition(is_odd);
        if odd.is_empty() {
            return None;
        }
        let mut odds: f64 = odd.iter().map(|&group| 1.0 / odds_of_form(groups[group].effect)).product();
        let kept = set.len();
        for common in self.common().filter(|&group| groups[group].joint == Some(joint)) {
            let family = groups[common].effect.family;
            let is_new = !self.shows(family, joint);
            let of_family = self.odds_of(family, Some(joint));
            if set.contains(&common) || self.absorbed.contains(&common) || is_new && of_family <= 1.0 {
                continue;
            }
            set.push(common);
            odds *= if is_new { of_family } else { 1.0 };
        }
        let is_common_of = |family: Family, group: usize| {
            let group = &groups[group];
            group.joint == Some(joint) && group.effect.family == family && group.effect.is_common()
        };
        let stands = |&odd: &usize| set.iter().any(|&group| is_common_of(groups[odd].effect.family, group));
        let is_possible = set[kept..].iter().all(|&group| gates::is_physical(self, &set, group));
        (is_possible && odd.iter().all(stands)).then_some((set, odds))
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
        sets.retain(|set: &Vec<usize>| {
            let mut new = set.iter().filter(|group| !self.active.contains(group));
            new.all(|&group| gates::is_physical(self, set, group))
        });
        sets
    }

    /// Whether a group is of such friction, and most of the other joints have it.
    pub fn is_usual(&self, group: usize) -> bool {
        let groups = &self.library.groups;
        let (family, joint) = (groups[group].effect.family, groups[group].joint);
        self.common().any(|common| groups[common].effect.family == family) && self.odds_of(family, joint) > 1.0
    }

    /// The candidates of friction that nearly every joint has.
    fn common(&self) -> impl Iterator<Item = usize> {
        let groups = &self.library.groups;
        let is_common = |group: &usize| groups[*group].effect.is_common() && !groups[*group].effect.facts.is_offset;
        (0..groups.len()).filter(is_common)
    }

    /// Their families.
    fn common_families(&self) -> Vec<Family> {
        let mut families: Vec<Family> = self.common().map(|group| self.library.groups[group].effect.family).collect();
        families.sort_unstable();
        families.dedup();
        families
    }

    /// Odds that a joint has something of a family, from the other joints alone.
    fn odds_of(&self, family: Family, joint: Option<usize>) -> f64 {
        let others: Vec<usize> = (0..self.weights.len()).filter(|&other| Some(other) != joint).collect();
        let having = others.iter().filter(|&&other| self.shows(family, other)).count();
        (having as f64 + 1.0) / ((others.len() - having) as f64 + 1.0)
    }

    /// Whether something of a family was found on a joint.
    fn shows(&self, family: Family, joint: usize) -> bool {
        let mut groups = self.active.iter().map(|&group| &self.library.groups[group]);
        groups.any(|group| group.effect.family == family && group.joint == Some(joint))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::candidates::Library;
    use crate::effect::registry;
    use crate::model::design::Design;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::Recording;
    use crate::recording::split::Split;
    use crate::simulation::{Scenario, simulate};

    /// A search for these effects that has come to its end.
    fn searched<'a>(recording: &'a Recording, effects: &[&str]) -> Search<'a> {
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
    fn found(search: &Search) -> Vec<(&'static str, Option<usize>)> {
        let groups = search.active.iter().map(|&group| &search.library.groups[group]);
        groups.map(|group| (group.effect.id, group.joint)).collect()
    }

    /// Friction of joint 3 grows with the root of the speed. As far as the difference counts it is that, else what common friction says
    /// of it, with the dry friction that the two other joints have.
    #[test]
    fn odd_friction_is_common_friction_where_the_difference_says_little() {
        let mut scenario = Scenario::embedded();
        let hidden =
            |scenario: &Scenario, id: &str, joints: &[usize]| scenario.hide_by_strength(id, joints, 0.1).unwrap();
        scenario.effects =
            [hidden(&scenario, "coulomb-friction", &[0, 1]), hidden(&scenario, "concave-friction", &[2])].concat();
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let effects = ["coulomb-friction", "viscous-friction", "concave-friction"];
        let mut search = searched(&recording, &effects);
        let before = found(&search);
        assert!(before.contains(&("concave-friction", Some(2))), "{before:?}");
        assert!(!search.prefer_common(|_| 1.0).unwrap());
        assert_eq!(found(&search), before);
        assert!(search.prefer_common(|_| 0.0).unwrap());
        let mut after = found(&search);
        after.sort_unstable();
        let dry = (0..3).map(|joint| ("coulomb-friction", Some(joint)));
        assert_eq!(after, dry.chain([("viscous-friction", Some(2))]).collect::<Vec<_>>());
        let mut without = searched(&recording, &["coulomb-friction", "concave-friction"]);
        assert!(found(&without).contains(&("concave-friction", Some(2))));
        assert!(!without.prefer_common(|_| 0.0).unwrap(), "nothing else says what it says");
    }

    /// The candidate of an effect on a joint.
    fn group(search: &Search, id: &str, joint: usize) -> usize {
        let mut groups = search.library.groups.iter();
        groups.position(|group| group.effect.id == id && group.joint == Some(joint)).unwrap()
    }

    /// Joint 1 rubs more near standstill, in each fourth run or in all of them. The former has evidence, but the other runs don't confirm
    /// it.
    #[test]
    fn an_odd_form_stays_only_where_other_blocks_confirm_it() {
        let found_with = |rubs: fn(usize) -> bool| {
            let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
            for (_, run) in recording.trajectories.iter_mut().enumerate().filter(|(run, _)| rubs(*run)) {
                let qd = run.qd[0].to_vec();
                let more = |qd: f64| 1.5 * qd.signum() * (-(qd / 0.2).powi(2)).exp();
                run.channels_mut().tau[0].iter_mut().zip(qd).for_each(|(tau, qd)| *tau += more(qd));
            }
            let mut search = searched(&recording, &["coulomb-friction", "stribeck-friction"]);
            let odd = vec![group(&search, "stribeck-friction", 0), group(&search, "coulomb-friction", 1)];
            let common = vec![group(&search, "coulomb-friction", 0), odd[1]];
            assert!(search.priced_cost(&odd) < search.priced_cost(&common), "it has the evidence");
            search.active = odd;
            search.prefer_common(|_| 1.0).unwrap();
            found(&search)
        };
        assert!(found_with(|_| true).contains(&("stribeck-friction", Some(0))));
        let now = found_with(|run| run % 4 == 1);
        assert!(
            now.contains(&("coulomb-friction", Some(0))) && !now.iter().any(|(id, _)| *id == "stribeck-friction"),
            "{now:?}"
        );
    }

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
