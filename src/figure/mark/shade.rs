//! A stretch of the horizontal axis that is held out.

use super::{Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill};
use crate::figure::place::Place;
use crate::figure::tex::{Drawn, Paper, color, number};

/// From where to where it is held out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shade(pub [f64; 2]);

impl Mark for Shade {
    fn reach(&self, _: &mut Reach) {}

    fn is_behind(&self) -> bool {
        true
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let ends = [place.plot.left, place.plot.right()];
        if let Some([[left, right], heights]) = place.sides(self.0, None)
            && left < ends[1]
            && right > ends[0]
        {
            let sides = [[left.max(ends[0]), right.min(ends[1])], heights];
            canvas.rectangle(sides, &Fill { color: canvas.colours().held_out, opacity: 1.0 }, None, 0.0);
        }
    }

    fn kind(&self) -> &'static str {
        "held out"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        let [low, high] = self.0;
        write(Row { low, high, ..Row::new("") });
    }

    /// From below to above.
    fn pgfplots(&self, rows: &[Row], paper: &Paper) -> Drawn {
        let fill = color(paper.colours.held_out);
        // The height of a corner is that of the axis; 1 is a number on a logarithmic one, too.
        let corner = |x: f64, end: u8| format!("({{axis cs:{},1}} |- {{rel axis cs:0,{end}}})", number(x));
        let shade = |row: &Row| {
            let corners = [corner(row.low, 0), corner(row.high, 1)].join(" rectangle ");
            format!("\\fill[{fill}, fill opacity=0.6] {corners};\n")
        };
        Drawn::Commands(rows.iter().map(shade).collect())
    }

    fn matplotlib(&self) -> &'static str {
        r#"for low, high in zip(column(rows, "low"), column(rows, "high")):
    ax.axvspan(low, high, color="0.92", zorder=0)"#
    }
}
