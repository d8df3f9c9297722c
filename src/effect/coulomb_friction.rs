use super::*;

/// Friction of constant size against the motion.
pub static EFFECT: Effect = Effect {
    id: "coulomb-friction",
    name: "Coulomb friction",
    formula: "tau = tau_c * sign(qd)",
    typeset: r"\tau = \tau_c \,\mathrm{sign}(\dot q)",
    description: "Dry friction in bearings, seals and gears. Its size does not depend on the speed; its direction does.",
    fingerprint: "Residual against velocity: a step of twice the friction torque at zero velocity, flat on both sides.",
    absorbed: "Nothing: a Lagrangian is conservative. A different friction torque in each direction adds a torque offset.",
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013",
    stage: Stage::Body(&CoulombFriction),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0)],
    facts: Facts { everyday: true, ..Facts::USUAL },
};

struct CoulombFriction;

impl AddsTorque for CoulombFriction {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![motion.coulomb(joint)])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["direction"], &[])
    }
}

/// −1, 0 or 1: unlike `f64::signum` it is 0 at 0, where dry friction has no direction.
pub fn sign(velocity: f64) -> f64 {
    if velocity == 0.0 { 0.0 } else { velocity.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula_and_nothing_at_rest() {
        testing::assert_is(&EFFECT, &[1.7], |_, qd, _| match qd {
            0.0 => 0.0,
            qd if qd > 0.0 => 1.7,
            _ => -1.7,
        });
        assert_eq!([-2.0, -0.0, 0.0, 1e-9].map(sign), [-1.0, 0.0, 0.0, 1.0]);
    }
}
