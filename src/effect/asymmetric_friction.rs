use super::*;

/// Dry friction that is larger in one direction than in the other.
pub static EFFECT: Effect = Effect {
    id: "asymmetric-friction",
    name: "asymmetric Coulomb friction",
    formula: "tau = tau_c * sign(qd) + tau_a for qd != 0",
    typeset: r"\tau = \tau_c\,\mathrm{sign}(\dot q) + \tau_a,\quad \dot q \neq 0",
    description: "A seal lip, a brush or a worn gear that rubs with tau_c + tau_a forward and tau_c - tau_a backward.",
    fingerprint: "Residual against velocity: a step at zero whose two sides are not equally far from zero.",
    absorbed: "Nothing, but where gravity or a sensor offset is free too, they take tau_a.",
    source: "Simoni et al., Robotica, 10.1017/S0263574717000509",
    stage: Stage::Body(&AsymmetricFriction),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0),
        ParameterSpec::linear("asymmetry_torque", "τ_a", Dimension::Torque),
    ],
    facts: Facts {
        includes: &["coulomb-friction"],
        look_alikes: &[LookAlike {
            effects: &["coulomb-friction", "torque-offset"],
            told_by: "Standstill in a known direction: an offset stays, friction does not.",
        }],
        goes_with: &["torque-offset"], // it is the same friction with an offset
        ..Facts::USUAL
    },
};

struct AsymmetricFriction;

impl AddsTorque for AsymmetricFriction {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![motion.coulomb(joint), Column::on_joint(joint, qd.iter().map(|&qd| motion.direction(joint, qd).abs()))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["direction", "abs(direction)"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula_and_nothing_at_rest() {
        testing::assert_is(&EFFECT, &[1.7, -0.4], |_, qd, _| match qd {
            0.0 => 0.0,
            qd if qd > 0.0 => 1.3,
            _ => -2.1,
        });
    }
}
