//! The area between a lower and an upper line.

use super::{Entry, Key, Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill};
use crate::figure::colours::Ink;
use crate::figure::place::{Place, is_finite};
use crate::figure::shared::Shared;
use crate::figure::tex::{Drawn, Paper, coordinates, hull};

/// How much of a band's colour is seen, unless something else is said.
const FAINT: f64 = 0.2;

/// An area between two lines over ascending x.
#[derive(Debug, Clone)]
pub struct Band {
    /// In the legend.
    pub name: String,
    /// x, lower, upper.
    pub points: Shared<[f64; 3]>,
    /// Colour.
    pub ink: Ink,
    /// Between 0 and 1.
    pub opacity: f64,
}

impl Band {
    /// A band of usual opacity.
    pub fn new(name: impl Into<String>, points: impl Into<Shared<[f64; 3]>>, ink: Ink) -> Self {
        Band { name: name.into(), points: points.into(), ink, opacity: FAINT }
    }
}

impl Mark for Band {
    fn reach(&self, reach: &mut Reach) {
        for [x, low, high] in self.points.iter() {
            match reach.which {
                0 => reach.take(*x),
                _ if reach.sees(*x) => reach.take_all([*low, *high]),
                _ => (),
            }
        }
    }

    fn entry(&self) -> Option<Entry<'_>> {
        Some(Entry { name: &self.name, key: Key::Patch(self.ink) })
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let ends = |[x, low, high]: &[f64; 3]| [place.point([*x, *low]), place.point([*x, *high])];
        let shown = self.points.iter().map(ends).filter(|ends| ends.iter().all(is_finite));
        let (lower, upper): (Vec<[f64; 2]>, Vec<[f64; 2]>) = shown.map(|[low, high]| (low, high)).unzip();
        if lower.len() > 1 {
            let fill = Fill { color: canvas.colours().of(self.ink), opacity: self.opacity };
            canvas.ribbon(&lower, &upper, &fill);
        }
    }

    fn kind(&self) -> &'static str {
        "band"
    }

    fn rows(&self, x: &Axis, write: &mut dyn FnMut(Row)) {
        let shown = |point: &&[f64; 3]| x.range.is_none_or(|[from, to]| (from..=to).contains(&point[0]));
        for [x, low, high] in self.points.iter().filter(shown) {
            write(Row { x: *x, low: *low, high: *high, ..Row::new(&self.name) });
        }
    }

    /// Its outline: the lower line, and back along the upper one.
    fn pgfplots(&self, rows: &[Row], paper: &Paper) -> Drawn {
        let seen = rows.iter().filter(|row| row.low.is_finite() && row.high.is_finite());
        let ends: Vec<[f64; 3]> = seen.map(|row| [row.x, row.low, row.high]).collect();
        let seen = hull(&ends, Paper::columns(paper.size[0]));
        let lower = seen.iter().map(|[x, low, _]| [*x, *low]);
        let outline: Vec<[f64; 2]> = lower.chain(seen.iter().rev().map(|[x, _, high]| [*x, *high])).collect();
        let filled = format!("draw=none, fill, fill opacity={}, area legend", self.opacity);
        Drawn::Plot(filled, format!("{} -- cycle", coordinates(&outline)))
    }

    fn matplotlib(&self) -> &'static str {
        r#"ax.fill_between(x, column(rows, "low"), column(rows, "high"), label=name or None, alpha=0.3)"#
    }
}
