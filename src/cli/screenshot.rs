//! Stub.
use clap::Args;
/// Stub
#[derive(Args)]
pub struct Screenshot {}
impl Screenshot {
    pub fn run(&self) -> anyhow::Result<()> {
        Ok(())
    }
}
