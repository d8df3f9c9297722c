//! What reading a file may take: one account for all readers, opened with the size of the file.
//!
//! A file tells how large its parts are, and it may lie; a few bytes of it may unpack to gigabytes. So whatever is unpacked, and
//! whatever is held beside the numbers, is put on this account before it is made, also for parts that are then passed over.

/// The file asks for more than it may take.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TooMuch {
    /// More than the limit.
    #[error("unpacked it takes more than {limit} MB; cut the log into several files, or raise the limit")]
    Limit {
        /// What is allowed \[MB\].
        limit: u64,
    },
    /// More than its own size lets one expect.
    #[error(
        "unpacked it takes more than {limit} MB, over {DENSEST} times its size, as no log does; \
         write it anew without compression"
    )]
    Dense {
        /// What is allowed \[MB\].
        limit: u64,
    },
    /// Names and parts that are no samples.
    #[error(
        "beside its samples it holds more than {limit} MB of names and other parts; write the log anew with its samples only"
    )]
    Beside {
        /// What is allowed \[MB\].
        limit: u64,
    },
}

/// Every file may be unpacked to so much \[bytes\], however small it is: arrays and the columns that are made of them stand in memory
/// together for a moment, and are to take less than 64 MiB.
const LEAST: u64 = 30 << 20;
/// Every file may hold so much beside its numbers \[bytes\].
const LEAST_BESIDE: u64 = 48 << 20;
/// How many times its size may be unpacked: logs of 64-bit numbers are packed to a tenth of their size, not to a thousandth.
const DENSEST: u64 = 32;
/// How many times its size may be held beside the numbers.
const BESIDE: u64 = 4;
/// What the name of a column takes for each of its bytes: it is read, compared and told many times.
const NAME: u64 = 64;
/// What a piece of text takes in memory, beside its bytes.
const TEXT: u64 = 64;

/// What may still be taken \[bytes\].
#[derive(Debug)]
pub(super) struct Budget {
    to_unpack: u64,
    beside: u64,
    if_unpacked: TooMuch,
    if_beside: TooMuch,
}

impl Budget {
    /// For a file of so many bytes, whose numbers may take `limit` bytes.
    pub fn of(size: u64, limit: u64) -> Budget {
        let dense = LEAST.max(size.saturating_mul(DENSEST));
        let beside = LEAST_BESIDE.max(size.saturating_mul(BESIDE));
        let if_unpacked = match limit <= dense {
            true => TooMuch::Limit { limit: limit >> 20 },
            false => TooMuch::Dense { limit: dense >> 20 },
        };
        let if_beside = TooMuch::Beside { limit: beside >> 20 };
        Budget { to_unpack: limit.min(dense), beside, if_unpacked, if_beside }
    }

    /// How much may still be unpacked.
    pub fn left_to_unpack(&self) -> u64 {
        self.to_unpack
    }

    /// Takes bytes that are unpacked, or numbers that are made of bytes; all of them, also those that are not kept.
    pub fn unpack(&mut self, bytes: u64) -> Result<(), TooMuch> {
        self.to_unpack = self.to_unpack.checked_sub(bytes).ok_or_else(|| self.if_unpacked.clone())?;
        Ok(())
    }

    /// Takes bytes that are held beside the numbers.
    pub fn hold(&mut self, bytes: u64) -> Result<(), TooMuch> {
        self.beside = self.beside.checked_sub(bytes).ok_or_else(|| self.if_beside.clone())?;
        Ok(())
    }

    /// Gives back what is not held any more.
    pub fn give_back(&mut self, bytes: u64) {
        self.beside = self.beside.saturating_add(bytes);
    }

    /// Takes a text that is held.
    pub fn text(&mut self, text: &str) -> Result<(), TooMuch> {
        self.hold(text.len() as u64 + TEXT)
    }

    /// Takes the name of a column.
    pub fn name(&mut self, name: &str) -> Result<(), TooMuch> {
        self.hold((name.len() as u64).saturating_mul(NAME) + TEXT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_and_the_limit_is_named() {
        let mut budget = Budget::of(1000, 1 << 20);
        assert_eq!(budget.unpack(1 << 19), Ok(()));
        assert_eq!(budget.unpack(1 << 19), Ok(()));
        assert_eq!(budget.unpack(1), Err(TooMuch::Limit { limit: 1 }));
        assert_eq!(Budget::of(1000, 1 << 30).unpack(LEAST + 1), Err(TooMuch::Dense { limit: 30 }));
        assert_eq!(Budget::of(10 << 20, 1 << 30).unpack(320 << 20), Ok(()));
        assert_eq!(Budget::of(100 << 20, 1 << 30).hold(400 << 20), Ok(()));
        assert_eq!(Budget::of(1000, 1 << 30).hold(LEAST_BESIDE + 1), Err(TooMuch::Beside { limit: 48 }));
        assert!(Budget::of(1000, 1 << 30).name(&"x".repeat(1 << 21)).is_err());
    }
}
