//! How far the reading of one file is: told in steps that can be seen, however often it is asked.

use std::io::{self, Read};

use crate::progress::{Monitor, Stopped};

/// In so many steps the reading of a file is told.
const STEPS: u64 = 200;

/// The part of a file that is read.
pub(super) struct Share<'a> {
    monitor: &'a Monitor,
    whole: u64,
    told: Option<u64>,
}

impl<'a> Share<'a> {
    /// Of so many bytes, rows or whatever is counted.
    pub fn of(whole: u64, monitor: &'a Monitor) -> Self {
        Share { monitor, whole: whole.max(1), told: None }
    }

    /// So much is read; ends what reads once it is asked to stop.
    pub fn is(&mut self, done: u64) -> Result<(), Stopped> {
        self.monitor.check()?;
        let step = done.saturating_mul(STEPS) / self.whole;
        if self.told.is_some_and(|told| told >= step) {
            return Ok(());
        }
        self.told = Some(step);
        self.monitor.report(done as f32 / self.whole as f32, "reading")
    }
}

/// Bytes that are counted as they are read; who stops it finds an error there.
pub(super) struct Counted<'a, R> {
    pub from: R,
    pub share: Share<'a>,
    pub done: u64,
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.share.is(self.done).map_err(io::Error::other)?;
        let read = self.from.read(buffer)?;
        self.done += read as u64;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_told_in_steps_and_a_stop_ends_it() {
        let monitor = Monitor::new();
        let share = Share::of(1_000_000, &monitor);
        let mut counted = Counted { from: io::repeat(0).take(1_000_000), share, done: 0 };
        let mut buffer = [0; 1000];
        for _ in 0..500 {
            counted.read_exact(&mut buffer).unwrap();
        }
        assert!((monitor.progress().fraction - 0.5).abs() < 0.01, "{:?}", monitor.progress());
        monitor.stop("enough");
        assert!(counted.read(&mut buffer).is_err() && counted.share.is(0).is_err());
    }
}
