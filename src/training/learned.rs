//! A trained model and a checkpoint of its training: what they hold, as bytes and back.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};

use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipArchive, ZipWriter};

use super::data::{Columns, Mark};
use super::options::Options;
use super::predict::{Components, component_program, torque_program};
use super::{Samples, TrainError};
use crate::effect::Dimension;
use crate::file::Unpacking;
use crate::model::learned::Architecture;
use crate::network::{Element, Layout};
use crate::progress::Epoch;
use crate::recording::{Trajectory, npy};
use crate::signals::Signals;

/// Values of each block by its name; matrices are inputs × outputs, row after row.
pub type Weights = BTreeMap<String, Vec<f64>>;

/// A trained model.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedModel {
    /// What it is.
    pub architecture: Architecture,
    /// Its weights.
    pub weights: Weights,
}

/// All that a run needs to go on exactly as if it had never been interrupted.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// The best model so far.
    pub model: LearnedModel,
    /// The newest weights.
    pub weights: Weights,
    /// State of the optimiser for each block.
    pub states: BTreeMap<String, Vec<f64>>,
    /// Options of the run.
    pub options: Options,
    /// What it learns from.
    pub data: Mark,
    /// Epochs done.
    pub epoch: u64,
    /// Steps done.
    pub step: u64,
    /// Loss of the first step.
    pub first_loss: Option<f64>,
    /// Mean loss of this epoch's steps so far, as a share of the whole epoch.
    pub epoch_loss: f64,
    /// Error of the best model.
    pub best_error: Option<f64>,
    /// All epochs.
    pub history: Vec<Epoch>,
}

/// Everything of a file but its arrays.
#[derive(Serialize, Deserialize)]
struct Header {
    architecture: Architecture,
    #[serde(default)]
    run: Option<RunHeader>,
}

#[derive(Serialize, Deserialize)]
struct RunHeader {
    options: Options,
    data: Mark,
    epoch: u64,
    step: u64,
    first_loss: Option<f64>,
    epoch_loss: f64,
    best_error: Option<f64>,
    history: Vec<Epoch>,
}

/// One coefficient of trained friction.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionCoefficient {
    /// Such as `coulomb_torque`.
    pub name: &'static str,
    /// Symbol for formulas.
    pub symbol: &'static str,
    /// The joint, from 0.
    pub joint: usize,
    /// In the SI unit of its dimension.
    pub value: f64,
    /// Which sets its unit, as the joint turns or slides.
    pub dimension: Dimension,
}

impl LearnedModel {
    pub(super) fn new<E: Element>(architecture: Architecture, layout: &Layout, flat: &[E]) -> Self {
        let block = |block: &crate::network::Block| (block.name.clone(), layout.read(block, flat));
        LearnedModel { architecture, weights: layout.blocks().iter().map(block).collect() }
    }

    /// Copies the blocks that a layout has too, with the same size.
    pub(super) fn copy_common<E: Element>(&self, layout: &Layout, flat: &mut [E]) {
        for block in layout.blocks() {
            if let Some(values) = self.weights.get(&block.name)
                && values.len() == block.rows * block.columns
            {
                layout.write(block, values, flat);
            }
        }
    }

    fn flat<E: Element>(&self, layout: &Layout) -> Vec<E> {
        let mut flat = vec![E::ZERO; layout.size()];
        self.copy_common(layout, &mut flat);
        flat
    }

    /// Torque \[N m\] for each joint and sample of a motion.
    ///
    /// # Errors
    /// [`TrainError`] if the trajectory has other joints or columns than the model, or gaps.
    pub fn torque(&self, trajectory: &Trajectory, columns: &Columns) -> Result<Signals, TrainError> {
        let program = torque_program::<f32>(&self.architecture);
        let motion = self.motion::<f32>(trajectory, columns)?;
        let mut torque = vec![0.0; motion[0].len()];
        let (weights, mut arena) = (self.flat::<f32>(program.layout()), program.arena());
        let inputs = [&motion[0][..], &motion[1], &motion[2]];
        program.run(f32::kernels(), &weights, &mut arena, inputs, &motion[3], &mut torque);
        Ok(Signals::from_samples(self.architecture.joints, &torque))
    }

    /// Torque, terms, H, c, g and energies for a motion, in double precision.
    ///
    /// # Errors
    /// As [`LearnedModel::torque`].
    pub fn components(&self, trajectory: &Trajectory, columns: &Columns) -> Result<Components, TrainError> {
        let program = component_program::<f64>(&self.architecture);
        let [q, qd, qdd, columns] = self.motion::<f64>(trajectory, columns)?;
        Ok(program.run(f64::kernels(), &self.flat::<f64>(program.layout()), &q, &qd, &qdd, &columns))
    }

    /// q, q̇, q̈ and effect columns, sample after sample.
    fn motion<E: Element>(&self, trajectory: &Trajectory, columns: &Columns) -> Result<[Vec<E>; 4], TrainError> {
        // The torque is not read, so a motion without torque can be predicted too.
        let motion = trajectory.without_torque();
        let own = if columns.is_empty() { Vec::new() } else { vec![columns.clone()] };
        let samples = Samples::<E>::new(self.architecture.joints, &[motion], &own)?;
        samples.check(&self.architecture)?;
        Ok([samples.channel(0), samples.channel(1), samples.channel(2), samples.channel(4)])
    }

    /// Σ‖τ − τ̂‖² / Σ‖τ‖² over trajectories.
    ///
    /// # Errors
    /// As [`LearnedModel::torque`].
    pub fn normalised_error(&self, trajectories: &[Trajectory], columns: &[Columns]) -> Result<f64, TrainError> {
        let (mut error, mut size) = (0.0, 0.0);
        for (index, trajectory) in trajectories.iter().enumerate() {
            let torque = self.torque(trajectory, columns.get(index).unwrap_or(&Columns::new()))?;
            for (ours, measured) in torque.iter().flatten().zip(trajectory.tau.iter().flatten()) {
                error += (ours - measured).powi(2);
                size += measured.powi(2);
            }
        }
        Ok(error / size.max(f64::MIN_POSITIVE))
    }

    /// Trained factors of the effect columns, in SI units, in the order of the columns.
    pub fn effect_factors(&self) -> Vec<f64> {
        let scale = self.architecture.scales.torque;
        let values = self.weights.get("effects/factors").into_iter().flatten();
        let count = self.architecture.column_count();
        values.take(count).map(|value| scale * value).collect()
    }

    /// Trained coefficients of the friction term, in SI units; none without that term.
    pub fn friction_coefficients(&self) -> Vec<FrictionCoefficient> {
        let scale = self.architecture.scales.torque;
        let blocks: [(&str, &str, &str, Dimension); 4] = [
            ("tau_cv", "coulomb_torque", "τ_c", Dimension::Torque),
            ("tau_cs", "stribeck_torque", "τ_s", Dimension::Torque),
            ("log_v", "stribeck_velocity", "v_s", Dimension::Velocity),
            ("d", "viscous_coefficient", "d", Dimension::Damping),
        ];
        let mut coefficients = Vec::new();
        for (block, name, symbol, dimension) in blocks {
            let values = self.weights.get(&format!("friction/{block}")).into_iter().flatten();
            coefficients.extend(values.enumerate().map(|(joint, value)| {
                // What is trained is the logarithm of the velocity's square; the others are multiples of the torque scale.
                let value = if block == "log_v" { (0.5 * value).exp() } else { scale * value };
                FrictionCoefficient { name, symbol, joint, value, dimension }
            }));
        }
        coefficients
    }

    /// The model as an NPZ file: its architecture as JSON in `header`, its weights by name.
    ///
    /// # Errors
    /// [`TrainError::Damaged`] if the archive can't be written, which memory never refuses.
    pub fn to_bytes(&self) -> Result<Vec<u8>, TrainError> {
        let header = Header { architecture: self.architecture.clone(), run: None };
        pack(&header, &[("param", &self.weights)])
    }

    /// A model as [`LearnedModel::to_bytes`] or [`Checkpoint::to_bytes`] gave it.
    ///
    /// # Errors
    /// [`TrainError::Damaged`] if it is none, or not whole.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TrainError> {
        let (header, mut arrays) = unpack(bytes)?;
        let model = LearnedModel { weights: take(&mut arrays, "param"), architecture: header.architecture };
        model.check_whole(&model.weights)?;
        Ok(model)
    }

    fn check_whole(&self, weights: &Weights) -> Result<(), TrainError> {
        self.architecture.check()?;
        for block in self.architecture.build().graph.layout.blocks() {
            let values = weights.get(&block.name).map_or(0, Vec::len);
            if values != block.rows * block.columns {
                return Err(TrainError::Damaged(format!("`{}` is missing or of another size", block.name)));
            }
        }
        Ok(())
    }
}

impl Checkpoint {
    /// Whether a run can go on from here.
    ///
    /// # Errors
    /// [`TrainError::OtherCheckpoint`] if samples, architecture or options differ.
    pub fn check(&self, architecture: &Architecture, options: &Options, data: &Mark) -> Result<(), TrainError> {
        let other =
            |what: &str, checkpoint, run| TrainError::OtherCheckpoint { what: what.to_owned(), checkpoint, run };
        if self.data != *data {
            return Err(other("set of samples", self.data.describe(), data.describe()));
        }
        let own = &self.model.architecture;
        if own != architecture {
            return Err(other("architecture", own.describe(), architecture.describe()));
        }
        same_settings(&self.options.course(), &options.course())
    }

    /// The checkpoint as an NPZ file.
    ///
    /// # Errors
    /// As [`LearnedModel::to_bytes`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, TrainError> {
        let run = RunHeader {
            options: self.options.clone(),
            data: self.data.clone(),
            epoch: self.epoch,
            step: self.step,
            first_loss: self.first_loss,
            epoch_loss: self.epoch_loss,
            best_error: self.best_error,
            history: self.history.clone(),
        };
        let header = Header { architecture: self.model.architecture.clone(), run: Some(run) };
        pack(&header, &[("param", &self.model.weights), ("newest", &self.weights), ("state", &self.states)])
    }

    /// A checkpoint as [`Checkpoint::to_bytes`] gave it.
    ///
    /// # Errors
    /// [`TrainError::Damaged`] if it is none, or not whole.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TrainError> {
        let (header, mut arrays) = unpack(bytes)?;
        let run = header.run.ok_or_else(|| TrainError::Damaged("a model, but not a checkpoint".into()))?;
        let model = LearnedModel { architecture: header.architecture, weights: take(&mut arrays, "param") };
        let (weights, states) = (take(&mut arrays, "newest"), take(&mut arrays, "state"));
        model.check_whole(&model.weights)?;
        model.check_whole(&weights)?;
        let RunHeader { options, data, epoch, step, first_loss, epoch_loss, best_error, history } = run;
        Ok(Checkpoint {
            model,
            weights,
            states,
            options,
            data,
            epoch,
            step,
            first_loss,
            epoch_loss,
            best_error,
            history,
        })
    }
}

/// Whether two sets of settings are the same.
///
/// # Errors
/// [`TrainError::OtherCheckpoint`] names the first that differs.
pub(super) fn same_settings<T: Serialize>(checkpoint: &T, run: &T) -> Result<(), TrainError> {
    let fields = |settings: &T| match serde_json::to_value(settings) {
        Ok(serde_json::Value::Object(fields)) => fields,
        _ => serde_json::Map::new(),
    };
    let run = fields(run);
    for (name, own) in fields(checkpoint) {
        let theirs = run.get(&name).cloned().unwrap_or_default();
        if own != theirs {
            let (checkpoint, run) = (own.to_string(), theirs.to_string());
            return Err(TrainError::OtherCheckpoint { what: name, checkpoint, run });
        }
    }
    Ok(())
}

/// Name of the entry that holds the header as JSON.
const HEADER: &str = "torquescope-model.json";
/// No array of a model that can be built is larger.
const MOST_VALUES: usize = 1 << 28;

fn damaged(error: impl std::fmt::Display) -> TrainError {
    TrainError::Damaged(error.to_string())
}

fn pack(header: &Header, groups: &[(&str, &BTreeMap<String, Vec<f64>>)]) -> Result<Vec<u8>, TrainError> {
    // No time stamps, so that equal models are equal files.
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file(HEADER, options).map_err(damaged)?;
    archive.write_all(&serde_json::to_vec(header).map_err(damaged)?).map_err(damaged)?;
    for (group, arrays) in groups {
        for (name, values) in *arrays {
            archive.start_file(format!("{group}/{name}.npy"), options).map_err(damaged)?;
            let bytes = values.iter().flat_map(|value| value.to_le_bytes());
            archive.write_all(&npy::encode("<f8", &[values.len()], bytes)).map_err(damaged)?;
        }
    }
    Ok(archive.finish().map_err(damaged)?.into_inner())
}

fn unpack(bytes: &[u8]) -> Result<(Header, Weights), TrainError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let (mut header, mut arrays) = (None, Weights::new());
    let mut unpacking = Unpacking::of(bytes.len());
    for index in 0..archive.len() {
        let part = archive.by_index(index).map_err(damaged)?;
        let name = part.name().map_err(damaged)?.into_owned();
        let content = unpacking.part(part).map_err(damaged)?;
        if name == HEADER {
            header = Some(serde_json::from_slice(&content).map_err(damaged)?);
        } else if let Some(name) = name.strip_suffix(".npy") {
            arrays.insert(name.to_owned(), npy::decode(&content, MOST_VALUES).map_err(damaged)?.into_iter().collect());
        }
    }
    let header = header.ok_or_else(|| damaged("it has no header"))?;
    Ok((header, arrays))
}

/// The arrays of one group, without its name.
fn take(arrays: &mut Weights, group: &str) -> Weights {
    let prefix = format!("{group}/");
    let own =
        |(name, values): (&String, &Vec<f64>)| name.strip_prefix(&prefix).map(|name| (name.to_owned(), values.clone()));
    arrays.iter().filter_map(own).collect()
}
