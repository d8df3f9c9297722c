//! What a Parquet file says of itself, checked: nothing in it claims to be longer or lies deeper than it can, and all is packed in a way
//! that is read. Only then the library makes room for it.
//!
//! Source: Apache Parquet, `parquet.thrift` (numbers of fields).

use ::parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};

use super::super::arrays::DEEPEST;
use super::super::budget::Budget;
use super::super::table::MOST_COLUMNS;
use super::thrift::{self, Value};
use super::{ParquetError, damaged};

/// A file begins and ends with this.
const MAGIC: &[u8] = b"PAR1";
/// Behind the footer stand its length and the end.
const TAIL: usize = 8;
/// The last number of a codec that is known.
const LAST_CODEC: i64 = 7;
/// What the description of a part of a column takes in memory \[bytes\].
const PART: u64 = 1024;

/// Reads the footer.
pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<ParquetMetaData, ParquetError> {
    if bytes.ends_with(b"PARE") {
        return Err(ParquetError::Encrypted);
    }
    let body = bytes.strip_suffix(MAGIC).filter(|body| body.len() > TAIL).ok_or(ParquetError::BrokenOff)?;
    let (body, length) = body.split_at(body.len() - 4);
    let length = length.iter().rev().fold(0usize, |sum, byte| sum << 8 | usize::from(*byte));
    let start = body.len().checked_sub(length).filter(|start| *start >= MAGIC.len());
    let start = start.ok_or_else(|| damaged("the footer", "it claims to be longer than the file"))?;
    let footer = &body[start..];
    check(footer, budget)?;
    ParquetMetaDataReader::decode_metadata(footer).map_err(|problem| damaged("the footer", problem))
}

/// Checks what a footer claims of its parts.
fn check(footer: &[u8], budget: &mut Budget) -> Result<(), ParquetError> {
    let wrong = |problem| damaged("the footer", problem);
    let (claims, _) = thrift::read(footer, budget).map_err(|problem| ParquetError::of("the footer", problem))?;
    if claims.field(8).is_some() {
        return Err(ParquetError::Encrypted);
    }
    let leaves = leaves(claims.list(2)).map_err(wrong)?;
    if leaves > MOST_COLUMNS {
        return Err(ParquetError::TooMany);
    }
    budget.hold(claims.list(2).len() as u64 * PART)?;
    for group in claims.list(4) {
        let parts = group.list(1);
        budget.hold(parts.len() as u64 * PART)?;
        if parts.len() != leaves || group.number(3).is_none_or(|rows| rows < 0) {
            return Err(wrong("a group of rows has other columns than the file"));
        }
        for part in parts {
            let part = part.field(3).ok_or_else(|| wrong("a column says nothing of itself"))?;
            if part.number(4).is_none_or(|codec| !(0..=LAST_CODEC).contains(&codec)) {
                return Err(ParquetError::Codec("nothing that is known"));
            }
        }
    }
    Ok(())
}

/// How many columns a schema has: a tree, written from its root down, in which each group tells the number of its children.
fn leaves(schema: &[Value]) -> Result<usize, &'static str> {
    let mut open = vec![1i64];
    let mut leaves = 0;
    for element in schema {
        while open.last() == Some(&0) {
            open.pop();
        }
        *open.last_mut().ok_or("its schema has more parts than it tells")? -= 1;
        match element.number(5).unwrap_or_default() {
            0 => leaves += 1,
            children if children > 0 && children <= schema.len() as i64 => open.push(children),
            _ => return Err("a group in its schema has an impossible number of parts"),
        }
        if open.len() > DEEPEST {
            return Err("the groups in its schema lie too deep in each other");
        }
    }
    match open.iter().all(|left| *left == 0) {
        true => Ok(leaves),
        false => Err("its schema has fewer parts than it tells"),
    }
}
