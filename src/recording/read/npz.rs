//! NPZ: a ZIP archive of numpy arrays, anybody's or in our own [`crate::recording::layout`].

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use ndarray::{ArrayD, Ix2, s};
use zip::ZipArchive;

use super::arrays::{ArraysError, Gathered};
use super::table::Table;
use crate::progress::{Monitor, Stopped};
use crate::recording::layout::{CHANNELS, MANIFEST, Manifest, TIME, TRAJECTORY, TRUTH, VERSION, Version};
use crate::recording::seal::Seal;
use crate::recording::{Channels, Recording, RecordingError, Trajectory};
use crate::signals::Signals;

/// The archive can't be read.
#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    /// It is no sound ZIP archive.
    #[error("the archive is damaged ({0}); copy or export it again")]
    Archive(#[from] zip::result::ZipError),
    /// One of its files can't be unpacked.
    #[error("`{entry}` in the archive is damaged ({problem}); copy or export the file again")]
    Entry {
        /// Name of the entry.
        entry: String,
        /// What went wrong.
        problem: String,
    },
    /// Its arrays make no table.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// A newer program wrote it.
    #[error(
        "it is in version {found} of our layout, but this program knows versions up to {VERSION}; use a newer program"
    )]
    FutureVersion {
        /// The version of the file.
        found: u32,
    },
    /// Our own layout, but something in it is wrong.
    #[error(
        "it is a recording of this program, but {0}; write it again, or delete its `{MANIFEST}` to read it as plain arrays"
    )]
    Layout(String),
    /// Our own layout, but the recording does not keep its promises.
    #[error("it is a recording of this program, but: {0}")]
    Recording(#[from] RecordingError),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// What an archive holds.
#[derive(Debug)]
pub(super) enum Content {
    /// Arrays of somebody else.
    Table(Table),
    /// A recording in our own layout.
    Recording(Box<Recording>),
}

/// Reads an archive; unpacked it may take `limit` bytes.
pub(super) fn read(bytes: &[u8], limit: u64, monitor: &Monitor) -> Result<Content, NpzError> {
    let Unpacked { gathered, manifest, truth } = unpack(bytes, limit, monitor)?;
    match manifest {
        Some(manifest) => Ok(Content::Recording(Box::new(recording(gathered.arrays, &manifest, truth)?))),
        None => Ok(Content::Table(gathered.table()?)),
    }
}

struct Unpacked {
    gathered: Gathered,
    manifest: Option<Vec<u8>>,
    truth: Option<Vec<u8>>,
}

fn unpack(bytes: &[u8], limit: u64, monitor: &Monitor) -> Result<Unpacked, NpzError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes))?;
    let mut unpacked = Unpacked { gathered: Gathered::within(limit), manifest: None, truth: None };
    for index in 0..archive.len() {
        monitor.check()?;
        let entry = archive.by_index(index)?;
        let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
        let array = name.strip_suffix(".npy").map(str::to_owned);
        if array.is_none() && name != MANIFEST && name != TRUTH {
            unpacked.gathered.passed_over.push(format!("`{name}` (no array)"));
            continue;
        }
        unpacked.gathered.check(entry.size())?;
        let damaged = |problem: String| NpzError::Entry { entry: name.clone(), problem };
        // What the archive claims is checked as it is unpacked, so that a false claim does not take memory either.
        let claimed = entry.size();
        let mut content = Vec::new();
        entry.take(claimed + 1).read_to_end(&mut content).map_err(|error| damaged(error.to_string()))?;
        if content.len() as u64 != claimed {
            return Err(damaged(format!("{} bytes instead of {claimed}", content.len())));
        }
        match array {
            Some(array) => unpacked.gathered.take(array, &content)?,
            None if name == TRUTH => unpacked.truth = Some(content),
            None => unpacked.manifest = Some(content),
        }
    }
    Ok(unpacked)
}

/// Our own layout.
fn recording(
    arrays: Vec<(String, ArrayD<f64>)>,
    manifest: &[u8],
    truth: Option<Vec<u8>>,
) -> Result<Recording, NpzError> {
    let unreadable = |error: serde_json::Error| NpzError::Layout(format!("its `{MANIFEST}` is damaged ({error})"));
    let version: Version = serde_json::from_slice(manifest).map_err(unreadable)?;
    if version.format > VERSION {
        return Err(NpzError::FutureVersion { found: version.format });
    }
    let manifest: Manifest = serde_json::from_slice(manifest).map_err(unreadable)?;
    let wrong = |problem: String| Err(NpzError::Layout(problem));

    let mut arrays: BTreeMap<String, ArrayD<f64>> = arrays.into_iter().collect();
    let mut take = |name: &str, columns: Option<usize>| -> Result<ArrayD<f64>, NpzError> {
        let lacking = || NpzError::Layout(format!("its array `{name}` is missing"));
        let array = arrays.remove(name).ok_or_else(lacking)?;
        match (columns, array.shape()) {
            (None, [_]) => Ok(array),
            (Some(columns), [_, own]) if columns == *own => Ok(array),
            (_, shape) => Err(NpzError::Layout(format!("its array `{name}` has the shape {shape:?}"))),
        }
    };
    let time: Vec<f64> = take(TIME, None)?.into_iter().collect();
    let numbers: Vec<f64> = take(TRAJECTORY, None)?.into_iter().collect();
    if numbers.len() != time.len() {
        return wrong(format!("`{TIME}` has {} samples and `{TRAJECTORY}` {}", time.len(), numbers.len()));
    }
    let joints = manifest.joints.len();
    let mut channels = Vec::new();
    for name in CHANNELS {
        let array = take(name, Some(joints))?;
        let array = array.into_dimensionality::<Ix2>().map_err(|problem| NpzError::Layout(problem.to_string()))?;
        if array.nrows() != time.len() {
            return wrong(format!("`{TIME}` has {} samples and `{name}` {}", time.len(), array.nrows()));
        }
        channels.push(array);
    }

    let mut trajectories = Vec::new();
    let mut start = 0;
    for (number, name) in manifest.trajectories.iter().enumerate() {
        let end = start + numbers[start..].iter().take_while(|own| **own == number as f64).count();
        let channel = |index: usize| Signals::from_array(channels[index].slice(s![start..end, ..]).reversed_axes());
        let (q, qd, qdd, tau) = (channel(0), channel(1), channel(2), channel(3));
        let channels = Channels { time: time[start..end].to_vec(), q, qd, qdd, tau };
        trajectories.push(Trajectory::new(name, channels).map_err(RecordingError::from)?);
        start = end;
    }
    if start != time.len() {
        return wrong(format!("`{TRAJECTORY}` does not count 0, 1, … in order at sample {start}"));
    }
    let Manifest { name, joints, provenance, posture, stated_arm, chain, .. } = manifest;
    let seal = truth.map(Seal::from_bytes);
    let recording = Recording { name, joints, trajectories, provenance, posture, stated_arm, chain, seal };
    recording.verify()?;
    Ok(recording)
}
