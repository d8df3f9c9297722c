//! Bet first: a guess is locked in before the answer is shown, so that one learns from the difference.

use egui::{Align, Layout, RichText, Ui};

use crate::app::desk::{Desk, Order};
use crate::app::screens::residuals;
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;
use crate::diagnosis::{Report, Verdict};
use crate::effect::registry;
use crate::session::{Command, Guess};

/// The choice to bet, before the diagnosis.
pub fn offer(ui: &mut Ui, desk: &mut Desk) {
    ui.with_layout(Layout::top_down(Align::Center), |ui| {
        let text = "Bet first: the answer is hidden until you have guessed";
        let mut first = desk.session.bets.first;
        if ui.checkbox(&mut first, text).changed() {
            desk.run(Command::BetFirst(first));
        }
    });
}

/// The answers that one can bet on; "nothing" and "none of these" are among them.
pub fn place(ui: &mut Ui, desk: &mut Desk, report: &Report) {
    let sentence =
        "The diagnosis has its answer. Look where the model fails, then choose yours; it can't be changed afterwards.";
    widgets::headline(ui, "What is missing? Place your bet", sentence);
    if ui.button(format!("Go to: {}", residuals::ABOUT.title)).clicked() {
        desk.orders.push(Order::Show(&residuals::ABOUT));
    }
    ui.add_space(GAP);
    let mut choices = vec![
        (Guess::Nothing, "Nothing is missing".to_owned()),
        (Guess::Unknown, "None of these: something unknown".to_owned()),
    ];
    for candidate in &report.ranking {
        let guess = Guess::Effect(candidate.effect.id.to_owned());
        if choices.iter().all(|(other, _)| *other != guess) {
            choices.push((guess, widgets::sentence_case(candidate.effect.name)));
        }
    }
    // In the order of the ranking the list would tell the answer.
    choices[2..].sort_by(|one, other| one.1.cmp(&other.1));
    egui::ScrollArea::vertical().id_salt("bets").auto_shrink(false).show(ui, |ui| {
        for (guess, name) in choices {
            let button = ui.add(egui::Button::new(&name).min_size(egui::vec2(320.0, 0.0)));
            if button.clicked() {
                desk.run(Command::PlaceBet(guess));
            }
        }
    });
}

/// What was guessed, beside the answer.
pub fn outcome(ui: &mut Ui, desk: &Desk, report: &Report) {
    let Some(guess) = desk.session.guess() else { return };
    let palette = Palette::in_ui(ui);
    let right = match guess {
        Guess::Nothing => report.verdict == Verdict::NothingMissing,
        Guess::Unknown => report.verdict == Verdict::UnknownEffect,
        Guess::Effect(id) => report.effects.iter().any(|effect| effect.effect.id == id),
    };
    let name = match guess {
        Guess::Nothing => "nothing is missing",
        Guess::Unknown => "something unknown",
        Guess::Effect(id) => registry::find(id).map_or(id.as_str(), |effect| effect.name),
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(format!("Your bet: {name}.")).color(palette.text));
        let (word, color) = if right { ("right", palette.good) } else { ("not what the data say", palette.warning) };
        widgets::chip(ui, word, color);
    });
    ui.add_space(GAP / 2.0);
}
