//! What models have learned: mass matrix, energies, gravity and Coriolis torque over one joint, the power along a run, and the
//! friction of all joints; the models that are shown over each other, beside the truth where the seal is open.

use std::sync::Arc;

use egui::{DragValue, RichText, Ui, WidgetInfo};
use serde::{Deserialize, Serialize};

use super::figures;
use crate::app::desk::Desk;
use crate::app::memo::{Answer, Question};
use crate::app::plot::PanelView;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::{controls, formula, widgets};
use crate::arm::Arm;
use crate::figure::{Ink, Panel};
use crate::model::Fitted;
use crate::recording::{JointKind, Recording, Trajectory};
use crate::session::{Generation, Session};
use crate::signals::Signals;
use crate::simulation::TrueParts;
use crate::statistics::ends;
use crate::training::TrainError;
use crate::training::friction::{self, FrictionCurve};
use crate::training::inside::{Balance, Fall, Inside, Slice};

/// Height of a chart \[points\].
const CHART: f32 = 200.0;
/// Least width of a chart \[points\]; where there is room for two they stand side by side.
const LEAST_CHART: f32 = 420.0;

/// Least width of a chart of one component of several models \[points\].
const LEAST_COMPARED: f32 = 300.0;

/// Least width of the chart of a joint's friction \[points\]: all joints stand side by side where there is room.
const LEAST_FRICTION: f32 = 230.0;

/// Of a model that is drawn over the current one.
pub struct Other<T> {
    pub name: String,
    pub ink: Ink,
    pub of: Arc<T>,
}

/// What is to be looked at.
#[derive(Default, Clone, Serialize, Deserialize)]
#[serde(default)]
pub struct Wish {
    /// Where the other joints stand \[rad or m\].
    posture: Vec<f64>,
    /// With which velocities c is asked for \[rad/s or m/s\].
    velocity: Vec<f64>,
    /// Whether the arm was let go.
    pub falls: bool,
}

/// The model over a slice, and the truth.
#[derive(Clone, PartialEq)]
pub struct Sliced {
    model: Generation,
    joint: usize,
    posture: Vec<f64>,
    velocity: Vec<f64>,
}

/// Something of a model, and the same of the arm as it is.
pub struct BesideTruth<T> {
    pub own: T,
    /// Once the seal is open.
    pub truth: Option<T>,
}

impl<T> BesideTruth<T> {
    fn of(
        session: &Session,
        model: Generation,
        of_model: impl Fn(&Fitted) -> Result<T, TrainError>,
        of_arm: impl Fn(&Arm) -> Result<T, TrainError>,
    ) -> Result<Self, String> {
        let step = session.model_of(model).ok_or("there is no such model")?;
        let own = of_model(&step.fitted).map_err(|error| error.to_string())?;
        let truth = session.truth.as_ref().map(|truth| of_arm(&truth.arm)).transpose();
        Ok(BesideTruth { own, truth: truth.map_err(|error| error.to_string())? })
    }
}

/// What [`Sliced`] is answered with.
pub type OverSlice = BesideTruth<Inside>;

impl Question for Sliced {
    type Answer = OverSlice;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<OverSlice, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        // As far as the recording went.
        let range = ends(recording.trajectories.iter().flat_map(|run| ends(run.q[self.joint].iter().copied())));
        let Sliced { joint, posture, velocity, .. } = self.clone();
        let slice = Slice { joint, range, posture, velocity };
        let of_model = |fitted: &Fitted| Inside::of_model(fitted, &slice);
        BesideTruth::of(session, self.model, of_model, |arm| Inside::of_arm(arm, &slice))
    }
}

/// The arm of the model let go in this posture, and the truth.
#[derive(Clone, PartialEq)]
pub struct Falling {
    model: Generation,
    posture: Vec<f64>,
}

/// What [`Falling`] is answered with.
pub type Falls = BesideTruth<Fall>;

impl Question for Falling {
    type Answer = Falls;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<Falls, String> {
        let of_model = |fitted: &Fitted| Fall::of_model(fitted, &self.posture);
        BesideTruth::of(session, self.model, of_model, |arm| Fall::of_arm(arm, &self.posture))
    }
}

/// Energy and power of the model along a trajectory, and the truth.
#[derive(Clone, PartialEq)]
pub struct Balanced {
    model: Generation,
    trajectory: usize,
}

/// What [`Balanced`] is answered with.
pub struct AlongRun {
    pub own: Balance,
    /// Once the seal is open.
    pub truth: Option<Balance>,
    /// Measured and predicted power \[W\].
    pub power: [Vec<f64>; 2],
}

impl Question for Balanced {
    type Answer = AlongRun;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<AlongRun, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.model).ok_or("there is no such model")?;
        let run = recording.trajectories.get(self.trajectory).ok_or("there is no such trajectory")?;
        let predicted = step.evaluation.predictions.get(self.trajectory).ok_or("it was not predicted")?;
        let of_model = |fitted: &Fitted| Balance::of_model(fitted, run);
        let BesideTruth { own, truth } =
            BesideTruth::of(session, self.model, of_model, |arm| Balance::of_arm(arm, run))?;
        let power = [&run.tau, &predicted.total].map(|torque| crate::training::inside::power(torque, run));
        Ok(AlongRun { own, truth, power })
    }
}

/// What of the torque is neither inertia nor gravity, over the velocity of each joint, and the truth.
#[derive(Clone, PartialEq)]
pub struct Friction {
    model: Generation,
}

/// What [`Friction`] is answered with, by joint.
pub struct OverVelocity {
    pub curves: Vec<FrictionCurve>,
    /// Of all hidden effects together, once the seal is open \[N m or N\].
    pub truth: Option<Vec<Vec<f64>>>,
}

impl Question for Friction {
    type Answer = OverVelocity;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<OverVelocity, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.model).ok_or("there is no such model")?;
        let runs = &recording.trajectories;
        let curves = friction::curves(&step.fitted, runs, &step.evaluation.predictions);
        let curves = curves.map_err(|error| error.to_string())?;
        let hidden = session.truth.as_ref().map(|truth| {
            let effects = |run| TrueParts::along(truth, run).map(|parts| sum_of(&parts.effects, run));
            runs.iter().map(effects).collect::<Result<Vec<_>, _>>()
        });
        let hidden = hidden.transpose().map_err(|error| error.to_string())?;
        let truth = hidden.map(|torques| friction::means(&curves, runs, &torques));
        Ok(OverVelocity { curves, truth })
    }
}

fn sum_of(parts: &[Signals], run: &Trajectory) -> Signals {
    let mut sum = Signals::zeros(run.joint_count(), run.len());
    parts.iter().for_each(|part| sum.add(part, 1.0));
    sum
}

/// How a question is asked of the memo: at once, or by a thread.
type Ask<'a, Q> = &'a dyn Fn(&mut Desk, Q) -> Option<Answer<Q>>;

/// What the models answer that are drawn over the current one, as far as it is known.
fn others<Q: Question>(desk: &mut Desk, of: impl Fn(Generation) -> Q, ask: Ask<Q>) -> Vec<Other<Q::Answer>> {
    let mut others = Vec::new();
    for (step, ink) in desk.overlaid() {
        if let Some(Ok(answer)) = ask(desk, of(step.generation)) {
            others.push(Other { name: step.name.clone(), ink, of: answer });
        }
    }
    others
}

impl Wish {
    fn question(&self, recording: &Recording, model: Generation, joint: usize) -> Sliced {
        let own = |values: &Vec<f64>, usual: f64| {
            (0..recording.joint_count()).map(|joint| values.get(joint).copied().unwrap_or(usual)).collect()
        };
        let (posture, velocity) = (own(&self.posture, 0.0), own(&self.velocity, 1.0));
        Sliced { model, joint, posture, velocity }
    }

    /// The panel of the screen.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
            return;
        };
        let (ctx, model) = (ui.ctx().clone(), step.generation);
        widgets::card(ui, "Over one joint, as far as the recording went", |ui| {
            self.controls(ui, desk, &recording);
            let joint = desk.focus.joint_of(&recording);
            let of = |model| self.question(&recording, model, joint);
            let others = others(desk, of, &|desk, question| desk.memo.later(&ctx, desk.session, question));
            match desk.memo.later(&ctx, desk.session, of(model)) {
                Some(Ok(slice)) => charts(ui, desk, figures::over_slice(&recording, &step, joint, &slice, &others)),
                other => waiting(ui, other.and_then(Result::err)),
            }
        });
        let title = format!("Neither inertia nor gravity: what is left of the {}, over velocity", recording.effort());
        widgets::card(ui, &title, |ui| {
            let of = |model| Friction { model };
            let others = others(desk, of, &|desk, question| desk.memo.later(&ctx, desk.session, question));
            match desk.memo.later(&ctx, desk.session, of(model)) {
                Some(Ok(curves)) => {
                    let text = "Friction, mostly. Shaded: where the mean of what was measured lies with 95 %, by how often that \
                                velocity was passed; pale, of one model alone: where eight of ten samples lie.";
                    ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
                    in_columns(ui, desk, figures::friction(&recording, &step, &curves, &others), LEAST_FRICTION);
                }
                other => waiting(ui, other.and_then(Result::err)),
            }
        });
        widgets::card(ui, "Let go", |ui| {
            ui.checkbox(&mut self.falls, "Let the arm go at rest in this posture, without motors and friction");
            if self.falls {
                let posture = self.question(&recording, model, desk.focus.joint_of(&recording)).posture;
                let of = |model| Falling { model, posture: posture.clone() };
                let others = others(desk, of, &|desk, question| desk.memo.later(&ctx, desk.session, question));
                match desk.memo.later(&ctx, desk.session, of(model)) {
                    Some(Ok(fall)) => charts(ui, desk, figures::falling(&recording, &step, &fall, &others)),
                    other => waiting(ui, other.and_then(Result::err)),
                }
            }
        });
        widgets::card(ui, "Along a run", |ui| {
            ui.horizontal_wrapped(|ui| {
                controls::trajectory(ui, desk);
                formula::field(ui, &mut desk.focus.own_series);
            });
            let trajectory = desk.focus.trajectory;
            let of = |model| Balanced { model, trajectory };
            let others = others(desk, of, &|desk, question| desk.memo.later(&ctx, desk.session, question));
            match desk.memo.later(&ctx, desk.session, of(model)) {
                Some(Ok(run)) => charts(ui, desk, figures::along_run(&recording, &step, trajectory, &run, &others)),
                other => waiting(ui, other.and_then(Result::err)),
            }
            formula::show(ui, desk);
        });
    }

    /// Which joint goes, and what the others do.
    fn controls(&mut self, ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
        ui.horizontal_wrapped(|ui| {
            ui.label("Goes:");
            controls::joint(ui, desk, recording);
            ui.add_space(GAP);
            widgets::weak(ui, "The others stand at");
            self.posture.resize(recording.joint_count(), 0.0);
            self.velocity.resize(recording.joint_count(), 1.0);
            for (joint, info) in recording.joints.iter().enumerate().filter(|(joint, _)| *joint != desk.focus.joint) {
                let [unit, ..] = info.kind.units();
                number(ui, &mut self.posture[joint], &format!("position of {}", info.name), unit);
            }
            ui.add_space(GAP);
            widgets::weak(ui, "c at the velocities");
            for (velocity, info) in self.velocity.iter_mut().zip(&recording.joints) {
                let [_, unit, ..] = info.kind.units();
                number(ui, velocity, &format!("velocity of {}", info.name), unit);
            }
        });
        let text = match desk.session.truth {
            Some(_) => "Wide and pale: the truth.",
            None if recording.seal.is_some() => "Once the seal is open (Ladder), the truth is drawn beside it.",
            None => "What this arm truly is nobody knows: only the model is drawn.",
        };
        ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
    }

    /// The same as figures.
    pub fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
            return Vec::new();
        };
        let (joint, trajectory, model) = (desk.focus.joint_of(&recording), desk.focus.trajectory, step.generation);
        let mut panels = Vec::new();
        let of = |model| self.question(&recording, model, joint);
        let over = others(desk, of, &|desk, question| Some(desk.memo.now(desk.session, question)));
        if let Ok(slice) = desk.memo.now(desk.session, of(model)) {
            panels.extend(figures::over_slice(&recording, &step, joint, &slice, &over));
        }
        let of = |model| Friction { model };
        let over = others(desk, of, &|desk, question| Some(desk.memo.now(desk.session, question)));
        if let Ok(curves) = desk.memo.now(desk.session, of(model)) {
            panels.extend(figures::friction(&recording, &step, &curves, &over));
        }
        if self.falls {
            let posture = self.question(&recording, model, joint).posture;
            let of = |model| Falling { model, posture: posture.clone() };
            let over = others(desk, of, &|desk, question| Some(desk.memo.now(desk.session, question)));
            if let Ok(fall) = desk.memo.now(desk.session, of(model)) {
                panels.extend(figures::falling(&recording, &step, &fall, &over));
            }
        }
        let of = |model| Balanced { model, trajectory };
        let over = others(desk, of, &|desk, question| Some(desk.memo.now(desk.session, question)));
        if let Ok(run) = desk.memo.now(desk.session, of(model)) {
            panels.extend(figures::along_run(&recording, &step, trajectory, &run, &over));
        }
        panels.extend(formula::figure(desk));
        panels
    }
}

fn number(ui: &mut Ui, value: &mut f64, spoken: &str, unit: &str) {
    let drag = ui.add(DragValue::new(value).speed(0.02).max_decimals(2).suffix(format!(" {unit}")));
    drag.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, spoken));
    drag.on_hover_text(spoken);
}

/// Charts in as many columns as there is room for: two at most, unless models are compared, whose charts are many and simple.
fn charts(ui: &mut Ui, desk: &mut Desk, panels: Vec<Panel>) {
    let is_compared = !desk.overlaid().is_empty();
    let least = if is_compared { LEAST_COMPARED } else { LEAST_CHART.max(0.4 * ui.available_width()) };
    in_columns(ui, desk, panels, least);
}

/// Charts of at least this width beside each other.
fn in_columns(ui: &mut Ui, desk: &mut Desk, panels: Vec<Panel>, least: f32) {
    let columns = ((ui.available_width() / least) as usize).clamp(1, panels.len().max(1));
    let mut panels = panels.into_iter();
    while panels.len() > 0 {
        ui.columns(columns, |columns| {
            for column in columns {
                let Some(panel) = panels.next() else { return };
                let view = PanelView::new(panel).height(CHART);
                view.show(column, &mut desk.focus.views, &mut desk.memo.decimator);
            }
        });
    }
}

fn waiting(ui: &mut Ui, problem: Option<String>) {
    match problem {
        Some(problem) => {
            ui.label(RichText::new(format!("It can't be told: {problem}.")).color(Palette::in_ui(ui).error))
        }
        None => widgets::weak(ui, "The model is being asked…"),
    };
}

/// The unit of H; none where joints of both kinds are mixed.
pub fn unit_of_mass(recording: &Recording) -> &'static str {
    let all = |kind: JointKind| recording.joints.iter().all(|joint| joint.kind == kind);
    match (all(JointKind::Revolute), all(JointKind::Prismatic)) {
        (true, _) => "kg m²",
        (_, true) => "kg",
        _ => "",
    }
}
