//! JSON: arrays by key (`{"time": […], "q": [[…], …]}`), or one object a sample (JSON Lines, or an array of objects).
//!
//! Numbers go straight into columns; what lies between is never held as a tree. Objects in objects are named with a dot.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;

use ndarray::{ArrayD, IxDyn};
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::arrays::{self, ArraysError, BYTES};
use super::budget::{Budget, TooMuch};
use super::share::Share;
use super::table::{Column, MOST_COLUMNS, Table};
use crate::progress::{Monitor, Stopped};

/// The text makes no table.
#[derive(Debug, thiserror::Error)]
pub enum JsonError {
    /// No JSON.
    #[error("line {line}, column {column}: {problem}; JSON has no NaN and no comments: write null for what is missing")]
    Syntax {
        /// Counted from 1.
        line: usize,
        /// Counted from 1.
        column: usize,
        /// What is wrong there.
        problem: String,
    },
    /// Its arrays make no table.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// Nothing in it is a sample.
    #[error("it holds no samples; a log is an object of arrays by key, or one object a sample")]
    NoSamples,
    /// Some of it is samples, some not.
    #[error("value {0} is no object, but the ones before it are; write one object a sample")]
    Mixed(usize),
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The user asked to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl JsonError {
    /// An error in a part of a text that begins behind so many bytes of it.
    fn syntax(error: &serde_json::Error, text: &[u8], begin: usize) -> Self {
        let before = &text[..begin];
        let lines = before.iter().filter(|byte| **byte == b'\n').count();
        let in_line = before.iter().rev().take_while(|byte| **byte != b'\n').count();
        let message = error.to_string();
        // Its place is told before it.
        let problem = message.split(" at line ").next().unwrap_or_default().to_owned();
        let column = error.column() + if error.line() == 1 { in_line } else { 0 };
        JsonError::Syntax { line: lines + error.line(), column, problem }
    }
}

/// Reads a text.
pub(super) fn read(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Table, JsonError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut account = Account { budget, monitor, wrong: None };
    let mut share = Share::of(bytes.len() as u64, monitor);
    let mut rows = Rows::default();
    let mut values = 0;
    let mut first = None;
    // Where each value ends is looked for first: a reader that is asked whether another one follows counts the lines up to there.
    let mut stream = serde_json::Deserializer::from_slice(bytes).into_iter::<IgnoredAny>();
    let mut begin = 0;
    while let Some(value) = stream.next() {
        value.map_err(|error| JsonError::syntax(&error, bytes, 0))?;
        let end = stream.byte_offset();
        let mut deserializer = serde_json::Deserializer::from_slice(&bytes[begin..end]);
        let node = Seed(&mut account).deserialize(&mut deserializer);
        let node = match (account.wrong.take(), node) {
            (Some(wrong), _) => return Err(wrong),
            (None, node) => node.map_err(|error| JsonError::syntax(&error, bytes, begin))?,
        };
        begin = end;
        share.is(end as u64)?;
        values += 1;
        match (node, values) {
            (node, 1) => first = Some(node),
            (Node::Object(object), _) => {
                if let Some(Node::Object(before)) = first.take() {
                    rows.add(before, &mut account)?;
                }
                rows.add(object, &mut account)?;
            }
            _ => return Err(JsonError::Mixed(values)),
        }
    }
    match first {
        None => rows.table(account.budget),
        Some(Node::Rows(rows)) => rows.table(account.budget),
        Some(Node::Object(object)) => {
            let (arrays, passed_over) = whole(object);
            Ok(arrays::table(arrays, passed_over, account.budget)?)
        }
        Some(_) => Err(JsonError::NoSamples),
    }
}

/// What an entry of an object takes in memory beside the letters of its key, while its list grows.
const ENTRY: u64 = 200;

/// What is taken, and why it was enough.
struct Account<'a> {
    budget: &'a mut Budget,
    monitor: &'a Monitor,
    wrong: Option<JsonError>,
}

/// An object on its way into columns.
#[derive(Default)]
struct Object {
    entries: Vec<(String, Node)>,
    /// What it takes beside the numbers \[bytes\], what is in it included.
    held: u64,
}

/// A value on its way into columns.
enum Node {
    Number(f64),
    /// Numbers of this shape, the last index fastest.
    Array(Vec<usize>, Vec<f64>),
    Object(Object),
    Rows(Rows),
    /// No numbers, in a word.
    Other(&'static str),
}

/// Reads one value.
struct Seed<'s, 'a>(&'s mut Account<'a>);

impl<'de> DeserializeSeed<'de> for Seed<'_, '_> {
    type Value = Node;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Node, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Seed<'_, '_> {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Number(f64::NAN))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Node, E> {
        Ok(Node::Other("true or false"))
    }

    fn visit_str<E>(self, _: &str) -> Result<Node, E> {
        Ok(Node::Other("text"))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Node, A::Error> {
        let account = self.0;
        let mut all = Sequence::default();
        while let Some(node) = sequence.next_element_seed(Seed(account))? {
            if let Err(wrong) = all.add(node, account) {
                account.wrong = Some(wrong);
                return Err(serde::de::Error::custom("enough"));
            }
        }
        Ok(all.node())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node, A::Error> {
        let account = self.0;
        let mut object = Object::default();
        while let Some(key) = map.next_key::<String>()? {
            let takes = key.len() as u64 + ENTRY;
            if let Err(wrong) = account.budget.hold(takes) {
                account.wrong = Some(wrong.into());
                return Err(serde::de::Error::custom("enough"));
            }
            let node = map.next_value_seed(Seed(account))?;
            object.held += takes + if let Node::Object(inner) = &node { inner.held } else { 0 };
            object.entries.push((key, node));
        }
        Ok(Node::Object(object))
    }
}

/// An array on its way.
#[derive(Default)]
struct Sequence {
    count: usize,
    /// Of each element; what is of another is no array.
    shape: Option<Vec<usize>>,
    values: Vec<f64>,
    rows: Option<Rows>,
    other: Option<&'static str>,
}

impl Sequence {
    fn add(&mut self, node: Node, account: &mut Account) -> Result<(), JsonError> {
        account.monitor.check()?;
        self.count += 1;
        let (shape, values) = match node {
            Node::Object(object) if self.shape.is_none() => {
                return self.rows.get_or_insert_default().add(object, account);
            }
            Node::Number(number) => (Vec::new(), vec![number]),
            Node::Array(shape, values) => (shape, values),
            Node::Other(other) => {
                self.other = Some(other);
                return Ok(());
            }
            Node::Object(_) | Node::Rows(_) => {
                self.other = Some("objects among other values");
                return Ok(());
            }
        };
        if self.shape.get_or_insert_with(|| shape.clone()) != &shape {
            self.other = Some("rows of different lengths");
        }
        if self.other.is_none() {
            account.budget.unpack(values.len() as u64 * BYTES)?;
            self.values.extend(values);
        }
        Ok(())
    }

    fn node(self) -> Node {
        match self {
            Sequence { other: Some(other), .. } => Node::Other(other),
            Sequence { rows: Some(_), shape: Some(_), .. } => Node::Other("objects among other values"),
            Sequence { rows: Some(rows), .. } => Node::Rows(rows),
            Sequence { count, shape, values, .. } => {
                let inner = shape.unwrap_or_default();
                Node::Array([vec![count], inner].concat(), values)
            }
        }
    }
}

/// One object a sample.
#[derive(Default)]
struct Rows {
    count: usize,
    /// In the order in which their names came.
    columns: Vec<(String, Vec<f64>)>,
    places: BTreeMap<String, usize>,
    passed_over: BTreeMap<String, &'static str>,
}

impl Rows {
    fn add(&mut self, object: Object, account: &mut Account) -> Result<(), JsonError> {
        account.monitor.check()?;
        self.count += 1;
        let held = object.held;
        self.take(String::new(), object, account)?;
        account.budget.give_back(held);
        Ok(())
    }

    fn take(&mut self, prefix: String, object: Object, account: &mut Account) -> Result<(), JsonError> {
        for (key, node) in object.entries {
            let name = if prefix.is_empty() { key } else { format!("{prefix}.{key}") };
            match node {
                Node::Number(number) => self.put(name, number, account)?,
                Node::Array(shape, values) if shape.len() == 1 => {
                    for (index, value) in values.into_iter().enumerate() {
                        self.put(format!("{name}[{index}]"), value, account)?;
                    }
                }
                Node::Object(inner) => self.take(name, inner, account)?,
                Node::Array(..) => self.pass_over(name, "an array of arrays", account)?,
                Node::Rows(_) => self.pass_over(name, "objects", account)?,
                Node::Other(other) => self.pass_over(name, other, account)?,
            }
        }
        Ok(())
    }

    fn put(&mut self, name: String, value: f64, account: &mut Account) -> Result<(), JsonError> {
        let place = match self.places.get(&name) {
            Some(place) => *place,
            None if self.columns.len() >= MOST_COLUMNS => return Err(ArraysError::TooWide.into()),
            None => {
                account.budget.name(&name)?;
                self.columns.push((name.clone(), Vec::new()));
                self.places.insert(name, self.columns.len() - 1);
                self.columns.len() - 1
            }
        };
        let values = &mut self.columns[place].1;
        let missing = (self.count - 1).saturating_sub(values.len());
        // What is missing stands in no file: no log has much of it. A column that grows is twice there.
        account.budget.hold(2 * missing as u64 * BYTES)?;
        account.budget.unpack(BYTES)?;
        values.resize(self.count - 1, f64::NAN);
        values.push(value);
        Ok(())
    }

    fn pass_over(&mut self, name: String, what: &'static str, account: &mut Account) -> Result<(), JsonError> {
        if let Entry::Vacant(place) = self.passed_over.entry(name) {
            account.budget.text(place.key())?;
            place.insert(what);
        }
        Ok(())
    }

    fn table(self, budget: &mut Budget) -> Result<Table, JsonError> {
        let count = self.count;
        if count == 0 || self.columns.is_empty() {
            return Err(JsonError::NoSamples);
        }
        let mut columns = Vec::new();
        for (name, mut values) in self.columns {
            budget.hold((count - values.len()) as u64 * BYTES)?;
            values.resize(count, f64::NAN);
            columns.push(Column { name, values, text: None });
        }
        let runs = std::iter::once(0..count).collect();
        let passed_over = self.passed_over.into_iter().map(|(name, what)| format!("`{name}` ({what})")).collect();
        Ok(Table { columns, runs, passed_over, ..Table::default() })
    }
}

/// Arrays by name, and what is none.
type Arrays = (Vec<(String, ArrayD<f64>)>, Vec<String>);

/// The arrays of an object; those that stand joint after joint are turned to sample after sample.
fn whole(object: Object) -> Arrays {
    let (mut arrays, mut passed_over) = (Vec::new(), Vec::new());
    collect(String::new(), object, &mut arrays, &mut passed_over);
    let clock = arrays.iter().filter(|(_, array)| array.ndim() == 1).map(|(_, array)| array.len()).max();
    for (_, array) in &mut arrays {
        let is_by_joint = array.ndim() == 2 && Some(array.shape()[1]) == clock && Some(array.shape()[0]) != clock;
        if is_by_joint {
            array.swap_axes(0, 1);
        }
    }
    (arrays, passed_over)
}

fn collect(prefix: String, object: Object, arrays: &mut Vec<(String, ArrayD<f64>)>, passed_over: &mut Vec<String>) {
    for (key, node) in object.entries {
        let name = if prefix.is_empty() { key } else { format!("{prefix}.{key}") };
        let array = match node {
            Node::Number(number) => ArrayD::from_elem(IxDyn(&[1]), number),
            Node::Array(shape, values) => match ArrayD::from_shape_vec(IxDyn(&shape), values) {
                Ok(array) => array,
                Err(_) => {
                    passed_over.push(format!("`{name}` (rows of different lengths)"));
                    continue;
                }
            },
            Node::Object(inner) => {
                collect(name, inner, arrays, passed_over);
                continue;
            }
            Node::Rows(_) => {
                passed_over.push(format!("`{name}` (objects)"));
                continue;
            }
            Node::Other(other) => {
                passed_over.push(format!("`{name}` ({other})"));
                continue;
            }
        };
        arrays.push((name, array));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Table, JsonError> {
        read(text.as_bytes(), &mut Budget::of(text.len() as u64, 1 << 30), &Monitor::new())
    }

    fn values(table: &Table, name: &str) -> Vec<f64> {
        table.column(name).unwrap().values.clone()
    }

    #[test]
    fn arrays_by_key_in_either_order() {
        let by_sample = r#"{"time":[0,1,2],"robot":{"q":[[1,2],[3,4],[5,6]]},"name":["a","b"],"rate":10}"#;
        let read = table(by_sample).unwrap();
        assert_eq!((values(&read, "robot.q[1]"), values(&read, "time")), (vec![2.0, 4.0, 6.0], vec![0.0, 1.0, 2.0]));
        assert_eq!((read.passed_over.as_slice(), read.step), (&["`name` (text)".to_owned()][..], Some(0.1)));
        let by_joint = table(r#"{"time":[0,1,2],"q":[[1,3,5],[2,4,6]]}"#).unwrap();
        assert_eq!(values(&by_joint, "q[1]"), [2.0, 4.0, 6.0]);
    }

    #[test]
    fn one_object_a_sample_as_lines_or_as_an_array() {
        let lines =
            "{\"t\":0,\"q\":[1,2],\"at\":{\"x\":1}}\n{\"t\":1,\"q\":[3,null]}\n\n{\"t\":2,\"q\":[5,6],\"late\":7}\n";
        let array = format!("[{}]", lines.trim().replace("\n\n", "\n").replace('\n', ","));
        for text in [lines, &array] {
            let read = table(text).unwrap();
            assert_eq!((values(&read, "t"), values(&read, "q[0]")), (vec![0.0, 1.0, 2.0], vec![1.0, 3.0, 5.0]));
            assert!(values(&read, "q[1]")[1].is_nan() && values(&read, "at.x")[2].is_nan());
            assert!(values(&read, "late")[1].is_nan() && values(&read, "late")[2] == 7.0);
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let message = |text: &str| table(text).unwrap_err().to_string();
        assert!(
            message("{\"q\":[1,\n NaN]}").starts_with("line 2, column 2: expected value;"),
            "{}",
            message("{\"q\":[1,\n NaN]}")
        );
        assert!(message("{\"q\":[1,2").contains("EOF"), "{}", message("{\"q\":[1,2"));
        assert!(message("{\"t\":1}\n3").contains("value 2 is no object"));
        assert!(message("[1,2]").contains("no samples") && message("{}").contains("no array"));
        let out_of_range = message("{\"t\":1}\n {\"t\":\n 1e999}");
        assert!(out_of_range.starts_with("line 3, column 6: number out of range"), "{out_of_range}");
        assert!(
            message("{\"t\":1}\n{\"t\":2}x").starts_with("line 2, column 8: "),
            "{}",
            message("{\"t\":1}\n{\"t\":2}x")
        );
        let deep = "[".repeat(100_000) + &"]".repeat(100_000);
        assert!(message(&deep).contains("recursion"), "{}", message(&deep));
        // Ever new keys would fill a table with nothing.
        let keys: String = (0..20_000).map(|number| format!("{{\"k{number}\":1}}\n")).collect();
        assert!(matches!(table(&keys), Err(JsonError::TooMuch(_) | JsonError::Arrays(_))));
    }
}
