//! The only threads of the program: long work runs in a [`Job`], which tells its progress, answers a stop at once and
//! turns a panic into a message.

mod job;

pub use job::{Job, Outcome, message_of};

/// Gives way to the jobs for a moment; for those who wait without a window that would wake them.
pub fn pause() {
    std::thread::sleep(std::time::Duration::from_millis(2));
}
