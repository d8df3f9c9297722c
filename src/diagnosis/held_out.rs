//! What the held-out part says of names that are in doubt.
//!
//! No parameter is learned from it. But it is evidence that nobody has looked at yet: left out of the model, what is there is missed there
//! too, and what fits the training part by chance is not. Both parts are asked as models are fitted: in their band, since above it an effect
//! that is there may well raise the error, such as that of an acceleration that follows a gap's crossing late; without the ends of runs, where
//! derived signals go astray; and where a joint moves, since what dry friction holds a joint that rests with nobody can tell, and it drowns
//! the rest.

use rayon::prelude::*;

use super::heard::{BEYOND_DOUBT, Heard};
use super::in_band::{InBand, Left};
use super::naming::Named;
use super::report::HeldOut;
use super::search::gates::BlockGains;
use crate::effect::{Effect, Family};
use crate::model::{Evaluation, ModelError};
use crate::recording::split::{Segment, Split};
use crate::signals::Signals;

/// Into about so many pieces the held-out part is cut, each for itself a witness.
const PIECES: usize = 20;

/// An effect that makes the error of the whole torque so many times as large where it is held out (squared) helps nobody, whatever it says in
/// the band of the fit: its formula multiplies the noise of the motion. Right ones do so up to 3.5 times (a backlash in recording 30 of the
/// forty); an elasticity of joint 1 of DFKI's pendulum does 400 times.
const HARMFUL: f64 = 10.0;

/// The squared error of a model, by part and joint \[(N m)²\].
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// In the band of the fit, where each joint moves.
    in_band: Sums,
    /// Of all that was measured.
    whole: Sums,
}

/// Sums of squares of each joint.
#[derive(Debug, Clone, PartialEq)]
struct Sums {
    train: Vec<f64>,
    /// By piece of the held-out part.
    held_out: Vec<Vec<f64>>,
}

impl Errors {
    /// Of a model that was held against a recording.
    pub fn of(evaluation: &Evaluation, recording: &InBand) -> Self {
        let Left { whole, in_band } = recording.left(evaluation);
        Errors { in_band: Sums::of(&in_band, recording.prepared()), whole: Sums::of(&whole, recording.split()) }
    }

    /// How much an effect that was so likely `before` is missed on the joints that feel it, if these are the errors without it.
    fn against(&self, with: &Errors, before: f64, felt: &[usize]) -> HeldOut {
        let errors =
            if self.are_harmed(with, felt) { [&self.whole, &with.whole] } else { [&self.in_band, &with.in_band] };
        errors[0].against(errors[1], before, felt)
    }

    /// Whether the effect multiplies the error of these joints, if these are the errors without it.
    fn are_harmed(&self, with: &Errors, felt: &[usize]) -> bool {
        self.whole.against(&with.whole, 1.0, felt).rises * HARMFUL < 1.0
    }
}

impl Sums {
    fn of(left: &[Signals], split: &Split) -> Self {
        let joints = 0..left.first().map_or(0, Signals::joint_count);
        let mut sums = Sums { train: vec![0.0; joints.len()], held_out: Vec::new() };
        let squared = |segment: &Segment, joint: usize| -> f64 {
            left[segment.trajectory][joint][segment.samples.clone()].iter().map(|left| left * left).sum()
        };
        for segment in &split.train {
            sums.train.iter_mut().enumerate().for_each(|(joint, sum)| *sum += squared(segment, joint));
        }
        let longest = split.held_out.iter().map(|segment| segment.samples.len()).sum::<usize>().div_ceil(PIECES).max(1);
        for segment in &split.held_out {
            let piece = |piece: &Segment| joints.clone().map(|joint| squared(piece, joint)).collect();
            sums.held_out.extend(segment.pieces(longest).iter().map(piece));
        }
        sums
    }

    /// Over the whole held-out part.
    fn held_out(&self, joint: usize) -> f64 {
        self.held_out.iter().map(|piece| piece[joint]).sum()
    }

    /// [`Errors::against`] in one of the two.
    fn against(&self, with: &Sums, before: f64, felt: &[usize]) -> HeldOut {
        let times = |of: fn(&Sums, usize) -> f64| -> f64 {
            let times = felt.iter().map(|&joint| of(self, joint) / of(with, joint));
            let mean = times.product::<f64>().powf(1.0 / felt.len() as f64);
            if mean > f64::MAX { f64::MAX } else { mean }
        };
        let of_pieces = |errors: &Sums| -> Vec<f64> {
            let share = |piece: &[f64], joint: usize| piece[joint] / with.held_out(joint).max(f64::MIN_POSITIVE);
            // Where none of the joints moves nobody can be asked.
            let asked = errors.held_out.iter().zip(&with.held_out);
            let asked = asked.filter(|(_, with)| felt.iter().any(|&joint| with[joint] > 0.0));
            asked.map(|(piece, _)| felt.iter().map(|&joint| share(piece, joint)).sum()).collect()
        };
        HeldOut {
            before,
            rises: times(Sums::held_out),
            rises_in_training: times(|errors, joint| errors.train[joint]),
            t: BlockGains::between(&of_pieces(self), &of_pieces(with)).t_of_shares(),
        }
    }
}

/// Asks the held-out part about all that is in doubt: each family at each place is left out of all that is `named`, and `errors` are those of
/// the rest, fitted anew. What a stated arm brings to light stands by that. What most of the other joints have can only gain: they say more
/// of it than a short part of the motion of one. Of what is beyond doubt, but for common friction, it is asked whether it multiplies the
/// error: evidence in training may be that of noise which the formula multiplies.
///
/// # Errors
/// [`ModelError`] if a model can't be fitted, or the work was stopped.
pub fn ask(
    named: &[Named],
    presence: impl Fn(Family, Option<usize>) -> f64 + Sync,
    errors: impl Fn(&[Named]) -> Result<Errors, ModelError> + Sync,
) -> Result<Vec<Heard>, ModelError> {
    let is_beyond_doubt = |family: Family, joint: Option<usize>| presence(family, joint) >= BEYOND_DOUBT;
    let places = |effect: &Named| {
        let (family, is_common) = (effect.effect.family, effect.effect.is_common_friction());
        let is_asked = move |joint: &Option<usize>| !is_common || !is_beyond_doubt(family, *joint);
        effect.places().into_iter().filter(is_asked).map(move |joint| (family, joint)).collect::<Vec<_>>()
    };
    let mut asked: Vec<(Family, Option<usize>)> = named.iter().filter(|effect| !effect.pins).flat_map(places).collect();
    asked.sort_unstable();
    asked.dedup();
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    let with = errors(named)?;
    let of_place = |(family, joint): (Family, Option<usize>)| {
        let (others, felt) = without(named, family, joint);
        let without = errors(&others)?;
        if is_beyond_doubt(family, joint) && !without.are_harmed(&with, &felt) {
            return Ok(None);
        }
        let held_out = without.against(&with, presence(family, joint), &felt);
        let heard = Heard::of((family, joint), held_out);
        Ok(if is_usual(named, family, joint) { heard.map(Heard::in_favour) } else { heard })
    };
    let heard: Result<Vec<Option<Heard>>, ModelError> = asked.into_par_iter().map(of_place).collect();
    Ok(heard?.into_iter().flatten().collect())
}

/// Whether most of the other joints have it.
fn is_usual(named: &[Named], family: Family, joint: Option<usize>) -> bool {
    let mut own = named.iter().filter(|effect| effect.effect.family == family);
    own.any(|effect| joint.is_some_and(|joint| effect.usual.contains(&joint)))
}

/// All but a family at a place, and the joints that felt it.
fn without(named: &[Named], family: Family, joint: Option<usize>) -> (Vec<Named>, Vec<usize>) {
    let mut others = named.to_vec();
    let mut felt: Vec<usize> = Vec::new();
    for effect in others.iter_mut().filter(|effect| effect.effect.family == family && !effect.pins) {
        let is_there = |at: &usize| effect.effect.places([*at]).contains(&joint);
        let (here, elsewhere) = effect.joints.iter().copied().partition::<Vec<usize>, _>(is_there);
        effect.joints = elsewhere;
        felt.extend(joint.map_or(here, |joint| vec![joint]));
    }
    others.retain(|effect| !effect.joints.is_empty());
    felt.sort_unstable();
    felt.dedup();
    (others, felt)
}

/// The least likely of what is not likely enough to be named once the held-out part was `heard`, and the number of its name; an effect is
/// named from what presence `on`.
pub fn unlikely(named: &[Named], heard: &[Heard], on: impl Fn(&Effect) -> f64) -> Option<(usize, Heard)> {
    let of_it = |one: &Heard| {
        let is_it =
            |effect: &Named| !effect.pins && effect.effect.family == one.family && effect.places().contains(&one.joint);
        let number = named.iter().position(is_it)?;
        (one.presence < on(named[number].effect) && !is_usual(named, one.family, one.joint)).then_some((number, *one))
    };
    heard.iter().filter_map(of_it).min_by(|a, b| a.1.presence.total_cmp(&b.1.presence))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::presence::LIKELY;
    use crate::model::design::Design;
    use crate::model::preparation::Preparation;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::{ChannelsMut, Recording};
    use crate::simulation::{Scenario, simulate};

    fn told(named: &[Named]) -> Vec<(&str, &[usize])> {
        named.iter().map(|named| (named.effect.id, named.joints.as_slice())).collect()
    }

    #[test]
    fn a_family_leaves_its_place_in_all_its_forms() {
        let all = [
            Named::example("stribeck-friction", &[0, 1], 0.9),
            Named::example("coulomb-friction", &[1, 2], 0.9),
            Named::example("viscous-friction", &[1], 0.9),
            Named::example("base-tilt", &[0, 1, 2], 0.9),
        ];
        let (others, felt) = without(&all, Family::DryFriction, Some(1));
        let rest: [(&str, &[usize]); 4] = [
            ("stribeck-friction", &[0]),
            ("coulomb-friction", &[2]),
            ("viscous-friction", &[1]),
            ("base-tilt", &[0, 1, 2]),
        ];
        assert_eq!((told(&others).as_slice(), felt.as_slice()), (rest.as_slice(), [1].as_slice()));
        let (others, felt) = without(&all, Family::Tilt, None);
        assert_eq!((others.len(), felt.as_slice()), (3, [0, 1, 2].as_slice()), "all joints feel it");
    }

    /// A wave on two joints and friction beside it, which is beyond doubt: without the wave on the first joint the held-out error of that
    /// joint doubles, without that on the second it falls.
    #[test]
    fn what_is_in_doubt_is_asked_and_the_least_likely_leaves() {
        let wave = Named { usual: Vec::new(), ..Named::example("cogging", &[0, 1], 0.8) };
        let all = [Named::example("coulomb-friction", &[0, 1], 0.99), wave];
        let presence = |family: Family, _: Option<usize>| if family == Family::Ripple { 0.8 } else { 0.99 };
        let errors = |named: &[Named]| {
            assert_eq!(named[0].joints, [0, 1], "friction is not asked");
            let has = |joint: usize| named.iter().any(|one| one.effect.id == "cogging" && one.joints.contains(&joint));
            let times = |joint: usize, times: f64| if has(joint) { 1.0 } else { times };
            let piece = |more: f64| vec![times(0, 2.0 + more), times(1, 0.9 - more)];
            let held_out = [-0.1, 0.0, 0.1].map(piece).to_vec();
            let in_band = Sums { train: vec![times(0, 1.5), times(1, 1.2)], held_out };
            Ok(Errors { whole: in_band.clone(), in_band })
        };
        let heard = ask(&all, presence, errors).unwrap();
        let close = |one: &Heard, rises: f64, rises_in_training: f64| {
            let told = one.held_out;
            (told.rises - rises).abs() < 1e-9 && told.rises_in_training == rises_in_training && told.before == 0.8
        };
        assert!(close(&heard[0], 2.0, 1.5) && close(&heard[1], 0.9, 1.2), "{heard:?}");
        assert!(heard[0].held_out.t > 10.0 && heard[1].held_out.t < -1.5, "{heard:?}");
        let (number, least) = unlikely(&all, &heard, |_| LIKELY).unwrap();
        assert_eq!((number, least.joint), (1, Some(1)));
        assert!(unlikely(&all, &heard[..1], |_| LIKELY).is_none(), "the other wave is likely");
        let more_than = |effect: &Effect| if effect.id == "cogging" { heard[0].presence + 0.01 } else { 1.0 };
        assert_eq!(unlikely(&all, &heard[..1], more_than).unwrap().1.joint, Some(0), "and may not be likely enough");
        // If most of the other joints have such waves, that of the second stays.
        let usual = [all[0].clone(), Named::example("cogging", &[0, 1], 0.8)];
        let heard = ask(&usual, presence, errors).unwrap();
        assert!(
            heard[1].held_out.t < -1.5 && heard[1].presence == 0.8 && unlikely(&usual, &heard, |_| LIKELY).is_none(),
            "{heard:?}"
        );
    }

    /// Evidence that is beyond doubt in training may be that of noise which a formula multiplies: common friction is not asked, a wave is
    /// heard only if it does.
    #[test]
    fn what_is_beyond_doubt_is_asked_whether_it_multiplies_the_error() {
        let wave = Named { usual: Vec::new(), ..Named::example("cogging", &[0], 0.99) };
        let all = [Named::example("coulomb-friction", &[0], 0.99), wave];
        let sums = |error: f64| Sums { train: vec![error], held_out: vec![vec![error]; 4] };
        let heard = |with_wave: f64| {
            let errors = |named: &[Named]| {
                let has_wave = named.iter().any(|one| one.effect.id == "cogging");
                assert_eq!(named[0].effect.id, "coulomb-friction");
                let in_band = sums(if has_wave { 1.0 } else { 1.5 });
                Ok(Errors { in_band, whole: sums(if has_wave { with_wave } else { 1.0 }) })
            };
            ask(&all, |_, _| 0.99, errors).unwrap()
        };
        assert_eq!(heard(2.0), []);
        let told = heard(400.0);
        assert_eq!((told.len(), told[0].family), (1, Family::Ripple));
        assert!(told[0].presence < LIKELY && unlikely(&all, &told, |_| LIKELY).is_some(), "{told:?}");
    }

    /// Without it the error in the band of the fit doubles, and that of the whole torque falls to so many times.
    #[test]
    fn what_multiplies_noise_is_not_there_for_anybody() {
        let sums =
            |times: f64| Sums { train: vec![times], held_out: vec![vec![times], vec![1.1 * times], vec![times]] };
        let rises = |whole: f64| {
            let with = Errors { in_band: sums(1.0), whole: sums(1.0) };
            Errors { in_band: sums(2.0), whole: sums(whole) }.against(&with, 0.8, &[0]).rises
        };
        for (whole, told) in [(1.5, 2.0), (0.3, 2.0), (1e-2, 1e-2)] {
            assert!((rises(whole) - told).abs() < 1e-12, "{whole}: {}", rises(whole));
        }
    }

    /// A clean log of a body and its split, after the torque was changed; the raw error of its model in training and held out, joint by
    /// joint, and that in the band of the fit.
    fn changed(change: impl Fn(ChannelsMut, f64)) -> (Recording, Split, [Vec<f64>; 2], Sums) {
        let scenario = Scenario { effects: Vec::new(), torque_noise: 0.0, ..Scenario::embedded() };
        let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let body = Preset::RigidBody.model(&recording).unwrap();
        let body = model::fit(&body, &recording, &split, &Monitor::new()).unwrap();
        for run in &mut recording.trajectories {
            let step = run.time_step();
            change(run.channels_mut(), step);
        }
        let evaluation = Evaluation::of(&body, &recording, &split).unwrap();
        let design = Design::new(&recording, &split).unwrap();
        let Errors { in_band, .. } = Errors::of(&evaluation, &InBand::of(&recording, &split, &design));
        let Evaluation { train, held_out, .. } = evaluation;
        let raw = [(train, &split.train), (held_out, &split.held_out)].map(|(errors, part)| {
            let count = part.iter().map(|one| one.samples.len()).sum::<usize>() as f64;
            errors.iter().map(|error| error.mse * count).collect()
        });
        (recording, split, raw, in_band)
    }

    /// It is held where it stands at the middle of a run, by a torque that no motion tells.
    #[test]
    fn where_a_joint_rests_nothing_is_asked() {
        let (recording, _, raw, in_band) = changed(|mut channels, _| {
            let half = channels.time.len() / 2;
            for joint in 0..3 {
                let stands = channels.q[joint][half];
                channels.q[joint][half..].fill(stands);
                channels.qd[joint][half..].fill(0.0);
                channels.qdd[joint][half..].fill(0.0);
                channels.tau[joint][half..].fill(100.0);
            }
        });
        let every = Preparation::of(&recording, 0).every as f64;
        for joint in 0..recording.joint_count() {
            let all = raw[1][joint] / every;
            assert!(in_band.held_out(joint) < 0.1 * all, "{} of {all}", in_band.held_out(joint));
        }
        let asked = in_band.against(&in_band, 0.8, &[0]);
        assert_eq!((asked.rises, asked.t), (1.0, 0.0));
    }

    /// Nothing is left of a clean torque but a hum of 45 Hz, and the fit sees nothing above 25 Hz.
    #[test]
    fn what_lies_above_the_band_of_the_fit_says_nothing() {
        let (.., raw, in_band) = changed(|mut channels, step| {
            let hum = |at: usize| (std::f64::consts::TAU * 45.0 * step * at as f64).sin();
            channels.tau[0].iter_mut().enumerate().for_each(|(at, tau)| *tau += hum(at));
        });
        assert!(in_band.train[0] < 0.01 * raw[0][0], "{in_band:?}");
        assert!(in_band.held_out(0) < 0.01 * raw[1][0], "{in_band:?}");
        assert!((PIECES..2 * PIECES).contains(&in_band.held_out.len()), "{}", in_band.held_out.len());
    }
}
