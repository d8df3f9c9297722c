//! Programs of other languages, by which tests try what was written.

use std::path::Path;
use std::process::Command;

/// Whether a program runs; without it the test is left out, and says so.
pub(super) fn runs(program: &str, arguments: &[&str]) -> bool {
    let is_there = Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success());
    if !is_there {
        eprintln!(
            "left out: the generated code is not tried, because `{program} {}` does not run here",
            arguments.join(" ")
        );
    }
    is_there
}

/// Runs a program in a folder, and wants it to end with 0.
pub(super) fn succeeds(folder: &Path, program: &str, arguments: &[&str]) {
    let output = Command::new(program).args(arguments).current_dir(folder).output().unwrap();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(output.status.success(), "{program} {arguments:?}: {said}");
}
