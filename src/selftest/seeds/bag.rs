//! Writes ROS 2 bags: joint states in CDR, in a database.

use rusqlite::{Connection, MAIN_DB};

use crate::recording::Trajectory;
use crate::selftest::SelftestError;

/// What a bag is made of before there is a message in it.
const TABLES: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
     CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
     INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr');";

fn failed(error: rusqlite::Error) -> SelftestError {
    SelftestError::making("a database")(&error)
}

/// A database that these statements make.
pub fn database(statements: &str) -> Result<Vec<u8>, SelftestError> {
    let database = Connection::open_in_memory().map_err(failed)?;
    database.execute_batch(statements).map_err(failed)?;
    Ok(database.serialize(MAIN_DB).map_err(failed)?.to_vec())
}

/// A run as a bag.
pub fn joint_states(run: &Trajectory) -> Result<Vec<u8>, SelftestError> {
    let database = Connection::open_in_memory().map_err(failed)?;
    database.execute_batch(TABLES).map_err(failed)?;
    for (sample, time) in run.time.iter().enumerate() {
        let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?1, ?2)";
        database.execute(insert, ((time * 1e9) as i64, message(run, sample, *time))).map_err(failed)?;
    }
    Ok(database.serialize(MAIN_DB).map_err(failed)?.to_vec())
}

fn message(run: &Trajectory, sample: usize, time: f64) -> Vec<u8> {
    /// Alignment counts from behind the four bytes of the encapsulation.
    fn pad(bytes: &mut Vec<u8>, alignment: usize) {
        bytes.resize((bytes.len() - 4).next_multiple_of(alignment) + 4, 0);
    }
    fn word(bytes: &mut Vec<u8>, value: u32) {
        pad(bytes, 4);
        bytes.extend(value.to_le_bytes());
    }
    let mut bytes = vec![0, 1, 0, 0];
    for value in [time as u32, (time.fract() * 1e9).round() as u32, 1] {
        word(&mut bytes, value);
    }
    // The frame is the empty text.
    bytes.push(0);
    word(&mut bytes, run.joint_count() as u32);
    for joint in 1..=run.joint_count() {
        let name = format!("joint_{joint}");
        word(&mut bytes, name.len() as u32 + 1);
        bytes.extend(name.as_bytes());
        bytes.push(0);
    }
    for signal in [&run.q, &run.qd, &run.tau] {
        word(&mut bytes, run.joint_count() as u32);
        pad(&mut bytes, 8);
        signal.at(sample).for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    bytes
}
