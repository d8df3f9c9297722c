use super::*;

/// Dry friction that is larger while the joint is cold.
pub static EFFECT: Effect = Effect {
    id: "friction-warm-up",
    name: "friction warm-up",
    formula: "tau = (tau_c + tau_w * exp(-t / T_w)) * sign(qd)",
    typeset: r"\tau = \left(\tau_c + \tau_w\, e^{-t/T_w}\right)\mathrm{sign}(\dot q)",
    description: "Grease is stiff at first and softens as the joint warms up to a steady temperature. Time counts \
                  from the start of each trajectory. It contains Coulomb friction (tau_c), the level when warm.",
    fingerprint: "Residual against time: a wedge that closes, ever more slowly, its sign that of the velocity.",
    absorbed: "Nothing: a Lagrangian is conservative. In short recordings its mean looks like Coulomb friction.",
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013 (friction and temperature)",
    stage: Stage::Body(&FrictionWarmUp),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0),
        ParameterSpec::linear("cold_torque", "τ_w", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("warm_up_time", "T_w", Dimension::Time, &[1.0, 3.0, 10.0]).between(0.5, 1e5),
    ],
    facts: Facts {
        includes: &["coulomb-friction"],
        look_alikes: &[
            LookAlike {
                effects: &["friction-drift"],
                told_by: "Runs longer than the warm-up: a drift goes on, a warm-up ends.",
            },
            LookAlike { effects: &["frictional-heating"], told_by: WARMING },
        ],
        ..Facts::USUAL
    },
};

struct FrictionWarmUp;

impl AddsTorque for FrictionWarmUp {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let Channels { time, qd, .. } = &**motion.trajectory;
        let start = time.first().copied().unwrap_or(0.0);
        let cold = time
            .iter()
            .zip(&qd[joint])
            .map(|(time, &qd)| ((start - time) / shape[0]).exp() * motion.direction(joint, qd));
        Ok(vec![motion.coulomb(joint), Column::on_joint(joint, cold)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn falls_from_the_cold_level_to_the_warm_one() {
        let mut sample = testing::Sample::new();
        sample.trajectory.channels_mut().time.iter_mut().for_each(|time| *time += 5.0);
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.3, 0.4, 0.1]).unwrap();
        for (t, &qd) in sample.trajectory.qd[1].iter().enumerate() {
            let level = 0.3 + 0.4 * (-(t as f64) / 10.0).exp();
            assert!((torque[1][t] - level * sign(qd)).abs() < 1e-12);
        }
    }
}
