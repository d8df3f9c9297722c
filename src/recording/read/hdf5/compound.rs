//! A dataset of rows with named fields, as pandas and robots' loggers write tables: an array for each field that holds numbers.

use hdf5_reader::{ByteOrder, CompoundField, Dataset, Datatype};
use ndarray::{ArrayD, IxDyn};

use super::{Hdf5Error, damaged};
use crate::recording::read::arrays::BYTES;
use crate::recording::read::budget::Budget;

/// A field of numbers.
struct Field<'a> {
    name: &'a str,
    /// Where it begins in a row.
    offset: usize,
    number: Number,
    /// Numbers in a row.
    width: usize,
    /// Whether it is an array of them.
    is_array: bool,
}

/// How a number stands in a row.
#[derive(Clone, Copy)]
struct Number {
    size: usize,
    kind: Kind,
    is_big_endian: bool,
}

#[derive(Clone, Copy)]
enum Kind {
    Float,
    Signed,
    Unsigned,
}

/// The fields of a table as arrays, each named by the table and itself; none if it has no numbers, or is no list of rows.
pub(super) fn columns(
    dataset: &Dataset,
    name: &str,
    fields: &[CompoundField],
    budget: &mut Budget,
) -> Result<Vec<(String, ArrayD<f64>)>, Hdf5Error> {
    let wrong = |problem| damaged(name, &problem);
    let fields: Vec<Field> = fields.iter().filter_map(Field::of).collect();
    let [rows] = *dataset.shape() else { return Ok(Vec::new()) };
    if fields.is_empty() {
        return Ok(Vec::new());
    }
    let too_short = |at: &str| Hdf5Error::Damaged {
        at: format!("`{at}`"),
        problem: "its rows are shorter than their fields".to_owned(),
    };
    let size = dataset.raw_element_size().map_err(wrong)?;
    if size == 0 {
        return Err(too_short(name));
    }
    let in_row = fields.iter().fold(0u64, |sum, field| sum.saturating_add((field.width as u64).saturating_mul(BYTES)));
    budget.unpack(rows.saturating_mul(size as u64).saturating_add(rows.saturating_mul(in_row)))?;
    let bytes = dataset.read_raw_bytes().map_err(wrong)?;
    let mut arrays = Vec::new();
    for field in fields {
        let label = format!("{name}.{}", field.name);
        budget.text(&label)?;
        let values: Option<Vec<f64>> = bytes.chunks_exact(size).flat_map(|row| field.numbers(row)).collect();
        let count = bytes.len() / size;
        let shape = if field.is_array { vec![count, field.width] } else { vec![count] };
        let array = values.and_then(|values| ArrayD::from_shape_vec(IxDyn(&shape), values).ok());
        arrays.push((label.clone(), array.ok_or_else(|| too_short(&label))?));
    }
    Ok(arrays)
}

impl<'a> Field<'a> {
    /// `None` if it holds something else than numbers.
    fn of(field: &'a CompoundField) -> Option<Field<'a>> {
        let (element, width, is_array) = match &field.datatype {
            Datatype::Array { base, dims } => {
                let [width] = dims[..] else { return None };
                (&**base, usize::try_from(width).ok()?, true)
            }
            alone => (alone, 1, false),
        };
        let number = Number::of(element)?;
        Some(Field { name: &field.name, offset: field.byte_offset as usize, number, width, is_array })
    }

    /// Its numbers in a row; `None` where the row is too short.
    fn numbers(&self, row: &[u8]) -> impl Iterator<Item = Option<f64>> {
        let size = self.number.size;
        (0..self.width).map(move |place| {
            let start = place.checked_mul(size)?.checked_add(self.offset)?;
            self.number.read(row.get(start..start.checked_add(size)?)?)
        })
    }
}

impl Number {
    fn of(datatype: &Datatype) -> Option<Number> {
        let (size, kind, order) = match datatype {
            Datatype::FloatingPoint { size, byte_order } => (*size, Kind::Float, byte_order),
            Datatype::FixedPoint { size, signed: true, byte_order } => (*size, Kind::Signed, byte_order),
            Datatype::FixedPoint { size, signed: false, byte_order } => (*size, Kind::Unsigned, byte_order),
            Datatype::Enum { base, .. } => return Number::of(base),
            _ => return None,
        };
        let is_read = match kind {
            Kind::Float => [4, 8].contains(&size),
            Kind::Signed | Kind::Unsigned => [1, 2, 4, 8].contains(&size),
        };
        let is_big_endian = matches!(order, ByteOrder::BigEndian);
        is_read.then_some(Number { size: usize::from(size), kind, is_big_endian })
    }

    fn read(self, bytes: &[u8]) -> Option<f64> {
        // As the low bytes of a word.
        let mut word = [0; 8];
        let place = word.get_mut(..self.size)?;
        place.copy_from_slice(bytes.get(..self.size)?);
        if self.is_big_endian {
            place.reverse();
        }
        let word = u64::from_le_bytes(word);
        let unused = 64 - 8 * self.size as u32;
        Some(match self.kind {
            Kind::Float if self.size == 4 => f64::from(f32::from_bits(word as u32)),
            Kind::Float => f64::from_bits(word),
            Kind::Unsigned => word as f64,
            Kind::Signed => ((word << unused) as i64 >> unused) as f64,
        })
    }
}
