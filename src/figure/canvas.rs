//! What marks draw on. A printer is a canvas: one writes SVG, another one draws in a window.

use super::colours::{Colours, Dash, Rgb};
use super::decimate::Decimator;

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub color: Rgb,
    /// Between 0 and 1.
    pub opacity: f64,
    /// Its width on the page.
    pub width: f64,
    /// How it is broken, for letters of 11 points.
    pub dash: Dash,
}

impl Stroke {
    /// An unbroken line.
    pub fn new(color: Rgb, width: f64) -> Self {
        Stroke { color, opacity: 1.0, width, dash: &[] }
    }
}

/// How an area is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fill {
    /// Its colour.
    pub color: Rgb,
    /// Between 0 and 1.
    pub opacity: f64,
}

/// Where a text is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// At its left end.
    Start,
    /// At its middle.
    Middle,
    /// At its right end.
    End,
}

/// A page. Its y goes down; points are finite.
pub trait Canvas {
    /// Its colours.
    fn colours(&self) -> &Colours;

    /// Height of its letters, which sets the size of everything else.
    fn letter(&self) -> f64;

    /// How finely it shows: so many columns are told apart on a unit of the page.
    fn fineness(&self) -> f64;

    /// What thins lines, and remembers how.
    fn decimator(&mut self) -> &mut Decimator;

    /// Width of a text.
    fn width_of(&self, text: &str, size: f64) -> f64;

    /// A line through points.
    fn polyline(&mut self, points: &[[f64; 2]], stroke: &Stroke);

    /// The area inside corners that bend one way only.
    fn polygon(&mut self, corners: &[[f64; 2]], fill: &Fill);

    /// The area between two lines, each from left to right, over the same places.
    fn ribbon(&mut self, lower: &[[f64; 2]], upper: &[[f64; 2]], fill: &Fill);

    /// A rectangle, given by its horizontal and vertical ends, with or without an edge.
    fn rectangle(&mut self, sides: [[f64; 2]; 2], fill: &Fill, edge: Option<&Stroke>, rounding: f64);

    /// Filled circles.
    fn dots(&mut self, centres: &[[f64; 2]], radius: f64, fill: &Fill);

    /// Many rectangles beside each other.
    fn cells(&mut self, cells: &[([[f64; 2]; 2], Rgb)]);

    /// A text on the line `y`.
    fn text(&mut self, at: [f64; 2], text: &str, size: f64, color: Rgb, hold: Hold);

    /// Width of a line of usual width.
    fn usual(&self) -> f64 {
        self.letter() / 8.0
    }

    /// A straight line.
    fn rule(&mut self, ends: [[f64; 2]; 2], color: Rgb, width: f64) {
        self.polyline(&ends, &Stroke::new(color, width));
    }
}
