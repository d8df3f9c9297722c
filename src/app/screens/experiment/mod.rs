//! Experiments: data × models × seeds, their cells as they are done, the table as it fills, curves with bands.

mod figures;
mod trials;

use std::sync::Arc;

use egui::{Checkbox, RichText, ScrollArea, TextEdit, Ui, WidgetText};

use trials::{Joined, Said, Trials, join};

use crate::app::desk::{About, Desk, Needs, Order};
use crate::app::dock::{self, Part};
use crate::app::plot::{PanelView, ticks};
use crate::app::screen::Screen;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;
use crate::experiment::Row;
use crate::experiment::catalogue;
use crate::experiment::run::State;
use crate::figure::Panel;
use crate::progress::Progress;
use crate::session::Session;

/// What the table can show: name in a row's data, name for people.
const QUANTITIES: [(&str, &str); 5] = [
    ("nmse_torque", "torque"),
    ("nmse_inertial", "inertial"),
    ("nmse_coriolis", "Coriolis"),
    ("nmse_gravity", "gravity"),
    ("r2", "R²"),
];
/// Height of the chart of a curve \[points\].
const CURVE: f32 = 300.0;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "experiment",
    title: "Experiments",
    purpose: "Many models and seeds, held against the paper",
    needs: Needs::Nothing,
    on_the_way: false,
};

const PANELS: Part<Experiments> = Part::Beside(&[
    (2.9, Part::Panel("Results", |screen, ui, desk| outcome(ui, desk, &mut screen.trials))),
    (1.0, Part::Panel("Choose", |screen, ui, _| choices(ui, &mut screen.trials))),
]);

/// The screen of experiments, which have data and models of their own.
#[derive(Default)]
pub struct Experiments {
    trials: Trials,
}

impl Screen for Experiments {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        self.trials.look(ui.ctx());
        let joined = self.trials.joined.as_ref();
        let sentence = joined.map_or(String::new(), |joined| format!("{}.", joined.experiment.title));
        widgets::headline(ui, "Experiments", &sentence);
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, _: &mut Desk) -> Vec<Panel> {
        let joined = self.trials.joined.clone().or_else(|| join(&self.trials.shown).ok().map(Arc::new));
        let Some(joined) = joined else { return Vec::new() };
        let name = names_of_curves(&joined).get(self.trials.curve).copied();
        name.and_then(|name| figures::curve(&joined, name, &self.trials.left_out)).into_iter().collect()
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(Experiments { trials: self.trials.without_jobs() })
    }

    fn is_done(&self, _: &Session) -> bool {
        false
    }

    fn hear(&mut self, order: &Order) -> Vec<Order> {
        let Order::Experiment(shown) = order else { return Vec::new() };
        self.trials.shown = shown.clone();
        vec![Order::Show(&ABOUT)]
    }

    fn poll(&mut self) {
        self.trials.poll();
    }

    fn is_busy(&self) -> bool {
        self.trials.is_busy()
    }

    fn at_work(&self) -> Option<(&str, Progress)> {
        let (progress, stopping) = self.trials.progress()?;
        Some((if stopping { "stopping the experiment" } else { "experiment" }, progress))
    }

    fn stop(&mut self) {
        self.trials.stop();
    }
}

fn outcome(ui: &mut Ui, desk: &mut Desk, trials: &mut Trials) {
    run(ui, trials);
    match trials.joined.clone() {
        Some(joined) => results(ui, desk, trials, &joined),
        None if trials.is_busy() => drop(widgets::weak(ui, "Reading…")),
        None => (),
    }
}

fn choices(ui: &mut Ui, trials: &mut Trials) {
    which(ui, trials);
    if let Some(joined) = trials.joined.clone() {
        models(ui, trials, &joined);
    }
}

/// Progress and Stop while it runs; what became of it afterwards.
fn run(ui: &mut Ui, trials: &mut Trials) {
    let palette = Palette::in_ui(ui);
    let progress = trials.progress();
    widgets::card(ui, "", |ui| {
        ui.horizontal_wrapped(|ui| match &progress {
            Some((_, stopping)) => {
                let word = if *stopping { "Stopping…" } else { "Stop the run" };
                if ui.add_enabled(!stopping, egui::Button::new(word)).clicked() {
                    trials.stop();
                }
            }
            None => {
                let ready = trials.joined.as_ref().is_some_and(|joined| !joined.cells.is_empty());
                let hint = "Only cells that the folder lacks; a stopped run goes on where it was";
                let missing = "It needs recordings: give their folder";
                let button =
                    ui.add_enabled(ready, egui::Button::new("Run")).on_hover_text(hint).on_disabled_hover_text(missing);
                if button.clicked() {
                    trials.run(ui.ctx());
                }
                if ui.button("Look again").on_hover_text("Other processes may have written into the folder").clicked() {
                    trials.look_again();
                }
            }
        });
        if let Some((progress, _)) = &progress {
            widgets::progress(ui, progress.fraction, ui.available_width());
            ui.label(RichText::new(&progress.activity).color(palette.text));
        }
        match &trials.said {
            Some(Said::Plain(text)) => drop(widgets::weak(ui, text)),
            Some(Said::Failed(text)) => drop(ui.label(RichText::new(format!("✖ {text}")).color(palette.error))),
            None => (),
        }
    });
}

fn results(ui: &mut Ui, desk: &mut Desk, trials: &mut Trials, joined: &Joined) {
    if joined.cells.is_empty() {
        let text =
            "This experiment needs recordings that do not come with the program: give their folder at the right.";
        widgets::weak(ui, text);
        return;
    }
    cells(ui, joined);
    table(ui, trials, joined);
    curve(ui, desk, trials, joined);
}

/// Where each model stands at each seed.
fn cells(ui: &mut Ui, joined: &Joined) {
    let palette = Palette::in_ui(ui);
    let done = joined.cells.iter().filter(|(_, _, state)| *state == State::Done).count();
    widgets::card(ui, &format!("Cells: {done} of {} are done", joined.cells.len()), |ui| {
        ScrollArea::horizontal().id_salt("cells").show(ui, |ui| {
            egui::Grid::new("cells of the experiment").spacing([10.0, 4.0]).show(ui, |ui| {
                ui.label(RichText::new("model \\ seed").size(SMALL).color(palette.weak));
                for seed in 1..=joined.experiment.seeds {
                    ui.label(RichText::new(seed.to_string()).size(SMALL).color(palette.weak));
                }
                ui.end_row();
                for model in &joined.experiment.models {
                    ui.label(model.title()).on_hover_text(&model.note);
                    let own = joined.cells.iter().filter(|(name, ..)| *name == model.name);
                    for (_, _, state) in own {
                        let (sign, color, text) = match state {
                            State::Done => ("✔", palette.good, "done".to_owned()),
                            State::Running(owner) => {
                                ("…", palette.accent, format!("process {} on {}", owner.process, owner.host))
                            }
                            State::Failed(reason) | State::Damaged(reason) => ("✖", palette.error, reason.clone()),
                            State::Open => ("·", palette.weak, "not done yet".to_owned()),
                        };
                        ui.label(RichText::new(sign).color(color)).on_hover_text(text);
                    }
                    ui.end_row();
                }
            });
        });
    });
}

/// Models × test sets, with the paper's value and the ratio where it has one.
fn table(ui: &mut Ui, trials: &mut Trials, joined: &Joined) {
    let palette = Palette::in_ui(ui);
    let mut sets: Vec<&str> = Vec::new();
    for row in joined.rows.iter().filter(|row| row.point.is_none()) {
        if !sets.contains(&row.test_set.as_str()) {
            sets.push(&row.test_set);
        }
    }
    if sets.is_empty() {
        return;
    }
    widgets::card(ui, "Errors (nMSE), mean over the seeds ± half of the 95 % interval", |ui| {
        ui.horizontal_wrapped(|ui| {
            for (index, (_, name)) in QUANTITIES.into_iter().enumerate() {
                ui.selectable_value(&mut trials.quantity, index, name);
            }
        });
        let quantity = QUANTITIES[trials.quantity].0;
        let shown = joined.experiment.models.iter().filter(|model| !trials.left_out.contains(&model.name));
        let rows: Vec<Vec<WidgetText>> = shown
            .map(|model| {
                let cell = |set: &&str| {
                    let row = joined.rows.iter().find(|row| row.model == model.name && row.test_set == **set);
                    WidgetText::from(row.map_or("—".to_owned(), |row| text_of(row, quantity)))
                };
                std::iter::once(WidgetText::from(model.title())).chain(sets.iter().map(cell)).collect()
            })
            .collect();
        let header: Vec<&str> = std::iter::once("model").chain(sets.iter().copied()).collect();
        ScrollArea::horizontal().id_salt("errors").show(ui, |ui| {
            widgets::table(ui, "errors of the experiment", &header, &rows);
        });
        if joined.rows.iter().any(|row| !row.paper.is_empty()) {
            let text = "In brackets: ours as a multiple of the paper's value.";
            ui.label(RichText::new(text).size(SMALL).color(palette.weak));
        }
    });
}

fn text_of(row: &Row, quantity: &str) -> String {
    let value = match quantity {
        "nmse_torque" => Some(row.nmse_torque),
        "nmse_inertial" => row.nmse_inertial,
        "nmse_coriolis" => row.nmse_coriolis,
        "nmse_gravity" => row.nmse_gravity,
        _ => Some(row.r2),
    };
    let Some(value) = value else { return "—".to_owned() };
    let mut text = ticks::number(value);
    if let Some(half) = row.interval.get(quantity).and_then(|ends| Some(ends[1].as_f64()? - value)) {
        text += &format!(" ± {}", ticks::number(half));
    }
    match row.paper.get(quantity).filter(|_| quantity != "r2") {
        Some(paper) => format!("{text} (× {:.2})", value / paper),
        None => text,
    }
}

/// The curves that there are, each once.
fn names_of_curves(joined: &Joined) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for curve in &joined.curves {
        if !names.contains(&curve.curve.as_str()) {
            names.push(&curve.curve);
        }
    }
    names
}

/// The chosen curve of all models.
fn curve(ui: &mut Ui, desk: &mut Desk, trials: &mut Trials, joined: &Joined) {
    let palette = Palette::in_ui(ui);
    let names = names_of_curves(joined);
    if names.is_empty() {
        return;
    }
    trials.curve = trials.curve.min(names.len() - 1);
    widgets::card(ui, "Error along a curve of test sets", |ui| {
        ui.horizontal_wrapped(|ui| {
            for (index, name) in names.iter().enumerate() {
                if ui.selectable_label(trials.curve == index, *name).clicked() {
                    trials.curve = index;
                }
            }
        });
        let Some(panel) = figures::curve(joined, names[trials.curve], &trials.left_out) else { return };
        let view = PanelView::new(panel).cursor(&mut trials.cursor).height(CURVE);
        view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        let text = "Lines: mean over the seeds. Bands: from the least seed to the largest.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
}

/// Which experiment, how much of it, and where its files are.
fn which(ui: &mut Ui, trials: &mut Trials) {
    let idle = trials.progress().is_none();
    widgets::card(ui, "Which experiment", |ui| {
        ui.add_enabled_ui(idle, |ui| {
            for (name, _) in catalogue::ALL {
                if ui.selectable_label(trials.shown.experiment == *name, *name).clicked() {
                    trials.shown.experiment = (*name).to_owned();
                }
            }
            let field = |ui: &mut Ui, name: &str, hint: &str, text: &mut String| {
                let label = ui.label(RichText::new(name).size(SMALL));
                let id = ui.scope_id().with(name);
                // What is typed counts when it is finished: half a path leads nowhere.
                let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| text.clone());
                let edit = TextEdit::singleline(&mut typed).hint_text(hint).desired_width(f32::INFINITY);
                let response = ui.add(edit).labelled_by(label.id);
                if response.has_focus() {
                    ui.data_mut(|data| data.insert_temp(id, typed));
                } else {
                    ui.data_mut(|data| data.remove_temp::<String>(id));
                    if response.lost_focus() {
                        *text = typed;
                    }
                }
            };
            field(ui, "Name, or a TOML file of your own", "path/to/mine.toml", &mut trials.shown.experiment);
            field(ui, "Folder of the results", "experiments", &mut trials.shown.results);
            field(ui, "Folder of the recordings, if it needs some", "path/to/logs", &mut trials.shown.data);
            ui.add_space(GAP / 2.0);
            let quick = ui.add(Checkbox::new(&mut trials.shown.quick, "Small version"));
            quick.on_hover_text("Less training, fewer seeds and test sets: a first look");
        });
    });
}

/// What it asks, and its models.
fn models(ui: &mut Ui, trials: &mut Trials, joined: &Arc<Joined>) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "What it asks", |ui| {
        ui.label(RichText::new(joined.experiment.description.replace('\n', " ")).size(SMALL).color(palette.text));
    });
    widgets::card(ui, "Models", |ui| {
        let left_out = &mut trials.left_out;
        for model in &joined.experiment.models {
            let mut chosen = !left_out.contains(&model.name);
            let label = ui.checkbox(&mut chosen, model.title()).on_hover_text(&model.note);
            if label.changed() && chosen {
                left_out.remove(&model.name);
            } else if label.changed() {
                left_out.insert(model.name.clone());
            }
        }
    });
}
