//! Paper: what marks draw becomes SVG.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::figure::canvas::{Canvas, Fill, Hold, Stroke};
use crate::figure::colours::{Colours, Dash, Rgb};
use crate::figure::decimate::Decimator;
use crate::figure::font::{Family, Ruler};

/// Columns of a point that are told apart: finer than any printer shows.
pub const COLUMNS_PER_POINT: f64 = 16.0;
/// Letters for which dashes are given \[points\].
const LETTER_OF_DASHES: f64 = 11.0;

/// Pieces of SVG.
pub struct Paper {
    pub out: String,
    colours: &'static Colours,
    letter: f64,
    ruler: Ruler,
    /// All that were written.
    pub letters: BTreeSet<char>,
    decimator: Decimator,
}

/// Writes a piece of SVG; a string takes everything.
macro_rules! put {
    ($paper:expr, $($part:tt)*) => { let _ = writeln!($paper.out, $($part)*); };
}
pub(super) use put;

impl Paper {
    pub fn new(colours: &'static Colours, letter: f64, family: Family) -> Self {
        let (ruler, decimator) = (Ruler::of(family), Decimator::default());
        Paper { out: String::new(), colours, letter, ruler, letters: BTreeSet::new(), decimator }
    }

    /// A text that reads upward.
    pub fn upward(&mut self, [x, y]: [f64; 2], text: &str, color: Rgb, hold: Hold) {
        put!(self, "<g transform=\"translate({x:.2} {y:.2}) rotate(-90)\">");
        self.text([0.0, 0.0], text, self.letter, color, hold);
        put!(self, "</g>");
    }

    fn dashes(&self, dash: Dash) -> String {
        if dash.is_empty() {
            return String::new();
        }
        let length = |length: &f32| format!("{:.2}", f64::from(*length) * self.letter / LETTER_OF_DASHES);
        format!(" stroke-dasharray=\"{}\"", dash.iter().map(length).collect::<Vec<_>>().join(" "))
    }
}

impl Canvas for Paper {
    fn colours(&self) -> &Colours {
        self.colours
    }

    fn letter(&self) -> f64 {
        self.letter
    }

    fn fineness(&self) -> f64 {
        COLUMNS_PER_POINT
    }

    fn decimator(&mut self) -> &mut Decimator {
        &mut self.decimator
    }

    fn width_of(&self, text: &str, size: f64) -> f64 {
        self.ruler.width(text, size)
    }

    fn polyline(&mut self, points: &[[f64; 2]], stroke: &Stroke) {
        let (path, color, dash) = (outline(points.iter()), hex(stroke.color), self.dashes(stroke.dash));
        let (width, opacity) = (stroke.width, opacity("stroke", stroke.opacity));
        put!(
            self,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\" stroke-linejoin=\"round\"{opacity}{dash}/>"
        );
    }

    fn polygon(&mut self, corners: &[[f64; 2]], fill: &Fill) {
        let (path, color) = (outline(corners.iter()), hex(fill.color));
        put!(self, "<path d=\"{path}Z\" fill=\"{color}\"{}/>", opacity("fill", fill.opacity));
    }

    fn ribbon(&mut self, lower: &[[f64; 2]], upper: &[[f64; 2]], fill: &Fill) {
        let (path, color) = (outline(lower.iter().chain(upper.iter().rev())), hex(fill.color));
        put!(self, "<path d=\"{path}Z\" fill=\"{color}\"{}/>", opacity("fill", fill.opacity));
    }

    fn rectangle(&mut self, sides: [[f64; 2]; 2], fill: &Fill, edge: Option<&Stroke>, rounding: f64) {
        let (place, color, opacity) = (rectangle(sides), hex(fill.color), opacity("fill", fill.opacity));
        let rounding = if rounding > 0.0 { format!(" rx=\"{rounding:.2}\"") } else { String::new() };
        let edge = edge.map_or_else(String::new, |edge| {
            format!(" stroke=\"{}\" stroke-width=\"{:.2}\"", hex(edge.color), edge.width)
        });
        put!(self, "<rect {place}{rounding} fill=\"{color}\"{opacity}{edge}/>");
    }

    fn dots(&mut self, centres: &[[f64; 2]], radius: f64, fill: &Fill) {
        put!(self, "<g fill=\"{}\"{}>", hex(fill.color), opacity("fill", fill.opacity));
        for [x, y] in centres {
            put!(self, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"/>");
        }
        put!(self, "</g>");
    }

    fn cells(&mut self, cells: &[([[f64; 2]; 2], Rgb)]) {
        for (sides, color) in cells {
            put!(self, "<rect {} fill=\"{}\"/>", rectangle(*sides), hex(*color));
        }
    }

    fn text(&mut self, [x, y]: [f64; 2], text: &str, size: f64, color: Rgb, hold: Hold) {
        let anchor = match hold {
            Hold::Start => "start",
            Hold::Middle => "middle",
            Hold::End => "end",
        };
        self.letters.extend(text.chars());
        let (color, text) = (hex(color), escaped(text));
        put!(
            self,
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size:.2}\" fill=\"{color}\" text-anchor=\"{anchor}\">{text}</text>"
        );
    }
}

/// Where a rectangle stands.
pub fn rectangle([[left, right], [top, bottom]]: [[f64; 2]; 2]) -> String {
    format!("x=\"{left:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{:.2}\"", right - left, bottom - top)
}

pub fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn opacity(of: &str, opacity: f64) -> String {
    if opacity < 1.0 { format!(" {of}-opacity=\"{opacity:.2}\"") } else { String::new() }
}

/// A text as SVG reads it.
pub fn escaped(text: &str) -> String {
    // XML has no letters below the space but line breaks and tabs.
    let text: String = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn outline<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> String {
    let mut path = String::new();
    for (number, [x, y]) in points.enumerate() {
        let _ = write!(path, "{}{x:.2} {y:.2}", if number == 0 { 'M' } else { 'L' });
    }
    path
}
