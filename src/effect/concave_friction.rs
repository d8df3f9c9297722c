use super::*;

/// Friction that grows ever less with the speed.
pub static EFFECT: Effect = Effect {
    id: "concave-friction",
    name: "concave speed friction",
    formula: "tau = c * |qd|^alpha * sign(qd), alpha < 1",
    typeset: r"\tau = c\,|\dot q|^{\alpha}\,\mathrm{sign}(\dot q),\quad \alpha < 1",
    description: "Grease that thins as it is sheared: geared robot joints need ever less torque for each further rad/s. It \
                  stands beside Coulomb friction, which does not grow at all.",
    fingerprint: "Residual against velocity: steep at low speed on both sides, and ever flatter.",
    absorbed: "Nothing: a Lagrangian is conservative. Over a narrow range of speeds it is Coulomb and viscous friction.",
    source: "Waiboer, Aarts and Jonker, Velocity dependence of joint friction in robotic manipulators with gear \
             transmissions, Proc. ECCOMAS Multibody Dynamics (2005): the power law of an elastohydrodynamic film",
    stage: Stage::Body(&ConcaveFriction),
    family: Family::SpeedFriction,
    scope: Scope::Joint,
    axis: Axis::Velocity,
    parameters: &[
        ParameterSpec::linear("film_coefficient", "c", Dimension::Torque).at_least(0.0),
        // Greases have 0.4 to 0.7 (Carvalho Bittencourt and Axelsson, 2014); what grows less than that is dry friction in other words.
        ParameterSpec::shape("film_exponent", "α", Dimension::Ratio, &[0.3, 0.5, 0.7]).between(0.3, 0.9),
    ],
    facts: Facts::USUAL,
};

struct ConcaveFriction;

impl AddsTorque for ConcaveFriction {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        // It is 0 at standstill and does not jump: unlike dry friction it has no width in which it turns round.
        let torque = motion.trajectory.qd[joint].iter().map(|&qd| qd.abs().powf(shape[0]) * sign(qd));
        Ok(vec![Column::on_joint(joint, torque)])
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::on_joint(&["abs(qd)^alpha * sign(qd)"], &["alpha"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_its_formula() {
        testing::assert_is(&EFFECT, &[1.3, 0.5], |_, qd, _| 1.3 * qd.abs().sqrt() * sign(qd));
    }
}
