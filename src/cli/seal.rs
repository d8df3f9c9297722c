use anyhow::Context;
use clap::{Args, Subcommand};
use serde::Serialize;

use super::data::OptionalData;
use super::failure::OrUsage;
use super::progress;
use super::table::{number, numbers, table};
use crate::effect::registry;
use crate::recording::correction::Correction;
use crate::recording::seal::{self, HiddenEffect, Truth};
use crate::recording::{Joint, JointKind};
use crate::session::Command;

/// The seal of a simulated recording.
#[derive(Subcommand)]
pub enum SealCommand {
    Open(Open),
}

/// Open the seal: names what was hidden in a simulated recording.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope seal open mystery.npz
  torquescope seal open mine.torquescope --json")]
pub struct Open {
    #[command(flatten)]
    data: OptionalData,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    effects: Vec<Hidden>,
    /// What else was there, in a world of bodies.
    causes: Vec<Cause>,
    /// What sets the log right, where it was set up wrongly on purpose.
    set_up: Vec<Correction>,
    /// Standard deviation by joint.
    torque_noise: Vec<f64>,
    seed: u64,
}

#[derive(Serialize)]
struct Hidden {
    effect: String,
    /// Counted from 1; `None` for an effect of the whole arm.
    joint: Option<usize>,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct Parameter {
    name: String,
    value: f64,
    unit: String,
}

#[derive(Serialize)]
struct Cause {
    effect: String,
    joint: Option<usize>,
    /// RMS of its torque over that of the joints that felt it.
    share: f64,
}

impl SealCommand {
    /// Does what is asked for.
    pub fn run(&self) -> anyhow::Result<()> {
        let SealCommand::Open(command) = self;
        command.run()
    }
}

impl Open {
    fn run(&self) -> anyhow::Result<()> {
        if self.data.files().is_empty() {
            return Err(anyhow::anyhow!("name a simulated recording or a session")).or_usage();
        }
        let session = progress::run(Command::OpenSeal, self.data.document_or_embedded()?.history.current())?;
        let joints = session.recording.as_deref().map_or(&[][..], |recording| &recording.joints);
        let answer = Answer::of(session.truth.as_deref().context("the recording has no seal")?, joints);
        match self.json {
            true => println!("{}", serde_json::to_string_pretty(&answer)?),
            false => answer.print(),
        }
        Ok(())
    }
}

impl Answer {
    /// The truth in the units of the joints on which it acts; an effect of the whole arm has those of the first, as in a model.
    fn of(truth: &Truth, joints: &[Joint]) -> Self {
        let hidden = |hidden: &HiddenEffect| {
            let kind = joints.get(hidden.joint.unwrap_or(0)).map_or(JointKind::Revolute, |joint| joint.kind);
            let specs = registry::find(&hidden.effect).map_or(&[][..], |effect| effect.parameters);
            let parameters = specs.iter().zip(&hidden.parameters).map(|(spec, value)| Parameter {
                name: spec.name.to_owned(),
                value: *value,
                unit: spec.dimension.unit(kind).to_owned(),
            });
            Hidden { effect: hidden.effect.clone(), joint: counted(hidden.joint), parameters: parameters.collect() }
        };
        let cause = |cause: &seal::Cause| Cause {
            effect: cause.effect.clone(),
            joint: counted(cause.joint),
            share: cause.share,
        };
        Answer {
            effects: truth.effects.iter().map(hidden).collect(),
            causes: truth.causes.iter().map(cause).collect(),
            set_up: truth.set_up.clone(),
            torque_noise: truth.torque_noise.clone(),
            seed: truth.seed,
        }
    }

    fn print(&self) {
        if self.effects.is_empty() && self.causes.is_empty() && self.set_up.is_empty() {
            println!("nothing was hidden");
        }
        for correction in &self.set_up {
            println!("set up wrongly: {}; right with --set-right {correction}", correction.fault());
        }
        let place = |joint: &Option<usize>| joint.map_or("the whole arm".to_owned(), |joint| format!("joint {joint}"));
        for hidden in &self.effects {
            println!("{} on {}", hidden.effect, place(&hidden.joint));
            let row = |it: &Parameter| vec![it.name.clone(), number(it.value), it.unit.clone()];
            let rows: Vec<Vec<String>> = hidden.parameters.iter().map(row).collect();
            println!("{}", table(&["  parameter", "value", " unit"], &rows));
        }
        for cause in &self.causes {
            let percent = 100.0 * cause.share;
            println!("{} on {}: {percent:.1} % of the torque", cause.effect, place(&cause.joint));
        }
        println!("torque noise by joint: {}; seed {}", numbers(&self.torque_noise), self.seed);
    }
}

/// People count joints from 1.
fn counted(joint: Option<usize>) -> Option<usize> {
    joint.map(|joint| joint + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Arm;

    #[test]
    fn what_acts_on_a_sliding_joint_has_its_units() {
        let hidden =
            |joint| HiddenEffect { effect: "viscous-friction".into(), joint: Some(joint), parameters: vec![2.0] };
        let truth = Truth {
            arm: Arm::uniform(2),
            effects: vec![hidden(0), hidden(1)],
            causes: Vec::new(),
            torque_noise: vec![0.0; 2],
            seed: 1,
            set_up: Vec::new(),
        };
        let joints = [Joint::numbered(1), Joint { kind: JointKind::Prismatic, ..Joint::numbered(2) }];
        let answer = Answer::of(&truth, &joints);
        let units: Vec<&str> = answer.effects.iter().map(|hidden| hidden.parameters[0].unit.as_str()).collect();
        assert_eq!(units, ["N m s/rad", "N s/m"]);
    }
}
