use super::*;

/// A linear spring across a joint.
pub static EFFECT: Effect = Effect {
    id: "joint-spring",
    name: "joint spring",
    formula: "tau = k * q + tau_0",
    typeset: r"\tau = k\,q + \tau_0",
    description: "A spring, a gas counterweight or a stiff cable across the joint. Its rest position is where k * q + tau_0 = 0.",
    fingerprint: "Residual against position: a straight line, the same at every speed and direction.",
    absorbed: "A rigid body with gravity absorbs little of it; a learned potential V(q) absorbs all of it.",
    source: "Jubien and Gautier, Global identification of spring balancer, IROS 2013",
    stage: Stage::Body(&JointSpring),
    family: Family::Spring,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("stiffness", "k", Dimension::Stiffness).at_least(0.0),
        ParameterSpec::linear("preload", "τ_0", Dimension::Torque),
    ],
    facts: Facts { includes: &["torque-offset"], goes_with: &["torque-offset"], ..Facts::USUAL },
};

struct JointSpring;

impl AddsTorque for JointSpring {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let q = &motion.trajectory.q[joint];
        Ok(vec![Column::on_joint(joint, q.iter().copied()), Column::on_joint(joint, q.iter().map(|_| 1.0))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["q", "1"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[5.0, -2.0], |q, _, _| 5.0 * q - 2.0);
    }
}
