//! A series of one's own: a formula of channels, such as `tau1 - predicted1` or `abs(qd2) * qd2`, as it is and behind a low-pass,
//! drawn over time on every screen that has charts over time.

use std::borrow::Cow;
use std::sync::Arc;

use egui::{DragValue, RichText, TextEdit, Ui, WidgetInfo};

use super::desk::{Desk, OwnSeries, time_extent};
use super::memo::Question;
use super::plot::{Along, PanelView, series};
use super::theme::{Palette, SMALL};
use crate::effect::own::{Expression, Input};
use crate::figure::mark::Line;
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::model::Prediction;
use crate::recording::differentiate::low_pass;
use crate::recording::{Recording, Trajectory};
use crate::session::{Generation, Session};

/// Width of the field \[points\].
const FIELD: f32 = 130.0;
/// Height of its chart \[points\].
const CHART: f32 = 170.0;
/// What a name can begin with; the joint stands behind it, counted from 1.
const CHANNELS: &str = "q1, qd1, qdd1, tau1, predicted1, residual1 (and so on by joint), and t";

/// How much of its colour a series has that is also drawn behind a low-pass.
const PALE: f64 = 0.4;

/// A formula of the channels of a trajectory and of what the current model predicts there.
#[derive(Clone, PartialEq)]
struct Formula {
    series: OwnSeries,
    trajectory: usize,
    model: Option<Generation>,
}

/// What [`Formula`] is answered with.
struct Values {
    own: Vec<f64>,
    /// Behind the low-pass, if there is one.
    smooth: Option<Vec<f64>>,
}

impl Question for Formula {
    type Answer = Values;
    const KEPT: usize = 9;

    fn answer(&self, session: &Session) -> Result<Values, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let run = recording.trajectories.get(self.trajectory).ok_or("there is no such trajectory")?;
        let predicted = session.current().and_then(|step| step.evaluation.predictions.get(self.trajectory));
        let own = values(&self.series.text, run, predicted)?;
        let smooth = (self.series.cutoff_hz > 0.0).then(|| smoothed(&own, run, self.series.cutoff_hz)).transpose()?;
        Ok(Values { own, smooth })
    }
}

/// A formula at every sample of a trajectory; what is wrong with it is told with its column.
fn values(text: &str, run: &Trajectory, predicted: Option<&Prediction>) -> Result<Vec<f64>, String> {
    let told = |at: usize, what: &str| format!("column {}: {what}", text[..at].chars().count() + 1);
    let expression = Expression::parse(text).map_err(|mistake| told(mistake.at, &mistake.what))?;
    let input = |(name, at): &(String, usize)| {
        if name == "t" {
            return Ok(Input::Series(Cow::Borrowed(&run.time[..])));
        }
        let unknown = || told(*at, &format!("there is no channel `{name}`; there are {CHANNELS}"));
        let digits = name.find(|letter: char| letter.is_ascii_digit()).ok_or_else(unknown)?;
        let joint = name[digits..].parse::<usize>().ok().and_then(|joint| joint.checked_sub(1));
        let joint = joint.filter(|joint| *joint < run.joint_count()).ok_or_else(unknown)?;
        let model = || predicted.map(|model| &model.total[joint]).ok_or_else(|| told(*at, "there is no model yet"));
        let values = match &name[..digits] {
            "q" => Cow::Borrowed(&run.q[joint]),
            "qd" => Cow::Borrowed(&run.qd[joint]),
            "qdd" => Cow::Borrowed(&run.qdd[joint]),
            "tau" => Cow::Borrowed(&run.tau[joint]),
            "predicted" => Cow::Borrowed(model()?),
            "residual" => Cow::Owned(run.tau[joint].iter().zip(model()?).map(|(own, model)| own - model).collect()),
            _ => return Err(unknown()),
        };
        Ok(Input::Series(values))
    };
    let inputs = expression.names().iter().map(input).collect::<Result<Vec<_>, String>>()?;
    Ok(expression.values(&inputs, run.len()))
}

/// Behind a low-pass without delay.
fn smoothed(values: &[f64], run: &Trajectory, cutoff_hz: f64) -> Result<Vec<f64>, String> {
    let highest = 0.5 / run.time_step();
    if cutoff_hz >= highest {
        return Err(format!("a low-pass of {cutoff_hz} Hz needs more than {highest:.0} Hz, half the sampling rate"));
    }
    if let Some(hole) = values.iter().position(|value| !value.is_finite()) {
        let time = run.time.get(hole).copied().unwrap_or(f64::NAN);
        return Err(format!("at {time:.3} s the formula has no value, which a low-pass would spread over all others"));
    }
    Ok(low_pass(values, run.time_step(), cutoff_hz))
}

/// Where the formula and its low-pass are written.
pub fn field(ui: &mut Ui, own: &mut OwnSeries) {
    let label = ui.label("Formula");
    let edit = TextEdit::singleline(&mut own.text).desired_width(FIELD).hint_text("tau1 - predicted1");
    let edit = ui.add(edit).labelled_by(label.id);
    edit.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, true, "formula of channels"));
    edit.on_hover_text(format!("A line of your own below the charts, of {CHANNELS}; abs, sign, sin, max …"));
    if !own.is_empty() {
        let cutoff = DragValue::new(&mut own.cutoff_hz).range(0.0..=1e5).speed(0.1).max_decimals(2).suffix(" Hz");
        let label = ui.label("low-pass");
        let drag = ui.add(cutoff).labelled_by(label.id);
        drag.on_hover_text("Cut-off of a fourth-order Butterworth filter run forward and backward; 0 for none");
    }
}

/// The chart of the formula, or what is wrong with it.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let Some((recording, question)) = asked(desk) else { return };
    match desk.memo.later(ui.ctx(), desk.session, question.clone()) {
        Some(Ok(values)) => {
            let view =
                PanelView::new(panel(&recording, &question, &values)).height(CHART).cursor(&mut desk.focus.cursor);
            view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        }
        Some(Err(problem)) => {
            ui.label(RichText::new(format!("{problem}.")).size(SMALL).color(Palette::in_ui(ui).error));
        }
        None => (),
    }
}

/// What is wrong with the formula, if something is.
pub fn problem(desk: &mut Desk) -> Option<String> {
    let (_, question) = asked(desk)?;
    desk.memo.now(desk.session, question).err()
}

/// The same as a figure.
pub fn figure(desk: &mut Desk) -> Option<Panel> {
    let (recording, question) = asked(desk)?;
    let values = desk.memo.now(desk.session, question.clone()).ok()?;
    Some(panel(&recording, &question, &values))
}

fn asked(desk: &Desk) -> Option<(Arc<Recording>, Formula)> {
    let recording = desk.session.recording.clone()?;
    let own = &desk.focus.own_series;
    let series = OwnSeries { text: own.text.trim().to_owned(), ..*own };
    let (trajectory, model) = (desk.focus.trajectory, desk.session.current().map(|step| step.generation));
    (!series.is_empty()).then_some((recording, Formula { series, trajectory, model }))
}

fn panel(recording: &Arc<Recording>, formula: &Formula, values: &Arc<Values>) -> Panel {
    let run = formula.trajectory;
    let x = Axis::new("time t", "s").range(time_extent(&recording.trajectories[run].time)).linked(Along::Time);
    let panel = Panel::new(&formula.series.text, [x, Axis::default()]);
    let line = |name: &str, of: fn(&Values) -> &[f64]| {
        Line::new(name, series::time(recording, run), Shared::of(values, of), Ink::Series(4)).sampled().dash(&[])
    };
    if values.smooth.is_none() {
        return panel.with(line("", |values| &values.own));
    }
    let name = format!("low-pass {} Hz", formula.series.cutoff_hz);
    let smooth = line(&name, |values| values.smooth.as_deref().unwrap_or_default());
    panel.with(line("as it is", |values| &values.own).opacity(PALE)).with(smooth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;
    use crate::signals::Signals;

    /// Two seconds of a slow wave of height 1 with a quick one of height 0.5 over it.
    fn run() -> Trajectory {
        let wave = |at: f64, hertz: f64| (std::f64::consts::TAU * hertz * at).sin();
        let time: Vec<f64> = (0..2000).map(|sample| f64::from(sample) * 1e-3).collect();
        let tau = Signals::from_fn(1, 2000, |_, n| wave(time[n], 2.0) + 0.5 * wave(time[n], 100.0));
        let still = || Signals::zeros(1, 2000);
        Trajectory::new("waves", Channels { time, q: still(), qd: still(), qdd: still(), tau }).unwrap()
    }

    #[test]
    fn a_low_pass_leaves_the_slow_part() {
        let run = run();
        let own = values("2 * tau1", &run, None).unwrap();
        let smooth = smoothed(&own, &run, 15.0).unwrap();
        let far = |sample: usize| (smooth[sample] - 2.0 * (std::f64::consts::TAU * 2.0 * run.time[sample]).sin()).abs();
        assert!((200..1800).all(|sample| far(sample) < 0.02));
        assert!((200..1800).any(|sample| (own[sample] - smooth[sample]).abs() > 0.9));
    }

    #[test]
    fn what_can_not_be_drawn_says_why() {
        let run = run();
        let told = |text: &str| values(text, &run, None).unwrap_err();
        assert!(told("tau1 - predicted1").contains("column 8: there is no model yet"));
        assert!(told("tau2").contains("there is no channel `tau2`"));
        assert!(smoothed(&[1.0, f64::NAN], &run, 15.0).unwrap_err().contains("at 0.001 s the formula has no value"));
        assert!(smoothed(&[1.0], &run, 500.0).unwrap_err().contains("half the sampling rate"));
    }
}
