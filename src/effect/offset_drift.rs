use super::*;

/// A zero error that grows with time.
pub static EFFECT: Effect = Effect {
    id: "offset-drift",
    name: "offset drift",
    formula: "tau = tau_0 + r * t",
    typeset: r"\tau = \tau_0 + r\,t",
    description: "A torque sensor that warms up after it was set to zero. Time counts from the start of each \
                  trajectory. It contains a torque offset (tau_0), the drift up to then.",
    fingerprint: "Residual against time: a straight line in every trajectory.",
    absorbed: "Nothing. In short recordings its mean looks like a torque offset.",
    source: "The offset of Janot, Gautier and Brunot, the EMPS benchmark, with a rate",
    stage: Stage::Body(&OffsetDrift),
    family: Family::Offset,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::linear("offset", "τ_0", Dimension::Torque),
        ParameterSpec::linear("drift_rate", "r", Dimension::TorqueRate),
    ],
    facts: Facts { includes: &["torque-offset"], ..Facts::USUAL },
};

struct OffsetDrift;

impl AddsTorque for OffsetDrift {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let time = &motion.trajectory.time;
        let start = time.first().copied().unwrap_or(0.0);
        Ok(vec![
            Column::on_joint(joint, time.iter().map(|_| 1.0)),
            Column::on_joint(joint, time.iter().map(|time| time - start)),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_at_the_offset_and_grows() {
        let mut sample = testing::Sample::new();
        sample.trajectory.channels_mut().time.iter_mut().for_each(|time| *time += 5.0);
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.3, -0.4]).unwrap();
        assert!(torque[1].iter().enumerate().all(|(t, value)| (value - 0.3 + 0.4 * 0.01 * t as f64).abs() < 1e-12));
    }
}
