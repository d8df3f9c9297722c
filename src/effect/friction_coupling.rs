use super::*;

/// Viscous friction of a transmission that two neighbouring joints share.
pub struct FrictionCoupling;

static SPEC: Spec = Spec {
    id: "friction-coupling",
    name: "friction coupling",
    formula: "tau_j = d * qd_i, tau_i = d * qd_j, i the joint before j",
    typeset: r"\tau_j = d\,\dot q_i,\quad \tau_i = d\,\dot q_j",
    description: "A belt or differential turns with the sum of two joints, so each feels the friction of the \
                  other's motion. Named by the later joint.",
    fingerprint: "Residual against the velocity of the neighbouring joint: a straight line through the origin.",
    absorbed: "Nothing: a Lagrangian is conservative.",
    look_alikes: &[],
    source: "Janot, Vandanjon and Gautier, IEEE Trans. Control Syst. Technol. 22 (2014) 132 (joints 5 and 6 of the \
             TX40)",
    scope: Scope::Pair,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec {
        name: "coupling_coefficient",
        symbol: "d",
        dimension: Dimension::Damping,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for FrictionCoupling {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let [before, joint] = motion.pair(&SPEC, joint)?;
        let qd = &motion.trajectory.qd;
        Ok(vec![Column { parts: vec![(before, qd[joint].clone()), (joint, qd[before].clone())] }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_joint_of_the_pair_feels_the_other() {
        let sample = testing::Sample::new();
        let torque = torque(&FrictionCoupling, &sample.motion(), 1, &[0.3]).unwrap();
        for t in 0..sample.trajectory.len() {
            assert_eq!(torque[0][t], 0.3 * sample.trajectory.qd[1][t]);
            assert_eq!(torque[1][t], 0.3 * sample.trajectory.qd[0][t]);
            assert_eq!(torque[2][t], 0.0);
        }
        assert!(FrictionCoupling.columns(&sample.motion(), 0, &[]).is_err(), "there is none before the first joint");
        assert!(FrictionCoupling.columns(&sample.motion(), 3, &[]).is_err());
    }
}
