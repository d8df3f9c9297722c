//! Clean recordings, and each of them as a file of every kind that is read.

pub mod arms;
pub mod bag;
pub mod hdf5;
pub mod json;
pub mod mat;
pub mod mcap;
mod message;
pub mod pickle;

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use ::mcap::Compression;
use flate2::write::GzEncoder;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::SelftestError;
use crate::arm::Arm;
use crate::progress::Monitor;
use crate::recording::write::{Form, to_bytes, to_csv_bytes, to_npz_bytes};
use crate::recording::{Recording, Trajectory, npy};
use crate::signals::Signals;
use crate::simulation::{Excitation, Scenario, simulate};

/// A log.
pub struct Seed {
    /// With the ending of its format; a folder's has none.
    pub name: String,
    /// What it holds, by names: one file that is the log, or several of a folder.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Seed {
    /// What all its files take \[bytes\].
    pub fn size(&self) -> u64 {
        self.files.iter().map(|(_, bytes)| bytes.len() as u64).sum()
    }
}

/// An arm that swings for a few seconds, with noise of 1 % on its torques; others for other seeds.
pub fn recording(seed: u64) -> Result<Recording, SelftestError> {
    simulate(&scenario(seed), &Monitor::new()).map_err(|error| SelftestError::making("a recording")(&error))
}

/// What [`recording`] simulates.
pub fn scenario(seed: u64) -> Scenario {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let motion = Excitation::MultiSine {
        trajectories: 1,
        duration: random.random_range(6.0..12.0),
        rate: [50.0, 100.0][random.random_range(0..2)],
        harmonics: 4,
        lowest_frequency: 0.1,
        highest_frequency: 0.8,
        max_position: 2.0,
        max_velocity: 3.0,
    };
    Scenario {
        name: format!("seed {seed}"),
        arm: Arm::uniform(random.random_range(1..=3)),
        motion,
        effects: Vec::new(),
        torque_noise: 0.01,
        seed,
        ..Scenario::embedded()
    }
}

/// A recording in every format, and in several dialects of text. All columns have names that are recognised.
pub fn files(recording: &Recording, number: usize) -> Result<Vec<Seed>, SelftestError> {
    let run = &recording.trajectories[0];
    let own = to_npz_bytes(recording).map_err(|error| SelftestError::making("an archive")(&error))?;
    let text = to_csv_bytes(run);
    let semicolons = dialect(&text, ";", |cell| cell.replace('.', ","));
    let short = dialect(&text, "\t", |cell| cell.parse::<f64>().map_or(cell.to_owned(), |value| format!("{value:.6}")));
    let files = [
        ("packed.csv.gz", gzip(&text)?),
        ("comma.csv", text),
        ("semicolon.csv", semicolons),
        ("tabs.txt", short),
        ("own.npz", own),
        ("stored.npz", archive(run, CompressionMethod::Stored)?),
        ("packed.npz", archive(run, CompressionMethod::Deflated)?),
        ("plain.mat", mat::plain(run)),
        ("struct.mat", mat::packed(run)?),
        ("states.db3", bag::joint_states(run)?),
        ("plain.mcap", mcap::joint_states(run, None)?),
        ("packed.mcap", mcap::joint_states(run, Some(Compression::Zstd))?),
        ("datasets.h5", hdf5::datasets(run)),
        ("columns.parquet", columns(recording, Form::Parquet)?),
        ("arrays.pickle", pickle::arrays(run)),
        ("arrays.json", json::arrays(run)),
        ("samples.jsonl", json::lines(run)),
    ];
    let of_one = files.into_iter().map(|(name, bytes)| {
        let name = format!("{number}-{name}");
        Seed { files: vec![(name.clone(), bytes)], name }
    });
    Ok(of_one.chain([Seed { name: format!("{number}-arrays"), files: arrays(run) }]).collect())
}

/// A recording as it is written.
pub fn columns(recording: &Recording, form: Form) -> Result<Vec<u8>, SelftestError> {
    to_bytes(recording, form).map_err(|error| SelftestError::making("a table")(&error))
}

/// The same text with other delimiters and cells.
fn dialect(text: &[u8], delimiter: &str, cell: impl Fn(&str) -> String) -> Vec<u8> {
    let mut other = String::new();
    for line in String::from_utf8_lossy(text).lines() {
        let cells: Vec<String> = line.split(',').map(&cell).collect();
        // Writing to a String can't fail.
        let _ = writeln!(other, "{}", cells.join(delimiter));
    }
    other.into_bytes()
}

/// The channels that a log has, by the names under which they are recognised.
pub fn channels(run: &Trajectory) -> [(&'static str, &Signals); 3] {
    [("q", &run.q), ("qd", &run.qd), ("tau", &run.tau)]
}

/// The values of a signal, sample after sample.
pub fn rows(signal: &Signals) -> Vec<f64> {
    (0..signal.sample_count()).flat_map(|sample| signal.at(sample)).collect()
}

/// A run as an archive of arrays.
pub fn archive(run: &Trajectory, method: CompressionMethod) -> Result<Vec<u8>, SelftestError> {
    packed(&arrays(run), method)
}

/// A run as arrays, each in a file of its own.
pub fn arrays(run: &Trajectory) -> Vec<(String, Vec<u8>)> {
    let bytes = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>().into_iter();
    let mut entries = vec![("t.npy".to_owned(), npy::encode("<f8", &[run.len()], bytes(&run.time)))];
    for (name, signal) in channels(run) {
        let shape = [run.len(), run.joint_count()];
        entries.push((format!("{name}.npy"), npy::encode("<f8", &shape, bytes(&rows(signal)))));
    }
    entries
}

/// A file that gzip has packed.
pub fn gzip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut packer = GzEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(bytes)?;
    packer.finish()
}

/// An archive of these entries.
pub fn packed(entries: &[(String, Vec<u8>)], method: CompressionMethod) -> Result<Vec<u8>, SelftestError> {
    let options = SimpleFileOptions::default().compression_method(method).last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        archive.start_file(name, options).map_err(|error| SelftestError::making("an archive")(&error))?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish().map_err(|error| SelftestError::making("an archive")(&error))?.into_inner())
}

pub use bag::database;
pub use mat::{file as mat_file, numbers as mat_numbers, packed_element as mat_packed, structure as mat_structure};
