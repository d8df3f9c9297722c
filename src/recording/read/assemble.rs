//! From a table and a mapping to trajectories: convert units, cut at gaps and missing values, derive what is missing.
//!
//! Nothing is mended in silence. Rows that can't be used are left out by cutting the trajectory there, which a finding
//! says with its count; a clock that stands still or goes back is an error, since no treatment of it would be honest.

use std::ops::Range;

use super::clocks::Told;
use super::repeats::{self, Times};
use super::table::{Table, listed};
use super::{ReadError, ReadOptions};
use crate::progress::Monitor;
use crate::recording::check::GAP_STEPS;
use crate::recording::differentiate::{
    Smoothing, default_cutoff, default_cutoff_of_positions, median_step, trusted_range,
};
use crate::recording::finding::{Finding, FindingKind, Place, Severity};
use crate::recording::mapping::{Channel, Mapping, MappingSpec, Unit, split_unit};
use crate::recording::transform::Factor;
use crate::recording::{Channels, JointKind, RecordingError, Trajectory};
use crate::signals::{ShapeError, Signals};
use crate::statistics::median;

/// Shorter stretches between two cuts are left out.
const SHORTEST_STRETCH: usize = 10;
/// Fewer samples have no second derivative.
const SHORTEST_RUN: usize = 3;

/// What one file gives.
pub(super) struct Assembled {
    pub trajectories: Vec<Trajectory>,
    pub findings: Vec<Finding>,
    /// Cut-offs of the filter for derived channels \[Hz\].
    pub cutoffs: Vec<f64>,
    pub kinds: Vec<JointKind>,
}

/// The channels of a table in SI units, all rows.
struct Converted {
    time: Vec<f64>,
    q: Signals,
    qd: Option<Signals>,
    qdd: Option<Signals>,
    /// Or the command of the drive that it follows from.
    tau: Signals,
}

/// `file` is the name for messages, `stem` the one for trajectories.
pub(super) fn assemble(
    mut table: Table,
    mapping: &Mapping,
    file: &str,
    stem: &str,
    options: &ReadOptions,
    monitor: &Monitor,
) -> Result<Assembled, ReadError> {
    let spec = options.mapping.clone().unwrap_or_default();
    let mut findings = passed_over(&table, &spec, file);
    findings.extend(table.broken_off.iter().map(|place| broken_off(place, file)));
    findings.extend(shortened(&table, file));
    findings.extend(table.clocks.iter().map(|told| clocks(told, file)));
    let mut channels = convert(&mut table, mapping, &spec, file, options, &mut findings)?;
    check_clock(&table, &channels.time, file)?;

    findings.extend(leave_out_repeats(&mut channels, &mut table, file));
    let usable = usable_rows(&channels);
    let left_out = usable.iter().filter(|usable| !**usable).count();
    if left_out > 0 {
        let first = usable.iter().position(|usable| !usable).unwrap_or_default();
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::NonFinite,
            what: format!(
                "{left_out} of {} samples have no finite value in a used channel (first: {}) and were left out; \
                 trajectories are cut there.",
                usable.len(),
                table.place(first)
            ),
            place: Place::file(file),
            remedy: "Nothing was filled in; find out why the values are missing.".to_owned(),
            set_right: Vec::new(),
        });
    }
    let stretches = stretches(&table, &channels.time, &usable, file, &mut findings);
    if stretches.is_empty() {
        return Err(ReadError::NothingLeft { file: file.to_owned(), run: SHORTEST_RUN, piece: SHORTEST_STRETCH });
    }

    let mut trajectories = Vec::new();
    let mut cutoffs = Vec::new();
    let several = stretches.len() > 1;
    for (index, rows) in stretches.iter().enumerate() {
        monitor.check()?;
        let name = match table.run_name(rows.start) {
            Some(run) if stretches.len() == table.runs.len() => format!("{stem}#{run}"),
            _ if several => format!("{stem}#{}", index + 1),
            _ => stem.to_owned(),
        };
        let (trajectory, cutoff) = derive(&mut channels, rows.clone(), name, options).map_err(RecordingError::from)?;
        trajectories.push(trajectory);
        cutoffs.push(cutoff);
    }
    let stated = |name: &String| split_unit(name).1.and_then(|unit| unit.kind);
    let kinds = mapping.q.iter().map(|name| spec.kind.or_else(|| stated(name)).unwrap_or_default()).collect();
    Ok(Assembled { trajectories, findings, cutoffs, kinds })
}

fn passed_over(table: &Table, spec: &MappingSpec, file: &str) -> Vec<Finding> {
    let used = |name: &String| {
        spec.transforms.values().any(|transform| transform.factor == Some(Factor::Constant(name.clone())))
    };
    let constants: Vec<&str> = table.constants.keys().filter(|name| !used(name)).map(String::as_str).collect();
    let mut parts = table.passed_over.clone();
    if !constants.is_empty() {
        parts.push(format!("constants, which a mapping file may name as factors: {}", constants.join(", ")));
    }
    if parts.is_empty() {
        return Vec::new();
    }
    vec![Finding {
        severity: Severity::Info,
        kind: FindingKind::PassedOver,
        what: format!("passed over: {}.", listed(&parts)),
        place: Place::file(file),
        remedy: String::new(),
        set_right: Vec::new(),
    }]
}

fn broken_off(place: &str, file: &str) -> Finding {
    Finding {
        severity: Severity::Info,
        kind: FindingKind::BrokenOff,
        what: format!(
            "{place}, the last one, has no line end: if the file was broken off there, its last number is cut."
        ),
        place: Place::file(file),
        remedy: "Delete that line if the recorder or a copy was broken off.".to_owned(),
        set_right: Vec::new(),
    }
}

fn shortened(table: &Table, file: &str) -> Option<Finding> {
    let names: Vec<String> = table.shortened.iter().map(|name| format!("`{name}`")).collect();
    (!names.is_empty()).then(|| Finding {
        severity: Severity::Warning,
        kind: FindingKind::PassedOver,
        what: format!("the last row of {} was left out: the others have one less.", names.join(", ")),
        place: Place::file(file),
        remedy:
            "If the first rows are not of the same moment, delete the row that is too many and read the files again."
                .to_owned(),
        set_right: Vec::new(),
    })
}

fn clocks(told: &Told, file: &str) -> Finding {
    let remedy = "If they are known to agree, record both on one topic, or put them side by side with their own times.";
    Finding {
        severity: if told.is_moved { Severity::Warning } else { Severity::Info },
        kind: FindingKind::Clocks,
        what: format!("{}.", told.what),
        place: Place::file(file),
        remedy: if told.is_moved { remedy } else { "" }.to_owned(),
        set_right: Vec::new(),
    }
}

/// Takes the columns that the mapping names out of the table; the others are let go, so that the numbers are there once.
fn convert(
    table: &mut Table,
    mapping: &Mapping,
    spec: &MappingSpec,
    file: &str,
    options: &ReadOptions,
    findings: &mut Vec<Finding>,
) -> Result<Converted, ReadError> {
    let mut converted = Vec::new();
    let used: Vec<&String> = mapping.used().collect();
    for column in &mut table.columns {
        if !used.contains(&&column.name) {
            column.values = Vec::new();
        }
    }
    // A number of a channel is in the units of that channel, but a command is in those of what it commands.
    let drive = spec.drive.as_ref();
    let units_of = |channel| match (channel, drive) {
        (Channel::Torque, Some(drive)) => drive.command(),
        _ => Some(channel),
    };
    let mut column = |table: &mut Table, channel: Channel, name: &String| -> Result<Vec<f64>, ReadError> {
        let file = || file.to_owned();
        let found =
            table.column_mut(name).ok_or_else(|| ReadError::MissingColumn { file: file(), column: name.clone() })?;
        if let Some(text) = &found.text {
            let (line, column, cell) = (text.line, name.clone(), text.cell.chars().take(40).collect());
            return Err(ReadError::Text { file: file(), line, column, cell });
        }
        if !found.values.iter().any(|value| value.is_finite()) {
            return Err(ReadError::NoValues { file: file(), column: name.clone() });
        }
        let is_used_once = used.iter().filter(|other| **other == name).count() == 1;
        let mut values = if is_used_once { std::mem::take(&mut found.values) } else { found.values.clone() };
        let is_of = |channel| move |unit: &Unit| unit.factor != 1.0 && unit.channels.contains(&channel);
        if let Some(unit) = units_of(channel).and_then(|channel| split_unit(name).1.filter(is_of(channel))) {
            converted.push(format!("`{name}` from {}", unit.text));
            values.iter_mut().for_each(|value| *value *= unit.factor);
        }
        Ok(values)
    };
    let mut joints = |channel, names: &Vec<String>| {
        let numbers = names.iter().map(|name| column(table, channel, name)).collect::<Result<Vec<_>, _>>()?;
        let numbers = Signals::from_joints(numbers).map_err(RecordingError::from)?;
        let Some(transform) = spec.transforms.get(&channel) else { return Ok(numbers) };
        let wrong = |problem| ReadError::Transform { file: file.to_owned(), channel, problem };
        transform.apply(numbers, &table.constants).map_err(wrong)
    };
    let q = joints(Channel::Position, &mapping.q)?;
    let tau = joints(Channel::Torque, &mapping.tau)?;
    let qd = mapping.qd.as_ref().map(|names| joints(Channel::Velocity, names)).transpose()?;
    let qdd = mapping.qdd.as_ref().map(|names| joints(Channel::Acceleration, names)).transpose()?;
    let stated = options.rate_hz.or(spec.rate_hz).map(f64::recip).or(table.step);
    let time = match &mapping.time {
        Some(name) => {
            let mut time = column(table, Channel::Time, name)?;
            let unsaid = split_unit(name).1.is_none();
            let unit = qd.as_ref().filter(|_| unsaid).and_then(|qd| unit_of_clock(table, &time, &q, qd));
            if let Some((second, unit)) = unit {
                time.iter_mut().for_each(|value| *value *= second);
                findings.push(clock_converted(name, unit, file));
            }
            time
        }
        None => {
            let no_time = || ReadError::NoTime { file: file.to_owned(), columns: table.names().join(", ") };
            let of_motion = || qd.as_ref().and_then(|qd| step_of_motion(table, &q, qd));
            let step = stated.or_else(of_motion).ok_or_else(no_time)?;
            if stated.is_none() {
                findings.push(rate_of_motion(step, file));
            }
            table.runs.iter().flat_map(|run| (0..run.len()).map(move |sample| sample as f64 * step)).collect()
        }
    };
    if let (Some(name), Some(rate)) = (&mapping.time, options.rate_hz) {
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::PassedOver,
            what: format!("the stated rate of {rate} Hz was not used, since `{name}` holds the time."),
            place: Place::file(file),
            remedy: "To use the rate instead, map `time=-`.".to_owned(),
            set_right: Vec::new(),
        });
    }
    let titled = |channel: Channel| match (channel, drive) {
        (Channel::Torque, Some(_)) => "the command",
        _ => channel.title(),
    };
    for (channel, transform) in &spec.transforms {
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::Converted,
            what: format!("{} is {}, as the mapping says.", titled(*channel), transform.describe()),
            place: Place::file(file),
            remedy: String::new(),
            set_right: Vec::new(),
        });
    }
    if !converted.is_empty() {
        findings.push(Finding {
            severity: Severity::Info,
            kind: FindingKind::Converted,
            what: format!("converted to SI units, as the names of the columns say: {}.", converted.join(", ")),
            place: Place::file(file),
            remedy: String::new(),
            set_right: Vec::new(),
        });
    }
    Ok(Converted { time, q, qd, qdd, tau })
}

/// Share of the steps of q that q̇ must explain for the time between them to follow.
const CLEAR: f64 = 0.9;

/// The time between rows \[s\] by which q grows as q̇ says; `None` if it does not.
fn step_of_motion(table: &Table, q: &Signals, qd: &Signals) -> Option<f64> {
    let (mut product, mut steps, mut speeds) = (0.0, 0.0, 0.0);
    for run in &table.runs {
        for (q, qd) in q.iter().zip(qd) {
            for row in run.start..run.end.saturating_sub(1) {
                let (step, speed) = (q[row + 1] - q[row], 0.5 * (qd[row] + qd[row + 1]));
                if step.is_finite() && speed.is_finite() {
                    product += step * speed;
                    steps += step * step;
                    speeds += speed * speed;
                }
            }
        }
    }
    let step = product / speeds;
    (step > 0.0 && product * product > CLEAR * steps * speeds).then_some(step)
}

/// Units in which loggers count time, without saying so: how many seconds, and its name.
const CLOCKS: [(f64, &str); 3] = [(1e-3, "milliseconds"), (1e-6, "microseconds"), (1e-9, "nanoseconds")];
/// No log of a moving robot has steps of as many seconds,
const LEAST_ODD_STEP: f64 = 0.1;
/// and its clock agrees with q and q̇ within this factor.
const SAME_STEP: f64 = 1.05;

/// The unit of a clock that can't be in seconds, if it is clear from the motion.
fn unit_of_clock(table: &Table, time: &[f64], q: &Signals, qd: &Signals) -> Option<(f64, &'static str)> {
    let steps = table.runs.iter().flat_map(|run| time[run.clone()].windows(2)).map(|pair| pair[1] - pair[0]);
    let step = median(steps.filter(|step| step.is_finite()).collect()).filter(|step| *step >= LEAST_ODD_STEP)?;
    let of_motion = step_of_motion(table, q, qd)?;
    let agrees = |factor: f64| (1.0 / SAME_STEP..SAME_STEP).contains(&(step * factor / of_motion));
    CLOCKS.into_iter().find(|(second, _)| agrees(*second))
}

fn clock_converted(name: &str, unit: &str, file: &str) -> Finding {
    Finding {
        severity: Severity::Info,
        kind: FindingKind::TimeUnit,
        what: format!("the time in `{name}` is in {unit}, by how q and q̇ change; it was converted to seconds."),
        place: Place::file(file),
        remedy: "If it is in seconds, name it so (`time[s]`), and look at the units of q̇.".to_owned(),
        set_right: Vec::new(),
    }
}

fn rate_of_motion(step: f64, file: &str) -> Finding {
    Finding {
        severity: Severity::Warning,
        kind: FindingKind::TimeUnit,
        what: format!("there is no clock; the rate of {:.1} Hz follows from q and q̇.", step.recip()),
        place: Place::file(file),
        remedy: "State the sampling rate in Hz (`--rate`) if you know it: it is exact then.".to_owned(),
        set_right: Vec::new(),
    }
}

fn check_clock(table: &Table, time: &[f64], file: &str) -> Result<(), ReadError> {
    for run in &table.runs {
        let mut before: Option<f64> = None;
        for row in run.clone() {
            let now = time[row];
            if let Some(before) = before.filter(|before| now <= *before) {
                return Err(ReadError::Clock { file: file.to_owned(), place: table.place(row), before, now });
            }
            before = if now.is_finite() { Some(now) } else { before };
        }
    }
    Ok(())
}

/// Leaves out rows that hold what the row before them held although the arm moved, if it is known when the others were made: by an even
/// clock, whose times they get, or soon before they were written.
fn leave_out_repeats(channels: &mut Converted, table: &mut Table, file: &str) -> Option<Finding> {
    let Converted { time, q, qd, qdd, tau } = channels;
    let others: Vec<&Signals> = [qd.as_ref(), qdd.as_ref(), Some(&*tau)].into_iter().flatten().collect();
    let repeated = repeats::find(&table.runs, q, &others);
    let first = *repeated.first()?;
    let rows = time.len();
    let mut finding = Finding {
        severity: Severity::Warning,
        kind: FindingKind::Repeated,
        what: format!(
            "{} of {rows} samples repeat the one before them in every channel while the arm moves (first: {}): there was \
             nothing newer to be written.",
            repeated.len(),
            table.place(first)
        ),
        place: Place::file(file),
        remedy: "Write each reading once, with the clock of whoever made it.".to_owned(),
        set_right: Vec::new(),
    };
    let mut is_repeated = vec![false; rows];
    repeated.iter().for_each(|row| is_repeated[*row] = true);
    let others = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(&is_repeated).filter(|(_, is_repeated)| !**is_repeated).map(|(value, _)| *value).collect()
    };
    let written = others(time);
    let (times, told) = match repeats::times(&table.runs_without(&repeated), &written, median_step(time)) {
        Times::Even(times) => {
            let rate = median_step(&times).recip();
            (times, format!("They were left out, and the others are where an even clock of {rate:.1} Hz has them."))
        }
        Times::AsWritten => (written, "They were left out.".to_owned()),
        Times::Unknown => {
            finding.what +=
                " The others did not come evenly, so nobody knows when they were made: all were left as they are.";
            return Some(finding);
        }
    };
    finding.what = format!("{} {told}", finding.what);
    *time = times;
    [Some(q), qd.as_mut(), qdd.as_mut(), Some(tau)]
        .into_iter()
        .flatten()
        .for_each(|signal| *signal = signal.map_joints(others));
    table.leave_out(&repeated);
    Some(finding)
}

/// For each row, whether all used channels have a finite value there.
fn usable_rows(channels: &Converted) -> Vec<bool> {
    let Converted { time, q, qd, qdd, tau } = channels;
    let all = [Some(q), qd.as_ref(), qdd.as_ref(), Some(tau)];
    let mut usable: Vec<bool> = time.iter().map(|value| value.is_finite()).collect();
    for signal in all.into_iter().flatten().flatten() {
        for (usable, value) in usable.iter_mut().zip(signal) {
            *usable &= value.is_finite();
        }
    }
    usable
}

/// The rows of each trajectory: runs, cut at rows that can't be used and where the clock jumps.
fn stretches(
    table: &Table,
    time: &[f64],
    usable: &[bool],
    file: &str,
    findings: &mut Vec<Finding>,
) -> Vec<Range<usize>> {
    let mut stretches = Vec::new();
    let (mut gaps, mut first_gap, mut largest) = (0usize, None, 0.0f64);
    let (mut short, mut short_samples) = (0usize, 0usize);
    for run in &table.runs {
        let clean: Vec<f64> = run.clone().filter(|row| usable[*row]).map(|row| time[row]).collect();
        let longest_step = GAP_STEPS * median_step(&clean);
        let mut pieces: Vec<Range<usize>> = Vec::new();
        for row in run.clone().filter(|row| usable[*row]) {
            match pieces.last_mut() {
                Some(piece) if piece.end == row && time[row] - time[row - 1] <= longest_step => piece.end = row + 1,
                last => {
                    if last.is_some_and(|piece| piece.end == row) {
                        gaps += 1;
                        largest = largest.max(time[row] - time[row - 1]);
                        first_gap.get_or_insert(row);
                    }
                    pieces.push(row..row + 1);
                }
            }
        }
        let fewest = if pieces.len() > 1 { SHORTEST_STRETCH } else { SHORTEST_RUN };
        let (long, few): (Vec<_>, Vec<_>) = pieces.into_iter().partition(|piece| piece.len() >= fewest);
        short += few.len();
        short_samples += few.iter().map(Range::len).sum::<usize>();
        stretches.extend(long);
    }
    if let Some(row) = first_gap {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::TimeGap,
            what: format!(
                "time steps longer than {GAP_STEPS} median steps: {gaps} (first: {}; largest: {largest:.4} s); \
                 trajectories are cut there.",
                table.place(row)
            ),
            place: Place::file(file),
            remedy: "Nothing was filled in; check whether the recorder lost samples.".to_owned(),
            set_right: Vec::new(),
        });
    }
    if short > 0 {
        findings.push(Finding {
            severity: Severity::Warning,
            kind: FindingKind::FewSamples,
            what: format!(
                "{short} stretches with {short_samples} samples in all are too short to use and were left out."
            ),
            place: Place::file(file),
            remedy: String::new(),
            set_right: Vec::new(),
        });
    }
    stretches
}

/// One trajectory, and the cut-off of its filter \[Hz\]. A stretch that is the whole log takes the channels as they are.
fn derive(
    channels: &mut Converted,
    rows: Range<usize>,
    name: String,
    options: &ReadOptions,
) -> Result<(Trajectory, f64), ShapeError> {
    let is_whole = rows == (0..channels.time.len());
    let cut = |signal: &mut Signals| if is_whole { std::mem::take(signal) } else { signal.cut(rows.clone()) };
    let is_derived = channels.qd.is_none() || channels.qdd.is_none();
    let time = channels.time[rows.clone()].to_vec();
    let q = cut(&mut channels.q);
    let measured = channels.qd.as_mut().map(cut);
    let smoothing = options.smoothing().unwrap_or_else(|| {
        Smoothing::Butterworth(match &measured {
            Some(qd) => default_cutoff(&q, qd, median_step(&time)),
            None => default_cutoff_of_positions(&q, &time),
        })
    });
    let cutoff = smoothing.cutoff_hz(median_step(&time));
    let slope = |signal: &Signals| signal.map_joints(|joint| smoothing.slope(joint, &time));
    let qd = measured.unwrap_or_else(|| slope(&q));
    let qdd = match &mut channels.qdd {
        Some(qdd) => cut(qdd),
        None => slope(&qd),
    };
    let mut tau = cut(&mut channels.tau);
    if let Some(drive) = options.mapping.as_ref().and_then(|mapping| mapping.drive.as_ref()) {
        tau = drive.torque(&tau, &q, &qd);
    }
    let trusted = if is_derived { trusted_range(time.len(), median_step(&time), cutoff) } else { 0..time.len() };
    // One after the other, so that no more than one of them is there twice.
    let trim = |signal: Signals| if trusted.len() == time.len() { signal } else { signal.cut(trusted.clone()) };
    let (q, qd, qdd, tau) = (trim(q), trim(qd), trim(qdd), trim(tau));
    let time = time[trusted.clone()].to_vec();
    Ok((Trajectory::new(name, Channels { time, q, qd, qdd, tau })?, cutoff))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::ArrayD;

    #[test]
    fn the_time_between_rows_follows_from_a_speed_that_fits() {
        let table = Table { runs: vec![0..50, 50..100], ..Table::default() };
        // The second run begins elsewhere: what lies between the two is no step.
        let q = Signals::from_fn(1, 100, |_, row| (0.02 * row as f64).sin() + if row < 50 { 0.0 } else { 7.0 });
        let rate = |row: usize| 2.0 * (0.02 * row as f64).cos();
        let step = step_of_motion(&table, &q, &Signals::from_fn(1, 100, |_, row| rate(row))).unwrap();
        assert!((step - 0.01).abs() < 1e-5, "{step}");
        let hole = Signals::from_fn(1, 100, |_, row| if row == 20 { f64::NAN } else { rate(row) });
        assert!((step_of_motion(&table, &q, &hole).unwrap() - 0.01).abs() < 1e-5);
        assert_eq!(step_of_motion(&table, &q, &Signals::from_fn(1, 100, |_, row| -rate(row))), None);
        let other = Signals::from_fn(1, 100, |_, row| if row % 2 == 0 { 1.0 } else { -1.0 });
        assert_eq!(step_of_motion(&table, &q, &other), None);
    }

    #[test]
    fn what_was_passed_over_is_told_with_constants_that_nothing_uses() {
        let constant = |name: &str| (name.to_owned(), ArrayD::zeros(vec![1]));
        let mut table = Table { passed_over: vec!["`note` (text)".into()], ..Table::default() };
        let told = |table: &Table, spec: &MappingSpec| -> Vec<String> {
            passed_over(table, spec, "log.mat").into_iter().map(|finding| finding.what).collect()
        };
        assert_eq!(told(&Table::default(), &MappingSpec::default()), [""; 0]);
        assert_eq!(told(&table, &MappingSpec::default()), ["passed over: `note` (text)."]);
        table.constants = [constant("gear"), constant("Kt")].into();
        let all = told(&table, &MappingSpec::default());
        assert!(all[0].contains("gear") && all[0].contains("Kt"), "{all:?}");
        let spec = MappingSpec::from_toml("[tau]\ncolumns = [\"i\"]\nfactor = \"Kt\"").unwrap();
        let rest = told(&table, &spec);
        assert!(rest[0].contains("gear") && !rest[0].contains("Kt"), "{rest:?}");
    }
}
