//! Stub.
use crate::session::Session;
/// Stub.
#[derive(Debug, Clone, Default)]
pub struct ScreenshotOptions {
    /// Stub.
    pub screen: String,
}
/// Stub.
pub fn run_window(_start: Session) -> anyhow::Result<()> {
    Ok(())
}
/// Stub.
pub fn screenshot(_session: Session, _options: &ScreenshotOptions) -> anyhow::Result<Vec<u8>> {
    Ok(Vec::new())
}
