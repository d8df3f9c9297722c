//! Faults planted into clean logs: each has to be found as what it is, and clean logs have to be left in peace.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use super::{Bench, Measure, Score, SelftestError};
use crate::arm::{Arm, Posture};
use crate::file;
use crate::recording::Recording;
use crate::recording::finding::{Finding, FindingKind, Severity};
use crate::recording::hold_out::HoldOut;
use crate::recording::read::ReadOptions;
use crate::recording::write::to_csv_bytes;
use crate::session::{Command, Session};
use crate::simulation::{Excitation, Scenario, simulate};

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "faults",
    promise: "spikes, gaps, signs, orders, delays, units, jumps, held derivatives, repeated readings and saturation planted into \
              clean logs: at least 95 % are found, and at most one of 20 clean logs raises an alarm",
    take,
};

/// Share of the faults that has to be found.
const RECALL: f64 = 0.95;
/// Share of the clean logs that may raise an alarm.
const ALARMS: f64 = 0.05;

/// A fault, and by which findings it is found.
struct Fault {
    name: &'static str,
    plant: fn(&mut Log, &mut ChaCha8Rng),
    found_by: &'static [FindingKind],
    /// Joints that it takes at least.
    joints: usize,
}

/// A log of one run, row by row, before it is written.
struct Log {
    posture: Option<Posture>,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    joints: usize,
}

use FindingKind::{
    AccelerationMismatch, BeyondBelief, Degrees, FarOut, Held, NonFinite, Repeated, Saturated, SetUp, Stuck, TimeGap,
    TimeUnit, UnevenTime, VelocityMismatch, WholeTurn,
};

const FAULTS: &[Fault] = &[
    Fault {
        name: "torque spike of 100 RMS",
        plant: |log, random| log.spike(log.tau(), 100.0, random),
        found_by: &[FarOut],
        joints: 1,
    },
    Fault {
        name: "torque spike of 10 RMS",
        plant: |log, random| log.spike(log.tau(), 10.0, random),
        found_by: &[FarOut],
        joints: 1,
    },
    Fault {
        name: "position spike of 3 RMS",
        plant: |log, random| log.spike(log.q(), 3.0, random),
        found_by: &[FarOut, WholeTurn],
        joints: 1,
    },
    Fault {
        name: "velocity spike of 3 RMS",
        plant: |log, random| log.spike(log.qd(), 3.0, random),
        found_by: &[FarOut],
        joints: 1,
    },
    Fault {
        name: "value beyond belief",
        plant: |log, random| log.spike(log.tau(), 1e12, random),
        found_by: &[BeyondBelief],
        joints: 1,
    },
    Fault { name: "gap in time", plant: Log::gap, found_by: &[TimeGap, UnevenTime], joints: 1 },
    Fault { name: "missing values", plant: Log::missing, found_by: &[NonFinite], joints: 1 },
    Fault {
        name: "sign of a torque",
        plant: |log, random| log.scale(log.tau(), -1.0, random),
        found_by: &[SetUp],
        joints: 2,
    },
    Fault {
        name: "sign of a velocity",
        plant: |log, random| log.scale(log.qd(), -1.0, random),
        found_by: &[VelocityMismatch, SetUp],
        joints: 1,
    },
    Fault { name: "order of torques", plant: Log::order, found_by: &[SetUp], joints: 2 },
    Fault { name: "torque late by 1 to 20 rows", plant: Log::late_torque, found_by: &[SetUp], joints: 1 },
    Fault {
        name: "velocity late by 2 to 20 rows",
        plant: Log::late_velocity,
        found_by: &[VelocityMismatch, SetUp],
        joints: 1,
    },
    Fault {
        name: "angles in degrees",
        plant: |log, _| log.scale_all(log.q(), 180.0 / PI),
        found_by: &[Degrees, SetUp, VelocityMismatch],
        joints: 1,
    },
    Fault {
        name: "velocity in degrees",
        plant: |log, _| log.scale_all(log.qd(), 180.0 / PI),
        found_by: &[VelocityMismatch, SetUp],
        joints: 1,
    },
    Fault { name: "time in ms", plant: |log, _| log.scale_all(0, 1e3), found_by: &[TimeUnit], joints: 1 },
    Fault { name: "angle jumps by a turn", plant: Log::jump, found_by: &[WholeTurn], joints: 1 },
    Fault {
        name: "velocity at a tenth of the rate",
        plant: |log, random| log.hold(log.qd(), random),
        found_by: &[Held],
        joints: 1,
    },
    Fault {
        name: "acceleration at a tenth of the rate",
        plant: |log, random| log.hold(log.qdd(), random),
        found_by: &[Held, AccelerationMismatch],
        joints: 1,
    },
    Fault { name: "readings written again", plant: Log::ask_faster, found_by: &[Repeated], joints: 1 },
    Fault { name: "torque cut off at 60 %", plant: Log::saturate, found_by: &[Saturated], joints: 1 },
    Fault { name: "torque stands still for 5 %", plant: Log::stick, found_by: &[Stuck], joints: 1 },
];

/// Columns are `time`, then q, q̇, q̈ and τ of all joints.
impl Log {
    fn of(recording: &Recording) -> Log {
        let text = String::from_utf8_lossy(&to_csv_bytes(&recording.trajectories[0])).into_owned();
        let mut lines = text.lines();
        let names = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
        let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        Log { posture: recording.posture, names, rows: lines.map(row).collect(), joints: recording.joint_count() }
    }

    fn text(&self) -> String {
        let row = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let rows: Vec<String> = self.rows.iter().map(row).collect();
        format!("{}\n{}\n", self.names.join(","), rows.join("\n"))
    }

    fn q(&self) -> usize {
        1
    }

    fn qd(&self) -> usize {
        1 + self.joints
    }

    fn qdd(&self) -> usize {
        1 + 2 * self.joints
    }

    fn tau(&self) -> usize {
        1 + 3 * self.joints
    }

    fn any_row(&self, random: &mut ChaCha8Rng) -> usize {
        random.random_range(self.rows.len() / 10..self.rows.len() * 9 / 10)
    }

    fn any(&self, channel: usize, random: &mut ChaCha8Rng) -> usize {
        channel + random.random_range(0..self.joints)
    }

    fn rms(&self, column: usize) -> f64 {
        (self.rows.iter().map(|row| row[column].powi(2)).sum::<f64>() / self.rows.len() as f64).sqrt()
    }

    fn change(&mut self, column: usize, value: impl Fn(usize, f64) -> f64) {
        self.rows.iter_mut().enumerate().for_each(|(number, row)| row[column] = value(number, row[column]));
    }

    fn spike(&mut self, channel: usize, size: f64, random: &mut ChaCha8Rng) {
        let (column, row) = (self.any(channel, random), self.any_row(random));
        let sign = if random.random() { 1.0 } else { -1.0 };
        self.rows[row][column] += sign * size * self.rms(column);
    }

    fn gap(&mut self, random: &mut ChaCha8Rng) {
        let row = self.any_row(random);
        let length = random.random_range(6..40).min(self.rows.len() - row - 1);
        self.rows.drain(row..row + length);
    }

    fn missing(&mut self, random: &mut ChaCha8Rng) {
        let (column, row) = (self.any(self.tau(), random), self.any_row(random));
        self.rows.iter_mut().skip(row).take(3).for_each(|row| row[column] = f64::NAN);
    }

    fn scale(&mut self, channel: usize, factor: f64, random: &mut ChaCha8Rng) {
        let column = self.any(channel, random);
        self.change(column, |_, value| factor * value);
    }

    /// All joints, or the clock (0).
    fn scale_all(&mut self, channel: usize, factor: f64) {
        let columns = if channel == 0 { 0..1 } else { channel..channel + self.joints };
        columns.for_each(|column| self.change(column, |_, value| factor * value));
    }

    fn order(&mut self, random: &mut ChaCha8Rng) {
        let mut joints: Vec<usize> = (0..self.joints).collect();
        joints.shuffle(random);
        let (one, other) = (self.tau() + joints[0], self.tau() + joints[1]);
        self.rows.iter_mut().for_each(|row| row.swap(one, other));
    }

    fn late(&mut self, channel: usize, rows: usize) {
        for column in channel..channel + self.joints {
            let values: Vec<f64> = self.rows.iter().map(|row| row[column]).collect();
            self.change(column, |number, _| values[number.saturating_sub(rows)]);
        }
    }

    fn late_torque(&mut self, random: &mut ChaCha8Rng) {
        self.late(self.tau(), random.random_range(1..=20));
    }

    fn late_velocity(&mut self, random: &mut ChaCha8Rng) {
        self.late(self.qd(), random.random_range(2..=20));
    }

    fn jump(&mut self, random: &mut ChaCha8Rng) {
        let (column, from) = (self.any(self.q(), random), self.any_row(random));
        self.change(column, |row, value| if row < from { value } else { value + TAU });
    }

    fn hold(&mut self, channel: usize, random: &mut ChaCha8Rng) {
        let column = self.any(channel, random);
        let values: Vec<f64> = self.rows.iter().map(|row| row[column]).collect();
        self.change(column, |row, _| values[row / 10 * 10]);
    }

    /// As a logger writes it that asks up to three times as often as there are readings.
    fn ask_faster(&mut self, random: &mut ChaCha8Rng) {
        let times = random.random_range(1.02..3.0);
        let count = (self.rows.len() as f64 * times) as usize;
        let (begin, step) = (self.rows[0][0], (self.rows[1][0] - self.rows[0][0]) / times);
        let asked = |row: usize| {
            let mut last = self.rows[(row as f64 / times) as usize].clone();
            last[0] = begin + step * row as f64;
            last
        };
        self.rows = (0..count).map(asked).collect();
    }

    fn saturate(&mut self, random: &mut ChaCha8Rng) {
        let column = self.any(self.tau(), random);
        let most = 0.6 * self.rows.iter().fold(0.0f64, |most, row| most.max(row[column].abs()));
        self.change(column, |_, value| value.clamp(-most, most));
    }

    fn stick(&mut self, random: &mut ChaCha8Rng) {
        let (column, from) = (self.any(self.tau(), random), self.any_row(random));
        let length = self.rows.len() / 20;
        let held = self.rows[from][column];
        self.change(column, |row, value| if (from..from + length).contains(&row) { held } else { value });
    }
}

/// An arm with friction that moves all its joints; others for other cases.
fn clean(random: &mut ChaCha8Rng, joints: usize) -> Scenario {
    let joints = random.random_range(joints..=3);
    let friction = Scenario::embedded().effects;
    let effects = friction.into_iter().filter(|effect| effect.joint.is_none_or(|joint| joint < joints)).collect();
    Scenario {
        name: "clean".to_owned(),
        arm: Arm::uniform(joints),
        motion: Excitation::MultiSine {
            trajectories: 1,
            duration: random.random_range(20.0..40.0),
            rate: [100.0, 200.0][random.random_range(0..2)],
            harmonics: 5,
            lowest_frequency: 0.1,
            highest_frequency: random.random_range(0.7..1.2),
            max_position: 2.0,
            max_velocity: 4.0,
        },
        effects,
        torque_noise: random.random_range(0.002..0.03),
        seed: random.next_u64(),
        ..Scenario::embedded()
    }
}

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let cases = bench.cases(2 * FAULTS.len(), 30 * FAULTS.len());
    let clean_cases = bench.cases(20, 300);
    let mut score = Score { cases: cases + clean_cases, ..Score::default() };
    let mut by_fault: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for case in 0..cases {
        bench.report(case, score.cases, "planted faults")?;
        let (fault, mut random) = (&FAULTS[case % FAULTS.len()], bench.random(case));
        let mut log = planted_into(&mut random, fault.joints)?;
        (fault.plant)(&mut log, &mut random);
        let is_found = findings(bench, &log)?.iter().any(|finding| fault.found_by.contains(&finding.kind));
        let [found, of] = by_fault.entry(fault.name).or_default();
        (*found, *of) = (*found + usize::from(is_found), *of + 1);
        score.count(if is_found { "found" } else { "missed" });
    }
    for (name, [found, of]) in by_fault {
        score.counts.insert(format!("found of {of}: {name}"), found);
    }
    let mut alarms = Vec::new();
    for case in 0..clean_cases {
        bench.report(cases + case, score.cases, "clean logs")?;
        let log = planted_into(&mut bench.random(cases + case), 1)?;
        let said = findings(bench, &log)?.into_iter().find(|finding| finding.severity > Severity::Info);
        score.count(if said.is_some() { "false alarm" } else { "left in peace" });
        alarms.extend(said.map(|finding| finding.what));
    }
    let found = score.of("found");
    score.demand(found as f64 >= RECALL * cases as f64, || format!("{found} of {cases} planted faults were found"));
    score.demand(alarms.len() as f64 <= ALARMS * clean_cases as f64, || {
        format!("{} of {clean_cases} clean logs raised an alarm, such as: {}", alarms.len(), alarms[0])
    });
    Ok(score)
}

fn planted_into(random: &mut ChaCha8Rng, joints: usize) -> Result<Log, SelftestError> {
    let recording = simulate(&clean(random, joints), &crate::progress::Monitor::new());
    Ok(Log::of(&recording.map_err(|error| SelftestError::making("a recording")(&error))?))
}

/// What the program says when it opens the log, told where the arm points.
fn findings(bench: &Bench, log: &Log) -> Result<Vec<Finding>, SelftestError> {
    let path = bench.path("log.csv");
    file::write(&path, log.text().as_bytes())?;
    let options = ReadOptions { zero: log.posture, ..ReadOptions::default() };
    let opened = Command::open(vec![path], options, HoldOut::default()).run(&Session::default(), bench.monitor);
    let session = opened.map_err(|error| SelftestError::making("a log")(&error))?;
    Ok(session.findings.to_vec())
}
