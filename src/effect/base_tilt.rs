use super::*;

/// A base that does not stand level.
pub static EFFECT: Effect = Effect {
    id: "base-tilt",
    name: "base tilt",
    formula: "tau = eps * d(tau_gravity)/d(phi_0)",
    typeset: r"\tau = \varepsilon\,\partial\tau_g/\partial\varphi_0",
    description: "The plane of the arm is turned against gravity by eps, or all of its angles have a zero error. \
                  First order in eps.",
    fingerprint: "All joints at once, against position: a quarter period away from the gravity torque.",
    absorbed: "Little of it: turned gravity has another phase than the gravity that the base parameters know.",
    source: "Closed form of the planar arm: gravity torque with the zero angle changed",
    stage: Stage::Body(&BaseTilt),
    family: Family::Tilt,
    scope: Scope::Arm,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("tilt", "ε", Dimension::Angle).between(-0.5, 0.5)],
    facts: Facts { depends_on_load: true, also_said_as: &["com-offset"], ..Facts::USUAL },
};

struct BaseTilt;

impl AddsTorque for BaseTilt {
    fn columns(&self, motion: &Motion, _joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![Column::on_all(motion.load()?.turned_gravity.clone())])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Signals;

    #[test]
    fn is_what_gravity_needs_more_on_a_turned_base() {
        let sample = testing::Sample::new();
        let still = Signals::zeros(3, sample.trajectory.len());
        let gravity = |tilt: f64| {
            let mut arm = sample.arm.clone();
            arm.posture.zero_angle += tilt;
            arm.inverse_dynamics_along(&sample.trajectory.q, &still, &still)
        };
        let (level, tilted) = (gravity(-0.5e-5), gravity(0.5e-5));
        let torque = EFFECT.torque(&sample.motion(), 0, &[1e-5]).unwrap();
        for joint in 0..3 {
            for t in 0..sample.trajectory.len() {
                let expected = tilted[joint][t] - level[joint][t];
                assert!((torque[joint][t] - expected).abs() < 1e-12, "{} is not {expected}", torque[joint][t]);
            }
        }
    }
}
