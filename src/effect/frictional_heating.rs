use super::*;

/// Dry friction that falls as its own heat warms the joint.
pub static EFFECT: Effect = Effect {
    id: "frictional-heating",
    name: "frictional heating",
    formula: "tau = (tau_c - tau_w * (1 - exp(-theta))) * sign(qd), dtheta/dt = |qd| / s_w - theta / T_w, theta = 0 at the start",
    typeset: r"\tau = \left(\tau_c - \tau_w (1 - e^{-\theta})\right)\mathrm{sign}(\dot q),\quad \dot\theta = \frac{|\dot q|}{s_w} - \frac{\theta}{T_w}",
    description: "Rubbing heats the joint along its way, which gives the heat to what is around it with time; the lubricant thins \
                  as its temperature theta rises. So fast runs end at less friction than slow ones. Each trajectory starts cold. \
                  It contains Coulomb friction (tau_c), the level when cold, which falls by up to tau_w.",
    fingerprint: "Residual against time: a wedge that closes, ever more slowly, its sign that of the velocity; further in fast \
                  runs than in slow ones.",
    absorbed: "Nothing: a Lagrangian is conservative. In short recordings its mean looks like Coulomb friction.",
    source: "Simoni, Beschi, Legnani, Visioli, Modelling the temperature in joint friction of industrial manipulators, \
             Robotica, 10.1017/S0263574717000509",
    stage: Stage::Body(&FrictionalHeating),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0),
        ParameterSpec::linear("thermal_drop", "τ_w", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("warm_up_distance", "s_w", Dimension::Position, &[1.0, 3.0, 10.0]).between(0.3, 1e6),
        ParameterSpec::shape("cooling_time", "T_w", Dimension::Time, &[4.0]).between(0.5, 1e6),
    ],
    facts: Facts {
        includes: &["coulomb-friction"],
        look_alikes: &[
            LookAlike { effects: &["friction-warm-up"], told_by: WARMING },
            LookAlike { effects: &["friction-drift"], told_by: WARMING },
        ],
        formerly: Some("friction-warm-up"),
        ..Facts::USUAL
    },
};

struct FrictionalHeating;

impl AddsTorque for FrictionalHeating {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let Channels { time, qd, .. } = &**motion.trajectory;
        let mut temperature = 0.0;
        let mut before = time.first().copied().unwrap_or(0.0);
        // Exact while the speed stands.
        let warm = time.iter().zip(&qd[joint]).map(|(&now, &qd)| {
            let steady = qd.abs() * shape[1] / shape[0];
            temperature = steady + (temperature - steady) * ((before - now) / shape[1]).exp();
            before = now;
            (-temperature).exp_m1() * motion.direction(joint, qd)
        });
        Ok(vec![motion.coulomb(joint), Column::on_joint(joint, warm)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISTANCE: f64 = 0.05;
    const TIME: f64 = 0.1;

    /// At a speed that stands it is θ = (|q̇| T_w/s_w)(1 − exp(−t/T_w)).
    #[test]
    fn falls_further_in_fast_motion() {
        for speed in [0.2, -0.5, 2.0] {
            let mut sample = testing::Sample::new();
            let mut channels = sample.trajectory.channels_mut();
            channels.time.iter_mut().for_each(|time| *time += 5.0);
            channels.qd[1].fill(speed);
            let torque = EFFECT.torque(&sample.motion(), 1, &[0.7, 0.4, DISTANCE, TIME]).unwrap();
            for (t, torque) in torque[1].iter().enumerate() {
                let temperature = speed.abs() * TIME / DISTANCE * (1.0 - (-(t as f64) * 0.01 / TIME).exp());
                let expected = (0.3 + 0.4 * (-temperature).exp()) * sign(speed);
                assert!((torque - expected).abs() < 1e-12, "{torque} is not {expected}");
            }
        }
    }

    /// Where hardly any heat is lost, only the way counts: twice as fast is as warm in half the time.
    #[test]
    fn without_cooling_the_way_counts() {
        let levels = |speed: f64| {
            let mut sample = testing::Sample::new();
            sample.trajectory.channels_mut().qd[1].fill(speed);
            EFFECT.torque(&sample.motion(), 1, &[0.7, 0.4, DISTANCE, 1e6]).unwrap()[1].to_vec()
        };
        let (slow, fast) = (levels(1.0), levels(2.0));
        for t in 0..10 {
            assert!((fast[t] - slow[2 * t]).abs() < 1e-5, "{} is not {}", fast[t], slow[2 * t]);
        }
    }

    #[test]
    fn what_was_warm_cools_at_rest() {
        let level = |while_others_move: f64| {
            let mut sample = testing::Sample::new();
            let qd = &mut sample.trajectory.channels_mut().qd[1];
            qd[..8].fill(3.0);
            qd[8..20].fill(while_others_move);
            qd[20] = 1.0;
            EFFECT.torque(&sample.motion(), 1, &[0.7, 0.4, DISTANCE, TIME]).unwrap()[1][20]
        };
        let (warm, rested) = (level(3.0), level(0.0));
        assert!(warm < rested && rested < 0.7, "{warm} {rested}");
    }
}
