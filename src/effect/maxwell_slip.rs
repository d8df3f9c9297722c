use super::*;

/// How many springs there are.
const ELEMENTS: usize = 4;

/// Friction of many small springs that let go one after the other.
pub static EFFECT: Effect = Effect {
    id: "maxwell-slip",
    name: "hysteresis (Maxwell slip)",
    formula: "tau = tau_h * mean of z_i, dz_i = dq / (i s_0 / 4), -1 <= z_i <= 1, i = 1 .. 4, z_i = 0 at the start",
    typeset: r"\tau = \frac{\tau_h}{4}\sum_{i=1}^{4} z_i,\quad \mathrm{d}z_i = \frac{4}{i\,s_0}\,\mathrm{d}q,\quad |z_i| \le 1",
    description: "Four elasto-plastic springs side by side, the first slides after s_0 / 4, the last after s_0: the \
                  generalised Maxwell-slip model (GMS) where sliding friction does not depend on the speed.",
    fingerprint: "Residual against velocity: as Coulomb friction, but after each reversal it builds up along a \
                  polygon of the travelled distance.",
    absorbed: "Nothing: a Lagrangian is conservative. On long strokes it looks like Coulomb friction.",
    source: "Al-Bender, Lampaert and Swevers, The generalized Maxwell-slip model, IEEE Trans. Autom. Control 50 (2005) 1883",
    stage: Stage::Body(&MaxwellSlip),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("friction_torque", "τ_h", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("breakaway_distance", "s_0", Dimension::Position, &[0.05, 0.12, 0.3, 0.7])
            .between(1e-4, 10.0),
    ],
    facts: Facts {
        look_alikes: &[
            LookAlike { effects: &["dahl-hysteresis"], told_by: PRE_SLIDING },
            LookAlike { effects: &["bouc-wen-hysteresis"], told_by: PRE_SLIDING },
            LookAlike { effects: &["lugre-friction"], told_by: PRE_SLIDING },
        ],
        ..Facts::USUAL
    },
};

struct MaxwellSlip;

impl AddsTorque for MaxwellSlip {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let q = &motion.trajectory.q[joint];
        let stiffness: [f64; ELEMENTS] = std::array::from_fn(|i| ELEMENTS as f64 / ((i + 1) as f64 * shape[0]));
        let mut springs = [0.0_f64; ELEMENTS];
        let mut before = q.first().copied().unwrap_or(0.0);
        let state = q.iter().map(|&q| {
            let travel = q - before;
            before = q;
            for (spring, stiffness) in springs.iter_mut().zip(stiffness) {
                *spring = (*spring + stiffness * travel).clamp(-1.0, 1.0);
            }
            springs.iter().sum::<f64>() / ELEMENTS as f64
        });
        Ok(vec![Column::on_joint(joint, state)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along a first stroke the springs let go at s₀/4, s₀/2, …; after a reversal everything takes twice the distance
    /// (Masing's rule).
    #[test]
    fn lets_go_spring_by_spring_and_turns_round_by_masings_rule() {
        let mut sample = testing::Sample::new();
        let count = sample.trajectory.len();
        let stroke = |t: usize| 0.03 * t.min(20 - t) as f64;
        let strokes: Vec<f64> = (0..count).map(stroke).collect();
        sample.trajectory.channels_mut().q[1].copy_from_slice(&strokes);
        let torque = EFFECT.torque(&sample.motion(), 1, &[2.0, 0.2]).unwrap();
        let first = |x: f64| (1..=4).map(|i| (x / (0.05 * i as f64)).min(1.0)).sum::<f64>() / 4.0;
        for t in 0..count {
            let expected =
                2.0 * if t <= 10 { first(stroke(t)) } else { first(0.3) - 2.0 * first((0.3 - stroke(t)) / 2.0) };
            assert!((torque[1][t] - expected).abs() < 1e-12, "{t}: {} is not {expected}", torque[1][t]);
        }
        assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
    }
}
