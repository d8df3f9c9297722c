//! The sealed truth: shut, or opened and beside what was found.

use egui::{RichText, Ui};

use crate::app::desk::{Desk, Question};
use crate::app::plot::ticks;
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;
use crate::effect::registry;
use crate::model::Term;
use crate::recording::Recording;
use crate::recording::seal::{Cause, HiddenEffect, Truth};
use crate::session::Session;

/// The sealed truth beside what was found.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    let Some(truth) = desk.session.truth.clone() else {
        widgets::card(ui, "", |ui| {
            if recording.seal.is_none() {
                widgets::weak(
                    ui,
                    "This was measured on a real arm: nobody knows the truth. Judge by the held-out error.",
                );
                return;
            }
            widgets::weak(ui, "What was hidden is sealed. Open it once you are done: then nothing is left to find.");
            ui.add_space(GAP);
            if ui.button("Open the seal").clicked() {
                desk.orders.push(Question::open_seal());
            }
        });
        return;
    };
    widgets::card(ui, "From the seal", |ui| revealed(ui, desk.session, &recording, &truth));
}

fn revealed(ui: &mut Ui, session: &Session, recording: &Recording, truth: &Truth) {
    let palette = Palette::in_ui(ui);
    let is_told = |cause: &&Cause| {
        truth.effects.iter().any(|hidden| hidden.effect == cause.effect && hidden.joint == cause.joint)
    };
    let others: Vec<&Cause> = truth.causes.iter().filter(|cause| !is_told(cause)).collect();
    if truth.effects.is_empty() && others.is_empty() && truth.set_up.is_empty() {
        ui.label("Nothing was hidden.");
    }
    for correction in &truth.set_up {
        ui.label(format!("The log is set up wrongly: {}.", correction.fault()));
    }
    // What no parameters of the catalogue describe.
    for Cause { effect, joint, share, .. } in others {
        let name = registry::find(effect).map_or_else(|_| effect.replace('-', " "), |spec| spec.name.to_owned());
        let percent = ticks::number(100.0 * share);
        ui.label(format!("{} on {}: {percent} % of the torque", widgets::sentence_case(&name), place(*joint)));
    }
    for hidden in &truth.effects {
        let Some(spec) = registry::find(&hidden.effect).ok() else {
            ui.label(&hidden.effect);
            continue;
        };
        ui.label(RichText::new(format!("{} on {}", spec.name, place(hidden.joint))).color(palette.text));
        for (parameter, value) in spec.parameters.iter().zip(&hidden.parameters) {
            let estimate = estimate(session, hidden, parameter.name);
            let (word, color) = match &estimate {
                None => ("not in the model", palette.warning),
                Some((_, Some([low, high]))) if (*low..=*high).contains(value) => ("inside the interval", palette.good),
                Some((_, Some(_))) => ("outside the interval", palette.error),
                Some((_, None)) => ("no interval", palette.warning),
            };
            let found = estimate.map_or(String::new(), |(value, _)| format!(", found {}", ticks::number(value)));
            ui.horizontal(|ui| {
                ui.add_space(GAP);
                ui.label(format!("{} = {}{found}", parameter.symbol, ticks::number(*value)));
                widgets::chip(ui, word, color);
            });
        }
    }
    let [.., unit] = recording.units();
    let noise: Vec<String> = truth.torque_noise.iter().copied().map(ticks::number).collect();
    widgets::weak(ui, format!("Torque noise by joint: {} {unit}. Seed {}.", noise.join(" · "), truth.seed));
}

fn place(joint: Option<usize>) -> String {
    joint.map_or("the whole arm".to_owned(), |joint| format!("joint {}", joint + 1))
}

/// The current model's value and interval of a hidden parameter.
fn estimate(session: &Session, hidden: &HiddenEffect, name: &str) -> Option<(f64, Option<[f64; 2]>)> {
    let fitted = &session.current()?.fitted;
    let term = fitted.model.terms.iter().position(
        |term| matches!(term, Term::Effect(term) if term.effect.id == hidden.effect && term.joint == hidden.joint),
    )?;
    let parameter = fitted.parameters.iter().find(|parameter| parameter.term == term && parameter.name == name)?;
    Some((parameter.value, parameter.interval))
}
