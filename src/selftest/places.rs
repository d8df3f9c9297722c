//! Places where nothing can be written, and names that nobody expects: it is said, and what can go on goes on.

use std::ffi::OsStr;
use std::process::Command;

use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::file;
use crate::recording::write::to_npz_bytes;

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "places",
    promise: "a full disk, a folder that can't be written, no home and odd names: the user is told, a training goes on",
    take,
};

/// What a command came to.
struct End {
    code: Option<i32>,
    said: String,
}

fn end(bench: &Bench, arguments: &[&OsStr]) -> std::io::Result<End> {
    let mut command = Command::new(&bench.program);
    command.args(arguments).current_dir(bench.folder).env_remove("HOME").env_remove("XDG_STATE_HOME");
    let output = command.output()?;
    Ok(End { code: output.status.code(), said: String::from_utf8_lossy(&output.stderr).into_owned() })
}

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let bytes = to_npz_bytes(&seeds::recording(bench.effort.seed)?);
    let bytes = bytes.map_err(|error| SelftestError::making("a recording")(&error))?;
    file::write(&bench.path("log.npz"), &bytes)?;
    let mut score = Score::default();
    full_disk(bench, &mut score)?;
    read_only(bench, &mut score)?;
    odd_names(bench, &bytes, &mut score)?;
    Ok(score)
}

fn tried(
    bench: &Bench,
    score: &mut Score,
    arguments: &[&str],
    is_right: impl Fn(&End) -> bool,
) -> Result<(), SelftestError> {
    bench.report(score.cases, 30, "odd places")?;
    let words: Vec<&OsStr> = arguments.iter().map(OsStr::new).collect();
    judge(bench, score, &words, is_right)
}

fn judge(
    bench: &Bench,
    score: &mut Score,
    arguments: &[&OsStr],
    is_right: impl Fn(&End) -> bool,
) -> Result<(), SelftestError> {
    let end = end(bench, arguments)?;
    let is_right = is_right(&end) && !end.said.contains("panicked");
    score.cases += 1;
    score.count(if is_right { "as promised" } else { "otherwise" });
    score.demand(is_right, || format!("{arguments:?} ended with {:?} and said: {}", end.code, end.said.trim()));
    Ok(())
}

/// Every kind of output, and a checkpoint, without which a training goes on.
fn full_disk(bench: &Bench, score: &mut Score) -> Result<(), SelftestError> {
    const FULL: &str = "/dev/full";
    if !std::path::Path::new(FULL).exists() {
        score.left_out.push(format!("a full disk: there is no {FULL}"));
        return Ok(());
    }
    let is_told = |end: &End| end.code == Some(1) && end.said.contains(FULL) && end.said.contains("No space");
    for command in
        [&["simulate", "-o", FULL][..], &["train", "log.npz", "-o", FULL], &["predict", "log.npz", "-o", FULL]]
    {
        tried(bench, score, command, is_told)?;
    }
    let train = ["train", "log.npz", "--model", "ff-nn", "--hidden", "4", "--epochs", "2", "--batch", "32"];
    let command = [&train[..], &["--checkpoint", FULL, "-o", "trained.model"]].concat();
    tried(bench, score, &command, |end| end.code == Some(0) && end.said.contains("The training goes on"))?;
    let is_there = bench.path("trained.model").is_file();
    score.demand(is_there, || "a full disk under the checkpoint took the model".to_owned());
    Ok(())
}

/// A folder that nobody may write into; whoever is the system's owner may.
fn read_only(bench: &Bench, score: &mut Score) -> Result<(), SelftestError> {
    let folder = bench.path("closed");
    std::fs::create_dir(&folder)?;
    let open = std::fs::metadata(&folder)?.permissions();
    let mut closed = open.clone();
    closed.set_readonly(true);
    std::fs::set_permissions(&folder, closed)?;
    let probe = std::fs::OpenOptions::new().create_new(true).write(true).open(folder.join("probe"));
    if probe.is_ok() {
        score.left_out.push("a folder that can't be written: this user may write everywhere".to_owned());
    } else {
        let is_told = |end: &End| end.code == Some(1) && end.said.contains("closed");
        for command in [
            &["simulate", "-o", "closed/x.npz"][..],
            &["train", "log.npz", "-o", "closed/x.json"],
            &["experiment", "run", "table-1", "--quick", "--out", "closed/out"],
        ] {
            tried(bench, score, command, is_told)?;
        }
    }
    std::fs::set_permissions(&folder, open)?;
    let is_told = |end: &End| end.code == Some(1) && end.said.contains("nowhere");
    tried(bench, score, &["simulate", "-o", "nowhere/x.npz"], is_told)
}

fn odd_names(bench: &Bench, bytes: &[u8], score: &mut Score) -> Result<(), SelftestError> {
    let long = format!("{}.npz", "x".repeat(240));
    let mut names: Vec<std::ffi::OsString> =
        ["a b.npz", " .npz", "ü–ñ.npz", "line\nfeed.npz", "esc\u{1b}[31m.npz", "100%.npz", "a'b\".npz", &long]
            .map(Into::into)
            .to_vec();
    #[cfg(target_os = "linux")]
    names.push(std::os::unix::ffi::OsStringExt::from_vec(b"bad\xff\xfe.npz".to_vec()));
    for name in names {
        file::write(&bench.folder.join(&name), bytes)?;
        let is_read = |end: &End| end.code == Some(0) && !end.said.contains('\u{1b}');
        judge(bench, score, &[OsStr::new("inspect"), &name], is_read)?;
        let mut output = std::ffi::OsString::from("out-");
        output.push(if name.len() > 200 { OsStr::new("long.npz") } else { &name });
        judge(bench, score, &[OsStr::new("predict"), &name, OsStr::new("-o"), &output], is_read)?;
    }
    Ok(())
}
