use super::*;

/// A gear that twists between the motor and the link.
pub static EFFECT: Effect = Effect {
    id: "joint-elasticity",
    name: "joint elasticity",
    formula: "tau = c * d^2(tau_load)/dt^2, c = I_r / k",
    typeset: r"\tau = c\,\ddot\tau_{\mathrm{load}},\quad c = I_r/k",
    description: "A harmonic drive or belt of stiffness k twists by tau_load / k, so the rotor I_r turns by so much more \
                  than the link, whose angle is measured, and the motor must accelerate it too. 1 / sqrt(c) is the \
                  frequency of the rotor against the locked link.",
    fingerprint: "Residual against acceleration: a line that is steeper the faster the motion; the second derivative of \
                  the predicted torque.",
    absorbed: "Where the motion has a single frequency, rotor inertia and base parameters absorb it.",
    source: "Spong, Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control 109 (1987) 310",
    stage: Stage::Body(&JointElasticity),
    family: Family::Elasticity,
    scope: Scope::Joint,
    axis: Axis::Acceleration,
    parameters: &[ParameterSpec::linear("inertia_over_stiffness", "c", Dimension::TimeSquared).between(0.0, 1.0)],
    facts: Facts {
        depends_on_load: true,
        encoder: Some(Side::Link),
        other_side: Some("motor-side-elasticity"),
        goes_with: &["rotor-inertia"],
        left_by: Some(LEFT_BY_LAG),
        ..Facts::USUAL
    },
};

/// A lag T is a delay or a filter of first order, which differ by T² / 2 of the second derivative; sampling adds to that.
const LEFT_BY_LAG: LeftBy =
    LeftBy { effect: "actuator-lag", is_left: |elasticity, lag| elasticity[0] < lag[0].powi(2) };

struct JointElasticity;

impl AddsTorque for JointElasticity {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let (load, time) = (&motion.load()?.torque[joint], &motion.trajectory.time);
        let curvature = central_difference(&central_difference(load, time), time);
        Ok(vec![Column::on_joint(joint, curvature.into_iter())])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The load of the sample is a parabola in time with the second derivative 80 N m/s².
    #[test]
    fn a_little_of_it_is_what_a_lag_leaves() {
        let [lag, gain] = ["actuator-lag", "torque-gain"].map(|id| registry::find(id).unwrap());
        assert!(EFFECT.is_left_by(&[3e-4], lag, &[0.02]));
        assert!(!EFFECT.is_left_by(&[5e-4], lag, &[0.02]));
        assert!(!EFFECT.is_left_by(&[3e-4], gain, &[0.02]));
    }

    #[test]
    fn is_its_formula() {
        let sample = testing::Sample::new();
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.01]).unwrap();
        assert!(torque[1].iter().all(|value| (value - 0.8).abs() < 1e-9), "{:?}", &torque[1]);
        assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
    }
}
