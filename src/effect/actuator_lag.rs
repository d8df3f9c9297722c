use super::derivative_delay::delayed;
use super::*;
use crate::recording::differentiate::reflected;

/// A torque reading that comes late.
pub static EFFECT: Effect = Effect {
    id: "actuator-lag",
    name: "actuator lag",
    formula: "tau = -T * d(tau_load)/dt",
    typeset: r"\tau = -T\,\dot\tau_{\mathrm{load}}",
    description: "The current loop, a filter or the bus delays the torque by T. First order in T, so T must be \
                  short beside the motion. A log of the commanded torque is ahead of it: then T is negative.",
    fingerprint: "Residual against the rate of the predicted torque: a falling straight line.",
    absorbed: "Nothing of the part in phase with the velocity. The same T on all joints is a delay of the \
               positions in truth.",
    source: "Swevers, Verdonck and De Schutter, IEEE Control Systems 27 (2007) 58 (first-order expansion of a delay)",
    stage: Stage::Drive(&ActuatorLag),
    family: Family::Lag,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("lag", "T", Dimension::Time).between(-LONGEST_DELAY, LONGEST_DELAY)],
    facts: Facts { depends_on_load: true, also_said_as: &["derivative-delay"], ..Facts::USUAL },
};

struct ActuatorLag;

impl ChangesTorque for ActuatorLag {
    /// Before the start and after the end the torque goes on as its own point reflection: one that stood still there would be read
    /// as a stuck channel.
    fn pass(&self, torque: &mut [f64], time: &[f64], lag: f64) {
        let Some(last) = time.len().checked_sub(1) else { return };
        let margin = time.iter().take_while(|now| *now - time[0] <= lag.abs()).count().min(last);
        let continued = |signal: &[f64]| -> Vec<f64> { reflected(signal, margin, [signal[0], signal[last]]).collect() };
        let late = delayed(&continued(torque), &continued(time), lag);
        torque.copy_from_slice(&late[margin..margin + torque.len()]);
    }

    /// The rate is taken halfway: tau(t - T) = tau(t) - T * d(tau)/dt(t - T/2) up to the third order of T.
    fn column(&self, motion: &Motion, joint: usize, found: f64) -> Result<Column, Lack> {
        let (load, time) = (&motion.load()?.torque[joint], &motion.trajectory.time);
        let rate = delayed(&central_difference(load, time), time, 0.5 * found);
        Ok(Column::on_joint(joint, rate.into_iter().map(|rate| -rate)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Signals;

    #[test]
    fn acts_as_a_delay_of_all_torque() {
        let sample = testing::Sample::new();
        let mut torque = Signals::from_fn(3, sample.trajectory.len(), |_, t| 5.0 * sample.trajectory.time[t]);
        EFFECT.act(&sample.motion(), 1, &[0.02], &mut torque).unwrap();
        for (t, time) in sample.trajectory.time.iter().enumerate() {
            assert!((torque[1][t] - 5.0 * (time - 0.02)).abs() < 1e-12);
            assert_eq!(torque[0][t], 5.0 * time);
        }
    }

    /// Neither end stands still, whichever way the log is off.
    #[test]
    fn no_end_of_a_run_is_stuck() {
        let sample = testing::Sample::new();
        for lag in [0.05, -0.05, 10.0] {
            let mut torque =
                Signals::from_fn(3, sample.trajectory.len(), |_, t| (7.0 * sample.trajectory.time[t]).sin());
            EFFECT.act(&sample.motion(), 1, &[lag], &mut torque).unwrap();
            assert!(torque[1].iter().all(|value| value.is_finite()));
            let stands = torque[1].windows(2).filter(|pair| (pair[1] - pair[0]).abs() < 1e-6).count();
            assert!(lag == 10.0 || stands == 0, "{lag}: {:?}", &torque[1]);
        }
    }

    /// The load of the sample is a parabola in time: with the rate taken halfway, the torque is that of the delay.
    #[test]
    fn the_second_order_of_the_lag_is_in_the_column() {
        let sample = testing::Sample::new();
        let (motion, lag) = (sample.motion(), 0.02);
        let load = &motion.load.unwrap().torque[1];
        let late = delayed(load, &sample.trajectory.time, lag);
        let column = &EFFECT.columns(&motion, 1, &[lag]).unwrap()[0].parts[0].1;
        for t in 5..sample.trajectory.len() {
            assert!((lag * column[t] - (late[t] - load[t])).abs() < 1e-9, "{} at {t}", column[t]);
        }
    }

    /// The load of the sample is a parabola in time, for which central differences are exact.
    #[test]
    fn is_its_formula() {
        let sample = testing::Sample::new();
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.02]).unwrap();
        for (value, rate) in torque[1].iter().zip(sample.load_rate(1)) {
            assert!((value + 0.02 * rate).abs() < 1e-9, "{value} is not {}", -0.02 * rate);
        }
    }
}
