//! Effects beside a learned term: their columns, so that their parameters are trained together with the network.
//!
//! Shape parameters (a Stribeck velocity) are given and stay; the linear ones become the factors of
//! [`crate::model::learned::LearnedTerm::Columns`].

use super::TrainError;
use super::data::Columns;
use crate::effect::{self, Motion, registry};
use crate::model::terms::Setting;
use crate::recording::Trajectory;

/// One effect on one joint, or on the whole arm.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedEffect {
    /// Its id in the registry.
    pub effect: String,
    /// The joint, from 0; ignored by effects of the whole arm.
    pub joint: usize,
    /// Its shape parameters, in the order of its file.
    pub shape: Vec<f64>,
}

/// Names of all linear parameters, for [`crate::model::learned::LearnedTerm::Columns`]: one for each column.
///
/// # Errors
/// [`TrainError::UnknownEffect`]
pub fn names(effects: &[AddedEffect]) -> Result<Vec<String>, TrainError> {
    let mut names = Vec::new();
    for added in effects {
        let spec = registry::find(&added.effect)?.spec();
        let title = |parameter: &'static effect::ParameterSpec| match spec.scope {
            effect::Scope::Joint | effect::Scope::Pair => {
                format!("{} {}, joint {}", spec.id, parameter.name, added.joint + 1)
            }
            effect::Scope::Arm => format!("{} {}", spec.id, parameter.name),
        };
        names.extend(spec.linear().map(title));
    }
    Ok(names)
}

/// The columns of all effects over one trajectory, for [`super::Samples::new`].
///
/// # Errors
/// [`TrainError::UnknownEffect`] and [`TrainError::NotApplicable`] say which effect and what it lacks.
pub fn columns(effects: &[AddedEffect], setting: &Setting, trajectory: &Trajectory) -> Result<Columns, TrainError> {
    let (joints, samples) = (trajectory.joint_count(), trajectory.len());
    if effects.is_empty() {
        return Ok(Columns::new());
    }
    let load = setting.load(trajectory);
    let motion = Motion { load: load.as_ref(), ..setting.motion(trajectory) };
    let mut all = Columns::new();
    for added in effects {
        for column in registry::find(&added.effect)?.columns(&motion, added.joint, &added.shape)? {
            let mut torque = vec![vec![0.0; samples]; joints];
            for (joint, values) in column.parts {
                torque[joint] = values;
            }
            all.push(torque);
        }
    }
    Ok(all)
}
