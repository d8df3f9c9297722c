//! What a step asks for, as widgets; and what became of the answer.

use egui::{Button, RichText, Slider, TextEdit, Ui, WidgetInfo};

use super::Entered;
use crate::app::desk::{Desk, Order};
use crate::app::plot::ticks;
use crate::app::theme::{GAP, Palette};
use crate::app::widgets;
use crate::lesson::{Act, Asked, Choice, Course, Lesson, Progress, Stage, Step, Task, right_answer};
use crate::session::Session;
use crate::session::study::Answer;

/// What is to be entered, and the button that gives it.
pub fn show(ui: &mut Ui, desk: &mut Desk, entered: &mut Entered, step: &Step, progress: &Progress) {
    let is_over = progress.predicted.is_some() || progress.right || progress.gave_up;
    ui.add_enabled_ui(!is_over, |ui| match &step.task {
        Task::Choice(choice) => options(ui, entered, step, progress, choice),
        Task::Number(asked) => number(ui, entered, asked),
        _ => (),
    });
    if is_over {
        return;
    }
    let answer = match &step.task {
        Task::Read | Task::Reveal(_) => return,
        Task::Choice(_) => entered.choice.clone().map(Answer::Choice),
        Task::Number(_) => parse(&entered.number).map(Answer::Number),
        Task::Pose(_) => Some(Answer::Pose(entered.pose.clone())),
        Task::Want(_) => Some(Answer::Session),
    };
    let word = if step.stage == Stage::Predict { "Lock it in" } else { "Check" };
    let button = ui.add_enabled(answer.is_some() && desk.busy.is_none(), Button::new(word));
    if let (true, Some(answer)) = (button.clicked(), answer) {
        let confidence = entered.sure / 100.0;
        desk.orders.push(Order::Lesson(Act::Answer { answer, confidence }));
    }
    ui.add_space(GAP);
}

fn options(ui: &mut Ui, entered: &mut Entered, step: &Step, progress: &Progress, choice: &Choice) {
    let said = match (&progress.predicted, &progress.last) {
        (Some((Answer::Choice(said), _)), _) | (None, Some(Answer::Choice(said))) => Some(said),
        _ => None,
    };
    let chosen = entered.choice.clone().or_else(|| said.cloned());
    for option in &choice.options {
        let name = widgets::sentence_case(&step.name_of(option).unwrap_or_default());
        if ui.radio(chosen.as_ref() == Some(option), name).clicked() {
            entered.choice = Some(option.clone());
        }
    }
    if choice.confidence && progress.predicted.is_none() {
        let least = 100.0 / choice.options.len() as f64;
        entered.sure = entered.sure.clamp(least, 100.0);
        ui.horizontal(|ui| {
            ui.label("How sure?");
            let slider = ui.add(Slider::new(&mut entered.sure, least..=100.0).suffix(" %").fixed_decimals(0));
            slider.widget_info(|| WidgetInfo::labeled(egui::Role::Slider, true, "How sure?"));
        });
    }
    ui.add_space(4.0);
}

fn number(ui: &mut Ui, entered: &mut Entered, asked: &Asked) {
    ui.horizontal(|ui| {
        let edit = ui.add(TextEdit::singleline(&mut entered.number).desired_width(90.0));
        edit.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, true, "Your number"));
        ui.label(&asked.unit);
    });
    ui.add_space(4.0);
}

/// A number as people write it.
fn parse(text: &str) -> Option<f64> {
    text.trim().replace(',', ".").parse().ok().filter(|value: &f64| value.is_finite())
}

/// Whether it was right, what lacks, and what is to be read afterwards.
pub fn outcome(ui: &mut Ui, session: &Session, lacks: Option<&str>, step: &Step, progress: &Progress) {
    let palette = Palette::in_ui(ui);
    if let Some((answer, confidence)) = &progress.predicted {
        let sure = confidence.map_or(String::new(), |sure| format!(", {:.0} % sure", 100.0 * sure));
        ui.label(RichText::new(format!("Locked in: {}{sure}.", text(step, answer))).color(palette.accent));
    } else if progress.right {
        ui.label(RichText::new("✔ That is right.").color(palette.good));
    } else if progress.gave_up {
        if let Ok(right) = right_answer(session) {
            ui.label(format!("It is: {}.", text(step, &right)));
        }
    } else if progress.tries > 0 {
        let what = lacks.map_or("Not yet.".to_owned(), |lacks| format!("Not yet: {lacks}."));
        ui.label(RichText::new(what).color(palette.warning));
        widgets::weak(ui, &step.text.hint);
    } else if let Some(lacks) = lacks {
        ui.label(RichText::new(widgets::sentence_case(&format!("{lacks}."))).color(palette.warning));
    }
    if (progress.right || progress.gave_up || progress.predicted.is_some()) && !step.text.after.is_empty() {
        ui.add_space(4.0);
        super::paragraphs(ui, &step.text.after);
    }
}

/// An answer in words.
fn text(step: &Step, answer: &Answer) -> String {
    match answer {
        Answer::Choice(option) => step.name_of(option).unwrap_or_else(|| option.clone()),
        Answer::Number(value) => match &step.task {
            Task::Number(asked) => format!("{} {}", ticks::short(*value), asked.unit).trim().to_owned(),
            _ => ticks::short(*value),
        },
        Answer::Pose(_) | Answer::Session => String::new(),
    }
}

/// Predictions beside what is so.
pub fn revealed(ui: &mut Ui, desk: &mut Desk, lesson: &Lesson, course: &Course, of: &[String]) {
    let palette = Palette::in_ui(ui);
    let shown = lesson.steps.iter().zip(&course.steps).filter(|(step, _)| of.contains(&step.id));
    let mut is_all = true;
    for (step, progress) in shown {
        let Some(revealed) = &progress.revealed else {
            is_all = false;
            continue;
        };
        let said = progress.predicted.as_ref().map_or(String::new(), |(answer, sure)| {
            let sure = sure.map_or(String::new(), |sure| format!(" ({:.0} % sure)", 100.0 * sure));
            format!("{}{sure}", text(step, answer))
        });
        widgets::card(ui, &step.text.title, |ui| {
            ui.label(format!("You said: {said}."));
            ui.label(RichText::new(format!("It is: {}.", text(step, &revealed.right))).strong());
            let color = if revealed.score > 0.5 { palette.good } else { palette.warning };
            let points = format!("{:.2} of {} points", revealed.score * step.points, step.points);
            widgets::chip(ui, &points, color);
        });
    }
    if !is_all && !course.here().gave_up && ui.add_enabled(desk.busy.is_none(), Button::new("Reveal")).clicked() {
        desk.orders.push(Order::Lesson(Act::Reveal));
    }
}
