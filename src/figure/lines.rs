//! A long name in several lines.

/// A space at which no line ends.
const NO_BREAK: char = '\u{a0}';
/// What stands at the end of a name that is cut.
const DOTS: char = '…';

/// The words of a name in lines as wide as the room, so many at most. A word that is wider than the room goes on in the next line;
/// what finds no room in the last line is cut, and ends in dots. `width` measures a text.
pub fn in_lines(name: &str, room: f64, most: usize, width: impl Fn(&str) -> f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in name.split(' ').filter(|word| !word.is_empty()) {
        let last = lines.len() - 1;
        let joined = if lines[last].is_empty() { word.to_owned() } else { format!("{} {word}", lines[last]) };
        if width(&joined) <= room {
            lines[last] = joined;
            continue;
        }
        let mut line = String::new();
        for letter in word.chars() {
            line.push(letter);
            if width(&line) > room && line.chars().count() > 1 {
                line.pop();
                lines.push(std::mem::replace(&mut line, letter.to_string()));
            }
        }
        lines.push(line);
    }
    lines.retain(|line| !line.is_empty());
    if lines.len() > most {
        lines.truncate(most);
        if let Some(last) = lines.last_mut() {
            while width(&format!("{}{DOTS}", last.trim_end())) > room && last.pop().is_some() {}
            *last = format!("{}{DOTS}", last.trim_end());
        }
    }
    lines
}

/// The same of a title, in which the unit in brackets is not broken.
pub fn title_in_lines(title: &str, room: f64, most: usize, width: impl Fn(&str) -> f64) -> Vec<String> {
    let whole = match title.rsplit_once(" [") {
        Some((title, unit)) if unit.ends_with(']') => format!("{title} [{}", unit.replace(' ', &NO_BREAK.to_string())),
        _ => title.to_owned(),
    };
    in_lines(&whole, room, most, width).into_iter().map(|line| line.replace(NO_BREAK, " ")).collect()
}

/// Whether every word of a name has room in a line.
pub fn has_room_for_words(name: &str, room: f64, width: impl Fn(&str) -> f64) -> bool {
    name.split_whitespace().all(|word| width(word) <= room)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn letters(text: &str) -> f64 {
        text.chars().count() as f64
    }

    #[test]
    fn a_name_is_broken_between_words_and_cut_only_behind_the_last_line() {
        let lines = |name: &str, room: f64, most: usize| in_lines(name, room, most, letters).join("|");
        assert_eq!(lines("rigid body", 20.0, 2), "rigid body");
        assert_eq!(lines("with Coulomb friction", 12.0, 2), "with Coulomb|friction");
        assert_eq!(lines("with Coulomb friction and viscous friction", 12.0, 2), "with Coulomb|friction an…");
        assert_eq!(
            lines("with Coulomb friction and viscous friction", 12.0, 9),
            "with Coulomb|friction and|viscous|friction"
        );
        assert_eq!(lines("", 12.0, 2), "");
        let title = title_in_lines("beside the diagonal [kg m²]", 12.0, 3, letters);
        assert_eq!(title, ["beside the", "diagonal", "[kg m²]"]);
    }

    #[test]
    fn a_word_that_is_too_long_goes_on_in_the_next_line() {
        let lines = in_lines("a self-explanatory word", 6.0, 9, letters);
        assert_eq!(lines, ["a", "self-e", "xplana", "tory", "word"]);
        assert!(
            !has_room_for_words("a self-explanatory word", 6.0, letters) && has_room_for_words("a word", 6.0, letters)
        );
    }
}
