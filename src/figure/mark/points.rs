//! Points in no order.

use super::{Edges, Entry, Key, Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill};
use crate::figure::colours::Ink;
use crate::figure::place::{Place, is_finite};
use crate::figure::shared::Shared;
use crate::figure::tex::{Drawn, Paper, coordinates};

/// Radius of a usual point on paper \[pt\].
const DOT: f64 = 0.7;

/// A cloud of points.
#[derive(Debug, Clone)]
pub struct Points {
    /// In the legend.
    pub name: String,
    /// x and y.
    pub points: Shared<[f64; 2]>,
    /// Colour.
    pub ink: Ink,
    /// Radius relative to the usual.
    pub radius: f64,
    /// Between 0 and 1.
    pub opacity: f64,
}

impl Points {
    /// Points of usual size.
    pub fn new(name: impl Into<String>, points: impl Into<Shared<[f64; 2]>>, ink: Ink) -> Self {
        Points { name: name.into(), points: points.into(), ink, radius: 1.0, opacity: 1.0 }
    }

    /// The same, so much larger than usual.
    #[must_use]
    pub fn radius(mut self, radius: f64) -> Self {
        self.radius = radius;
        self
    }

    /// The same, so much of their colour: 1 for all.
    #[must_use]
    pub fn opacity(mut self, opacity: f64) -> Self {
        self.opacity = opacity;
        self
    }
}

impl Mark for Points {
    fn reach(&self, reach: &mut Reach) {
        reach.take_points(self.points.iter());
    }

    fn edges(&self) -> Edges {
        Edges::Loose
    }

    fn entry(&self) -> Option<Entry<'_>> {
        Some(Entry { name: &self.name, key: Key::Dot(self.ink) })
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let radius = self.radius * canvas.letter() / 5.0;
        let [left, right] = [place.plot.left - radius, place.plot.right() + radius];
        let seen = |at: &[f64; 2]| is_finite(at) && (left..=right).contains(&at[0]);
        let centres: Vec<[f64; 2]> = self.points.iter().map(|point| place.point(*point)).filter(seen).collect();
        canvas.dots(&centres, radius, &Fill { color: canvas.colours().of(self.ink), opacity: self.opacity });
    }

    fn kind(&self) -> &'static str {
        "points"
    }

    fn rows(&self, x: &Axis, write: &mut dyn FnMut(Row)) {
        let shown = |point: &&[f64; 2]| x.range.is_none_or(|[from, to]| (from..=to).contains(&point[0]));
        self.points.iter().filter(shown).for_each(|point| write(Row::point(&self.name, *point)));
    }

    fn pgfplots(&self, rows: &[Row], paper: &Paper) -> Drawn {
        let points: Vec<[f64; 2]> = rows.iter().map(|row| [row.x, row.y]).collect();
        let dots = format!("only marks, mark=*, mark size={:.2}pt, opacity={}", DOT * self.radius, self.opacity);
        Drawn::Plot(dots, coordinates(&paper.some(&points)))
    }

    fn matplotlib(&self) -> &'static str {
        "ax.scatter(x, y, label=name or None, s=4)"
    }
}
