//! The seal: the hidden truth of a simulated recording, unreadable until somebody opens it on purpose.
//!
//! In memory and in the file the truth is one scrambled block of bytes. Only `session/` and `cli/` (on the user's order)
//! and the scoring of `trial/` may call [`Seal::open`]; `tests/architecture.rs` keeps everybody else from it. The scrambling
//! keeps the truth from eyes that skim a file and from code that parses it by accident; it is not cryptography.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::correction::Correction;
use crate::arm::Arm;

/// Key of the stream that scrambles the truth.
const KEY: u64 = 0x7042_5343_4f50_4521;

/// The scrambled truth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seal {
    bytes: Vec<u8>,
}

/// What was simulated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// The arm that moved.
    pub arm: Arm,
    /// The effects that were hidden in the torque.
    pub effects: Vec<HiddenEffect>,
    /// Of a recording from a world of bodies: everything that was there besides the arm, and what it really did.
    #[serde(default)]
    pub causes: Vec<Cause>,
    /// Standard deviation of the torque noise, per joint \[N m\].
    pub torque_noise: Vec<f64>,
    /// Seed of all random draws.
    pub seed: u64,
    /// What sets the log right, where it was set up wrongly on purpose.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set_up: Vec<Correction>,
}

/// One effect that a simulation hid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HiddenEffect {
    /// Its id in the registry of effects.
    pub effect: String,
    /// The joint it acts on, counted from 0; `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// Its parameters, in the order of its file.
    pub parameters: Vec<f64>,
}

/// One thing that was in a world besides the bare arm, and what it did there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Id in the registry of effects, or a name that the registry does not have.
    pub effect: String,
    /// The joint it acts on, counted from 0; `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// Its parameters, in the order of the effect's file; empty where they have no counterpart there.
    pub parameters: Vec<f64>,
    /// RMS of the torque that it really caused, over the RMS of the logged torque of the joints that felt it.
    pub share: f64,
    /// Of something that the registry does not have: how much of that share is left when a rigid body, and what nearly every joint has, are
    /// fitted to its torque along the motion. `None` where nobody looked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside_everyday: Option<f64>,
}

/// The sealed block is damaged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the sealed truth is damaged ({0}); the measurements are not affected. Simulate the recording again to get a truth"
)]
pub struct SealError(String);

impl Seal {
    /// Seals a truth.
    pub fn close(truth: &Truth) -> Self {
        let bytes = serde_json::to_vec(truth).expect("numbers and texts always have a JSON form");
        Seal { bytes: scramble(bytes) }
    }

    /// Opens the seal. For the user's own order only: see the module's text.
    ///
    /// # Errors
    /// [`SealError`] if the block was changed.
    pub fn open(&self) -> Result<Truth, SealError> {
        serde_json::from_slice(&scramble(self.bytes.clone())).map_err(|error| SealError(error.to_string()))
    }

    /// The same truth of a log that is set up wrongly, and what sets it right.
    ///
    /// # Errors
    /// [`SealError`] if the block was changed.
    pub fn with_set_up(&self, set_up: Vec<Correction>) -> Result<Seal, SealError> {
        Ok(Seal::close(&Truth { set_up, ..self.open()? }))
    }

    /// The scrambled block as it stands in files.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// A seal as it was read from a file; nothing is checked before it is opened.
    pub fn from_bytes(bytes: Vec<u8>) -> Self {
        Seal { bytes }
    }
}

/// Adds the key stream; twice gives the input back.
fn scramble(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut stream = vec![0; bytes.len()];
    ChaCha8Rng::seed_from_u64(KEY).fill_bytes(&mut stream);
    for (byte, key) in bytes.iter_mut().zip(stream) {
        *byte ^= key;
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth() -> Truth {
        Truth {
            arm: Arm::uniform(2),
            effects: vec![HiddenEffect { effect: "coulomb-friction".into(), joint: Some(1), parameters: vec![0.7] }],
            causes: Vec::new(),
            torque_noise: vec![0.1, 0.2],
            seed: 7,
            set_up: Vec::new(),
        }
    }

    #[test]
    fn opens_to_what_was_closed_and_shows_nothing_before() {
        let seal = Seal::close(&truth());
        let readable = String::from_utf8_lossy(seal.as_bytes()).into_owned();
        assert!(!readable.contains("coulomb"));
        assert_eq!(Seal::from_bytes(seal.as_bytes().to_vec()).open().unwrap(), truth());
    }

    #[test]
    fn a_damaged_seal_is_an_error() {
        let mut bytes = Seal::close(&truth()).as_bytes().to_vec();
        bytes[0] ^= 1;
        assert!(Seal::from_bytes(bytes).open().is_err());
    }
}
