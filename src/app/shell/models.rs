//! All models of the session in one table, on every screen: what is shown over the current one, under which name, and what they
//! are worth.

use std::sync::Arc;

use egui::{Button, Checkbox, Color32, Grid, RichText, ScrollArea, TextEdit, TextStyle, Ui, WidgetInfo};

use super::frame::Shell;
use crate::app::desk::{Desk, Order};
use crate::app::glossary::{self, Word};
use crate::app::plot::{key_of, ticks};
use crate::app::theme::{GAP, GROUP, Palette, SMALL, TITLE};
use crate::app::widgets::is_narrow;
use crate::app::{tables, widgets};
use crate::experiment::run::duration_text;
use crate::figure::Ink;
use crate::figure::table::Table;
use crate::model::{JointError, Preset, Term};
use crate::session::{Command, Generation, Session, Step};
use crate::training::rollout::{HORIZON, Rollout};

/// Most of the window's height that the table takes.
const HEIGHT: f32 = 0.36;
/// Least width of a name \[points\], and its most as a part of the table's: a longer one goes on in the next line.
const LEAST_NAME: f32 = 120.0;
const MOST_NAME: f32 = 0.29;

/// The table, while it is open.
#[derive(Debug, Default)]
pub struct Models {
    /// The name that is being written, and of which model.
    editing: Option<(Generation, String)>,
}

pub fn show(ui: &mut Ui, shell: &mut Shell, open: &mut Models) {
    let desk = &mut shell.desk;
    let palette = Palette::in_ui(ui);
    ui.horizontal(|ui| {
        ui.label(RichText::new("Models of this session").size(TITLE).color(palette.text));
        if !is_narrow(ui) {
            let text = "Ticked: drawn over the current one on every screen. A click into a name changes it.";
            ui.label(RichText::new(text).size(SMALL).color(palette.weak));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let close = ui.add(Button::new("×").small());
            close.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, "Close the models"));
            if close.clicked() {
                desk.orders.push(Order::Models(false));
            }
        });
    });
    let height = ui.ctx().content_rect().height() * HEIGHT;
    let width = width_of_names(ui, desk.session);
    ScrollArea::both().id_salt("models").max_height(height).auto_shrink([false, true]).show(ui, |ui| {
        let shown = Grid::new("models").striped(true).spacing([GAP, 4.0]).show(ui, |ui| {
            header(ui, desk);
            for step in desk.session.all_models() {
                row(ui, desk, open, step, width);
            }
        });
        widgets::copied(ui, &shown.response, "models", || as_table(desk.session));
    });
    wanted(ui, desk);
}

/// The models with their errors by joint, to be copied.
fn as_table(session: &Session) -> Table {
    let joints = session.recording.iter().flat_map(|recording| &recording.joints);
    let errors = joints.map(|joint| format!("nMSE of {}", joint.name));
    let head = ["model".to_owned()].into_iter().chain(errors).chain(["parameters".to_owned()]).collect();
    let row = |step: &Arc<Step>| {
        let errors = step.evaluation.held_out.iter().map(|joint| ticks::number(joint.nmse));
        [step.name.clone()].into_iter().chain(errors).chain([step.parameter_count().to_string()]).collect()
    };
    Table { title: "models, errors on held-out data".to_owned(), head, rows: session.all_models().map(row).collect() }
}

/// As much as the longest name needs, if there is room for it in one line.
fn width_of_names(ui: &Ui, session: &Session) -> f32 {
    let font = TextStyle::Body.resolve(ui.style());
    let width = |name: &String| ui.painter().layout_no_wrap(name.clone(), font.clone(), Color32::PLACEHOLDER).size().x;
    let longest = session.all_models().map(|step| width(&step.name)).fold(0.0, f32::max);
    let most = MOST_NAME * ui.available_width();
    (longest + 2.0 * GROUP).clamp(LEAST_NAME.min(most), most)
}

fn header(ui: &mut Ui, desk: &mut Desk) {
    let weak = Palette::in_ui(ui).weak;
    let head = |ui: &mut Ui, text: &str| ui.label(RichText::new(text).size(SMALL).color(weak));
    head(ui, "shown");
    head(ui, "name");
    head(ui, "");
    glossary::explained(head(ui, "nMSE held out, by joint"), Word::HeldOut);
    if !is_narrow(ui) {
        off_head(ui, desk);
        glossary::explained(head(ui, "nMSE on train, by joint"), Word::Nmse);
        for text in ["terms", "parameters", "seed", "training"] {
            head(ui, text);
        }
    }
    ui.end_row();
}

/// The heading of how far the arms run off, with what asks for it.
fn off_head(ui: &mut Ui, desk: &mut Desk) {
    let weak = Palette::in_ui(ui).weak;
    let unit = desk.session.recording.as_ref().map_or(String::new(), |recording| recording.units()[0].clone());
    ui.horizontal(|ui| {
        let text = format!("off after {} s [{unit}]", ticks::short(HORIZON));
        glossary::explained(ui.label(RichText::new(text).size(SMALL).color(weak)), Word::Rollout);
        if desk.session.all_models().any(|step| step.rollout.is_none()) {
            let idle = desk.busy.is_none();
            let button = ui.add_enabled(idle, Button::new("Simulate").small());
            if button.on_hover_text(Word::Rollout.meaning()).clicked() {
                desk.run(Command::RollOut);
            }
        }
    });
}

/// How far the arm of a model is from the measured one, by joint.
fn off(ui: &mut Ui, rollout: Option<&Rollout>) {
    let Some(Rollout { error, starts, ran_away }) = rollout else {
        ui.label("—").on_hover_text("It was not simulated yet");
        return;
    };
    let mut text = error.iter().map(|error| format!("{error:.3}")).collect::<Vec<_>>().join(" · ");
    if *ran_away > 0 {
        let comma = if error.is_empty() { "" } else { ", " };
        text += &format!("{comma}{ran_away} of {starts} ran away");
    }
    ui.label(text).on_hover_text(format!("From {starts} states along the held-out part"));
}

fn row(ui: &mut Ui, desk: &mut Desk, open: &mut Models, step: &Step, width: f32) {
    let name = &step.name;
    let (idle, is_current) = (desk.busy.is_none(), is_current(desk.session, step));
    shown(ui, desk, step, is_current);
    edit_name(ui, desk, open, step, width);
    ui.horizontal(|ui| {
        if is_current {
            widgets::weak(ui, "the current model");
            return;
        }
        let mut button = |ui: &mut Ui, word: &str, possible: bool, why_not: &str, command: Command| {
            let button = ui.add_enabled(possible, Button::new(word).small());
            let spoken = format!("{word} {name}");
            button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, possible, &spoken));
            let hint = format!("{spoken}; undo takes it back");
            if button.on_hover_text(hint).on_disabled_hover_text(why_not).clicked() {
                desk.orders.push(Order::run(command));
            }
        };
        let at_work = "Something is at work; see below";
        button(ui, "Use", idle, at_work, Command::TakeUp { name: name.clone() });
        let on_ladder = desk.session.has_on_ladder(step);
        let why_not = if on_ladder { "It is a step of the ladder" } else { at_work };
        button(ui, "Delete", idle && !on_ladder, why_not, Command::Delete { name: name.clone() });
    });
    ui.label(errors(&step.evaluation.held_out));
    if !is_narrow(ui) {
        off(ui, step.rollout.as_ref());
        details(ui, step);
    }
    ui.end_row();
}

/// What a window with little room leaves out.
fn details(ui: &mut Ui, step: &Step) {
    ui.label(errors(&step.evaluation.train));
    let labels: Vec<String> = step.fitted.model.terms.iter().map(Term::label).collect();
    ui.label(labels.len().to_string()).on_hover_text(labels.join("\n"));
    ui.label(widgets::thousands(step.parameter_count()));
    match &step.run {
        Some(run) => {
            ui.label(run.plan.options.seed.to_string()).on_hover_text(tables::plan_text(&run.plan));
            let time = step.history.last().map_or("—".to_owned(), |last| duration_text(last.elapsed_s));
            match run.other_starts.as_slice() {
                [] => ui.label(time),
                others => {
                    let left = others.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
                    let text = format!(
                        "It got stuck and began anew from another start. Left of the variance by others: {left}"
                    );
                    ui.label(format!("{time}, best of {} starts", others.len() + 1)).on_hover_text(text)
                }
            };
        }
        None => {
            ui.label("—");
            ui.label("solved for").on_hover_text("By least squares, at once");
        }
    }
}

/// Whether it is drawn, and how.
fn shown(ui: &mut Ui, desk: &mut Desk, step: &Step, is_current: bool) {
    let overlaid = &mut desk.focus.overlaid;
    let ink = if is_current { Some(Ink::Predicted) } else { overlaid.ink(step.generation) };
    let mut on = ink.is_some();
    let possible = !is_current && (on || !overlaid.is_full());
    ui.horizontal(|ui| {
        let tick = ui.add_enabled(possible, Checkbox::without_text(&mut on));
        let spoken = format!("show {}", step.name);
        tick.widget_info(|| WidgetInfo::selected(egui::Role::CheckBox, possible, on, &spoken));
        let why_not = match is_current {
            true => "The current model is always drawn",
            false => "More lines could not be told apart on paper: hide another model first",
        };
        if tick.on_hover_text(spoken.clone()).on_disabled_hover_text(why_not).changed() {
            overlaid.set(step.generation, on);
        }
        key_of(ui, ink);
    });
}

/// A name is written in its place, over as many lines as it needs; Enter or a click elsewhere gives it.
fn edit_name(ui: &mut Ui, desk: &mut Desk, open: &mut Models, step: &Step, width: f32) {
    let idle = desk.busy.is_none();
    let of_it = |editing: &&(Generation, String)| editing.0 == step.generation;
    let mut text = open.editing.as_ref().filter(of_it).map_or_else(|| step.name.clone(), |(_, text)| text.clone());
    let edit = TextEdit::multiline(&mut text).id_salt(("name", step.generation)).desired_rows(1).return_key(None);
    // Where a table is drawn for the first time a cell has no width yet.
    let of_width = |ui: &mut Ui| {
        ui.set_width(width);
        ui.add(edit.desired_width(f32::INFINITY))
    };
    let edit = ui.add_enabled_ui(idle, of_width).inner;
    edit.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, idle, format!("name of {}", step.name)));
    if edit.has_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter)) {
        edit.surrender_focus();
    }
    if edit.changed() {
        open.editing = Some((step.generation, text.replace('\n', " ")));
    }
    if edit.lost_focus()
        && let Some((_, text)) = open.editing.take_if(|editing| editing.0 == step.generation)
        && text.trim() != step.name
        && !ui.input(|input| input.key_pressed(egui::Key::Escape))
    {
        desk.run(Command::Rename { name: step.name.clone(), to: text });
    }
    if edit.hovered() {
        edit.on_hover_text(&step.name);
    }
}

/// Models that the session does not have yet, to be made beside the current one.
fn wanted(ui: &mut Ui, desk: &mut Desk) {
    let idle = desk.busy.is_none();
    let possible: Vec<Preset> = desk.session.presets_without_model().collect();
    if possible.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        widgets::weak(ui, "To be compared with:");
        for preset in possible {
            let mut on = desk.focus.wanted.contains(&preset);
            if ui.checkbox(&mut on, preset.title()).on_hover_text(preset.description()).changed() {
                desk.focus.wanted.retain(|other| *other != preset);
                if on {
                    desk.focus.wanted.push(preset);
                }
            }
        }
        if let Some(make) = desk.focus.make_wanted(desk.session) {
            let button = ui.add_enabled(idle, Button::new("Make them"));
            if button.on_hover_text("Each is solved for, or trained by the settings of the last training").clicked() {
                desk.run(make);
            }
        }
    });
}

fn is_current(session: &Session, step: &Step) -> bool {
    session.current().is_some_and(|current| current.generation == step.generation)
}

fn errors(joints: &[JointError]) -> String {
    joints.iter().map(|joint| ticks::percent(joint.nmse)).collect::<Vec<_>>().join(" · ")
}
