//! Where it fails: the residual of one joint over every state, in frequency and in its own past, and its worst moments.
//!
//! A region that is marked in one view is lit in all others and on the time line.

mod figures;
mod moments;
mod own;
pub(in crate::app) mod table;
mod views;

use std::sync::Arc;

use egui::{Align, Layout, RichText, Ui, vec2};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use figures::{Other, Shown};
use table::{AllSpectra, Brush, Lit, Marked, MarkedSpectra, MeanMap, Quantity, Samples, Table};
use views::{Looking, View};

use crate::app::controls;
use crate::app::desk::{About, Desk, Needs};
use crate::app::dock::{self, Part};
use crate::app::plot::{Along, PanelView};
use crate::app::screen::{Screen, Switch};
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::widgets::{self, is_narrow};
use crate::figure::Panel;
use crate::figure::mark::nearest;
use crate::session::{Command, Session, Step};

/// Least height of the time line \[points\].
const LEAST_TIME_LINE: f32 = 90.0;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "residuals",
    title: "Where it fails",
    purpose: "What the model leaves, over every state",
    needs: Needs::Model,
    on_the_way: true,
};

const PANELS: Part<Residuals> = Part::Stack(&[
    (
        3.2,
        Part::Beside(&[
            (4.0, Part::Panel("Views", Residuals::grid)),
            (1.0, Part::Panel("Worst moments", Residuals::worst)),
        ]),
    ),
    (1.0, Part::Panel("Time line", Residuals::time_line)),
]);

/// How it is set up, as a file keeps it.
#[derive(Serialize, Deserialize)]
#[serde(default)]
struct Setup {
    held_out_only: bool,
    looking: Looking,
}

impl Default for Setup {
    fn default() -> Self {
        Setup { held_out_only: true, looking: Looking::default() }
    }
}

/// The screen of the residual.
#[derive(Clone)]
pub struct Residuals {
    held_out_only: bool,
    looking: Looking,
    /// The joint, which another screen may have changed, and whether it is held-out data that is shown.
    shown_of: Option<(usize, bool)>,
    /// Whether somebody has looked at this recording here.
    was_seen: bool,
}

impl Default for Residuals {
    fn default() -> Self {
        Residuals { held_out_only: true, looking: Looking::default(), shown_of: None, was_seen: false }
    }
}

impl Screen for Residuals {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        self.was_seen = true;
        let Some(recording) = desk.session.recording.clone() else { return };
        controls::let_time_pass(ui, desk, &recording);
        if desk.focus.marked.is_none() {
            // Another screen has forgotten it.
            self.looking.brush = None;
        }
        let narrow = is_narrow(ui);
        let effort = recording.effort();
        let sentence = format!(
            "Measured minus predicted {effort}. Noise looks the same everywhere; a missing effect has a shape."
        );
        widgets::headline(ui, "Where the model fails", if narrow { "" } else { &sentence });
        ui.horizontal_wrapped(|ui| {
            controls::joint(ui, desk, &recording);
            ui.add_space(GROUP);
            ui.selectable_value(&mut self.held_out_only, true, "Held-out data");
            ui.selectable_value(&mut self.held_out_only, false, "Training data");
            ui.add_space(GROUP);
            controls::fit(ui, desk);
            if self.looking.brush.is_some() {
                let what = "Let time go on where it is marked, one stretch after the other; Compare shows the arm there";
                controls::play(ui, desk, "▶ Play what is marked", what);
                if ui.button("Unmark").clicked() {
                    self.looking.brush = None;
                }
            }
            if !narrow {
                let text = "Drag in a view to mark a region: others light it, spectra follow it. Line: mean, band: ± one deviation.";
                ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
            }
        });
        let now = (desk.focus.joint, self.held_out_only);
        if self.shown_of.replace(now).is_some_and(|before| before != now) {
            // A region of one joint's states means nothing to another.
            self.looking.brush = None;
            desk.focus.marked = None;
            desk.focus.views.fit(Along::WholeTime);
        }
        ui.add_space(4.0);
        let table = self.table(ui, desk);
        if let Some(table) = &table {
            let session = desk.session;
            own::prepare(desk, table, |memo, question| memo.later(ui.ctx(), session, question));
        }
        if table.is_some_and(|table| table.len() == 0) {
            let text = "No samples in this part of the data: look at the other part.";
            widgets::card(ui, "", |ui| widgets::weak(ui, text));
            return;
        }
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
        self.tell_what_is_marked(ui, desk);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let Some(step) = desk.session.current() else { return Vec::new() };
        let Ok(table) = desk.memo.now(desk.session, self.samples(desk, step)) else { return Vec::new() };
        if table.len() == 0 {
            return Vec::new();
        }
        let (of_table, session) = (|| Arc::clone(&table), desk.session);
        own::prepare(desk, &table, |memo, question| Some(memo.now(session, question)));
        let lit = self.lit(desk, &table);
        let spectra = desk.memo.now(desk.session, AllSpectra { table: of_table() }).ok();
        let marked_of = |desk: &mut Desk, of: &Arc<Table>| {
            let question = MarkedSpectra { table: of_table(), brush: self.looking.brush?, of: Arc::clone(of) };
            desk.memo.now(desk.session, question).ok()
        };
        let marked = marked_of(desk, &table);
        let cells = desk.memo.now(desk.session, MeanMap { table: of_table(), states: self.looking.map }).ok();
        let mut others = Vec::new();
        for (step, ink) in desk.overlaid() {
            let Ok(table) = desk.memo.now(desk.session, self.samples(desk, &step)) else { continue };
            let spectra = desk.memo.now(desk.session, AllSpectra { table: Arc::clone(&table) }).ok();
            let cells = MeanMap { table: Arc::clone(&table), states: self.looking.map };
            let (marked, cells) = (marked_of(desk, &table), desk.memo.now(desk.session, cells).ok());
            others.push(Other { name: step.name.clone(), ink, table, spectra, marked, cells });
        }
        let shown = Shown {
            name: &step.name,
            others: &others,
            table: &table,
            lit: &lit.rows,
            spectra: spectra.as_ref(),
            marked: marked.as_ref(),
            unit: unit(desk),
            joint: desk.focus.joint,
            row: moments::row_at_cursor(desk, &table),
        };
        let panels = |view: &View| match view {
            View::Over(x) => vec![shown.over(*x)],
            View::Map => cells.as_ref().map_or(Vec::new(), |cells| shown.maps(self.looking.map, cells)),
            View::Loop => vec![shown.around_cursor()],
            View::Of(curve) => shown.curve(*curve).into_iter().collect(),
        };
        views::ALL.iter().flat_map(panels).chain([shown.time_line()]).collect()
    }

    fn switches<'a>(&'a mut self, _: &mut Desk) -> Vec<Switch<'a>> {
        let Residuals { held_out_only, looking, .. } = self;
        let name = |[x, y]: [Quantity; 2]| [x, y].map(|state| state.text([""; 4]).0).join("-");
        let all = || Quantity::STATES.into_iter().flat_map(|x| Quantity::STATES.map(|y| [x, y]));
        let map = move |asked: Option<&str>| {
            looking.map = all().find(|map| asked == Some(&name(*map))).unwrap_or(looking.map);
        };
        let maps = all().map(name);
        vec![Switch::that("training", || *held_out_only = false), Switch::one_of("map", maps, map)]
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(self.clone())
    }

    fn is_done(&self, session: &Session) -> bool {
        self.was_seen && session.current().is_some()
    }

    fn follow(&mut self, before: &Session, after: &Session, _: Option<&Command>) {
        if !before.has_recording_of(after) {
            self.was_seen = false;
            self.looking.brush = None;
        }
    }

    fn setup(&self) -> Value {
        let setup = Setup { held_out_only: self.held_out_only, looking: self.looking.clone() };
        serde_json::to_value(setup).unwrap_or_default()
    }

    fn set_up(&mut self, setup: Value) {
        Setup { held_out_only: self.held_out_only, looking: self.looking } =
            serde_json::from_value(setup).unwrap_or_default();
        self.shown_of = None;
    }
}

/// The name of the current model.
fn name<'a>(desk: &Desk<'a>) -> &'a str {
    desk.session.current().map_or("", |step| &step.name)
}

/// Units of the shown joint.
fn unit(desk: &Desk) -> [&'static str; 4] {
    let joints = desk.session.recording.iter().flat_map(|recording| &recording.joints);
    joints.map(|joint| joint.kind).nth(desk.focus.joint).unwrap_or_default().units()
}

impl Residuals {
    /// What is asked of a model.
    fn samples(&self, desk: &Desk, step: &Step) -> Samples {
        Samples { model: step.generation, joint: desk.focus.joint, held_out: self.held_out_only }
    }

    /// The residual of the shown joint and part; `None` until it is known.
    fn table(&self, ui: &Ui, desk: &mut Desk) -> Option<Arc<Table>> {
        let samples = self.samples(desk, desk.session.current()?);
        desk.memo.later(ui.ctx(), desk.session, samples)?.ok()
    }

    /// What is known of the models that are drawn over the current one, whose samples are in a table.
    fn others(&self, ui: &Ui, desk: &mut Desk, current: &Arc<Table>) -> Vec<Other> {
        let brush = self.settled_brush(ui);
        let mut others = Vec::new();
        for (step, ink) in desk.overlaid() {
            let samples = self.samples(desk, &step);
            let Some(Ok(table)) = desk.memo.later(ui.ctx(), desk.session, samples) else { continue };
            let all = AllSpectra { table: Arc::clone(&table) };
            let spectra = desk.memo.later(ui.ctx(), desk.session, all).and_then(Result::ok);
            let cells = MeanMap { table: Arc::clone(&table), states: self.looking.map };
            let cells = desk.memo.later(ui.ctx(), desk.session, cells).and_then(Result::ok);
            let marked = brush.and_then(|brush| {
                let question = MarkedSpectra { table: Arc::clone(current), brush, of: Arc::clone(&table) };
                desk.memo.later(ui.ctx(), desk.session, question)?.ok()
            });
            others.push(Other { name: step.name.clone(), ink, table, spectra, marked, cells });
        }
        others
    }

    /// What is marked; nothing while a region is drawn, which changes in every frame.
    fn settled_brush(&self, ui: &Ui) -> Option<Brush> {
        self.looking.brush.filter(|_| !ui.input(|input| input.pointer.any_down()))
    }

    /// All screens show what is marked here, until another recording comes.
    fn tell_what_is_marked(&self, ui: &Ui, desk: &mut Desk) {
        let marked = match self.looking.brush {
            None => None,
            Some(_) => match self.table(ui, desk) {
                None => return,
                Some(table) => Some(Arc::clone(&self.lit(desk, &table).stretches)),
            },
        };
        if marked.is_some() && marked != desk.focus.marked {
            // What was marked last is played.
            desk.focus.views.of(Along::Time).measured = None;
        }
        desk.focus.marked = marked;
    }

    /// What is marked.
    fn lit(&self, desk: &mut Desk, table: &Arc<Table>) -> Arc<Marked> {
        let Some(brush) = self.looking.brush else { return Arc::default() };
        desk.memo.now(desk.session, Lit { table: Arc::clone(table), brush }).unwrap_or_default()
    }

    fn worst(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        let Some(table) = self.table(ui, desk) else { return };
        let [.., unit] = unit(desk);
        moments::show(ui, desk, &recording, &table, unit);
    }

    /// All views, two beside each other where there is room.
    fn grid(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(table) = self.table(ui, desk) else { return };
        let lit = self.lit(desk, &table);
        let all = AllSpectra { table: Arc::clone(&table) };
        let spectra = desk.memo.later(ui.ctx(), desk.session, all).and_then(Result::ok);
        let marked = self.settled_brush(ui).and_then(|brush| {
            let question = MarkedSpectra { table: Arc::clone(&table), brush, of: Arc::clone(&table) };
            desk.memo.later(ui.ctx(), desk.session, question)?.ok()
        });
        let (others, name) = (self.others(ui, desk, &table), name(desk));
        let shown = Shown {
            name,
            others: &others,
            table: &table,
            lit: &lit.rows,
            spectra: spectra.as_ref(),
            marked: marked.as_ref(),
            unit: unit(desk),
            joint: desk.focus.joint,
            row: moments::row_at_cursor(desk, &table),
        };
        let columns = if ui.available_width() > 640.0 { 2 } else { 1 };
        let width = (ui.available_width() - GAP * (columns as f32 - 1.0)) / columns as f32;
        let size = vec2(width, (ui.available_height() / 2.0 - GAP).clamp(250.0, 400.0));
        for row in views::ALL.chunks(columns) {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GAP;
                for view in row {
                    ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
                        ui.set_width(size.x);
                        views::show(ui, desk, &mut self.looking, *view, &shown, size.y);
                    });
                }
            });
        }
    }

    /// The residual over the time of all segments, with what is marked and where the cursor is.
    fn time_line(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(table) = self.table(ui, desk) else { return };
        let lit = self.lit(desk, &table);
        let (unit, joint, row) = (unit(desk), desk.focus.joint, moments::row_at_cursor(desk, &table));
        let (others, name) = (self.others(ui, desk, &table), name(desk));
        let others = others.as_slice();
        let shown =
            Shown { name, others, table: &table, lit: &lit.rows, spectra: None, marked: None, unit, joint, row };
        let time = table.column(Quantity::Time);
        let mut cursor = row.map(|row| time[row]);
        let before = cursor;
        let view = PanelView::new(shown.time_line()).lit(lit.shown.clone()).cursor(&mut cursor);
        let view = view.height((ui.available_height() - 4.0).clamp(LEAST_TIME_LINE, 300.0));
        view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        if cursor != before
            && let Some(at) = cursor
        {
            moments::jump(desk, &table, nearest(time, at));
        }
    }
}
