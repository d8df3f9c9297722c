//! Lessons that come with the program: two files in `assets/lessons/` and one line here.

use super::file::{Lesson, LessonFileError};
use crate::session::study::Source;

/// Steps and text of each, by its number.
const ALL: &[(&str, &str)] = &[
    (
        include_str!("../../assets/lessons/01-where-torque-comes-from.toml"),
        include_str!("../../assets/lessons/en/01-where-torque-comes-from.toml"),
    ),
    (
        include_str!("../../assets/lessons/02-one-energy.toml"),
        include_str!("../../assets/lessons/en/02-one-energy.toml"),
    ),
    (
        include_str!("../../assets/lessons/03-outside-the-data.toml"),
        include_str!("../../assets/lessons/en/03-outside-the-data.toml"),
    ),
    (
        include_str!("../../assets/lessons/04-look-inside.toml"),
        include_str!("../../assets/lessons/en/04-look-inside.toml"),
    ),
    (
        include_str!("../../assets/lessons/05-read-a-residual.toml"),
        include_str!("../../assets/lessons/en/05-read-a-residual.toml"),
    ),
    (
        include_str!("../../assets/lessons/06-hidden-effect.toml"),
        include_str!("../../assets/lessons/en/06-hidden-effect.toml"),
    ),
    (
        include_str!("../../assets/lessons/07-energy-must-balance.toml"),
        include_str!("../../assets/lessons/en/07-energy-must-balance.toml"),
    ),
    (
        include_str!("../../assets/lessons/08-two-causes.toml"),
        include_str!("../../assets/lessons/en/08-two-causes.toml"),
    ),
    (
        include_str!("../../assets/lessons/09-doctor-the-data.toml"),
        include_str!("../../assets/lessons/en/09-doctor-the-data.toml"),
    ),
    (include_str!("../../assets/lessons/10-black-box.toml"), include_str!("../../assets/lessons/en/10-black-box.toml")),
    (
        include_str!("../../assets/lessons/11-your-own-robot.toml"),
        include_str!("../../assets/lessons/en/11-your-own-robot.toml"),
    ),
];

/// No lesson has this number or name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no lesson `{name}`; there are: {known}")]
pub struct UnknownLesson {
    /// What was asked for.
    pub name: String,
    /// What there is.
    pub known: String,
}

/// All lessons, by their numbers.
pub fn all() -> impl Iterator<Item = Lesson> {
    // A test reads every lesson of the program.
    ALL.iter().filter_map(|(data, text)| read(data, text).ok())
}

fn read(data: &str, text: &str) -> Result<Lesson, LessonFileError> {
    Lesson::read(&Source { data: data.to_owned(), text: text.to_owned() })
}

/// The lesson of this number or id.
///
/// # Errors
/// [`UnknownLesson`] lists what there is.
pub fn find(name: &str) -> Result<Lesson, UnknownLesson> {
    let is_it = |lesson: &Lesson| lesson.id == name || name.parse() == Ok(lesson.number);
    all().find(is_it).ok_or_else(|| UnknownLesson {
        name: name.to_owned(),
        known: all().map(|lesson| format!("{} ({})", lesson.number, lesson.id)).collect::<Vec<_>>().join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lesson_can_be_read() {
        let lessons: Vec<Lesson> = ALL.iter().map(|(data, text)| read(data, text).unwrap()).collect();
        assert!(lessons.is_sorted_by(|one, next| one.number < next.number));
        let message = find("12").unwrap_err().to_string();
        assert!(message.contains("no lesson `12`; there are: 1 (where-torque-comes-from)"), "{message}");
    }
}
