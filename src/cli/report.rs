use std::path::PathBuf;

use clap::Args;

use super::choice::{Choice, one_of};
use super::data::OptionalData;
use super::screenshot::prepared;
use super::{progress, write_file};
use crate::app::screens::{diagnose, extrapolation, ladder};
use crate::app::{ReportFormat, comparison, report};
use crate::file::ending::named;
use crate::session::{Document, Session};

/// Write what is known of recordings as one page: data, findings, model, what is missing and its evidence, how it does outside the
/// data, what is not known.
///
/// The page needs nothing else and no network; its pictures stand in it. What a report is about is done first: a diagnosis, and the
/// effects that it names are added one after the other. Two saved sessions stand side by side on one page.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope report arm.npz -o report.html
  torquescope report log.csv --zero down -o report.pdf
  torquescope report log.csv --zero down -o report.md
  torquescope report mine.torquescope --format latex -o tables.tex
  torquescope report before.torquescope after.torquescope -o compare.html")]
pub struct ReportCommand {
    #[command(flatten)]
    data: OptionalData,
    /// What it is written as; without, as the ending of the file says, else as html.
    #[arg(long, value_parser = one_of(FORMATS))]
    format: Option<ReportFormat>,
    /// The file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

const FORMATS: [Choice<ReportFormat>; 4] = [
    ("html", "one page with everything in it", ReportFormat::Html),
    ("pdf", "the same as pages of paper", ReportFormat::Pdf),
    ("latex", "its tables, with booktabs", ReportFormat::Latex),
    ("markdown", "its text and tables", ReportFormat::Markdown),
];

impl ReportCommand {
    /// Reads, diagnoses, writes.
    pub fn run(&self) -> anyhow::Result<()> {
        self.data.check_output(&self.output)?;
        let format = self.format();
        let page = match self.data.two_sessions()? {
            Some([(one, first), (two, second)]) => {
                let names = [one, two].map(|path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned());
                let [first, second] = [reported(&first)?, reported(&second)?];
                progress::watch("report", move |monitor| {
                    comparison([(&names[0], &first), (&names[1], &second)], format, monitor)
                })
            }
            None => {
                let session = reported(&self.data.document_or_embedded()?)?;
                progress::watch("report", move |monitor| report(&session, format, monitor))
            }
        }?;
        write_file(&self.output, &page)?;
        progress::told(format_args!("saved {}", self.output.display()));
        Ok(())
    }

    fn format(&self) -> ReportFormat {
        let by_ending = || named(&ReportFormat::ALL, &self.output);
        self.format.or_else(by_ending).unwrap_or(ReportFormat::Html)
    }
}

/// The newest session of a document, diagnosed, repaired, and tried outside its data.
fn reported(document: &Document) -> anyhow::Result<Session> {
    let session = prepared(&diagnose::ABOUT, document.history.current(), &[])?;
    // The ladder grows by what was found, which is told beside it.
    let repaired = Session { report: session.report.clone(), ..prepared(&ladder::ABOUT, &session, &[])? };
    Ok(prepared(&extrapolation::ABOUT, &repaired, &[]).unwrap_or_else(|problem| {
        progress::told(format_args!("left out: how it does outside the data, since {problem}"));
        repaired
    }))
}
