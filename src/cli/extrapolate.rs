use clap::{Args, ValueEnum};

use super::data::Data;
use super::progress;
use super::table::{number, table};
use crate::session::Command;
use crate::simulation::extrapolation::{Basis, Stretch};

/// How the error of a model, and of each step to it, grows outside the data.
///
/// A simulated recording is travelled anew, with the exact torque of its sealed arm; a measured one is sorted by speed.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope extrapolate arm.npz
  torquescope extrapolate arm.npz --add coulomb-friction@1,2 --stretch load")]
pub struct Extrapolate {
    /// Faster, wider about the middle of each path, or with a heavier last link.
    #[arg(long, default_value = "speed")]
    stretch: Way,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    data: Data,
}

/// In which way.
#[derive(Clone, Copy, ValueEnum)]
enum Way {
    /// The same paths, faster.
    Speed,
    /// Wider paths in the same time.
    Range,
    /// The same paths with a heavier last link; of measured data, blocks of larger torque.
    Load,
}

impl Extrapolate {
    /// Computes and prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let session = self.data.session_with_model()?;
        let stretch = match self.stretch {
            Way::Speed => Stretch::Speed,
            Way::Range => Stretch::Range,
            Way::Load => Stretch::Load,
        };
        let session = progress::run(Command::Extrapolate { steps: session.ladder.clone(), stretch }, &session)?;
        let Some(sweep) = &session.sweep else { return Ok(()) };
        if self.json {
            println!("{}", serde_json::to_string_pretty(sweep.as_ref())?);
            return Ok(());
        }
        let mut rows = Vec::new();
        for curve in &sweep.curves {
            for point in &curve.points {
                let joints: Vec<String> = point.joints.iter().copied().map(number).collect();
                let band = format!("{} … {}", number(point.band[0]), number(point.band[1]));
                let scale = format!("{:.2}", point.scale);
                rows.push(vec![curve.model.clone(), scale, number(point.overall), band, joints.join(", ")]);
            }
        }
        println!("{}", table(&["model", "scale", "nMSE", "four in five blocks", "nMSE by joint"], &rows));
        println!(
            "{}",
            match sweep.basis {
                Basis::Simulated => "The held-out runs, travelled anew by the simulated arm; the torque is exact.",
                Basis::Measured => "Held-out blocks of a second, sorted; the scale is relative to the training part.",
            }
        );
        Ok(())
    }
}
