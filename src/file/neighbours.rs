//! What stands beside a file while it is written and afterwards: what it was, and what it is to become.
//!
//! ```text
//! log.npz           the file
//! log.npz.bak       what it was before it was saved last
//! log.npz.17-3.new  what process 17 writes; after a kill it stays
//! ```
//!
//! A name with no room for an ending is cut, and a mark of the whole name put in its place, so that no two are taken for one.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use sha2::{Digest, Sha256};

use super::{folder_of, written};

/// Ending of the copy of what a document was before it was saved last.
const OLD: &str = ".bak";
/// Ending of what is being written.
const NEW: &str = ".new";

/// No file system that is in use takes shorter names only \[bytes\].
const LONGEST_NAME: usize = 255;
/// So many letters of a name that is cut are kept, whatever script they are of.
const KEPT: usize = 32;
/// The ending by which programs know a file is kept as well, if it is no longer \[bytes\].
const LONGEST_ENDING: usize = 16;

/// The same file with something behind its name.
pub fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    PathBuf::from(name)
}

/// Where what a file was before it was saved last is kept.
pub fn old(path: &Path) -> PathBuf {
    fitting(path, OLD)
}

/// What is left of a document: what it would have become, and what it was before; the newest first.
pub fn remains(path: &Path) -> Vec<PathBuf> {
    let kept = old(path);
    let entries =
        neighbours(path).filter(|other| drafted_by(path, other).is_some() || other.file_name() == kept.file_name());
    newest_first(entries)
}

/// What a file was to become when its saving was cut off: drafts that were written after it, the newest first. None if the file is
/// gone, which [`remains`] is for.
pub fn unfinished(path: &Path) -> Vec<PathBuf> {
    let Some(saved) = written(path) else { return Vec::new() };
    let is_newer = |other: &PathBuf| written(other).is_some_and(|time| time > saved);
    newest_first(neighbours(path).filter(|other| drafted_by(path, other).is_some()).filter(is_newer))
}

/// Whose remains a file is, by its name; `None` if it is a file of its own. Of a name that was cut, what is left.
pub fn owner(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let whose = name.strip_suffix(OLD).or_else(|| {
        let (whose, number) = name.strip_suffix(NEW)?.rsplit_once('.')?;
        process_of(number).map(|_| whose)
    });
    whose.filter(|whose| !whose.is_empty()).map(|whose| path.with_file_name(whose))
}

/// Removes what was begun in a folder, and not written on since: who began it is gone.
pub fn remove_drafts(folder: &Path, since: SystemTime) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_draft = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(NEW));
    remove_older(entries.filter(is_draft), since);
}

/// Removes drafts of a file that was saved since they were begun, by processes that are gone: nobody asks for them any more.
pub(super) fn remove_superseded(path: &Path, since: SystemTime) {
    // Where the system does not list its processes, those of the same moment only are not told apart from the dead.
    let is_alive = |process: &str| Path::new("/proc").join(process).exists();
    let is_left = |draft: &PathBuf| {
        drafted_by(path, draft).is_some_and(|process| process != own_process() && !is_alive(&process))
    };
    remove_older(neighbours(path).filter(is_left), since);
}

fn own_process() -> String {
    std::process::id().to_string()
}

fn remove_older(drafts: impl Iterator<Item = PathBuf>, since: SystemTime) {
    for path in drafts.filter(|path| written(path).is_some_and(|time| time < since)) {
        // What can't be removed is in nobody's way.
        let _ = fs::remove_file(path);
    }
}

/// A name beside a file that nobody else uses; what is still there in the end is removed.
pub(super) struct Draft(pub PathBuf);

impl Draft {
    pub fn new(path: &Path) -> Draft {
        static DRAFTS: AtomicU64 = AtomicU64::new(0);
        let number = DRAFTS.fetch_add(1, Ordering::Relaxed);
        Draft(fitting(path, &format!(".{}-{number}{NEW}", own_process())))
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After a rename it is gone already.
        let _ = fs::remove_file(&self.0);
    }
}

/// Everything in the folder of a file.
fn neighbours(path: &Path) -> impl Iterator<Item = PathBuf> {
    fs::read_dir(folder_of(path)).into_iter().flatten().flatten().map(|entry| entry.path())
}

fn newest_first(paths: impl Iterator<Item = PathBuf>) -> Vec<PathBuf> {
    let mut paths: Vec<(Option<SystemTime>, PathBuf)> = paths.map(|path| (written(&path), path)).collect();
    paths.sort();
    paths.into_iter().rev().map(|(_, path)| path).collect()
}

/// Which process wrote a draft of a file; `None` if it is none.
fn drafted_by(path: &Path, draft: &Path) -> Option<String> {
    let name = path.file_name()?;
    let draft = draft.file_name()?.as_encoded_bytes();
    let process = |begin: &OsStr| {
        let number = draft.strip_prefix(begin.as_encoded_bytes())?.strip_prefix(b".")?.strip_suffix(NEW.as_bytes())?;
        process_of(std::str::from_utf8(number).ok()?).map(str::to_owned)
    };
    // By its number a draft may have been just too long.
    process(name).or_else(|| process(&cut(name)))
}

/// The process of `17-3`, its third draft.
fn process_of(number: &str) -> Option<&str> {
    let is_count = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    number.split_once('-').filter(|(process, count)| is_count(process) && is_count(count)).map(|(process, _)| process)
}

/// A file's name with an ending, as long as names may be.
fn fitting(path: &Path, ending: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default();
    if name.len() + ending.len() <= LONGEST_NAME {
        return beside(path, ending);
    }
    let mut name = cut(name);
    name.push(ending);
    path.with_file_name(name)
}

/// The first letters of a name, a mark of all of it, and its ending.
fn cut(name: &OsStr) -> OsString {
    let begin: String = name.to_string_lossy().chars().take(KEPT).collect();
    let mark: String =
        Sha256::digest(name.as_encoded_bytes()).iter().take(4).map(|byte| format!("{byte:02x}")).collect();
    let ending = Path::new(name).extension().unwrap_or_default().to_string_lossy();
    let point = if (1..=LONGEST_ENDING).contains(&ending.len()) { "." } else { "" };
    let ending = if point.is_empty() { "" } else { &*ending };
    OsString::from(format!("{begin}~{mark}{point}{ending}"))
}

#[cfg(test)]
mod tests {
    use super::super::{write, write_keeping_old};
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    fn write_at(path: &Path, second: u64) {
        fs::write(path, second.to_string()).unwrap();
        let time = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(second);
        fs::File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
    }

    #[test]
    fn what_is_left_of_a_file_is_found_newest_first() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let all =
            [("a.txt.bak", 1), ("a.txt.4294967295-0.new", 2), ("a.txt.b.new", 3), ("a.txt2.bak", 3), ("b.txt.bak", 4)];
        all.iter().for_each(|(name, second)| write_at(&at(name), *second));
        assert_eq!(remains(&at("a.txt")), ["a.txt.4294967295-0.new", "a.txt.bak"].map(at));
        assert_eq!(owner(&at("a.txt.4294967295-0.new")), Some(at("a.txt")));
        assert_eq!(owner(&at("a.txt.bak")), Some(at("a.txt")));
        for of_its_own in ["a.txt", "a.txt.b.new", "a.new", ".bak"] {
            assert_eq!(owner(&at(of_its_own)), None, "{of_its_own}");
        }
    }

    /// A kill between writing and renaming.
    #[test]
    fn only_what_was_written_after_a_file_is_unfinished_and_goes_when_it_is_superseded() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let path = at("a.txt");
        write_at(&at("a.txt.4294967295-1.new"), 3);
        assert_eq!(unfinished(&path), Vec::<PathBuf>::new(), "it is gone, not unfinished");
        for (name, second) in
            [("a.txt", 2), ("a.txt.4294967295-0.new", 1), ("a.txt.4294967295-2.new", 4), ("b.txt.4294967295-0.new", 5)]
        {
            write_at(&at(name), second);
        }
        assert_eq!(unfinished(&path), ["a.txt.4294967295-2.new", "a.txt.4294967295-1.new"].map(at));
        write(&path, b"saved").unwrap();
        assert_eq!(unfinished(&path), Vec::<PathBuf>::new());
        assert_eq!(
            names(folder.path()),
            ["a.txt", "a.txt.4294967295-1.new", "a.txt.4294967295-2.new", "b.txt.4294967295-0.new"]
        );
        write(&path, b"saved again").unwrap();
        assert_eq!(names(folder.path()), ["a.txt", "b.txt.4294967295-0.new"]);
    }

    #[test]
    fn a_name_may_be_as_long_as_names_can_be_and_its_old_one_is_found() {
        for letter in ["x", "ü", "🦾"] {
            let folder = tempfile::tempdir().unwrap();
            let ending = ".torquescope";
            for length in [LONGEST_NAME, LONGEST_NAME - 4] {
                let name = letter.repeat((length - ending.len()) / letter.len()) + ending;
                let path = folder.path().join(name);
                write_keeping_old(&path, b"one").unwrap();
                write_keeping_old(&path, b"two").unwrap();
                assert_eq!((fs::read(&path).unwrap(), fs::read(old(&path)).unwrap()), (b"two".into(), b"one".into()));
                assert_eq!(remains(&path), [old(&path)]);
                assert!(owner(&old(&path)).unwrap().extension().unwrap() == "torquescope");
                let draft = fitting(&path, ".4294967295-3.new");
                fs::write(&draft, b"three").unwrap();
                assert_eq!(unfinished(&path), std::slice::from_ref(&draft));
                fs::remove_file(draft).unwrap();
            }
            assert_eq!(names(folder.path()).len(), 4, "each has an old one of its own");
        }
    }
}
