//! Whole numbers that are written as what each adds to the one before (DELTA_BINARY_PACKED), as plain ones: the library ends the program
//! where such a page lies.
//!
//! Source: Apache Parquet, "Encodings", delta encoding.

/// The numbers of a page, of so many bytes each; no more than `most`. `None` if it is cut, or lies.
pub(super) fn plain(packed: &[u8], width: usize, most: usize) -> Option<Vec<u8>> {
    let mut reader = Reader { bytes: packed };
    let (block, parts) = (reader.count()?, reader.count()?);
    let count = reader.count()?;
    let per_part = block.checked_div(parts)?;
    if count > most || per_part % 32 != 0 || parts > packed.len() {
        return None;
    }
    let mut value = reader.signed()?;
    let mut numbers = Vec::with_capacity(count * width);
    let mut left = count;
    let mut push = |value: i64| {
        numbers.extend(value.to_le_bytes().into_iter().take(width));
    };
    if left > 0 {
        push(value);
        left -= 1;
    }
    while left > 0 {
        let least = reader.signed()?;
        let bits = reader.take(parts)?;
        for bits in bits {
            // What follows the last number is not written.
            if left == 0 {
                break;
            }
            let bits = usize::from(*bits);
            let deltas = reader.take(per_part.checked_mul(bits)? / 8)?;
            for index in 0..per_part.min(left) {
                value = value.wrapping_add(least).wrapping_add(bits_at(deltas, index * bits, bits)? as i64);
                push(value);
            }
            left -= per_part.min(left);
        }
        if per_part == 0 {
            return None;
        }
    }
    Some(numbers)
}

/// A number of at most 64 bits that begins at a bit, the least first.
fn bits_at(bytes: &[u8], at: usize, bits: usize) -> Option<u64> {
    if bits > 64 {
        return None;
    }
    let (first, last) = (at / 8, (at + bits).div_ceil(8));
    let whole = bytes.get(first..last)?.iter().rev().fold(0u128, |sum, byte| sum << 8 | u128::from(*byte));
    Some((whole >> (at % 8)) as u64 & (u128::pow(2, bits as u32) - 1) as u64)
}

/// The number with which bytes begin, seven bits in each, and how many they are.
pub(super) fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut value = 0;
    for (index, byte) in bytes.iter().take(10).enumerate() {
        value |= u64::from(byte & 0x7f) << (7 * index);
        if byte & 0x80 == 0 {
            return Some((value, index + 1));
        }
    }
    None
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (now, later) = self.bytes.split_at_checked(count)?;
        self.bytes = later;
        Some(now)
    }

    fn varint(&mut self) -> Option<u64> {
        let (value, length) = varint(self.bytes)?;
        self.take(length).map(|_| value)
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(self.varint()?).ok()
    }

    fn signed(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification: 7, 5, 3, 1, 2, 3, 4, 5 in blocks of 128 of four parts.
    #[test]
    fn the_example_of_the_specification() {
        let deltas = [0b1100_0000, 0b0011_1111, 0, 0, 0, 0, 0, 0];
        let page = [&[0x80, 1, 4, 8, 14, 3, 2, 0, 0, 0][..], &deltas].concat();
        let numbers = |width: usize| {
            let plain = plain(&page, width, 8).unwrap();
            plain.chunks(width).map(|bytes| bytes[0]).collect::<Vec<u8>>()
        };
        assert_eq!((numbers(4), numbers(8)), (vec![7, 5, 3, 1, 2, 3, 4, 5], vec![7, 5, 3, 1, 2, 3, 4, 5]));
        assert!((0..page.len()).all(|end| plain(&page[..end], 8, 8).is_none()));
        assert!(plain(&page, 8, 7).is_none() && plain(&[0xff; 40], 8, 8).is_none());
    }
}
