use super::coulomb_friction::sign;
use super::*;

/// Torque that is lost before the actuator answers.
pub struct DeadZone;

static SPEC: Spec = Spec {
    id: "dead-zone",
    name: "dead zone",
    formula: "tau = delta * sign(tau_load)",
    typeset: r"\tau = \delta\,\mathrm{sign}(\tau_{\mathrm{load}})",
    description: "A command below delta moves nothing: the commanded torque is larger than what arrives by delta, \
                  whatever its size.",
    fingerprint: "Residual against the torque that the model predicts: a step at zero.",
    absorbed: "Gravity absorbs part of it where the torque changes its sign only with the position.",
    look_alikes: &[],
    source: "Tao and Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996",
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[ParameterSpec {
        name: "dead_torque",
        symbol: "δ",
        dimension: Dimension::Torque,
        min: 0.0,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for DeadZone {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn depends_on_load(&self) -> bool {
        true
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let load = &motion.load(&SPEC)?.torque[joint];
        Ok(vec![Column::on_joint(joint, load.iter().map(|&load| sign(load)))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_depends_on_load(&DeadZone, &[0.5], |load, _, _| 0.5 * sign(load));
    }
}
