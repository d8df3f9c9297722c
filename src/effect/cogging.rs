use super::*;

/// A torque that repeats with the position.
pub struct Cogging;

static SPEC: Spec = Spec {
    id: "cogging",
    name: "cogging",
    formula: "tau = a * sin(k q) + b * cos(k q)",
    typeset: r"\tau = a \sin k q + b \cos k q",
    description: "Magnets of the motor snap from pole to pole, gears mesh tooth by tooth: k periods for each 2 pi \
                  of the joint.",
    fingerprint: "Residual against position: a wave, the same at every speed and direction.",
    absorbed: "A learned potential V(q) absorbs it if it is fine enough. At k = 1 gravity absorbs it.",
    look_alikes: &[],
    source: "Holtz and Springob, IEEE Trans. Ind. Electron. 43 (1996) 310",
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec {
            name: "sine_torque",
            symbol: "a",
            dimension: Dimension::Torque,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            role: Role::Linear,
        },
        ParameterSpec {
            name: "cosine_torque",
            symbol: "b",
            dimension: Dimension::Torque,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            role: Role::Linear,
        },
        ParameterSpec {
            name: "wave_number",
            symbol: "k",
            dimension: Dimension::WaveNumber,
            min: 1.0,
            max: 1000.0,
            role: Role::Shape {
                grid: &[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0],
            },
        },
    ],
    includes: &[],
};

impl Effect for Cogging {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let q = &motion.trajectory.q[joint];
        let wave = |wave: fn(f64) -> f64| Column::on_joint(joint, q.iter().map(move |q| wave(shape[0] * q)));
        Ok(vec![wave(f64::sin), wave(f64::cos)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&Cogging, &[0.7, -0.3, 7.0], |q, _, _| 0.7 * (7.0 * q).sin() - 0.3 * (7.0 * q).cos());
    }
}
