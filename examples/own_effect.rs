//! An effect of one's own, hidden in the torque of an arm, found by the diagnosis and added to the model:
//!
//!     cargo run --release --example own_effect
//!
//! To give it to everybody, its file goes into `src/effect/` and its name into the registry there: see CONTRIBUTING.md.

use torquescope::diagnosis::diagnose_among;
use torquescope::effect::registry;
use torquescope::effect::{
    AddsTorque, Axis, Column, Dimension, Effect, Facts, Family, Lack, Motion, ParameterSpec, Scope, Stage,
};
use torquescope::model;
use torquescope::prelude::*;

/// Damping with the cube of the velocity, as of a magnetic brake far below its critical speed.
static CUBIC_DAMPING: Effect = Effect {
    id: "cubic-damping",
    name: "cubic damping",
    formula: "tau = c * qd^3",
    typeset: r"\tau = c\, \dot q^3",
    description: "A torque against the motion that grows with the cube of its speed.",
    fingerprint: "Residual against velocity: flat at low speed, steep at either end.",
    absorbed: "Nothing: a Lagrangian is conservative.",
    source: "an example",
    stage: Stage::Body(&CubicDamping),
    family: Family::SpeedFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("cubic_damping", "c", Dimension::Torque).at_least(0.0)],
    facts: Facts::USUAL,
};

struct CubicDamping;

impl AddsTorque for CubicDamping {
    /// The torque that c = 1 makes.
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.qd[joint].iter().map(|qd| qd.powi(3)))])
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let monitor = Monitor::new();
    // An arm of three joints without any effect; the second gets ours.
    let mut recording = simulate(&Scenario { effects: Vec::new(), ..Scenario::embedded() }, &monitor)?;
    for trajectory in &mut recording.trajectories {
        let qd = trajectory.qd[1].to_vec();
        for (tau, qd) in trajectory.channels_mut().tau[1].iter_mut().zip(qd) {
            *tau += 0.4 * qd.powi(3);
        }
    }
    let split = Split::automatic(&recording);
    let body = model::fit(&Preset::RigidBody.model(&recording)?, &recording, &split, &monitor)?;

    // The candidates are the whole catalogue, and ours.
    let candidates = [registry::sought(), vec![&CUBIC_DAMPING]].concat();
    let report = diagnose_among(&candidates, &body, &recording, &split, &monitor)?;
    for named in &report.effects {
        println!("{} on {}: {:.0} %", named.effect.name, joints_text(&named.joints), 100.0 * named.presence);
    }

    let repaired = model::fit(&body.model.with_effect(&CUBIC_DAMPING, &[1])?, &recording, &split, &monitor)?;
    for (title, fitted) in [("rigid body", &body), ("with cubic damping", &repaired)] {
        let nmse = Evaluation::of(fitted, &recording, &split)?.held_out_nmse();
        println!("{title}: held-out nMSE by joint {nmse:?}");
    }
    let found = repaired.parameters.iter().find(|parameter| parameter.name == "cubic_damping");
    println!("c = {:.4} of 0.4", found.ok_or("it was not fitted")?.value);
    Ok(())
}
