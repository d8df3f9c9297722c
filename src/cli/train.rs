use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, anyhow, bail};
use clap::Args;
use serde::Serialize;

use super::data::Data;
use super::failure::OrUsage;
use super::table::{number, table, titled};
use super::{evaluate, progress, write_file};
use crate::model::{self, Evaluation, JointError, Parameter};
use crate::progress::Epoch;
use crate::recording::Recording;
use crate::recording::split::Split;
use crate::session::{Command, Session, Spread, Step, file};
use crate::training::{self, OtherStart};

/// Identify a model from recordings and save it.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope train arm.npz --add stribeck-friction@2 -o model.json
  torquescope train arm.npz --model structured-delan -o delan.model
  torquescope train arm.npz --model delan-friction --recipe thorough --hidden 64,64 --checkpoint run.npz
  torquescope train arm.npz --resume run.npz -o friction.model
  torquescope train arm.npz --model structured-delan --seeds 5
  torquescope train arm.npz --model structured-delan --seeds 5 -o seeds.torquescope  # then: torquescope figure train seeds.torquescope …")]
pub struct Train {
    /// Where to save the model: JSON, or an archive of JSON and weights if it has networks; a file that ends in .torquescope is the
    /// whole session, with the models of all seeds.
    #[arg(short, long, value_name = "MODEL|SESSION")]
    output: Option<PathBuf>,
    /// Where training with networks saves itself every 5 s and at its end, to be resumed.
    #[arg(long, value_name = "RUN")]
    checkpoint: Option<PathBuf>,
    /// Goes on with the training that --checkpoint saved, as if it had never been interrupted: with its model and settings, on
    /// the same recordings.
    #[arg(long, value_name = "RUN")]
    resume: Option<PathBuf>,
    /// Train networks from so many seeds, and tell mean, least and greatest of the held-out error; saved is the one with the
    /// smallest validation error.
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=MOST_SEEDS), conflicts_with_all = ["checkpoint", "resume"])]
    seeds: u64,
    /// Identify by plain least squares, as most published parameters were, to compare with them: from the whole log, with dry friction
    /// that jumps, and with derivatives as --low-pass makes them. Samples of a joint that is slower than SPEED [rad/s or m/s] do not
    /// count; all do if none is given. How good the model is elsewhere is not known then.
    #[arg(long, value_name = "SPEED", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = speed)]
    #[arg(conflicts_with_all = ["held_out", "resume", "checkpoint", "seeds"])]
    plain: Option<f64>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    data: Data,
}

/// Most seeds that a model is trained from.
const MOST_SEEDS: u64 = 100;

/// One of several trainings of a model.
#[derive(Serialize)]
struct OfSeed<'a> {
    name: &'a str,
    seed: u64,
    held_out: &'a [JointError],
    other_starts: &'a [OtherStart],
    history: &'a [Epoch],
}

impl<'a> OfSeed<'a> {
    fn of(step: &'a Step) -> Option<Self> {
        let run = step.run.as_deref()?;
        let held_out = &step.evaluation.held_out;
        let (name, seed, history) = (&step.name, run.plan.options.seed, &step.history);
        Some(OfSeed { name, seed, held_out, other_starts: &run.other_starts, history })
    }
}

#[derive(Serialize)]
struct Answer<'a> {
    name: &'a str,
    terms: Vec<String>,
    parameters: &'a [Parameter],
    train: &'a [JointError],
    held_out: &'a [JointError],
    /// All joints together.
    all_train: &'a JointError,
    /// All joints together.
    all_held_out: &'a JointError,
    noise_floor_nmse: &'a Option<Vec<f64>>,
    /// Starts that were tried beside the one that was kept, since a training got stuck.
    other_starts: &'a [OtherStart],
    /// Epochs of training; empty for models without networks.
    history: &'a [Epoch],
    /// All trainings, where several seeds were asked for.
    seeds: Vec<OfSeed<'a>>,
    /// Their held-out nMSE by joint.
    held_out_nmse_of_seeds: Vec<Spread>,
}

impl Train {
    /// Reads, fits, saves, prints. A training that ended early is a failure, but its best weights so far are saved.
    pub fn run(&self) -> anyhow::Result<()> {
        self.output.iter().chain(&self.checkpoint).try_for_each(|path| self.data.check_output(path))?;
        if self.plain.is_some() && self.data.asks_for_networks()? {
            return Err(anyhow!("--plain solves for the parameters of a model: one with networks is trained instead"))
                .or_usage();
        }
        let document = self.output.as_deref().filter(|path| file::is_session(path));
        if self.plain.is_some() && document.is_some() {
            return Err(anyhow!("--plain makes no session: save the model it finds as .json")).or_usage();
        }
        let session = match &self.resume {
            Some(run) => self.data.session_resuming(run, self.checkpoint.clone())?,
            None => self.data.session_keeping(self.checkpoint.clone())?,
        };
        let session = match self.seeds {
            1 => session,
            seeds => progress::run(Command::TrainSeeds { begin: None, seeds }, &session)?,
        };
        let step = session.current().context("no model was fitted")?;
        let step = match self.plain {
            Some(slowest) => &Arc::new(plain(step, &session, slowest)?),
            None => step,
        };
        let seeds: Vec<OfSeed> = match self.seeds {
            1 => Vec::new(),
            _ => session.seeds_of(step).into_iter().filter_map(|step| OfSeed::of(step)).collect(),
        };
        let of_seeds = spreads(&seeds);
        if self.checkpoint.is_some() && step.run.is_none() {
            bail!("--checkpoint is for models with networks: this one is solved for at once");
        }
        if let Some(path) = &self.output {
            let bytes = match document {
                // Where it kept itself while it was at work concerns nobody any more.
                Some(_) => file::to_bytes(&Session { checkpoint_file: None, ..session.clone() }.into())?,
                None => training::fit::to_bytes(&step.fitted)?,
            };
            write_file(path, &bytes)?;
        }
        if let Some(reason) = step.early_end() {
            match &self.output {
                Some(path) => bail!("training ended early: {reason}, saved as {}", path.display()),
                None => bail!("training ended early: {reason}; name a file with -o to save them"),
            }
        }
        let evaluation = &step.evaluation;
        if self.json {
            let answer = Answer {
                name: &step.name,
                terms: step.fitted.model.terms.iter().map(model::Term::label).collect(),
                parameters: &step.fitted.parameters,
                train: &evaluation.train,
                held_out: &evaluation.held_out,
                all_train: &evaluation.all_train,
                all_held_out: &evaluation.all_held_out,
                noise_floor_nmse: &evaluation.noise_floor_nmse,
                other_starts: step.run.as_ref().map_or(&[], |run| &run.other_starts),
                history: &step.history,
                seeds,
                held_out_nmse_of_seeds: of_seeds,
            };
            println!("{}", serde_json::to_string_pretty(&answer)?);
            return Ok(());
        }
        let is_stated = step.fitted.parameters.iter().any(|parameter| parameter.stated.is_some());
        let rows: Vec<Vec<String>> = step
            .fitted
            .parameters
            .iter()
            .map(|parameter| {
                let interval = match parameter.interval {
                    Some([low, high]) => format!("[{}, {}]", number(low), number(high)),
                    None if step.run.is_some() => "–".to_owned(),
                    None => "not shown by these data".to_owned(),
                };
                let joint = parameter.joint.map_or("–".to_owned(), |joint| (joint + 1).to_string());
                let term = step.fitted.model.terms[parameter.term].label();
                let stated = is_stated.then(|| parameter.stated.map_or(String::new(), number));
                let known = [term, parameter.name.clone(), joint, number(parameter.value), interval].into_iter();
                known.chain(stated).chain([parameter.unit.clone()]).collect()
            })
            .collect();
        println!("model: {}\n", step.name);
        if let Some(last) = step.history.last() {
            println!(
                "trained {} epochs in {:.1} s, {} samples/s\n",
                last.epoch,
                last.elapsed_s,
                number(last.samples_per_s)
            );
        }
        if let Some(starts) = step.run.as_ref().and_then(|run| run.starts_text()) {
            println!("{starts}\n");
        }
        if !rows.is_empty() {
            let mut titles = vec!["term", "parameter", "joint", "value", "95 % interval", "as stated", " unit"];
            if !is_stated {
                titles.retain(|title| *title != "as stated");
            }
            println!("{}\n", table(&titles, &rows));
        }
        if let Some(text) = step.fitted.beside_stated() {
            println!("{text}\n");
        }
        let recording = session.recording.as_deref().context("no recording was read")?;
        println!("{}\n", evaluate::error_table("training data", recording, &evaluation.train, &evaluation.all_train));
        match self.plain {
            Some(_) => println!("held-out data: none"),
            None => println!(
                "{}",
                evaluate::error_table("held-out data", recording, &evaluation.held_out, &evaluation.all_held_out)
            ),
        }
        if !of_seeds.is_empty() {
            println!("\n{}", seeds_table(recording, &of_seeds, seeds.len()));
        }
        if let Some(path) = &self.output {
            progress::told(format_args!("\nsaved as {}", path.display()));
        }
        Ok(())
    }
}

/// A speed that some samples may have.
fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse::<f64>().ok().filter(|speed| speed.is_finite() && *speed >= 0.0);
    speed.ok_or_else(|| format!("`{text}` is no speed: give a number from 0 on"))
}

/// The model identified by plain least squares instead.
fn plain(step: &Step, session: &Session, slowest: f64) -> anyhow::Result<Step> {
    let recording = session.recording.clone().context("no recording was read")?;
    let model = step.fitted.model.clone();
    let identified = Arc::clone(&recording);
    let fitted = progress::watch("identify", move |monitor| model::fit_plain(&model, &identified, slowest, monitor))
        .or_usage()?;
    let evaluation = Evaluation::of(&fitted, &recording, &Split::whole(&recording))?;
    Ok(Step { fitted, evaluation, ..step.clone() })
}

/// Held-out nMSE of each joint over several trainings; of none there is nothing.
fn spreads(seeds: &[OfSeed]) -> Vec<Spread> {
    let joints = seeds.first().map_or(0, |seed| seed.held_out.len());
    (0..joints).filter_map(|joint| Spread::of(seeds.iter().map(|seed| seed.held_out[joint].nmse))).collect()
}

fn seeds_table(recording: &Recording, spreads: &[Spread], seeds: usize) -> String {
    let row = |(joint, spread): (&crate::recording::Joint, &Spread)| {
        let Spread { mean, least, greatest } = *spread;
        [joint.name.clone()].into_iter().chain([mean, least, greatest].map(number)).collect()
    };
    let rows: Vec<Vec<String>> = recording.joints.iter().zip(spreads).map(row).collect();
    titled(&format!("held-out nMSE of {seeds} seeds"), &["joint", "mean", "least", "greatest"], &rows)
}
