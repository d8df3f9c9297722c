//! A model held against the truth of a simulated recording, whose seal the user orders to be opened.

use anyhow::Context;
use serde::Serialize;

use super::progress;
use crate::effect::registry;
use crate::model::Fitted;
use crate::recording::Recording;
use crate::recording::seal::Truth;
use crate::session::{Command, Session};
use crate::training::components;

/// What the truth says of a model.
pub struct Comparison {
    /// Errors of inertial, Coriolis and gravity torque.
    pub components: Vec<ComponentError>,
    /// Parameters that are those of a hidden effect.
    pub parameters: Vec<ParameterError>,
}

/// Error of one component of the torque over all joints and trajectories.
#[derive(Serialize)]
pub struct ComponentError {
    /// Its name.
    pub component: &'static str,
    /// Σ‖error‖² / Σ‖truth‖²
    pub nmse: f64,
}

/// A parameter of the model beside that of the same name of an effect that was hidden on the same joint.
#[derive(Serialize)]
pub struct ParameterError {
    /// Its name.
    pub parameter: String,
    /// Counted from 1; `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// SI unit.
    pub unit: String,
    /// In the model.
    pub value: f64,
    /// In the simulation.
    pub truth: f64,
}

/// Opens the seal and compares.
pub fn compare(session: &Session, fitted: &Fitted) -> anyhow::Result<Comparison> {
    let opened = progress::run(Command::OpenSeal, session)?;
    let truth = opened.truth.as_deref().context("the recording has no seal")?;
    let recording = session.recording.as_deref().context("no recording was read")?;
    Ok(Comparison {
        components: component_errors(truth, recording, fitted)?,
        parameters: parameter_errors(truth, fitted)?,
    })
}

fn component_errors(truth: &Truth, recording: &Recording, fitted: &Fitted) -> anyhow::Result<Vec<ComponentError>> {
    let mut errors = [("inertial", 0.0, 0.0), ("coriolis", 0.0, 0.0), ("gravity", 0.0, 0.0)];
    for trajectory in &recording.trajectories {
        let parts = truth.arm.components_along(&trajectory.q, &trajectory.qd, &trajectory.qdd);
        let own = components(fitted, trajectory)?;
        for ((name, error, energy), exact) in errors.iter_mut().zip([parts.inertial, parts.coriolis, parts.gravity]) {
            let Some((_, estimate)) = own.iter().find(|(other, _)| other == name) else { continue };
            for (exact, estimate) in exact.iter().flatten().zip(estimate.iter().flatten()) {
                *error += (exact - estimate).powi(2);
                *energy += exact * exact;
            }
        }
    }
    let ratio = |(component, error, energy)| ComponentError { component, nmse: error / energy };
    Ok(errors.map(ratio).into_iter().collect())
}

fn parameter_errors(truth: &Truth, fitted: &Fitted) -> anyhow::Result<Vec<ParameterError>> {
    let mut errors = Vec::new();
    for hidden in &truth.effects {
        for (spec, value) in registry::find(&hidden.effect)?.parameters.iter().zip(&hidden.parameters) {
            let is_same = |own: &&crate::model::Parameter| own.name == spec.name && own.joint == hidden.joint;
            errors.extend(fitted.parameters.iter().find(is_same).map(|own| ParameterError {
                parameter: own.name.clone(),
                joint: own.joint.map(|joint| joint + 1),
                unit: own.unit.clone(),
                value: own.value,
                truth: *value,
            }));
        }
    }
    Ok(errors)
}
