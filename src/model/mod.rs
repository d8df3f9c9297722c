//! To be written.

pub mod learned;
