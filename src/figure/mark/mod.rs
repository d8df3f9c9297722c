//! What can be drawn over two axes. A mark is one file: its data, what it takes of the axes, its entry in the legend, its
//! numbers, how it is drawn on any [`Canvas`], and by pgfplots and matplotlib. A new mark is one file and one line here.

mod arrow;
mod band;
mod bars;
mod boxes;
mod cells;
mod frame;
mod line;
mod points;
mod shade;
mod word;

use std::fmt::Debug;

pub use arrow::Arrow;
pub use band::Band;
pub use bars::Bars;
pub use boxes::Boxes;
pub use cells::{Cells, Shades};
pub use frame::Frame;
pub use line::{Course, Line, nearest};
pub use points::Points;
pub use shade::Shade;
pub use word::Word;

use super::axis::{Axis, Scale};
use super::canvas::{Canvas, Fill, Stroke};
use super::colours::{Dash, Ink};
use super::decimate::{Decimator, Pieces, Sight};
use super::place::Place;
use super::shared::Shared;
use super::tex::{Drawn, Paper};

/// How much of an area's colour is seen.
const PALE: f64 = 0.35;
/// Width of an area's edge, relative to the usual line.
const EDGE: f64 = 0.6;
/// Width of whiskers, relative to the usual line.
const WHISKER: f64 = 0.8;

/// Something drawn over the axes. NaN is a hole.
pub trait Mark: Debug + Send + Sync {
    /// Tells which values of an axis it shows.
    fn reach(&self, reach: &mut Reach);

    /// What is left free beside it.
    fn edges(&self) -> Edges {
        Edges::Tight
    }

    /// How the legend names it; an empty name stands in no legend.
    fn entry(&self) -> Option<Entry<'_>> {
        None
    }

    /// What it is called where it stands alone: as in the legend, unless it stands there with others.
    fn name(&self) -> &str {
        self.entry().map_or("", |entry| entry.name)
    }

    /// Whether it lies behind the grid.
    fn is_behind(&self) -> bool {
        false
    }

    /// Draws it.
    fn draw(&self, place: &Place, canvas: &mut dyn Canvas);

    /// What it is, in tables.
    fn kind(&self) -> &'static str;

    /// Its numbers, one row a point: all that lie in the shown range.
    fn rows(&self, x: &Axis, write: &mut dyn FnMut(Row));

    /// What draws these rows in a picture of pgfplots.
    fn pgfplots(&self, rows: &[Row], paper: &Paper) -> Drawn;

    /// Lines of Python that draw `rows` of its kind on `ax` by matplotlib, where `x`, `y` and `column(rows, "low")` are lists,
    /// `name` stands in the legend, and `count` is how many marks of the kind the plot has.
    fn matplotlib(&self) -> &'static str;

    /// Its value at x, if it has one there.
    fn value_at(&self, _x: f64) -> Option<f64> {
        None
    }

    /// Its value and that value's unit at a place, if it has one there and not only at an x.
    fn value_in(&self, _place: [f64; 2]) -> Option<(f64, &str)> {
        None
    }

    /// Mean and root mean square of what it shows between two x.
    fn mean_and_rms(&self, _between: [f64; 2]) -> Option<[f64; 2]> {
        None
    }
}

/// What is left free beside a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// Something above and below, nothing at the sides.
    Tight,
    /// Something on all sides.
    Loose,
    /// Something on all sides but below 0, on which it stands.
    OnZero,
    /// Nothing: it fills the plot, also the grid.
    Filled,
}

/// A name in the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry<'a> {
    /// What it says.
    pub name: &'a str,
    /// What stands before it.
    pub key: Key,
}

/// How an entry of the legend looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Key {
    /// A piece of a line of this dash, opacity and width.
    Line(Ink, Dash, f64, f64),
    /// A piece of an area.
    Patch(Ink),
    /// A point.
    Dot(Ink),
    /// A bar of the colours of values.
    Scale(Shades),
}

impl Key {
    /// Width of a piece of a line in letters.
    pub const WIDTH: f64 = 2.3;
    /// Width of a bar of colours in letters: enough to read a value off it.
    const BAR: f64 = 6.0;

    /// Its width in letters.
    pub fn width(self) -> f64 {
        if matches!(self, Key::Scale(_)) { Key::BAR } else { Key::WIDTH }
    }

    /// Its ink.
    pub fn ink(self) -> Ink {
        match self {
            Key::Line(ink, ..) | Key::Patch(ink) | Key::Dot(ink) => ink,
            Key::Scale(_) => Ink::Text,
        }
    }

    /// Draws it from `x` to the right, about the height `middle`.
    pub fn draw(self, canvas: &mut dyn Canvas, [x, middle]: [f64; 2]) {
        let (letter, usual) = (canvas.letter(), canvas.usual());
        match self {
            Key::Line(ink, dash, opacity, width) => {
                let stroke = Stroke { color: canvas.colours().of(ink), opacity, width: width * usual, dash };
                canvas.polyline(&[[x, middle], [x + Key::WIDTH * letter, middle]], &stroke);
            }
            Key::Patch(ink) => {
                let color = canvas.colours().of(ink);
                let sides = [[x + 1.2 * letter, x + 2.3 * letter], [middle - 0.35 * letter, middle + 0.35 * letter]];
                let edge = Stroke::new(color, EDGE * usual);
                canvas.rectangle(sides, &Fill { color, opacity: PALE }, Some(&edge), 0.0);
            }
            Key::Dot(ink) => {
                let fill = Fill { color: canvas.colours().of(ink), opacity: 1.0 };
                canvas.dots(&[[x + 1.8 * letter, middle]], 0.25 * letter, &fill);
            }
            Key::Scale(shades) => {
                let sides = [[x, x + Key::BAR * letter], [middle - 0.4 * letter, middle + 0.4 * letter]];
                shades.bar(canvas, sides);
            }
        }
    }
}

/// Numbers of one point. What a mark does not have, and what is a hole, is NaN.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// Its name in the legend.
    pub series: &'a str,
    /// Where.
    pub x: f64,
    /// How high.
    pub y: f64,
    /// Lower end of an interval, or lower quartile.
    pub low: f64,
    /// Upper end of an interval, or upper quartile.
    pub high: f64,
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// What a colour stands for.
    pub value: f64,
}

impl<'a> Row<'a> {
    /// A row without numbers.
    pub fn new(series: &'a str) -> Self {
        let none = f64::NAN;
        Row { series, x: none, y: none, low: none, high: none, least: none, most: none, value: none }
    }

    /// A row of a point.
    pub fn point(series: &'a str, [x, y]: [f64; 2]) -> Self {
        Row { x, y, ..Row::new(series) }
    }
}

/// Which values of one axis are shown.
pub struct Reach<'a> {
    /// 0 for the horizontal axis, 1 for the vertical one.
    pub which: usize,
    axes: [&'a Axis; 2],
    seen: Option<[f64; 2]>,
    columns: usize,
    decimator: &'a mut Decimator,
    ends: [f64; 2],
}

impl<'a> Reach<'a> {
    /// Of the axis `which`; with `seen` only what lies there on the horizontal one.
    pub(super) fn new(
        which: usize,
        axes: [&'a Axis; 2],
        seen: Option<[f64; 2]>,
        columns: usize,
        decimator: &'a mut Decimator,
    ) -> Self {
        Reach { which, axes, seen, columns, decimator, ends: [f64::INFINITY, f64::NEG_INFINITY] }
    }

    /// Shows a value.
    pub fn take(&mut self, value: f64) {
        let value = self.axes[self.which].measure(value);
        if value.is_finite() {
            self.ends = [self.ends[0].min(value), self.ends[1].max(value)];
        }
    }

    /// Shows all values.
    pub fn take_all(&mut self, values: impl IntoIterator<Item = f64>) {
        values.into_iter().for_each(|value| self.take(value));
    }

    /// Shows points, as far as they are in sight.
    pub fn take_points<'p>(&mut self, points: impl IntoIterator<Item = &'p [f64; 2]>) {
        for point in points {
            if self.sees(point[0]) {
                self.take(point[self.which]);
            }
        }
    }

    /// Whether anything at this x is in sight.
    pub fn sees(&self, x: f64) -> bool {
        self.which == 0 || self.seen.is_none_or(|[from, to]| (from..=to).contains(&x))
    }

    /// What is in sight of a line over ascending x, thinned.
    fn pieces(&mut self, x: &Shared<f64>, y: &Shared<f64>, gaps: bool) -> Pieces {
        let whole = || [x.first().copied().unwrap_or(0.0), x.last().copied().unwrap_or(0.0)];
        let (range, columns) = (self.seen.unwrap_or_else(whole), self.columns);
        let positive = self.axes[1].scale == Scale::Logarithmic;
        self.decimator.line(x, y, Sight { range, columns, gaps, positive })
    }

    /// The least and the largest value, in the axis' own measure.
    pub(super) fn ends(&self) -> [f64; 2] {
        self.ends
    }
}
