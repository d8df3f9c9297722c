//! Data: what was measured, where it came from, what is odd about it; and the panel that simulates.

mod arm_editor;
mod coverage;
mod figures;
mod gallery;
mod hiding;
mod motion;
mod recent;
mod simulate;
mod start;

use std::path::PathBuf;
use std::sync::Arc;

use egui::{Button, Checkbox, ComboBox, DragValue, RichText, TextEdit, Ui};

use simulate::Simulator;

use crate::app::desk::{About, Desk, Needs, Order, held_out_times, is_held_out, time_extent};
use crate::app::dock::{self, Part};
use crate::app::memo::Question;
use crate::app::plot::{PanelView, ticks};
use crate::app::screen::Screen;
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::widgets::thousands;
use crate::app::{controls, facts, formula, glossary, widgets};
use crate::arm::Posture;
use crate::figure::Panel;
use crate::model::Preset;
use crate::recording::correction::Correction;
use crate::recording::finding::Severity;
use crate::recording::hold_out::{self, HoldOut};
use crate::recording::read::{READABLE, ReadOptions};
use crate::recording::torque::TorqueFact;
use crate::recording::{JointKind, Origin, Recording};
use crate::session::{Command, Session, Source};
use crate::simulation::Level;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "data",
    title: "Data",
    purpose: "What was measured, and what is odd about it",
    needs: Needs::Nothing,
    on_the_way: true,
};

const PANELS: Part<Data> = Part::Beside(&[
    (
        2.9,
        Part::Tabs(&[
            Part::Panel("Recording", |_, ui, desk| measured(ui, desk)),
            Part::Panel("Coverage and spectrum", |_, ui, desk| coverage::show(ui, desk)),
        ]),
    ),
    (
        1.0,
        Part::Tabs(&[
            Part::Panel("Sources", Data::sources),
            Part::Panel("Simulate your own", |screen, ui, desk| screen.simulator.show(ui, desk)),
        ]),
    ),
]);

/// Height of the chart of a signal as a part of the window, at least so many points, and what the numbers of the last one need.
const CHART: f32 = 0.13;
const LEAST_CHART: f32 = 90.0;
const TICKS: f32 = 30.0;

/// The screen of the data.
#[derive(Default)]
pub struct Data {
    /// The file to be opened, as it is typed.
    path: String,
    /// The file to be saved into, as it is typed.
    save_path: String,
    simulator: Simulator,
}

impl Screen for Data {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn answers(&self, command: &Command) -> bool {
        matches!(command, Command::BeginAnew)
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let Some(recording) = &desk.session.recording else { return Vec::new() };
        let joint = desk.focus.joint_of(recording);
        let mut panels = figures::signals(desk.session, recording, desk.focus.trajectory, joint);
        panels.extend(formula::figure(desk));
        panels.extend(coverage::figures(desk, recording));
        panels
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::<Data>::default()
    }

    fn is_done(&self, session: &Session) -> bool {
        session.recording.is_some()
    }

    fn hear(&mut self, order: &Order) -> Vec<Order> {
        match order {
            Order::DrawMystery => vec![self.simulator.draw_mystery()],
            _ => Vec::new(),
        }
    }
}

/// Median time step of each trajectory \[s\].
#[derive(Clone, PartialEq)]
struct TimeSteps;

impl Question for TimeSteps {
    type Answer = Vec<f64>;

    fn answer(&self, session: &Session) -> Result<Vec<f64>, String> {
        let runs = session.recording.iter().flat_map(|recording| &recording.trajectories);
        Ok(runs.map(|run| run.time_step()).collect())
    }
}

/// Where the session's recording was read from; `None` if it was not read from files.
fn opening(session: &Session) -> Option<&Source> {
    session.source.as_deref().filter(|source| source.files().is_some())
}

fn measured(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return start::show(ui, desk) };
    let duration: f64 =
        recording.trajectories.iter().map(|run| time_extent(&run.time)).map(|[first, last]| last - first).sum();
    let joints = recording.joint_count();
    let summary = format!(
        "{joints} joint{}, {} trajector{}, {} samples, {} s in all.",
        if joints == 1 { "" } else { "s" },
        recording.trajectories.len(),
        if recording.trajectories.len() == 1 { "y" } else { "ies" },
        thousands(recording.sample_count()),
        ticks::short(duration)
    );
    widgets::headline(ui, &recording.name, &summary);
    gallery::story(ui, &recording);
    findings(ui, desk, &recording);
    posture(ui, desk, &recording);
    torque(ui, desk, &recording);
    signals(ui, desk, &recording);
    trajectories(ui, desk, &recording);
}

fn findings(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    let findings = Arc::clone(&desk.session.findings);
    widgets::card(ui, "Findings", |ui| {
        if findings.is_empty() {
            let from =
                if recording.seal.is_some() { "Simulated: nothing odd." } else { "Nothing odd was found at import." };
            widgets::weak(ui, from);
        }
        for finding in findings.iter() {
            let color = match finding.severity {
                Severity::Info => palette.accent,
                Severity::Warning => palette.warning,
                Severity::Error => palette.error,
            };
            ui.horizontal_wrapped(|ui| {
                widgets::chip(ui, finding.severity.word(), color);
                if let Some(file) = &finding.place.file {
                    ui.label(RichText::new(file).strong());
                }
                ui.label(&finding.what);
                widgets::weak(ui, &finding.remedy);
                if !finding.set_right.is_empty() && ui.button("Set right").clicked() {
                    desk.run(Command::SetRight(finding.set_right.clone()));
                }
            });
        }
        let origin = |origin: &Origin| match origin {
            Origin::Measured => "measured".to_owned(),
            Origin::Derived(how) => format!("derived ({how})"),
        };
        let provenance = &recording.provenance;
        let torque = match recording.torque.has(TorqueFact::Commanded) {
            true => format!("Position q is measured, {} τ commanded", recording.effort()),
            false => format!("Position q and {} τ are measured", recording.effort()),
        };
        let text = format!(
            "{torque}; velocity q̇ is {}, acceleration q̈ is {}.",
            origin(&provenance.velocity),
            origin(&provenance.acceleration)
        );
        ui.label(RichText::new(text).size(SMALL + 0.5).color(palette.weak));
    });
}

/// A log hardly ever says where q = 0 points, but gravity depends on it: without the answer the model is wrong.
fn posture(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let Some(source) = opening(desk.session) else { return };
    // What slides does not point anywhere, and axes in space are stated with where they are at q = 0.
    let slides = recording.joints.iter().all(|joint| joint.kind == JointKind::Prismatic);
    if slides || recording.chain.is_some() {
        return;
    }
    widgets::card(ui, "Where does the arm point at q = 0?", |ui| {
        ui.horizontal_wrapped(|ui| {
            let choices = [("To the right", Posture::RIGHT), ("Up", Posture::UP), ("Down", Posture::DOWN)];
            let current = recording.posture;
            for (name, zero) in choices {
                let same = current.is_some_and(|posture| (posture.zero_angle - zero.zero_angle).abs() < 1e-6);
                if ui.selectable_label(same, name).clicked() && !same {
                    let sense = current.unwrap_or_default().sense;
                    let mut options = ReadOptions { zero: Some(Posture { sense, ..zero }), ..source.options.clone() };
                    // What is chosen here is not set right once more.
                    options.set_right.retain(|correction| !matches!(correction, Correction::Zero { .. }));
                    read_again(desk, source, options);
                }
            }
            if !recording.states_zero() {
                let color = Palette::in_ui(ui).warning;
                ui.label(
                    RichText::new("The file does not say: to the right is assumed. Gravity depends on it.")
                        .color(color),
                );
            }
        });
    });
}

/// Nothing in the numbers tells what had been taken out of the torque; what can be found depends on it.
fn torque(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let Some(source) = opening(desk.session) else { return };
    let title = format!("What is the {}?", recording.effort());
    widgets::card(ui, &title, |ui| {
        let mut stated = recording.torque.clone();
        let mut encoders = recording.encoders;
        let mut is_said_anew = facts::choose(ui, &mut stated);
        if recording.torque.is_empty() {
            widgets::weak(ui, "Nothing is stated: it is taken for all that the joints feel.");
        }
        is_said_anew |= facts::choose_encoders(ui, &mut encoders);
        if is_said_anew {
            let options = ReadOptions { torque: Some(stated), encoders, ..source.options.clone() };
            read_again(desk, source, options);
        }
    });
}

/// Reads the files of the recording once more, in another way.
fn read_again(desk: &mut Desk, source: &Source, options: ReadOptions) {
    if let Some(again) = Command::read_again(source, options) {
        desk.run(again);
    }
}

fn signals(ui: &mut Ui, desk: &mut Desk, recording: &Arc<Recording>) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "Signals", |ui| {
        ui.horizontal_wrapped(|ui| {
            controls::trajectory(ui, desk);
            ui.add_space(GAP);
            controls::joint(ui, desk, recording);
            ui.add_space(GAP);
            formula::field(ui, &mut desk.focus.own_series);
            controls::fit(ui, desk);
        });
        ui.add_space(4.0);
        let panels = figures::signals(desk.session, recording, desk.focus.trajectory, desk.focus.joint);
        let last = panels.len() - 1;
        let height = (CHART * ui.ctx().content_rect().height()).max(LEAST_CHART);
        for (number, panel) in panels.into_iter().enumerate() {
            let view = PanelView::new(panel).cursor(&mut desk.focus.cursor);
            let view = if number == last { view.height(height + TICKS) } else { view.without_ticks().height(height) };
            view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        }
        formula::show(ui, desk);
        let hint = format!("Shaded: held out. {}", controls::HINT);
        ui.label(RichText::new(hint).size(SMALL).color(palette.weak));
    });
}

fn trajectories(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    let time_steps = desk.memo.later(ui.ctx(), desk.session, TimeSteps).and_then(Result::ok);
    let study = desk.session.study.as_deref();
    let is_free = study.is_none_or(|study| Command::HoldOut(HoldOut::default()).locked_by(study).is_none());
    widgets::card(ui, "Trajectories", |ui| {
        egui::Grid::new("trajectories").striped(true).spacing([GROUP, 5.0]).show(ui, |ui| {
            for title in ["name", "samples", "time step", "train / held out"] {
                ui.label(RichText::new(title).size(SMALL).color(palette.weak));
            }
            ui.end_row();
            for (index, run) in recording.trajectories.iter().enumerate() {
                if ui.selectable_label(desk.focus.trajectory == index, &run.name).clicked() {
                    desk.focus.show_trajectory(index);
                }
                ui.label(thousands(run.len()));
                let step = time_steps.as_ref().map_or("…".to_owned(), |steps| {
                    format!("{} ms", ticks::short((1e6 * steps[index]).round() / 1e3))
                });
                ui.label(step);
                ui.horizontal(|ui| {
                    let held_out = held_out_times(desk.session, index);
                    split_line(ui, time_extent(&run.time), &held_out);
                    if recording.trajectories.len() > 1 {
                        let mut out = is_held_out(desk.session, index);
                        let check = ui.add_enabled(is_free, Checkbox::without_text(&mut out));
                        let spoken = format!("Hold out {}", run.name);
                        check.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, out, &spoken));
                        if check.on_hover_text(&spoken).changed() {
                            let chosen = |other: &usize| {
                                if *other == index { out } else { is_held_out(desk.session, *other) }
                            };
                            let names = (0..recording.trajectories.len()).filter(chosen);
                            let held_out = names.map(|other| recording.trajectories[other].name.clone()).collect();
                            desk.run(Command::HoldOut(HoldOut::named(held_out)));
                        }
                    }
                    let text = match held_out.len() {
                        0 => "train".to_owned(),
                        _ if is_held_out(desk.session, index) => "held out".to_owned(),
                        count => format!("train, {count} blocks held out"),
                    };
                    ui.label(RichText::new(text).size(SMALL).color(palette.weak));
                });
                ui.end_row();
            }
        });
        ui.add_space(GAP);
        ui.add_enabled_ui(is_free, |ui| turns(ui, desk, recording));
    });
}

/// Lets the user choose which fifth is held out.
fn turns(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    let now = desk.session.source.as_ref().map(|source| &source.held_out);
    let which = if hold_out::is_by_time_block(recording) {
        "a fifth of about twenty time blocks, number"
    } else {
        "every fifth of them, beginning with"
    };
    ui.horizontal(|ui| {
        let hold_out = if recording.trajectories.len() > 1 { "Or hold out" } else { "Hold out" };
        ui.label(format!("{hold_out} {which}"));
        for turn in 0..hold_out::turns(recording) {
            let this = HoldOut::Fifth(turn);
            let is_now = now == Some(&this);
            let choice = ui.selectable_label(is_now, (turn + 1).to_string());
            let spoken = format!("Hold out fifth {}", turn + 1);
            choice.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, is_now, &spoken));
            let what =
                "Identifies the ladder anew; models that are not on it learned from what is held out then, and go";
            if choice.on_hover_text(what).clicked() && !is_now {
                desk.run(Command::HoldOut(this));
            }
        }
    });
}

/// Opens the import assistant on the file that is typed, else on the one that is open.
fn columns(ui: &mut Ui, desk: &mut Desk, typed: &str) {
    let log = match (typed, opening(desk.session).map(|source| (source.files(), &source.options))) {
        ("", Some((Some(paths), options))) => Some((paths.to_vec(), options.clone())),
        ("", _) => None,
        (typed, _) => Some((vec![PathBuf::from(typed)], ReadOptions::default())),
    };
    let button = ui.add_enabled(log.is_some(), Button::new("Columns…"));
    let what = "What each column of the log is taken for, and why; to be changed";
    let clicked = button.on_hover_text(what).on_disabled_hover_text(what).clicked();
    if let Some((paths, options)) = log.filter(|_| clicked) {
        desk.orders.push(Order::Import(paths, Box::new(options)));
    }
}

/// The time line of a trajectory: train is empty, held out is filled.
fn split_line(ui: &mut Ui, extent: [f64; 2], held_out: &[[f64; 2]]) {
    let palette = Palette::in_ui(ui);
    let (rect, _) = ui.allocate_exact_size(egui::vec2(180.0, 12.0), egui::Sense::hover());
    ui.painter().rect_filled(rect, 3, palette.grid);
    let place =
        |time: f64| rect.left() + rect.width() * ((time - extent[0]) / (extent[1] - extent[0]).max(1e-12)) as f32;
    for [from, to] in held_out {
        let block = egui::Rect::from_x_y_ranges(place(*from)..=place(*to), rect.y_range());
        ui.painter().rect_filled(block, 3, palette.nth(0).0);
    }
}

impl Data {
    fn sources(&mut self, ui: &mut Ui, desk: &mut Desk) {
        // Before that they stand below the ways to begin.
        if desk.session.recording.is_some() {
            recent::show(ui, desk);
        }
        widgets::card(ui, "Open a recording", |ui| {
            let sentence = format!("{READABLE} with position, torque and, where measured, velocity and acceleration.");
            widgets::weak(ui, sentence);
            let label = ui.label("Path of a file");
            let edit = TextEdit::singleline(&mut self.path).hint_text("path/to/log.csv").desired_width(f32::INFINITY);
            let entered = ui.add(edit).labelled_by(label.id).lost_focus()
                && ui.input(|input| input.key_pressed(egui::Key::Enter));
            ui.horizontal_wrapped(|ui| {
                let path = self.path.trim().to_owned();
                let open = ui.add_enabled(!path.is_empty(), Button::new("Open this file"));
                if !path.is_empty() && (open.clicked() || entered) {
                    desk.orders.push(Order::open(vec![path.clone().into()]));
                }
                let beside = ui.add_enabled(!path.is_empty() && desk.session.recording.is_some(), Button::new("Look at it beside"));
                let what = "The same arm in another recording: all of it is held out, and every model of this session is held against \
                            it as it is";
                if beside.on_hover_text(what).on_disabled_hover_text(what).clicked() {
                    desk.run(Command::Beside { paths: vec![path.clone().into()] });
                }
                if ui.button("Choose files…").clicked() {
                    desk.orders.push(Order::OpenDialog);
                }
                columns(ui, desk, &path);
                let hint = "Small logs with a story each; undo brings back what is here now";
                if desk.session.recording.is_some() && ui.button("Recordings to try…").on_hover_text(hint).clicked() {
                    desk.run(Command::BeginAnew);
                }
            });
        });
        if let Some(recording) = desk.session.recording.clone() {
            widgets::card(ui, "Save the session", |ui| {
                let label = ui.label("File to save into");
                let hint = "path/to/mine.torquescope";
                let edit = TextEdit::singleline(&mut self.save_path).hint_text(hint).desired_width(f32::INFINITY);
                ui.add(edit).labelled_by(label.id);
                let path = self.save_path.trim().to_owned();
                if ui.add_enabled(!path.is_empty(), Button::new("Save into this file")).clicked() {
                    desk.orders.push(Order::Save(path.into()));
                }
            });
            widgets::card(ui, "Model to start from", |ui| {
                // Learned models take a training, which is not a choice of a moment.
                let at_once = |preset: &Preset| !matches!(preset, Preset::Learned(_));
                for preset in Preset::ALL.into_iter().filter(at_once) {
                    let possible = preset == Preset::RigidBody || recording.states_arm();
                    let chosen = desk.session.preset == preset && desk.session.current().is_some();
                    let radio = ui.add_enabled(possible, egui::RadioButton::new(chosen, preset.title()));
                    if glossary::radio(radio, preset).on_disabled_hover_text("The recording states no arm.").clicked()
                        && !chosen
                    {
                        desk.run(Command::ChoosePreset(preset));
                    }
                }
            });
        }
        widgets::card(ui, "Draw a mystery", |ui| {
            let level = &mut self.simulator.level;
            widgets::weak(ui, "An arm in which something is hidden, drawn by a seed and sealed.");
            ui.horizontal(|ui| {
                let label = ui.label("Level");
                let chooser = ComboBox::from_id_salt("level of the mystery").selected_text(level.name());
                let chooser = chooser.show_ui(ui, |ui| {
                    for one in Level::ALL {
                        ui.selectable_value(level, one, one.name()).on_hover_text(one.about());
                    }
                });
                chooser.response.labelled_by(label.id);
            });
            widgets::weak(ui, widgets::sentence_case(&format!("{}.", level.about())));
            ui.horizontal(|ui| {
                let label = ui.label("Seed");
                ui.add(DragValue::new(&mut self.simulator.seed).range(0..=999_999)).labelled_by(label.id);
                if ui.button("Draw a mystery").clicked() {
                    desk.orders.push(Order::DrawMystery);
                }
            });
        });
    }
}
