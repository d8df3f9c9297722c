//! The only threads of the program: long work runs in a [`Job`], which tells its progress, answers a stop at once and
//! turns a panic into a message.

mod job;

pub use job::{Job, Outcome};
