//! Whole journeys: a hidden effect in, the right name out, and the held-out error falling to the noise floor.

use std::f64::consts::FRAC_PI_2;

use torquescope::arm::{Arm, Link, Posture};
use torquescope::diagnosis::{Note, Report, Verdict};
use torquescope::model::Preset;
use torquescope::model::learned::LearnedPreset;
use torquescope::progress::Monitor;
use torquescope::recording::seal::{HiddenEffect, Seal, Truth};
use torquescope::session::{Command, History, Session};
use torquescope::simulation::{Excitation, Scenario};
use torquescope::training::fit::Plan;

fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).unwrap()
}

fn simulated(scenario: Scenario) -> Session {
    run(Command::Simulate(Box::new(scenario)), &Session::default())
}

fn hiding(effect: &str, joints: &[usize], strength: f64, seed: u64) -> Scenario {
    let mut scenario = Scenario { seed, effects: Vec::new(), ..Scenario::embedded() };
    scenario.effects = scenario.hide_by_strength(effect, joints, strength).unwrap();
    scenario
}

fn report(session: &Session) -> &Report {
    session.report.as_ref().unwrap()
}

fn held_out(session: &Session) -> f64 {
    session.current().unwrap().evaluation.held_out_nmse().iter().sum()
}

/// Adds everything that the report names.
fn add_all(session: &Session) -> Session {
    report(session).effects.iter().fold(session.clone(), |session, effect| {
        run(Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() }, &session)
    })
}

#[test]
fn without_a_hidden_effect_nothing_is_reported() {
    for seed in 0..5 {
        let scenario = Scenario { seed, effects: Vec::new(), ..Scenario::embedded() };
        let session = run(Command::Diagnose, &simulated(scenario));
        assert_eq!(report(&session).verdict, Verdict::NothingMissing, "seed {seed}: {}", report(&session).advice());
        assert!(report(&session).effects.is_empty());
    }
}

#[test]
fn what_was_added_helps_at_higher_speed_too() {
    let slow = hiding("viscous-friction", &[0], 0.1, 5);
    let session = run(Command::Diagnose, &simulated(slow.clone()));
    let (before, after) = (session.current().unwrap().clone(), add_all(&session).current().unwrap().clone());
    let fast = simulated(Scenario { speed_scale: 2.0, ..slow }).recording.unwrap();
    let error = |fitted: &torquescope::model::Fitted| -> f64 {
        let of_trajectory = |trajectory: &torquescope::recording::Trajectory| -> f64 {
            let predicted = fitted.predict(trajectory).unwrap().total;
            let pairs = trajectory.tau.iter().flatten().zip(predicted.iter().flatten());
            pairs.map(|(tau, model)| (tau - model).powi(2)).sum()
        };
        fast.trajectories.iter().map(of_trajectory).sum()
    };
    assert!(error(&after.fitted) < 0.5 * error(&before.fitted));
}

#[test]
fn a_trained_lagrangian_is_told_its_friction_and_its_error_falls() {
    let mut scenario = Scenario { arm: Arm::uniform(2), seed: 8, effects: Vec::new(), ..Scenario::embedded() };
    scenario.effects = scenario.hide_by_strength("coulomb-friction", &[0], 0.15).unwrap();
    let mut plan = Plan::default();
    (plan.options.epochs, plan.options.batch) = (20, 64);
    let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: Box::new(plan) };
    let session = run(Command::Diagnose, &run(train, &simulated(scenario)));
    let named: Vec<(&str, &[usize])> =
        report(&session).effects.iter().map(|effect| (effect.effect.id, effect.joints.as_slice())).collect();
    assert_eq!(named, [("coulomb-friction", [0].as_slice())], "{}", report(&session).advice());
    let (before, after) = (held_out(&session), held_out(&add_all(&session)));
    assert!(after < 0.3 * before, "held-out nMSE {before} -> {after}");
}

/// Slow motion of a light arm: the rigid body's torque hardly tells the lag, but the friction that turns round late does.
#[test]
fn friction_tells_the_lag_behind_it() {
    let link = Link { mass: 0.6, length: 0.16, com: 0.08, inertia: 0.002 };
    let arm =
        Arm { links: vec![link; 2], posture: Posture { zero_angle: -FRAC_PI_2, ..Posture::RIGHT }, ..Arm::uniform(2) };
    let motion = Excitation::SuperposedSines {
        trajectories: 6,
        duration: 20.0,
        rate: 100.0,
        sines: 5,
        lowest_frequency: 0.05,
        highest_frequency: 0.6,
        space: vec![[-1.6, -0.1]; 2],
    };
    let hidden =
        |effect: &str, parameter| HiddenEffect { effect: effect.into(), joint: Some(0), parameters: vec![parameter] };
    let lag = 0.01;
    let effects = vec![hidden("load-friction", 0.4), hidden("actuator-lag", lag)];
    let sensors = Scenario { torque_noise: 0.01, encoder_resolution: Some(1e-4), ..Scenario::embedded() };
    let session = run(Command::Diagnose, &simulated(Scenario { arm, motion, effects, ..sensors }));
    let named: Vec<(&str, &[usize])> =
        report(&session).effects.iter().map(|effect| (effect.effect.id, effect.joints.as_slice())).collect();
    assert_eq!(named, [("load-friction", [0].as_slice()), ("actuator-lag", &[0])], "{}", report(&session).advice());
    let found = &report(&session).effects[1].parameters[0];
    // Its standard error is 6 %, what may act unseen included, so its interval judges it.
    let [low, high] = found.interval.unwrap();
    assert!(low < lag && lag < high && high - low < 0.25 * lag, "{found:?}");
}

/// Teeth that rub at a fifth of the torque that the motor sends, which is a little more than the load: what that leaves of the formula is
/// no wrong motor constant, and nothing unknown.
#[test]
fn friction_under_the_torque_of_the_motor_is_load_friction_alone() {
    let ratio: f64 = 0.2;
    let [drives, brakes] = [1.0 / (1.0 - ratio), 1.0 / (1.0 + ratio)];
    let hidden =
        |effect: &str, parameter| HiddenEffect { effect: effect.into(), joint: Some(1), parameters: vec![parameter] };
    let effects =
        vec![hidden("load-friction", 0.5 * (drives - brakes)), hidden("torque-gain", 0.5 * (drives + brakes) - 1.0)];
    let session = run(Command::Diagnose, &simulated(Scenario { effects, ..Scenario::embedded() }));
    let report = report(&session);
    let named: Vec<(&str, &[usize])> =
        report.effects.iter().map(|effect| (effect.effect.id, effect.joints.as_slice())).collect();
    assert_eq!(named, [("load-friction", [1].as_slice())], "{}", report.advice());
    assert!(report.unexplained_joints.is_empty(), "{}", report.advice());
    let gain = report.presence.iter().find(|one| one.effect.id == "torque-gain" && one.joint == Some(1));
    assert!(gain.is_none(), "{gain:?}");
}

#[test]
fn the_diagnosis_can_not_read_the_seal() {
    let honest = simulated(hiding("joint-spring", &[2], 0.1, 3));
    let mut recording = honest.recording.as_deref().unwrap().clone();
    let truth = recording.seal.as_ref().unwrap().open().unwrap();
    let lie = HiddenEffect { effect: "coulomb-friction".into(), joint: Some(0), parameters: vec![9.0] };
    recording.seal = Some(Seal::close(&Truth { effects: vec![lie], ..truth }));
    let lied_to = Session { recording: Some(recording.clone().into()), ..honest.clone() };
    recording.seal = None;
    let unsealed = Session { recording: Some(recording.into()), ..honest.clone() };
    let answer = |session: &Session| serde_json::to_string(report(&run(Command::Diagnose, session))).unwrap();
    let expected = answer(&honest);
    assert!(expected.contains("joint-spring"));
    assert_eq!(answer(&lied_to), expected);
    assert_eq!(answer(&unsealed), expected);
}

#[test]
fn the_truth_stays_closed_until_the_user_opens_it() {
    let session = run(Command::Diagnose, &simulated(Scenario::embedded()));
    assert!(session.truth.is_none());
    assert!(run(Command::OpenSeal, &session).truth.is_some());
}

#[test]
fn each_addition_is_a_step_that_can_be_undone() {
    let mut history = History::new(run(Command::Diagnose, &simulated(Scenario::embedded())));
    let error_before = held_out(history.current());
    let added = add_all(history.current());
    history.push(added, "add Coulomb friction");
    assert_eq!(history.current().ladder.len(), 2);
    assert!(held_out(history.current()) < 0.3 * error_before);
    history.undo();
    assert_eq!(history.current().ladder.len(), 1);
    assert_eq!(held_out(history.current()), error_before);
    history.redo();
    let back = run(Command::GoTo { step: 0 }, history.current());
    assert_eq!(held_out(&back), error_before);
}

#[test]
fn a_payload_is_known_only_beside_a_stated_arm() {
    let unstated = simulated(Scenario { stated: false, ..hiding("tip-payload", &[0], 0.1, 4) });
    let session = run(Command::Diagnose, &unstated);
    assert_eq!(report(&session).verdict, Verdict::NothingMissing);
    assert!(report(&session).advice().contains("state the arm"), "{}", report(&session).advice());
    let command = Command::AddEffect { effect: "tip-payload".into(), joints: vec![] };
    let message = command.run(&session, &Monitor::new()).unwrap_err().to_string();
    assert!(message.contains("state the arm"), "{message}");
}

#[test]
fn the_stated_arm_is_a_preset_of_its_own() {
    let session = simulated(hiding("tip-payload", &[0], 0.1, 4));
    let stated = run(Command::ChoosePreset(Preset::StatedArm), &session);
    assert!(held_out(&stated) > 3.0 * held_out(&session), "the stated arm does not know the payload");
    let found = run(Command::Diagnose, &stated);
    assert_eq!(report(&found).effects[0].effect.id, "tip-payload");
}

#[test]
fn a_stop_ends_the_work_and_leaves_the_session() {
    let monitor = Monitor::new();
    monitor.stop("the user changed their mind");
    let error = Command::Simulate(Box::new(Scenario::embedded())).run(&Session::default(), &monitor).unwrap_err();
    assert!(error.to_string().contains("changed their mind"));
}

/// In the held-out runs the last link pushes against something that is not there in training.
#[test]
fn what_fits_in_training_only_is_no_answer() {
    let clean = simulated(Scenario { effects: Vec::new(), ..Scenario::embedded() });
    let split = clean.split.clone();
    let mut recording = clean.recording.as_deref().unwrap().clone();
    for segment in &split.held_out {
        let mut torque = recording.trajectories[segment.trajectory].channels_mut().tau;
        torque[2][segment.samples.clone()].iter_mut().for_each(|tau| *tau += 5.0);
    }
    let pushing = Session { recording: Some(recording.into()), split, ..Session::default() };
    let session = run(Command::Diagnose, &run(Command::ChoosePreset(Preset::RigidBody), &pushing));
    let report = report(&session);
    assert_eq!((report.verdict, &report.unexplained_joints), (Verdict::UnknownEffect, &vec![2]), "{}", report.advice());
    assert!(report.effects.is_empty() && report.notes.contains(&Note::FailsOnHeldOut { joints: vec![2] }));
    let complete: Vec<bool> = report.completeness.iter().map(|one| one.complete).collect();
    assert_eq!(complete, [true, true, false]);
    assert!(report.advice().contains("On held-out data the error of joint 3 is far larger than in training"));
}

#[test]
fn data_that_can_not_answer_get_an_honest_answer() {
    let still = |change: fn(&mut torquescope::recording::Recording)| {
        let mut recording = simulated(Scenario::embedded()).recording.as_deref().unwrap().clone();
        change(&mut recording);
        let split = torquescope::recording::split::Split::automatic(&recording);
        let session = Session { recording: Some(recording.into()), split, ..Session::default() };
        Command::ChoosePreset(Preset::RigidBody)
            .run(&session, &Monitor::new())
            .and_then(|session| Command::Diagnose.run(&session, &Monitor::new()))
    };
    let zero_torque = still(|recording| {
        for trajectory in &mut recording.trajectories {
            trajectory.channels_mut().tau.values_mut().fill(0.0);
        }
    });
    assert!(zero_torque.unwrap_err().to_string().contains("torque is zero"));
    let fifty_samples = still(|recording| {
        recording.trajectories = vec![recording.trajectories[0].slice(0..50)];
    });
    if let Ok(session) = fifty_samples {
        assert!(report(&session).effects.iter().all(|effect| effect.presence < 1.0));
    }
    let one_joint_still = still(|recording| {
        for trajectory in &mut recording.trajectories {
            let run = trajectory.channels_mut();
            for mut signal in [run.q, run.qd, run.qdd] {
                signal[2].fill(0.0);
            }
        }
    });
    let session = one_joint_still.unwrap();
    assert!(
        report(&session).effects.iter().all(|effect| !effect.joints.contains(&2)),
        "{:?}",
        report(&session).effects
    );
}
