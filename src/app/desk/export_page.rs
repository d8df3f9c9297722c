//! What the dialog of exports is about.

/// What goes out of the window as files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportPage {
    /// The plots of the screen.
    Plots,
    /// A report of the session.
    Report,
    /// A model: code, values in a robot's file, weights.
    Model,
    /// The recording, or what a model says of it.
    Data,
}
