use super::coulomb_friction::sign;
use super::*;

/// Dry friction that grows with the torque that the gear transmits.
pub struct LoadFriction;

static SPEC: Spec = Spec {
    id: "load-friction",
    name: "load-dependent friction",
    formula: "tau = mu * |tau_load| * sign(qd)",
    typeset: r"\tau = \mu\,|\tau_{\mathrm{load}}|\,\mathrm{sign}(\dot q)",
    description: "The more torque the teeth of a gear transmit, the harder they rub. The load is the torque that \
                  the rigid body needs.",
    fingerprint: "Residual against velocity, coloured by the size of the torque: a step that opens like a fan.",
    absorbed: "Nothing: a Lagrangian is conservative. Where the load hardly changes it looks like Coulomb friction.",
    look_alikes: &[],
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013",
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec {
        name: "load_friction_ratio",
        symbol: "μ",
        dimension: Dimension::Ratio,
        min: 0.0,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for LoadFriction {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn depends_on_load(&self) -> bool {
        true
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let load = &motion.load(&SPEC)?.torque[joint];
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![Column::on_joint(joint, load.iter().zip(qd).map(|(load, &qd)| load.abs() * sign(qd)))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_depends_on_load(&LoadFriction, &[0.2], |load, _, qd| 0.2 * load.abs() * sign(qd));
    }
}
