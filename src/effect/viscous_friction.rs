use super::*;

/// Friction in proportion to speed.
pub static EFFECT: Effect = Effect {
    id: "viscous-friction",
    name: "viscous friction",
    formula: "tau = d * qd",
    typeset: r"\tau = d\,\dot q",
    description: "Shear of lubricant and back-EMF of a voltage-driven motor: a torque against the motion that grows with speed.",
    fingerprint: "Residual against velocity: a straight line through the origin.",
    absorbed: "Nothing: a Lagrangian is conservative.",
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013",
    stage: Stage::Body(&ViscousFriction),
    family: Family::SpeedFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("viscous_coefficient", "d", Dimension::Damping).at_least(0.0)],
    facts: Facts { everyday: true, learned_friction: true, ..Facts::USUAL },
};

struct ViscousFriction;

impl AddsTorque for ViscousFriction {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.qd[joint].iter().copied())])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["qd"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[0.8], |_, qd, _| 0.8 * qd);
    }
}
