//! Files that gzip has packed: unpacked once, then read as what they are.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use super::budget::{Budget, TooMuch};

/// The file can't be unpacked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
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
}

/// With these bytes a packed file begins.
pub(super) const SIGNATURE: &[u8] = b"\x1f\x8b";
/// So much is unpacked at a time \[bytes\].
const PART: u64 = 1 << 20;

/// What comes out of a packed file.
pub(super) struct Unpacked<R> {
    decoder: MultiGzDecoder<R>,
    budget: Budget,
    after: usize,
}

impl<R: Read> Unpacked<R> {
    /// Of a packed file, within what may be unpacked.
    pub fn of(packed: R, budget: Budget) -> Self {
        Unpacked { decoder: MultiGzDecoder::new(packed), budget, after: 0 }
    }

    /// Adds the next bytes, at most so many; none at the end.
    pub fn read(&mut self, most: u64, into: &mut Vec<u8>) -> Result<(), GzipError> {
        let before = into.len();
        let read = (&mut self.decoder).take(most).read_to_end(into);
        let (is_begun, count) = (self.after > 0, into.len() - before);
        self.after += count;
        read.map_err(|problem| GzipError::Damaged { after: self.after, problem: problem.to_string() })?;
        if !is_begun && into[before..].starts_with(SIGNATURE) {
            return Err(GzipError::Twice);
        }
        Ok(self.budget.unpack(count as u64)?)
    }
}

/// The beginning of what was packed, as far as it can be unpacked.
pub(super) fn head(packed: impl Read, most: u64) -> Result<Vec<u8>, GzipError> {
    let mut head = Vec::new();
    Unpacked::of(packed, Budget::of(most, most)).read(most, &mut head)?;
    Ok(head)
}

/// All of what was packed.
pub(super) fn unpack(packed: impl Read, budget: Budget) -> Result<Vec<u8>, GzipError> {
    let (mut from, mut unpacked) = (Unpacked::of(packed, budget), Vec::new());
    loop {
        let before = unpacked.len();
        from.read(PART, &mut unpacked)?;
        if unpacked.len() == before {
            return Ok(unpacked);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        crate::selftest::seeds::gzip(bytes).unwrap()
    }

    #[test]
    fn what_is_packed_is_unpacked_once_and_whole() {
        let of = |bytes: &[u8]| unpack(bytes, Budget::of(bytes.len() as u64, 1 << 30));
        let text: Vec<u8> = (0..40_000u32).flat_map(|n| format!("{}\n", n * n % 977).into_bytes()).collect();
        let whole = packed(&text);
        assert!(of(&whole).unwrap() == text);
        assert!(of(&[whole.clone(), packed(b"more")].concat()).unwrap().ends_with(b"more"), "parts follow each other");
        assert!(matches!(of(&packed(&whole)), Err(GzipError::Twice)));
        assert!(matches!(of(&whole[..whole.len() / 2]), Err(GzipError::Damaged { after, .. }) if after < text.len()));
        let small = unpack(whole.as_slice(), Budget::of(whole.len() as u64, 1000));
        assert!(matches!(small, Err(GzipError::TooMuch(_))));
    }
}
