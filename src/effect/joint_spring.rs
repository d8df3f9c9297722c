use super::*;

/// A linear spring across a joint.
pub struct JointSpring;

static SPEC: Spec = Spec {
    id: "joint-spring",
    name: "joint spring",
    formula: "tau = k * q + tau_0",
    typeset: r"\tau = k\,q + \tau_0",
    description: "A spring, a gas counterweight or a stiff cable across the joint. Its rest position is where k * q + tau_0 = 0.",
    fingerprint: "Residual against position: a straight line, the same at every speed and direction.",
    absorbed: "A rigid body with gravity absorbs little of it; a learned potential V(q) absorbs all of it.",
    look_alikes: &[],
    source: "Jubien and Gautier, Global identification of spring balancer, IROS 2013",
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec {
            name: "stiffness",
            symbol: "k",
            dimension: Dimension::Stiffness,
            min: 0.0,
            max: f64::INFINITY,
            role: Role::Linear,
        },
        ParameterSpec {
            name: "preload",
            symbol: "τ_0",
            dimension: Dimension::Torque,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            role: Role::Linear,
        },
    ],
    includes: &["torque-offset"],
};

impl Effect for JointSpring {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let q = &motion.trajectory.q[joint];
        Ok(vec![Column::on_joint(joint, q.iter().copied()), Column::on_joint(joint, q.iter().map(|_| 1.0))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&JointSpring, &[5.0, -2.0], |q, _, _| 5.0 * q - 2.0);
    }
}
