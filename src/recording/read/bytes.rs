//! Where the bytes of a log lie: in its file, or in memory already.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::arrays::Source;
use crate::file;

/// The bytes of one file.
pub(super) enum Bytes<'a> {
    /// They are read when they are needed.
    InFile(PathBuf),
    /// They are there.
    InMemory(&'a [u8]),
}

impl Bytes<'_> {
    /// How many they are.
    pub fn size(&self) -> io::Result<u64> {
        match self {
            Bytes::InFile(path) => file::size(path),
            Bytes::InMemory(bytes) => Ok(bytes.len() as u64),
        }
    }

    /// From their beginning; of a file that grows no more than it has now.
    pub fn open(&self) -> io::Result<Box<dyn Read + '_>> {
        Ok(match self {
            Bytes::InFile(path) => Box::new(BufReader::new(File::open(path)?).take(self.size()?)),
            Bytes::InMemory(bytes) => Box::new(*bytes),
        })
    }

    /// As many of the first as there are, but at most so many.
    pub fn head(&self, most: usize) -> io::Result<Vec<u8>> {
        let mut head = Vec::new();
        self.open()?.take(most as u64).read_to_end(&mut head)?;
        Ok(head)
    }

    /// All of them, at most so many.
    pub fn whole(&self, most: u64) -> io::Result<Cow<'_, [u8]>> {
        Ok(match self {
            Bytes::InFile(path) => Cow::Owned(file::read(path, most)?),
            Bytes::InMemory(bytes) => Cow::Borrowed(bytes),
        })
    }
}

impl<'a> From<&'a Path> for Bytes<'a> {
    fn from(path: &'a Path) -> Self {
        Bytes::InFile(path.to_owned())
    }
}

impl Source for Vec<Bytes<'_>> {
    fn open(&mut self, index: usize) -> io::Result<(Box<dyn Read + '_>, u64)> {
        let bytes = &self[index];
        Ok((bytes.open()?, bytes.size()?))
    }
}
