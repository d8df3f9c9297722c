//! OMG IDL, the other language in which ROS 2 defines messages, as the text of .msg files: both are read in one way from there.
//!
//! Sources: OMG, IDL 4.2, §7.4; ROS 2, rosidl (which makes of .msg files modules, structs, sequences, and typedefs of arrays).

use std::collections::HashMap;
use std::iter::Peekable;
use std::vec::IntoIter;

/// The definitions of a text in IDL, each behind a line `MSG: package/msg/Type`; that of this name is one of them.
pub(super) fn as_messages(name: &str, text: &str) -> Result<String, String> {
    let mut reader = Reader { words: words(text).into_iter().peekable(), typedefs: HashMap::new() };
    let mut modules: Vec<String> = Vec::new();
    let mut messages = String::new();
    while let Some(word) = reader.words.next() {
        match word.as_str() {
            "module" => {
                modules.push(reader.next()?);
                reader.expect("{")?;
            }
            "struct" => {
                messages += &format!("MSG: {}/{}\n", modules.join("/"), reader.next()?);
                reader.expect("{")?;
                messages += &reader.fields()?;
            }
            "typedef" => {
                let (kind, name) = reader.declared()?;
                reader.typedefs.insert(name, kind);
            }
            "const" => while reader.next()? != ";" {},
            "@" => reader.annotation()?,
            "}" => drop(modules.pop()),
            ";" => {}
            other => return Err(format!("its IDL has `{other}`, which is not read")),
        }
    }
    if !messages.lines().any(|line| line.strip_prefix("MSG: ") == Some(name)) {
        return Err(format!("the type {name} is not defined in its IDL"));
    }
    Ok(messages)
}

/// The words and signs of a text, without comments, and without the lines between its parts and for the preprocessor. A text in quotes
/// is a quote: it says nothing of numbers.
fn words(text: &str) -> Vec<String> {
    let is_beside = |line: &&str| !["#", "===", "IDL:"].iter().any(|start| line.trim_start().starts_with(start));
    let lines: Vec<&str> = text.lines().filter(is_beside).collect();
    let text = lines.join("\n");
    let is_of_word = |letter: char| letter.is_alphanumeric() || "_:.".contains(letter);
    let (mut rest, mut words) = (text.trim_start(), Vec::new());
    while let Some(first) = rest.chars().next() {
        let until = |end: &str, from: usize| rest[from..].find(end).map_or(rest.len(), |at| from + at + end.len());
        let (end, word) = match first {
            '"' => (end_of_quote(rest), Some("\"")),
            _ if rest.starts_with("//") => (until("\n", 2), None),
            _ if rest.starts_with("/*") => (until("*/", 2), None),
            _ if is_of_word(first) => {
                let end = rest.find(|letter| !is_of_word(letter)).unwrap_or(rest.len());
                (end, Some(&rest[..end]))
            }
            _ => (first.len_utf8(), Some(&rest[..first.len_utf8()])),
        };
        words.extend(word.map(str::to_owned));
        rest = rest[end..].trim_start();
    }
    words
}

/// Where a text in quotes ends, whose first sign is a quote.
fn end_of_quote(text: &str) -> usize {
    let mut is_escaped = false;
    let is_end = |(_, letter): &(usize, char)| {
        let is_end = *letter == '"' && !is_escaped;
        is_escaped = *letter == '\\' && !is_escaped;
        is_end
    };
    text.char_indices().skip(1).find(is_end).map_or(text.len(), |(at, quote)| at + quote.len_utf8())
}

const ARRAYS_OF_ARRAYS: &str = "its IDL has arrays of arrays, which are not read";

struct Reader {
    words: Peekable<IntoIter<String>>,
    /// Arrays that have a name of their own: `double__7` is `float64[7]`.
    typedefs: HashMap<String, String>,
}

impl Reader {
    fn next(&mut self) -> Result<String, String> {
        self.words.next().ok_or_else(|| "its IDL breaks off".to_owned())
    }

    fn expect(&mut self, wanted: &str) -> Result<(), String> {
        match self.next()? {
            word if word == wanted => Ok(()),
            word => Err(format!("its IDL has `{word}` in place of `{wanted}`")),
        }
    }

    /// Takes the next word if it is this one.
    fn takes(&mut self, wanted: &str) -> bool {
        self.words.next_if(|word| word == wanted).is_some()
    }

    /// Passes over what is said about the next part.
    fn annotation(&mut self) -> Result<(), String> {
        self.next()?;
        let mut depth = usize::from(self.takes("("));
        while depth > 0 {
            match self.next()?.as_str() {
                "(" => depth += 1,
                ")" => depth -= 1,
                _ => {}
            }
        }
        Ok(())
    }

    /// The fields of a struct, a line each.
    fn fields(&mut self) -> Result<String, String> {
        let mut lines = String::new();
        loop {
            if self.takes("}") {
                return Ok(lines);
            } else if self.takes("@") {
                self.annotation()?;
            } else {
                let (kind, name) = self.declared()?;
                lines += &format!("{kind} {name}\n");
            }
        }
    }

    /// A type and the name of what has it.
    fn declared(&mut self) -> Result<(String, String), String> {
        let mut kind = self.kind()?;
        let name = self.next()?;
        if self.takes("[") {
            kind = array(kind, &self.next()?)?;
            self.expect("]")?;
        }
        self.expect(";")?;
        Ok((kind, name))
    }

    fn kind(&mut self) -> Result<String, String> {
        let word = self.next()?;
        let plain = match word.as_str() {
            "sequence" => {
                self.expect("<")?;
                if self.words.peek().is_some_and(|word| word == "sequence") {
                    return Err(ARRAYS_OF_ARRAYS.to_owned());
                }
                let inner = self.kind()?;
                if self.takes(",") {
                    self.next()?;
                }
                self.expect(">")?;
                return array(inner, "");
            }
            "string" => {
                if self.takes("<") {
                    self.next()?;
                    self.expect(">")?;
                }
                "string"
            }
            "unsigned" => match self.next()?.as_str() {
                "short" => "uint16",
                "long" if self.takes("long") => "uint64",
                "long" => "uint32",
                other => return Err(format!("its IDL has `unsigned {other}`, which is not read")),
            },
            "long" if self.takes("long") => "int64",
            "long" if self.takes("double") => return Err("its IDL has `long double`, which is not read".to_owned()),
            "long" => "int32",
            "short" => "int16",
            "float" => "float32",
            "double" => "float64",
            "boolean" => "bool",
            "octet" => "byte",
            other => {
                let bare = other.rsplit("::").next().unwrap_or_default();
                return Ok(self.typedefs.get(bare).cloned().unwrap_or_else(|| other.replace("::", "/")));
            }
        };
        Ok(plain.to_owned())
    }
}

/// An array of so many elements, or of any number.
fn array(kind: String, count: &str) -> Result<String, String> {
    if kind.contains('[') { Err(ARRAYS_OF_ARRAYS.to_owned()) } else { Ok(format!("{kind}[{count}]")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATE: &str = r#"====
IDL: my_msgs/msg/State
// made by hand, of "State.msg
#include "std_msgs/msg/Header.idl"
module my_msgs {
  module msg {
    typedef double double__7[7];
    module State_Constants { const uint8 MOST = 3; const string NAME = "a; \"b\" {"; };
    @verbatim (language="comment", text="see http://example.org (twice)" "and on")
    struct State {
      std_msgs::msg::Header header; /* when
      */
      sequence<string<20>> name;
      @unit (value="rad") @default (value=-0.5)
      sequence<double, 7> position;
      my_msgs::msg::double__7 other;
      double__7 effort;
      unsigned long long count;
      long raw[2];
    };
  };
};
====
IDL: std_msgs/msg/Header
module std_msgs { module msg { struct Header { builtin_interfaces::msg::Time stamp; string frame_id; }; }; };
"#;

    #[test]
    fn idl_becomes_the_text_of_messages() {
        let expected = "MSG: my_msgs/msg/State\nstd_msgs/msg/Header header\nstring[] name\nfloat64[] position\nfloat64[7] other\n\
             float64[7] effort\nuint64 count\nint32[2] raw\nMSG: std_msgs/msg/Header\nbuiltin_interfaces/msg/Time stamp\nstring frame_id\n";
        assert_eq!(as_messages("my_msgs/msg/State", STATE).unwrap(), expected);
    }

    #[test]
    fn what_is_not_read_is_told_and_whatever_breaks_off_ends() {
        for (text, words) in [
            ("struct A { long double a; };", "long double"),
            ("struct A { sequence<sequence<double>> a; };", "arrays of arrays"),
            ("union A { };", "`union`"),
            ("struct A { double a", "breaks off"),
            ("module x { struct B { double a; }; };", "A is not defined"),
        ] {
            let problem = as_messages("A", text).unwrap_err();
            assert!(problem.contains(words), "{problem}");
        }
        for end in (0..STATE.len()).filter(|end| STATE.is_char_boundary(*end)) {
            let _ = as_messages("my_msgs/msg/State", &STATE[..end]);
        }
    }
}
