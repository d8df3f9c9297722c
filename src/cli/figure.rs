use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use clap::builder::RangedU64ValueParser;

use super::choice::{Choice, one_of};
use super::data::OptionalData;
use super::screenshot::{prepared, screen_choices};
use super::{output_folder, progress, write_file};
use crate::app::{self, About, screens};
use crate::figure::{self, Family, Figure, Format, Legend, Panel, Size, Style, Theme};

/// Write the plots of a screen as SVG, PDF, PNG, or the numbers behind them as CSV with what plots them (matplotlib, pgfplots).
///
/// They hold what the window shows at first: all samples of the first trajectory; of a saved session those of the trajectory that
/// one looked at, with the models that are drawn over each other. What a screen is about is done first, as for `screenshot`, but
/// not where all screens are asked for.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope figure compare --only torque --size one-column -o torque.pdf
  torquescope figure model --only structure -o network.svg
  torquescope figure compare --only residual --columns 2 --letters --font serif --theme grey -o residuals.pdf
  torquescope figure all mine.torquescope --format pdf -o figures
  torquescope figure ladder mine.torquescope -o ladder.csv")]
pub struct FigureCommand {
    /// Which screen, or all that have plots.
    #[arg(value_parser = one_of(shown_choices()))]
    screen: Shown,
    #[command(flatten)]
    data: OptionalData,
    /// Only plots whose title contains this.
    #[arg(long, value_name = "TITLE")]
    only: Option<String>,
    #[command(flatten)]
    look: FigureLook,
    /// The file; its ending says what it holds: .svg, .pdf, .png or .csv. For all screens a folder.
    #[arg(short, long, value_name = "FILE|FOLDER")]
    output: PathBuf,
    /// For all screens: what the files hold.
    #[arg(long, default_value = "svg", value_parser = one_of(FORMATS))]
    format: Format,
}

/// Whose plots are written.
#[derive(Clone, Copy)]
enum Shown {
    One(&'static About),
    All,
}

fn shown_choices() -> impl Iterator<Item = Choice<Shown>> {
    let one = |(name, purpose, about): Choice<&'static About>| (name, purpose, Shown::One(about));
    screen_choices().map(one).chain([("all", "every screen that has plots, as it is in the session", Shown::All)])
}

/// What a figure's file can hold.
pub const FORMATS: [Choice<Format>; 4] = [
    ("svg", "vectors for the web", Format::Svg),
    ("pdf", "vectors for print", Format::Pdf),
    ("png", "pixels", Format::Png),
    ("csv", "the numbers", Format::Csv),
];

/// How figures are drawn.
#[derive(Args)]
pub struct FigureLook {
    /// How large a figure is.
    #[arg(long, default_value = "two-column", value_parser = one_of(sizes()))]
    size: Size,
    /// Pixels per inch of a PNG; without it 600, on slides 300.
    #[arg(long)]
    dpi: Option<f64>,
    /// Its colours.
    #[arg(long, default_value = "print", value_parser = one_of(THEMES))]
    theme: Theme,
    /// How many plots stand beside each other.
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(COLUMNS))]
    columns: Option<usize>,
    /// Height of each plot [mm]; without it as suits the width. Slides share their height.
    #[arg(long, value_name = "MM", value_parser = positive)]
    height: Option<f64>,
    /// Height of the letters [points]; without it as suits the size.
    #[arg(long, value_name = "POINTS", value_parser = positive)]
    font_size: Option<f64>,
    /// Which letters.
    #[arg(long, default_value = "sans", value_parser = one_of(FONTS))]
    font: Family,
    /// Calls the plots (a), (b), …
    #[arg(long)]
    letters: bool,
    /// One legend for all plots, above them.
    #[arg(long)]
    shared_legend: bool,
    /// Does not shade what is held out.
    #[arg(long)]
    no_shade: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (1.0..=500.0).contains(number));
    number.ok_or_else(|| format!("`{text}` is no number from 1 to 500"))
}

fn sizes() -> [Choice<Size>; 7] {
    Size::ALL.map(|size| (size.name(), size.about(), size))
}

const THEMES: [Choice<Theme>; 4] = [
    ("print", "dark on white, told apart without colours too", Theme::Print),
    ("light", "as the light window", Theme::Light),
    ("dark", "as the dark window", Theme::Dark),
    ("grey", "for paper without colours", Theme::Grey),
];

const FONTS: [Choice<Family>; 2] =
    [("sans", "without serifs", Family::Sans), ("serif", "with serifs, as most papers", Family::Serif)];

/// Columns that a figure may have.
const COLUMNS: std::ops::RangeInclusive<u64> = 1..=4;

impl FigureLook {
    /// The style that was asked for.
    pub fn style(&self) -> Style {
        Style {
            size: self.size,
            theme: self.theme,
            dpi: self.dpi.unwrap_or(self.size.dpi()),
            columns: self.columns,
            height: self.height,
            letter: self.font_size,
            family: self.font,
            lettered: self.letters,
            shaded: !self.no_shade,
            legend: if self.shared_legend { Legend::Shared } else { Legend::Own },
        }
    }
}

impl FigureCommand {
    /// Reads or simulates, does what the screen is about, writes.
    pub fn run(&self) -> anyhow::Result<()> {
        self.data.check_output(&self.output)?;
        match self.screen {
            Shown::One(screen) => self.one(screen),
            Shown::All => self.all(),
        }
    }

    /// A file for each screen that has plots, as the session is.
    fn all(&self) -> anyhow::Result<()> {
        let document = self.data.document_or_embedded()?;
        output_folder(&self.output)?;
        for screen in screens::all() {
            let mut panels = app::plots(document.history.current().clone(), document.view.clone(), screen);
            panels.retain(|panel| self.only.as_ref().is_none_or(|only| panel.title.contains(only.as_str())));
            if !panels.is_empty() {
                let path = self.output.join(format!("{}.{}", screen.id, self.format.ending()));
                self.write(panels, self.format, &path)?;
            }
        }
        Ok(())
    }

    fn write(&self, panels: Vec<Panel>, format: Format, path: &Path) -> anyhow::Result<()> {
        let (figure, style) = (Figure::new(panels), self.look.style());
        let files = if self.look.dpi.is_some() {
            figure::files(&figure, format, &style, path)?
        } else {
            // Nobody asked for so many pixels an inch: a figure of many plots has fewer.
            let (files, fewer) = figure::files_that_fit(&figure, format, &style, path)?;
            if let Some(dpi) = fewer {
                progress::remark(format_args!("{} has {dpi} pixels an inch: more would be too many", path.display()));
            }
            files
        };
        files.iter().try_for_each(|(path, bytes)| write_file(path, bytes))
    }

    fn one(&self, screen: &'static About) -> anyhow::Result<()> {
        let format = Format::of(&self.output)?;
        let document = self.data.document_or_embedded()?;
        let session = prepared(screen, document.history.current())?;
        let mut panels = app::plots(session, document.view, screen);
        let titles: Vec<String> = panels.iter().map(|panel| format!("“{}”", panel.title)).collect();
        if titles.is_empty() {
            bail!("the screen `{}` shows no plot of these data", screen.id);
        }
        if let Some(only) = &self.only {
            panels.retain(|panel| panel.title.contains(only.as_str()));
            if panels.is_empty() {
                bail!("no title contains “{only}”; the screen shows {}", titles.join(", "));
            }
        }
        self.write(panels, format, &self.output)
    }
}
