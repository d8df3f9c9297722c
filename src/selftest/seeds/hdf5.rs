//! Writes HDF5 files: datasets of single precision in the root group, each in one piece.
//!
//! Source: The HDF Group, HDF5 file format specification 3.0 (superblock and object headers of version 0 and 1).

use super::{channels, rows};
use crate::recording::Trajectory;

/// An address that leads nowhere.
const NOWHERE: [u8; 8] = [0xff; 8];
/// What the superblock takes, with the entry of the root group \[bytes\].
const SUPERBLOCK: usize = 96;

/// A run as datasets.
pub fn datasets(run: &Trajectory) -> Vec<u8> {
    let mut sets = vec![("t", vec![run.len()], run.time.clone())];
    for (name, signal) in channels(run) {
        sets.push((name, vec![run.len(), run.joint_count()], rows(signal)));
    }
    let mut file = File::default();
    let mut links = Vec::new();
    for (name, shape, values) in sets {
        let values: Vec<u8> = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        let data = file.data(&values);
        let shape: Vec<u64> = shape.into_iter().map(|size| size as u64).collect();
        links.push((name, file.dataset(&shape, &SINGLE, data, values.len() as u64)));
    }
    let root = file.group(&links);
    file.finish(root)
}

/// Numbers of four bytes, the least one first.
const SINGLE: [u8; 20] = [0x11, 0x20, 31, 0, 4, 0, 0, 0, 0, 0, 32, 0, 23, 8, 0, 23, 127, 0, 0, 0];

/// A file on its way: objects one behind the other, each known by its address. Nobody asks whether they are true.
#[derive(Default)]
pub struct File {
    body: Vec<u8>,
}

impl File {
    /// Numbers.
    pub fn data(&mut self, bytes: &[u8]) -> u64 {
        self.put(bytes.to_vec())
    }

    /// A dataset of this shape and type (the content of a datatype message), whose numbers are there.
    pub fn dataset(&mut self, shape: &[u64], kind: &[u8], data: u64, size: u64) -> u64 {
        let mut space = vec![1, shape.len() as u8, 0, 0, 0, 0, 0, 0];
        space.extend(shape.iter().flat_map(|size| size.to_le_bytes()));
        let layout = [&[3, 1][..], &data.to_le_bytes(), &size.to_le_bytes()].concat();
        self.put(header(&[message(0x01, &space), message(0x03, kind), message(0x08, &layout)]))
    }

    /// A group of objects by their names.
    pub fn group(&mut self, links: &[(impl AsRef<str>, u64)]) -> u64 {
        let mut messages = vec![message(0x02, &[&[0, 0][..], &NOWHERE, &NOWHERE].concat()), message(0x0a, &[0, 0])];
        messages.extend(links.iter().map(|(name, object)| {
            let name = name.as_ref().as_bytes();
            message(0x06, &[&[1, 0, name.len() as u8][..], name, &object.to_le_bytes()].concat())
        }));
        self.put(header(&messages))
    }

    /// Where the next object will be.
    pub fn end(&self) -> u64 {
        (SUPERBLOCK + self.body.len()) as u64
    }

    /// All of it, with this group as the root.
    pub fn finish(self, root: u64) -> Vec<u8> {
        [superblock(root, self.end()), self.body].concat()
    }

    fn put(&mut self, object: Vec<u8>) -> u64 {
        let at = self.end();
        self.body.extend(object);
        self.body.resize(self.body.len().next_multiple_of(8), 0);
        at
    }
}

fn superblock(root: u64, end: u64) -> Vec<u8> {
    let mut bytes = b"\x89HDF\r\n\x1a\n".to_vec();
    // Versions, then how wide addresses and lengths are, and two numbers of trees that are not there.
    bytes.extend([0, 0, 0, 0, 0, 8, 8, 0, 4, 0, 16, 0, 0, 0, 0, 0]);
    for address in [[0; 8], NOWHERE, end.to_le_bytes(), NOWHERE, [0; 8], root.to_le_bytes()] {
        bytes.extend(address);
    }
    bytes.resize(SUPERBLOCK, 0);
    bytes
}

/// Messages with the head of an object before them.
fn header(messages: &[Vec<u8>]) -> Vec<u8> {
    let size: usize = messages.iter().map(Vec::len).sum();
    let mut bytes = vec![1, 0];
    bytes.extend((messages.len() as u16).to_le_bytes());
    bytes.extend(1u32.to_le_bytes());
    bytes.extend((size as u32).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(messages.concat());
    bytes
}

fn message(kind: u16, content: &[u8]) -> Vec<u8> {
    let size = content.len().next_multiple_of(8);
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend((size as u16).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(content);
    bytes.resize(8 + size, 0);
    bytes
}
