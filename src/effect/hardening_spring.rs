use super::*;

/// A spring that gets stiffer the further it is bent.
pub static EFFECT: Effect = Effect {
    id: "hardening-spring",
    name: "hardening spring",
    formula: "tau = k_3 * q^3",
    typeset: r"\tau = k_3\,q^3",
    description: "A cable loom, a leaf spring or a rubber joint that stiffens with the angle. A linear part is a \
                  joint spring beside it.",
    fingerprint: "Residual against position: flat in the middle, steep at both ends, the same at every speed and \
                  direction.",
    absorbed: "A rigid body with gravity absorbs little of it; a learned potential V(q) absorbs all of it.",
    source: "Kovacic and Brennan, The Duffing Equation, Wiley 2011",
    stage: Stage::Body(&HardeningSpring),
    family: Family::Spring,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("cubic_stiffness", "k_3", Dimension::CubicStiffness).at_least(0.0)],
    facts: Facts { goes_with: &["torque-offset"], ..Facts::USUAL },
};

struct HardeningSpring;

impl AddsTorque for HardeningSpring {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.q[joint].iter().map(|q| q.powi(3)))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["q^3"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[2.5], |q, _, _| 2.5 * q * q * q);
    }
}
