use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use clap::builder::RangedU64ValueParser;

use super::choice::{Choice, one_of};
use super::data::OptionalData;
use super::failure::OrUsage;
use super::screenshot::{prepared, screen_choices};
use super::{output_folder, progress, write_file};
use crate::app::{About, Looking, TorquescopeApp};
use crate::figure::{self, Family, Figure, Format, Legend, Panel, Size, Style, Theme};
use crate::progress::Monitor;
use crate::session::{Document, Session, View};

/// Write the plots of a screen as SVG, PDF, PNG, or the numbers behind them as CSV with what plots them (matplotlib, pgfplots).
///
/// They hold what the window shows at first: all samples of the first trajectory; of a saved session those of the trajectory that
/// one looked at, with the models that are drawn over each other. What a screen is about is done first, as for `screenshot`, but
/// not where all screens are asked for.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope figure compare --only torque --size one-column -o torque.pdf
  torquescope figure compare log.csv --trajectory 3 --range 2..5 --only 'joint 2' --show components -o parts.pdf
  torquescope figure compare mine.torquescope --models all --show grid -o grid.pdf
  torquescope figure compare log.csv --line 'joint 1: residual' '0.4 * sign(qd1)' --only 'joint 1: residual' -o guess.pdf
  torquescope figure model --only structure -o network.svg
  torquescope figure compare --only residual --columns 2 --letters --font serif --theme grey -o residuals.pdf
  torquescope figure all mine.torquescope --format pdf -o figures
  torquescope figure ladder mine.torquescope -o ladder.csv
  torquescope figure extrapolation seeds.torquescope --models all -o bands.pdf  # after: train … --seeds 5 -o seeds.torquescope")]
pub struct FigureCommand {
    /// Which screen, or all that have plots.
    #[arg(value_parser = one_of(shown_choices()))]
    screen: Shown,
    #[command(flatten)]
    data: OptionalData,
    #[command(flatten)]
    at: FigureOf,
    /// Only plots whose title contains this. May be repeated: the plots stand in the order of these.
    #[arg(long, value_name = "TITLE")]
    only: Vec<String>,
    #[command(flatten)]
    look: FigureLook,
    /// The file; its ending says what it holds: .svg, .pdf, .png or .csv. For all screens a folder.
    #[arg(short, long, value_name = "FILE|FOLDER")]
    output: PathBuf,
    /// For all screens: what the files hold.
    #[arg(long, default_value = "svg", value_parser = one_of(FORMATS))]
    format: Format,
}

/// What figures are of.
#[derive(Args)]
struct FigureOf {
    /// Of which trajectory: its name, or its number from 1.
    #[arg(long, value_name = "NAME|NUMBER")]
    trajectory: Option<String>,
    /// Only this part of the trajectory [s].
    #[arg(long, value_name = "FROM..TO", value_parser = range)]
    range: Option<[f64; 2]>,
    /// Of these models of the session and no others, by name or by number from 1, with commas between them; `all` for all. The first
    /// is the current one. May be repeated.
    #[arg(long, value_name = "NAME,…")]
    models: Vec<String>,
    /// Of which joint, from 1, where a screen shows one at a time.
    #[arg(long, value_name = "NUMBER")]
    joint: Option<usize>,
    /// Lines of your own in a chart below those over time, such as `tau1 - predicted1`, with semicolons between them.
    #[arg(long, value_name = "FORMULA;…")]
    formula: Option<String>,
    /// A line of your own in each chart over time or over a state whose title contains this. May be repeated.
    #[arg(long, num_args = 2, value_names = ["CHART", "FORMULA"])]
    line: Vec<String>,
    /// What a check box or chooser of the screen shows: `terms`, `components`, `components=gravity`, `grid`, `grid=torque` (compare);
    /// `training`, `map=position-velocity` (residuals); `let-go` (model); `one-seed` (train); `one-joint` (extrapolation); `after`,
    /// `effect=ID` (diagnose). May be repeated.
    #[arg(long, value_name = "WHAT")]
    show: Vec<String>,
}

impl FigureOf {
    fn looking(&self) -> Looking {
        let (trajectory, formula) = (self.trajectory.clone(), self.formula.clone());
        let (models, show) = (self.models.clone(), self.show.clone());
        let lines = self.line.chunks_exact(2).map(|line| [line[0].clone(), line[1].clone()]).collect();
        Looking { trajectory, range: self.range, models, joint: self.joint, formula, lines, show }
    }
}

/// A stretch of time.
fn range(text: &str) -> Result<[f64; 2], String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some([from.trim().parse().ok()?, to.trim().parse().ok()?]));
    let ends: Option<[f64; 2]> = ends.filter(|[from, to]: &[f64; 2]| from.is_finite() && to.is_finite() && from < to);
    ends.ok_or_else(|| format!("`{text}` is no stretch of time: write it like 2..5.5"))
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
        let Document { history, view } = self.data.document_or_embedded()?;
        let looking = self.at.looking();
        let session = looking.taken_up(history.current()).or_usage()?;
        let mut app = self.window(session, view, &looking, |_| true)?;
        output_folder(&self.output)?;
        for (path, figure) in app.pages(self.format, &self.output, &Monitor::new())? {
            let panels = self.wanted(&figure.panels);
            if !panels.is_empty() {
                self.write(Figure { panels, ..figure }, self.format, &path)?;
            }
        }
        Ok(())
    }

    /// The window that looks as it was asked for; what is to be shown must be known to one of these screens.
    fn window(
        &self,
        session: Session,
        view: View,
        looking: &Looking,
        of: impl Fn(&About) -> bool,
    ) -> anyhow::Result<TorquescopeApp> {
        let mut app = TorquescopeApp::looking_at(session, view);
        let left_out = app.look_as(looking, of).or_usage()?;
        if !left_out.is_empty() {
            let names: Vec<&str> = left_out.iter().map(|step| step.name.as_str()).collect();
            progress::remark(format_args!("left out, since no more models can be told apart: {}", names.join("; ")));
        }
        Ok(app)
    }

    /// The plots that were asked for, in that order.
    fn wanted(&self, panels: &[Panel]) -> Vec<Panel> {
        if self.only.is_empty() {
            return panels.to_vec();
        }
        let mut wanted: Vec<&Panel> = Vec::new();
        for only in &self.only {
            for panel in panels.iter().filter(|panel| panel.title.contains(only.as_str())) {
                if !wanted.iter().any(|known| std::ptr::eq(*known, panel)) {
                    wanted.push(panel);
                }
            }
        }
        wanted.into_iter().cloned().collect()
    }

    fn write(&self, figure: Figure, format: Format, path: &Path) -> anyhow::Result<()> {
        let style = self.look.style();
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
        let Document { history, view } = self.data.document_or_embedded()?;
        let looking = self.at.looking();
        let session = looking.taken_up(history.current()).or_usage()?;
        let session = prepared(screen, &session, &looking.chosen(&session).or_usage()?)?;
        let mut app = self.window(session, view, &looking, |about| about == screen)?;
        app.show_screen(screen);
        let figure = app.figure();
        if figure.panels.is_empty() {
            bail!("the screen `{}` shows no plot of these data", screen.id);
        }
        let titles = |panels: &[Panel]| panels.iter().map(|panel| format!("“{}”", panel.title)).collect::<Vec<_>>();
        let has = |only: &&String| figure.panels.iter().any(|panel| panel.title.contains(only.as_str()));
        if let Some(only) = self.only.iter().find(|only| !has(only)) {
            bail!("no title contains “{only}”; the screen shows {}", titles(&figure.panels).join(", "));
        }
        let panels = self.wanted(&figure.panels);
        self.write(Figure { panels, ..figure }, format, &self.output)
    }
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn a_stretch_of_time_goes_forward() {
        assert_eq!(range("2..5.5"), Ok([2.0, 5.5]));
        assert_eq!(range("-1.5 .. 0"), Ok([-1.5, 0.0]));
        for wrong in ["5..2", "2", "..", "a..b", "0..inf"] {
            assert!(range(wrong).unwrap_err().contains("like 2..5.5"), "{wrong}");
        }
    }
}
