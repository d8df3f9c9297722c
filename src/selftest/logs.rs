//! Logs that were damaged at random: they are refused, or read as they are and told, or what changed is inside the noise.

use std::collections::HashMap;
use std::path::PathBuf;

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::damage::damage;
use super::opener::{Answer, Kind, LONGEST_S, Opened, Opener, Request};
use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::file;
use crate::recording::read::Import;
use crate::recording::{Origin, Recording, Trajectory};
use crate::signals::Signals;

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "logs",
    promise: "damaged logs of all formats: no panic, none computes over 5 s or takes over 64 MiB or four times its size, and at \
              most 2 % are read with other numbers and without a finding",
    take,
};

/// Changes up to this share of a channel's RMS are inside the noise, which has so much in the seeds.
const NOISE: f64 = 0.01;
/// Share of all damaged files that may be read with other numbers, and nothing is said.
const MOST_SILENT: f64 = 0.02;
/// What reading any file may take \[bytes\], beside the numbers that are kept.
pub const LEAST_MEMORY: u64 = 64 << 20;

/// How a recording that was read differs from the one that was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Difference {
    /// In no measured number.
    None,
    /// By less than the noise.
    InNoise,
    /// By more, and a finding that the clean one does not have says that something is odd.
    Told,
    /// Samples are missing, and nothing is said.
    SilentlyShorter,
    /// In its numbers, and nothing is said.
    Silent,
}

impl Difference {
    /// Between what was written and what was read.
    pub fn between(clean: &Import, read: &Import) -> Difference {
        let numbers = compared(&clean.recording, &read.recording);
        let is_new = |what: &String| !clean.findings.iter().any(|known| known.what == *what);
        let is_told = read.findings.iter().any(|finding| is_new(&finding.what));
        match numbers {
            Difference::SilentlyShorter | Difference::Silent if is_told => Difference::Told,
            other => other,
        }
    }
}

/// What was measured in a run, each joint by itself.
fn measured(recording: &Recording, run: &Trajectory) -> Vec<Vec<f64>> {
    let mut signals: Vec<&Signals> = vec![&run.q, &run.tau];
    if recording.provenance.velocity == Origin::Measured {
        signals.push(&run.qd);
    }
    if recording.provenance.acceleration == Origin::Measured {
        signals.push(&run.qdd);
    }
    signals.into_iter().flatten().map(<[f64]>::to_vec).collect()
}

/// As if nothing were said.
fn compared(clean: &Recording, read: &Recording) -> Difference {
    let run = &clean.trajectories[0];
    let own = measured(clean, run);
    let scales: Vec<f64> = own.iter().map(|values| rms(values)).collect();
    let by_time: HashMap<u64, usize> = run.time.iter().enumerate().map(|(at, time)| (time.to_bits(), at)).collect();
    let is_whole = read.trajectories.len() == 1 && read.trajectories[0].len() == run.len();
    let (mut largest, mut is_same) = (0.0f64, is_whole);
    for other in &read.trajectories {
        let theirs = measured(read, other);
        if theirs.len() != own.len() {
            // That a channel was derived, the recording itself says.
            return Difference::Told;
        }
        for sample in 0..other.len() {
            let at = if is_whole { Some(sample) } else { by_time.get(&other.time[sample].to_bits()).copied() };
            let Some(at) = at else { return Difference::Silent };
            let pairs = own.iter().zip(&theirs).map(|(own, theirs)| (own[at], theirs[sample]));
            largest = pairs
                .clone()
                .zip(&scales)
                .fold(largest, |far, ((one, other), scale)| far.max((one - other).abs() / scale));
            largest = largest.max((run.time[at] - other.time[sample]).abs() / run.time_step());
            is_same &= pairs.into_iter().all(|(one, other)| one == other) && run.time[at] == other.time[sample];
        }
    }
    match () {
        () if is_same => Difference::None,
        () if largest > NOISE || largest.is_nan() => Difference::Silent,
        () if is_whole => Difference::InNoise,
        () => Difference::SilentlyShorter,
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt().max(f64::MIN_POSITIVE)
}

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let (recordings, cases) = (5, bench.cases(300, 4500));
    let mut files = Vec::new();
    for number in 0..recordings {
        files.extend(seeds::files(&seeds::recording(bench.effort.seed + number as u64)?, number)?);
    }
    let mut opener = Opener::new(&bench.program);
    let mut score = Score { cases, ..Score::default() };
    for seed in &files {
        let path = written(bench, &seed.name, &seed.files)?;
        let answer = opener.open(&Request { kind: Kind::Log, path, clean: None })?;
        score.demand(matches!(answer.opened, Opened::Accepted(_)), || format!("{}: {:?}", seed.name, answer.opened));
    }
    for case in 0..cases {
        bench.report(case, cases, "damaged logs")?;
        let seed = &files[case % files.len()];
        let mut random = bench.random(case);
        let mut damaged = seed.files.clone();
        let which = random.random_range(0..damaged.len());
        let (part, bytes) = &mut damaged[which];
        *bytes = damage(bytes, &mut random);
        let kept = (format!("{case}-{part}"), bytes.clone());
        let path = written(bench, &format!("damaged-{}", seed.name), &damaged)?;
        let answer = opener.open(&Request { kind: Kind::Log, path, clean: Some(bench.path(&seed.name)) })?;
        let name = format!("case {case} ({})", seed.name);
        let before = score.broken.len();
        let size = damaged.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        survived(&mut score, &name, &answer, size, seed.size());
        let is_silent = matches!(answer.opened, Opened::Accepted(Difference::Silent | Difference::SilentlyShorter));
        if is_silent || score.broken.len() > before {
            bench.keep(&kept.0, &kept.1)?;
        }
    }
    let silent = score.of("silently other") + score.of("silently shorter");
    score.demand(silent as f64 <= MOST_SILENT * cases as f64, || format!("{silent} of {cases} were read in silence"));
    Ok(score)
}

/// Writes the files of a log, and says where it is.
fn written(bench: &Bench, name: &str, files: &[(String, Vec<u8>)]) -> std::io::Result<PathBuf> {
    let path = bench.path(name);
    match files {
        [(_, bytes)] => file::write(&path, bytes)?,
        several => {
            std::fs::create_dir_all(&path)?;
            for (part, bytes) in several {
                file::write(&path.join(part), bytes)?;
            }
        }
    }
    Ok(path)
}

/// Counts an answer, and demands that it came in time and within memory. Numbers that are kept may take what the largest of the
/// files that lead to them has.
pub fn survived(score: &mut Score, name: &str, answer: &Answer, size: u64, kept: u64) {
    score.count(match &answer.opened {
        Opened::Accepted(Difference::None) => "as before",
        Opened::Accepted(Difference::InNoise) => "inside the noise",
        Opened::Accepted(Difference::Told) => "told",
        Opened::Accepted(Difference::Silent) => "silently other",
        Opened::Accepted(Difference::SilentlyShorter) => "silently shorter",
        Opened::Refused(_) => "refused",
        Opened::Broke(_) | Opened::Hung | Opened::Died => "broken",
    });
    let is_sound = matches!(answer.opened, Opened::Accepted(_) | Opened::Refused(_));
    score.demand(is_sound, || format!("{name}: {:?}", answer.opened));
    score.demand(answer.seconds <= LONGEST_S, || format!("{name}: {:.1} s", answer.seconds));
    let most = LEAST_MEMORY.max(4 * size) + 16 * kept;
    let memory = answer.memory.unwrap_or(0);
    score.demand(memory <= most, || format!("{name}: {} MiB for {size} bytes", memory >> 20));
}
