use super::own::Of;
use super::*;

/// Inertia of a transmission that two neighbouring joints share.
pub static EFFECT: Effect = Effect {
    id: "inertia-coupling",
    name: "inertia coupling",
    formula: "tau_j = c * qdd_i, tau_i = c * qdd_j, i the joint before j",
    typeset: r"\tau_j = c\,\ddot q_i,\quad \tau_i = c\,\ddot q_j",
    description: "A rotor that turns with the sum of two joints: each feels the other's acceleration. Named by the \
                  later joint.",
    fingerprint: "Residual against the acceleration of the neighbouring joint: a straight line through the origin.",
    absorbed: "Beside free base parameters a coupling of joints 1 and 2 with c < 0 can't be told from rotor \
               inertia on joint 2, so only c > 0 is sought. A learned mass matrix absorbs all of it.",
    source: "Janot, Vandanjon and Gautier, IEEE Trans. Control Syst. Technol. 22 (2014) 132 (joints 5 and 6 of the \
             TX40)",
    stage: Stage::Body(&InertiaCoupling),
    family: Family::InertiaCoupling,
    scope: Scope::Pair,
    axis: Axis::Acceleration,
    parameters: &[ParameterSpec::linear("coupling_inertia", "c", Dimension::Inertia).at_least(0.0)],
    facts: Facts::USUAL,
};

struct InertiaCoupling;

impl AddsTorque for InertiaCoupling {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let [before, joint] = motion.pair(joint)?;
        let qdd = &motion.trajectory.qdd;
        Ok(vec![Column { parts: vec![(before, qdd[joint].to_vec()), (joint, qdd[before].to_vec())] }])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_pair(&[&[(Of::Before, "qdd"), (Of::Own, "qdd_before")]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_joint_of_the_pair_feels_the_other() {
        let sample = testing::Sample::new();
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.3]).unwrap();
        for t in 0..sample.trajectory.len() {
            assert_eq!(torque[0][t], 0.3 * sample.trajectory.qdd[1][t]);
            assert_eq!(torque[1][t], 0.3 * sample.trajectory.qdd[0][t]);
            assert_eq!(torque[2][t], 0.0);
        }
        assert!(EFFECT.columns(&sample.motion(), 0, &[]).is_err(), "there is none before the first joint");
        assert!(EFFECT.columns(&sample.motion(), 3, &[]).is_err());
    }
}
