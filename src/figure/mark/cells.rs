//! Values as colours over a rectangle.

use super::{Edges, Entry, Key, Mark, Reach, Row};
use crate::figure::axis::Axis;
use crate::figure::canvas::{Canvas, Hold};
use crate::figure::colours::{Colours, Rgb};
use crate::figure::place::Place;
use crate::figure::shared::Shared;
use crate::figure::tex::{self, Drawn, Paper};
use crate::figure::ticks;

/// Pieces of a bar of colours.
const BAR: usize = 16;

/// A map of values.
#[derive(Debug, Clone)]
pub struct Cells {
    /// How many columns and rows.
    pub size: [usize; 2],
    /// The ends of the horizontal and of the vertical axis.
    pub extent: [[f64; 2]; 2],
    /// Row by row from below; NaN where there is nothing.
    pub values: Shared<f64>,
    /// What the colours say.
    pub shades: Shades,
    /// What a value is in; empty for none.
    pub unit: &'static str,
    /// What the colours range over, for the legend; empty for no entry.
    pub scale: String,
    /// The value of the strongest colour; its own largest one if `None`.
    pub most: Option<f64>,
}

/// What the colours of cells say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shades {
    /// Two hues, nothing at 0.
    Signed,
    /// How much there is.
    Amount,
    /// How much of its row there is; the value is written into the cell.
    Written,
}

impl Shades {
    /// The colour of a share of the largest value.
    fn of(self, colours: &Colours, share: f64) -> Rgb {
        match self {
            Shades::Signed => colours.signed(share),
            Shades::Amount => colours.amount(share),
            Shades::Written => colours.signed(share.abs()),
        }
    }

    /// The colours from that of the smallest value to that of the largest.
    pub fn all(self, colours: &Colours) -> [Rgb; BAR] {
        let first = if self == Shades::Signed { -1.0 } else { 0.0 };
        std::array::from_fn(|part| self.of(colours, first + (1.0 - first) * (part as f64 + 0.5) / BAR as f64))
    }

    /// A bar of them.
    pub(super) fn bar(self, canvas: &mut dyn Canvas, [[left, right], sides]: [[f64; 2]; 2]) {
        let at = |part: usize| left + part as f64 / BAR as f64 * (right - left);
        let colours = self.all(canvas.colours());
        let pieces: Vec<_> =
            colours.into_iter().enumerate().map(|(part, color)| ([[at(part), at(part + 1)], sides], color)).collect();
        canvas.cells(&pieces);
    }
}

impl Cells {
    /// The same with an entry in the legend that tells what the colours range over.
    #[must_use]
    pub fn with_scale(mut self) -> Self {
        let most = ticks::short(self.strongest());
        let from = if self.shades == Shades::Signed { format!("−{most}") } else { "0".to_owned() };
        self.scale = format!("{from} … {most} {}", self.unit).trim().to_owned();
        self
    }

    /// The value of the strongest colour.
    pub fn strongest(&self) -> f64 {
        self.most.unwrap_or_else(|| largest(&self.values))
    }

    /// The same in colours that range up to this value, to stand beside others.
    #[must_use]
    pub fn up_to(mut self, most: f64) -> Self {
        self.most = Some(most);
        self.with_scale()
    }

    /// The cell at a place.
    fn at(&self, place: [f64; 2]) -> Option<usize> {
        let mut index = [0; 2];
        for which in 0..2 {
            let [from, to] = self.extent[which];
            let count = self.size[which].max(1);
            let share = (place[which] - from) / (to - from);
            index[which] = if (0.0..=1.0).contains(&share) {
                ((share * count as f64) as usize).min(count - 1)
            } else {
                return None;
            };
        }
        Some(index[1] * self.size[0].max(1) + index[0])
    }

    fn sides(&self, index: usize) -> [[f64; 2]; 2] {
        let [columns, rows] = self.size.map(|count| count.max(1));
        let side = |which: usize, at: usize, count: usize| {
            let [from, to] = self.extent[which];
            let end = |at: usize| from + (to - from) * at as f64 / count as f64;
            [end(at), end(at + 1)]
        };
        [side(0, index % columns, columns), side(1, index / columns, rows)]
    }

    /// The colour of a value beside the largest one.
    fn color(&self, colours: &Colours, value: f64, most: f64) -> Rgb {
        self.shades.of(colours, if most > 0.0 { value / most } else { 0.0 })
    }

    /// The largest value that the value of a cell is compared with.
    fn most(&self) -> impl Fn(usize) -> f64 + '_ {
        let whole = self.strongest();
        let columns = self.size[0].max(1);
        let rows: Vec<f64> = match self.shades {
            Shades::Written => self.values.chunks(columns).map(largest).collect(),
            Shades::Signed | Shades::Amount => Vec::new(),
        };
        move |index| rows.get(index / columns).copied().unwrap_or(whole)
    }
}

impl Mark for Cells {
    fn reach(&self, reach: &mut Reach) {
        reach.take_all(self.extent[reach.which]);
    }

    fn edges(&self) -> Edges {
        Edges::Filled
    }

    fn entry(&self) -> Option<Entry<'_>> {
        (!self.scale.is_empty()).then_some(Entry { name: &self.scale, key: Key::Scale(self.shades) })
    }

    fn value_in(&self, place: [f64; 2]) -> Option<(f64, &str)> {
        let value = *self.values.get(self.at(place)?)?;
        (value.is_finite() && self.shades != Shades::Written).then_some((value, self.unit))
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let most = self.most();
        let (mut cells, mut texts) = (Vec::with_capacity(self.values.len()), Vec::new());
        for (index, value) in self.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            let color = self.color(canvas.colours(), *value, most(index));
            let [x, y] = self.sides(index);
            let Some(sides) = place.sides(x, Some(y)) else { continue };
            cells.push((sides, color));
            if self.shades == Shades::Written && *value != 0.0 {
                let middle = sides.map(|[from, to]| (from + to) / 2.0);
                texts.push((middle, *value, if is_bright(color) { [0, 0, 0] } else { [0xff, 0xff, 0xff] }));
            }
        }
        canvas.cells(&cells);
        let letter = canvas.letter();
        for ([x, y], value, color) in texts {
            canvas.text([x, y + 0.35 * letter], &ticks::short(value), letter, color, Hold::Middle);
        }
    }

    fn kind(&self) -> &'static str {
        "cell"
    }

    fn rows(&self, _: &Axis, write: &mut dyn FnMut(Row)) {
        for (index, value) in self.values.iter().enumerate() {
            let [x, y] = self.sides(index).map(|[from, to]| (from + to) / 2.0);
            write(Row { value: *value, ..Row::point("", [x, y]) });
        }
    }

    fn pgfplots(&self, _: &[Row], paper: &Paper) -> Drawn {
        let most = self.most();
        let cell = |(index, value): (usize, &f64)| {
            let color = self.color(paper.colours, *value, most(index));
            let sides = self.sides(index);
            let filled = format!("\\fill[{}] {};\n", tex::color(color), tex::rectangle(sides));
            if self.shades != Shades::Written || *value == 0.0 {
                return filled;
            }
            let ink = if is_bright(color) { "black" } else { "white" };
            let middle = tex::place(sides.map(|[from, to]| (from + to) / 2.0));
            format!("{filled}\\node[{ink}, font=\\footnotesize] at {middle} {{{}}};\n", ticks::short(*value))
        };
        Drawn::Commands(self.values.iter().enumerate().filter(|(_, value)| value.is_finite()).map(cell).collect())
    }

    fn matplotlib(&self) -> &'static str {
        r#"across, up, values = sorted(set(x)), sorted(set(y)), column(rows, "value")
cells = {(at, high): value for at, high, value in zip(x, y, values)}
grid = [[cells.get((at, high), float("nan")) for at in across] for high in up]
most = max((abs(value) for value in values if value == value), default=0)
look = dict(cmap="PuOr", vmin=-most) if any(value < 0 for value in values) else dict(cmap="Blues", vmin=0)
shown = ax.pcolormesh(across, up, grid, shading="nearest", vmax=most, **look)
figure.colorbar(shown, ax=ax, label=name or None)"#
    }
}

/// The largest size of a value.
fn largest(values: &[f64]) -> f64 {
    values.iter().filter(|value| value.is_finite()).fold(0.0, |most, value| value.abs().max(most))
}

/// Whether black is easier to read on it than white.
fn is_bright([red, green, blue]: Rgb) -> bool {
    0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue) > 140.0
}
