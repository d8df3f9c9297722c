use super::*;

/// Dry friction that grows with the torque that the gear transmits.
pub static EFFECT: Effect = Effect {
    id: "load-friction",
    name: "load-dependent friction",
    formula: "tau = mu * |tau_load| * sign(qd)",
    typeset: r"\tau = \mu\,|\tau_{\mathrm{load}}|\,\mathrm{sign}(\dot q)",
    description: "The more torque the teeth of a gear transmit, the harder they rub. The load is the torque that \
                  the rigid body needs.",
    fingerprint: "Residual against velocity, coloured by the size of the torque: a step that opens like a fan.",
    absorbed: "Nothing: a Lagrangian is conservative. Where the load hardly changes it looks like Coulomb friction.",
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013",
    stage: Stage::Body(&LoadFriction),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("load_friction_ratio", "μ", Dimension::Ratio).at_least(0.0)],
    facts: Facts { depends_on_load: true, ..Facts::USUAL },
};

struct LoadFriction;

impl AddsTorque for LoadFriction {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let load = &motion.load()?.torque[joint];
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![Column::on_joint(
            joint,
            load.iter().zip(qd).map(|(load, &qd)| load.abs() * motion.direction(joint, qd)),
        )])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["abs(tau_load) * direction"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_depends_on_load(&EFFECT, &[0.2], |load, _, qd| 0.2 * load.abs() * sign(qd));
    }
}
