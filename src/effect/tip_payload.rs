use super::*;
use crate::arm::Link;

/// A point mass at the end of the last link.
pub static EFFECT: Effect = Effect {
    id: "tip-payload",
    name: "tip payload",
    formula: "tau = m_p * J^T (a_tip + g e_z)",
    typeset: r"\tau = m_p\, J^{\mathsf T}(\ddot p_{\mathrm{tip}} + g\, e_z)",
    description: "A load at the tip that the model does not know: a tool, a cable, a work piece.",
    fingerprint: "All joints at once, in the proportions of gravity and inertia at the tip: residual against position.",
    absorbed: "The base parameters absorb all of a payload that never changes. It can be named only beside a stated arm.",
    source: "Khalil, Gautier and Lemoine, Identification of the payload inertial parameters, ICRA 2007; closed form of the planar arm",
    stage: Stage::Body(&TipPayload),
    family: Family::Payload,
    scope: Scope::Arm,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("payload_mass", "m_p", Dimension::Mass).at_least(0.0)],
    facts: Facts { absorbed_by_body: true, ..Facts::USUAL },
};

struct TipPayload;

impl AddsTorque for TipPayload {
    fn columns(&self, motion: &Motion, _joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let arm = motion.arm.ok_or(Lack::Arm)?;
        let (links, joints) = (arm.joint_count(), motion.trajectory.joint_count());
        if links != joints {
            return Err(Lack::OtherArm { links, joints });
        }
        if motion.kinds.contains(&JointKind::Prismatic) {
            return Err(Lack::TurningJoints);
        }
        // The torque is linear in the masses, so the torque of a unit mass is that of an arm that has no other mass.
        let mut tip_mass_only = arm.clone();
        for link in &mut tip_mass_only.links {
            *link = Link { mass: 0.0, com: 0.0, inertia: 0.0, length: link.length };
        }
        if let Some(last) = tip_mass_only.links.last_mut() {
            *last = Link { mass: 1.0, com: last.length, ..*last };
        }
        tip_mass_only.posture = motion.posture;
        let trajectory = motion.trajectory;
        Ok(vec![Column::on_all(tip_mass_only.inverse_dynamics_along(&trajectory.q, &trajectory.qd, &trajectory.qdd))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{Arm, Posture};
    use testing::Sample;

    /// The last link with a point mass at its end, by the parallel-axis theorem.
    fn loaded(arm: &Arm, mass: f64) -> Arm {
        let mut arm = arm.clone();
        if let Some(last) = arm.links.last_mut() {
            let total = last.mass + mass;
            let com = (last.mass * last.com + mass * last.length) / total;
            last.inertia += last.mass * (last.com - com).powi(2) + mass * (last.length - com).powi(2);
            (last.mass, last.com) = (total, com);
        }
        arm
    }

    #[test]
    fn is_what_the_arm_needs_more_with_the_mass_than_without() {
        let mut sample = Sample::new();
        sample.arm.links[0].length = 0.6;
        sample.arm.links[2] = Link { mass: 0.8, length: 0.4, com: 0.15, inertia: 0.02 };
        for posture in [Posture::RIGHT, Posture::UP] {
            sample.arm.posture = posture;
            let Channels { q, qd, qdd, .. } = &*sample.trajectory;
            let with = loaded(&sample.arm, 0.9).inverse_dynamics_along(q, qd, qdd);
            let without = sample.arm.inverse_dynamics_along(q, qd, qdd);
            let torque = EFFECT.torque(&sample.motion(), 0, &[0.9]).unwrap();
            for joint in 0..3 {
                for t in 0..sample.trajectory.len() {
                    let expected = with[joint][t] - without[joint][t];
                    assert!((torque[joint][t] - expected).abs() < 1e-11, "{} is not {expected}", torque[joint][t]);
                }
            }
        }
    }

    #[test]
    fn needs_an_arm_that_fits_the_motion() {
        let sample = Sample::new();
        let reason = |motion: Motion| EFFECT.columns(&motion, 0, &[]).unwrap_err().to_string();
        assert!(reason(Motion { arm: None, ..sample.motion() }).contains("state the arm"));
        let two = Arm::uniform(2);
        assert!(reason(Motion { arm: Some(&two), ..sample.motion() }).contains("2 links"));
        let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
        assert!(reason(Motion { kinds: &kinds, ..sample.motion() }).contains("turn"));
    }
}
