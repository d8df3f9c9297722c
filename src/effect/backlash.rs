use std::f64::consts::TAU;

use super::*;

/// Play between teeth that the rotor must cross.
pub static EFFECT: Effect = Effect {
    id: "backlash",
    name: "backlash",
    formula: "tau = tau_b * s * sin(2 pi (t - t_0) / T_b) for t_0 < t < t_0 + T_b, s the new sign of tau_load since t_0",
    typeset: r"\tau = \tau_b\, s \sin\frac{2\pi (t - t_0)}{T_b},\quad t_0 < t < t_0 + T_b",
    description: "Whenever the transmitted torque changes its sign, at t_0, the teeth part, and the rotor must cross the \
                  gap to their other flanks within T_b: it is speeded up and stopped again, beside the link, whose \
                  angle is measured. With the inertia I_r of the rotor the gap is tau_b T_b^2 / (2 pi I_r).",
    fingerprint: "Residual against time: short bursts, up and down, wherever the predicted torque goes through zero.",
    absorbed: "Nothing. Where the torque never changes its sign there is none.",
    source: "Nordin and Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002) 1633; the \
             crossing as a cycloid",
    stage: Stage::Body(&Backlash),
    family: Family::Elasticity,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::linear("crossing_torque", "τ_b", Dimension::Torque).at_least(0.0),
        ParameterSpec::shape("crossing_time", "T_b", Dimension::Time, &[0.05, 0.08, 0.13, 0.2]).between(1e-3, 2.0),
    ],
    facts: Facts {
        depends_on_load: true,
        encoder: Some(Side::Link),
        other_side: Some("motor-side-backlash"),
        goes_with: &["rotor-inertia"],
        ..Facts::USUAL
    },
};

struct Backlash;

impl AddsTorque for Backlash {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let load = &motion.load()?.torque[joint];
        let burst = crossings(&motion.trajectory.time, load, shape[0]).into_iter();
        let burst = burst.map(|(part, sign)| sign * (TAU * part).sin());
        Ok(vec![Column::on_joint(joint, burst)])
    }
}

/// How far the teeth are on their way to the other flanks (0 to 1, 1 where they rest), and to which sign of the load; at exactly
/// zero it has the sign that it had before.
pub(super) fn crossings(time: &[f64], load: &[f64], crossing_time: f64) -> Vec<(f64, f64)> {
    let mut change: Option<f64> = None;
    let mut sign = 0.0;
    let mut before = (0.0, 0.0);
    let mut crossings = Vec::with_capacity(time.len());
    for (&time, &load) in time.iter().zip(load) {
        if load * sign < 0.0 {
            let (time_before, load_before) = before;
            let share = load_before / (load_before - load);
            change = Some(time_before + share * (time - time_before));
        }
        if load != 0.0 {
            sign = load.signum();
        }
        before = (time, load);
        let part = change.map_or(1.0, |start| ((time - start) / crossing_time).min(1.0));
        crossings.push((part, sign));
    }
    crossings
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The load of joint 2 of the sample changes its sign at 0.07 s, to minus, and at 0.15 s, to plus.
    #[test]
    fn bursts_after_each_change_of_sign() {
        let sample = testing::Sample::new();
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.5, 0.03]).unwrap();
        for (t, &time) in sample.trajectory.time.iter().enumerate() {
            let burst = |start: f64| {
                let part = (time - start) / 0.03;
                if (0.0..1.0).contains(&part) { 0.5 * (TAU * part).sin() } else { 0.0 }
            };
            // Between samples the change is found on a straight line, so it is a bit off.
            let expected = burst(0.15) - burst(0.07);
            assert!((torque[1][t] - expected).abs() < 0.02, "{time}: {} is not {expected}", torque[1][t]);
        }
        assert!(torque[1].iter().any(|value| value.abs() > 0.3));
        assert!(torque[0].iter().zip(&torque[2]).all(|(a, b)| *a == 0.0 && *b == 0.0));
    }
}
