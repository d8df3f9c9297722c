//! What every reader makes of its file: columns with names, one number a sample.

use std::collections::BTreeMap;
use std::ops::Range;

use ndarray::ArrayD;

/// Columns of equal length, one row a sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Table {
    pub columns: Vec<Column>,
    /// Rows of each run; most files hold one.
    pub runs: Vec<Range<usize>>,
    /// Line of the file that each row stands on, for text files.
    pub lines: Option<Vec<u64>>,
    /// Line of the last row, where the text ends without ending that line.
    pub broken_off: Option<u64>,
    /// Time between rows \[s\], where the file states it apart from a time column.
    pub step: Option<f64>,
    /// Numbers of the file that hold for all samples, such as gear ratios; a mapping may name them.
    pub constants: BTreeMap<String, ArrayD<f64>>,
    /// Names of the joints, base first, where the file states them.
    pub joints: Option<Vec<String>>,
    /// Parts of the file that no column was made of, each with the reason.
    pub passed_over: Vec<String>,
    /// Of files side by side those whose last row was left out, because the others have one less.
    pub shortened: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    pub name: String,
    /// NaN where the file has no number.
    pub values: Vec<f64>,
    /// The first cell that holds text instead of a number.
    pub text: Option<TextCell>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct TextCell {
    pub line: u64,
    pub cell: String,
}

impl Table {
    pub fn names(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.name.clone()).collect()
    }

    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Leaves out the last row of a table of one run; false if it has several.
    pub fn drop_last_row(&mut self) -> bool {
        let [run] = self.runs.as_mut_slice() else { return false };
        run.end -= 1;
        self.columns.iter_mut().for_each(|column| column.values.truncate(run.end));
        if let Some(lines) = &mut self.lines {
            lines.truncate(run.end);
        }
        true
    }

    /// Where a row stands, in words.
    pub fn place(&self, row: usize) -> String {
        if let Some(line) = self.lines.as_ref().and_then(|lines| lines.get(row)) {
            return format!("line {line}");
        }
        match self.runs.iter().position(|run| run.contains(&row)) {
            Some(run) if self.runs.len() > 1 => format!("sample {} of run {}", row - self.runs[run].start, run + 1),
            _ => format!("sample {row}"),
        }
    }
}
