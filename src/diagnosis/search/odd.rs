//! Odd forms of friction, and whether common ones do as well: then these take their place or stand beside them.
//!
//! On one joint an odd form may pass for dry friction and for friction that grows with the speed at once, and an exponent or a width of
//! its own takes what the other one leaves. The common forms are the likelier before the data speak, the more so the more of the other
//! joints have them.

use super::Search;
use super::gates;
use crate::effect::Effect;
use crate::model::ModelError;

/// Odds of a form that not nearly every joint has, before the data speak.
const RARE: f64 = 0.2;

/// Odds of a form beside the common one of its family, before the data speak.
pub fn odds_of_form(effect: &Effect) -> f64 {
    if effect.facts.everyday { 1.0 } else { RARE }
}

/// Another set than what was found.
struct Otherwise {
    set: Vec<usize>,
    /// Odds for it before the data speak.
    odds: f64,
    /// Whether the odd forms stay in it.
    keeps_odd: bool,
}

impl Search<'_> {
    /// Puts common friction in the place of odd forms of it, or beside them, where that is likelier, and where blocks that were left out
    /// don't confirm that the odd ones are better; whether any changed.
    ///
    /// A difference of evidence says as much of two forms as `certainty` on their joint, at most 1: where more is left than noise, it may
    /// be that which tells them apart.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn prefer_common(&mut self, certainty: impl Fn(usize) -> f64) -> Result<bool, ModelError> {
        self.take_otherwise(certainty, |search, other, (joint, evidence)| {
            !gates::is_confirmed_as_odd(search, &other.set, &search.active, joint, evidence)
        })
    }

    /// The same after something has left the set without which blocks confirm little: they decide only where most of the other joints have
    /// that common friction, too.
    ///
    /// # Errors
    /// As [`Search::prefer_common`].
    pub fn prefer_likelier(&mut self, certainty: impl Fn(usize) -> f64) -> Result<bool, ModelError> {
        self.take_otherwise(certainty, |search, other, (joint, evidence)| {
            let mut new = other.set.iter().filter(|group| !search.active.contains(group));
            new.all(|&group| search.is_usual(group))
                && !gates::is_confirmed_as_odd(search, &other.set, &search.active, joint, evidence)
        })
    }

    /// Takes of each joint the likeliest of the other sets that are likelier than what was found or, if no odd form stays, `as_good` on
    /// that joint with this evidence against it.
    fn take_otherwise(
        &mut self,
        certainty: impl Fn(usize) -> f64,
        as_good: impl Fn(&Self, &Otherwise, (usize, f64)) -> bool,
    ) -> Result<bool, ModelError> {
        let before = self.active.clone();
        for joint in 0..self.weights.len() {
            let now = self.priced_cost(&self.active);
            let worse =
                |other: &Otherwise| certainty(joint) * (self.priced_cost(&other.set) - now) - 2.0 * other.odds.ln();
            let is_preferred = |(worse, other): &(f64, Otherwise)| {
                let is_likelier = *worse < 0.0;
                if other.keeps_odd {
                    is_likelier && gates::is_confirmed_as_everyday(self, &self.active, &other.set)
                } else {
                    is_likelier || as_good(self, other, (joint, *worse))
                }
            };
            let others = self.otherwise_on(joint).into_iter().map(|other| (worse(&other), other));
            let best = others.filter(is_preferred).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, Otherwise { set, .. })) = best {
                self.active = set;
            }
        }
        let changed = self.active != before;
        if changed {
            self.refine_found()?;
        }
        Ok(changed)
    }

    /// The sets with common friction on a joint that has odd forms of it: in the place of them all, with and without that of a family
    /// that the joint does not show, and such friction beside them, where each odd form may have another shape. Those with impossible
    /// parameters are left out.
    fn otherwise_on(&self, joint: usize) -> Vec<Otherwise> {
        let groups = &self.library.groups;
        let families = self.common_families();
        let is_odd = |group: &usize| {
            let group = &groups[*group];
            group.joint == Some(joint) && families.contains(&group.effect.family) && !group.effect.is_common()
        };
        let (odd, rest): (Vec<usize>, Vec<usize>) = self.active.iter().copied().partition(is_odd);
        if odd.is_empty() {
            return Vec::new();
        }
        let is_open = |group: &usize| !rest.contains(group) && !self.absorbed.contains(group);
        let common: Vec<usize> = self.common().filter(|&group| groups[group].joint == Some(joint)).collect();
        let (shown, new): (Vec<usize>, Vec<usize>) =
            common.iter().copied().filter(is_open).partition(|&group| self.shows(groups[group].effect.family, joint));
        let odds_of = |new: usize| self.odds_of(groups[new].effect.family, Some(joint));
        let odds_of_odd: f64 = odd.iter().map(|&group| self.odds_of_odd(groups[group].effect, joint)).product();
        let mut sets: Vec<Otherwise> = Vec::new();
        let has_common = |&odd: &usize| {
            let mut there = rest.iter().chain(&shown).filter(|&group| common.contains(group));
            there.any(|&group| groups[group].effect.family == groups[odd].effect.family)
        };
        if odd.iter().all(has_common) {
            let mut choices = vec![&[][..], &new];
            choices.dedup();
            for more in choices {
                let odds = more.iter().map(|&new| odds_of(new)).product::<f64>() / odds_of_odd;
                sets.push(Otherwise { set: [&rest[..], &shown, more].concat(), odds, keeps_odd: false });
            }
        }
        for (&new, &old) in new.iter().flat_map(|new| odd.iter().map(move |old| (new, old))) {
            let is_shape = |&group: &usize| groups[group].same_place_and_effect(&groups[old]);
            for shape in (0..groups.len()).filter(is_shape) {
                let stays = self.active.iter().copied().filter(|&group| group != old);
                sets.push(Otherwise { set: stays.chain([new, shape]).collect(), odds: odds_of(new), keeps_odd: true });
            }
        }
        sets.retain(|other| gates::are_new_ones_physical(self, &other.set));
        sets
    }

    /// Odds of an odd form of friction on a joint, before the data speak: the less the more of the other joints have the common form.
    fn odds_of_odd(&self, effect: &Effect, joint: usize) -> f64 {
        let groups = self.active.iter().map(|&group| &self.library.groups[group]);
        let common = groups.filter(|group| {
            group.joint != Some(joint) && group.effect.family == effect.family && group.effect.is_common()
        });
        odds_of_form(effect) / (common.count() as f64 + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{found, group, searched};
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

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

    /// Joint 1 has dry friction and one that grows with the speed to the 0.6, or the latter alone. A smaller exponent stands for both, so
    /// that nothing is left for the other kind; beside that one there is.
    #[test]
    fn an_odd_form_leaves_room_for_the_other_kind_of_friction() {
        let found_with = |dry: bool, start: f64| {
            let hidden = |scenario: &Scenario, id: &str| scenario.hide_by_strength(id, &[0], 0.2).unwrap();
            let mut scenario = Scenario { torque_noise: 1e-3, ..Scenario::embedded() };
            scenario.effects = hidden(&scenario, "concave-friction");
            scenario.effects[0].parameters[1] = 0.6;
            if dry {
                scenario.effects.extend(hidden(&scenario, "coulomb-friction"));
            }
            let recording = simulate(&scenario, &Monitor::new()).unwrap();
            let mut search = searched(&recording, &["coulomb-friction", "viscous-friction", "concave-friction"]);
            let groups = &search.library.groups;
            let first = &groups[group(&search, "concave-friction", 0)];
            let starts = (0..groups.len()).filter(|&group| groups[group].same_place_and_effect(first));
            let above = starts.filter(|&group| groups[group].shape[0] >= start);
            // The search may have refined one of them.
            search.active =
                above.min_by(|&a, &b| groups[a].shape[0].total_cmp(&groups[b].shape[0])).into_iter().collect();
            search.refine_found().unwrap();
            let alone = search.library.groups[search.active[0]].shape[0];
            search.prefer_common(|_| 1.0).unwrap();
            let odd = search.active.iter().find(|&&group| !search.library.groups[group].shape.is_empty()).unwrap();
            let exponent = search.library.groups[*odd].shape[0];
            let mut found = found(&search);
            found.sort_unstable();
            (found, alone, exponent)
        };
        let concave = ("concave-friction", Some(0));
        let (found, alone, exponent) = found_with(true, 0.2);
        assert_eq!(found, [concave, ("coulomb-friction", Some(0))], "{alone} {exponent}");
        assert!(alone < 0.5 && (0.55..0.65).contains(&exponent), "{alone} {exponent}");
        let (found, alone, exponent) = found_with(false, 0.5);
        assert_eq!((found, alone), (vec![concave], exponent));
        assert!((0.55..0.65).contains(&exponent), "{exponent}");
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
}
