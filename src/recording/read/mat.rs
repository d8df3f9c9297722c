//! MATLAB files of version 5 to 7.2: a header, then variables, mostly compressed one by one.
//!
//! Read by hand, because logs hold structs, and objects that have to be passed over. Numbers become columns named by their
//! path (`rec.position`), the longer side of a matrix being time. Sizes are checked before anything is allocated.
//! Source of the layout: MathWorks, MAT-File Format (2019).

use std::io::Read;

use flate2::read::ZlibDecoder;
use ndarray::{Array1, Array2, ArrayD, ShapeBuilder};

use super::arrays::{self, ArraysError, BYTES};
use super::budget::{Budget, TooMuch};
use super::table::Table;
use crate::progress::{Monitor, Stopped};

/// The file can't be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MatError {
    /// Its bytes are not as they should be.
    #[error("the MATLAB file is damaged at {place}: {problem}; copy or save it again (in MATLAB with `save -v7`)")]
    Damaged {
        /// Name of the variable, or the byte.
        place: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// Its variables make no table.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Reads a file.
pub(super) fn read(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Table, MatError> {
    let damaged = |at: usize, problem| MatError::Damaged { place: format!("byte {at}"), problem };
    let header = bytes.get(..HEADER).ok_or_else(|| damaged(bytes.len(), "it ends within its header"))?;
    let big_endian = match &header[126..] {
        b"IM" => false,
        b"MI" => true,
        _ => return Err(damaged(126, "the mark of its byte order is missing")),
    };
    // Where the workspace of objects stands, if there are any: bytes that mean nothing outside MATLAB.
    let workspace = Cursor { bytes: &header[116..124], big_endian }.number(8) as usize;
    let mut found = Found { arrays: Vec::new(), passed_over: Vec::new(), budget };
    let mut file = Cursor { bytes: &bytes[HEADER..], big_endian };
    while !file.bytes.is_empty() {
        monitor.check()?;
        let at = bytes.len() - file.bytes.len();
        let element = file.element().map_err(|problem| damaged(at, problem))?;
        let unpacked;
        let content = match element.kind {
            COMPRESSED => {
                unpacked = inflate(element.bytes, found.budget).map_err(|problem| problem.at(at))?;
                let mut inner = Cursor { bytes: &unpacked, big_endian };
                inner.element().map_err(|problem| damaged(at, problem))?
            }
            _ => element,
        };
        if content.kind != MATRIX {
            return Err(damaged(at, "a variable was expected"));
        }
        if at == workspace {
            continue;
        }
        let variable = Cursor { bytes: content.bytes, big_endian };
        matrix(variable, None, 0, &mut found).map_err(|problem| problem.at(at))?;
    }
    Ok(arrays::table(found.arrays, found.passed_over, found.budget)?)
}

const HEADER: usize = 128;
/// Kinds of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Structs in structs in structs …
const DEEPEST: usize = 32;

/// What was found so far.
struct Found<'a> {
    arrays: Vec<(String, ArrayD<f64>)>,
    passed_over: Vec<String>,
    budget: &'a mut Budget,
}

enum Problem {
    Damaged(&'static str),
    TooMuch(TooMuch),
}

impl Problem {
    /// The error of a variable that begins at this byte.
    fn at(self, at: usize) -> MatError {
        match self {
            Problem::Damaged(problem) => MatError::Damaged { place: format!("byte {at}"), problem },
            Problem::TooMuch(problem) => ArraysError::from(problem).into(),
        }
    }
}

impl From<&'static str> for Problem {
    fn from(problem: &'static str) -> Self {
        Problem::Damaged(problem)
    }
}

impl From<TooMuch> for Problem {
    fn from(problem: TooMuch) -> Self {
        Problem::TooMuch(problem)
    }
}

fn inflate(bytes: &[u8], budget: &mut Budget) -> Result<Vec<u8>, Problem> {
    let mut unpacked = Vec::new();
    let most = budget.left_to_unpack().saturating_add(1);
    ZlibDecoder::new(bytes).take(most).read_to_end(&mut unpacked).map_err(|_| "it can't be unpacked")?;
    budget.unpack(unpacked.len() as u64)?;
    Ok(unpacked)
}

/// Bytes that are read from the front.
#[derive(Clone, Copy)]
struct Cursor<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

/// A tag and what follows it.
struct Element<'a> {
    kind: u32,
    bytes: &'a [u8],
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], &'static str> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or("it ends too early")?;
        self.bytes = rest;
        Ok(taken)
    }

    /// The first bytes as an unsigned number.
    fn number(&self, size: usize) -> u64 {
        let place = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let bytes = &self.bytes[..size.min(self.bytes.len())];
        if self.big_endian { bytes.iter().fold(0, place) } else { bytes.iter().rev().fold(0, place) }
    }

    fn u32(&mut self) -> Result<u32, &'static str> {
        let taken = Cursor { bytes: self.take(4)?, ..*self };
        Ok(taken.number(4) as u32)
    }

    fn element(&mut self) -> Result<Element<'a>, &'static str> {
        let tag = self.u32()?;
        if tag >> 16 != 0 {
            // A small element: kind, size and up to four bytes in one word.
            let content = self.take(4)?;
            let bytes = content.get(..(tag >> 16) as usize).ok_or("a small element claims more than four bytes")?;
            return Ok(Element { kind: tag & 0xffff, bytes });
        }
        let size = self.u32()? as usize;
        let bytes = self.take(size)?;
        if tag != COMPRESSED {
            let padding = size.next_multiple_of(8) - size;
            self.take(padding.min(self.bytes.len()))?;
        }
        Ok(Element { kind: tag, bytes })
    }

    /// Numbers of an element, whatever their type.
    fn numbers(&self, element: &Element) -> Result<Vec<f64>, &'static str> {
        let size = match element.kind {
            1 | 2 => 1,
            3 | 4 => 2,
            5..=7 => 4,
            9 | 12 | 13 => 8,
            _ => return Err("numbers of an unknown type"),
        };
        let value = |bytes: &[u8]| {
            let raw = Cursor { bytes, ..*self }.number(size);
            let unused = 64 - 8 * size as u32;
            match element.kind {
                7 => f64::from(f32::from_bits(raw as u32)),
                9 => f64::from_bits(raw),
                1 | 3 | 5 | 12 => ((raw << unused) as i64 >> unused) as f64,
                _ => raw as f64,
            }
        };
        Ok(element.bytes.chunks_exact(size).map(value).collect())
    }
}

/// One variable, field or cell; `path` replaces its own name, which fields and cells do not have.
fn matrix(mut cursor: Cursor, path: Option<String>, depth: usize, found: &mut Found) -> Result<(), Problem> {
    if cursor.bytes.is_empty() {
        return Ok(()); // an empty field
    }
    if depth > DEEPEST {
        return Err("structs are nested too deeply".into());
    }
    let flags = cursor.element()?;
    let flags = Cursor { bytes: flags.bytes, ..cursor }.u32()?;
    let pass_over = |path: String, reason: &str, found: &mut Found| {
        if !path.is_empty() {
            found.passed_over.push(format!("`{path}` ({reason})"));
        }
        Ok(())
    };
    let text = |element: &Element| String::from_utf8_lossy(element.bytes).trim_end_matches('\0').to_owned();
    if flags & 0xff == 17 {
        // An object of a class, which has a name but no size.
        let name = path.map_or_else(|| cursor.element().map(|name| text(&name)), Ok)?;
        return pass_over(if name.is_empty() { "an object".to_owned() } else { name }, "an object", found);
    }
    let sizes = cursor.element()?;
    let sizes = cursor.numbers(&sizes)?;
    let count = sizes.iter().try_fold(
        1usize,
        |product, &size| {
            if size < 0.0 { None } else { product.checked_mul(size as usize) }
        },
    );
    let count = count.ok_or("its size is no size")?;
    let own_name = cursor.element()?;
    let path = path.unwrap_or_else(|| text(&own_name));
    found.budget.text(&path)?;
    // Every element of a struct or cell takes bytes, so a false size can't claim more than there are.
    let claims_too_much = |pieces: usize, cursor: &Cursor| count.saturating_mul(pieces) > cursor.bytes.len() / 8;
    match flags & 0xff {
        1 => {
            if claims_too_much(1, &cursor) {
                return Err("it claims more cells than there are".into());
            }
            for index in 0..count {
                let inner = cursor.element()?;
                found.budget.text(&path)?;
                let place = format!("{path}{{{}}}", index + 1);
                matrix(Cursor { bytes: inner.bytes, ..cursor }, Some(place), depth + 1, found)?;
            }
            Ok(())
        }
        class @ (2 | 3) => {
            if class == 3 {
                cursor.element()?; // the name of the class
            }
            let length = cursor.element()?;
            let length = Cursor { bytes: length.bytes, ..cursor }.u32()? as usize;
            let names = cursor.element()?;
            if length == 0 {
                return Err("the names of its fields have no length".into());
            }
            let name = |bytes: &[u8]| {
                let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
                String::from_utf8_lossy(&bytes[..end]).into_owned()
            };
            found.budget.hold(names.bytes.len() as u64 + (names.bytes.len() / length * size_of::<String>()) as u64)?;
            let names: Vec<String> = names.bytes.chunks_exact(length).map(name).collect();
            if claims_too_much(names.len().max(1), &cursor) && !names.is_empty() {
                return Err("it claims more fields than there are".into());
            }
            for index in 0..if names.is_empty() { 0 } else { count } {
                found.budget.text(&path)?;
                let place = if count > 1 { format!("{path}({})", index + 1) } else { path.clone() };
                for name in &names {
                    found.budget.hold((place.len() + name.len()) as u64)?;
                    let inner = cursor.element()?;
                    matrix(Cursor { bytes: inner.bytes, ..cursor }, Some(format!("{place}.{name}")), depth + 1, found)?;
                }
            }
            Ok(())
        }
        4 => pass_over(path, "text", found),
        5 => pass_over(path, "a sparse matrix; save it with full()", found),
        6..=15 => {
            if flags & 0x0800 != 0 {
                return pass_over(path, "complex numbers", found);
            }
            let element = cursor.element()?;
            // They were unpacked already, and perhaps with fewer bytes each.
            found.budget.unpack((count as u64).saturating_mul(BYTES).saturating_sub(element.bytes.len() as u64))?;
            let values = cursor.numbers(&element)?;
            if values.len() != count {
                return Err("a variable has another number of elements than it claims".into());
            }
            if count == 0 || path.is_empty() {
                return Ok(());
            }
            match time_first(&sizes, values) {
                Some(array) => found.arrays.push((path, array)),
                None => pass_over(path, "it has more than two dimensions", found)?,
            }
            Ok(())
        }
        _ => pass_over(path, "a function or the like", found),
    }
}

/// A matrix, stored by columns, as samples × joints; the longer side is time. A vector has one dimension.
fn time_first(sizes: &[f64], values: Vec<f64>) -> Option<ArrayD<f64>> {
    let &[rows, columns] = sizes else { return None };
    let (rows, columns) = (rows as usize, columns as usize);
    if rows == 1 || columns == 1 {
        return Some(Array1::from_vec(values).into_dyn());
    }
    let matrix = Array2::from_shape_vec((rows, columns).f(), values).ok()?;
    let samples_first = if rows < columns { matrix.reversed_axes() } else { matrix };
    Some(samples_first.into_dyn())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn element(kind: u32, content: &[u8], big: bool) -> Vec<u8> {
        let word = |value: u32| if big { value.to_be_bytes() } else { value.to_le_bytes() };
        let mut bytes = [word(kind), word(content.len() as u32)].concat();
        bytes.extend(content);
        if kind != COMPRESSED {
            bytes.resize(bytes.len().next_multiple_of(8), 0);
        }
        bytes
    }

    fn words(values: &[u32], big: bool) -> Vec<u8> {
        values.iter().flat_map(|value| if big { value.to_be_bytes() } else { value.to_le_bytes() }).collect()
    }

    fn start(class: u32, sizes: [u32; 2], name: &str, big: bool) -> Vec<u8> {
        [
            element(6, &words(&[class, 0], big), big),
            element(5, &words(&sizes, big), big),
            element(1, name.as_bytes(), big),
        ]
        .concat()
    }

    fn numbers(name: &str, sizes: [u32; 2], values: &[f64], big: bool) -> Vec<u8> {
        let content: Vec<u8> =
            values.iter().flat_map(|value| if big { value.to_be_bytes() } else { value.to_le_bytes() }).collect();
        element(MATRIX, &[start(6, sizes, name, big), element(9, &content, big)].concat(), big)
    }

    fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let names: Vec<u8> = fields
            .iter()
            .flat_map(|(name, _)| {
                let mut name = name.as_bytes().to_vec();
                name.resize(16, 0);
                name
            })
            .collect();
        let mut content = start(2, [1, 1], name, false);
        content.extend([&[5, 0, 4, 0], &16u32.to_le_bytes()[..]].concat()); // a small element
        content.extend(element(1, &names, false));
        fields.iter().for_each(|(_, field)| content.extend(field));
        element(MATRIX, &content, false)
    }

    fn compressed(variable: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(variable).unwrap();
        element(COMPRESSED, &packer.finish().unwrap(), false)
    }

    fn file(variables: &[Vec<u8>], big: bool) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file, made by a test".to_vec();
        bytes.resize(116, b' ');
        bytes.resize(124, 0);
        bytes.extend(if big { [1, 0, b'M', b'I'] } else { [0, 1, b'I', b'M'] });
        bytes.extend(variables.concat());
        bytes
    }

    fn ramp(count: usize, start: f64) -> Vec<f64> {
        (0..count).map(|value| start + value as f64).collect()
    }

    /// A struct with a 2 × 100 matrix, a 100 × 2 matrix, a clock, gear ratios, a text and an object.
    fn log() -> Vec<u8> {
        let text = element(MATRIX, &[start(4, [1, 2], "", false), element(4, b"h\0i\0", false)].concat(), false);
        let object =
            element(MATRIX, &[element(6, &words(&[17, 0], false), false), element(1, b"robot", false)].concat(), false);
        let wide = numbers("", [2, 100], &ramp(200, 0.0), false);
        let tall = numbers("", [100, 2], &ramp(200, 1000.0), false);
        let ratios = numbers("", [1, 2], &[50.0, 100.0], false);
        file(
            &[
                compressed(&structure("rec", &[("q", wide), ("tau", tall), ("note", text), ("u", ratios)])),
                object,
                numbers("t", [100, 1], &ramp(100, 0.0), false),
            ],
            false,
        )
    }

    fn parse(bytes: &[u8]) -> Result<Table, MatError> {
        read(bytes, &mut Budget::of(bytes.len() as u64, 1 << 20), &Monitor::new())
    }

    #[test]
    fn structs_are_columns_by_path_and_the_longer_side_is_time() {
        let table = parse(&log()).unwrap();
        assert_eq!(table.names(), ["rec.q[0]", "rec.q[1]", "rec.tau[0]", "rec.tau[1]", "t"]);
        let column = |name: &str| table.column(name).unwrap().values.clone();
        assert_eq!(column("rec.q[1]")[..3], [1.0, 3.0, 5.0]);
        assert_eq!(column("rec.tau[1]")[..3], [1100.0, 1101.0, 1102.0]);
        assert_eq!(table.constants["rec.u"], ndarray::array![50.0, 100.0].into_dyn());
        assert_eq!(table.passed_over, ["`rec.note` (text)", "`robot` (an object)"]);
    }

    #[test]
    fn the_other_byte_order_is_read_too() {
        let table = parse(&file(&[numbers("q", [100, 1], &ramp(100, 0.5), true)], true)).unwrap();
        assert_eq!(table.column("q").unwrap().values[..2], [0.5, 1.5]);
    }

    #[test]
    fn truncated_and_damaged_files_are_clear_errors() {
        let whole = log();
        let mut sound = 0;
        for end in 0..whole.len() {
            match parse(&whole[..end]) {
                Ok(_) => sound += 1, // cut between variables
                Err(error) => assert!(error.to_string().contains("damaged") || error.to_string().contains("no array")),
            }
        }
        assert!(sound < 12, "{sound} cut files were read");
        for at in 128..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0xff;
            let _ = parse(&damaged); // an error or other numbers, but no panic
        }
    }

    #[test]
    fn sizes_that_lie_and_bombs_take_no_memory() {
        let liar =
            element(MATRIX, &[start(6, [u32::MAX / 2, 1], "x", false), element(9, &[0; 8], false)].concat(), false);
        assert!(parse(&file(&[liar], false)).is_err());
        let bomb = compressed(&numbers("x", [1 << 18, 1], &vec![0.0; 1 << 18], false));
        let error = parse(&file(&[bomb], false)).unwrap_err();
        assert!(error.to_string().contains("more than 1 MB"), "{error}");
        let mut nested = numbers("", [1, 1], &[1.0], false);
        for _ in 0..60 {
            nested = structure("", &[("a", nested)]);
        }
        assert!(parse(&file(&[nested], false)).unwrap_err().to_string().contains("deeply"));
    }

    /// A long name stands in the path of each of its fields: 400 MB here, of a file of 20 KB.
    #[test]
    fn names_are_on_the_account_too() {
        let text = || element(MATRIX, &[start(4, [1, 1], "", false), element(4, b"h\0", false)].concat(), false);
        let fields: Vec<(&str, Vec<u8>)> = (0..2000).map(|_| ("field", text())).collect();
        let bomb = file(&[compressed(&structure(&"x".repeat(200_000), &fields))], false);
        assert!(bomb.len() < 20_000, "{}", bomb.len());
        let error = read(&bomb, &mut Budget::of(bomb.len() as u64, 1 << 30), &Monitor::new()).unwrap_err();
        assert!(error.to_string().contains("beside its samples"), "{error}");
    }
}
