//! What the dialog of exports asks about data: the recording or what a model says of it, which part, and into which file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{RichText, Ui, WidgetInfo};

use super::primary::primary;
use super::{ending, which_model};
use crate::app::desk::{DataOut, Desk, Order};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;
use crate::export::part::Part;
use crate::recording::write::Form;
use crate::session::{Session, Step};

fn forms() -> [(Form, &'static str, &'static str); 4] {
    let title = |form| match form {
        Form::Npz => "NPZ",
        Form::Csv => "CSV",
        Form::Parquet => "Parquet",
        Form::Mcap => "MCAP",
    };
    Form::ALL.map(|form| (form, title(form), form.ending()))
}

/// Data, while it is asked how they leave.
pub struct AskedData {
    /// Whether it is what a model says, and not the recording itself.
    torques: bool,
    /// Which model, by name; the current one where none is named.
    of: Option<String>,
    part: Part,
    form: Form,
    /// Where to, as it is typed.
    pub path: String,
}

impl AskedData {
    /// The data of a recording of this name.
    pub fn new(name: &str) -> Self {
        let (part, form) = (Part::Whole, Form::Npz);
        AskedData { torques: false, of: None, part, form, path: format!("{name}-export.npz") }
    }

    /// They go into this file.
    pub fn set_path(&mut self, path: String) {
        ending::follow(&forms(), &mut self.form, &path);
        self.path = path;
    }

    /// Whether each run gets a CSV of its own, in a folder.
    fn is_folder(&self, session: &Session) -> bool {
        let stretches = |recording| Some(self.part.stretches(recording, &session.split).ok()?.len());
        let runs = session.recording.as_deref().and_then(stretches);
        !self.torques && self.form == Form::Csv && runs.is_some_and(|runs| runs > 1)
    }

    /// What is said below the path.
    fn remark(&self, is_folder: bool) -> String {
        let folder = if is_folder { "A CSV holds one run: a folder of this name gets one for each. " } else { "" };
        match (self.torques, self.form.lacks()) {
            (true, _) => "A table: time, measured and predicted torque, residual, each term, and the components that the model has.".into(),
            (false, "") => "All that is known of the arm is in it, in SI units, set right as it is here.".into(),
            (false, lacks) => format!("{folder}In SI units, set right as it is here. Left out: {lacks} (an NPZ keeps all)."),
        }
    }
}

/// The questions, and whether they are answered.
pub fn ask(ui: &mut Ui, desk: &mut Desk, asked: &mut AskedData) -> bool {
    if desk.session.recording.is_none() {
        widgets::weak(ui, "There is no recording yet that could be exported.");
        return ui.button("Close").clicked();
    }
    let model = what(ui, desk.session, asked);
    ui.add_space(GAP);
    ending::choose(ui, &forms(), &mut asked.form, &mut asked.path);
    ui.add_space(GAP);
    ending::ask(ui, &forms(), &mut asked.form, &mut asked.path, false);
    let is_folder = asked.is_folder(desk.session);
    ui.label(RichText::new(asked.remark(is_folder)).size(SMALL).color(Palette::in_ui(ui).weak));
    ui.add_space(GAP);
    let ready = ending::is_named(&forms(), &asked.path) && (model.is_some() || !asked.torques);
    ui.horizontal_wrapped(|ui| {
        let write = primary(ui, ready, "Write the file");
        write.widget_info(|| WidgetInfo::labeled(egui::Role::Button, ready, "Write the file"));
        if write.on_disabled_hover_text("Name a file").clicked() {
            let file = Path::new(asked.path.trim());
            let path: PathBuf = if is_folder { file.with_extension("") } else { file.to_owned() };
            desk.orders.push(Order::WriteData(Box::new(DataOut { torques_of: model, part: asked.part, path })));
            return true;
        }
        if ui.button("Choose a file…").clicked() {
            desk.orders.push(Order::ExportDialog);
        }
        ui.button("Cancel").clicked()
    })
    .inner
}

/// What is written, and of which part; the model, if it is what one says.
fn what(ui: &mut Ui, session: &Session, asked: &mut AskedData) -> Option<Arc<Step>> {
    ui.horizontal_wrapped(|ui| {
        ui.radio_value(&mut asked.torques, false, "The recording");
        ui.add_enabled_ui(session.current().is_some(), |ui| {
            ui.radio_value(&mut asked.torques, true, "Torques of a model")
                .on_hover_text("Measured, predicted, residual, terms and components")
                .on_disabled_hover_text("There is no model yet");
        });
    });
    let model = if asked.torques { which_model::choose(ui, session, &mut asked.of) } else { None };
    ui.horizontal_wrapped(|ui| {
        for part in Part::ALL {
            ui.radio_value(&mut asked.part, part, part.title()).on_hover_text(widgets::sentence_case(part.about()));
        }
    });
    model
}
