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

    /// Passes over so many bytes.
    pub fn skip(&mut self, count: usize) -> Result<(), &'static str> {
        self.take(count, 1).map(drop)
    }
}

/// Writes a CDR message, numbers with their least byte first.
pub(crate) struct CdrWriter(Vec<u8>);

impl CdrWriter {
    /// An empty message.
    pub fn new() -> Self {
        CdrWriter(vec![0, 1, 0, 0])
    }

    /// A number by its bytes, at a multiple of their count.
    pub fn word<const SIZE: usize>(&mut self, word: [u8; SIZE]) -> &mut Self {
        // Alignment counts from behind the four bytes of the encapsulation.
        self.0.resize((self.0.len() - 4).next_multiple_of(SIZE) + 4, 0);
        self.0.extend(word);
        self
    }

    /// A text, with a zero at its end.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.word((text.len() as u32 + 1).to_le_bytes());
        self.0.extend(text.bytes().chain([0]));
        self
    }

    /// A list of texts.
    pub fn texts(&mut self, texts: &[&str]) -> &mut Self {
        self.word((texts.len() as u32).to_le_bytes());
        texts.iter().fold(self, |message, text| message.text(text))
    }

    /// A list of numbers.
    pub fn numbers(&mut self, values: &[f64]) -> &mut Self {
        self.word((values.len() as u32).to_le_bytes());
        values.iter().fold(self, |message, value| message.word(value.to_le_bytes()))
    }

    /// A `sensor_msgs/JointState`, stamped in seconds and nanoseconds; `channels` are positions, velocities and efforts.
    pub fn joint_state(stamp: [u32; 2], joints: &[&str], channels: [&[f64]; 3]) -> Vec<u8> {
        let mut message = CdrWriter::new();
        for word in stamp {
            message.word(word.to_le_bytes());
        }
        message.text("").texts(joints);
        for channel in channels {
            message.numbers(channel);
        }
        message.end()
    }

    /// The message.
    pub fn end(self) -> Vec<u8> {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first bytes say in which order those of numbers stand.
    #[test]
    fn either_order_of_bytes_is_read() {
        let numbers = |order: u8, bytes: fn(u32) -> [u8; 4], long: fn(f64) -> [u8; 8]| {
            // A text of one letter, and a list behind the gap that it leaves.
            let list = [long(0.5).to_vec(), long(-3.0).to_vec()].concat();
            [vec![0, order, 0, 0], bytes(2).to_vec(), b"a\0".to_vec(), vec![9; 2], bytes(2).to_vec(), vec![9; 4], list]
                .concat()
        };
        for message in [numbers(0, u32::to_be_bytes, f64::to_be_bytes), numbers(1, u32::to_le_bytes, f64::to_le_bytes)]
        {
            let mut cdr = Cdr::new(&message).unwrap();
            assert_eq!((cdr.text().unwrap().as_str(), cdr.count(8)), ("a", Ok(2)));
            assert_eq!([cdr.word(), cdr.word()].map(|word| word.map(f64::from_le_bytes)), [Ok(0.5), Ok(-3.0)]);
            assert_eq!(cdr.u32(), Err("it ends too early"));
        }
        for other in [&[0, 2, 0, 0][..], &[1, 1, 0, 0], &[0, 1, 0]] {
            assert!(Cdr::new(other).is_err(), "{other:?} is no plain CDR");
        }
    }

    #[test]
    fn no_list_is_longer_than_its_message() {
        let claims =
            |count: u32, bytes: usize| [vec![0, 1, 0, 0], count.to_le_bytes().to_vec(), vec![0; bytes]].concat();
        let counted = |count, bytes, size| Cdr::new(&claims(count, bytes)).unwrap().count(size);
        assert_eq!((counted(3, 24, 8), counted(4, 4, 1)), (Ok(3), Ok(4)));
        assert!(counted(4, 24, 8).is_err() && counted(u32::MAX, 24, 8).is_err());
    }
}
