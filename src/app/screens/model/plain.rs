//! The parameters of the model by plain least squares over the whole recording, as published values were identified.

use egui::{DragValue, Ui, WidgetInfo, WidgetText};

use crate::app::desk::Desk;
use crate::app::memo::Question;
use crate::app::plot::ticks;
use crate::app::theme::{GAP, Palette};
use crate::app::{tables, widgets};
use crate::model::{Evaluation, Parameter, fit_plain};
use crate::progress::Monitor;
use crate::recording::split::Split;
use crate::session::Session;

/// What is asked for, and with which speed it was asked last.
#[derive(Default, Clone)]
pub struct Plain {
    slowest: f64,
    asked: Option<f64>,
}

/// The question, with the speed \[rad/s or m/s\] below which a joint's samples are left out.
#[derive(Clone, PartialEq)]
struct Identified(f64);

/// The answer: the parameters of all terms, and the nMSE of each joint over the whole recording.
struct Found {
    parameters: Vec<Parameter>,
    nmse: Vec<f64>,
}

impl Question for Identified {
    type Answer = Found;

    fn answer(&self, session: &Session) -> Result<Found, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let model = &session.current().ok_or("there is no model")?.fitted.model;
        let told = |error: crate::model::ModelError| error.to_string();
        let fitted = fit_plain(model, recording, self.0, &Monitor::new()).map_err(told)?;
        let evaluation = Evaluation::of(&fitted, recording, &Split::whole(recording)).map_err(told)?;
        let nmse = evaluation.train.iter().map(|error| error.nmse).collect();
        Ok(Found { parameters: fitted.parameters, nmse })
    }
}

impl Plain {
    /// Asks and tells.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current()) else { return };
        widgets::weak(
            ui,
            "Published parameters were mostly identified by plain least squares over a whole log: nothing is filtered, weighed or held \
             out. The same here, to be held against them. It changes nothing in the session.",
        );
        if step.fitted.model.is_learned() {
            widgets::weak(ui, "A model with networks is trained, not solved for: choose another on Change the model.");
            return;
        }
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Leave out samples of a joint that is slower than");
            let field = DragValue::new(&mut self.slowest).range(0.0..=100.0).speed(0.01).max_decimals(3);
            let field = ui.add(field.suffix(format!(" {}", recording.units()[1]))).labelled_by(label.id);
            field.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, "slowest speed that counts"));
            if ui.button("Identify so").clicked() {
                self.asked = Some(self.slowest);
            }
        });
        ui.add_space(GAP);
        let Some(slowest) = self.asked else { return };
        match desk.memo.later(ui.ctx(), desk.session, Identified(slowest)) {
            None => drop(widgets::weak(ui, "It is being identified…")),
            Some(Err(problem)) => drop(ui.colored_label(Palette::in_ui(ui).error, format!("✖ {problem}."))),
            Some(Ok(found)) => {
                tables::parameters(ui, "plain parameters", "95 % interval", found.parameters.iter());
                let row = |(joint, nmse): (&crate::recording::Joint, &f64)| -> Vec<WidgetText> {
                    vec![joint.name.clone().into(), ticks::percent(*nmse).into()]
                };
                let rows: Vec<Vec<WidgetText>> = recording.joints.iter().zip(&found.nmse).map(row).collect();
                widgets::table(ui, "plain errors", &["", "nMSE over all"], &rows);
            }
        }
    }

    /// What was asked of another recording is not asked of this one.
    pub fn forget(&mut self) {
        self.asked = None;
    }
}
