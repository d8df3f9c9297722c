//! Every effect that the program knows. A new effect is one new file and one line here; those of one's own are loaded
//! ([`own::load`]) and found by their ids, too, but sought only by who asks for them.

use super::*;

/// All effects, in the order in which help and lists show them. It changes no result: they act in the order of their stages.
pub static ALL: &[&Effect] = &[
    &viscous_friction::EFFECT,
    &coulomb_friction::EFFECT,
    &asymmetric_friction::EFFECT,
    &stribeck_friction::EFFECT,
    &load_friction::EFFECT,
    &quadratic_drag::EFFECT,
    &concave_friction::EFFECT,
    &position_friction::EFFECT,
    &friction_drift::EFFECT,
    &friction_warm_up::EFFECT,
    &frictional_heating::EFFECT,
    &dahl_hysteresis::EFFECT,
    &maxwell_slip::EFFECT,
    &bouc_wen_hysteresis::EFFECT,
    &lugre_friction::EFFECT,
    &friction_coupling::EFFECT,
    &joint_spring::EFFECT,
    &hardening_spring::EFFECT,
    &upper_stop::EFFECT,
    &lower_stop::EFFECT,
    &cogging::EFFECT,
    &tip_payload::EFFECT,
    &base_tilt::EFFECT,
    &com_offset::EFFECT,
    &rotor_inertia::EFFECT,
    &inertia_coupling::EFFECT,
    &joint_elasticity::EFFECT,
    &backlash::EFFECT,
    &motor_side_elasticity::EFFECT,
    &motor_side_backlash::EFFECT,
    &torque_coupling::EFFECT,
    &torque_offset::EFFECT,
    &offset_drift::EFFECT,
    &torque_gain::EFFECT,
    &dead_zone::EFFECT,
    &actuator_lag::EFFECT,
    &derivative_delay::EFFECT,
    &torque_saturation::EFFECT,
    &stuck_channel::EFFECT,
];

/// The effects that a model can have: all but faults of the readings.
pub fn addable() -> impl Iterator<Item = &'static Effect> {
    ALL.iter().copied().filter(|effect| effect.fault().is_none())
}

/// The effects that the diagnosis looks for by their columns: those that a model can have, but for those that data can't tell
/// from a sum of others, which it names instead.
pub fn sought() -> Vec<&'static Effect> {
    addable().filter(|effect| effect.sum().is_none()).collect()
}

/// The effect that stands for a fault of the readings.
pub fn of_fault(kind: FaultKind) -> Option<&'static Effect> {
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

/// The effect with this id, of the catalogue or loaded from a file.
///
/// # Errors
/// [`UnknownEffect`] lists the ids that exist.
pub fn find(id: &str) -> Result<&'static Effect, UnknownEffect> {
    let known = || ALL.iter().copied().chain(own::loaded());
    known().find(|effect| effect.id == id).ok_or_else(|| UnknownEffect {
        id: id.to_owned(),
        known: known().map(|effect| effect.id).collect::<Vec<_>>().join(", "),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::effect::testing::Sample;

    /// Start values in the middle of the shape grids.
    fn shape(effect: &Effect) -> Vec<f64> {
        effect.shapes().map(|(_, starts)| starts.values([-1.0, 1.2])).map(|values| values[values.len() / 2]).collect()
    }

    #[test]
    fn ids_are_unique_and_found() {
        let mut seen = HashSet::new();
        for effect in ALL {
            assert!(seen.insert(effect.id), "{} is there twice", effect.id);
            assert!(
                effect.id.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'),
                "{}",
                effect.id
            );
            assert_eq!(find(effect.id).unwrap().name, effect.name);
        }
        let message = find("coulomb").map(|_| ()).unwrap_err().to_string();
        assert!(message.contains("no effect `coulomb`") && message.contains("coulomb-friction"), "{message}");
    }

    #[test]
    fn every_effect_is_complete() {
        for effect in ALL {
            let texts = [
                effect.name,
                effect.formula,
                effect.typeset,
                effect.description,
                effect.fingerprint,
                effect.absorbed,
                effect.source,
            ];
            assert!(texts.iter().all(|text| !text.trim().is_empty()), "{} lacks a text", effect.id);
            assert_eq!(effect.linear().count() > 0, effect.fault().is_none(), "{} has nothing to fit", effect.id);
            let linear_first = effect.parameters.iter().is_sorted_by_key(|p| matches!(p.role, Role::Shape { .. }));
            assert!(linear_first, "{}: linear parameters come first", effect.id);
            let names: HashSet<_> = effect.parameters.iter().map(|parameter| parameter.name).collect();
            assert_eq!(names.len(), effect.parameters.len(), "{} has a parameter twice", effect.id);
            for parameter in effect.parameters {
                assert!(!parameter.name.is_empty() && !parameter.symbol.is_empty() && parameter.min < parameter.max);
            }
            for (parameter, starts) in effect.shapes() {
                let values = starts.values([-1.0, 1.0]);
                assert!(!values.is_empty() && values.is_sorted(), "{}: starts of {}", effect.id, parameter.name);
                assert!(values.iter().all(|value| (parameter.min..=parameter.max).contains(value)));
            }
        }
    }

    #[test]
    fn every_linear_parameter_has_its_column_and_the_torque_is_their_sum() {
        let sample = Sample::new();
        for effect in addable() {
            let columns = effect.columns(&sample.motion(), 1, &shape(effect)).unwrap();
            assert_eq!(columns.len(), effect.linear().count(), "{}", effect.id);
            for (index, column) in columns.iter().enumerate() {
                let torque_with = |value: f64| {
                    let mut parameters = vec![0.7; columns.len()];
                    parameters[index] = value;
                    parameters.extend(shape(effect));
                    effect.torque(&sample.motion(), 1, &parameters).unwrap()
                };
                let (low, high) = (torque_with(0.2), torque_with(1.2));
                let mut derivative = vec![vec![0.0; sample.trajectory.len()]; 3];
                for (joint, values) in &column.parts {
                    assert_eq!(values.len(), sample.trajectory.len(), "{}", effect.id);
                    derivative[*joint].clone_from(values);
                }
                for joint in 0..3 {
                    for t in 0..sample.trajectory.len() {
                        let slope = high[joint][t] - low[joint][t];
                        assert!((slope - derivative[joint][t]).abs() < 1e-9, "{}: {slope}", effect.id);
                    }
                }
            }
        }
    }

    #[test]
    fn effects_say_whether_they_depend_on_the_load() {
        let sample = Sample::new();
        for effect in addable() {
            let without = effect.columns(&Motion { load: None, ..sample.motion() }, 1, &shape(effect));
            assert_eq!(without.is_err(), effect.facts.depends_on_load, "{}", effect.id);
        }
    }

    #[test]
    fn faults_of_readings_have_their_effect_and_no_columns() {
        let sample = Sample::new();
        for kind in [FaultKind::Stuck, FaultKind::Saturated] {
            let effect = of_fault(kind).unwrap();
            assert_eq!(effect.fault(), Some(kind));
            assert_eq!(effect.columns(&sample.motion(), 1, &[]).unwrap_err().lack, Lack::InReadings);
            assert!(effect.check_addable().unwrap_err().to_string().contains("nothing to add"));
        }
    }

    #[test]
    fn look_alikes_exist_and_look_alike_both_ways() {
        for effect in ALL {
            for others in effect.facts.look_alikes {
                assert!(!others.effects.is_empty() && others.told_by.ends_with('.'), "{}", effect.id);
                for id in others.effects {
                    let other = find(id).unwrap();
                    assert!(other.id != effect.id && other.scope == effect.scope, "{}", effect.id);
                }
                if let [id] = others.effects {
                    let back = find(id).unwrap().facts.look_alikes;
                    assert!(
                        back.iter().any(|others| others.effects == [effect.id]),
                        "{id} does not name {}",
                        effect.id
                    );
                }
            }
            let is_sought = sought().iter().any(|sought| sought.id == effect.id);
            let expected = effect.fault().is_none() && effect.id != "asymmetric-friction";
            assert_eq!(is_sought, expected, "{}", effect.id);
        }
    }

    #[test]
    fn names_in_facts_exist_and_sides_are_two() {
        for effect in ALL {
            let formerly = effect.facts.formerly.map(|id| find(id).unwrap());
            assert!(formerly.is_none_or(|elder| elder.family == effect.family && elder != *effect), "{}", effect.id);
            for id in effect.facts.also_said_as.iter().chain(effect.facts.goes_with) {
                assert_ne!(find(id).unwrap().family, effect.family, "{}: {id} is its form already", effect.id);
            }
            let other = effect.facts.other_side.map(|id| find(id).unwrap());
            assert_eq!(other.is_some(), effect.facts.encoder.is_some(), "{}", effect.id);
            if let Some(other) = other {
                assert!(other.facts.encoder != effect.facts.encoder && other.family == effect.family, "{}", effect.id);
                assert_eq!(other.facts.other_side, Some(effect.id));
            }
        }
    }

    #[test]
    fn what_an_effect_includes_exists_and_is_among_its_columns() {
        let sample = Sample::new();
        for effect in addable() {
            let columns = effect.columns(&sample.motion(), 1, &shape(effect)).unwrap();
            for id in effect.facts.includes {
                let part = find(id).unwrap();
                assert_ne!(part.id, effect.id);
                for column in part.columns(&sample.motion(), 1, &shape(part)).unwrap() {
                    assert!(columns.contains(&column), "{} does not contain {id}", effect.id);
                }
            }
        }
    }
}
