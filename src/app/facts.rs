//! What the torque of a log is, to be stated: the same words on the Data screen and in the import assistant.

use egui::Ui;

use super::widgets;
use crate::recording::torque::{TorqueFact, TorqueFacts};

/// A button for each fact; whether one was changed.
pub fn choose(ui: &mut Ui, facts: &mut TorqueFacts) -> bool {
    let mut changed = false;
    ui.horizontal_wrapped(|ui| {
        for fact in TorqueFact::ALL {
            let is_stated = facts.has(fact);
            let button = ui.selectable_label(is_stated, title(fact)).on_hover_text(hint(fact));
            if button.clicked() {
                changed = true;
                if is_stated { facts.retract(fact) } else { facts.state(fact) }
            }
        }
    });
    changed
}

/// As it stands on a button.
fn title(fact: TorqueFact) -> &'static str {
    match fact {
        TorqueFact::Link => "Behind the gear",
        TorqueFact::Motor => "Of the motor",
        TorqueFact::Measured => "Measured",
        TorqueFact::Commanded => "Commanded",
        TorqueFact::WithoutGravity => "Without gravity",
        TorqueFact::WithoutFriction => "Without friction",
    }
}

fn hint(fact: TorqueFact) -> String {
    let about = widgets::sentence_case(fact.about());
    match fact.hides() {
        Some(hidden) => format!("{about}. It does not show {hidden}."),
        None => format!("{about}."),
    }
}
