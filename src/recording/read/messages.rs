//! Messages of ROS 2 by the text of their definition, as named numbers: so that every message with arrays of positions and torques can be
//! read, and not only joint states.
//!
//! Source: ROS 2, "About ROS 2 interfaces" (the language of .msg files); MCAP, "ros2msg" schemas (definitions of nested types stand
//! behind lines of `=` and `MSG: package/Type`).

use std::collections::HashMap;

use super::cdr::Cdr;

/// Types may lie in each other this deep.
const DEEPEST: usize = 12;
/// No message has more numbers: a log has a row of them for each.
const MOST_NUMBERS: usize = 4096;
/// Elements of an array that have no bytes of their own (an empty type) are not counted by the bytes that are left.
const MOST_ELEMENTS: usize = 65_536;

/// The topic that was asked for is not among those that can be read.
#[derive(Debug, thiserror::Error)]
#[error("no topic `{asked}` with joint states is in the log; it has {there}")]
pub struct NoTopic {
    asked: String,
    there: String,
}

impl NoTopic {
    /// Where the topic that is asked for stands among those that can be read; the first, if none is.
    pub(super) fn unless_first<'a>(
        topics: impl Iterator<Item = &'a str> + Clone,
        asked: Option<&str>,
    ) -> Result<usize, NoTopic> {
        let Some(asked) = asked else { return Ok(0) };
        topics.clone().position(|topic| topic == asked).ok_or_else(|| NoTopic {
            asked: asked.to_owned(),
            there: topics.map(|topic| format!("`{topic}`")).collect::<Vec<_>>().join(", "),
        })
    }
}

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
    pub numbers: Vec<(String, f64)>,
    /// Arrays of texts by their names: of joints, of interfaces.
    pub texts: Vec<(String, Vec<String>)>,
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
            match kind {
                Kind::Text => {
                    let texts = (0..count).map(|_| cdr.text()).collect::<Result<Vec<_>, _>>()?;
                    if is_array {
                        message.texts.push((path, texts));
                    }
                }
                Kind::Number(number) => {
                    for index in 0..count {
                        let value = number.read(cdr)?;
                        // Pictures and point clouds are bytes, too, but no samples.
                        if message.numbers.len() < MOST_NUMBERS {
                            message.numbers.push((place(index), value));
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

impl Message {
    /// Values that stand beside texts of the same number in an inner type are named by these: `interface_values[1].values[0]`, where
    /// `interface_names` begins with `effort`, is `effort[1]`.
    pub fn named(mut self) -> Message {
        let inner: Vec<(String, Vec<String>)> = self
            .texts
            .iter()
            .filter_map(|(path, texts)| Some((path.rsplit_once('.')?.0.to_owned(), texts.clone())))
            .collect();
        for (path, texts) in inner {
            let Some(outer) = path.rfind('[').map(|at| path[at..].to_owned()) else { continue };
            for (name, _) in &mut self.numbers {
                let rest = name.strip_prefix(&path).and_then(|rest| rest.strip_suffix(']'));
                let index = rest.and_then(|rest| rest.rsplit_once('[')).and_then(|(_, index)| index.parse().ok());
                if let Some(text) = index.and_then(|index: usize| texts.get(index)) {
                    *name = format!("{text}{outer}");
                }
            }
        }
        self
    }

    /// Names of the joints, where the message says as many as it has values.
    pub fn joints(&self) -> Option<Vec<String>> {
        let is_list = |path: &str| ["name", "names", "joint_names", "joint_name"].contains(&path);
        self.texts.iter().find(|(path, texts)| is_list(path) && !texts.is_empty()).map(|(_, texts)| texts.clone())
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
        let read = definition.decode(&message()).unwrap().named();
        let value = |name: &str| read.numbers.iter().find(|(other, _)| other == name).map(|(_, value)| *value);
        assert_eq!(
            (value("header.stamp.sec"), value("position[1]"), value("effort[1]")),
            (Some(7.0), Some(1.5), Some(-2.0))
        );
        assert_eq!(read.joints(), Some(vec!["shoulder".to_owned(), "elbow".to_owned()]));
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
