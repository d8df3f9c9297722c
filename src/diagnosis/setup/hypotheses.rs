//! What may be wrong about a set-up: a list of corrections, and searches for those that have a number.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rayon::prelude::*;

use super::bench::{Bench, Fit};
use crate::progress::{Monitor, Stopped};
use crate::recording::Pick;
use crate::recording::check::FAR;
use crate::recording::correction::{Correction, Counted, Part};
use crate::recording::{JointKind, Recording};

/// All orders are tried of so many joints; of more, pairs that were taken for each other, and the reverse.
const ALL_ORDERS: usize = 4;
/// All sets of joints with the other sign are tried of so many joints; of more, single ones and all.
const ALL_SIGNS: usize = 3;
/// Longest delay that is looked for, as a share of the period of the motion.
const LONGEST_DELAY: f64 = 0.2;
/// A zero may be off by more than this \[rad\]; less is a tilt or a centre of mass beside the link, which effects describe.
const LEAST_TURN: f64 = 0.55;
/// Steps of a search over a circle, and over delays.
const ON_CIRCLE: usize = 24;
const DELAYS: i32 = 8;
/// Steps of a golden section.
const REFINED: usize = 10;
/// How far a joint is likely to move \[rad\]: where the search for gear ratios begins. Neighbours are near enough that the angle
/// of the better one is right within half a radian.
const LIKELY_RANGES: [f64; 8] = [0.7, 0.95, 1.3, 1.75, 2.35, 3.2, 4.3, 5.8];
/// All likely ranges are tried together of so many joints.
const ALL_RATIOS: usize = 3;
/// That is done with every `ROUGH`-th sample, and goes on from the best with every `COARSE`-th.
const ROUGH: usize = 6;
const COARSE: usize = 3;
const BEST_STARTS: usize = 4;
/// It goes so many steps of this factor to either side, so many rounds, until a round gains less (in sums of logarithms).
const RATIO_STEP: f64 = 1.1;
const STEPS: i32 = 4;
const ROUNDS: usize = 5;
const SLOW: f64 = 0.01;
/// A lag is tried with these multiples of the delay that it could be.
const LAGS: [f64; 5] = [0.6, 0.8, 1.0, 1.25, 1.6];

/// Set-ups without a number to search for.
pub(super) fn listed(bench: &Bench) -> Vec<Correction> {
    let thin = &bench.thin;
    let joints = thin.joint_count();
    let mut list = Vec::new();
    if is_planar(thin) {
        list.extend(other_directions(bench));
    }
    if thin.spatial().is_some() || joints > 1 {
        let first = usize::from(thin.spatial().is_none());
        for joint in (first..joints).filter(|&joint| thin.joints[joint].kind == JointKind::Revolute) {
            for quarters in [1.0, -1.0, 2.0] {
                list.push(Correction::Offset { joints: vec![joint], angles: vec![quarters * FRAC_PI_2] });
            }
        }
    }
    for part in [Part::Torque, Part::Motion, Part::All] {
        for joints in sign_sets(joints) {
            list.push(Correction::Sign { part, joints });
        }
        for order in orders(joints) {
            list.push(Correction::Order { part, order });
        }
    }
    if is_planar(thin) && joints > 1 {
        list.extend([Counted::Absolute, Counted::Relative].map(Correction::Angles));
    }
    list
}

/// Whether it is an arm in a vertical plane, whose zero is a direction.
pub(super) fn is_planar(thin: &Recording) -> bool {
    thin.chain.is_none() && thin.joints.iter().all(|joint| joint.kind == JointKind::Revolute)
}

/// The first link in the directions in which it is not said to be.
pub(super) fn other_directions(bench: &Bench) -> impl Iterator<Item = Correction> {
    let stated = bench.posture().zero_angle;
    let is_other = move |angle: &f64| turn_between(*angle, stated) > 1e-6;
    [0.0, FRAC_PI_2, PI, -FRAC_PI_2].into_iter().filter(is_other).map(|angle| Correction::Zero { angle })
}

/// The smaller angle between two directions \[rad\].
fn turn_between(one: f64, other: f64) -> f64 {
    let turn = (one - other).rem_euclid(TAU);
    turn.min(TAU - turn)
}

/// Sets of joints that may have the other sign together. All of them at once are among them.
fn sign_sets(joints: usize) -> Vec<Vec<usize>> {
    if joints <= ALL_SIGNS {
        let members = |set: usize| (0..joints).filter(|joint| set >> joint & 1 == 1).collect();
        return (1..1usize << joints).map(members).collect();
    }
    (0..joints).map(|joint| vec![joint]).chain([(0..joints).collect()]).collect()
}

/// Orders of joints but the one that is stated.
fn orders(joints: usize) -> Vec<Vec<usize>> {
    let as_stated: Vec<usize> = (0..joints).collect();
    let mut orders = vec![as_stated.clone()];
    if joints <= ALL_ORDERS {
        for place in 0..joints {
            let extended = orders.iter().flat_map(|order| {
                (place..joints).map(|other| {
                    let mut order = order.clone();
                    order.swap(place, other);
                    order
                })
            });
            orders = extended.collect();
        }
    } else {
        for one in 0..joints {
            for other in one + 1..joints {
                let mut order = as_stated.clone();
                order.swap(one, other);
                orders.push(order);
            }
        }
        orders.push((0..joints).rev().collect());
    }
    orders.retain(|order| *order != as_stated);
    orders
}

/// How much is left, for a search: the mean of the joints' logarithms, so that each counts alike.
fn left(fit: Option<Fit>) -> f64 {
    fit.map_or(f64::INFINITY, |fit| fit.errors.iter().map(|error| error.max(1e-9).ln()).sum())
}

/// The best direction of the first link, if it is none of the four.
pub(super) fn free_zero(bench: &Bench, monitor: &Monitor) -> Result<Option<Correction>, Stopped> {
    let zero = |angle: f64| Correction::Zero { angle };
    let step = TAU / ON_CIRCLE as f64;
    let grid = (0..ON_CIRCLE).map(|place| place as f64 * step - PI);
    let angle = search(bench, monitor, grid, step, zero)?;
    let degrees = angle.to_degrees().round();
    let is_far = turn_between(angle, bench.posture().zero_angle) > LEAST_TURN;
    Ok((is_far && degrees.rem_euclid(90.0) > 0.0).then(|| zero(degrees.to_radians())))
}

/// The best delay of the torque, in whole samples. That parts of the motion come late the derivatives say by themselves.
pub(super) fn delay(bench: &Bench, monitor: &Monitor) -> Result<Option<(Correction, f64)>, Stopped> {
    let longest = LONGEST_DELAY * period(&bench.thin);
    let step = longest / f64::from(DELAYS);
    if !(step.is_finite() && step > 0.0) {
        return Ok(None);
    }
    let delay = |seconds: f64| Correction::Delay { part: Part::Torque, seconds };
    let grid = (-DELAYS..=DELAYS).map(|place| f64::from(place) * step);
    let seconds = search(bench, monitor, grid, step, delay)?;
    let samples = (seconds / bench.step).round();
    let whole = samples * bench.step;
    Ok((samples != 0.0 && seconds.abs() < longest).then(|| (delay(whole), whole)))
}

/// The drive's lag that stands nearest to a delay of the torque: no mistake of the set-up.
pub(super) fn lag(bench: &Bench, seconds: f64) -> Option<Fit> {
    let fits = LAGS.iter().filter_map(|multiple| bench.without_lag(multiple * seconds));
    fits.map(|fit| (left(Some(fit.clone())), fit)).min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, fit)| fit)
}

/// Shortest of the joints' periods \[s\], 2π rms(q − mean) / rms(q̇).
fn period(thin: &Recording) -> f64 {
    let of_joint = |joint: usize| {
        let spread = |signal: Pick| {
            let values: Vec<f64> = thin.trajectories.iter().flat_map(|run| &signal(run)[joint]).copied().collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>().sqrt()
        };
        TAU * spread(|run| &run.q) / spread(|run| &run.qd)
    };
    (0..thin.joint_count()).map(of_joint).filter(|period| period.is_finite()).fold(f64::INFINITY, f64::min)
}

/// The value with the least error: of a grid, then by golden section between its neighbours.
fn search(
    bench: &Bench,
    monitor: &Monitor,
    grid: impl Iterator<Item = f64>,
    step: f64,
    correction: impl Fn(f64) -> Correction + Sync,
) -> Result<f64, Stopped> {
    let error = |value: f64| {
        monitor.check()?;
        Ok::<f64, Stopped>(left(bench.corrected(&[correction(value)])))
    };
    let values: Vec<f64> = grid.collect();
    let errors = values.par_iter().map(|&value| error(value)).collect::<Result<Vec<f64>, Stopped>>()?;
    let mut best = (f64::INFINITY, 0.0);
    for (found, value) in errors.into_iter().zip(values) {
        if found < best.0 {
            best = (found, value);
        }
    }
    golden([best.1 - step, best.1 + step], error)
}

/// The place of the least error in an interval, by golden section.
pub(super) fn golden(
    [mut low, mut high]: [f64; 2],
    error: impl Fn(f64) -> Result<f64, Stopped>,
) -> Result<f64, Stopped> {
    let share = (5f64.sqrt() - 1.0) / 2.0;
    let inner = |low: f64, high: f64| (high - share * (high - low), low + share * (high - low));
    let (mut below, mut above) = inner(low, high);
    let (mut left, mut right) = (error(below)?, error(above)?);
    for _ in 0..REFINED {
        if left < right {
            (high, above, right) = (above, below, left);
            below = inner(low, high).0;
            left = error(below)?;
        } else {
            (low, below, left) = (below, above, right);
            above = inner(low, high).1;
            right = error(above)?;
        }
    }
    Ok((low + high) / 2.0)
}

/// Joints whose angles reach further than a robot's.
pub(super) fn far(thin: &Recording) -> Vec<usize> {
    let is_far = |joint: &usize| {
        let reaches = thin.trajectories.iter().flat_map(|run| &run.q[*joint]).any(|q| q.abs() > FAR);
        thin.joints[*joint].kind == JointKind::Revolute && reaches
    };
    (0..thin.joint_count()).filter(is_far).collect()
}

/// What the motion of the joints that reach too far may have to be multiplied by: all are in degrees, or each is that of a motor
/// before a gear of its own.
pub(super) fn gears(bench: &Bench, far: &[usize], monitor: &Monitor) -> Result<Vec<Correction>, Stopped> {
    let correction =
        |factors: &[f64]| Correction::Factor { part: Part::Motion, joints: far.to_vec(), factors: factors.to_vec() };
    let error = |bench: &Bench, factors: &[f64]| {
        monitor.check()?;
        Ok::<f64, Stopped>(left(bench.corrected(&[correction(factors)])))
    };
    let rough = bench.coarse(ROUGH);
    let starts = starts(&bench.thin, far).into_par_iter().map(|start| Ok((error(&rough, &start)?, start)));
    let mut starts = starts.collect::<Result<Vec<(f64, Vec<f64>)>, Stopped>>()?;
    starts.sort_by(|one, other| one.0.total_cmp(&other.0));
    starts.truncate(BEST_STARTS);
    let coarse = bench.coarse(COARSE);
    let descend = |(_, mut factors): (f64, Vec<f64>)| {
        let mut least = error(&coarse, &factors)?;
        for _ in 0..ROUNDS {
            let before = least;
            for place in 0..far.len() {
                let middle = factors[place];
                for (way, step) in [1.0, -1.0].into_iter().flat_map(|way| (-STEPS..=STEPS).map(move |step| (way, step)))
                {
                    let mut tried = factors.clone();
                    tried[place] = way * middle * RATIO_STEP.powi(step);
                    let found = error(&coarse, &tried)?;
                    if found < least {
                        (least, factors) = (found, tried);
                    }
                }
            }
            if before - least < SLOW {
                break;
            }
        }
        Ok((least, factors))
    };
    let ends = starts.into_par_iter().map(descend).collect::<Result<Vec<(f64, Vec<f64>)>, Stopped>>()?;
    let best = ends.into_iter().min_by(|one, other| one.0.total_cmp(&other.0));
    let mut factors = best.map_or(Vec::new(), |(_, factors)| factors);
    for width in [RATIO_STEP, RATIO_STEP.powf(0.2), RATIO_STEP.powf(0.04)] {
        for place in 0..far.len() {
            let of = |exponent: f64| {
                let mut tried = factors.clone();
                tried[place] *= width.powf(exponent);
                tried
            };
            let exponent = golden([-1.0, 1.0], |exponent| error(bench, &of(exponent)))?;
            factors = of(exponent);
        }
    }
    let rounded: Vec<f64> = factors.iter().copied().map(round_ratio).collect();
    // The mirror image of a motion explains as much; which of the two it is the signs of the masses say.
    let mirrored: Vec<f64> = rounded.iter().map(|factor| -factor).collect();
    Ok(vec![correction(&vec![PI / 180.0; far.len()]), correction(&rounded), correction(&mirrored)])
}

/// Where the search for factors begins: each joint moves as far as joints are likely to, either way round but for the first. Of
/// many joints, all as far as each other.
fn starts(thin: &Recording, far: &[usize]) -> Vec<Vec<f64>> {
    let ranges = far.iter().map(|&joint| thin.way(joint)).map(|[low, high]| high - low);
    let ranges: Vec<f64> = ranges.collect();
    if far.len() > ALL_RATIOS {
        return LIKELY_RANGES.iter().map(|likely| ranges.iter().map(|range| likely / range).collect()).collect();
    }
    let mut starts = vec![Vec::new()];
    for (place, range) in ranges.iter().enumerate() {
        let ways: &[f64] = if place == 0 { &[1.0] } else { &[1.0, -1.0] };
        let factors = LIKELY_RANGES.iter().flat_map(|likely| ways.iter().map(move |way| way * likely / range));
        let factors: Vec<f64> = factors.collect();
        let longer = starts.iter().flat_map(|start: &Vec<f64>| {
            factors.iter().map(|factor| start.iter().copied().chain([*factor]).collect::<Vec<f64>>())
        });
        starts = longer.collect();
    }
    starts
}

/// A factor 1 / n for a ratio n that is nearly whole, or nearly degrees.
fn round_ratio(factor: f64) -> f64 {
    let ratio = 1.0 / factor;
    let degrees = (180.0 / PI).copysign(ratio);
    if (ratio / degrees - 1.0).abs() < 0.003 {
        return 1.0 / degrees;
    }
    let whole = ratio.round();
    if (ratio / whole - 1.0).abs() < 0.003 { 1.0 / whole } else { factor }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Channels, Trajectory};
    use crate::signals::Signals;

    #[test]
    fn every_order_is_tried_once_and_the_stated_one_never() {
        for (joints, count) in [(1, 0), (2, 1), (3, 5), (4, 23), (6, 16)] {
            let mut found = orders(joints);
            assert_eq!(found.len(), count);
            assert!(!found.contains(&(0..joints).collect()));
            found.sort();
            found.dedup();
            assert_eq!(found.len(), count);
        }
        assert_eq!([1, 2, 3, 6].map(|joints| sign_sets(joints).len()), [1, 3, 7, 7]);
    }

    #[test]
    fn ratios_are_rounded_to_whole_ones_and_degrees() {
        assert_eq!([0.010_01, -0.031_3, 0.017_47, 0.0283].map(round_ratio), [0.01, -1.0 / 32.0, PI / 180.0, 0.0283]);
    }

    #[test]
    fn a_turn_is_the_shorter_way_round() {
        for (one, other, turn) in [(0.1, -0.1, 0.2), (3.0, -3.0, TAU - 6.0), (TAU, 0.0, 0.0), (0.0, PI, PI)] {
            assert!((turn_between(one, other) - turn).abs() < 1e-12, "{one} {other}");
        }
    }

    /// The first link of an arm in a vertical plane has a direction, that of an arm in space or of what slides has none.
    #[test]
    fn only_arms_in_a_plane_have_a_zero() {
        let mut recording = crate::selftest::seeds::recording(0).unwrap();
        assert!(is_planar(&recording));
        // q = A sin(ωt) has the period 2π rms(q) / rms(q̇).
        let time: Vec<f64> = (0..500).map(|sample| f64::from(sample) * 0.01).collect();
        let signal = |f: &dyn Fn(f64) -> f64| Signals::from_fn(1, 500, |_, sample| f(TAU * 0.8 * time[sample]));
        let (q, qd) = (signal(&|phase| 2.0 + 0.3 * phase.sin()), signal(&|phase| 0.3 * TAU * 0.8 * phase.cos()));
        let channels = Channels { q, qd, qdd: signal(&|_| 0.0), tau: signal(&|_| 0.0), time: time.clone() };
        let swing = Recording::of_runs(vec![Trajectory::new("swing", channels).unwrap()]);
        assert!((period(&swing) - 1.25).abs() < 1e-3, "{}", period(&swing));
        recording.joints[0].kind = JointKind::Prismatic;
        assert!(!is_planar(&recording));
    }
}
