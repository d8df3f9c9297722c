//! No target: writes small clean files of every kind to begin from, into `tests/fuzz/corpus/TARGET`. Once is enough: `-runs=1`.

#![no_main]

use std::path::Path;
use std::sync::Once;

use torquescope::experiment::catalogue as experiments;
use torquescope::model::learned::{Layers, LearnedPreset};
use torquescope::progress::Monitor;
use torquescope::recording::catalogue as mappings;
use torquescope::recording::hold_out::HoldOut;
use torquescope::recording::read::ReadOptions;
use torquescope::selftest::seeds::{self, arms};
use torquescope::session::{self, Command, Session, SessionError};
use torquescope::simulation::Scenario;
use torquescope::training::Options;
use torquescope::training::fit::{self, Plan};

libfuzzer_sys::fuzz_target!(|_bytes: &[u8]| {
    static WRITTEN: Once = Once::new();
    WRITTEN.call_once(|| {
        (0..3).for_each(logs);
        documents().expect("a session can be made");
    });
});

fn write(target: &str, name: &str, bytes: &[u8]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    std::fs::write(folder.join(name), bytes).expect("a file can be written");
}

/// Of which target a log is.
fn target(name: &str) -> &str {
    match name.rsplit('.').next() {
        Some("npz") => "npz",
        Some("npy") => "npy",
        Some("mat") => "mat",
        Some("db3") => "bag",
        Some("mcap") => "mcap",
        Some("h5") => "hdf5",
        Some("parquet") => "parquet",
        Some("pickle") => "pickle",
        Some("json" | "jsonl") => "json",
        _ => "csv",
    }
}

fn logs(number: u64) {
    let recording = torquescope_fuzz::clean(number);
    for log in seeds::files(&recording, number as usize).expect("a log can be written") {
        for (name, bytes) in &log.files {
            write(target(name), &format!("{number}-{name}"), bytes);
        }
    }
}

fn documents() -> Result<(), SessionError> {
    let monitor = Monitor::new();
    let log = torquescope_fuzz::folder().join("clean.npz");
    let loaded = Command::open(vec![log], ReadOptions::default(), HoldOut::default()).run(&Session::default(), &monitor)?;
    let add = Command::AddEffect { effect: Scenario::embedded().effects.swap_remove(0).effect, joints: vec![0] };
    let solved = add.run(&loaded, &monitor)?;
    let options = Options { epochs: 2, batch: 16, ..Options::ours() };
    let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
    let train = Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: Box::new(plan) };
    let trained = train.run(&solved, &monitor)?;
    for (name, session) in [("solved", &solved), ("trained", &trained)] {
        let step = session.current().ok_or(SessionError::NoModel)?;
        write("model", name, &fit::to_bytes(&step.fitted).expect("a model can be written"));
        if let Some(run) = &step.run {
            write("checkpoint", name, &run.to_bytes().expect("a checkpoint can be written"));
        }
    }
    for (name, session) in [("loaded", loaded), ("solved", solved), ("trained", trained)] {
        write("session", name, &session::file::to_bytes(&session.into()).expect("a session can be written"));
    }
    write("arm", "arm.json", arms::ARM.as_bytes());
    write("robot", "robot.urdf", arms::URDF.as_bytes());
    write("robot", "robot.xml", arms::MJCF.as_bytes());
    for (name, text) in experiments::ALL {
        write("experiment", name, text.as_bytes());
    }
    for (name, text) in mappings::ALL {
        write("mapping", name, text.as_bytes());
    }
    Ok(())
}
