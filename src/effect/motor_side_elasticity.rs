use super::motor_side::Behind;
use super::*;

/// A gear that twists behind the motor whose angle is measured.
pub static EFFECT: Effect = Effect {
    id: "motor-side-elasticity",
    name: "joint elasticity seen from the motor",
    formula: "tau = kappa * d(tau_load(q - kappa tau_load))/d(kappa) at kappa = 0, kappa = 1 / k",
    typeset: r"\tau = -\kappa\left(\frac{\partial\tau}{\partial q_j}\tau_j + \frac{\partial\tau}{\partial\dot q_j}\dot\tau_j + \frac{\partial\tau}{\partial\ddot q_j}\ddot\tau_j\right),\quad \kappa = 1/k",
    description: "A harmonic drive or belt of stiffness k twists by tau_load / k. The encoder sits on the motor, so the link is \
                  behind the angle that is read, and all joints carry an arm that is a bit elsewhere. First order in 1 / k.",
    fingerprint: "All joints at once: a little of how each one's torque changes with the soft joint's angle, velocity and \
                  acceleration.",
    absorbed: "Where the motion has a single frequency, base parameters absorb most of it.",
    source: "Spong, Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control 109 (1987) 310, solved for the angle of \
             the motor",
    stage: Stage::Body(&MotorSideElasticity),
    family: Family::Elasticity,
    scope: Scope::Joint,
    axis: Axis::Acceleration,
    parameters: &[ParameterSpec::linear("compliance", "κ", Dimension::Compliance).at_least(0.0)],
    facts: Facts {
        depends_on_load: true,
        encoder: Some(Side::Motor),
        other_side: Some("joint-elasticity"),
        goes_with: &["rotor-inertia"],
        ..Facts::USUAL
    },
};

struct MotorSideElasticity;

impl AddsTorque for MotorSideElasticity {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let (load, time) = (&motion.load()?.torque[joint], &motion.trajectory.time);
        let velocity = central_difference(load, time);
        let acceleration = central_difference(&velocity, time);
        Ok(vec![Behind { position: load.to_vec(), velocity, acceleration }.column(motion, joint)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The torque of the arm where its links are, less that where its motors say they are, for a twist so small that the first order is
    /// all of it.
    #[test]
    fn is_the_torque_of_an_arm_behind_its_motor() {
        let sample = testing::Sample::new();
        let load = Load::of_arm(&sample.arm, &sample.trajectory);
        let motion = Motion { load: Some(&load), ..sample.motion() };
        let compliance = 1e-9;
        let torque = EFFECT.torque(&motion, 1, &[compliance]).unwrap();
        let time = &sample.trajectory.time;
        let twist = |signal: &[f64]| signal.iter().map(|torque| compliance * torque).collect::<Vec<_>>();
        let rate = central_difference(&load.torque[1], time);
        let behind = [twist(&load.torque[1]), twist(&rate), twist(&central_difference(&rate, time))];
        let mut there = sample.trajectory.clone();
        let channels = there.channels_mut();
        for (mut signal, behind) in [channels.q, channels.qd, channels.qdd].into_iter().zip(behind) {
            let link = signal.iter_mut().nth(1).unwrap();
            link.iter_mut().zip(behind).for_each(|(value, behind)| *value -= behind);
        }
        let truth = sample.arm.inverse_dynamics_along(&there.q, &there.qd, &there.qdd);
        let most = torque.values().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        assert!(torque.iter().all(|joint| joint.iter().any(|value| value.abs() > 1e-3 * most)), "all joints feel it");
        for joint in 0..3 {
            for sample in 0..time.len() {
                let expected = truth[joint][sample] - load.torque[joint][sample];
                let found = torque[joint][sample];
                assert!((found - expected).abs() < 1e-4 * most, "{found} is not {expected}");
            }
        }
        assert!(EFFECT.columns(&Motion { load: None, ..sample.motion() }, 1, &[]).is_err());
    }
}
