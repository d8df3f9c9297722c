//! Models of the session's history, drawn over the current one.

use std::sync::Arc;

use egui::Ui;
use egui::containers::menu::{MenuButton, MenuConfig};

use crate::app::desk::Desk;
use crate::session::Step;

/// Lets the user choose which models are drawn too.
pub fn chooser(ui: &mut Ui, desk: &mut Desk, current: &Step) {
    let others: Vec<&Arc<Step>> = desk.models.iter().filter(|model| model.generation != current.generation).collect();
    if others.is_empty() {
        return;
    }
    let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let count = chosen(desk, current).len();
    let name = if count == 0 { "Overlay models".to_owned() } else { format!("Overlay models ({count})") };
    let overlaid = &mut desk.focus.overlaid;
    MenuButton::new(name).config(stays).ui(ui, |ui| {
        for model in others {
            let mut on = overlaid.contains(&model.generation);
            if ui.checkbox(&mut on, &model.title).changed() {
                overlaid.retain(|other| *other != model.generation);
                if on {
                    overlaid.push(model.generation);
                }
            }
        }
    });
}

/// The models that are drawn over the current one.
pub fn chosen(desk: &Desk, current: &Step) -> Vec<Arc<Step>> {
    let overlaid = &desk.focus.overlaid;
    let is_chosen = |model: &&Arc<Step>| overlaid.contains(&model.generation) && model.generation != current.generation;
    desk.models.iter().filter(is_chosen).cloned().collect()
}
