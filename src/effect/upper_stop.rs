use super::*;

/// An elastic stop at the upper end of the way.
pub static EFFECT: Effect = Effect {
    id: "upper-stop",
    name: "upper end stop",
    formula: "tau = k * max(0, q - q_u)",
    typeset: r"\tau = k\,\max(0, q - q_u)",
    description: "A rubber bumper or a stretched cable above q_u, at any angle: nothing before it, a spring beyond. It pushes \
                  back down; a stop at the other end is an effect of its own.",
    fingerprint: "Residual against position: flat with a knee at the upper end, the same at every speed and direction.",
    absorbed: "A rigid body absorbs little of it; a learned potential V(q) absorbs all of it. Only a stop that was touched \
               shows.",
    source: "Hunt and Crossley, J. Appl. Mech. 42 (1975) 440 (without its damping)",
    stage: Stage::Body(&UpperStop),
    family: Family::Spring,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("stop_stiffness", "k", Dimension::Stiffness).at_least(0.0),
        // A stop that is touched most of the time is a spring.
        ParameterSpec::place("stop_position", "q_u", &[0.5, 0.6, 0.7, 0.8, 0.9]),
    ],
    facts: Facts { goes_with: &["torque-offset"], ..Facts::USUAL },
};

struct UpperStop;

impl AddsTorque for UpperStop {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let beyond = |&q: &f64| (q - shape[0]).max(0.0);
        Ok(vec![Column::on_joint(joint, motion.trajectory.q[joint].iter().map(beyond))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["max(q - q_u, 0)"], &["q_u"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        let formula = |q: f64| if q > -0.2 { 30.0 * (q + 0.2) } else { 0.0 };
        testing::assert_is(&EFFECT, &[30.0, -0.2], |q, _, _| formula(q));
    }
}
