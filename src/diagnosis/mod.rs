//! Which physical effect is missing: from a model and measurements, name it with evidence, and never cry wolf.
//!
//! A recording goes through once, of a very long one an `excerpt`. `candidates` lays every effect beside the model, as columns of one design. `search` finds
//! the set that explains the torque for the least price (once more among whitened data where more than noise is left), [`presence`] says how likely each family is there and how complete
//! the answer is, `stated_arm` what the base parameters absorb. `naming` says in which form it is there and what else it could
//! be, `telling` which motion would tell. `steps` adds what was named; `held_out` data are asked about what is in doubt, and `heard` is how likely it is with that (`withdrawn` keeps what leaves and why); `noise` is what readings make of what is left, `bursts` are stretches that stand out from it; `conclusion` draws the answer, a [`Report`]: data,
//! which `words` says in words.
//! [`setup`] asks before all that whether the log is set up right. [`evidence`] holds its plots. [`proposal`] asks on what the
//! remainder depends that no effect explains, and by which formula. [`sufficiency`] asks, once the truth is known, whether the
//! data could show it.
//!
//! A diagnosis sees measurements only. It never opens a seal; a test keeps it so.

mod bursts;
mod candidates;
mod conclusion;
pub mod evidence;
mod excerpt;
mod flexible;
mod heard;
mod held_out;
mod in_band;
mod naming;
mod noise;
pub mod presence;
pub mod proposal;
mod ranking;
mod report;
mod search;
pub mod setup;
mod stated_arm;
mod steps;
mod sufficiency;
mod telling;
mod withdrawn;
mod words;

use bursts::Burst;
use candidates::Library;
use excerpt::Excerpt;
use in_band::InBand;
use presence::Judged;
use presence::calibration::Calibration;
use search::Search;
use stated_arm::{Comparison, StatedBody};
use steps::{Base, Steps};

pub use heard::weights as held_out_weights;
pub use presence::{Rest, Sighting};
pub use report::{
    Alternative, Candidate, Completeness, Evidence, Exciting, Ground, HeldOut, MissingEffect, NotKnown, Note, Presence,
    Refusal, Report, TellingMotion, Verdict,
};
pub use sufficiency::{Suspect, sufficiency};

use crate::effect::{Effect, registry};
use crate::model::design::Design;
use crate::model::learned::LearnedTerm;
use crate::model::{EffectTerm, Evaluation, Fitted, Model, ModelError, RigidBody, Term, fit};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;

/// Looks for what `fitted` lacks on the training part, and measures on the held-out part what adding it gains.
///
/// # Errors
/// [`ModelError`] if the model does not fit the recording, or the work was stopped.
pub fn diagnose(
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Report, ModelError> {
    diagnose_among(&registry::sought(), fitted, recording, split, monitor)
}

/// [`diagnose`] with other candidates than the whole catalogue: with effects of one's own, or without the right one, to measure
/// what happens then.
///
/// ```
/// use torquescope::diagnosis::diagnose_among;
/// use torquescope::{effect::registry, model, prelude::*};
///
/// let monitor = Monitor::new();
/// let recording = simulate(&Scenario::embedded(), &monitor)?; // Coulomb friction is hidden in it
/// let split = Split::automatic(&recording);
/// let body = model::fit(&Preset::RigidBody.model(&recording)?, &recording, &split, &monitor)?;
/// let springs = [registry::find("joint-spring")?, registry::find("hardening-spring")?];
/// let report = diagnose_among(&springs, &body, &recording, &split, &monitor)?;
/// assert_ne!(report.verdict, Verdict::NothingMissing);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_among(
    effects: &[&'static Effect],
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Report, ModelError> {
    let given = Evaluation::of(fitted, recording, split)?;
    let held_out_nmse = given.held_out_nmse();
    let excerpt = Excerpt::of(recording, split);
    let searched = Searched::new(effects, fitted, &excerpt, monitor)?;
    let Searched { mut search, mut plain, design, counterpart, refused, drops, mut not_known } = searched;
    let (fitted, before) = match &counterpart {
        Some(counterpart) => (counterpart, Evaluation::of(counterpart, recording, split)?),
        None => (fitted, given),
    };
    let blocks = search.library.equations.block_count();
    let (judged, doubtful) = judge(&mut search, plain.as_mut())?;
    let stated = StatedBody::of(&search, &fitted.model);
    let comparison = stated_arm::compare(&search, stated.as_ref());
    // Without a held-out part nobody can be asked about what the search has not found.
    let beside = if split.held_out.is_empty() { Vec::new() } else { naming::in_question_beside(&search, &judged) };
    let named = naming::name_effects(&mut search, &beside, &comparison, stated.as_ref(), &judged);
    monitor.report(0.8, "adding what was found, step by step")?;
    let in_band = InBand::of(recording, split, &design);
    let base = Base {
        fitted,
        evaluation: &before,
        stated: stated.as_ref(),
        recording,
        split,
        in_band: &in_band,
        design: &design,
        monitor,
    };
    let left = |fitted: &Fitted, last: &Evaluation| -> Result<Left, ModelError> {
        let in_training = judged.beside(noise::of_readings(fitted, &excerpt.recording, &design)?);
        let bursts = bursts::find(last, &in_band, recording);
        Ok(Left { completeness: conclusion::carried_over(&in_training, last, &bursts), in_training, bursts })
    };
    let is_complete =
        |fitted: &Fitted, last: &Evaluation| Ok(left(fitted, last)?.completeness.iter().all(|one| one.complete));
    let Steps { mut effects, last, fitted: last_fitted, rivals_of, withdrawn, heard } =
        steps::measure(named, &judged, is_complete, &base)?;
    telling::tell_apart(&mut effects, rivals_of, &search, &last_fitted, monitor)?;
    effects.extend(steps::faults_of_readings(recording, &last));
    let supported = ranking::supported(&search, &beside, &heard);
    let Left { in_training, completeness, bursts } = left(&last_fitted, &last)?;
    let judged = judged.with(heard).without(|family, joint| withdrawn::is_gone(family, joint, &withdrawn, &effects));
    let presence = judged.told();
    let unexplained_joints = incomplete(&completeness);
    let verdict = conclusion::verdict(&effects, &unexplained_joints, &comparison);
    not_known.extend(ranking::unseen(&search, comparison == Comparison::NotPossible && !last_fitted.model.is_pinned()));
    let hiding = recording.torque.iter().filter(|fact| fact.hides().is_some());
    not_known.splice(0..0, hiding.map(|fact| NotKnown::NotInTorque { fact }));
    let mut notes =
        conclusion::notes(verdict, &effects, &incomplete(&in_training), &comparison, blocks, recording.encoders);
    // Before anything is added: what is missing may be found once models learn from it.
    notes.splice(0..0, conclusion::fails_on_held_out(&last));
    notes.extend(conclusion::in_bursts(&bursts, recording, split));
    let of_torque = last.noise_floor_nmse.as_deref();
    notes.extend(of_torque.and_then(|noise| conclusion::noise_of_motion(&completeness, noise)));
    notes.extend(design.follows_up_to().map(|above_hz| Note::NotFollowed { above_hz }));
    if excerpt.share < 1.0 {
        notes.push(Note::Excerpt { share: excerpt.share });
    }
    let ranking = ranking::rank(&search, &drops, &refused, &doubtful, &supported, &withdrawn, &comparison);
    monitor.report(1.0, "diagnosed")?;
    Ok(Report {
        verdict,
        effects,
        presence,
        completeness,
        held_out_nmse,
        noise_floor_nmse: last.noise_floor_nmse,
        unexplained_joints,
        notes,
        not_known,
        ranking,
    })
}

/// What an answer leaves.
struct Left {
    /// How complete it is, by joint, in training.
    in_training: Vec<Completeness>,
    /// The same held against what was held out.
    completeness: Vec<Completeness>,
    /// Stretches that stand out.
    bursts: Vec<Burst>,
}

/// The joints (from 0) whose answer is not complete.
fn incomplete(completeness: &[Completeness]) -> Vec<usize> {
    completeness.iter().filter(|one| !one.complete).map(|one| one.joint).collect()
}

/// Judges what was found, with common friction where odd forms of it are no likelier, and leaves in the set what is likely; the rest comes
/// back, each with its presence.
///
/// Beside a whitened search a `plain` one tells how much is left of the torque as it was measured.
fn judge(search: &mut Search, mut plain: Option<&mut Search>) -> Result<(Judged, Vec<(usize, f64)>), ModelError> {
    let mut judged = Judged::of(search, Calibration::learned())?;
    if search.prefer_common(|joint| judged.certainty(Some(joint)))? {
        judged = Judged::of(search, Calibration::learned())?;
    }
    judged = beside_measured(judged, search, plain.as_deref_mut())?;
    let (mut judged, mut doubtful) = without_doubtful(search, judged)?;
    // What is in doubt may have spoken for an odd form.
    if !doubtful.is_empty() && search.prefer_likelier(|joint| judged.certainty(Some(joint)))? {
        // Common friction that was in doubt may be back by itself.
        let back: Vec<usize> =
            doubtful.iter().map(|(group, _)| *group).filter(|group| !search.active.contains(group)).collect();
        search.active.extend(back);
        let anew = Judged::of(search, Calibration::learned())?;
        let anew = beside_measured(anew, search, plain.as_deref_mut())?;
        (judged, doubtful) = without_doubtful(search, anew)?;
    }
    if let Some(plain) = plain {
        plain.adopt(search)?;
        judged = judged.of_measured(plain)?;
    }
    Ok((judged, doubtful))
}

/// With how complete the answer is beside the torque as it was measured, if a `plain` search knows that.
fn beside_measured(judged: Judged, search: &Search, plain: Option<&mut Search>) -> Result<Judged, ModelError> {
    let Some(plain) = plain else { return Ok(judged) };
    plain.adopt(search)?;
    judged.complete_beside(plain, Calibration::learned())
}

/// Takes out of the set what is not likely to be there, one after the other and each time judged anew, since what is in doubt may speak
/// against what stays. How likely it was comes back.
///
/// What most of the other joints have as well is named as soon as it is likelier there than not: whoever models such an arm gives it to all
/// of them. It is judged last, and at once, for each says something of the others.
fn without_doubtful(search: &mut Search, mut judged: Judged) -> Result<(Judged, Vec<(usize, f64)>), ModelError> {
    let mut doubtful: Vec<(usize, f64)> = Vec::new();
    let presence = |search: &Search, judged: &Judged, usual: bool| -> Vec<(usize, f64)> {
        let groups = search.active.iter().filter(|&&group| search.is_usual(group) == usual);
        groups.map(|&group| (group, judged.presence_of(search, group))).collect()
    };
    let is_unlikely = |(_, presence): &(usize, f64)| *presence < presence::LIKELY;
    loop {
        let unlikely = presence(search, &judged, false).into_iter().filter(is_unlikely);
        let Some(least) = unlikely.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        search.active.retain(|&group| group != least.0);
        doubtful.push(least);
        judged = judged.but_for(Judged::of(search, Calibration::learned())?, search, &doubtful);
    }
    let usual = presence(search, &judged, true).into_iter();
    let unusual: Vec<(usize, f64)> = usual.filter(|(_, presence)| *presence < presence::EVEN).collect();
    search.active.retain(|group| unusual.iter().all(|(other, _)| group != other));
    doubtful.extend(unusual);
    Ok((judged, doubtful))
}

/// What the data say of every family of effects at every place, and what is left: the clues that [`presence::calibration`] learns
/// from.
///
/// # Errors
/// As [`diagnose`].
pub fn sightings(
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<(Vec<Sighting>, Rest), ModelError> {
    let excerpt = Excerpt::of(recording, split);
    let Searched { mut search, mut plain, .. } = Searched::new(&registry::sought(), fitted, &excerpt, monitor)?;
    let judged = Judged::of(&search, Calibration::learned())?;
    let judged = beside_measured(judged, &search, plain.as_mut())?;
    let (judged, _) = without_doubtful(&mut search, judged)?;
    Ok(judged.seen())
}

/// A search that has come to its end.
struct Searched<'a> {
    search: Search<'a>,
    /// That of the torque as it was measured, where `search` is among whitened data.
    plain: Option<Search<'a>>,
    /// The prepared data as they were before the search took columns at what it found.
    design: Design<'a>,
    /// What stands for a model with networks.
    counterpart: Option<Fitted>,
    refused: Vec<(usize, Refusal)>,
    /// What each candidate does alone, by group.
    drops: Vec<f64>,
    not_known: Vec<NotKnown>,
}

impl<'a> Searched<'a> {
    fn new(
        effects: &[&'static Effect],
        fitted: &Fitted,
        excerpt: &'a Excerpt,
        monitor: &Monitor,
    ) -> Result<Self, ModelError> {
        monitor.report(0.05, "filtering the torque")?;
        let design = Design::new(&excerpt.recording, &excerpt.split)?;
        let learned = fitted.model.is_learned();
        let counterpart =
            learned.then(|| fit::fit_design(&linear_counterpart(fitted), &design, monitor)).transpose()?;
        monitor.report(0.1, "computing candidate effects")?;
        let linear = counterpart.as_ref().unwrap_or(fitted);
        let (library, not_known) = Library::new(linear, design.clone(), effects, monitor)?;
        let mut search = Search::new(library);
        let drops = ranking::error_drops(&search, monitor)?;
        let mut refused = search.run(monitor)?;
        search.weigh_anew();
        let mut plain = None;
        let whitening = search.whitening();
        if whitening.is_any() {
            let monitor = monitor.part(0.75..0.8);
            let (library, _) = Library::new(linear, design.whitened(whitening)?, effects, &monitor)?;
            plain = Some(std::mem::replace(&mut search, Search::new(library)));
            refused = search.run(&monitor)?;
            search.weigh_anew();
        }
        Ok(Searched { search, plain, design, counterpart, refused, drops, not_known })
    }
}

/// The model in which a network's Lagrangian is a rigid body and its friction that of the catalogue.
///
/// A network hides an effect that it lacks in the weights of those it has; what it bends can't be linearised away. The rigid
/// body that it stands for is known, so that is what the effects are laid beside.
fn linear_counterpart(network: &Fitted) -> Model {
    let joints = network.setting().kinds.len();
    let mut terms = vec![Term::RigidBody(RigidBody::Identified)];
    for term in &network.model.terms {
        match term {
            Term::Learned(LearnedTerm::Friction) => {
                let mut friction: Vec<_> = registry::addable().filter(|effect| effect.facts.learned_friction).collect();
                friction.sort_by_key(|effect| effect.id);
                let placed = |effect| (0..joints).map(move |joint| EffectTerm { effect, joint: Some(joint) });
                terms.extend(friction.into_iter().flat_map(placed).map(Term::Effect));
            }
            Term::Effect(_) => terms.push(term.clone()),
            Term::Learned(_) | Term::RigidBody(_) | Term::Resistance(_) => {}
        }
    }
    Model { terms }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::model::{self, Preset};
    use crate::simulation::{Excitation, Scenario, simulate};

    /// The order of the registry is that of help and lists; it changes nothing that is said of a recording.
    #[test]
    fn the_order_of_the_candidates_changes_nothing() {
        let motion = Excitation::PaperPointToPoint { trajectories: 12, duration: 4.0, samples: 100, range: 2.0 };
        let recording = simulate(&Scenario { motion, ..Scenario::embedded() }, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let body =
            crate::model::fit(&Preset::RigidBody.model(&recording).unwrap(), &recording, &split, &Monitor::new());
        let report = |effects: &[&'static Effect]| {
            diagnose_among(effects, body.as_ref().unwrap(), &recording, &split, &Monitor::new()).unwrap()
        };
        let mut effects: Vec<&'static Effect> =
            registry::sought().into_iter().filter(|effect| effect.scope == crate::effect::Scope::Joint).collect();
        let told = report(&effects);
        effects.reverse();
        effects.rotate_left(7);
        assert_eq!(report(&effects), told);
        assert!(told.ranking.iter().any(Candidate::accepted));
    }

    /// A torque that nobody names pushes and pulls joint 1 as slowly as the arm moves, and a small wave lies along its way: beside the one
    /// the other shows once what is slow counts no more than it tells. How much is left is told of the torque as it was measured.
    #[test]
    fn a_wave_is_found_beside_what_moves_slowly() {
        let scenario = Scenario { effects: Vec::new(), torque_noise: 1e-3, ..Scenario::embedded() };
        let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for run in &mut recording.trajectories {
            let (q, mut run, mut slow) = (run.q[0].to_vec(), run.channels_mut(), 0.0);
            for (tau, q) in run.tau[0].iter_mut().zip(q) {
                slow += 0.02 * (random.random_range(-1.0..=1.0) - slow);
                *tau += 8.0 * slow + 0.3 * (9.0 * q).sin();
            }
        }
        let split = Split::automatic(&recording);
        let body = Preset::RigidBody.model(&recording).unwrap();
        let body = model::fit(&body, &recording, &split, &Monitor::new()).unwrap();
        let excerpt = Excerpt::of(&recording, &split);
        let effects = [registry::find("cogging").unwrap()];
        let Searched { mut search, mut plain, .. } = Searched::new(&effects, &body, &excerpt, &Monitor::new()).unwrap();
        let found = |search: &Search| search::testing::found(search);
        assert_eq!(found(plain.as_ref().unwrap()), []);
        assert_eq!(found(&search), [("cogging", Some(0))]);
        let before = Judged::of(&search, Calibration::learned()).unwrap().completeness()[0].left.unwrap();
        let (judged, _) = judge(&mut search, plain.as_mut()).unwrap();
        let left = judged.completeness()[0].left.unwrap();
        assert!(left < 0.5 * before, "{left} of {before}");
    }
}
