//! Stub.
/// Stub.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping;
