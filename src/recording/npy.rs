//! One NPY array: a header that is a Python dict, then the elements.
//!
//! Read by hand, because a header may lie: every size is checked before anything is allocated, and nothing is evaluated.

use std::io::Read;

use ndarray::{ArrayD, IxDyn, ShapeBuilder};

/// No header is longer \[bytes\]; those that numpy writes for numbers have some hundred.
const MOST_HEADER: u32 = 1 << 16;
/// So many bytes of elements are read at once: whole elements of every size.
const CHUNK: usize = 1 << 13;

/// The array can't be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NpyError {
    /// It is not an array of numbers, but a sound array: it may be passed over.
    #[error("{0}")]
    NotNumbers(String),
    /// As 64-bit numbers it would take more memory than is allowed.
    #[error("it takes too much memory")]
    TooLarge,
    /// The bytes are damaged.
    #[error("the array is damaged: {0}; write the file again")]
    Damaged(String),
}

/// How the elements of an array are stored, and how many there are.
#[derive(Clone)]
pub struct Header {
    element: Element,
    fortran_order: bool,
    shape: Vec<usize>,
    count: usize,
    /// What the header takes \[bytes\].
    length: u64,
}

/// Decodes a whole NPY file of at most `most` elements, to an array in C order.
///
/// # Errors
/// [`NpyError`] if it is damaged, too large, or does not hold numbers.
pub fn decode(bytes: &[u8], most: usize) -> Result<ArrayD<f64>, NpyError> {
    let mut rest = bytes;
    let header = Header::read(&mut rest)?;
    header.check_size(bytes.len() as u64)?;
    if header.count > most { Err(NpyError::TooLarge) } else { header.values(&mut rest) }
}

impl Header {
    /// Reads it from the beginning of an NPY file, and leaves the elements.
    ///
    /// # Errors
    /// [`NpyError::NotNumbers`] if the elements are something else, [`NpyError::Damaged`] if it is no header.
    pub fn read(source: &mut dyn Read) -> Result<Header, NpyError> {
        let damaged = |problem: &str| NpyError::Damaged(problem.to_owned());
        let (mut start, mut long) = ([0; 10], [0; 2]);
        source.read_exact(&mut start).map_err(|_| damaged("it does not begin like an NPY array"))?;
        let [b'\x93', b'N', b'U', b'M', b'P', b'Y', version, _, first, second] = start else {
            return Err(damaged("it does not begin like an NPY array"));
        };
        let early = |_| damaged("it ends within its header");
        let (start, length) = match version {
            1 => (10, u32::from(u16::from_le_bytes([first, second]))),
            2 | 3 => {
                source.read_exact(&mut long).map_err(early)?;
                (12, u32::from_le_bytes([first, second, long[0], long[1]]))
            }
            _ => return Err(damaged("its NPY version is unknown")),
        };
        if length > MOST_HEADER {
            return Err(damaged("its header is longer than any"));
        }
        let mut text = vec![0; length as usize];
        source.read_exact(&mut text).map_err(early)?;
        let text = std::str::from_utf8(&text).map_err(|_| damaged("its header is not text"))?;
        let missing = || damaged("its header lacks the element type, the order or the shape");

        let element = field(text, "descr").ok_or_else(missing)?;
        let quote = element.chars().next().filter(|c| matches!(c, '\'' | '"'));
        let Some(element) = quote.and_then(|quote| element[1..].split(quote).next()) else {
            return Err(NpyError::NotNumbers(
                "it is a structured array; save each of its fields as an array".to_owned(),
            ));
        };
        let order = field(text, "fortran_order").ok_or_else(missing)?;
        let shape =
            field(text, "shape").and_then(|rest| rest.strip_prefix('(')?.split(')').next()).ok_or_else(missing)?;
        let sizes = shape.split(',').map(|size| size.trim().trim_end_matches('L')).filter(|size| !size.is_empty());
        let shape =
            sizes.map(str::parse).collect::<Result<Vec<usize>, _>>().map_err(|_| damaged("its shape is no shape"))?;
        let length = start + u64::from(length);
        Ok(Header { length, ..Header::of(element, order.starts_with("True"), shape)? })
    }

    /// That of elements of this type (such as `<f8`) which stand alone, without a header before them.
    ///
    /// # Errors
    /// As [`Header::read`].
    pub fn of(element: &str, fortran_order: bool, shape: Vec<usize>) -> Result<Header, NpyError> {
        let element = Element::parse(element)?;
        let count = shape.iter().try_fold(1usize, |product, size| product.checked_mul(*size));
        let count = count.filter(|count| count.checked_mul(element.size).is_some());
        let count = count.ok_or_else(|| NpyError::Damaged(format!("its header claims the shape {shape:?}")))?;
        Ok(Header { element, fortran_order, shape, count, length: 0 })
    }

    /// Its sizes, the slowest first.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// How many elements there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// How long a file of these elements is \[bytes\].
    pub fn size(&self) -> u64 {
        ((self.count * self.element.size) as u64).saturating_add(self.length)
    }

    /// Whether a file of so many bytes holds these elements, and nothing else.
    ///
    /// # Errors
    /// [`NpyError::Damaged`] if not.
    pub fn check_size(&self, bytes: u64) -> Result<(), NpyError> {
        let needed = (self.count * self.element.size) as u64;
        let found = bytes.saturating_sub(self.length);
        if needed == found {
            return Ok(());
        }
        Err(NpyError::Damaged(format!(
            "its header claims the shape {:?}, which takes {needed} bytes, but {found} follow",
            self.shape
        )))
    }

    /// Reads the elements that follow the header, to an array in C order. They take 8 bytes each, and so little beside that a
    /// file that is unpacked on the way is never in memory as a whole.
    ///
    /// # Errors
    /// [`NpyError::Damaged`] if they can't be read to their end.
    pub fn values(&self, source: &mut dyn Read) -> Result<ArrayD<f64>, NpyError> {
        let unreadable = |problem: std::io::Error| NpyError::Damaged(problem.to_string());
        let mut values = Vec::with_capacity(self.count);
        let mut chunk = [0; CHUNK];
        while values.len() < self.count {
            let bytes = &mut chunk[..CHUNK.min((self.count - values.len()) * self.element.size)];
            source.read_exact(bytes).map_err(unreadable)?;
            values.extend(bytes.chunks_exact(self.element.size).map(|bytes| self.element.value(bytes)));
        }
        // Only at its end a source knows whether its checksum is right.
        if source.read(&mut chunk[..1]).map_err(unreadable)? != 0 {
            return Err(NpyError::Damaged(format!("more follows than its shape {:?} takes", self.shape)));
        }
        let stored = IxDyn(&self.shape).set_f(self.fortran_order);
        let array = ArrayD::from_shape_vec(stored, values).map_err(|error| NpyError::Damaged(error.to_string()))?;
        Ok(if array.is_standard_layout() { array } else { array.as_standard_layout().into_owned() })
    }
}

/// The text after `'key':`.
fn field<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let rest = ['\'', '"'].iter().find_map(|quote| Some(header.split_once(&format!("{quote}{key}{quote}"))?.1))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

/// The type of the elements.
#[derive(Clone, Copy)]
struct Element {
    kind: Kind,
    size: usize,
    big_endian: bool,
}

#[derive(Clone, Copy)]
enum Kind {
    Float,
    Signed,
    Unsigned,
}

impl Element {
    fn parse(text: &str) -> Result<Element, NpyError> {
        let not_numbers = |problem: String| Err(NpyError::NotNumbers(problem));
        let big_endian = text.starts_with('>');
        let bare = text.trim_start_matches(['<', '>', '|', '=']);
        if bare.starts_with('O') {
            return not_numbers(
                "it holds Python objects, which could run code when read; if it is a list of runs of unequal length, \
                 save each run as a file of its own, or pad them with NaN to one float array (run, sample, joint)"
                    .to_owned(),
            );
        }
        let Some((kind, size)) = bare.split_at_checked(1) else {
            return not_numbers("it has no element type".to_owned());
        };
        let (kind, size) = match (kind, size) {
            ("f", "4" | "8") => (Kind::Float, size),
            ("i", "1" | "2" | "4" | "8") => (Kind::Signed, size),
            ("u", "1" | "2" | "4" | "8") | ("b", "1") => (Kind::Unsigned, size),
            _ => return not_numbers(format!("its elements are of type `{text}`; save it with .astype(float)")),
        };
        Ok(Element { kind, size: usize::from(size.as_bytes()[0] - b'0'), big_endian })
    }

    fn value(&self, bytes: &[u8]) -> f64 {
        // The bytes as one little-endian number, its sign carried up.
        let mut word = [0; 8];
        for (place, byte) in word.iter_mut().zip(bytes) {
            *place = *byte;
        }
        if self.big_endian {
            word[..self.size].reverse();
        }
        let raw = u64::from_le_bytes(word);
        let unused = 64 - 8 * self.size as u32;
        match self.kind {
            Kind::Float if self.size == 4 => f64::from(f32::from_bits(raw as u32)),
            Kind::Float => f64::from_bits(raw),
            Kind::Signed => ((raw << unused) as i64 >> unused) as f64,
            Kind::Unsigned => raw as f64,
        }
    }
}

/// An NPY file, version 1.0, C order, of elements of this type (such as `<f8`) that are given as bytes.
pub fn encode(element: &str, shape: &[usize], bytes: impl Iterator<Item = u8>) -> Vec<u8> {
    const ALIGNMENT: usize = 64;
    const PREAMBLE: usize = 10;
    let sizes: String = shape.iter().map(|size| format!("{size}, ")).collect();
    let mut header = format!("{{'descr': '{element}', 'fortran_order': False, 'shape': ({}), }}", sizes.trim_end());
    let padding = (PREAMBLE + header.len() + 1).next_multiple_of(ALIGNMENT) - (PREAMBLE + header.len() + 1);
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes());
    file.extend(bytes);
    file
}

#[cfg(test)]
mod tests {
    use ndarray::{Array, arr0, array};

    use super::*;

    fn decode(bytes: &[u8]) -> Result<ArrayD<f64>, NpyError> {
        super::decode(bytes, 1000)
    }

    fn npy(element: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{element}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn reads_any_number_type_in_both_byte_orders() {
        for (element, data) in [
            ("<f8", (-2.0f64).to_le_bytes().to_vec()),
            (">f8", (-2.0f64).to_be_bytes().to_vec()),
            ("<f4", (-2.0f32).to_le_bytes().to_vec()),
            (">f4", (-2.0f32).to_be_bytes().to_vec()),
            ("|i1", (-2i8).to_le_bytes().to_vec()),
            (">i2", (-2i16).to_be_bytes().to_vec()),
            ("<i4", (-2i32).to_le_bytes().to_vec()),
            (">i8", (-2i64).to_be_bytes().to_vec()),
        ] {
            assert_eq!(decode(&npy(element, "False", "(1,)", &data)).unwrap(), array![-2.0].into_dyn(), "{element}");
        }
        assert_eq!(decode(&npy(">u2", "False", "()", &[0xff, 0xfe])).unwrap(), arr0(65534.0).into_dyn());
        assert_eq!(decode(&npy("|b1", "False", "(2,)", &[0, 1])).unwrap(), array![0.0, 1.0].into_dyn());
    }

    #[test]
    fn fortran_order_becomes_c_order() {
        // [[0, 1, 2], [3, 4, 5]] is stored by columns.
        let array = decode(&npy("|u1", "True", "(2, 3)", &[0, 3, 1, 4, 2, 5])).unwrap();
        assert_eq!(array, array![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]].into_dyn());
        assert!(array.is_standard_layout());
        let cube: Vec<u8> =
            (0..2).flat_map(|c| (0..3).flat_map(move |b| (0..2).map(move |a| 6 * a + 2 * b + c))).collect();
        let ordered = Array::from_iter((0..12).map(f64::from)).into_shape_with_order(IxDyn(&[2, 3, 2])).unwrap();
        assert_eq!(decode(&npy("|u1", "True", "(2, 3, 2)", &cube)).unwrap(), ordered);
    }

    #[test]
    fn lying_and_broken_headers_are_errors_without_allocation() {
        for shape in
            ["(1000000000000,)", "(18446744073709551615, 9)", "(4294967296, 4294967296)", "(2,)", "(-1,)", "(x,)", "()"]
        {
            let error = decode(&npy("<f8", "False", shape, &[0; 24])).unwrap_err();
            assert!(matches!(error, NpyError::Damaged(_)), "{shape}: {error}");
        }
        let whole = npy("<f8", "False", "(1,)", &[0; 8]);
        for end in 0..whole.len() {
            assert!(decode(&whole[..end]).is_err());
        }
        assert!(decode(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{").is_err());
        assert!(decode(&npy("<f8", "False", &"(".repeat(30_000), &[])).is_err());
    }

    #[test]
    fn more_elements_than_allowed_are_refused_before_they_are_decoded() {
        assert_eq!(decode(&npy("|u1", "False", "(1001,)", &[0; 1001])), Err(NpyError::TooLarge));
    }

    #[test]
    fn objects_texts_and_records_are_no_numbers() {
        for element in ["|O", "<U3", "<c16", "<f2", "", "<M8[ns]"] {
            let error = decode(&npy(element, "False", "(1,)", &[0; 8])).unwrap_err();
            assert!(matches!(error, NpyError::NotNumbers(_)), "{element}");
        }
        let mut record = npy("x", "False", "(1,)", &[]);
        let at = record.windows(3).position(|w| w == b"'x'").unwrap();
        record.splice(at..at + 3, b"[('a', '<f8')]".iter().copied());
        let length = (record.len() - 10) as u16;
        record[8..10].copy_from_slice(&length.to_le_bytes());
        assert!(matches!(decode(&record).unwrap_err(), NpyError::NotNumbers(_)));
    }
}
