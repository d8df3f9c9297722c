//! Trains a structured deep Lagrangian network on a simulated arm and measures it on runs that it has not seen:
//!
//!     cargo run --release --example train_network

use torquescope::model::learned::LearnedPreset;
use torquescope::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let monitor = Monitor::new();
    // Point-to-point runs of two uniform rods with viscous friction at joint 1.
    let motion = Excitation::PaperPointToPoint { trajectories: 40, duration: 4.0, samples: 200, range: 3.0 };
    let mut scenario = Scenario { arm: Arm::uniform(2), motion, effects: Vec::new(), ..Scenario::embedded() };
    scenario.effects = scenario.hide_by_strength("viscous-friction", &[0], 0.1)?;
    let simulated = Command::Simulate(Box::new(scenario)).run(&Session::default(), &monitor)?;

    let mut plan = Plan::default();
    (plan.options.epochs, plan.options.batch) = (40, 128);
    let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: Box::new(plan) };
    let trained = train.run(&simulated, &monitor)?;
    // The effect is trained together with the network, which starts from where it is.
    let add = Command::AddEffect { effect: "viscous-friction".into(), joints: vec![0] };
    let repaired = add.run(&trained, &monitor)?;
    for step in &repaired.ladder {
        let epochs = step.history.len();
        println!("{}: {epochs} epochs, held-out nMSE by joint {:?}", step.name, step.evaluation.held_out_nmse());
    }
    Ok(())
}
