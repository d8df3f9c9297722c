use super::bodies::Bodies;
use super::course::{Course, Draws};
use super::moment::Moment;
use super::part::*;
use super::*;
use crate::arm::{GRAVITY, Link, Posture, Sense};
use crate::recording::encoders::Side;
use crate::simulation;

/// Uneven links, in another posture for each number of joints.
fn arm(joints: usize) -> Arm {
    let link = |number: usize| {
        let size = 1.0 + 0.3 * (1.7 * number as f64).sin();
        Link { mass: 2.5 * size * 0.7f64.powi(number as i32), length: 0.35 * size, com: 0.16, inertia: 0.03 * size }
    };
    let sense = if joints.is_multiple_of(2) { Sense::Clockwise } else { Sense::CounterClockwise };
    let posture = Posture { zero_angle: 0.4 * joints as f64, sense };
    Arm { links: (0..joints).map(link).collect(), gravity: GRAVITY, posture }
}

/// Some state and torques of an arm with so many joints.
fn state(joints: usize) -> [Vec<f64>; 3] {
    let wave = |scale: f64, rate: f64| (0..joints).map(|joint| scale * (rate * (joint as f64 + 1.0)).sin()).collect();
    [wave(1.1, 1.3), wave(2.0, 2.1), wave(6.0, 0.9)]
}

/// Acceleration in the first step of so many seconds.
fn first_acceleration(plan: &Plan, [q, qd, tau]: &[Vec<f64>; 3], step: f64) -> Vec<f64> {
    let mut bodies = Bodies::build(plan, q, qd, step).unwrap();
    let mut now = Moment::new(&plan.arm, plan.tilt, step);
    bodies.read(&mut now);
    bodies.step(tau, [].iter());
    bodies.read(&mut now);
    now.qdd
}

fn distance(found: &[f64], expected: &[f64]) -> f64 {
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The engine against H, c and g of the closed form: what is between them is the first order of the engine, and halves with its
/// step.
#[test]
fn bodies_accelerate_as_the_closed_form_says() {
    for joints in 1..=6 {
        let (arm, state) = (arm(joints), state(joints));
        let expected = arm.forward_dynamics(&state[0], &state[1], &state[2]).unwrap();
        let size = expected.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        let error = |step| distance(&first_acceleration(&Plan::bare(&arm), &state, step), &expected) / size;
        let (whole, half) = (error(1e-4), error(5e-5));
        assert!(whole < 2e-3, "{joints} joints: {whole}");
        assert!(whole < 1e-9 || (0.4..0.6).contains(&(half / whole)), "{joints} joints: {whole} and {half}");
    }
}

/// The same with a rotor behind a stiff gear in every other joint: H has its inertia on the diagonal.
#[test]
fn stiff_rotors_add_to_the_diagonal() {
    let (arm, state) = (arm(4), state(4));
    let mut plan = Plan::bare(&arm);
    let mut mass = arm.mass_matrix(&state[0]);
    for (joint, inertia) in [(1, 0.2), (3, 0.05)] {
        Rotor { joint, inertia }.install(&mut plan);
        mass[(joint, joint)] += inertia;
    }
    let [bias, gravity] = [arm.coriolis(&state[0], &state[1]), arm.gravity_torque(&state[0])];
    let excess = nalgebra::DVector::from_fn(4, |joint, _| state[2][joint] - bias[joint] - gravity[joint]);
    let expected = mass.cholesky().unwrap().solve(&excess);
    let error = |step| distance(&first_acceleration(&plan, &state, step), expected.as_slice()) / expected.amax();
    let (whole, half) = (error(1e-4), error(5e-5));
    assert!(whole < 2e-3 && (0.4..0.6).contains(&(half / whole)), "{whole} and {half}");
}

#[test]
fn the_gravity_torque_holds_the_arm_still() {
    for joints in [1, 3, 6] {
        let arm = arm(joints);
        let [q, ..] = state(joints);
        let mut bodies = Bodies::build(&Plan::bare(&arm), &q, &vec![0.0; joints], 1e-4).unwrap();
        let mut now = Moment::new(&arm, 0.0, 1e-4);
        for _ in 0..200 {
            bodies.step(&arm.gravity_torque(&q), [].iter());
        }
        bodies.read(&mut now);
        assert!(distance(&now.q, &q) < 1e-9 && distance(&now.qd, &vec![0.0; joints]) < 1e-8, "{now:?}");
    }
}

/// A falling arm keeps its energy but for the first order of the engine, and the work of a torque is what it gains.
#[test]
fn energy_is_kept_and_work_adds_to_it() {
    let arm = arm(3);
    let [q, ..] = state(3);
    let energy = |q: &[f64], qd: &[f64]| arm.kinetic_energy(q, qd) + arm.potential_energy(q);
    let start = energy(&q, &[0.0; 3]);
    // As a share of the kinetic energy at the end.
    let gone = |step: f64, torque: f64| {
        let mut bodies = Bodies::build(&Plan::bare(&arm), &q, &[0.0; 3], step).unwrap();
        let mut now = Moment::new(&arm, 0.0, step);
        bodies.read(&mut now);
        let mut work = 0.0;
        for _ in 0..(0.5 / step).round() as usize {
            let before = now.q[1];
            bodies.step(&[0.0, torque, 0.0], [].iter());
            bodies.read(&mut now);
            work += torque * (now.q[1] - before);
        }
        (energy(&now.q, &now.qd) - start - work).abs() / arm.kinetic_energy(&now.q, &now.qd)
    };
    for torque in [0.0, 4.0] {
        let (whole, half) = (gone(2e-4, torque), gone(1e-4, torque));
        assert!(whole < 0.01 && half < 0.6 * whole, "{whole} and {half} of the kinetic energy are gone");
    }
}

/// A short motion of two joints with perfect sensors.
fn quiet(parts: Vec<Part>) -> Scenario {
    Scenario {
        name: "test".to_owned(),
        arm: Arm { posture: Posture::DOWN, ..arm(2) },
        motion: Excitation::MultiSine {
            trajectories: 1,
            duration: 5.0,
            rate: 500.0,
            harmonics: 3,
            lowest_frequency: 0.3,
            highest_frequency: 1.0,
            max_position: 1.4,
            max_velocity: 3.0,
        },
        servo: Servo::default(),
        sensors: Sensors { torque_noise: 0.0, ..Sensors::default() },
        parts,
        step: 2e-4,
        seed: 7,
        stated: false,
    }
}

fn truth(recording: &Recording) -> Truth {
    recording.seal.as_ref().unwrap().open().unwrap()
}

/// RMS of what the closed form does not explain over RMS of the torque, by joint.
fn unexplained(scenario: &Scenario, recording: &Recording) -> Vec<f64> {
    let run = &recording.trajectories[0];
    let explained = scenario.arm.inverse_dynamics_along(&run.q, &run.qd, &run.qdd);
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>().sqrt();
    let share = |joint: usize| {
        let (tau, explained) = (&run.tau[joint], &explained[joint]);
        norm(&mut tau.iter().zip(explained).map(|(a, b)| a - b)) / norm(&mut tau.iter().copied())
    };
    (0..run.joint_count()).map(share).collect()
}

#[test]
fn an_empty_world_logs_what_the_arm_needs() {
    let scenario = quiet(Vec::new());
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    assert!(truth(&recording).causes.is_empty());
    let left = unexplained(&scenario, &recording);
    assert!(left.iter().all(|share| *share < 3e-3), "{left:?}");
    let run = &recording.trajectories[0];
    let moved = run.q.iter().all(|q| q.iter().fold(0.0, |most: f64, q| most.max(q.abs())) > 0.5);
    assert!(moved, "it has to move");
}

/// What the seal says is what a log shows: the share of each joint's torque that the closed form does not explain.
#[test]
fn the_sealed_share_is_what_the_log_shows() {
    let dry = DryFriction {
        joint: 0,
        torque: 1.5,
        reach: 5e-4,
        stribeck_torque: 0.7,
        stribeck_velocity: 0.1,
        asymmetry: 0.0,
    };
    let parts = [
        Part::DryFriction(dry),
        Part::LoadFriction(LoadFriction { joint: 1, ratio: 0.2, reach: 5e-4 }),
        Part::SpeedFriction(SpeedFriction { joint: 1, coefficient: 0.4, exponent: 0.6 }),
        Part::Spring(Spring { joint: 0, stiffness: 2.0, cubic_stiffness: 0.0, rest: 0.4 }),
        Part::ConstantTorque(ConstantTorque { joint: 1, torque: 0.5, rate: 0.1 }),
        Part::JointStop(JointStop { joint: 0, low: Some(-0.6), high: None, stiffness: 10.0, damping: 0.1 }),
        Part::Cogging(Cogging { joint: 0, torque: 1.0, wave_number: 9.0, phase: 0.4 }),
        Part::TorqueConstant(TorqueConstant { joint: 1, error: 0.15 }),
        Part::CurrentLoop(CurrentLoop { joint: 0, time: 0.01 }),
        Part::TorqueFilter(TorqueFilter { joint: 1, time: 0.02 }),
        Part::Rotor(Rotor { joint: 1, inertia: 0.05 }),
        Part::BaseTilt(BaseTilt { angle: 0.1 }),
        Part::LeaningLink(LeaningLink { link: 1, beside: 0.03 }),
        Part::TipLoad(TipLoad { mass: 0.3, during: None }),
        Part::TipLoad(TipLoad { mass: 0.3, during: Some([1.0, 3.0]) }),
        Part::DragPlate(DragPlate { link: 1, drag: 3.0 }),
        Part::Cable(Cable { link: 1, anchor: [0.1, 0.5], length: 0.7, stiffness: 30.0 }),
        Part::BiarticularSpring(BiarticularSpring { joint: 1, stiffness: 1.0, rest: 0.2 }),
        Part::Pendulum(Pendulum { mass: 0.3, length: 0.2, damping: 0.002 }),
        Part::Sloshing(Sloshing { mass: 0.3, frequency: 2.5, damping_ratio: 0.05 }),
        Part::Floor(Floor { at: [0.0, -0.65], facing: std::f64::consts::FRAC_PI_2 }),
    ];
    let mut wrong = Vec::new();
    for part in parts {
        let scenario = quiet(vec![part.clone()]);
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let truth = truth(&recording);
        let left = unexplained(&scenario, &recording);
        for cause in &truth.causes {
            // What acts on the whole arm is checked on the joint that it shows most on.
            let found = cause.joint.map_or_else(|| left.iter().copied().fold(0.0, f64::max), |joint| left[joint]);
            let ratio = found / cause.share;
            let tolerance = if cause.joint.is_none() { 0.8..2.0 } else { 0.85..1.15 };
            if cause.share < 0.01 || !tolerance.contains(&ratio) {
                wrong.push(format!("{cause:?}: {found} in {part:?}"));
            }
            // Of what the catalogue does not have it is told how much shows, which is hardly more than all.
            let is_known = crate::effect::registry::find(&cause.effect).is_ok();
            let is_told = match cause.beside_everyday {
                None => is_known,
                Some(beside) => !is_known && (0.0..1.1 * cause.share).contains(&beside),
            };
            if !is_told {
                wrong.push(format!("{cause:?}: what shows of it"));
            }
        }
        if truth.causes.is_empty() {
            wrong.push(format!("{part:?} did nothing"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The twist of an elastic gear: seen from the link it is what the rotor needs beyond turning with the link, and seen from the
/// motor the arm also seems to be elsewhere.
#[test]
fn an_elastic_gear_shows_on_either_side() {
    let gear = ElasticGear { joint: 0, inertia: 0.15, stiffness: 400.0, damping_ratio: 0.1, play: 0.0 };
    for (side, effect) in [(Side::Link, "joint-elasticity"), (Side::Motor, "motor-side-elasticity")] {
        let mut scenario = quiet(vec![Part::ElasticGear(gear.clone())]);
        scenario.sensors.side = side;
        scenario.step = 1e-4;
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let causes = truth(&recording).causes;
        let of = |effect: &str| causes.iter().find(|cause| cause.effect == effect).map(|cause| cause.share);
        assert!(of("rotor-inertia").unwrap() > 0.01, "{causes:?}");
        let twist = of(effect).unwrap_or_default();
        let with_rotor = Scenario { parts: Vec::new(), ..scenario.clone() };
        let run = &recording.trajectories[0];
        let explained = with_rotor.arm.inverse_dynamics_along(&run.q, &run.qd, &run.qdd);
        let rest: Vec<f64> =
            (0..run.len()).map(|t| run.tau[0][t] - explained[0][t] - gear.inertia * run.qdd[0][t]).collect();
        let norm = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
        let left = norm(&rest) / norm(&run.tau[0]);
        assert!((left - twist).abs() < 0.3 * twist + 4e-3, "{side:?}: {left} is not {twist}");
    }
}

#[test]
fn backlash_lets_the_link_rest_on_either_flank() {
    let gear = ElasticGear { joint: 0, inertia: 0.1, stiffness: 2000.0, damping_ratio: 0.2, play: 0.02 };
    let mut scenario = quiet(vec![Part::ElasticGear(gear)]);
    scenario.step = 1e-4;
    // Without weight the torque changes its sign with every swing.
    scenario.arm.gravity = 0.0;
    let seen = |side| {
        let mut scenario = scenario.clone();
        scenario.sensors.side = side;
        simulate(&scenario, &Monitor::new()).unwrap().trajectories.swap_remove(0).q.clone()
    };
    let (link, motor) = (seen(Side::Link), seen(Side::Motor));
    let twists: Vec<f64> = link[0].iter().zip(&motor[0]).map(|(link, motor)| motor - link).collect();
    let (least, most) = twists.iter().fold((0.0, 0.0), |(a, b): (f64, f64), x| (a.min(*x), b.max(*x)));
    assert!(least < -0.01 && most > 0.01, "{least} to {most} rad");
    assert_eq!(link[1], motor[1]);
    let causes = truth(&simulate(&scenario, &Monitor::new()).unwrap()).causes;
    assert!(causes.iter().any(|cause| cause.effect == "backlash" && cause.joint == Some(0)), "{causes:?}");
}

#[test]
fn a_sticking_joint_holds_a_torque_below_its_friction() {
    // Friction above every gravity torque, and a servo that asks for next to nothing.
    let friction = |joint| {
        let torque = 60.0;
        let (stribeck_torque, stribeck_velocity, asymmetry) = (0.0, 0.1, 0.0);
        Part::DryFriction(DryFriction { joint, torque, reach: 1e-3, stribeck_torque, stribeck_velocity, asymmetry })
    };
    let mut scenario = quiet(vec![friction(0), friction(1)]);
    scenario.servo = Servo { bandwidth: 1e-6, damping_ratio: 1.0, model_error: 0.0 };
    scenario.motion = Excitation::MultiSine {
        trajectories: 1,
        duration: 1.0,
        rate: 500.0,
        harmonics: 1,
        lowest_frequency: 0.1,
        highest_frequency: 0.2,
        max_position: 0.5,
        max_velocity: 0.1,
    };
    let run = simulate(&scenario, &Monitor::new()).unwrap().trajectories.swap_remove(0);
    let moved = |q: &[f64]| q.iter().fold(0.0, |most: f64, value| most.max((value - q[0]).abs()));
    assert!(run.q.iter().all(|q| moved(q) < 1e-3), "{:?}", run.q.iter().map(moved).collect::<Vec<_>>());
}

#[test]
fn the_seed_decides_everything() {
    let mut scenario = quiet(vec![Part::BaseTilt(BaseTilt { angle: 0.05 })]);
    scenario.sensors = Sensors { encoder_resolution: Some(1e-4), velocity: false, ..Sensors::default() };
    let once = simulate(&scenario, &Monitor::new()).unwrap();
    assert_eq!(once, simulate(&scenario, &Monitor::new()).unwrap());
    scenario.seed += 1;
    assert_ne!(once.trajectories[0].q, simulate(&scenario, &Monitor::new()).unwrap().trajectories[0].q);
}

#[test]
fn a_world_can_be_stopped() {
    let monitor = Monitor::new();
    monitor.stop("enough");
    let error = simulate(&quiet(Vec::new()), &monitor).unwrap_err();
    assert!(matches!(error, SimulationError::Stopped(_)), "{error}");
}

#[test]
fn drawn_worlds_can_exist_and_come_back_from_their_files() {
    for class in Class::ALL {
        for seed in 0..15 {
            let scenario = draw(seed, class).unwrap();
            scenario.check().unwrap();
            let text = toml::to_string(&scenario).unwrap();
            let back: Scenario = toml::from_str(&text).unwrap();
            assert_eq!(back, scenario, "{text}");
            let expected = match class {
                Class::None => 0..=0,
                Class::Single => 1..=1,
                Class::Several => 2..=3,
                Class::Realistic => 5..=10,
                Class::Geared => {
                    let joints = scenario.arm.joint_count();
                    2 * joints..=3 * joints
                }
                Class::Unknown => 1..=2,
            };
            assert!(expected.contains(&scenario.parts.len()), "{class:?} {seed}: {:?}", scenario.parts);
        }
    }
    assert_eq!(draw(3, Class::Realistic).unwrap(), draw(3, Class::Realistic).unwrap());
    assert_ne!(draw(3, Class::Single).unwrap().arm, draw(4, Class::Single).unwrap().arm);
}

#[test]
fn parts_are_drawn_as_strong_as_they_are_wanted() {
    let scenario = quiet(Vec::new());
    let prescribed = simulation::Scenario {
        arm: scenario.arm.clone(),
        motion: scenario.motion.clone(),
        effects: Vec::new(),
        ..simulation::Scenario::embedded()
    };
    let runs = prescribed.exact_runs(&Monitor::new()).unwrap();
    let course = Course::along(&scenario.arm, &runs[0]);
    let mut random = Draws::new(1, 0);
    let parts = [
        Part::DryFriction(DryFriction::stribeck(0, &course, &mut random)),
        Part::SpeedFriction(SpeedFriction::quadratic(1, &course, &mut random)),
        Part::Cogging(Cogging::drawn(1, &course, &mut random)),
        Part::LeaningLink(LeaningLink::drawn(1, &course, &mut random)),
        Part::Cable(Cable::drawn(0, &course, &mut random)),
    ];
    for mut part in parts {
        let factor = 0.1 / course.strength(&part);
        part.as_install_mut().scale(factor);
        let strength = course.strength(&part);
        assert!((strength - 0.1).abs() < 0.005, "{strength}: {part:?}");
    }
}

/// Each by itself, in the arm of the demonstration.
#[test]
fn every_kind_of_part_can_be_hidden_by_its_name() {
    let prescribed = simulation::Scenario { effects: Vec::new(), ..simulation::Scenario::embedded() };
    let bare = Scenario::of(&prescribed);
    for kind in Kind::ALL {
        assert_eq!(Kind::find(kind.id).unwrap().name, kind.name, "two have one name");
        let mut world = bare.clone();
        world.hide_by_strength(kind, &[1], 0.1).unwrap();
        world.check().unwrap();
        assert_eq!(world.parts.len(), 1);
        if let Some(place) = world.parts[0].as_install().place().filter(|_| kind.first_joint.is_some()) {
            assert_eq!(place, 1, "{}", kind.id);
        }
    }
    let rotor = Kind::find("rotor").unwrap();
    let message = bare.clone().hide_by_strength(rotor, &[0], 0.1).unwrap_err().to_string();
    assert_eq!(message, "rotor behind a stiff gear can't be on joint 1: choose a joint from 2 to 3");
}

#[test]
fn what_can_not_be_is_named() {
    let message = |change: &dyn Fn(&mut Scenario)| {
        let mut scenario = quiet(Vec::new());
        change(&mut scenario);
        scenario.check().unwrap_err().to_string()
    };
    let rotor = || Part::Rotor(Rotor { joint: 1, inertia: 0.1 });
    assert!(message(&|s| s.parts = vec![rotor(), rotor()]).starts_with("joint 2 has two parts that are its rotor"));
    assert!(message(&|s| s.parts = vec![Part::Rotor(Rotor { joint: 2, inertia: 0.1 })]).contains("joint 3"));
    assert!(
        message(&|s| s.parts = vec![Part::Rotor(Rotor { joint: 0, inertia: -1.0 })]).contains("rotor's inertia is -1")
    );
    assert!(message(&|s| s.arm.links[1].inertia = 0.0).contains("link 2 has no moment of inertia"));
    assert!(message(&|s| s.step = 0.1).contains("step is 0.1, but must be 1e-6 to 2e-3 s"));
    let part = |text: &str| toml::from_str::<Part>(text).unwrap_err().to_string();
    assert!(part("kind = 'rotor'\njoint = 0\ninertia = 1").contains("joints and links are counted from 1"));
    assert!(part("kind = 'magic'").contains("unknown variant `magic`"));
}

/// In steps of a tenth of a millisecond the bodies of this arm fly apart, in shorter ones they do not.
#[test]
fn what_diverges_is_done_again_in_shorter_steps() {
    let scenario = draw(7035, Class::Several).unwrap();
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let fastest = (0..recording.joint_count()).map(|joint| recording.top_speed(joint)).fold(0.0, f64::max);
    assert!(fastest < 20.0, "{fastest} rad/s");
}
