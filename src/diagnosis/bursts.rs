//! Stretches in which a model errs many times as much as elsewhere, wherever they stand: in training, where a contact of half a second in a
//! long log looks like noise, where it is held out, or between the two, where else nobody looks.

use super::in_band::InBand;
use crate::model::Evaluation;
use crate::recording::Recording;
use crate::recording::split::{self, Segment, Unusable};
use crate::signals::Signals;
use crate::statistics::median;

/// A knock, a contact or a slip lasts about so long \[s\].
const LASTS: f64 = 0.5;
/// A stretch counts if the error in it is so many times the median of all stretches (RMS) …
const TIMES: f64 = 4.0;
/// … and more than this share of the torque. Of 216 worlds (`bench diagnosis --world --draws 216 --seed 500000`) no complete one is flagged for
/// that alone; with a tenth it is three geared arms, whose friction at crawling speed is called by another form.
const WORTH_A_DOUBT: f64 = 0.25;
/// Of fewer stretches none is said to differ from the others.
const FEWEST: usize = 10;
/// A joint moves in so much of a stretch that counts.
const MOVES: f64 = 0.5;

/// A stretch in which a model errs many times as much on a joint as elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// From 0.
    pub joint: usize,
    /// In samples of the recording.
    pub stretch: Segment,
    /// RMS error over the median of all stretches.
    pub times: f64,
}

/// The worst such stretch of each joint, if there is one, of a model that was held against the recording.
pub fn find(evaluation: &Evaluation, in_band: &InBand, recording: &Recording) -> Vec<Burst> {
    let residuals = in_band.left(evaluation).in_band;
    let all = |unusable: &[Unusable]| -> Vec<Burst> {
        let of_joint = |joint| worst(&residuals, in_band, recording, joint, unusable);
        (0..recording.joint_count()).filter_map(of_joint).collect()
    };
    // Readings that are none are told elsewhere; to look for them takes longer than to look for bursts.
    let bursts = all(&[]);
    if bursts.is_empty() { bursts } else { all(&split::unusable(recording)) }
}

fn worst(
    residuals: &[Signals],
    in_band: &InBand,
    recording: &Recording,
    joint: usize,
    unusable: &[Unusable],
) -> Option<Burst> {
    let mut stretches: Vec<(f64, Segment)> = Vec::new();
    for (run, residual) in residuals.iter().enumerate() {
        let (every, moves) = (in_band.every(run), &in_band.moves(run)[joint]);
        let time_step = recording.trajectories[run].time_step() * every as f64;
        let all = Segment { trajectory: run, samples: 0..moves.len() };
        for piece in all.pieces((LASTS / time_step) as usize) {
            let moving = moves[piece.samples.clone()].iter().filter(|moves| **moves).count();
            let stretch = Segment { trajectory: run, samples: piece.samples.start * every..piece.samples.end * every };
            let is_usable = unusable.iter().filter(|one| one.torque_of.is_none_or(|of| of == joint)).all(|one| {
                // A filter spreads them.
                let (beside, one) = (stretch.samples.len(), &one.stretch);
                one.trajectory != run
                    || one.samples.end + beside <= stretch.samples.start
                    || stretch.samples.end + beside <= one.samples.start
            });
            if is_usable && moving as f64 > MOVES * moves[piece.samples.clone()].len() as f64 {
                let squares = residual[joint][piece.samples].iter().map(|left| left * left);
                stretches.push(((squares.sum::<f64>() / moving as f64).sqrt(), stretch));
            }
        }
    }
    if stretches.len() < FEWEST {
        return None;
    }
    let usual = median(stretches.iter().map(|(error, _)| *error).collect())?;
    let (error, stretch) = stretches.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let (count, energy) = recording.trajectories.iter().fold((0, 0.0), |(count, energy), run| {
        (count + run.len(), energy + run.tau[joint].iter().map(|tau| tau * tau).sum::<f64>())
    });
    let torque = (energy / count as f64).sqrt();
    (error > TIMES * usual && error > WORTH_A_DOUBT * torque).then_some(Burst { joint, stretch, times: error / usual })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::design::Design;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::Origin;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    const STEP: f64 = 0.005;

    /// A run of 15 s in which nothing is missing.
    fn clean() -> Recording {
        let mut scenario = Scenario { effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut scenario.motion {
            (*trajectories, *duration, *rate) = (1, 15.0, 1.0 / STEP);
        }
        simulate(&scenario, &Monitor::new()).unwrap()
    }

    /// With a torque that pushes joint 2 for a while.
    fn push(mut recording: Recording, from: f64, to: f64, torque: f64) -> Recording {
        let tau = &mut recording.trajectories[0].channels_mut().tau[1];
        tau[(from / STEP) as usize..(to / STEP) as usize].iter_mut().for_each(|tau| *tau += torque);
        recording
    }

    /// A rigid body that is held against the recording.
    fn held_against(recording: &Recording) -> (Evaluation, InBand<'_>) {
        let split = Split::automatic(recording);
        let body = Preset::RigidBody.model(recording).unwrap();
        let body = model::fit(&body, recording, &split, &Monitor::new()).unwrap();
        let evaluation = Evaluation::of(&body, recording, &split).unwrap();
        let design = Design::new(recording, &split).unwrap();
        (evaluation, InBand::of(recording, &split, &design))
    }

    /// What stands out once joint 2 is pushed.
    fn pushed(recording: Recording, from: f64, to: f64, torque: f64) -> Vec<Burst> {
        let recording = push(recording, from, to, torque);
        let (evaluation, in_band) = held_against(&recording);
        find(&evaluation, &in_band, &recording)
    }

    #[test]
    fn what_acts_for_a_moment_stands_out_where_it_acts() {
        assert_eq!(pushed(clean(), 0.0, 0.0, 0.0), []);
        assert_eq!(pushed(clean(), 4.1, 4.5, 1e-2), [], "hardly any torque");
        let [burst] = pushed(clean(), 4.1, 4.5, 10.0).try_into().unwrap();
        let samples = burst.stretch.samples.clone();
        assert_eq!((burst.joint, burst.stretch.trajectory), (1, 0));
        assert!(samples.contains(&((4.3 / STEP) as usize)) && burst.times > 2.0 * TIMES, "{burst:?}");
        assert_eq!(pushed(clean(), 2.0, 13.0, 10.0), [], "what acts most of the time is no burst");
    }

    /// The ends of derived signals go astray by themselves.
    #[test]
    fn nothing_stands_out_at_the_ends_of_runs() {
        let derived = || {
            let mut recording = clean();
            recording.provenance.acceleration = Origin::Derived("here".to_owned());
            recording
        };
        assert_eq!(pushed(derived(), 14.9, 15.0, 20.0), []);
        assert_eq!(pushed(derived(), 4.1, 4.5, 10.0).len(), 1);
    }

    #[test]
    fn readings_that_are_none_do_not_stand_out() {
        let recording = push(clean(), 4.1, 4.5, 10.0);
        let (evaluation, in_band) = held_against(&recording);
        let residuals = in_band.left(&evaluation).in_band;
        let worst = |torque_of: Option<usize>| {
            let stretch = Segment { trajectory: 0, samples: 815..905 };
            worst(&residuals, &in_band, &recording, 1, &[Unusable { stretch, torque_of }])
        };
        assert_eq!([worst(Some(1)), worst(None)], [None, None]);
        assert!(worst(Some(0)).is_some(), "those of another joint are not its own");
    }
}
