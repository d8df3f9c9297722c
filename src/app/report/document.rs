//! What a report is made of, whatever it is written as.

pub(super) use crate::figure::table::Table;

/// A report.
pub(super) struct Document {
    pub(super) title: String,
    pub(super) blocks: Vec<Block>,
}

/// A part of it.
pub(super) enum Block {
    /// A section begins.
    Heading(String),
    Text(String),
    List(Vec<String>),
    Table(Table),
    Figure {
        title: String,
        svg: String,
    },
    /// What is typed into a terminal.
    Code(String),
    /// Two parts side by side, or one below the other where there is no room, each under its name.
    Beside([(String, Vec<Block>); 2]),
}
