use super::*;

/// Dry friction that changes with time.
pub static EFFECT: Effect = Effect {
    id: "friction-drift",
    name: "friction drift",
    formula: "tau = (tau_c + r * t) * sign(qd)",
    typeset: r"\tau = (\tau_c + r\,t)\,\mathrm{sign}(\dot q)",
    description: "Grease warms up and friction falls, a seal swells and it grows. Time counts from the start of \
                  each trajectory. It contains Coulomb friction (tau_c), the level at the start.",
    fingerprint: "Residual against time: a wedge that opens or closes, its sign that of the velocity.",
    absorbed: "Nothing. In short recordings its mean looks like Coulomb friction.",
    source: "Simoni et al., Robotica, 10.1017/S0263574717000509",
    stage: Stage::Body(&FrictionDrift),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0),
        ParameterSpec::linear("drift_rate", "r", Dimension::TorqueRate),
    ],
    facts: Facts {
        includes: &["coulomb-friction"],
        look_alikes: &[
            LookAlike {
                effects: &["friction-warm-up"],
                told_by: "Runs longer than the warm-up: a drift goes on, a warm-up ends.",
            },
            LookAlike { effects: &["frictional-heating"], told_by: WARMING },
        ],
        ..Facts::USUAL
    },
};

struct FrictionDrift;

impl AddsTorque for FrictionDrift {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let Channels { time, qd, .. } = &**motion.trajectory;
        let start = time.first().copied().unwrap_or(0.0);
        let drift = time.iter().zip(&qd[joint]).map(|(time, &qd)| (time - start) * motion.direction(joint, qd));
        Ok(vec![motion.coulomb(joint), Column::on_joint(joint, drift)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_at_the_coulomb_level_and_changes() {
        let mut sample = testing::Sample::new();
        sample.trajectory.channels_mut().time.iter_mut().for_each(|time| *time += 5.0);
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.3, -0.4]).unwrap();
        for (t, &qd) in sample.trajectory.qd[1].iter().enumerate() {
            assert!((torque[1][t] - (0.3 - 0.4 * 0.01 * t as f64) * sign(qd)).abs() < 1e-12);
        }
    }
}
