use super::*;

/// A gear that twists between the motor and the link.
pub struct JointElasticity;

static SPEC: Spec = Spec {
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
    look_alikes: &[],
    source: "Spong, Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control 109 (1987) 310",
    scope: Scope::Joint,
    axis: Axis::Acceleration,
    parameters: &[ParameterSpec {
        name: "inertia_over_stiffness",
        symbol: "c",
        dimension: Dimension::TimeSquared,
        min: 0.0,
        max: 1.0,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for JointElasticity {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn depends_on_load(&self) -> bool {
        true
    }

    /// A lag T is a delay or a filter of first order, which differ by T² / 2 of the second derivative; sampling adds to that.
    fn is_left_by(&self, own: &[f64], other: &str, others: &[f64]) -> bool {
        other == "actuator-lag" && own[0] < others[0].powi(2)
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let (load, time) = (&motion.load(&SPEC)?.torque[joint], &motion.trajectory.time);
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
        assert!(JointElasticity.is_left_by(&[3e-4], "actuator-lag", &[0.02]));
        assert!(!JointElasticity.is_left_by(&[5e-4], "actuator-lag", &[0.02]));
        assert!(!JointElasticity.is_left_by(&[3e-4], "torque-gain", &[0.02]));
    }

    #[test]
    fn is_its_formula() {
        let sample = testing::Sample::new();
        let torque = torque(&JointElasticity, &sample.motion(), 1, &[0.01]).unwrap();
        assert!(torque[1].iter().all(|value| (value - 0.8).abs() < 1e-9), "{:?}", torque[1]);
        assert!(torque[0].iter().chain(&torque[2]).all(|&value| value == 0.0));
    }
}
