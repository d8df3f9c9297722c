//! What a model is called: a short name from its terms, until somebody gives it another one; in a session no two have the same.

use crate::effect::Effect;
use crate::model::learned::{Layers, LearnedPreset, LearnedTerm};
use crate::model::{Model, Preset, RigidBody, Term};

/// With more effects than this only the first two are named.
const MOST_EFFECTS: usize = 3;
/// Longest name that can be given \[letters\].
pub(super) const LONGEST: usize = 60;

/// The name of a model by its terms: `structured DeLaN`, `rigid body + Coulomb 1, 2`.
///
/// ```
/// use torquescope::effect::registry;
/// use torquescope::model::{Model, RigidBody, Term};
/// use torquescope::session::default_name;
///
/// let body = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] };
/// let repaired = body.with_effect(registry::find("coulomb-friction")?, &[0, 1])?;
/// assert_eq!(default_name(&repaired), "rigid body + Coulomb 1, 2");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn default_name(model: &Model) -> String {
    let mut effects: Vec<(&Effect, Vec<usize>)> = Vec::new();
    for term in model.effects() {
        let place = effects.iter().position(|(known, _)| *known == term.effect);
        let place = place.unwrap_or_else(|| {
            effects.push((term.effect, Vec::new()));
            effects.len() - 1
        });
        effects[place].1.extend(term.joint);
    }
    let mut parts = vec![base(model)];
    let named = if effects.len() > MOST_EFFECTS { MOST_EFFECTS - 1 } else { effects.len() };
    parts.extend(effects[..named].iter().map(|(effect, joints)| short(effect, joints)));
    if named < effects.len() {
        parts.push(format!("{} more", effects.len() - named));
    }
    parts.join(" + ")
}

/// This name, or with the first number behind it that makes it unlike all others.
pub(super) fn unique<'a>(name: &str, taken: impl IntoIterator<Item = &'a str>) -> String {
    let taken: Vec<&str> = taken.into_iter().collect();
    let numbered = |number: usize| if number == 1 { name.to_owned() } else { format!("{name} ({number})") };
    let free = (1..).map(numbered).find(|name| !taken.contains(&name.as_str()));
    free.unwrap_or_else(|| name.to_owned())
}

/// What the effects are added to.
fn base(model: &Model) -> String {
    let terms: Vec<&Term> = model.terms.iter().filter(|term| !matches!(term, Term::Effect(_))).collect();
    let labels = || terms.iter().map(|term| term.label());
    match terms.as_slice() {
        [Term::RigidBody(RigidBody::Identified)] => Preset::RigidBody.title().to_owned(),
        [Term::RigidBody(RigidBody::Stated(_))] | [Term::RigidBody(RigidBody::Stated(_)), Term::Resistance(_)] => {
            Preset::StatedArm.title().to_owned()
        }
        _ => {
            let is_of = |preset: &LearnedPreset| {
                let architecture = preset.architecture(1, &Layers::default());
                architecture.terms.iter().map(|term| term.kind().to_owned()).eq(labels())
            };
            let preset = LearnedPreset::ALL.into_iter().find(is_of);
            let name =
                preset.map_or_else(|| labels().collect::<Vec<_>>().join(" + "), |preset| preset.title().to_owned());
            let is_free =
                |term: &&Term| matches!(term, Term::Learned(LearnedTerm::StructuredLagrangian { positive: None, .. }));
            if terms.iter().any(is_free) { format!("{name}, any H") } else { name }
        }
    }
}

/// `Coulomb 1, 2`: friction is what most effects are, so its name goes without saying.
fn short(effect: &Effect, joints: &[usize]) -> String {
    let name = effect.name.strip_suffix(" friction").unwrap_or(effect.name);
    match joints {
        [] => name.to_owned(),
        _ => format!("{name} {}", numbers(joints)),
    }
}

/// `1, 2` or `1–4, 6`, counted from 1.
fn numbers(joints: &[usize]) -> String {
    let mut joints = joints.to_vec();
    joints.sort_unstable();
    let mut texts: Vec<String> = Vec::new();
    for run in joints.chunk_by(|one, next| one + 1 == *next) {
        match run {
            [first, .., last] if run.len() > 2 => texts.push(format!("{}–{}", first + 1, last + 1)),
            _ => texts.extend(run.iter().map(|joint| (joint + 1).to_string())),
        }
    }
    texts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::registry;

    #[test]
    fn a_name_is_short_and_says_what_the_model_adds_up() {
        let body = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] };
        let with =
            |model: &Model, id: &str, joints: &[usize]| model.with_effect(registry::find(id).unwrap(), joints).unwrap();
        assert_eq!(default_name(&body), "rigid body");
        let rubbed = with(&with(&body, "coulomb-friction", &[0, 1, 2, 4]), "base-tilt", &[]);
        assert_eq!(default_name(&rubbed), "rigid body + Coulomb 1–3, 5 + base tilt");
        let more = with(&with(&rubbed, "viscous-friction", &[0]), "torque-offset", &[1]);
        assert_eq!(default_name(&more), "rigid body + Coulomb 1–3, 5 + base tilt + 2 more");
        for preset in LearnedPreset::ALL {
            let terms = preset.architecture(2, &Layers::default()).terms.into_iter().map(Term::Learned);
            assert_eq!(default_name(&Model { terms: terms.collect() }), preset.title());
        }
    }

    #[test]
    fn a_name_that_is_taken_gets_a_number() {
        assert_eq!(unique("rigid body", []), "rigid body");
        assert_eq!(unique("rigid body", ["rigid body", "rigid body (2)"]), "rigid body (3)");
    }
}
