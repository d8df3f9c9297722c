use std::path::PathBuf;

use clap::Args;

use super::choice::{Choice, one_of};
use super::data::OptionalData;
use super::screenshot::prepared;
use super::{progress, write_file};
use crate::app::screens::{diagnose, ladder};
use crate::app::{ReportFormat, report};
use crate::session::Session;

/// Write what is known of recordings as one page: data, findings, model, what is missing and its evidence, what is not known.
///
/// The page needs nothing else and no network; its pictures stand in it. What a report is about is done first: a diagnosis, and the
/// effects that it names are added one after the other.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope report arm.npz -o report.html
  torquescope report log.csv --zero down --format markdown -o report.md
  torquescope report mine.torquescope --format latex -o tables.tex")]
pub struct ReportCommand {
    #[command(flatten)]
    data: OptionalData,
    /// What it is written as.
    #[arg(long, default_value = "html", value_parser = one_of(FORMATS))]
    format: ReportFormat,
    /// The file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

const FORMATS: [Choice<ReportFormat>; 3] = [
    ("html", "one page with everything in it", ReportFormat::Html),
    ("latex", "its tables, with booktabs", ReportFormat::Latex),
    ("markdown", "its text and tables", ReportFormat::Markdown),
];

impl ReportCommand {
    /// Reads, diagnoses, writes.
    pub fn run(&self) -> anyhow::Result<()> {
        self.data.check_output(&self.output)?;
        let session = prepared(&diagnose::ABOUT, self.data.document_or_embedded()?.history.current())?;
        // The ladder grows by what was found, which is told beside it.
        let session = Session { report: session.report.clone(), ..prepared(&ladder::ABOUT, &session)? };
        let page = report(&session, &[this_command()], self.format);
        write_file(&self.output, page.as_bytes())?;
        progress::told(format_args!("saved {}", self.output.display()));
        Ok(())
    }
}

/// The command as it was typed, for a shell.
fn this_command() -> String {
    let quoted = |word: String| {
        let is_plain = |c: char| c.is_alphanumeric() || "-_./=@,:+".contains(c);
        if !word.is_empty() && word.chars().all(is_plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let words = std::env::args().skip(1).map(quoted);
    std::iter::once("torquescope".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
