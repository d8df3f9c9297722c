use super::*;

/// Friction in proportion to speed.
pub struct ViscousFriction;

static SPEC: Spec = Spec {
    id: "viscous-friction",
    name: "viscous friction",
    formula: "tau = d * qd",
    typeset: r"\tau = d\,\dot q",
    description: "Shear of lubricant and back-EMF of a voltage-driven motor: a torque against the motion that grows with speed.",
    fingerprint: "Residual against velocity: a straight line through the origin.",
    absorbed: "Nothing: a Lagrangian is conservative.",
    look_alikes: &[],
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013",
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec {
        name: "viscous_coefficient",
        symbol: "d",
        dimension: Dimension::Damping,
        min: 0.0,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for ViscousFriction {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        Ok(vec![Column::on_joint(joint, motion.trajectory.qd[joint].iter().copied())])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&ViscousFriction, &[0.8], |_, qd, _| 0.8 * qd);
    }
}
