//! How the torque follows from a command where a log has none: the law of the drive and its constants, in the import assistant.

use egui::{ComboBox, RichText, TextEdit, Ui, WidgetInfo};

use crate::app::theme::{Palette, SMALL};
use crate::recording::drive::{Drive, PerJoint};
use crate::recording::mapping::{Channel, Draft};

/// What a log is whose torque is in it.
const LOGGED: &str = "logged";

/// The constants of the law, as they are typed; none where the torque is logged.
#[derive(Default)]
pub struct Law {
    constants: Vec<String>,
}

impl Law {
    /// Of a drive; what nobody said is blank.
    pub fn of(drive: Option<&Drive>) -> Self {
        let written = |constant: &PerJoint| match constant {
            PerJoint::One(value) if value.is_nan() => String::new(),
            stated => stated.to_string(),
        };
        let constants = drive.into_iter().flat_map(Drive::constants);
        Law { constants: constants.map(|(_, constant)| written(constant)).collect() }
    }

    /// Asks for it; whether another law was chosen.
    pub fn ask(&mut self, ui: &mut Ui, draft: &mut Draft) -> bool {
        let is_another = ui.horizontal_wrapped(|ui| {
            ui.label("It is");
            let now = draft.drive.as_ref().map_or(LOGGED, Drive::name);
            let said = |name: &str| if name == LOGGED { LOGGED.to_owned() } else { format!("from a {name}") };
            let mut chosen = None;
            let laws = Drive::laws().map(|(name, law)| (name, Some(law)));
            let chooser = ComboBox::from_id_salt("law").width(170.0).selected_text(said(now)).show_ui(ui, |ui| {
                for (name, law) in std::iter::once((LOGGED, None)).chain(laws) {
                    if ui.selectable_label(now == name, said(name)).clicked() && now != name {
                        chosen = Some(law);
                    }
                }
            });
            let spoken = "how the torque is known";
            chooser.response.widget_info(|| WidgetInfo::labeled(egui::Role::ComboBox, true, spoken));
            let is_another = chosen.is_some();
            if let Some(law) = chosen {
                *self = Law::of(law.as_ref());
                draft.state_drive(law);
            }
            self.constants(ui, draft.drive.as_mut());
            is_another
        });
        let joints = draft.columns.iter().filter(|role| role.channel == Some(Channel::Position)).count();
        if let Some(drive) = draft.drive.as_ref().filter(|drive| joints > 0 && drive.check_for(joints).is_ok()) {
            let [law, absorbs] = drive.absorbs(joints);
            let text = format!("{} {absorbs}", crate::app::widgets::sentence_case(&law));
            ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
        }
        is_another.inner
    }

    /// What is typed is what holds; what is no number is told with the mapping.
    fn constants(&mut self, ui: &mut Ui, drive: Option<&mut Drive>) {
        let Some(drive) = drive else { return };
        let about: Vec<_> = drive.constants().into_iter().map(|(constant, _)| constant).collect();
        for ((constant, value), text) in about.iter().zip(drive.constants_mut()).zip(&mut self.constants) {
            let unit = if constant.unit.is_empty() { String::new() } else { format!(" [{}]", constant.unit) };
            let label = ui.label(format!("{}{unit}", constant.name));
            let field = TextEdit::singleline(text).desired_width(70.0).hint_text("number");
            let field = ui.add(field).labelled_by(label.id);
            if field.on_hover_text(format!("{}: one number, or one a joint, as in 20, 15", constant.about)).changed() {
                *value = text.parse().unwrap_or(PerJoint::One(f64::NAN));
            }
        }
    }
}
