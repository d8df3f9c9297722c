//! Where a log goes beyond what the robot's file says that its joints can do: most often the log is not what it is taken for.
//!
//! Angles in degrees, joints in another order, a wrong sign or zero, the file of another robot: all of them break limits that a
//! controller keeps. Only what lies well beyond is told, as readings are noisy and limits are rounded.

use super::finding::{Finding, FindingKind, Place, Severity};
use super::{JointKind, Recording, Trajectory};
use crate::arm::chain::Chain;
use crate::arm::stated::Limits;

/// By so much of its range a position may lie beyond an end of it: stops give way, and encoders have an offset.
const POSITION_SLACK: f64 = 0.01;
/// By so much a speed or an effort may exceed its limit: they are noisy, and derived ones more so.
const RATE_SLACK: f64 = 0.05;
/// A position so many times beyond what is possible is hardly one in rad.
const LIKE_DEGREES: f64 = 10.0;

/// What has a limit.
#[derive(Clone, Copy, PartialEq)]
enum Quantity {
    Position,
    Velocity,
    Effort,
}

/// How far a joint goes beyond a limit.
struct Beyond {
    /// The limit that is exceeded.
    limit: f64,
    /// The value that exceeds it most, and where.
    value: f64,
    trajectory: usize,
    sample: usize,
    /// Samples beyond it.
    count: usize,
}

impl Quantity {
    const ALL: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Effort];

    fn symbol(self) -> &'static str {
        match self {
            Quantity::Position => "q",
            Quantity::Velocity => "q̇",
            Quantity::Effort => "τ",
        }
    }

    fn unit(self, kind: JointKind) -> &'static str {
        let [position, velocity, _, effort] = kind.units();
        match self {
            Quantity::Position => position,
            Quantity::Velocity => velocity,
            Quantity::Effort => effort,
        }
    }

    fn values(self, trajectory: &Trajectory, joint: usize) -> &[f64] {
        match self {
            Quantity::Position => &trajectory.q[joint],
            Quantity::Velocity => &trajectory.qd[joint],
            Quantity::Effort => &trajectory.tau[joint],
        }
    }

    /// The lowest and the highest value, and the slack of both.
    fn range(self, limits: &Limits) -> Option<([f64; 2], f64)> {
        let even = |most: f64| ([-most, most], RATE_SLACK * most);
        match self {
            Quantity::Position => limits.position.map(|[low, high]| ([low, high], POSITION_SLACK * (high - low))),
            Quantity::Velocity => limits.velocity.map(even),
            Quantity::Effort => limits.effort.map(even),
        }
    }
}

/// A finding for each limit of a joint that is exceeded; none where no limits are stated.
pub(super) fn find(recording: &Recording) -> Vec<Finding> {
    let Some(chain) = &recording.chain else { return Vec::new() };
    let places = (0..recording.joint_count()).flat_map(|joint| Quantity::ALL.map(|quantity| (joint, quantity)));
    let found = |(joint, quantity): (usize, Quantity)| {
        let beyond = beyond(recording, joint, quantity, &chain.limits(joint))?;
        Some((joint, quantity, beyond))
    };
    let found: Vec<(usize, Quantity, Beyond)> = places.filter_map(found).collect();
    let order = if found.is_empty() { None } else { order(recording, chain) };
    found.iter().map(|(joint, quantity, beyond)| told(recording, *joint, *quantity, beyond, order.as_deref())).collect()
}

/// How far the data of one joint exceed these limits.
fn beyond(recording: &Recording, joint: usize, quantity: Quantity, limits: &Limits) -> Option<Beyond> {
    let ([low, high], slack) = quantity.range(limits)?;
    let mut found: Option<Beyond> = None;
    for (trajectory, run) in recording.trajectories.iter().enumerate() {
        for (sample, &value) in quantity.values(run, joint).iter().enumerate() {
            let excess = (value - high).max(low - value);
            if excess <= slack {
                continue;
            }
            let count = found.as_ref().map_or(0, |found| found.count) + 1;
            let is_most = found.as_ref().is_none_or(|found| excess > (found.value - found.limit).abs());
            match &mut found {
                Some(found) if !is_most => found.count = count,
                _ => {
                    let limit = if value > high { high } else { low };
                    found = Some(Beyond { limit, value, trajectory, sample, count });
                }
            }
        }
    }
    found
}

fn told(recording: &Recording, joint: usize, quantity: Quantity, beyond: &Beyond, order: Option<&[usize]>) -> Finding {
    let Beyond { limit, value, trajectory, sample, count } = *beyond;
    let own = &recording.joints[joint];
    let (symbol, unit) = (quantity.symbol(), quantity.unit(own.kind));
    let by = (value - limit).abs();
    let share = 100.0 * count as f64 / recording.sample_count() as f64;
    let looks_like_degrees = quantity == Quantity::Position
        && own.kind == JointKind::Revolute
        && value.abs() > LIKE_DEGREES * limit.abs().max(1.0);
    let remedy = match (order, quantity) {
        _ if looks_like_degrees => {
            "They look like degrees: if they are, name the unit in the column, such as `q1[deg]`, and read the file again."
                .to_owned()
        }
        (Some(order), _) => {
            let numbers: Vec<String> = order.iter().map(|joint| (joint + 1).to_string()).collect();
            format!(
                "With the columns of the joints in the order {} nothing would exceed its limits: check the mapping.",
                numbers.join(", ")
            )
        }
        (None, Quantity::Position) => {
            "Check that the file is that of this robot, and that zero, sign and order of the joints are those of the log."
                .to_owned()
        }
        (None, _) => "Check the unit of the column, and that the file is that of this robot.".to_owned(),
    };
    Finding {
        severity: Severity::Warning,
        kind: FindingKind::BeyondLimit,
        what: format!(
            "{symbol} of {} is {value:.4} {unit} at sample {sample} of `{}`, {by:.4} {unit} beyond the limit of {limit:.4} {unit} that the \
             robot's file states; {count} samples ({share:.1} %) are beyond it.",
            own.name, recording.trajectories[trajectory].name
        ),
        place: Place { trajectory: Some(trajectory), samples: Some(sample..sample + 1), ..Place::joint(joint) },
        remedy,
        set_right: Vec::new(),
    }
}

/// Which joint of the log each joint of the file would be, so that no limit were exceeded; only where every joint has ends, as others
/// take any data.
fn order(recording: &Recording, chain: &Chain) -> Option<Vec<usize>> {
    let joints = recording.joint_count();
    let has_ends = |joint: usize| chain.limits(joint).position.is_some();
    if !(0..joints).all(has_ends) {
        return None;
    }
    let fits = |own: usize, place: usize| {
        let limits = chain.limits(place);
        recording.joints[own].kind == recording.joints[place].kind
            && Quantity::ALL.into_iter().all(|quantity| beyond(recording, own, quantity, &limits).is_none())
    };
    let fitting: Vec<Vec<bool>> = (0..joints).map(|place| (0..joints).map(|own| fits(own, place)).collect()).collect();
    arranged(&fitting, &mut Vec::new())
}

/// A way to give each place one that fits it and no other has.
fn arranged(fitting: &[Vec<bool>], before: &mut Vec<usize>) -> Option<Vec<usize>> {
    let Some(place) = fitting.get(before.len()) else { return Some(before.clone()) };
    for own in 0..place.len() {
        if place[own] && !before.contains(&own) {
            before.push(own);
            if let Some(whole) = arranged(fitting, before) {
                return Some(whole);
            }
            before.pop();
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::chain::{Axis, Convention};
    use crate::arm::stated::Stated;
    use crate::recording::Channels;
    use crate::signals::Signals;

    /// Joints that swing within these amplitudes of position, speed and effort, and an arm whose joints have these limits.
    fn swinging(amplitudes: &[[f64; 3]], limits: &[Limits]) -> Recording {
        let time: Vec<f64> = (0..1000).map(|sample| f64::from(sample) * 0.01).collect();
        let signal = |which: usize| {
            Signals::from_fn(amplitudes.len(), time.len(), |joint, t| {
                amplitudes[joint][which] * (0.05 * t as f64 + which as f64).sin()
            })
        };
        let channels = Channels { q: signal(0), qd: signal(1), qdd: signal(1), tau: signal(2), time: time.clone() };
        let axis = |limits: &Limits| Axis {
            stated: Stated { limits: *limits, ..Stated::default() }.if_any(),
            ..Axis::default()
        };
        let axes = limits.iter().map(axis).collect();
        let chain = Chain { convention: Convention::Modified, axes, gravity: [0.0, -9.81, 0.0] };
        let recording = Recording::of_runs(vec![Trajectory::new("swing", channels).unwrap()]);
        Recording { chain: Some(chain), ..recording }
    }

    fn within(position: f64, velocity: f64, effort: f64) -> Limits {
        Limits { position: Some([-position, position]), velocity: Some(velocity), effort: Some(effort) }
    }

    #[test]
    fn what_keeps_its_limits_or_has_none_is_not_told() {
        let amplitudes = [[1.0, 2.0, 30.0], [1.019, 2.09, 31.0]];
        assert!(find(&swinging(&amplitudes, &[within(1.0, 2.0, 30.0); 2])).is_empty(), "a little beyond is nothing");
        assert!(find(&swinging(&amplitudes, &[Limits::default(); 2])).is_empty());
        assert!(find(&Recording { chain: None, ..swinging(&amplitudes, &[Limits::default(); 2]) }).is_empty());
    }

    #[test]
    fn each_limit_that_is_exceeded_is_told_with_place_and_amount() {
        let recording = swinging(&[[1.5, 2.0, 30.0], [0.5, 3.0, 40.0]], &[within(1.0, 2.0, 30.0); 2]);
        let found = find(&recording);
        let joints: Vec<Option<usize>> = found.iter().map(|finding| finding.place.joint).collect();
        assert_eq!(joints, [Some(0), Some(1), Some(1)]);
        let first = &found[0];
        let sample = first.place.samples.clone().unwrap().start;
        assert!((recording.trajectories[0].q[0][sample].abs() - 1.5).abs() < 1e-3);
        assert!(first.what.contains("q of joint 1") && first.what.contains("0.5"), "{}", first.what);
        assert!(first.what.contains(&format!("at sample {sample} of `swing`")), "{}", first.what);
        assert!(found[1].what.contains("q̇ of joint 2") && found[2].what.contains("N m beyond"), "{}", found[2].what);
        assert!(found.iter().all(|finding| finding.kind == FindingKind::BeyondLimit));
    }

    #[test]
    fn degrees_and_another_order_of_joints_are_named() {
        let limits = [within(3.0, 2.0, 100.0), within(1.0, 4.0, 20.0)];
        let swapped = find(&swinging(&[[0.9, 3.5, 15.0], [2.5, 1.5, 80.0]], &limits));
        assert!(
            swapped.len() >= 2 && swapped.iter().all(|one| one.remedy.contains("in the order 2, 1")),
            "{swapped:?}"
        );
        let degrees = find(&swinging(&[[57.3 * 2.5, 1.5, 80.0], [0.5, 3.5, 15.0]], &limits));
        assert!(degrees[0].remedy.contains("degrees"), "{degrees:?}");
        let other = find(&swinging(&[[3.5, 1.5, 80.0], [0.5, 3.5, 15.0]], &limits));
        assert!(other.len() == 1 && other[0].remedy.contains("zero, sign and order"), "{other:?}");
    }
}
