//! The learning core as its users see it: right derivatives, the same weights for the same seed, clean ends, clear errors.

use torquescope::arm::{Arm, Posture};
use torquescope::effect::registry;
use torquescope::model::learned::{Architecture, Features, Layers, LearnedPreset, LearnedTerm, Positive, Scales};
use torquescope::model::terms::Setting;
use torquescope::model::{EffectTerm, Evaluation, Fitted, Preset};
use torquescope::network::{Activation, Element, TILE, draw_weights};
use torquescope::progress::{Event, Monitor};
use torquescope::recording::seal::HiddenEffect;
use torquescope::recording::split::Split;
use torquescope::recording::{Channels, JointKind, Recording, Trajectory};
use torquescope::signals::Signals;
use torquescope::simulation::{Excitation, Scenario, simulate};
use torquescope::training::effects::{AddedEffect, columns, names};
use torquescope::training::fit::{Plan, SavedRun, fit, resume, to_bytes};
use torquescope::training::learn::{Begin, Ending, Outcome, TrainingData, train};
use torquescope::training::learned::{Checkpoint, LearnedModel};
use torquescope::training::loss::{SHARE_INPUT, WEIGHT_INPUT, loss_program};
use torquescope::training::optimiser::Optimiser;
use torquescope::training::options::scale_to;
use torquescope::training::predict::component_program;
use torquescope::training::{Options, Precision, Recipe, Samples, TrainError, components};

fn layers(activation: Activation) -> Layers {
    Layers { hidden: vec![7, 5], activation }
}

fn random(seed: u64) -> rand_chacha::ChaCha8Rng {
    rand::SeedableRng::seed_from_u64(seed)
}

/// Architectures that together hold every term, feature, activation and scale.
fn architectures() -> Vec<Architecture> {
    let scales = |weights: &[f64]| Scales {
        velocity: 2.0,
        acceleration: 3.0,
        torque: 5.0,
        inertia: Some(1.5),
        joints: weights.to_vec(),
    };
    let mut all = Vec::new();
    for (preset, activation) in LearnedPreset::ALL.into_iter().zip([
        Activation::Tanh,
        Activation::Silu,
        Activation::Sigmoid,
        Activation::Softplus,
        Activation::Silu,
    ]) {
        all.push(Architecture { scales: scales(&[1.0, 0.1]), ..preset.architecture(2, &layers(activation)) });
    }
    let positive = Positive { shift: 0.5, floor: 0.01, inertia: 0.2 };
    all.push(Architecture {
        joints: 3,
        features: Features::Raw,
        terms: vec![
            LearnedTerm::StructuredLagrangian { layers: layers(Activation::Tanh), positive: Some(positive) },
            LearnedTerm::Columns { names: vec!["spring".into(), "payload".into()] },
        ],
        scales: scales(&[1.0, 0.4, 0.2]),
    });
    for (joints, preset) in [(3, LearnedPreset::DelanFfnn), (1, LearnedPreset::StructuredDelan)] {
        all.push(Architecture {
            features: Features::LinkAngles,
            scales: scales(&[0.3, 1.0, 0.1][..joints]),
            ..preset.architecture(joints, &layers(Activation::Tanh))
        });
    }
    let free = LearnedPreset::StructuredDelan.architecture(2, &layers(Activation::Tanh));
    let terms = free.terms.into_iter().map(|term| term.with_positive(None)).collect();
    all.push(Architecture { joints: 2, features: Features::CosSin, terms, scales: scales(&[]) });
    all.push(Architecture { joints: 1, ..LearnedPreset::DelanFriction.architecture(1, &layers(Activation::Tanh)) });
    all
}

/// Weights of which none is zero.
fn weights(layout: &torquescope::network::Layout, seed: u64) -> Vec<f64> {
    let mut flat = draw_weights::<f64>(layout, &mut random(seed));
    for (index, block) in layout.blocks().iter().enumerate().filter(|(_, block)| block.rows == 1) {
        let values: Vec<f64> = (0..block.columns).map(|i| 0.3 * ((index * 7 + i) as f64).sin() + 0.05).collect();
        layout.write(block, &values, &mut flat);
    }
    flat
}

#[test]
fn every_gradient_is_that_of_finite_differences() {
    for architecture in architectures() {
        architecture.check().unwrap();
        let program = loss_program::<f64>(&architecture);
        let (layout, kernels) = (program.layout(), f64::kernels());
        let mut arena = program.arena();
        for (i, value) in program.input(&mut arena, 0).iter_mut().enumerate() {
            *value = 1.5 * ((i * 13) as f64 * 0.7).sin();
        }
        for input in [WEIGHT_INPUT, SHARE_INPUT] {
            program.input(&mut arena, input).fill(0.3 / TILE as f64);
        }
        let mut loss = |flat: &[f64], gradient: &mut [f64]| {
            program.run(kernels, flat, &mut arena, gradient);
            program.output(&arena, 0).iter().sum::<f64>()
        };
        let mut flat = weights(layout, 1);
        let mut gradient = vec![0.0; flat.len()];
        loss(&flat, &mut gradient);
        let mut scratch = gradient.clone();
        for block in layout.blocks() {
            let own = layout.read(block, &gradient);
            let largest = own.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let values = layout.read(block, &flat);
            for index in 0..values.len() {
                let mut shifted = |by: f64| {
                    let mut changed = values.clone();
                    changed[index] += by;
                    layout.write(block, &changed, &mut flat);
                    loss(&flat, &mut scratch)
                };
                const STEP: f64 = 1e-5;
                let slope = (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP);
                let error = (slope - own[index]).abs() / largest.max(1e-3);
                assert!(
                    error < 2e-6,
                    "{}: {}[{index}] {} not {slope}",
                    architecture.describe(),
                    block.name,
                    own[index]
                );
            }
            layout.write(block, &values, &mut flat);
        }
    }
}

/// An arm a thousand times as heavy has the same loss with the same weights: a penalty in squared N m would drown its errors.
#[test]
fn the_penalty_on_epsilon_has_no_unit() {
    let loss = |heavier: f64| {
        let scales = Scales { torque: heavier, inertia: Some(heavier), ..Scales::default() };
        let architecture =
            Architecture { scales, ..LearnedPreset::DelanFfnn.architecture(2, &layers(Activation::Tanh)) };
        let program = loss_program::<f64>(&architecture);
        let flat = weights(program.layout(), 3);
        let mut arena = program.arena();
        for (row, values) in program.input(&mut arena, 0).chunks_exact_mut(TILE).enumerate() {
            // q, q̇ and q̈ of two joints come first, their torque then.
            let size = if (6..8).contains(&row) { heavier } else { 1.0 };
            values.iter_mut().enumerate().for_each(|(i, value)| *value = size * ((row * TILE + i) as f64).sin());
        }
        program.input(&mut arena, WEIGHT_INPUT).fill(1.0 / (heavier * heavier));
        program.input(&mut arena, SHARE_INPUT).fill(1.0);
        program.run(f64::kernels(), &flat, &mut arena, &mut vec![0.0; flat.len()]);
        program.output(&arena, 0).iter().sum::<f64>()
    };
    assert!((loss(1000.0) / loss(1.0) - 1.0).abs() < 1e-9, "{} is not {}", loss(1000.0), loss(1.0));
}

/// Friction is what no Lagrangian has: ε is there to learn it.
#[test]
fn epsilon_learns_the_friction_that_a_lagrangian_can_not() {
    let motion = Excitation::PaperPointToPoint { trajectories: 20, duration: 4.0, samples: 100, range: 2.0 };
    let mut arm = Arm::uniform(1);
    arm.links[0].mass = 8.0;
    let mut scenario = Scenario { arm, motion, ..Scenario::paper(4) };
    scenario.hide("viscous-friction", Some(0), vec![8.0]);
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let split = Split::automatic(&recording);
    let plan = Plan { options: Options { epochs: 40, batch: 50, ..Options::ours() }, ..Plan::default() };
    let error = |preset| {
        let model = Preset::Learned(preset).model(&recording).unwrap().with_layers(&layers(Activation::Tanh));
        let trained = fit(&model, &recording, &split, &plan, None, &Monitor::new(), &mut |_| {}).unwrap();
        trained.history.last().unwrap().validation.unwrap()
    };
    let (alone, beside) = (error(LearnedPreset::StructuredDelan), error(LearnedPreset::DelanFfnn));
    assert!(beside < 0.2 * alone, "{beside} with ε, {alone} without");
}

#[test]
fn torque_is_what_the_lagrangian_says_and_energy_balances() {
    for architecture in architectures().into_iter().filter(|a| a.terms.iter().any(LearnedTerm::is_lagrangian)) {
        let n = architecture.joints;
        let program = component_program::<f64>(&architecture);
        let flat = weights(program.layout(), 2);
        let none = vec![0.0; architecture.column_count() * n];
        let at = |q: &[f64], qd: &[f64], qdd: &[f64]| program.run(f64::kernels(), &flat, q, qd, qdd, &none);
        let (q, qd, qdd): (Vec<f64>, Vec<f64>, Vec<f64>) =
            ((0..n).map(|i| 0.4 + i as f64).collect(), vec![0.8; n], (0..n).map(|i| 1.0 - i as f64).collect());
        let still = vec![0.0; n];
        let lagrangian = |q: &[f64], qd: &[f64]| at(q, qd, &still).lagrangian.unwrap().lagrangian[0][0];
        let moved = |values: &[f64], index: usize, by: f64| {
            let mut values = values.to_vec();
            values[index] += by;
            values
        };
        const STEP: f64 = 1e-4;
        // Where the arm is a moment later or earlier.
        let later = |t: f64| -> (Vec<f64>, Vec<f64>) {
            let q = (0..n).map(|i| q[i] + t * qd[i] + 0.5 * t * t * qdd[i]).collect();
            (q, (0..n).map(|i| qd[i] + t * qdd[i]).collect())
        };
        let momentum = |t: f64, i: usize| {
            let (q, qd) = later(t);
            (lagrangian(&q, &moved(&qd, i, STEP)) - lagrangian(&q, &moved(&qd, i, -STEP))) / (2.0 * STEP)
        };
        let components = at(&q, &qd, &qdd);
        let own = components.lagrangian.clone().unwrap();
        let torque: Vec<f64> = (0..n).map(|i| own.inertial[i][0] + own.coriolis[i][0] + own.gravity[i][0]).collect();
        for i in 0..n {
            let rate = (momentum(STEP, i) - momentum(-STEP, i)) / (2.0 * STEP);
            let slope = (lagrangian(&moved(&q, i, STEP), &qd) - lagrangian(&moved(&q, i, -STEP), &qd)) / (2.0 * STEP);
            let error = (torque[i] - (rate - slope)).abs();
            assert!(error < 1e-5 * torque[i].abs().max(10.0), "{}: joint {i}", architecture.describe());
        }
        if own.potential.is_some() {
            let energy = |t: f64| {
                let (q, qd) = later(t);
                let parts = at(&q, &qd, &still).lagrangian.unwrap();
                parts.kinetic.unwrap()[0][0] + parts.potential.unwrap()[0][0]
            };
            let power: f64 = torque.iter().zip(&qd).map(|(torque, velocity)| torque * velocity).sum();
            let rate = (energy(STEP) - energy(-STEP)) / (2.0 * STEP);
            assert!((power - rate).abs() < 1e-5 * power.abs().max(10.0), "{}", architecture.describe());
        }
    }
}

#[test]
fn the_work_that_a_structured_model_takes_is_the_energy_it_gains() {
    // So often sampled that sums are integrals.
    let mut motion = Scenario::embedded().motion;
    if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut motion {
        (*trajectories, *duration, *rate) = (4, 1.0, 1000.0);
    }
    let scenario = Scenario { arm: Arm::uniform(2), motion, effects: vec![], ..Scenario::embedded() };
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let model = Preset::Learned(LearnedPreset::StructuredDelan).model(&recording).unwrap();
    let plan = Plan { options: Options { epochs: 2, ..Options::ours() }, ..Plan::default() };
    let split = Split::automatic(&recording);
    let fitted = fit(&model, &recording, &split, &plan, None, &Monitor::new(), &mut |_| {}).unwrap().fitted;
    for run in &recording.trajectories {
        let torque = fitted.predict(run).unwrap().total;
        let parts = components(&fitted, run).unwrap();
        let series = |name: &str| &parts.iter().find(|(other, _)| *other == name).unwrap().1[0];
        let [power, kinetic, potential] = ["power", "kinetic_energy", "potential_energy"].map(series);
        let gained = |t: usize| kinetic[t] + potential[t] - kinetic[0] - potential[0];
        let largest = (0..run.len()).map(gained).fold(0.0_f64, |most, value| most.max(value.abs()));
        let mut work = 0.0;
        for t in 0..run.len() {
            let own: f64 = (0..2).map(|joint| torque[joint][t] * run.qd[joint][t]).sum();
            assert!((power[t] - own).abs() < 1e-9 * own.abs().max(1.0), "{} is not {own}", power[t]);
            if t > 0 {
                work += 0.5 * (power[t] + power[t - 1]) * (run.time[t] - run.time[t - 1]);
            }
            assert!((work - gained(t)).abs() < 1e-3 * largest, "{work} J went in, {} J are there", gained(t));
        }
    }
}

fn trajectories(count: usize, seed: u64) -> Vec<Trajectory> {
    let motion = Excitation::PaperPointToPoint { trajectories: count, duration: 4.0, samples: 400, range: 3.0 };
    let scenario = Scenario { arm: Arm::uniform(2), motion, ..Scenario::paper(seed) };
    simulate(&scenario, &Monitor::new()).unwrap().trajectories
}

fn samples(count: usize, seed: u64) -> Samples<f32> {
    Samples::new(2, &trajectories(count, seed), &[]).unwrap()
}

fn small(preset: LearnedPreset) -> Architecture {
    preset.architecture(2, &Layers { hidden: vec![16, 16], activation: Activation::Tanh })
}

fn options() -> Options {
    Options { epochs: 4, batch: 200, threads: Some(1), ..Options::ours() }
}

fn run(architecture: &Architecture, options: &Options, begin: Begin, monitor: &Monitor) -> Result<Outcome, TrainError> {
    let (training, held_out) = (samples(6, 1), samples(2, 2));
    let data = TrainingData { train: &training, validation: Some(&held_out), held_out: None };
    train(architecture, options, data, begin, monitor, &mut |_| {})
}

#[test]
fn the_same_seed_gives_the_same_weights_for_any_number_of_threads() {
    for (preset, optimiser) in
        [(LearnedPreset::StructuredDelan, Optimiser::SOAP), (LearnedPreset::DelanFfnn, Optimiser::ADAM_W)]
    {
        let with = |threads| {
            let options = Options { optimiser, threads: Some(threads), ..options() };
            run(&small(preset), &options, Begin::Fresh, &Monitor::new()).unwrap().checkpoint.weights
        };
        let alone = with(1);
        assert_eq!(alone, with(2));
        assert_eq!(alone, with(3));
    }
}

#[test]
fn a_resumed_run_ends_where_an_uninterrupted_one_ends() {
    for optimiser in [Optimiser::SOAP, Optimiser::ADAM_W] {
        let options = Options { optimiser, epochs: 5, ..options() };
        let architecture = small(LearnedPreset::StructuredDelan);
        let whole = run(&architecture, &options, Begin::Fresh, &Monitor::new()).unwrap();

        // Stopped after two epochs, saved, loaded, resumed.
        let (training, held_out) = (samples(6, 1), samples(2, 2));
        let data = TrainingData { train: &training, validation: Some(&held_out), held_out: None };
        let monitor = Monitor::new();
        let mut seen = None;
        let mut stop = |checkpoint: &dyn Fn() -> Checkpoint| {
            let now = checkpoint();
            if now.epoch == 2 {
                seen = Some(now);
                monitor.stop("enough for today");
            }
        };
        let first = train(&architecture, &options, data, Begin::Fresh, &monitor, &mut stop).unwrap();
        assert_eq!(first.ending, Ending::Stopped("enough for today".into()));
        // What is kept is the best so far.
        let best = first.history.iter().filter_map(|epoch| epoch.validation).fold(f64::INFINITY, f64::min);
        assert!((first.model.normalised_error(&trajectories(2, 2), &[]).unwrap() / best - 1.0).abs() < 1e-3);
        let checkpoint = Checkpoint::from_bytes(&first.checkpoint.to_bytes().unwrap()).unwrap();
        assert_eq!(checkpoint, first.checkpoint);
        // The one that a watcher asked for is from the end of that epoch.
        for checkpoint in [checkpoint, seen.unwrap()] {
            let second = run(&architecture, &options, Begin::Resume(&checkpoint), &Monitor::new()).unwrap();
            assert_eq!(second.checkpoint.weights, whole.checkpoint.weights);
            assert_eq!(second.checkpoint.states, whole.checkpoint.states);
            assert_eq!(second.model, whole.model);
        }
    }
}

#[test]
fn a_run_of_the_session_is_resumed_with_its_effects_in_either_precision() {
    let motion = Excitation::PaperPointToPoint { trajectories: 5, duration: 4.0, samples: 200, range: 3.0 };
    let scenario =
        |joints, seed| Scenario { arm: Arm::uniform(joints), motion: motion.clone(), ..Scenario::paper(seed) };
    let recording = |joints, seed| simulate(&scenario(joints, seed), &Monitor::new()).unwrap();
    let (own, split) = (recording(2, 1), Split::automatic(&recording(2, 1)));
    let model = Preset::Learned(LearnedPreset::StructuredDelan).model(&own).unwrap();
    let model = model
        .with_layers(&layers(Activation::Silu))
        .with_effect(registry::find("viscous-friction").unwrap(), &[1])
        .unwrap();
    for precision in [Precision::F32, Precision::F64] {
        let options = Options { epochs: 4, batch: 100, ..Options::ours() };
        let plan = Plan { options, precision, features: Some(Features::Raw), ..Plan::default() };
        let monitor = Monitor::new();
        let whole = fit(&model, &own, &split, &plan, None, &monitor, &mut |_| {}).unwrap();
        let told = monitor.take_events().into_iter().filter_map(|event| match event {
            Event::Epoch(epoch) => Some(epoch),
            _ => None,
        });
        assert_eq!(told.collect::<Vec<_>>(), whole.history, "a watcher hears of every epoch");
        let mut saved = None;
        fit(&model, &own, &split, &plan, None, &monitor, &mut |run| {
            let run = run();
            if run.checkpoint.epoch == 2 {
                saved = Some(run.to_bytes().unwrap());
            }
        })
        .unwrap();
        let bytes = saved.unwrap();
        let saved = SavedRun::from_bytes(&bytes).unwrap();
        let second = resume(&saved, &own, &split, &monitor, &mut |_| {}).unwrap();
        assert_eq!(to_bytes(&second.fitted).unwrap(), to_bytes(&whole.fitted).unwrap());
        assert_eq!(second.run.checkpoint.weights, whole.run.checkpoint.weights);

        let refused = |result: Result<(), TrainError>| result.unwrap_err().to_string();
        let on = |other: &torquescope::recording::Recording| {
            refused(resume(&saved, other, &Split::automatic(other), &monitor, &mut |_| {}).map(|_| ()))
        };
        let message = on(&recording(3, 1));
        assert!(message.contains("samples of 2 joints") && message.contains("samples of 3 joints"), "{message}");
        assert!(on(&recording(2, 2)).contains("another set of samples"));
        let slower = Plan { options: Options { rate: 1e-3, ..plan.options.clone() }, ..plan.clone() };
        let message = refused(saved.clone().with_plan(slower).map(|_| ()));
        assert!(message.contains("another rate: it has 0.01, this run 0.001"), "{message}");
        let threads = Plan { options: Options { threads: Some(2), ..plan.options.clone() }, ..plan.clone() };
        assert!(saved.clone().with_plan(threads).is_ok());
        for length in [0, 10, bytes.len() / 2, bytes.len() - 1] {
            let message = refused(SavedRun::from_bytes(&bytes[..length]).map(|_| ()));
            assert!(message.contains("not a trained model or checkpoint"), "{message}");
        }
    }
}

#[test]
fn a_model_is_saved_and_warms_up_another() {
    let structured = run(&small(LearnedPreset::StructuredDelan), &options(), Begin::Fresh, &Monitor::new()).unwrap();
    let loaded = LearnedModel::from_bytes(&structured.model.to_bytes().unwrap()).unwrap();
    assert_eq!(loaded, structured.model);
    let held_out = trajectories(2, 2);
    let error = loaded.normalised_error(&held_out, &[]).unwrap();
    // With a term more the error begins where it was, since the new term begins at zero.
    let options = Options { epochs: 1, rate: 1e-9, ..options() };
    let warm = run(&small(LearnedPreset::DelanFriction), &options, Begin::Warm(&loaded), &Monitor::new()).unwrap();
    assert!((warm.history[0].validation.unwrap() / error - 1.0).abs() < 1e-3);
    assert_eq!(warm.model.friction_coefficients().len(), 8);
}

/// An arm as a whole may be turned about its first joint: its inertia does not change, the work against gravity does.
#[test]
fn link_angles_make_the_inertia_independent_of_the_first_joint() {
    let architecture = Architecture {
        features: Features::LinkAngles,
        ..LearnedPreset::StructuredDelan.architecture(3, &layers(Activation::Tanh))
    };
    let program = component_program::<f64>(&architecture);
    let flat = weights(program.layout(), 3);
    let at = |q: [f64; 3]| {
        let parts = program.run(f64::kernels(), &flat, &q, &[0.0; 3], &[0.0; 3], &[]).lagrangian.unwrap();
        (parts.mass_matrix.values().to_vec(), parts.gravity.values().to_vec())
    };
    let (mass, gravity) = at([0.3, 0.7, -0.4]);
    let (turned_mass, turned_gravity) = at([1.5, 0.7, -0.4]);
    assert_eq!(mass, turned_mass);
    assert!(gravity.iter().zip(&turned_gravity).all(|(one, other)| (one - other).abs() > 1e-6), "{gravity:?}");
    let (other_mass, _) = at([0.3, 0.9, -0.4]);
    assert_ne!(mass, other_mass);
    // A whole turn of any joint changes nothing.
    let turn = std::f64::consts::TAU;
    let (same_mass, same_gravity) = at([0.3 + turn, 0.7 - turn, -0.4 + turn]);
    let same = |one: &[f64], other: &[f64]| one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-9);
    assert!(same(&mass, &same_mass) && same(&gravity, &same_gravity));
}

#[test]
fn our_recipe_learns_the_arm_and_its_parts() {
    let training = samples(20, 1);
    let mut architecture = Recipe::Ours.architecture(LearnedPreset::StructuredDelan, 2, &training);
    for term in &mut architecture.terms {
        if let LearnedTerm::StructuredLagrangian { layers, .. } = term {
            layers.hidden = vec![32, 32];
        }
    }
    let options = Options { epochs: 8, batch: 200, goal: Some(5e-3), ..Options::ours() };
    let held_out = samples(3, 2);
    let data = TrainingData { train: &training, validation: Some(&held_out), held_out: None };
    let outcome = train(&architecture, &options, data, Begin::Fresh, &Monitor::new(), &mut |_| {}).unwrap();
    assert_eq!(outcome.ending, Ending::GoalReached, "{:?}", outcome.history.last());
    // Gravity of two uniform rods at q = 0: (1.5 m l + 0.5 m l) g and 0.5 m l g.
    let none = || Signals::zeros(2, 1);
    let channels = Channels { time: vec![0.0], q: none(), qd: none(), qdd: none(), tau: none() };
    let still = Trajectory::new("still", channels).unwrap();
    let parts = outcome.model.components(&still, &vec![]).unwrap().lagrangian.unwrap();
    assert!(
        (parts.gravity[0][0] - 2.0 * 9.81).abs() < 2.0 && (parts.gravity[1][0] - 0.5 * 9.81).abs() < 2.0,
        "{parts:?}"
    );
}

#[test]
fn a_hidden_friction_is_found_beside_a_learned_arm() {
    // A frictional arm; the network learns the arm, the effect's factor the friction.
    let damping = 3.0;
    let frictional = |seed: u64, count: usize| {
        let mut runs = trajectories(count, seed);
        for run in &mut runs {
            let mut run = run.channels_mut();
            run.tau[1].iter_mut().zip(&run.qd[1]).for_each(|(tau, qd)| *tau += damping * qd);
        }
        runs
    };
    let effects = [AddedEffect {
        term: EffectTerm { effect: registry::find("viscous-friction").unwrap(), joint: Some(1) },
        shape: vec![],
    }];
    let setting = Setting {
        kinds: vec![JointKind::Revolute; 2],
        posture: Posture::RIGHT,
        arm: None,
        chain: None,
        resistances: Vec::new(),
        weightless: false,
        body: None,
        alterations: Vec::new(),
        reversal_widths: Vec::new(),
    };
    let columns_of =
        |runs: &[Trajectory]| -> Vec<_> { runs.iter().map(|run| columns(&effects, &setting, run).unwrap()).collect() };
    let (training, held_out) = (frictional(1, 20), frictional(2, 3));
    let samples = |runs: &[Trajectory]| Samples::<f32>::new(2, runs, &columns_of(runs)).unwrap();
    let (training, test) = (samples(&training), samples(&held_out));
    let mut architecture = small(LearnedPreset::StructuredDelan);
    architecture.terms.push(LearnedTerm::Columns { names: names(&effects) });
    scale_to(&mut architecture, &training);
    let options = Options { epochs: 10, batch: 200, ..Options::ours() };
    let data = TrainingData { train: &training, validation: Some(&test), held_out: None };
    let outcome = train(&architecture, &options, data, Begin::Fresh, &Monitor::new(), &mut |_| {}).unwrap();
    let value = outcome.model.effect_factors()[0];
    assert!((value / damping - 1.0).abs() < 0.05, "viscous friction is {value}, not {damping}");
    let parts = outcome.model.components(&held_out[0], &columns_of(&held_out)[0]).unwrap();
    assert!((parts.terms[1][1][200] - value * held_out[0].qd[1][200]).abs() < 1e-3);
    let masses = parts.lagrangian.unwrap().mass_eigenvalues();
    assert!(masses.values().len() == 800 && masses.values().iter().all(|mass| *mass > 0.0));
}

/// Two rods moved by sums of sines, with these effects on both joints and 1 % noise; a network for the arm and trained friction.
fn learned_friction(effects: &[(&str, &[f64])]) -> (Recording, Fitted) {
    let hidden = |(effect, parameters): &(&str, &[f64])| {
        [0, 1].map(|joint| HiddenEffect {
            effect: (*effect).into(),
            joint: Some(joint),
            parameters: parameters.to_vec(),
        })
    };
    let scenario = Scenario {
        arm: Arm::uniform(2),
        effects: effects.iter().flat_map(hidden).collect(),
        torque_noise: 0.01,
        ..Scenario::embedded()
    };
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let model = Preset::Learned(LearnedPreset::DelanFriction).model(&recording).unwrap();
    let model = model.with_layers(&Layers { hidden: vec![24, 24], activation: Activation::Tanh });
    let plan = Plan { options: Options { epochs: 30, batch: 256, ..Options::ours() }, ..Plan::default() };
    let split = Split::automatic(&recording);
    let trained = fit(&model, &recording, &split, &plan, None, &Monitor::new(), &mut |_| {}).unwrap();
    (recording, trained.fitted)
}

fn few_runs() -> (Recording, Split) {
    let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 100, range: 3.0 };
    let scenario = Scenario { arm: Arm::uniform(2), motion, ..Scenario::paper(3) };
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    let split = Split::automatic(&recording);
    (recording, split)
}

fn short(epochs: u64, rate: f64) -> Plan {
    let options = Options { epochs, rate, batch: 64, threads: Some(1), ..Options::ours() };
    Plan { options, layers: Layers { hidden: vec![6], activation: Activation::Tanh }, ..Plan::default() }
}

/// Whatever the held-out runs are, the weights are the same; only what is told of them differs.
#[test]
fn held_out_runs_have_no_say_in_what_is_learned() {
    let (recording, split) = few_runs();
    let mut other = recording.clone();
    for segment in &split.held_out {
        let mut run = other.trajectories[segment.trajectory].channels_mut();
        run.tau.iter_mut().flatten().for_each(|torque| *torque *= -3.0);
    }
    let model = Preset::Learned(LearnedPreset::StructuredDelan).model(&recording).unwrap();
    let model = model.with_layers(&Layers { hidden: vec![6], activation: Activation::Tanh });
    let trained = |recording: &Recording| {
        fit(&model, recording, &split, &short(5, 1e-2), None, &Monitor::new(), &mut |_| {}).unwrap()
    };
    let (one, two) = (trained(&recording), trained(&other));
    assert_eq!(to_bytes(&one.fitted).unwrap(), to_bytes(&two.fitted).unwrap());
    let (first, second) = (one.history[4], two.history[4]);
    assert_eq!(first.validation, second.validation);
    assert!(first.validation.is_some() && first.held_out != second.held_out);
    // Without held-out runs all is learned from, and the loss decides.
    let whole = Split { held_out: Vec::new(), ..split.clone() };
    let alone = fit(&model, &recording, &whole, &short(1, 1e-2), None, &Monitor::new(), &mut |_| {}).unwrap();
    assert_eq!((alone.history[0].validation, alone.history[0].held_out), (None, None));
}

/// A wrist whose torque is a twentieth of the shoulder's is learned as well as the shoulder: as long as every joint weighed the same, its
/// relative error was five times that of the others.
#[test]
fn a_light_wrist_is_learned_as_well_as_the_shoulder() {
    let recording = simulate(&Scenario::mystery(28).unwrap(), &Monitor::new()).unwrap();
    let split = Split::automatic(&recording);
    let mut plan = Plan::of(Recipe::Ours);
    plan.options.seed = 28;
    let network = plan.shaped(&Preset::Learned(LearnedPreset::StructuredDelan).model(&recording).unwrap());
    let network = fit(&network, &recording, &split, &plan, None, &Monitor::new(), &mut |_| {}).unwrap().fitted;
    let learned = Evaluation::of(&network, &recording, &split).unwrap().held_out_nmse();
    assert!(learned[2] < 2.0 * learned[0].max(learned[1]), "{learned:?}");
}

/// A training that learns nothing is begun anew, told, and the best start is kept; that is remembered with its run.
#[test]
fn a_training_that_got_stuck_begins_anew_from_another_start() {
    let (recording, split) = few_runs();
    let model = Preset::Learned(LearnedPreset::StructuredDelan).model(&recording).unwrap();
    let model = model.with_layers(&Layers { hidden: vec![6], activation: Activation::Tanh });
    let trained = |plan: &Plan, before: Option<&Fitted>| {
        let monitor = Monitor::new();
        let trained = fit(&model, &recording, &split, plan, before, &monitor, &mut |_| {}).unwrap();
        let warnings = monitor.take_events().into_iter().filter(|event| matches!(event, Event::Warning(_))).count();
        (trained, warnings)
    };
    // So small a rate leaves the weights as they were drawn.
    let (stuck, warnings) = trained(&short(20, 1e-9), None);
    let others = &stuck.run.other_starts;
    assert!(!others.is_empty() && warnings == others.len(), "{others:?}");
    let kept = stuck.history.iter().map(|epoch| epoch.loss).fold(f64::INFINITY, f64::min) / 2.0;
    assert!(others.iter().all(|other| other.unexplained >= kept), "{kept} {others:?}");
    assert!(others.iter().all(|other| other.seed != stuck.run.plan.options.seed && other.seed % 1000 == 0));
    assert!(stuck.run.starts_text().unwrap().contains("others got stuck"));
    assert_eq!(SavedRun::from_bytes(&stuck.run.to_bytes().unwrap()).unwrap(), stuck.run);
    // One that learns is left alone, and so is one that is too short to be judged, or goes on from weights that were given.
    let (good, told) = trained(&short(60, 2e-2), None);
    assert_eq!((good.run.other_starts.as_slice(), told), (&[][..], 0), "{:?}", good.history.last());
    assert!(trained(&short(3, 1e-9), None).0.run.other_starts.is_empty());
    assert!(trained(&short(20, 1e-9), Some(&stuck.fitted)).0.run.other_starts.is_empty());
}

/// At the beginning H q̈ is no larger than the torque, however fast the arm moves: from far above, some trainings never came back.
#[test]
fn a_training_begins_with_an_inertia_of_the_right_size() {
    let mut fast = trajectories(6, 1);
    for run in &mut fast {
        run.channels_mut().qdd.iter_mut().flatten().for_each(|acceleration| *acceleration *= 50.0);
    }
    for runs in [trajectories(6, 1), fast] {
        let samples = Samples::<f32>::new(2, &runs, &[]).unwrap();
        let scales = Recipe::Ours.architecture(LearnedPreset::StructuredDelan, 2, &samples).scales;
        let inertial = scales.inertia.unwrap() * scales.acceleration;
        assert!(inertial <= 1.001 * scales.torque && scales.inertia.unwrap() <= scales.torque, "{scales:?}");
    }
}

#[test]
fn trained_friction_is_that_of_the_arm() {
    let (_, fitted) = learned_friction(&[("stribeck-friction", &[2.0, 1.0, 0.3]), ("viscous-friction", &[0.5])]);
    let truth =
        [("coulomb_torque", 2.0), ("stribeck_torque", 1.0), ("stribeck_velocity", 0.3), ("viscous_coefficient", 0.5)];
    assert_eq!(fitted.parameters.len(), 2 * truth.len());
    for parameter in &fitted.parameters {
        let exact = truth.iter().find(|(name, _)| *name == parameter.name).unwrap().1;
        assert!((parameter.value / exact - 1.0).abs() < 0.05, "{parameter:?} is not {exact}");
    }
}

#[test]
fn an_arm_without_friction_is_given_none() {
    let (recording, fitted) = learned_friction(&[]);
    let (mut friction, mut whole) = ([0.0; 2], [0.0; 2]);
    for run in &recording.trajectories {
        let terms = fitted.predict(run).unwrap().terms;
        for joint in 0..2 {
            friction[joint] += terms[1][joint].iter().map(|torque| torque * torque).sum::<f64>();
            whole[joint] += run.tau[joint].iter().map(|torque| torque * torque).sum::<f64>();
        }
    }
    for joint in 0..2 {
        let share = (friction[joint] / whole[joint]).sqrt();
        assert!(share < 0.01, "friction is {:.2} % of the torque of joint {}", 100.0 * share, joint + 1);
    }
}

#[test]
fn a_run_that_makes_no_sense_ends_with_a_reason() {
    // So large a rate sends the weights to infinity.
    let wild =
        Options { rate: 10.0, epochs: 60, schedule: torquescope::training::schedule::Schedule::Constant, ..options() };
    let outcome = run(&small(LearnedPreset::BlackBoxDelan), &wild, Begin::Fresh, &Monitor::new()).unwrap();
    assert!(matches!(&outcome.ending, Ending::Failed(_)), "{:?} {:?}", outcome.ending, outcome.history.last());
    assert!(outcome.model.weights.values().flatten().all(|weight| weight.is_finite()));

    // An effect that never acts has no gradient.
    let architecture = Architecture {
        terms: vec![LearnedTerm::Columns { names: vec!["nothing".into()] }],
        ..small(LearnedPreset::StructuredDelan)
    };
    let training = trajectories(2, 1);
    let zero: Vec<Vec<Signals>> = training.iter().map(|t| vec![Signals::zeros(2, t.len())]).collect();
    let samples = Samples::<f32>::new(2, &training, &zero).unwrap();
    let data = TrainingData { train: &samples, validation: None, held_out: None };
    let outcome = train(&architecture, &options(), data, Begin::Fresh, &Monitor::new(), &mut |_| {}).unwrap();
    assert!(
        matches!(&outcome.ending, Ending::Failed(reason) if reason.contains("exactly zero")),
        "{:?}",
        outcome.ending
    );
}

#[test]
fn bad_input_is_a_clear_error() {
    let refused = |architecture: &Architecture, options: &Options, begin: Begin| {
        run(architecture, options, begin, &Monitor::new()).unwrap_err().to_string()
    };
    let good = small(LearnedPreset::StructuredDelan);
    let three = LearnedPreset::FfNn.architecture(3, &layers(Activation::Tanh));
    assert!(refused(&three, &options(), Begin::Fresh).contains("the model has 3 joints"));
    for rate in [0.0, 1e6, f64::NAN, -1.0] {
        assert!(refused(&good, &Options { rate, ..options() }, Begin::Fresh).contains("the learning rate is"));
    }
    let few = Options { batch: 5000, ..options() };
    assert!(refused(&good, &few, Begin::Fresh).contains("fewer than a batch"));
    assert!(refused(&Architecture { terms: vec![], ..good.clone() }, &options(), Begin::Fresh).contains("no terms"));

    let checkpoint = run(&good, &options(), Begin::Fresh, &Monitor::new()).unwrap().checkpoint;
    let other = refused(&small(LearnedPreset::FfNn), &options(), Begin::Resume(&checkpoint));
    assert!(other.contains("another architecture"), "{other}");
    let bytes = checkpoint.to_bytes().unwrap();
    for length in [0, 10, bytes.len() / 2, bytes.len() - 1] {
        assert!(Checkpoint::from_bytes(&bytes[..length]).is_err());
    }

    let mut broken = trajectories(2, 1);
    broken[1].channels_mut().qd[0][7] = f64::NAN;
    assert!(Samples::<f32>::new(2, &broken, &[]).unwrap_err().to_string().contains("velocity of trajectory `run 2`"));
    let mut constant = trajectories(2, 1);
    constant.iter_mut().for_each(|t| t.channels_mut().tau[1].fill(3.0));
    let samples = Samples::<f32>::new(2, &constant, &[]).unwrap();
    let data = TrainingData { train: &samples, validation: None, held_out: None };
    let error = train(&good, &options(), data, Begin::Fresh, &Monitor::new(), &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("torque of joint 2 is always 3"));
}
