//! From named arrays to columns: what NPZ archives, NPY files and MATLAB files have in common.

use std::collections::BTreeMap;

use ndarray::{ArrayD, Axis};

use super::table::{Column, Table};
use crate::recording::npy::{self, NpyError};

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
    /// It would take too much memory.
    #[error("unpacked it takes more than {limit} MB; cut the log into several files, or raise the limit")]
    TooLarge {
        /// What is allowed \[MB\].
        limit: u64,
    },
}

fn also(passed_over: &[String]) -> String {
    if passed_over.is_empty() { String::new() } else { format!(" (passed over: {})", passed_over.join("; ")) }
}

/// What a number takes.
pub(super) const BYTES: u64 = 8;
/// Arrays with at most so many numbers are constants that a mapping may name, such as gear ratios.
const LARGEST_CONSTANT: usize = 64;

/// NPY arrays on their way into a table, with the memory that they may still take.
#[derive(Default)]
pub(super) struct Gathered {
    pub arrays: Vec<(String, ArrayD<f64>)>,
    pub passed_over: Vec<String>,
    left: u64,
    limit: u64,
}

impl Gathered {
    /// Nothing yet; all arrays together may take `limit` bytes.
    pub fn within(limit: u64) -> Self {
        Gathered { left: limit, limit, ..Gathered::default() }
    }

    /// Whether so many bytes more may be taken.
    pub fn check(&self, size: u64) -> Result<(), ArraysError> {
        if size > self.left { Err(ArraysError::TooLarge { limit: self.limit >> 20 }) } else { Ok(()) }
    }

    /// Takes an array from the bytes of an NPY file; what holds no numbers is passed over.
    pub fn take(&mut self, array: String, bytes: &[u8]) -> Result<(), ArraysError> {
        match npy::decode(bytes, (self.left / BYTES) as usize) {
            Ok(values) => {
                self.left = self.left.saturating_sub(values.len() as u64 * BYTES);
                self.arrays.push((array, values));
                Ok(())
            }
            Err(NpyError::TooLarge) => Err(ArraysError::TooLarge { limit: self.limit >> 20 }),
            Err(NpyError::NotNumbers(reason)) => {
                self.passed_over.push(format!("`{array}` ({reason})"));
                Ok(())
            }
            Err(problem) => Err(ArraysError::Array { array, problem }),
        }
    }

    /// The columns of the arrays.
    pub fn table(self) -> Result<Table, ArraysError> {
        table(self.arrays, self.passed_over, self.limit)
    }
}

/// How many runs, and how many samples in each.
type Extent = (usize, usize);

/// How an array may be read: (samples), (samples, joints) or (runs, samples, joints).
fn extent(shape: &[usize]) -> Option<Extent> {
    match *shape {
        [samples] | [samples, _] => Some((1, samples)),
        [runs, samples, _] => Some((runs, samples)),
        _ => None,
    }
}

/// Columns of the arrays that share the extent which most of them have; the others are passed over.
pub(super) fn table(
    arrays: Vec<(String, ArrayD<f64>)>,
    mut passed_over: Vec<String>,
    limit: u64,
) -> Result<Table, ArraysError> {
    let step = arrays.iter().find_map(|(name, array)| stated_step(name, array));
    let mut votes: BTreeMap<Extent, usize> = BTreeMap::new();
    // An array without elements may claim any extent.
    let full = arrays.iter().filter(|(_, array)| array.len() > 1);
    // Constants do not outvote signals, however many there are.
    let signals = full.clone().any(|(_, array)| array.len() > LARGEST_CONSTANT);
    let full = full.filter(|(_, array)| !signals || array.len() > LARGEST_CONSTANT);
    for extent in full.filter_map(|(_, array)| extent(array.shape())) {
        *votes.entry(extent).or_default() += 1;
    }
    let winner = votes.into_iter().max_by_key(|&((runs, samples), votes)| (votes, runs.saturating_mul(samples)));
    let Some(((runs, samples), _)) = winner else {
        return Err(ArraysError::None(passed_over));
    };
    let rows = runs * samples;
    let mut table =
        Table { runs: (0..runs).map(|run| run * samples..(run + 1) * samples).collect(), step, ..Table::default() };
    for (name, array) in arrays {
        // One clock for many runs takes its memory once for each.
        if (table.columns.len() as u64 + 1).saturating_mul(rows as u64).saturating_mul(BYTES) > limit {
            return Err(ArraysError::TooLarge { limit: limit >> 20 });
        }
        let column = |name, values| Column { name, values, text: None };
        match *array.shape() {
            [own] if own == samples => {
                // One clock for all runs.
                let repeated = array.iter().copied().cycle().take(rows).collect();
                table.columns.push(column(name, repeated));
            }
            [first, second] if runs > 1 && (first, second) == (runs, samples) => {
                table.columns.push(column(name, array.into_iter().collect()))
            }
            [.., width] if array.ndim() > 1 && extent(array.shape()) == Some((runs, samples)) => {
                for joint in 0..width {
                    let values = array.index_axis(Axis(array.ndim() - 1), joint).iter().copied().collect();
                    table.columns.push(column(format!("{name}[{joint}]"), values));
                }
            }
            _ if stated_step(&name, &array).is_some() => {}
            _ if array.len() <= LARGEST_CONSTANT => {
                table.constants.insert(name, array);
            }
            _ => passed_over.push(format!("`{name}` (its shape is {:?})", array.shape())),
        }
    }
    table.passed_over = passed_over;
    Ok(table)
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
