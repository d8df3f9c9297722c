use super::*;

/// A torque channel that now and then repeats its last reading.
pub static EFFECT: Effect = Effect {
    id: "stuck-channel",
    name: "stuck torque channel",
    formula: "tau(t) = tau(t_0) for t_0 <= t < t_0 + d, once every T",
    typeset: r"\tau(t) = \tau(t_0),\quad t_0 \le t < t_0 + d",
    description: "A loose contact, a lost message or a frozen driver: the log repeats the last reading for a time d, about \
                  once every T, while the joint moves on. A channel that reads zero is dead.",
    fingerprint: "Residual against time: the predicted torque itself, upside down, in short stretches; in the torque a \
                  flat line.",
    absorbed: "Nothing, but it biases all parameters. Readings that are stuck are found when a recording is opened and \
               left out of every fit and every error, so there is nothing to add to the model.",
    source: "Isermann, Fault-Diagnosis Systems, Springer 2006, chapter 20 (sensor faults)",
    stage: Stage::Reading(&StuckChannel, Remedy::LeaveOut(FaultKind::Stuck)),
    family: Family::Clipping,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::reading("stuck_time", "d", Dimension::Time),
        ParameterSpec::reading("stuck_period", "T", Dimension::Time),
    ],
    facts: Facts::USUAL,
};

struct StuckChannel;

impl ChangesReading for StuckChannel {
    fn misread(&self, reading: &mut Trajectory, joint: usize, parameters: &[f64]) {
        let &[duration, period] = parameters else { return };
        let start = reading.time.first().copied().unwrap_or(0.0);
        // Joints are not stuck at the same times.
        let shift = 0.37 * joint as f64 * period;
        let mut reading = reading.channels_mut();
        let mut last = reading.tau[joint].first().copied().unwrap_or(0.0);
        for (tau, time) in reading.tau[joint].iter_mut().zip(reading.time.iter()) {
            // The end of each period, so that the first reading of a run is a good one.
            if (time - start + shift) % period >= period - duration {
                *tau = last;
            }
            last = *tau;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Signals;

    #[test]
    fn repeats_the_last_reading() {
        let mut sample = testing::Sample::new();
        sample.trajectory = sample.trajectory.with_torque(Signals::from_fn(3, 21, |_, t| t as f64)).unwrap();
        EFFECT.misread(&mut sample.trajectory, 0, &[0.0301, 0.1]);
        let expected = [0, 1, 2, 3, 4, 5, 6, 6, 6, 6, 10, 11, 12, 13, 14, 15, 16, 16, 16, 16, 20].map(f64::from);
        assert_eq!(sample.trajectory.tau[0], expected);
        assert_eq!(sample.trajectory.tau[1][9], 9.0);
    }
}
