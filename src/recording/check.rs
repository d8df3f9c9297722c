//! Stub.
/// Stub.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Stub.
    pub what: String,
    /// Stub.
    pub remedy: String,
}
