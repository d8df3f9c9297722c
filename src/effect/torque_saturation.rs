use super::*;

/// A torque reading that is cut off at a limit.
pub static EFFECT: Effect = Effect {
    id: "torque-saturation",
    name: "torque saturation",
    formula: "tau = min(max(tau, -tau_max), tau_max)",
    typeset: r"\tau = \min(\max(\tau, -\tau_{\max}), \tau_{\max})",
    description: "The sensor, its converter or the logged command ends at a limit, while the arm is driven by more than \
                  that.",
    fingerprint: "Residual against the torque that the model predicts: zero up to the limit, a falling line beyond; the \
                  torque has flat ends.",
    absorbed: "Nothing, but it biases masses and friction downwards. Readings at the limit are found when a recording is \
               opened and left out of every fit and every error, so there is nothing to add to the model.",
    source: "Tao and Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996",
    stage: Stage::Reading(&TorqueSaturation, Remedy::LeaveOut(FaultKind::Saturated)),
    family: Family::Clipping,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[ParameterSpec::reading("torque_limit", "τ_max", Dimension::Torque)],
    facts: Facts::USUAL,
};

struct TorqueSaturation;

impl ChangesReading for TorqueSaturation {
    fn misread(&self, reading: &mut Trajectory, joint: usize, parameters: &[f64]) {
        let &[limit] = parameters else { return };
        reading.channels_mut().tau[joint].iter_mut().for_each(|tau| *tau = tau.max(-limit).min(limit));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Signals;

    #[test]
    fn cuts_off_both_ends() {
        let mut sample = testing::Sample::new();
        sample.trajectory = sample.trajectory.with_torque(Signals::from_fn(3, 21, |_, t| t as f64 - 10.0)).unwrap();
        EFFECT.misread(&mut sample.trajectory, 1, &[7.5]);
        for (t, tau) in sample.trajectory.tau[1].iter().enumerate() {
            assert_eq!(*tau, (t as f64 - 10.0).clamp(-7.5, 7.5));
        }
        assert_eq!(sample.trajectory.tau[0][20], 10.0);
    }
}
