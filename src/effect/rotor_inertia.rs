use super::*;

/// The motor's own inertia, seen through the gear.
pub struct RotorInertia;

static SPEC: Spec = Spec {
    id: "rotor-inertia",
    name: "rotor inertia",
    formula: "tau = I_r * qdd",
    typeset: r"\tau = I_r\,\ddot q",
    description: "The rotor turns faster than the joint by the gear ratio N, so its inertia counts N² times.",
    fingerprint: "Residual against acceleration: a straight line through the origin.",
    absorbed: "At the first joint it can't be told from the first link's inertia, unless the arm's parameters are stated. A \
               learned mass matrix absorbs all of it.",
    look_alikes: &[],
    source: "Spong, Hutchinson and Vidyasagar, Robot Modeling and Control; Leboutet et al., Appl. Sci. 11 (2021) 4303",
    scope: Scope::Joint,
    axis: Axis::Acceleration,
    parameters: &[ParameterSpec {
        name: "reflected_inertia",
        symbol: "I_r",
        dimension: Dimension::Inertia,
        min: 0.0,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for RotorInertia {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.qdd[joint].iter().copied())])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&RotorInertia, &[0.6], |_, _, qdd| 0.6 * qdd);
    }
}
