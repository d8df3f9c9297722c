//! Writes pickles of protocol 3, as Python does it with a dict of numpy arrays.

use super::{channels, rows};
use crate::recording::Trajectory;

/// A run as a dict of arrays.
pub fn arrays(run: &Trajectory) -> Vec<u8> {
    let mut bytes = b"\x80\x03}(".to_vec();
    array("t", &[run.len()], &run.time, &mut bytes);
    for (name, signal) in channels(run) {
        array(name, &[run.len(), run.joint_count()], &rows(signal), &mut bytes);
    }
    bytes.extend(b"u.");
    bytes
}

/// A key, and an array of f8 as numpy has itself put together again.
fn array(name: &str, shape: &[usize], values: &[f64], bytes: &mut Vec<u8>) {
    text(name, bytes);
    bytes.extend(b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01(");
    for size in shape {
        bytes.push(b'J');
        bytes.extend(u32::try_from(*size).unwrap_or_default().to_le_bytes());
    }
    bytes.extend(b"tcnumpy\ndtype\n");
    text("f8", bytes);
    bytes.extend(b"K\x00K\x01\x87R(K\x03");
    text("<", bytes);
    bytes.extend(b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B");
    bytes.extend(u32::try_from(8 * values.len()).unwrap_or_default().to_le_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes.extend(b"tb");
}

fn text(text: &str, bytes: &mut Vec<u8>) {
    bytes.push(b'X');
    bytes.extend(u32::try_from(text.len()).unwrap_or_default().to_le_bytes());
    bytes.extend(text.bytes());
}
