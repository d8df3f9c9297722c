//! The one way from the command line to a terminal: names that stand in files may hold what a terminal would obey.
//!
//! Within `cli`, `println!` and `eprintln!` are those of this file, so that nobody has to remember it.

use std::borrow::Cow;
use std::fmt;

/// As in the standard library, without what a terminal obeys.
macro_rules! println {
    () => { std::println!() };
    ($($text:tt)*) => { std::println!("{}", $crate::cli::terminal::harmless(&format_args!($($text)*))) };
}

/// As in the standard library, without what a terminal obeys.
macro_rules! eprintln {
    ($($text:tt)*) => { std::eprintln!("{}", $crate::cli::terminal::harmless(&format_args!($($text)*))) };
}

/// The text with all that moves the cursor, colours, rings or turns the direction of writing made visible, as JSON writes it; line
/// feeds and tabs stay.
pub fn harmless(text: &fmt::Arguments) -> String {
    let text = text.as_str().map_or_else(|| Cow::Owned(text.to_string()), Cow::Borrowed);
    let mut harmless = String::with_capacity(text.len());
    for letter in text.chars() {
        if obeyed(letter) {
            harmless.push_str(&format!("\\u{:04x}", u32::from(letter)));
        } else {
            harmless.push(letter);
        }
    }
    harmless
}

fn obeyed(letter: char) -> bool {
    let turns_round = matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns_round || (letter.is_control() && !matches!(letter, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_becomes_visible() {
        let name = "q\u{1b}]0;mine\u{7}\u{9b}31m\r\u{202e}1";
        assert_eq!(harmless(&format_args!("{name}")), "q\\u001b]0;mine\\u0007\\u009b31m\\u000d\\u202e1");
        assert_eq!(harmless(&format_args!("q̇ [rad/s]\t1\n–")), "q̇ [rad/s]\t1\n–");
    }

    #[test]
    fn json_stays_what_it_says() {
        let name = "a\u{7f}\u{9b}b";
        let printed = harmless(&format_args!("{}", serde_json::json!({ "name": name })));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&printed).unwrap()["name"], name);
    }
}
