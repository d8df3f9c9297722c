//! Learning.
pub mod loss;
pub mod predict;
