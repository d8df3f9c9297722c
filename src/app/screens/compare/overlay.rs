//! Models of the session's history, drawn over the current one.

use std::sync::Arc;

use egui::Ui;
use egui::containers::menu::{MenuButton, MenuConfig};

use crate::app::state::Desk;
use crate::session::Step;

/// The address of a model, by which it is known while it lives.
fn key(model: &Arc<Step>) -> usize {
    Arc::as_ptr(model) as usize
}

/// Lets the user choose which models are drawn too.
pub fn chooser(ui: &mut Ui, desk: &mut Desk, current: &Arc<Step>) {
    let others: Vec<Arc<Step>> = desk.models.iter().filter(|model| !Arc::ptr_eq(model, current)).cloned().collect();
    if others.is_empty() {
        return;
    }
    let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let count = chosen(desk, current).len();
    let name = if count == 0 { "Overlay models".to_owned() } else { format!("Overlay models ({count})") };
    MenuButton::new(name).config(stays).ui(ui, |ui| {
        for model in &others {
            let mut on = desk.state.overlaid.contains(&key(model));
            if ui.checkbox(&mut on, &model.title).changed() {
                desk.state.overlaid.retain(|other| *other != key(model));
                if on {
                    desk.state.overlaid.push(key(model));
                }
            }
        }
    });
}

/// The models that are drawn over the current one.
pub fn chosen(desk: &Desk, current: &Arc<Step>) -> Vec<Arc<Step>> {
    let is_chosen = |model: &&Arc<Step>| desk.state.overlaid.contains(&key(model)) && !Arc::ptr_eq(model, current);
    desk.models.iter().filter(is_chosen).cloned().collect()
}
