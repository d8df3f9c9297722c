//! What the dialog of exports asks about a model: as what it leaves, and into which files.

use std::path::{Path, PathBuf};

use egui::{DragValue, RichText, TextEdit, Ui, WidgetInfo};

use super::primary::primary;
use super::{ending, which_model};
use crate::app::desk::{Desk, ModelOut, Order};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;
use crate::export::kind::{KINDS, Kind};
use crate::export::outgoing::{SMOOTH, Wish};
use crate::model::Model;
use crate::session::Session;

/// A model, while it is asked how it leaves.
pub struct AskedModel {
    /// Which, by name; the current one where none is named.
    of: Option<String>,
    kind: Kind,
    /// Where to, as it is typed.
    pub path: String,
    /// The robot's own file, as it is typed.
    pub into: String,
    /// The model's joints in it, with commas between them; none for those that move.
    joints: String,
    inertials: bool,
    smooth: f64,
}

impl AskedModel {
    /// The current model of a session of this name.
    pub fn new(name: &str, session: &Session) -> Self {
        let suits = |kind: &Kind| session.current().is_none_or(|step| kind.suits(&step.fitted.model));
        let kind = kinds().find(suits).unwrap_or(Kind::Network);
        let path = file_of(&function_name(name), kind);
        let (into, joints) = (String::new(), String::new());
        AskedModel { of: None, kind, path, into, joints, inertials: false, smooth: SMOOTH }
    }

    /// It goes into this file.
    pub fn set_path(&mut self, path: String) {
        ending::follow(&endings(|_| true), &mut self.kind, &path);
        self.path = path;
    }

    fn is_folder(&self) -> bool {
        self.kind.ending().is_empty()
    }

    fn is_robot(&self) -> bool {
        matches!(self.kind, Kind::Robot(_))
    }

    /// Another model can't always be written as the one before.
    fn suit(&mut self, model: &Model) {
        if let Some(kind) = kinds().find(|kind| kind.suits(model)).filter(|_| !self.kind.suits(model)) {
            self.path = file_of(&self.path, kind);
            self.kind = kind;
        }
    }

    fn wish(&self) -> Wish {
        let typed = |text: &str| PathBuf::from(text.trim());
        let names = self.joints.split(',').map(str::trim).filter(|name| !name.is_empty());
        Wish {
            kind: self.kind,
            output: Some(typed(&self.path)),
            into: self.is_robot().then(|| typed(&self.into)),
            joints: names.map(str::to_owned).collect(),
            inertials: self.inertials && self.is_robot(),
            smooth: self.smooth,
        }
    }
}

fn kinds() -> impl Iterator<Item = Kind> {
    KINDS.into_iter().map(|(.., kind)| kind)
}

/// What can be chosen, with how its files end.
fn endings(can: impl Fn(Kind) -> bool) -> Vec<(Kind, &'static str, &'static str)> {
    kinds().filter(|kind| can(*kind)).map(|kind| (kind, kind.title(), kind.ending())).collect()
}

/// The same place for another kind.
fn file_of(path: &str, kind: Kind) -> String {
    Path::new(path).with_extension(kind.ending()).to_string_lossy().into_owned()
}

/// The file names the function, which begins with a letter and has letters, digits and _.
fn function_name(name: &str) -> String {
    let kept = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    let name: String = name.chars().map(kept).collect();
    match name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        true => name + "_torque",
        false => format!("arm_{name}_torque"),
    }
}

/// The questions, and whether they are answered.
pub fn ask(ui: &mut Ui, desk: &mut Desk, asked: &mut AskedModel) -> bool {
    let Some(model) = which_model::choose(ui, desk.session, &mut asked.of) else {
        widgets::weak(ui, "There is no model yet that could be exported.");
        return ui.button("Close").clicked();
    };
    asked.suit(&model.fitted.model);
    let choices = endings(|kind| kind.suits(&model.fitted.model));
    ending::choose(ui, &choices, &mut asked.kind, &mut asked.path);
    weak(ui, &format!("{}.", widgets::sentence_case(asked.kind.about())));
    ui.add_space(GAP);
    if asked.is_robot() {
        robot(ui, desk, asked)
    } else {
        smooth(ui, asked)
    }
    ui.add_space(GAP);
    let is_folder = asked.is_folder();
    ending::ask(ui, &choices, &mut asked.kind, &mut asked.path, is_folder);
    let place = match asked.kind {
        Kind::Code(_) => {
            "The file's name is that of the function; a test with states of the recording stands beside it."
        }
        Kind::Robot(_) => "Nothing else in it changes. If this is the robot's own file, that stays beside it as .bak.",
        Kind::Network => "A folder with weights, the torque as ONNX, and what computes and tests it in NumPy.",
    };
    weak(ui, &format!("{place} What it can't hold is told once it is written, with its share of the torque."));
    ui.add_space(GAP);
    let is_named = if is_folder { !asked.path.trim().is_empty() } else { ending::is_named(&choices, &asked.path) };
    let ready = is_named && !(asked.is_robot() && asked.into.trim().is_empty());
    ui.horizontal_wrapped(|ui| {
        let write = primary(ui, ready, "Write the file");
        write.widget_info(|| WidgetInfo::labeled(egui::Role::Button, ready, "Write the file"));
        if write.on_disabled_hover_text("Name a file, and that of the robot if it goes into one").clicked() {
            desk.orders.push(Order::WriteModel(Box::new(ModelOut { model, wish: asked.wish() })));
            return true;
        }
        if ui.button("Choose a file…").clicked() {
            desk.orders.push(Order::ExportDialog);
        }
        ui.button("Cancel").clicked()
    })
    .inner
}

/// Which of the robot's files, and what goes into it.
fn robot(ui: &mut Ui, desk: &mut Desk, asked: &mut AskedModel) {
    let label = ui.label("The robot's own file");
    let edit = TextEdit::singleline(&mut asked.into).hint_text("path/to/robot.urdf").desired_width(f32::INFINITY);
    ui.add(edit).labelled_by(label.id);
    if ui.button("Choose the robot's file…").clicked() {
        desk.orders.push(Order::RobotFileDialog);
    }
    let label = ui.label("The model's joints in it, base first");
    let edit = TextEdit::singleline(&mut asked.joints).hint_text("those that move").desired_width(f32::INFINITY);
    ui.add(edit).labelled_by(label.id);
    ui.checkbox(&mut asked.inertials, "Masses of its links, too")
        .on_hover_text("Those that can exist and are nearest to what was identified, along the recording");
}

/// How dry friction turns round.
fn smooth(ui: &mut Ui, asked: &mut AskedModel) {
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Dry friction turns round within");
        let drag = DragValue::new(&mut asked.smooth).range(1e-6..=10.0).speed(0.001).max_decimals(6);
        ui.add(drag.suffix(" rad/s or m/s")).labelled_by(label.id);
    });
}

fn weak(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_as_a_function_may_be() {
        assert_eq!(function_name("three-joint demo"), "three_joint_demo_torque");
        assert_eq!(function_name("7 größen"), "arm_7_gr__en_torque");
    }
}
