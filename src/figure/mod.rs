//! Figures as data, and as files: SVG, PDF, PNG, and the numbers behind them as CSV.
//!
//! A [`Figure`] is a grid of [`Panel`]s; a panel has two [`Axis`] and [`Mark`]s, which hold plain numbers. Nothing here knows
//! of windows, recordings or experiments: who has results describes them with these types and calls [`render`].
//!
//! ```
//! use torquescope::figure::{Axis, Figure, Format, Ink, Mark, Panel, Style, render};
//! let curve = Mark::line("structured DeLaN", vec![[1.0, 1e-6], [2.0, 4e-6]], Ink::Series(0));
//! let axes = [Axis::new("velocity scale", ""), Axis::new("nMSE", "").logarithmic()];
//! let figure = Figure::new(vec![Panel::new("error", axes).with(curve)]);
//! let svg = render(&figure, Format::Svg, &Style::default())?;
//! # assert!(svg.starts_with(b"<svg"));
//! # Ok::<(), torquescope::figure::FigureError>(())
//! ```
//!
//! Equal figures give equal bytes: nothing of a file depends on time, place or machine.

pub mod colours;
mod csv;
pub mod decimate;
pub mod diagnosis;
pub mod font;
mod page;
mod svg;
pub mod ticks;

use std::path::Path;
use std::str::FromStr;

pub use colours::{Ink, Theme};

/// Panels, drawn row by row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// What is drawn.
    pub panels: Vec<Panel>,
    /// How many panels stand beside each other.
    pub columns: usize,
}

impl Figure {
    /// Panels below each other.
    pub fn new(panels: Vec<Panel>) -> Self {
        Figure { panels, columns: 1 }
    }
}

/// Marks over two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, from back to front.
    pub marks: Vec<Mark>,
    /// Height of the plot as a part of its width; `None` takes what suits the size of the figure.
    pub aspect: Option<f64>,
    /// Whether it is a drawing: without numbers, grid and frame.
    pub bare: bool,
}

impl Panel {
    /// A panel without marks.
    pub fn new(title: impl Into<String>, [x, y]: [Axis; 2]) -> Self {
        Panel { title: title.into(), x, y, marks: Vec::new(), aspect: None, bare: false }
    }

    /// Adds a mark in front of the others.
    #[must_use]
    pub fn with(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// A drawing, without numbers, grid and frame.
    #[must_use]
    pub fn bare(mut self) -> Self {
        self.bare = true;
        self
    }

    /// Sets the height of the plot as a part of its width: 1 for a square.
    #[must_use]
    pub fn aspect(mut self, aspect: f64) -> Self {
        self.aspect = Some(aspect);
        self
    }
}

/// What stands along an axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// How values are placed.
    pub scale: Scale,
    /// The shown range, in the values' own unit; `None` shows everything with a margin.
    pub range: Option<[f64; 2]>,
}

/// How values are placed along an axis.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; what is not positive is left out.
    Logarithmic,
    /// The n-th name stands at n, from 0.
    Names(Vec<String>),
}

impl Axis {
    /// An even axis over everything.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Axis { label: label.into(), unit: unit.into(), ..Axis::default() }
    }

    /// An axis of names, the first at 0.
    pub fn names(label: impl Into<String>, names: Vec<String>) -> Self {
        let range = Some([-0.5, names.len() as f64 - 0.5]);
        Axis { label: label.into(), unit: String::new(), scale: Scale::Names(names), range }
    }

    /// The same with powers of ten at equal distances.
    #[must_use]
    pub fn logarithmic(mut self) -> Self {
        self.scale = Scale::Logarithmic;
        self
    }

    /// The same over this range only.
    #[must_use]
    pub fn range(mut self, range: [f64; 2]) -> Self {
        self.range = Some(range);
        self
    }
}

/// Something drawn over the axes. Names stand in the legend; those of empty name do not. NaN is a hole.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line.
    Line {
        /// In the legend.
        name: String,
        /// x and y.
        points: Vec<[f64; 2]>,
        /// Colour, and with it the dash.
        ink: Ink,
        /// Width relative to the usual.
        width: f64,
        /// How its points follow each other.
        course: Course,
    },
    /// The area between a lower and an upper line: x, lower, upper.
    Band {
        /// In the data.
        name: String,
        /// x, lower, upper.
        points: Vec<[f64; 3]>,
        /// Colour.
        ink: Ink,
    },
    /// Points in no order.
    Points {
        /// In the legend.
        name: String,
        /// x and y.
        points: Vec<[f64; 2]>,
        /// Colour.
        ink: Ink,
        /// Radius relative to the usual.
        radius: f64,
        /// Between 0 and 1.
        opacity: f64,
    },
    /// Bars from the lower end of the axis, or from 0.
    Bars {
        /// In the legend.
        name: String,
        /// Where, how high, and the ends of the interval (NaN for none).
        bars: Vec<[f64; 4]>,
        /// Width of a bar in units of x.
        width: f64,
        /// Colour.
        ink: Ink,
    },
    /// Boxes from quartile to quartile with whiskers.
    Boxes {
        /// In the legend.
        name: String,
        /// Where, least, lower quartile, median, upper quartile, most.
        boxes: Vec<[f64; 6]>,
        /// Width of a box in units of x.
        width: f64,
        /// Colour.
        ink: Ink,
    },
    /// Values as colours over a rectangle.
    Cells {
        /// How many columns and rows.
        size: [usize; 2],
        /// The ends of the horizontal and of the vertical axis.
        extent: [[f64; 2]; 2],
        /// Row by row from below; NaN where there is nothing.
        values: Vec<f64>,
        /// Whether 0 is in the middle of the colours; else it is at their beginning.
        signed: bool,
        /// Whether each value is written into its cell.
        written: bool,
    },
    /// A stretch of the horizontal axis that is held out.
    Shade([f64; 2]),
    /// A box of a drawing.
    Frame {
        /// Its left and right end, and its lower and upper one.
        sides: [[f64; 2]; 2],
        /// Colour of its edge.
        ink: Ink,
    },
    /// An arrow of a drawing, from the first point to the second.
    Arrow {
        /// Where it begins and ends.
        ends: [[f64; 2]; 2],
        /// Colour.
        ink: Ink,
    },
    /// A word of a drawing, about its middle.
    Word {
        /// What it says.
        text: String,
        /// Where its middle is.
        at: [f64; 2],
        /// How wide it may be, in units of x: a longer one has smaller letters.
        room: f64,
        /// Colour.
        ink: Ink,
    },
}

/// How the points of a line follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Course {
    /// Samples of a clock: x ascends, a jump of it is a gap.
    Sampled,
    /// x ascends, at any distances.
    #[default]
    Ascending,
    /// Anywhere, such as the path of a tool.
    Free,
}

impl Mark {
    /// A line of usual width over ascending x.
    pub fn line(name: impl Into<String>, points: Vec<[f64; 2]>, ink: Ink) -> Self {
        Mark::Line { name: name.into(), points, ink, width: 1.0, course: Course::Ascending }
    }

    /// A path through the plane, such as that of a tool.
    pub fn path(name: impl Into<String>, points: Vec<[f64; 2]>, ink: Ink) -> Self {
        Mark::Line { name: name.into(), points, ink, width: 1.0, course: Course::Free }
    }

    /// Points of usual size.
    pub fn points(name: impl Into<String>, points: Vec<[f64; 2]>, ink: Ink) -> Self {
        Mark::Points { name: name.into(), points, ink, radius: 1.0, opacity: 1.0 }
    }
}

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

/// How wide a figure is, which also sets its letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Size {
    /// One column of a page: 85 mm.
    OneColumn,
    /// A page from margin to margin: 175 mm.
    #[default]
    TwoColumn,
    /// A slide of 254 × 143 mm; panels share its height.
    Slide,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "one-column" => Ok(Size::OneColumn),
            "two-column" => Ok(Size::TwoColumn),
            "slide" => Ok(Size::Slide),
            other => Err(format!("there is no size `{other}`: choose one-column, two-column or slide")),
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
}

impl Default for Style {
    fn default() -> Self {
        Style { size: Size::default(), theme: Theme::default(), dpi: 300.0 }
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
        Format::Pdf => page::pdf(&svg::draw(figure, style, svg::Letters::Named)),
        Format::Png => page::png(&svg::draw(figure, style, svg::Letters::Named), style.dpi),
        Format::Csv => csv::table(figure),
    }
}

#[cfg(test)]
mod tests;
