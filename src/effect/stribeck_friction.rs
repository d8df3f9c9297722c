use super::coulomb_friction::sign;
use super::*;

/// Coulomb friction that is larger near standstill.
pub struct StribeckFriction;

static SPEC: Spec = Spec {
    id: "stribeck-friction",
    name: "Stribeck friction",
    formula: "tau = (tau_c + tau_s * exp(-(qd / v_s)^2)) * sign(qd)",
    typeset: r"\tau = \left(\tau_c + \tau_s\, e^{-(\dot q/v_s)^2}\right)\mathrm{sign}(\dot q)",
    description: "Dry friction that falls from its break-away value to the Coulomb level as a lubricant film builds up with \
                  speed. It contains Coulomb friction (tau_c).",
    fingerprint: "Residual against velocity: a step as for Coulomb friction with a peak on either side of zero velocity.",
    absorbed: "Nothing: a Lagrangian is conservative. With no slow motion in the data it looks like Coulomb friction.",
    source: "Li, Wu, Chen, Sun, Mathematics 12 (2024) 2527, eq. 12; Bittencourt and Gunnarsson (2012)",
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec {
            name: "coulomb_torque",
            symbol: "τ_c",
            dimension: Dimension::Torque,
            min: 0.0,
            max: f64::INFINITY,
            role: Role::Linear,
        },
        ParameterSpec {
            name: "stribeck_torque",
            symbol: "τ_s",
            dimension: Dimension::Torque,
            min: 0.0,
            max: f64::INFINITY,
            role: Role::Linear,
        },
        ParameterSpec {
            name: "stribeck_velocity",
            symbol: "v_s",
            dimension: Dimension::Velocity,
            min: 1e-3,
            max: 10.0,
            role: Role::Shape { grid: &[0.02, 0.05, 0.1, 0.2, 0.4, 0.8] },
        },
    ],
    includes: &["coulomb-friction"],
};

impl Effect for StribeckFriction {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![
            Column::on_joint(joint, qd.iter().map(|&qd| sign(qd))),
            Column::on_joint(joint, qd.iter().map(|&qd| (-(qd / shape[0]).powi(2)).exp() * sign(qd))),
        ])
    }
}
