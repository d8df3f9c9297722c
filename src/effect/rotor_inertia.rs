use super::*;

/// The motor's own inertia, seen through the gear.
pub static EFFECT: Effect = Effect {
    id: "rotor-inertia",
    name: "rotor inertia",
    formula: "tau = I_r * qdd",
    typeset: r"\tau = I_r\,\ddot q",
    description: "The rotor turns faster than the joint by the gear ratio N, so its inertia counts N² times.",
    fingerprint: "Residual against acceleration: a straight line through the origin.",
    absorbed: "At the first joint it can't be told from the first link's inertia, unless the arm's parameters are stated. A \
               learned mass matrix absorbs all of it.",
    source: "Spong, Hutchinson and Vidyasagar, Robot Modeling and Control; Leboutet et al., Appl. Sci. 11 (2021) 4303",
    stage: Stage::Body(&RotorInertia),
    family: Family::RotorInertia,
    scope: Scope::Joint,
    axis: Axis::Acceleration,
    parameters: &[ParameterSpec::linear("reflected_inertia", "I_r", Dimension::Inertia).at_least(0.0)],
    facts: Facts { everyday: true, absorbed_by_body: true, ..Facts::USUAL },
};

struct RotorInertia;

impl AddsTorque for RotorInertia {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.qdd[joint].iter().copied())])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["qdd"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[0.6], |_, _, qdd| 0.6 * qdd);
    }
}
