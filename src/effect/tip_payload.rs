use nalgebra::{Matrix3, Vector3};

use super::*;
use crate::arm::Link;
use crate::arm::body::Body;
use crate::arm::chain::{Chain, PER_LINK};
use crate::signals::Signals;

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
        if let Some(chain) = motion.chain {
            return Ok(vec![Column::on_all(in_space(chain, motion).ok_or(Lack::Tip)?)]);
        }
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

/// The torque of a unit mass at the tip of an arm in space; `None` where nothing says where that is.
fn in_space(chain: &Chain, motion: &Motion) -> Option<Signals> {
    let tip = chain.axes.last()?.stated?.tip?;
    let (mass, inertia) = (1.0, Matrix3::zeros());
    let point = Body { mass, com: Vector3::from(tip), inertia }.parameters();
    let joints = chain.axes.len();
    let mut parameters = vec![0.0; joints * PER_LINK];
    parameters[(joints - 1) * PER_LINK..].copy_from_slice(&point);
    let sliding: Vec<bool> = motion.kinds.iter().map(|kind| *kind == JointKind::Prismatic).collect();
    let regressor = chain.regressor(&sliding);
    let trajectory = motion.trajectory;
    let mut torque = Signals::zeros(joints, trajectory.len());
    let mut now = vec![0.0; joints];
    for sample in 0..trajectory.len() {
        let [q, qd, qdd] = [&trajectory.q, &trajectory.qd, &trajectory.qdd]
            .map(|channel| channel.iter().map(|joint| joint[sample]).collect::<Vec<f64>>());
        regressor.torque(&q, &qd, &qdd, &parameters, &mut now);
        now.iter().enumerate().for_each(|(joint, value)| torque[joint][sample] = *value);
    }
    Some(torque)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::chain::{Axis as ChainAxis, Convention};
    use crate::arm::stated::Stated;
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

    /// A planar arm as a chain whose tip is stated gives the same torque.
    #[test]
    fn in_space_it_is_the_same_point() {
        let sample = Sample::new();
        let plane = EFFECT.torque(&sample.motion(), 0, &[0.9]).unwrap();
        let lengths: Vec<f64> = sample.arm.links.iter().map(|link| link.length).collect();
        let before = [0.0].into_iter().chain(lengths.iter().copied());
        let mut axes: Vec<ChainAxis> = before.take(3).map(|a| ChainAxis { a, ..ChainAxis::default() }).collect();
        axes[0].theta = sample.arm.posture.zero_angle;
        let gravity = [0.0, -sample.arm.gravity, 0.0];
        let mut chain = Chain { convention: Convention::Modified, axes, gravity };
        let reason = EFFECT.columns(&Motion { arm: None, chain: Some(&chain), ..sample.motion() }, 0, &[]).unwrap_err();
        assert_eq!(reason.lack, Lack::Tip);
        chain.axes[2].stated = Some(Stated { tip: Some([lengths[2], 0.0, 0.0]), ..Stated::default() });
        let motion = Motion { arm: None, chain: Some(&chain), ..sample.motion() };
        let space = EFFECT.torque(&motion, 0, &[0.9]).unwrap();
        for (one, other) in plane.iter().flatten().zip(space.iter().flatten()) {
            assert!((one - other).abs() < 1e-9, "{one} {other}");
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
