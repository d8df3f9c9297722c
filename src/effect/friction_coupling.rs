use super::own::Of;
use super::*;

/// Friction of a transmission that two neighbouring joints share.
pub static EFFECT: Effect = Effect {
    id: "friction-coupling",
    name: "friction coupling",
    formula: "tau_j = d * qd_i + c * sign(qd_i + qd_j), tau_i = d * qd_j + c * sign(qd_i + qd_j), i the joint before j",
    typeset: r"\tau_j = d\,\dot q_i + c\,\mathrm{sign}(\dot q_i + \dot q_j),\quad \tau_i = d\,\dot q_j + c\,\mathrm{sign}(\dot q_i + \dot q_j)",
    description: "A belt or differential turns with the sum of two joints, so each feels the friction of the \
                  other's motion. The viscous part of its own velocity is viscous friction of the joint. Named by the \
                  later joint.",
    fingerprint: "Residual against the velocity of the neighbouring joint: a straight line through the origin, and a \
                  step where the sum of both velocities changes its sign.",
    absorbed: "Nothing: a Lagrangian is conservative.",
    source: "Janot, Vandanjon and Gautier, IEEE Trans. Control Syst. Technol. 22 (2014) 132 (joints 5 and 6 of the \
             TX40)",
    stage: Stage::Body(&FrictionCoupling),
    family: Family::SharedFriction,
    scope: Scope::Pair,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("coupling_coefficient", "d", Dimension::Damping),
        ParameterSpec::linear("coupling_torque", "c", Dimension::Torque).at_least(0.0),
    ],
    facts: Facts::USUAL,
};

struct FrictionCoupling;

impl AddsTorque for FrictionCoupling {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let [before, joint] = motion.pair(joint)?;
        let qd = &motion.trajectory.qd;
        let of_sum: Vec<f64> =
            qd[before].iter().zip(&qd[joint]).map(|(first, second)| motion.direction(joint, first + second)).collect();
        Ok(vec![
            Column { parts: vec![(before, qd[joint].to_vec()), (joint, qd[before].to_vec())] },
            Column { parts: vec![(before, of_sum.clone()), (joint, of_sum)] },
        ])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_pair(&[
            &[(Of::Before, "qd"), (Of::Own, "qd_before")],
            &[(Of::Before, "pair_direction"), (Of::Own, "pair_direction")],
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_joint_of_the_pair_feels_the_other() {
        let sample = testing::Sample::new();
        let torque = EFFECT.torque(&sample.motion(), 1, &[0.3, 0.2]).unwrap();
        for t in 0..sample.trajectory.len() {
            let [first, second] = [sample.trajectory.qd[0][t], sample.trajectory.qd[1][t]];
            let of_sum = 0.2 * (first + second).signum();
            assert!((torque[0][t] - 0.3 * second - of_sum).abs() < 1e-12);
            assert!((torque[1][t] - 0.3 * first - of_sum).abs() < 1e-12);
            assert_eq!(torque[2][t], 0.0);
        }
        assert!(EFFECT.columns(&sample.motion(), 0, &[]).is_err(), "there is none before the first joint");
        assert!(EFFECT.columns(&sample.motion(), 3, &[]).is_err());
    }
}
