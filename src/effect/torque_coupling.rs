use super::own::Of;
use super::*;

/// Torque of one joint that is read, or borne, by its neighbour.
pub static EFFECT: Effect = Effect {
    id: "torque-coupling",
    name: "torque coupling",
    formula: "tau_j = a * tau_load_i, tau_i = b * tau_load_j, i the joint before j",
    typeset: r"\tau_j = a\,\tau_{\mathrm{load},i},\quad \tau_i = b\,\tau_{\mathrm{load},j}",
    description: "A belt or differential leads part of a joint's torque through the motor of its neighbour, or a \
                  sensor feels its neighbour's torque. Named by the later joint.",
    fingerprint: "Residual against the torque that the model predicts for the neighbouring joint: a straight line \
                  through the origin.",
    absorbed: "Base parameters absorb little of it, because the joints share their links.",
    source: "Janot, Vandanjon and Gautier, IEEE Trans. Control Syst. Technol. 22 (2014) 132 (joints 5 and 6 of the \
             TX40)",
    stage: Stage::Body(&TorqueCoupling),
    family: Family::Crosstalk,
    scope: Scope::Pair,
    axis: Axis::Position,
    parameters: &[
        ParameterSpec::linear("share_of_earlier", "a", Dimension::Ratio).between(-2.0, 2.0),
        ParameterSpec::linear("share_of_later", "b", Dimension::Ratio).between(-2.0, 2.0),
    ],
    facts: Facts { depends_on_load: true, ..Facts::USUAL },
};

struct TorqueCoupling;

impl AddsTorque for TorqueCoupling {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let [before, joint] = motion.pair(joint)?;
        let load = &motion.load()?.torque;
        Ok(vec![
            Column::on_joint(joint, load[before].iter().copied()),
            Column::on_joint(before, load[joint].iter().copied()),
        ])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_pair(&[&[(Of::Own, "tau_load_before")], &[(Of::Before, "tau_load")]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_joint_of_the_pair_feels_the_torque_of_the_other() {
        let sample = testing::Sample::new();
        let motion = sample.motion();
        let load = &motion.load.unwrap().torque;
        let torque = EFFECT.torque(&motion, 1, &[0.3, -0.1]).unwrap();
        for t in 0..sample.trajectory.len() {
            assert_eq!(torque[1][t], 0.3 * load[0][t]);
            assert_eq!(torque[0][t], -0.1 * load[1][t]);
            assert_eq!(torque[2][t], 0.0);
        }
        assert!(EFFECT.columns(&motion, 0, &[]).is_err(), "there is none before the first joint");
    }
}
