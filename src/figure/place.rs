//! From values to the page.

use super::axis::Axis;

/// A rectangle of the page; its y goes down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left end.
    pub left: f64,
    /// Upper end.
    pub top: f64,
    /// How wide.
    pub width: f64,
    /// How high.
    pub height: f64,
}

impl Area {
    /// Right end.
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Lower end.
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// Where values lie on the page.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// The plot.
    pub plot: Area,
    /// What it shows, in the axes' own measure.
    pub ranges: [[f64; 2]; 2],
    /// The horizontal and the vertical axis.
    pub axes: [&'a Axis; 2],
}

impl Place<'_> {
    /// Of a value in the axis' own measure.
    pub fn along(&self, which: usize, measured: f64) -> f64 {
        let [from, to] = self.ranges[which];
        let part = (measured - from) / (to - from);
        match which {
            0 => self.plot.left + part * self.plot.width,
            _ => self.plot.top + (1.0 - part) * self.plot.height,
        }
    }

    /// Of a value; NaN where the axis has no place for it.
    pub fn at(&self, which: usize, value: f64) -> f64 {
        self.along(which, self.axes[which].measure(value))
    }

    /// Of a point.
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.at(0, x), self.at(1, y)]
    }

    /// The values at a place of the page.
    pub fn value(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let parts = [(x - self.plot.left) / self.plot.width, 1.0 - (y - self.plot.top) / self.plot.height];
        [0, 1].map(|which| {
            let [from, to] = self.ranges[which];
            self.axes[which].value(from + parts[which] * (to - from))
        })
    }

    /// The rectangle between two values of x, and two of y or over the whole height: its horizontal and its vertical ends.
    /// `None` where an axis has no place for it.
    pub fn sides(&self, x: [f64; 2], y: Option<[f64; 2]>) -> Option<[[f64; 2]; 2]> {
        let [left, right] = x.map(|x| self.at(0, x));
        let [low, high] = match y {
            Some(y) => y.map(|y| self.at(1, y)),
            None => [self.plot.bottom(), self.plot.top],
        };
        let ends = [left, right, low, high];
        ends.iter()
            .all(|end| end.is_finite())
            .then(|| [[left.min(right), left.max(right)], [low.min(high), low.max(high)]])
    }
}

/// Whether a point can be drawn.
pub fn is_finite(point: &[f64; 2]) -> bool {
    point.iter().all(|number| number.is_finite())
}
