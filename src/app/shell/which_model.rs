//! Which of the session's models is meant.

use std::sync::Arc;

use egui::{ComboBox, Ui};

use crate::session::{Session, Step};

/// The model of this name, or the current one where none is named; another can be chosen.
pub fn choose(ui: &mut Ui, session: &Session, name: &mut Option<String>) -> Option<Arc<Step>> {
    let named = name.as_ref().and_then(|name| session.model(name));
    let mut chosen = Arc::clone(named.or(session.current())?);
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Model");
        let chooser = ComboBox::from_id_salt("which model").selected_text(&chosen.name).width(320.0).truncate();
        let chooser = chooser.show_ui(ui, |ui| {
            for step in session.all_models() {
                if ui.selectable_label(step.generation == chosen.generation, &step.name).clicked() {
                    *name = Some(step.name.clone());
                    chosen = Arc::clone(step);
                }
            }
        });
        chooser.response.labelled_by(label.id);
    });
    Some(chosen)
}
