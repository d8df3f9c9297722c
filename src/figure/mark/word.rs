//! A word of a drawing.

use super::{Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Hold};
use crate::figure::colours::Ink;
use crate::figure::font::{Family, Ruler};
use crate::figure::latex::escaped;
use crate::figure::place::{Place, is_finite};
use crate::figure::tex::{self, Drawn, FOOTNOTE, Paper};

/// Height of a word with what hangs below and stands above its letters, in letters.
const HEIGHT: f64 = 1.15;

/// A word about its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct Word {
    /// What it says.
    pub text: String,
    /// Where its middle is.
    pub at: [f64; 2],
    /// How wide and how high it may be, in units of the axes: where it has less room its letters are smaller.
    pub room: [f64; 2],
    /// Colour.
    pub ink: Ink,
}

impl Mark for Word {
    fn reach(&self, reach: &mut Reach) {
        reach.take(self.at[reach.which]);
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let at = place.point(self.at);
        if !is_finite(&at) {
            return;
        }
        let [wide, high] = [0, 1].map(|axis| (place.at(axis, self.at[axis] + self.room[axis]) - at[axis]).abs());
        let letter = canvas.letter();
        let size =
            letter * (wide / canvas.width_of(&self.text, letter).max(1e-9)).min(high / (HEIGHT * letter)).min(1.0);
        let color = canvas.colours().of(self.ink);
        canvas.text([at[0], at[1] + 0.35 * size], &self.text, size, color, Hold::Middle);
    }

    fn kind(&self) -> &'static str {
        "word"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        write(Row::point(&self.text, self.at));
    }

    fn pgfplots(&self, _: &[Row], paper: &Paper) -> Drawn {
        let room = |axis: usize| self.room[axis] * paper.per_unit(axis);
        let width = Ruler::of(Family::Serif).width(&self.text, FOOTNOTE).max(1e-9);
        let scale = (room(0) / width).min(room(1) / (HEIGHT * FOOTNOTE)).min(1.0);
        let (color, at) = (tex::color(paper.colours.of(self.ink)), tex::place(self.at));
        let text = escaped(&self.text);
        Drawn::Commands(format!("\\node[{color}, font=\\footnotesize, scale={scale:.2}] at {at} {{{text}}};\n"))
    }

    fn matplotlib(&self) -> &'static str {
        r#"for at in zip(x, y):
    ax.text(*at, name, ha="center", va="center", fontsize="xx-small", zorder=4)"#
    }
}
