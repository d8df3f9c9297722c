//! Runs and tables as MCAP logs of ROS 2 messages in CDR, with their definitions.
//!
//! Sources: mcap.dev, MCAP format specification; ROS 2, `sensor_msgs/msg/JointState`.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::mcap::records::MessageHeader;
use ::mcap::{Compression, WriteOptions};

use super::super::Trajectory;
use super::super::layout::{TIME, TRAJECTORY};
use super::super::read::cdr::CdrWriter;
use super::WriteError;

/// What stands behind every definition.
const HEADER: &str = "===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const JOINT_STATE: &str =
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n";
/// Between runs of a log lie so many seconds, or as many times the longest step as is a gap for every reader.
const PAUSE: f64 = 10.0;
const PAUSE_STEPS: f64 = 100.0;

/// Runs as joint states, one after another with a pause between; the stamps of the first begin where its clock does.
pub fn joint_states(
    runs: &[Trajectory],
    joints: &[&str],
    compression: Option<Compression>,
) -> Result<Vec<u8>, WriteError> {
    let mut log = Log::begin("sensor_msgs/msg/JointState", JOINT_STATE, "/joint_states", compression)?;
    for (number, run) in runs.iter().enumerate() {
        log.begin_run(number, &run.time);
        for (sample, time) in run.time.iter().enumerate() {
            let [q, qd, tau] = [&run.q, &run.qd, &run.tau].map(|signal| signal.at(sample).collect::<Vec<f64>>());
            log.add(*time, |stamp| CdrWriter::joint_state(stamp, joints, [&q, &qd, &tau]))?;
        }
    }
    log.end()
}

/// A table as messages of a type of its own, with a number of each column; trajectories one after another with a pause between.
pub fn table(columns: &[(String, Vec<f64>)]) -> Result<Vec<u8>, WriteError> {
    let column = |wanted: &str| columns.iter().find(|(name, _)| name == wanted).map(|(_, values)| values.as_slice());
    let rows = columns.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let counted: Vec<f64> = (0..rows).map(|row| row as f64).collect();
    let (time, trajectory) = (column(TIME).unwrap_or(&counted), column(TRAJECTORY).unwrap_or(&[]));
    let definition: String = columns.iter().map(|(name, _)| format!("float64 {}\n", field(name))).collect();
    let definition = format!("std_msgs/Header header\n{definition}");
    let mut log = Log::begin("torquescope_msgs/msg/Row", &definition, "/torquescope/table", Some(Compression::Zstd))?;
    let of = |row: usize| trajectory.get(row).copied().unwrap_or_default();
    let (mut start, mut number) = (0, 0);
    while start < rows {
        let end = (start..rows).find(|row| of(*row) != of(start)).unwrap_or(rows);
        log.begin_run(number, &time[start..end]);
        for row in start..end {
            log.add(time[row], |[seconds, nanoseconds]| {
                let mut message = CdrWriter::new();
                message.word(seconds.to_le_bytes()).word(nanoseconds.to_le_bytes()).text("");
                for (_, values) in columns {
                    message.word(values.get(row).copied().unwrap_or(f64::NAN).to_le_bytes());
                }
                message.end()
            })?;
        }
        (start, number) = (end, number + 1);
    }
    log.end()
}

/// The name of a column as that of a field: `coulomb-friction@1` is `coulomb_friction_1`.
fn field(name: &str) -> String {
    let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    name.chars().map(letter).collect()
}

/// A log that is being written.
struct Log {
    writer: ::mcap::Writer<Cursor<Vec<u8>>>,
    channel_id: u16,
    sequence: u32,
    /// What is added to the clock of a run \[s\].
    shift: f64,
    /// When the last message was stamped \[s\].
    last: f64,
}

impl Log {
    fn begin(kind: &str, definition: &str, topic: &str, compression: Option<Compression>) -> Result<Log, WriteError> {
        let mut writer = WriteOptions::new().compression(compression).create(Cursor::new(Vec::new()))?;
        let schema = writer.add_schema(kind, "ros2msg", format!("{definition}{HEADER}").as_bytes())?;
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new())?;
        Ok(Log { writer, channel_id, sequence: 0, shift: 0.0, last: 0.0 })
    }

    /// A clock begins again. That of the first run is kept, unless it begins before zero.
    fn begin_run(&mut self, number: usize, time: &[f64]) {
        let first = time.first().copied().unwrap_or_default();
        let step = time.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        self.shift = match number {
            0 => (-first).max(0.0),
            _ => self.last + PAUSE.max(PAUSE_STEPS * step) - first,
        };
    }

    fn add(&mut self, time: f64, message: impl FnOnce([u32; 2]) -> Vec<u8>) -> Result<(), WriteError> {
        let stamped = time + self.shift;
        let nanoseconds = (stamped * 1e9).round();
        if !(0.0..=f64::from(i32::MAX) * 1e9).contains(&nanoseconds) {
            return Err(WriteError::Stamp { from: self.last, to: stamped });
        }
        let log_time = nanoseconds as u64;
        let header =
            MessageHeader { channel_id: self.channel_id, sequence: self.sequence, log_time, publish_time: log_time };
        let stamp = [(log_time / 1_000_000_000) as u32, (log_time % 1_000_000_000) as u32];
        self.writer.write_to_known_channel(&header, &message(stamp))?;
        self.sequence += 1;
        self.last = stamped;
        Ok(())
    }

    fn end(mut self) -> Result<Vec<u8>, WriteError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}
