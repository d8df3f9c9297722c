//! Models of the session's history, drawn over the current one.

use std::sync::Arc;

use egui::Ui;
use egui::containers::menu::{MenuButton, MenuConfig};

use crate::app::desk::Desk;
use crate::session::{Generation, Step};

/// Which models are drawn over the current one.
#[derive(Default)]
pub struct Overlay(Vec<Generation>);

impl Overlay {
    /// Lets the user choose which models are drawn too.
    pub fn chooser(&mut self, ui: &mut Ui, desk: &Desk, current: &Step) {
        let others: Vec<&Arc<Step>> =
            desk.models.iter().filter(|model| model.generation != current.generation).collect();
        if others.is_empty() {
            return;
        }
        let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
        let count = self.chosen(desk, current).len();
        let name = if count == 0 { "Overlay models".to_owned() } else { format!("Overlay models ({count})") };
        MenuButton::new(name).config(stays).ui(ui, |ui| {
            for model in others {
                let mut on = self.0.contains(&model.generation);
                if ui.checkbox(&mut on, &model.title).changed() {
                    self.0.retain(|other| *other != model.generation);
                    if on {
                        self.0.push(model.generation);
                    }
                }
            }
        });
    }

    /// The models that are drawn over the current one.
    pub fn chosen(&self, desk: &Desk, current: &Step) -> Vec<Arc<Step>> {
        let is_chosen =
            |model: &&Arc<Step>| self.0.contains(&model.generation) && model.generation != current.generation;
        desk.models.iter().filter(is_chosen).cloned().collect()
    }
}
