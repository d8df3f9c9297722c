//! A table of named columns, for results that other programs are to read.

use std::fmt::Write as _;
use std::io::{Cursor, Write};
use std::ops::Range;

use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

use super::npy;
use super::write::{Form, WriteError, mcap, parquet};
use crate::signals::Signals;

/// Columns of equal length, in the order in which they were begun.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    /// Appends values to a column, which is begun if it is new.
    pub fn extend(&mut self, name: &str, values: &[f64]) {
        match self.columns.iter_mut().find(|(other, _)| other == name) {
            Some((_, column)) => column.extend_from_slice(values),
            None => self.columns.push((name.to_owned(), values.to_vec())),
        }
    }

    /// Appends to one column per joint: `name1`, `name2`, …; a single signal keeps the plain name.
    pub fn extend_joints(&mut self, name: &str, signal: &Signals) {
        if signal.joint_count() == 1 {
            return self.extend(name, &signal[0]);
        }
        for (joint, values) in signal.iter().enumerate() {
            self.extend(&format!("{name}{}", joint + 1), values);
        }
    }

    /// Appends rows of another table to the columns of the same names.
    pub fn extend_rows(&mut self, other: &Table, rows: Range<usize>) {
        for (name, values) in &other.columns {
            self.extend(name, &values[rows.clone()]);
        }
    }

    /// Names of the columns.
    pub fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// How many rows it has: those of its longest column.
    pub fn row_count(&self) -> usize {
        self.columns.iter().map(|(_, values)| values.len()).max().unwrap_or(0)
    }

    /// As a file of this form.
    ///
    /// # Errors
    /// [`WriteError`]
    pub fn to_bytes(&self, form: Form) -> Result<Vec<u8>, WriteError> {
        match form {
            Form::Npz => self.to_npz_bytes(),
            Form::Csv => Ok(self.to_csv_bytes()),
            Form::Parquet => Ok(parquet::table(&self.columns)?),
            Form::Mcap => mcap::table(&self.columns),
        }
    }

    /// One array of f64 per column.
    ///
    /// # Errors
    /// [`WriteError`] if the archive can't be made, which memory never refuses.
    pub fn to_npz_bytes(&self) -> Result<Vec<u8>, WriteError> {
        let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, values) in &self.columns {
            archive.start_file(format!("{name}.npy"), options)?;
            archive.write_all(&npy::encode("<f8", &[values.len()], values.iter().flat_map(|v| v.to_le_bytes())))?;
        }
        Ok(archive.finish()?.into_inner())
    }

    /// A header and one line per row, with as many digits as it takes to read the same numbers back.
    pub fn to_csv_bytes(&self) -> Vec<u8> {
        let mut text = self.names().join(",");
        text.push('\n');
        for row in 0..self.row_count() {
            for (number, (_, values)) in self.columns.iter().enumerate() {
                let comma = if number > 0 { "," } else { "" };
                // Writing to a String can't fail.
                let _ = match values.get(row) {
                    Some(value) => write!(text, "{comma}{value:?}"),
                    None => write!(text, "{comma}"),
                };
            }
            text.push('\n');
        }
        text.into_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::recording::read::{ReadOptions, preview};

    #[test]
    fn columns_grow_and_are_written_in_order() {
        let mut table = Table::default();
        for _ in 0..2 {
            table.extend("time", &[0.5]);
            table.extend_joints("tau", &Signals::from_samples(2, &[1.0, -0.25]));
        }
        assert_eq!(String::from_utf8(table.to_csv_bytes()).unwrap(), "time,tau1,tau2\n0.5,1.0,-0.25\n0.5,1.0,-0.25\n");
    }

    #[test]
    fn a_table_is_read_back_from_every_form() {
        let mut table = Table::default();
        for trajectory in [1.0, 2.0] {
            table.extend("trajectory", &[trajectory; 20]);
            table.extend("time", &(0..20).map(|sample| 0.01 * f64::from(sample)).collect::<Vec<_>>());
            for name in ["q", "tau_measured", "coulomb-friction@1"] {
                table.extend(name, &(0..20).map(|sample| (trajectory + f64::from(sample)).sin()).collect::<Vec<_>>());
            }
        }
        let folder = tempfile::tempdir().unwrap();
        for form in Form::ALL {
            let path = folder.path().join(format!("table.{}", form.ending()));
            std::fs::write(&path, table.to_bytes(form).unwrap()).unwrap();
            let seen = preview(&path, &ReadOptions::default(), &Monitor::new()).unwrap();
            let name = if form == Form::Mcap { "coulomb_friction_1" } else { "coulomb-friction@1" };
            let column = seen.columns.iter().find(|column| column.name == name);
            let column = column.unwrap_or_else(|| panic!("{form:?}: {:?}", seen.names()));
            assert_eq!(column.values, table.columns[4].1, "{form:?}");
        }
    }

    #[test]
    fn rows_of_another_table_go_to_the_columns_of_their_names() {
        let mut table = Table::default();
        table.extend("t", &[0.0, 1.0]);
        table.extend("q", &[5.0, 6.0]);
        let mut other = Table::default();
        other.extend("q", &[7.0, 8.0, 9.0]);
        other.extend("t", &[2.0, 3.0, 4.0]);
        table.extend_rows(&other, 1..3);
        assert_eq!((table.names(), table.row_count()), (vec!["t", "q"], 4));
        assert_eq!(table.columns[0].1, [0.0, 1.0, 3.0, 4.0]);
        assert_eq!(table.columns[1].1, [5.0, 6.0, 8.0, 9.0]);
    }
}
