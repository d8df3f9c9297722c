//! Rows that say again what the row before them said: a logger that asks faster than the robot answers, or by a clock of its own, writes
//! the last answer anew. They hold no reading of their moment, so nothing is to be learned from them; and an answer is as old as it
//! happened to be when it was asked for, so that its time is off by up to one row.
//!
//! That all channels are the same is no proof, since an arm may rest, or creep between two counts of its encoder. But between two answers
//! in which a joint went several counts, the same way and not much more slowly than usual, it did not stand still. And a robot whose
//! answers lie on a line over their number, but for less than the time between two questions, answers by an even clock.

use std::ops::Range;

use crate::recording::check::GAP_STEPS;
use crate::recording::differentiate::median_step;
use crate::signals::Signals;
use crate::statistics::median;

/// A joint that goes so many of its smallest steps from row to row is no encoder that counts on now and then,
const COUNTS: f64 = 4.0;
/// and one that goes this share of its usual step does not start or stop there.
const SHARE: f64 = 0.1;

/// Nearly all answers came within so many times that between two questions, if the robot answered evenly: once, and the jitter of both.
const WITHIN: f64 = 1.5;
/// So many of a thousand on either side are not among nearly all.
const OUTSIDE: usize = 5;
/// No line is drawn through fewer answers than these.
const FEWEST: usize = 20;
/// Who asks so many times as often as there are answers knows well enough when each was made.
const OFTEN: f64 = 5.0;

/// The rows that repeat the one before them, of a log with these runs: positions of all joints, and all that else was measured.
pub(super) fn find(runs: &[Range<usize>], q: &Signals, others: &[&Signals]) -> Vec<usize> {
    let inside = |run: &Range<usize>| {
        let (begin, end) = (run.start, run.end);
        stretches(run, q, others).into_iter().filter(move |rows| begin < rows.start && rows.end < end)
    };
    let equal: Vec<Range<usize>> = runs.iter().flat_map(inside).collect();
    // Nearly all logs have none, and need not be looked at any more.
    if equal.is_empty() {
        return Vec::new();
    }
    let joints: Vec<Joint> = q.iter().filter_map(|q| Joint::of(runs, q)).collect();
    let motion = |rows: &Range<usize>| joints.iter().map(|joint| joint.over(rows)).max().unwrap_or(Motion::Unclear);
    let equal: Vec<(Range<usize>, Motion)> = equal.into_iter().map(|rows| (rows.clone(), motion(&rows))).collect();
    let moving = equal.iter().filter(|(_, motion)| *motion == Motion::OneWay);
    let Some(usual) = median(moving.map(|(rows, _)| rows.len() as f64).collect()) else { return Vec::new() };
    let is_one_answer = |(rows, motion): &(Range<usize>, Motion)| match motion {
        Motion::OneWay => true,
        // Where the arm turns round, an answer was written as often as elsewhere; what is longer is a rest.
        Motion::Turning => rows.len() as f64 <= usual + 1.0,
        Motion::Unclear => false,
    };
    equal.into_iter().filter(is_one_answer).flat_map(|(rows, _)| rows.skip(1)).collect()
}

/// What a joint does over rows that are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Motion {
    /// It may stand, or creep from count to count.
    Unclear,
    /// It goes some counts before and some behind, but slowly, or back.
    Turning,
    /// It comes and goes the same way, and fast: it can't have stood still.
    OneWay,
}

/// When answers were made \[s\].
#[derive(Debug, PartialEq)]
pub(super) enum Times {
    /// By an even clock, at these times.
    Even(Vec<f64>),
    /// As long before they were written as was asked at most, which is soon.
    AsWritten,
    /// At any time between two questions.
    Unknown,
}

/// When the answers were made that were written at these times, in these runs, by somebody who asked every so many seconds.
pub(super) fn times(runs: &[Range<usize>], written: &[f64], every_s: f64) -> Times {
    match even_times(runs, written, every_s) {
        Some(times) => Times::Even(times),
        None if OFTEN * every_s < median_step(written) => Times::AsWritten,
        None => Times::Unknown,
    }
}

/// The times of a robot that answers evenly; `None` if it did not.
fn even_times(runs: &[Range<usize>], written: &[f64], every_s: f64) -> Option<Vec<f64>> {
    let mut times = written.to_vec();
    for run in runs {
        let longest = GAP_STEPS * median_step(&written[run.clone()]);
        let mut begin = run.start;
        for end in run.start + 1..=run.end {
            if end == run.end || written[end] - written[end - 1] > longest {
                if end - begin >= FEWEST {
                    straighten(&mut times[begin..end], every_s)?;
                }
                begin = end;
            }
        }
        if times[run.clone()].windows(2).any(|pair| pair[1] <= pair[0]) {
            return None;
        }
    }
    Some(times)
}

/// Puts times on a line over their number; what is far from it comes as near as nearly all are.
fn straighten(times: &mut [f64], every_s: f64) -> Option<()> {
    let middle = 0.5 * (times.len() - 1) as f64;
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let [mut moment, mut squares] = [0.0; 2];
    for (number, time) in times.iter().enumerate() {
        let from_middle = number as f64 - middle;
        moment += from_middle * (time - mean);
        squares += from_middle * from_middle;
    }
    let on_line = |number: usize| mean + moment / squares * (number as f64 - middle);
    let late: Vec<f64> = times.iter().enumerate().map(|(number, time)| time - on_line(number)).collect();
    let mut sorted = late.clone();
    sorted.sort_by(f64::total_cmp);
    let few = sorted.len() * OUTSIDE / 1000;
    let [earliest, latest] = [sorted[few], sorted[sorted.len() - 1 - few]];
    // Of a clock with holes nothing is known.
    let spare = WITHIN * every_s - (latest - earliest);
    (spare >= 0.0).then(|| {
        let [earliest, latest] = [earliest - 0.5 * spare, latest + 0.5 * spare];
        for (number, (time, late)) in times.iter_mut().zip(late).enumerate() {
            *time = on_line(number) + late - late.clamp(earliest, latest);
        }
    })
}

/// Rows of a run, two or more, in which all channels are the same.
fn stretches(run: &Range<usize>, q: &Signals, others: &[&Signals]) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    let is_same = |row: usize| {
        let mut channels = q.iter().chain(others.iter().flat_map(|signal| signal.iter()));
        channels.all(|channel| channel[row] == channel[row - 1])
    };
    for row in (run.start + 1..run.end).filter(|row| is_same(*row)) {
        match stretches.last_mut() {
            Some(last) if last.end == row => last.end = row + 1,
            _ => stretches.push(row - 1..row + 1),
        }
    }
    stretches
}

/// The positions of a joint.
struct Joint<'a> {
    q: &'a [f64],
    /// Less than this from row to row are single counts.
    some_counts: f64,
    /// From this on it is fast.
    fast: f64,
}

impl Joint<'_> {
    /// `None` if it never moves.
    fn of<'a>(runs: &[Range<usize>], q: &'a [f64]) -> Option<Joint<'a>> {
        let steps = runs.iter().flat_map(|run| q[run.clone()].windows(2)).map(|pair| (pair[1] - pair[0]).abs());
        let steps: Vec<f64> = steps.filter(|step| *step > 0.0 && step.is_finite()).collect();
        let count = steps.iter().copied().reduce(f64::min)?;
        Some(Joint { q, some_counts: COUNTS * count, fast: SHARE * median(steps)? })
    }

    /// What it does over rows that are the same, and have others before and behind.
    fn over(&self, rows: &Range<usize>) -> Motion {
        let (before, behind) = (self.q[rows.start] - self.q[rows.start - 1], self.q[rows.end] - self.q[rows.start]);
        let least = before.abs().min(behind.abs());
        match least >= self.some_counts {
            true if before * behind > 0.0 && least >= self.fast => Motion::OneWay,
            true => Motion::Turning,
            false => Motion::Unclear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.01;
    const NONE: [usize; 0] = [];

    /// A log of one run.
    fn whole(rows: usize) -> Vec<Range<usize>> {
        std::iter::once(0..rows).collect()
    }

    /// What a robot answers that swings and has a rest of a second in the middle, with the counts of an encoder if one is given.
    fn answers(count: Option<f64>) -> [Signals; 2] {
        let angle = |time: f64| {
            let swung = match time {
                ..3.5 => time,
                ..4.0 => 3.75 - (4.0 - time).powi(2),
                ..5.0 => 3.75,
                ..5.5 => 3.75 + (time - 5.0).powi(2),
                _ => time - 1.5,
            };
            let q = (0.7 * swung).sin() + 0.3 * (2.3 * swung).sin();
            count.map_or(q, |count| (q / count).round() * count)
        };
        let q = Signals::from_fn(1, 1000, |_, row| angle(PERIOD_S * row as f64));
        let tau = Signals::from_fn(1, 1000, |_, row| (2.0 * q[0][row]).cos());
        [q, tau]
    }

    /// The answers as somebody writes them who asks every so many seconds, and which of these are new.
    fn asked(answers: &[Signals; 2], every_s: f64) -> ([Signals; 2], Vec<bool>) {
        let rows = (9.99 / every_s) as usize;
        let last = |row: usize| (row as f64 * every_s / PERIOD_S + 1e-6) as usize;
        let written = answers.clone().map(|channel| Signals::from_fn(1, rows, |_, row| channel[0][last(row)]));
        (written, (0..rows).map(|row| row == 0 || last(row) != last(row - 1)).collect())
    }

    #[test]
    fn answers_that_are_written_again_are_found() {
        for count in [None, Some(1e-4)] {
            for every_s in [PERIOD_S / 1.02, PERIOD_S / 1.3, PERIOD_S / 3.0, PERIOD_S / 20.0] {
                let ([q, tau], is_new) = asked(&answers(count), every_s);
                let found = find(&whole(q.sample_count()), &q, &[&tau]);
                assert!(!found.is_empty());
                assert!(found.iter().all(|row| !is_new[*row]), "{count:?}, {every_s}");
                // While the arm rests, and from count to count, a new answer may be the old one.
                let moves = |row: &usize| !(3.4..5.6).contains(&(*row as f64 * every_s));
                let expected: Vec<usize> = (0..is_new.len()).filter(|row| !is_new[*row]).filter(moves).collect();
                let missed = expected.iter().filter(|row| found.binary_search(row).is_err()).count();
                assert!(missed * 10 <= expected.len() + 10, "{count:?}, {every_s}: {missed} of {}", expected.len());
            }
        }
    }

    #[test]
    fn answers_of_an_even_clock_get_its_times() {
        for every_s in [PERIOD_S / 1.02, PERIOD_S / 1.3, PERIOD_S / 3.0] {
            let (_, is_new) = asked(&answers(None), every_s);
            let mut written: Vec<f64> =
                (0..is_new.len()).filter(|row| is_new[*row]).map(|row| every_s * row as f64).collect();
            // One answer was written late, and half a minute of answers was not written at all.
            written[30] += 1.5 * every_s;
            written[500..].iter_mut().for_each(|time| *time += 30.0);
            let runs = [0..200, 200..written.len()];
            let Times::Even(even) = times(&runs, &written, every_s) else { panic!("an even clock") };
            let off = |(row, time): (usize, &f64)| {
                let answered = PERIOD_S * row as f64 + if row < 500 { 0.0 } else { 30.0 };
                // Each is half a question late on average; what is the same for all of a run says nothing.
                (time - answered - 0.5 * every_s).abs() / every_s
            };
            let worst = even.iter().enumerate().filter(|(row, _)| *row != 30).map(off).fold(0.0, f64::max);
            assert!(worst < 0.55, "{every_s}: {worst}");
            let steps = even[200..500].windows(2).map(|pair| (pair[1] - pair[0] - PERIOD_S).abs() / PERIOD_S);
            assert!(steps.fold(0.0, f64::max) < 0.01);
            // A robot that rested for some questions, and one that answers as it likes.
            written[700..].iter_mut().for_each(|time| *time += 3.0 * PERIOD_S);
            assert_eq!(times(&runs, &written, every_s), Times::Unknown);
            assert_eq!(times(&runs, &written, every_s / 20.0), Times::AsWritten);
        }
        let few = vec![0.0, 0.1, 0.5];
        assert_eq!(times(&whole(3), &few, 0.1), Times::Even(few.clone()), "too few for a line");
    }

    #[test]
    fn rests_coarse_encoders_and_other_runs_are_left_in_peace() {
        for count in [None, Some(1e-4), Some(0.01)] {
            let [q, tau] = answers(count);
            assert_eq!(find(&whole(1000), &q, &[&tau]), NONE, "{count:?}");
        }
        // The torque of the second row is another one.
        let ([q, mut tau], _) = asked(&answers(None), PERIOD_S / 3.0);
        tau[0].iter_mut().enumerate().for_each(|(row, tau)| *tau += 1e-9 * row as f64);
        assert_eq!(find(&whole(q.sample_count()), &q, &[&tau]), NONE);
        let [q, tau] = [[0.0, 0.1, 0.2, 0.2, 0.3, 0.4, 0.45], [0.0; 7]].map(|row| Signals::from_joints([row]).unwrap());
        assert_eq!(find(&[0..3, 3..7], &q, &[&tau]), NONE, "the second run begins where the first one ended");
    }
}
