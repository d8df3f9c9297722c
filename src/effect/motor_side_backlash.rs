use std::f64::consts::TAU;

use super::motor_side::Behind;
use super::*;

/// Play between the teeth, behind the motor whose angle is measured.
pub static EFFECT: Effect = Effect {
    id: "motor-side-backlash",
    name: "backlash seen from the motor",
    formula: "tau = tau_load(q - delta s / 2) - tau_load(q), s from the old to the new sign of tau_load within T_b",
    typeset: r"\tau = \tau_{\mathrm{load}}\left(q - \tfrac{1}{2}\delta s\right) - \tau_{\mathrm{load}}(q)",
    description: "Whenever the transmitted torque changes its sign, the teeth part, and the link crosses the gap delta to their other \
                  flanks within T_b. The encoder sits on the motor and sees nothing of that: all joints carry an arm that is a \
                  bit elsewhere, and the jerk of the link. First order in delta.",
    fingerprint: "Residual of all joints against time: short bursts wherever the predicted torque of the joint goes through zero, and a \
                  step of gravity torque between them.",
    absorbed: "Nothing. Where the torque never changes its sign there is none.",
    source: "Nordin and Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002) 1633; the crossing as a \
             cycloid",
    stage: Stage::Body(&MotorSideBacklash),
    family: Family::Elasticity,
    scope: Scope::Joint,
    axis: Axis::Time,
    parameters: &[
        ParameterSpec::linear("gap", "δ", Dimension::Position).between(0.0, 0.5),
        ParameterSpec::shape("crossing_time", "T_b", Dimension::Time, &[0.06, 0.15]).between(1e-3, 2.0),
    ],
    facts: Facts {
        depends_on_load: true,
        encoder: Some(Side::Motor),
        other_side: Some("backlash"),
        goes_with: &["rotor-inertia"],
        ..Facts::USUAL
    },
};

struct MotorSideBacklash;

impl AddsTorque for MotorSideBacklash {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        let load = &motion.load()?.torque[joint];
        Ok(vec![behind(&motion.trajectory.time, load, shape[0]).column(motion, joint)?])
    }
}

/// Where the link is behind its motor for a gap of one, which it crosses as a cycloid.
fn behind(time: &[f64], load: &[f64], crossing_time: f64) -> Behind {
    let state = |(part, sign): (f64, f64)| {
        let turn = TAU * part;
        let position = sign * (part - turn.sin() / TAU - 0.5);
        [position, sign * (1.0 - turn.cos()) / crossing_time, sign * TAU * turn.sin() / crossing_time.powi(2)]
    };
    let states: Vec<[f64; 3]> = backlash::crossings(time, load, crossing_time).into_iter().map(state).collect();
    let part = |number: usize| states.iter().map(|state| state[number]).collect();
    Behind { position: part(0), velocity: part(1), acceleration: part(2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between crossings the link rests on a flank, half of the gap beside where the motor says, to the side to which the load
    /// pushes; on its way it has the rates of its position.
    #[test]
    fn rests_on_a_flank_between_crossings() {
        let time: Vec<f64> = (0..=2000).map(|step| 1e-4 * f64::from(step)).collect();
        // The load changes its sign at 0.05 s, to minus.
        let load: Vec<f64> = time.iter().map(|time| 0.05 - time).collect();
        let behind = behind(&time, &load, 0.08);
        let at = |seconds: f64| (seconds / 1e-4).round() as usize;
        assert_eq!(behind.position[at(0.01)], 0.5);
        assert!((behind.position[at(0.09)]).abs() < 2e-3, "half way it is in the middle");
        assert!((behind.position[at(0.19)] + 0.5).abs() < 1e-12);
        assert!([0.01, 0.19].iter().all(|time| behind.velocity[at(*time)].abs() < 1e-9));
        let rates = [&behind.position, &behind.velocity].map(|signal| central_difference(signal, &time));
        for sample in at(0.055)..at(0.125) {
            for (rate, told) in rates.iter().zip([&behind.velocity, &behind.acceleration]) {
                let most = told.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                assert!((rate[sample] - told[sample]).abs() < 1e-3 * most);
            }
        }
    }
}
