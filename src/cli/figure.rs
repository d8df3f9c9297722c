use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::data::OptionalData;
use super::screenshot::prepared;
use super::write_file;
use crate::app::{self, About, screens};
use crate::figure::{self, Figure, Format, Size, Style, Theme};

/// Write the plots of a screen as SVG, PDF, PNG, or the numbers behind them as CSV.
///
/// They hold what the window shows at first: all samples of the first trajectory. What a screen is about is done first, as for
/// `screenshot`.
#[derive(Args)]
pub struct FigureCommand {
    /// Which screen.
    #[arg(value_parser = screens::find)]
    screen: &'static About,
    #[command(flatten)]
    data: OptionalData,
    /// Only plots whose title contains this.
    #[arg(long, value_name = "TITLE")]
    only: Option<String>,
    #[command(flatten)]
    look: FigureLook,
    /// The file; its ending says what it holds: .svg, .pdf, .png or .csv.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// How figures are drawn.
#[derive(Args)]
pub struct FigureLook {
    /// one-column (85 mm), two-column (175 mm) or slide.
    #[arg(long, default_value = "two-column")]
    size: Size,
    /// Pixels per inch of a PNG.
    #[arg(long, default_value_t = 300.0)]
    dpi: f64,
    /// print, light or dark.
    #[arg(long, default_value = "print")]
    theme: Theme,
}

impl FigureLook {
    /// The style that was asked for.
    pub fn style(&self) -> Style {
        Style { size: self.size, theme: self.theme, dpi: self.dpi }
    }
}

impl FigureCommand {
    /// Reads or simulates, does what the screen is about, writes.
    pub fn run(&self) -> anyhow::Result<()> {
        let format = Format::of(&self.output)?;
        let session = prepared(self.screen, &self.data.session_or_embedded()?)?;
        let mut panels = app::plots(session, self.screen)?;
        let titles: Vec<String> = panels.iter().map(|panel| format!("“{}”", panel.title)).collect();
        if titles.is_empty() {
            bail!("the screen `{}` shows no plot of these data", self.screen.id);
        }
        if let Some(only) = &self.only {
            panels.retain(|panel| panel.title.contains(only.as_str()));
            if panels.is_empty() {
                bail!("no title contains “{only}”; the screen shows {}", titles.join(", "));
            }
        }
        write_file(&self.output, &figure::render(&Figure::new(panels), format, &self.look.style())?)
    }
}
