use clap::Args;
use serde::Serialize;

use super::speed::cpu_seconds;
use crate::arm::Arm;
use crate::cli::data::Training;
use crate::cli::progress;
use crate::cli::table::{number, table};
use crate::effect::registry;
use crate::model::learned::LearnedPreset;
use crate::model::{self, Evaluation, Fitted, Preset};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::seal::HiddenEffect;
use crate::recording::split::Split;
use crate::session::SessionError;
use crate::simulation::{Excitation, Scenario, simulate};
use crate::training::fit::{Plan, fit};

/// Test recordings have seeds from here on, so that none is a training recording.
const FIRST_TEST_SEED: u64 = 1_000_000;

/// Whether the recipe of training holds elsewhere than on the paper's data: noise, friction, other numbers of joints.
///
/// Uniform rods are moved by 20 runs of multi-sines; the error is that of the exact torque on 20 runs more. Beside it stands the
/// error of the rigid body of the true form, whose parameters are solved for: what the noise leaves to be known.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope bench recipe --seeds 2")]
pub struct RecipeBench {
    /// How many seeds, each with motion, noise and first weights of its own.
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    training: Training,
}

/// What is learned, and from what.
struct Case {
    name: &'static str,
    joints: usize,
    torque_noise: f64,
    effects: &'static [(&'static str, &'static [f64])],
    preset: LearnedPreset,
}

const FRICTION: &[(&str, &[f64])] = &[("stribeck-friction", &[2.0, 1.0, 0.3]), ("viscous-friction", &[0.5])];

#[rustfmt::skip]
const CASES: [Case; 9] = {
    use LearnedPreset::{DelanFriction, StructuredDelan};
    [
        Case { name: "no noise", joints: 3, torque_noise: 0.0, effects: &[], preset: StructuredDelan },
        Case { name: "1 % noise", joints: 3, torque_noise: 0.01, effects: &[], preset: StructuredDelan },
        Case { name: "2 % noise", joints: 3, torque_noise: 0.02, effects: &[], preset: StructuredDelan },
        Case { name: "5 % noise", joints: 3, torque_noise: 0.05, effects: &[], preset: StructuredDelan },
        Case { name: "friction, 2 % noise", joints: 3, torque_noise: 0.02, effects: FRICTION, preset: DelanFriction },
        Case { name: "frictionless, 2 % noise", joints: 3, torque_noise: 0.02, effects: &[], preset: DelanFriction },
        Case { name: "2 joints, 2 % noise", joints: 2, torque_noise: 0.02, effects: &[], preset: StructuredDelan },
        Case { name: "4 joints, 2 % noise", joints: 4, torque_noise: 0.02, effects: &[], preset: StructuredDelan },
        Case { name: "7 joints, 2 % noise", joints: 7, torque_noise: 0.02, effects: &[], preset: StructuredDelan },
    ]
};

/// One case, means over the seeds.
#[derive(Debug, Clone, Serialize)]
struct Row {
    case: &'static str,
    model: &'static str,
    seeds: u64,
    /// Of the exact torque, all joints together.
    nmse: f64,
    /// Of the joint whose nMSE is largest.
    nmse_of_worst_joint: f64,
    /// The same as `nmse`, of the rigid body of the true form.
    rigid_body_nmse: f64,
    /// CPU time of one training \[s\].
    cpu_s: Option<f64>,
}

impl RecipeBench {
    /// Trains, measures, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let (plan, seeds) = (self.training.plan()?, self.seeds.max(1));
        let rows = progress::watch("bench recipe", move |monitor| {
            let row = |(index, case): (usize, &Case)| {
                monitor.report(index as f32 / CASES.len() as f32, case.name).map_err(SessionError::from)?;
                case.row(&plan, seeds)
            };
            CASES.iter().enumerate().map(row).collect::<anyhow::Result<Vec<Row>>>()
        })?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&serde_json::json!({ "cases": rows }))?);
            return Ok(());
        }
        let line = |row: &Row| {
            let cpu = row.cpu_s.map_or("–".to_owned(), |seconds| format!("{seconds:.1}"));
            let numbers = [row.nmse, row.nmse_of_worst_joint, row.rigid_body_nmse].map(number);
            [row.case.to_owned(), row.model.to_owned()].into_iter().chain(numbers).chain([cpu]).collect()
        };
        let lines: Vec<Vec<String>> = rows.iter().map(line).collect();
        let header = ["data", " model", "nMSE", "of the worst joint", "rigid body", "CPU s"];
        println!("{}\n\nnMSE of the exact torque on new runs; mean over {seeds} seeds.", table(&header, &lines));
        Ok(())
    }
}

impl Case {
    fn row(&self, plan: &Plan, seeds: u64) -> anyhow::Result<Row> {
        let mut row = Row {
            case: self.name,
            model: self.preset.id(),
            seeds,
            nmse: 0.0,
            nmse_of_worst_joint: 0.0,
            rigid_body_nmse: 0.0,
            cpu_s: Some(0.0),
        };
        for seed in 0..seeds {
            let recording = self.recording(seed, self.torque_noise)?;
            let (test, split) = (self.recording(FIRST_TEST_SEED + seed, 0.0)?, Split::automatic(&recording));
            let mut plan = plan.clone();
            plan.options.seed = seed;
            let before = cpu_seconds();
            let network = Preset::Learned(self.preset).model(&recording)?;
            let trained = fit(&network, &recording, &split, &plan, None, &Monitor::new(), &mut |_| {})?;
            let used = before.zip(cpu_seconds()).map(|(before, after)| after - before);
            let every_joint: Vec<usize> = (0..self.joints).collect();
            let mut body = Preset::RigidBody.model(&recording)?;
            for (effect, _) in self.effects {
                body = body.with_effect(registry::find(effect)?, &every_joint)?;
            }
            let solved = model::fit(&body, &recording, &split, &Monitor::new())?;
            let (nmse, worst) = errors(&trained.fitted, &test)?;
            let share = 1.0 / seeds as f64;
            row.nmse += share * nmse;
            row.nmse_of_worst_joint += share * worst;
            row.rigid_body_nmse += share * errors(&solved, &test)?.0;
            row.cpu_s = row.cpu_s.zip(used).map(|(sum, used)| sum + share * used);
        }
        Ok(row)
    }

    fn recording(&self, seed: u64, torque_noise: f64) -> anyhow::Result<Recording> {
        let mut motion = Scenario::embedded().motion;
        if let Excitation::MultiSine { trajectories, .. } = &mut motion {
            *trajectories = 20;
        }
        let hidden = |(effect, parameters): &(&str, &[f64])| {
            let on = |joint| HiddenEffect {
                effect: (*effect).to_owned(),
                joint: Some(joint),
                parameters: parameters.to_vec(),
            };
            (0..self.joints).map(on).collect::<Vec<_>>()
        };
        let effects = self.effects.iter().flat_map(hidden).collect();
        let scenario =
            Scenario { arm: Arm::uniform(self.joints), motion, effects, torque_noise, seed, ..Scenario::embedded() };
        Ok(simulate(&scenario, &Monitor::new()).map_err(SessionError::from)?)
    }
}

/// nMSE of all joints together, and of the worst one.
fn errors(fitted: &Fitted, test: &Recording) -> anyhow::Result<(f64, f64)> {
    let joints = Evaluation::of(fitted, test, &Split { held_out: test.runs().collect(), ..Split::default() })?.held_out;
    let error: f64 = joints.iter().map(|joint| joint.mse).sum();
    let energy: f64 = joints.iter().map(|joint| joint.mse / joint.nmse).sum();
    Ok((error / energy, joints.iter().map(|joint| joint.nmse).fold(0.0, f64::max)))
}
