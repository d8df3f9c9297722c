use std::collections::BTreeMap;

use ::safetensors::SafeTensors;
use nalgebra::DMatrix;

use super::*;
use crate::effect::registry;
use crate::export::tests::{runs, succeeds};
use crate::model::Model;
use crate::model::learned::{Features, LearnedPreset};
use crate::network::Activation;
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;
use crate::signals::Signals;
use crate::simulation::{Scenario, simulate};
use crate::training::fit::{self, Plan};

const WIDTH: f64 = 0.02;

fn recording() -> Recording {
    let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
    recording.trajectories.truncate(3);
    recording
}

/// A preset after one epoch, with these effects on joint 2: its weights are no longer those that were drawn, and biases not zero.
fn trained(recording: &Recording, preset: LearnedPreset, shape: impl Fn(&mut Plan), effects: &[&str]) -> Fitted {
    let mut plan = Plan::default();
    (plan.options.epochs, plan.layers.hidden) = (1, vec![6, 5]);
    shape(&mut plan);
    let architecture = preset.architecture(recording.joint_count(), &plan.layers);
    let start = plan.shaped(&Model { terms: architecture.terms.into_iter().map(Term::Learned).collect() });
    let add = |model: Model, id: &&str| model.with_effect(registry::find(id).unwrap(), &[1]).unwrap();
    let model = effects.iter().fold(start, add);
    let split = Split::automatic(recording);
    fit::fit(&model, recording, &split, &plan, None, &Monitor::new(), &mut |_| {}).unwrap().fitted
}

/// Every kind of term, of features, of activation, and both mass matrices.
fn all_kinds(recording: &Recording) -> Vec<(&'static str, Fitted)> {
    use LearnedPreset::*;
    let see = |features: Features, activation: Activation| {
        move |plan: &mut Plan| (plan.features, plan.layers.activation) = (Some(features), activation)
    };
    let loose = |plan: &mut Plan| (plan.cholesky, plan.layers.activation) = (false, Activation::Tanh);
    let of = |preset, shape: &dyn Fn(&mut Plan)| trained(recording, preset, shape, &[]);
    vec![
        ("structured", of(StructuredDelan, &|_| {})),
        ("structured-loose", of(StructuredDelan, &loose)),
        ("black-box", of(BlackBoxDelan, &see(Features::LinkAngles, Activation::Silu))),
        ("black-box-of-joints", of(BlackBoxDelan, &see(Features::CosSin, Activation::Sigmoid))),
        ("delan-ffnn", of(DelanFfnn, &see(Features::Raw, Activation::Tanh))),
        ("ff-nn", of(FfNn, &|plan| plan.layers.hidden = Vec::new())),
        ("delan-friction", trained(recording, DelanFriction, |_| {}, &["stribeck-friction", "dahl-hysteresis"])),
    ]
}

fn file<'a>(package: &'a Package, name: &str) -> &'a [u8] {
    let found = package.files.iter().find(|(other, _)| *other == name);
    found.map(|(_, bytes)| bytes.as_slice()).unwrap()
}

/// The model of the safetensors, by what stands in its metadata.
fn read_back(bytes: &[u8]) -> (LearnedModel, Value) {
    let (_, header) = SafeTensors::read_metadata(bytes).unwrap();
    let about: Value = serde_json::from_str(&header.metadata().as_ref().unwrap()[ABOUT]).unwrap();
    let mut weights = BTreeMap::new();
    for (name, tensor) in SafeTensors::deserialize(bytes).unwrap().tensors() {
        let value = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
        weights.insert(name, tensor.data().chunks_exact(8).map(value).collect());
    }
    (LearnedModel { architecture: serde_json::from_value(about["architecture"].clone()).unwrap(), weights }, about)
}

#[test]
fn weights_that_are_read_back_give_our_torque() {
    let recording = recording();
    for (name, fitted) in all_kinds(&recording).into_iter().take(6) {
        let package = write(&fitted, WIDTH, recording.trajectories.first()).unwrap();
        let (model, about) = read_back(file(&package, "weights.safetensors"));
        assert_eq!(about["joint_units"], json!(["rad", "rad", "rad"]));
        let motion = &recording.trajectories[0];
        let torque = model.components(motion, &Vec::new()).unwrap().torque;
        assert_eq!(torque, fitted.predict(motion).unwrap().total, "{name}");

        let mut archive = zip::ZipArchive::new(Cursor::new(file(&package, "weights.npz"))).unwrap();
        for (name, values) in &model.weights {
            let mut bytes = Vec::new();
            std::io::copy(&mut archive.by_name(&format!("{name}.npy")).unwrap(), &mut bytes).unwrap();
            let array = npy::decode(&bytes, 1000).unwrap();
            assert!(array.iter().eq(values), "{name}");
            assert_eq!(array.ndim(), if name.ends_with("/w") { 2 } else { 1 }, "{name}");
        }
        assert_eq!(write(&fitted, WIDTH, recording.trajectories.first()).unwrap(), package, "equal bytes");
    }
}

#[test]
fn effects_beside_the_network_are_written_or_told() {
    let recording = recording();
    let (_, fitted) = all_kinds(&recording).pop().unwrap();
    let package = write(&fitted, WIDTH, None).unwrap();
    let effects = std::str::from_utf8(file(&package, "effects.py")).unwrap();
    assert!(effects.contains("def effects(q, qd, qdd)") && !effects.contains("K11"), "{effects}");
    assert_eq!(package.left_out.len(), 1);
    assert_eq!(fitted.model.terms[package.left_out[0].term].label(), package.left_out[0].name);

    let solved = crate::model::Preset::RigidBody.model(&recording).unwrap();
    let solved = crate::model::fit(&solved, &recording, &Split::automatic(&recording), &Monitor::new()).unwrap();
    assert!(write(&solved, WIDTH, None).unwrap_err().to_string().contains("export python"));
}

#[test]
fn the_onnx_model_gives_our_torque() {
    let recording = recording();
    let motion = &recording.trajectories[0];
    for (name, fitted) in all_kinds(&recording) {
        let package = write(&fitted, WIDTH, None).unwrap();
        let prediction = fitted.predict(motion).unwrap();
        let learned =
            fitted.model.terms.iter().zip(&prediction.terms).filter(|(term, _)| matches!(term, Term::Learned(_)));
        let mut expected = DMatrix::zeros(motion.len(), motion.joint_count());
        learned.for_each(|(_, torque)| expected += matrix(torque));
        let states = [("q", &motion.q), ("qd", &motion.qd), ("qdd", &motion.qdd)];
        let found = played(file(&package, "model.onnx"), states.map(|(name, signal)| (name, matrix(signal))));
        let error = (&found - &expected).amax();
        assert!(error < 1e-9 * expected.amax().max(1.0), "{name}: {error}");
    }
}

/// Samples × joints.
fn matrix(signals: &Signals) -> DMatrix<f64> {
    DMatrix::from_fn(signals.sample_count(), signals.joint_count(), |sample, joint| signals[joint][sample])
}

/// The fields of a message of protocol buffers: a number, or the bytes of what is in it.
fn fields(mut bytes: &[u8]) -> Vec<(u64, Result<u64, &[u8]>)> {
    fn varint(bytes: &mut &[u8]) -> u64 {
        let end = bytes.iter().position(|byte| byte & 0x80 == 0).unwrap();
        let (own, rest) = bytes.split_at(end + 1);
        *bytes = rest;
        own.iter().rev().fold(0, |value, byte| value << 7 | u64::from(byte & 0x7f))
    }
    let mut all = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let value = varint(&mut bytes);
        match key & 7 {
            0 => all.push((key >> 3, Ok(value))),
            2 => {
                let (own, rest) = bytes.split_at(value as usize);
                bytes = rest;
                all.push((key >> 3, Err(own)));
            }
            other => panic!("wire type {other}"),
        }
    }
    all
}

/// The messages of a field.
fn messages(bytes: &[u8], field: u64) -> Vec<&[u8]> {
    fields(bytes).into_iter().filter(|(own, _)| *own == field).filter_map(|(_, value)| value.err()).collect()
}

fn texts(bytes: &[u8], field: u64) -> Vec<String> {
    messages(bytes, field).into_iter().map(|text| String::from_utf8(text.to_vec()).unwrap()).collect()
}

/// What an ONNX model of matrices gives, node after node; places are matrices, too.
fn played(model: &[u8], inputs: [(&str, DMatrix<f64>); 3]) -> DMatrix<f64> {
    let graph = messages(model, 7)[0];
    let mut known: BTreeMap<String, DMatrix<f64>> =
        inputs.into_iter().map(|(name, values)| (name.to_owned(), values)).collect();
    assert!(messages(graph, 11).iter().all(|input| known.contains_key(&texts(input, 1)[0])));
    for tensor in messages(graph, 5) {
        let sizes: Vec<usize> =
            fields(tensor).iter().filter(|(field, _)| *field == 1).map(|(_, size)| size.unwrap() as usize).collect();
        let is_whole = fields(tensor).contains(&(2, Ok(7)));
        let value = |bytes: &[u8]| {
            let bytes: [u8; 8] = bytes.try_into().unwrap();
            if is_whole { i64::from_le_bytes(bytes) as f64 } else { f64::from_le_bytes(bytes) }
        };
        let values: Vec<f64> = messages(tensor, 9)[0].chunks_exact(8).map(value).collect();
        let columns = sizes.last().copied().unwrap_or(1);
        assert_eq!(values.len(), sizes.iter().product::<usize>());
        known.insert(texts(tensor, 8)[0].clone(), DMatrix::from_row_slice(values.len() / columns, columns, &values));
    }
    for node in messages(graph, 1) {
        let from: Vec<&DMatrix<f64>> = texts(node, 1).iter().map(|name| &known[name]).collect();
        let attribute = messages(node, 5).first().map(|one| fields(one)[1].1.unwrap());
        let place = |input: usize, index: usize| from[input][(0, index)] as usize;
        let result = match (texts(node, 4)[0].as_str(), from.as_slice()) {
            ("Concat", parts) => {
                let columns: Vec<_> = parts.iter().flat_map(|part| part.column_iter()).collect();
                DMatrix::from_columns(&columns)
            }
            ("Identity", [x]) => (*x).clone(),
            ("Gemm", [x, w, bias @ ..]) => {
                let product = if attribute == Some(1) { *x * w.transpose() } else { *x * *w };
                bias.iter().fold(product, |sum, bias| both(&sum, bias, |a, b| a + b))
            }
            ("MatMul", [a, b]) => *a * *b,
            ("Add", [a, b]) => both(a, b, |a, b| a + b),
            ("Mul", [a, b]) => both(a, b, |a, b| a * b),
            ("ReduceSum", [x, _]) => DMatrix::from_fn(x.nrows(), 1, |row, _| x.row(row).sum()),
            ("Slice", [x, ..]) => x.columns_range(place(1, 0)..place(2, 0)).into_owned(),
            ("Pad", [x, pads]) => {
                let mut wide = DMatrix::zeros(x.nrows(), pads[(0, 1)] as usize + x.ncols() + pads[(0, 3)] as usize);
                wide.columns_mut(place(1, 1), x.ncols()).copy_from(x);
                wide
            }
            (function, [x]) => x.map(|x| match function {
                "Tanh" => x.tanh(),
                "Sigmoid" => 1.0 / (1.0 + (-x).exp()),
                "Abs" => x.abs(),
                "Neg" => -x,
                "Log" => x.ln(),
                "Relu" => x.max(0.0),
                "Exp" => x.exp(),
                "Sin" => x.sin(),
                "Cos" => x.cos(),
                "Sign" => crate::effect::sign(x),
                other => panic!("{other} is not expected"),
            }),
            (other, _) => panic!("{other} is not expected"),
        };
        known.insert(texts(node, 2)[0].clone(), result);
    }
    let output = texts(messages(graph, 12)[0], 1)[0].clone();
    known.remove(&output).unwrap()
}

/// Element by element; what has one row or column is repeated.
fn both(a: &DMatrix<f64>, b: &DMatrix<f64>, f: impl Fn(f64, f64) -> f64) -> DMatrix<f64> {
    let at = |m: &DMatrix<f64>, row: usize, column: usize| m[(row % m.nrows(), column % m.ncols())];
    let [rows, columns] = [a.nrows().max(b.nrows()), a.ncols().max(b.ncols())];
    DMatrix::from_fn(rows, columns, |row, column| f(at(a, row, column), at(b, row, column)))
}

#[test]
fn the_onnx_model_runs_in_onnxruntime() {
    if !runs("python3", &["-c", "import numpy, onnxruntime"]) {
        return;
    }
    const SCRIPT: &str = "import numpy as np, onnxruntime as ort, sys\n\
                          v = np.load('vectors.npz')\n\
                          tau, = ort.InferenceSession('model.onnx').run(['tau'], {name: v[name] for name in ('q', 'qd', 'qdd')})\n\
                          sys.exit(0 if np.max(np.abs(tau - v['tau'])) < 1e-9 * max(1, np.max(np.abs(v['tau']))) else 1)\n";
    let recording = recording();
    for (_, fitted) in all_kinds(&recording).into_iter().take(6) {
        let folder = folder_with(&write(&fitted, WIDTH, None).unwrap());
        succeeds(folder.path(), "python3", &["-c", SCRIPT]);
    }
}

fn folder_with(package: &Package) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &package.files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

#[test]
fn the_evaluator_for_numpy_passes_its_vectors() {
    if !runs("python3", &["-c", "import numpy"]) {
        return;
    }
    let recording = recording();
    for (name, fitted) in all_kinds(&recording) {
        let motion = recording.trajectories.first().filter(|_| name != "structured");
        let folder = folder_with(&write(&fitted, WIDTH, motion).unwrap());
        succeeds(folder.path(), "python3", &["evaluate.py"]);
        if name == "ff-nn" {
            let script = folder.path().join("evaluate.py");
            let text = std::fs::read_to_string(&script).unwrap();
            std::fs::write(&script, text.replace("x @ w + b", "x @ w")).unwrap();
            let status = std::process::Command::new("python3").arg(&script).status().unwrap();
            assert!(!status.success(), "the test can fail: without its biases, it does");
        }
    }
}
