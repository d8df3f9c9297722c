//! What the model has learned: mass matrix, energies, gravity and Coriolis torque over one joint, and the power along a run,
//! beside the truth where the seal is open.

use egui::{DragValue, RichText, Ui, WidgetInfo};

use super::figures;
use crate::app::desk::Desk;
use crate::app::memo::Question;
use crate::app::plot::PanelView;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::{controls, widgets};
use crate::figure::Panel;
use crate::recording::{JointKind, Recording};
use crate::session::{Generation, Session, Step};
use crate::statistics::ends;
use crate::training::inside::{Balance, Fall, Inside, Slice};

/// Height of a chart \[points\].
const CHART: f32 = 200.0;
/// Least width of a chart \[points\]; where there is room for two they stand side by side.
const LEAST_CHART: f32 = 420.0;

/// What is to be looked at.
#[derive(Default)]
pub struct Wish {
    /// Where the other joints stand \[rad or m\].
    posture: Vec<f64>,
    /// With which velocities c is asked for \[rad/s or m/s\].
    velocity: Vec<f64>,
    /// Whether the arm was let go.
    falls: bool,
}

/// The model over a slice, and the truth.
#[derive(Clone, PartialEq)]
pub struct Sliced {
    model: Generation,
    joint: usize,
    posture: Vec<f64>,
    velocity: Vec<f64>,
}

/// What [`Sliced`] is answered with.
pub struct OverSlice {
    pub own: Inside,
    /// Once the seal is open.
    pub truth: Option<Inside>,
}

impl Question for Sliced {
    type Answer = OverSlice;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<OverSlice, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.all_models().find(|step| step.generation == self.model).ok_or("there is no such model")?;
        // As far as the recording went.
        let range = ends(recording.trajectories.iter().flat_map(|run| ends(run.q[self.joint].iter().copied())));
        let Sliced { joint, posture, velocity, .. } = self.clone();
        let slice = Slice { joint, range, posture, velocity };
        let truth = session.truth.as_ref().map(|truth| Inside::of_arm(&truth.arm, &slice)).transpose();
        let truth = truth.map_err(|error| error.to_string())?;
        Ok(OverSlice { own: Inside::of_model(&step.fitted, &slice).map_err(|error| error.to_string())?, truth })
    }
}

/// The arm of the model let go in this posture, and the truth.
#[derive(Clone, PartialEq)]
pub struct Falling {
    model: Generation,
    posture: Vec<f64>,
}

/// What [`Falling`] is answered with.
pub struct Falls {
    pub own: Fall,
    /// Once the seal is open.
    pub truth: Option<Fall>,
}

impl Question for Falling {
    type Answer = Falls;

    fn answer(&self, session: &Session) -> Result<Falls, String> {
        let step = session.all_models().find(|step| step.generation == self.model).ok_or("there is no such model")?;
        let truth = session.truth.as_ref().map(|truth| Fall::of_arm(&truth.arm, &self.posture)).transpose();
        let truth = truth.map_err(|error| error.to_string())?;
        Ok(Falls { own: Fall::of_model(&step.fitted, &self.posture).map_err(|error| error.to_string())?, truth })
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
        let step = session.all_models().find(|step| step.generation == self.model).ok_or("there is no such model")?;
        let run = recording.trajectories.get(self.trajectory).ok_or("there is no such trajectory")?;
        let predicted = step.evaluation.predictions.get(self.trajectory).ok_or("it was not predicted")?;
        let truth = session.truth.as_ref().map(|truth| Balance::of_arm(&truth.arm, run)).transpose();
        let truth = truth.map_err(|error| error.to_string())?;
        let power = [&run.tau, &predicted.total].map(|torque| crate::training::inside::power(torque, run));
        Ok(AlongRun { own: Balance::of_model(&step.fitted, run).map_err(|error| error.to_string())?, truth, power })
    }
}

impl Wish {
    fn question(&self, recording: &Recording, step: &Step, joint: usize) -> Sliced {
        let own = |values: &Vec<f64>, usual: f64| {
            (0..recording.joint_count()).map(|joint| values.get(joint).copied().unwrap_or(usual)).collect()
        };
        let (posture, velocity) = (own(&self.posture, 0.0), own(&self.velocity, 1.0));
        Sliced { model: step.generation, joint, posture, velocity }
    }

    /// The panel of the screen.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
            return;
        };
        widgets::card(ui, "Over one joint, as far as the recording went", |ui| {
            self.controls(ui, desk, &recording);
            let joint = desk.focus.joint_of(&recording);
            let question = self.question(&recording, &step, joint);
            match desk.memo.later(ui.ctx(), desk.session, question) {
                Some(Ok(slice)) => charts(ui, desk, figures::over_slice(&recording, joint, &slice)),
                other => waiting(ui, other.and_then(Result::err)),
            }
        });
        widgets::card(ui, "Let go", |ui| {
            ui.checkbox(&mut self.falls, "Let the arm go at rest in this posture, without motors and friction");
            if self.falls {
                let posture = self.question(&recording, &step, desk.focus.joint_of(&recording)).posture;
                match desk.memo.later(ui.ctx(), desk.session, Falling { model: step.generation, posture }) {
                    Some(Ok(fall)) => charts(ui, desk, vec![figures::falling(&recording, &fall)]),
                    other => waiting(ui, other.and_then(Result::err)),
                }
            }
        });
        widgets::card(ui, "Along a run", |ui| {
            ui.horizontal_wrapped(|ui| controls::trajectory(ui, desk));
            let trajectory = desk.focus.trajectory;
            match desk.memo.later(ui.ctx(), desk.session, Balanced { model: step.generation, trajectory }) {
                Some(Ok(run)) => charts(ui, desk, figures::along_run(&recording, trajectory, &run)),
                other => waiting(ui, other.and_then(Result::err)),
            }
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
        let joint = desk.focus.joint_of(&recording);
        let slice = desk.memo.now(desk.session, self.question(&recording, &step, joint));
        let mut panels = slice.map_or_else(|_| Vec::new(), |slice| figures::over_slice(&recording, joint, &slice));
        if self.falls {
            let posture = self.question(&recording, &step, joint).posture;
            let fall = desk.memo.now(desk.session, Falling { model: step.generation, posture });
            panels.extend(fall.iter().map(|fall| figures::falling(&recording, fall)));
        }
        let trajectory = desk.focus.trajectory;
        let run = desk.memo.now(desk.session, Balanced { model: step.generation, trajectory });
        panels.extend(run.iter().flat_map(|run| figures::along_run(&recording, trajectory, run)));
        panels
    }
}

fn number(ui: &mut Ui, value: &mut f64, spoken: &str, unit: &str) {
    let drag = ui.add(DragValue::new(value).speed(0.02).max_decimals(2).suffix(format!(" {unit}")));
    drag.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, spoken));
    drag.on_hover_text(spoken);
}

/// Charts in as many columns as there is room for.
fn charts(ui: &mut Ui, desk: &mut Desk, panels: Vec<Panel>) {
    let columns = ((ui.available_width() / LEAST_CHART) as usize).clamp(1, 2);
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
