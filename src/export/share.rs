//! How much of the torque a part of a model is.

use crate::model::property::Property;
use crate::model::{Fitted, ModelError, Term};
use crate::recording::Recording;

/// RMS of the torque of a term over that which was measured, along a recording, on the joints on which it acts; of one linear
/// parameter of an effect alone, if its place is named.
///
/// # Errors
/// [`ModelError`] if the term can't be computed.
pub fn of_torque(
    fitted: &Fitted,
    recording: &Recording,
    term: usize,
    parameter: Option<usize>,
) -> Result<f64, ModelError> {
    let (mut own, mut whole) = (0.0, 0.0);
    for trajectory in &recording.trajectories {
        let parts = match (&fitted.model.terms[term], parameter) {
            (Term::Effect(placed), Some(place)) => {
                let load = fitted.setting().load(trajectory);
                let columns = placed.columns(fitted.setting(), trajectory, load.as_ref(), &fitted.shapes()[term])?;
                let factor = fitted.linear_of(term)[place];
                let scaled = |values: &Vec<f64>| values.iter().map(|value| factor * value).collect::<Vec<f64>>();
                columns[place].parts.iter().map(|(joint, values)| (*joint, scaled(values))).collect::<Vec<_>>()
            }
            _ => {
                let torque = &fitted.predict(trajectory)?.terms[term];
                let acts = torque.iter().enumerate().filter(|(_, values)| values.iter().any(|value| *value != 0.0));
                acts.map(|(joint, values)| (joint, values.to_vec())).collect()
            }
        };
        for (joint, values) in parts {
            own += energy(&values);
            whole += energy(&trajectory.tau[joint]);
        }
    }
    Ok(beside(own, whole))
}

/// The same of a plain property of a joint.
pub(super) fn of_property(recording: &Recording, joint: usize, property: Property, value: f64) -> f64 {
    let (mut own, mut whole) = (0.0, 0.0);
    for trajectory in &recording.trajectories {
        whole += energy(&trajectory.tau[joint]);
        own += value
            * value
            * match property {
                Property::Damping => energy(&trajectory.qd[joint]),
                Property::Armature => energy(&trajectory.qdd[joint]),
                Property::Stiffness => energy(&trajectory.q[joint]),
                Property::Friction | Property::Preload => trajectory.len() as f64,
            };
    }
    beside(own, whole)
}

fn energy(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

fn beside(own: f64, whole: f64) -> f64 {
    if whole > 0.0 { (own / whole).sqrt() } else { 0.0 }
}
