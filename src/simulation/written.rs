//! Hidden effects as people write them in scenarios and experiments: an effect with its joints, counted from 1, and its
//! parameters, such as `{ effect = "viscous-friction@1,2", parameters = [0.8] }`.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::effect::place::Place;
use crate::recording::seal::HiddenEffect;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    effect: String,
    /// The form of earlier versions, which counted joints from 0.
    #[serde(default, skip_serializing)]
    joint: Option<usize>,
    parameters: Vec<f64>,
}

/// Each effect of one joint by itself.
pub(super) fn serialize<S: Serializer>(effects: &[HiddenEffect], serializer: S) -> Result<S::Ok, S::Error> {
    let written = effects.iter().map(|hidden| Written {
        effect: hidden.joint.map_or_else(|| hidden.effect.clone(), |joint| format!("{}@{}", hidden.effect, joint + 1)),
        joint: None,
        parameters: hidden.parameters.clone(),
    });
    serializer.collect_seq(written)
}

/// An effect with several joints becomes one on each of them, with the same parameters.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<HiddenEffect>, D::Error> {
    let mut effects = Vec::new();
    for Written { effect, joint, parameters } in Vec::<Written>::deserialize(deserializer)? {
        if let Some(joint) = joint {
            let new = format!("effect = \"{effect}@{}\"", joint + 1);
            return Err(Error::custom(format!(
                "`joint = {joint}` counts from 0, as files of earlier versions did: write `{new}` instead"
            )));
        }
        let Place { effect, joints } = effect.parse().map_err(Error::custom)?;
        let hidden = |joint| HiddenEffect { effect: effect.id.to_owned(), joint, parameters: parameters.clone() };
        match joints {
            None => effects.push(hidden(None)),
            Some(joints) => effects.extend(joints.into_iter().map(|joint| hidden(Some(joint)))),
        }
    }
    Ok(effects)
}

#[cfg(test)]
mod tests {
    use crate::simulation::Scenario;

    const ARM: &str = r#"{ "links": [{ "mass": 1.0, "length": 1.0, "com": 0.5, "inertia": 0.1 }] }"#;
    const MOTION: &str =
        r#"{ "kind": "paper-point-to-point", "trajectories": 2, "duration": 4.0, "samples": 50, "range": 3.0 }"#;

    fn scenario(effects: &str) -> Result<Scenario, serde_json::Error> {
        serde_json::from_str(&format!(r#"{{ "arm": {ARM}, "motion": {MOTION}, "effects": [{effects}] }}"#))
    }

    #[test]
    fn joints_are_counted_from_one_and_come_back() {
        let read = scenario(
            r#"{ "effect": "viscous-friction@1,3", "parameters": [0.8] }, { "effect": "base-tilt", "parameters": [0.1] }"#,
        )
        .unwrap();
        let places: Vec<_> = read.effects.iter().map(|hidden| (hidden.effect.as_str(), hidden.joint)).collect();
        assert_eq!(places, [("viscous-friction", Some(0)), ("viscous-friction", Some(2)), ("base-tilt", None)]);
        let written = serde_json::to_string(&read).unwrap();
        assert!(written.contains(r#"{"effect":"viscous-friction@3","parameters":[0.8]}"#), "{written}");
        assert_eq!(serde_json::from_str::<Scenario>(&written).unwrap(), read);
    }

    #[test]
    fn the_old_form_is_refused_with_the_new_one() {
        let old = r#"{ "effect": "viscous-friction", "joint": 0, "parameters": [0.8] }"#;
        let message = scenario(old).unwrap_err().to_string();
        assert!(message.contains(r#"write `effect = "viscous-friction@1"` instead"#), "{message}");
    }
}
