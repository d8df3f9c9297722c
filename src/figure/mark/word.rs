//! A word of a drawing.

use super::{Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Hold};
use crate::figure::colours::Ink;
use crate::figure::place::{Place, is_finite};

/// A word about its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct Word {
    /// What it says.
    pub text: String,
    /// Where its middle is.
    pub at: [f64; 2],
    /// How wide it may be, in units of x: a longer one has smaller letters.
    pub room: f64,
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
        let room = place.at(0, self.at[0] + self.room) - at[0];
        let size = canvas.letter() * (room / canvas.width_of(&self.text, canvas.letter()).max(1e-9)).min(1.0);
        let color = canvas.colours().of(self.ink);
        canvas.text([at[0], at[1] + 0.35 * size], &self.text, size, color, Hold::Middle);
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        write(Row::point("word", &self.text, self.at));
    }
}
