//! Messages of ROS 2 by the text of their definition, as named numbers: so that every message with arrays of positions and torques can be
//! read, and not only joint states.
//!
//! Source: ROS 2, "About ROS 2 interfaces" (the language of .msg files); MCAP, "ros2msg" schemas (definitions of nested types stand
//! behind lines of `=` and `MSG: package/Type`).

use std::collections::{HashMap, HashSet};

use super::cdr::Cdr;
use super::idl;

/// No definition is longer \[bytes\]: it is taken apart before anything is known of it.
const LONGEST: usize = 1 << 20;
/// Types may lie in each other this deep.
const DEEPEST: usize = 12;
/// No message has more numbers: a log has a row of them for each.
const MOST_NUMBERS: usize = 4096;
/// Elements of an array that have no bytes of their own (an empty type) are not counted by the bytes that are left.
const MOST_ELEMENTS: usize = 65_536;

/// The states of joints, the same in every version of ROS 2: they are known where a log does not define them.
pub(super) const JOINT_STATE: &str = "sensor_msgs/msg/JointState";
const JOINT_STATE_TEXT: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
     ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
     ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

/// The definition of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Definition {
    root: String,
    types: HashMap<String, Vec<Field>>,
}

#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    kind: Kind,
    count: Count,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// `bytes`, and whether it is a float or has a sign.
    Number(Number),
    Text,
    Type(String),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

/// What a message holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Message {
    pub shape: Shape,
    pub values: Vec<f64>,
}

/// All of a message but its numbers: most messages of a topic have the same.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Shape {
    /// The path of each number.
    paths: Vec<String>,
    /// Arrays of texts by their paths: names of joints, of interfaces.
    texts: Vec<(String, Vec<String>)>,
    /// How many elements the other arrays have, by their paths.
    arrays: Vec<(String, usize)>,
}

/// What a number of a message is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Named {
    head: String,
    /// Of which joint it is, and the place of that; it stands between head and tail.
    joint: Option<(usize, String)>,
    tail: String,
}

impl Definition {
    /// Reads the text of a definition; `name` is that of the message, such as `sensor_msgs/msg/JointState`.
    pub fn parse(name: &str, text: &str) -> Result<Definition, String> {
        let root = short(name);
        let mut types: HashMap<String, Vec<Field>> = HashMap::new();
        let mut current = root.clone();
        types.insert(root.clone(), Vec::new());
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if let Some(next) = line.strip_prefix("MSG:") {
                current = short(next.trim());
                types.entry(current.clone()).or_default();
            } else if !line.is_empty() && !line.starts_with("===") {
                let package = current.split('/').next().unwrap_or_default().to_owned();
                if let Some(field) = field(line, &package)? {
                    types.entry(current.clone()).or_default().push(field);
                }
            }
        }
        let definition = Definition { root, types };
        definition.check(&definition.root, 0)?;
        Ok(definition)
    }

    /// That of a message by a text in this encoding; joint states need none.
    pub fn of(name: &str, encoding: &str, text: &str) -> Result<Definition, String> {
        let definition = match encoding {
            _ if text.len() > LONGEST => Err(format!("its definition is longer than {} kB", LONGEST >> 10)),
            "" => Err("it has no definition".to_owned()),
            "ros2msg" | "ros2idl" if text.trim().is_empty() => Err("it has no definition".to_owned()),
            "ros2msg" => Definition::parse(name, text),
            "ros2idl" => idl::as_messages(name, text).and_then(|text| Definition::parse(name, &text)),
            other => Err(format!("its definition is in `{other}`, not in ros2msg or ros2idl")),
        };
        match name {
            JOINT_STATE => definition.or_else(|_| Definition::parse(JOINT_STATE, JOINT_STATE_TEXT)),
            _ => definition,
        }
    }

    /// What it takes in memory \[bytes\].
    pub fn size(&self) -> u64 {
        let name = |name: &str| name.len() + size_of::<Field>();
        let kind = |kind: &Kind| if let Kind::Type(inner) = kind { inner.len() } else { 0 };
        let field = |field: &Field| name(&field.name) + kind(&field.kind);
        self.types.iter().map(|(key, fields)| name(key) + fields.iter().map(field).sum::<usize>()).sum::<usize>() as u64
    }

    /// Whether all types are there, and none holds itself.
    fn check(&self, name: &str, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("the type {name} is nested deeper than {DEEPEST}"));
        }
        let fields = self.types.get(name).ok_or_else(|| format!("the type {name} is not defined"))?;
        fields.iter().try_for_each(|field| match &field.kind {
            Kind::Type(inner) => self.check(inner, depth + 1),
            Kind::Number(_) | Kind::Text => Ok(()),
        })
    }

    /// What a message in CDR holds.
    pub fn decode(&self, bytes: &[u8]) -> Result<Message, &'static str> {
        let mut message = Message::default();
        self.fields(&self.root, "", &mut Cdr::new(bytes)?, &mut message)?;
        Ok(message)
    }

    fn fields(&self, name: &str, path: &str, cdr: &mut Cdr, message: &mut Message) -> Result<(), &'static str> {
        let fields = self.types.get(name).ok_or("its type is not defined")?;
        for Field { name, kind, count } in fields {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let (count, is_array) = match count {
                Count::One => (1, false),
                Count::Fixed(count) => (*count, true),
                Count::Any => (cdr.count(0)?, true),
            };
            if count > MOST_ELEMENTS {
                return Err("it claims an impossible number of elements");
            }
            let place = |index: usize| if is_array { format!("{path}[{index}]") } else { path.clone() };
            if is_array && !matches!(kind, Kind::Text) {
                message.shape.arrays.push((path.clone(), count));
            }
            match kind {
                Kind::Text => {
                    let texts = (0..count).map(|_| cdr.text()).collect::<Result<Vec<_>, _>>()?;
                    if is_array && (names_joints(&path) || path.contains('[')) {
                        message.shape.texts.push((path, texts));
                    }
                }
                // Pictures and point clouds are arrays of bytes, and no samples.
                Kind::Number(Number::U8 | Number::I8) if is_array => cdr.skip(count)?,
                Kind::Number(number) => {
                    for index in 0..count {
                        let value = number.read(cdr)?;
                        if message.values.len() < MOST_NUMBERS {
                            message.shape.paths.push(place(index));
                            message.values.push(value);
                        }
                    }
                }
                Kind::Type(inner) => {
                    for index in 0..count {
                        self.fields(inner, &place(index), cdr, message)?;
                    }
                }
            }
        }
        if fields.is_empty() {
            // An empty message is written as one byte.
            cdr.word::<1>()?;
        }
        Ok(())
    }
}

/// Whether an array of texts is of names of joints.
fn names_joints(path: &str) -> bool {
    let field = path.rsplit('.').next().unwrap_or_default();
    ["name", "names", "joint_names", "joint_name"].contains(&field)
}

/// What a path lies in; empty for what lies in nothing.
fn outer(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(outer, _)| outer)
}

/// The arrays that a path leads through, the innermost first: where the bracket of each is, and the index in it.
fn indices(path: &str) -> impl Iterator<Item = (usize, usize)> {
    path.rmatch_indices('[').filter_map(|(at, _)| {
        let (index, _) = path[at + 1..].split_once(']')?;
        Some((at, index.parse().ok()?))
    })
}

impl Shape {
    /// All its texts.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        let texts = self.texts.iter().flat_map(|(path, texts)| std::iter::once(path).chain(texts));
        let arrays = self.arrays.iter().map(|(path, _)| path);
        self.paths.iter().chain(texts).chain(arrays).map(String::as_str)
    }

    /// Whether each array beside the names of the joints has a number for each of these, or none at all.
    pub fn has_a_value_for_each_joint(&self) -> bool {
        let named = self.texts.iter().find(|(path, _)| outer(path).is_empty()).map_or(0, |(_, names)| names.len());
        let fits = |count: usize| named == 0 || count == 0 || count == named;
        self.arrays.iter().filter(|(path, _)| outer(path).is_empty()).all(|(_, count)| fits(*count))
    }

    /// What each number is. An array with as many elements as there are names of joints beside it, or further out, has one for each
    /// of these joints. Values that stand beside texts of the same number in an inner type are named by these:
    /// `interface_values[1].values[0]`, where `interface_names` begins with `effort`, is `effort[1]`.
    pub fn named(&self) -> Vec<Named> {
        let names = Names::of(self);
        self.paths.iter().map(|path| names.named(path)).collect()
    }
}

/// What the texts of a message say of its numbers.
struct Names<'a> {
    arrays: HashMap<&'a str, usize>,
    /// Names of joints, by what they lie in. A joint that is named twice is none that could be told from others.
    joints: HashMap<&'a str, &'a [String]>,
    /// Other names in inner types.
    interfaces: HashMap<&'a str, &'a [String]>,
}

impl<'a> Names<'a> {
    fn of(shape: &'a Shape) -> Names<'a> {
        let arrays = shape.arrays.iter().map(|(path, count)| (path.as_str(), *count)).collect();
        let mut names = Names { arrays, joints: HashMap::new(), interfaces: HashMap::new() };
        for (path, texts) in &shape.texts {
            let are_unlike = || texts.iter().collect::<HashSet<_>>().len() == texts.len();
            let (kind, is_usable) = match names_joints(path) {
                true => (&mut names.joints, are_unlike()),
                false => (&mut names.interfaces, true),
            };
            if is_usable {
                kind.entry(outer(path)).or_insert(texts.as_slice());
            }
        }
        names
    }

    fn named(&self, path: &str) -> Named {
        // What is named by its interface is so in place of all up to the array around it.
        let (text, place) = match self.interface(path) {
            Some(text) => (text, outer(path)),
            None => ("", path),
        };
        let start = if text.is_empty() { 0 } else { place.rfind('[').unwrap_or_default() };
        match self.joint(place).filter(|(at, ..)| *at >= start) {
            Some((at, index, joint)) => {
                let tail = place[at..].find(']').map_or("", |end| &place[at + end..]);
                let head = format!("{text}{}", &place[start..=at]);
                Named { head, joint: Some((index, joint.to_owned())), tail: tail.to_owned() }
            }
            None => Named { head: format!("{text}{}", &place[start..]), joint: None, tail: String::new() },
        }
    }

    /// The text that stands for an element of an array beside texts in an inner type.
    fn interface(&self, path: &str) -> Option<&'a str> {
        let (at, index) = indices(path).next().filter(|_| path.ends_with(']'))?;
        let texts = self.interfaces.get(outer(&path[..at]))?;
        let is_one_each = self.arrays.get(&path[..at]) == Some(&texts.len());
        texts.get(index).filter(|_| is_one_each).map(String::as_str)
    }

    /// The innermost array of one element a joint that a path leads through: its bracket, the index in it, and the joint.
    fn joint(&self, path: &str) -> Option<(usize, usize, &'a str)> {
        indices(path).find_map(|(at, index)| {
            let array = &path[..at];
            let mut around = outer(array);
            let joints = loop {
                match self.joints.get(around) {
                    Some(joints) => break joints,
                    None if around.is_empty() => return None,
                    None => around = outer(around),
                }
            };
            let is_one_each = self.arrays.get(array) == Some(&joints.len());
            joints.get(index).filter(|_| is_one_each).map(|joint| (at, index, joint.as_str()))
        })
    }
}

impl Named {
    /// What its column is called.
    pub fn name(&self) -> String {
        match &self.joint {
            Some((place, _)) => format!("{}{place}{}", self.head, self.tail),
            None => self.head.clone(),
        }
    }

    /// The same with the joint in place of where it stands.
    pub fn label(&self) -> String {
        format!("{}{}{}", self.head, self.joint().unwrap_or_default(), self.tail)
    }

    /// The joint that it is of.
    pub fn joint(&self) -> Option<&str> {
        self.joint.as_ref().map(|(_, joint)| joint.as_str())
    }

    /// Gives its joint the place that it has among others; false if it has none there.
    pub fn follow(&mut self, places: &HashMap<&str, usize>) -> bool {
        let Some((place, joint)) = &mut self.joint else { return true };
        let found = places.get(joint.as_str());
        found.iter().for_each(|found| *place = **found);
        found.is_some()
    }

    /// Whether it tells when the message was measured.
    pub fn is_of_the_clock(&self) -> bool {
        self.head.starts_with("header.") || self.head == "time"
    }
}

/// `package/msg/Type` as `package/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A line of a definition; constants are no fields.
fn field(line: &str, package: &str) -> Result<Option<Field>, String> {
    let mut words = line.split_whitespace();
    let (Some(kind), Some(name)) = (words.next(), words.next()) else {
        return Err(format!("`{line}` is no field"));
    };
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, bound)) => match bound.trim_end_matches(']') {
            "" => (kind, Count::Any),
            bound if bound.starts_with("<=") => (kind, Count::Any),
            number => (kind, Count::Fixed(number.parse().map_err(|_| format!("`{line}` has no number of elements"))?)),
        },
    };
    // A bound of a text says nothing of how it is written.
    let plain = kind.split("<=").next().unwrap_or_default();
    let kind = match (Number::named(plain), plain) {
        (Some(number), _) => Kind::Number(number),
        (None, "string") => Kind::Text,
        (None, "wstring") => return Err("wide texts (wstring) are not read".to_owned()),
        (None, "Header") => Kind::Type("std_msgs/Header".to_owned()),
        (None, inner) if inner.contains('/') => Kind::Type(short(inner)),
        (None, inner) => Kind::Type(format!("{package}/{inner}")),
    };
    Ok(Some(Field { name: name.to_owned(), kind, count }))
}

impl Number {
    fn named(name: &str) -> Option<Number> {
        Some(match name {
            "bool" | "byte" | "uint8" | "char" => Number::U8,
            "int8" => Number::I8,
            "uint16" => Number::U16,
            "int16" => Number::I16,
            "uint32" => Number::U32,
            "int32" => Number::I32,
            "uint64" => Number::U64,
            "int64" => Number::I64,
            "float32" => Number::F32,
            "float64" => Number::F64,
            _ => return None,
        })
    }

    fn read(self, cdr: &mut Cdr) -> Result<f64, &'static str> {
        Ok(match self {
            Number::U8 => f64::from(u8::from_le_bytes(cdr.word()?)),
            Number::I8 => f64::from(i8::from_le_bytes(cdr.word()?)),
            Number::U16 => f64::from(u16::from_le_bytes(cdr.word()?)),
            Number::I16 => f64::from(i16::from_le_bytes(cdr.word()?)),
            Number::U32 => f64::from(u32::from_le_bytes(cdr.word()?)),
            Number::I32 => f64::from(i32::from_le_bytes(cdr.word()?)),
            Number::U64 => u64::from_le_bytes(cdr.word()?) as f64,
            Number::I64 => i64::from_le_bytes(cdr.word()?) as f64,
            Number::F32 => f64::from(f32::from_le_bytes(cdr.word()?)),
            Number::F64 => f64::from_le_bytes(cdr.word()?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::read::cdr::CdrWriter;

    const DYNAMIC: &str = "# of ros2_control\nstd_msgs/Header header\nstring[] joint_names\nInterfaceValue[] interface_values\n\
        ================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
        ================\nMSG: control_msgs/InterfaceValue\nuint8 MOST=3\nstring[] interface_names\nfloat64[] values\n";

    fn message() -> Vec<u8> {
        let mut message = CdrWriter::new();
        message.word(7i32.to_le_bytes()).word(5u32.to_le_bytes()).text("base").texts(&["shoulder", "elbow"]);
        message.word(2u32.to_le_bytes());
        for joint in 0..2 {
            message.texts(&["position", "effort"]).numbers(&[0.5 + f64::from(joint), -2.0 * f64::from(joint)]);
        }
        message.end()
    }

    #[test]
    fn a_message_is_read_by_the_text_of_its_definition() {
        let definition = Definition::parse("control_msgs/msg/DynamicJointState", DYNAMIC).unwrap();
        let read = definition.decode(&message()).unwrap();
        let named = read.shape.named();
        let value = |name: &str| named.iter().position(|other| other.name() == name).map(|place| read.values[place]);
        assert_eq!(
            (value("header.stamp.sec"), value("position[1]"), value("effort[1]")),
            (Some(7.0), Some(1.5), Some(-2.0))
        );
        assert_eq!(
            named.iter().filter_map(Named::joint).collect::<Vec<_>>(),
            ["shoulder", "shoulder", "elbow", "elbow"]
        );
        assert_eq!(named.last().unwrap().label(), "effort[elbow]");
    }

    #[test]
    fn a_definition_in_idl_says_the_same() {
        let idl = "IDL: control_msgs/msg/DynamicJointState\nmodule control_msgs { module msg { struct DynamicJointState {
            std_msgs::msg::Header header; sequence<string> joint_names;
            sequence<control_msgs::msg::InterfaceValue> interface_values; }; }; };
            module control_msgs { module msg { struct InterfaceValue {
            sequence<string> interface_names; sequence<double> values; }; }; };
            module std_msgs { module msg { struct Header { builtin_interfaces::msg::Time stamp; string frame_id; }; }; };
            module builtin_interfaces { module msg { struct Time { long sec; unsigned long nanosec; }; }; };";
        let kind = "control_msgs/msg/DynamicJointState";
        let [idl, msg] =
            [("ros2idl", idl), ("ros2msg", DYNAMIC)].map(|(encoding, text)| Definition::of(kind, encoding, text));
        assert_eq!(idl, msg);
        assert!(Definition::of(kind, "ros2idl", "module x {}").unwrap_err().contains("not defined"));
        for text in ["", " \n"] {
            assert_eq!(Definition::of(kind, "ros2msg", text).unwrap_err(), "it has no definition");
            assert!(Definition::of(JOINT_STATE, "ros2msg", text).is_ok());
        }
        let known = Definition::of(JOINT_STATE, "ros2idl", "module x {}").unwrap();
        assert!((300..2000).contains(&known.size()), "{} bytes", known.size());
        assert!(Definition::of(kind, "ros2msg", &"#".repeat(LONGEST + 1)).unwrap_err().contains("longer than"));
    }

    #[test]
    fn lies_are_refused() {
        let definition = Definition::parse("control_msgs/msg/DynamicJointState", DYNAMIC).unwrap();
        let whole = message();
        for end in 0..whole.len() {
            assert!(definition.decode(&whole[..end]).is_err(), "{end}");
        }
        for place in 4..whole.len() {
            let mut lying = whole.clone();
            lying[place] = 0xff;
            let _ = definition.decode(&lying);
        }
        let wrong = |text: &str| Definition::parse("a/msg/B", text).unwrap_err();
        assert!(wrong("C c\n").contains("a/C is not defined"));
        assert!(wrong("C c\n===\nMSG: a/C\nC again\n").contains("nested deeper"));
        assert!(wrong("float64[x] a\n").contains("no number of elements") && wrong("float64\n").contains("no field"));
    }
}
