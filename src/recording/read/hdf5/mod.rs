//! HDF5, and MATLAB 7.3, which is HDF5 behind a header of its own: a tree of datasets, named by their paths with dots between.
//!
//! A table of rows ([`compound`]) has a column for each of its fields. Groups beside each other with the same datasets may be runs
//! ([`groups`]).
//! MATLAB writes its arrays with their dimensions turned round, and a vector as a matrix with one column.

mod compound;
mod groups;

use std::collections::HashSet;

use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem};
use ndarray::{ArrayD, Axis};

use super::arrays::{self, ArraysError, BYTES, DEEPEST};
use super::budget::Budget;
use super::share::Share;
use super::table::{MOST_COLUMNS, Table};
use crate::progress::Monitor;

/// The file can't be read.
#[derive(Debug, thiserror::Error)]
pub enum Hdf5Error {
    /// It is damaged, or uses what is not read.
    #[error(
        "{at}: {problem}; copy the file again, or write it anew in Python: f = h5py.File('log.h5'); \
             numpy.savez('log.npz', time=f['time'][:], q=f['q'][:], tau=f['tau'][:])"
    )]
    Damaged {
        /// The dataset or group.
        at: String,
        /// What is wrong.
        problem: String,
    },
    /// More datasets than any log has.
    #[error("it has more than {MOST_COLUMNS} datasets and groups; a log has one dataset a channel")]
    TooMany,
    /// Its datasets make no table, would take too much memory, or were not read to the end.
    #[error(transparent)]
    Arrays(ArraysError),
}

impl<E: Into<ArraysError>> From<E> for Hdf5Error {
    fn from(problem: E) -> Self {
        Hdf5Error::Arrays(problem.into())
    }
}

/// What a packed part may unpack to \[bytes\].
const LARGEST_CHUNK: usize = 64 << 20;
/// How much of it may be kept unpacked \[bytes\].
const CACHE: usize = 8 << 20;

/// Reads a file.
pub(super) fn read(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Table, Hdf5Error> {
    let most = usize::try_from(budget.left_to_unpack()).unwrap_or(usize::MAX);
    let options = OpenOptions::default();
    let options = options.with_max_chunk_bytes(LARGEST_CHUNK).with_max_read_bytes(most).with_chunk_cache_bytes(CACHE);
    budget.unpack(bytes.len() as u64)?;
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(|problem| damaged("the file", &problem))?;
    let root = file.root_group().map_err(|problem| damaged("the file", &problem))?;
    let mut found = Found { datasets: Vec::new(), passed_over: Vec::new(), groups: HashSet::new() };
    found.collect(&root, "", 0, budget, monitor)?;
    let turned = bytes.starts_with(MATLAB);
    let names: Vec<&str> = found.datasets.iter().map(|(name, _)| name.as_str()).collect();
    let shapes: Vec<Vec<usize>> = found.datasets.iter().map(|(_, dataset)| shape(dataset, turned)).collect();
    let length = |dataset: usize| shapes[dataset].first().copied().unwrap_or(0);
    let runs = groups::runs(&names, length);
    let is_in_run = |dataset: usize| runs.as_ref().is_some_and(|runs| runs.has(dataset));
    let usual = arrays::usual_extent(shapes.iter().map(Vec::as_slice));
    let mut arrays = Vec::new();
    let size = |shape: &Vec<usize>| shape.iter().fold(1u64, |product, size| product.saturating_mul(*size as u64));
    let whole = shapes.iter().map(size).fold(0, u64::saturating_add);
    let mut watch = Watch { share: Share::of(whole, monitor), done: 0 };
    let mut plain = bytes.len() as u64;
    for (number, ((name, dataset), shape)) in found.datasets.iter().zip(&shapes).enumerate() {
        watch.share.is(watch.done)?;
        let count = shape.iter().fold(1usize, |product, size| product.saturating_mul(*size));
        if !is_in_run(number) && !arrays::is_of_use(shape, count, usual) {
            found.passed_over.push(format!("`{name}` (its shape is {shape:?})"));
            continue;
        }
        if !is_in(dataset, &mut plain) {
            found.passed_over.push(format!("`{name}` (its numbers are not in the file, or are those of others)"));
            continue;
        }
        if let Datatype::Compound { fields, .. } = dataset.dtype() {
            let columns = compound::columns(dataset, name, fields, budget)?;
            let is_empty = columns.is_empty();
            arrays.extend(columns.into_iter().map(|(name, array)| (number, name, array)));
            if !is_empty {
                continue;
            }
        }
        // What is read, and what becomes of it.
        budget.unpack((count as u64).saturating_mul(2 * BYTES))?;
        match values(dataset, name, &mut watch)? {
            Some(array) => arrays.push((number, name.clone(), laid_out(array, turned))),
            None => found.passed_over.push(format!("`{name}` (no numbers)")),
        }
    }
    let alone = |arrays: Vec<(usize, String, ArrayD<f64>)>| arrays.into_iter().map(|(_, name, array)| (name, array));
    let Some(runs) = runs else { return Ok(arrays::table(alone(arrays).collect(), found.passed_over, budget)?) };
    let (inside, beside): (Vec<_>, Vec<_>) = arrays.into_iter().partition(|(dataset, ..)| runs.has(*dataset));
    let (lists, one_sided) = runs.lists(inside);
    found.passed_over.extend(one_sided.into_iter().map(|name| format!("`{name}` (not in every run)")));
    let table = arrays::table_of_runs(lists, alone(beside).collect(), found.passed_over, budget)?;
    Ok(Table { run_names: Some(runs.names()), ..table })
}

/// Whether the numbers of a dataset can be in the file beside those that were read before: what is not packed in chunks takes its place
/// there. `plain` is what such datasets may still take \[bytes\].
fn is_in(dataset: &Dataset, plain: &mut u64) -> bool {
    let sizes = dataset.num_elements().ok().zip(dataset.raw_element_size().ok());
    let Some((count, size)) = sizes.filter(|_| dataset.chunks().is_none()) else { return true };
    let left = plain.checked_sub(count.saturating_mul(size as u64));
    *plain = left.unwrap_or(*plain);
    left.is_some()
}

/// With these bytes begins what MATLAB wrote.
pub(super) const MATLAB: &[u8] = b"MATLAB 7.3";

fn damaged(at: &str, problem: &hdf5_reader::error::Error) -> Hdf5Error {
    Hdf5Error::Damaged { at: format!("`{at}`"), problem: problem.to_string() }
}

/// What was found in the tree.
struct Found {
    datasets: Vec<(String, Dataset)>,
    passed_over: Vec<String>,
    /// Where the groups are: one that leads back to itself is not entered again.
    groups: HashSet<u64>,
}

impl Found {
    fn collect(
        &mut self,
        group: &Group,
        path: &str,
        depth: usize,
        budget: &mut Budget,
        monitor: &Monitor,
    ) -> Result<(), Hdf5Error> {
        monitor.check()?;
        if depth > DEEPEST || !self.groups.insert(group.address()) {
            return Ok(());
        }
        if self.groups.len() + self.datasets.len() > MOST_COLUMNS {
            return Err(Hdf5Error::TooMany);
        }
        let at = if path.is_empty() { "the file" } else { path };
        let (groups, datasets) = group.members().map_err(|problem| damaged(at, &problem))?;
        let named = |name: &str| {
            let name = name.rsplit('/').next().unwrap_or(name);
            if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
        };
        for dataset in datasets {
            let name = named(dataset.name());
            budget.text(&name)?;
            self.datasets.push((name, dataset));
        }
        // What MATLAB keeps for itself begins with #.
        for inner in groups.iter().filter(|inner| !inner.name().rsplit('/').next().unwrap_or_default().starts_with('#'))
        {
            let name = named(inner.name());
            budget.text(&name)?;
            self.collect(inner, &name, depth + 1, budget, monitor)?;
        }
        Ok(())
    }
}

/// The shape of a dataset as its writer meant it.
fn shape(dataset: &Dataset, turned: bool) -> Vec<usize> {
    let mut shape: Vec<usize> =
        dataset.shape().iter().map(|size| usize::try_from(*size).unwrap_or(usize::MAX)).collect();
    if turned {
        shape.reverse();
    }
    if turned && is_vector(&shape) {
        shape.retain(|size| *size != 1);
    }
    shape
}

fn is_vector(shape: &[usize]) -> bool {
    shape.len() == 2 && shape.contains(&1) && shape.iter().any(|size| *size > 1)
}

fn laid_out(array: ArrayD<f64>, turned: bool) -> ArrayD<f64> {
    if !turned {
        return array;
    }
    let mut array = array.reversed_axes();
    if is_vector(array.shape()) {
        let single = usize::from(array.shape()[1] == 1);
        array = array.index_axis_move(Axis(single), 0);
    }
    array
}

/// How many numbers of all datasets are read.
struct Watch<'a> {
    share: Share<'a>,
    done: u64,
}

/// So many numbers are read at once.
const BLOCK: usize = 1 << 20;

/// The numbers of a dataset; `None` if it holds something else.
fn values(dataset: &Dataset, name: &str, watch: &mut Watch) -> Result<Option<ArrayD<f64>>, Hdf5Error> {
    Ok(Some(match dataset.dtype() {
        Datatype::FloatingPoint { size: 8, .. } => blocks(dataset, name, watch, |value: f64| value)?,
        Datatype::FloatingPoint { size: 4, .. } => blocks(dataset, name, watch, |value: f32| f64::from(value))?,
        Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
            (1, true) => blocks(dataset, name, watch, |value: i8| f64::from(value))?,
            (1, false) => blocks(dataset, name, watch, |value: u8| f64::from(value))?,
            (2, true) => blocks(dataset, name, watch, |value: i16| f64::from(value))?,
            (2, false) => blocks(dataset, name, watch, |value: u16| f64::from(value))?,
            (4, true) => blocks(dataset, name, watch, |value: i32| f64::from(value))?,
            (4, false) => blocks(dataset, name, watch, |value: u32| f64::from(value))?,
            (8, true) => blocks(dataset, name, watch, |value: i64| value as f64)?,
            (8, false) => blocks(dataset, name, watch, |value: u64| value as f64)?,
            _ => return Ok(None),
        },
        _ => return Ok(None),
    }))
}

/// Reads a dataset along its longest axis, block after block, so that it can be stopped.
fn blocks<T: H5Type>(
    dataset: &Dataset,
    name: &str,
    watch: &mut Watch,
    number: impl Fn(T) -> f64 + Copy,
) -> Result<ArrayD<f64>, Hdf5Error> {
    let wrong = |problem| damaged(name, &problem);
    let shape = shape(dataset, false);
    let count: usize = shape.iter().product();
    let longest = (0..shape.len()).max_by_key(|axis| shape[*axis]);
    let Some(axis) = longest.filter(|_| count > BLOCK) else {
        watch.done += count as u64;
        return Ok(dataset.read_array::<T>().map_err(wrong)?.map(|value| number(value.clone())));
    };
    let rows = (BLOCK / (count / shape[axis])).max(1);
    let mut array = ArrayD::zeros(shape.as_slice());
    for start in (0..shape[axis]).step_by(rows) {
        watch.share.is(watch.done)?;
        let end = (start + rows).min(shape[axis]);
        let mut selection = SliceInfo::all(shape.len());
        selection.selections[axis] = SliceInfoElem::Slice { start: start as u64, end: end as u64, step: 1 };
        let block = dataset.read_slice::<T>(&selection).map_err(wrong)?;
        watch.done += block.len() as u64;
        let mut place = array.slice_axis_mut(Axis(axis), (start..end).into());
        if place.shape() != block.shape() {
            return Err(Hdf5Error::Damaged {
                at: format!("`{name}`"),
                problem: "it has fewer numbers than it says".to_owned(),
            });
        }
        place.zip_mut_with(&block, |place, value| *place = number(value.clone()));
    }
    Ok(array)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written by h5py 3.16 (`tests/data/README.md` tells how): chunks with gzip and shuffle, groups, integers, texts.
    const H5: &[u8] = include_bytes!("../../../../tests/data/log.h5");
    /// The same layout as MATLAB 7.3 writes it.
    const MAT: &[u8] = include_bytes!("../../../../tests/data/log73.mat");

    fn table(bytes: &[u8]) -> Result<Table, Hdf5Error> {
        read(bytes, &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new())
    }

    #[test]
    fn datasets_are_columns_named_by_their_paths() {
        for bytes in [H5, MAT] {
            let table = table(bytes).unwrap();
            let value = |name: &str, row: usize| {
                table.column(name).unwrap_or_else(|| panic!("{:?}", table.names())).values[row]
            };
            assert_eq!((value("time", 30), value("robot.q[0]", 30), value("robot.q[1]", 30)), (0.3, 30.0, -30.0));
            assert_eq!((value("robot.tau[1]", 59), value("counter", 59)), (59.5, 59.0));
            assert_eq!((table.runs.len(), table.runs[0].clone()), (1, 0..60));
        }
    }

    /// Runs of 30 and 20 samples in groups of their own, written by h5py.
    const RUNS: &[u8] = include_bytes!("../../../../tests/data/runs.h5");
    /// A table whose rows have fields, in chunks with gzip.
    const ROWS: &[u8] = include_bytes!("../../../../tests/data/rows.h5");

    #[test]
    fn groups_may_be_runs() {
        let table = table(RUNS).unwrap();
        assert_eq!(
            (table.runs.as_slice(), table.run_names.as_deref().unwrap()),
            (&[0..30, 30..50][..], &["demo_2", "demo_10"].map(str::to_owned)[..])
        );
        assert_eq!(table.names(), ["obs.q[0]", "obs.q[1]", "obs.tau[0]", "obs.tau[1]", "t"]);
        let value = |name: &str, row: usize| table.column(name).unwrap().values[row];
        assert_eq!((value("obs.q[1]", 29), value("obs.q[0]", 30), value("obs.tau[0]", 49)), (-27.0, 10.0, 19.5));
        assert_eq!(table.constants["data.gear"].as_slice().unwrap(), [50.0, 80.0]);
        assert_eq!(table.passed_over, ["`data.demo_2.notes` (not in every run)"]);
    }

    #[test]
    fn a_table_of_rows_has_a_column_for_each_field() {
        let table = table(ROWS).unwrap();
        let names = [
            "robot.log.stamp",
            "robot.log.q[0]",
            "robot.log.q[1]",
            "robot.log.tau[0]",
            "robot.log.tau[1]",
            "robot.log.count",
        ];
        assert_eq!(table.names(), names);
        let value = |name: &str, row: usize| table.column(name).unwrap().values[row];
        assert_eq!(
            (value(names[0], 39), value(names[2], 17), value(names[4], 3), value(names[5], 5)),
            (0.39, -17.0, 3.5, -5.0)
        );
    }

    #[test]
    fn cut_and_damaged_files_are_errors_and_never_more() {
        for (whole, place) in
            [RUNS, ROWS].iter().flat_map(|whole| (8..whole.len()).step_by(29).map(move |place| (whole, place)))
        {
            let mut damaged = whole.to_vec();
            damaged[place] ^= 0xff;
            let _ = table(&damaged);
            let _ = table(&whole[..place]);
        }
        for end in (8..H5.len()).step_by(61) {
            let _ = table(&H5[..end]);
        }
        assert!(table(&H5[..H5.len() / 3]).unwrap_err().to_string().contains("copy the file again"));
        for place in (8..H5.len()).step_by(13) {
            let mut damaged = H5.to_vec();
            damaged[place] ^= 0xff;
            let _ = table(&damaged);
        }
    }
}
