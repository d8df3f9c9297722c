//! The parameters of the model by plain least squares over the whole recording, as published values were identified.

use egui::{Button, DragValue, Ui, WidgetInfo, WidgetText};

use crate::app::desk::Desk;
use crate::app::plot::ticks;
use crate::app::theme::{GAP, Palette};
use crate::app::{tables, widgets};
use crate::model::{Evaluation, Model, ModelError, Parameter, fit_plain};
use crate::progress::{Monitor, Progress};
use crate::recording::Recording;
use crate::recording::split::Split;
use crate::session::Session;
use crate::work::{Job, Outcome};

/// What is asked for, and what was found.
#[derive(Default)]
pub struct Plain {
    /// Speed \[rad/s or m/s\] below which a joint's samples are left out.
    slowest: f64,
    running: Option<Job<Found>>,
    found: Option<Result<Found, String>>,
}

/// The parameters of all terms, and the nMSE of each joint over the whole recording.
struct Found {
    parameters: Vec<Parameter>,
    nmse: Vec<f64>,
}

impl Found {
    fn of(model: &Model, recording: &Recording, slowest: f64, monitor: &Monitor) -> Result<Found, ModelError> {
        let fitted = fit_plain(model, recording, slowest, monitor)?;
        monitor.report(0.9, "measuring the error over all")?;
        let evaluation = Evaluation::of(&fitted, recording, &Split::whole(recording))?;
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
            if ui.add_enabled(self.running.is_none(), Button::new("Identify so")).clicked() {
                self.begin(ui.ctx(), desk.session);
            }
        });
        ui.add_space(GAP);
        if let Some((_, progress)) = self.at_work() {
            widgets::progress(ui, progress.fraction, ui.available_width());
            widgets::weak(ui, progress.activity);
            if ui.button("Stop identifying").clicked() {
                self.stop("you pressed Stop");
            }
            return;
        }
        match &self.found {
            None => (),
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

    fn begin(&mut self, ctx: &egui::Context, session: &Session) {
        let (Some(recording), Some(step)) = (session.recording.clone(), session.current().cloned()) else { return };
        let (slowest, context) = (self.slowest, ctx.clone());
        self.found = None;
        self.running = Some(Job::spawn(
            "plain least squares",
            move || context.request_repaint(),
            move |monitor| Found::of(&step.fitted.model, &recording, slowest, monitor),
        ));
    }

    /// Receives what the job has.
    pub fn poll(&mut self) {
        let Some(outcome) = self.running.as_mut().and_then(Job::poll) else { return };
        self.running = None;
        self.found = match outcome {
            Outcome::Done(found) => Some(Ok(found)),
            Outcome::Stopped(_) => None,
            Outcome::Failed(message) => Some(Err(message)),
            Outcome::Panicked(message) => Some(Err(format!("a defect of the program ended it: {message}"))),
        };
    }

    /// The job: its name, and how far it is.
    pub fn at_work(&self) -> Option<(&str, Progress)> {
        self.running.as_ref().map(|job| (job.name(), job.progress()))
    }

    /// Stops the job.
    pub fn stop(&mut self, reason: &str) {
        if let Some(job) = &mut self.running {
            job.stop(reason);
        }
    }

    /// What was found of another model or recording says nothing of this one.
    pub fn follow(&mut self, before: &Session, after: &Session) {
        let model = |session: &Session| session.current().map(|step| step.generation);
        if !after.has_recording_of(before) || model(before) != model(after) {
            self.stop("the model or the recording changed");
            (self.running, self.found) = (None, None);
        }
    }
}
