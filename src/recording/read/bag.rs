//! ROS 2 bags in SQLite (`.db3`): the topic with positions and torques becomes columns.
//!
//! A bag is a database with a table of topics and one of messages, each in CDR, the wire format of DDS; since ROS 2 Iron the definitions
//! of the messages stand in a third. Where they do not, `sensor_msgs/JointState` is read. SQLite reads the database from memory.
//!
//! A database may hold programs: views, triggers, computed columns, tables of other modules. A bag holds none of them, so one that
//! does is refused before its tables are asked anything; what is left is rows, which are read in the order of the file. Damaged
//! pages may lead round in circles: the steps of SQLite are counted, and so are the bytes of the messages.
//! Sources: rosbag2_storage_sqlite3; OMG, DDSI-RTPS 2.3, §10 (CDR encapsulation); SQLite, Defense Against The Dark Arts.

use std::collections::HashMap;
use std::io::Read;

use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::{Connection, ErrorCode, MAIN_DB};

use super::budget::{Budget, TooMuch};
use super::messages::Definition;
use super::share::Share;
use super::table::Table;
use super::topics::{TopicError, Topics};
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
    /// Its topics make no table.
    #[error(transparent)]
    Topics(#[from] TopicError),
    /// Something in it is computed, which could go on for ever.
    #[error("it is a database that computes (it holds {0}), which no bag does; export the log as CSV or NPZ")]
    Computes(String),
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Reads a bag; of several topics with positions and torques the one that is asked for, or that with the most numbers.
pub(super) fn read(bytes: &[u8], asked: &[String], budget: &mut Budget, monitor: &Monitor) -> Result<Table, BagError> {
    let database = open(bytes, monitor)?;
    let table = table(&database, bytes.len() as u64, asked, budget, monitor);
    // SQLite only says that it was interrupted.
    monitor.check()?;
    table
}

fn table(
    database: &Connection,
    size: u64,
    asked: &[String],
    budget: &mut Budget,
    monitor: &Monitor,
) -> Result<Table, BagError> {
    refuse_programs(database)?;
    let mut topics = topics(database, asked, budget)?;
    take_messages(database, &mut topics, size, budget, monitor)?;
    Ok(topics.table(budget)?)
}

const ENDLESS: &str = "its pages lead round in circles";

fn damaged(error: rusqlite::Error) -> BagError {
    match error.sqlite_error_code() {
        Some(ErrorCode::OperationInterrupted) => BagError::Damaged(ENDLESS.to_owned()),
        _ => BagError::Damaged(error.to_string()),
    }
}

fn open(bytes: &[u8], monitor: &Monitor) -> Result<Connection, BagError> {
    let needed = claimed_size(bytes);
    if (bytes.len() as u64) < needed {
        return Err(BagError::Damaged(format!("it ends after {} of {needed} bytes", bytes.len())));
    }
    // A bag that was written with a journal beside it says so here, and would ask for that file; it is complete without.
    const VERSIONS: std::ops::Range<usize> = 18..20;
    let cut_short = || BagError::Damaged("it ends within its header".to_owned());
    let versions: Vec<u8> =
        bytes.get(VERSIONS).ok_or_else(cut_short)?.iter().map(|version| (*version).min(1)).collect();
    let whole = bytes[..VERSIONS.start].chain(versions.as_slice()).chain(&bytes[VERSIONS.end..]);
    let mut database = Connection::open_in_memory().map_err(damaged)?;
    guard(&database, bytes.len(), monitor).map_err(damaged)?;
    database.deserialize_read_exact(MAIN_DB, whole, bytes.len(), true).map_err(damaged)?;
    database.execute_batch("PRAGMA cell_size_check = ON; PRAGMA query_only = ON").map_err(damaged)?;
    Ok(database)
}

/// Sets bounds to what a database of so many bytes can ask for.
fn guard(database: &Connection, size: usize, monitor: &Monitor) -> rusqlite::Result<()> {
    /// After so many steps of SQLite somebody may ask it to stop.
    const LOOK: i32 = 1000;
    /// What every bag may take, and what it may for each of its bytes: a row is longer than the steps that it takes.
    const LEAST_STEPS: u64 = 10_000_000;
    const STEPS: u64 = 4;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    // No row of a database is longer than it is itself.
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, i32::try_from(size).unwrap_or(i32::MAX))?;
    database.set_limit(Limit::SQLITE_LIMIT_EXPR_DEPTH, 50)?;
    database.set_limit(Limit::SQLITE_LIMIT_ATTACHED, 0)?;
    let mut looks = (LEAST_STEPS + STEPS * size as u64) / LOOK as u64;
    let monitor = monitor.clone();
    let is_enough = move || {
        looks = looks.saturating_sub(1);
        looks == 0 || monitor.check().is_err()
    };
    database.progress_handler(LOOK, Some(is_enough));
    Ok(())
}

/// A bag has tables and indices. SQLite stores each as the text that made it; what the other columns of its list say may be a lie.
fn refuse_programs(database: &Connection) -> Result<(), BagError> {
    let others = "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL AND sql NOT LIKE 'CREATE TABLE %' \
                  AND sql NOT LIKE 'CREATE INDEX %' AND sql NOT LIKE 'CREATE UNIQUE INDEX %'";
    let computed = "SELECT 'the computed column ' || name FROM pragma_table_xinfo(?1) WHERE hidden <> 0";
    let tables = ["topics", "messages", "message_definitions"].map(|table| (computed, Some(table)));
    for (query, of) in [(others, None)].into_iter().chain(tables) {
        let mut query = database.prepare(query).map_err(damaged)?;
        let mut found = query.query(rusqlite::params_from_iter(of)).map_err(damaged)?;
        if let Some(row) = found.next().map_err(damaged)? {
            let what: String = row.get(0).map_err(damaged)?;
            return Err(BagError::Computes(format!("`{}`", what.chars().take(60).collect::<String>())));
        }
    }
    Ok(())
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

/// The definitions of messages by their kinds: encoding and text. Bags have them since ROS 2 Iron.
fn definitions(database: &Connection, budget: &mut Budget) -> Result<HashMap<String, [String; 2]>, BagError> {
    let are_there = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'message_definitions'";
    let mut definitions = HashMap::new();
    if database.query_one(are_there, [], |row| row.get(0)).map_err(damaged)? {
        let all = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions NOT INDEXED";
        let mut query = database.prepare(all).map_err(damaged)?;
        let mut rows = query.query([]).map_err(damaged)?;
        while let Some(row) = rows.next().map_err(damaged)? {
            let text = |index| row.get::<_, String>(index).map_err(damaged);
            let (kind, definition) = (text(0)?, [text(1)?, text(2)?]);
            [&kind].into_iter().chain(&definition).try_for_each(|text| budget.text(text))?;
            definitions.insert(kind, definition);
        }
    }
    Ok(definitions)
}

/// The topics, and how the messages of each are read.
fn topics<'a>(database: &Connection, asked: &'a [String], budget: &mut Budget) -> Result<Topics<'a>, BagError> {
    let not_a_bag = |error: rusqlite::Error| match error.sqlite_error_code() {
        Some(ErrorCode::Unknown) => BagError::NoBag(error.to_string()),
        _ => damaged(error),
    };
    let mut query =
        database.prepare("SELECT id, name, type, serialization_format FROM topics NOT INDEXED").map_err(not_a_bag)?;
    let definitions = definitions(database, budget)?;
    let mut rows = query.query([]).map_err(damaged)?;
    let mut topics = Topics::asked_for(asked);
    while let Some(row) = rows.next().map_err(damaged)? {
        let text = |index| row.get::<_, String>(index).map_err(damaged);
        let (name, kind, format) = (text(1)?, text(2)?, text(3)?);
        let [encoding, definition] =
            definitions.get(&kind).map_or(["", ""], |texts| texts.each_ref().map(String::as_str));
        let definition = || match format.as_str() {
            "cdr" => Definition::of(&kind, encoding, definition),
            other => Err(format!("its messages are in `{other}`, not in CDR")),
        };
        topics.add(row.get(0).map_err(damaged)?, &name, &kind, definition, budget)?;
    }
    Ok(topics)
}

/// Gives the messages of a bag of `size` bytes to their topics.
fn take_messages(
    database: &Connection,
    topics: &mut Topics,
    size: u64,
    budget: &mut Budget,
    monitor: &Monitor,
) -> Result<(), BagError> {
    // SQLite would sort by writing all messages to another file.
    let mut query = database.prepare("SELECT topic_id, timestamp, data FROM messages NOT INDEXED").map_err(damaged)?;
    let mut rows = query.query([]).map_err(damaged)?;
    let mut taken = 0;
    let mut share = Share::of(size, monitor);
    while let Some(row) = rows.next().map_err(damaged)? {
        share.is(taken)?;
        let (topic, received) = (row.get(0).map_err(damaged)?, row.get(1).map_err(damaged)?);
        let data = row.get_ref(2).map_err(damaged)?;
        let data = data.as_blob().map_err(|error| BagError::Damaged(error.to_string()))?;
        taken += data.len() as u64;
        if taken > size {
            return Err(BagError::Damaged(ENDLESS.to_owned()));
        }
        if !topics.take(topic, received, data, budget)? {
            return Err(BagError::Damaged(format!("a message belongs to topic {topic}, which is not in its list")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::read::cdr::CdrWriter;

    const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

    fn message(stamp: u32, joints: &[&str], channels: [&[f64]; 3]) -> Vec<u8> {
        CdrWriter::joint_state([0, stamp], joints, channels)
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
        read(bytes, &[], &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new())
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
            let told = table.passed_over.join(";");
            let other = "1 messages of `/joint_states` of other joints than wrist_1_joint, elbow";
            assert!(told.contains("/rosout") && told.contains(other), "{told}");
        }
    }

    #[test]
    fn unstamped_messages_take_the_clock_of_the_bag() {
        let messages: Vec<_> = (0..20).map(|_| message(0, &["a"], [&[0.0], &[], &[1.0]])).collect();
        let table = parse(&bag(JOINT_STATE, &messages)).unwrap();
        assert!((table.column("time").unwrap().values[3] - 0.03).abs() < 1e-12);
    }

    /// Rows and topics stand in a bag in any order; numbers are those of the topic that is asked for, in the order of their arrival.
    #[test]
    fn of_several_topics_the_one_that_is_asked_for_is_read() {
        let database = Connection::open_in_memory().unwrap();
        let tables = "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
             INSERT INTO topics VALUES (7, '/right', 'sensor_msgs/msg/JointState', 'cdr'),
                 (3, '/left', 'sensor_msgs/msg/JointState', 'cdr'), (5, '/packed', 'sensor_msgs/msg/JointState', 'zip');";
        database.execute_batch(tables).unwrap();
        for number in (0..20).rev() {
            for (topic, sign) in [(7, 1.0), (3, -1.0)] {
                let message = message(0, &["a"], [&[sign * f64::from(number)], &[], &[sign]]);
                let row = (topic, number * 10_000_000, message);
                database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)", row).unwrap();
            }
        }
        let bytes = database.serialize(MAIN_DB).unwrap().to_vec();
        let budget = || Budget::of(bytes.len() as u64, 1 << 30);
        let asked =
            |topic: Option<&str>| read(&bytes, topic.map(str::to_owned).as_slice(), &mut budget(), &Monitor::new());
        for (topic, sign, others) in
            [(Some("/right"), 1.0, "/left"), (Some("/left"), -1.0, "/right"), (None, -1.0, "/right")]
        {
            let table = asked(topic).unwrap();
            let positions: Vec<f64> = (0..20).map(|number| sign * f64::from(number)).collect();
            assert_eq!(table.column("position[0]").unwrap().values, positions, "{topic:?}");
            let told = table.passed_over.join(";");
            assert!(told.contains("/packed") && told.contains(others), "{told}");
        }
        let missing = asked(Some("/middle")).unwrap_err();
        assert!(
            matches!(missing, BagError::Topics(TopicError::NoTopic { .. })) && missing.to_string().contains("/left"),
            "{missing}"
        );
    }

    #[test]
    fn other_databases_and_damaged_bags_are_clear_errors() {
        let error = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        assert!(
            error(&bag("std_msgs/msg/String", &messages())).contains("only topic `/joint_states` (std_msgs/msg/String")
        );
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

    /// Bags say since ROS 2 Iron how their messages are read; positions and torques may stand on two topics of them.
    #[test]
    fn messages_of_all_kinds_and_on_two_topics_are_read_by_the_definitions_of_the_bag() {
        let database = Connection::open_in_memory().unwrap();
        let tables = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
             CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT,
                 encoded_message_definition TEXT, type_description_hash TEXT);
             INSERT INTO topics VALUES (1, '/motion', 'my_msgs/msg/Motion', 'cdr'),
                 (2, '/torque', 'sensor_msgs/msg/JointState', 'cdr'), (3, '/other', 'my_msgs/msg/Other', 'cdr');
             INSERT INTO message_definitions VALUES (1, 'my_msgs/msg/Motion', 'ros2msg',
                 'string[] joint_names' || char(10) || 'float64[2] position', ''), (2, 'my_msgs/msg/Other', 'unknown', '', '');";
        database.execute_batch(tables).unwrap();
        for number in 0..20 {
            let value = f64::from(number);
            let mut motion = CdrWriter::new();
            motion.texts(&["a", "b"]).word(value.to_le_bytes()).word((-value).to_le_bytes());
            let torque = message(0, &["b", "a"], [&[], &[], &[-2.0 * value, 2.0 * value]]);
            for (topic, data) in [(1, motion.end()), (2, torque), (3, vec![0])] {
                let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
                database.execute(insert, (topic, number * 10_000_000, data)).unwrap();
            }
        }
        let table = parse(&database.serialize(MAIN_DB).unwrap()).unwrap();
        assert_eq!(table.joints.as_deref().unwrap(), ["a", "b"]);
        let last = |name: &str| *table.column(name).unwrap().values.last().unwrap();
        assert_eq!(["position[0]", "position[1]", "effort[0]", "effort[1]"].map(last), [19.0, -19.0, 38.0, -38.0]);
        let told = table.passed_over.join(";");
        assert!(told.contains("`/other` (my_msgs/msg/Other, 20 messages, its definition is in `unknown`"), "{told}");
    }

    fn database(statements: &str) -> Vec<u8> {
        let database = Connection::open_in_memory().unwrap();
        database.execute_batch(statements).unwrap();
        database.serialize(MAIN_DB).unwrap().to_vec()
    }

    const TOPICS: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
         INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr');";

    /// Asked for their rows, each would go on for ever, or take all memory there is.
    #[test]
    fn a_bag_that_computes_is_refused_before_it_is_asked() {
        let endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)";
        let view = format!(
            "CREATE VIEW messages AS {endless} SELECT i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data FROM n;"
        );
        let module = "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data);";
        let column = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, \
                      data BLOB GENERATED ALWAYS AS (zeroblob(900000000)));
                      INSERT INTO messages(topic_id, timestamp) VALUES (1, 1);";
        let topics = format!(
            "CREATE VIEW topics AS {endless} SELECT i AS id, 'a' AS name, 'b' AS type, 'c' AS serialization_format FROM n;"
        );
        for messages in [view.as_str(), module, column] {
            let error = parse(&database(&format!("{TOPICS}{messages}"))).unwrap_err();
            assert!(matches!(error, BagError::Computes(_)), "{messages}: {error}");
        }
        assert!(parse(&database(&topics)).unwrap_err().to_string().contains("CREATE VIEW topics"));
    }

    /// The list of a database may call a view a table.
    #[test]
    fn a_view_that_is_listed_as_a_table_is_refused() {
        let lie = "CREATE VIEW messages AS SELECT 1 AS topic_id, 2 AS timestamp, x'00' AS data;
                   PRAGMA writable_schema = ON;
                   UPDATE sqlite_master SET type = 'table', rootpage = 2 WHERE name = 'messages';";
        let error = parse(&database(&format!("{TOPICS}{lie}"))).unwrap_err();
        assert!(matches!(error, BagError::Computes(_) | BagError::Damaged(_)), "{error}");
    }

    /// An inner page leads to another one many times, and that to one leaf: more rows than the file has room for.
    #[test]
    fn pages_that_lead_round_in_circles_end() {
        const INNER: u8 = 5;
        let mut bytes = bag(JOINT_STATE, &(0..40).flat_map(|_| messages()).collect::<Vec<_>>());
        let size = usize::from(u16::from_be_bytes([bytes[16], bytes[17]]));
        let root = (1..bytes.len() / size).find(|page| bytes[page * size] == INNER).unwrap() * size;
        let number = |bytes: &[u8], at: usize| usize::from(u16::from_be_bytes([bytes[at], bytes[at + 1]]));
        let cells = number(&bytes, root + 3);
        assert!(cells > 10, "{cells}");
        // Where the numbers of the next pages stand: one for each cell, and the last in the head of the page.
        let places: Vec<usize> = (0..cells).map(|cell| number(&bytes, root + 12 + 2 * cell)).chain([8]).collect();
        let next = |bytes: &[u8], place: usize| bytes[root + place..][..4].to_vec();
        let (leaf, other) = (next(&bytes, places[0]), next(&bytes, places[1]));
        let other_page = (u32::from_be_bytes([other[0], other[1], other[2], other[3]]) as usize - 1) * size;
        places.iter().for_each(|place| bytes[root + place..][..4].copy_from_slice(&leaf));
        bytes.copy_within(root..root + size, other_page);
        places.iter().for_each(|place| bytes[root + place..][..4].copy_from_slice(&other));
        let error = parse(&bytes).unwrap_err().to_string();
        assert!(error.contains(ENDLESS), "{error}");
    }

    #[test]
    fn a_stop_is_heard() {
        let (whole, monitor) = (bag(JOINT_STATE, &messages()), Monitor::new());
        monitor.stop("enough");
        let stopped = read(&whole, &[], &mut Budget::of(whole.len() as u64, 1 << 30), &monitor);
        assert!(matches!(stopped, Err(BagError::Stopped(_))));
    }
}
