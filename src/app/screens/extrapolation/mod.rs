//! Extrapolation: how the error of the models grows when the arm moves faster or wider than in the data, and the torque there.

mod figures;

use std::sync::Arc;

use egui::{Button, RichText, Slider, Ui, WidgetInfo, WidgetText};

use crate::app::desk::{About, Desk, Focus, Needs};
use crate::app::dock::{self, Part};
use crate::app::formula::{self, Channels};
use crate::app::memo::{Answer, Memo, Question};
use crate::app::plot::{Along, OwnSeries, PanelView, ticks};
use crate::app::screen::{Next, NextStep, Screen, Switch};
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::{controls, widgets};
use crate::figure::mark::Line;
use crate::figure::{Ink, Panel, Shared};
use crate::recording::Recording;
use crate::session::{Command, Generation, Session, Step};
use crate::simulation::extrapolation::{Basis, Curve, Replay, Stretch, Sweep, replay};

/// Scales that the replay can have.
const REPLAYED: std::ops::RangeInclusive<f64> = 1.0..=3.0;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "extrapolation",
    title: "Extrapolation",
    purpose: "How the error grows outside the data",
    needs: Needs::Model,
    on_the_way: true,
};

const PANELS: Part<Extrapolation> = Part::Beside(&[
    (
        2.9,
        Part::Stack(&[
            (1.0, Part::Panel("Error over scale", Extrapolation::errors)),
            (1.1, Part::Panel("Replay", Extrapolation::replayed)),
        ]),
    ),
    (1.0, Part::Panel("Models", Extrapolation::choices)),
]);

/// The screen of extrapolation.
#[derive(Default, Clone)]
pub struct Extrapolation {
    stretch: Stretch,
    /// The shown joint; `None` for all together.
    joint: Option<usize>,
    /// The scale of the replay; the cursor of the curves.
    scale: Option<f64>,
    /// Where in the replay one looks \[s\].
    cursor: Option<f64>,
    /// What is drawn while the next replay is computed.
    newest: Option<Arc<Replay>>,
}

impl Screen for Extrapolation {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        widgets::headline(ui, "Outside the data", &self.sentence(desk.session, &recording));
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let Some(recording) = &desk.session.recording else { return Vec::new() };
        let mut panels = Vec::new();
        panels.extend(self.sweep(desk.session).map(|sweep| figures::errors(desk, recording, sweep, self.joint)));
        let current = desk.session.current().map(|step| self.replay_of(desk, step));
        if let Some(Ok(replay)) = current.map(|question| desk.memo.now(desk.session, question)) {
            let mut others = Vec::new();
            for (step, ink) in desk.overlaid() {
                let question = self.replay_of(desk, &step);
                others.extend(desk.memo.now(desk.session, question).ok().map(|replay| (step, ink, replay)));
            }
            let session = desk.session;
            prepare(desk, &replay, |memo, question| Some(memo.now(session, question)));
            panels.extend(figures::replay(recording, &replay, &others, desk.focus.joint_of(recording)));
        }
        panels
    }

    fn switches<'a>(&'a mut self, desk: &mut Desk) -> Vec<Switch<'a>> {
        let joint = desk.focus.joint;
        vec![Switch::that("one-joint", move || self.joint = Some(joint))]
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(self.clone())
    }

    fn is_done(&self, session: &Session) -> bool {
        session.sweep.is_some()
    }

    fn next(&self, session: &Session, focus: &Focus) -> Next {
        if session.sweep.is_some() {
            return Next::Export;
        }
        let why = "Test the models at up to three times the speed";
        let shown = |step: &Step| focus.overlaid.ink(step.generation).is_some();
        let sweep = Command::Extrapolate { steps: computed(session, shown), stretch: Stretch::Speed };
        Next::Step(NextStep::run("Go faster", why, sweep))
    }

    fn answers(&self, command: &Command) -> bool {
        matches!(command, Command::Extrapolate { .. })
    }

    fn follow(&mut self, before: &Session, after: &Session, by: Option<&Command>) {
        if !before.has_recording_of(after) {
            *self = Extrapolation { stretch: self.stretch, ..Extrapolation::default() };
        }
        if let Some(Command::Extrapolate { stretch, .. }) = by {
            self.stretch = *stretch;
        }
        self.newest = None;
    }
}

/// The models that are computed: the ladder, what is drawn over the current model, and with each the trainings that differ from it
/// in nothing but their seed, which are one band.
pub fn computed(session: &Session, is_shown: impl Fn(&Step) -> bool) -> Vec<Arc<Step>> {
    let shown = session.all_models().filter(|step| is_shown(step));
    let mut all: Vec<Arc<Step>> = Vec::new();
    for step in session.ladder.iter().chain(shown) {
        for step in [step].into_iter().chain(session.seeds_of(step)) {
            if all.iter().all(|known| known.generation != step.generation) {
                all.push(Arc::clone(step));
            }
        }
    }
    all
}

/// A model along a trajectory, faster, wider or under load.
#[derive(Clone, PartialEq)]
struct Replayed {
    model: Generation,
    trajectory: usize,
    stretch: Stretch,
    scale: f64,
}

impl Question for Replayed {
    type Answer = Replay;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<Replay, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.model).ok_or("there is no such model")?;
        replay(recording, self.trajectory, self.stretch, self.scale, &step.fitted).map_err(|error| error.to_string())
    }
}

/// A formula of the channels of a replay.
#[derive(Clone)]
struct OnReplay {
    series: OwnSeries,
    replay: Arc<Replay>,
}

/// Whoever asks holds the replay, so that no other can stand where it does.
impl PartialEq for OnReplay {
    fn eq(&self, other: &Self) -> bool {
        self.series == other.series && Arc::ptr_eq(&self.replay, &other.replay)
    }
}

impl Question for OnReplay {
    type Answer = Vec<f64>;
    const KEPT: usize = 9;

    fn answer(&self, _: &Session) -> Result<Vec<f64>, String> {
        let Replay { motion, predicted, exact } = &*self.replay;
        formula::along(&self.series, &Channels { run: motion, predicted: Some(predicted), is_measured: *exact })
    }
}

/// The charts of a replay can have lines of one's own.
fn prepare(desk: &mut Desk, replay: &Arc<Replay>, ask: impl Fn(&mut Memo, OnReplay) -> Option<Answer<OnReplay>>) {
    let Desk { focus, memo, .. } = desk;
    focus.views.own.draw(Along::ReplayTime, |series| {
        let values = ask(memo, OnReplay { series: series.clone(), replay: Arc::clone(replay) })?;
        let time = Shared::of(replay, |replay| &replay.motion.time);
        let line =
            |values: Arc<Vec<f64>>| Line::new("", time, Shared::of(&values, |values| &values[..]), Ink::Text).sampled();
        Some(values.map(line))
    });
}

impl Extrapolation {
    /// What was computed in the way that is chosen; that of another way says nothing of it.
    fn sweep<'a>(&self, session: &'a Session) -> Option<&'a Arc<Sweep>> {
        session.sweep.as_ref().filter(|sweep| sweep.stretch == self.stretch)
    }

    /// What the curves are made of, said before anything is believed.
    fn sentence(&self, session: &Session, recording: &Recording) -> String {
        let how = if recording.seal.is_some() {
            let effort = recording.effort();
            format!("the held-out runs are travelled anew by the simulated arm, and the exact {effort} is known")
        } else {
            "the held-out data are cut into blocks of a second, sorted by how fast they are".to_owned()
        };
        match self.sweep(session).and_then(|sweep| sweep.curves.last()) {
            Some(Curve { model, points }) if points.len() > 1 => {
                let (first, last) = (&points[0], &points[points.len() - 1]);
                let (from, to) = (ticks::number(first.overall), ticks::number(last.overall));
                let scale = ticks::short((100.0 * last.scale).round() / 100.0);
                let what = self.stretch.name();
                format!("“{model}” goes from an error (nMSE) of {from} to {to} at {scale} times the {what}; {how}.")
            }
            _ => format!("Does the model hold where nothing was recorded? For the answer {how}."),
        }
    }

    fn errors(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        match self.sweep(desk.session).cloned() {
            Some(sweep) => self.curves(ui, desk, &recording, &sweep),
            None => widgets::card(ui, "Error over scale", |ui| {
                let text =
                    format!("Nothing was computed yet over {}: press Compute at the right.", self.stretch.name());
                widgets::weak(ui, text);
            }),
        }
    }

    fn curves(&mut self, ui: &mut Ui, desk: &mut Desk, recording: &Recording, sweep: &Sweep) {
        let palette = Palette::in_ui(ui);
        let what = match sweep.basis {
            Basis::Simulated => "exact truth",
            Basis::Measured => "held-out blocks as measured",
        };
        widgets::card(ui, &format!("Error over {}, {what}", sweep.stretch.name()), |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.selectable_value(&mut self.joint, None, "All joints");
                for (joint, info) in recording.joints.iter().enumerate() {
                    ui.selectable_value(&mut self.joint, Some(joint), &info.name);
                }
            });
            let panel = figures::errors(desk, recording, sweep, self.joint);
            let mut scale = self.scale;
            let height = (ui.available_height() - 80.0).clamp(130.0, 420.0);
            let view = PanelView::new(panel).cursor(&mut scale).height(height);
            view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
            if scale != self.scale {
                self.scale = scale.map(|scale| scale.clamp(*REPLAYED.start(), *REPLAYED.end()));
            }
            let text = "Bands: four in five blocks of a second, or all trainings of a model that was trained several times, whose \
                        median is the line. nMSE: squared error over squared measurement. Drag: scale of the replay.";
            ui.label(RichText::new(text).size(SMALL).color(palette.weak));
        });
    }

    /// The chosen trajectory at the chosen scale.
    fn replayed(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        let palette = Palette::in_ui(ui);
        let Some(step) = desk.session.current().cloned() else { return };
        widgets::card(ui, "", |ui| {
            ui.horizontal_wrapped(|ui| {
                let mut scale = self.scale.unwrap_or(1.0);
                let label = ui.label(widgets::sentence_case(self.stretch.name()));
                let slider = Slider::new(&mut scale, REPLAYED).fixed_decimals(2).suffix(" ×");
                let slider = ui.add(slider).labelled_by(label.id);
                slider.widget_info(|| WidgetInfo::slider(true, scale, "scale of the replay"));
                if slider.changed() {
                    self.scale = Some(scale);
                }
                ui.add_space(GAP);
                controls::trajectory(ui, desk);
                ui.add_space(GAP);
                controls::joint(ui, desk, &recording);
            });
            let Some(replay) = self.current_replay(ui, desk, &step) else { return };
            let mut others = Vec::new();
            for (step, ink) in desk.overlaid() {
                let question = self.replay_of(desk, &step);
                let replay = desk.memo.later(ui.ctx(), desk.session, question).and_then(Result::ok);
                others.extend(replay.map(|replay| (step, ink, replay)));
            }
            let session = desk.session;
            prepare(desk, &replay, |memo, question| memo.later(ui.ctx(), session, question));
            let height = (ui.available_height() - 140.0).clamp(90.0, 300.0);
            let [torque, velocity] = figures::replay(&recording, &replay, &others, desk.focus.joint);
            let torque = PanelView::new(torque).cursor(&mut self.cursor).without_ticks().height(height);
            torque.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
            let velocity = PanelView::new(velocity).cursor(&mut self.cursor).height(110.0);
            velocity.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
            let text = if replay.exact {
                format!("Model: {}. {}", step.name, controls::HINT)
            } else {
                "This arm was measured: what it would need at this scale is not known, so only the prediction is drawn."
                    .into()
            };
            ui.label(RichText::new(text).size(SMALL).color(palette.weak));
        });
    }

    fn replay_of(&self, desk: &Desk, step: &Step) -> Replayed {
        let (model, trajectory) = (step.generation, desk.focus.trajectory);
        Replayed { model, trajectory, stretch: self.stretch, scale: self.scale.unwrap_or(1.0) }
    }

    /// The replay of what is chosen; while it is computed the one before it, so that the slider moves a picture.
    fn current_replay(&mut self, ui: &mut Ui, desk: &mut Desk, step: &Step) -> Option<Arc<Replay>> {
        let question = self.replay_of(desk, step);
        match desk.memo.later(ui.ctx(), desk.session, question) {
            Some(Ok(replay)) => self.newest = Some(replay),
            Some(Err(error)) => {
                ui.label(RichText::new(format!("It can't be replayed: {error}.")).color(Palette::in_ui(ui).error));
                return None;
            }
            None => (),
        }
        self.newest.clone()
    }

    /// Which models, faster or wider, and the button that computes.
    fn choices(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let palette = Palette::in_ui(ui);
        widgets::card(ui, "What to compute", |ui| {
            ui.horizontal(|ui| {
                let choices = [(Stretch::Speed, "Faster"), (Stretch::Range, "Wider"), (Stretch::Load, "Under load")];
                for (stretch, name) in choices {
                    if ui.radio_value(&mut self.stretch, stretch, name).changed() {
                        // What is drawn until the next replay is there went another way.
                        self.newest = None;
                    }
                }
            });
            ui.add_space(2.0);
            let shown = |step: &Step| desk.focus.overlaid.ink(step.generation).is_some();
            let steps = computed(desk.session, shown);
            let names: Vec<&str> = steps.iter().map(|step| step.name.as_str()).collect();
            widgets::weak(
                ui,
                format!("The ladder, what is shown over it (Models), all seeds of each: {}.", names.join("; ")),
            );
            ui.add_space(2.0);
            let button = ui.add_enabled(desk.busy.is_none(), Button::new("Compute"));
            if button.on_disabled_hover_text("Something is at work; see below").clicked() {
                desk.run(Command::Extrapolate { steps, stretch: self.stretch });
            }
        });
        let Some(sweep) = self.sweep(desk.session) else { return };
        widgets::card(ui, "Error (nMSE) of all joints", |ui| {
            let scale = self.scale.unwrap_or(*REPLAYED.start());
            let scales: Vec<f64> = sweep.curves.first().map_or(Vec::new(), |curve| {
                let mut near: Vec<f64> = curve.points.iter().map(|point| point.scale).collect();
                near.sort_by(|one, other| (one - scale).abs().total_cmp(&(other - scale).abs()));
                let (Some(first), Some(last)) = (curve.points.first(), curve.points.last()) else { return Vec::new() };
                let mut shown = vec![first.scale, near[0], last.scale];
                shown.dedup();
                shown
            });
            for curve in &sweep.curves {
                ui.label(RichText::new(&curve.model).size(SMALL).color(palette.weak));
                let cell = |scale: &f64| {
                    let point = curve.points.iter().find(|point| point.scale == *scale);
                    WidgetText::from(point.map_or("—".to_owned(), |point| ticks::number(point.overall)))
                };
                let header: Vec<String> =
                    scales.iter().map(|scale| format!("{} ×", ticks::short((100.0 * scale).round() / 100.0))).collect();
                let header: Vec<&str> = header.iter().map(String::as_str).collect();
                widgets::table(
                    ui,
                    &format!("errors of {}", curve.model),
                    &header,
                    &[scales.iter().map(cell).collect()],
                );
                ui.add_space(GROUP / 4.0);
            }
        });
    }
}
