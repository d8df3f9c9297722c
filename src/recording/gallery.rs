//! Recordings that come with the program, each with a story and a sealed truth: its files in `datasets/gallery/` and one line here.
//!
//! A sample is named by a path, `gallery/NAME`, and goes through the same door as a file of the user
//! ([`read`](super::read::read())). `NAME.toml` ([`Told`]) says what is told before it is opened, `NAME.sealed` what is hidden;
//! `torquescope gallery make` writes the logs and seals anew.

use std::path::{Component, Path, PathBuf};
use std::sync::LazyLock;

use serde::Deserialize;

use super::Recording;
use super::read::ReadOptions;
use super::seal::Seal;
use crate::arm::Posture;

/// What the paths of all samples begin with.
pub const FOLDER: &str = "gallery";

/// The files of a sample, by its name and those of its log.
macro_rules! files {
    ($name:literal: $($log:literal),+) => {
        Files {
            name: $name,
            told: include_str!(concat!("../../datasets/gallery/", $name, ".toml")),
            truth: include_bytes!(concat!("../../datasets/gallery/", $name, ".sealed")),
            log: &[$(($log, include_bytes!(concat!("../../datasets/gallery/", $log)) as &[u8])),+],
        }
    };
}

/// In the order in which they are shown: what is easy stands first.
const FILES: &[Files] = &[
    files!("sticky-shoulder": "sticky-shoulder.csv"),
    files!("healthy-arm": "healthy-arm.csv.gz"),
    files!("cold-grease": "cold-grease.jsonl"),
    files!("balanced-elbow": "balanced-elbow/q.npy", "balanced-elbow/qd.npy", "balanced-elbow/t.npy", "balanced-elbow/tau.npy"),
    files!("leaning-table": "leaning-table.csv"),
    files!("toothed-motor": "toothed-motor.npz"),
    files!("rubber-buffer": "rubber-buffer.npz"),
    files!("new-gearbox": "new-gearbox.json"),
    files!("clipped-sensor": "clipped-sensor.mat"),
    files!("nameless-logger": "nameless-logger.csv"),
    files!("mirrored-elbow": "mirrored-elbow.txt"),
    files!("lost-zero": "lost-zero.mat"),
    files!("helping-spring": "helping-spring.parquet"),
    files!("old-rig": "old-rig.h5"),
    files!("crossed-plugs": "crossed-plugs.pickle"),
    files!("soup-kitchen": "soup-kitchen.db3"),
    files!("welding-hose": "welding-hose.mcap"),
];

/// What is embedded of a sample.
struct Files {
    name: &'static str,
    told: &'static str,
    truth: &'static [u8],
    log: &'static [(&'static str, &'static [u8])],
}

/// A recording that comes with the program.
#[derive(Debug)]
pub struct Sample {
    /// Its name, without [`FOLDER`].
    pub name: &'static str,
    /// What is told of it.
    pub told: Told,
    /// Names and bytes of the files of its log: one, or the arrays of a folder.
    pub log: &'static [(&'static str, &'static [u8])],
    truth: &'static [u8],
}

/// What is told of a sample before it is opened; its TOML file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Told {
    /// A few words.
    pub title: String,
    /// Which arm it is, and what somebody noticed.
    pub story: String,
    /// What one learns from it; it does not give the answer away.
    pub teaches: String,
    /// The format of the log in words.
    pub format: String,
    /// Where the arm is said to point at q = 0.
    zero: Option<Zero>,
    /// Which column is which channel, as [`MappingSpec`](super::mapping::MappingSpec) reads it.
    map: Option<String>,
    /// Sampling rate \[Hz\] of a log without a clock.
    rate_hz: Option<f64>,
}

/// Directions of the first link at q = 0.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Zero {
    Down,
    Right,
    Up,
}

/// No sample has this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no sample `{name}` in the gallery; there are: {known}")]
pub struct UnknownSample {
    /// What was asked for.
    pub name: String,
    /// What there is.
    pub known: String,
}

/// All of them.
pub fn all() -> &'static [Sample] {
    static ALL: LazyLock<Vec<Sample>> = LazyLock::new(|| FILES.iter().map(Sample::of).collect());
    &ALL
}

/// The sample that a path names; `None` if it leads elsewhere.
///
/// # Errors
/// [`UnknownSample`] if it leads into the gallery, where there is none of its name. A file of the user is no error.
pub fn at(path: &Path) -> Result<Option<&'static Sample>, UnknownSample> {
    let mut parts = path.components();
    let (Some(Component::Normal(folder)), Some(Component::Normal(name)), None) =
        (parts.next(), parts.next(), parts.next())
    else {
        return Ok(None);
    };
    if folder != FOLDER {
        return Ok(None);
    }
    let name = name.to_string_lossy();
    match all().iter().find(|sample| sample.name == name) {
        None if path.exists() => Ok(None),
        None => Err(UnknownSample {
            name: name.into_owned(),
            known: all().iter().map(|it| it.name).collect::<Vec<_>>().join(", "),
        }),
        found => Ok(found),
    }
}

/// The sample that a recording was read from, told by its seal.
pub fn of(recording: &Recording) -> Option<&'static Sample> {
    let seal = recording.seal.as_ref()?;
    all().iter().find(|sample| sample.truth == seal.as_bytes())
}

impl Sample {
    fn of(files: &Files) -> Sample {
        let told = toml::from_str(files.told).expect("a test reads every sample of the program");
        Sample { name: files.name, told, log: files.log, truth: files.truth }
    }

    /// What opens it, as a path.
    pub fn path(&self) -> PathBuf {
        Path::new(FOLDER).join(self.name)
    }

    /// What is hidden in it.
    pub fn seal(&self) -> Seal {
        Seal::from_bytes(self.truth.to_vec())
    }
}

impl Told {
    /// How its log is read where the user says nothing else.
    pub(super) fn completing(&self, options: &ReadOptions) -> ReadOptions {
        let mut completed = options.clone();
        let zero = self.zero.map(|zero| match zero {
            Zero::Down => Posture::DOWN,
            Zero::Right => Posture::RIGHT,
            Zero::Up => Posture::UP,
        });
        completed.zero = options.zero.or(zero);
        completed.rate_hz = options.rate_hz.or(self.rate_hz);
        let map = || self.map.as_ref().map(|text| text.parse().expect("a test reads every sample of the program"));
        completed.mapping = options.mapping.clone().or_else(map);
        completed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Channels, Trajectory};
    use crate::signals::Signals;

    #[test]
    fn a_sample_is_found_by_its_path_and_by_its_seal() {
        let sample = &all()[0];
        assert!(at(&sample.path()).is_ok_and(|found| found.is_some_and(|it| it.name == sample.name)));
        let elsewhere = ["gallery", "other/healthy-arm", "gallery/healthy-arm/log.csv"];
        assert!(elsewhere.iter().all(|path| matches!(at(Path::new(path)), Ok(None))));
        let unknown = at(&Path::new(FOLDER).join("no-such-log")).err().map(|error| error.to_string());
        assert!(unknown.is_some_and(|error| error.contains("no-such-log") && error.contains(sample.name)));
        let channels = || Signals::zeros(1, 3);
        let run =
            Channels { time: vec![0.0, 1.0, 2.0], q: channels(), qd: channels(), qdd: channels(), tau: channels() };
        let mut recording = Recording::of_runs(vec![Trajectory::new("run", run).unwrap()]);
        assert!(of(&recording).is_none(), "it has no seal");
        recording.seal = Some(sample.seal());
        assert!(of(&recording).is_some_and(|it| it.name == sample.name));
    }
}
