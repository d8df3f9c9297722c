//! An arrow of a drawing.

use super::{Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill};
use crate::figure::colours::Ink;
use crate::figure::place::{Place, is_finite};
use crate::figure::tex::{self, Drawn, Paper};

/// An arrow from the first point to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrow {
    /// Where it begins and ends.
    pub ends: [[f64; 2]; 2],
    /// Colour.
    pub ink: Ink,
}

impl Mark for Arrow {
    fn reach(&self, reach: &mut Reach) {
        reach.take_points(&self.ends);
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let [from, to] = self.ends.map(|end| place.point(end));
        if !(is_finite(&from) && is_finite(&to)) {
            return;
        }
        let color = canvas.colours().of(self.ink);
        canvas.rule([from, to], color, canvas.usual());
        let length = (to[0] - from[0]).hypot(to[1] - from[1]).max(1e-9);
        let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
        let (long, wide) = (0.6 * canvas.letter(), 0.3 * canvas.letter());
        let side = |sign: f64| {
            [to[0] - along[0] * long - sign * along[1] * wide, to[1] - along[1] * long + sign * along[0] * wide]
        };
        canvas.polygon(&[to, side(1.0), side(-1.0)], &Fill { color, opacity: 1.0 });
    }

    fn kind(&self) -> &'static str {
        "arrow"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        self.ends.into_iter().for_each(|end| write(Row::point("", end)));
    }

    fn pgfplots(&self, _: &[Row], paper: &Paper) -> Drawn {
        let color = tex::color(paper.colours.of(self.ink));
        Drawn::Commands(format!("\\draw[{color}, -latex] {};\n", self.ends.map(tex::place).join(" -- ")))
    }

    fn matplotlib(&self) -> &'static str {
        r#"for end in range(0, len(x), 2):
    tip, tail = (x[end + 1], y[end + 1]), (x[end], y[end])
    ax.annotate("", tip, tail, arrowprops=dict(arrowstyle="-|>", linewidth=LINE, shrinkA=0, shrinkB=0))"#
    }
}
