//! What the torque of a log is and where its encoders are, to be stated: the same words on the Data screen and in the import assistant.

use egui::Ui;

use super::widgets;
use crate::recording::encoders::Side;
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

/// The same for the side of the gears where the encoders are; who is not sure leaves it open.
pub fn choose_encoders(ui: &mut Ui, encoders: &mut Option<Side>) -> bool {
    let before = *encoders;
    ui.horizontal_wrapped(|ui| {
        ui.label("Encoders");
        for side in Side::ALL {
            let (title, hidden) = match side {
                Side::Link => ("On the links", "see what the gears twist"),
                Side::Motor => ("On the motors", "see nothing of what the gears twist, and all joints feel it"),
            };
            let button = ui.selectable_label(*encoders == Some(side), title);
            let hint = format!("The encoders are {}: they {hidden}.", side.about());
            if button.on_hover_text(hint).clicked() {
                *encoders = Some(side);
            }
        }
    });
    *encoders != before
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
