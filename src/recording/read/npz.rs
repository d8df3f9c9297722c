//! NPZ: a ZIP archive of numpy arrays, anybody's or in our own [`crate::recording::layout`].

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};
use std::ops::Range;

use ndarray::{ArrayD, Ix2, s};
use zip::ZipArchive;

use super::arrays::{ArraysError, Gathered, Source};
use super::budget::Budget;
use super::table::{MOST_COLUMNS, Table};
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
    /// More entries than any log has.
    #[error(
        "the archive lists {count} entries, more than the {MOST_ENTRIES} that a log may have; write one array a channel"
    )]
    TooMany {
        /// How many there are.
        count: usize,
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
    Table(Box<Table>),
    /// A recording in our own layout.
    Recording(Box<Recording>),
}

/// Reads an archive.
pub(super) fn read(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Content, NpzError> {
    let count = bytes.windows(LISTED.len()).filter(|part| *part == LISTED).count();
    if count > MOST_ENTRIES {
        return Err(NpzError::TooMany { count });
    }
    let mut archive = Archive(ZipArchive::new(Cursor::new(bytes))?);
    let (mut gathered, mut names) = (Gathered::default(), Vec::new());
    let (mut manifest, mut truth) = (None, None);
    for index in 0..archive.0.len() {
        monitor.check()?;
        let name = String::from_utf8_lossy(archive.0.by_index(index)?.name_raw()).into_owned();
        budget.text(&name).map_err(ArraysError::from)?;
        match name.strip_suffix(".npy") {
            Some(array) => names.push((index, array.to_owned())),
            None if name == MANIFEST => manifest = Some(archive.part(index, &name, budget)?),
            None if name == TRUTH => truth = Some(archive.part(index, &name, budget)?),
            None => gathered.passed_over.push(format!("`{name}` (no array)")),
        }
    }
    gathered.take(&mut archive, names, manifest.is_some(), budget, monitor)?;
    match manifest {
        Some(manifest) => Ok(Content::Recording(Box::new(recording(gathered.arrays, &manifest, truth)?))),
        None => Ok(Content::Table(Box::new(gathered.table(budget)?))),
    }
}

/// With these bytes begins what the list of an archive says of an entry.
const LISTED: &[u8] = b"PK\x01\x02";
/// More entries are not believed: each takes memory before its name is known, and many may share the same bytes.
const MOST_ENTRIES: usize = MOST_COLUMNS;

struct Archive<'a>(ZipArchive<Cursor<&'a [u8]>>);

impl Source for Archive<'_> {
    fn open(&mut self, index: usize) -> io::Result<(Box<dyn Read + '_>, u64)> {
        let entry = self.0.by_index(index)?;
        let size = entry.size();
        Ok((Box::new(entry), size))
    }
}

impl Archive<'_> {
    /// All bytes of an entry that is no array.
    fn part(&mut self, index: usize, name: &str, budget: &mut Budget) -> Result<Vec<u8>, NpzError> {
        let damaged = |problem: String| NpzError::Entry { entry: name.to_owned(), problem };
        let (entry, claimed) = self.open(index).map_err(|error| damaged(error.to_string()))?;
        budget.hold(claimed).map_err(ArraysError::from)?;
        // What the archive claims is checked as it is unpacked, so that a false claim does not take memory either.
        let mut content = Vec::new();
        entry.take(claimed + 1).read_to_end(&mut content).map_err(|error| damaged(error.to_string()))?;
        match content.len() as u64 == claimed {
            true => Ok(content),
            false => Err(damaged(format!("{} bytes instead of {claimed}", content.len()))),
        }
    }
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
    let runs = runs(numbers, manifest.trajectories.len())?;
    // Channel after channel, so that no more than one is there twice.
    let mut channels: Vec<Vec<Signals>> = vec![Vec::new(); runs.len()];
    for name in CHANNELS {
        let array = take(name, Some(manifest.joints.len()))?;
        let array = array.into_dimensionality::<Ix2>().map_err(|problem| NpzError::Layout(problem.to_string()))?;
        if array.nrows() != time.len() {
            return wrong(format!("`{TIME}` has {} samples and `{name}` {}", time.len(), array.nrows()));
        }
        for (run, channels) in runs.iter().zip(&mut channels) {
            channels.push(Signals::from_array(array.slice(s![run.clone(), ..]).reversed_axes()));
        }
    }
    let mut trajectories = Vec::new();
    for ((name, run), channels) in manifest.trajectories.iter().zip(runs).zip(channels) {
        let Ok([q, qd, qdd, tau]) = <[Signals; CHANNELS.len()]>::try_from(channels) else {
            return wrong(format!("trajectory `{name}` lacks a channel"));
        };
        let channels = Channels { time: time[run].to_vec(), q, qd, qdd, tau };
        trajectories.push(Trajectory::new(name, channels).map_err(RecordingError::from)?);
    }
    let Manifest { name, joints, provenance, posture, stated_arm, chain, torque, encoders, .. } = manifest;
    let seal = truth.map(Seal::from_bytes);
    let recording =
        Recording { name, joints, trajectories, provenance, posture, stated_arm, chain, torque, encoders, seal };
    recording.verify()?;
    Ok(recording)
}

/// The samples of each run, from the number of the run of each sample.
fn runs(numbers: Vec<f64>, count: usize) -> Result<Vec<Range<usize>>, NpzError> {
    let mut start = 0;
    let run = |number: usize| {
        let samples = numbers[start..].iter().take_while(|own| **own == number as f64).count();
        start += samples;
        start - samples..start
    };
    let runs = (0..count).map(run).collect();
    match start == numbers.len() {
        true => Ok(runs),
        false => Err(NpzError::Layout(format!("`{TRAJECTORY}` does not count 0, 1, … in order at sample {start}"))),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::recording::npy;

    fn archive(parts: &[(&str, &str, &[usize])]) -> Vec<u8> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, element, shape) in parts {
            archive.start_file(*name, SimpleFileOptions::default()).unwrap();
            let size = shape.iter().product::<usize>() * 8;
            archive.write_all(&npy::encode(element, shape, std::iter::repeat_n(0, size))).unwrap();
        }
        archive.finish().unwrap().into_inner()
    }

    fn parse(bytes: &[u8], limit: u64) -> Result<Content, NpzError> {
        read(bytes, &mut Budget::of(bytes.len() as u64, limit), &Monitor::new())
    }

    const LOG: [(&str, &str, &[usize]); 2] = [("q.npy", "<f8", &[1000, 2]), ("tau.npy", "<f8", &[1000, 2])];

    #[test]
    fn what_is_passed_over_is_on_the_account_too() {
        let objects: [(&str, &str, &[usize]); 3] =
            [("a.npy", "|O", &[50_000]), ("b.npy", "|O", &[50_000]), ("c.npy", "<f8", &[50, 10, 10, 10])];
        let bytes = archive(&[&LOG[..], &objects].concat());
        assert!(bytes.len() < 20_000);
        let error = parse(&bytes, 1 << 20).unwrap_err().to_string();
        assert!(error.contains("more than 1 MB"), "{error}");
        let Content::Table(table) = parse(&bytes, 1 << 21).unwrap() else { panic!("a recording") };
        assert_eq!((table.columns.len(), table.passed_over.len()), (4, 3));
    }

    #[test]
    fn what_no_log_packs_so_tightly_is_refused() {
        let bytes = archive(&[("q.npy", "<f8", &[9 << 20, 1])]);
        assert!(bytes.len() < 1 << 20);
        let error = parse(&bytes, 1 << 30).unwrap_err().to_string();
        assert!(error.contains("30 MB, over 32 times its size"), "{error}");
    }

    #[test]
    fn damage_of_what_is_passed_over_is_told() {
        let mut bytes = archive(&[&LOG[..], &[("c.npy", "<f8", &[50, 10, 10, 10])]].concat());
        let at = bytes.windows(5).rposition(|part| part == b"c.npy").unwrap() - 30;
        bytes[at] ^= 1; // in its checksum, which the list keeps 30 bytes before the name
        assert!(parse(&bytes, 1 << 30).is_err());
    }

    #[test]
    fn a_list_without_end_is_refused() {
        let bytes = [b"PK\x03\x04".to_vec(), LISTED.repeat(MOST_ENTRIES + 1)].concat();
        assert!(matches!(parse(&bytes, 1 << 30), Err(NpzError::TooMany { .. })));
    }

    #[test]
    fn runs_are_counted_from_zero_without_a_gap() {
        assert_eq!(runs(vec![0.0, 0.0, 1.0, 2.0, 2.0], 3).unwrap(), [0..2, 2..3, 3..5]);
        for (numbers, count) in
            [(vec![0.0, 1.0, 0.0], 2), (vec![1.0, 1.0], 1), (vec![0.0, 1.0], 1), (vec![0.0, f64::NAN], 2)]
        {
            assert!(matches!(runs(numbers, count), Err(NpzError::Layout(_))));
        }
    }

    /// A recording of our own whose parts do not fit together is refused by name, and one of a later layout as such.
    #[test]
    fn a_layout_that_does_not_fit_is_refused_where_it_does_not() {
        let whole = crate::selftest::seeds::recording(0).unwrap();
        let bytes = crate::recording::write::to_npz_bytes(&whole).unwrap();
        let mut archive = ZipArchive::new(Cursor::new(&bytes[..])).unwrap();
        let mut manifest = String::new();
        archive.by_name(MANIFEST).unwrap().read_to_string(&mut manifest).unwrap();
        let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
        let samples = 4;
        let array = |rows: usize, columns: Option<usize>| {
            let shape: Vec<usize> = std::iter::once(rows).chain(columns).collect();
            ArrayD::from_shape_fn(shape, |place| if columns.is_none() { place[0] as f64 } else { 0.5 })
        };
        let arrays = |rows: [usize; 3]| {
            let joints = whole.joint_count();
            let run = ArrayD::zeros(vec![rows[1]]);
            let channels = CHANNELS.map(|name| (name.to_owned(), array(rows[2], Some(joints))));
            [(TIME.to_owned(), array(rows[0], None)), (TRAJECTORY.to_owned(), run)]
                .into_iter()
                .chain(channels)
                .collect()
        };
        let read = |rows, manifest: &serde_json::Value| recording(arrays(rows), manifest.to_string().as_bytes(), None);
        assert_eq!(read([samples; 3], &manifest).unwrap().sample_count(), samples);
        let told = |rows| read(rows, &manifest).unwrap_err().to_string();
        assert!(told([samples, samples + 1, samples]).contains(&format!("`{TRAJECTORY}` {}", samples + 1)));
        assert!(told([samples, samples, samples - 1]).contains(&format!("`{}` {}", CHANNELS[0], samples - 1)));
        let mut later = manifest.clone();
        later["format"] = (VERSION + 1).into();
        assert!(matches!(read([samples; 3], &later), Err(NpzError::FutureVersion { .. })));
    }
}
