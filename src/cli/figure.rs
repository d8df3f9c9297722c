use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::choice::{Choice, one_of};
use super::data::OptionalData;
use super::screenshot::{prepared, screen_choices};
use super::write_file;
use crate::app::{self, About};
use crate::figure::{self, Figure, Format, Size, Style, Theme};

/// Write the plots of a screen as SVG, PDF, PNG, or the numbers behind them as CSV with a script that plots them (matplotlib).
///
/// They hold what the window shows at first: all samples of the first trajectory. What a screen is about is done first, as for
/// `screenshot`.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope figure compare --only torque --size one-column -o torque.pdf
  torquescope figure model --only structure -o network.svg
  torquescope figure ladder mine.torquescope -o ladder.csv")]
pub struct FigureCommand {
    /// Which screen.
    #[arg(value_parser = one_of(screen_choices()))]
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
    /// How large a figure is.
    #[arg(long, default_value = "two-column", value_parser = one_of(SIZES))]
    size: Size,
    /// Pixels per inch of a PNG.
    #[arg(long, default_value_t = 300.0)]
    dpi: f64,
    /// Its colours.
    #[arg(long, default_value = "print", value_parser = one_of(THEMES))]
    theme: Theme,
}

const SIZES: [Choice<Size>; 3] = [
    ("one-column", "85 mm wide", Size::OneColumn),
    ("two-column", "175 mm wide", Size::TwoColumn),
    ("slide", "254 x 143 mm", Size::Slide),
];

const THEMES: [Choice<Theme>; 3] = [
    ("print", "dark on white, told apart without colours too", Theme::Print),
    ("light", "as the light window", Theme::Light),
    ("dark", "as the dark window", Theme::Dark),
];

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
        self.data.check_output(&self.output)?;
        let session = prepared(self.screen, &self.data.session_or_embedded()?)?;
        let mut panels = app::plots(session, self.screen);
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
        let files = figure::files(&Figure::new(panels), format, &self.look.style(), &self.output)?;
        files.iter().try_for_each(|(path, bytes)| write_file(path, bytes))
    }
}
