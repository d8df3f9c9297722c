//! What every reader makes of its file: columns with names, one number a sample.

use std::collections::BTreeMap;
use std::ops::Range;

use ndarray::ArrayD;

use super::clocks::Told;
use super::topics::SeenTopic;

/// More columns are not believed: each takes memory, and its name is compared with others.
pub(super) const MOST_COLUMNS: usize = 10_000;

/// Columns of equal length, one row a sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Table {
    pub columns: Vec<Column>,
    /// Rows of each run; most files hold one.
    pub runs: Vec<Range<usize>>,
    /// Where its rows stood before some were left out: all of them and the runs then.
    pub before: Option<(Vec<usize>, Vec<Range<usize>>)>,
    /// Names of the runs, where the file states them.
    pub run_names: Option<Vec<String>>,
    /// Line of the file that each row stands on, for text files.
    pub lines: Option<Lines>,
    /// Where the last row stands, in words, if the text ends without ending that line; one for each file.
    pub broken_off: Vec<String>,
    /// Time between rows \[s\], where the file states it apart from a time column.
    pub step: Option<f64>,
    /// Numbers of the file that hold for all samples, such as gear ratios; a mapping may name them.
    pub constants: BTreeMap<String, ArrayD<f64>>,
    /// Names of the joints, base first, where the file states them.
    pub joints: Option<Vec<String>>,
    /// What is to be said of the clocks of a log of messages.
    pub clocks: Vec<Told>,
    /// The topics of a log of messages.
    pub topics: Vec<SeenTopic>,
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

/// On which line of a file each row stands. Nearly always that is the one below the row before, so only the others are kept.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Lines {
    /// Rows that stand elsewhere, with their lines.
    elsewhere: Vec<(usize, u64)>,
    rows: usize,
}

impl Lines {
    /// The next row, which stands on this line.
    pub fn push(&mut self, line: u64) {
        if self.rows == 0 || self.at(self.rows) != line {
            self.elsewhere.push((self.rows, line));
        }
        self.rows += 1;
    }

    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.rows
    }

    /// The line of a row, and of the rows behind the last one as if they followed it.
    pub fn at(&self, row: usize) -> u64 {
        let before = self.elsewhere.partition_point(|(start, _)| *start <= row);
        let (start, line) = before.checked_sub(1).map_or((0, 0), |index| self.elsewhere[index]);
        line + (row - start) as u64
    }
}

/// Parts of a file for a message; a long list is cut, and says so.
pub(super) fn listed(parts: &[String]) -> String {
    const MOST: usize = 30;
    let shown = parts.iter().take(MOST).map(String::as_str).collect::<Vec<_>>().join("; ");
    if parts.len() > MOST { format!("{shown} and {} more", parts.len() - MOST) } else { shown }
}

impl Table {
    /// What the run of a row is called.
    pub fn run_name(&self, row: usize) -> Option<&str> {
        let run = self.runs.iter().position(|run| run.contains(&row))?;
        self.run_names.as_ref()?.get(run).map(String::as_str)
    }

    pub fn names(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.name.clone()).collect()
    }

    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    pub fn column_mut(&mut self, name: &str) -> Option<&mut Column> {
        self.columns.iter_mut().find(|column| column.name == name)
    }

    /// Leaves out the last row of a table of one run; false if it has several.
    pub fn drop_last_row(&mut self) -> bool {
        let [run] = self.runs.as_mut_slice() else { return false };
        run.end -= 1;
        self.broken_off.clear();
        self.columns.iter_mut().for_each(|column| column.values.truncate(run.end));
        true
    }

    /// Where a row stands, in words.
    pub fn place(&self, row: usize) -> String {
        let (row, runs) = match &self.before {
            Some((rows, runs)) => (rows[row], runs),
            None => (row, &self.runs),
        };
        if let Some(lines) = &self.lines {
            return format!("line {}", lines.at(row));
        }
        match runs.iter().position(|run| run.contains(&row)) {
            Some(run) if runs.len() > 1 => format!("sample {} of run {}", row - runs[run].start, run + 1),
            _ => format!("sample {row}"),
        }
    }

    /// Leaves out rows, which are told in their order, once the columns were taken out of it.
    pub fn leave_out(&mut self, rows: &[usize]) {
        let count = self.runs.last().map_or(0, |run| run.end);
        let kept = (0..count).filter(|row| rows.binary_search(row).is_err()).collect();
        let runs = self.runs_without(rows);
        self.before = Some((kept, std::mem::replace(&mut self.runs, runs)));
    }

    /// The runs, once rows are left out that are told in their order.
    pub fn runs_without(&self, rows: &[usize]) -> Vec<Range<usize>> {
        let now = |row: usize| row - rows.partition_point(|left_out| *left_out < row);
        self.runs.iter().map(|run| now(run.start)..now(run.end)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_rows_are_known_though_few_are_kept() {
        let mut lines = Lines::default();
        let all = [2, 3, 4, 7, 8, 20, 22];
        all.iter().for_each(|line| lines.push(*line));
        assert_eq!((0..all.len()).map(|row| lines.at(row)).collect::<Vec<_>>(), all);
        assert_eq!((lines.len(), lines.elsewhere.len()), (7, 4));
    }

    #[test]
    fn rows_are_found_where_they_stood_before_others_were_left_out() {
        let mut table = Table { runs: vec![0..4, 4..8], ..Table::default() };
        table.leave_out(&[1, 4, 6]);
        assert_eq!(table.runs, [0..3, 3..5]);
        let places: Vec<String> = (0..5).map(|row| table.place(row)).collect();
        let all =
            ["sample 0 of run 1", "sample 2 of run 1", "sample 3 of run 1", "sample 1 of run 2", "sample 3 of run 2"];
        assert_eq!(places, all);
    }

    #[test]
    fn a_long_list_is_cut() {
        assert_eq!(listed(&["a".to_owned(), "b".to_owned()]), "a; b");
        assert!(listed(&vec!["a".to_owned(); 100]).ends_with("a and 70 more"));
    }
}
