//! Bytes become a file, which the program opens through its own door. What panics, hangs or breaks a promise is a finding.

use std::path::PathBuf;
use std::sync::OnceLock;

use libfuzzer_sys::Corpus;
use tempfile::TempDir;
pub use torquescope::recording::read::Format;
use torquescope::recording::read::sniff;
pub use torquescope::selftest::opener::Kind;
use torquescope::selftest::opener::{Opened, Request, open};

/// A recording of this format; bytes of another one are none of this target's.
pub fn log(format: Format, bytes: &[u8]) -> Corpus {
    let ending = format.endings()[0];
    match sniff(bytes, ending) {
        Ok(found) if found == format => opened(Kind::Log, ending, bytes),
        _ => Corpus::Reject,
    }
}

/// Any other document.
pub fn document(kind: Kind, bytes: &[u8]) -> Corpus {
    opened(kind, if kind == Kind::Session { "torquescope" } else { "file" }, bytes)
}

fn opened(kind: Kind, ending: &str, bytes: &[u8]) -> Corpus {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| tempfile::tempdir().expect("a folder can be made"));
    let path: PathBuf = folder.path().join(format!("fuzzed.{ending}"));
    std::fs::write(&path, bytes).expect("a file can be written");
    if let Ok(Opened::Broke(promise)) = open(&Request { kind, path, clean: None }) {
        panic!("{promise}");
    }
    Corpus::Keep
}
