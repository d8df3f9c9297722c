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
    let mut body = Vec::new();
    let mut links = vec![message(0x02, &[&[0, 0][..], &NOWHERE, &NOWHERE].concat()), message(0x0a, &[0, 0])];
    for (name, shape, values) in sets {
        let data = SUPERBLOCK + body.len();
        body.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
        body.resize(body.len().next_multiple_of(8), 0);
        let head = SUPERBLOCK + body.len();
        body.extend(header(&dataset(&shape, data as u64, 4 * values.len() as u64)));
        let link = [&[1, 0, name.len() as u8][..], name.as_bytes(), &(head as u64).to_le_bytes()].concat();
        links.push(message(0x06, &link));
    }
    let root = SUPERBLOCK + body.len();
    body.extend(header(&links));
    let end = SUPERBLOCK + body.len();
    [superblock(root as u64, end as u64), body].concat()
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

/// Shape, type (IEEE single, the least byte first), and where the numbers are.
fn dataset(shape: &[usize], at: u64, size: u64) -> Vec<Vec<u8>> {
    let mut space = vec![1, shape.len() as u8, 0, 0, 0, 0, 0, 0];
    space.extend(shape.iter().flat_map(|size| (*size as u64).to_le_bytes()));
    let single = [0x11, 0x20, 31, 0, 4, 0, 0, 0, 0, 0, 32, 0, 23, 8, 0, 23, 127, 0, 0, 0];
    let layout = [&[3, 1][..], &at.to_le_bytes(), &size.to_le_bytes()].concat();
    vec![message(0x01, &space), message(0x03, &single), message(0x08, &layout)]
}
