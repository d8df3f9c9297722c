//! One sample as a message of ROS 2.

use crate::recording::Trajectory;
use crate::recording::read::cdr::CdrWriter;

/// The sample of a run as a `sensor_msgs/JointState`.
pub fn joint_state(run: &Trajectory, sample: usize) -> Vec<u8> {
    let time = run.time[sample];
    let names = names(run);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let [q, qd, tau] = [&run.q, &run.qd, &run.tau].map(|signal| signal.at(sample).collect::<Vec<f64>>());
    CdrWriter::joint_state([time as u32, (time.fract() * 1e9).round() as u32], &names, [&q, &qd, &tau])
}

/// Names of its joints.
pub fn names(run: &Trajectory) -> Vec<String> {
    (1..=run.joint_count()).map(|joint| format!("joint_{joint}")).collect()
}
