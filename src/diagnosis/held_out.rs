//! What the held-out part says of names that are in doubt.
//!
//! Nothing is learned from it; but where it speaks more clearly against a name in doubt than the training part for it, the name does not
//! stand. Both are asked in the band in which models are fitted: above it an effect that is there may well raise the error, such as that
//! of an acceleration that follows a gap's crossing late.

use super::naming::Named;
use super::presence::SURE;
use super::report::Ground;
use super::withdrawn::Withdrawn;
use crate::effect::Family;
use crate::model::Evaluation;
use crate::model::design::Design;
use crate::model::preparation::Preparation;
use crate::recording::Recording;
use crate::recording::split::Split;

/// Squared error of each joint in the band of the fit \[(N m)²\].
#[derive(Debug, Clone, PartialEq)]
pub struct InBand {
    train: Vec<f64>,
    held_out: Vec<f64>,
}

impl InBand {
    /// Of a model that was held against the recording.
    pub fn of(evaluation: &Evaluation, recording: &Recording, split: &Split, design: &Design) -> Self {
        let none = vec![0.0; recording.joint_count()];
        let mut sums = InBand { train: none.clone(), held_out: none };
        let highest = design.follows_up_to().unwrap_or(f64::INFINITY);
        for run in 0..recording.trajectories.len() {
            let preparation = Preparation::of(recording, run).within(highest);
            let residual = preparation.apply_all(&evaluation.residual(recording, run));
            for (sums, part) in [(&mut sums.train, &split.train), (&mut sums.held_out, &split.held_out)] {
                for segment in part.iter().filter(|segment| segment.trajectory == run) {
                    let range = preparation.range(&segment.samples);
                    for (joint, sum) in sums.iter_mut().enumerate() {
                        *sum += residual[joint][range.clone()].iter().map(|left| left * left).sum::<f64>();
                    }
                }
            }
        }
        sums
    }
}

/// Of these names the one in doubt that the held-out part contradicts most, by its number. The errors before and after a step are asked for
/// only where a name is in doubt. What most of the other joints have stands by them, and what the stated arm brings to light by that.
pub fn contradicted(
    named: &[Named],
    errors: impl Fn(usize) -> [InBand; 2],
    presence: impl Fn(Family, Option<usize>) -> f64,
) -> Option<(usize, Withdrawn)> {
    let mut worst: Option<(f64, usize, Withdrawn)> = None;
    for (number, named) in named.iter().enumerate().filter(|(_, named)| !named.pins) {
        let in_doubt = |joint: &Option<usize>| {
            let is_usual = joint.is_some_and(|joint| named.usual.contains(&joint));
            !is_usual && presence(named.effect.family, *joint) < SURE
        };
        let mut places = named.effect.places(named.joints.iter().copied());
        places.retain(in_doubt);
        if places.is_empty() {
            continue;
        }
        let [before, after] = errors(number);
        for joint in places {
            let felt = joint.as_ref().map_or(named.joints.as_slice(), std::slice::from_ref);
            let rises: f64 = felt.iter().map(|&joint| after.held_out[joint] / before.held_out[joint]).product();
            let falls: f64 = felt.iter().map(|&joint| before.train[joint] / after.train[joint]).product();
            // By how much what speaks against it outweighs what speaks for it; where the training part does not fall, a step of rounding or
            // of other joints is compared, which says nothing.
            let outweighs = rises / falls;
            if falls > 1.0 && outweighs > 1.0 && worst.as_ref().is_none_or(|(other, ..)| outweighs > *other) {
                let ground = Ground::Contradicted { rises, falls };
                worst = Some((outweighs, number, Withdrawn { effect: named.effect, joint, ground }));
            }
        }
    }
    worst.map(|(_, number, one)| (number, one))
}

#[cfg(test)]
mod tests {
    use super::super::withdrawn::AFTER_ALL;
    use super::*;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    fn named(id: &str, joints: &[usize]) -> Named {
        Named { usual: Vec::new(), ..Named::example(id, joints, 0.7) }
    }

    fn errors(train: [f64; 2], held_out: [f64; 2]) -> InBand {
        InBand { train: train.to_vec(), held_out: held_out.to_vec() }
    }

    fn of(steps: &[[InBand; 2]]) -> impl Fn(usize) -> [InBand; 2] {
        |number| steps[number].clone()
    }

    /// A wave on both joints: on the first the held-out error rises by a fifth and the other falls by a tenth, on the second it is the other
    /// way round.
    #[test]
    fn what_is_in_doubt_falls_where_the_held_out_part_says_more_against_it() {
        let wave = || vec![named("cogging", &[0, 1])];
        let steps = [[errors([1.0, 1.2], [1.0, 1.0]), errors([0.9, 1.0], [1.2, 1.1])]];
        let (number, against) = contradicted(&wave(), of(&steps), |_, _| 0.8).unwrap();
        let ground = Ground::Contradicted { rises: 1.2, falls: 1.0 / 0.9 };
        assert_eq!((number, against.joint, against.ground, against.presence(0.8)), (0, Some(0), ground, AFTER_ALL));
        let is_on = |joint: Option<usize>, sure: f64| move |_: Family, place| if place == joint { sure } else { 0.99 };
        assert!(contradicted(&wave(), of(&steps), is_on(Some(0), SURE)).is_none(), "that it is there is sure");
        assert!(contradicted(&wave(), of(&steps), is_on(Some(1), 0.7)).is_none(), "the training part says more for it");
        let usual = vec![Named { usual: vec![0], ..named("cogging", &[0, 1]) }];
        assert!(contradicted(&usual, of(&steps), |_, _| 0.8).is_none(), "the other joints speak for it");
        let tilt = vec![named("base-tilt", &[0, 1])];
        assert!(contradicted(&tilt, of(&steps), |_, _| 0.8).is_none(), "both joints feel it");
        let steps = [[errors([1.0, 1.2], [1.0, 1.0]), errors([0.9, 1.0], [1.2, 1.3])]];
        let (_, against) = contradicted(&tilt, of(&steps), |_, _| 0.8).unwrap();
        let ground = Ground::Contradicted { rises: 1.2 * 1.3, falls: (1.0 / 0.9) * (1.2 / 1.0) };
        assert_eq!((against.joint, against.ground), (None, ground));
        let steps = [[errors([1.0, 1.0], [1.0, 1.0]), errors([1.005, 1.0], [1.002, 1.0])]];
        assert!(contradicted(&wave(), of(&steps), |_, _| 0.8).is_none(), "the training part does not speak for it");
    }

    /// Nothing is left of a clean torque but a hum of 45 Hz, and the fit sees nothing above 25 Hz.
    #[test]
    fn what_lies_above_the_band_of_the_fit_says_nothing() {
        let scenario = Scenario { effects: Vec::new(), torque_noise: 0.0, ..Scenario::embedded() };
        let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let body = Preset::RigidBody.model(&recording).unwrap();
        let body = model::fit(&body, &recording, &split, &Monitor::new()).unwrap();
        for run in &mut recording.trajectories {
            let step = run.time_step();
            let hum = |at: usize| (std::f64::consts::TAU * 45.0 * step * at as f64).sin();
            run.channels_mut().tau[0].iter_mut().enumerate().for_each(|(at, tau)| *tau += hum(at));
        }
        let design = Design::new(&recording, &split).unwrap();
        let evaluation = Evaluation::of(&body, &recording, &split).unwrap();
        let in_band = InBand::of(&evaluation, &recording, &split, &design);
        let count = |part: &[crate::recording::split::Segment]| part.iter().map(|one| one.samples.len()).sum::<usize>();
        let raw = |mse: f64, part: &[crate::recording::split::Segment]| mse * count(part) as f64;
        assert!(in_band.train[0] < 0.01 * raw(evaluation.train[0].mse, &split.train), "{in_band:?}");
        assert!(in_band.held_out[0] < 0.01 * raw(evaluation.held_out[0].mse, &split.held_out), "{in_band:?}");
    }
}
