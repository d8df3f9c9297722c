//! Parquet: a table by columns, as LeRobot, pandas and Arrow write it. A column of numbers is a column here; one of lists of equal length,
//! such as `observation.state`, is one for each place in the list.
//!
//! The file is taken apart here as far as to its unpacked pages, since it may lie about all sizes; the library only decodes values.

mod delta;
mod footer;
mod pages;
mod thrift;

use ::parquet::basic::{ConvertedType, LogicalType, Repetition, TimeUnit, Type as Physical};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader, get_typed_column_reader};
use ::parquet::data_type::{BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use ::parquet::file::metadata::ColumnChunkMetaData;
use ::parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};
use ndarray::{ArrayD, IxDyn};

use self::pages::{Codec, Pages, Shape};
use self::thrift::Wrong;
use super::arrays::{self, ArraysError, BYTES};
use super::budget::Budget;
use super::share::Share;
use super::table::{MOST_COLUMNS, Table};
use crate::progress::Monitor;

/// The file can't be read.
#[derive(Debug, thiserror::Error)]
pub enum ParquetError {
    /// Its end is missing.
    #[error("it breaks off: a Parquet file ends with `PAR1`; copy it again, or close it where it is written")]
    BrokenOff,
    /// It is damaged, or uses what is not read.
    #[error(
        "{at}: {problem}; copy the file again, or write it anew in Python: \
             pandas.read_parquet('log.parquet').to_csv('log.csv', index=False)"
    )]
    Damaged {
        /// The column or other part.
        at: String,
        /// What is wrong.
        problem: String,
    },
    /// It is packed in a way that is not read.
    #[error(
        "its pages are packed with {0}, which is not read (Snappy, gzip, zstd and LZ4 are); write it anew in Python: \
         pandas.read_parquet('log.parquet').to_parquet('log2.parquet', compression='zstd')"
    )]
    Codec(&'static str),
    /// Nobody without its key can read it.
    #[error("it is encrypted, which is not read; write it anew without encryption")]
    Encrypted,
    /// More columns than any log has.
    #[error("it has more than {MOST_COLUMNS} columns; a log has one column a channel")]
    TooMany,
    /// Its columns make no table, would take too much memory, or were not read to the end.
    #[error(transparent)]
    Arrays(ArraysError),
}

impl<E: Into<ArraysError>> From<E> for ParquetError {
    fn from(problem: E) -> Self {
        ParquetError::Arrays(problem.into())
    }
}

impl ParquetError {
    fn of(at: &str, problem: Wrong) -> ParquetError {
        match problem {
            Wrong::Lie(problem) => damaged(at, problem),
            Wrong::TooMuch(problem) => problem.into(),
        }
    }
}

fn damaged(at: &str, problem: impl ToString) -> ParquetError {
    ParquetError::Damaged { at: at.to_owned(), problem: problem.to_string() }
}

/// A list of more numbers is a picture.
const WIDEST: usize = 4096;
/// So many rows are decoded at once.
const ROWS: usize = 1 << 14;
/// Columns that count the runs of a log: those of LeRobot, and our own.
const RUNS: [&str; 2] = ["episode_index", "trajectory"];

/// Reads a file.
pub(super) fn read(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Table, ParquetError> {
    let metadata = footer::read(bytes, budget)?;
    let schema = metadata.file_metadata().schema_descr();
    let (mut found, mut passed_over) = (Vec::new(), Vec::new());
    let parts = metadata.row_groups().iter().flat_map(|group| group.columns());
    let size = |part: &ColumnChunkMetaData| u64::try_from(part.num_values()).unwrap_or_default();
    let whole = parts.map(size).fold(0, u64::saturating_add);
    let mut watch = Watch { share: Share::of(whole, monitor), done: 0 };
    for (index, column) in schema.columns().iter().enumerate() {
        let form = Form::of(schema, column);
        budget.text(&form.name)?;
        let mut values = match form.numbers {
            Ok(_) => Values::new(&form, column.max_def_level()),
            Err(reason) => {
                passed_over.push(format!("`{}` ({reason})", form.name));
                continue;
            }
        };
        let width = match column.physical_type() {
            Physical::INT32 | Physical::FLOAT => 4,
            _ => 8,
        };
        let levels = [column.max_rep_level(), column.max_def_level()].map(i16::unsigned_abs);
        let shape = Shape { width, levels };
        for group in metadata.row_groups() {
            let part = group.column(index);
            let count =
                u64::try_from(part.num_values()).map_err(|_| damaged(&form.name, "it has less than no value"))?;
            // Unless it is of lists, it has a value a row.
            if column.max_rep_level() == 0 && part.num_values() != group.num_rows() {
                return Err(damaged(&form.name, "it has another number of values than of rows"));
            }
            let start = part.dictionary_page_offset().filter(|start| *start > 0).unwrap_or(part.data_page_offset());
            let end = start.checked_add(part.compressed_size()).and_then(|end| usize::try_from(end).ok());
            let part_of_file = usize::try_from(start).ok().zip(end).and_then(|(start, end)| bytes.get(start..end));
            let part_of_file =
                part_of_file.ok_or_else(|| damaged(&form.name, "it claims to lie outside of the file"))?;
            budget.unpack(count.saturating_mul(BYTES))?;
            let codec = Codec::of(part.compression())?;
            let pages = Pages::of(part_of_file, codec, shape, count, &form.name, budget)?;
            let rows = usize::try_from(group.num_rows()).unwrap_or(usize::MAX);
            values.take(column, pages, rows, budget, &mut watch)?;
        }
        match values.array() {
            Ok(array) => found.push((form.name, array)),
            Err(reason) => passed_over.push(format!("`{}` ({reason})", form.name)),
        }
    }
    let mut table = arrays::table(found, passed_over, budget)?;
    cut_into_runs(&mut table);
    Ok(table)
}

/// What a column is, as its type says.
struct Form {
    /// Its path with dots between, without what only says that it is a list.
    name: String,
    /// How its numbers are read, or why it has none.
    numbers: Result<Physical, &'static str>,
    is_unsigned: bool,
    /// What a number of a clock means \[s\], which begins at the first sample.
    tick: Option<f64>,
    /// The definition level from which a list has an element; `None` if there is one number a row.
    element: Option<i16>,
}

impl Form {
    fn of(schema: &SchemaDescriptor, column: &ColumnDescriptor) -> Form {
        let parts = column.path().parts();
        let (mut node, mut level, mut element) = (schema.root_schema(), 0, None);
        let mut name: Vec<&str> = Vec::new();
        let mut is_in_list = false;
        for part in parts {
            let Some(child) = node.get_fields().iter().find(|field| field.name() == part) else { break };
            let info = child.get_basic_info();
            let repetition = if info.has_repetition() { info.repetition() } else { Repetition::REQUIRED };
            level += i16::from(repetition != Repetition::REQUIRED);
            // A list is a group of a repeated group of an element; the names of the inner two say nothing.
            let is_repeated = repetition == Repetition::REPEATED;
            let says_nothing = is_in_list || (is_repeated && child.is_group() && !name.is_empty());
            is_in_list = is_repeated && child.is_group() && child.get_fields().len() == 1;
            if is_repeated {
                element = Some(level);
            }
            if !says_nothing {
                name.push(part);
            }
            node = child;
        }
        let name = if name.is_empty() { column.path().string() } else { name.join(".") };
        let logical = column.logical_type_ref();
        let tick = match (logical, column.converted_type()) {
            (Some(LogicalType::Timestamp(clock)), _) => Some(seconds(&clock.unit)),
            (Some(LogicalType::Time(clock)), _) => Some(seconds(&clock.unit)),
            (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => Some(1e-3),
            (_, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS) => Some(1e-6),
            _ => None,
        };
        let is_decimal =
            matches!(logical, Some(LogicalType::Decimal(_))) || column.converted_type() == ConvertedType::DECIMAL;
        let is_unsigned = matches!(logical, Some(LogicalType::Integer(integer)) if !integer.is_signed)
            || matches!(column.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64);
        let numbers = match column.physical_type() {
            _ if column.max_rep_level() > 1 => Err("lists in lists"),
            _ if is_decimal => Err("decimal numbers"),
            Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY | Physical::INT96 => Err("no numbers"),
            physical => Ok(physical),
        };
        Form { name, numbers, is_unsigned, tick, element }
    }
}

fn seconds(unit: &TimeUnit) -> f64 {
    match unit {
        TimeUnit::MILLIS => 1e-3,
        TimeUnit::MICROS => 1e-6,
        TimeUnit::NANOS => 1e-9,
    }
}

/// How many values of all columns are read.
struct Watch<'a> {
    share: Share<'a>,
    done: u64,
}

/// The numbers of a column, row after row, as they come.
struct Values<'a> {
    form: &'a Form,
    numbers: Vec<f64>,
    rows: usize,
    /// The definition level of a number that is there.
    deepest: i16,
    /// How many numbers a row has, once a list shows it.
    width: Option<usize>,
    /// How many the list has that is being read.
    begun: Option<usize>,
    /// The first tick of a clock.
    start: Option<i64>,
    /// Why it is no column.
    unfit: Option<String>,
}

impl<'a> Values<'a> {
    fn new(form: &'a Form, deepest: i16) -> Self {
        let width = form.element.is_none().then_some(1);
        Values { form, numbers: Vec::new(), rows: 0, deepest, width, begun: None, start: None, unfit: None }
    }

    /// The rows of a group.
    fn take(
        &mut self,
        column: &std::sync::Arc<ColumnDescriptor>,
        pages: Pages,
        rows: usize,
        budget: &mut Budget,
        watch: &mut Watch,
    ) -> Result<(), ParquetError> {
        let before = self.rows;
        let reader = get_column_reader(column.clone(), Box::new(pages));
        let (tick, is_unsigned) = (self.form.tick, self.form.is_unsigned);
        let mut start = self.start;
        let mut whole = |value: i64| match tick {
            Some(tick) => value.wrapping_sub(*start.get_or_insert(value)) as f64 * tick,
            None if is_unsigned => value as u64 as f64,
            None => value as f64,
        };
        let narrow = |value: i32| if is_unsigned { i64::from(value as u32) } else { i64::from(value) };
        match column.physical_type() {
            Physical::BOOLEAN => self.decode::<BoolType>(reader, |value| f64::from(u8::from(value)), budget, watch),
            Physical::INT32 => self.decode::<Int32Type>(reader, |value| whole(narrow(value)), budget, watch),
            Physical::INT64 => self.decode::<Int64Type>(reader, whole, budget, watch),
            Physical::FLOAT => self.decode::<FloatType>(reader, f64::from, budget, watch),
            _ => self.decode::<DoubleType>(reader, |value| value, budget, watch),
        }?;
        self.start = start;
        self.end_list(budget)?;
        match self.unfit.is_some() || self.rows - before == rows {
            true => Ok(()),
            false => Err(damaged(&self.form.name, "it has another number of rows than the file")),
        }
    }

    fn decode<T: DataType>(
        &mut self,
        reader: ColumnReader,
        mut number: impl FnMut(T::T) -> f64,
        budget: &mut Budget,
        watch: &mut Watch,
    ) -> Result<(), ParquetError> {
        let mut reader: ColumnReaderImpl<T> = get_typed_column_reader(reader);
        let (mut definitions, mut repetitions, mut values) = (Vec::new(), Vec::new(), Vec::new());
        while self.unfit.is_none() {
            watch.share.is(watch.done)?;
            definitions.clear();
            repetitions.clear();
            values.clear();
            let read = reader.read_records(ROWS, Some(&mut definitions), Some(&mut repetitions), &mut values);
            let (records, _, levels) = read.map_err(|problem| damaged(&self.form.name, problem))?;
            if records == 0 && levels == 0 {
                break;
            }
            watch.done += levels as u64;
            let mut values = values.drain(..).map(&mut number);
            for index in 0..levels {
                let is_there = definitions.get(index).is_none_or(|level| *level == self.deepest);
                let value = is_there.then(|| values.next()).flatten();
                match self.form.element {
                    None => self.row(value),
                    Some(element) => {
                        let is_new = repetitions.get(index).is_none_or(|level| *level == 0);
                        let is_element = definitions.get(index).is_none_or(|level| *level >= element);
                        self.element(value, is_new, is_element, budget)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// A row of one number, or of none.
    fn row(&mut self, value: Option<f64>) {
        self.numbers.push(value.unwrap_or(f64::NAN));
        self.rows += 1;
    }

    /// An element of a list, with which a new list may begin; an empty list has none.
    fn element(
        &mut self,
        value: Option<f64>,
        is_new: bool,
        is_element: bool,
        budget: &mut Budget,
    ) -> Result<(), ParquetError> {
        if is_new {
            self.end_list(budget)?;
            self.begun = Some(0);
        }
        if is_element {
            self.numbers.push(value.unwrap_or(f64::NAN));
            *self.begun.get_or_insert(0) += 1;
            if self.begun > Some(WIDEST) {
                self.unfit = Some(format!("its lists have more than {WIDEST} numbers"));
            }
        }
        Ok(())
    }

    /// A list is complete: the first one shows the width of all, and one that is missing is a row without numbers.
    fn end_list(&mut self, budget: &mut Budget) -> Result<(), ParquetError> {
        let Some(count) = self.begun.take() else { return Ok(()) };
        match self.width {
            _ if count == 0 => {
                let width = self.width.unwrap_or(0);
                budget.unpack(width as u64 * BYTES)?;
                self.numbers.resize(self.numbers.len() + width, f64::NAN);
            }
            None => {
                // Lists that were missing before the first one that is there.
                let missing = self.rows.saturating_mul(count);
                budget.unpack((missing as u64).saturating_mul(BYTES))?;
                self.numbers.splice(0..0, std::iter::repeat_n(f64::NAN, missing));
                self.width = Some(count);
            }
            Some(width) if width != count => {
                self.unfit = Some(format!("its lists have {width} numbers and {count}"));
            }
            Some(_) => {}
        }
        self.rows += 1;
        Ok(())
    }

    /// All rows as an array, or why they are none.
    fn array(self) -> Result<ArrayD<f64>, String> {
        if let Some(reason) = self.unfit {
            return Err(reason);
        }
        let shape = match (self.form.element, self.width) {
            (None, _) => vec![self.rows],
            (Some(_), Some(width)) => vec![self.rows, width],
            (Some(_), None) => return Err("its lists are empty".to_owned()),
        };
        ArrayD::from_shape_vec(IxDyn(&shape), self.numbers).map_err(|problem| problem.to_string())
    }
}

/// Rows with the same number of an episode are a run, named by that number.
fn cut_into_runs(table: &mut Table) {
    let Some(at) = table.columns.iter().position(|column| RUNS.contains(&column.name.as_str())) else { return };
    let numbers = table.columns.remove(at).values;
    let starts = (0..numbers.len()).filter(|row| *row == 0 || numbers[*row].to_bits() != numbers[row - 1].to_bits());
    let starts: Vec<usize> = starts.collect();
    let ends = starts.iter().skip(1).copied().chain([numbers.len()]);
    table.runs = starts.iter().copied().zip(ends).map(|(start, end)| start..end).collect();
    table.run_names = Some(starts.iter().map(|start| numbers[*start].to_string()).collect());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::write;

    /// Written by pyarrow 26 in LeRobot's layout (`tests/data/README.md` tells how): lists, dictionaries, four codecs, three groups of
    /// rows; and the same in pages of version 2 with other encodings.
    const LOGS: [&[u8]; 2] =
        [include_bytes!("../../../../tests/data/log.parquet"), include_bytes!("../../../../tests/data/log2.parquet")];

    fn table(bytes: &[u8]) -> Result<Table, ParquetError> {
        read(bytes, &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new())
    }

    #[test]
    fn lists_are_a_column_for_each_place_and_episodes_are_runs() {
        for bytes in LOGS {
            let table = table(bytes).unwrap();
            let value = |name: &str, row: usize| {
                table.column(name).unwrap_or_else(|| panic!("{:?}", table.names())).values[row]
            };
            assert_eq!((value("observation.state[0]", 50), value("observation.state[1]", 50)), (0.5, -0.5));
            assert_eq!((value("observation.velocity[1]", 59), value("observation.effort[1]", 59)), (-1.0, 0.5));
            assert!(value("observation.effort[0]", 40).is_nan(), "the list is missing there");
            assert_eq!((value("done", 58), value("done", 59)), (0.0, 1.0));
            assert!((value("logged", 59) - 0.59).abs() < 1e-9, "a clock in ns begins at the first sample, in s");
            assert_eq!((table.runs.as_slice(), value("timestamp", 31) as f32), (&[0..30, 30..60][..], 0.01));
            assert_eq!(table.run_names, Some(vec!["4".to_owned(), "5".to_owned()]));
            assert_eq!(table.passed_over, ["`task` (no numbers)"]);
        }
    }

    #[test]
    fn cut_and_lying_files_are_refused_and_nothing_panics() {
        let says = |bytes: &[u8]| table(bytes).unwrap_err().to_string();
        for bytes in LOGS {
            for end in (8..bytes.len()).step_by(61) {
                assert!(says(&bytes[..end]).contains("breaks off"));
            }
            let mut lying = bytes.to_vec();
            let at = lying.len() - 8;
            lying[at..at + 4].copy_from_slice(&[0xff; 4]);
            assert!(says(&lying).contains("the footer: it claims to be longer than the file"));
            for place in (4..bytes.len()).step_by(7) {
                for flip in [0xff, 0x01, 0x80] {
                    let mut damaged = bytes.to_vec();
                    damaged[place] ^= flip;
                    let _ = table(&damaged);
                }
            }
        }
        // The codec of the first column: Brotli instead of Snappy.
        let mut other = LOGS[0].to_vec();
        let codec = other.windows(3).rposition(|bytes| bytes == [0x15, 0x02, 0x16]).unwrap();
        other[codec + 1] = 0x08;
        assert!(says(&other).contains("packed with Brotli, which is not read"), "{}", says(&other));
        other[codec + 1] = 0x40;
        assert!(says(&other).contains("nothing that is known"), "{}", says(&other));
    }

    #[test]
    fn what_no_log_packs_so_tightly_is_refused() {
        let zeros = |rows: usize| write::parquet::table(&[("q".to_owned(), vec![0.0; rows])]).unwrap();
        assert_eq!(table(&zeros(1 << 20)).unwrap().columns[0].values.len(), 1 << 20);
        let error = table(&zeros(4 << 20)).unwrap_err().to_string();
        assert!(error.contains("over 32 times its size"), "{error}");
    }
}
