//! The program tries to break itself, and counts: [`MEASURES`] are its promises of reliability, each with what passes.
//!
//! What may hang, die or take all memory does so in a process of its own: [`opener`] opens files there, [`window`] works in the
//! window, and `kills` starts the program's own commands. The truth is known everywhere: `seeds` are clean files, `damage` breaks them. Everything follows from one
//! seed, but the moments of kills. A new measure is one file with a [`Measure`] and one line in the table.

mod crafted;
mod damage;
mod documents;
mod endurance;
mod faults;
mod jobs;
mod kills;
mod logs;
pub mod memory;
pub mod opener;
mod places;
mod sameness;
pub mod seeds;
pub mod window;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::file;
use crate::progress::{Monitor, Stopped};

/// All measures, in the order in which they are taken.
pub static MEASURES: [&Measure; 9] = [
    &logs::MEASURE,
    &crafted::MEASURE,
    &documents::MEASURE,
    &faults::MEASURE,
    &sameness::MEASURE,
    &kills::MEASURE,
    &jobs::MEASURE,
    &places::MEASURE,
    &endurance::MEASURE,
];

/// One promise, and how it is tried.
pub struct Measure {
    /// Its name on the command line.
    pub id: &'static str,
    /// What is done, and what passes.
    pub promise: &'static str,
    take: fn(&Bench) -> Result<Score, SelftestError>,
}

/// How much is tried.
#[derive(Debug, Clone, Default)]
pub struct Effort {
    /// As much as the scoreboard asks for, and not only what fits into a minute.
    pub long: bool,
    /// No measure takes more cases than this.
    pub most: Option<usize>,
    /// Of all random draws.
    pub seed: u64,
    /// Where damaged files are kept that were opened as they should not.
    pub keep: Option<PathBuf>,
}

/// It could not be tried.
#[derive(Debug, thiserror::Error)]
pub enum SelftestError {
    /// Files or processes.
    #[error("the selftest needs files and processes of its own: {0}")]
    System(#[from] std::io::Error),
    /// What is known to work does not: what was to be damaged can't be made.
    #[error("the selftest can't make {what}: {problem}")]
    Preparation {
        /// What.
        what: String,
        /// What is wrong.
        problem: String,
    },
    /// The window could not be worked in.
    #[error("the window can't be worked in: {0}")]
    Window(String),
    /// Somebody stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl SelftestError {
    /// What can't be made, and why.
    fn making(what: &str) -> impl Fn(&dyn std::fmt::Display) -> SelftestError {
        move |problem| SelftestError::Preparation { what: what.to_owned(), problem: problem.to_string() }
    }
}

/// What a measure found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Score {
    /// How many cases were tried.
    pub cases: usize,
    /// How many of them ended how.
    pub counts: BTreeMap<String, usize>,
    /// Every promise that was broken; nothing if it passes.
    pub broken: Vec<String>,
    /// What could not be tried here, and why.
    pub left_out: Vec<String>,
}

impl Score {
    fn count(&mut self, what: impl Into<String>) {
        *self.counts.entry(what.into()).or_default() += 1;
    }

    fn of(&self, what: &str) -> usize {
        self.counts.get(what).copied().unwrap_or(0)
    }

    /// Whether something is as promised; if not, what is not.
    fn demand(&mut self, is_so: bool, broken: impl FnOnce() -> String) {
        if !is_so {
            self.broken.push(broken());
        }
    }
}

/// The score of a measure that was taken.
#[derive(Debug, Serialize)]
pub struct Taken {
    /// Of which measure.
    pub measure: &'static str,
    /// What it promises.
    pub promise: &'static str,
    /// Whether it holds.
    pub passed: bool,
    /// How long it took \[s\].
    pub seconds: f64,
    /// What was found.
    #[serde(flatten)]
    pub score: Score,
}

/// What measures work with.
struct Bench<'a> {
    effort: Effort,
    /// This program, to be started again.
    program: PathBuf,
    folder: &'a Path,
    monitor: &'a Monitor,
}

impl Bench<'_> {
    /// How many cases of those that a short or a long selftest takes.
    fn cases(&self, short: usize, long: usize) -> usize {
        let cases = if self.effort.long { long } else { short };
        cases.min(self.effort.most.unwrap_or(usize::MAX))
    }

    /// Keeps a file that was opened as it should not, to be looked at.
    fn keep(&self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        self.effort.keep.as_ref().map_or(Ok(()), |folder| file::write(&folder.join(name), bytes))
    }

    fn random(&self, case: usize) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.effort.seed);
        random.set_stream(case as u64);
        random
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn report(&self, case: usize, cases: usize, what: &str) -> Result<(), Stopped> {
        self.monitor.report(case as f32 / cases.max(1) as f32, &format!("{what}, {case} of {cases}"))
    }
}

/// Takes these measures, each in an empty folder of its own that is removed afterwards.
///
/// # Errors
/// [`SelftestError`] if one can't be taken; what it finds is no error.
pub fn take(measures: &[&'static Measure], effort: &Effort, monitor: &Monitor) -> Result<Vec<Taken>, SelftestError> {
    let program = std::env::current_exe()?;
    let take = |(index, measure): (usize, &&'static Measure)| {
        let folder = tempfile::tempdir()?;
        let share = 1.0 / measures.len() as f32;
        let part = monitor.part(index as f32 * share..(index + 1) as f32 * share);
        let bench = Bench { effort: effort.clone(), program: program.clone(), folder: folder.path(), monitor: &part };
        let begin = Instant::now();
        let score = (measure.take)(&bench)?;
        let (passed, seconds) = (score.broken.is_empty(), begin.elapsed().as_secs_f64());
        Ok(Taken { measure: measure.id, promise: measure.promise, passed, seconds, score })
    };
    measures.iter().enumerate().map(take).collect()
}
