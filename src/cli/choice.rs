//! Options that take one of a few values: help, completions and errors list them.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::simulation::Level;

/// A name on the command line, what it stands for in a few words, and the value.
pub type Choice<T> = (&'static str, &'static str, T);

/// Takes one of these.
pub fn one_of<T: Clone + Send + Sync + 'static>(
    choices: impl IntoIterator<Item = Choice<T>>,
) -> impl TypedValueParser<Value = T> {
    let choices: Vec<Choice<T>> = choices.into_iter().collect();
    let names = choices.iter().map(|(name, about, _)| PossibleValue::new(*name).help(*about));
    PossibleValuesParser::new(names).try_map(move |text| {
        let chosen = choices.iter().find(|(name, ..)| *name == text);
        chosen.map(|(.., value)| value.clone()).ok_or_else(|| format!("there is no `{text}`"))
    })
}

/// Takes the level of a mystery.
pub fn level() -> impl TypedValueParser<Value = Level> {
    one_of(Level::ALL.map(|level| (level.name(), level.about(), level)))
}
