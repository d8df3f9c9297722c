use super::*;

/// A torque that repeats with the position.
pub static EFFECT: Effect = Effect {
    id: "cogging",
    name: "cogging",
    formula: "tau = a * sin(k q) + b * cos(k q)",
    typeset: r"\tau = a \sin k q + b \cos k q",
    description: "Magnets of the motor snap from pole to pole, gears mesh tooth by tooth: k periods for each 2 pi \
                  of the joint.",
    fingerprint: "Residual against position: a wave, the same at every speed and direction.",
    absorbed: "A learned potential V(q) absorbs it if it is fine enough. At k = 1 gravity absorbs it.",
    source: "Holtz and Springob, IEEE Trans. Ind. Electron. 43 (1996) 310",
    stage: Stage::Body(&Cogging),
    family: Family::Ripple,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("sine_torque", "a", Dimension::Torque),
        ParameterSpec::linear("cosine_torque", "b", Dimension::Torque),
        ParameterSpec::wave("wave_number", "k").at_least(1.0),
    ],
    facts: Facts::USUAL,
};

struct Cogging;

impl AddsTorque for Cogging {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let q = &motion.trajectory.q[joint];
        let wave = |wave: fn(f64) -> f64| Column::on_joint(joint, q.iter().map(move |q| wave(shape[0] * q)));
        Ok(vec![wave(f64::sin), wave(f64::cos)])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["sin(k * q)", "cos(k * q)"], &["k"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a quarter of a metre one and a half periods are 37.7 rad/m.
    #[test]
    fn a_short_way_shows_no_slow_wave() {
        let repeats = |wave_number: f64| EFFECT.repeats_along([0.0, 0.25], &[wave_number]);
        assert!(repeats(38.2) && !repeats(37.9) && !repeats(11.2));
    }

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[0.7, -0.3, 7.0], |q, _, _| 0.7 * (7.0 * q).sin() - 0.3 * (7.0 * q).cos());
    }
}
