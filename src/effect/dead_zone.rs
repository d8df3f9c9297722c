use super::coulomb_friction::sign;
use super::*;

/// Torque that is lost before the actuator answers.
pub static EFFECT: Effect = Effect {
    id: "dead-zone",
    name: "dead zone",
    formula: "tau = delta * sign(tau_load)",
    typeset: r"\tau = \delta\,\mathrm{sign}(\tau_{\mathrm{load}})",
    description: "A command below delta moves nothing: the commanded torque is larger than what arrives by delta, \
                  whatever its size.",
    fingerprint: "Residual against the torque that the model predicts: a step at zero.",
    absorbed: "Gravity absorbs part of it where the torque changes its sign only with the position.",
    source: "Tao and Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996",
    stage: Stage::Body(&DeadZone),
    family: Family::Elasticity,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("dead_torque", "δ", Dimension::Torque).at_least(0.0)],
    facts: Facts { depends_on_load: true, ..Facts::USUAL },
};

struct DeadZone;

impl AddsTorque for DeadZone {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let load = &motion.load()?.torque[joint];
        Ok(vec![Column::on_joint(joint, load.iter().map(|&load| sign(load)))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["sign(tau_load)"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_depends_on_load(&EFFECT, &[0.5], |load, _, _| 0.5 * sign(load));
    }
}
