//! Text as it comes from its file, packed or not: block by block, so that no log of numbers has to stand in memory as text, too.
//!
//! Whoever reads it finds a line feed at the end of every line, however the file ends them.

use std::io::Read;

use super::budget::Budget;
use super::gzip::{GzipError, Unpacked};

/// So much is read at a time \[bytes\].
const BLOCK: u64 = 1 << 20;
/// With these bytes some programs begin a text.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// The text can't be read on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TextError {
    /// What the system says.
    #[error("it can't be read to its end ({0}); copy it again")]
    Unreadable(String),
    /// What unpacks it says.
    #[error(transparent)]
    Gzip(#[from] GzipError),
}

/// Where the text comes from.
enum From<'a> {
    Plain(Box<dyn Read + 'a>),
    Packed(Box<Unpacked<Box<dyn Read + 'a>>>),
}

/// A text on its way.
pub(super) struct Text<'a> {
    from: From<'a>,
    /// How many bytes it has, where that is known before it is read.
    size: Option<u64>,
    block: Vec<u8>,
    /// How much of the block was taken.
    taken: usize,
    is_begun: bool,
    /// The last byte of the file so far.
    last: u8,
}

impl<'a> Text<'a> {
    /// Of a file of so many bytes.
    pub fn plain(from: Box<dyn Read + 'a>, size: u64) -> Self {
        Text::of(From::Plain(from), Some(size))
    }

    /// Of what gzip packed, within what may be unpacked.
    pub fn packed(from: Box<dyn Read + 'a>, budget: Budget) -> Self {
        Text::of(From::Packed(Box::new(Unpacked::of(from, budget))), None)
    }

    fn of(from: From<'a>, size: Option<u64>) -> Self {
        Text { from, size, block: Vec::new(), taken: 0, is_begun: false, last: b'\n' }
    }

    /// How many bytes it has, where that is known before it is read.
    pub fn size(&self) -> Option<u64> {
        self.size
    }

    /// What was not taken yet of the block that is there; of the next one if it was taken. Empty at the end.
    pub fn rest(&mut self) -> Result<&[u8], TextError> {
        while self.taken == self.block.len() && self.fill()? {}
        Ok(&self.block[self.taken..])
    }

    /// Takes some of [`Text::rest`].
    pub fn take(&mut self, count: usize) {
        self.taken += count;
    }

    /// Whole lines from the beginning, as many as a block has; all of a text that is no longer.
    pub fn first_lines(&mut self) -> Result<&[u8], TextError> {
        let block = self.rest()?;
        let cut = if block.len() as u64 + 3 < BLOCK { None } else { block.iter().rposition(|byte| *byte == b'\n') };
        Ok(cut.map_or(block, |end| &block[..=end]))
    }

    /// How many lines it has, about, by those at its beginning; `None` if its size is not known.
    pub fn line_count(&mut self) -> Result<Option<usize>, TextError> {
        let Some(size) = self.size else { return Ok(None) };
        let head = self.first_lines()?;
        let lines = head.iter().filter(|byte| **byte == b'\n').count() + 1;
        Ok(Some((size as f64 * lines as f64 / head.len().max(1) as f64).ceil() as usize))
    }

    /// Whether what was read ends within a line.
    pub fn ends_within_a_line(&self) -> bool {
        self.last != b'\n' && self.last != b'\r'
    }

    /// Reads the next block; false if there is none.
    fn fill(&mut self) -> Result<bool, TextError> {
        self.block.clear();
        self.taken = 0;
        match &mut self.from {
            From::Plain(from) => {
                from.take(BLOCK)
                    .read_to_end(&mut self.block)
                    .map_err(|problem| TextError::Unreadable(problem.to_string()))?;
            }
            From::Packed(from) => from.read(BLOCK, &mut self.block)?,
        }
        let is_after_return = self.last == b'\r';
        let Some(last) = self.block.last() else { return Ok(false) };
        self.last = *last;
        if !self.is_begun && self.block.starts_with(MARK) {
            self.block.drain(..MARK.len());
        }
        self.is_begun = true;
        with_line_feeds(&mut self.block, is_after_return);
        Ok(true)
    }
}

/// Ends every line with a line feed, where some end with a carriage return, alone or before one.
fn with_line_feeds(block: &mut Vec<u8>, mut is_after_return: bool) {
    if !is_after_return && !block.contains(&b'\r') {
        return;
    }
    block.retain_mut(|byte| {
        let is_second = is_after_return && *byte == b'\n';
        is_after_return = *byte == b'\r';
        if is_after_return {
            *byte = b'\n';
        }
        !is_second
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(text: &mut Text) -> Vec<u8> {
        let mut all = Vec::new();
        loop {
            let rest = text.rest().unwrap();
            if rest.is_empty() {
                return all;
            }
            all.extend(rest);
            let count = rest.len();
            text.take(count);
        }
    }

    /// Hands out three bytes at a time, so that ends of lines fall between two blocks too.
    struct Drop<'a>(&'a [u8]);

    impl Read for Drop<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let room = buffer.len().min(3);
            self.0.read(&mut buffer[..room])
        }
    }

    #[test]
    fn every_line_ends_with_a_line_feed() {
        for ending in ["\n", "\r\n", "\r"] {
            let lines = format!("1,2{ending}{ending}3,4{ending}");
            let mut text = Text::plain(Box::new(Drop(lines.as_bytes())), lines.len() as u64);
            assert_eq!(whole(&mut text), b"1,2\n\n3,4\n", "{ending:?}");
            assert!(!text.ends_within_a_line());
        }
        let mut halves = (b"1\r".to_vec(), b"\n2\r".to_vec());
        with_line_feeds(&mut halves.0, false);
        with_line_feeds(&mut halves.1, true);
        assert_eq!([halves.0, halves.1].concat(), b"1\n2\n");
    }

    #[test]
    fn a_text_longer_than_a_block_comes_whole_and_its_lines_are_guessed() {
        let rows = 400_000;
        let lines = "\u{feff}".to_owned() + &"0.5,-1.25\n".repeat(rows) + "0.5";
        let mut text = Text::plain(Box::new(lines.as_bytes()), lines.len() as u64);
        let guess = text.line_count().unwrap().unwrap();
        assert!((rows..rows + 10).contains(&guess), "{guess}");
        assert!(text.first_lines().unwrap().ends_with(b"\n"));
        assert!(whole(&mut text) == lines.as_bytes()[3..]);
        assert!(text.ends_within_a_line());
    }
}
