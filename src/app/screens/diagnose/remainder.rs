//! What no effect explains: on what it depends, and formulas that can be adopted.

use egui::{Button, RichText, Ui, WidgetInfo};

use crate::app::desk::Desk;
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::diagnosis::proposal::{Proposal, percent};
use crate::recording::Joint;
use crate::session::Command;

/// The question, or its answer.
pub fn card(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    widgets::card(ui, "What does the remainder depend on?", |ui| {
        let Some(proposals) = desk.session.proposals.clone() else {
            let text = "Every channel is asked what it tells of what is left, and formulas are tried.";
            widgets::weak(ui, text);
            if ui.add_enabled(desk.busy.is_none(), Button::new("Ask what it depends on")).clicked() {
                desk.run(Command::Propose);
            }
            return;
        };
        for remainder in &proposals.remainders {
            ui.label(remainder.sentence(&recording.joints[remainder.joint]));
            for (how, channels) in remainder.dependence() {
                ui.label(RichText::new(format!("{how}: {channels}")).size(SMALL).color(Palette::in_ui(ui).weak));
            }
        }
        if proposals.formulas.is_empty() {
            widgets::weak(ui, "No formula is stable enough to be proposed.");
        }
        for (place, proposal) in proposals.formulas.iter().enumerate() {
            ui.separator();
            formula(ui, desk, place, proposal, &recording.joints[proposal.joint]);
        }
    });
}

fn formula(ui: &mut Ui, desk: &mut Desk, place: usize, proposal: &Proposal, joint: &Joint) {
    let palette = Palette::in_ui(ui);
    let Proposal { formula, value, unit, share, stability, .. } = proposal;
    let text = format!("{}: {value:.4} {unit} × {}", joint.name, widgets::formula(formula));
    ui.label(RichText::new(text).monospace().color(palette.accent));
    let (share, stability) = (percent(*share), percent(*stability));
    widgets::weak(
        ui,
        format!("Explains {share} of the remainder on data that it has not seen; {stability} of the halves choose it."),
    );
    for remark in proposal.remarks(joint) {
        widgets::weak(ui, widgets::sentence_case(&format!("{remark}.")));
    }
    let idle = desk.busy.is_none();
    let button = ui.add_enabled(idle, Button::new("Adopt").small());
    button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, idle, format!("Adopt {formula}, {}", joint.name)));
    let hint = "Makes it an effect of your own and adds it to the model; all parameters are identified anew.";
    if button.on_hover_text(hint).clicked() {
        desk.run(Command::Adopt { proposal: place });
    }
}
