//! Bytes become a file, which the program opens through its own door. What panics, hangs, takes too much or breaks a promise is a
//! finding.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use cpu_time::ProcessTime;
use libfuzzer_sys::Corpus;
use tempfile::TempDir;
use torquescope::recording::Recording;
pub use torquescope::recording::read::Format;
use torquescope::recording::read::sniff;
use torquescope::recording::write::to_npz_bytes;
use torquescope::selftest::memory;
pub use torquescope::selftest::opener::Kind;
use torquescope::selftest::opener::{LONGEST_S, Opened, Request, open};
use torquescope::selftest::seeds;

/// Most memory that a small file may take \[bytes\]; what is larger may take four times its size.
const MOST_MEMORY: u64 = 64 << 20;

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

/// Few samples of an arm of one joint or several: what all seeds hold, and what models are asked about.
pub fn clean(number: u64) -> Recording {
    let whole = seeds::recording(number).expect("an arm can be simulated");
    let run = whole.trajectories[0].slice(0..80);
    whole.with_trajectories(vec![run])
}

/// The folder of the file that is opened, with a clean recording beside it.
pub fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let made = || {
        let folder = tempfile::tempdir().expect("a folder can be made");
        let bytes = to_npz_bytes(&clean(0)).expect("a clean recording can be written");
        std::fs::write(folder.path().join("clean.npz"), bytes).expect("a file can be written");
        folder
    };
    FOLDER.get_or_init(made).path()
}

/// Archives, and those in them, with the checksums that their stored parts have: else whatever is changed in them ends at the door.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut archives = bytes.to_vec();
    // The end of what is inside comes first.
    for end in (0..bytes.len()).filter(|&at| bytes[at..].starts_with(b"PK\x05\x06")) {
        // What leads nowhere stays as it is.
        let _ = set_right(&mut archives, end);
    }
    archives
}

/// The same for the archive whose list ends there; `None` where it breaks off.
fn set_right(archive: &mut [u8], end: usize) -> Option<()> {
    fn number(archive: &[u8], at: usize, size: usize) -> Option<usize> {
        let bytes = archive.get(at..at + size)?;
        Some(bytes.iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte)))
    }
    let mut entry = end.checked_sub(number(archive, end + 12, 4)?)?;
    let begin = entry.checked_sub(number(archive, end + 16, 4)?)?;
    while archive.get(entry..)?.starts_with(b"PK\x01\x02") {
        let of_entry = |at: usize, size: usize| number(archive, entry + at, size);
        let (method, size, head) = (of_entry(10, 2)?, of_entry(20, 4)?, begin + of_entry(42, 4)?);
        let next = entry + 46 + of_entry(28, 2)? + of_entry(30, 2)? + of_entry(32, 2)?;
        if method == 0 && archive.get(head..)?.starts_with(b"PK\x03\x04") {
            let start = head + 30 + number(archive, head + 26, 2)? + number(archive, head + 28, 2)?;
            let checksum = crc32fast::hash(archive.get(start..start + size)?).to_le_bytes();
            archive.get_mut(head + 14..head + 18)?.copy_from_slice(&checksum);
            archive.get_mut(entry + 16..entry + 20)?.copy_from_slice(&checksum);
        }
        entry = next;
    }
    Some(())
}

fn opened(kind: Kind, ending: &str, bytes: &[u8]) -> Corpus {
    let path: PathBuf = folder().join(format!("fuzzed.{ending}"));
    std::fs::write(&path, with_checksums(bytes)).expect("a file can be written");
    let clean = matches!(kind, Kind::Model | Kind::Checkpoint).then(|| folder().join("clean.npz"));
    let (before, computed) = (memory::start(), ProcessTime::now());
    let opened = open(&Request { kind, path, clean });
    let seconds = computed.elapsed().as_secs_f64();
    let memory = before.and_then(|before| Some(memory::most()?.saturating_sub(before))).unwrap_or(0);
    if let Ok(Opened::Broke(promise)) = opened {
        panic!("{promise}");
    }
    assert!(seconds <= LONGEST_S, "it computed for {seconds:.1} s");
    assert!(memory <= MOST_MEMORY.max(4 * bytes.len() as u64), "it took {} MiB", memory >> 20);
    Corpus::Keep
}
