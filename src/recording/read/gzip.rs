//! Files that gzip has packed: unpacked once, then read as what they are.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use super::budget::{Budget, TooMuch};
use super::share::Share;
use crate::progress::{Monitor, Stopped};

/// The file can't be unpacked.
#[derive(Debug, thiserror::Error)]
pub enum GzipError {
    /// It is cut, or its checksum is wrong.
    #[error("it is packed with gzip and damaged after {after} unpacked bytes ({problem}); copy or pack it again")]
    Damaged {
        /// How far it could be unpacked.
        after: usize,
        /// What is wrong.
        problem: String,
    },
    /// It was packed twice.
    #[error("it is packed with gzip twice; unpack it once with `gunzip`")]
    Twice,
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// With these bytes a packed file begins.
pub(super) const SIGNATURE: &[u8] = b"\x1f\x8b";
/// So much is unpacked at a time \[bytes\].
const PART: u64 = 1 << 20;

/// What was packed.
pub(super) fn unpack(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Vec<u8>, GzipError> {
    let mut decoder = MultiGzDecoder::new(bytes);
    let mut unpacked = Vec::new();
    let mut share = Share::of(bytes.len() as u64, monitor);
    loop {
        share.is((bytes.len() - decoder.get_ref().len()) as u64)?;
        let before = unpacked.len();
        let read = (&mut decoder).take(PART).read_to_end(&mut unpacked);
        let read =
            read.map_err(|problem| GzipError::Damaged { after: unpacked.len(), problem: problem.to_string() })?;
        budget.unpack(read as u64)?;
        if unpacked.len() == before {
            break;
        }
    }
    if unpacked.starts_with(SIGNATURE) { Err(GzipError::Twice) } else { Ok(unpacked) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        crate::selftest::seeds::gzip(bytes).unwrap()
    }

    #[test]
    fn what_is_packed_is_unpacked_once_and_whole() {
        let of = |bytes: &[u8]| unpack(bytes, &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new());
        let text: Vec<u8> = (0..40_000u32).flat_map(|n| format!("{}\n", n * n % 977).into_bytes()).collect();
        let whole = packed(&text);
        assert!(of(&whole).unwrap() == text);
        assert!(of(&[whole.clone(), packed(b"more")].concat()).unwrap().ends_with(b"more"), "parts follow each other");
        assert!(matches!(of(&packed(&whole)), Err(GzipError::Twice)));
        assert!(matches!(of(&whole[..whole.len() / 2]), Err(GzipError::Damaged { after, .. }) if after < text.len()));
        let small = unpack(&whole, &mut Budget::of(whole.len() as u64, 1000), &Monitor::new());
        assert!(matches!(small, Err(GzipError::TooMuch(_))));
    }
}
