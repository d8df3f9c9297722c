//! What the words of the trade mean, told to those who point at them.

use egui::{Response, Ui};

use crate::model::Preset;

/// A word that not everybody knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    /// The measure of all errors.
    Nmse,
    /// What is kept from the training.
    HeldOut,
    /// What can be identified of a rigid body.
    BaseParameters,
    /// The networks of the paper.
    Delan,
    /// What is measured where the arm of a model is simulated.
    Rollout,
}

/// What can stand in a text, and what it is about.
const TEXTS: [(&str, Word); 6] = [
    ("nMSE", Word::Nmse),
    ("held out", Word::HeldOut),
    ("held-out", Word::HeldOut),
    ("base parameters", Word::BaseParameters),
    ("DeLaN", Word::Delan),
    ("off after", Word::Rollout),
];

impl Word {
    /// What it means, in a sentence or two.
    pub fn meaning(self) -> &'static str {
        match self {
            Word::Nmse => {
                "nMSE, normalised mean squared error: squared error over squared torque. 0 % is perfect; 100 % is as bad as \
                 predicting 0."
            }
            Word::HeldOut => {
                "Held out: data that were kept from the fit, so the error on them tells how the model does on what it has not seen."
            }
            Word::BaseParameters => {
                "Base parameters: the combinations of masses, lengths and inertias that the motion can tell apart; no data of \
                 this arm tell more."
            }
            Word::Delan => {
                "DeLaN, Deep Lagrangian Network: networks learn the mass matrix and the potential energy, and the torque follows \
                 by mechanics."
            }
            Word::Rollout => {
                "Off after 0.25 s: the arm of the model is moved by the measured torque, from measured states along the held-out data; \
                 RMS of how far each joint is from where it was measured then."
            }
        }
    }
}

/// Tells what a word means to those who point at it.
pub fn explained(response: Response, word: Word) -> Response {
    response.on_hover_text(word.meaning())
}

/// A text of less weight that tells what the words in it mean to those who point at it.
pub fn weak(ui: &mut Ui, text: impl Into<String>) -> Response {
    let text = text.into();
    let meaning = meanings(&text);
    let label = super::widgets::weak(ui, text);
    if meaning.is_empty() { label } else { label.on_hover_text(meaning) }
}

/// The choice of a model: what it is, and what the words for it mean.
pub fn radio(response: Response, preset: Preset) -> Response {
    let text = preset.description();
    let meaning = meanings(&format!("{} {text}", preset.title()));
    response.on_hover_text(if meaning.is_empty() { text.to_owned() } else { format!("{text}\n\n{meaning}") })
}

/// The meanings of all words in a text, each once.
pub fn meanings(text: &str) -> String {
    let mut words: Vec<Word> = Vec::new();
    for (_, word) in TEXTS.iter().filter(|(part, _)| text.contains(part)) {
        if !words.contains(word) {
            words.push(*word);
        }
    }
    words.into_iter().map(Word::meaning).collect::<Vec<_>>().join("\n\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_word_of_a_text_is_explained_once() {
        let text = meanings("Held-out error by joint (nMSE): 3 %; on held-out data, nMSE 2 %.");
        assert_eq!(text.matches("normalised mean squared error").count(), 1);
        assert_eq!(text.matches("kept from the fit").count(), 1);
        assert!(meanings("rigid body").is_empty());
    }
}
