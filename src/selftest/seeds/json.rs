//! Writes JSON, with five digits behind the point: arrays by key, or an object a sample.

use serde_json::json;

use super::channels;
use crate::recording::Trajectory;

/// A run as arrays by key.
pub fn arrays(run: &Trajectory) -> Vec<u8> {
    let mut arrays = json!({ "time": rounded(&run.time) });
    for (name, signal) in channels(run) {
        let samples = (0..run.len()).map(|sample| rounded(&signal.at(sample).collect::<Vec<_>>()));
        arrays[name] = json!(samples.collect::<Vec<_>>());
    }
    arrays.to_string().into_bytes()
}

/// A run as JSON Lines.
pub fn lines(run: &Trajectory) -> Vec<u8> {
    let mut lines = String::new();
    for (sample, time) in run.time.iter().enumerate() {
        let mut line = json!({ "t": rounded(&[*time])[0] });
        for (name, signal) in channels(run) {
            line[name] = json!(rounded(&signal.at(sample).collect::<Vec<_>>()));
        }
        lines.push_str(&line.to_string());
        lines.push('\n');
    }
    lines.into_bytes()
}

fn rounded(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| (1e5 * value).round() / 1e5).collect()
}
