use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use super::choice::level;
use super::diagnose::text;
use super::table::{numbers, table};
use super::{output_folder, progress, write_file};
use crate::app::screens::{self, ladder};
use crate::app::{self, ScreenshotOptions};
use crate::recording::{joints_text, write};
use crate::session::{Command, Session, View};
use crate::simulation::{Level, Scenario};

/// The whole story without a window: simulate an arm with a hidden effect, fit, diagnose, add, report, draw.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope demo
  torquescope demo --seed 7 --no-pictures
  torquescope demo --seed 7 --level real
  torquescope demo -o story")]
pub struct Demo {
    /// Where the recording and the pictures go.
    #[arg(short, long, default_value = "torquescope-demo")]
    output: PathBuf,
    /// Draw another mystery by its seed, instead of the embedded one.
    #[arg(long)]
    seed: Option<u64>,
    /// Draw another mystery, so hard to find.
    #[arg(long, value_parser = level())]
    level: Option<Level>,
    /// Draw no pictures.
    #[arg(long)]
    no_pictures: bool,
}

impl Demo {
    /// Runs the story.
    pub fn run(&self) -> anyhow::Result<()> {
        let simulate = match (self.seed, self.level) {
            (None, None) => Command::Simulate(Box::new(Scenario::embedded())),
            (seed, level) => Command::DrawMystery { level: level.unwrap_or_default(), seed: seed.unwrap_or(1) },
        };
        output_folder(&self.output)?;
        let mut session = progress::run(simulate, &Session::default())?;
        let recording = session.recording.clone().context("nothing was simulated")?;
        println!(
            "1. Simulated {}: {} joints, {} samples; what is hidden in it is sealed.",
            recording.name,
            recording.joint_count(),
            recording.sample_count()
        );
        write_file(&self.output.join("recording.npz"), &write::to_npz_bytes(&recording)?)?;
        let first = session.current().context("no model was fitted")?.clone();
        println!("2. Fitted {}: held-out nMSE by joint {}.", first.name, numbers(&first.evaluation.held_out_nmse()));
        session = progress::run(Command::Diagnose, &session)?;
        let diagnosed = session.clone();
        let report = session.report.clone().context("there is no report")?;
        println!("3. Diagnosed:\n");
        println!("{}\n", indented(&text(&report)));
        for effect in &report.effects {
            let command = Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() };
            session = progress::run(command, &session)?;
        }
        println!("4. Added what it named; the ladder of held-out errors:\n\n{}\n", indented(&ladder_table(&session)));
        session = progress::run(Command::OpenSeal, &session)?;
        let truth = session.truth.clone().context("the seal is empty")?;
        println!("5. Opened the seal. It was:");
        for hidden in &truth.effects {
            let place = hidden.joint.map_or("the whole arm".to_owned(), |joint| joints_text(&[joint]));
            println!("   {} on {place}: {}", hidden.effect, numbers(&hidden.parameters));
        }
        if !self.no_pictures {
            for screen in screens::all() {
                // The ladder shows the repaired model, the other screens the one that still lacks the effect.
                let shown = if *screen == ladder::ABOUT { &session } else { &diagnosed };
                let options = ScreenshotOptions { screen: screen.id.to_owned(), ..ScreenshotOptions::default() };
                let picture = app::screenshot(shown.clone(), View::default(), &options)?;
                write_file(&self.output.join(format!("{}.png", screen.id)), &picture)?;
            }
        }
        progress::told(format_args!("\nThe recording and the pictures are in {}.", self.output.display()));
        Ok(())
    }
}

/// The ladder as text.
fn ladder_table(session: &Session) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for step in &session.ladder {
        let r2: Vec<String> = step.evaluation.held_out.iter().map(|joint| format!("{:.4}", joint.r2)).collect();
        rows.push(vec![step.name.clone(), numbers(&step.evaluation.held_out_nmse()), r2.join(", ")]);
    }
    if let Some(floor) = session.current().and_then(|step| step.evaluation.noise_floor_nmse.clone()) {
        rows.push(vec!["noise floor".to_owned(), numbers(&floor), String::new()]);
    }
    table(&["model", "held-out nMSE by joint", "R² by joint"], &rows)
}

fn indented(text: &str) -> String {
    text.lines()
        .map(|line| if line.is_empty() { String::new() } else { format!("   {line}") })
        .collect::<Vec<_>>()
        .join("\n")
}
