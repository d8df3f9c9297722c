//! What the clues of one search amount to: how likely each family is there, and how complete the answer is.

use super::calibration::Calibration;
use super::{Rest, Sighting, WORTH_ASKING, look};
use crate::diagnosis::heard::{BEYOND_DOUBT, Heard};
use crate::diagnosis::report::{Completeness, Presence};
use crate::diagnosis::search::Search;
use crate::effect::Family;
use crate::model::ModelError;

/// Less than this presence is not worth a thought.
const WORTH_TELLING: f64 = 0.1;

/// Noise that is computed may be so many times as large: of 804 joints of the worlds 2001 and 500000 on which nothing unknown acts half leave
/// 1.02 times what is computed, three quarters no more than 1.14 times.
const SURELY_NOISE: f64 = 1.25;
/// An answer is complete that leaves no more of a joint's torque (RMS) beyond noise than this share of it, which is hardly anything, …
const HARDLY_ANYTHING: f64 = 0.004;
/// … and this share of what was missing, since no formula fits exactly. Of what is missing formulas leave 1 to 9 % in worlds in which nothing
/// is unknown, and mostly more than 20 % where something is …
const OF_WHAT_WAS_MISSING: f64 = 0.08;
/// … but for so much of the torque, whatever was missing. Of those 288 worlds (RESULTS.md, "What is noise is computed") these four call 10 of
/// 240 incomplete in which nothing is unknown, and 46 of 48 in which something is; 10 and 40 were what looks at the colour of the rest alone.
const MUCH: f64 = 0.04;

/// Families with the probability that each is there, and what is left of each joint.
pub struct Judged {
    sightings: Vec<(Sighting, f64)>,
    /// What the held-out part says of some of them.
    heard: Vec<Heard>,
    rest: Rest,
    completeness: Vec<Completeness>,
    /// How much of each joint's torque rests on what carries evidence and is not likely, as a share (RMS).
    doubtful: Vec<f64>,
    /// The remainder that an answer may leave which is complete.
    allowed: f64,
}

impl Judged {
    /// Judges a search that has come to its end.
    ///
    /// # Errors
    /// [`ModelError`] if a column of the flexible basis can't be computed.
    pub fn of(search: &Search, map: &Calibration) -> Result<Judged, ModelError> {
        let (seen, rest) = look(search)?;
        let sightings: Vec<(Sighting, f64)> = seen.into_iter().map(|one| (one.clone(), map.presence(&one))).collect();
        let (completeness, doubtful) = completeness(&sightings, &rest, map);
        Ok(Judged { sightings, heard: Vec::new(), rest, completeness, doubtful, allowed: map.remainder })
    }

    /// With shares of the torque as it was measured, where what was judged was whitened: those that a `plain` search sees which has the same
    /// set.
    ///
    /// # Errors
    /// As [`Judged::of`].
    pub fn of_measured(self, plain: &Search) -> Result<Judged, ModelError> {
        let (seen, _) = look(plain)?;
        Ok(self.with_shares_of(&seen))
    }

    /// With how complete the answer is beside the torque as it was measured, and its shares.
    ///
    /// # Errors
    /// As [`Judged::of`].
    pub fn complete_beside(self, plain: &Search, map: &Calibration) -> Result<Judged, ModelError> {
        let (seen, rest) = look(plain)?;
        let judged = self.with_shares_of(&seen);
        let (completeness, doubtful) = completeness(&judged.sightings, &rest, map);
        Ok(Judged { rest, completeness, doubtful, ..judged })
    }

    fn with_shares_of(mut self, seen: &[Sighting]) -> Judged {
        for (one, _) in &mut self.sightings {
            if let Some(plain) = seen.iter().find(|plain| (plain.family, plain.joint) == (one.family, one.joint)) {
                (one.share, one.unique) = (plain.share, plain.unique);
            }
        }
        self
    }

    /// With the probabilities that a `later` judgement has beside what stays, once the `doubtful` have left: theirs are those at which they
    /// left. How complete the answer is remains: they may be there.
    pub fn but_for(self, later: Judged, search: &Search, doubtful: &[(usize, f64)]) -> Judged {
        let mut sightings = later.sightings;
        let groups = &search.library.groups;
        for &(gone, at) in doubtful {
            let is_it = |family: Family, joint: Option<usize>| {
                groups[gone].effect.family == family && groups[gone].joint == joint
            };
            let stays = search.active.iter().any(|&group| is_it(groups[group].effect.family, groups[group].joint));
            let own = sightings.iter_mut().find(|(one, _)| is_it(one.family, one.joint));
            let before = self.sightings.iter().find(|(one, _)| is_it(one.family, one.joint));
            if let (false, Some(own), Some(before)) = (stays, own, before) {
                *own = (before.0.clone(), at);
            }
        }
        Judged { sightings, ..self }
    }

    /// The families of which nobody can say yet whether they are there, each at its place.
    pub fn in_question(&self) -> impl Iterator<Item = (Family, Option<usize>)> {
        let asked = self.sightings.iter().filter(|(_, presence)| (WORTH_ASKING..BEYOND_DOUBT).contains(presence));
        asked.map(|(one, _)| (one.family, one.joint))
    }

    /// How likely something of a family is at a place.
    pub fn presence(&self, family: Family, joint: Option<usize>) -> f64 {
        let is_it = |(one, _): &&(Sighting, f64)| one.family == family && one.joint == joint;
        self.sightings.iter().find(is_it).map_or(0.0, |(_, presence)| *presence)
    }

    /// How likely something of the family of a group of the search is at its place.
    pub fn presence_of(&self, search: &Search, group: usize) -> f64 {
        let group = &search.library.groups[group];
        self.presence(group.effect.family, group.joint)
    }

    /// How much a difference of evidence between two forms says at a place: less where more is left than noise, since it may
    /// be that which tells them apart.
    pub fn certainty(&self, joint: Option<usize>) -> f64 {
        let felt = self.completeness.iter().filter(|one| joint.is_none_or(|joint| one.joint == joint));
        let worst = felt.map(|one| one.remainder).fold(0.0, f64::max);
        1.0 / (worst / self.allowed).max(1.0).powi(2)
    }

    /// With what the held-out part says of some of them.
    pub fn with(self, heard: Vec<Heard>) -> Judged {
        Judged { heard, ..self }
    }

    /// Without the families of which nothing is left at their places once all that is named is fitted together.
    pub fn without(mut self, is_gone: impl Fn(Family, Option<usize>) -> bool) -> Judged {
        self.sightings.retain(|(one, _)| !is_gone(one.family, one.joint));
        self
    }

    /// How complete the answer is, by joint, with what noise of the readings makes of the torque that is left, as a share (RMS). Where that is
    /// known, what is left beyond it counts, whatever its colour.
    pub fn beside(&self, noise: Vec<Option<f64>>) -> Vec<Completeness> {
        let (rest, mut completeness) = (&self.rest, self.completeness.clone());
        for (joint, (one, noise)) in completeness.iter_mut().zip(noise).enumerate() {
            one.noise = noise;
            let Some(noise) = noise else { continue };
            let beyond = rest.share[joint].powi(2) - (SURELY_NOISE * noise).powi(2);
            one.remainder = beyond.max(0.0).sqrt().hypot(self.doubtful[joint]);
            let allowed = (HARDLY_ANYTHING + OF_WHAT_WAS_MISSING * rest.before[joint]).min(MUCH);
            one.complete = one.remainder <= allowed && !rest.has_law(joint);
        }
        completeness
    }

    /// The families that are worth a thought, the likeliest first.
    pub fn told(&self) -> Vec<Presence> {
        let presence = |(one, before): &(Sighting, f64)| {
            let heard = Heard::find(&self.heard, one.family, one.joint);
            Presence {
                group: one.family.group(),
                family: one.family,
                joint: one.joint,
                probability: heard.map_or(*before, |heard| heard.presence),
                effect: one.effect,
                share: one.share,
                held_out: heard.map(|heard| heard.held_out),
            }
        };
        let told = self.sightings.iter().map(presence);
        let mut told: Vec<Presence> = told.filter(|one| one.probability >= WORTH_TELLING).collect();
        told.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.joint.cmp(&b.joint)));
        told
    }

    /// What was seen, and what is left beside all that was found.
    pub fn seen(self) -> (Vec<Sighting>, Rest) {
        (self.sightings.into_iter().map(|(one, _)| one).collect(), self.rest)
    }

    /// How complete the answer is, by joint.
    #[cfg(test)]
    pub fn completeness(&self) -> &[Completeness] {
        &self.completeness
    }
}

/// How complete an answer is by joint, and how much of each joint's torque rests on what carries evidence and is not likely.
fn completeness(sightings: &[(Sighting, f64)], rest: &Rest, map: &Calibration) -> (Vec<Completeness>, Vec<f64>) {
    let seen = || sightings.iter().map(|(one, _)| one);
    let of_joint = |joint: usize| {
        let remainder = map.remainder_on(rest, seen(), joint);
        Completeness {
            joint,
            left: Some(rest.share[joint]),
            noise: None,
            explained: (1.0 - (rest.share[joint] / rest.before[joint]).powi(2)).clamp(0.0, 1.0),
            remainder,
            held_out: None,
            complete: map.is_complete(rest, remainder, joint),
        }
    };
    let joints = 0..rest.share.len();
    (joints.clone().map(of_joint).collect(), joints.map(|joint| map.doubtful_on(seen(), joint)).collect())
}

#[cfg(test)]
impl Judged {
    /// With another probability of a family at a place.
    pub fn believing(mut self, family: Family, joint: Option<usize>, presence: f64) -> Judged {
        let own = self.sightings.iter_mut().find(|(one, _)| one.family == family && one.joint == joint);
        own.expect("it was looked at").1 = presence;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::search::testing::searched;
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    #[test]
    fn what_is_left_beyond_noise_is_held_against_what_was_missing() {
        /// What was missing of a joint, what is left, what is predicted of that, what noise makes of it, and what is doubtful.
        struct Left(f64, f64, f64, f64, f64);
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let mut judged = Judged::of(&searched(&recording, &["coulomb-friction"]), Calibration::learned()).unwrap();
        let joints = [
            (Left(0.5, 0.02, 0.0, 0.015, 0.0), true, 0.00696),
            (Left(0.02, 0.02, 0.0, 0.01, 0.0), false, 0.0156),
            (Left(0.9, 0.06, 0.0, 0.02, 0.0), false, 0.0545),
            (Left(0.9, 0.06, 0.0, 0.049, 0.0), true, 0.0),
            (Left(0.5, 0.02, 0.9, 0.015, 0.0), false, 0.00696),
            (Left(0.5, 0.02, 0.0, 0.015, 0.05), false, 0.05048),
        ];
        let each = |of: fn(&Left) -> f64| -> Vec<f64> { joints.iter().map(|(left, ..)| of(left)).collect() };
        let whiteness = vec![1.0; joints.len()];
        judged.rest =
            Rest { before: each(|one| one.0), share: each(|one| one.1), predicted: each(|one| one.2), whiteness };
        judged.doubtful = each(|one| one.4);
        judged.completeness = vec![Completeness::example(); joints.len()];
        let told = judged.beside(joints.iter().map(|(left, ..)| Some(left.3)).collect());
        for (joint, (one, (left, complete, remainder))) in told.iter().zip(&joints).enumerate() {
            assert_eq!((one.noise, one.complete), (Some(left.3), *complete), "joint {}", joint + 1);
            assert!((one.remainder - remainder).abs() < 1e-4, "joint {}: {}", joint + 1, one.remainder);
        }
    }

    #[test]
    fn where_readings_do_not_tell_their_noise_the_answer_stays() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let judged = Judged::of(&searched(&recording, &["coulomb-friction"]), Calibration::learned()).unwrap();
        assert_eq!(judged.beside(vec![None; judged.completeness().len()]), judged.completeness());
    }

    /// Joints 1 and 2 have dry friction; that of joint 1 has left.
    #[test]
    fn what_has_left_is_not_told() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let search = searched(&recording, &["coulomb-friction"]);
        let told = |judged: &Judged| judged.told().iter().map(|one| one.joint).collect::<Vec<_>>();
        let judged = Judged::of(&search, Calibration::learned()).unwrap();
        assert_eq!(told(&judged), [Some(0), Some(1)]);
        let judged = judged.without(|family, joint| (family, joint) == (Family::DryFriction, Some(0)));
        assert_eq!(told(&judged), [Some(1)]);
    }
}
