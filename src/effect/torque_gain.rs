use super::*;

/// A torque reading that is too large or too small by a factor.
pub static EFFECT: Effect = Effect {
    id: "torque-gain",
    name: "torque gain error",
    formula: "tau = gamma * tau_load",
    typeset: r"\tau = \gamma\,\tau_{\mathrm{load}}",
    description: "A wrong motor constant or gear ratio: the joint's torque is read (1 + gamma) times as large as \
                  the rigid body's.",
    fingerprint: "Residual against the torque that the model predicts: a straight line through the origin.",
    absorbed: "One gain on all joints can't be told from heavier links. Gains that differ show, because the joints \
               share their links.",
    source: "Gautier and Briot, Global identification of joint drive gains, J. Dyn. Sys. Meas. Control 136 (2014) \
             051025",
    stage: Stage::Body(&TorqueGain),
    family: Family::Gain,
    scope: Scope::Joint,
    axis: Axis::Position,
    parameters: &[ParameterSpec::linear("gain_error", "γ", Dimension::Ratio).between(-0.9, 10.0)],
    facts: Facts { depends_on_load: true, is_relative: true, left_by: Some(LEFT_BY_LOAD_FRICTION), ..Facts::USUAL },
};

/// Teeth are pressed by what the motor sends, friction included: tau = tau_load + m |tau| sign(qd) has two slopes, 1 / (1 - m) where
/// the motor drives and 1 / (1 + m) where it brakes. Of these the formula of load friction takes half of the difference,
/// mu = m / (1 - m²); their mean is a gain of m² / (1 - m²), which is less than mu² (other friction on the joint presses, too: up to
/// twice as much).
const LEFT_BY_LOAD_FRICTION: LeftBy =
    LeftBy { effect: "load-friction", is_left: |gain, friction| gain[0] > 0.0 && gain[0] < 2.0 * friction[0].powi(2) };

struct TorqueGain;

impl AddsTorque for TorqueGain {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let load = &motion.load()?.torque[joint];
        Ok(vec![Column::on_joint(joint, load.iter().copied())])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["tau_load"], &[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_depends_on_load(&EFFECT, &[-0.1], |load, _, _| -0.1 * load);
    }

    /// Teeth that rub at a fifth of the torque that the motor sends.
    #[test]
    fn load_friction_leaves_a_small_gain() {
        let ratio: f64 = 0.2;
        let [drives, brakes] = [1.0 / (1.0 - ratio), 1.0 / (1.0 + ratio)];
        let (gain, friction) = (0.5 * (drives + brakes) - 1.0, 0.5 * (drives - brakes));
        let load_friction = crate::effect::registry::find("load-friction").unwrap();
        assert!(EFFECT.is_left_by(&[gain], load_friction, &[friction]));
        assert!(!EFFECT.is_left_by(&[-gain], load_friction, &[friction]), "friction makes no torque smaller");
        assert!(!EFFECT.is_left_by(&[0.1], load_friction, &[friction]), "a motor constant is not so nearly right");
        assert!(!EFFECT.is_left_by(&[gain], &EFFECT, &[friction]));
    }
}
