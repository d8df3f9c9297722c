//! The ladder: held-out error of every joint over the steps of the model, beside the noise; and the seal.

use egui::{Align2, FontId, Rect, RichText, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo, WidgetText, pos2, vec2};

use super::diagnose;
use crate::app::desk::{About, Desk, Needs, Order};
use crate::app::dock::{self, Part};
use crate::app::plot::{export, ticks};
use crate::app::screen::{Next, NextStep, Screen};
use crate::app::tables::parameter_row;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;
use crate::diagnosis::Verdict;
use crate::effect::registry;
use crate::figure::mark::{Bars, Line};
use crate::figure::{Axis, Ink, Panel};
use crate::model::Term;
use crate::recording::Recording;
use crate::recording::seal::{HiddenEffect, Truth};
use crate::session::{Command, Session};

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
            (1.0, Part::Panel("The truth", |_, ui, desk| seal(ui, desk))),
        ]),
    ),
]);

/// The screen of the ladder; all that it shows is in the session.
#[derive(Default)]
pub struct Ladder;

impl Screen for Ladder {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        widgets::headline(ui, "The ladder", &summary(desk.session));
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn is_done(&self, session: &Session) -> bool {
        session.ladder.len() > 1
    }

    fn next(&self, session: &Session) -> Next {
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
                Next::Step(NextStep::run("Open the seal", why, Command::OpenSeal))
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
    widgets::card(ui, "Held-out error by step (nMSE, logarithmic)", |ui| bars(ui, desk, &recording, height));
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

/// The same as data.
fn panel(session: &Session, errors: &[Vec<f64>], floor: Option<&[f64]>, recording: &Recording) -> Panel {
    let titles = session.ladder.iter().map(|step| step.title.clone()).collect();
    let y = Axis::new("held-out nMSE", "").logarithmic();
    let mut panel = Panel::new("held-out error by step", [Axis::names("", titles), y]);
    let joints = recording.joint_count();
    let width = 0.7 / joints.max(1) as f64;
    for (joint, info) in recording.joints.iter().enumerate() {
        let at = |step: usize| step as f64 + (joint as f64 - (joints as f64 - 1.0) / 2.0) * width;
        let bars = errors.iter().enumerate();
        let bars = bars.map(|(step, errors)| [at(step), errors[joint], f64::NAN, f64::NAN]).collect();
        panel.push(Bars { name: info.name.clone(), bars, width: 0.9 * width, ink: Ink::Series(joint), written: None });
        for (step, noise) in floor.iter().flat_map(|floor| (0..errors.len()).map(|step| (step, floor[joint]))) {
            let ends = [at(step) - width / 2.0, at(step) + width / 2.0].map(|x| [x, noise]);
            panel.push(Line::through("noise floor", ends, Ink::Text));
        }
    }
    panel
}

/// For every step a group of bars, one for each joint, down from 100 % on a logarithmic axis; a line marks the noise floor. A
/// click on a group goes back to its step.
fn bars(ui: &mut Ui, desk: &mut Desk, recording: &Recording, height: f32) {
    let palette = Palette::in_ui(ui);
    let session = desk.session;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
    response.widget_info(|| {
        WidgetInfo::labeled(egui::Role::GraphicsObject, true, "bars of held-out error by step and joint")
    });
    let floor = session.current().and_then(|step| step.evaluation.noise_floor_nmse.clone());
    let errors: Vec<Vec<f64>> = session.ladder.iter().map(|step| step.evaluation.held_out_nmse()).collect();
    let all = errors
        .iter()
        .flatten()
        .chain(floor.iter().flatten())
        .copied()
        .filter(|error| error.is_finite() && *error > 0.0);
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), error| (low.min(error), high.max(error)));
    if low > high {
        widgets::weak(ui, "There are no held-out samples, so there is no error to show.");
        return;
    }
    export::offer(ui, &response, || panel(session, &errors, floor.as_deref(), recording));
    let (bottom, top) = ((0.7 * low).log10().floor(), (1.05 * high).log10().ceil());
    let plot = Rect::from_min_max(rect.min + vec2(62.0, 26.0), rect.max - vec2(8.0, 26.0));
    let painter = ui.painter().clone();
    painter.rect_filled(plot, 0, palette.canvas);
    let y = |error: f64| {
        plot.bottom() - ((error.max(1e-300).log10() - bottom) / (top - bottom).max(1.0)) as f32 * plot.height()
    };
    let font = FontId::proportional(SMALL);
    for decade in bottom as i32..=top as i32 {
        let at = y(10f64.powi(decade)).round() + 0.5;
        painter.hline(plot.x_range(), at, Stroke::new(1.0, palette.grid));
        let text = ticks::percent(10f64.powi(decade));
        painter.text(pos2(plot.left() - 6.0, at), Align2::RIGHT_CENTER, text, font.clone(), palette.weak);
    }
    let joints = recording.joint_count();
    let group = plot.width() / errors.len().max(1) as f32;
    let width = (group * 0.7 / joints as f32).min(64.0);
    for (step, errors) in errors.iter().enumerate() {
        let middle = plot.left() + group * (step as f32 + 0.5);
        if step + 1 < session.ladder.len() {
            go_back(ui, desk, step, Rect::from_center_size(pos2(middle, plot.center().y), vec2(group, plot.height())));
        }
        for (joint, error) in errors.iter().enumerate() {
            let left = middle + (joint as f32 - joints as f32 / 2.0) * width;
            let bar = Rect::from_min_max(pos2(left + 2.0, y(*error)), pos2(left + width - 2.0, plot.bottom()));
            let (color, _) = palette.nth(joint);
            painter.rect_filled(bar, 2, color.gamma_multiply(0.35));
            painter.rect_stroke(bar, 2, Stroke::new(1.2, color), StrokeKind::Inside);
            painter.text(
                pos2(bar.center().x, bar.top() - 2.0),
                Align2::CENTER_BOTTOM,
                ticks::percent(*error),
                font.clone(),
                palette.text,
            );
            let name = format!("{}", joint + 1);
            if bar.height() > 18.0 {
                painter.text(
                    pos2(bar.center().x, plot.bottom() - 3.0),
                    Align2::CENTER_BOTTOM,
                    name,
                    font.clone(),
                    palette.text,
                );
            }
            if let Some(floor) = floor.as_ref().map(|floor| floor[joint]) {
                let line = [pos2(left, y(floor)), pos2(left + width, y(floor))];
                let stroke = Stroke::new(2.0, palette.text);
                painter.extend(Shape::dashed_line(&line, stroke, 4.0, 2.0));
            }
        }
        let title = session.ladder[step].title.as_str();
        let galley = painter.layout(title.to_owned(), font.clone(), palette.text, group - 8.0);
        let size = galley.size();
        painter.galley(pos2(middle - size.x / 2.0, plot.bottom() + 5.0), galley, palette.text);
    }
    painter.rect_stroke(plot, 0, Stroke::new(1.0, palette.border), StrokeKind::Outside);
    let legend =
        if floor.is_some() { "bars: joints 1, 2, …   dashed line: noise floor" } else { "bars: joints 1, 2, …" };
    painter.text(pos2(plot.right(), rect.top() + 4.0), Align2::RIGHT_TOP, legend, font, palette.weak);
}

/// The place of a step's bars, which takes one back there.
fn go_back(ui: &mut Ui, desk: &mut Desk, step: usize, rect: Rect) {
    let response = ui.interact(rect, ui.scope_id().with(("step", step)), Sense::click());
    let spoken = format!("bars of step {}", step + 1);
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &spoken));
    if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 4, Palette::in_ui(ui).accent_soft);
    }
    if response.on_hover_text(format!("Go back to step {}; undo brings the later ones back", step + 1)).clicked() {
        desk.run(Command::GoTo { step });
    }
}

fn steps(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "", |ui| {
        let count = desk.session.ladder.len();
        egui::Grid::new("steps").striped(true).spacing([18.0, 6.0]).show(ui, |ui| {
            ui.label(RichText::new("step").size(SMALL).color(palette.weak));
            for joint in &recording.joints {
                ui.label(RichText::new(format!("{}: nMSE", joint.name)).size(SMALL).color(palette.weak));
                ui.label(RichText::new("R²").size(SMALL).color(palette.weak));
            }
            ui.label("");
            ui.end_row();
            for (number, step) in desk.session.ladder.iter().enumerate() {
                ui.label(format!("{}  {}", number + 1, step.title));
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
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            let ready = desk.busy.is_none();
            if widgets::primary(ui, ready, "Diagnose again")
                .on_hover_text("Ask what the current model still lacks")
                .clicked()
            {
                desk.run(Command::Diagnose);
            }
            if ui.add_enabled(count > 1 && ready, egui::Button::new("Remove the last step")).clicked() {
                desk.run(Command::GoTo { step: count.saturating_sub(2) });
            }
        });
    });
}

/// The parameters of the effects in the current model.
fn found(ui: &mut Ui, desk: &mut Desk) {
    let Some(step) = desk.session.current() else { return };
    widgets::card(ui, "", |ui| {
        let of_effects = |term: usize| matches!(step.fitted.model.terms.get(term), Some(Term::Effect(_)));
        let rows: Vec<Vec<WidgetText>> =
            step.fitted.parameters.iter().filter(|parameter| of_effects(parameter.term)).map(parameter_row).collect();
        if rows.is_empty() {
            widgets::weak(ui, "No effect was added to the model yet.");
            if ui.button(format!("Go to: {}", diagnose::ABOUT.title)).clicked() {
                desk.orders.push(Order::Show(&diagnose::ABOUT));
            }
            return;
        }
        widgets::table(ui, "found", &["parameter", "joint", "value", "95 % interval", "unit"], &rows);
    });
}

/// The sealed truth beside what was found.
fn seal(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    let Some(truth) = desk.session.truth.clone() else {
        widgets::card(ui, "", |ui| {
            if recording.seal.is_none() {
                widgets::weak(
                    ui,
                    "This was measured on a real arm: nobody knows the truth. Judge by the held-out error.",
                );
                return;
            }
            widgets::weak(ui, "What was hidden is sealed. Open it once you are done: then nothing is left to find.");
            ui.add_space(GAP);
            if ui.button("Open the seal").clicked() {
                desk.run(Command::OpenSeal);
            }
        });
        return;
    };
    widgets::card(ui, "From the seal", |ui| revealed(ui, desk.session, &recording, &truth));
}

fn revealed(ui: &mut Ui, session: &Session, recording: &Recording, truth: &Truth) {
    let palette = Palette::in_ui(ui);
    if truth.effects.is_empty() {
        ui.label("Nothing was hidden.");
    }
    for hidden in &truth.effects {
        let Some(spec) = registry::find(&hidden.effect).ok() else {
            ui.label(&hidden.effect);
            continue;
        };
        let place = hidden.joint.map_or("the whole arm".to_owned(), |joint| format!("joint {}", joint + 1));
        ui.label(RichText::new(format!("{} on {place}", spec.name)).color(palette.text));
        for (parameter, value) in spec.parameters.iter().zip(&hidden.parameters) {
            let estimate = estimate(session, hidden, parameter.name);
            let (word, color) = match &estimate {
                None => ("not in the model", palette.warning),
                Some((_, Some([low, high]))) if (*low..=*high).contains(value) => ("inside the interval", palette.good),
                Some((_, Some(_))) => ("outside the interval", palette.error),
                Some((_, None)) => ("no interval", palette.warning),
            };
            let found = estimate.map_or(String::new(), |(value, _)| format!(", found {}", ticks::number(value)));
            ui.horizontal(|ui| {
                ui.add_space(GAP);
                ui.label(format!("{} = {}{found}", parameter.symbol, ticks::number(*value)));
                widgets::chip(ui, word, color);
            });
        }
    }
    let [.., unit] = recording.units();
    let noise: Vec<String> = truth.torque_noise.iter().copied().map(ticks::number).collect();
    widgets::weak(ui, format!("Torque noise by joint: {} {unit}. Seed {}.", noise.join(" · "), truth.seed));
}

/// The current model's value and interval of a hidden parameter.
fn estimate(session: &Session, hidden: &HiddenEffect, name: &str) -> Option<(f64, Option<[f64; 2]>)> {
    let fitted = &session.current()?.fitted;
    let term = fitted.model.terms.iter().position(
        |term| matches!(term, Term::Effect(term) if term.effect.id == hidden.effect && term.joint == hidden.joint),
    )?;
    let parameter = fitted.parameters.iter().find(|parameter| parameter.term == term && parameter.name == name)?;
    Some((parameter.value, parameter.interval))
}
