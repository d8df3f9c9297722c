//! The ladder: held-out error of every joint over the steps of the model, beside the noise; and the seal.

mod figures;
mod seal;

use std::sync::Arc;

use egui::{Rect, RichText, Sense, Ui, WidgetInfo};

use super::diagnose;
use crate::app::desk::{About, Desk, Focus, Needs, Order, Question};
use crate::app::dock::{self, Part};
use crate::app::plot::{PanelView, ticks};
use crate::app::screen::{Next, NextStep, Screen};
use crate::app::theme::{Palette, SMALL};
use crate::app::{tables, widgets};
use crate::diagnosis::Verdict;
use crate::effect::registry;
use crate::figure::Panel;
use crate::figure::table::Table;
use crate::model::Term;
use crate::recording::Recording;
use crate::recording::seal::HiddenEffect;
use crate::session::{Command, Session, Step};

/// How much of the colour is seen over the bars that lead back.
const LIT: f32 = 0.15;
/// Least height of the bars \[points\].
const LEAST_BARS: f32 = 170.0;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "ladder",
    title: "Ladder",
    purpose: "How the error fell with every added effect",
    needs: Needs::Model,
    on_the_way: true,
};

const PANELS: Part<Ladder> = Part::Stack(&[
    (2.8, Part::Panel("Steps", |_, ui, desk| ladder(ui, desk))),
    (
        1.0,
        Part::Beside(&[
            (1.0, Part::Panel("What was found", |_, ui, desk| found(ui, desk))),
            (1.0, Part::Panel("The truth", |_, ui, desk| seal::show(ui, desk))),
        ]),
    ),
]);

/// The screen of the ladder; all that it shows is in the session.
#[derive(Default, Clone)]
pub struct Ladder;

impl Screen for Ladder {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        widgets::headline(ui, "The ladder", &summary(desk.session));
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        figures::figures(desk.session, &figures::models(desk))
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(self.clone())
    }

    fn is_done(&self, session: &Session) -> bool {
        session.ladder.len() > 1
    }

    fn next(&self, session: &Session, _: &Focus) -> Next {
        let is_sealed = session.recording.as_ref().is_some_and(|recording| recording.seal.is_some());
        let sealed = session.truth.is_none() && is_sealed;
        match &session.report {
            None if session.ladder.len() > 1 => {
                let why = "Ask what the current model still lacks";
                Next::Step(NextStep::run("Diagnose again", why, Command::Diagnose))
            }
            None if session.ladder.len() == 1 => Next::Step(NextStep::show(&diagnose::ABOUT)),
            Some(report) if sealed && report.verdict == Verdict::NothingMissing => {
                let why = "Compare what was found with what was hidden";
                Next::Step(NextStep { label: "Open the seal".to_owned(), why, order: Question::open_seal() })
            }
            _ => Next::OnTheWay,
        }
    }

    fn answers(&self, command: &Command) -> bool {
        matches!(command, Command::AddEffect { .. })
    }
}

fn ladder(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    // The table below stays in sight as far as that leaves something of the bars.
    let table = 110.0 + 32.0 * (desk.session.ladder.len() + 2) as f32;
    let height = (ui.available_height() - table - 50.0).clamp(LEAST_BARS, 300.0);
    widgets::card(ui, "Held-out error by step (nMSE, logarithmic)", |ui| bars(ui, desk, height));
    steps(ui, desk, &recording);
}

/// One sentence: from where to where.
fn summary(session: &Session) -> String {
    let (Some(first), Some(last)) = (session.ladder.first(), session.ladder.last()) else { return String::new() };
    let list = |errors: Vec<f64>| errors.into_iter().map(ticks::percent).collect::<Vec<_>>().join(" · ");
    let (from, to) = (list(first.evaluation.held_out_nmse()), list(last.evaluation.held_out_nmse()));
    if session.ladder.len() == 1 {
        return format!("Held-out error by joint: {from}. Each effect that you add is a step down.");
    }
    let errors =
        [&first.evaluation, &last.evaluation].map(|evaluation| evaluation.held_out.iter().map(|error| error.nmse));
    let [before, after] = errors.map(|errors| errors.sum::<f64>());
    let verb = if after < before { "fell" } else { "rose" };
    format!("Held-out error by joint {verb} from {from} to {to}{}.", verdict(session))
}

/// Whether what was hidden is in the model, once the seal is open.
fn verdict(session: &Session) -> String {
    let Some(truth) = session.truth.as_deref() else { return String::new() };
    let Some(step) = session.current() else { return String::new() };
    let found = |hidden: &HiddenEffect| {
        step.fitted.model.effects().any(|term| term.effect.id == hidden.effect && term.joint == hidden.joint)
    };
    if truth.effects.is_empty() {
        return "; nothing was hidden".to_owned();
    }
    if !truth.effects.iter().all(found) {
        return "; the hidden effect was not found".to_owned();
    }
    let mut names: Vec<&str> = Vec::new();
    for hidden in &truth.effects {
        let name = registry::find(&hidden.effect).map_or(hidden.effect.as_str(), |effect| effect.name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    format!("; hidden effect found: {}", names.join(", "))
}

/// For every model a group of bars, one for each joint; a click on a group goes back to its step, or to that model.
fn bars(ui: &mut Ui, desk: &mut Desk, height: f32) {
    let models = figures::models(desk);
    let Some(panel) = figures::figures(desk.session, &models).pop() else {
        widgets::weak(ui, "There are no held-out samples, so there is no error to show.");
        return;
    };
    let view = PanelView::new(panel).height(height).spoken("bars of held-out error by step and joint");
    let shown = view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
    let current = desk.session.ladder.len().saturating_sub(1);
    for (number, model) in models.iter().enumerate().filter(|(number, _)| *number != current) {
        let place = shown.place();
        let [left, right] = [-0.5, 0.5].map(|side| place.at(0, number as f64 + side) as f32);
        let room = Rect::from_x_y_ranges(left..=right, shown.plot.y_range()).intersect(shown.plot);
        match number < current {
            true => {
                let hint = format!("Go back to step {}, {}; undo brings the later ones back", number + 1, model.name);
                leads_to(ui, desk, room, &format!("bars of step {}", number + 1), hint, Command::GoTo { step: number });
            }
            false => {
                let hint = format!("Use {}; undo takes it back", model.name);
                let name = model.name.clone();
                leads_to(ui, desk, room, &format!("bars of {name}"), hint, Command::TakeUp { name });
            }
        }
    }
}

/// The place of a model's bars, which takes one there.
fn leads_to(ui: &mut Ui, desk: &mut Desk, rect: Rect, spoken: &str, hint: String, command: Command) {
    let response = ui.interact(rect, ui.scope_id().with(spoken), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, spoken));
    if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 4, Palette::in_ui(ui).accent.gamma_multiply(LIT));
    }
    if response.on_hover_text(hint).clicked() {
        desk.run(command);
    }
}

fn steps(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "", |ui| {
        let count = desk.session.ladder.len();
        let shown = egui::Grid::new("steps").striped(true).spacing([18.0, 6.0]).show(ui, |ui| {
            ui.label(RichText::new("step").size(SMALL).color(palette.weak));
            for joint in &recording.joints {
                ui.label(RichText::new(format!("{}: nMSE", joint.name)).size(SMALL).color(palette.weak));
                ui.label(RichText::new("R²").size(SMALL).color(palette.weak));
            }
            ui.label("");
            ui.end_row();
            for (number, step) in desk.session.ladder.iter().enumerate() {
                ui.label(format!("{}  {}", number + 1, step.name));
                for error in &step.evaluation.held_out {
                    ui.label(ticks::percent(error.nmse));
                    ui.label(ticks::number(error.r2));
                }
                if number + 1 == count {
                    ui.label(RichText::new("current model").size(SMALL).color(palette.weak));
                } else if ui.button(format!("Go back to step {}", number + 1)).clicked() {
                    desk.orders.push(Order::run(Command::GoTo { step: number }));
                }
                ui.end_row();
            }
            if let Some(floor) = desk.session.current().and_then(|step| step.evaluation.noise_floor_nmse.as_ref()) {
                ui.label(RichText::new("noise floor").color(palette.weak));
                for error in floor {
                    ui.label(RichText::new(ticks::percent(*error)).color(palette.weak));
                    ui.label("");
                }
                ui.end_row();
            }
        });
        widgets::copied(ui, &shown.response, "steps", || as_table(&desk.session.ladder, recording));
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            let ready = desk.busy.is_none();
            let again = ui.add_enabled(ready, egui::Button::new("Diagnose again"));
            if again.on_hover_text("Ask what the current model still lacks").clicked() {
                desk.run(Command::Diagnose);
            }
            if ui.add_enabled(count > 1 && ready, egui::Button::new("Remove the last step")).clicked() {
                desk.run(Command::GoTo { step: count.saturating_sub(2) });
            }
        });
    });
}

/// The steps with their errors by joint, to be copied.
fn as_table(ladder: &[Arc<Step>], recording: &Recording) -> Table {
    let errors = recording.joints.iter().flat_map(|joint| [format!("{}: nMSE", joint.name), "R²".to_owned()]);
    let row = |step: &Arc<Step>| {
        let errors = step.evaluation.held_out.iter().flat_map(|error| [error.nmse, error.r2].map(ticks::number));
        [step.name.clone()].into_iter().chain(errors).collect()
    };
    Table {
        title: "held-out error, step by step".to_owned(),
        head: ["step".to_owned()].into_iter().chain(errors).collect(),
        rows: ladder.iter().map(row).collect(),
    }
}

/// The parameters of the effects in the current model.
fn found(ui: &mut Ui, desk: &mut Desk) {
    let Some(step) = desk.session.current() else { return };
    widgets::card(ui, "", |ui| {
        let of_effects = |term: usize| matches!(step.fitted.model.terms.get(term), Some(Term::Effect(_)));
        let parameters = step.fitted.parameters.iter().filter(|parameter| of_effects(parameter.term));
        if parameters.clone().next().is_none() {
            widgets::weak(ui, "No effect was added to the model yet.");
            if ui.button(format!("Go to: {}", diagnose::ABOUT.title)).clicked() {
                desk.orders.push(Order::Show(&diagnose::ABOUT));
            }
            return;
        }
        tables::parameters(ui, "found", "95 % interval", parameters);
    });
}
