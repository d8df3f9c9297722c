//! What marks are made of in a picture of pgfplots.

use super::axis::{Axis, Scale};
use super::colours::{Colours, Rgb};
use super::decimate::{self, Sight};
use super::size::POINTS_PER_MILLIMETRE;
use crate::statistics::ends as ends_of;

/// Of a line on paper, all is seen that columns of this width hold: they are as wide as the line \[mm\].
const COLUMN: f64 = 0.25;
/// At most so many points are drawn of a cloud or of a path; and of all that a figure has, which is what TeX's memory holds.
const MOST_POINTS: usize = 2000;
const MOST_OF_ALL: usize = 8000;

/// Height of letters of LaTeX's `\footnotesize` in a paper of 10 pt \[mm\].
pub const FOOTNOTE: f64 = 8.0 / POINTS_PER_MILLIMETRE;

/// What a mark is drawn on.
pub struct Paper<'a> {
    /// The horizontal and the vertical axis.
    pub axes: [&'a Axis; 2],
    /// What they show.
    pub ranges: [[f64; 2]; 2],
    /// Width and height of the plot \[mm\].
    pub size: [f64; 2],
    /// What inks are.
    pub colours: &'a Colours,
    /// How many marks the figure has.
    pub marks: usize,
}

/// What draws a mark.
pub enum Drawn {
    /// A plot, by its options beside the colour and by what is plotted.
    Plot(String, String),
    /// Commands that draw it.
    Commands(String),
}

impl Paper<'_> {
    /// So many columns hold all that is seen on a plot of this width \[mm\].
    pub fn columns(width: f64) -> usize {
        (width / COLUMN) as usize
    }

    /// How long a unit of an even axis is \[mm\].
    pub fn per_unit(&self, axis: usize) -> f64 {
        let [low, high] = self.ranges[axis];
        self.size[axis] / (high - low)
    }

    /// Every point, or every n-th.
    pub fn some(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let most = (MOST_OF_ALL / self.marks.max(1)).clamp(1, MOST_POINTS);
        points.iter().step_by(points.len().div_ceil(most).max(1)).copied().collect()
    }

    /// A line as it is seen, with a hole between its pieces; a path that turns back keeps its shape.
    pub fn thinned(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let [across, up] = self.axes;
        let shown = points.iter().filter(|[x, _]| x.is_finite()).map(|[x, y]| (across.measure(*x), *y));
        let (x, y): (Vec<f64>, Vec<f64>) = shown.filter(|(x, _)| x.is_finite()).unzip();
        let (Some(first), Some(last)) = (x.first(), x.last()) else { return Vec::new() };
        if x.windows(2).any(|pair| pair[1] < pair[0]) || last <= first {
            return self.some(points);
        }
        let positive = up.scale == Scale::Logarithmic;
        let sight = Sight { range: [*first, *last], columns: Paper::columns(self.size[0]), gaps: false, positive };
        let mut line: Vec<[f64; 2]> = Vec::new();
        for piece in decimate::pieces(&x, &y, sight) {
            if let Some([end, _]) = line.last() {
                line.push([*end, f64::NAN]);
            }
            line.extend(piece.into_iter().map(|[x, y]| [across.value(x), y]));
        }
        line
    }
}

/// An area between two lines over ascending x (each x, lower, upper), as it is seen in so many pieces.
pub fn hull(ends: &[[f64; 3]], pieces: usize) -> Vec<[f64; 3]> {
    let around = |piece: &[[f64; 3]]| {
        let [low, high] = ends_of(piece.iter().flat_map(|[_, low, high]| [*low, *high]));
        [piece[piece.len() / 2][0], low, high]
    };
    ends.chunks(ends.len().div_ceil(pieces.max(1)).max(1)).map(around).collect()
}

/// A place between the axes, as commands read it.
pub fn place([x, y]: [f64; 2]) -> String {
    format!("(axis cs:{},{})", number(x), number(y))
}

/// A rectangle between two values of x and two of y, as commands read it.
pub fn rectangle([[left, right], [low, high]]: [[f64; 2]; 2]) -> String {
    [[left, low], [right, high]].map(place).join(" rectangle ")
}

/// The option for a colour.
pub fn color(of: Rgb) -> String {
    format!("color={}", rgb(of))
}

/// A colour.
pub fn rgb([red, green, blue]: Rgb) -> String {
    format!("{{rgb,255:red,{red};green,{green};blue,{blue}}}")
}

/// A number of six digits, or what TeX takes for none.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "nan".to_owned();
    }
    let text = format!("{value:.5e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if exponent == "0" { digits.to_owned() } else { format!("{digits}e{exponent}") }
}

/// Points to be plotted.
pub fn coordinates(points: &[[f64; 2]]) -> String {
    listed(points.iter().map(|[x, y]| format!("({},{})", number(*x), number(*y))))
}

/// The same, each written already.
pub fn listed(points: impl Iterator<Item = String>) -> String {
    format!("coordinates {{{}}}", points.collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_keeps_its_ends_where_it_is_thinned() {
        let ends: Vec<[f64; 3]> = (0..1000).map(|n| [f64::from(n), -1.0, if n == 777 { 9.0 } else { 1.0 }]).collect();
        let hull = hull(&ends, 50);
        assert!(hull.len() == 50 && hull.iter().filter(|[.., high]| *high == 9.0).count() == 1);
        assert!(hull.iter().all(|[_, low, _]| *low == -1.0) && super::hull(&ends[..3], 50) == ends[..3]);
    }

    #[test]
    fn numbers_are_short_and_holes_are_told() {
        assert_eq!([0.0, 1.5, -1.234_567e-7, f64::NAN].map(number), ["0", "1.5", "-1.23457e-7", "nan"]);
    }
}
