//! The residual of one joint beside every state, as one table of samples; every view is drawn from it.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::app::desk::Stretch;
use crate::app::memo::Question;
use crate::app::plot::{Along, Region};
use crate::effect::Axis;
use crate::figure::mark::{Cells, Shades};
use crate::recording::{Recording, spectrum};
use crate::session::{Generation, Session};
use crate::statistics::ends;

/// Most points that one plot draws.
const MOST_POINTS: usize = 4000;
/// Columns in which mean and spread are computed.
const COLUMNS: usize = 48;
/// Columns with fewer samples than this show no mean.
const FEWEST: f64 = 4.0;
/// Columns and rows of the map.
const MAP: [usize; 2] = [44, 30];
/// Highest order of the spectrum over position.
const HIGHEST_ORDER: usize = 64;
/// Most samples of which the autocorrelation is computed, so that it takes no longer than a frame.
const MOST_CORRELATED: usize = 40_000;
/// How many lags are drawn, up to this time \[s\].
const LAGS: usize = 120;
const LONGEST_LAG: f64 = 2.0;
/// How many moments are listed, and how far they are apart at least \[s\].
const WORST: usize = 20;
const APART: f64 = 0.25;

/// What can stand on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Quantity {
    /// t, from one trajectory on to the next.
    Time,
    /// q
    Position,
    /// q̇
    Velocity,
    /// q̈
    Acceleration,
    /// τ
    Load,
    /// τ − τ̂
    Residual,
}

impl Quantity {
    /// All states, without the residual itself.
    pub const STATES: [Quantity; 5] =
        [Quantity::Velocity, Quantity::Position, Quantity::Acceleration, Quantity::Load, Quantity::Time];

    /// Name, label and unit, of a joint with these units of q, q̇, q̈ and τ.
    pub fn text(self, unit: [&'static str; 4]) -> (&'static str, &'static str, &'static str) {
        match self {
            Quantity::Time => ("time", "time t, all trajectories end to end", "s"),
            Quantity::Position => ("position", "position q", unit[0]),
            Quantity::Velocity => ("velocity", "velocity q̇", unit[1]),
            Quantity::Acceleration => ("acceleration", "acceleration q̈", unit[2]),
            Quantity::Load if unit[0] == "m" => ("load", "load: measured force τ", unit[3]),
            Quantity::Load => ("load", "load: measured torque τ", unit[3]),
            Quantity::Residual => ("residual", "residual τ − τ̂", unit[3]),
        }
    }
}

impl Quantity {
    /// Which charts show it along with others.
    pub fn along(self, joint: usize) -> Along {
        match self {
            Quantity::Time => Along::WholeTime,
            Quantity::Position => Along::Position(joint),
            Quantity::Velocity => Along::Velocity(joint),
            Quantity::Acceleration => Along::Acceleration(joint),
            Quantity::Load => Along::Load(joint),
            Quantity::Residual => Along::Residual(joint),
        }
    }
}

impl From<Axis> for Quantity {
    fn from(axis: Axis) -> Self {
        match axis {
            Axis::Time => Quantity::Time,
            Axis::Position => Quantity::Position,
            Axis::Velocity => Quantity::Velocity,
            Axis::Acceleration => Quantity::Acceleration,
        }
    }
}

/// A region that was marked in one view.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Brush {
    pub x: Quantity,
    pub y: Quantity,
    pub region: Region,
}

/// Where a sample of the table comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    pub trajectory: usize,
    pub sample: usize,
}

/// The residual over one state, ready to be drawn.
pub struct Scatter {
    pub points: Vec<[f64; 2]>,
    pub extent: [f64; 2],
    pub mean_at: Vec<f64>,
    pub mean: Vec<f64>,
    pub band: Vec<[f64; 3]>,
}

/// What the frequencies and the past of the residual say; empty where there are too few samples that follow each other.
pub struct Spectra {
    /// Frequency \[Hz\] and power.
    pub power: Vec<[f64; 2]>,
    /// Order and amplitude of what repeats with the position.
    pub orders: Vec<[f64; 2]>,
    /// Lag \[s\] and autocorrelation.
    pub correlation: Vec<[f64; 2]>,
}

/// Which samples: of one model and joint, in the training or the held-out part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    pub model: Generation,
    /// Counted from 0.
    pub joint: usize,
    pub held_out: bool,
}

impl Question for Samples {
    type Answer = Table;

    fn answer(&self, session: &Session) -> Result<Table, String> {
        Ok(Table::new(session, *self))
    }
}

/// What of a table a brush lights.
#[derive(Clone, PartialEq)]
pub struct Lit {
    pub table: Arc<Table>,
    pub brush: Brush,
}

/// See [`Lit`].
#[derive(Default)]
pub struct Marked {
    pub rows: Vec<usize>,
    /// Stretches of the time line \[s\].
    pub shown: Vec<[f64; 2]>,
    /// The same in the time of their trajectories.
    pub stretches: Arc<Vec<Stretch>>,
}

impl Question for Lit {
    type Answer = Marked;
    const KEPT: usize = 1;

    fn answer(&self, session: &Session) -> Result<Marked, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let rows = self.table.lit(&self.brush);
        let (shown, stretches) = self.table.stretches(&rows, recording).into_iter().unzip();
        Ok(Marked { rows, shown, stretches: Arc::new(stretches) })
    }
}

/// Frequencies and past of all samples of a table.
#[derive(Clone, PartialEq)]
pub struct AllSpectra {
    pub table: Arc<Table>,
}

impl Question for AllSpectra {
    type Answer = Spectra;

    fn answer(&self, _: &Session) -> Result<Spectra, String> {
        Ok(self.table.spectra_of_pieces(&self.table.pieces))
    }
}

/// Frequencies and past of what a model leaves in a region that is marked in a view of the current one.
#[derive(Clone, PartialEq)]
pub struct MarkedSpectra {
    pub table: Arc<Table>,
    pub brush: Brush,
    /// Of the same samples: what the model leaves.
    pub of: Arc<Table>,
}

impl Question for MarkedSpectra {
    type Answer = Spectra;
    const KEPT: usize = 9;

    fn answer(&self, _: &Session) -> Result<Spectra, String> {
        // Where a model has no value there is no row.
        let rows: Vec<usize> = self.table.lit(&self.brush).into_iter().filter(|row| *row < self.of.len()).collect();
        Ok(self.of.spectra_of(&rows))
    }
}

/// The mean residual over two states.
#[derive(Clone, PartialEq)]
pub struct MeanMap {
    pub table: Arc<Table>,
    pub states: [Quantity; 2],
}

impl Question for MeanMap {
    type Answer = Cells;

    fn answer(&self, _: &Session) -> Result<Cells, String> {
        let [x, y] = self.states;
        Ok(self.table.map(x, y))
    }
}

/// All finite samples of one joint in the training or the held-out part.
pub struct Table {
    of: Samples,
    columns: [Vec<f64>; 6],
    places: Vec<Place>,
    /// Samples that follow each other in time.
    pieces: Vec<Range<usize>>,
    step: f64,
    /// Of the residual.
    unit: &'static str,
    /// Over each of the states.
    scatters: Vec<Scatter>,
    worst: Vec<usize>,
}

/// Of one session, tables of the same samples are the same.
impl PartialEq for Table {
    fn eq(&self, other: &Self) -> bool {
        self.of == other.of
    }
}

impl Table {
    fn new(session: &Session, of: Samples) -> Self {
        let mut table = Table::gathered(session, of);
        let states = [Quantity::Time, Quantity::Position, Quantity::Velocity, Quantity::Acceleration, Quantity::Load];
        table.scatters = states.map(|state| table.scattered(state)).into();
        table.worst = table.ranked();
        table
    }

    /// The samples alone.
    fn gathered(session: &Session, of: Samples) -> Self {
        let Samples { model, joint, held_out } = of;
        let segments = if held_out { &session.split.held_out } else { &session.split.train };
        let mut table = Table {
            of,
            columns: Default::default(),
            places: Vec::new(),
            pieces: Vec::new(),
            step: 0.0,
            unit: "",
            scatters: Vec::new(),
            worst: Vec::new(),
        };
        let step = session.model_of(model);
        let (Some(recording), Some(step)) = (session.recording.as_deref(), step) else { return table };
        table.unit = recording.joints[joint].kind.units()[3];
        let mut elapsed = 0.0;
        for segment in segments {
            let (Some(run), Some(prediction)) =
                (recording.trajectories.get(segment.trajectory), step.evaluation.predictions.get(segment.trajectory))
            else {
                continue;
            };
            let start = run.time.get(segment.samples.start).copied().unwrap_or(0.0);
            let first = table.places.len();
            for sample in segment.samples.clone() {
                let (load, model) = (run.tau[joint][sample], prediction.total[joint][sample]);
                let time = elapsed + run.time[sample] - start;
                let row =
                    [time, run.q[joint][sample], run.qd[joint][sample], run.qdd[joint][sample], load, load - model];
                if row.iter().all(|value| value.is_finite()) {
                    table.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
                    table.places.push(Place { trajectory: segment.trajectory, sample });
                }
            }
            table.pieces.push(first..table.places.len());
            let last = segment.samples.end.saturating_sub(1);
            table.step = run.time_step();
            elapsed += run.time.get(last).map_or(0.0, |time| time - start) + table.step;
        }
        table
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    pub fn column(&self, quantity: Quantity) -> &[f64] {
        &self.columns[quantity as usize]
    }

    /// Where every row comes from.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    pub fn place(&self, row: usize) -> Place {
        self.places[row]
    }

    /// The row of a sample of a trajectory, or of the nearest one in the table.
    pub fn row(&self, place: Place) -> Option<usize> {
        let rows = self
            .pieces
            .iter()
            .filter(|piece| self.places.get(piece.start).is_some_and(|first| first.trajectory == place.trajectory));
        let distance = |row: &usize| self.places[*row].sample.abs_diff(place.sample);
        let nearest = |piece: &Range<usize>| {
            let after = self.places[piece.clone()].partition_point(|other| other.sample < place.sample) + piece.start;
            [after.saturating_sub(1).max(piece.start), after.min(piece.end - 1)].into_iter().min_by_key(distance)
        };
        rows.filter_map(nearest).min_by_key(distance)
    }

    /// The rows around one, at most so many seconds before and after, without a jump between them.
    pub fn around(&self, row: usize, seconds: f64) -> Range<usize> {
        let Some(piece) = self.pieces.iter().find(|piece| piece.contains(&row)) else { return 0..0 };
        let reach = (seconds / self.step.max(1e-9)) as usize;
        row.saturating_sub(reach).max(piece.start)..(row + reach).min(piece.end)
    }

    /// Every n-th row, so that a plot of them is not too full.
    fn thinned(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).step_by(self.len().div_ceil(MOST_POINTS).max(1))
    }

    /// The residual over a state.
    pub fn scatter(&self, state: Quantity) -> &Scatter {
        &self.scatters[state as usize]
    }

    fn scattered(&self, state: Quantity) -> Scatter {
        let (x, residual) = (self.column(state), self.column(Quantity::Residual));
        let mut scatter = Scatter {
            points: self.thinned().map(|row| [x[row], residual[row]]).collect(),
            extent: extent(x),
            mean_at: Vec::new(),
            mean: Vec::new(),
            band: Vec::new(),
        };
        for [x, mean, spread] in self.means(state, residual) {
            scatter.mean_at.push(x);
            scatter.mean.push(mean);
            scatter.band.push([x, mean - spread, mean + spread]);
        }
        scatter
    }

    /// In columns over a state: where the column is, mean and deviation of what is there, given by row.
    pub fn means(&self, state: Quantity, values: &[f64]) -> Vec<[f64; 3]> {
        let x = self.column(state);
        let extent = extent(x);
        let width = (extent[1] - extent[0]) / COLUMNS as f64;
        let mut sums = vec![[0.0; 3]; COLUMNS];
        for (x, value) in x.iter().zip(values) {
            let sum = &mut sums[(((x - extent[0]) / width.max(1e-300)) as usize).min(COLUMNS - 1)];
            *sum = [sum[0] + 1.0, sum[1] + value, sum[2] + value * value];
        }
        let column = |(number, [count, sum, squares]): (usize, [f64; 3])| {
            let mean = sum / count;
            [extent[0] + (number as f64 + 0.5) * width, mean, (squares / count - mean * mean).max(0.0).sqrt()]
        };
        sums.into_iter().enumerate().filter(|(_, sum)| sum[0] >= FEWEST).map(column).collect()
    }

    /// Of which model the residual is.
    pub fn model(&self) -> Generation {
        self.of.model
    }

    /// Mean residual over two states.
    fn map(&self, x: Quantity, y: Quantity) -> Cells {
        let [x, y] = [x, y].map(|quantity| self.column(quantity));
        let ends = [extent(x), extent(y)];
        let mut sums = vec![[0.0; 2]; MAP[0] * MAP[1]];
        let cell = |value: f64, axis: usize| {
            let share = (value - ends[axis][0]) / (ends[axis][1] - ends[axis][0]).max(1e-300);
            ((share * MAP[axis] as f64) as usize).min(MAP[axis] - 1)
        };
        for ((x, y), residual) in x.iter().zip(y).zip(self.column(Quantity::Residual)) {
            let sum = &mut sums[cell(*y, 1) * MAP[0] + cell(*x, 0)];
            *sum = [sum[0] + 1.0, sum[1] + residual];
        }
        let mean = |[count, sum]: [f64; 2]| if count > 0.0 { sum / count } else { f64::NAN };
        let values: Vec<f64> = sums.into_iter().map(mean).collect();
        let (unit, scale) = (self.unit, String::new());
        Cells { size: MAP, extent: ends, values: values.into(), shades: Shades::Signed, unit, scale, most: None }
            .with_scale()
    }

    /// Frequencies and the past of some rows, in ascending order: of every stretch of rows that follow each other.
    fn spectra_of(&self, rows: &[usize]) -> Spectra {
        let mut pieces: Vec<Range<usize>> = Vec::new();
        for row in rows {
            let begins = self.pieces.binary_search_by_key(row, |piece| piece.start).is_ok();
            match pieces.last_mut() {
                Some(last) if last.end == *row && !begins => last.end += 1,
                _ => pieces.push(*row..row + 1),
            }
        }
        self.spectra_of_pieces(&pieces)
    }

    fn spectra_of_pieces(&self, pieces: &[Range<usize>]) -> Spectra {
        let column = |quantity| pieces.iter().map(move |piece| &self.column(quantity)[piece.clone()]);
        let mut residual: Vec<&[f64]> = column(Quantity::Residual).collect();
        let power = spectrum::power(&residual, self.step);
        let joined = |quantity| column(quantity).collect::<Vec<_>>().concat();
        let orders = spectrum::orders(&joined(Quantity::Position), &joined(Quantity::Residual), HIGHEST_ORDER);
        let every = ((LONGEST_LAG / LAGS as f64 / self.step.max(1e-9)) as usize).max(1);
        let mut left = MOST_CORRELATED;
        for piece in &mut residual {
            *piece = &piece[..piece.len().min(left)];
            left -= piece.len();
        }
        // Lags longer than every piece have no value.
        let longest = residual.iter().map(|piece| piece.len()).max().unwrap_or(0);
        let lags = || (0..=LAGS).map(|lag| lag * every).take_while(|lag| *lag < longest);
        let correlation = spectrum::autocorrelation(&residual, lags());
        Spectra {
            power,
            orders,
            correlation: lags().zip(correlation).map(|(lag, value)| [lag as f64 * self.step, value]).collect(),
        }
    }

    /// Rows of the largest residuals, each some time from the others, worst first.
    pub fn worst(&self) -> &[usize] {
        &self.worst
    }

    fn ranked(&self) -> Vec<usize> {
        let (time, residual) = (self.column(Quantity::Time), self.column(Quantity::Residual));
        let size = |row: &usize| residual[*row].abs();
        let mut rows: Vec<usize> = (0..self.len()).collect();
        // Only the largest have to be sorted; each may keep its neighbours of a quarter of a second out.
        let near = (2.0 * APART / self.step.max(1e-9)) as usize + 1;
        let most = (WORST * near).min(rows.len());
        if most < rows.len() {
            rows.select_nth_unstable_by(most, |one, other| size(other).total_cmp(&size(one)));
            rows.truncate(most);
        }
        rows.sort_by(|one, other| size(other).total_cmp(&size(one)));
        let mut worst: Vec<usize> = Vec::new();
        for row in rows {
            if worst.len() < WORST && worst.iter().all(|other| (time[row] - time[*other]).abs() > APART) {
                worst.push(row);
            }
        }
        worst
    }

    /// The rows inside a marked region.
    fn lit(&self, brush: &Brush) -> Vec<usize> {
        let [x, y] = [brush.x, brush.y].map(|quantity| self.column(quantity));
        let inside = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let [across, along] = brush.region;
        (0..self.len()).filter(|row| inside(x[*row], across) && inside(y[*row], along)).collect()
    }

    /// Rows as stretches of the time line \[s\] and of the trajectories; rows next to each other are one stretch.
    fn stretches(&self, rows: &[usize], recording: &Recording) -> Vec<([f64; 2], Stretch)> {
        let time = self.column(Quantity::Time);
        let whole = time.last().copied().unwrap_or(0.0);
        // What no eye can part is one.
        let apart = (whole / 800.0).max(3.0 * self.step);
        let piece = |row: usize| self.pieces.partition_point(|piece| piece.start <= row);
        let mut ends: Vec<[usize; 2]> = Vec::new();
        for row in rows.iter().copied() {
            match ends.last_mut() {
                Some([_, last]) if time[row] - time[*last] <= apart && piece(row) == piece(*last) => *last = row,
                _ => ends.push([row, row]),
            }
        }
        let stretch = |[first, last]: [usize; 2]| {
            let Place { trajectory, sample } = self.place(first);
            let run = &recording.trajectories[trajectory].time;
            let times = [run[sample], run[self.place(last).sample] + self.step];
            ([time[first], time[last] + self.step], Stretch { trajectory, times })
        };
        ends.into_iter().map(stretch).collect()
    }
}

/// Smallest and largest; 0 and 1 if there is nothing.
fn extent(values: &[f64]) -> [f64; 2] {
    let [low, high] = ends(values.iter().copied());
    if low < high { [low, high] } else { [0.0, 1.0] }
}
