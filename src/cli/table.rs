//! Numbers and tables as text; what is printed can be had as a file, too.

use std::path::Path;
use std::sync::Mutex;

use anyhow::anyhow;

use super::failure::OrUsage;
use super::write_file;
use crate::figure::table::{Table, TableFormat, written};
use crate::file::ending::{listed, named};

/// The tables that were printed, if somebody wants them in a file.
static PRINTED: Mutex<Option<Vec<Table>>> = Mutex::new(None);

/// Where the tables of a command go beside the terminal.
pub struct TableFile<'a> {
    path: &'a Path,
    format: TableFormat,
}

impl<'a> TableFile<'a> {
    /// From here on the tables that are printed are kept for this file.
    pub fn keep(path: &'a Path) -> anyhow::Result<Self> {
        let problem = || {
            anyhow!("--table {}: its ending names no format, end it with {}", path.display(), listed(&TableFormat::ALL))
        };
        let format = named(&TableFormat::ALL, path).ok_or_else(problem).or_usage()?;
        *PRINTED.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(Vec::new());
        Ok(TableFile { path, format })
    }

    /// Writes what was printed.
    pub fn write(&self) -> anyhow::Result<()> {
        let tables = PRINTED.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).take().unwrap_or_default();
        if tables.is_empty() {
            return Err(anyhow!("--table: this command printed no table"));
        }
        write_file(self.path, written(&tables, self.format).as_bytes())
    }
}

/// A table under its title, as [`table`] makes it.
pub fn titled(title: &str, header: &[&str], rows: &[Vec<String>]) -> String {
    keep(title, header, rows);
    format!("{title}:\n{}", aligned(header, rows))
}

/// A table with aligned columns. Numbers are set flush right, text flush left: a column whose title starts with a space is
/// text, and so is the first one.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    keep("", header, rows);
    aligned(header, rows)
}

fn keep(title: &str, header: &[&str], rows: &[Vec<String>]) {
    let mut printed = PRINTED.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(tables) = printed.as_mut() else { return };
    let head = header.iter().map(|cell| cell.trim_start().to_owned()).collect();
    tables.push(Table { title: title.to_owned(), head, rows: rows.to_vec() });
}

fn aligned(header: &[&str], rows: &[Vec<String>]) -> String {
    let is_text: Vec<bool> =
        header.iter().enumerate().map(|(column, title)| column == 0 || title.starts_with(' ')).collect();
    let header: Vec<&str> = header.iter().map(|title| title.trim_start()).collect();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count());
        cells.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &[String]| {
        let cells = cells.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
            if is_text[column] { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let header: Vec<String> = header.iter().map(|cell| (*cell).to_owned()).collect();
    let mut lines = vec![line(&header)];
    lines.extend(rows.iter().map(|row| line(row)));
    lines.join("\n")
}

/// A number with four significant digits.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "–".to_owned();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    if (-2..=6).contains(&digits) { format!("{value:.*}", digits.max(0) as usize) } else { format!("{value:.3e}") }
}

/// Numbers of all joints.
pub fn numbers(values: &[f64]) -> String {
    values.iter().map(|&value| number(value)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!(["0", "1.234", "123.5", "0.01235", "1.235e-5", "1.235e6"].map(String::from).to_vec(), {
            [0.0, 1.234, 123.46, 0.012346, 1.2346e-5, 1234567.0].map(number).to_vec()
        });
    }

    #[test]
    fn columns_are_aligned() {
        let text = table(
            &["joint", "R²", " why"],
            &[vec!["1".into(), "0.5".into(), "so".into()], vec!["10".into(), "0.25".into(), "because".into()]],
        );
        assert_eq!(text, "joint    R²  why\n1       0.5  so\n10     0.25  because");
    }
}
