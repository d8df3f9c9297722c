//! A series of one's own: a formula of channels, such as `tau1 - predicted1` or `abs(qd2) * qd2`, drawn over time.

use std::borrow::Cow;
use std::sync::Arc;

use egui::{RichText, TextEdit, Ui, WidgetInfo};

use crate::app::desk::{Desk, time_extent};
use crate::app::memo::Question;
use crate::app::plot::{Along, PanelView, series};
use crate::app::theme::{Palette, SMALL};
use crate::effect::own::{Expression, Input};
use crate::figure::mark::Line;
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::recording::Recording;
use crate::session::{Generation, Session, Step};

/// Width of the field \[points\].
const FIELD: f32 = 130.0;
/// Height of its chart \[points\].
const CHART: f32 = 170.0;
/// What a name can begin with; the joint stands behind it, counted from 1.
const CHANNELS: &str = "q1, qd1, qdd1, tau1, predicted1, residual1 (and so on by joint), and t";

/// A formula of the channels of a trajectory and of what a model predicts there.
#[derive(Clone, PartialEq)]
pub struct Formula {
    pub text: String,
    pub trajectory: usize,
    pub model: Generation,
}

impl Question for Formula {
    type Answer = Vec<f64>;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<Vec<f64>, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.all_models().find(|step| step.generation == self.model).ok_or("there is no such model")?;
        let run = recording.trajectories.get(self.trajectory).ok_or("there is no such trajectory")?;
        let predicted = step.evaluation.predictions.get(self.trajectory).ok_or("it was not predicted")?;
        let told = |at: usize, what: &str| format!("column {}: {what}", self.text[..at].chars().count() + 1);
        let expression = Expression::parse(&self.text).map_err(|mistake| told(mistake.at, &mistake.what))?;
        let input = |(name, at): &(String, usize)| {
            if name == "t" {
                return Ok(Input::Series(Cow::Borrowed(&run.time[..])));
            }
            let unknown = || told(*at, &format!("there is no channel `{name}`; there are {CHANNELS}"));
            let digits = name.find(|letter: char| letter.is_ascii_digit()).ok_or_else(unknown)?;
            let joint = name[digits..].parse::<usize>().ok().and_then(|joint| joint.checked_sub(1));
            let joint = joint.filter(|joint| *joint < recording.joint_count()).ok_or_else(unknown)?;
            let values = match &name[..digits] {
                "q" => Cow::Borrowed(&run.q[joint]),
                "qd" => Cow::Borrowed(&run.qd[joint]),
                "qdd" => Cow::Borrowed(&run.qdd[joint]),
                "tau" => Cow::Borrowed(&run.tau[joint]),
                "predicted" => Cow::Borrowed(&predicted.total[joint]),
                "residual" => Cow::Owned(
                    run.tau[joint].iter().zip(&predicted.total[joint]).map(|(own, model)| own - model).collect(),
                ),
                _ => return Err(unknown()),
            };
            Ok(Input::Series(values))
        };
        let inputs = expression.names().iter().map(input).collect::<Result<Vec<_>, String>>()?;
        Ok(expression.values(&inputs, run.len()))
    }
}

/// Where the formula is written.
pub fn field(ui: &mut Ui, text: &mut String) {
    let label = ui.label("Formula");
    let edit = TextEdit::singleline(text).desired_width(FIELD).hint_text("tau1 - predicted1");
    let edit = ui.add(edit).labelled_by(label.id);
    edit.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, true, "formula of channels"));
    edit.on_hover_text(format!("A line of your own below the charts, of {CHANNELS}; abs, sign, sin, max …"));
}

/// The chart of a formula, or what is wrong with it.
pub fn show(ui: &mut Ui, desk: &mut Desk, recording: &Arc<Recording>, step: &Step, text: &str) {
    let Some(question) = asked(desk, step, text) else { return };
    match desk.memo.later(ui.ctx(), desk.session, question.clone()) {
        Some(Ok(values)) => {
            let view =
                PanelView::new(panel(recording, &question, &values)).height(CHART).cursor(&mut desk.focus.cursor);
            view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        }
        Some(Err(problem)) => {
            ui.label(RichText::new(format!("{problem}.")).size(SMALL).color(Palette::in_ui(ui).error));
        }
        None => (),
    }
}

/// The same as a figure.
pub fn figure(desk: &mut Desk, recording: &Arc<Recording>, step: &Step, text: &str) -> Option<Panel> {
    let question = asked(desk, step, text)?;
    let values = desk.memo.now(desk.session, question.clone()).ok()?;
    Some(panel(recording, &question, &values))
}

fn asked(desk: &Desk, step: &Step, text: &str) -> Option<Formula> {
    let text = text.trim().to_owned();
    let (trajectory, model) = (desk.focus.trajectory, step.generation);
    (!text.is_empty()).then_some(Formula { text, trajectory, model })
}

fn panel(recording: &Arc<Recording>, formula: &Formula, values: &Arc<Vec<f64>>) -> Panel {
    let run = formula.trajectory;
    let x = Axis::new("time t", "s").range(time_extent(&recording.trajectories[run].time)).linked(Along::Time);
    let line = Line::new("", series::time(recording, run), Shared::from(values), Ink::Series(4)).sampled();
    Panel::new(&formula.text, [x, Axis::default()]).with(line.dash(&[]))
}
