//! MCAP: logs of messages, as rosbag2 has written them since ROS 2 Iron. The topic with positions and torques becomes columns.
//!
//! What a chunk claims to hold is put on the account before it is unpacked.
//! Source: mcap.dev, MCAP format specification.

use std::collections::HashMap;

use ::mcap::records::{Channel, Record, op};
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::budget::{Budget, TooMuch};
use super::messages::Definition;
use super::share::Share;
use super::table::Table;
use super::topics::{TopicError, Topics};
use crate::progress::{Monitor, Stopped};

/// The log can't be read.
#[derive(Debug, thiserror::Error)]
pub enum McapError {
    /// It is cut, or lies about its lengths.
    #[error("the log is damaged at byte {at}: {problem}; copy it again, or mend it with `mcap recover`")]
    Damaged {
        /// Where.
        at: usize,
        /// What is wrong.
        problem: String,
    },
    /// Its records can't be read.
    #[error("the log is damaged ({0}); copy it again, or mend it with `mcap recover`")]
    Record(#[from] ::mcap::McapError),
    /// A chunk is packed in a way that is not read.
    #[error(
        "its chunks are packed with `{0}`, which is not read (lz4 and zstd are); write them anew with `mcap compress`"
    )]
    Codec(String),
    /// A message of a channel that nothing said.
    #[error("a message belongs to channel {0}, which is not in the log; copy it again, or mend it with `mcap recover`")]
    NoChannel(u16),
    /// Its topics make no table.
    #[error(transparent)]
    Topics(#[from] TopicError),
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The first bytes of a log, and the last.
const MAGIC: usize = 8;
/// A record begins with its kind and its length.
const HEAD: usize = 9;
/// The kind of a record with packed ones in it.
const CHUNK: u8 = op::CHUNK;
/// The kinds of records that are looked into.
const MATTER: [u8; 3] = [op::SCHEMA, op::CHANNEL, op::MESSAGE];

/// Reads a log; of several topics with positions and torques the one that is asked for, or that with the most numbers.
pub(super) fn read(bytes: &[u8], asked: &[String], budget: &mut Budget, monitor: &Monitor) -> Result<Table, McapError> {
    let largest = check_chunks(bytes, budget)?;
    let mut schemas: HashMap<u16, Schema> = HashMap::new();
    let mut topics = Topics::asked_for(asked);
    let mut records = Records::new(bytes, largest);
    let mut share = Share::of(bytes.len() as u64, monitor);
    while let Some((record, left)) = records.next()? {
        share.is((bytes.len() - left) as u64)?;
        match record {
            Record::Schema { header, data } => {
                budget.hold(data.len() as u64)?;
                let text = String::from_utf8_lossy(&data).into_owned();
                schemas.insert(header.id, Schema { name: header.name, encoding: header.encoding, text });
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id);
                let kind = schema.map_or("", |schema| schema.name.as_str());
                topics.add(channel.id.into(), &channel.topic, kind, || definition(&channel, schema), budget)?;
            }
            Record::Message { header, data } => {
                let is_known = topics.take(header.channel_id.into(), header.log_time as i64, &data, budget)?;
                if !is_known {
                    return Err(McapError::NoChannel(header.channel_id));
                }
            }
            _ => {}
        }
    }
    Ok(topics.table(budget)?)
}

/// The records of a log that matter here, those in its chunks too. No record may claim more than `largest` \[bytes\]: room is made
/// for what it claims before it is read.
struct Records<'a> {
    reader: LinearReader,
    left: &'a [u8],
}

impl<'a> Records<'a> {
    fn new(bytes: &'a [u8], largest: usize) -> Self {
        let options = LinearReaderOptions::default().with_record_length_limit(largest).with_validate_chunk_crcs(true);
        Records { reader: LinearReader::new_with_options(options), left: bytes }
    }

    fn next(&mut self) -> Result<Option<(Record<'_>, usize)>, McapError> {
        let (opcode, data) = loop {
            match self.reader.next_event().transpose()? {
                None => return Ok(None),
                Some(LinearReadEvent::ReadRequest(wanted)) => {
                    let (now, later) = self.left.split_at(wanted.min(self.left.len()));
                    self.reader.insert(now.len()).copy_from_slice(now);
                    self.reader.notify_read(now.len());
                    self.left = later;
                }
                Some(LinearReadEvent::Record { opcode, data }) if MATTER.contains(&opcode) => {
                    // The borrow of one record must not outlive the loop that looks for it.
                    break (opcode, data.to_vec());
                }
                Some(LinearReadEvent::Record { .. }) => {}
            }
        };
        Ok(Some((::mcap::parse_record(opcode, &data)?.into_owned(), self.left.len())))
    }
}

/// Walks over the records: each must end within the file, and what chunks claim to unpack to must be allowed. Returns how large a
/// record may be.
fn check_chunks(bytes: &[u8], budget: &mut Budget) -> Result<usize, McapError> {
    let mut largest = bytes.len();
    let damaged = |at: usize, problem: &str| McapError::Damaged { at, problem: problem.to_owned() };
    let mut at = MAGIC;
    while at + HEAD <= bytes.len() {
        let length = number(bytes, at + 1).ok_or_else(|| damaged(at, "it ends within a record"))?;
        let start = at + HEAD;
        let end = usize::try_from(length).ok().and_then(|length| start.checked_add(length));
        let body = end.and_then(|end| bytes.get(start..end));
        let body = body.ok_or_else(|| damaged(at, "a record claims to be longer than the file"))?;
        if bytes[at] == CHUNK {
            // Times of the first and the last message, unpacked size, checksum, codec.
            let unpacked = number(body, 16).ok_or_else(|| damaged(at, "a chunk ends within its head"))?;
            let codec = body.get(28..32).and_then(|size| size.try_into().ok()).map(u32::from_le_bytes);
            let codec = codec.and_then(|size| body.get(32..32usize.checked_add(size as usize)?));
            let codec = codec.ok_or_else(|| damaged(at, "a chunk ends within its head"))?;
            if ![&b""[..], b"lz4", b"zstd"].contains(&codec) {
                return Err(McapError::Codec(String::from_utf8_lossy(codec).chars().take(40).collect()));
            }
            if codec.is_empty() && !holds_whole_records(body) {
                return Err(damaged(at, "a record in a chunk claims to be longer than the chunk"));
            }
            budget.unpack(unpacked)?;
            largest = largest.max(usize::try_from(unpacked).unwrap_or(usize::MAX));
        }
        at = start + body.len();
        if bytes.len() - at == MAGIC {
            return Ok(largest);
        }
    }
    Err(damaged(at.min(bytes.len()), "it breaks off"))
}

/// Whether the records that are stored in the body of a chunk end with it, one behind the other. The reader counts on that.
fn holds_whole_records(body: &[u8]) -> bool {
    // Behind the empty name of the codec stands how long they are in all.
    let length = number(body, 32).and_then(|length| usize::try_from(length).ok());
    let Some(mut left) = length.and_then(|length| body.get(40..length.checked_add(40)?)) else { return false };
    while !left.is_empty() {
        let end = number(left, 1).and_then(|length| usize::try_from(length).ok()?.checked_add(HEAD));
        let Some(rest) = end.and_then(|end| left.get(end..)) else { return false };
        left = rest;
    }
    true
}

fn number(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

/// The definition of the messages of a channel.
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

/// How the messages of a channel are read, or why not.
fn definition(channel: &Channel, schema: Option<&Schema>) -> Result<Definition, String> {
    match (channel.message_encoding.as_str(), schema) {
        ("cdr", Some(schema)) => Definition::of(&schema.name, &schema.encoding, &schema.text),
        ("cdr", None) => Err("it has no definition".to_owned()),
        (other, _) => Err(format!("its messages are in `{other}`, not in CDR")),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::io::Cursor;

    use super::*;
    use crate::recording::read::cdr::CdrWriter;

    const JOINT_STATE: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
        ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

    fn state(t: u32) -> Vec<u8> {
        let value = f64::from(t) * 0.1;
        let channels = [&[value][..], &[value + 1.0], &[value + 2.0]];
        CdrWriter::joint_state([1000 + t / 100, (t % 100) * 10_000_000], &["elbow"], channels)
    }

    /// A log of 200 joint states, packed in this way.
    fn log(compression: Option<::mcap::Compression>) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let options = ::mcap::WriteOptions::new().compression(compression);
        let mut writer = options.create(&mut file).unwrap();
        let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.as_bytes()).unwrap();
        let states = writer.add_channel(schema, "/joint_states", "cdr", &BTreeMap::new()).unwrap();
        let other = writer.add_channel(0, "/notes", "json", &BTreeMap::new()).unwrap();
        for t in 0..200 {
            let header = ::mcap::records::MessageHeader {
                channel_id: states,
                sequence: t,
                log_time: u64::from(t),
                publish_time: 0,
            };
            writer.write_to_known_channel(&header, &state(t)).unwrap();
        }
        let header = ::mcap::records::MessageHeader { channel_id: other, sequence: 0, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, b"{}").unwrap();
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    fn table(bytes: &[u8]) -> Result<Table, McapError> {
        read_topics(bytes, &[])
    }

    fn read_topics(bytes: &[u8], topics: &[&str]) -> Result<Table, McapError> {
        let topics: Vec<String> = topics.iter().map(|topic| (*topic).to_owned()).collect();
        read(bytes, &topics, &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new())
    }

    #[test]
    fn joint_states_are_read_however_they_are_packed() {
        for compression in [None, Some(::mcap::Compression::Lz4), Some(::mcap::Compression::Zstd)] {
            let table = table(&log(compression)).unwrap();
            assert_eq!(table.names(), ["time", "position[0]", "velocity[0]", "effort[0]"]);
            let last = |name: &str| *table.column(name).unwrap().values.last().unwrap();
            assert!((last("time") - 1.99).abs() < 1e-9 && (last("effort[0]") - 21.9).abs() < 1e-9);
            assert_eq!(table.joints, Some(vec!["elbow".to_owned()]));
            assert!(table.passed_over[0].contains("/notes"), "{:?}", table.passed_over);
        }
    }

    /// Found by fuzzing: the reader of the library counts below zero there.
    #[test]
    fn a_record_that_is_longer_than_its_chunk_is_refused() {
        let whole = log(None);
        let next = |at: &usize| Some(at + HEAD + number(&whole, at + 1)? as usize);
        let chunk = std::iter::successors(Some(MAGIC), next).find(|&at| whole[at] == CHUNK).unwrap();
        let first = chunk + HEAD + 40;
        for length in [number(&whole, chunk + HEAD + 32).unwrap(), 1 << 60] {
            let mut bytes = whole.clone();
            bytes[first + 1..first + 9].copy_from_slice(&length.to_le_bytes());
            let refusal = table(&bytes).unwrap_err().to_string();
            assert!(refusal.contains("a record in a chunk claims to be longer than the chunk"), "{refusal}");
        }
        assert!(table(&whole).is_ok());
    }

    /// A topic: its name, and what it says each time, if it says something then.
    type Said<'a> = (&'a str, &'a dyn Fn(u32) -> Option<Vec<u8>>);

    /// A log of joint states at 100 Hz, received as they are stamped by default.
    fn log_of(topics: &[Said]) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut writer = ::mcap::WriteOptions::new().create(&mut file).unwrap();
        let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.as_bytes()).unwrap();
        let channel = |(topic, _): &Said| writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        let channels: Vec<u16> = topics.iter().map(channel).collect();
        for t in 0..200u32 {
            let log_time = u64::from(t) * 10_000_000 + 9_000_000_000;
            for (channel_id, (_, said)) in channels.iter().copied().zip(topics) {
                let header = ::mcap::records::MessageHeader { channel_id, sequence: t, log_time, publish_time: 0 };
                if let Some(message) = said(t) {
                    writer.write_to_known_channel(&header, &message).unwrap();
                }
            }
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    /// What is said at a time, stamped so much later [ms]; a joint's position is its number and the time, its torque ten times that.
    fn said(t: u32, late: u32, joints: &[&str], channels: [bool; 3]) -> Option<Vec<u8>> {
        let ms = 5000 + 10 * t + late;
        let number = |joint: &&str| f64::from(joint.as_bytes()[0] - b'a') + f64::from(t) * 0.01;
        let values = |factor: f64| joints.iter().map(|joint| factor * number(joint)).collect::<Vec<f64>>();
        let given = [values(1.0), values(2.0), values(10.0)];
        let of = |channel: usize| if channels[channel] { given[channel].as_slice() } else { &[] };
        Some(CdrWriter::joint_state([ms / 1000, ms % 1000 * 1_000_000], joints, [of(0), of(1), of(2)]))
    }

    const ALL: [bool; 3] = [true; 3];
    const POSITIONS: [bool; 3] = [true, false, false];
    const TORQUES: [bool; 3] = [false, false, true];

    /// Whether each joint, counted from that of `a`, has what [`said`] gives it.
    fn assert_joints(table: &Table, joints: &[&str], rows: usize) {
        assert_eq!(table.joints.as_deref().unwrap(), joints);
        for (index, joint) in joints.iter().enumerate() {
            for (name, factor) in [("position", 1.0), ("effort", 10.0)] {
                let values = &table.column(&format!("{name}[{index}]")).unwrap().values;
                assert_eq!(values.len(), rows);
                for (t, value) in values.iter().enumerate() {
                    let expected = factor * (f64::from(joint.as_bytes()[0] - b'a') + 0.01 * t as f64);
                    assert!((value - expected).abs() < 1e-9, "{name} of {joint} at {t}: {value}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn positions_and_torques_of_two_topics_are_brought_to_one_clock() {
        let bytes = log_of(&[
            ("/motion", &|t| said(t, 0, &["a"], [true, true, false])),
            ("/torque", &|t| said(t, 1500, &["a"], TORQUES)),
        ]);
        let table = table(&bytes).unwrap();
        assert_eq!(table.names(), ["time", "position[0]", "velocity[0]", "effort[0]"]);
        assert_joints(&table, &["a"], 200);
        assert!(table.clocks[0].is_moved && table.clocks[0].what.contains("-1500.000 ms apart"), "{:?}", table.clocks);
    }

    #[test]
    fn joints_keep_their_numbers_in_whatever_order_a_message_names_them() {
        let order = |t: u32| if t.is_multiple_of(2) { ["a", "b"] } else { ["b", "a"] };
        let table = table(&log_of(&[("/joint_states", &|t| said(t, 0, &order(t), ALL))])).unwrap();
        assert_joints(&table, &["a", "b"], 200);
        assert!(table.passed_over.is_empty(), "{:?}", table.passed_over);
    }

    /// An arm and its hand tell their states on one topic; both have two joints.
    #[test]
    fn joints_of_two_publishers_are_kept_apart() {
        let joints = |t: u32| if t.is_multiple_of(4) { ["f", "g"] } else { ["a", "b"] };
        let table = table(&log_of(&[("/joint_states", &|t| said(t, 0, &joints(t), ALL))])).unwrap();
        assert_eq!(table.joints.as_deref().unwrap(), ["a", "b"]);
        assert!((table.column("position[1]").unwrap().values[2] - 1.03).abs() < 1e-9);
        assert_eq!(table.column("time").unwrap().values.len(), 150);
        let told = table.passed_over.join(";");
        assert!(told.contains("50 messages of `/joint_states`") && told.contains("a, b"), "{told}");
    }

    #[test]
    fn torques_of_another_topic_are_those_of_the_joints_that_they_are_named_for() {
        let bytes = log_of(&[
            ("/pos", &|t| said(t, 0, &["a", "b"], POSITIONS)),
            ("/eff", &|t| said(t, 0, &["b", "a"], TORQUES)),
        ]);
        assert_joints(&table(&bytes).unwrap(), &["a", "b"], 200);
    }

    #[test]
    fn of_two_topics_with_other_joints_those_are_taken_that_both_have() {
        let bytes = log_of(&[
            ("/pos", &|t| said(t, 0, &["f", "a", "b"], POSITIONS)),
            ("/eff", &|t| said(t, 0, &["b", "e", "a"], TORQUES)),
        ]);
        let table = table(&bytes).unwrap();
        assert_joints(&table, &["a", "b"], 200);
        let told = table.passed_over.join(";");
        assert!(told.contains("f, which only `/pos` has") && told.contains("e, which only `/eff` has"), "{told}");
    }

    #[test]
    fn the_topic_that_is_asked_for_is_read_or_told_not_to_be_there() {
        let log = log(None);
        assert_eq!(read_topics(&log, &["/joint_states"]).unwrap().names().len(), 4);
        let problem = read_topics(&log, &["/notes"]).unwrap_err().to_string();
        assert!(problem.contains("no topic `/notes` with numbers") && problem.contains("`/joint_states`"), "{problem}");
        assert!(problem.contains("`/notes` (1 messages, its messages are in `json`"), "{problem}");
    }

    #[test]
    fn the_topics_that_are_asked_for_stand_side_by_side() {
        let log = log_of(&[
            ("/pos", &|t| said(t, 0, &["a", "b"], POSITIONS)),
            ("/eff", &|t| said(t, 0, &["b", "a"], TORQUES)),
            ("/other", &|t| said(t, 0, &["c", "d"], ALL)),
            ("/hand", &|t| said(t, 0, &["f"], TORQUES)),
        ]);
        assert_eq!(table(&log).unwrap().joints.as_deref().unwrap(), ["c", "d"]);
        assert_joints(&read_topics(&log, &["/pos", "/eff"]).unwrap(), &["a", "b"], 200);
        // At the times and in the order of the first.
        assert_joints(&read_topics(&log, &["/eff", "/pos"]).unwrap(), &["b", "a"], 200);
        // What is asked for alone is read alone: whether it is enough is said where its columns are mapped.
        assert_eq!(read_topics(&log, &["/eff"]).unwrap().names(), ["time", "effort[0]", "effort[1]"]);
        for (asked, words) in [
            (&["/pos", "/hand"][..], "`/pos` are of the joints a, b, those of `/hand` of f"),
            (&["/pos", "/gone"], "no topic `/gone`"),
            (&["/pos", "/pos"], "`topic` names /pos, /pos"),
            (&["/pos", "/eff", "/hand"], "name one topic, or two different ones"),
        ] {
            let problem = read_topics(&log, asked).unwrap_err().to_string();
            assert!(problem.contains(words), "{problem}");
        }
    }

    #[test]
    fn cut_and_lying_logs_are_refused_with_the_place() {
        let whole = log(Some(::mcap::Compression::Zstd));
        for end in (8..whole.len() - 1).step_by(7) {
            assert!(table(&whole[..end]).is_err(), "cut at {end}");
        }
        // The head of the chunk: its length, what it claims to unpack to, its codec.
        let chunk = (8..).find(|at| whole[*at] == CHUNK && whole[at + 37..].starts_with(&[4, 0, 0, 0])).unwrap();
        let lying = |at: usize, bytes: &[u8]| {
            let mut lying = whole.clone();
            lying[at..at + bytes.len()].copy_from_slice(bytes);
            table(&lying).unwrap_err().to_string()
        };
        assert!(lying(chunk + 1, &[0xff; 8]).contains(&format!("at byte {chunk}: a record claims")));
        assert!(lying(chunk + HEAD + 16, &[0xff; 8]).contains("unpacked it takes more"));
        assert!(lying(chunk + HEAD + 32, b"snap").contains("`snap`, which is not read"));
        // Whatever is wrong, nothing panics.
        for place in (8..whole.len()).step_by(3) {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x55;
            let _ = table(&damaged);
        }
    }
}
