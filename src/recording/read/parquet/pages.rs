//! The pages of a part of a column, unpacked one by one: none to more than it claims, and none claims more than its values can take.
//!
//! Source: Apache Parquet, `parquet.thrift` (numbers of fields, encodings, codecs) and "Data Pages".

use std::io::{self, Read};
use std::vec::IntoIter;

use ::parquet::basic::{Compression, Encoding};
use ::parquet::column::page::{Page, PageMetadata, PageReader};
use ::parquet::errors::{ParquetError as Problem, Result};
use bytes::Bytes;

use super::super::budget::Budget;
use super::thrift::{self, Value};
use super::{ParquetError, damaged, delta};

/// How pages are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Codec {
    Plain,
    Snappy,
    Gzip,
    Zstd,
    Lz4,
}

impl Codec {
    /// By its name in the library.
    pub fn of(name: Compression) -> std::result::Result<Codec, ParquetError> {
        Ok(match name {
            Compression::UNCOMPRESSED => Codec::Plain,
            Compression::SNAPPY => Codec::Snappy,
            Compression::GZIP(_) => Codec::Gzip,
            Compression::ZSTD(_) => Codec::Zstd,
            Compression::LZ4_RAW => Codec::Lz4,
            Compression::BROTLI(_) => return Err(ParquetError::Codec("Brotli")),
            Compression::LZO => return Err(ParquetError::Codec("LZO")),
            Compression::LZ4 => return Err(ParquetError::Codec("Hadoop's LZ4")),
        })
    }

    /// Unpacks to `size` bytes, and to no more.
    fn unpack(self, packed: &[u8], size: usize) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        match self {
            Codec::Plain => bytes.extend_from_slice(packed),
            Codec::Gzip => {
                flate2::read::MultiGzDecoder::new(packed).take(size as u64 + 1).read_to_end(&mut bytes)?;
            }
            Codec::Zstd => {
                zstd::Decoder::new(packed)?.take(size as u64 + 1).read_to_end(&mut bytes)?;
            }
            Codec::Snappy => {
                bytes.resize(size, 0);
                let length = snap::raw::Decoder::new().decompress(packed, &mut bytes)?;
                bytes.truncate(length);
            }
            Codec::Lz4 => {
                bytes.resize(size, 0);
                let length = lz4_flex::block::decompress_into(packed, &mut bytes).map_err(io::Error::other)?;
                bytes.truncate(length);
            }
        }
        match bytes.len() == size {
            true => Ok(bytes),
            false => Err(io::Error::other(format!("a page does not unpack to the {size} bytes that it claims"))),
        }
    }
}

/// A page before it is unpacked.
struct Head {
    /// Where its bytes stand in the part.
    range: std::ops::Range<usize>,
    unpacked: usize,
    values: u32,
    encoding: Encoding,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Values,
    /// Of version 2: levels stand before what is packed.
    Split {
        nulls: u32,
        rows: u32,
        definitions: u32,
        repetitions: u32,
        is_packed: bool,
    },
    Dictionary,
}

/// What the type of a column says of its pages.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// What a number takes \[bytes\].
    pub width: usize,
    /// The highest levels that stand before the numbers: of lists, and of what may be missing.
    pub levels: [u16; 2],
}

/// The pages of a part of a column.
pub(super) struct Pages {
    bytes: Bytes,
    codec: Codec,
    shape: Shape,
    heads: IntoIter<Head>,
}

/// What pages may take beside their values \[bytes\].
const BESIDE: u64 = 1 << 16;
/// What a value and its levels may take in a page \[bytes\].
const VALUE: u64 = 16;

impl Pages {
    /// Looks through the heads of all pages; `at` names the column, which has `values` values here.
    pub fn of(
        bytes: &[u8],
        codec: Codec,
        shape: Shape,
        values: u64,
        at: &str,
        budget: &mut Budget,
    ) -> std::result::Result<Pages, ParquetError> {
        let (mut heads, mut place, mut counted) = (Vec::new(), 0, 0);
        while counted < values {
            let rest = &bytes[place..];
            let (head, length) = thrift::read(rest, budget).map_err(|problem| ParquetError::of(at, problem))?;
            let packed = head.number(3).and_then(|size| usize::try_from(size).ok());
            let end = packed.and_then(|size| length.checked_add(size)).filter(|end| *end <= rest.len());
            let end = end.ok_or_else(|| damaged(at, "a page claims to be longer than its column"))?;
            if let Some(head) = Head::of(&head, place + length..place + end).map_err(|problem| damaged(at, problem))? {
                // One dictionary stands before all that refers to it.
                let is_known = heads.first().is_some_and(|first: &Head| first.kind == Kind::Dictionary);
                match head.kind {
                    Kind::Dictionary if !heads.is_empty() => {
                        return Err(damaged(at, "a dictionary stands in its middle"));
                    }
                    Kind::Dictionary => {}
                    _ if head.encoding == Encoding::RLE_DICTIONARY && !is_known => {
                        return Err(damaged(at, "its dictionary is missing"));
                    }
                    _ => counted += u64::from(head.values),
                }
                if head.unpacked as u64 > u64::from(head.values) * VALUE + BESIDE {
                    return Err(damaged(at, "a page claims more bytes than its values can take"));
                }
                budget.unpack(head.unpacked as u64)?;
                heads.push(head);
            }
            place += end;
        }
        if counted > values {
            return Err(damaged(at, "its pages claim more values than the column"));
        }
        Ok(Pages { bytes: Bytes::copy_from_slice(bytes), codec, shape, heads: heads.into_iter() })
    }

    fn page(&self, head: Head) -> io::Result<Page> {
        let packed = &self.bytes[head.range.clone()];
        let num_values = head.values;
        let encoding = match head.encoding {
            Encoding::BYTE_STREAM_SPLIT | Encoding::DELTA_BINARY_PACKED => Encoding::PLAIN,
            other => other,
        };
        let numbers = |bytes: Vec<u8>, levels: Option<[usize; 2]>| {
            let readable = self.shape.readable(bytes, head.encoding, num_values as usize, levels);
            readable.ok_or_else(|| io::Error::other("the numbers of a page are cut, or more than it claims"))
        };
        let plain = |from: usize| self.codec.unpack(&packed[from..], head.unpacked - from);
        Ok(match head.kind {
            Kind::Values => Page::DataPage {
                buf: numbers(plain(0)?, None)?.into(),
                num_values,
                encoding,
                def_level_encoding: Encoding::RLE,
                rep_level_encoding: Encoding::RLE,
                statistics: None,
            },
            Kind::Dictionary => {
                Page::DictionaryPage { buf: plain(0)?.into(), num_values, encoding: Encoding::PLAIN, is_sorted: false }
            }
            Kind::Split { nulls, rows, definitions, repetitions, is_packed } => {
                let levels = definitions as usize + repetitions as usize;
                let mut buf = packed[..levels].to_vec();
                match is_packed && levels < head.unpacked {
                    true => buf.extend(plain(levels)?),
                    false => buf.extend_from_slice(&packed[levels..]),
                }
                Page::DataPageV2 {
                    buf: numbers(buf, Some([repetitions as usize, definitions as usize]))?.into(),
                    num_values,
                    encoding,
                    num_nulls: nulls,
                    num_rows: rows,
                    def_levels_byte_len: definitions,
                    rep_levels_byte_len: repetitions,
                    is_compressed: false,
                    statistics: None,
                }
            }
        })
    }
}

impl Shape {
    /// A page whose runs can all be read, and in which numbers that are written in another way stand one after another. The levels before
    /// them take so many bytes, or tell their lengths themselves. `None` if the page is cut, or has more than `most` numbers.
    fn readable(
        self,
        mut page: Vec<u8>,
        encoding: Encoding,
        most: usize,
        levels: Option<[usize; 2]>,
    ) -> Option<Vec<u8>> {
        let mut start = 0usize;
        for (index, level) in self.levels.into_iter().enumerate() {
            let length = match levels {
                Some(lengths) => lengths[index],
                None if level == 0 => 0,
                None => {
                    let length: [u8; 4] = page.get(start..start.checked_add(4)?)?.try_into().ok()?;
                    start += 4;
                    u32::from_le_bytes(length) as usize
                }
            };
            let end = start.checked_add(length)?;
            check_runs(page.get(start..end)?, (u16::BITS - level.leading_zeros()) as usize, most)?;
            start = end;
        }
        let numbers = &page[start..];
        let plain = match encoding {
            Encoding::DELTA_BINARY_PACKED => delta::plain(numbers, self.width, most)?,
            Encoding::BYTE_STREAM_SPLIT => self.joined(numbers)?,
            Encoding::RLE_DICTIONARY => {
                // A page without numbers has no indices either.
                let (bits, indices) = numbers.split_first().unwrap_or((&0, &[]));
                check_runs(indices, usize::from(*bits), most)?;
                return Some(page);
            }
            Encoding::RLE => {
                check_runs(numbers.get(4..)?, 1, most)?;
                return Some(page);
            }
            _ => return Some(page),
        };
        page.truncate(start);
        page.extend(plain);
        Some(page)
    }

    /// Numbers that are written split: the first bytes of all, then the second ones, ….
    fn joined(self, split: &[u8]) -> Option<Vec<u8>> {
        let count = split.len() / self.width;
        let numbers = (0..count).flat_map(|number| (0..self.width).map(move |byte| split[byte * count + number]));
        split.len().is_multiple_of(self.width).then(|| numbers.collect())
    }
}

/// Looks through runs of numbers of so many bits, until there are `most`: the library ends the program where the head of one is too long.
fn check_runs(mut bytes: &[u8], bits: usize, most: usize) -> Option<()> {
    let mut count = 0;
    while count < most && !bytes.is_empty() {
        let (head, length) = delta::varint(bytes).filter(|(head, _)| *head <= u64::from(u32::MAX))?;
        let run = (head >> 1) as usize;
        let (numbers, taken) = if head & 1 == 0 { (run, bits.div_ceil(8)) } else { (run.checked_mul(8)?, run * bits) };
        if numbers == 0 {
            return None;
        }
        count = count.saturating_add(numbers);
        // The last run may be shorter than it could be.
        bytes = bytes.get(length.checked_add(taken)?..).unwrap_or_default();
    }
    (bits <= 32).then_some(())
}

impl Head {
    /// `None` for a page that holds no values, such as an index.
    fn of(head: &Value, range: std::ops::Range<usize>) -> std::result::Result<Option<Head>, &'static str> {
        let unpacked = head.number(2).and_then(|size| usize::try_from(size).ok()).ok_or("a page has no size")?;
        let (about, kind) = match head.number(1) {
            Some(0) => {
                let about = head.field(5).ok_or("a page says nothing of its values")?;
                if [about.number(3), about.number(4)].contains(&Some(4)) {
                    return Err("its levels are packed in a way that was given up (BIT_PACKED)");
                }
                (about, Kind::Values)
            }
            Some(2) => (head.field(7).ok_or("a dictionary says nothing of its values")?, Kind::Dictionary),
            Some(3) => {
                let about = head.field(8).ok_or("a page says nothing of its values")?;
                let [nulls, rows, definitions, repetitions] = [2, 3, 5, 6].map(|field| count(about, field));
                let (definitions, repetitions) = (definitions?, repetitions?);
                let levels = definitions as usize + repetitions as usize;
                if levels > unpacked || levels > range.len() {
                    return Err("the levels of a page claim to be longer than it");
                }
                let is_packed = about.number(7) != Some(0);
                (about, Kind::Split { nulls: nulls?, rows: rows?, definitions, repetitions, is_packed })
            }
            _ => return Ok(None),
        };
        let (values, encoding) = match kind {
            Kind::Dictionary => (count(about, 1)?, Encoding::PLAIN),
            Kind::Values => (count(about, 1)?, encoding(about.number(2))?),
            Kind::Split { .. } => (count(about, 1)?, encoding(about.number(4))?),
        };
        Ok(Some(Head { range, unpacked, values, encoding, kind }))
    }
}

fn count(about: &Value, field: i16) -> std::result::Result<u32, &'static str> {
    about.number(field).and_then(|count| u32::try_from(count).ok()).ok_or("a page has an impossible number of values")
}

/// How numbers may be written.
fn encoding(number: Option<i64>) -> std::result::Result<Encoding, &'static str> {
    Ok(match number {
        Some(0) => Encoding::PLAIN,
        Some(2 | 8) => Encoding::RLE_DICTIONARY,
        Some(3) => Encoding::RLE,
        Some(5) => Encoding::DELTA_BINARY_PACKED,
        Some(9) => Encoding::BYTE_STREAM_SPLIT,
        _ => return Err("its values are written in a way that is not read"),
    })
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        let head = self.heads.next()?;
        Some(self.page(head).map_err(|problem| Problem::General(problem.to_string())))
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.next().transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        Ok(self.heads.as_slice().first().map(|head| PageMetadata {
            num_rows: match head.kind {
                Kind::Split { rows, .. } => Some(rows as usize),
                _ => None,
            },
            num_levels: (head.kind != Kind::Dictionary).then_some(head.values as usize),
            is_dict: head.kind == Kind::Dictionary,
        }))
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.heads.next();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_unpacks_to_more_than_it_claims() {
        let bytes = vec![0; 1 << 20];
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        io::Write::write_all(&mut gzip, &bytes).unwrap();
        for (codec, packed) in [
            (Codec::Plain, bytes.clone()),
            (Codec::Gzip, gzip.finish().unwrap()),
            (Codec::Zstd, zstd::encode_all(&bytes[..], 1).unwrap()),
            (Codec::Snappy, snap::raw::Encoder::new().compress_vec(&bytes).unwrap()),
            (Codec::Lz4, lz4_flex::block::compress(&bytes)),
        ] {
            assert_eq!(codec.unpack(&packed, bytes.len()).unwrap(), bytes, "{codec:?}");
            assert!(codec.unpack(&packed, 100).is_err() && codec.unpack(&packed, 2 << 20).is_err(), "{codec:?}");
        }
    }
}
