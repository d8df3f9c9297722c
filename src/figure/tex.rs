//! What marks are made of in a picture of pgfplots.

use super::axis::{Axis, Scale};
use super::colours::{Colours, Rgb};
use super::decimate::{self, Sight};

/// So many columns of pixels hold all that is seen of a line on paper.
pub const COLUMNS: usize = 400;
/// So many points are drawn of a cloud, or of a path.
const MOST_POINTS: usize = 2000;

/// What a mark is drawn on.
pub struct Paper<'a> {
    /// The horizontal and the vertical axis.
    pub axes: [&'a Axis; 2],
    /// What inks are.
    pub colours: &'a Colours,
    /// How many marks of its kind the plot has.
    pub of_kind: usize,
}

/// What draws a mark.
pub enum Drawn {
    /// A plot, by its options beside the colour and by what is plotted. It may stand in the legend.
    Plot(String, String),
    /// Commands that paint the ground.
    Ground(String),
}

impl Paper<'_> {
    /// A line as it is seen, with a hole between its pieces; a path that turns back keeps its shape.
    pub fn thinned(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let [across, up] = self.axes;
        let shown = points.iter().filter(|[x, _]| x.is_finite()).map(|[x, y]| (across.measure(*x), *y));
        let (x, y): (Vec<f64>, Vec<f64>) = shown.filter(|(x, _)| x.is_finite()).unzip();
        let (Some(first), Some(last)) = (x.first(), x.last()) else { return Vec::new() };
        if x.windows(2).any(|pair| pair[1] < pair[0]) || last <= first {
            return some(points);
        }
        let positive = up.scale == Scale::Logarithmic;
        let sight = Sight { range: [*first, *last], columns: COLUMNS, gaps: false, positive };
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

/// Every point, or every n-th.
pub fn some(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    points.iter().step_by(points.len().div_ceil(MOST_POINTS).max(1)).copied().collect()
}

/// The option for a colour.
pub fn color([red, green, blue]: Rgb) -> String {
    format!("color={{rgb,255:red,{red};green,{green};blue,{blue}}}")
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
    fn numbers_are_short_and_holes_are_told() {
        assert_eq!([0.0, 1.5, -1.234_567e-7, f64::NAN].map(number), ["0", "1.5", "-1.23457e-7", "nan"]);
    }
}
