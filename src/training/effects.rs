//! Effects beside a learned term: their columns, so that their parameters are trained together with the network.
//!
//! Shape parameters (a Stribeck velocity) are given and stay; the linear ones become the factors of
//! [`crate::model::learned::LearnedTerm::Columns`].

use super::data::Columns;
use crate::effect::{ParameterSpec, Scope};
use crate::model::terms::Setting;
use crate::model::{EffectTerm, ModelError};
use crate::recording::Trajectory;
use crate::signals::Signals;

/// One effect on one joint, or on the whole arm.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedEffect {
    /// Which and where.
    pub term: EffectTerm,
    /// Its shape parameters, in the order of its file.
    pub shape: Vec<f64>,
}

/// Names of all linear parameters, for [`crate::model::learned::LearnedTerm::Columns`]: one for each column.
pub fn names(effects: &[AddedEffect]) -> Vec<String> {
    let mut names = Vec::new();
    for AddedEffect { term, .. } in effects {
        let effect = term.effect;
        let title = |parameter: &'static ParameterSpec| match (effect.scope, term.joint) {
            (Scope::Joint | Scope::Pair, Some(joint)) => {
                format!("{} {}, joint {}", effect.id, parameter.name, joint + 1)
            }
            _ => format!("{} {}", effect.id, parameter.name),
        };
        names.extend(effect.linear().map(title));
    }
    names
}

/// The columns of all effects over one trajectory, for [`super::Samples::new`].
///
/// # Errors
/// [`ModelError::NotApplicable`] says which effect and what it lacks.
pub fn columns(effects: &[AddedEffect], setting: &Setting, trajectory: &Trajectory) -> Result<Columns, ModelError> {
    let (joints, samples) = (trajectory.joint_count(), trajectory.len());
    if effects.is_empty() {
        return Ok(Columns::new());
    }
    let load = setting.load(trajectory);
    let mut all = Columns::new();
    for AddedEffect { term, shape } in effects {
        for column in term.columns(setting, trajectory, load.as_ref(), shape)? {
            let mut torque = Signals::zeros(joints, samples);
            column.add_to(&mut torque, 1.0);
            all.push(torque);
        }
    }
    Ok(all)
}
