//! Hours of clicks, training and loading in one window: its memory does not grow, nothing panics, and frames stay as short as they were.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::window::{Said, Task};
use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::file;
use crate::recording::write::to_npz_bytes;

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "endurance",
    promise: "random clicks and keys, trainings and recordings in one window without a display, half a minute or two hours: no panic; \
              in its last quarter the slowest frame of a hundred takes at most half as long again as in its second, or 1/60 s, and in \
              two hours memory grows by at most 5 % from the one to the other",
    take,
};

/// How long a window is worked in \[s\].
const SHORT: u64 = 30;
const LONG: u64 = 7200;
/// How much the memory may grow.
const GROWTH: f64 = 1.05;
/// How much longer the slowest frame of a hundred may take, and the time that no screen is faster than \[ms\].
const SLOWER: f64 = 1.5;
const REFRESH_MS: f64 = 1000.0 / 60.0;

/// What a quarter of the time was like.
struct Quarter {
    memory: Option<f64>,
    p99_ms: f64,
}

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let recording = seeds::recording(bench.effort.seed)?;
    let bytes = to_npz_bytes(&recording).map_err(|error| SelftestError::making("a recording")(&error))?;
    let log = bench.path("log.npz");
    file::write(&log, &bytes)?;
    let length = Duration::from_secs(if bench.effort.long { LONG } else { SHORT });
    let rounds = rounds(bench, &Task::Endure { log, seed: bench.effort.seed }, length)?;
    let mut score = Score { cases: rounds.len(), ..Score::default() };
    let (has_lived, panics) = match rounds.last() {
        Some((at, Said::Round { panics, .. })) => (*at >= 0.9 * length.as_secs_f64(), *panics),
        _ => (false, 0),
    };
    score.demand(has_lived, || "the window ended before its time".to_owned());
    score.counts.insert("panics".to_owned(), panics);
    score.demand(panics == 0, || format!("{panics} panics"));
    let quarters = quarters(&rounds, length);
    for (number, quarter) in quarters.iter().enumerate() {
        let name = |what: &str| format!("quarter {}: {what}", number + 1);
        if let Some(memory) = quarter.memory {
            score.counts.insert(name("memory [MiB]"), (memory / f64::from(1 << 20)).round() as usize);
        }
        score.counts.insert(name("slowest frame of a hundred [µs]"), (1000.0 * quarter.p99_ms).round() as usize);
    }
    let (Some(second), Some(last)) = (quarters.get(1), quarters.get(3)) else {
        score.left_out.push("memory and frames: too few rounds were done to compare quarters".to_owned());
        return Ok(score);
    };
    match second.memory.zip(last.memory) {
        _ if !bench.effort.long => {
            score
                .left_out
                .push("growth of memory: half a minute is over before undo holds its hundred steps".to_owned());
        }
        Some((before, after)) => score.demand(after <= GROWTH * before, || {
            format!("memory grew by {:.1} % from the second quarter to the last", 100.0 * (after / before - 1.0))
        }),
        None => score.left_out.push("memory: this system does not tell it".to_owned()),
    }
    let longest = REFRESH_MS.max(SLOWER * second.p99_ms);
    score.demand(last.p99_ms <= longest, || {
        format!(
            "the slowest frame of a hundred took {:.1} ms at first and {:.1} ms in the end",
            second.p99_ms, last.p99_ms
        )
    });
    Ok(score)
}

/// A window at work that ends with whoever started it.
struct Worker(Child);

impl Drop for Worker {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Every round of a window that is worked in for so long, and when it ended \[s since the begin\].
fn rounds(bench: &Bench, task: &Task, length: Duration) -> Result<Vec<(f64, Said)>, SelftestError> {
    let task = serde_json::to_string(task).map_err(std::io::Error::from)?;
    let mut command = Command::new(&bench.program);
    command.args(["selftest", "--window", &task]).current_dir(bench.folder);
    let mut worker = Worker(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn()?);
    let output = worker.0.stdout.take().ok_or_else(|| std::io::Error::other("the process has no pipe"))?;
    let begin = Instant::now();
    let mut rounds = Vec::new();
    for line in BufReader::new(output).lines() {
        rounds.push((begin.elapsed().as_secs_f64(), serde_json::from_str(&line?).map_err(std::io::Error::from)?));
        let done = (begin.elapsed().as_secs_f64() / length.as_secs_f64()).min(1.0);
        bench.monitor.report(done as f32, &format!("{} rounds in one window", rounds.len()))?;
        if begin.elapsed() >= length || rounds.len() >= bench.effort.most.unwrap_or(usize::MAX) {
            break;
        }
    }
    Ok(rounds)
}

/// The rounds by quarters of the time, as long as each has some.
fn quarters(rounds: &[(f64, Said)], length: Duration) -> Vec<Quarter> {
    let quarter_of = |at: f64| ((4.0 * at / length.as_secs_f64()) as usize).min(3);
    let quarter = |number: usize| {
        let (mut frames, mut memories) = (Vec::new(), Vec::new());
        for (_, said) in rounds.iter().filter(|(at, _)| quarter_of(*at) == number) {
            if let Said::Round { frames_ms, memory, .. } = said {
                frames.extend(frames_ms.iter().map(|ms| f64::from(*ms)));
                memories.extend(memory.map(|bytes| bytes as f64));
            }
        }
        frames.sort_by(f64::total_cmp);
        memories.sort_by(f64::total_cmp);
        let p99_ms = *frames.get((frames.len().checked_sub(1)? as f64 * 0.99).round() as usize)?;
        Some(Quarter { memory: memories.get(memories.len() / 2).copied(), p99_ms })
    };
    (0..4).map_while(quarter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_are_told_by_their_middle_and_their_slow_frames() {
        let round = |at: f64, ms: f32, mib: u64| {
            (at, Said::Round { frames_ms: vec![1.0, ms], memory: Some(mib << 20), panics: 0 })
        };
        let rounds =
            [round(1.0, 2.0, 10), round(3.0, 3.0, 20), round(3.5, 9.0, 90), round(3.9, 4.0, 30), round(5.0, 5.0, 7)];
        let quarters = quarters(&rounds, Duration::from_secs(8));
        assert_eq!(quarters.len(), 3, "the last has none");
        assert_eq!((quarters[1].memory, quarters[1].p99_ms), (Some(f64::from(30 << 20)), 9.0));
    }
}
