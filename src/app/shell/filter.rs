//! What a log does not measure is the slope of what it does: behind which filter, in the import assistant, raw and filtered over each
//! other.

use egui::{DragValue, Role as Spoken, Ui, WidgetInfo};

use super::frame::Shell;
use crate::app::plot::{PanelView, ticks};
use crate::app::widgets;
use crate::figure::mark::Line;
use crate::figure::{Axis, Ink, Panel};
use crate::recording::differentiate::{
    central_difference, default_cutoff, default_cutoff_of_positions, low_pass, median_step,
};
use crate::recording::mapping::{Channel, Draft};
use crate::recording::noise_filter::{Advice, Sampled};
use crate::recording::read::Preview;

/// How much of its colour the raw slope has.
const PALE: f64 = 0.4;

/// The filter, as it is set, and what it makes.
pub struct Filter {
    /// Cut-off \[Hz\]; 0 as suits the motion.
    cutoff_hz: f64,
    /// What was drawn last, and of what.
    drawn: Option<(Asked, Option<Slope>)>,
}

/// Of what a slope is drawn.
#[derive(Clone, PartialEq)]
struct Asked {
    draft: Draft,
    shown: usize,
    cutoff_hz: f64,
}

/// The slope of a signal.
struct Slope {
    /// What it is: `velocity` or `acceleration`, and in what.
    name: &'static str,
    unit: &'static str,
    /// Counted from 1.
    joint: usize,
    time: Vec<f64>,
    raw: Vec<f64>,
    filtered: Vec<f64>,
    cutoff_hz: f64,
    /// What the noise of the log asks for.
    advice: Option<Advice>,
}

impl Filter {
    /// With the cut-off that was stated before, if one was.
    pub fn new(stated: Option<f64>) -> Self {
        Filter { cutoff_hz: stated.unwrap_or(0.0), drawn: None }
    }

    /// The cut-off that is stated \[Hz\]; `None` where it is to suit the motion.
    pub fn cutoff_hz(&self) -> Option<f64> {
        (self.cutoff_hz > 0.0).then_some(self.cutoff_hz)
    }

    /// Asks for it where something is derived, and draws what it does to the joint of the shown column.
    pub fn ask(&mut self, ui: &mut Ui, shell: &mut Shell, draft: &Draft, preview: &Preview, shown: usize) {
        let Some(derived) = derived(draft) else { return };
        let asked = Asked { draft: draft.clone(), shown, cutoff_hz: self.cutoff_hz };
        if self.drawn.as_ref().is_none_or(|(of, _)| *of != asked) {
            let slope = slope(draft, preview, shown, self.cutoff_hz());
            self.drawn = Some((asked, slope));
        }
        let slope = self.drawn.as_ref().and_then(|(_, slope)| slope.as_ref());
        ui.horizontal_wrapped(|ui| {
            let label = ui.label(format!("{derived} derived, behind a low-pass of"));
            let field = DragValue::new(&mut self.cutoff_hz).range(0.0..=1e5).speed(0.1).max_decimals(2).suffix(" Hz");
            let field = ui.add(field).labelled_by(label.id);
            field.widget_info(|| WidgetInfo::labeled(Spoken::SpinButton, true, "cut-off of derived channels"));
            field.on_hover_text("A fourth-order Butterworth filter run forward and backward, without delay");
            if self.cutoff_hz == 0.0 {
                let suits = slope.map_or(String::new(), |slope| format!(", {} Hz", ticks::short(slope.cutoff_hz)));
                widgets::weak(ui, format!("0: as suits the motion{suits}"));
            }
        });
        if let Some(advice) = slope.and_then(|slope| slope.advice) {
            ui.horizontal_wrapped(|ui| {
                let before = match advice.told_hz() {
                    Some(hertz) => {
                        if ui.button(format!("Take {hertz} Hz")).clicked() {
                            self.cutoff_hz = hertz;
                        }
                        "as the noise asks for"
                    }
                    None => "No cut-off is asked for",
                };
                widgets::weak(ui, format!("{before}: {}.", advice.reason()));
            });
        }
        if let Some(slope) = slope {
            let view = PanelView::new(slope.panel()).height(150.0);
            view.show(ui, &mut shell.desk.focus.views, &mut shell.desk.memo.decimator);
        }
    }
}

/// What is not measured, as the beginning of a sentence; `None` if all is.
fn derived(draft: &Draft) -> Option<&'static str> {
    let has = |channel| draft.columns.iter().any(|role| role.channel == Some(channel));
    match (has(Channel::Velocity), has(Channel::Acceleration)) {
        _ if !has(Channel::Position) => None,
        (true, true) => None,
        (true, false) => Some("Acceleration is"),
        (false, true) => Some("Velocity is"),
        (false, false) => Some("Velocity and acceleration are"),
    }
}

/// The slope of what is differentiated first, of the joint of a column, and what its noise asks for; `None` without a clock, or where
/// numbers are missing.
fn slope(draft: &Draft, preview: &Preview, shown: usize, cutoff_hz: Option<f64>) -> Option<Slope> {
    let joint = draft.columns.get(shown).filter(|role| role.of_joint().is_some()).map_or(0, |role| role.joint);
    let sampled = Sampled::derived_from(draft, preview)?;
    let advice = sampled.advice();
    let Sampled { time, q, qd } = sampled;
    let step = median_step(&time);
    let cutoff_hz = match (cutoff_hz, &qd) {
        (Some(stated), _) => stated,
        (None, None) => default_cutoff_of_positions(&q, &time),
        (None, Some(qd)) => default_cutoff(&q, qd, step),
    };
    let measured = qd.as_ref().unwrap_or(&q);
    let joint = if joint < measured.joint_count() { joint } else { 0 };
    let raw = central_difference(&measured[joint], &time);
    let slides = draft.columns.iter().any(|role| role.channel == Some(Channel::Position) && role.unit.ends_with('m'));
    let (name, unit) = match (qd.is_none(), slides) {
        (true, false) => ("velocity", "rad/s"),
        (true, true) => ("velocity", "m/s"),
        (false, false) => ("acceleration", "rad/s²"),
        (false, true) => ("acceleration", "m/s²"),
    };
    let filtered = low_pass(&raw, step, cutoff_hz);
    Some(Slope { name, unit, joint: joint + 1, filtered, time, raw, cutoff_hz, advice })
}

impl Slope {
    fn panel(&self) -> Panel {
        let axes = [Axis::new("time t", "s"), Axis::new("", self.unit)];
        let line =
            |name: String, values: &[f64], ink: Ink| Line::new(name, self.time.clone(), values.to_vec(), ink).sampled();
        let filter = format!("low-pass {} Hz", ticks::short(self.cutoff_hz));
        Panel::new(format!("{} of joint {}, derived", self.name, self.joint), axes)
            .with(line("raw".to_owned(), &self.raw, Ink::Measured).opacity(PALE))
            .with(line(filter, &self.filtered, Ink::Predicted))
    }
}
