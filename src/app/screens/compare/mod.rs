//! Compare: measured against predicted torque of every joint, the residual under it, and the arm at the cursor.

mod arm;
mod asked;
mod errors;
mod figures;
mod grid;
mod parts;
mod sum;

use std::sync::Arc;

use egui::{ComboBox, RichText, Slider, Ui, WidgetText};

use serde_json::{Value, json};

use arm::START;
use asked::{Drawn, MovedTo, Residual, facts};
use errors::Sorting;
use figures::{Beside, Overlay, Torques};
use grid::Cell;
use parts::Decomposition;

use crate::app::desk::{About, Desk, Focus, Needs, held_out_times, time_extent};
use crate::app::dock::{self, Part};
use crate::app::plot::{PanelView, spatial, ticks};
use crate::app::screen::{Next, NextStep, Screen, Switch};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::{controls, formula, tables, widgets};
use crate::figure::mark::nearest;
use crate::figure::{Ink, Panel};
use crate::recording::Recording;
use crate::session::{Command, Generation, Session, Step};
use crate::signals::Signals;

/// How many times as fast as it was recorded time can go on.
const SPEEDS: [f64; 6] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0];

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "compare",
    title: "Compare",
    purpose: "Measured against predicted torque",
    needs: Needs::Model,
    on_the_way: true,
};

const PANELS: Part<Compare> = Part::Beside(&[
    (
        2.75,
        Part::Tabs(&[
            Part::Panel("Torques", Compare::torques),
            Part::Panel("Predicted against measured", |_, ui, desk| errors::scatter(ui, desk)),
            Part::Panel("Errors by trajectory", |screen, ui, desk| {
                errors::by_trajectory(ui, desk, &mut screen.sorting);
            }),
        ]),
    ),
    (1.0, Part::Panel("At the cursor", |_, ui, desk| at_cursor(ui, desk))),
]);

/// The screen that compares.
#[derive(Default, Clone)]
pub struct Compare {
    show_terms: bool,
    /// Whether the parts of the torque are shown in place of the residual.
    show_parts: bool,
    /// Only this part of the torque is shown, of all models; `None` for all parts of the current one.
    only: Option<String>,
    /// What a grid of all joints and all models that are shown is of, in place of the torques of the current one; `None` for no grid.
    grid: Option<Cell>,
    sorting: Sorting,
    /// Whether somebody has looked at this recording here.
    was_seen: bool,
}

impl Screen for Compare {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        self.was_seen = true;
        let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
            return;
        };
        controls::let_time_pass(ui, desk, &recording);
        let errors: Vec<String> = step.evaluation.held_out.iter().map(|error| ticks::number(error.r2)).collect();
        let sentence = format!("Held-out R² by joint: {}.", errors.join(" · "));
        let title = format!("Measured against predicted {}", recording.effort());
        widgets::headline(ui, &title, &sentence);
        ui.horizontal_wrapped(|ui| {
            controls::trajectory(ui, desk);
            controls::beside(ui, desk);
            ui.add_space(GAP);
            ui.checkbox(&mut self.show_terms, "Terms").on_hover_text("Draw each term of the model, too");
            let what = "Inertial, Coriolis, gravity and effects in place of the residual; thick and pale: the truth, once unsealed";
            ui.checkbox(&mut self.show_parts, "Decompose").on_hover_text(what);
            self.part(ui, desk, &step);
            Cell::choose(ui, &mut self.grid);
            formula::field(ui, &mut desk.focus.own_series);
            controls::fit(ui, desk);
            ui.label(RichText::new(controls::HINT).size(SMALL).color(Palette::in_ui(ui).weak));
        });
        ui.add_space(4.0);
        let extent = time_extent(&recording.trajectories[desk.focus.trajectory].time);
        desk.focus.cursor.get_or_insert(extent[0] + START * (extent[1] - extent[0]));
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let (Some(recording), Some(step)) = (&desk.session.recording, desk.session.current()) else {
            return Vec::new();
        };
        if let Some(cell) = self.grid {
            let residual = |desk: &mut Desk, question| desk.memo.now(desk.session, question).ok();
            return grid::panels(desk, cell, &residual).concat();
        }
        let run = desk.focus.trajectory;
        let Ok(facts) = desk.memo.now(desk.session, Drawn { trajectory: run }) else { return Vec::new() };
        let parts_of = |desk: &mut Desk, model: Generation| {
            let question = Decomposition { trajectory: run, model };
            self.show_parts.then(|| desk.memo.now(desk.session, question))?.ok()
        };
        let parts = parts_of(desk, step.generation);
        let mut overlaid = Vec::new();
        for (step, ink) in desk.overlaid() {
            let residual = Residual { trajectory: run, model: step.generation };
            let residual = desk.memo.now(desk.session, residual).ok();
            overlaid.push(Overlay { residual, parts: parts_of(desk, step.generation), step, ink });
        }
        let (held_out, show_terms, parts) = (held_out_times(desk.session, run), self.show_terms, parts.as_ref());
        let (facts, overlaid, only) = (&facts, overlaid.as_slice(), self.only.as_deref());
        let beside = desk.focus.beside.and_then(|other| {
            let moved = desk.memo.now(desk.session, MovedTo { trajectory: run, other }).ok()?;
            Some(Beside { run: other, moved })
        });
        let lit = None;
        let torques = Torques { recording, step, facts, run, held_out, overlaid, show_terms, beside, parts, only, lit };
        let joints = 0..recording.joint_count();
        let mut panels: Vec<Panel> = joints.flat_map(|joint| [torques.torque(joint), torques.below(joint)]).collect();
        panels.extend(formula::figure(desk));
        panels.extend(figures::scatter(desk));
        panels.extend(arm::panel(recording, step, facts, run, desk.focus.cursor, desk.focus.sight));
        panels
    }

    /// A grid has a column for each model.
    fn columns(&self, desk: &Desk) -> usize {
        self.grid.map_or(1, |_| desk.shown_models().len())
    }

    fn switches<'a>(&'a mut self, desk: &mut Desk) -> Vec<Switch<'a>> {
        let Compare { show_terms, show_parts, only, grid, .. } = self;
        let question = desk
            .session
            .current()
            .map(|step| Decomposition { trajectory: desk.focus.trajectory, model: step.generation });
        let parts = question.and_then(|question| desk.memo.now(desk.session, question).ok());
        let names: Vec<String> = parts.iter().flat_map(|parts| parts.iter()).map(|part| part.name.clone()).collect();
        let components = |asked: Option<&str>| (*show_parts, *only) = (true, asked.map(str::to_owned));
        let cells = |asked: Option<&str>| *grid = Some(Cell::of(asked));
        vec![
            Switch::on("terms", show_terms),
            Switch::one_of("components", names, components),
            Switch::one_of("grid", Cell::ALL.map(Cell::name), cells),
        ]
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(self.clone())
    }

    fn is_done(&self, session: &Session) -> bool {
        self.was_seen && session.current().is_some()
    }

    fn follow(&mut self, before: &Session, after: &Session, _: Option<&Command>) {
        self.was_seen &= before.has_recording_of(after);
    }

    fn setup(&self) -> Value {
        json!({ "terms": self.show_terms, "parts": self.show_parts, "only": self.only })
    }

    fn set_up(&mut self, setup: Value) {
        (self.show_terms, self.show_parts) = (setup["terms"] == true, setup["parts"] == true);
        self.only = setup["only"].as_str().map(str::to_owned);
    }

    /// What was ticked to be compared is made first.
    fn next(&self, session: &Session, focus: &Focus) -> Next {
        let Some(make) = focus.make_wanted(session) else { return Next::OnTheWay };
        let label = widgets::sentence_case(&make.title());
        Next::Step(NextStep::run(label, "Make the models that are ticked, and draw them over the current one", make))
    }
}

impl Compare {
    /// Of the parts of the torque all are shown, or one of all models over each other.
    fn part(&mut self, ui: &mut Ui, desk: &mut Desk, step: &Step) {
        let question = Decomposition { trajectory: desk.focus.trajectory, model: step.generation };
        let Some(Ok(parts)) = self.show_parts.then(|| desk.memo.later(ui.ctx(), desk.session, question)).flatten()
        else {
            return;
        };
        // Another model may not have it.
        self.only.take_if(|only| parts.iter().all(|part| part.name != *only));
        let all = "all parts";
        let label = ui.label("Part");
        let text = self.only.as_deref().unwrap_or(all).to_owned();
        let chooser = ComboBox::from_id_salt("part").selected_text(text).width(120.0).show_ui(ui, |ui| {
            ui.selectable_value(&mut self.only, None, all);
            for part in parts.iter() {
                ui.selectable_value(&mut self.only, Some(part.name.clone()), &part.name);
            }
        });
        let what =
            "One part is drawn of all models that are shown, over each other; all parts, of the current model alone";
        chooser.response.labelled_by(label.id).on_hover_text(what);
    }

    fn torques(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
            return;
        };
        if let Some(cell) = self.grid {
            return grid::show(ui, desk, cell);
        }
        let run = desk.focus.trajectory;
        let Some(facts) = facts(ui, desk) else { return };
        let ctx = ui.ctx().clone();
        let parts_of = |desk: &mut Desk, model: Generation| {
            let question = Decomposition { trajectory: run, model };
            self.show_parts.then(|| desk.memo.later(&ctx, desk.session, question)).flatten()?.ok()
        };
        let parts = parts_of(desk, step.generation);
        if self.show_parts && parts.is_none() {
            widgets::weak(ui, "It is being decomposed…");
        }
        let mut overlaid = Vec::new();
        for (step, ink) in desk.overlaid() {
            let residual = Residual { trajectory: run, model: step.generation };
            let residual = desk.memo.later(&ctx, desk.session, residual).and_then(Result::ok);
            overlaid.push(Overlay { residual, parts: parts_of(desk, step.generation), step, ink });
        }
        let (held_out, show_terms) = (held_out_times(desk.session, run), self.show_terms);
        let (recording, step, facts, parts) = (&recording, &step, &facts, parts.as_ref());
        let (overlaid, only) = (overlaid.as_slice(), self.only.as_deref());
        let beside = desk.focus.beside.and_then(|other| {
            let moved = desk.memo.later(&ctx, desk.session, MovedTo { trajectory: run, other })?.ok()?;
            Some(Beside { run: other, moved })
        });
        let lit = parts.filter(|_| only.is_none()).and_then(|parts| sum::show(ui, parts));
        let torques = Torques { recording, step, facts, run, held_out, overlaid, show_terms, beside, parts, only, lit };
        let joints = recording.joint_count();
        let marked = desk.focus.marked_of(run);
        let last_extra = 31.0;
        let per_joint = ((ui.available_height() - last_extra) / joints as f32 - 12.0).clamp(150.0, 640.0);
        let above = if parts.is_some() { 0.5 } else { 0.62 };
        for joint in 0..joints {
            let upper = PanelView::new(torques.torque(joint)).without_ticks().height(per_joint * above);
            upper.lit(marked.clone()).cursor(&mut desk.focus.cursor).show(
                ui,
                &mut desk.focus.views,
                &mut desk.memo.decimator,
            );
            let is_last = joint + 1 == joints;
            let height = per_joint * (1.0 - above);
            let lower = PanelView::new(torques.below(joint)).lit(marked.clone()).cursor(&mut desk.focus.cursor);
            let lower = if is_last { lower.height(height + last_extra) } else { lower.without_ticks().height(height) };
            lower.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
            if !is_last {
                ui.add_space(4.0);
            }
        }
        formula::show(ui, desk);
    }
}

fn speed_text(speed: f64) -> String {
    format!("{speed} ×")
}

fn at_cursor(ui: &mut Ui, desk: &mut Desk) {
    let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
        return;
    };
    let palette = Palette::in_ui(ui);
    let index = desk.focus.trajectory;
    let run = &recording.trajectories[index];
    let prediction = &step.evaluation.predictions[index];
    let Some(facts) = facts(ui, desk) else { return };
    let extent = time_extent(&run.time);
    let mut time = desk.focus.cursor.unwrap_or(extent[0]).clamp(extent[0], extent[1]);
    let before = time;
    widgets::card(ui, "", |ui| {
        ui.horizontal_wrapped(|ui| {
            controls::play(ui, desk, "▶ Play", "Let time go on; only there where something is marked (M and drag)");
            let speed = ComboBox::from_id_salt("speed").width(64.0).selected_text(speed_text(desk.focus.speed));
            let speed = speed.show_ui(ui, |ui| {
                for speed in SPEEDS {
                    ui.selectable_value(&mut desk.focus.speed, speed, speed_text(speed));
                }
            });
            let spoken = format!("speed: {}", speed_text(desk.focus.speed));
            speed.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, &spoken));
            speed.response.on_hover_text("How many times as fast as it was recorded");
            ui.checkbox(&mut desk.focus.loops, "Loop").on_hover_text("From the end again from the beginning");
            ui.checkbox(&mut desk.focus.follows, "Follow").on_hover_text("A zoomed view moves with the cursor");
        });
        marked(ui, desk);
        ui.spacing_mut().slider_width = (ui.available_width() - 100.0).max(60.0);
        let slider = Slider::new(&mut time, extent[0]..=extent[1]).suffix(" s").fixed_decimals(2);
        let response = ui.add(slider);
        response.widget_info(|| egui::WidgetInfo::slider(true, time, "time cursor"));
        let sample = nearest(&run.time, time);
        let at = |signal: &Signals| -> Vec<f64> {
            signal.iter().map(|joint| joint.get(sample).copied().unwrap_or(f64::NAN)).collect()
        };
        let (q, measured, predicted) = (at(&run.q), at(&run.tau), at(&prediction.total));
        if let Some(panel) = arm::panel(&recording, &step, &facts, index, Some(time), desk.focus.sight) {
            let is_spatial = recording.spatial().is_some();
            let unit_links = recording.stated_arm.is_none() && !is_spatial;
            let drawing = PanelView::new(panel).drawing().spoken("the arm at the time cursor").height(250.0);
            let drawn = drawing.show(ui, &mut desk.focus.views, &mut desk.memo.decimator).response;
            let legend = match is_spatial {
                true => {
                    spatial::turn(ui, &drawn, &mut desk.focus.sight);
                    "Drag it to turn it (or arrow keys; a double click turns it back). Arcs about the axes: torque, full line measured, \
                     dashed predicted."
                }
                false => "Arcs: torque, counter-clockwise positive, full line measured, dashed predicted.",
            };
            ui.label(RichText::new(legend).size(SMALL).color(palette.weak));
            if unit_links {
                let text = "The recording states no lengths: all links are drawn equally long.";
                ui.label(RichText::new(text).size(SMALL).color(palette.warning));
            }
            if recording.posture.is_none() && unit_links {
                let text = "Nor does it say where q = 0 points: it is drawn to the right.";
                ui.label(RichText::new(text).size(SMALL).color(palette.warning));
            }
        }
        ui.add_space(4.0);
        let rows: Vec<Vec<WidgetText>> = (0..q.len())
            .map(|joint| {
                let cells = [q[joint], measured[joint], predicted[joint], measured[joint] - predicted[joint]];
                let mut row: Vec<WidgetText> = vec![recording.joints[joint].name.clone().into()];
                row.extend(cells.map(|value| WidgetText::from(format!("{value:.2}").replace('-', "−"))));
                row
            })
            .collect();
        let unit = recording.units();
        let header = ["", &format!("q [{}]", unit[0]), "τ", "τ̂", &format!("τ − τ̂ [{}]", unit[3])];
        ui.scope(|ui| {
            ui.style_mut().spacing.item_spacing.x = 4.0;
            widgets::table(ui, "values at the cursor", &header, &rows);
        });
    });
    residuals_of_others(ui, desk, &recording, nearest(&run.time, time));
    if time != before {
        desk.focus.cursor = Some(time);
    }
    tables::errors(ui, &recording, &step);
}

/// What the models that are drawn over the current one leave at a sample.
fn residuals_of_others(ui: &mut Ui, desk: &Desk, recording: &Recording, sample: usize) {
    let (others, run) = (desk.overlaid(), desk.focus.trajectory);
    if others.is_empty() {
        return;
    }
    let row = |(step, _): &(Arc<Step>, Ink)| -> Vec<WidgetText> {
        let residual = |joint: usize| {
            let of = |torque: &Signals| torque[joint][sample];
            of(&recording.trajectories[run].tau) - of(&step.evaluation.predictions[run].total)
        };
        let cells =
            (0..recording.joint_count()).map(|joint| format!("{:.2}", residual(joint)).replace('-', "−").into());
        std::iter::once(step.name.clone().into()).chain(cells).collect()
    };
    widgets::card(ui, &format!("What others leave: τ − τ̂ [{}]", recording.units()[3]), |ui| {
        let names = recording.joints.iter().map(|joint| joint.name.as_str());
        let header: Vec<&str> = std::iter::once("").chain(names).collect();
        widgets::table(ui, "what others leave at the cursor", &header, &others.iter().map(row).collect::<Vec<_>>());
    });
}

/// What was marked in state space on another screen, and that it can be forgotten.
fn marked(ui: &mut Ui, desk: &mut Desk) {
    let Some(marked) = desk.focus.marked.clone() else { return };
    ui.horizontal_wrapped(|ui| {
        let places = match marked.len() {
            1 => "one stretch".to_owned(),
            count => format!("{count} stretches"),
        };
        let text = format!("Marked in “Where it fails”: {places}.");
        ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
        if ui.small_button("Unmark").clicked() {
            desk.focus.marked = None;
        }
    });
}
