//! From named arrays to columns: what NPZ archives, NPY files and MATLAB files have in common.

use std::collections::BTreeMap;

use std::io::{self, Read};

use ndarray::{ArrayD, Axis};

use super::budget::{Budget, TooMuch};
use super::share::{Counted, Share};
use super::table::{Column, MOST_COLUMNS, Table, listed};
use crate::progress::{Monitor, Stopped};
use crate::recording::npy::{Header, NpyError};

/// Groups of arrays may lie in each other this deep.
pub(super) const DEEPEST: usize = 16;

/// The arrays make no table.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ArraysError {
    /// It holds other things.
    #[error("the file holds no array of samples{}; save the log with numpy.savez('log.npz', time=time, q=q, tau=tau)", also(.0))]
    None(Vec<String>),
    /// An array can't be read.
    #[error("array `{array}`: {problem}")]
    Array {
        /// Its name.
        array: String,
        /// What is wrong.
        problem: NpyError,
    },
    /// More columns than any log has.
    #[error("its arrays have more than {MOST_COLUMNS} columns; a log has one column a channel, one row a sample")]
    TooWide,
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

fn also(passed_over: &[String]) -> String {
    if passed_over.is_empty() { String::new() } else { format!(" (passed over: {})", listed(passed_over)) }
}

/// What a number takes.
pub(super) const BYTES: u64 = 8;
/// Arrays with at most so many numbers are constants that a mapping may name, such as gear ratios.
const LARGEST_CONSTANT: usize = 64;

/// NPY files that belong together: the entries of an archive, the files of a folder.
pub(super) trait Source {
    /// One of them from its beginning, and its size \[bytes\].
    fn open(&mut self, index: usize) -> io::Result<(Box<dyn Read + '_>, u64)>;
}

/// Arrays on their way into a table.
#[derive(Default)]
pub(super) struct Gathered {
    pub arrays: Vec<(String, ArrayD<f64>)>,
    pub passed_over: Vec<String>,
}

impl Gathered {
    /// Takes arrays, given as their places in the source and their names: those that fit most of the others, or `all`. The headers
    /// decide, so that what is passed over is never in memory; it is still read to its end, where damage shows.
    pub fn take(
        &mut self,
        source: &mut dyn Source,
        names: Vec<(usize, String)>,
        all: bool,
        budget: &mut Budget,
        monitor: &Monitor,
    ) -> Result<(), ArraysError> {
        let mut found = Vec::new();
        for (index, array) in names {
            monitor.check()?;
            budget.text(&array)?;
            match header(source, index) {
                Ok(header) => found.push((index, array, header)),
                Err(NpyError::NotNumbers(reason)) => {
                    skim(source, index, &array, budget, &Watch { whole: u64::MAX, before: 0, monitor })?;
                    self.passed_over.push(format!("`{array}` ({reason})"));
                }
                Err(problem) => return Err(ArraysError::Array { array, problem }),
            }
        }
        let usual = usual_extent(found.iter().map(|(_, _, header)| header.shape()));
        let whole = found.iter().map(|(.., header)| header.size()).fold(0, u64::saturating_add);
        let mut watch = Watch { whole, before: 0, monitor };
        for (index, array, header) in found {
            if !all && !is_of_use(header.shape(), header.count(), usual) {
                skim(source, index, &array, budget, &watch)?;
                watch.before = watch.before.saturating_add(header.size());
                self.passed_over.push(misfit(&array, header.shape()));
                continue;
            }
            budget.unpack((header.count() as u64).saturating_mul(BYTES))?;
            match values(source, index, &watch) {
                Ok(values) => self.arrays.push((array, values)),
                Err(problem) => return Err(ArraysError::Array { array, problem }),
            }
            watch.before = watch.before.saturating_add(header.size());
        }
        Ok(())
    }

    /// The columns of the arrays.
    pub fn table(self, budget: &mut Budget) -> Result<Table, ArraysError> {
        table(self.arrays, self.passed_over, budget)
    }
}

fn header(source: &mut dyn Source, index: usize) -> Result<Header, NpyError> {
    let (mut file, size) = source.open(index).map_err(unreadable)?;
    let header = Header::read(&mut *file)?;
    header.check_size(size)?;
    Ok(header)
}

/// How far the reading of arrays that belong together is \[bytes\].
struct Watch<'a> {
    whole: u64,
    /// What stands in the arrays before this one.
    before: u64,
    monitor: &'a Monitor,
}

impl<'a> Watch<'a> {
    fn counted<R>(&self, from: R) -> Counted<'a, R> {
        Counted { from, share: Share::of(self.whole, self.monitor), done: self.before }
    }
}

fn values(source: &mut dyn Source, index: usize, watch: &Watch) -> Result<ArrayD<f64>, NpyError> {
    let (file, _) = source.open(index).map_err(unreadable)?;
    let mut file = watch.counted(file);
    Header::read(&mut file)?.values(&mut file)
}

/// Reads a file without keeping it.
fn skim(
    source: &mut dyn Source,
    index: usize,
    array: &str,
    budget: &mut Budget,
    watch: &Watch,
) -> Result<(), ArraysError> {
    let most = budget.left_to_unpack().saturating_add(1);
    let read = source.open(index).and_then(|(file, _)| io::copy(&mut watch.counted(file).take(most), &mut io::sink()));
    let wrong = |problem| ArraysError::Array { array: array.to_owned(), problem: unreadable(problem) };
    Ok(budget.unpack(read.map_err(wrong)?)?)
}

fn unreadable(problem: io::Error) -> NpyError {
    NpyError::Damaged(problem.to_string())
}

fn misfit(array: &str, shape: &[usize]) -> String {
    format!("`{array}` (its shape is {shape:?})")
}

/// How many runs, and how many samples in each.
pub(super) type Extent = (usize, usize);

/// How an array may be read: (samples), (samples, joints) or (runs, samples, joints).
fn extent(shape: &[usize]) -> Option<Extent> {
    match *shape {
        [samples] | [samples, _] => Some((1, samples)),
        [runs, samples, _] => Some((runs, samples)),
        _ => None,
    }
}

/// The extent that most arrays have; an array without elements may claim any, and constants do not outvote signals, however many
/// there are.
pub(super) fn usual_extent<'a>(shapes: impl Iterator<Item = &'a [usize]> + Clone) -> Option<Extent> {
    let count = |shape: &[usize]| shape.iter().fold(1usize, |product, size| product.saturating_mul(*size));
    let full = shapes.filter(|shape| count(shape) > 1);
    let signals = full.clone().any(|shape| count(shape) > LARGEST_CONSTANT);
    let full = full.filter(|shape| !signals || count(shape) > LARGEST_CONSTANT);
    let mut votes: BTreeMap<Extent, usize> = BTreeMap::new();
    for extent in full.filter_map(extent) {
        *votes.entry(extent).or_default() += 1;
    }
    let winner = votes.into_iter().max_by_key(|&((runs, samples), votes)| (votes, runs.saturating_mul(samples)));
    winner.map(|(extent, _)| extent)
}

/// Whether an array becomes columns, a constant or a time step, where most have this extent.
pub(super) fn is_of_use(shape: &[usize], count: usize, usual: Option<Extent>) -> bool {
    let fits = |(runs, samples): Extent| match *shape {
        [own] if own == samples => true,
        [first, second] if runs > 1 && (first, second) == (runs, samples) => true,
        _ => extent(shape) == Some((runs, samples)),
    };
    count <= LARGEST_CONSTANT || usual.is_some_and(fits)
}

/// Columns of the arrays that share the extent which most of them have; the others are passed over.
pub(super) fn table(
    arrays: Vec<(String, ArrayD<f64>)>,
    mut passed_over: Vec<String>,
    budget: &mut Budget,
) -> Result<Table, ArraysError> {
    let step = arrays.iter().find_map(|(name, array)| stated_step(name, array));
    let Some((runs, samples)) = usual_extent(arrays.iter().map(|(_, array)| array.shape())) else {
        return Err(ArraysError::None(passed_over));
    };
    let rows = runs * samples;
    let mut table =
        Table { runs: (0..runs).map(|run| run * samples..(run + 1) * samples).collect(), step, ..Table::default() };
    for (name, array) in arrays {
        budget.name(&name)?;
        let column = |name, values| Column { name, values, text: None };
        match *array.shape() {
            [own] if own == samples => {
                // One clock for many runs takes its memory once for each.
                budget.unpack((rows - samples) as u64 * BYTES)?;
                let repeated = match runs {
                    1 => flat(array),
                    _ => array.iter().copied().cycle().take(rows).collect(),
                };
                table.columns.push(column(name, repeated));
            }
            [first, second] if runs > 1 && (first, second) == (runs, samples) => {
                table.columns.push(column(name, flat(array)))
            }
            [.., 1] if array.ndim() > 1 && extent(array.shape()) == Some((runs, samples)) => {
                table.columns.push(column(format!("{name}[0]"), flat(array)));
            }
            [.., width] if array.ndim() > 1 && extent(array.shape()) == Some((runs, samples)) => {
                if table.columns.len().saturating_add(width) > MOST_COLUMNS {
                    return Err(ArraysError::TooWide);
                }
                for joint in 0..width {
                    let values = array.index_axis(Axis(array.ndim() - 1), joint).iter().copied().collect();
                    table.columns.push(column(format!("{name}[{joint}]"), values));
                }
            }
            _ if stated_step(&name, &array).is_some() => {}
            _ if array.len() <= LARGEST_CONSTANT => {
                table.constants.insert(name, array);
            }
            _ => passed_over.push(misfit(&name, array.shape())),
        }
        if table.columns.len() > MOST_COLUMNS {
            return Err(ArraysError::TooWide);
        }
    }
    table.passed_over = passed_over;
    Ok(table)
}

/// Columns of lists of arrays, one array a run: of those whose runs are as long as most have them. Of arrays beside them the small
/// ones are constants.
pub(super) fn table_of_runs(
    lists: Vec<(String, Vec<ArrayD<f64>>)>,
    beside: Vec<(String, ArrayD<f64>)>,
    mut passed_over: Vec<String>,
    budget: &mut Budget,
) -> Result<Table, ArraysError> {
    let lengths =
        |runs: &[ArrayD<f64>]| runs.iter().map(|run| run.shape().first().copied().unwrap_or(0)).collect::<Vec<_>>();
    let mut votes: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
    lists.iter().for_each(|(_, runs)| *votes.entry(lengths(runs)).or_default() += 1);
    let winner = votes.into_iter().max_by_key(|(lengths, votes)| (*votes, lengths.iter().sum::<usize>()));
    let Some((usual, _)) = winner else { return Err(ArraysError::None(passed_over)) };
    let mut table = Table::default();
    let mut start = 0;
    for &length in &usual {
        table.runs.push(start..start + length);
        start += length;
    }
    for (name, runs) in lists {
        let width = runs.first().map_or(&[][..], |run| &run.shape()[1.min(run.ndim())..]).to_vec();
        let is_alike = runs.iter().all(|run| run.ndim() == width.len() + 1 && run.shape()[1..] == width[..]);
        if lengths(&runs) != usual || !is_alike || width.len() > 1 {
            passed_over.push(format!("`{name}` (its runs are not like those of the others)"));
            continue;
        }
        budget.unpack(runs.iter().map(|run| run.len() as u64 * BYTES).sum())?;
        budget.name(&name)?;
        let width = width.first().copied();
        if table.columns.len().saturating_add(width.unwrap_or(1)) > MOST_COLUMNS {
            return Err(ArraysError::TooWide);
        }
        for joint in 0..width.unwrap_or(1) {
            let values =
                |run: &ArrayD<f64>| run.iter().copied().skip(joint).step_by(width.unwrap_or(1)).collect::<Vec<_>>();
            let values = runs.iter().flat_map(values).collect();
            let name = if width.is_some() { format!("{name}[{joint}]") } else { name.clone() };
            table.columns.push(Column { name, values, text: None });
        }
    }
    for (name, array) in beside {
        match stated_step(&name, &array) {
            Some(step) => table.step = Some(step),
            None if array.len() <= LARGEST_CONSTANT => drop(table.constants.insert(name, array)),
            None => passed_over.push(format!("`{name}` (not one array a run)")),
        }
    }
    table.passed_over = passed_over;
    Ok(table)
}

/// The numbers of an array, row after row. Those that lie so in memory are not copied: a log of one joint may be all that fits.
fn flat(array: ArrayD<f64>) -> Vec<f64> {
    let count = array.len();
    if !array.is_standard_layout() {
        return array.into_iter().collect();
    }
    let (mut numbers, offset) = array.into_raw_vec_and_offset();
    numbers.drain(..offset.unwrap_or(0));
    numbers.truncate(count);
    numbers
}

/// The time step \[s\] that an array of one number states.
fn stated_step(name: &str, array: &ArrayD<f64>) -> Option<f64> {
    let value = *array.first().filter(|_| array.len() == 1)?;
    let step = match name.to_lowercase().as_str() {
        "dt" | "time_step" | "timestep" | "step" | "sampling_time" | "sample_time" => value,
        "fs" | "rate" | "sample_rate" | "sampling_rate" | "frequency" => 1.0 / value,
        _ => return None,
    };
    (step.is_finite() && step > 0.0).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As they stand, turned round, and what is left of the front of a longer one.
    #[test]
    fn an_array_is_read_row_after_row_however_it_lies_in_memory() {
        let array = ArrayD::from_shape_vec(vec![2, 3], (1..=6).map(f64::from).collect()).unwrap();
        assert_eq!(flat(array.clone()), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(flat(array.clone().reversed_axes()), [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        let mut last = array;
        last.slice_axis_inplace(Axis(0), ndarray::Slice::from(1..));
        assert_eq!(flat(last), [4.0, 5.0, 6.0]);
    }

    #[test]
    fn a_complaint_names_what_was_passed_over() {
        assert_eq!(also(&[]), "");
        assert_eq!(also(&["`a` (text)".to_owned()]), " (passed over: `a` (text))");
    }
}
