use super::*;

/// Hysteresis that unloads along a straight line.
pub static EFFECT: Effect = Effect {
    id: "bouc-wen-hysteresis",
    name: "hysteresis (Bouc–Wen)",
    formula: "tau = tau_h * z, dz/dt = (qd - (|qd| z + qd |z|) / 2) / s_0, z = 0 at the start",
    typeset: r"\tau = \tau_h z,\quad \dot z = \left(\dot q - \tfrac12(|\dot q|\, z + \dot q\, |z|)\right)/s_0",
    description: "Bouc–Wen hysteresis with n = 1 and beta = gamma, as of harmonic drives, cables and magnets: it \
                  builds up over the distance s_0 and unloads along a straight line. Its elastic part is a spring.",
    fingerprint: "Residual against velocity: as Coulomb friction, but after each reversal it falls in a straight line \
                  of the travelled distance, then builds up in a curve.",
    absorbed: "Nothing: a Lagrangian is conservative. On long strokes it looks like Coulomb friction.",
    source: "Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102 (1976) 249",
    stage: Stage::Body(&BoucWenHysteresis),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("hysteresis_torque", "τ_h", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("hysteresis_distance", "s_0", Dimension::Position, &[0.02, 0.06, 0.15, 0.4])
            .between(1e-4, 10.0),
    ],
    facts: Facts {
        look_alikes: &[
            LookAlike { effects: &["dahl-hysteresis"], told_by: PRE_SLIDING },
            LookAlike { effects: &["maxwell-slip"], told_by: PRE_SLIDING },
            LookAlike { effects: &["lugre-friction"], told_by: PRE_SLIDING },
        ],
        ..Facts::USUAL
    },
};

struct BoucWenHysteresis;

impl AddsTorque for BoucWenHysteresis {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let q = &motion.trajectory.q[joint];
        let mut z: f64 = 0.0;
        let mut before = q.first().copied().unwrap_or(0.0);
        let state = q.iter().map(|&q| {
            z = moved(z, (q - before) / shape[0]);
            before = q;
            z
        });
        Ok(vec![Column::on_joint(joint, state)])
    }
}

/// The state after so much travel in one direction, in units of s₀; exact. Against its sign z falls in a straight line to
/// zero, from there it approaches its limit.
fn moved(z: f64, travel: f64) -> f64 {
    let limit = travel.signum();
    let unloading = (-limit * z).clamp(0.0, travel.abs());
    let z = z + limit * unloading;
    if unloading == travel.abs() { z } else { limit + (z - limit) * (unloading - travel.abs()).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The differential equation itself, in small steps.
    #[test]
    fn is_the_solution_of_its_equation() {
        for (start, travel) in [(0.0, 0.7), (0.0, -2.0), (0.6, 1.0), (0.6, -0.3), (0.6, -1.4), (-0.9, 3.0), (0.5, 0.0)]
        {
            let steps = 200_000;
            let dq = travel / f64::from(steps);
            let mut z: f64 = start;
            for _ in 0..steps {
                z += dq - 0.5 * (dq.abs() * z + dq * z.abs());
            }
            assert!((moved(start, travel) - z).abs() < 1e-5, "{start}, {travel}: {} is not {z}", moved(start, travel));
        }
    }

    #[test]
    fn follows_the_position_in_units_of_its_distance() {
        let mut sample = testing::Sample::new();
        let stroke = |t: usize| 0.03 * t.min(20 - t) as f64;
        let strokes: Vec<f64> = (0..sample.trajectory.len()).map(stroke).collect();
        sample.trajectory.channels_mut().q[1].copy_from_slice(&strokes);
        let torque = EFFECT.torque(&sample.motion(), 1, &[1.5, 0.1]).unwrap();
        let top = 1.0 - (-3.0_f64).exp();
        assert!((torque[1][10] - 1.5 * top).abs() < 1e-12);
        assert!((torque[1][12] - 1.5 * (top - 0.6)).abs() < 1e-12);
    }
}
