//! Set-ups that are wrong on purpose are told, and right ones are not.

use std::f64::consts::FRAC_PI_2;

use super::*;
use crate::arm::{Arm, Link, Posture};
use crate::effect::registry;
use crate::recording::check;
use crate::simulation::{Excitation, Scenario, simulate};

/// An arm of links that are not alike.
fn arm(joints: usize, posture: Posture) -> Arm {
    let link = |number: usize| {
        let scale = 0.75f64.powi(number as i32);
        Link { mass: 3.0 * scale, length: 0.6 * scale, com: 0.25 * scale, inertia: 0.08 * scale.powi(3) }
    };
    Arm { links: (0..joints).map(link).collect(), posture, ..Arm::uniform(joints) }
}

/// A log of 20 s of such an arm without anything hidden, which states neither masses nor lengths.
fn scenario(joints: usize, posture: Posture, seed: u64) -> Scenario {
    let motion = match seed % 3 {
        0 => Excitation::MultiSine {
            trajectories: 1,
            duration: 20.0,
            rate: 200.0,
            harmonics: 5,
            lowest_frequency: 0.1,
            highest_frequency: 0.9,
            max_position: 1.8,
            max_velocity: 3.0,
        },
        1 => Excitation::PaperPointToPoint { trajectories: 8, duration: 2.5, samples: 400, range: 2.0 },
        _ => Excitation::Stops {
            trajectories: 1,
            duration: 20.0,
            rate: 250.0,
            places: 9,
            pause: 0.3,
            max_position: 1.8,
            max_velocity: 2.5,
        },
    };
    let encoder_resolution = seed.is_multiple_of(2).then_some(1e-4);
    let arm = arm(joints, posture);
    Scenario {
        arm,
        motion,
        effects: Vec::new(),
        torque_noise: 0.01,
        encoder_resolution,
        seed,
        stated: false,
        ..Scenario::embedded()
    }
}

fn clean(joints: usize, posture: Posture, seed: u64) -> Recording {
    simulate(&scenario(joints, posture, seed), &Monitor::new()).unwrap()
}

/// A log whose three derivatives are measured.
fn measured(joints: usize, posture: Posture, seed: u64) -> Recording {
    let scenario = Scenario { encoder_resolution: None, ..scenario(joints, posture, seed) };
    simulate(&scenario, &Monitor::new()).unwrap()
}

fn told(recording: &Recording) -> Option<Finding> {
    super::check(recording, &check::check(recording), &Monitor::new()).unwrap()
}

/// The log as it would be with this mistake.
fn with_mistake(mut recording: Recording, mistake: &str) -> Recording {
    mistake.parse::<Correction>().unwrap().apply(&mut recording).unwrap();
    recording
}

fn texts(finding: &Option<Finding>) -> String {
    let corrections = finding.iter().flat_map(|finding| &finding.set_right);
    corrections.map(Correction::to_string).collect::<Vec<_>>().join(" ")
}

/// A mistake, and what sets it right.
const MISTAKES: [(&str, &str); 24] = [
    ("zero=right", "zero=down"),
    ("zero=left", "zero=down"),
    ("zero=up", "zero=down"),
    ("zero=-145", "zero=down"),
    ("zero@2=-90", "zero@2=90"),
    ("sign-motion@2", "sign-motion@2"),
    ("sign-motion@1,2,3", "sign-torque@1,2,3"),
    ("sign@2", "sign@2"),
    ("order-motion=2,1,3", "order-motion=2,1,3"),
    ("order=3,1,2", "order=2,3,1"),
    ("angles=relative", "angles=absolute"),
    ("angles=absolute", "angles=relative"),
    ("factor-motion@1=100", "factor-motion@1=0.01"),
    ("factor-motion@1,2,3=121,-80,50", "factor-motion@1,2,3=0.008264463,-0.0125,0.02"),
    ("sign-torque@3", "sign-torque@3"),
    ("sign-torque@1,2,3", "sign-torque@1,2,3"),
    ("order-torque=1,3,2", "order-torque=1,3,2"),
    ("order-torque=2,3,1", "order-torque=3,1,2"),
    ("delay-torque=-0.08", "delay-torque=0.08"),
    ("delay-position=-0.08", "delay-position=0.08"),
    ("delay-acceleration=-0.06", "delay-acceleration=0.06"),
    ("factor-velocity@1,2,3=57.295779513", "factor-velocity@1,2,3=0.017453293"),
    ("factor-acceleration@2=0.1", "factor-acceleration@2=10"),
    ("factor-position@1,2,3=57.295779513", "factor-position@1,2,3=0.017453293"),
];

#[test]
#[ignore = "measures: how often mistakes are told, and clean logs called wrong"]
fn rates() {
    let postures = [Posture::DOWN, Posture::RIGHT, Posture::UP];
    let start = std::time::Instant::now();
    let mut false_alarms = 0;
    for seed in 0..50 {
        let joints = 1 + seed as usize % 5;
        let recording = clean(joints, postures[seed as usize / 5 % 3], seed);
        let bench = Bench::of(&recording).unwrap();
        let stated = bench.stated().unwrap();
        let found = told(&recording);
        false_alarms += usize::from(found.is_some());
        println!(
            "clean {seed} {joints} {:.1e} {:?} {} {}",
            stated.errors.iter().fold(0.0, |a: f64, b| a.max(*b)),
            stated.impossible,
            stated.is_turned_over(),
            texts(&found)
        );
    }
    println!("clean: {false_alarms} of 50, {:.1} s", start.elapsed().as_secs_f64());
    let mut false_alarms = 0;
    let effects: Vec<_> = registry::sought();
    for seed in 0..60 {
        let joints = 2 + seed as usize % 3;
        let mut scenario = scenario(joints, postures[seed as usize / 5 % 3], seed);
        let effect = effects[seed as usize % effects.len()];
        let places: Vec<usize> =
            if effect.scope == crate::effect::Scope::Joint { vec![seed as usize % joints] } else { vec![1] };
        let Ok(hidden) = scenario.hide_by_strength(effect.id, &places, 0.2) else {
            println!("no {}", effect.id);
            continue;
        };
        scenario.effects = hidden;
        let Ok(recording) = simulate(&scenario, &Monitor::new()) else {
            println!("no {}", effect.id);
            continue;
        };
        let bench = Bench::of(&recording).unwrap();
        let stated = bench.stated().unwrap();
        let found = told(&recording);
        false_alarms += usize::from(found.is_some());
        println!(
            "effect {} {seed} {joints} {:.1e} {:?} {} {}",
            effect.id,
            stated.errors.iter().fold(0.0, |a: f64, b| a.max(*b)),
            stated.impossible,
            stated.is_turned_over(),
            texts(&found)
        );
    }
    println!("with an effect: {false_alarms} of 60, {:.1} s", start.elapsed().as_secs_f64());
    for (mistake, right) in MISTAKES {
        let mut line = format!("{mistake:36}");
        for seed in 0..6 {
            let begin = std::time::Instant::now();
            let recording = with_mistake(measured(3, Posture::DOWN, seed), mistake);
            let sim = begin.elapsed().as_secs_f64();
            let found = told(&recording);
            let text = texts(&found);
            line += &format!(
                " [{}{} {:.1}]",
                if text == right { "ok" } else { &text },
                if found.is_some_and(|found| found.remedy.contains("can't tell")) { "=" } else { "" },
                begin.elapsed().as_secs_f64() - sim
            );
        }
        println!("{line}");
    }
    let _ = FRAC_PI_2;
}
