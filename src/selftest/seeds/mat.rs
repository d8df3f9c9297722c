//! Writes MATLAB files of version 5, by the published format (MathWorks, MAT-File Format, 2023, chapter 1).

use std::io::Write;

use super::{channels, rows};
use crate::recording::Trajectory;

const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;
const DOUBLE: u32 = 9;
const SIGNED: u32 = 5;
const UNSIGNED: u32 = 6;
const TEXT: u32 = 1;

fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (content.len() as u32).to_le_bytes()].concat();
    bytes.extend(content);
    if kind != COMPRESSED {
        bytes.resize(bytes.len().next_multiple_of(8), 0);
    }
    bytes
}

fn start(class: u32, sizes: [u32; 2], name: &str) -> Vec<u8> {
    let words = |values: [u32; 2]| values.map(u32::to_le_bytes).concat();
    let flags = element(UNSIGNED, &words([class, 0]));
    [flags, element(SIGNED, &words(sizes)), element(TEXT, name.as_bytes())].concat()
}

/// A matrix of these sizes; its values need not be as many as they say.
pub fn numbers(name: &str, sizes: [u32; 2], values: &[f64]) -> Vec<u8> {
    let content: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    element(MATRIX, &[start(6, sizes, name), element(DOUBLE, &content)].concat())
}

/// A struct of these fields.
pub fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    const LONGEST: usize = 16;
    let names = fields.iter().flat_map(|(name, _)| {
        let mut name = name.as_bytes().to_vec();
        name.resize(LONGEST, 0);
        name
    });
    let mut content = start(2, [1, 1], name);
    // A small element has its size beside its kind.
    content.extend([&[5, 0, 4, 0], &(LONGEST as u32).to_le_bytes()[..]].concat());
    content.extend(element(TEXT, &names.collect::<Vec<u8>>()));
    fields.iter().for_each(|(_, field)| content.extend(field));
    element(MATRIX, &content)
}

/// A compressed variable.
pub fn packed_element(variable: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(variable)?;
    Ok(element(COMPRESSED, &packer.finish()?))
}

/// A file of these variables.
pub fn file(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, made by Torquescope".to_vec();
    bytes.resize(116, b' ');
    bytes.resize(124, 0);
    bytes.extend([0, 1, b'I', b'M']);
    bytes.extend(variables.concat());
    bytes
}

/// Matrices are written column by column, so that one of joints × samples has the samples in turn.
fn variables(run: &Trajectory) -> Vec<(&'static str, [u32; 2], Vec<f64>)> {
    let (samples, joints) = (run.len() as u32, run.joint_count() as u32);
    let clock = ("t", [samples, 1], run.time.clone());
    let signals = channels(run).map(|(name, signal)| (name, [joints, samples], rows(signal)));
    [vec![clock], signals.to_vec()].concat()
}

/// A run as matrices, not compressed.
pub fn plain(run: &Trajectory) -> Vec<u8> {
    let matrices: Vec<Vec<u8>> =
        variables(run).iter().map(|(name, sizes, values)| numbers(name, *sizes, values)).collect();
    file(&matrices)
}

/// A run as a compressed struct.
pub fn packed(run: &Trajectory) -> std::io::Result<Vec<u8>> {
    let variables = variables(run);
    let fields: Vec<(&str, Vec<u8>)> =
        variables.iter().map(|(name, sizes, values)| (*name, numbers("", *sizes, values))).collect();
    Ok(file(&[packed_element(&structure("log", &fields))?]))
}
