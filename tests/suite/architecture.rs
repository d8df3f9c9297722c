//! Keeps the house's rules by reading the sources: who may import whom, and who may do what.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms by floor; a room may import only from floors below its own.
const FLOORS: &[&[&str]] = &[
    &["signals", "statistics", "progress", "file"],
    &["arm", "network", "figure"],
    &["recording"],
    &["effect"],
    &["model"],
    &["simulation", "training", "diagnosis"],
    &["session", "work", "experiment", "trial", "export"],
    &["lesson"],
    &["app"],
    &["selftest"],
    &["cli"],
];

/// Where threads may be started: the jobs, and the parallel kernels of learning.
const THREADS: &[&str] = &["work", "network", "training"];
/// Where files may be opened: the front door of the readers, what is saved, and the edges.
const FILES: &[&str] = &[
    "file",
    "recording/read/mod.rs",
    "recording/read/bytes.rs",
    "session",
    "experiment/store.rs",
    "cli",
    "app",
    "selftest",
];
/// Who may open a seal: the user's own command, a saved session in which the user had opened it, the seal's tests, and the
/// scoring of simulated draws.
const SEALS: &[&str] = &["recording/seal.rs", "session/command.rs", "session/file.rs", "trial", "simulation"];

/// Where an effect may be named by its id: its own room, what hides a chosen effect on purpose (the embedded scenario and the
/// benches that state what they measure), and the parts of the simulated world, which say what they are in the catalogue. A rule
/// asks `effect::Facts` instead.
const EFFECTS: &[&str] = &["effect", "simulation/mod.rs", "simulation/world/part", "cli/bench"];

/// A source file: its path below `src`, and its code without comments and unit tests (`tests.rs` holds nothing else).
pub struct Source {
    pub path: String,
    pub code: String,
}

pub fn sources() -> Vec<Source> {
    fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, files);
            } else if path.extension().is_some_and(|ending| ending == "rs") && !path.ends_with("tests.rs") {
                files.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&root, &mut files);
    assert!(files.len() > 20, "the sources were not found");
    let source = |file: &PathBuf| {
        let text = fs::read_to_string(file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let code = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
        let path = file.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        Source { path, code }
    };
    files.iter().map(source).collect()
}

fn room(path: &str) -> &str {
    path.split(['/', '.']).next().unwrap_or_default()
}

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// Names that follow `crate::`, also inside `use crate::{…}`.
fn imports(code: &str) -> Vec<String> {
    let name = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut names = Vec::new();
    for part in code.split("crate::").skip(1) {
        match part.strip_prefix('{') {
            Some(list) => {
                let mut depth = 0;
                let mut start = true;
                for (index, letter) in list.char_indices() {
                    match letter {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => start = true,
                        letter if start && depth == 0 && letter.is_alphabetic() => {
                            names.push(name(&list[index..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
            None => names.push(name(part)),
        }
    }
    names
}

#[test]
fn nothing_imports_upward_or_sideways() {
    for source in sources() {
        let own = room(&source.path);
        let Some(own_floor) = floor(own) else {
            assert!(["main", "lib"].contains(&own), "{} is in no room of FLOORS", source.path);
            continue;
        };
        for import in imports(&source.code) {
            if import == own {
                continue;
            }
            let Some(other_floor) = floor(&import) else { continue };
            assert!(
                other_floor < own_floor,
                "{} (floor {own_floor}) imports {import} (floor {other_floor})",
                source.path
            );
        }
    }
}

#[test]
fn every_room_exists() {
    let sources = sources();
    for room_name in FLOORS.iter().copied().flatten() {
        assert!(sources.iter().any(|source| room(&source.path) == *room_name), "there is no room `{room_name}`");
    }
}

/// Whether it stands there, and not as the end of a longer word.
fn is_used(word: &str, code: &str) -> bool {
    code.match_indices(word)
        .any(|(at, _)| !code[..at].ends_with(|before: char| before.is_alphanumeric() || before == '_'))
}

fn only_in(what: &[&str], places: &[&str]) {
    for source in sources() {
        for word in what {
            let allowed = places.iter().any(|place| source.path.starts_with(place));
            assert!(
                allowed || !is_used(word, &source.code),
                "{} uses `{word}`, which belongs to {places:?}",
                source.path
            );
        }
    }
}

#[test]
fn egui_is_drawn_with_only_in_the_window() {
    only_in(&["egui::", "eframe::"], &["app"]);
    only_in(&["egui_plot::"], &["app/plot/adapter.rs"]);
}

#[test]
fn the_physics_engine_is_asked_only_by_the_world() {
    only_in(&["rapier2d", "parry2d"], &["simulation/world/bodies.rs"]);
}

#[test]
fn threads_are_started_only_in_jobs_and_kernels() {
    only_in(&["thread::spawn", "thread::Builder", "thread::scope"], THREADS);
}

#[test]
fn files_are_opened_only_at_the_doors() {
    only_in(&["fs::", "File::"], FILES);
}

/// Files are written whole, or not at all, in one way.
#[test]
fn files_are_written_at_one_door() {
    only_in(&["fs::write", "File::create(", "fs::rename", "BufWriter"], &["file"]);
}

#[test]
fn a_seal_is_opened_only_on_the_users_order() {
    only_in(&["Truth", "Seal", "seal::"], &[SEALS, &["recording", "session", "lesson", "app", "cli"]].concat());
    for source in sources() {
        let opens = source.code.contains("seal.open()") || source.code.contains("Seal::open");
        assert!(!opens || SEALS.iter().any(|place| source.path.starts_with(place)), "{} opens a seal", source.path);
    }
}

#[test]
fn an_effect_is_named_only_in_its_own_room() {
    let sources = sources();
    let stated =
        |line: &str| line.trim().strip_prefix("id: \"").and_then(|id| id.strip_suffix("\",")).map(str::to_owned);
    let of_effects = sources.iter().filter(|source| source.path.starts_with("effect/"));
    let ids: Vec<String> = of_effects.flat_map(|source| source.code.lines().filter_map(stated)).collect();
    assert!(ids.len() > 30, "the effects were not found");
    for source in sources.iter().filter(|source| !source.path.ends_with("tests.rs")) {
        let may = EFFECTS.iter().any(|place| source.path.starts_with(place));
        for id in &ids {
            let names = source.code.contains(&format!("\"{id}\""));
            assert!(
                may || !names,
                "{} names the effect `{id}`: make what the rule needs a field of `Facts`",
                source.path
            );
        }
    }
}
