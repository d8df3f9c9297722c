//! Writes ROS 2 bags: joint states in a database.

use rusqlite::{Connection, MAIN_DB};

use super::message;
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
        database.execute(insert, ((time * 1e9) as i64, message::joint_state(run, sample))).map_err(failed)?;
    }
    Ok(database.serialize(MAIN_DB).map_err(failed)?.to_vec())
}
