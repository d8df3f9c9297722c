//! Writes MCAP logs: joint states in chunks, as rosbag2 does.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::mcap::records::MessageHeader;
use ::mcap::{Compression, McapError, WriteOptions};

use super::message;
use crate::recording::Trajectory;
use crate::selftest::SelftestError;

/// What rosbag2 says of a joint state.
const DEFINITION: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
    ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

/// A run as a log whose chunks are packed in this way.
pub fn joint_states(run: &Trajectory, compression: Option<Compression>) -> Result<Vec<u8>, SelftestError> {
    written(run, compression).map_err(|error| SelftestError::making("a log of messages")(&error))
}

fn written(run: &Trajectory, compression: Option<Compression>) -> Result<Vec<u8>, McapError> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = WriteOptions::new().compression(compression).create(&mut file)?;
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", DEFINITION.as_bytes())?;
    let channel_id = writer.add_channel(schema, "/joint_states", "cdr", &BTreeMap::new())?;
    for (sample, time) in run.time.iter().enumerate() {
        let log_time = (time * 1e9) as u64;
        let header = MessageHeader { channel_id, sequence: sample as u32, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &message::joint_state(run, sample))?;
    }
    writer.finish()?;
    drop(writer);
    Ok(file.into_inner())
}
