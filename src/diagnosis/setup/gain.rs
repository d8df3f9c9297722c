//! Currents that stand for torques: where the masses of the arm are stated, the gain of each drive is identified.
//!
//! A current is i = (τ + friction, rotor, offset) / k. The stated arm says τ along the motion, so 1/k is the factor by which its torque
//! is found in the current, beside what every drive has. Without stated masses all gains could be larger and all links heavier.
//! Source: Gautier and Briot, Global identification of joint drive gains, J. Dyn. Sys. Meas. Control 136 (2014) 051025.

use crate::effect::{Family, Scope, registry};
use crate::model::{self, Model, Parameter, Preset, Term};
use crate::progress::{Monitor, Stopped};
use crate::recording::correction::{Correction, Part};
use crate::recording::finding::{Finding, FindingKind, Place, Severity};
use crate::recording::split::Split;
use crate::recording::{JointKind, Recording};

/// The interval of a gain has to lie within this share of it.
const SURE: f64 = 0.2;

/// A gain and its 95 % interval \[N m/A\].
struct Gain {
    joint: usize,
    value: f64,
    interval: [f64; 2],
}

/// The gains of the joints of a log whose torques are currents, as a finding that can take them; none where the masses are not stated,
/// or the motion does not tell a gain from what else is in the current.
///
/// # Errors
/// [`Stopped`] if the work was stopped.
pub fn gains(
    recording: &Recording,
    split: &Split,
    found: &[Finding],
    monitor: &Monitor,
) -> Result<Option<Finding>, Stopped> {
    let is_current = found.iter().any(|finding| finding.kind == FindingKind::Amperes);
    if !is_current || !recording.states_arm() {
        return Ok(None);
    }
    let fitted = with_gains(recording).and_then(|model| model::fit(&model, recording, split, monitor).ok());
    monitor.check()?;
    let Some(fitted) = fitted else { return Ok(None) };
    let is_gain = |parameter: &&Parameter| match &fitted.model.terms[parameter.term] {
        Term::Effect(placed) => placed.effect.family == Family::Gain,
        _ => false,
    };
    let gains: Vec<Gain> = fitted.parameters.iter().filter(is_gain).filter_map(gain).collect();
    Ok((!gains.is_empty()).then(|| told(recording, &gains)))
}

/// The stated arm with a gain on each joint, and what every drive has.
fn with_gains(recording: &Recording) -> Option<Model> {
    let stated = Preset::StatedArm.model(recording).ok()?;
    let joints: Vec<usize> = (0..recording.joint_count()).collect();
    let of_drives = registry::ALL.iter().filter(|effect| {
        let is_plain = effect.facts.everyday && effect.shapes().count() == 0;
        effect.scope == Scope::Joint && (is_plain || effect.family == Family::Gain)
    });
    of_drives.copied().try_fold(stated, |model, effect| model.with_effect(effect, &joints).ok())
}

/// What one current more or less than the torque says of the gain, if it says it surely.
fn gain(parameter: &Parameter) -> Option<Gain> {
    let ([low, high], joint) = (parameter.interval?, parameter.joint?);
    // The torque is in the current 1 + γ times.
    let [low, value, high] = [low, parameter.value, high].map(|error| 1.0 + error);
    let is_sure = parameter.identified && high - low < 2.0 * SURE * value.abs();
    is_sure.then(|| Gain { joint, value: 1.0 / value, interval: [1.0 / high, 1.0 / low] })
}

fn told(recording: &Recording, gains: &[Gain]) -> Finding {
    let unit = |joint: usize| match recording.joints[joint].kind {
        JointKind::Revolute => "N m/A",
        JointKind::Prismatic => "N/A",
    };
    let one = |gain: &Gain| {
        let [low, high] = gain.interval.map(digits);
        format!("{} {} at joint {} ({low} to {high})", digits(gain.value), unit(gain.joint), gain.joint + 1)
    };
    let all: Vec<String> = gains.iter().map(one).collect();
    let others: Vec<String> = (0..recording.joint_count())
        .filter(|joint| gains.iter().all(|gain| gain.joint != *joint))
        .map(|joint| (joint + 1).to_string())
        .collect();
    let others = match others.as_slice() {
        [] => String::new(),
        others => format!("; the motion does not tell that of joint {}", others.join(", ")),
    };
    let rounded = |gain: &Gain| digits(gain.value).parse().unwrap_or(gain.value);
    let (joints, factors) = gains.iter().map(|gain| (gain.joint, rounded(gain))).unzip();
    let set_right = Correction::Factor { part: Part::Torque, joints, factors };
    Finding {
        severity: Severity::Warning,
        kind: FindingKind::Gains,
        what: format!("with the masses that are stated the gains of the currents are {}{others}.", all.join(", ")),
        place: Place::default(),
        remedy: format!(
            "If the masses are right, take them with `--set-right {set_right}`; all parameters are as right as they are."
        ),
        set_right: vec![set_right],
    }
}

/// Four digits.
fn digits(value: f64) -> String {
    let decimals = (3.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{Scenario, simulate};

    fn amperes() -> Finding {
        Finding {
            severity: Severity::Warning,
            kind: FindingKind::Amperes,
            what: String::new(),
            place: Place::default(),
            remedy: String::new(),
            set_right: Vec::new(),
        }
    }

    /// Currents of drives whose gains differ, with friction: the gains are found, and with them the torque.
    #[test]
    fn gains_are_found_where_masses_are_stated() {
        let torque = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let gains_of = |recording: &Recording, found: &[Finding]| {
            gains(recording, &Split::automatic(recording), found, &Monitor::new()).unwrap()
        };
        let truth = [12.0, -40.0, 3.0];
        let mut current = torque.clone();
        for run in &mut current.trajectories {
            let mut tau = run.channels_mut().tau;
            for joint in 0..3 {
                tau[joint].iter_mut().for_each(|tau| *tau /= truth[joint]);
            }
        }
        let told = gains_of(&current, &[amperes()]).unwrap();
        let Correction::Factor { part: Part::Torque, joints, factors } = &told.set_right[0] else { panic!("{told:?}") };
        assert_eq!(joints, &[0, 1, 2]);
        for (found, truth) in factors.iter().zip(truth) {
            assert!((found / truth - 1.0).abs() < 0.03, "{found}, not {truth}: {}", told.what);
        }
        assert!(told.what.contains("N m/A at joint 2"), "{}", told.what);
        assert_eq!(gains_of(&torque, &[]), None, "torques have no gain");
        let bare = Recording { stated_arm: None, ..current };
        assert_eq!(gains_of(&bare, &[amperes()]), None, "heavier links would do as well");
    }
}
