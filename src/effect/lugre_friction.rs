use super::*;

/// Bristles that bend before they slide, over a film that builds up with speed.
pub static EFFECT: Effect = Effect {
    id: "lugre-friction",
    name: "LuGre friction",
    formula: "tau = tau_c * z, dz/dt = (qd - |qd| z / g) / s_0, g = 1 + r * exp(-(qd / v_s)^2), z = 0 at the start",
    typeset: r"\tau = \tau_c z,\quad \dot z = \left(\dot q - |\dot q|\, z/g(\dot q)\right)/s_0,\quad g = 1 + r\, e^{-(\dot q/v_s)^2}",
    description: "Bristles bend over the distance s_0 before they slide, and carry more at low speed: Dahl's \
                  hysteresis with the Stribeck effect. Its damping of the bristles is left out; viscous friction is an \
                  effect of its own.",
    fingerprint: "Residual against velocity: a rounded loop after each reversal that overshoots before it settles at \
                  the Coulomb level.",
    absorbed: "Nothing: a Lagrangian is conservative. With no slow motion in the data it looks like Dahl hysteresis, on \
               long strokes like Stribeck or Coulomb friction.",
    source: "Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419",
    stage: Stage::Body(&LugreFriction),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("coulomb_torque", "τ_c", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("breakaway_distance", "s_0", Dimension::Position, &[0.02, 0.06, 0.2]).between(1e-4, 10.0),
        ParameterSpec::shape("stribeck_ratio", "r", Dimension::Ratio, &[0.6]).between(1e-3, 10.0),
        ParameterSpec::shape("stribeck_velocity", "v_s", Dimension::Velocity, &[0.1, 0.4]).between(1e-3, 10.0),
    ],
    facts: Facts {
        look_alikes: &[
            LookAlike { effects: &["dahl-hysteresis"], told_by: PRE_SLIDING },
            LookAlike { effects: &["bouc-wen-hysteresis"], told_by: PRE_SLIDING },
            LookAlike { effects: &["maxwell-slip"], told_by: PRE_SLIDING },
        ],
        ..Facts::USUAL
    },
};

struct LugreFriction;

impl AddsTorque for LugreFriction {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let &[distance, ratio, velocity] = shape else {
            return Err(Lack::Parameters { needed: 3, given: shape.len() });
        };
        let (q, qd) = (&motion.trajectory.q[joint], &motion.trajectory.qd[joint]);
        let carried = |qd: f64| 1.0 + ratio * (-(qd / velocity).powi(2)).exp();
        let mut z: f64 = 0.0;
        let mut before = q.first().copied().unwrap_or(0.0);
        let mut carried_before = qd.first().map_or(1.0, |&qd| carried(qd));
        // Between samples the motion has one direction and the bristles carry the mean of both ends: then this is exact.
        let state = q.iter().zip(qd).map(|(&q, &qd)| {
            let (travel, here) = (q - before, carried(qd));
            let carried = 0.5 * (here + carried_before);
            (before, carried_before) = (q, here);
            let limit = carried.copysign(travel);
            z = limit + (z - limit) * (-travel.abs() / (distance * carried)).exp();
            z
        });
        Ok(vec![Column::on_joint(joint, state)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Signals;

    /// A swing, finely sampled.
    fn swing(samples: usize) -> testing::Sample {
        let mut sample = testing::Sample::new();
        let time: Vec<f64> = (0..samples).map(|t| 4.0 * t as f64 / samples as f64).collect();
        let signal = |f: fn(f64) -> f64| Signals::from_fn(3, samples, |_, t| f(time[t]));
        let (q, qd) = (signal(|t| 0.3 * (2.0 * t).cos()), signal(|t| -0.6 * (2.0 * t).sin()));
        let (qdd, tau) = (signal(|t| -1.2 * (2.0 * t).cos()), Signals::zeros(3, samples));
        sample.trajectory = Trajectory::new("", Channels { time, q, qd, qdd, tau }).unwrap();
        sample
    }

    #[test]
    fn is_the_solution_of_its_equation() {
        let (coarse, fine) = (swing(400), swing(400_000));
        let found = &EFFECT.torque(&coarse.motion(), 1, &[1.5, 0.05, 0.6, 0.2]).unwrap()[1];
        let mut z: f64 = 0.0;
        for (t, &qd) in fine.trajectory.qd[1].iter().enumerate() {
            if t % 1000 == 0 {
                let expected = 1.5 * z;
                assert!((found[t / 1000] - expected).abs() < 4e-3, "{t}: {} is not {expected}", found[t / 1000]);
            }
            let carried = 1.0 + 0.6 * (-(qd / 0.2).powi(2)).exp();
            z += 1e-5 * (qd - qd.abs() * z / carried) / 0.05;
        }
    }

    #[test]
    fn without_the_stribeck_part_it_is_dahl_hysteresis() {
        let swing = swing(400);
        let dahl = registry::find("dahl-hysteresis").unwrap();
        let dahl = &dahl.torque(&swing.motion(), 1, &[1.5, 0.05]).unwrap()[1];
        let found = &EFFECT.torque(&swing.motion(), 1, &[1.5, 0.05, 1e-12, 0.2]).unwrap()[1];
        assert!(dahl.iter().zip(found).all(|(dahl, found)| (dahl - found).abs() < 1e-9));
    }
}
