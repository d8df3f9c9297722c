use super::coulomb_friction::sign;
use super::*;

/// Dry friction that changes with time.
pub struct FrictionDrift;

static SPEC: Spec = Spec {
    id: "friction-drift",
    name: "friction drift",
    formula: "tau = (tau_c + r * t) * sign(qd)",
    typeset: r"\tau = (\tau_c + r\,t)\,\mathrm{sign}(\dot q)",
    description: "Grease warms up and friction falls, a seal swells and it grows. Time counts from the start of \
                  each trajectory. It contains Coulomb friction (tau_c), the level at the start.",
    fingerprint: "Residual against time: a wedge that opens or closes, its sign that of the velocity.",
    absorbed: "Nothing. In short recordings its mean looks like Coulomb friction.",
    look_alikes: &[LookAlike {
        effects: &["friction-warm-up"],
        told_by: "Runs longer than the warm-up: a drift goes on, a warm-up ends.",
    }],
    source: "Simoni et al., Robotica, 10.1017/S0263574717000509",
    scope: Scope::Joint,
    axis: Axis::Time,
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
            name: "drift_rate",
            symbol: "r",
            dimension: Dimension::TorqueRate,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            role: Role::Linear,
        },
    ],
    includes: &["coulomb-friction"],
};

impl Effect for FrictionDrift {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let Trajectory { time, qd, .. } = motion.trajectory;
        let start = time.first().copied().unwrap_or(0.0);
        let drift = time.iter().zip(&qd[joint]).map(|(time, &qd)| (time - start) * sign(qd));
        Ok(vec![Column::on_joint(joint, qd[joint].iter().map(|&qd| sign(qd))), Column::on_joint(joint, drift)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_at_the_coulomb_level_and_changes() {
        let mut sample = testing::Sample::new();
        sample.trajectory.time.iter_mut().for_each(|time| *time += 5.0);
        let torque = torque(&FrictionDrift, &sample.motion(), 1, &[0.3, -0.4]).unwrap();
        for (t, &qd) in sample.trajectory.qd[1].iter().enumerate() {
            assert!((torque[1][t] - (0.3 - 0.4 * 0.01 * t as f64) * sign(qd)).abs() < 1e-12);
        }
    }
}
