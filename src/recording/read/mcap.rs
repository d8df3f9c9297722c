//! MCAP: logs of messages, as rosbag2 has written them since ROS 2 Iron. The topic with positions and torques becomes columns.
//!
//! What a chunk claims to hold is put on the account before it is unpacked.
//! Source: mcap.dev, MCAP format specification.

use std::collections::{BTreeMap, HashMap};

use ::mcap::records::{Channel, Record, op};
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::budget::{Budget, TooMuch};
use super::clocks::{self, Clock, Told};
use super::messages::{Definition, Message, NoTopic};
use super::share::Share;
use super::table::{Column, MOST_COLUMNS, Table};
use crate::progress::{Monitor, Stopped};
use crate::recording::mapping::{Mapping, MappingSpec};

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
    /// No topic has what is needed.
    #[error("no topic of the log has positions and torques{}; record /joint_states or /dynamic_joint_states", also(.0))]
    NoStates(Vec<String>),
    /// The topic that was asked for is not there.
    #[error(transparent)]
    NoTopic(#[from] NoTopic),
    /// A message that is cut or lies about its sizes.
    #[error("message {number} of `{topic}` is damaged: {problem}; copy or record the log again")]
    Message {
        /// Counted from 1.
        number: usize,
        /// Its topic.
        topic: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

fn also(topics: &[String]) -> String {
    if topics.is_empty() { String::new() } else { format!(", only {}", topics.join("; ")) }
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
pub(super) fn read(
    bytes: &[u8],
    topic: Option<&str>,
    budget: &mut Budget,
    monitor: &Monitor,
) -> Result<Table, McapError> {
    let largest = check_chunks(bytes, budget)?;
    let mut schemas: HashMap<u16, Schema> = HashMap::new();
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
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
                budget.text(&channel.topic)?;
                let schema = schemas.get(&channel.schema_id);
                topics.entry(channel.id).or_insert_with(|| Topic::of(&channel, schema));
            }
            Record::Message { header, data } => {
                let topic = topics.get_mut(&header.channel_id).ok_or(McapError::NoChannel(header.channel_id))?;
                topic.take(header.log_time, &data, budget)?;
            }
            _ => {}
        }
    }
    let (mut states, others): (Vec<Topic>, Vec<Topic>) = topics.into_values().partition(Topic::has_states);
    if let Some((positions, other)) = pair(&others).filter(|_| states.is_empty()) {
        return joined(others, positions, other, budget);
    }
    if states.is_empty() {
        return Err(McapError::NoStates(others.iter().map(Topic::told).collect()));
    }
    states.sort_by_key(|topic| std::cmp::Reverse(topic.values()));
    let chosen = states.remove(NoTopic::unless_first(states.iter().map(|topic| topic.name.as_str()), topic)?);
    Ok(chosen.table(states.iter().chain(&others).map(Topic::told).collect()))
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

fn number(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

/// The messages of a topic.
struct Topic {
    name: String,
    kind: String,
    /// How its messages are read, or why not.
    definition: Result<Definition, String>,
    count: usize,
    /// Messages of the same names are one table.
    groups: BTreeMap<Vec<String>, Group>,
}

/// Messages that hold numbers of the same names.
#[derive(Default)]
struct Group {
    /// When the log received each \[ns\].
    received: Vec<i64>,
    columns: Vec<Vec<f64>>,
    joints: Option<Vec<String>>,
}

/// The definition of the messages of a channel.
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

impl Topic {
    fn of(channel: &Channel, schema: Option<&Schema>) -> Topic {
        let definition = match (schema, channel.message_encoding.as_str()) {
            (Some(schema), "cdr") if schema.encoding == "ros2msg" => Definition::parse(&schema.name, &schema.text),
            (Some(schema), "cdr") => Err(format!("its definition is in {}", schema.encoding)),
            (None, _) => Err("it has no definition".to_owned()),
            (_, other) => Err(format!("its messages are in `{other}`, not in CDR")),
        };
        let kind = schema.map_or_else(String::new, |schema| schema.name.clone());
        Topic { name: channel.topic.clone(), kind, definition, count: 0, groups: BTreeMap::new() }
    }

    fn take(&mut self, received: u64, data: &[u8], budget: &mut Budget) -> Result<(), McapError> {
        self.count += 1;
        let Ok(definition) = &self.definition else { return Ok(()) };
        let (number, topic) = (self.count, &self.name);
        let message =
            definition.decode(data).map_err(|problem| McapError::Message { number, topic: topic.clone(), problem })?;
        let message: Message = message.named();
        let joints = message.joints();
        let (names, values): (Vec<String>, Vec<f64>) = message.numbers.into_iter().unzip();
        if names.len() > MOST_COLUMNS {
            return Ok(());
        }
        budget.unpack((values.len() as u64 + 1) * size_of::<f64>() as u64)?;
        let group = match self.groups.get_mut(&names) {
            Some(group) => group,
            None => {
                names.iter().try_for_each(|name| budget.name(name))?;
                let columns = vec![Vec::new(); names.len()];
                self.groups.entry(names).or_insert(Group { columns, joints, ..Group::default() })
            }
        };
        group.received.push(received as i64);
        group.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        Ok(())
    }

    fn usual(&self) -> Option<(&Vec<String>, &Group)> {
        self.groups.iter().max_by_key(|(names, group)| names.len() * group.received.len())
    }

    /// How many numbers it holds.
    fn values(&self) -> usize {
        self.usual().map_or(0, |(names, group)| names.len() * group.received.len())
    }

    /// Whether it has what a recording needs.
    fn has_states(&self) -> bool {
        self.usual().is_some_and(|(names, _)| Mapping::find(names, &MappingSpec::default()).is_ok())
    }

    fn told(&self) -> String {
        let why = self.definition.as_ref().err().map_or(String::new(), |why| format!(", {why}"));
        format!("topic `{}` ({}, {} messages{why})", self.name, self.kind, self.count)
    }

    /// Its columns without a clock, the clock, and names of joints.
    fn columns(self, passed_over: &mut Vec<String>) -> (Vec<Column>, Clock, Option<Vec<String>>) {
        let all = self.count;
        let usual = self.groups.into_iter().max_by_key(|(names, group)| names.len() * group.received.len());
        let (names, mut group) = usual.unwrap_or_default();
        let count = group.received.len();
        if count < all {
            passed_over.push(format!("{} messages of `{}` with other values", all - count, self.name));
        }
        let place = |wanted: &str| names.iter().position(|name| name == wanted);
        let stamp = place("header.stamp.sec").zip(place("header.stamp.nanosec"));
        let stamps = stamp.map_or_else(Vec::new, |(sec, nanosec)| {
            let [sec, nanosec] = [sec, nanosec].map(|place| &group.columns[place]);
            let whole = |(sec, nanosec): (&f64, &f64)| {
                (*sec as i64).saturating_mul(1_000_000_000).saturating_add(*nanosec as i64)
            };
            sec.iter().zip(nanosec).map(whole).collect()
        });
        let mut columns = Vec::new();
        for (name, values) in names.into_iter().zip(&mut group.columns) {
            if !name.starts_with("header.") && name != "time" {
                columns.push(Column { name, values: std::mem::take(values), text: None });
            }
        }
        (columns, Clock { stamps, received: group.received }, group.joints)
    }

    /// Its table; time is that of the measurement, unless nobody stamped it.
    fn table(self, mut passed_over: Vec<String>) -> Table {
        let name = self.name.clone();
        let (columns, clock, joints) = self.columns(&mut passed_over);
        let clocks = clock.told(&name).into_iter().collect();
        table(columns, &clock, joints, clocks, passed_over)
    }
}

fn table(
    mut columns: Vec<Column>,
    clock: &Clock,
    joints: Option<Vec<String>>,
    clocks: Vec<Told>,
    passed_over: Vec<String>,
) -> Table {
    columns.insert(0, Column { name: "time".to_owned(), values: clock.seconds(), text: None });
    let runs = std::iter::once(0..clock.received.len()).collect();
    Table { columns, runs, joints, clocks, passed_over, ..Table::default() }
}

/// More topics are not paired: each pair is looked at.
const MOST_PAIRED: usize = 64;

/// Of topics none of which has all, two which have it together: that with the positions first.
fn pair(topics: &[Topic]) -> Option<(usize, usize)> {
    let names = |topic: &Topic| topic.usual().map_or_else(Vec::new, |(names, _)| names.clone());
    let usable: Vec<(usize, Vec<String>)> =
        topics.iter().take(MOST_PAIRED).map(names).enumerate().filter(|(_, names)| !names.is_empty()).collect();
    let mut best = None;
    for (first, own) in &usable {
        for (other, others) in usable.iter().filter(|(other, _)| other != first) {
            let together: Vec<String> =
                own.iter().chain(others.iter().filter(|name| !own.contains(name))).cloned().collect();
            let Ok(mapping) = Mapping::find(&together, &MappingSpec::default()) else { continue };
            if mapping.q.iter().all(|name| own.contains(name)) && !mapping.tau.iter().any(|name| own.contains(name)) {
                let values = topics[*first].values().min(topics[*other].values());
                best = best.max(Some((values, *first, *other)));
            }
        }
    }
    best.map(|(_, first, other)| (first, other))
}

/// One table of two topics, at the times of the first.
fn joined(topics: Vec<Topic>, first: usize, other: usize, budget: &mut Budget) -> Result<Table, McapError> {
    let (mut pair, mut rest) = (BTreeMap::new(), Vec::new());
    for (index, topic) in topics.into_iter().enumerate() {
        match index == first || index == other {
            true => drop(pair.insert(index, topic)),
            false => rest.push(topic.told()),
        }
    }
    let (Some(topic), Some(beside)) = (pair.remove(&first), pair.remove(&other)) else {
        return Err(McapError::NoStates(rest));
    };
    let [name, other_name] = [topic.name.clone(), beside.name.clone()];
    let (mut columns, clock, joints) = topic.columns(&mut rest);
    let (mut others, other_clock, other_joints) = beside.columns(&mut rest);
    others.retain(|column| columns.iter().all(|own| own.name != column.name));
    let (others, told) = clocks::beside(&clock, &other_clock, [&name, &other_name], others, budget)?;
    columns.extend(others);
    Ok(table(columns, &clock, joints.or(other_joints), vec![told], rest))
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
        read_topic(bytes, None)
    }

    fn read_topic(bytes: &[u8], topic: Option<&str>) -> Result<Table, McapError> {
        read(bytes, topic, &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new())
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

    #[test]
    fn positions_and_torques_of_two_topics_are_brought_to_one_clock() {
        let mut file = Cursor::new(Vec::new());
        let mut writer = ::mcap::WriteOptions::new().create(&mut file).unwrap();
        let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.as_bytes()).unwrap();
        let topics =
            ["/motion", "/torque"].map(|topic| writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap());
        for t in 0..200u32 {
            let value = f64::from(t) * 0.1;
            for (topic, late) in topics.into_iter().zip([0, 1_500_000_000]) {
                let channels = if late == 0 { [&[value][..], &[1.0], &[]] } else { [&[][..], &[], &[2.0 * value]] };
                let stamp = u64::from(t) * 10_000_000 + 5_000_000_000 + late;
                let message = CdrWriter::joint_state(
                    [(stamp / 1_000_000_000) as u32, (stamp % 1_000_000_000) as u32],
                    &["elbow"],
                    channels,
                );
                let log_time = u64::from(t) * 10_000_000 + 9_000_000_000;
                let header =
                    ::mcap::records::MessageHeader { channel_id: topic, sequence: t, log_time, publish_time: 0 };
                writer.write_to_known_channel(&header, &message).unwrap();
            }
        }
        writer.finish().unwrap();
        drop(writer);
        let table = table(&file.into_inner()).unwrap();
        assert_eq!(table.names(), ["time", "position[0]", "velocity[0]", "effort[0]"]);
        let values = |name: &str| table.column(name).unwrap().values.clone();
        assert!(values("effort[0]").iter().zip(values("position[0]")).all(|(tau, q)| (tau - 2.0 * q).abs() < 1e-9));
        assert!(table.clocks[0].is_moved && table.clocks[0].what.contains("-1500.000 ms apart"), "{:?}", table.clocks);
    }

    #[test]
    fn the_topic_that_is_asked_for_is_read_or_told_not_to_be_there() {
        let log = log(None);
        assert_eq!(read_topic(&log, Some("/joint_states")).unwrap().names().len(), 4);
        let problem = read_topic(&log, Some("/notes")).unwrap_err().to_string();
        assert!(problem.contains("no topic `/notes` with joint states") && problem.contains("`/joint_states`"));
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
