use super::*;

/// A constant error of the torque reading.
pub static EFFECT: Effect = Effect {
    id: "torque-offset",
    name: "torque offset",
    formula: "tau = tau_0",
    typeset: r"\tau = \tau_0",
    description: "A zero error of the torque sensor or of the motor current.",
    fingerprint: "Residual against anything: flat, but not at zero.",
    absorbed: "Nothing, unless a joint hardly moves: then it looks like gravity.",
    source: "Janot, Gautier and Brunot, the EMPS benchmark (its model has an offset)",
    stage: Stage::Body(&TorqueOffset),
    family: Family::Offset,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[ParameterSpec::linear("offset", "τ_0", Dimension::Torque)],
    facts: Facts { everyday: true, is_offset: true, also_said_as: &["joint-spring"], ..Facts::USUAL },
};

struct TorqueOffset;

impl AddsTorque for TorqueOffset {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.time.iter().map(|_| 1.0))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["1"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[-1.3], |_, _, _| -1.3);
    }
}
