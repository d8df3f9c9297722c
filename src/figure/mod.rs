//! Figures as data, and as files: SVG, PDF, PNG, and the numbers behind them as CSV.
//!
//! A [`Figure`] is a grid of [`Panel`]s; a panel has two [`Axis`] and [marks](mark), which share the numbers of whoever has
//! them. Nothing here knows of windows, recordings or experiments: who has results describes them with these types. Marks
//! draw themselves on a [`Canvas`](canvas::Canvas): [`render`] prints them on paper, the window has a canvas of its own.
//!
//! ```
//! use torquescope::figure::{Axis, Figure, Format, Ink, Panel, Style, mark::Line, render};
//! let curve = Line::through("structured DeLaN", [[1.0, 1e-6], [2.0, 4e-6]], Ink::Series(0));
//! let axes = [Axis::new("velocity scale", ""), Axis::new("nMSE", "").logarithmic()];
//! let figure = Figure::new(vec![Panel::new("error", axes).with(curve)]);
//! let svg = render(&figure, Format::Svg, &Style::default())?;
//! # assert!(svg.starts_with(b"<svg"));
//! # Ok::<(), torquescope::figure::FigureError>(())
//! ```
//!
//! Equal figures give equal bytes: nothing of a file depends on time, place or machine.

mod axis;
pub mod canvas;
pub mod colours;
mod csv;
pub mod decimate;
pub mod diagnosis;
pub mod font;
pub mod latex;
pub mod lines;
pub mod mark;
mod page;
mod panel;
mod pgfplots;
mod place;
mod script;
mod shared;
mod size;
mod svg;
pub mod table;
pub mod tex;
pub mod ticks;

use std::path::{Path, PathBuf};

pub use axis::{Axis, Scale, with_unit};
pub use colours::{Ink, Theme};
pub use font::Family;
use page::LARGEST_SIDE;
#[cfg(test)]
pub(crate) use page::embedded;
pub use panel::{Figure, Panel};
pub use place::{Area, Place};
pub use script::script;
pub use shared::Shared;
pub use size::Size;
pub use svg::escaped as svg_escaped;

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Vector picture for the web, with its font.
    Svg,
    /// Vector picture for print, with its font.
    Pdf,
    /// Pixels.
    Png,
    /// The numbers.
    Csv,
}

impl Format {
    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Svg => "svg",
            Format::Pdf => "pdf",
            Format::Png => "png",
            Format::Csv => "csv",
        }
    }

    /// The format that a path's ending asks for.
    ///
    /// # Errors
    /// If it ends otherwise.
    pub fn of(path: &Path) -> Result<Self, FigureError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(Format::Svg),
            Some("pdf") => Ok(Format::Pdf),
            Some("png") => Ok(Format::Png),
            Some("csv") => Ok(Format::Csv),
            _ => Err(FigureError::Ending(path.display().to_string())),
        }
    }
}

/// How a figure is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// How wide.
    pub size: Size,
    /// In which colours.
    pub theme: Theme,
    /// Pixels per inch of a PNG.
    pub dpi: f64,
    /// How many panels stand beside each other; `None` as the figure says.
    pub columns: Option<usize>,
    /// Height of each plot \[mm\]; `None` takes what suits its width. Slides share their height.
    pub height: Option<f64>,
    /// Height of the letters \[points\]; `None` takes what suits the size.
    pub letter: Option<f64>,
    /// Their font.
    pub family: Family,
    /// Whether panels are called (a), (b), …
    pub lettered: bool,
    /// Whether stretches that lie behind the lines, such as what is held out, are shaded.
    pub shaded: bool,
    /// Where the legends stand.
    pub legend: Legend,
}

/// Where the legends of a figure stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Legend {
    /// Above each panel, or above all of them where they all have the same.
    #[default]
    Own,
    /// One for all panels, above them.
    Shared,
}

impl Default for Style {
    fn default() -> Self {
        Style {
            size: Size::default(),
            theme: Theme::default(),
            dpi: Size::default().dpi(),
            columns: None,
            height: None,
            letter: None,
            family: Family::default(),
            lettered: false,
            shaded: true,
            legend: Legend::default(),
        }
    }
}

/// Why there is no file of a figure.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The ending of the path names no format.
    #[error("`{0}` names no format of a figure: end it with .svg, .pdf, .png or .csv")]
    Ending(String),
    /// There is nothing to draw.
    #[error("there is no plot to draw")]
    Empty,
    /// Pixels that can't be.
    #[error("a picture of {width} × {height} pixels can't be drawn: choose another resolution (dpi)")]
    Pixels {
        /// Width \[pixels\].
        width: f64,
        /// Height \[pixels\].
        height: f64,
    },
    /// The picture could not be turned into this format.
    #[error("the figure can't be written as {format}: {reason}")]
    Conversion {
        /// Which format.
        format: &'static str,
        /// What the library says.
        reason: String,
    },
}

/// A file, and what is in it.
pub type Named = (PathBuf, Vec<u8>);

/// The files that an export to `path` makes: the figure, and beside the table of its numbers what draws them anew, a script for
/// matplotlib and a file of pgfplots.
///
/// # Errors
/// As [`render`].
pub fn files(figure: &Figure, format: Format, style: &Style, path: &Path) -> Result<Vec<Named>, FigureError> {
    let mut files = vec![(path.to_owned(), render(figure, format, style)?)];
    if format == Format::Csv {
        let table = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        files.push((path.with_file_name(format!("{stem}_plot.py")), script(figure, style, &table).into_bytes()));
        files.push((path.with_file_name(format!("{stem}.tex")), pgfplots::picture(figure, style, &table).into_bytes()));
    }
    Ok(files)
}

/// [`files`] with as many pixels an inch as fit, where those of the style are too many; in that case these come back too.
///
/// # Errors
/// As [`files`].
pub fn files_that_fit(
    figure: &Figure,
    format: Format,
    style: &Style,
    path: &Path,
) -> Result<(Vec<Named>, Option<f64>), FigureError> {
    match files(figure, format, style, path) {
        Err(FigureError::Pixels { width, height }) => {
            let dpi = (style.dpi * LARGEST_SIDE / width.max(height)).floor();
            Ok((files(figure, format, &Style { dpi, ..*style }, path)?, Some(dpi)))
        }
        files => Ok((files?, None)),
    }
}

/// An SVG to stand in a page among others, without the font; `mark` begins its own ids, so that they are nobody else's.
///
/// # Errors
/// If there is no panel.
pub fn inline(figure: &Figure, style: &Style, mark: &str) -> Result<String, FigureError> {
    if figure.panels.is_empty() {
        return Err(FigureError::Empty);
    }
    let svg = svg::draw(figure, style, svg::Letters::Named);
    Ok(svg.replace("id=\"", &format!("id=\"{mark}-")).replace("url(#", &format!("url(#{mark}-")))
}

/// A PDF of pages that are SVG without fonts, set in the letters of a family.
///
/// # Errors
/// [`FigureError::Conversion`] if a page is no SVG.
pub fn pages(pages: &[String], family: Family) -> Result<Vec<u8>, FigureError> {
    page::pdf(pages, family)
}

/// The bytes of a file that shows `figure`, or of the table of its numbers.
///
/// # Errors
/// If there is no panel, or the resolution of a PNG can't be.
pub fn render(figure: &Figure, format: Format, style: &Style) -> Result<Vec<u8>, FigureError> {
    if figure.panels.is_empty() {
        return Err(FigureError::Empty);
    }
    match format {
        Format::Svg => Ok(svg::draw(figure, style, svg::Letters::Embedded).into_bytes()),
        Format::Pdf => page::pdf(&[svg::draw(figure, style, svg::Letters::Named)], style.family),
        Format::Png => page::png(&svg::draw(figure, style, svg::Letters::Named), style.family, style.dpi),
        Format::Csv => csv::table(figure),
    }
}

/// A picture as it is.
pub struct Pixels {
    /// Width and height.
    pub size: [usize; 2],
    /// Red, green, blue and opacity of each pixel, row after row, the colours multiplied by the opacity.
    pub rgba: Vec<u8>,
}

/// The pixels of a PNG of `figure`.
///
/// # Errors
/// As [`render`].
pub fn pixels(figure: &Figure, style: &Style) -> Result<Pixels, FigureError> {
    if figure.panels.is_empty() {
        return Err(FigureError::Empty);
    }
    let picture = page::pixels(&svg::draw(figure, style, svg::Letters::Named), style.family, style.dpi)?;
    let size = [picture.width(), picture.height()].map(|side| side as usize);
    Ok(Pixels { size, rgba: picture.take() })
}

#[cfg(test)]
mod tests;
