//! Thrift's compact protocol, in which Parquet keeps what it says of itself, as a tree: so that its claims can be checked before anybody
//! makes room for them.
//!
//! Source: Apache Thrift, "Thrift Compact protocol encoding".

use super::super::budget::{Budget, TooMuch};

/// Values may lie in each other this deep.
const DEEPEST: usize = 24;
/// What a value takes in memory \[bytes\], beside what it points to.
const TAKES: u64 = 96;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value<'a> {
    /// Of any width; also true (1) and false (0).
    Number(i64),
    /// Bytes or a text.
    Bytes(&'a [u8]),
    List(Vec<Value<'a>>),
    /// By the numbers of the fields.
    Struct(Vec<(i16, Value<'a>)>),
    /// What is of no use here: floating point numbers, maps.
    Other,
}

/// Why there is no value.
#[derive(Debug)]
pub(super) enum Wrong {
    Lie(&'static str),
    TooMuch(TooMuch),
}

impl From<TooMuch> for Wrong {
    fn from(problem: TooMuch) -> Self {
        Wrong::TooMuch(problem)
    }
}

impl<'a> Value<'a> {
    /// A field of a struct.
    pub fn field(&self, number: i16) -> Option<&Value<'a>> {
        match self {
            Value::Struct(fields) => fields.iter().find(|(own, _)| *own == number).map(|(_, value)| value),
            _ => None,
        }
    }

    /// A number in a field of a struct.
    pub fn number(&self, field: i16) -> Option<i64> {
        match self.field(field)? {
            Value::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// A list in a field of a struct; empty if there is none.
    pub fn list(&self, field: i16) -> &[Value<'a>] {
        match self.field(field) {
            Some(Value::List(values)) => values,
            _ => &[],
        }
    }
}

/// The struct with which these bytes begin, and how long it is.
pub(super) fn read<'a>(bytes: &'a [u8], budget: &mut Budget) -> Result<(Value<'a>, usize), Wrong> {
    let mut reader = Reader { bytes, at: 0, budget };
    let value = reader.fields(0)?;
    Ok((value, reader.at))
}

struct Reader<'a, 'b> {
    bytes: &'a [u8],
    at: usize,
    budget: &'b mut Budget,
}

impl<'a> Reader<'a, '_> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Wrong> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or(Wrong::Lie("it ends within a value"))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, Wrong> {
        Ok(self.take(1)?[0])
    }

    fn varint(&mut self) -> Result<u64, Wrong> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(Wrong::Lie("a number in it is too long"))
    }

    fn signed(&mut self) -> Result<i64, Wrong> {
        let value = self.varint()?;
        Ok((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    /// How many elements follow, each of a byte at least.
    fn count(&self, claimed: u64) -> Result<usize, Wrong> {
        let left = self.bytes.len() - self.at;
        let count = usize::try_from(claimed).ok().filter(|count| *count <= left);
        count.ok_or(Wrong::Lie("a list in it claims to be longer than the file"))
    }

    fn fields(&mut self, depth: usize) -> Result<Value<'a>, Wrong> {
        if depth > DEEPEST {
            return Err(Wrong::Lie("its parts lie too deep in each other"));
        }
        let (mut fields, mut number) = (Vec::new(), 0i16);
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(Value::Struct(fields));
            }
            number = match head >> 4 {
                0 => self.signed()? as i16,
                step => number.wrapping_add(i16::from(step)),
            };
            let value = match head & 0x0f {
                1 => Value::Number(1),
                2 => Value::Number(0),
                kind => self.value(kind, depth)?,
            };
            self.budget.hold(TAKES)?;
            fields.push((number, value));
        }
    }

    fn value(&mut self, kind: u8, depth: usize) -> Result<Value<'a>, Wrong> {
        Ok(match kind {
            // In lists a truth is a byte of its own.
            1..=3 => Value::Number(i64::from(self.byte()? as i8)),
            4..=6 => Value::Number(self.signed()?),
            7 => {
                self.take(8)?;
                Value::Other
            }
            8 => {
                let claimed = self.varint()?;
                let count = self.count(claimed)?;
                Value::Bytes(self.take(count)?)
            }
            9 | 10 => {
                let head = self.byte()?;
                let claimed = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
                let mut values = Vec::new();
                for _ in 0..self.count(claimed)? {
                    self.budget.hold(TAKES)?;
                    values.push(self.element(head & 0x0f, depth)?);
                }
                Value::List(values)
            }
            11 => {
                let claimed = self.varint()?;
                let kinds = if claimed == 0 { 0 } else { self.byte()? };
                for _ in 0..self.count(claimed)? {
                    self.element(kinds >> 4, depth)?;
                    self.element(kinds & 0x0f, depth)?;
                }
                Value::Other
            }
            12 => self.fields(depth + 1)?,
            13 => {
                self.take(16)?;
                Value::Other
            }
            _ => return Err(Wrong::Lie("a value in it is of no known kind")),
        })
    }

    /// A value in a list or a map, which may hold lists again.
    fn element(&mut self, kind: u8, depth: usize) -> Result<Value<'a>, Wrong> {
        if depth >= DEEPEST {
            return Err(Wrong::Lie("its parts lie too deep in each other"));
        }
        self.value(kind, depth + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(bytes: &[u8]) -> Result<(Value<'_>, usize), String> {
        read(bytes, &mut Budget::of(100, 1 << 20)).map_err(|problem| format!("{problem:?}"))
    }

    #[test]
    fn fields_are_found_by_their_numbers() {
        // 1: -3 (i32); 4: [{2: "ab"}]; 20: true
        let bytes = [0x15, 0x05, 0x39, 0x1c, 0x28, 0x02, b'a', b'b', 0x00, 0x01, 0x28, 0x00, 9];
        let (value, length) = parse(&bytes).unwrap();
        assert_eq!((value.number(1), value.number(20), length), (Some(-3), Some(1), bytes.len() - 1));
        assert_eq!(value.list(4)[0].field(2), Some(&Value::Bytes(b"ab")));
        for end in 0..bytes.len() - 1 {
            assert!(parse(&bytes[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn lies_take_no_memory() {
        // A list of 2³¹ numbers, a text of as many letters, and lists in lists without end.
        assert!(parse(&[0x19, 0xf5, 0x80, 0x80, 0x80, 0x80, 0x08, 0]).unwrap_err().contains("longer than the file"));
        assert!(parse(&[0x18, 0x80, 0x80, 0x80, 0x80, 0x08, 0]).unwrap_err().contains("longer than the file"));
        assert!(parse(&[&[0x19][..], &[0x19; 1000]].concat()).unwrap_err().contains("too deep"));
        assert!(parse(&[0x1c; 1000]).unwrap_err().contains("too deep"));
        assert!(parse(&[0x16, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1]).is_err());
        let many = [&[0x19, 0xf5, 0xc0, 0x84, 0x3d][..], &vec![0; 1_000_000], &[0]].concat();
        assert!(
            read(&many, &mut Budget::of(100, 1 << 20)).is_err(),
            "a million values are more than a small file holds"
        );
    }
}
