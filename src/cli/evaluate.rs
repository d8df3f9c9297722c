use anyhow::Context;
use clap::Args;
use serde::Serialize;

use super::data::Data;
use super::progress;
use super::table::{number, numbers, table, titled};
use super::truth::{self, ComponentError, ParameterError};
use crate::model::{Evaluation, Fitted, JointError};
use crate::recording::Recording;
use crate::recording::split::{Segment, Split};
use crate::session::Session;
use crate::training::components;
use crate::training::rollout::{HORIZON, Rollout};

/// Measure a model's error on recordings.
///
/// With `--model FILE` the saved model is measured on all samples. With a preset, the preset is identified on the training part and
/// measured on the held-out part; of a saved session in place of recordings it is the current model, or --of NAME, there.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope evaluate arm.npz --add coulomb-friction
  torquescope evaluate arm.npz --add coulomb-friction --rollout
  torquescope evaluate mine.torquescope --of 'rigid body + Coulomb 1, 2'
  torquescope evaluate arm.npz --model delan-friction --open-seal")]
pub struct Evaluate {
    /// Open the seal of a simulated recording, and compare inertial, Coriolis and gravity torque and the parameters of effects
    /// with the truth as well.
    #[arg(long)]
    open_seal: bool,
    /// Simulate the arm of the model as well: moved by the measured torque, from states along the samples that are measured, how
    /// far is each joint from where it was measured a quarter of a second later?
    #[arg(long)]
    rollout: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    data: Data,
}

/// How large the torque of one term is.
#[derive(Serialize)]
struct TermShare {
    term: String,
    /// RMS over all samples, as a share of that of the measured torque, for each joint.
    share: Vec<f64>,
}

/// The eigenvalues of the mass matrix over all samples \[kg m²\]; a physical arm has only positive ones.
#[derive(Serialize)]
struct MassEigenvalues {
    smallest: f64,
    largest: f64,
    /// Share of samples with one that is not positive.
    not_positive: f64,
}

#[derive(Serialize)]
struct Answer {
    data: &'static str,
    joints: Vec<JointError>,
    /// All joints together: the sums of errors and torques are over samples and joints.
    all: JointError,
    mean_r2: f64,
    noise_floor_nmse: Option<Vec<f64>>,
    terms: Vec<TermShare>,
    /// Only with an opened seal; over all samples.
    components: Option<Vec<ComponentError>>,
    /// Only with an opened seal.
    parameters: Option<Vec<ParameterError>>,
    /// Only of models with a mass matrix that is learned.
    mass_eigenvalues: Option<MassEigenvalues>,
    /// Only with `--rollout`; from the samples that are measured.
    rollout: Option<Rollout>,
}

impl Evaluate {
    /// Reads, predicts, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let (data, session, fitted, evaluation, parts) = match self.data.saved_model()? {
            Some(fitted) => {
                let session = self.data.session()?;
                let (evaluation, everything) = evaluate_all(&session, &fitted)?;
                ("all samples", session, fitted, evaluation, everything)
            }
            None => {
                let session = self.data.session_with_model()?;
                let step = session.current().context("no model was fitted")?.clone();
                let held_out = session.split.held_out.clone();
                ("held-out samples", session, step.fitted.clone(), step.evaluation.clone(), held_out)
            }
        };
        let rollout = if self.rollout { Some(rollout(&session, &fitted, parts)?) } else { None };
        let truth = if self.open_seal { Some(truth::compare(&session, &fitted)?) } else { None };
        let (components, parameters) = truth.map(|truth| (truth.components, truth.parameters)).unzip();
        let terms = term_shares(&session, &fitted, &evaluation)?;
        let mass_eigenvalues = mass_eigenvalues(&session, &fitted)?;
        let (joints, all) = (evaluation.held_out, evaluation.all_held_out);
        let recording = session.recording.as_deref().context("no recording was read")?;
        let mean_r2 = joints.iter().map(|joint| joint.r2).sum::<f64>() / joints.len().max(1) as f64;
        if self.json {
            let noise_floor_nmse = evaluation.noise_floor_nmse;
            let answer = Answer {
                data,
                joints,
                all,
                mean_r2,
                noise_floor_nmse,
                terms,
                components,
                parameters,
                mass_eigenvalues,
                rollout,
            };
            println!("{}", serde_json::to_string_pretty(&answer)?);
        } else {
            println!("{}", error_table(data, recording, &joints, &all));
            if let Some(floor) = &evaluation.noise_floor_nmse {
                println!("noise floor (nMSE): {}", numbers(floor));
            }
            let percent = |share: &f64| format!("{:.2}", 100.0 * share);
            let row = |term: &TermShare| {
                vec![term.term.clone(), term.share.iter().map(percent).collect::<Vec<_>>().join(", ")]
            };
            let rows: Vec<Vec<String>> = terms.iter().map(row).collect();
            let share = format!("share of the {} by joint [%]", recording.effort());
            println!("{}", table(&["term", &share], &rows));
            for error in components.iter().flatten() {
                let (part, effort) = (&error.component, recording.effort());
                println!("{part} {effort}, against the truth (nMSE): {}", number(error.nmse));
            }
            if let Some(parameters) = parameters.filter(|parameters| !parameters.is_empty()) {
                println!("{}", parameter_table(&parameters));
            }
            if let Some(Rollout { error, starts, ran_away }) = rollout {
                let unit = &recording.units()[0];
                println!(
                    "RMS of q off after {HORIZON} s of simulation, from {starts} states, by joint [{unit}]: {}",
                    numbers(&error)
                );
                if ran_away > 0 {
                    println!("from {ran_away} of these states the arm ran away; they are left out");
                }
            }
            if let Some(MassEigenvalues { smallest, largest, not_positive }) = mass_eigenvalues {
                println!(
                    "eigenvalues of the mass matrix: {} to {} {}, not all positive in {} % of the samples",
                    number(smallest),
                    number(largest),
                    if recording.units()[3] == "N" { "kg" } else { "kg m²" },
                    number(100.0 * not_positive)
                );
            }
        }
        Ok(())
    }
}

/// How far the arm of the model runs from these parts.
fn rollout(session: &Session, fitted: &Fitted, parts: Vec<Segment>) -> anyhow::Result<Rollout> {
    let (recording, fitted) = (session.recording.clone().context("no recording was read")?, fitted.clone());
    progress::watch("simulate the model", move |monitor| Rollout::of(&fitted, &recording, &parts, monitor))
}

/// A saved model on all samples, and where they are.
fn evaluate_all(session: &Session, fitted: &Fitted) -> anyhow::Result<(Evaluation, Vec<Segment>)> {
    let recording = session.recording.as_deref().context("no recording was read")?;
    let joints = fitted.setting().kinds.len();
    if recording.joint_count() != joints {
        anyhow::bail!(
            "the model has {joints} joints, the recording {}: use recordings of the arm that it was trained on",
            recording.joint_count()
        );
    }
    let split = Split { held_out: recording.runs().collect(), ..Split::default() };
    Ok((Evaluation::of(fitted, recording, &split)?, split.held_out))
}

/// `None` if the model has no mass matrix that is learned.
fn mass_eigenvalues(session: &Session, fitted: &Fitted) -> anyhow::Result<Option<MassEigenvalues>> {
    let recording = session.recording.as_deref().context("no recording was read")?;
    let (mut smallest, mut largest, mut samples, mut not_positive) = (f64::INFINITY, f64::NEG_INFINITY, 0, 0);
    for trajectory in &recording.trajectories {
        let parts = components(fitted, trajectory)?;
        let Some((_, by_order)) = parts.iter().find(|(name, _)| *name == "mass_eigenvalue") else { return Ok(None) };
        // They are in ascending order.
        let (Some(least), Some(most)) = (by_order.iter().next(), by_order.iter().last()) else { return Ok(None) };
        smallest = least.iter().copied().fold(smallest, f64::min);
        largest = most.iter().copied().fold(largest, f64::max);
        samples += least.len();
        not_positive += least.iter().filter(|value| **value <= 0.0).count();
    }
    Ok(Some(MassEigenvalues { smallest, largest, not_positive: not_positive as f64 / samples.max(1) as f64 }))
}

/// What each term contributes to all predictions.
fn term_shares(session: &Session, fitted: &Fitted, evaluation: &Evaluation) -> anyhow::Result<Vec<TermShare>> {
    let recording = session.recording.as_deref().context("no recording was read")?;
    let energy = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let measured = |joint: usize| recording.trajectories.iter().map(|run| energy(&run.tau[joint])).sum::<f64>();
    let share = |term: usize, joint: usize| {
        let own: f64 = evaluation.predictions.iter().map(|run| energy(&run.terms[term][joint])).sum();
        (own / measured(joint)).sqrt()
    };
    let of_term = |(index, term): (usize, &crate::model::Term)| TermShare {
        term: term.label(),
        share: (0..recording.joint_count()).map(|joint| share(index, joint)).collect(),
    };
    Ok(fitted.model.terms.iter().enumerate().map(of_term).collect())
}

/// Parameters beside the truth as text.
fn parameter_table(parameters: &[ParameterError]) -> String {
    let row = |own: &ParameterError| {
        let joint = own.joint.map_or("–".to_owned(), |joint| joint.to_string());
        let error = 100.0 * (own.value / own.truth - 1.0);
        let (value, truth) = (number(own.value), number(own.truth));
        vec![own.parameter.clone(), joint, value, truth, format!("{error:+.2} %"), own.unit.clone()]
    };
    let rows: Vec<Vec<String>> = parameters.iter().map(row).collect();
    table(&["parameter", "joint", "value", "truth", "error", " unit"], &rows)
}

/// Errors on these data by joint, and of all together, as text.
pub fn error_table(data: &str, recording: &Recording, joints: &[JointError], all: &JointError) -> String {
    let row = |name: String, error: &JointError| {
        vec![name, number(error.mse), number(error.nmse), format!("{:.4}", error.r2)]
    };
    let mut rows: Vec<Vec<String>> =
        joints.iter().enumerate().map(|(joint, error)| row((joint + 1).to_string(), error)).collect();
    if joints.len() > 1 {
        rows.push(row("all".to_owned(), all));
    }
    let mse = match recording.units()[3].as_str() {
        "N" => "MSE [N²]".to_owned(),
        unit => format!("MSE [({unit})²]"),
    };
    titled(data, &["joint", &mse, "nMSE", "R²"], &rows)
}
