//! Bet first: a guess is locked in before the answer is shown, so that one learns from the difference.

use egui::{Align, Layout, RichText, Ui};

use crate::app::desk::{Desk, Order};
use crate::app::screens::residuals;
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;
use crate::diagnosis::{Report, Verdict};
use crate::effect::registry;

/// A guess before the answer is shown.
#[derive(Debug, Default)]
pub struct Bet {
    /// Whether the answer is hidden until one has guessed.
    pub first: bool,
    /// What was guessed: the id of an effect, or [`NOTHING`] or [`UNKNOWN`].
    pub guess: Option<String>,
}

/// "Nothing is missing".
const NOTHING: &str = "nothing";
/// "None of these".
const UNKNOWN: &str = "unknown";

impl Bet {
    /// The choice to bet, before the diagnosis.
    pub fn offer(&mut self, ui: &mut Ui) {
        ui.with_layout(Layout::top_down(Align::Center), |ui| {
            let text = "Bet first: the answer is hidden until you have guessed";
            if ui.checkbox(&mut self.first, text).changed() {
                self.guess = None;
            }
        });
    }

    /// The answers that one can bet on; "nothing" and "none of these" are among them.
    pub fn place(&mut self, ui: &mut Ui, desk: &mut Desk, report: &Report) {
        let sentence = "The diagnosis has its answer. Look where the model fails, then choose yours; it can't be changed afterwards.";
        widgets::headline(ui, "What is missing? Place your bet", sentence);
        if ui.button(format!("Go to: {}", residuals::ABOUT.title)).clicked() {
            desk.orders.push(Order::Show(&residuals::ABOUT));
        }
        ui.add_space(GAP);
        let mut choices = vec![
            (NOTHING.to_owned(), "Nothing is missing".to_owned()),
            (UNKNOWN.to_owned(), "None of these: something unknown".to_owned()),
        ];
        for candidate in &report.ranking {
            if choices.iter().all(|(id, _)| *id != candidate.effect.id) {
                choices.push((candidate.effect.id.to_owned(), widgets::sentence_case(candidate.effect.name)));
            }
        }
        // In the order of the ranking the list would tell the answer.
        choices[2..].sort();
        egui::ScrollArea::vertical().id_salt("bets").auto_shrink(false).show(ui, |ui| {
            for (id, name) in choices {
                let button = ui.add(egui::Button::new(&name).min_size(egui::vec2(320.0, 0.0)));
                if button.clicked() {
                    self.guess = Some(id);
                }
            }
        });
    }

    /// What was guessed, beside the answer.
    pub fn outcome(&self, ui: &mut Ui, report: &Report) {
        let Some(guess) = self.guess.as_deref().filter(|_| self.first) else { return };
        let palette = Palette::in_ui(ui);
        let right = match guess {
            NOTHING => report.verdict == Verdict::NothingMissing,
            UNKNOWN => report.verdict == Verdict::UnknownEffect,
            id => report.effects.iter().any(|effect| effect.effect.id == id),
        };
        let name = match guess {
            NOTHING => "nothing is missing",
            UNKNOWN => "something unknown",
            id => registry::find(id).map_or(id, |effect| effect.name),
        };
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("Your bet: {name}.")).color(palette.text));
            let (word, color) =
                if right { ("right", palette.good) } else { ("not what the data say", palette.warning) };
            widgets::chip(ui, word, color);
        });
        ui.add_space(GAP / 2.0);
    }
}
