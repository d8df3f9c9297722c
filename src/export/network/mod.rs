//! A trained network out of the house: its weights as safetensors and NPZ, an evaluator for NumPy, its torque as ONNX, and the states
//! by which they are tested.
//!
//! `docs/networks.md` tells the layout. Effects that were trained beside the network are a function of their own, written as for a
//! [`controller`].

use std::collections::HashMap;
use std::io::{Cursor, Write};

use safetensors::tensor::{Dtype, SafeTensorError, TensorView};
use serde_json::{Value, json};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

use super::controller::{self, CodeError, Language, LeftOut, Wish};
use crate::model::learned::LearnedTerm;
use crate::model::{Fitted, ModelError, Term};
use crate::network::onnx;
use crate::recording::{JointKind, Trajectory, npy};
use crate::training::fit::networks;
use crate::training::{LearnedModel, TrainError};

/// Computes the torque from `weights.npz`; the same for every model.
const EVALUATOR: &str = include_str!("evaluate.py");
/// What the arrays are is told under this name in the metadata of safetensors, and in an entry of the NPZ.
const ABOUT: &str = "model.json";
/// The layout that is told there.
const LAYOUT: u32 = 1;

/// The files of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Package {
    /// Their names, without a folder, and what is in them.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// Effects that are in none of them.
    pub left_out: Vec<LeftOut>,
}

/// A network can't be written.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    /// There is none.
    #[error(
        "the model has no network: export it as code, such as `torquescope export python model.json -o arm_torque.py`"
    )]
    None,
    /// The effects beside it can't be written.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// A term can't be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The weights are not those of its architecture.
    #[error(transparent)]
    Weights(#[from] TrainError),
    /// The tensors could not be put together.
    #[error("the safetensors could not be made: {0}")]
    Tensors(#[from] SafeTensorError),
    /// The archive could not be made.
    #[error("the archive could not be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The same, while writing an entry.
    #[error("the archive could not be made: {0}")]
    Entry(#[from] std::io::Error),
}

/// The files of a model's network. Dry friction of effects beside it turns round within `width` \[rad/s or m/s\]; the states of the
/// test are taken from `motion`, or drawn.
///
/// # Errors
/// [`NetworkError`] if the model has none, or an effect beside it can't be computed.
pub fn write(fitted: &Fitted, width: f64, motion: Option<&Trajectory>) -> Result<Package, NetworkError> {
    let model = networks(fitted).ok_or(NetworkError::None)?;
    let (effects, left_out) = effects_beside(fitted, &Wish { name: "effects", width, motion })?;
    let about = about(fitted, model, effects.is_some(), &left_out).to_string();
    let arrays = arrays(model);
    let kept = fitted.with_reversals_of(width).without(|term| left_out.iter().any(|out| out.term == term));
    let mut files = vec![
        ("weights.safetensors", safetensors(&arrays, &about)?),
        ("weights.npz", archive(&arrays, Some(&about))?),
        ("model.onnx", as_onnx(model, &about)),
        ("evaluate.py", EVALUATOR.as_bytes().to_vec()),
        ("vectors.npz", archive(&vectors(&kept, motion)?, None)?),
    ];
    files.extend(effects.map(|code| ("effects.py", code.into_bytes())));
    Ok(Package { files, left_out })
}

/// An array in C order.
struct Array {
    name: String,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl Array {
    fn new(name: &str, shape: Vec<usize>, values: impl IntoIterator<Item = f64>) -> Self {
        Array { name: name.to_owned(), shape, bytes: values.into_iter().flat_map(f64::to_le_bytes).collect() }
    }
}

/// The effects beside the network as a function of Python, if there are any, and those that it does not have.
fn effects_beside(fitted: &Fitted, wish: &Wish) -> Result<(Option<String>, Vec<LeftOut>), CodeError> {
    let terms = &fitted.model.terms;
    let beside: Vec<usize> = (0..terms.len()).filter(|&term| !matches!(terms[term], Term::Learned(_))).collect();
    let alone = fitted.without(|term| !beside.contains(&term));
    let (code, left_out) = match controller::write(&alone, Language::Python, wish) {
        _ if beside.is_empty() => (None, Vec::new()),
        Ok(mut code) => (Some(code.files.swap_remove(0).text), code.left_out),
        Err(CodeError::Nothing(left_out)) => (None, left_out),
        Err(other) => return Err(other),
    };
    Ok((code, left_out.into_iter().map(|out| LeftOut { term: beside[out.term], ..out }).collect()))
}

/// What a reader of the arrays must know.
fn about(fitted: &Fitted, model: &LearnedModel, has_effects: bool, left_out: &[LeftOut]) -> Value {
    let unit = |kind: &JointKind| if *kind == JointKind::Revolute { "rad" } else { "m" };
    json!({
        "layout": LAYOUT,
        "written_by": format!("Torquescope {}", env!("CARGO_PKG_VERSION")),
        "joint_units": fitted.setting().kinds.iter().map(unit).collect::<Vec<_>>(),
        "architecture": model.architecture,
        "effects": has_effects,
        "left_out": left_out.iter().map(|out| &out.name).collect::<Vec<_>>(),
    })
}

/// All weights: matrices inputs × outputs.
fn arrays(model: &LearnedModel) -> Vec<Array> {
    let layout = model.architecture.build().graph.layout;
    let array = |block: &crate::network::Block| {
        let (inputs, outputs) = block.shape();
        let shape = if block.name.ends_with("/w") { vec![inputs, outputs] } else { vec![outputs] };
        Array::new(&block.name, shape, model.weights.get(&block.name).into_iter().flatten().copied())
    };
    layout.blocks().iter().map(array).collect()
}

/// States and the torque of the model there, each samples × joints.
fn vectors(kept: &Fitted, motion: Option<&Trajectory>) -> Result<Vec<Array>, ModelError> {
    let states = controller::test_states(kept.setting().kinds.len(), motion);
    let torque = kept.predict(&states)?.total;
    let signals = [("q", &states.q), ("qd", &states.qd), ("qdd", &states.qdd), ("tau", &torque)];
    let array = |(name, signal): (&str, &crate::signals::Signals)| {
        let values = (0..states.len()).flat_map(|sample| signal.at(sample));
        Array::new(name, vec![states.len(), states.joint_count()], values)
    };
    Ok(signals.into_iter().map(array).collect())
}

/// The torque as ONNX, without that of effects beside the networks.
fn as_onnx(model: &LearnedModel, about: &str) -> Vec<u8> {
    let architecture = &model.architecture;
    let mut built = architecture.build();
    let mut torque = built.graph.constant(0.0, architecture.joints);
    for (term, node) in architecture.terms.iter().zip(&built.terms) {
        if !matches!(term, LearnedTerm::Columns { .. }) {
            torque = built.graph.add(torque, *node);
        }
    }
    let inputs = ["q", "qd", "qdd"].map(|name| (name, architecture.joints));
    onnx::model(&built.graph, &model.weights, &inputs, ("tau", torque), &[(ABOUT, about)])
}

fn safetensors(arrays: &[Array], about: &str) -> Result<Vec<u8>, SafeTensorError> {
    let mut views = Vec::new();
    for Array { name, shape, bytes } in arrays {
        views.push((name, TensorView::new(Dtype::F64, shape.clone(), bytes)?));
    }
    // One entry only: a map of several has no order, and equal models shall be equal files.
    let metadata = HashMap::from([(ABOUT.to_owned(), about.to_owned())]);
    ::safetensors::serialize(views, Some(metadata))
}

fn archive(arrays: &[Array], about: Option<&str>) -> Result<Vec<u8>, NetworkError> {
    // No time stamps, so that equal models are equal files.
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for Array { name, shape, bytes } in arrays {
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&npy::encode("<f8", shape, bytes.iter().copied()))?;
    }
    if let Some(about) = about {
        archive.start_file(ABOUT, options)?;
        archive.write_all(about.as_bytes())?;
    }
    Ok(archive.finish()?.into_inner())
}

#[cfg(test)]
mod tests;
