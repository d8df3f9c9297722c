//! What a pickle holds, as a log: arrays by the keys of dicts, and runs where lists hold several.

use std::collections::{BTreeMap, BTreeSet};

use ndarray::{Array1, ArrayD, IxDyn};

use super::machine::{Id, Thing, text};
use super::{DEEPEST, PickleError};
use crate::progress::Monitor;
use crate::recording::read::arrays::{self, ArraysError, BYTES};
use crate::recording::read::budget::Budget;
use crate::recording::read::table::Table;

/// What an array takes beside its numbers \[bytes\].
const ARRAY: u64 = 160;

/// The arrays of a pickle on their way into a table.
pub(super) struct Log<'a, 'b> {
    things: &'a [Thing<'a>],
    arrays: Vec<(String, ArrayD<f64>)>,
    /// Lists of arrays that are not equally long: one array a run.
    runs: Vec<(String, Vec<ArrayD<f64>>)>,
    /// Lists of texts, which may name the runs.
    texts: Vec<Vec<String>>,
    passed_over: Vec<String>,
    budget: &'b mut Budget,
}

impl<'a, 'b> Log<'a, 'b> {
    /// Of these things, none of which is taken yet.
    pub(super) fn new(things: &'a [Thing<'a>], budget: &'b mut Budget) -> Self {
        Log { things, arrays: Vec::new(), runs: Vec::new(), texts: Vec::new(), passed_over: Vec::new(), budget }
    }

    /// Takes what has this name: one thing, or one for each run or sample.
    pub(super) fn take(&mut self, ids: &[Id], name: &str, depth: usize) -> Result<(), PickleError> {
        if depth > DEEPEST {
            return Err(PickleError::Deep);
        }
        self.budget.text(name)?;
        let dict = |id: &Id| match &self.things[*id] {
            Thing::Dict(dict) => Some(dict.as_slice()),
            _ => None,
        };
        if let Some(dicts) = ids.iter().map(dict).collect::<Option<Vec<_>>>().filter(|dicts| !dicts.is_empty()) {
            return self.take_dicts(&dicts, name, depth);
        }
        if let [id] = ids {
            match &self.things[*id] {
                Thing::List(items) if !items.is_empty() && items.iter().all(|item| dict(item).is_some()) => {
                    return self.take(items, name, depth + 1);
                }
                _ => {}
            }
        }
        let name = if name.is_empty() { "data" } else { name };
        let mut found = Vec::new();
        for id in ids {
            found.extend(self.values(*id, depth)?);
        }
        if found.is_empty() || found.len() < ids.len() {
            let texts = self.texts_of(ids)?;
            self.texts.extend(texts);
            self.passed_over.push(format!("`{name}` (no numbers)"));
            return Ok(());
        }
        match stacked(found) {
            Ok(array) => self.arrays.push((name.to_owned(), array)),
            Err(runs) => self.runs.push((name.to_owned(), runs)),
        }
        Ok(())
    }

    /// A list of different texts.
    fn texts_of(&mut self, ids: &[Id]) -> Result<Option<Vec<String>>, PickleError> {
        let things = self.things;
        let ids = match ids {
            [id] => match &things[*id] {
                Thing::List(items) => items,
                _ => return Ok(None),
            },
            several => several,
        };
        let mut texts = Vec::new();
        for id in ids {
            let Some(text) = text(&things[*id]) else { return Ok(None) };
            self.budget.text(&text)?;
            texts.push(text);
        }
        let different: BTreeSet<&String> = texts.iter().collect();
        Ok((different.len() == texts.len()).then_some(texts))
    }

    /// What dicts have under the same key belongs together.
    fn take_dicts(&mut self, dicts: &[&[(Id, Id)]], name: &str, depth: usize) -> Result<(), PickleError> {
        let mut entries: Vec<(String, Vec<Id>)> = Vec::new();
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        for (key, value) in dicts.iter().copied().flatten() {
            let key = match &self.things[*key] {
                Thing::Number(number) => number.to_string(),
                key => text(key).unwrap_or_default(),
            };
            self.budget.text(&key)?;
            let place = *places.entry(key.clone()).or_insert(entries.len());
            if place == entries.len() {
                entries.push((key, Vec::new()));
            }
            entries[place].1.push(*value);
        }
        for (key, values) in entries {
            let name = if name.is_empty() { key } else { format!("{name}.{key}") };
            self.take(&values, &name, depth + 1)?;
        }
        Ok(())
    }

    /// The arrays of a thing: its own, or one for each run; none where it holds no numbers.
    fn values(&mut self, id: Id, depth: usize) -> Result<Vec<ArrayD<f64>>, PickleError> {
        if depth > DEEPEST {
            return Err(PickleError::Deep);
        }
        Ok(match &self.things[id] {
            Thing::Number(number) => {
                self.budget.unpack(BYTES + ARRAY)?;
                vec![ArrayD::from_elem(IxDyn(&[]), *number)]
            }
            Thing::Array(header, bytes) => {
                self.budget.unpack((header.count() as u64).saturating_mul(BYTES) + ARRAY)?;
                let Thing::Bytes(bytes) = &self.things[*bytes] else { return Ok(Vec::new()) };
                let wrong = |problem| ArraysError::Array { array: "of the pickle".to_owned(), problem };
                vec![header.values(&mut &bytes[..]).map_err(wrong)?]
            }
            Thing::List(items) if items.iter().all(|item| matches!(self.things[*item], Thing::Number(_))) => {
                self.budget.unpack(items.len() as u64 * BYTES + ARRAY)?;
                let number = |item: &Id| match self.things[*item] {
                    Thing::Number(number) => number,
                    _ => f64::NAN,
                };
                vec![items.iter().map(number).collect::<Array1<f64>>().into_dyn()]
            }
            Thing::List(items) => {
                let mut all = Vec::new();
                for item in items {
                    let found = self.values(*item, depth + 1)?;
                    let [one] = <[ArrayD<f64>; 1]>::try_from(found).unwrap_or_else(|_| [ArrayD::zeros(IxDyn(&[0]))]);
                    if one.is_empty() {
                        return Ok(Vec::new());
                    }
                    all.push(one);
                }
                match stacked(all) {
                    Ok(array) => vec![array],
                    Err(runs) => runs,
                }
            }
            _ => Vec::new(),
        })
    }

    /// The columns of all that was taken.
    pub(super) fn table(mut self, monitor: &Monitor) -> Result<Table, PickleError> {
        monitor.check()?;
        let texts = std::mem::take(&mut self.texts);
        let mut table = self.columns()?;
        let count = table.runs.len();
        table.run_names = texts.into_iter().find(|names| count > 1 && names.len() == count);
        Ok(table)
    }

    fn columns(self) -> Result<Table, PickleError> {
        Ok(match self.runs.is_empty() {
            true => arrays::table(self.arrays, self.passed_over, self.budget)?,
            false => arrays::table_of_runs(self.runs, self.arrays, self.passed_over, self.budget)?,
        })
    }
}

/// Arrays of one shape as one with a first index more; a single one as it is; those of different shapes as they were.
fn stacked(mut arrays: Vec<ArrayD<f64>>) -> Result<ArrayD<f64>, Vec<ArrayD<f64>>> {
    if arrays.len() == 1 && arrays[0].ndim() > 0 {
        return Ok(arrays.remove(0));
    }
    let Some(first) = arrays.first() else { return Err(arrays) };
    if arrays.iter().any(|array| array.shape() != first.shape()) {
        return Err(arrays);
    }
    let shape = [&[arrays.len()], first.shape()].concat();
    let values: Vec<f64> = arrays.iter().flatten().copied().collect();
    ArrayD::from_shape_vec(IxDyn(&shape), values).map_err(|_| arrays)
}
