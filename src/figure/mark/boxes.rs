//! Boxes from quartile to quartile with whiskers.

use super::{Edges, Entry, Key, Mark, PALE, Reach, Row, WHISKER};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Fill};
use crate::figure::colours::Ink;
use crate::figure::place::{Place, is_finite};
use crate::figure::tex::{Drawn, Paper, coordinates};

/// Width of the median, relative to the usual line.
const MEDIAN: f64 = 1.6;

/// Boxes of what is spread.
#[derive(Debug, Clone)]
pub struct Boxes {
    /// In the legend.
    pub name: String,
    /// Where, least, lower quartile, median, upper quartile, most.
    pub boxes: Vec<[f64; 6]>,
    /// Width of a box in units of x.
    pub width: f64,
    /// Colour.
    pub ink: Ink,
}

impl Mark for Boxes {
    fn reach(&self, reach: &mut Reach) {
        for [x, ends @ ..] in &self.boxes {
            match reach.which {
                0 => reach.take_all([x - self.width, x + self.width]),
                _ => reach.take_all(*ends),
            }
        }
    }

    fn edges(&self) -> Edges {
        Edges::Tight
    }

    fn entry(&self) -> Option<Entry<'_>> {
        Some(Entry { name: &self.name, key: Key::Patch(self.ink) })
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let (color, usual) = (canvas.colours().of(self.ink), canvas.usual());
        for [x, least, low, median, high, most] in &self.boxes {
            let end = |y: f64| place.point([*x, y]);
            for ends in [[end(*least), end(*low)], [end(*high), end(*most)]] {
                if ends.iter().all(is_finite) {
                    canvas.rule(ends, color, WHISKER * usual);
                }
            }
            let across = [x - self.width / 2.0, x + self.width / 2.0];
            if let Some(sides) = place.sides(across, Some([*low, *high])) {
                canvas.rectangle(sides, &Fill { color, opacity: PALE }, None, 0.0);
            }
            let middle = across.map(|x| place.point([x, *median]));
            if middle.iter().all(is_finite) {
                canvas.rule(middle, color, MEDIAN * usual);
            }
        }
    }

    fn kind(&self) -> &'static str {
        "box"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        for [x, least, low, median, high, most] in &self.boxes {
            let row = Row::point(&self.name, [*x, *median]);
            write(Row { low: *low, high: *high, least: *least, most: *most, ..row });
        }
    }

    /// One line with holes.
    fn pgfplots(&self, rows: &[Row], _: &Paper) -> Drawn {
        let (half, hole) = (self.width / 2.0, [f64::NAN; 2]);
        let of = |row: &Row| {
            let [left, right] = [row.x - half, row.x + half];
            let frame = [[left, row.low], [right, row.low], [right, row.high], [left, row.high], [left, row.low], hole];
            let lines = [[row.x, row.least], [row.x, row.low], hole, [row.x, row.high], [row.x, row.most], hole];
            [frame.to_vec(), lines.to_vec(), vec![[left, row.y], [right, row.y], hole]].concat()
        };
        let lines: Vec<[f64; 2]> = rows.iter().flat_map(of).collect();
        Drawn::Plot("line width=0.70pt".to_owned(), coordinates(&lines))
    }

    fn matplotlib(&self) -> &'static str {
        r#"ends = (column(rows, end) for end in ("least", "low", "y", "high", "most"))
boxes = [dict(zip(("whislo", "q1", "med", "q3", "whishi"), of)) for of in zip(*ends)]
look = dict(color=ax.plot([], [], label=name or None)[0].get_color(), linewidth=LINE)
look = {f"{part}props": look for part in ("box", "whisker", "cap", "median")}
ax.bxp(boxes, positions=x, widths=0.6 / count, showfliers=False, manage_ticks=False, **look)"#
    }
}
