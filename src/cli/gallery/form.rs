//! A recording as a log in one of the formats that are read: as loggers write them, without acceleration.

use std::fmt::Write as _;

use zip::CompressionMethod;

use crate::recording::table::Table;
use crate::recording::write::{Form, to_npz_bytes};
use crate::recording::{Recording, Trajectory};
use crate::selftest::seeds::{self, bag, channels, hdf5, json, mat, mcap, pickle};

/// The files of a log, by what stands behind the name of the sample.
pub type Log = anyhow::Result<Vec<(&'static str, Vec<u8>)>>;

/// A column of a text: its title and its values.
type Column = (String, Vec<f64>);

/// CSV with commas.
pub fn csv(recording: &Recording) -> Log {
    Ok(vec![(".csv", text(&columns(&recording.trajectories[0]), ",", |value| value))])
}

/// The same, packed.
pub fn packed_csv(recording: &Recording) -> Log {
    Ok(vec![(".csv.gz", seeds::gzip(&text(&columns(&recording.trajectories[0]), ",", |value| value))?)])
}

/// CSV as spreadsheets write it where numbers have commas; angles in degrees.
pub fn semicolons(recording: &Recording) -> Log {
    let mut columns = columns(&recording.trajectories[0]);
    for (title, values) in &mut columns {
        let (unit, factor) = match title.trim_end_matches(char::is_numeric) {
            "time" => ("s", 1.0),
            "q" => ("deg", 1f64.to_degrees()),
            "qd" => ("deg/s", 1f64.to_degrees()),
            _ => ("Nm", 1.0),
        };
        *title = format!("{title} [{unit}]");
        values.iter_mut().for_each(|value| *value *= factor);
    }
    Ok(vec![(".csv", text(&columns, ";", |number| number.replace('.', ",")))])
}

/// CSV without a clock, whose columns have numbers for names.
pub fn nameless(recording: &Recording) -> Log {
    let mut columns = columns(&recording.trajectories[0]);
    columns.remove(0);
    for (number, (title, _)) in columns.iter_mut().enumerate() {
        *title = format!("ch{}", number + 1);
    }
    Ok(vec![(".csv", text(&columns, ",", |number| number))])
}

/// A text with tabs, time in milliseconds, and no velocity.
pub fn tabs(recording: &Recording) -> Log {
    let mut columns = columns(&recording.trajectories[0]);
    columns.retain(|(title, _)| !title.starts_with("qd"));
    for (title, values) in &mut columns {
        if title == "time" {
            *title = "time_ms".to_owned();
            values.iter_mut().for_each(|value| *value *= 1e3);
        }
    }
    Ok(vec![(".txt", text(&columns, "\t", |number| number))])
}

/// JSON: arrays by key.
pub fn json(recording: &Recording) -> Log {
    Ok(vec![(".json", json::arrays(&recording.trajectories[0]))])
}

/// JSON Lines: an object a sample.
pub fn json_lines(recording: &Recording) -> Log {
    Ok(vec![(".jsonl", json::lines(&recording.trajectories[0]))])
}

/// NPZ in our own layout. The seal stands beside it.
pub fn own_npz(recording: &Recording) -> Log {
    let open = Recording { seal: None, ..recording.clone() };
    Ok(vec![(".npz", to_npz_bytes(&open)?)])
}

/// NPZ as numpy writes it, packed.
pub fn npz(recording: &Recording) -> Log {
    Ok(vec![(".npz", seeds::archive(&recording.trajectories[0], CompressionMethod::Deflated)?)])
}

/// A folder of NPY arrays.
pub fn npy(recording: &Recording) -> Log {
    let names = ["/t.npy", "/q.npy", "/qd.npy", "/tau.npy"];
    let arrays = seeds::arrays(&recording.trajectories[0]);
    Ok(names.into_iter().zip(arrays.into_iter().map(|(_, bytes)| bytes)).collect())
}

/// MATLAB: a matrix a channel.
pub fn matrices(recording: &Recording) -> Log {
    Ok(vec![(".mat", mat::plain(&recording.trajectories[0]))])
}

/// MATLAB: a struct, compressed.
pub fn structure(recording: &Recording) -> Log {
    Ok(vec![(".mat", mat::packed(&recording.trajectories[0])?)])
}

/// HDF5: a dataset a channel.
pub fn hdf5(recording: &Recording) -> Log {
    Ok(vec![(".h5", hdf5::datasets(&recording.trajectories[0]))])
}

/// Parquet in LeRobot's words.
pub fn parquet(recording: &Recording) -> Log {
    let run = &recording.trajectories[0];
    let mut table = Table::default();
    table.extend("timestamp", &run.time);
    for (name, (_, signal)) in ["state", "velocity", "effort"].into_iter().zip(channels(run)) {
        for (joint, values) in signal.iter().enumerate() {
            table.extend(&format!("observation.{name}.{joint}"), values);
        }
    }
    Ok(vec![(".parquet", table.to_bytes(Form::Parquet)?)])
}

/// A Python pickle: a dict of arrays.
pub fn pickle(recording: &Recording) -> Log {
    Ok(vec![(".pickle", pickle::arrays(&recording.trajectories[0]))])
}

/// A ROS 2 bag in SQLite.
pub fn ros_bag(recording: &Recording) -> Log {
    Ok(vec![(".db3", bag::joint_states(&recording.trajectories[0])?)])
}

/// A ROS 2 bag in MCAP.
pub fn ros_mcap(recording: &Recording) -> Log {
    Ok(vec![(".mcap", mcap::joint_states(&recording.trajectories[0], Some(::mcap::Compression::Zstd))?)])
}

/// Time and channels, a column each joint.
fn columns(run: &Trajectory) -> Vec<Column> {
    let clock = ("time".to_owned(), run.time.clone());
    let signals = channels(run).into_iter().flat_map(|(name, signal)| {
        let named = move |(joint, values): (usize, &[f64])| (format!("{name}{}", joint + 1), values.to_vec());
        signal.iter().enumerate().map(named).collect::<Vec<_>>()
    });
    std::iter::once(clock).chain(signals).collect()
}

fn text(columns: &[Column], delimiter: &str, cell: impl Fn(String) -> String) -> Vec<u8> {
    let titles: Vec<&str> = columns.iter().map(|(title, _)| title.as_str()).collect();
    let mut text = titles.join(delimiter) + "\n";
    for row in 0..columns[0].1.len() {
        let cells: Vec<String> = columns.iter().map(|(_, values)| cell(format!("{:.5}", values[row]))).collect();
        // Writing to a String can't fail.
        let _ = writeln!(text, "{}", cells.join(delimiter));
    }
    text.into_bytes()
}
