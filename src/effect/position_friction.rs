use super::*;

/// The part of dry friction that changes with the position.
pub static EFFECT: Effect = Effect {
    id: "position-friction",
    name: "position-dependent friction",
    formula: "tau = (a * sin(k q) + b * cos(k q)) * sign(qd)",
    typeset: r"\tau = (a \sin k q + b \cos k q)\,\mathrm{sign}(\dot q)",
    description: "An eccentric gear or a bent shaft rubs more at some positions than at others. This is the \
                  varying part; its mean is Coulomb friction.",
    fingerprint: "Residual against position: two waves, mirror images of each other, one for each direction of \
                  motion.",
    absorbed: "Nothing: a Lagrangian is conservative.",
    source: "Bittencourt and Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051013",
    stage: Stage::Body(&PositionFriction),
    family: Family::DryFriction,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("sine_torque", "a", Dimension::Torque),
        ParameterSpec::linear("cosine_torque", "b", Dimension::Torque),
        ParameterSpec::shape("wave_number", "k", Dimension::WaveNumber, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
            .between(0.5, 100.0)
            // With less it can't be told from friction that is the same everywhere.
            .shown_from(parameter::half_a_period),
    ],
    facts: Facts::USUAL,
};

struct PositionFriction;

impl AddsTorque for PositionFriction {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let Channels { q, qd, .. } = &**motion.trajectory;
        let wave = |wave: fn(f64) -> f64| {
            let torque =
                q[joint].iter().zip(&qd[joint]).map(move |(q, &qd)| wave(shape[0] * q) * motion.direction(joint, qd));
            Column::on_joint(joint, torque)
        };
        Ok(vec![wave(f64::sin), wave(f64::cos)])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["sin(k * q) * direction", "cos(k * q) * direction"], &["k"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[0.7, -0.3, 2.0], |q, qd, _| {
            (0.7 * (2.0 * q).sin() - 0.3 * (2.0 * q).cos()) * sign(qd)
        });
    }
}
