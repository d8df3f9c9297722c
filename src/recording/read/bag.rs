//! ROS 2 bags in SQLite (`.db3`): the joint states in it, as columns.
//!
//! A bag is a database with a table of topics and one of messages, each a `sensor_msgs/JointState` in CDR, the wire format
//! of DDS. SQLite reads the database from memory; nothing in it can run.
//! Sources: rosbag2_storage_sqlite3; OMG, DDSI-RTPS 2.3, §10 (CDR encapsulation).

use std::collections::BTreeMap;

use rusqlite::{Connection, MAIN_DB};

use super::table::{Column, Table};
use crate::progress::{Monitor, Stopped};

/// The bag can't be read.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// SQLite finds it damaged.
    #[error("the bag is damaged ({0}); copy it again, or mend it with `ros2 bag reindex`")]
    Damaged(String),
    /// Another database.
    #[error("it is an SQLite database, but no ROS 2 bag ({0}); export the log as CSV or NPZ")]
    NoBag(String),
    /// Other messages only.
    #[error("the bag holds no `{JOINT_STATE}`{}; record the topic /joint_states", also(.0))]
    NoJointStates(Vec<String>),
    /// A message that is cut or lies about its sizes.
    #[error("message {number} of `{topic}` is damaged: {problem}; copy or record the bag again")]
    Message {
        /// Counted from 1.
        number: usize,
        /// Its topic.
        topic: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// It would take too much memory.
    #[error("its joint states take more than {limit} MB; cut the bag into several, or raise the limit")]
    TooLarge {
        /// What is allowed \[MB\].
        limit: u64,
    },
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

fn also(topics: &[String]) -> String {
    if topics.is_empty() { String::new() } else { format!(", only {}", topics.join(", ")) }
}

const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

/// Reads a bag; its joint states may take `limit` bytes.
pub(super) fn read(bytes: &[u8], limit: u64, monitor: &Monitor) -> Result<Table, BagError> {
    let database = open(bytes)?;
    let (topics, passed_over) = topics(&database)?;
    // One topic is read; a bag of a single arm has no other.
    let Some((topic, name)) = topics.first() else {
        return Err(BagError::NoJointStates(passed_over));
    };
    let mut passed_over: Vec<String> = passed_over.into_iter().map(|topic| format!("topic {topic}")).collect();
    let others = topics.iter().skip(1).map(|(_, name)| format!("topic `{name}` (joint states again)"));
    passed_over.extend(others);

    let states = states(&database, *topic, name, limit, monitor)?;
    Ok(table(states, passed_over))
}

fn damaged(error: rusqlite::Error) -> BagError {
    BagError::Damaged(error.to_string())
}

fn open(bytes: &[u8]) -> Result<Connection, BagError> {
    let needed = claimed_size(bytes);
    if (bytes.len() as u64) < needed {
        return Err(BagError::Damaged(format!("it ends after {} of {needed} bytes", bytes.len())));
    }
    let mut bytes = bytes.to_vec();
    // A bag that was written with a journal beside it says so here, and would ask for that file; it is complete without.
    const WRITE_VERSION: usize = 18;
    const READ_VERSION: usize = 19;
    for at in [WRITE_VERSION, READ_VERSION] {
        if let Some(version) = bytes.get_mut(at) {
            *version = (*version).min(1);
        }
    }
    let mut database = Connection::open_in_memory().map_err(damaged)?;
    let size = bytes.len();
    database.deserialize_read_exact(MAIN_DB, bytes.as_slice(), size, true).map_err(damaged)?;
    Ok(database)
}

/// How long the database says it is; SQLite itself reads a cut one as far as it goes.
fn claimed_size(bytes: &[u8]) -> u64 {
    let number = |range: std::ops::Range<usize>| {
        bytes.get(range).map_or(0, |bytes| bytes.iter().fold(0u64, |sum, byte| sum << 8 | u64::from(*byte)))
    };
    let page = match number(16..18) {
        1 => 1 << 16,
        size => size,
    };
    page * number(28..32)
}

/// A topic's number and name.
type Topic = (i64, String);

/// The topics with joint states, and descriptions of the others.
fn topics(database: &Connection) -> Result<(Vec<Topic>, Vec<String>), BagError> {
    let not_a_bag = |error: rusqlite::Error| match error.sqlite_error_code() {
        Some(rusqlite::ErrorCode::Unknown) => BagError::NoBag(error.to_string()),
        _ => damaged(error),
    };
    let mut query =
        database.prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id").map_err(not_a_bag)?;
    let mut rows = query.query([]).map_err(damaged)?;
    let (mut topics, mut others) = (Vec::new(), Vec::new());
    while let Some(row) = rows.next().map_err(damaged)? {
        let text = |index| row.get::<_, String>(index).map_err(damaged);
        let (name, kind, format) = (text(1)?, text(2)?, text(3)?);
        if kind == JOINT_STATE && format == "cdr" {
            topics.push((row.get(0).map_err(damaged)?, name));
        } else {
            others.push(format!("`{name}` ({kind}, {format})"));
        }
    }
    Ok((topics, others))
}

/// One message.
#[derive(Debug, Default, PartialEq)]
struct State {
    /// When the bag received it \[ns\].
    received: i64,
    /// When it was measured \[ns\].
    stamp: i64,
    joints: Vec<String>,
    /// Position, velocity, effort: one value a joint, or none.
    channels: [Vec<f64>; 3],
}

fn states(
    database: &Connection,
    topic: i64,
    name: &str,
    limit: u64,
    monitor: &Monitor,
) -> Result<Vec<State>, BagError> {
    let mut query = database
        .prepare("SELECT timestamp, data FROM messages WHERE topic_id = ?1 ORDER BY timestamp, id")
        .map_err(damaged)?;
    let mut rows = query.query([topic]).map_err(damaged)?;
    let mut states = Vec::new();
    let mut taken = 0;
    while let Some(row) = rows.next().map_err(damaged)? {
        monitor.check()?;
        let data = row.get_ref(1).map_err(damaged)?;
        let data = data.as_blob().map_err(|error| BagError::Damaged(error.to_string()))?;
        taken += 2 * data.len() as u64;
        if taken > limit {
            return Err(BagError::TooLarge { limit: limit >> 20 });
        }
        let number = states.len() + 1;
        let state = joint_state(data);
        let mut state = state.map_err(|problem| BagError::Message { number, topic: name.to_owned(), problem })?;
        state.received = row.get(0).map_err(damaged)?;
        states.push(state);
    }
    Ok(states)
}

/// Decodes one `sensor_msgs/JointState`.
fn joint_state(message: &[u8]) -> Result<State, &'static str> {
    let mut cdr = Cdr::new(message)?;
    let seconds = i64::from(cdr.u32()? as i32);
    let stamp = seconds * 1_000_000_000 + i64::from(cdr.u32()?);
    cdr.text()?; // the frame
    let count = cdr.count(4)?;
    let joints = (0..count).map(|_| cdr.text()).collect::<Result<Vec<_>, _>>()?;
    let mut channels = [const { Vec::new() }; 3];
    for channel in &mut channels {
        *channel = cdr.numbers()?;
        if !channel.is_empty() && channel.len() != joints.len() {
            return Err("it has another number of values than of joints");
        }
    }
    Ok(State { received: 0, stamp, joints, channels })
}

/// Columns of the messages with the joints that most of them have.
fn table(states: Vec<State>, mut passed_over: Vec<String>) -> Table {
    let all = states.len();
    let mut values: BTreeMap<&Vec<String>, usize> = BTreeMap::new();
    for state in &states {
        *values.entry(&state.joints).or_default() += state.joints.len();
    }
    let joints =
        values.into_iter().max_by_key(|(_, values)| *values).map_or_else(Vec::new, |(joints, _)| joints.clone());
    let states: Vec<State> = states.into_iter().filter(|state| state.joints == joints).collect();
    if states.len() < all {
        passed_over.push(format!("{} messages of other joints than {}", all - states.len(), joints.join(", ")));
    }

    // The time of the measurement, unless nobody stamped it.
    let stamped = states.windows(2).all(|pair| pair[1].stamp > pair[0].stamp);
    let clock = |state: &State| if stamped { state.stamp } else { state.received };
    let start = states.first().map_or(0, clock);
    let column = |name: String, values| Column { name, values, text: None };
    let seconds = states.iter().map(|state| (clock(state) - start) as f64 * 1e-9).collect();
    let mut columns = vec![column("time".to_owned(), seconds)];
    for (channel, name) in ["position", "velocity", "effort"].into_iter().enumerate() {
        if states.iter().all(|state| state.channels[channel].is_empty()) {
            continue;
        }
        for joint in 0..joints.len() {
            let value = |state: &State| state.channels[channel].get(joint).copied().unwrap_or(f64::NAN);
            columns.push(column(format!("{name}[{joint}]"), states.iter().map(value).collect()));
        }
    }
    let runs = std::iter::once(0..states.len()).collect();
    Table { columns, runs, joints: Some(joints), passed_over, ..Table::default() }
}

/// A CDR message, read from the front.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> Cdr<'a> {
    fn new(message: &'a [u8]) -> Result<Self, &'static str> {
        match message {
            [0, order @ (0 | 1), _, _, bytes @ ..] => Ok(Cdr { bytes, at: 0, big_endian: *order == 0 }),
            _ => Err("it is not in plain CDR"),
        }
    }

    /// The next bytes; numbers stand at multiples of their size.
    fn take(&mut self, count: usize, alignment: usize) -> Result<&'a [u8], &'static str> {
        let start = self.at.next_multiple_of(alignment);
        let end = start.checked_add(count).ok_or("it claims an impossible size")?;
        self.at = end;
        self.bytes.get(start..end).ok_or("it ends too early")
    }

    fn u32(&mut self) -> Result<u32, &'static str> {
        let bytes: [u8; 4] = self.take(4, 4)?.try_into().map_err(|_| "it ends too early")?;
        Ok(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// How many elements follow, each of at least `size` bytes.
    fn count(&mut self, size: usize) -> Result<usize, &'static str> {
        let count = self.u32()? as usize;
        let left = self.bytes.len().saturating_sub(self.at);
        if count.saturating_mul(size) > left { Err("it claims more elements than there are") } else { Ok(count) }
    }

    fn text(&mut self) -> Result<String, &'static str> {
        let length = self.count(1)?;
        let bytes = self.take(length, 1)?;
        Ok(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned())
    }

    fn numbers(&mut self) -> Result<Vec<f64>, &'static str> {
        let count = self.count(8)?;
        let number = |bytes: &[u8]| {
            let mut word = [0; 8];
            word.copy_from_slice(bytes);
            if self.big_endian { f64::from_be_bytes(word) } else { f64::from_le_bytes(word) }
        };
        let bytes = if count == 0 { &[] } else { self.bytes.get(self.at.next_multiple_of(8)..).unwrap_or_default() };
        let values: Vec<f64> = bytes.chunks_exact(8).take(count).map(number).collect();
        if values.len() != count {
            return Err("it ends too early");
        }
        if count > 0 {
            self.at = self.at.next_multiple_of(8) + 8 * count;
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(stamp: u32, joints: &[&str], channels: [&[f64]; 3]) -> Vec<u8> {
        fn pad(bytes: &mut Vec<u8>, alignment: usize) {
            bytes.resize((bytes.len() - 4).next_multiple_of(alignment) + 4, 0);
        }
        fn word(bytes: &mut Vec<u8>, value: u32) {
            pad(bytes, 4);
            bytes.extend(value.to_le_bytes());
        }
        let mut bytes = vec![0, 1, 0, 0];
        for value in [0, stamp, 1] {
            word(&mut bytes, value);
        }
        bytes.push(0); // the frame is the empty text
        word(&mut bytes, joints.len() as u32);
        for joint in joints {
            word(&mut bytes, joint.len() as u32 + 1);
            bytes.extend(joint.as_bytes());
            bytes.push(0);
        }
        for channel in channels {
            word(&mut bytes, channel.len() as u32);
            if !channel.is_empty() {
                pad(&mut bytes, 8);
                channel.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
            }
        }
        bytes
    }

    fn bag(kind: &str, messages: &[Vec<u8>]) -> Vec<u8> {
        let database = Connection::open_in_memory().unwrap();
        database
            .execute_batch(
                "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
                 CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);",
            )
            .unwrap();
        let topic = "INSERT INTO topics VALUES (1, '/joint_states', ?1, 'cdr'), (2, '/rosout', 'rcl/Log', 'cdr')";
        database.execute(topic, [kind]).unwrap();
        for (number, message) in messages.iter().enumerate() {
            let row = (number as i64 * 10_000_000, message);
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?1, ?2)", row).unwrap();
        }
        database.serialize(MAIN_DB).unwrap().to_vec()
    }

    fn messages() -> Vec<Vec<u8>> {
        let message = |number: u32| {
            let value = f64::from(number);
            message(number * 8_000_000, &["wrist_1_joint", "elbow"], [&[value, 1.0], &[], &[-value, 2.0]])
        };
        (0..40).map(message).collect()
    }

    fn parse(bytes: &[u8]) -> Result<Table, BagError> {
        read(bytes, 1 << 20, &Monitor::new())
    }

    #[test]
    fn joint_states_become_columns_on_the_clock_of_the_measurement() {
        let mut messages = messages();
        messages.push(message(0, &["gripper"], [&[0.1], &[], &[]]));
        let mut bytes = bag(JOINT_STATE, &messages);
        for journal in [false, true] {
            if journal {
                bytes[18..20].copy_from_slice(&[2, 2]);
            }
            let table = parse(&bytes).unwrap();
            assert_eq!(table.names(), ["time", "position[0]", "position[1]", "effort[0]", "effort[1]"]);
            assert_eq!(table.joints.as_deref().unwrap(), ["wrist_1_joint", "elbow"]);
            assert!((table.column("time").unwrap().values[3] - 0.024).abs() < 1e-12);
            assert_eq!(table.column("effort[0]").unwrap().values[3], -3.0);
            assert!(table.passed_over[0].contains("/rosout") && table.passed_over[1].contains("1 messages of other"));
        }
    }

    #[test]
    fn unstamped_messages_take_the_clock_of_the_bag() {
        let messages: Vec<_> = (0..20).map(|_| message(0, &["a"], [&[0.0], &[], &[1.0]])).collect();
        let table = parse(&bag(JOINT_STATE, &messages)).unwrap();
        assert!((table.column("time").unwrap().values[3] - 0.03).abs() < 1e-12);
    }

    #[test]
    fn other_databases_and_damaged_bags_are_clear_errors() {
        let error = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        assert!(error(&bag("std_msgs/msg/String", &messages())).contains("only `/joint_states` (std_msgs/msg/String"));
        let other = Connection::open_in_memory().unwrap();
        other.execute_batch("CREATE TABLE songs(id INTEGER)").unwrap();
        assert!(error(&other.serialize(MAIN_DB).unwrap()).contains("no ROS 2 bag"));
        let mut cut = messages();
        let half = cut[2].len() / 2;
        cut[2].truncate(half);
        let text = error(&bag(JOINT_STATE, &cut));
        assert!(text.contains("message 3 of `/joint_states` is damaged"), "{text}");
        let whole = bag(JOINT_STATE, &messages());
        for end in (0..whole.len()).step_by(97) {
            assert!(parse(&whole[..end]).is_err(), "{end}");
        }
        for at in (16..whole.len()).step_by(31) {
            let mut damaged = whole.clone();
            damaged[at] ^= 0xff;
            let _ = parse(&damaged); // an error or other numbers, but no panic
        }
    }
}
