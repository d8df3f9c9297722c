//! Files that were made and are to be written together. Where they go is looked at before the first of them is there.

use std::io;
use std::path::{Path, PathBuf};

use crate::file;

/// Files that were made.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Files {
    /// The folder that is made for them, if they need one.
    pub folder: Option<PathBuf>,
    /// Where each goes, and what is in it.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// Whether what stood there stays beside it as `.bak`.
    pub keep_old: bool,
}

/// Files can't be written.
#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    /// The result would take the place of what it is made of.
    #[error("{path} is read here, so the result can't be written over it: name another file", path = .0.display())]
    IsInput(PathBuf),
    /// The folder can't be made.
    #[error("can't make the folder {path}: {problem}", path = path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// A file can't be written.
    #[error("can't write {path}: check the folder and its permissions ({problem})", path = path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
}

/// Refuses to write a result over what it is made of.
///
/// # Errors
/// [`FilesError::IsInput`]
pub fn check_output(output: &Path, inputs: &[PathBuf]) -> Result<(), FilesError> {
    match inputs.iter().any(|input| file::is_same(input, output)) {
        true => Err(FilesError::IsInput(output.to_owned())),
        false => Ok(()),
    }
}

impl Files {
    /// One file.
    pub fn one(path: &Path, bytes: Vec<u8>) -> Self {
        Files { files: vec![(path.to_owned(), bytes)], ..Files::default() }
    }

    /// Files of these names in a folder.
    pub fn within<N: AsRef<Path>>(folder: &Path, files: impl IntoIterator<Item = (N, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(name, bytes)| (folder.join(name), bytes)).collect();
        Files { folder: Some(folder.to_owned()), files, keep_old: false }
    }

    /// Refuses to write any of them over what they are made of, unless that stays beside it.
    ///
    /// # Errors
    /// [`FilesError::IsInput`]
    pub fn check(&self, inputs: &[PathBuf]) -> Result<(), FilesError> {
        if self.keep_old {
            return Ok(());
        }
        self.files.iter().try_for_each(|(path, _)| check_output(path, inputs))
    }

    /// Writes all of them, each whole or not at all.
    ///
    /// # Errors
    /// [`FilesError`] at the first that can't be written.
    pub fn write(&self) -> Result<(), FilesError> {
        if let Some(folder) = &self.folder {
            file::make_folder(folder).map_err(|problem| FilesError::Folder { path: folder.clone(), problem })?;
        }
        for (path, bytes) in &self.files {
            let written = if self.keep_old { file::write_keeping_old(path, bytes) } else { file::write(path, bytes) };
            written.map_err(|problem| FilesError::Write { path: path.clone(), problem })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_they_are_made_of_stays() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("log.csv");
        file::write(&input, b"measured").unwrap();
        let files = Files::within(folder.path(), [("./log.csv", b"made".to_vec())]);
        let inputs = [input];
        assert!(matches!(files.check(&inputs), Err(FilesError::IsInput(_))));
        Files { keep_old: true, ..files }.check(&inputs).unwrap();
        let other = Files::within(&folder.path().join("deep/new"), [("log.csv", b"made".to_vec())]);
        other.check(&inputs).unwrap();
        other.write().unwrap();
        assert!(folder.path().join("deep/new/log.csv").exists());
    }
}
