//! What a file is written as, by the ending of its path: one list for the words of a chooser and for what a path says.

use std::path::Path;

/// What a file can be written as: the choice, its name for people, and how its files end.
pub type Choices<T> = [(T, &'static str, &'static str)];

/// The choice that the ending of a path names, if it names one.
pub fn named<T: Copy>(choices: &Choices<T>, path: &Path) -> Option<T> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    choices.iter().find(|(_, _, own)| *own == ending).map(|(choice, ..)| *choice)
}

/// All endings, as `.html, .pdf`.
pub fn listed<T>(choices: &Choices<T>) -> String {
    choices.iter().map(|(_, _, ending)| format!(".{ending}")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_of_a_path_is_a_choice_whatever_its_case() {
        let choices = [(1, "one", "tex"), (2, "two", "md")];
        let named = |path: &str| named(&choices, Path::new(path));
        assert_eq!([named("a/b.TEX"), named("x.md"), named("x.tex.txt"), named("tex")], [Some(1), Some(2), None, None]);
        assert_eq!(listed(&choices), ".tex, .md");
    }
}
