//! Questions before something that can't be taken back: one of them, or whether to close the window.

use egui::{Id, Modal, TextEdit, Ui};

use super::frame::Shell;
use super::primary::primary;
use crate::app::desk::{Order, Parting, Question};
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;

/// The question whether to close the window, while it is open: the file to save into.
#[derive(Debug, Clone)]
pub struct Closing {
    /// As it is typed.
    pub path: String,
}

/// The question, while it is open.
pub fn question(ui: &mut Ui, shell: &mut Shell, place: &mut Option<Question>) {
    let Some(open) = place.take() else { return };
    let mut answered = false;
    let modal = Modal::new(Id::unique("question")).show(ui.ctx(), |ui| {
        set_width(ui);
        ui.heading(&open.title);
        ui.add_space(GAP);
        ui.label(&open.text);
        ui.add_space(GAP);
        ui.horizontal_wrapped(|ui| {
            for (name, order) in &open.choices {
                if ui.button(name).clicked() {
                    shell.desk.orders.push(order.clone());
                    answered = true;
                }
            }
            answered |= primary(ui, true, &open.otherwise).clicked();
        });
    });
    if !answered && !modal.should_close() {
        *place = Some(open);
    }
}

fn set_width(ui: &mut Ui) {
    let room = ui.ctx().content_rect().width();
    ui.set_width((room - 80.0).min(480.0));
}

/// Whether to close the window, and how.
pub fn closing(ui: &mut Ui, shell: &mut Shell, place: &mut Option<Closing>) {
    let Some(mut open) = place.take() else { return };
    let mut parting = None;
    let modal = Modal::new(Id::unique("closing")).show(ui.ctx(), |ui| {
        set_width(ui);
        ui.heading("Close Torquescope?");
        ui.add_space(GAP);
        parting = if shell.is_leaving { wait(ui) } else { ask(ui, shell, &mut open) };
    });
    if modal.should_close() {
        parting = Some(Parting::Stay);
    }
    // It stays until what was chosen is done: saving may fail.
    let stays = parting != Some(Parting::Stay);
    shell.desk.orders.extend(parting.map(Order::Leave));
    *place = stays.then_some(open);
}

/// While the training ends and the session is saved.
fn wait(ui: &mut Ui) -> Option<Parting> {
    widgets::weak(ui, "The session is being saved; then the window closes.");
    ui.add_space(GAP);
    ui.button("Stay").clicked().then_some(Parting::Stay)
}

fn ask(ui: &mut Ui, shell: &Shell, open: &mut Closing) -> Option<Parting> {
    let palette = Palette::in_ui(ui);
    if let Some(work) = &shell.at_work {
        ui.label(format!("{} is still at work.", widgets::sentence_case(work)));
    }
    for text in shell.unsaved {
        ui.label(text);
    }
    ui.add_space(GAP);
    let mut overwrites = None;
    let saves = shell.desk.session.recording.is_some() || !shell.unsaved.is_empty();
    if saves {
        let label = ui.label("File to save into");
        ui.add(TextEdit::singleline(&mut open.path).desired_width(f32::INFINITY)).labelled_by(label.id);
        overwrites = shell.filed.would_overwrite(open.path.trim().as_ref());
        if let Some(text) = &overwrites {
            let text = format!("{text} What it is now stays beside it as .bak.");
            ui.label(egui::RichText::new(text).color(palette.warning));
        }
        ui.add_space(GAP);
    }
    let path = open.path.trim();
    let mut parting = None;
    ui.horizontal_wrapped(|ui| {
        if saves {
            let name = if overwrites.is_some() { "Overwrite it and close" } else { "Save and close" };
            let save = primary(ui, !path.is_empty(), name);
            if save.on_hover_text("A training ends with the best that it has, which is saved too").clicked() {
                parting = Some(Parting::Save(path.into()));
            }
        }
        let (name, what) = match saves {
            true => {
                ("Close, keep a copy", "The next start offers to go on with it; a training goes on from its checkpoint")
            }
            false => ("Stop it and close", "Nothing of it is kept"),
        };
        if ui.button(name).on_hover_text(what).clicked() {
            parting = Some(Parting::KeepCopy);
        }
        if ui.button("Stay").clicked() {
            parting = Some(Parting::Stay);
        }
    });
    parting
}
