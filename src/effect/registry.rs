//! Every effect that the program knows. A new effect is one new file and one line here.

use super::*;

/// All effects, in the order in which help and lists show them, and in which they act: first what moves with the arm, then
/// what the torque goes through until it is read.
pub static ALL: &[&dyn Effect] = &[
    &viscous_friction::ViscousFriction,
    &coulomb_friction::CoulombFriction,
    &asymmetric_friction::AsymmetricFriction,
    &stribeck_friction::StribeckFriction,
    &load_friction::LoadFriction,
    &quadratic_drag::QuadraticDrag,
    &position_friction::PositionFriction,
    &friction_drift::FrictionDrift,
    &friction_warm_up::FrictionWarmUp,
    &dahl_hysteresis::DahlHysteresis,
    &maxwell_slip::MaxwellSlip,
    &bouc_wen_hysteresis::BoucWenHysteresis,
    &lugre_friction::LugreFriction,
    &friction_coupling::FrictionCoupling,
    &joint_spring::JointSpring,
    &hardening_spring::HardeningSpring,
    &end_stop::EndStop,
    &cogging::Cogging,
    &tip_payload::TipPayload,
    &base_tilt::BaseTilt,
    &com_offset::ComOffset,
    &rotor_inertia::RotorInertia,
    &inertia_coupling::InertiaCoupling,
    &joint_elasticity::JointElasticity,
    &backlash::Backlash,
    &torque_coupling::TorqueCoupling,
    &torque_offset::TorqueOffset,
    &offset_drift::OffsetDrift,
    &torque_gain::TorqueGain,
    &dead_zone::DeadZone,
    &actuator_lag::ActuatorLag,
    &derivative_delay::DerivativeDelay,
    &torque_saturation::TorqueSaturation,
    &stuck_channel::StuckChannel,
];

/// The effects that the diagnosis looks for by their columns: all but faults of the readings, and those that data can't tell
/// from a sum of others, which it names instead.
pub fn sought() -> Vec<&'static dyn Effect> {
    let is_sum = |effect: &dyn Effect| effect.spec().look_alikes.iter().any(|others| others.effects.len() > 1);
    ALL.iter().copied().filter(|&effect| effect.fault().is_none() && !is_sum(effect)).collect()
}

/// Whether nearly every real joint has this effect, so that it comes to mind before any other: friction, the zero of the torque
/// reading, the inertia of a geared motor.
pub fn is_everyday(id: &str) -> bool {
    ["viscous-friction", "coulomb-friction", "stribeck-friction", "torque-offset", "rotor-inertia"].contains(&id)
}

/// Whether the first of these effects acts before the second.
pub fn acts_before(first: &str, second: &str) -> bool {
    let place = |id: &str| ALL.iter().position(|effect| effect.spec().id == id);
    place(first) < place(second)
}

/// The effect that stands for a fault of the readings.
pub fn of_fault(kind: FaultKind) -> Option<&'static dyn Effect> {
    ALL.iter().copied().find(|effect| effect.fault() == Some(kind))
}

/// No effect has this id.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no effect `{id}`; known effects: {known}")]
pub struct UnknownEffect {
    /// What was asked for.
    pub id: String,
    /// What there is.
    pub known: String,
}

/// The effect with this id.
///
/// # Errors
/// [`UnknownEffect`] lists the ids that exist.
pub fn find(id: &str) -> Result<&'static dyn Effect, UnknownEffect> {
    ALL.iter().copied().find(|effect| effect.spec().id == id).ok_or_else(|| UnknownEffect {
        id: id.to_owned(),
        known: ALL.iter().map(|effect| effect.spec().id).collect::<Vec<_>>().join(", "),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::effect::testing::Sample;

    /// Start values in the middle of the shape grids.
    fn shape(spec: &Spec) -> Vec<f64> {
        spec.shapes().map(|(_, grid)| grid[grid.len() / 2]).collect()
    }

    #[test]
    fn ids_are_unique_and_found() {
        let mut seen = HashSet::new();
        for effect in ALL {
            let spec = effect.spec();
            assert!(seen.insert(spec.id), "{} is there twice", spec.id);
            assert!(spec.id.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'), "{}", spec.id);
            assert_eq!(find(spec.id).unwrap().spec().name, spec.name);
        }
        let message = find("coulomb").map(|_| ()).unwrap_err().to_string();
        assert!(message.contains("no effect `coulomb`") && message.contains("coulomb-friction"), "{message}");
    }

    #[test]
    fn every_spec_is_complete() {
        for effect in ALL {
            let spec = effect.spec();
            let texts =
                [spec.name, spec.formula, spec.typeset, spec.description, spec.fingerprint, spec.absorbed, spec.source];
            assert!(texts.iter().all(|text| !text.trim().is_empty()), "{} lacks a text", spec.id);
            assert_eq!(spec.linear().count() > 0, effect.fault().is_none(), "{} has nothing to fit", spec.id);
            let linear_first = spec.parameters.iter().is_sorted_by_key(|p| matches!(p.role, Role::Shape { .. }));
            assert!(linear_first, "{}: linear parameters come first", spec.id);
            let names: HashSet<_> = spec.parameters.iter().map(|parameter| parameter.name).collect();
            assert_eq!(names.len(), spec.parameters.len(), "{} has a parameter twice", spec.id);
            for parameter in spec.parameters {
                assert!(!parameter.name.is_empty() && !parameter.symbol.is_empty() && parameter.min < parameter.max);
            }
            for (parameter, grid) in spec.shapes() {
                assert!(!grid.is_empty() && grid.is_sorted(), "{}: grid of {}", spec.id, parameter.name);
                assert!(grid.iter().all(|value| (parameter.min..=parameter.max).contains(value)));
            }
        }
    }

    #[test]
    fn every_linear_parameter_has_its_column_and_the_torque_is_their_sum() {
        let sample = Sample::new();
        for effect in ALL.iter().filter(|effect| effect.fault().is_none()) {
            let spec = effect.spec();
            let columns = effect.columns(&sample.motion(), 1, &shape(spec)).unwrap();
            assert_eq!(columns.len(), spec.linear().count(), "{}", spec.id);
            for (index, column) in columns.iter().enumerate() {
                let torque_with = |value: f64| {
                    let mut parameters = vec![0.7; columns.len()];
                    parameters[index] = value;
                    parameters.extend(shape(spec));
                    torque(*effect, &sample.motion(), 1, &parameters).unwrap()
                };
                let (low, high) = (torque_with(0.2), torque_with(1.2));
                let mut derivative = vec![vec![0.0; sample.trajectory.len()]; 3];
                for (joint, values) in &column.parts {
                    assert_eq!(values.len(), sample.trajectory.len(), "{}", spec.id);
                    derivative[*joint].clone_from(values);
                }
                for joint in 0..3 {
                    for t in 0..sample.trajectory.len() {
                        let slope = high[joint][t] - low[joint][t];
                        assert!((slope - derivative[joint][t]).abs() < 1e-9, "{}: {slope}", spec.id);
                    }
                }
            }
        }
    }

    #[test]
    fn effects_say_whether_they_depend_on_the_load() {
        let sample = Sample::new();
        for effect in ALL.iter().filter(|effect| effect.fault().is_none()) {
            let without = effect.columns(&Motion { load: None, ..sample.motion() }, 1, &shape(effect.spec()));
            assert_eq!(without.is_err(), effect.depends_on_load(), "{}", effect.spec().id);
        }
    }

    #[test]
    fn faults_of_readings_have_their_effect_and_no_columns() {
        let sample = Sample::new();
        for kind in [FaultKind::Stuck, FaultKind::Saturated] {
            let effect = of_fault(kind).unwrap();
            assert_eq!(effect.fault(), Some(kind));
            assert!(effect.columns(&sample.motion(), 1, &[]).unwrap_err().to_string().contains("nothing to add"));
        }
    }

    #[test]
    fn look_alikes_exist_and_look_alike_both_ways() {
        for effect in ALL {
            let spec = effect.spec();
            for others in spec.look_alikes {
                assert!(!others.effects.is_empty() && others.told_by.ends_with('.'), "{}", spec.id);
                for id in others.effects {
                    let other = find(id).unwrap().spec();
                    assert!(other.id != spec.id && other.scope == spec.scope, "{}", spec.id);
                }
                if let [id] = others.effects {
                    let back = find(id).unwrap().spec().look_alikes;
                    assert!(back.iter().any(|others| others.effects == [spec.id]), "{id} does not name {}", spec.id);
                }
            }
            let is_sought = sought().iter().any(|sought| sought.spec().id == spec.id);
            let expected = effect.fault().is_none() && spec.id != "asymmetric-friction";
            assert_eq!(is_sought, expected, "{}", spec.id);
        }
    }

    #[test]
    fn what_an_effect_includes_exists_and_is_among_its_columns() {
        let sample = Sample::new();
        for effect in ALL.iter().filter(|effect| effect.fault().is_none()) {
            let spec = effect.spec();
            let columns = effect.columns(&sample.motion(), 1, &shape(spec)).unwrap();
            for id in spec.includes {
                let part = find(id).unwrap();
                assert_ne!(part.spec().id, spec.id);
                for column in part.columns(&sample.motion(), 1, &shape(part.spec())).unwrap() {
                    assert!(columns.contains(&column), "{} does not contain {id}", spec.id);
                }
            }
        }
    }
}
