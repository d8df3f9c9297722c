use super::*;

/// Velocity and acceleration that come late because they were filtered.
pub struct DerivativeDelay;

static SPEC: Spec = Spec {
    id: "derivative-delay",
    name: "delay of velocity and acceleration",
    formula: "tau = T * (d(tau_load)/d(qd) * qdd + d(tau_load)/d(qdd) * d(qdd)/dt)",
    typeset: r"\tau = T\left(\frac{\partial\tau_{\mathrm{load}}}{\partial\dot q}\,\ddot q + \frac{\partial\tau_{\mathrm{load}}}{\partial\ddot q}\,\dddot q\right)",
    description: "A filter that runs forward only makes q̇ and q̈ late by T beside position and torque, on all joints. \
                  First order in T, so T must be short beside the motion.",
    fingerprint: "All joints at once, against the rate of the acceleration: a rising straight line; inertia and Coriolis \
                  torque lag, gravity does not.",
    absorbed: "Nothing of the part in phase with the velocity.",
    look_alikes: &[],
    source: "Swevers, Verdonck and De Schutter, IEEE Control Systems 27 (2007) 58; first-order expansion",
    scope: Scope::Arm,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec {
        name: "delay",
        symbol: "T",
        dimension: Dimension::Time,
        min: 0.0,
        max: 1.0,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for DerivativeDelay {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn depends_on_load(&self) -> bool {
        true
    }

    fn columns(&self, motion: &Motion, _joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        Ok(vec![Column::on_all(motion.load(&SPEC)?.advanced.clone())])
    }

    /// The torque is right: it is the motion that is read late.
    fn act(&self, _: &Motion, _: usize, _: &[f64], _: &mut PerJoint) -> Result<(), NotApplicable> {
        Ok(())
    }

    fn misread(&self, reading: &mut Trajectory, _joint: usize, parameters: &[f64]) {
        let &[delay] = parameters else { return };
        for signal in reading.qd.iter_mut().chain(&mut reading.qdd) {
            *signal = delayed(signal, &reading.time, delay);
        }
    }
}

/// The signal as it was `delay` \[s\] ago, on straight lines between the samples; before the start it was as at the start.
pub(super) fn delayed(signal: &[f64], time: &[f64], delay: f64) -> Vec<f64> {
    let mut before = 0;
    let value = |now: &f64| {
        let then = now - delay;
        while before + 1 < time.len() && time[before + 1] <= then {
            before += 1;
        }
        match (time.get(before + 1), signal.get(before + 1)) {
            (Some(time_after), Some(after)) if then > time[before] => {
                let share = (then - time[before]) / (time_after - time[before]);
                signal[before] + share * (after - signal[before])
            }
            _ => signal[before],
        }
    };
    time.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delayed_signal_is_that_of_before() {
        let time: Vec<f64> = (0..50).map(|t| 0.01 * f64::from(t)).collect();
        let signal: Vec<f64> = time.iter().map(|t| (3.0 * t).sin()).collect();
        for (t, value) in delayed(&signal, &time, 0.025).iter().enumerate() {
            let expected = (3.0 * (time[t] - 0.025).max(0.0)).sin();
            assert!((value - expected).abs() < 2e-4, "{value} is not {expected}");
        }
        assert_eq!(delayed(&signal, &time, 0.0), signal);
    }

    /// On a smooth motion that is read late, the column says what the torque of the read motion lacks.
    #[test]
    fn says_what_the_late_motion_lacks() {
        let arm = Arm::uniform(3);
        let time: Vec<f64> = (0..400).map(|t| 0.005 * f64::from(t)).collect();
        let wave = |order: i32, phase: f64| -> PerJoint {
            let value = |joint: usize, t: f64| {
                let rate = 1.0 + joint as f64;
                0.5 * rate.powi(order) * (rate * t + phase).sin()
            };
            (0..3).map(|joint| time.iter().map(|&t| value(joint, t)).collect()).collect()
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let (q, qd, qdd) = (wave(0, 0.0), wave(1, quarter), wave(2, 2.0 * quarter));
        let truth = arm.inverse_dynamics_along(&q, &qd, &qdd);
        let mut reading = Trajectory { name: String::new(), time, q, qd, qdd, tau: truth.clone() };
        DerivativeDelay.misread(&mut reading, 0, &[0.01]);
        let load = Load::of_arm(&arm, &reading);
        let kinds = [JointKind::Revolute; 3];
        let motion = Motion { trajectory: &reading, kinds: &kinds, posture: arm.posture, arm: None, load: Some(&load) };
        let torque = torque(&DerivativeDelay, &motion, 0, &[0.01]).unwrap();
        for joint in 0..3 {
            let lack = |t: usize| truth[joint][t] - load.torque[joint][t];
            let largest = (10..390).map(|t| lack(t).abs()).fold(0.0, f64::max);
            for t in 10..390 {
                assert!((torque[joint][t] - lack(t)).abs() < 0.05 * largest, "{} is not {}", torque[joint][t], lack(t));
            }
        }
    }
}
