//! Twenty journeys with two hidden effects: both named, added, until the held-out error is down at the noise; then the seal is
//! opened.

use std::collections::BTreeSet;

use torquescope::progress::Monitor;
use torquescope::session::{Command, Session};
use torquescope::simulation::{Excitation, Scenario};

/// One test for each pair, so that they run in parallel: the joints are counted from 1.
macro_rules! pairs {
    ($($name:ident: $first:literal @ $here:literal, $second:literal @ $there:literal);* $(;)?) => {
        $(
            #[test]
            fn $name() {
                journey([($first, $here - 1), ($second, $there - 1)]);
            }
        )*
    };
}

pairs! {
    coulomb_and_viscous: "coulomb-friction" @ 1, "viscous-friction" @ 1;
    coulomb_and_offset: "coulomb-friction" @ 2, "torque-offset" @ 2;
    stribeck_and_spring: "stribeck-friction" @ 1, "joint-spring" @ 3;
    stribeck_and_viscous: "stribeck-friction" @ 2, "viscous-friction" @ 2;
    load_friction_and_viscous: "load-friction" @ 1, "viscous-friction" @ 1;
    drag_and_cogging: "quadratic-drag" @ 1, "cogging" @ 2;
    position_friction_and_offset: "position-friction" @ 2, "torque-offset" @ 1;
    drift_and_spring: "friction-drift" @ 1, "joint-spring" @ 2;
    hysteresis_and_viscous: "dahl-hysteresis" @ 1, "viscous-friction" @ 2;
    slip_and_offset: "maxwell-slip" @ 2, "torque-offset" @ 2;
    coupled_friction_and_coulomb: "friction-coupling" @ 2, "coulomb-friction" @ 1;
    hardening_spring_and_coulomb: "hardening-spring" @ 2, "coulomb-friction" @ 2;
    stop_and_viscous: "upper-stop" @ 1, "viscous-friction" @ 1;
    cogging_and_coulomb: "cogging" @ 1, "coulomb-friction" @ 1;
    tilt_and_coulomb: "base-tilt" @ 1, "coulomb-friction" @ 2;
    coupled_inertia_and_viscous: "inertia-coupling" @ 3, "viscous-friction" @ 1;
    elasticity_and_coulomb: "joint-elasticity" @ 1, "coulomb-friction" @ 2;
    backlash_and_viscous: "backlash" @ 1, "viscous-friction" @ 3;
    gain_and_coulomb: "torque-gain" @ 2, "coulomb-friction" @ 3;
    lag_and_viscous: "actuator-lag" @ 1, "viscous-friction" @ 2;
}

fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).unwrap()
}

/// Both effects on the embedded arm, on fewer and shorter runs.
fn hiding(effects: [(&str, usize); 2]) -> Scenario {
    let mut scenario = Scenario { seed: 21, effects: Vec::new(), ..Scenario::embedded() };
    if let Excitation::MultiSine { trajectories, duration, .. } = &mut scenario.motion {
        (*trajectories, *duration) = (10, 6.0);
    }
    let drawn = effects.map(|(id, joint)| scenario.hide_by_strength(id, &[joint], 0.08).unwrap());
    scenario.effects = drawn.into_iter().flatten().collect();
    scenario
}

fn journey(effects: [(&str, usize); 2]) {
    let simulated = run(Command::Simulate(Box::new(hiding(effects))), &Session::default());
    let before = run(Command::Diagnose, &simulated);
    let report = before.report.as_ref().unwrap();
    let named = report.effects.iter().flat_map(|effect| {
        let places = effect.effect.places(effect.joints.iter().copied());
        places.into_iter().map(|place| (effect.effect.id.to_owned(), place))
    });
    let named: BTreeSet<(String, Option<usize>)> = named.collect();

    let after = report.effects.iter().fold(before.clone(), |session, effect| {
        run(Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() }, &session)
    });
    let evaluation = &after.current().unwrap().evaluation;
    let left: f64 = evaluation.held_out_nmse().iter().sum();
    let floor: f64 = evaluation.noise_floor_nmse.as_ref().unwrap().iter().sum();
    assert!(left < 1.1 * floor, "{left} is left over a floor of {floor}; {}", report.advice());

    let opened = run(Command::OpenSeal, &after);
    let truth = opened.truth.as_ref().unwrap().effects.iter();
    let truth: BTreeSet<(String, Option<usize>)> = truth.map(|hidden| (hidden.effect.clone(), hidden.joint)).collect();
    assert_eq!(named, truth, "{}", report.advice());
}
