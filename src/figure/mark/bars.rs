//! Bars with intervals.

use super::{EDGE, Edges, Entry, Key, Mark, PALE, Reach, Row, WHISKER};
use crate::figure::axis::{Axis, Scale};
use crate::figure::canvas::{Canvas, Fill, Hold, Stroke};
use crate::figure::colours::Ink;
use crate::figure::place::{Place, is_finite};
use crate::figure::tex::{Drawn, Paper, listed, number};

/// Bars from 0, or from the lower end of a logarithmic axis.
#[derive(Debug, Clone)]
pub struct Bars {
    /// In the legend.
    pub name: String,
    /// Where, how high, and the ends of the interval (NaN for none).
    pub bars: Vec<[f64; 4]>,
    /// Width of a bar in units of x.
    pub width: f64,
    /// Colour.
    pub ink: Ink,
    /// How its height is written above a bar; `None` leaves it out.
    pub written: Option<fn(f64) -> String>,
}

/// The part of a group's room that its bars fill.
const FILLED: f64 = 0.7;
/// The part of its own room that a bar fills.
const BAR: f64 = 0.9;
/// Heights whose letters would be smaller than this, relative to the usual, are not written: the axis tells them.
const LEAST_WRITTEN: f64 = 0.6;

impl Bars {
    /// The bars of one series among several that stand beside each other about 0, 1, 2 …: of each its height, and the ends of
    /// its interval (NaN for none).
    pub fn beside(name: impl Into<String>, [number, count]: [usize; 2], heights: &[[f64; 3]], ink: Ink) -> Self {
        let width = FILLED / count.max(1) as f64;
        let shift = (number as f64 - (count as f64 - 1.0) / 2.0) * width;
        let bar = |(place, [height, low, high]): (usize, &[f64; 3])| [place as f64 + shift, *height, *low, *high];
        Bars {
            name: name.into(),
            bars: heights.iter().enumerate().map(bar).collect(),
            width: BAR * width,
            ink,
            written: None,
        }
    }

    /// The same with their heights written above them.
    #[must_use]
    pub fn written(mut self, text: fn(f64) -> String) -> Self {
        self.written = Some(text);
        self
    }

    /// Height of letters in which what is written over each bar has room beside its neighbours.
    fn letter_of(&self, text: fn(f64) -> String, place: &Place, canvas: &dyn Canvas) -> f64 {
        let letter = canvas.letter();
        let room = (place.along(0, self.width) - place.along(0, 0.0)).abs() / BAR;
        let widest = self.bars.iter().map(|[_, value, ..]| canvas.width_of(&text(*value), letter)).fold(0.0, f64::max);
        letter * (room / widest.max(1e-9)).min(1.0)
    }

    fn whisker(&self, place: &Place, [x, _, low, high]: [f64; 4]) -> Option<[[f64; 2]; 2]> {
        let top = place.point([x, high]);
        let bottom = match has_no_place(place.axes[1], low) {
            true => [top[0], place.plot.bottom()],
            false => place.point([x, low]),
        };
        (is_finite(&top) && is_finite(&bottom)).then_some([bottom, top])
    }
}

/// Whether an interval has a lower end that the axis can't show.
fn has_no_place(axis: &Axis, low: f64) -> bool {
    axis.scale == Scale::Logarithmic && low <= 0.0
}

impl Mark for Bars {
    fn reach(&self, reach: &mut Reach) {
        for [x, ends @ ..] in &self.bars {
            match reach.which {
                0 => reach.take_all([x - self.width, x + self.width]),
                _ => reach.take_all(*ends),
            }
        }
    }

    fn edges(&self) -> Edges {
        Edges::OnZero
    }

    fn entry(&self) -> Option<Entry<'_>> {
        Some(Entry { name: &self.name, key: Key::Patch(self.ink) })
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let base = match place.axes[1].scale {
            Scale::Logarithmic => place.plot.bottom(),
            _ => place.along(1, 0.0f64.clamp(place.ranges[1][0], place.ranges[1][1])),
        };
        let color = canvas.colours().of(self.ink);
        let edge = Stroke::new(color, EDGE * canvas.usual());
        let written = self.written.map(|text| (text, self.letter_of(text, place, canvas)));
        let written = written.filter(|(_, size)| *size >= LEAST_WRITTEN * canvas.letter());
        for bar in &self.bars {
            let [x, value, ..] = *bar;
            let across = [x - self.width / 2.0, x + self.width / 2.0].map(|x| place.at(0, x));
            let y = place.at(1, value);
            if y.is_finite() {
                canvas.rectangle(
                    [across, [y.min(base), y.max(base)]],
                    &Fill { color, opacity: PALE },
                    Some(&edge),
                    0.0,
                );
            }
            if let Some((text, size)) = written.filter(|_| y.is_finite()) {
                let (at, color) = ([(across[0] + across[1]) / 2.0, y - 0.3 * canvas.letter()], canvas.colours().text);
                canvas.text(at, &text(value), size, color, Hold::Middle);
            }
            if let Some(ends) = self.whisker(place, *bar) {
                canvas.rule(ends, canvas.colours().text, WHISKER * canvas.usual());
            }
        }
    }

    fn kind(&self) -> &'static str {
        "bar"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        for [x, y, low, high] in &self.bars {
            write(Row { low: *low, high: *high, ..Row::point(&self.name, [*x, *y]) });
        }
    }

    fn pgfplots(&self, rows: &[Row], paper: &Paper) -> Drawn {
        let lowest = paper.ranges[1][0];
        let error = |end: f64, from: f64| if end.is_finite() { (end - from).abs() } else { 0.0 };
        let bar = |row: &Row| {
            let low = if has_no_place(paper.axes[1], row.low) { lowest } else { row.low };
            let [x, y, up, down] = [row.x, row.y, error(row.high, row.y), error(low, row.y)].map(number);
            format!("({x},{y}) += (0,{up}) -= (0,{down})")
        };
        let bars = format!("ybar, bar width={:.4}, fill, fill opacity={PALE}, area legend", self.width);
        Drawn::Plot(
            format!("{bars}, error bars/.cd, y dir=both, y explicit, error bar style={{black}}"),
            listed(rows.iter().map(bar)),
        )
    }

    fn matplotlib(&self) -> &'static str {
        r#"down = [end - low for end, low in zip(y, column(rows, "low"))]
up = [high - end for end, high in zip(y, column(rows, "high"))]
ax.bar(x, y, width=0.6 / count, yerr=[down, up], label=name or None, alpha=0.5)"#
    }
}
