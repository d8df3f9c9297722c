use super::*;

/// Friction in proportion to the square of the speed.
pub static EFFECT: Effect = Effect {
    id: "quadratic-drag",
    name: "quadratic drag",
    formula: "tau = c * qd * |qd|",
    typeset: r"\tau = c\,\dot q\,|\dot q|",
    description: "Drag of air or of a flooded gear: it hardly counts at low speed and dominates at high speed.",
    fingerprint: "Residual against velocity: a parabola that opens upwards on the right and downwards on the left.",
    absorbed: "Nothing: a Lagrangian is conservative. Over a narrow range of speeds it looks like viscous friction.",
    source: "Duclusaud et al., BAM: extended friction models for servo actuators, arXiv 2410.08650",
    stage: Stage::Body(&QuadraticDrag),
    family: Family::SpeedFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[ParameterSpec::linear("drag_coefficient", "c", Dimension::QuadraticDamping).at_least(0.0)],
    facts: Facts::USUAL,
};

struct QuadraticDrag;

impl AddsTorque for QuadraticDrag {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let qd = &motion.trajectory.qd[joint];
        Ok(vec![Column::on_joint(joint, qd.iter().map(|&qd| qd * qd.abs()))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["qd * abs(qd)"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[0.4], |_, qd, _| if qd < 0.0 { -0.4 * qd * qd } else { 0.4 * qd * qd });
    }
}
