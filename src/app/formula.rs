//! Series of one's own: formulas of channels, such as `tau1 - predicted1` or `abs(qd2) * qd2`, as they are and behind a low-pass;
//! in a chart of their own on every screen that has charts over time, and as lines in the charts of the screens.

use std::borrow::Cow;
use std::sync::Arc;

use egui::{Context, RichText, Ui};

use super::desk::{Desk, time_extent};
use super::memo::{Answer, Memo, Question};
use super::plot::{Along, CHANNELS, OwnSeries, PanelView, series};
use super::theme::{Palette, SMALL};
use crate::effect::own::{Expression, Input};
use crate::figure::mark::Line;
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::recording::Trajectory;
use crate::recording::differentiate::low_pass;
use crate::session::{Generation, Session};
use crate::signals::Signals;

/// Height of the chart of its own \[points\].
const CHART: f32 = 170.0;
/// Between the formulas of one chart.
const BETWEEN: char = ';';
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

impl Values {
    /// As far as the low-pass lets it pass.
    fn passed(&self) -> &[f64] {
        self.smooth.as_deref().unwrap_or(&self.own)
    }
}

impl Question for Formula {
    type Answer = Values;
    const KEPT: usize = 16;

    fn answer(&self, session: &Session) -> Result<Values, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let run = recording.trajectories.get(self.trajectory).ok_or("there is no such trajectory")?;
        let step = self.model.and_then(|model| session.model_of(model));
        let predicted = step.and_then(|step| step.evaluation.predictions.get(self.trajectory));
        let predicted = predicted.map(|prediction| &prediction.total);
        let own = values(&self.series.text, &Channels { run, predicted, is_measured: true })?;
        let smooth = self.series.filter().map(|_| smoothed(&own, run, self.series.cutoff_hz)).transpose()?;
        Ok(Values { own, smooth })
    }
}

/// What a formula is of.
pub struct Channels<'a> {
    /// The motion and its torque.
    pub run: &'a Trajectory,
    /// What a model predicts there.
    pub predicted: Option<&'a Signals>,
    /// Whether the torque is that of this motion.
    pub is_measured: bool,
}

/// A formula at every sample, behind its low-pass if it has one.
///
/// # Errors
/// What is wrong with it, with its column.
pub fn along(series: &OwnSeries, channels: &Channels) -> Result<Vec<f64>, String> {
    let own = values(&series.text, channels)?;
    if series.filter().is_some() { smoothed(&own, channels.run, series.cutoff_hz) } else { Ok(own) }
}

/// A formula at every sample of a trajectory; what is wrong with it is told with its column.
fn values(text: &str, channels: &Channels) -> Result<Vec<f64>, String> {
    let Channels { run, predicted, is_measured } = *channels;
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
        let torque = || match is_measured {
            true => Ok(&run.tau[joint]),
            false => Err(told(*at, "what the arm would need here is not known")),
        };
        let model = || predicted.map(|model| &model[joint]).ok_or_else(|| told(*at, "there is no model yet"));
        let values = match &name[..digits] {
            "q" => Cow::Borrowed(&run.q[joint]),
            "qd" => Cow::Borrowed(&run.qd[joint]),
            "qdd" => Cow::Borrowed(&run.qdd[joint]),
            "tau" => Cow::Borrowed(torque()?),
            "predicted" => Cow::Borrowed(model()?),
            "residual" => Cow::Owned(torque()?.iter().zip(model()?).map(|(own, model)| own - model).collect()),
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

/// Charts over the time of the shown trajectory can have lines; those over something else are told of by their screens.
fn prepare(desk: &mut Desk, mut ask: impl FnMut(&mut Memo, Formula) -> Option<Answer<Formula>>) {
    let Desk { session, focus, memo, .. } = desk;
    focus.views.own.begin();
    let Some(recording) = &session.recording else { return };
    let (trajectory, model) = (focus.trajectory, session.current().map(|step| step.generation));
    focus.views.own.draw(Along::Time, |series| {
        let values = ask(memo, Formula { series: series.clone(), trajectory, model })?;
        let line = |values: Arc<Values>| {
            let passed = Shared::of(&values, Values::passed);
            Line::new("", series::time(recording, trajectory), passed, Ink::Text).sampled()
        };
        Some(values.map(line))
    });
}

/// Before screens are drawn: what their charts over time have of one's own.
pub fn prepare_later(ctx: &Context, desk: &mut Desk) {
    let session = desk.session;
    prepare(desk, |memo, formula| memo.later(ctx, session, formula));
}

/// The same before figures are made.
pub fn prepare_now(desk: &mut Desk) {
    let session = desk.session;
    prepare(desk, |memo, formula| Some(memo.now(session, formula)));
}

/// Where the formulas of the chart of its own and their low-pass are written.
pub fn field(ui: &mut Ui, own: &mut OwnSeries) {
    ui.label("Formula");
    own.edit(ui, "formula of channels", "Lines in a chart of their own, with ; between them");
}

/// The chart of the formulas, and what is wrong with those that are not in it.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let (ctx, asked) = (ui.ctx().clone(), asked(desk));
    let mut problem = None;
    let panel = panel(desk, &asked, |desk, formula| match desk.memo.later(&ctx, desk.session, formula) {
        Some(Err(reason)) => {
            problem.get_or_insert(reason);
            None
        }
        known => known?.ok(),
    });
    if let Some(panel) = panel {
        let view = PanelView::new(panel).height(CHART).cursor(&mut desk.focus.cursor);
        view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
    }
    if let Some(problem) = problem {
        ui.label(RichText::new(format!("{problem}.")).size(SMALL).color(Palette::in_ui(ui).error));
    }
}

/// What is wrong with a formula of the chart of its own, if something is.
pub fn problem(desk: &mut Desk) -> Option<String> {
    asked(desk).into_iter().find_map(|formula| desk.memo.now(desk.session, formula).err())
}

/// The same chart as a figure.
pub fn figure(desk: &mut Desk) -> Option<Panel> {
    let asked = asked(desk);
    panel(desk, &asked, |desk, formula| desk.memo.now(desk.session, formula).ok())
}

/// The formulas of the chart of its own.
fn asked(desk: &Desk) -> Vec<Formula> {
    let (trajectory, model) = (desk.focus.trajectory, desk.session.current().map(|step| step.generation));
    let own = &desk.focus.own_series;
    let all = own.text.split(BETWEEN).map(|text| OwnSeries { text: text.trim().to_owned(), ..*own });
    let all = all.filter(|series| !series.is_empty() && desk.session.recording.is_some());
    all.map(|series| Formula { series, trajectory, model }).collect()
}

/// The chart of those formulas that are known; `None` if none is.
fn panel(
    desk: &mut Desk,
    asked: &[Formula],
    mut ask: impl FnMut(&mut Desk, Formula) -> Option<Arc<Values>>,
) -> Option<Panel> {
    let recording = desk.session.recording.clone()?;
    let known = asked.iter().filter_map(|formula| Some((formula, ask(desk, formula.clone())?)));
    let known: Vec<(&Formula, Arc<Values>)> = known.collect();
    let run = known.first()?.0.trajectory;
    let x = Axis::new("time t", "s").range(time_extent(&recording.trajectories[run].time)).linked(Along::Time);
    let texts: Vec<&str> = asked.iter().map(|formula| formula.series.text.as_str()).collect();
    let mut panel = Panel::new(texts.join("; "), [x, Axis::default()]);
    for (number, (formula, values)) in known.iter().enumerate() {
        let text = if asked.len() == 1 { "" } else { &formula.series.text };
        let line = |name: &str, of: fn(&Values) -> &[f64]| {
            Line::new(name, series::time(&recording, run), Shared::of(values, of), Ink::Series(number)).sampled()
        };
        let own = |name: &str| line(name, |values| &values.own);
        match formula.series.filter() {
            None => panel.push(own(text)),
            Some(filter) => {
                panel.push(own(if text.is_empty() { "as it is" } else { text }).opacity(PALE));
                let name = if text.is_empty() { filter } else { format!("{text}, {filter}") };
                panel.push(line(&name, Values::passed));
            }
        }
    }
    Some(panel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels as Measured;
    use crate::signals::Signals;

    /// Two seconds of a slow wave of height 1 with a quick one of height 0.5 over it.
    fn run() -> Trajectory {
        let wave = |at: f64, hertz: f64| (std::f64::consts::TAU * hertz * at).sin();
        let time: Vec<f64> = (0..2000).map(|sample| f64::from(sample) * 1e-3).collect();
        let tau = Signals::from_fn(1, 2000, |_, n| wave(time[n], 2.0) + 0.5 * wave(time[n], 100.0));
        let still = || Signals::zeros(1, 2000);
        Trajectory::new("waves", Measured { time, q: still(), qd: still(), qdd: still(), tau }).unwrap()
    }

    #[test]
    fn a_low_pass_leaves_the_slow_part() {
        let run = run();
        let own = values("2 * tau1", &Channels { run: &run, predicted: None, is_measured: true }).unwrap();
        let smooth = smoothed(&own, &run, 15.0).unwrap();
        let far = |sample: usize| (smooth[sample] - 2.0 * (std::f64::consts::TAU * 2.0 * run.time[sample]).sin()).abs();
        assert!((200..1800).all(|sample| far(sample) < 0.02));
        assert!((200..1800).any(|sample| (own[sample] - smooth[sample]).abs() > 0.9));
    }

    #[test]
    fn what_can_not_be_drawn_says_why() {
        let run = run();
        let channels = Channels { run: &run, predicted: None, is_measured: true };
        let told = |text: &str| values(text, &channels).unwrap_err();
        assert!(told("tau1 - predicted1").contains("column 8: there is no model yet"));
        assert!(told("tau2").contains("there is no channel `tau2`"));
        let faster = Channels { is_measured: false, ..channels };
        assert!(values("qd1 + tau1", &faster).unwrap_err().contains("column 7: what the arm would need here"));
        assert!(smoothed(&[1.0, f64::NAN], &run, 15.0).unwrap_err().contains("at 0.001 s the formula has no value"));
        assert!(smoothed(&[1.0], &run, 500.0).unwrap_err().contains("half the sampling rate"));
    }
}
