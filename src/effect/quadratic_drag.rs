use super::*;

/// Friction in proportion to the square of the speed.
pub struct QuadraticDrag;

static SPEC: Spec = Spec {
    id: "quadratic-drag",
    name: "quadratic drag",
    formula: "tau = c * qd * |qd|",
    typeset: r"\tau = c\,\dot q\,|\dot q|",
    description: "Drag of air or of a flooded gear: it hardly counts at low speed and dominates at high speed.",
    fingerprint: "Residual against velocity: a parabola that opens upwards on the right and downwards on the left.",
    absorbed: "Nothing: a Lagrangian is conservative. Over a narrow range of speeds it looks like viscous friction.",
    look_alikes: &[],
    source: "Duclusaud et al., BAM: extended friction models for servo actuators, arXiv 2410.08650",
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec {
        name: "drag_coefficient",
        symbol: "c",
        dimension: Dimension::QuadraticDamping,
        min: 0.0,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for QuadraticDrag {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![Column::on_joint(joint, qd.iter().map(|&qd| qd * qd.abs()))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&QuadraticDrag, &[0.4], |_, qd, _| if qd < 0.0 { -0.4 * qd * qd } else { 0.4 * qd * qd });
    }
}
