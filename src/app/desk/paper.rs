//! As what a report is written.

/// What a report is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportFormat {
    /// One page with everything in it.
    Html,
    /// The same as pages of paper.
    Pdf,
    /// The tables, with booktabs.
    Latex,
    /// Text and tables.
    Markdown,
}

impl ReportFormat {
    /// What it is called, and how its files end.
    pub const ALL: [(ReportFormat, &'static str, &'static str); 4] = [
        (ReportFormat::Html, "HTML: one page", "html"),
        (ReportFormat::Pdf, "PDF", "pdf"),
        (ReportFormat::Latex, "LaTeX: its tables", "tex"),
        (ReportFormat::Markdown, "Markdown", "md"),
    ];

    /// Whether charts stand in it.
    pub fn has_figures(self) -> bool {
        matches!(self, ReportFormat::Html | ReportFormat::Pdf)
    }
}
