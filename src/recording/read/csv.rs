//! Numbers as text: comma, semicolon, tab or blanks between them, with or without header, comments, quotes, decimal
//! commas and a row of units.

use std::borrow::Cow;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::budget::{Budget, TooMuch};
use super::table::{Column, Lines, MOST_COLUMNS, Table, TextCell};
use super::text::{Text, TextError};
use crate::recording::mapping::unit_named;

/// The text is not a table of numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CsvError {
    /// Nothing but blanks and comments.
    #[error("it holds no line of data")]
    Empty,
    /// Column names, but no sample.
    #[error("it has column names (line {line}), but no sample below them; perhaps the recording was broken off")]
    HeaderOnly {
        /// Where the names stand.
        line: u64,
    },
    /// A row with too few or too many cells.
    #[error(
        "line {line} has {found} cells, but the lines before have {expected}; mend or delete this line \
         (a log that was broken off often ends so)"
    )]
    Ragged {
        /// Where it stands.
        line: u64,
        /// How many cells it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// More cells in a line than any log has.
    #[error("line {line} has more than {MOST_COLUMNS} cells; a log has one column a channel, one line a sample")]
    TooWide {
        /// The line.
        line: u64,
    },
    /// Words, not numbers.
    #[error(
        "it is text, but line {line} below the first holds no number; a log has one column a channel, one line a sample"
    )]
    NoNumbers {
        /// The line.
        line: u64,
    },
    /// It can't be read on.
    #[error(transparent)]
    Text(#[from] TextError),
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
}

/// What a number takes \[bytes\].
const NUMBER: u64 = size_of::<f64>() as u64;

/// One line of cells, with its number in the file.
struct Row {
    line: u64,
    /// The cells, one behind the other.
    bytes: Vec<u8>,
    /// Where each of them ends.
    ends: Vec<usize>,
    count: usize,
}

impl Row {
    /// With room for as many cells as any log has, for one too many, and for what ends them.
    fn new() -> Row {
        Row { line: 0, bytes: vec![0; 1 << 10], ends: vec![0; MOST_COLUMNS + 2], count: 0 }
    }

    fn len(&self) -> usize {
        self.count
    }

    /// The cells without blanks around them.
    fn cells(&self) -> impl DoubleEndedIterator<Item = &[u8]> + ExactSizeIterator {
        let start = |cell: usize| if cell == 0 { 0 } else { self.ends[cell - 1] };
        (0..self.count).map(move |cell| self.bytes[start(cell)..self.ends[cell]].trim_ascii())
    }

    /// What stands in each cell; what is no UTF-8 is shown as such.
    fn texts(&self) -> impl ExactSizeIterator<Item = Cow<'_, str>> {
        self.cells().map(String::from_utf8_lossy)
    }

    /// How many lines it goes on for: cells between quotes may have some.
    fn breaks(&self) -> u64 {
        let end = self.count.checked_sub(1).map_or(0, |last| self.ends[last]);
        self.bytes[..end].iter().filter(|byte| **byte == b'\n').count() as u64
    }
}

/// What stands between two cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Delimiter {
    Byte(u8),
    Blanks,
}

/// Reads a text. Columns without a header are named `c1`, `c2`, …
pub(super) fn read(text: &mut Text, budget: &mut Budget) -> Result<Table, CsvError> {
    let head = text.first_lines()?;
    let delimiter = sniff_delimiter(head);
    let comment = last_comment(head);
    let decimal_comma = delimiter != Delimiter::Byte(b',');
    let number = |cell: &str| parse(cell, decimal_comma);

    let (line_count, size) = (text.line_count()?, text.size());
    let (mut rows, mut row) = (Rows::new(text, delimiter), Row::new());
    if !rows.next(&mut row)? {
        return Err(CsvError::Empty);
    }
    let (names_line, width) = (row.line, row.len());
    let is_header = row.texts().any(|cell| number(&cell).is_none());
    let names = if is_header {
        row.texts().map(Cow::into_owned).collect()
    } else {
        let names = comment.and_then(|comment| names_in(&comment, delimiter, width));
        names.unwrap_or_else(|| (1..=width).map(|number| format!("c{number}")).collect())
    };
    let mut more = !is_header || rows.next(&mut row)?;
    names.iter().try_for_each(|name| budget.name(name))?;
    // Room that is found out bit by bit would be taken twice; no cell is shorter than its number and what ends it.
    let most = size.map_or(0, |size| size as usize / (2 * width) + 1);
    let room = line_count.unwrap_or(0).min(most);
    let column = |name: String| Column { name, values: Vec::with_capacity(room), text: None };
    let mut table = Table { columns: names.into_iter().map(column).collect(), ..Table::default() };
    if is_header && more && is_row_of_units(&row, width) {
        for (column, unit) in table.columns.iter_mut().zip(row.texts()) {
            if !unit.is_empty() {
                column.name = format!("{}[{}]", column.name, unit.trim_matches(['[', ']', '(', ')']));
            }
        }
        more = rows.next(&mut row)?;
    }

    let mut lines = Lines::default();
    while more {
        // A delimiter at the end of each row, but not of the header, is common and harmless.
        if row.len() == width + 1 && row.cells().next_back().is_some_and(<[u8]>::is_empty) {
            row.count = width;
        }
        if lines.len() == 0 && row.texts().all(|cell| number(&cell).is_none()) {
            return Err(CsvError::NoNumbers { line: row.line });
        }
        if row.len() != width {
            return Err(CsvError::Ragged { line: row.line, found: row.len(), expected: width });
        }
        budget.unpack(NUMBER * width as u64)?;
        for (column, cell) in table.columns.iter_mut().zip(row.texts()) {
            let value = number(&cell);
            column.values.push(value.unwrap_or(f64::NAN));
            if value.is_none() && column.text.is_none() {
                column.text = Some(TextCell { line: row.line, cell: cell.into_owned() });
            }
        }
        lines.push(row.line);
        more = rows.next(&mut row)?;
    }
    if lines.len() == 0 {
        return Err(CsvError::HeaderOnly { line: names_line });
    }
    table.runs = std::iter::once(0..lines.len()).collect();
    if rows.text.ends_within_a_line() {
        table.broken_off.push(format!("line {}", lines.at(lines.len() - 1)));
    }
    table.lines = Some(lines);
    Ok(table)
}

/// A cell as a number; an empty one, or one that says that there is no value, is NaN. `None` if it is text.
fn parse(cell: &str, decimal_comma: bool) -> Option<f64> {
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    if cell.is_empty()
        || ["na", "n/a", "null", "none", "-nan", "nan(ind)", "-nan(ind)"].contains(&cell.to_lowercase().as_str())
    {
        return Some(f64::NAN);
    }
    let one_comma = decimal_comma && !cell.contains('.') && cell.matches(',').count() == 1;
    one_comma.then(|| cell.replace(',', ".").parse().ok()).flatten()
}

fn is_row_of_units(row: &Row, width: usize) -> bool {
    let is_unit = |cell: Cow<str>| {
        let bare = cell.trim_matches(['[', ']', '(', ')']);
        ["", "-", "1", "a", "v", "bool"].contains(&bare.to_lowercase().as_str()) || unit_named(bare).is_some()
    };
    row.len() == width
        && row.texts().all(is_unit)
        && row.texts().any(|cell| cell.parse::<f64>().is_err())
        && row.texts().any(|cell| !cell.is_empty())
}

/// The last comment above the data.
fn last_comment(head: &[u8]) -> Option<String> {
    let comments =
        head.split(|byte| *byte == b'\n').take_while(|line| line.starts_with(b"#") || line.trim_ascii().is_empty());
    let last = comments.filter(|line| line.starts_with(b"#")).last()?;
    Some(String::from_utf8_lossy(last).into_owned())
}

/// Names in a comment right above the data, as `numpy.savetxt` writes them.
fn names_in(comment: &str, delimiter: Delimiter, width: usize) -> Option<Vec<String>> {
    let text = comment.trim_start_matches('#').trim();
    let names: Vec<&str> = match delimiter {
        Delimiter::Byte(byte) => text.split(char::from(byte)).map(str::trim).take(width + 1).collect(),
        Delimiter::Blanks => text.split_whitespace().take(width + 1).collect(),
    };
    let all_names = names.iter().all(|name| !name.is_empty() && name.parse::<f64>().is_err());
    (names.len() == width && all_names).then(|| names.into_iter().map(str::to_owned).collect())
}

/// The delimiter by which most of the first lines have the same number of cells, at least two.
fn sniff_delimiter(bytes: &[u8]) -> Delimiter {
    const LOOKED_AT: usize = 50;
    let lines: Vec<&[u8]> = bytes
        .split(|byte| *byte == b'\n')
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"))
        .take(LOOKED_AT)
        .collect();
    let agreeing = |delimiter: u8| {
        let counts: Vec<usize> =
            lines.iter().map(|line| line.iter().filter(|byte| **byte == delimiter).count()).collect();
        // The header may count otherwise (commas in names), so the lines below it decide where there are any.
        let counts = if counts.len() > 2 { &counts[1..] } else { &counts[..] };
        let usual = counts.iter().max_by_key(|count| counts.iter().filter(|other| other == count).count());
        let usual = usual.copied().filter(|usual| *usual > 0);
        usual.map_or(0, |usual| 10 * counts.iter().filter(|count| **count == usual).count() / counts.len())
    };
    // A semicolon or a tab is hardly ever anything else; a comma may be a decimal one.
    let chosen = [b';', b'\t', b','].into_iter().find(|delimiter| agreeing(*delimiter) >= 8);
    let chosen = chosen.or_else(|| [b';', b'\t', b','].into_iter().find(|delimiter| agreeing(*delimiter) > 0));
    let blanks = |line: &&[u8]| line.iter().any(|byte| byte.is_ascii_whitespace());
    match chosen {
        // Decimal commas between blanks: cells that were cut at the commas would still hold two numbers.
        Some(b',') if between_blanks_are_numbers(&lines) => Delimiter::Blanks,
        Some(byte) => Delimiter::Byte(byte),
        None if lines.iter().skip(1).any(blanks) || lines.len() == 1 && lines.iter().any(blanks) => Delimiter::Blanks,
        None => Delimiter::Byte(b','),
    }
}

/// Whether the last line is `0,1 0,2 0,3`: numbers between blanks, each with at most one comma inside.
fn between_blanks_are_numbers(lines: &[&[u8]]) -> bool {
    let Some(line) = lines.last().and_then(|line| std::str::from_utf8(line).ok()) else { return false };
    let cells: Vec<&str> = line.split_whitespace().collect();
    let inside = |cell: &str| !cell.starts_with(',') && !cell.ends_with(',') && parse(cell, true).is_some();
    cells.len() > 1 && cells.iter().all(|cell| inside(cell))
}

/// The rows of a text without comments and empty lines.
struct Rows<'a, 'b> {
    text: &'a mut Text<'b>,
    cells: Cells,
}

/// What cuts a line into cells.
enum Cells {
    Delimited(Box<Reader>),
    /// The line that is cut, with its number.
    Blanks(Vec<u8>, u64),
}

impl<'a, 'b> Rows<'a, 'b> {
    fn new(text: &'a mut Text<'b>, delimiter: Delimiter) -> Self {
        let cells = match delimiter {
            Delimiter::Blanks => Cells::Blanks(Vec::new(), 0),
            Delimiter::Byte(byte) => {
                Cells::Delimited(Box::new(ReaderBuilder::new().delimiter(byte).comment(Some(b'#')).build()))
            }
        };
        Rows { text, cells }
    }

    /// Reads the next row into this one; false if there is none.
    fn next(&mut self, row: &mut Row) -> Result<bool, CsvError> {
        loop {
            let is_there = match &mut self.cells {
                Cells::Delimited(reader) => delimited(self.text, reader, row)?,
                Cells::Blanks(line, number) => between_blanks(self.text, line, number, row)?,
            };
            if !is_there {
                return Ok(false);
            }
            if row.len() > MOST_COLUMNS {
                return Err(CsvError::TooWide { line: row.line });
            }
            if row.cells().any(|cell| !cell.is_empty()) {
                return Ok(true);
            }
        }
    }
}

/// The next row, whose cells a byte divides; false if there is none.
fn delimited(text: &mut Text, reader: &mut Reader, row: &mut Row) -> Result<bool, CsvError> {
    let (mut written, mut ended) = (0, 0);
    loop {
        let rest = text.rest()?;
        let (result, used, more, ends) = reader.read_record(rest, &mut row.bytes[written..], &mut row.ends[ended..]);
        let is_line_ended = rest[..used].ends_with(b"\n");
        text.take(used);
        (written, ended) = (written + more, ended + ends);
        match result {
            ReadRecordResult::InputEmpty => {}
            ReadRecordResult::OutputFull => row.bytes.resize(2 * row.bytes.len(), 0),
            ReadRecordResult::OutputEndsFull => return Err(CsvError::TooWide { line: reader.line() }),
            ReadRecordResult::End => return Ok(false),
            ReadRecordResult::Record => {
                row.count = ended;
                // The reader stands where the next line begins, or at the end of the last one.
                row.line = reader.line() - u64::from(is_line_ended) - row.breaks();
                return Ok(true);
            }
        }
    }
}

/// The next row, whose cells stand between blanks; false if there is none.
fn between_blanks(text: &mut Text, line: &mut Vec<u8>, number: &mut u64, row: &mut Row) -> Result<bool, CsvError> {
    loop {
        line.clear();
        let is_there = next_line(text, line)?;
        *number += 1;
        if !is_there {
            return Ok(false);
        }
        if !line.trim_ascii_start().starts_with(b"#") {
            break;
        }
    }
    (row.line, row.count) = (*number, 0);
    row.bytes.clear();
    let cells = line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty());
    for cell in cells.take(MOST_COLUMNS + 1) {
        let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
        row.bytes.extend(cell.strip_suffix(b"\"").unwrap_or(cell));
        row.ends[row.count] = row.bytes.len();
        row.count += 1;
    }
    Ok(true)
}

/// Adds the next line without its end; false if there is none.
fn next_line(text: &mut Text, line: &mut Vec<u8>) -> Result<bool, CsvError> {
    loop {
        let rest = text.rest()?;
        if rest.is_empty() {
            return Ok(!line.is_empty());
        }
        let end = rest.iter().position(|byte| *byte == b'\n');
        line.extend(&rest[..end.unwrap_or(rest.len())]);
        let taken = end.map_or(rest.len(), |end| end + 1);
        text.take(taken);
        if end.is_some() {
            return Ok(true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Table, CsvError> {
        let size = text.len() as u64;
        read(&mut Text::plain(Box::new(text.as_bytes()), size), &mut Budget::of(size, 1 << 30))
    }

    fn table(text: &str) -> Table {
        read_text(text).unwrap()
    }

    fn problem(text: &str) -> CsvError {
        read_text(text).unwrap_err()
    }

    /// Looking for the end of a line in all the rest of the text, for each line, would take minutes here.
    #[test]
    fn lines_that_end_with_a_carriage_return_alone_are_lines_like_others() {
        let rows = 300_000;
        let text = "t,q1\r".to_owned() + &"0.5,-1.25\r".repeat(rows) + "0.5,x\r";
        let table = table(&text);
        assert_eq!(table.runs, std::iter::once(0..rows + 1).collect::<Vec<_>>());
        assert_eq!(table.columns[1].text.as_ref().map(|cell| cell.line), Some(rows as u64 + 2));
    }

    /// Looking through all blank lines below, for each of them, would take minutes here.
    #[test]
    fn lines_of_blanks_are_passed_over_in_linear_time() {
        let text = "t,q1\n".to_owned() + &" \n".repeat(1_000_000) + "0.5,-1.25\n";
        let table = table(&text);
        assert_eq!(table.place(0), "line 1000002");
    }

    /// Cells that are counted only when the whole line is there would take many times the size of the file.
    #[test]
    fn a_file_of_one_line_is_refused() {
        assert_eq!(problem(&"1,".repeat(1 << 20)), CsvError::TooWide { line: 1 });
        assert!(matches!(problem(&format!("{},b\n1,2\n", "x".repeat(2 << 20))), CsvError::TooMuch(_)));
    }

    #[test]
    fn a_last_line_without_an_end_may_be_cut_within_its_last_number() {
        assert_eq!(table("t,q1\n0.5,-1.25\n1.5,-1.2").broken_off, ["line 3"]);
        assert_eq!(table("t q1\n0.5 -1.25\n1.5 -1.2").broken_off, ["line 3"]);
        for whole in ["t,q1\n0.5,-1.25\n", "t,q1\r\n0.5,-1.25\r\n", "t,q1\r0.5,-1.25\r", "t,q1\n0.5,-1.25\n\n"] {
            assert!(table(whole).broken_off.is_empty(), "{whole:?}");
        }
    }

    #[test]
    fn reads_the_same_table_in_many_dialects() {
        for text in [
            "t,q1,q2\n0.5,-1.5,2e3\n1.5,4,5\n",
            "\u{feff}t,q1,q2\r\n0.5,-1.5,2e3\r\n1.5,4,5\r\n",
            "t;q1;q2\n0,5;-1,5;2e3\n1,5;4;5\n",
            "t;q1;q2\n0.5;-1.5;2e3\n1.5;4;5\n",
            "t\tq1\tq2\n0.5\t-1.5\t2e3\n1.5\t4\t5",
            "t\tq1\tq2\n0,5\t-1,5\t2e3\n1,5\t4\t5",
            "t q1 q2\n0.5 -1.5 2e3\n1.5 4 5\n",
            "t,q1,q2\r0.5,-1.5,2e3\r1.5,4,5\r",
            "t q1 q2\r0.5 -1.5 2e3\r1.5 4 5\r",
            "  t   q1  q2\n  0.5  -1.5  2e3\n  1.5   4    5\n",
            "# a comment, with commas\nt,q1,q2\n0.5,-1.5,2e3\n# another\n\n1.5,4,5\n",
            "# made by a rig\n# t,q1,q2\n0.5,-1.5,2e3\n1.5,4,5\n",
            "# t q1 q2\n0.5 -1.5 2e3\n1.5 4 5\n",
            "\"t\",\"q1\",\"q2\"\n\"0.5\",\"-1.5\",2e3\n 1.5 , 4 , 5 \n",
            "t,q1,q2\n0.5,-1.5,2e3,\n1.5,4,5,\n",
        ] {
            let table = table(text);
            assert_eq!(table.names(), ["t", "q1", "q2"], "{text}");
            let values: Vec<_> = table.columns.iter().map(|column| column.values.clone()).collect();
            assert_eq!(values, [[0.5, 1.5], [-1.5, 4.0], [2000.0, 5.0]], "{text}");
        }
    }

    #[test]
    fn names_may_be_missing_or_hold_commas_and_units_may_stand_below() {
        assert_eq!(table("1,2\n3,4\n").names(), ["c1", "c2"]);
        assert_eq!(table("\"t, in s\";q\n1;2\n3;4\n").names(), ["t, in s", "q"]);
        assert_eq!(table("t,q1,tau1\ns,deg,Nm\n1,2,3\n").names(), ["t[s]", "q1[deg]", "tau1[Nm]"]);
    }

    /// Below the names stand units only if every cell may be one, one of them is no number, and none is missing.
    #[test]
    fn a_row_of_units_is_told_from_values() {
        let names = |units: &str| table(&format!("t,q1,tau1\n{units}\n1,2,3\n4,5,6\n")).names().join(" ");
        for (units, named) in [
            ("[s],(rad),Nm", "t[s] q1[rad] tau1[Nm]"),
            ("s,,Nm", "t[s] q1 tau1[Nm]"),
            ("s,-,1", "t[s] q1[-] tau1[1]"),
            ("S,A,V", "t[S] q1[A] tau1[V]"),
        ] {
            assert_eq!(names(units), named, "{units}");
        }
        // A value, and a row of nothing.
        for values in ["1,1,1", ",,"] {
            assert_eq!(names(values), "t q1 tau1", "{values}");
        }
        assert_eq!(table("t,q1,tau1\n1,1,1\n1,2,3\n").column("t").unwrap().values, [1.0, 1.0]);
        assert_eq!(table("t,q1,note\n0,1,bool\n1,2,b\n").column("t").unwrap().values, [0.0, 1.0], "0 is no unit");
        assert_eq!(problem("t,q1,tau1\ns,rad\n1,2,3\n"), CsvError::NoNumbers { line: 2 });
    }

    #[test]
    fn cells_without_a_number_are_nan_or_text_with_its_line() {
        let table = table("# head\nt,q,label\n0,nan,a\n1,,b\n2,-inf,c\n3,x,d\n");
        let q = table.column("q").unwrap();
        assert!(q.values[0].is_nan() && q.values[1].is_nan() && q.values[2].is_infinite());
        assert_eq!(q.text, Some(TextCell { line: 6, cell: "x".into() }));
        assert_eq!(table.column("label").unwrap().text, Some(TextCell { line: 3, cell: "a".into() }));
        assert_eq!(table.column("t").unwrap().text, None);
        assert_eq!(table.place(2), "line 5");
    }

    #[test]
    fn what_is_no_table_is_told_with_its_line() {
        assert_eq!(problem("# only\n\n# comments\n"), CsvError::Empty);
        assert_eq!(problem("\n\nt,q1\n"), CsvError::HeaderOnly { line: 3 });
        assert_eq!(problem("t,q1\n0,1\n# note\n\n1\n2,3\n"), CsvError::Ragged { line: 5, found: 1, expected: 2 });
        assert_eq!(problem(&format!("t,q1\n{}", "1,".repeat(20_000))), CsvError::TooWide { line: 2 });
        assert_eq!(problem(&"1 ".repeat(20_000)), CsvError::TooWide { line: 1 });
        assert_eq!(problem("MIT License\nCopyright by me\n"), CsvError::NoNumbers { line: 2 });
        assert_eq!(problem("t,q1\n0,1\n1\n2,3\n"), CsvError::Ragged { line: 3, found: 1, expected: 2 });
        assert_eq!(problem("t q1\n0 1\n1 2 3\n"), CsvError::Ragged { line: 3, found: 3, expected: 2 });
        assert_eq!(problem("t,q1\r\n0,1\r\n1,2,3\r\n"), CsvError::Ragged { line: 3, found: 3, expected: 2 });
    }

    /// Cells between quotes may go on in the next line, and rows may lie across two blocks of the text.
    #[test]
    fn lines_are_counted_through_quotes_comments_and_blocks() {
        let head = "# made by a rig\n\"time\n[s]\",\"q1\n[rad]\"\n";
        let rows = 200_000;
        let text = head.to_owned() + &"0.125,-1.25\n".repeat(rows) + "\n# a note\n0.5,x\n";
        let table = table(&text);
        assert_eq!(table.names(), ["time\n[s]", "q1\n[rad]"]);
        assert_eq!((table.columns[0].values.len(), table.place(0)), (rows + 1, "line 5".to_owned()));
        assert!(table.columns[1].values[..rows].iter().all(|value| *value == -1.25));
        assert_eq!(table.columns[1].text, Some(TextCell { line: rows as u64 + 7, cell: "x".into() }));
    }

    #[test]
    fn decimal_commas_between_blanks_are_numbers() {
        let is_it = |line: &str| between_blanks_are_numbers(&[&b"t q"[..], line.as_bytes()]);
        assert!(is_it("0,1 0,2 0,3") && is_it("1 2,5"));
        assert!(!is_it("0,1") && !is_it("0.1,0.2, 0.3,0.4") && !is_it("1,2 three") && !is_it(",1 2"));
        assert!(!between_blanks_are_numbers(&[]));
    }

    #[test]
    fn a_line_wider_than_any_log_is_refused_with_its_number() {
        let wide = format!("t,q\n1,2\n{}\n", "1,".repeat(MOST_COLUMNS));
        assert_eq!(problem(&wide), CsvError::TooWide { line: 3 });
        let comment = format!("# {}\n", "1,".repeat(MOST_COLUMNS));
        assert_eq!(
            table(&format!("t,q\n1,2\n{comment}3,4\n")).columns[0].values,
            [1.0, 3.0],
            "a comment is no line of the log"
        );
    }
}
