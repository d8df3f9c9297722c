use super::*;

/// Elastic stops on both sides of the range.
pub struct EndStop;

static SPEC: Spec = Spec {
    id: "end-stop",
    name: "end stop",
    formula: "tau = k * sign(q) * max(0, |q| - q_e)",
    typeset: r"\tau = k\,\mathrm{sign}(q)\,\max(0, |q| - q_e)",
    description: "Rubber bumpers or a stretched cable at -q_e and q_e: nothing between them, a spring beyond.",
    fingerprint: "Residual against position: flat with a knee on either side, the same at every speed and direction.",
    absorbed: "A rigid body absorbs little of it; a learned potential V(q) absorbs all of it. Only the stops that \
               were touched show.",
    look_alikes: &[],
    source: "Hunt and Crossley, J. Appl. Mech. 42 (1975) 440 (without its damping)",
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec {
            name: "stop_stiffness",
            symbol: "k",
            dimension: Dimension::Stiffness,
            min: 0.0,
            max: f64::INFINITY,
            role: Role::Linear,
        },
        ParameterSpec {
            name: "stop_position",
            symbol: "q_e",
            dimension: Dimension::Position,
            min: 0.01,
            max: 20.0,
            role: Role::Shape { grid: &[0.3, 0.5, 0.7, 0.9, 1.1, 1.3] },
        },
    ],
    includes: &[],
};

impl Effect for EndStop {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    /// A stop that is touched most of the time is a spring.
    fn least_shape(&self, positions: &[f64]) -> Vec<f64> {
        let mut distances: Vec<f64> = positions.iter().map(|q| q.abs()).collect();
        distances.sort_by(f64::total_cmp);
        vec![distances.get(distances.len() / 4).copied().unwrap_or(0.0).max(SPEC.parameters[1].min)]
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let beyond = |&q: &f64| if q.abs() > shape[0] { q - shape[0].copysign(q) } else { 0.0 };
        Ok(vec![Column::on_joint(joint, motion.trajectory.q[joint].iter().map(beyond))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EndStop, &[30.0, 0.6], |q, _, _| match q {
            q if q > 0.6 => 30.0 * (q - 0.6),
            q if q < -0.6 => 30.0 * (q + 0.6),
            _ => 0.0,
        });
    }
}
