use super::*;

/// Velocity and acceleration that come late because they were filtered.
pub static EFFECT: Effect = Effect {
    id: "derivative-delay",
    name: "delay of velocity and acceleration",
    formula: "tau = T * (d(tau_load)/d(qd) * qdd + d(tau_load)/d(qdd) * d(qdd)/dt)",
    typeset: r"\tau = T\left(\frac{\partial\tau_{\mathrm{load}}}{\partial\dot q}\,\ddot q + \frac{\partial\tau_{\mathrm{load}}}{\partial\ddot q}\,\dddot q\right)",
    description: "A filter that runs forward only makes q̇ and q̈ late by T beside position and torque, on all joints; \
                  where T is negative, position and torque are late. The formula is its first order in T.",
    fingerprint: "All joints at once, against the rate of the acceleration: a rising straight line; inertia and Coriolis \
                  torque lag, gravity does not.",
    absorbed: "Nothing of the part in phase with the velocity.",
    source: "Swevers, Verdonck and De Schutter, IEEE Control Systems 27 (2007) 58; first-order expansion",
    stage: Stage::Reading(&DerivativeDelay, Remedy::SetRight(&DerivativeDelay)),
    family: Family::Delay,
    scope: Scope::Arm,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("delay", "T", Dimension::Time).between(-LONGEST_DELAY, LONGEST_DELAY)],
    facts: Facts { depends_on_load: true, of_measured_derivatives: true, ..Facts::USUAL },
};

/// Step of the derivative by the delay, before a delay was found \[s\].
const LEAST_AHEAD: f64 = 1e-4;

struct DerivativeDelay;

impl ChangesReading for DerivativeDelay {
    fn misread(&self, reading: &mut Trajectory, _joint: usize, parameters: &[f64]) {
        let &[delay] = parameters else { return };
        let mut reading = reading.channels_mut();
        let moments = moments(reading.time, delay);
        for signal in reading.qd.iter_mut().chain(reading.qdd.iter_mut()) {
            signal.copy_from_slice(&along(signal, reading.time, &moments));
        }
    }
}

impl SetsRight for DerivativeDelay {
    fn set_right(&self, motion: &mut Trajectory, delay: f64) {
        self.misread(motion, 0, &[-delay]);
    }

    /// The torque of the motion that is read, moved ahead by the delay, less that of the motion as it is read.
    fn column(&self, motion: &Motion, found: f64) -> Result<Column, Lack> {
        let load = motion.load()?;
        let ahead = if found.abs() < LEAST_AHEAD { LEAST_AHEAD } else { found };
        let mut right = motion.trajectory.clone();
        self.set_right(&mut right, ahead);
        let mut column = (load.body)(&right);
        for (value, read) in column.iter_mut().flatten().zip(load.torque_along(motion.trajectory).iter().flatten()) {
            *value = (*value - read) / ahead;
        }
        Ok(Column::on_all(column))
    }
}

/// The signal as it was `delay` \[s\] ago, on a smooth curve through the samples; before the start it was as at the start, and
/// after the end it stays as at the end.
pub(super) fn delayed(signal: &[f64], time: &[f64], delay: f64) -> Vec<f64> {
    along(signal, time, &moments(time, delay))
}

/// A moment between two samples.
struct Moment {
    /// The sample before it.
    before: usize,
    /// Its share of the way to the next one; 0 before the first sample and after the last.
    share: f64,
}

/// Of each sample the moment `delay` \[s\] ago.
fn moments(time: &[f64], delay: f64) -> Vec<Moment> {
    let mut before = 0;
    let moment = |now: &f64| {
        let then = now - delay;
        while before + 1 < time.len() && time[before + 1] <= then {
            before += 1;
        }
        let is_within = before + 1 < time.len() && then > time[before];
        let share = if is_within { (then - time[before]) / (time[before + 1] - time[before]) } else { 0.0 };
        Moment { before, share }
    };
    time.iter().map(moment).collect()
}

/// The signal at these moments, by Hermite's cubic with the slopes of central differences.
fn along(signal: &[f64], time: &[f64], moments: &[Moment]) -> Vec<f64> {
    let last = time.len().saturating_sub(1);
    let slope = |t: usize| {
        let (before, after) = (t.saturating_sub(1), (t + 1).min(last));
        (signal[after] - signal[before]) / (time[after] - time[before])
    };
    let slopes: Vec<f64> = (0..time.len()).map(slope).collect();
    let value = |&Moment { before, share }: &Moment| {
        if share == 0.0 {
            return signal[before];
        }
        let after = before + 1;
        let step = time[after] - time[before];
        let (rest, rise) = (1.0 - share, signal[after] - signal[before]);
        let bends = [step * slopes[before] - rise, rise - step * slopes[after]];
        signal[before] + share * rise + share * rest * (rest * bends[0] + share * bends[1])
    };
    moments.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Arm;
    use crate::signals::Signals;

    #[test]
    fn a_delayed_signal_is_that_of_before() {
        let time: Vec<f64> = (0..50).map(|t| 0.01 * f64::from(t)).collect();
        let signal: Vec<f64> = time.iter().map(|t| (3.0 * t).sin()).collect();
        for (t, value) in delayed(&signal, &time, 0.025).iter().enumerate() {
            let expected = (3.0 * (time[t] - 0.025).max(0.0)).sin();
            let precision = if (4..48).contains(&t) { 2e-6 } else { 2e-4 };
            assert!((value - expected).abs() < precision, "{value} is not {expected}");
        }
        assert_eq!(delayed(&signal, &time, 0.0), signal);
    }

    /// On a smooth motion that is read late, the column says what the torque of the read motion lacks.
    #[test]
    fn says_what_the_late_motion_lacks() {
        let arm = Arm::uniform(3);
        let time: Vec<f64> = (0..400).map(|t| 0.005 * f64::from(t)).collect();
        let wave = |order: i32, phase: f64| {
            let value = |joint: usize, t: f64| {
                let rate = 1.0 + joint as f64;
                0.5 * rate.powi(order) * (rate * t + phase).sin()
            };
            Signals::from_fn(3, time.len(), |joint, t| value(joint, time[t]))
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let (q, qd, qdd) = (wave(0, 0.0), wave(1, quarter), wave(2, 2.0 * quarter));
        let truth = arm.inverse_dynamics_along(&q, &qd, &qdd);
        let mut reading = Trajectory::new("", Channels { time, q, qd, qdd, tau: truth.clone() }).unwrap();
        EFFECT.misread(&mut reading, 0, &[0.01]);
        let load = Load::of_arm(&arm, &reading);
        let kinds = [JointKind::Revolute; 3];
        let motion = Motion {
            trajectory: &reading,
            kinds: &kinds,
            posture: arm.posture,
            gravity: arm.gravity,
            arm: None,
            chain: None,
            load: Some(&load),
            reversal_widths: &[],
        };
        let column = &EFFECT.columns(&motion, 0, &[0.01]).unwrap()[0];
        for (joint, torque) in &column.parts {
            let joint = *joint;
            let lack = |t: usize| truth[joint][t] - load.torque[joint][t];
            let largest = (10..390).map(|t| lack(t).abs()).fold(0.0, f64::max);
            for t in 10..390 {
                assert!((0.01 * torque[t] - lack(t)).abs() < 1e-3 * largest, "{} is not {}", 0.01 * torque[t], lack(t));
            }
        }
    }
}
