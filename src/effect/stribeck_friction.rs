use super::*;

/// Coulomb friction that is larger near standstill.
pub static EFFECT: Effect = Effect {
    id: "stribeck-friction",
    name: "Stribeck friction",
    formula: "tau = (tau_c + tau_s * exp(-(qd / v_s)^2)) * sign(qd)",
    typeset: r"\tau = \left(\tau_c + \tau_s\, e^{-(\dot q/v_s)^2}\right)\mathrm{sign}(\dot q)",
    description: "Dry friction that falls from its break-away value to the Coulomb level as a lubricant film builds up with \
                  speed. It contains Coulomb friction (tau_c).",
    fingerprint: "Residual against velocity: a step as for Coulomb friction with a peak on either side of zero velocity.",
    absorbed: "Nothing: a Lagrangian is conservative. With no slow motion in the data it looks like Coulomb friction.",
    source: "Li, Wu, Chen, Sun, Mathematics 12 (2024) 2527, eq. 12; Bittencourt and Gunnarsson (2012)",
    stage: Stage::Body(&StribeckFriction),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0),
        ParameterSpec::linear("stribeck_torque", "τ_s", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("stribeck_velocity", "v_s", Dimension::Velocity, &[0.02, 0.05, 0.1, 0.2, 0.4, 0.8])
            .between(1e-3, 10.0),
    ],
    facts: Facts { everyday: true, learned_friction: true, includes: &["coulomb-friction"], ..Facts::USUAL },
};

struct StribeckFriction;

impl AddsTorque for StribeckFriction {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![
            motion.coulomb(joint),
            Column::on_joint(
                joint,
                qd.iter().map(|&qd| (-(qd / shape[0]).powi(2)).exp() * motion.direction(joint, qd)),
            ),
        ])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["direction", "exp(-(qd / v_s)^2) * direction"], &["v_s"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use testing::Sample;

    const VELOCITY: f64 = 0.3;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[1.1, 0.6, VELOCITY], |_, qd, _| {
            (1.1 + 0.6 * (-qd * qd / (VELOCITY * VELOCITY)).exp()) * sign(qd)
        });
    }

    #[test]
    fn falls_from_break_away_to_the_coulomb_level() {
        let mut sample = Sample::new();
        sample.trajectory.channels_mut().qd[0][..4].copy_from_slice(&[1e-9, VELOCITY, 100.0, 0.0]);
        let torque = EFFECT.torque(&sample.motion(), 0, &[1.1, 0.6, VELOCITY]).unwrap();
        for (found, expected) in torque[0].iter().zip([1.7, 1.1 + 0.6 / std::f64::consts::E, 1.1, 0.0]) {
            assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
        }
    }

    /// What a search over the shape relies on: ∂τ/∂v_s = τ_s (2 q̇²/v_s³) exp(−(q̇/v_s)²) sign q̇.
    #[test]
    fn changes_smoothly_with_the_stribeck_velocity() {
        let sample = Sample::new();
        let step = 1e-6;
        let at = |velocity| EFFECT.torque(&sample.motion(), 1, &[1.1, 0.6, velocity]).unwrap();
        let (low, high) = (at(VELOCITY - step), at(VELOCITY + step));
        for (t, &qd) in sample.trajectory.qd[1].iter().enumerate() {
            let slope = (high[1][t] - low[1][t]) / (2.0 * step);
            let ratio = (qd / VELOCITY).powi(2);
            let expected = 0.6 * 2.0 * ratio / VELOCITY * (-ratio).exp() * sign(qd);
            assert!((slope - expected).abs() < 1e-6, "{slope} is not {expected}");
        }
    }
}
