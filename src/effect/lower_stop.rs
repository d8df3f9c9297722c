use super::*;

/// An elastic stop at the lower end of the way.
pub static EFFECT: Effect = Effect {
    id: "lower-stop",
    name: "lower end stop",
    formula: "tau = -k * max(0, q_l - q)",
    typeset: r"\tau = -k\,\max(0, q_l - q)",
    description: "A rubber bumper or a stretched cable below q_l, at any angle: nothing before it, a spring beyond. It pushes \
                  back up; a stop at the other end is an effect of its own.",
    fingerprint: "Residual against position: flat with a knee at the lower end, the same at every speed and direction.",
    absorbed: "A rigid body absorbs little of it; a learned potential V(q) absorbs all of it. Only a stop that was touched \
               shows.",
    source: "Hunt and Crossley, J. Appl. Mech. 42 (1975) 440 (without its damping)",
    stage: Stage::Body(&LowerStop),
    family: Family::Spring,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("stop_stiffness", "k", Dimension::Stiffness).at_least(0.0),
        // A stop that is touched most of the time is a spring.
        ParameterSpec::place("stop_position", "q_l", &[0.1, 0.2, 0.3, 0.4, 0.5]),
    ],
    facts: Facts { goes_with: &["torque-offset"], ..Facts::USUAL },
};

struct LowerStop;

impl AddsTorque for LowerStop {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let beyond = |&q: &f64| (q - shape[0]).min(0.0);
        Ok(vec![Column::on_joint(joint, motion.trajectory.q[joint].iter().map(beyond))])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["min(q - q_l, 0)"], &["q_l"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        let formula = |q: f64| if q < -0.2 { 30.0 * (q + 0.2) } else { 0.0 };
        testing::assert_is(&EFFECT, &[30.0, -0.2], |q, _, _| formula(q));
    }
}
