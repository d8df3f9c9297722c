//! A stretch of the horizontal axis that is held out.

use super::{Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill};
use crate::figure::place::Place;

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

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        let [low, high] = self.0;
        write(Row { low, high, ..Row::new("held out", "") });
    }
}
