//! What the clues of one search amount to: how likely each family is there, and how complete the answer is.

use super::calibration::{Calibration, has_law, remainder};
use super::{LIKELY, Rest, Sighting, sightings};
use crate::diagnosis::flexible;
use crate::diagnosis::report::{Completeness, Presence};
use crate::diagnosis::search::Search;
use crate::effect::Family;
use crate::model::ModelError;

/// Less than this presence is not worth a thought.
const WORTH_TELLING: f64 = 0.1;

/// Families with the probability that each is there, and what is left of each joint.
pub struct Judged {
    sightings: Vec<(Sighting, f64)>,
    completeness: Vec<Completeness>,
    /// What is left and doubtful on a joint, over what an answer may leave that is complete.
    excess: Vec<f64>,
}

impl Judged {
    /// Judges a search that has come to its end.
    ///
    /// # Errors
    /// [`ModelError`] if a column of the flexible basis can't be computed.
    pub fn of(search: &Search, map: &Calibration) -> Result<Judged, ModelError> {
        let rest = Rest::of(search, flexible::predicted(search)?);
        let seen = sightings(search, &rest).into_iter();
        let sightings: Vec<(Sighting, f64)> =
            seen.map(|one| (map.presence(&one), one)).map(|(p, one)| (one, p)).collect();
        let remainder = |joint: usize| {
            let doubtful = sightings.iter().filter(|(one, presence)| one.is_doubtful(*presence) && one.acts_on(joint));
            remainder(&rest, joint, doubtful.map(|(one, _)| one.unique))
        };
        let completeness = (0..rest.share.len())
            .map(|joint| {
                let remainder = remainder(joint);
                Completeness {
                    joint,
                    explained: (1.0 - (rest.share[joint] / rest.before[joint]).powi(2)).clamp(0.0, 1.0),
                    remainder,
                    complete: remainder <= map.remainder && !has_law(&rest, joint),
                }
            })
            .collect::<Vec<_>>();
        let excess = completeness.iter().map(|one| one.remainder / map.remainder).collect();
        Ok(Judged { sightings, completeness, excess })
    }

    /// How likely something of a family is at a place.
    pub fn presence(&self, family: Family, joint: Option<usize>) -> f64 {
        let is_it = |(one, _): &&(Sighting, f64)| one.family == family && one.joint == joint;
        self.sightings.iter().find(is_it).map_or(0.0, |(_, presence)| *presence)
    }

    /// Whether a group of the search belongs to a family that is likely enough to be named.
    pub fn is_likely(&self, search: &Search, group: usize) -> bool {
        let group = &search.library.groups[group];
        self.presence(group.effect.family, group.joint) >= LIKELY
    }

    /// How much a difference of evidence between two forms says at a place: less where more is left than noise, since it may
    /// be that which tells them apart.
    pub fn certainty(&self, joint: Option<usize>) -> f64 {
        let worst = joint.map_or_else(|| self.excess.iter().copied().fold(0.0, f64::max), |joint| self.excess[joint]);
        1.0 / worst.max(1.0).powi(2)
    }

    /// The families that are worth a thought, the likeliest first.
    pub fn told(&self) -> Vec<Presence> {
        let worth = self.sightings.iter().filter(|(_, presence)| *presence >= WORTH_TELLING);
        let mut told: Vec<Presence> = worth
            .map(|(one, probability)| Presence {
                group: one.family.group(),
                family: one.family,
                joint: one.joint,
                probability: *probability,
                effect: one.effect,
                share: one.share,
            })
            .collect();
        told.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.joint.cmp(&b.joint)));
        told
    }

    /// How complete the answer is, by joint.
    pub fn completeness(&self) -> &[Completeness] {
        &self.completeness
    }

    /// The joints (from 0) whose answer is not complete.
    pub fn incomplete(&self) -> Vec<usize> {
        self.completeness.iter().filter(|one| !one.complete).map(|one| one.joint).collect()
    }
}
