//! The program as a process.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

/// The program with these arguments in this folder; what it prints is kept.
pub fn torquescope(arguments: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_torquescope"));
    command.args(arguments).current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// What it prints where it succeeds.
pub fn succeeds(arguments: &[&str], folder: &Path) -> String {
    let output = torquescope(arguments, folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The same as JSON.
pub fn json(arguments: &[&str], folder: &Path) -> Value {
    let text = succeeds(arguments, folder);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Its message where it fails with this exit code.
pub fn fails(arguments: &[&str], folder: &Path, code: i32) -> String {
    let output = torquescope(arguments, folder).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    assert!(output.stdout.is_empty(), "{arguments:?} printed a result");
    message
}
