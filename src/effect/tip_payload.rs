use super::*;
use crate::arm::Link;

/// A point mass at the end of the last link.
pub struct TipPayload;

static SPEC: Spec = Spec {
    id: "tip-payload",
    name: "tip payload",
    formula: "tau = m_p * (J^T (a_tip + g))",
    typeset: r"\tau = m_p\, J^{\mathsf T}(\ddot p_{\mathrm{tip}} + g)",
    description: "A load at the tip that the model does not know: a tool, a cable, a work piece.",
    fingerprint: "All joints at once, in the proportions of gravity and inertia at the tip: residual against position.",
    absorbed: "The base parameters absorb all of a payload that never changes. It can be named only beside a stated arm.",
    source: "Khalil, Gautier and Lemoine on payload identification, ICRA 2007; closed form of the planar arm",
    scope: Scope::Arm,
    axis: Axis::Position,
    parameters: &[ParameterSpec {
        name: "payload_mass",
        symbol: "m_p",
        dimension: Dimension::Mass,
        min: 0.0,
        max: f64::INFINITY,
        role: Role::Linear,
    }],
    includes: &[],
};

impl Effect for TipPayload {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, _joint: usize, _shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let arm = motion.arm.ok_or_else(|| NotApplicable {
            effect: SPEC.name,
            reason: "it needs the link lengths: state the arm".to_owned(),
        })?;
        // The torque is linear in the masses, so the torque of a unit mass is that of an arm that has no other mass.
        let mut tip_mass_only = arm.clone();
        for link in &mut tip_mass_only.links {
            *link = Link { mass: 0.0, com: 0.0, inertia: 0.0, length: link.length };
        }
        if let Some(last) = tip_mass_only.links.last_mut() {
            *last = Link { mass: 1.0, com: last.length, ..*last };
        }
        tip_mass_only.posture = motion.posture;
        let trajectory = motion.trajectory;
        Ok(vec![Column::on_all(tip_mass_only.inverse_dynamics_along(&trajectory.q, &trajectory.qd, &trajectory.qdd))])
    }
}
