//! A fitted model as a file: JSON, with a version, readable by people.

use serde::{Deserialize, Serialize};

use super::terms::Alteration;
use super::{EffectTerm, Fitted, Model, ModelError, RigidBody, Term};
use crate::arm::MOST_JOINTS;
use crate::arm::stated::StatedArm;
use crate::effect::Scope;
use crate::effect::own::{self, OwnEffectError};

/// Written into every file; a file of another version is refused.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    /// The version; the key says what the file is.
    torquescope_model: u32,
    /// The files of effects of one's own that are in it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    own_effects: Vec<String>,
    fitted: Fitted,
}

/// The text is not a model that this program can read.
#[derive(Debug, thiserror::Error)]
pub enum ModelFileError {
    /// Another version.
    #[error(
        "the model file has version {0}, this program reads version {VERSION}: use the program that wrote it, or train again"
    )]
    Version(u64),
    /// Not a model at all.
    #[error(
        "this is not a model file (it has no key `torquescope_model`): make one with `torquescope train FILE -o model.json`"
    )]
    NotAModel,
    /// Damaged.
    #[error("the model file is damaged: {0} (line {line}, column {column}): train again", line = .0.line(), column = .0.column())]
    Damaged(#[from] serde_json::Error),
    /// An effect of one's own that it brings along.
    #[error("an effect of one's own in the model file: {0}")]
    OwnEffect(#[from] OwnEffectError),
    /// The parts do not fit together.
    #[error("the model file is damaged: it holds {found} factors, its terms need {needed}: train again")]
    Factors {
        /// In the file.
        found: usize,
        /// By its terms.
        needed: usize,
    },
    /// The terms have not as many shape parameters as their effects.
    #[error("the model file is damaged: it holds {found:?} shape parameters, its terms need {needed:?}: train again")]
    Shapes {
        /// Of each term, in the file.
        found: Vec<usize>,
        /// Of each term, by its effect.
        needed: Vec<usize>,
    },
    /// A parameter belongs to a term or joint that is not there.
    #[error("the model file is damaged: its parameter `{0}` belongs to a term or joint that is not there: train again")]
    Parameter(String),
    /// What it was told of its recording does not fit its joints.
    #[error("the model file is damaged: its {0} does not fit its joints: train again")]
    Setting(&'static str),
    /// The terms can't be those of its joints.
    #[error("the model file is damaged: {0}: train again")]
    Terms(#[from] ModelError),
}

/// Loads the effects of one's own that a file brings along under the key `own_effects`: before anything in it that has one
/// by its id can be read.
///
/// # Errors
/// [`OwnEffectError`] if one is damaged, or is another one than that which is in use.
pub fn load_own_effects(file: &serde_json::Value) -> Result<(), OwnEffectError> {
    let texts = file.get("own_effects").and_then(serde_json::Value::as_array);
    texts.into_iter().flatten().filter_map(serde_json::Value::as_str).try_for_each(|text| own::load(text).map(|_| ()))
}

impl Model {
    /// The files of effects of one's own that are in it.
    pub fn own_effects(&self) -> Vec<String> {
        own::texts(self.effects().map(|term| term.effect))
    }
}

impl Fitted {
    /// The model as text.
    pub fn to_json(&self) -> String {
        let file =
            ModelFile { torquescope_model: VERSION, own_effects: self.model.own_effects(), fitted: self.clone() };
        serde_json::to_string_pretty(&file).expect("numbers and texts always have a JSON form")
    }

    /// A model from text.
    ///
    /// # Errors
    /// [`ModelFileError`] says what is wrong and where.
    pub fn from_json(text: &str) -> Result<Fitted, ModelFileError> {
        let value: serde_json::Value = serde_json::from_str(text)?;
        match value.get("torquescope_model").and_then(serde_json::Value::as_u64) {
            None => Err(ModelFileError::NotAModel),
            Some(version) if version != u64::from(VERSION) => Err(ModelFileError::Version(version)),
            Some(_) => {
                load_own_effects(&value)?;
                let ModelFile { fitted, .. } = serde_json::from_str(text)?;
                check_whole(&fitted)?;
                Ok(fitted)
            }
        }
    }
}

/// Whether the parts of a model are those of its terms and joints.
fn check_whole(fitted: &Fitted) -> Result<(), ModelFileError> {
    let (terms, joints) = (&fitted.model.terms, fitted.setting().kinds.len());
    check_setting(fitted)?;
    let (needed, found) = (fitted.model.factors(fitted.setting())?.len(), fitted.factor_count());
    if found != needed {
        return Err(ModelFileError::Factors { found, needed });
    }
    let found: Vec<usize> = fitted.shapes().iter().map(Vec::len).collect();
    let shapes_of = |(number, term): (usize, &Term)| match term {
        // The value at which its column was taken, once one was found.
        Term::Effect(term) if term.effect.changes_others() => found.get(number).map_or(0, |count| (*count).min(1)),
        Term::Effect(term) => term.effect.shapes().count(),
        Term::RigidBody(_) | Term::Resistance(_) | Term::Learned(_) => 0,
    };
    let needed: Vec<usize> = terms.iter().enumerate().map(shapes_of).collect();
    if found != needed {
        return Err(ModelFileError::Shapes { found, needed });
    }
    let is_there = |parameter: &&super::Parameter| {
        parameter.term < terms.len() && parameter.joint.is_none_or(|joint| joint < joints)
    };
    match fitted.parameters.iter().find(|parameter| !is_there(parameter)) {
        Some(parameter) => Err(ModelFileError::Parameter(parameter.name.clone())),
        None => Ok(()),
    }
}

/// Whether what the terms were told of the recording fits its joints.
fn check_setting(fitted: &Fitted) -> Result<(), ModelFileError> {
    let setting = fitted.setting();
    let joints = setting.kinds.len();
    if !(1..=MOST_JOINTS).contains(&joints) {
        return Err(ModelError::JointCount { joints }.into());
    }
    let terms = || fitted.model.terms.iter();
    let stated = terms().filter_map(|term| match term {
        Term::RigidBody(RigidBody::Stated(arm)) => Some(arm),
        _ => None,
    });
    let mut resistances = terms().filter_map(|term| match term {
        Term::Resistance(stated) => Some(stated),
        _ => None,
    });
    let own = setting.arm.clone().map(StatedArm::Planar);
    let body_factors = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] }.factors(setting)?.len();
    let is_placed = |term: &EffectTerm| {
        let least = usize::from(term.effect.scope == Scope::Pair);
        term.joint.map_or(term.effect.scope == Scope::Arm, |joint| (least..joints).contains(&joint))
    };
    let is_whole =
        |other: &Alteration| is_placed(&other.term) && other.linear.len() == other.term.effect.linear().count();
    let fits = [
        ("stated arm", stated.chain(&own).all(|arm| arm.can_be_of(joints))),
        (
            "stated resistance",
            resistances.all(|stated| stated.len() == joints)
                && (setting.resistances.is_empty() || setting.resistances.len() == joints),
        ),
        ("chain", setting.chain.as_ref().is_none_or(|chain| chain.check_for(joints).is_ok())),
        ("rigid body", setting.body.as_ref().is_none_or(|factors| factors.len() == body_factors)),
        ("list of effects", fitted.model.effects().all(is_placed) && setting.alterations.iter().all(is_whole)),
    ];
    fits.into_iter().find(|(_, fits)| !fits).map_or(Ok(()), |(what, _)| Err(ModelFileError::Setting(what)))
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::effect::registry;
    use crate::model::{Preset, fit};
    use crate::progress::Monitor;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// The places of all lists in a value, as JSON pointers.
    fn lists(value: &Value, place: &str, all: &mut Vec<String>) {
        match value {
            Value::Array(items) => {
                all.push(place.to_owned());
                items.iter().enumerate().for_each(|(number, item)| lists(item, &format!("{place}/{number}"), all));
            }
            Value::Object(fields) => {
                fields.iter().for_each(|(name, field)| lists(field, &format!("{place}/{name}"), all));
            }
            _ => (),
        }
    }

    /// A model whose lists were cut or grew is refused, or predicts what it can; it never ends the program.
    #[test]
    fn a_model_with_lists_of_another_length_is_refused_or_works() {
        let motion = Excitation::PaperPointToPoint { trajectories: 4, duration: 4.0, samples: 60, range: 2.0 };
        let recording = simulate(&Scenario { motion, ..Scenario::embedded() }, &Monitor::new()).unwrap();
        let mut model = Preset::RigidBody.model(&recording).unwrap();
        for (id, joint) in [
            ("stribeck-friction", 0),
            ("load-friction", 1),
            ("torque-coupling", 2),
            ("actuator-lag", 0),
            ("derivative-delay", 0),
        ] {
            model = model.with_effect(registry::find(id).unwrap(), &[joint]).unwrap();
        }
        let fitted = fit(&model, &recording, &Split::automatic(&recording), &Monitor::new()).unwrap();
        // Effects that change what others do keep the value at which their columns were taken.
        assert!(fitted.shapes()[4..].iter().all(|found| found.len() == 1), "{:?}", fitted.shapes());
        assert_eq!(Fitted::from_json(&fitted.to_json()).unwrap().shapes(), fitted.shapes());
        let whole: Value = serde_json::from_str(&fitted.to_json()).unwrap();
        let mut all = Vec::new();
        lists(&whole, "", &mut all);
        assert!(all.contains(&"/fitted/shapes".to_owned()), "{all:?}");
        let changes: [fn(&mut Vec<Value>); 3] =
            [Vec::clear, |list| drop(list.pop()), |list| list.extend(list.first().cloned())];
        let mut refused = 0;
        for place in &all {
            for change in changes {
                let mut damaged = whole.clone();
                change(damaged.pointer_mut(place).and_then(Value::as_array_mut).unwrap());
                match Fitted::from_json(&damaged.to_string()) {
                    Ok(fitted) => drop(fitted.predict(&recording.trajectories[0])),
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > all.len(), "{refused} of {} lists", all.len());
        let mut empty = whole.clone();
        *empty.pointer_mut("/fitted/shapes").unwrap() = Value::Array(Vec::new());
        let error = Fitted::from_json(&empty.to_string()).unwrap_err();
        assert!(matches!(error, ModelFileError::Shapes { .. }) && error.to_string().contains("train again"), "{error}");
    }
}
