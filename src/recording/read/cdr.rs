//! CDR, the wire format of DDS, in which ROS 2 writes its messages.
//! Source: OMG, DDSI-RTPS 2.3, §10 (CDR encapsulation).

/// A CDR message, read from the front.
pub(super) struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> Cdr<'a> {
    pub fn new(message: &'a [u8]) -> Result<Self, &'static str> {
        match message {
            [0, order @ (0 | 1), _, _, bytes @ ..] => Ok(Cdr { bytes, at: 0, big_endian: *order == 0 }),
            _ => Err("it is not in plain CDR"),
        }
    }

    /// The next bytes; numbers stand at multiples of their size.
    fn take(&mut self, count: usize, alignment: usize) -> Result<&'a [u8], &'static str> {
        let start = self.at.next_multiple_of(alignment);
        let end = start.checked_add(count).ok_or("it claims an impossible size")?;
        self.at = end;
        self.bytes.get(start..end).ok_or("it ends too early")
    }

    /// The next bytes of a number, the least first.
    pub fn word<const SIZE: usize>(&mut self) -> Result<[u8; SIZE], &'static str> {
        let mut word: [u8; SIZE] = self.take(SIZE, SIZE)?.try_into().map_err(|_| "it ends too early")?;
        if self.big_endian {
            word.reverse();
        }
        Ok(word)
    }

    pub fn u32(&mut self) -> Result<u32, &'static str> {
        Ok(u32::from_le_bytes(self.word()?))
    }

    /// How many elements follow, each of at least `size` bytes.
    pub fn count(&mut self, size: usize) -> Result<usize, &'static str> {
        let count = self.u32()? as usize;
        let left = self.bytes.len().saturating_sub(self.at);
        if count.saturating_mul(size) > left { Err("it claims more elements than there are") } else { Ok(count) }
    }

    pub fn text(&mut self) -> Result<String, &'static str> {
        let length = self.count(1)?;
        let bytes = self.take(length, 1)?;
        Ok(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned())
    }

    pub fn numbers(&mut self) -> Result<Vec<f64>, &'static str> {
        let count = self.count(8)?;
        (0..count).map(|_| Ok(f64::from_le_bytes(self.word()?))).collect()
    }
}
