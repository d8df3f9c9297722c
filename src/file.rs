//! The one way in which the program writes a file, whole or not at all, and the door for files that people name.
//!
//! What is no plain file, or larger than what it should be can be, is refused before it is read: a pipe would be waited for,
//! `/dev/zero` has no end. The bytes that are written go beside the file and are brought to the disk; then they take its place by
//! one rename. So at every moment, also when the power fails or the disk is full, there is either the old file or the new one.
//! Should a document be gone nevertheless, [`remains`] finds what is left of it; [`unfinished`] finds what was to become of one whose
//! saving was cut off.

pub mod ending;
mod neighbours;

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use neighbours::Draft;
pub use neighbours::{beside, old, owner, remains, remove_drafts, unfinished};

/// No recording, and no session that holds one, is larger \[bytes\], unless somebody says so.
pub const LARGEST: u64 = 1 << 30;
/// No model and no checkpoint is larger \[bytes\].
pub const LARGEST_MODEL: u64 = 1 << 28;
/// No text that people write (an arm, a scenario, a mapping, an experiment) is larger \[bytes\].
pub const LARGEST_TEXT: u64 = 1 << 19;

/// A message without the number by which the system knows an error, as in `No such file or directory (os error 2)`: it tells
/// people nothing.
pub fn without_number(message: &str) -> String {
    let mut text = message.to_owned();
    while let Some(from) = text.find(" (os error ") {
        let Some(to) = text[from..].find(')') else { break };
        text.replace_range(from..=from + to, "");
    }
    text
}

/// How large a plain file is \[bytes\].
///
/// # Errors
/// What the system says, or that it is a folder, a device or the like.
pub fn size(path: &Path) -> io::Result<u64> {
    let about = fs::metadata(path)?;
    match (about.is_file(), about.is_dir()) {
        (true, _) => Ok(about.len()),
        (false, true) => Err(io::Error::other("it is a folder; name a file in it")),
        (false, false) => Err(io::Error::other("it is no plain file, but a pipe, a device or the like")),
    }
}

/// By which one tells whether somebody else has written a file since.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    size: u64,
    written: Option<SystemTime>,
}

impl Mark {
    /// When the file was written, where the system tells.
    pub fn written(&self) -> Option<SystemTime> {
        self.written
    }
}

/// The mark of a file as it is now; `None` if there is none.
pub fn mark(path: &Path) -> Option<Mark> {
    let about = fs::metadata(path).ok()?;
    Some(Mark { size: about.len(), written: about.modified().ok() })
}

/// When a file was written; `None` if there is none, or the system does not tell.
pub fn written(path: &Path) -> Option<SystemTime> {
    mark(path)?.written()
}

/// The bytes of a plain file, at most so many.
///
/// # Errors
/// As [`size`], and if the file is larger.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let too_large = || {
        let most = if most < 1 << 20 { format!("{} KB", most >> 10) } else { format!("{} MB", most >> 20) };
        let what = format!("it has more than {most}, which nothing of its kind has; name another file");
        Err(io::Error::other(what))
    };
    let size = size(path)?;
    if size > most {
        return too_large();
    }
    // It may grow while it is read; if not, it takes no more memory than its size.
    let mut bytes = Vec::with_capacity(size as usize + 1);
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { too_large() } else { Ok(bytes) }
}

/// A text that people write, from a plain file of at most [`LARGEST_TEXT`].
///
/// # Errors
/// As [`read`], and if it is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path, LARGEST_TEXT)?)
        .map_err(|_| io::Error::other("it is no text in UTF-8; save it as that"))
}

/// What the parts of an archive of this program may take when they are unpacked: a few bytes may say that they are gigabytes, and hold
/// archives that say so again.
#[derive(Debug)]
pub struct Unpacking {
    size: u64,
    left: u64,
}

impl Unpacking {
    /// Every archive may take so much \[bytes\], however small it is.
    const LEAST: u64 = 4 << 20;
    /// How many times its size the parts of an archive may take together.
    const DENSEST: u64 = 32;
    /// How many times its size an archive in it may have, since what is packed already hardly gets smaller, and how much more \[bytes\].
    const AGAIN: [u64; 2] = [2, 1 << 16];

    /// For an archive of so many bytes.
    pub fn of(size: usize) -> Unpacking {
        let size = size as u64;
        Unpacking { size, left: Unpacking::LEAST.max(size.saturating_mul(Unpacking::DENSEST)) }
    }

    /// The bytes of a part.
    ///
    /// # Errors
    /// What the unpacking says, and if it takes too much.
    pub fn part(&mut self, part: impl Read) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        part.take(self.left + 1).read_to_end(&mut bytes)?;
        let size = bytes.len() as u64;
        self.left =
            self.left.checked_sub(size).ok_or_else(|| io::Error::other("unpacked it takes more than any such file"))?;
        let [times, more] = Unpacking::AGAIN;
        if bytes.starts_with(b"PK") && size > times * self.size + more {
            return Err(io::Error::other("it holds an archive that is packed more tightly than one can be"));
        }
        Ok(bytes)
    }
}

/// Writes a file, in the place of the one that is there.
///
/// # Errors
/// What the system says; the old file is then as it was, and nothing is left beside it.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    put(path, bytes, false)
}

/// Writes a file and keeps what it was before, where [`old`] says.
///
/// # Errors
/// As [`write()`].
pub fn write_keeping_old(path: &Path, bytes: &[u8]) -> io::Result<()> {
    put(path, bytes, true)
}

/// Makes a folder and those that it stands in, if they are not there.
///
/// # Errors
/// What the system says.
pub fn make_folder(path: &Path) -> io::Result<()> {
    fs::create_dir_all(path)
}

/// Makes a file that is not there yet, whole. Of several who do so at once one gets it.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] if it is there, or what the system says.
pub fn create(path: &Path, bytes: &[u8]) -> io::Result<File> {
    let draft = Draft::new(path);
    let mut file = File::create(&draft.0)?;
    file.write_all(bytes)?;
    match fs::hard_link(&draft.0, path) {
        Ok(()) => Ok(file),
        Err(problem) if problem.kind() == io::ErrorKind::AlreadyExists => Err(problem),
        // Not every file system has second names; without them, others may see it before it is whole.
        Err(_) => {
            let mut file = fs::OpenOptions::new().write(true).create_new(true).open(path)?;
            file.write_all(bytes)?;
            Ok(file)
        }
    }
}

/// The time by the clock that stamps the files of a folder; that of another machine, if the folder is there.
///
/// # Errors
/// What the system says.
pub fn clock(folder: &Path) -> io::Result<SystemTime> {
    let draft = Draft::new(&folder.join("clock"));
    File::create(&draft.0)?.metadata()?.modified()
}

fn put(path: &Path, bytes: &[u8], keep_old: bool) -> io::Result<()> {
    let old = fs::metadata(path).ok();
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        // A pipe or a device has no place that could be taken.
        return fs::OpenOptions::new().write(true).open(path)?.write_all(bytes);
    }
    // What a link leads to is replaced, and not the link.
    let path = if old.is_some() { fs::canonicalize(path)? } else { path.to_owned() };
    let draft = Draft::new(&path);
    let mut file = File::create(&draft.0)?;
    file.write_all(bytes)?;
    if let Some(old) = &old {
        file.set_permissions(old.permissions())?;
    }
    file.sync_all()?;
    if keep_old && old.is_some() {
        keep(&path)?;
    }
    fs::rename(&draft.0, &path)?;
    sync_folder(&path);
    if let Some(replaced) = old.and_then(|old| old.modified().ok()) {
        neighbours::remove_superseded(&path, replaced);
    }
    Ok(())
}

/// Puts what a file is now beside it, by a rename too.
fn keep(path: &Path) -> io::Result<()> {
    let draft = Draft::new(path);
    // A second name costs no space; not every file system has them.
    fs::hard_link(path, &draft.0).or_else(|_| fs::copy(path, &draft.0).map(drop))?;
    fs::rename(&draft.0, old(path))
}

/// Brings a rename to the disk, where a folder can be synchronised at all.
fn sync_folder(path: &Path) {
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A path from the root on, whether or not something is there.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Whether two paths lead to one file.
pub fn is_same(one: &Path, other: &Path) -> bool {
    match (fs::canonicalize(one), fs::canonicalize(other)) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}

/// All files of a folder, and of so many levels of folders in it.
///
/// # Errors
/// If one of them can't be listed.
pub fn within(folder: &Path, deeper: usize) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?.path();
        match entry.is_dir() {
            true if deeper > 0 => files.extend(within(&entry, deeper - 1)?),
            true => {}
            false => files.push(entry),
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_are_not_told_the_number_of_an_error() {
        let error = std::fs::read("no/such/file").unwrap_err();
        let text = without_number(&format!("can't read it: {error}, twice ({error}). Mend it"));
        assert!(!text.contains("os error") && text.ends_with("). Mend it"), "{text}");
    }

    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn only_plain_files_of_a_likely_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, b"12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert_eq!(read_text(&path).unwrap(), "12345");
        assert!(read(&path, 4).unwrap_err().to_string().contains("more than"));
        assert!(read(folder.path(), 5).unwrap_err().to_string().contains("a folder"));
        fs::write(&path, b"\xff").unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("UTF-8"));
    }

    /// Reading them would never end.
    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [pipe.as_path(), Path::new("/dev/zero")] {
            assert!(read(path, 5).unwrap_err().to_string().contains("no plain file"), "{}", path.display());
        }
    }

    #[test]
    fn a_file_is_replaced_and_what_it_was_can_be_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"two".to_vec(), vec!["a.txt".to_owned()]));
        write_keeping_old(&path, b"three").unwrap();
        write_keeping_old(&path, b"four").unwrap();
        assert_eq!((fs::read(&path).unwrap(), fs::read(old(&path)).unwrap()), (b"four".to_vec(), b"three".to_vec()));
        assert_eq!(names(folder.path()), ["a.txt", "a.txt.bak"]);
    }

    #[test]
    fn what_is_unpacked_is_counted() {
        let mut honest = Unpacking::of(1000);
        assert_eq!(honest.part(&[7u8; 3000][..]).unwrap().len(), 3000);
        assert!(honest.part(io::repeat(0)).unwrap_err().to_string().contains("more than any such file"));
        let mut all = Unpacking::of(1000);
        let half = (Unpacking::LEAST / 2 + 1) as usize;
        assert!(all.part(&vec![7u8; half][..]).is_ok() && all.part(&vec![7u8; half][..]).is_err());
        let inner = [b"PK".to_vec(), vec![0; 1 << 17]].concat();
        assert!(Unpacking::of(1000).part(&inner[..]).unwrap_err().to_string().contains("more tightly"));
        assert!(Unpacking::of(1 << 16).part(&inner[..]).is_ok());
    }

    #[test]
    fn a_file_is_made_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        create(&path, b"one").unwrap();
        assert_eq!(create(&path, b"two").unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert!(clock(folder.path()).unwrap() >= written(&path).unwrap());
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"one".to_vec(), vec!["a.txt".to_owned()]));
    }

    #[test]
    fn a_change_by_somebody_else_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        assert_eq!(mark(&path), None);
        write(&path, b"one").unwrap();
        let before = mark(&path);
        assert_eq!(before, mark(&path));
        File::options().write(true).open(&path).unwrap().set_modified(SystemTime::UNIX_EPOCH).unwrap();
        assert_ne!(before, mark(&path), "as large, but written at another time");
    }

    #[test]
    fn what_fails_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let nowhere = folder.path().join("no/such/folder/a.txt");
        assert!(write(&nowhere, b"one").is_err() && names(folder.path()).is_empty());
        // A folder can't be replaced by a file.
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        assert!(write(&taken, b"one").is_err());
        assert_eq!(names(folder.path()), ["taken"]);
    }

    #[test]
    fn readers_see_the_old_file_or_the_new_one_and_never_a_part() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let texts = [vec![1u8; 200_000], vec![2u8; 300_000]];
        write(&path, &texts[0]).unwrap();
        std::thread::scope(|scope| {
            let writers = [0, 1].map(|writer| {
                let (path, texts) = (&path, &texts);
                scope.spawn(move || {
                    (0..20).for_each(|turn| write_keeping_old(path, &texts[(writer + turn) % 2]).unwrap())
                })
            });
            while writers.iter().any(|writer| !writer.is_finished()) {
                let seen = fs::read(&path).unwrap();
                assert!(texts.contains(&seen), "{} bytes", seen.len());
            }
        });
        assert_eq!(names(folder.path()), ["a.bin", "a.bin.bak"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_permissions_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["a.txt", "link"].map(|name| folder.path().join(name));
        write(&path, b"one").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("a.txt", &link).unwrap();
        write(&link, b"two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink() && is_same(&path, &link));
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        write(Path::new("/dev/null"), b"three").unwrap();
    }
}
