//! Data that are not part of the repository: logs of real robots, and most reference vectors of other programs. They are looked for
//! in `../shared`, or where an environment variable says. Tests that need logs are left out where these are absent, and say so; of the
//! reference vectors a small part is in `tests/reference`.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder of logs of a real robot.
pub fn real_logs(folder: &str) -> Option<PathBuf> {
    find("TORQUESCOPE_REAL_DATA", "../shared/real", folder)
}

/// The folders of reference vectors that are there: the small part that comes with the repository, which must hold by itself on a
/// clean clone, and all of them.
pub fn references() -> Vec<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference");
    let all = place("TORQUESCOPE_ORACLE", "../shared/oracle");
    [own, all].into_iter().filter(|folder| folder.exists()).collect()
}

fn place(variable: &str, beside: &str) -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join(beside);
    std::env::var_os(variable).map_or_else(beside, PathBuf::from)
}

fn find(variable: &str, beside: &str, path: &str) -> Option<PathBuf> {
    let full = place(variable, beside).join(path);
    if full.exists() {
        return Some(full);
    }
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    // Past the capture of the test's own output, which nobody sees of a test that passes.
    let line =
        format!("left out: {test}, there is no {} (set {variable} to the folder that has {path})\n", full.display());
    std::io::stderr().write_all(line.as_bytes()).unwrap();
    None
}
