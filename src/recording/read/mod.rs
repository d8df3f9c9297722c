//! The front door: files in, one [`Recording`] and what is to be said about it out.
//!
//! Only this file and `bytes` open files; the readers below take bytes, that of CSV its text as it comes. Everything is checked before
//! anything is returned: there is no half-read recording.

mod arrays;
mod assemble;
mod bag;
mod budget;
mod bytes;
pub(crate) mod cdr;
mod clocks;
mod csv;
mod folder;
mod gzip;
mod hdf5;
mod idl;
mod join;
mod json;
mod mat;
mod mcap;
mod messages;
mod npz;
mod parquet;
mod pickle;
mod repeats;
mod share;
mod sniff;
mod table;
mod text;
mod topics;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use self::bag::BagError;
pub use self::csv::CsvError;
pub use super::npy::NpyError;
pub use arrays::ArraysError;
pub use budget::TooMuch;
pub use gzip::GzipError;
pub use hdf5::Hdf5Error;
pub use join::JoinError;
pub(crate) use join::parts;
pub use join::path_of as side_by_side;
pub use json::JsonError;
pub use mat::MatError;
pub use mcap::McapError;
pub use npz::NpzError;
pub use parquet::ParquetError;
pub use pickle::PickleError;
pub use sniff::{Format, FormatError, READABLE, endings, sniff};
pub use text::TextError;
pub use topics::{SeenTopic, TopicError};

use self::arrays::{Gathered, Source};
use self::budget::Budget;
use self::bytes::Bytes;
use self::npz::Content;
use self::share::{Counted, Share};
use self::table::{Table, listed};
use self::text::Text;
use super::catalogue;
use super::check::{Checked, check};
use super::correction::{Correction, CorrectionError};
use super::differentiate::{Smoothing, description, gaussian_description};
use super::drive::DriveError;
use super::encoders::Side;
use super::finding::{Finding, FindingKind, Place, Severity};
use super::gallery::{self, Sample, UnknownSample};
use super::mapping::{Channel, Mapping, MappingError, MappingSpec, is_current};
use super::split::Unusable;
use super::torque::{TorqueFact, TorqueFacts};
use super::transform::TransformError;
use super::{Joint, Origin, Provenance, Recording, RecordingError};
use crate::arm::{Arm, Posture};
use crate::file;
use crate::progress::{Event, Monitor, Stopped};

/// How to read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReadOptions {
    /// Which column is which channel; what it leaves open is guessed.
    pub mapping: Option<MappingSpec>,
    /// Where q = 0 points and which way q grows, where the file does not say it (or says it wrongly).
    pub zero: Option<Posture>,
    /// The arm's stated masses and lengths, where the file does not say them (or says them wrongly).
    pub arm: Option<Arm>,
    /// What the torque is, where the user says it; as the mapping says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<TorqueFacts>,
    /// On which side of the gears the encoders are, where the user says it; as the mapping says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoders: Option<Side>,
    /// Sampling rate \[Hz\] of files without a time column.
    pub rate_hz: Option<f64>,
    /// Cut-off of the filter for derived channels \[Hz\]; by default [`super::differentiate::default_cutoff`].
    pub low_pass_hz: Option<f64>,
    /// Width \[samples\] of the Gaussian that smooths derived channels instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gaussian_samples: Option<f64>,
    /// What is set right after reading, one after the other.
    pub set_right: Vec<Correction>,
    /// Largest file that is read, and most that the numbers of an archive may take \[bytes\].
    pub largest: u64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        ReadOptions {
            mapping: None,
            zero: None,
            arm: None,
            torque: None,
            encoders: None,
            rate_hz: None,
            low_pass_hz: None,
            gaussian_samples: None,
            set_right: Vec::new(),
            largest: file::LARGEST,
        }
    }
}

impl ReadOptions {
    /// The same by another mapping, which says what the torque is and where the encoders are, too.
    #[must_use]
    pub fn by(self, mapping: MappingSpec) -> Self {
        ReadOptions { mapping: Some(mapping), torque: None, encoders: None, ..self }
    }

    /// The same of these topics of a log of messages.
    #[must_use]
    pub fn on_topics(self, topics: Vec<String>) -> Self {
        let mapping = MappingSpec { topic: Some(topics), ..self.mapping.unwrap_or_default() };
        ReadOptions { mapping: Some(mapping), ..self }
    }

    /// What is said of the torque, here or in the mapping; `None` where nothing is.
    pub fn stated_torque(&self) -> Option<&TorqueFacts> {
        let mapped = || self.mapping.as_ref().map(|mapping| &mapping.torque).filter(|facts| !facts.is_empty());
        self.torque.as_ref().or_else(mapped)
    }

    /// Where the encoders are said to be, here or in the mapping.
    pub fn stated_encoders(&self) -> Option<Side> {
        self.encoders.or_else(|| self.mapping.as_ref()?.encoders)
    }

    /// Whether its numbers can be.
    ///
    /// # Errors
    /// [`ReadError::Option`]
    pub fn check(&self) -> Result<(), ReadError> {
        let stated = self.mapping.as_ref();
        for (option, unit, value) in [
            ("the sampling rate", "Hz", self.rate_hz),
            ("the sampling rate of the mapping", "Hz", stated.and_then(|mapping| mapping.rate_hz)),
            ("the cut-off of the mapping", "Hz", stated.and_then(|mapping| mapping.low_pass_hz)),
            ("the cut-off", "Hz", self.low_pass_hz),
            ("the width of the mapping's Gaussian", "samples", stated.and_then(|mapping| mapping.gaussian_samples)),
            ("the width of the Gaussian", "samples", self.gaussian_samples),
        ] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(ReadError::Option { option, value, unit });
            }
        }
        Ok(())
    }
}

impl ReadOptions {
    /// The topics that the mapping names.
    fn topics(&self) -> &[String] {
        self.mapping.as_ref().and_then(|mapping| mapping.topic.as_deref()).unwrap_or_default()
    }

    /// How derived channels are smoothed, if it was said: here before in the mapping, and by a Gaussian before a cut-off.
    fn smoothing(&self) -> Option<Smoothing> {
        let mapping = self.mapping.as_ref();
        let of = |width: Option<f64>, cutoff_hz: Option<f64>| {
            width.map(Smoothing::Gaussian).or(cutoff_hz.map(Smoothing::Butterworth))
        };
        let of_mapping = || mapping.and_then(|mapping| of(mapping.gaussian_samples, mapping.low_pass_hz));
        of(self.gaussian_samples, self.low_pass_hz).or_else(of_mapping)
    }
}

/// What was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The recording; it passes [`Recording::verify`].
    pub recording: Recording,
    /// What is to be said about it: what the import did, then what [`check`] found.
    pub findings: Vec<Finding>,
    /// The readings that are none, as [`unusable`](super::split::unusable) gives them.
    pub unusable: Vec<Unusable>,
    /// Which column became which channel.
    pub mapping: Mapping,
}

/// Nothing was read, and why.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// No file was named.
    #[error("no file was named; name at least one log ({READABLE})")]
    NoFile,
    /// It is not in the gallery.
    #[error(transparent)]
    Sample(#[from] UnknownSample),
    /// An option makes no sense.
    #[error("{option} is {value}, but must be a number of {unit} above 0")]
    Option {
        /// Which option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it is a number of.
        unit: &'static str,
    },
    /// The file can't be opened.
    #[error("{path} can't be read: {problem}", path = path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// The file is too large.
    #[error(
        "{file} has {size} MB, more than the limit of {limit} MB; cut the log into several files, or raise the limit"
    )]
    TooLarge {
        /// Its name.
        file: String,
        /// Its size \[MB\].
        size: u64,
        /// What is allowed \[MB\].
        limit: u64,
    },
    /// It is not a format that we read.
    #[error("{file}: {problem}")]
    Format {
        /// Its name.
        file: String,
        /// What it is instead.
        problem: FormatError,
    },
    /// The text is not a table.
    #[error("{file}: {problem}")]
    Csv {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: CsvError,
    },
    /// The archive can't be read.
    #[error("{file}: {problem}")]
    Npz {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: Box<NpzError>,
    },
    /// Arrays in files of their own can't be read.
    #[error("{file}: {problem}")]
    Npy {
        /// Name of the file or folder.
        file: String,
        /// What is wrong.
        problem: ArraysError,
    },
    /// The MATLAB file can't be read.
    #[error("{file}: {problem}")]
    Mat {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: MatError,
    },
    /// The bag can't be read.
    #[error("{file}: {problem}")]
    Bag {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: Box<BagError>,
    },
    /// The MCAP log can't be read.
    #[error("{file}: {problem}")]
    Mcap {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: Box<McapError>,
    },
    /// The HDF5 file can't be read.
    #[error("{file}: {problem}")]
    Hdf5 {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: Hdf5Error,
    },
    /// The JSON can't be read.
    #[error("{file}: {problem}")]
    Json {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: JsonError,
    },
    /// The Parquet file can't be read.
    #[error("{file}: {problem}")]
    Parquet {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: ParquetError,
    },
    /// The pickle can't be read.
    #[error("{file}: {problem}")]
    Pickle {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: Box<PickleError>,
    },
    /// The packed file can't be unpacked.
    #[error("{file}: {problem}")]
    Gzip {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: GzipError,
    },
    /// Files that were to stand side by side do not fit.
    #[error("{file}: {problem}")]
    Join {
        /// Their names.
        file: String,
        /// What is wrong.
        problem: JoinError,
    },
    /// What the mapping says of the numbers does not fit the file.
    #[error("{file}: {}: {problem}; change the mapping", channel.title())]
    Transform {
        /// Its name.
        file: String,
        /// The channel.
        channel: Channel,
        /// What is wrong.
        problem: TransformError,
    },
    /// What the mapping says of the drive does not fit the file.
    #[error("{file}: {problem}; change the mapping")]
    Drive {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: DriveError,
    },
    /// The columns can't be mapped.
    #[error("{file}: {problem}{}{}", and_constants(.constants), and_passed_over(.passed_over))]
    Mapping {
        /// Its name.
        file: String,
        /// What is wrong.
        problem: Box<MappingError>,
        /// Numbers of the file that hold for all samples.
        constants: Vec<String>,
        /// Parts of the file that no column was made of.
        passed_over: Vec<String>,
    },
    /// A later file lacks a column of the first.
    #[error("{file}: the column `{column}`, which the first file has, is missing; read files with other columns apart")]
    MissingColumn {
        /// Its name.
        file: String,
        /// The column.
        column: String,
    },
    /// Text where a number should be.
    #[error(
        "{file}: line {line}, column `{column}`: `{cell}` is not a number; mend or delete it, or map another column"
    )]
    Text {
        /// Its name.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: String,
        /// What stands there.
        cell: String,
    },
    /// A used column has no value at all.
    #[error(
        "{file}: the column `{column}` holds no finite number; map another column, or leave the channel out with `-`"
    )]
    NoValues {
        /// Its name.
        file: String,
        /// The column.
        column: String,
    },
    /// Neither time nor rate.
    #[error(
        "{file}: no time column was recognised among: {columns}; map one (`time=…`), or state the sampling rate in Hz"
    )]
    NoTime {
        /// Its name.
        file: String,
        /// All columns there are.
        columns: String,
    },
    /// The clock stands still or goes back.
    #[error(
        "{file}: {place}: time goes from {before} s to {now} s, but must increase; if several runs stand in one file, make \
         each a file of its own; if samples were written twice, delete the copies; if only the clock is wrong, leave it \
         out (`time=-`) and state the sampling rate"
    )]
    Clock {
        /// Its name.
        file: String,
        /// Line or sample.
        place: String,
        /// Time before \[s\].
        before: f64,
        /// Time there \[s\].
        now: f64,
    },
    /// No stretch is long enough.
    #[error(
        "{file}: nothing is left between missing values and gaps in time: a run needs {run} samples, a piece of one that \
         is cut {piece}; channels that were sampled at different times have to be brought to one clock first"
    )]
    NothingLeft {
        /// Its name.
        file: String,
        /// How many samples an uncut run needs.
        run: usize,
        /// How many samples a piece between two cuts needs.
        piece: usize,
    },
    /// Derivatives became infinite, or the like.
    #[error("{0}; the values of the log are too large or too close in time to compute with: check its units")]
    Recording(#[from] RecordingError),
    /// Two files are of different arms.
    #[error("{file}: its joints move otherwise than those of the first file ({what}); read the files apart")]
    OtherJoints {
        /// Its name.
        file: String,
        /// The difference.
        what: String,
    },
    /// What was to be set right does not fit.
    #[error("what is to be set right: {0}")]
    Correction(#[from] CorrectionError),
    /// A recording of our own together with other files.
    #[error("{file} is a whole recording of this program; read it alone")]
    NotAlone {
        /// Its name.
        file: String,
    },
    /// There are no columns to be mapped.
    #[error("{file} is a whole recording of this program, which needs no mapping")]
    NeedsNone {
        /// Its name.
        file: String,
    },
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl ReadError {
    /// Whether whoever knows what the columns are can help.
    pub fn is_about_columns(&self) -> bool {
        matches!(
            self,
            ReadError::Mapping { .. } | ReadError::NoTime { .. } | ReadError::NoValues { .. } | ReadError::Text { .. }
        ) || self.fullest_topic().is_some()
    }
}

impl ReadError {
    /// Of a log of messages none of whose topics has positions and torques by their names, the topic with most numbers.
    fn fullest_topic(&self) -> Option<&str> {
        let problem = match self {
            ReadError::Bag { problem, .. } => match &**problem {
                BagError::Topics(problem) => problem,
                _ => return None,
            },
            ReadError::Mcap { problem, .. } => match &**problem {
                McapError::Topics(problem) => problem,
                _ => return None,
            },
            _ => return None,
        };
        match problem {
            TopicError::NoStates { fullest, .. } => fullest.as_deref(),
            _ => None,
        }
    }
}

fn and_constants(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!("; a mapping file may take as factor: {}", names.join(", ")) }
}

fn and_passed_over(parts: &[String]) -> String {
    if parts.is_empty() { String::new() } else { format!("; passed over: {}", listed(parts)) }
}

/// Reads one recording; several files become trajectories of one arm, all mapped like the first. A path such as
/// `angles.csv+currents.csv` stands for files with channels of the same samples, which are put side by side; a folder stands for
/// the arrays of its `.npy` files, as if they were in one archive, or for its logs (a ROS 2 bag, LeRobot's episodes, runs of one
/// kind); `gallery/NAME` for a recording that comes with the program.
///
/// # Errors
/// [`ReadError`] says which file, where in it, what is wrong and what to do. Nothing is returned then.
pub fn read(paths: &[PathBuf], options: &ReadOptions, monitor: &Monitor) -> Result<Import, ReadError> {
    options.check()?;
    for path in paths {
        if let Some(sample) = gallery::at(path)? {
            return match paths.len() {
                1 => read_sample(sample, options, monitor),
                _ => Err(ReadError::NotAlone { file: path.display().to_string() }),
            };
        }
    }
    let mut files = Vec::new();
    for path in paths {
        let unreadable = |problem| ReadError::File { path: path.clone(), problem };
        match folder::logs(path).map_err(unreadable)? {
            Some(logs) => files.extend(logs),
            None => files.push(path.clone()),
        }
    }
    let mut import = read_files(&files, options, monitor)?;
    if let ([path], true) = (paths, files.len() > 1) {
        import.recording.name = stem(path);
    }
    Ok(import)
}

/// A sample of the gallery as if it were a file: with what is told of it where the user says nothing else, and with its seal.
fn read_sample(sample: &Sample, options: &ReadOptions, monitor: &Monitor) -> Result<Import, ReadError> {
    let mut import = read_files(&[sample.path()], &sample.told.completing(options), monitor)?;
    import.recording.name = sample.told.title.clone();
    import.recording.seal = Some(sample.seal());
    Ok(import)
}

/// The share of its time that the reading of a file takes; the rest goes into filters and checks.
const READING: f32 = 0.8;

/// The line of what reads a file, which need not know its name.
fn of_file(monitor: &Monitor, file: &str) -> Monitor {
    let (whole, activity) = (monitor.clone(), format!("reading {file}"));
    monitor.of_part(move |event| match event {
        Event::Progress(progress) => whole.report(progress.fraction, &activity),
        _ => Ok(()),
    })
}

fn read_files(paths: &[PathBuf], options: &ReadOptions, monitor: &Monitor) -> Result<Import, ReadError> {
    let mut merge: Option<Merge> = None;
    for (index, path) in paths.iter().enumerate() {
        let file = file_name(path);
        let share = |part: f32| (index as f32 + part) / paths.len() as f32;
        let reading = of_file(&monitor.part(share(0.0)..share(READING)), &file);
        reading.report(0.0, "")?;
        match open(path, options, &reading)? {
            Content::Recording(recording) if paths.len() == 1 => return own(*recording, options),
            Content::Recording(_) => return Err(ReadError::NotAlone { file }),
            Content::Table(table) => {
                let merge = match &mut merge {
                    Some(merge) => merge,
                    None => merge.insert(Merge::start(&table, &file, options)?),
                };
                monitor.report(share(READING), &format!("filtering {file}"))?;
                merge.add(*table, &file, &stem(path), options, monitor)?;
            }
        }
    }
    merge.ok_or(ReadError::NoFile)?.finish(paths, options)
}

/// A recording in our own layout, from its bytes.
///
/// # Errors
/// [`ReadError`] as for [`read`].
pub fn own_recording(bytes: &[u8], monitor: &Monitor) -> Result<Recording, ReadError> {
    let name = Path::new("the recording of the session");
    match decode(&Bytes::InMemory(bytes), name, &ReadOptions::default(), monitor)? {
        Content::Recording(recording) => Ok(*recording),
        Content::Table(_) => Err(ReadError::NotAlone { file: file_name(name) }),
    }
}

/// The columns of a log as they stand in it, for a mapping to be made by hand.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// In the order of the file.
    pub columns: Vec<Seen>,
    /// The topics of a log of messages, by their names; empty for all other logs.
    pub topics: Vec<SeenTopic>,
    /// What is to be said of their clocks.
    pub clocks: Vec<String>,
}

/// A column as it stands in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Its name.
    pub name: String,
    /// Its numbers, NaN where there is none.
    pub values: Vec<f64>,
}

impl Preview {
    /// The names of all columns.
    pub fn names(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.name.clone()).collect()
    }

    /// The topics that the columns are from, the one that gives the times first.
    pub fn taken(&self) -> Vec<String> {
        let mut taken: Vec<&SeenTopic> = self.topics.iter().filter(|topic| topic.taken.is_some()).collect();
        taken.sort_by_key(|topic| topic.taken);
        taken.into_iter().map(|topic| topic.name.clone()).collect()
    }

    /// The topics for a mapping: none where the log has no choice.
    pub fn stated_topics(&self) -> Option<Vec<String>> {
        (self.topics.len() > 1).then(|| self.taken())
    }
}

/// Looks into a log, or the first one of a folder, without making anything of it. Where no topic of a log of messages has positions and
/// torques by their names, it is the one with most numbers, for a mapping by hand.
///
/// # Errors
/// [`ReadError`] as for [`read`], and [`ReadError::NeedsNone`] for a recording of our own, which has no columns.
pub fn preview(path: &Path, options: &ReadOptions, monitor: &Monitor) -> Result<Preview, ReadError> {
    let logs = folder::logs(path).map_err(|problem| ReadError::File { path: path.to_owned(), problem })?;
    let first = logs.and_then(|logs| logs.into_iter().next());
    let path = first.as_deref().unwrap_or(path);
    let content = match open(path, options, monitor) {
        Err(error) => match error.fullest_topic() {
            Some(topic) => open(path, &options.clone().on_topics(vec![topic.to_owned()]), monitor)?,
            None => return Err(error),
        },
        content => content?,
    };
    match content {
        Content::Table(table) => {
            let Table { columns, topics, clocks, .. } = *table;
            let seen = |column: table::Column| Seen { name: column.name, values: column.values };
            let clocks = clocks.into_iter().map(|told| told.what).collect();
            Ok(Preview { columns: columns.into_iter().map(seen).collect(), topics, clocks })
        }
        Content::Recording(_) => Err(ReadError::NeedsNone { file: file_name(path) }),
    }
}

fn open(path: &Path, options: &ReadOptions, monitor: &Monitor) -> Result<Content, ReadError> {
    let parts = join::parts(path);
    if path.exists() || parts.len() < 2 {
        return open_one(path, options, monitor);
    }
    let file = || file_name(path);
    let mut tables = Vec::new();
    for part in &parts {
        match open_one(part, options, monitor)? {
            Content::Table(table) => tables.push((stem(part), *table)),
            Content::Recording(_) => return Err(ReadError::NotAlone { file: file_name(part) }),
        }
    }
    let joined = join::side_by_side(tables).map_err(|problem| ReadError::Join { file: file(), problem })?;
    Ok(Content::Table(Box::new(joined)))
}

fn open_one(path: &Path, options: &ReadOptions, monitor: &Monitor) -> Result<Content, ReadError> {
    if let Some(sample) = gallery::at(path)? {
        return embedded(sample, options, monitor);
    }
    let unreadable = |problem| ReadError::File { path: path.to_owned(), problem };
    if std::fs::metadata(path).map_err(unreadable)?.is_dir() {
        return arrays_of(path, options, monitor);
    }
    size(path, options)?;
    decode(&Bytes::from(path), path, options, monitor)
}

/// The size of a plain file that is not too large \[bytes\].
fn size(path: &Path, options: &ReadOptions) -> Result<u64, ReadError> {
    let unreadable = |problem| ReadError::File { path: path.to_owned(), problem };
    let (size, limit) = (file::size(path).map_err(unreadable)?, options.largest);
    if size > limit {
        return Err(ReadError::TooLarge { file: file_name(path), size: size >> 20, limit: limit >> 20 });
    }
    Ok(size)
}

/// The arrays of a folder of NPY files, each named by its file.
fn arrays_of(path: &Path, options: &ReadOptions, monitor: &Monitor) -> Result<Content, ReadError> {
    let unreadable = |problem| ReadError::File { path: path.to_owned(), problem };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        files.push(entry.map_err(unreadable)?.path());
    }
    files.retain(|file| Format::Npy.endings().contains(&ending(file).as_str()));
    if files.is_empty() {
        let what = "it is a folder without NPY arrays; name its files themselves";
        return Err(unreadable(std::io::Error::other(what)));
    }
    files.sort();
    let mut sum = 0;
    for file in &files {
        sum += size(file, options)?;
    }
    let mut budget = Budget::of(sum, options.largest);
    let names = files.iter().map(|file| stem(file)).collect();
    let mut source: Vec<Bytes> = files.iter().map(|file| Bytes::from(file.as_path())).collect();
    let table = table_of(&mut source, names, &file_name(path), &mut budget, monitor)?;
    Ok(Content::Table(Box::new(table)))
}

/// The log of a sample, which lies in the program.
fn embedded(sample: &Sample, options: &ReadOptions, monitor: &Monitor) -> Result<Content, ReadError> {
    if let [(name, bytes)] = sample.log {
        return decode(&Bytes::InMemory(bytes), Path::new(name), options, monitor);
    }
    let mut arrays: Vec<Bytes> = sample.log.iter().map(|(_, bytes)| Bytes::InMemory(bytes)).collect();
    let names = sample.log.iter().map(|(name, _)| stem(Path::new(name))).collect();
    let mut budget = Budget::of(sample.log.iter().map(|(_, bytes)| bytes.len() as u64).sum(), options.largest);
    let table = table_of(&mut arrays, names, sample.name, &mut budget, monitor)?;
    Ok(Content::Table(Box::new(table)))
}

/// The columns of arrays that belong together.
fn table_of(
    source: &mut dyn Source,
    names: Vec<String>,
    file: &str,
    budget: &mut Budget,
    monitor: &Monitor,
) -> Result<Table, ReadError> {
    let mut gathered = Gathered::default();
    let taken = gathered.take(source, names.into_iter().enumerate().collect(), false, budget, monitor);
    monitor.check()?;
    let table = taken.and_then(|()| gathered.table(budget));
    table.map_err(|problem| ReadError::Npy { file: file.to_owned(), problem })
}

/// The share of its time that unpacking takes of a packed file.
const UNPACKING: f32 = 0.3;

fn decode(bytes: &Bytes, path: &Path, options: &ReadOptions, monitor: &Monitor) -> Result<Content, ReadError> {
    let unreadable = |problem| ReadError::File { path: path.to_owned(), problem };
    let wrong = |problem| ReadError::Gzip { file: file_name(path), problem };
    let (mut head, mut ending) = (bytes.head(sniff::LOOKED_AT).map_err(unreadable)?, ending(path));
    let is_packed = head.starts_with(gzip::SIGNATURE);
    if is_packed {
        head = gzip::head(bytes.open().map_err(unreadable)?, sniff::LOOKED_AT as u64).map_err(wrong)?;
        // `log.csv.gz` is a CSV; a name that says nothing of what is inside promises nothing.
        ending = if ending == sniff::PACKED { self::ending(&path.with_extension("")) } else { String::new() };
    }
    let format = sniff(&head, &ending).map_err(|problem| ReadError::Format { file: file_name(path), problem })?;
    let content = content(bytes, is_packed, format, path, options, monitor);
    // Who was stopped says so in the words of its format.
    monitor.check()?;
    let mut content = content?;
    let topics = options.topics();
    if let Content::Table(table) = &mut content
        && !topics.is_empty()
        && ![Format::Bag, Format::Mcap].contains(&format)
    {
        table
            .passed_over
            .push(format!("the topic {} of the mapping: only logs of messages have topics", topics.join(", ")));
    }
    Ok(content)
}

fn content(
    bytes: &Bytes,
    is_packed: bool,
    format: Format,
    path: &Path,
    options: &ReadOptions,
    monitor: &Monitor,
) -> Result<Content, ReadError> {
    let (file, topics) = (file_name(path), options.topics());
    let unreadable = |problem| ReadError::File { path: path.to_owned(), problem };
    let size = bytes.size().map_err(unreadable)?;
    let counted = |monitor| {
        let from = bytes.open().map_err(unreadable)?;
        Ok::<_, ReadError>(Counted { from, share: Share::of(size, monitor), done: 0 })
    };
    let budget = || Budget::of(size, options.largest);
    let (unpacking, unpacked) = (monitor.part(0.0..UNPACKING), monitor.part(UNPACKING..1.0));
    let (whole, after) = match (format, is_packed) {
        // Text is never there as a whole.
        (Format::Csv, _) => (Cow::default(), monitor),
        (_, false) => (bytes.whole(options.largest).map_err(unreadable)?, monitor),
        (_, true) => {
            let whole = gzip::unpack(counted(&unpacking)?, budget());
            (whole.map_err(|problem| ReadError::Gzip { file: file.clone(), problem })?.into(), &unpacked)
        }
    };
    let (whole, monitor, of_whole) = (&*whole, after, &mut Budget::of(whole.len() as u64, options.largest));
    match format {
        Format::Csv => {
            let from = Box::new(counted(monitor)?);
            let mut text = if is_packed { Text::packed(from, budget()) } else { Text::plain(from, size) };
            csv::read(&mut text, &mut budget()).map_err(|problem| match problem {
                CsvError::Text(TextError::Gzip(problem)) => ReadError::Gzip { file, problem },
                problem => ReadError::Csv { file, problem },
            })
        }
        Format::Mat => mat::read(whole, of_whole, monitor).map_err(|problem| ReadError::Mat { file, problem }),
        Format::Bag => bag::read(whole, topics, of_whole, monitor)
            .map_err(|problem| ReadError::Bag { file, problem: Box::new(problem) }),
        Format::Mcap => mcap::read(whole, topics, of_whole, monitor)
            .map_err(|problem| ReadError::Mcap { file, problem: Box::new(problem) }),
        Format::Hdf5 => hdf5::read(whole, of_whole, monitor).map_err(|problem| ReadError::Hdf5 { file, problem }),
        Format::Json => json::read(whole, of_whole, monitor).map_err(|problem| ReadError::Json { file, problem }),
        Format::Parquet => {
            parquet::read(whole, of_whole, monitor).map_err(|problem| ReadError::Parquet { file, problem })
        }
        Format::Pickle => pickle::read(whole, of_whole, monitor)
            .map_err(|problem| ReadError::Pickle { file, problem: Box::new(problem) }),
        Format::Npz => {
            let wrong = |problem| ReadError::Npz { file, problem: Box::new(problem) };
            return npz::read(whole, of_whole, monitor).map_err(wrong);
        }
        Format::Npy => {
            let mut source = vec![Bytes::InMemory(whole)];
            table_of(&mut source, vec![stem(path)], &file, of_whole, monitor)
        }
    }
    .map(|table| Content::Table(Box::new(table)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// In small letters, without the dot.
fn ending(path: &Path) -> String {
    path.extension().map_or_else(String::new, |ending| ending.to_string_lossy().to_lowercase())
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A recording of our own is complete; only the posture and the stated arm may be said anew.
fn own(mut recording: Recording, options: &ReadOptions) -> Result<Import, ReadError> {
    if let Some(chain) = options.mapping.as_ref().and_then(|mapping| mapping.chain.clone()) {
        // Who states axes states the arm.
        (recording.posture, recording.stated_arm, recording.chain) = (None, None, Some(chain));
    }
    recording.posture = options.zero.or(recording.posture);
    recording.stated_arm = options.arm.clone().or(recording.stated_arm);
    recording.settle_plane();
    recording.torque = options.stated_torque().cloned().unwrap_or(recording.torque);
    recording.encoders = options.stated_encoders().or(recording.encoders);
    let names = |array: &str| (0..recording.joint_count()).map(|joint| format!("{array}[{joint}]")).collect();
    let mapping = Mapping {
        time: Some("time".to_owned()),
        q: names("q"),
        qd: Some(names("qd")),
        qdd: Some(names("qdd")),
        tau: names("tau"),
        joints: recording.joints.iter().map(|joint| joint.name.clone()).collect(),
        ..Mapping::default()
    };
    let mut findings = set_right(&mut recording, &options.set_right)?;
    let Checked { findings: odd, unusable } = check(&recording);
    findings.extend(odd);
    if options.mapping.is_some() || options.rate_hz.is_some() || options.smoothing().is_some() {
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::PassedOver,
            what: "mapping, rate and filter were not used: a recording of this program is complete.".to_owned(),
            place: Place::default(),
            remedy: String::new(),
            set_right: Vec::new(),
        });
    }
    Ok(Import { recording, findings, unusable, mapping })
}

/// Sets right what the user asked for, and says so.
///
/// # Errors
/// [`CorrectionError`] if it does not fit the recording.
pub fn set_right(recording: &mut Recording, corrections: &[Correction]) -> Result<Vec<Finding>, CorrectionError> {
    let mut findings = Vec::new();
    for correction in corrections {
        correction.apply(recording)?;
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::SetRight,
            what: format!("set right, as asked (`{correction}`): {}.", correction.fault()),
            place: Place::default(),
            remedy: String::new(),
            set_right: Vec::new(),
        });
    }
    Ok(findings)
}

/// Files on their way to become one recording.
struct Merge {
    mapping: Mapping,
    torque: TorqueFacts,
    joints: Vec<Joint>,
    trajectories: Vec<super::Trajectory>,
    findings: Vec<Finding>,
    cutoffs: Vec<f64>,
}

impl Merge {
    fn start(table: &Table, file: &str, options: &ReadOptions) -> Result<Merge, ReadError> {
        let spec = options.mapping.clone().unwrap_or_default();
        let mut mapping = Mapping::find(&table.names(), &spec).map_err(|problem| ReadError::Mapping {
            file: file.to_owned(),
            problem: Box::new(problem),
            constants: table.constants.keys().map(|name| format!("`{name}`")).collect(),
            passed_over: table.passed_over.clone(),
        })?;
        if let Some(joints) = table.joints.as_ref().filter(|joints| joints.len() == mapping.joints.len()) {
            mapping.joints = joints.clone();
        }
        let mut torque = options.stated_torque().cloned().unwrap_or_default();
        if let Some(drive) = &spec.drive {
            let wrong = |problem| ReadError::Drive { file: file.to_owned(), problem };
            drive.check_for(mapping.joints.len()).map_err(wrong)?;
            torque.state(TorqueFact::Commanded);
        }
        if mapping.commanded.contains(&Channel::Torque) && !torque.has(TorqueFact::Measured) {
            torque.state(TorqueFact::Commanded);
        }
        let mut findings = about_mapping(&mapping, &spec, &torque, file);
        if options.mapping.is_none() {
            findings.extend(ready_mapping(&table.names(), file));
        }
        Ok(Merge { mapping, torque, joints: Vec::new(), trajectories: Vec::new(), findings, cutoffs: Vec::new() })
    }

    fn add(
        &mut self,
        table: Table,
        file: &str,
        stem: &str,
        options: &ReadOptions,
        monitor: &Monitor,
    ) -> Result<(), ReadError> {
        let mut name = stem.to_owned();
        let taken = |name: &str| self.trajectories.iter().any(|t| t.name == name || t.name == format!("{name}#1"));
        for number in 2.. {
            if !taken(&name) {
                break;
            }
            name = format!("{stem} ({number})");
        }
        let found = assemble::assemble(table, &self.mapping, file, &name, options, monitor)?;
        let joints: Vec<Joint> = self
            .mapping
            .joints
            .iter()
            .zip(found.kinds)
            .map(|(name, kind)| Joint { name: name.clone(), kind })
            .collect();
        if self.trajectories.is_empty() {
            self.joints = joints;
        } else if self.joints != joints {
            let what = "some turn in one and slide in the other".to_owned();
            return Err(ReadError::OtherJoints { file: file.to_owned(), what });
        }
        self.trajectories.extend(found.trajectories);
        self.findings.extend(found.findings);
        self.cutoffs.extend(found.cutoffs);
        Ok(())
    }

    fn finish(mut self, paths: &[PathBuf], options: &ReadOptions) -> Result<Import, ReadError> {
        let first = paths.first().map_or_else(String::new, |path| stem(path));
        let name = if paths.len() > 1 { format!("{first} and {} more", paths.len() - 1) } else { first };
        let lowest = self.cutoffs.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = self.cutoffs.iter().copied().fold(0.0, f64::max);
        let origin = |column: &Option<Vec<String>>, of| match column {
            Some(_) => Origin::Measured,
            None => Origin::Derived(match options.smoothing() {
                Some(Smoothing::Gaussian(width)) => gaussian_description(of, width),
                _ => description(of, lowest..=highest),
            }),
        };
        let is_derived = self.mapping.qd.is_none() || self.mapping.qdd.is_none();
        let provenance = Provenance {
            velocity: origin(&self.mapping.qd, "q"),
            acceleration: origin(&self.mapping.qdd, "q̇"),
            low_pass_hz: is_derived.then_some(lowest),
        };
        let mut recording = Recording {
            name,
            joints: self.joints,
            trajectories: self.trajectories,
            provenance,
            posture: options.zero,
            stated_arm: options.arm.clone(),
            chain: options.mapping.as_ref().and_then(|mapping| mapping.chain.clone()),
            torque: self.torque,
            encoders: options.stated_encoders(),
            seal: None,
        };
        recording.settle_plane();
        recording.verify()?;
        self.findings.extend(set_right(&mut recording, &options.set_right)?);
        if options.set_right.iter().any(Correction::scales_torque) {
            self.findings.retain(|finding| finding.kind != FindingKind::Amperes);
        }
        let Checked { findings, unusable } = check(&recording);
        self.findings.extend(findings);
        Ok(Import { recording, findings: self.findings, unusable, mapping: self.mapping })
    }
}

/// Whether a mapping that comes with the program names the very columns of a log that was opened without it.
fn ready_mapping(columns: &[String], file: &str) -> Option<Finding> {
    let mut ready = catalogue::fitting(columns).into_iter();
    let (name, about, _) = ready.find(|(.., spec)| spec.q.is_some() && spec.tau.is_some())?;
    Some(Finding {
        severity: Severity::Warning,
        kind: FindingKind::ReadyMapping,
        what: format!("its columns are those of a mapping that comes with the program, `{name}` ({about})."),
        place: Place::file(file),
        remedy: format!(
            "If it is that robot, open it so, with its units, gears and axes: by *Columns…* in the window, by --map {name} elsewhere."
        ),
        set_right: Vec::new(),
    })
}

fn about_mapping(mapping: &Mapping, spec: &MappingSpec, torque: &TorqueFacts, file: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(drive) = &spec.drive {
        let [what, remedy] = drive.absorbs(mapping.joints.len());
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::Drive,
            what,
            place: Place::file(file),
            remedy,
            set_right: Vec::new(),
        });
    }
    let says_ratio = spec.drive.is_some() || spec.transforms.contains_key(&Channel::Torque);
    if torque.has(TorqueFact::Motor) && !says_ratio {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::MotorSide,
            what: "the torque is said to be that of the motors, and no gear ratio is stated.".to_owned(),
            place: Place::file(file),
            remedy: "Unless the gears are 1:1 all torques and parameters are as the motors feel them. State the ratios as factor of \
                     tau in a mapping file."
                .to_owned(),
            set_right: Vec::new(),
        });
    }
    let currents = mapping.tau.iter().find(|name| is_current(name));
    if let Some(name) = currents.filter(|_| !spec.transforms.contains_key(&Channel::Torque)) {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::Amperes,
            what: format!("the torque is taken from `{name}`, which is a current [A]: no gain is stated."),
            place: Place::file(file),
            remedy: "All torques and parameters are in amperes then. State the motor's constant times the gear's ratio as factor \
                     of tau in a mapping file; where the masses of the arm are stated (`--arm robot.urdf`) it is identified."
                .to_owned(),
            set_right: Vec::new(),
        });
    }
    let mut commanded = mapping.commanded.clone();
    commanded.retain(|channel| *channel != Channel::Torque);
    let is_told = torque.has(TorqueFact::Commanded) && spec.drive.is_none();
    commanded.extend(is_told.then_some(Channel::Torque));
    for channel in &commanded {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::Commanded,
            what: format!("{} is taken from commanded values, not from measured ones.", channel.title()),
            place: Place::file(file),
            remedy: match channel {
                Channel::Torque => {
                    "What the motor was told is not what it did: expect errors of the drive in the residual."
                }
                _ => "Map the measured column, if there is one.",
            }
            .to_owned(),
            set_right: Vec::new(),
        });
    }
    if !mapping.alternatives.is_empty() {
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::Alternatives,
            what: format!(
                "of several columns that fit one was chosen; the file also has {}.",
                mapping.alternatives.join(", ")
            ),
            place: Place::file(file),
            remedy: "Give one of these as mapping to take it instead.".to_owned(),
            set_right: Vec::new(),
        });
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::seeds;
    use crate::simulation::{Scenario, simulate};

    #[test]
    fn what_is_set_right_is_said() {
        let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let before = recording.trajectories[0].tau[1][0];
        let findings = set_right(&mut recording, &["sign-torque@2".parse().unwrap()]).unwrap();
        assert_eq!(recording.trajectories[0].tau[1][0], -before);
        assert_eq!(findings.iter().map(|finding| finding.kind).collect::<Vec<_>>(), [FindingKind::SetRight]);
        assert!(findings[0].what.contains("`sign-torque@2`"), "{}", findings[0].what);
    }

    /// What comes block by block is stopped between two of them, packed or not.
    #[test]
    fn a_stop_is_heard_while_text_is_read() {
        let text = "1,2\n".repeat(5000).into_bytes();
        let packed = seeds::gzip(&text).unwrap();
        for (name, bytes) in [("log.csv", text), ("log.csv.gz", packed)] {
            let monitor = Monitor::new();
            monitor.stop("enough");
            let stopped = decode(&Bytes::InMemory(&bytes), Path::new(name), &ReadOptions::default(), &monitor);
            assert!(matches!(stopped, Err(ReadError::Stopped(_))), "{name}");
        }
    }
}
