//! A pickle is a program for a small machine with a stack, which may ask for any function of Python.
//!
//! This machine knows what the few that make up numpy's arrays stand for, and makes the data itself; nothing is ever called. Whatever
//! else is asked for is refused by its name. What it makes lies in one list and refers to others by their places, so that neither
//! depth nor circles cost anything before they are looked at.
//! Source: Python's `pickletools`, where every instruction is described.

use std::borrow::Cow;
use std::collections::HashMap;

use super::PickleError;
use crate::progress::Monitor;
use crate::recording::npy::{Header, NpyError};
use crate::recording::read::arrays::BYTES;
use crate::recording::read::budget::Budget;

/// What a thing takes beside what is in it \[bytes\].
const THING: u64 = 64;
/// What it takes to keep one for later \[bytes\].
const KEPT: u64 = 40;
/// What a place on the stack takes while the stack grows, in which it is copied to a larger one.
const PLACE: u64 = 24;
/// Functions that we know take no more arguments, and states have no more parts.
const MOST_ARGUMENTS: usize = 16;
/// The longest name that they are given \[bytes\].
const LONGEST_NAME: usize = 64;
/// After so many instructions the monitor is asked.
const OFTEN: usize = 1 << 12;

/// The place of a thing in the list of all.
pub(super) type Id = usize;

/// Something that the pickle holds.
#[derive(Clone)]
pub(super) enum Thing<'a> {
    None,
    Number(f64),
    Text(String),
    Bytes(Cow<'a, [u8]>),
    /// A list, tuple or set.
    List(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    /// What stands for a function or type of Python.
    Known(Known),
    /// The type of an array's elements, such as `<f8`.
    Element(String),
    /// An array that is not filled yet.
    Empty,
    /// And the place of its bytes.
    Array(Box<Header>, Id),
    /// A module of numpy, as dill asks for it.
    Module,
}

/// The functions and types whose results we make ourselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Known {
    Reconstruct,
    FromBuffer,
    Scalar,
    Array,
    Element,
    Encode,
    Dict,
    ImportModule,
    GetAttribute,
}

fn known(module: &str, name: &str) -> Option<Known> {
    // numpy 2 calls its inside `_core`.
    let numpy = module.strip_prefix("numpy.core.").or_else(|| module.strip_prefix("numpy._core."));
    Some(match (numpy, module, name) {
        (Some("multiarray" | "_multiarray_umath"), _, "_reconstruct") => Known::Reconstruct,
        (Some("multiarray" | "_multiarray_umath"), _, "scalar") => Known::Scalar,
        (Some("numeric"), _, "_frombuffer") => Known::FromBuffer,
        (_, "numpy", "ndarray") => Known::Array,
        (_, "numpy", "dtype") => Known::Element,
        (_, "_codecs", "encode") => Known::Encode,
        (_, "collections", "OrderedDict") => Known::Dict,
        (_, "dill._dill" | "dill.dill", "_import_module") => Known::ImportModule,
        (_, "dill._dill" | "dill.dill", "_get_attr") => Known::GetAttribute,
        _ => return None,
    })
}

pub(super) struct Machine<'a, 'b> {
    bytes: &'a [u8],
    at: usize,
    things: Vec<Thing<'a>>,
    stack: Vec<Id>,
    /// How high the stack was at each mark that is not used yet.
    marks: Vec<usize>,
    /// How high both ever were together.
    highest: usize,
    memo: HashMap<u64, Id>,
    budget: &'b mut Budget,
}

impl<'a, 'b> Machine<'a, 'b> {
    /// Before the first instruction.
    pub(super) fn new(bytes: &'a [u8], budget: &'b mut Budget) -> Self {
        let (things, stack, marks, memo) = (Vec::new(), Vec::new(), Vec::new(), HashMap::new());
        Machine { bytes, at: 0, things, stack, marks, highest: 0, memo, budget }
    }

    /// Everything that it made, and what may still be taken.
    pub(super) fn made(self) -> (Vec<Thing<'a>>, &'b mut Budget) {
        (self.things, self.budget)
    }

    /// Obeys all instructions; what the pickle ends with.
    pub(super) fn run(&mut self, monitor: &Monitor) -> Result<Id, PickleError> {
        for count in 0.. {
            if count % OFTEN == 0 {
                monitor.check()?;
            }
            let instruction = self.take(1)?[0];
            if instruction == b'.' {
                return self.pop();
            }
            self.obey(instruction)?;
            let height = self.stack.len() + self.marks.len();
            if height > self.highest {
                self.budget.hold((height - self.highest) as u64 * PLACE)?;
                self.highest = height;
            }
        }
        Err(self.damaged("it has no end"))
    }

    fn obey(&mut self, instruction: u8) -> Result<(), PickleError> {
        match instruction {
            // How it is written, and what lies on the stack.
            0x80 => drop(self.take(1)?),
            0x95 => drop(self.take(8)?),
            b'(' => self.marks.push(self.stack.len()),
            b'0' => drop(self.pop()?),
            b'1' => drop(self.since_mark()?),
            b'2' => {
                let top = self.top()?;
                self.stack.push(top);
            }
            // Numbers and texts.
            b'N' => self.push(Thing::None)?,
            0x88 => self.push(Thing::Number(1.0))?,
            0x89 => self.push(Thing::Number(0.0))?,
            b'K' => self.whole(1, false)?,
            b'M' => self.whole(2, false)?,
            b'J' => self.whole(4, true)?,
            0x8a => {
                let size = self.size(1)?;
                self.whole(size, true)?;
            }
            0x8b => {
                let size = self.size(4)?;
                self.whole(size, true)?;
            }
            b'G' => {
                let bytes = self.take(8)?.try_into().map_err(|_| self.damaged("it ends within a number"))?;
                self.push(Thing::Number(f64::from_be_bytes(bytes)))?;
            }
            b'I' | b'L' | b'F' => {
                let text = self.line()?.trim_end_matches('L');
                let number = text.parse().map_err(|_| self.damaged("a number is none"))?;
                self.push(Thing::Number(number))?;
            }
            b'S' => {
                let bytes = unquoted(self.line()?).ok_or_else(|| self.damaged("a text has no quotes"))?;
                self.push(Thing::Bytes(Cow::Owned(bytes)))?;
            }
            b'V' => {
                let text = unescaped(self.line_of_bytes()?).ok_or_else(|| self.damaged("a text is none"))?;
                self.push(Thing::Text(text))?;
            }
            0x8c | b'X' | 0x8d => {
                let size = self.size(match instruction {
                    0x8c => 1,
                    b'X' => 4,
                    _ => 8,
                })?;
                let text = std::str::from_utf8(self.take(size)?).map_err(|_| self.damaged("a text is none"))?;
                self.push(Thing::Text(text.to_owned()))?;
            }
            b'C' | b'U' | b'B' | b'T' | 0x8e | 0x96 => {
                let size = self.size(match instruction {
                    b'C' | b'U' => 1,
                    b'B' | b'T' => 4,
                    _ => 8,
                })?;
                let bytes = self.take(size)?;
                self.push(Thing::Bytes(Cow::Borrowed(bytes)))?;
            }
            0x97 | 0x98 => return Err(PickleError::Elsewhere),
            // Lists and dicts; a tuple is a list here, and so is a set.
            b')' | b']' | 0x8f => self.push(Thing::List(Vec::new()))?,
            b'}' => self.push(Thing::Dict(Vec::new()))?,
            b't' | b'l' | 0x91 => {
                let items = self.since_mark()?;
                self.push_list(items)?;
            }
            0x85..=0x87 => {
                let count = usize::from(instruction - 0x84);
                let start = self.stack.len().checked_sub(count).ok_or_else(|| self.damaged("its stack is empty"))?;
                let items = self.stack.split_off(start);
                self.push_list(items)?;
            }
            b'd' => {
                let items = self.since_mark()?;
                self.push(Thing::Dict(Vec::new()))?;
                self.set(items)?;
            }
            b'a' => {
                let item = self.pop()?;
                self.append(vec![item])?;
            }
            b'e' | 0x90 => {
                let items = self.since_mark()?;
                self.append(items)?;
            }
            b's' => {
                let value = self.pop()?;
                let key = self.pop()?;
                self.set(vec![key, value])?;
            }
            b'u' => {
                let items = self.since_mark()?;
                self.set(items)?;
            }
            // What is kept to be used again.
            b'p' | b'q' | b'r' | 0x94 => {
                let key = match instruction {
                    b'p' => self.line()?.parse().map_err(|_| self.damaged("a number is none"))?,
                    b'q' => self.size(1)? as u64,
                    b'r' => self.size(4)? as u64,
                    _ => self.memo.len() as u64,
                };
                self.budget.hold(KEPT)?;
                let top = self.top()?;
                self.memo.insert(key, top);
            }
            b'g' | b'h' | b'j' => {
                let key = match instruction {
                    b'g' => self.line()?.parse().map_err(|_| self.damaged("a number is none"))?,
                    b'h' => self.size(1)? as u64,
                    _ => self.size(4)? as u64,
                };
                let kept = self.memo.get(&key).copied().ok_or_else(|| self.damaged("it uses what it has not kept"))?;
                self.stack.push(kept);
            }
            // What is asked of Python.
            b'c' => {
                let module = self.line()?;
                let name = self.line()?;
                self.ask_for(module, name)?;
            }
            0x93 => {
                let [name, module] = [self.pop()?, self.pop()?].map(|id| self.name(id));
                let (Some(name), Some(module)) = (name, module) else {
                    return Err(self.damaged("a name is none"));
                };
                self.ask_for(&module, &name)?;
            }
            b'R' => {
                let (arguments, function) = (self.pop()?, self.pop()?);
                self.call(function, arguments)?;
            }
            b'b' => {
                let state = self.pop()?;
                self.fill(state)?;
            }
            b'i' => {
                let name = format!("{}.{}", self.line()?, self.line()?);
                return Err(PickleError::Global { name });
            }
            b'o' | 0x81 | 0x92 => return Err(PickleError::Global { name: "an object of a class".to_owned() }),
            b'P' | b'Q' => return Err(PickleError::Global { name: "persistent_load".to_owned() }),
            0x82..=0x84 => return Err(PickleError::Global { name: "copyreg.add_extension".to_owned() }),
            _ => return Err(self.damaged("an instruction is unknown")),
        }
        Ok(())
    }

    fn damaged(&self, problem: &'static str) -> PickleError {
        PickleError::Damaged { at: self.at, problem }
    }

    /// The next bytes.
    fn take(&mut self, count: usize) -> Result<&'a [u8], PickleError> {
        let rest = &self.bytes[self.at..];
        let bytes = rest.get(..count).ok_or_else(|| self.damaged("it ends here, though more is announced"))?;
        self.at += count;
        Ok(bytes)
    }

    /// What stands before the end of a line.
    fn line_of_bytes(&mut self) -> Result<&'a [u8], PickleError> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == b'\n').ok_or_else(|| self.damaged("it ends within a line"))?;
        Ok(&self.take(end + 1)?[..end])
    }

    /// A text up to the end of its line.
    fn line(&mut self) -> Result<&'a str, PickleError> {
        std::str::from_utf8(self.line_of_bytes()?).map_err(|_| self.damaged("a text is none"))
    }

    /// A size in so many bytes.
    fn size(&mut self, bytes: usize) -> Result<usize, PickleError> {
        let mut word = [0; 8];
        word[..bytes].copy_from_slice(self.take(bytes)?);
        usize::try_from(u64::from_le_bytes(word)).map_err(|_| self.damaged("a size is beyond belief"))
    }

    /// A whole number in so many bytes.
    fn whole(&mut self, size: usize, is_signed: bool) -> Result<(), PickleError> {
        let bytes = self.take(size)?;
        let mut value = bytes.iter().rev().fold(0.0, |value, byte| 256.0 * value + f64::from(*byte));
        if is_signed && bytes.last().is_some_and(|byte| *byte >= 0x80) {
            value -= 256f64.powi(i32::try_from(size).unwrap_or(i32::MAX));
        }
        // With eight bytes and less, exactly.
        if let (true, Ok(1..=8)) = (is_signed, u32::try_from(size)) {
            let mut word = [if value < 0.0 { 0xff } else { 0 }; 8];
            word[..size].copy_from_slice(bytes);
            value = i64::from_le_bytes(word) as f64;
        }
        self.push(Thing::Number(value))
    }

    fn push(&mut self, thing: Thing<'a>) -> Result<(), PickleError> {
        match &thing {
            Thing::Number(_) => self.budget.hold(THING).map_err(|_| PickleError::Plain)?,
            Thing::Text(text) => self.budget.text(text)?,
            Thing::Bytes(Cow::Owned(bytes)) => self.budget.hold(bytes.len() as u64 + THING)?,
            _ => self.budget.hold(THING)?,
        }
        self.stack.push(self.things.len());
        self.things.push(thing);
        Ok(())
    }

    fn push_list(&mut self, items: Vec<Id>) -> Result<(), PickleError> {
        self.budget.hold(items.len() as u64 * BYTES)?;
        self.push(Thing::List(items))
    }

    fn pop(&mut self) -> Result<Id, PickleError> {
        self.stack.pop().ok_or_else(|| self.damaged("its stack is empty"))
    }

    fn top(&self) -> Result<Id, PickleError> {
        self.stack.last().copied().ok_or_else(|| self.damaged("its stack is empty"))
    }

    /// What was put on the stack since the last mark.
    fn since_mark(&mut self) -> Result<Vec<Id>, PickleError> {
        let mark = self.marks.pop().filter(|mark| *mark <= self.stack.len());
        let mark = mark.ok_or_else(|| self.damaged("a mark is missing"))?;
        Ok(self.stack.split_off(mark))
    }

    fn append(&mut self, items: Vec<Id>) -> Result<(), PickleError> {
        self.budget.hold(items.len() as u64 * BYTES)?;
        let top = self.top()?;
        match &mut self.things[top] {
            Thing::List(list) => list.extend(items),
            _ => return Err(self.damaged("it adds to what is no list")),
        }
        Ok(())
    }

    fn set(&mut self, items: Vec<Id>) -> Result<(), PickleError> {
        self.budget.hold(items.len() as u64 * BYTES)?;
        let top = self.top()?;
        match &mut self.things[top] {
            Thing::Dict(dict) => dict.extend(items.chunks_exact(2).map(|pair| (pair[0], pair[1]))),
            _ => return Err(self.damaged("it adds to what is no dict")),
        }
        Ok(())
    }

    /// A short text.
    fn name(&self, id: Id) -> Option<String> {
        match &self.things[id] {
            Thing::Text(text) if text.len() > LONGEST_NAME => None,
            Thing::Bytes(bytes) if bytes.len() > LONGEST_NAME => None,
            thing => text(thing),
        }
    }

    /// The few things that a function takes, or a state has.
    fn few(&self, id: Id) -> Option<Vec<Id>> {
        match &self.things[id] {
            Thing::List(items) if items.len() <= MOST_ARGUMENTS => Some(items.clone()),
            _ => None,
        }
    }

    fn ask_for(&mut self, module: &str, name: &str) -> Result<(), PickleError> {
        let known = known(module, name).ok_or_else(|| PickleError::Global { name: format!("{module}.{name}") })?;
        self.push(Thing::Known(known))
    }

    /// The result of a function that we know, made by ourselves.
    fn call(&mut self, function: Id, arguments: Id) -> Result<(), PickleError> {
        let Thing::Known(function) = self.things[function] else {
            return Err(self.damaged("it calls what is no function"));
        };
        let arguments =
            self.few(arguments).ok_or_else(|| self.damaged("the arguments of a function are no tuple of a few"))?;
        let result = match (function, arguments.as_slice()) {
            (Known::Reconstruct, _) => Thing::Empty,
            (Known::Dict, []) => Thing::Dict(Vec::new()),
            (Known::Element, [name, ..]) => {
                Thing::Element(self.name(*name).ok_or_else(|| self.damaged("the type of an array has no name"))?)
            }
            (Known::Scalar, [element, value]) => self.scalar(*element, *value)?,
            (Known::FromBuffer, [bytes, element, shape, order]) => {
                let is_fortran = self.name(*order).as_deref() == Some("F");
                self.array(*element, *shape, is_fortran, *bytes)?
            }
            (Known::Encode, [letters, code]) if self.name(*code).is_some_and(|code| code.starts_with("latin")) => {
                let letters = text(&self.things[*letters]).unwrap_or_default();
                let bytes =
                    letters.chars().map(|letter| u8::try_from(u32::from(letter))).collect::<Result<Vec<u8>, _>>();
                Thing::Bytes(Cow::Owned(bytes.map_err(|_| self.damaged("bytes are none"))?))
            }
            (Known::ImportModule, [module]) => {
                let module = self.name(*module).unwrap_or_default();
                if known(&module, "_reconstruct").is_none() {
                    return Err(PickleError::Global { name: module });
                }
                Thing::Module
            }
            (Known::GetAttribute, [module, name]) if matches!(self.things[*module], Thing::Module) => {
                let name = self.name(*name).unwrap_or_default();
                return self.ask_for("numpy.core.multiarray", &name);
            }
            (function, _) => {
                return Err(PickleError::Global { name: format!("{function:?} (in a way that is not known)") });
            }
        };
        self.push(result)
    }

    /// Gives an array its elements, or the type of elements its byte order.
    fn fill(&mut self, state: Id) -> Result<(), PickleError> {
        let top = self.top()?;
        let of_a_class = || PickleError::Global { name: "an object of a class".to_owned() };
        let state = self.few(state).ok_or_else(of_a_class)?;
        let filled = match (&self.things[top], state.as_slice()) {
            (Thing::Empty, [_, shape, element, is_fortran, values]) => {
                let is_fortran = matches!(self.things[*is_fortran], Thing::Number(flag) if flag != 0.0);
                match &self.things[*values] {
                    // An array of objects: as good as a list.
                    Thing::List(items) => {
                        self.budget.hold(items.len() as u64 * BYTES)?;
                        Thing::List(items.clone())
                    }
                    _ => self.array(*element, *shape, is_fortran, *values)?,
                }
            }
            (Thing::Element(name), [_, order, ..]) => {
                let order = self.name(*order).unwrap_or_default();
                Thing::Element(format!("{order}{}", name.trim_start_matches(['<', '>', '|', '='])))
            }
            _ => return Err(of_a_class()),
        };
        self.things[top] = filled;
        Ok(())
    }

    fn array(&self, element: Id, shape: Id, is_fortran: bool, values: Id) -> Result<Thing<'a>, PickleError> {
        let Thing::List(sizes) = &self.things[shape] else { return Err(self.damaged("the shape of an array is none")) };
        let size = |id: &Id| match self.things[*id] {
            Thing::Number(size) if size >= 0.0 && size.fract() == 0.0 => Ok(size as usize),
            _ => Err(self.damaged("the shape of an array is none")),
        };
        let shape = sizes.iter().map(size).collect::<Result<Vec<usize>, _>>()?;
        self.elements(element, is_fortran, shape, values)
    }

    /// An array of these bytes; what its elements can't be is no array of numbers.
    fn elements(&self, element: Id, is_fortran: bool, shape: Vec<usize>, values: Id) -> Result<Thing<'a>, PickleError> {
        let Thing::Element(element) = &self.things[element] else {
            return Err(self.damaged("the type of an array's elements is none"));
        };
        let Thing::Bytes(bytes) = &self.things[values] else {
            return Err(self.damaged("the elements of an array are no bytes"));
        };
        let wrong = |problem| PickleError::Array { at: self.at, problem };
        let header = match Header::of(element, is_fortran, shape) {
            Err(NpyError::NotNumbers(_)) => return Ok(Thing::None),
            header => header.map_err(wrong)?,
        };
        header.check_size(bytes.len() as u64).map_err(wrong)?;
        Ok(Thing::Array(Box::new(header), values))
    }

    /// A number of numpy's.
    fn scalar(&self, element: Id, value: Id) -> Result<Thing<'a>, PickleError> {
        let array = self.elements(element, false, Vec::new(), value)?;
        let (Thing::Array(header, _), Thing::Bytes(bytes)) = (array, &self.things[value]) else {
            return Ok(Thing::None);
        };
        let values = header.values(&mut &bytes[..]).map_err(|problem| PickleError::Array { at: self.at, problem })?;
        Ok(values.first().map_or(Thing::None, |value| Thing::Number(*value)))
    }
}

pub(super) fn text(thing: &Thing) -> Option<String> {
    match thing {
        Thing::Text(text) => Some(text.clone()),
        Thing::Bytes(bytes) => String::from_utf8(bytes.to_vec()).ok(),
        _ => None,
    }
}

/// The bytes of a text as Python 2 wrote it, in quotes and with escapes.
fn unquoted(line: &str) -> Option<Vec<u8>> {
    let line = line.trim_end();
    let quote = line.chars().next().filter(|letter| matches!(letter, '\'' | '"'))?;
    let inside = line[1..].strip_suffix(quote)?;
    let mut bytes = Vec::new();
    let mut rest = inside.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'\\' {
            bytes.push(byte);
            continue;
        }
        bytes.push(match rest.next()? {
            b'n' => b'\n',
            b'r' => b'\r',
            b't' => b'\t',
            b'x' => {
                let digits = [rest.next()?, rest.next()?];
                u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
            }
            escaped @ (b'\\' | b'\'' | b'"') => escaped,
            _ => return None,
        });
    }
    Some(bytes)
}

/// A text of Latin letters in which others are given by their numbers.
fn unescaped(line: &[u8]) -> Option<String> {
    let line: String = line.iter().map(|byte| char::from(*byte)).collect();
    let mut text = String::new();
    let mut rest = line.as_str();
    while let Some((before, after)) = rest.split_once('\\') {
        text.push_str(before);
        let digits = match after.chars().next() {
            Some('u') => 4,
            Some('U') => 8,
            _ => {
                text.push('\\');
                rest = after;
                continue;
            }
        };
        let number = u32::from_str_radix(after.get(1..=digits)?, 16).ok()?;
        text.push(char::from_u32(number)?);
        rest = &after[1 + digits..];
    }
    Some(text + rest)
}
