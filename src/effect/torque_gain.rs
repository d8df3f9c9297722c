use super::*;

/// A torque reading that is too large or too small by a factor.
pub static EFFECT: Effect = Effect {
    id: "torque-gain",
    name: "torque gain error",
    formula: "tau = gamma * tau_load",
    typeset: r"\tau = \gamma\,\tau_{\mathrm{load}}",
    description: "A wrong motor constant or gear ratio: the joint's torque is read (1 + gamma) times as large as \
                  the rigid body's.",
    fingerprint: "Residual against the torque that the model predicts: a straight line through the origin.",
    absorbed: "One gain on all joints can't be told from heavier links. Gains that differ show, because the joints \
               share their links.",
    source: "Gautier and Briot, Global identification of joint drive gains, J. Dyn. Sys. Meas. Control 136 (2014) \
             051025",
    stage: Stage::Body(&TorqueGain),
    family: Family::Gain,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("gain_error", "γ", Dimension::Ratio).between(-0.9, 10.0)],
    facts: Facts { depends_on_load: true, ..Facts::USUAL },
};

struct TorqueGain;

impl AddsTorque for TorqueGain {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let load = &motion.load()?.torque[joint];
        Ok(vec![Column::on_joint(joint, load.iter().copied())])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["tau_load"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_depends_on_load(&EFFECT, &[-0.1], |load, _, _| -0.1 * load);
    }
}
