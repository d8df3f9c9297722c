//! Files with channels of the same samples, such as angles in one and currents in the other, put side by side.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::table::Table;

/// The files do not fit beside each other.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JoinError {
    /// Other samples.
    #[error(
        "`{first}` has {expected} samples and `{other}` {found}; files side by side must hold the same samples (one more at the \
         end is left out)"
    )]
    Length {
        /// Name of the first file.
        first: String,
        /// Its samples.
        expected: usize,
        /// Name of the other.
        other: String,
        /// Its samples.
        found: usize,
    },
    /// Other runs.
    #[error("`{first}` and `{other}` are cut into other runs; join files of one run")]
    Runs {
        /// Name of the first file.
        first: String,
        /// Name of the other.
        other: String,
    },
}

/// The files that a path such as `folder/angles.csv+folder/currents.csv` names; one if it names one.
pub(crate) fn parts(path: &Path) -> Vec<PathBuf> {
    path.to_string_lossy().split('+').filter(|part| !part.is_empty()).map(PathBuf::from).collect()
}

/// The path that names these files side by side.
pub fn path_of(files: &[PathBuf]) -> PathBuf {
    files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join("+").into()
}

/// One table of all columns. Columns of the same name are equal (a clock that all files have) and kept once, or they are
/// told apart by the name of their file: `currents.joint_1`.
/// A recorder that is stopped writes one file a row further than the other: that row is left out.
pub(super) fn side_by_side(mut tables: Vec<(String, Table)>) -> Result<Table, JoinError> {
    let shortened = shorten(&mut tables);
    let mut joined = Table { shortened, ..Table::default() };
    let mut values: BTreeMap<String, Vec<&[f64]>> = BTreeMap::new();
    for column in tables.iter().flat_map(|(_, table)| &table.columns) {
        values.entry(column.name.clone()).or_default().push(&column.values);
    }
    let same = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    let differ = |values: &Vec<&[f64]>| values.iter().any(|other| !same(values[0], other));
    let differing: BTreeSet<String> =
        values.into_iter().filter(|(_, values)| differ(values)).map(|(name, _)| name).collect();
    let mut first: Option<(String, usize)> = None;
    for (stem, table) in tables {
        let found = table.columns.first().map_or(0, |column| column.values.len());
        match &first {
            None => {
                first = Some((stem.clone(), found));
                (joined.runs, joined.step, joined.joints) = (table.runs, table.step, table.joints);
            }
            Some((first, expected)) if *expected != found => {
                let (first, expected) = (first.clone(), *expected);
                return Err(JoinError::Length { first, expected, other: stem, found });
            }
            Some((first, _)) if joined.runs != table.runs => {
                return Err(JoinError::Runs { first: first.clone(), other: stem });
            }
            Some(_) => {}
        }
        for mut column in table.columns {
            if differing.contains(&column.name) {
                column.name = format!("{stem}.{}", column.name);
            } else if joined.column(&column.name).is_some() {
                continue;
            }
            joined.columns.push(column);
        }
        joined.broken_off.extend(table.broken_off.into_iter().map(|place| format!("{place} of `{stem}`")));
        joined.constants.extend(table.constants);
        joined.passed_over.extend(table.passed_over);
    }
    Ok(joined)
}

/// Leaves out the last row of tables that have one more than the shortest, if none has more than that; names them.
fn shorten(tables: &mut [(String, Table)]) -> Vec<String> {
    let rows = |table: &Table| table.columns.first().map_or(0, |column| column.values.len());
    let shortest = tables.iter().map(|(_, table)| rows(table)).min().unwrap_or_default();
    let longest = tables.iter().map(|(_, table)| rows(table)).max().unwrap_or_default();
    if shortest < 2 || longest != shortest + 1 {
        return Vec::new();
    }
    let longer = tables.iter_mut().filter(|(_, table)| rows(table) == longest);
    longer.filter_map(|(stem, table)| table.drop_last_row().then(|| stem.clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    fn table(columns: &[(&str, &[f64])]) -> Table {
        let column = |&(name, values): &(&str, &[f64])| Column { name: name.into(), values: values.into(), text: None };
        let runs = std::iter::once(0..columns[0].1.len()).collect();
        Table { columns: columns.iter().map(column).collect(), runs, ..Table::default() }
    }

    #[test]
    fn equal_clocks_are_kept_once_and_equal_names_are_told_apart() {
        let angles = table(&[("time", &[0.0, 0.1]), ("Joint_1", &[1.0, 2.0])]);
        let currents = table(&[("time", &[0.0, 0.1]), ("Joint_1", &[5.0, 6.0]), ("volts", &[7.0, 8.0])]);
        let joined = side_by_side(vec![("angles".into(), angles), ("currents".into(), currents)]).unwrap();
        assert_eq!(joined.names(), ["time", "angles.Joint_1", "currents.Joint_1", "volts"]);
        assert_eq!(joined.column("currents.Joint_1").unwrap().values, [5.0, 6.0]);
    }

    #[test]
    fn files_of_other_length_are_refused_but_for_one_row_at_the_end() {
        let beside = |rows: &[f64]| {
            let q = table(&[("time", &[0.0, 0.1, 0.2, 0.3]), ("q", &[1.0, 2.0, 3.0, 4.0])]);
            let clock: Vec<f64> = (0..rows.len()).map(|row| [0.0, 0.1, 0.2, 0.3][row]).collect();
            side_by_side(vec![("a".into(), q), ("b".into(), table(&[("time", &clock), ("tau", rows)]))])
        };
        let message = beside(&[5.0, 6.0]).unwrap_err().to_string();
        assert!(message.contains("`a` has 4 samples and `b` 2"), "{message}");
        let joined = beside(&[5.0, 6.0, 7.0]).unwrap();
        assert_eq!(joined.names(), ["time", "q", "tau"], "clocks that are equal but for that row are one");
        assert_eq!((joined.columns[1].values.len(), joined.runs[0].clone()), (3, 0..3));
        assert_eq!(joined.shortened, ["a"]);
        assert_eq!(beside(&[5.0, 6.0, 7.0, 8.0]).unwrap().shortened, Vec::<String>::new());
    }

    #[test]
    fn a_file_that_is_broken_off_is_named_unless_its_last_row_is_left_out() {
        let beside = |rows: &[f64]| {
            let q = table(&[("q", &[1.0, 2.0, 3.0])]);
            let tau = Table { broken_off: vec!["line 4".into()], ..table(&[("tau", rows)]) };
            side_by_side(vec![("a".into(), q), ("b".into(), tau)]).unwrap().broken_off
        };
        assert_eq!(beside(&[1.0, 2.0, 3.0]), ["line 4 of `b`"]);
        assert!(beside(&[1.0, 2.0, 3.0, 4.0]).is_empty());
    }

    #[test]
    fn a_plus_separates_files() {
        assert_eq!(parts(Path::new("x/a.csv+y/b.csv")), [PathBuf::from("x/a.csv"), PathBuf::from("y/b.csv")]);
        assert_eq!(parts(Path::new("a.csv")).len(), 1);
    }
}
