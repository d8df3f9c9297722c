//! What the views show, as figures.

use std::ops::Range;
use std::sync::Arc;

use super::table::{Quantity, Scatter, Spectra, Table};
use crate::app::plot::Along;
use crate::app::plot::series::density;
use crate::app::theme::PREDICTED_DASH;
use crate::app::widgets::thousands;
use crate::figure::mark::{Band, Cells, Line, Points};
use crate::figure::{Axis, Ink, Panel, Shared};

/// Seconds before and after the cursor that the loop shows.
const LOOP: f64 = 1.5;
/// Most points of a loop, and most marked points of a view.
const MOST_OF_LOOP: usize = 1500;
const MOST_MARKED: usize = 3000;
/// Width of means and curves.
const STRONG: f64 = 1.86;

/// Another model, over the current one.
pub struct Other {
    pub name: String,
    pub ink: Ink,
    pub table: Arc<Table>,
    /// `None` while they are computed, as all that follows.
    pub spectra: Option<Arc<Spectra>>,
    /// Of the rows that are marked.
    pub marked: Option<Arc<Spectra>>,
    /// Its mean residual over the two states of the map.
    pub cells: Option<Arc<Cells>>,
}

/// What every view is drawn from.
pub struct Shown<'a> {
    /// The name of the current model.
    pub name: &'a str,
    /// Other models, over it.
    pub others: &'a [Other],
    pub table: &'a Arc<Table>,
    /// Rows of the table that are marked.
    pub lit: &'a [usize],
    /// Frequencies and past of all rows; `None` while they are computed.
    pub spectra: Option<&'a Arc<Spectra>>,
    /// Frequencies and past of the marked rows; `None` if nothing is marked, or while they are computed.
    pub marked: Option<&'a Arc<Spectra>>,
    /// Units of q, q̇, q̈ and τ.
    pub unit: [&'static str; 4],
    /// Counted from 0.
    pub joint: usize,
    /// The row under the cursor.
    pub row: Option<usize>,
}

impl Shown<'_> {
    fn column(&self, quantity: Quantity) -> Shared<f64> {
        Shared::of(self.table, move |table| table.column(quantity))
    }

    fn axis(&self, quantity: Quantity, extent: [f64; 2]) -> Axis {
        let (_, label, unit) = quantity.text(self.unit);
        Axis::new(label, unit).range(extent).linked(quantity.along(self.joint))
    }

    /// Marked rows as points, not more than can be seen.
    fn lit(&self, x: Quantity, y: Quantity, among: Range<usize>) -> Points {
        let (x, y) = (self.table.column(x), self.table.column(y));
        let rows = self.lit.iter().filter(|row| among.contains(row));
        let every = self.lit.len().div_ceil(MOST_MARKED).max(1);
        let points: Vec<[f64; 2]> = rows.step_by(every).map(|row| [x[*row], y[*row]]).collect();
        Points::new("", points, Ink::Marked).radius(0.7)
    }

    /// The residual over a state.
    pub fn over(&self, x: Quantity) -> Panel {
        let of = |part: fn(&Scatter) -> &[f64]| Shared::of(self.table, move |table| part(table.scatter(x)));
        let band = Band::new("", Shared::of(self.table, move |table| &table.scatter(x).band), Ink::Residual);
        let points = Points::new("", Shared::of(self.table, move |table| &table.scatter(x).points), Ink::Residual);
        let name = if self.others.is_empty() { "mean" } else { self.name };
        let mean = Line::new(name, of(|scatter| &scatter.mean_at), of(|scatter| &scatter.mean), Ink::Text);
        let means = self.others.iter().map(|other| {
            let of = |part: fn(&Scatter) -> &[f64]| Shared::of(&other.table, move |table| part(table.scatter(x)));
            let (at, mean) = (of(|scatter| &scatter.mean_at), of(|scatter| &scatter.mean));
            Line::new(&other.name, at, mean, other.ink).width(STRONG)
        });
        let title = format!("residual against {}", x.text(self.unit).0);
        Panel::new(title, [self.axis(x, self.table.scatter(x).extent), Axis::new("", self.unit[3])])
            .with(band)
            .with(points.radius(0.5).opacity(0.42))
            .with(self.lit(x, Quantity::Residual, 0..self.table.len()))
            .with_all(means)
            .with(mean.width(STRONG).dash(&[]))
    }

    /// Its mean over two states, of each model by itself, all in the same colours.
    pub fn maps(&self, [x, y]: [Quantity; 2], cells: &Cells) -> Vec<Panel> {
        let (name, _, unit) = y.text(self.unit);
        let panel = |title: String, cells: Cells| {
            let up = Axis::new("", unit).range(cells.extent[1]);
            let axes = [self.axis(x, cells.extent[0]), up];
            Panel::new(title, axes).with(cells).with(self.lit(x, y, 0..self.table.len()))
        };
        if self.others.is_empty() {
            return vec![panel(format!("mean residual, ↑ {name}"), cells.clone())];
        }
        let others = self.others.iter().filter_map(|other| Some((other.name.as_str(), other.cells.as_deref()?)));
        let all: Vec<(&str, &Cells)> = [(self.name, cells)].into_iter().chain(others).collect();
        let most = all.iter().map(|(_, cells)| cells.strongest()).fold(0.0, f64::max);
        let of_model = |(model, cells): (&str, &Cells)| {
            // The title is for the name of the model, which may be long.
            let cells = cells.clone().up_to(most);
            let scale = format!("mean residual {}", cells.scale);
            panel(format!("{model}: ↑ {name}"), Cells { scale, ..cells })
        };
        all.into_iter().map(of_model).collect()
    }

    /// The residual against velocity, in the order of time, around the cursor.
    pub fn around_cursor(&self) -> Panel {
        let row = self.row.unwrap_or(0);
        let rows = self.table.around(row, LOOP);
        let path = |table: &Table| -> Vec<[f64; 2]> {
            let (x, y) = (table.column(Quantity::Velocity), table.column(Quantity::Residual));
            let rows = table.around(row, LOOP);
            let every = rows.len().div_ceil(MOST_OF_LOOP).max(1);
            rows.step_by(every).map(|row| [x[row], y[row]]).collect()
        };
        let others = self.others.iter().map(|other| Line::path(&other.name, path(&other.table), other.ink));
        let name = if self.others.is_empty() { "" } else { self.name };
        let (x, y) = (self.table.column(Quantity::Velocity), self.table.column(Quantity::Residual));
        let path = path(self.table);
        let ends = |[low, high]: [f64; 2], point: &[f64; 2]| [low.min(point[0]), high.max(point[0])];
        let extent = path.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        let axes = [self.axis(Quantity::Velocity, extent), Axis::new("", self.unit[3])];
        Panel::new("residual–velocity loop around the cursor", axes)
            .with_all(others)
            .with(Line::path(name, path, Ink::Residual))
            .with(self.lit(Quantity::Velocity, Quantity::Residual, rows))
            .with(Points::new("", vec![[x[row], y[row]]], Ink::Cursor).radius(1.8))
    }

    /// A curve of all samples, and in front of it that of the marked region; `None` if there is none of all samples.
    pub fn curve(&self, curve: Curve) -> Option<Panel> {
        let all = self.spectra?;
        let (first, last) = (curve.of(all).first()?, curve.of(all).last()?);
        let marked = self.marked.map(|marked| (marked, curve.of(marked).is_empty()));
        let title = match marked {
            None => curve.title().to_owned(),
            Some((_, true)) => format!("{}: the marked region is too short", curve.title()),
            Some(_) => format!("{}: marked region", curve.title()),
        };
        let line = |name: &str, of: &Arc<Spectra>, ink: Ink| {
            let points = curve.of(of);
            Line::through(name, points.iter().copied(), ink).width(STRONG)
        };
        let mut panel = Panel::new(title, curve.axes(self.unit, [first[0], last[0]]));
        match marked {
            None => {
                for other in self.others {
                    panel = panel.with_all(other.spectra.as_ref().map(|own| line(&other.name, own, other.ink)));
                }
                panel.push(line(if self.others.is_empty() { "" } else { self.name }, all, Ink::Residual));
            }
            Some((marked, _)) => {
                panel.push(line("all", all, Ink::Weak).opacity(0.6).dash(&[]));
                for other in self.others {
                    panel = panel.with_all(other.marked.as_ref().map(|own| line(&other.name, own, other.ink)));
                }
                let name = if self.others.is_empty() { "marked" } else { self.name };
                panel.push(line(name, marked, Ink::Residual).dash(PREDICTED_DASH));
            }
        }
        Some(panel)
    }

    /// The residual over the time of all segments.
    pub fn time_line(&self) -> Panel {
        let (time, residual) = (self.column(Quantity::Time), self.column(Quantity::Residual));
        let extent = [time[0], time[time.len() - 1].max(time[0] + 1e-9)];
        let count = self.lit.len();
        let marked = if count == 0 { String::new() } else { format!(": {} samples marked", thousands(count)) };
        let axes = [self.axis(Quantity::Time, extent), Axis::new("", self.unit[3])];
        let name = if self.others.is_empty() { "τ − τ̂" } else { self.name };
        let others = self.others.iter().map(|other| {
            let of = |quantity| Shared::of(&other.table, move |table| table.column(quantity));
            Line::new(&other.name, of(Quantity::Time), of(Quantity::Residual), other.ink).sampled()
        });
        let line = Line::new(name, time, residual, Ink::Residual).sampled();
        Panel::new(format!("time line{marked}"), axes).with_all(others).with(line)
    }
}

/// What the frequencies and the past of the residual say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// Power over frequency.
    Power,
    /// Amplitude over the order of what repeats with position.
    Orders,
    /// With itself some time later.
    Correlation,
}

impl Curve {
    /// What it shows.
    pub fn title(self) -> &'static str {
        match self {
            Curve::Power => "residual power by frequency",
            Curve::Orders => "residual amplitude by order",
            Curve::Correlation => "residual autocorrelation",
        }
    }

    fn of(self, spectra: &Spectra) -> &[[f64; 2]] {
        match self {
            Curve::Power => &spectra.power,
            Curve::Orders => &spectra.orders,
            Curve::Correlation => &spectra.correlation,
        }
    }

    fn axes(self, unit: [&'static str; 4], extent: [f64; 2]) -> [Axis; 2] {
        let (label, x_unit, along) = match self {
            Curve::Power => ("frequency", "Hz", Along::Frequency),
            // A joint that slides has no turns: its orders count in as many metres as a turn has radians.
            Curve::Orders if unit[0] == "m" => ("order: times in 2π metres", "", Along::Order),
            Curve::Orders => ("order: times per turn of the joint", "", Along::Order),
            Curve::Correlation => ("lag", "s", Along::Lag),
        };
        let up = match self {
            Curve::Power => Axis::new("", density(unit[3])).logarithmic(),
            Curve::Orders => Axis::new("", unit[3]),
            Curve::Correlation => Axis::default(),
        };
        [Axis::new(label, x_unit).range(extent).linked(along), up]
    }
}
