use super::coulomb_friction::sign;
use super::*;

/// Friction that turns round over a distance, not at once.
pub static EFFECT: Effect = Effect {
    id: "dahl-hysteresis",
    name: "hysteresis (Dahl)",
    formula: "tau = tau_h * z, dz/dt = (qd - |qd| z) / s_0, z = 0 at the start",
    typeset: r"\tau = \tau_h z,\quad \dot z = (\dot q - |\dot q|\, z)/s_0",
    description: "Asperities, belts and bearings bend elastically before they slide: after each reversal the \
                  friction builds up over the distance s_0.",
    fingerprint: "Residual against velocity: as Coulomb friction, but with a rounded loop after each reversal.",
    absorbed: "Nothing: a Lagrangian is conservative. On long strokes it looks like Coulomb friction.",
    source: "Dahl, A solid friction model, Aerospace Corp. TOR-0158 (1968)",
    stage: Stage::Body(&DahlHysteresis),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("friction_torque", "τ_h", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("breakaway_distance", "s_0", Dimension::Position, &[0.02, 0.05, 0.1, 0.2, 0.4])
            .between(1e-4, 10.0),
    ],
    facts: Facts {
        look_alikes: &[
            LookAlike { effects: &["bouc-wen-hysteresis"], told_by: PRE_SLIDING },
            LookAlike { effects: &["maxwell-slip"], told_by: PRE_SLIDING },
            LookAlike { effects: &["lugre-friction"], told_by: PRE_SLIDING },
        ],
        ..Facts::USUAL
    },
};

struct DahlHysteresis;

impl AddsTorque for DahlHysteresis {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let q = &motion.trajectory.q[joint];
        let mut z: f64 = 0.0;
        let mut before = q.first().copied().unwrap_or(0.0);
        // Between samples the motion has one direction, for which the equation has this exact solution.
        let state = q.iter().map(|&q| {
            let travel = q - before;
            before = q;
            let limit = sign(travel);
            z = limit + (z - limit) * (-travel.abs() / shape[0]).exp();
            z
        });
        Ok(vec![Column::on_joint(joint, state)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along a stroke in one direction z = 1 − exp(−x/s₀), from rest at z = 0.
    #[test]
    fn builds_up_over_its_distance_and_turns_round() {
        let mut sample = testing::Sample::new();
        let count = sample.trajectory.len();
        let stroke = |t: usize| 0.03 * t.min(20 - t) as f64;
        let strokes: Vec<f64> = (0..count).map(stroke).collect();
        sample.trajectory.channels_mut().q[1].copy_from_slice(&strokes);
        let torque = EFFECT.torque(&sample.motion(), 1, &[1.5, 0.1]).unwrap();
        for t in 0..count {
            let there = |x: f64| 1.0 - (-x / 0.1).exp();
            let top = there(0.3);
            let back = |x: f64| -1.0 + (top + 1.0) * (-(0.3 - x) / 0.1).exp();
            let expected = 1.5 * if t <= 10 { there(stroke(t)) } else { back(stroke(t)) };
            assert!((torque[1][t] - expected).abs() < 1e-12, "{t}: {} is not {expected}", torque[1][t]);
        }
        assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
    }
}
