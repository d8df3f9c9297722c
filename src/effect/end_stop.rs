use super::*;

/// Elastic stops on both sides of the range.
pub static EFFECT: Effect = Effect {
    id: "end-stop",
    name: "end stop",
    formula: "tau = k * sign(q) * max(0, |q| - q_e)",
    typeset: r"\tau = k\,\mathrm{sign}(q)\,\max(0, |q| - q_e)",
    description: "Rubber bumpers or a stretched cable at -q_e and q_e: nothing between them, a spring beyond.",
    fingerprint: "Residual against position: flat with a knee on either side, the same at every speed and direction.",
    absorbed: "A rigid body absorbs little of it; a learned potential V(q) absorbs all of it. Only the stops that \
               were touched show.",
    source: "Hunt and Crossley, J. Appl. Mech. 42 (1975) 440 (without its damping)",
    stage: Stage::Body(&EndStop),
    family: Family::Spring,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("stop_stiffness", "k", Dimension::Stiffness).at_least(0.0),
        ParameterSpec::shape("stop_position", "q_e", Dimension::Position, &[0.3, 0.5, 0.7, 0.9, 1.1, 1.3])
            .between(0.01, 20.0)
            .shown_from(a_quarter_within),
    ],
    facts: Facts::USUAL,
};

/// A stop that is touched most of the time is a spring.
fn a_quarter_within(positions: &[f64]) -> f64 {
    let mut distances: Vec<f64> = positions.iter().map(|q| q.abs()).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 4).copied().unwrap_or(0.0)
}

struct EndStop;

impl AddsTorque for EndStop {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let beyond = |&q: &f64| if q.abs() > shape[0] { q - shape[0].copysign(q) } else { 0.0 };
        Ok(vec![Column::on_joint(joint, motion.trajectory.q[joint].iter().map(beyond))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[30.0, 0.6], |q, _, _| match q {
            q if q > 0.6 => 30.0 * (q - 0.6),
            q if q < -0.6 => 30.0 * (q + 0.6),
            _ => 0.0,
        });
    }
}
