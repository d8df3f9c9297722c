use super::*;
use crate::arm::regressor;

/// A link whose centre of mass lies beside the line between its joints.
pub static EFFECT: Effect = Effect {
    id: "com-offset",
    name: "centre of mass beside the link",
    formula: "tau = lambda * d(tau)/d(angle of the link's first moment)",
    typeset: r"\tau = \lambda\,\partial\tau/\partial\theta_{\mathrm{m}}",
    description: "The first moment of a link, with what it carries at its end, does not point along the line between its \
                  joints but has lambda times as much beside it as along it, the tangent of the angle by which it leans: a motor \
                  or a cable at the side, a bent link.",
    fingerprint: "The joint and all before it, against position: a quarter period away from the gravity torque of that link.",
    absorbed: "Nothing: the planar rigid body has its centres of mass on the lines between the joints. A learned Lagrangian \
               absorbs all of it, and so do the base parameters of an arm in space.",
    source: "Khalil and Dombre, Modeling, Identification and Control of Robots, 2002: first moments mX and mY of a link",
    stage: Stage::Body(&ComOffset),
    family: Family::CentreOfMass,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("lean", "λ", Dimension::Ratio).between(-1.5, 1.5)],
    facts: Facts { depends_on_load: true, also_said_as: &["base-tilt"], ..Facts::USUAL },
};

struct ComOffset;

impl AddsTorque for ComOffset {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let Channels { q, qd, qdd, .. } = &**motion.trajectory;
        if q.joint_count() < 2 {
            return Err(Lack::SecondJoint);
        }
        let lumped = motion.load()?.lumped.as_ref().ok_or(Lack::PlanarArm)?;
        let (posture, gravity) = (motion.posture, motion.gravity);
        let mut column = Column::on_all(regressor::leaning_along(posture, gravity, lumped, joint, q, qd, qdd));
        column.parts.truncate(joint + 1);
        Ok(vec![column])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sideways masses written out: positions of points in the plane, their accelerations by differences, and moments of force.
    #[test]
    fn is_what_a_point_beside_the_line_needs_more() {
        let sample = testing::Sample::new();
        let Channels { q, qd, qdd, .. } = &*sample.trajectory;
        let arm = &sample.arm;
        let moment = arm.lumped_parameters()[regressor::parameter_count(3) - 2];
        let lean = 0.3;
        let torque = EFFECT.torque(&sample.motion(), 1, &[lean]).unwrap();
        assert!(torque[2].iter().all(|&value| value == 0.0));
        // A first moment of lean · G₂ at a right angle to link 2, carried by its joint.
        let theta = |angles: &[f64]| arm.posture.zero_angle + arm.posture.sign() * (angles[0] + angles[1]);
        let joint = |angles: &[f64]| {
            let first = arm.posture.zero_angle + arm.posture.sign() * angles[0];
            [arm.links[0].length * first.cos(), arm.links[0].length * first.sin()]
        };
        let side = |angles: &[f64]| {
            let turned = theta(angles) + arm.posture.sign() * std::f64::consts::FRAC_PI_2;
            [turned.cos(), turned.sin()]
        };
        for t in 0..sample.trajectory.len() {
            let at = |time: f64| [0, 1].map(|j| q[j][t] + qd[j][t] * time + 0.5 * qdd[j][t] * time * time);
            let h = 1e-4;
            let second = |point: &dyn Fn(&[f64]) -> [f64; 2]| {
                let [before, now, after] = [-h, 0.0, h].map(|time| point(&at(time)));
                [0, 1].map(|axis| (before[axis] - 2.0 * now[axis] + after[axis]) / (h * h))
            };
            let here = at(0.0);
            let (place, arm_point) = (joint(&here), side(&here));
            let (of_joint, of_side) = (second(&joint), second(&side));
            let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
            let pull = [of_joint[0], of_joint[1] + arm.gravity];
            let about_second = cross(arm_point, pull);
            let about_first = about_second + cross(place, of_side);
            for (joint, expected) in [about_first, about_second].into_iter().enumerate() {
                let expected = arm.posture.sign() * lean * moment * expected;
                assert!((torque[joint][t] - expected).abs() < 1e-4, "{} is not {expected}", torque[joint][t]);
            }
        }
        assert!(EFFECT.columns(&Motion { load: None, ..sample.motion() }, 1, &[]).is_err());
    }
}
