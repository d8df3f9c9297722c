//! A box of a drawing.

use super::{Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill, Stroke};
use crate::figure::colours::Ink;
use crate::figure::place::Place;
use crate::figure::tex::{self, Drawn, Paper};

/// A box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Its left and right end, and its lower and upper one.
    pub sides: [[f64; 2]; 2],
    /// Colour of its edge.
    pub ink: Ink,
}

impl Mark for Frame {
    fn reach(&self, reach: &mut Reach) {
        reach.take_all(self.sides[reach.which]);
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let [x, y] = self.sides;
        let Some(sides) = place.sides(x, Some(y)) else { return };
        let edge = Stroke::new(canvas.colours().of(self.ink), canvas.usual());
        let fill = Fill { color: canvas.colours().canvas, opacity: 1.0 };
        canvas.rectangle(sides, &fill, Some(&edge), 0.3 * canvas.letter());
    }

    fn kind(&self) -> &'static str {
        "frame"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        let [[left, right], [low, high]] = self.sides;
        [[left, low], [right, high]].into_iter().for_each(|corner| write(Row::point("", corner)));
    }

    fn pgfplots(&self, _: &[Row], paper: &Paper) -> Drawn {
        let [color, ground] = [paper.colours.of(self.ink), paper.colours.canvas].map(tex::rgb);
        let corners = tex::rectangle(self.sides);
        Drawn::Commands(format!("\\draw[draw={color}, fill={ground}, rounded corners=1pt] {corners};\n"))
    }

    fn matplotlib(&self) -> &'static str {
        r#"for corner in range(0, len(x), 2):
    size = (x[corner + 1] - x[corner], y[corner + 1] - y[corner])
    ax.add_patch(plt.Rectangle((x[corner], y[corner]), *size, edgecolor="0.2", facecolor="white", zorder=3))"#
    }
}
