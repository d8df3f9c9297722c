use super::*;

/// A constant error of the torque reading.
pub struct TorqueOffset;

static SPEC: Spec = Spec {
    id: "torque-offset",
    name: "torque offset",
    formula: "tau = tau_0",
    typeset: r"\tau = \tau_0",
    description: "A zero error of the torque sensor or of the motor current.",
    fingerprint: "Residual against anything: flat, but not at zero.",
    absorbed: "Nothing, unless a joint hardly moves: then it looks like gravity.",
    look_alikes: &[],
    source: "Janot, Gautier and Brunot, the EMPS benchmark (its model has an offset)",
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[ParameterSpec {
        name: "offset",
        symbol: "τ_0",
        dimension: Dimension::Torque,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for TorqueOffset {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.time.iter().map(|_| 1.0))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&TorqueOffset, &[-1.3], |_, _, _| -1.3);
    }
}
