//! The views: each draws the table in one way, and says in a sentence what it would show for which effect.

use std::sync::Arc;

use egui::{Color32, ComboBox, FontId, RichText, Ui};
use serde::{Deserialize, Serialize};

use super::figures::{Curve, Shown};
use super::table::{Brush, MeanMap, Quantity};
use crate::app::desk::Desk;
use crate::app::plot::PanelView;
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::effect::{Effect, registry};
use crate::figure::Panel;

/// Most effects that a sentence names.
const MOST_NAMED: usize = 2;

/// What stands beside a map, and the least height of one of several \[points\].
const BESIDE_MAP: f32 = 80.0;
const LEAST_MAP_HEIGHT: f32 = 110.0;

/// One way to look at the residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// Over a state.
    Over(Quantity),
    /// Its mean over two states, in colours.
    Map,
    /// Against velocity, along time.
    Loop,
    /// In frequency, in what repeats, or in its own past.
    Of(Curve),
}

/// All views, in the order in which they stand.
pub const ALL: [View; 10] = [
    View::Over(Quantity::Velocity),
    View::Over(Quantity::Position),
    View::Over(Quantity::Acceleration),
    View::Map,
    View::Over(Quantity::Load),
    View::Loop,
    View::Of(Curve::Orders),
    View::Of(Curve::Power),
    View::Of(Curve::Correlation),
    View::Over(Quantity::Time),
];

/// What is marked, and of what the map is.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default)]
pub struct Looking {
    pub brush: Option<Brush>,
    /// The states of the map.
    pub map: [Quantity; 2],
}

impl Default for Looking {
    fn default() -> Self {
        Looking { brush: None, map: [Quantity::Position, Quantity::Velocity] }
    }
}

pub fn show(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, view: View, shown: &Shown, height: f32) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "", |ui| {
        let height = (height - 100.0).max(140.0);
        match view {
            View::Over(x) => {
                with_brush(ui, desk, looking, [x, Quantity::Residual], shown.over(x), height);
            }
            View::Map => map(ui, desk, looking, shown, height),
            View::Loop => {
                let states = [Quantity::Velocity, Quantity::Residual];
                with_brush(ui, desk, looking, states, shown.around_cursor(), height);
            }
            View::Of(curve) => curved(ui, desk, curve, shown, height),
        }
        let follows = matches!(view, View::Of(_)) && shown.marked.is_some();
        let of = if follows { " Strong: the marked region alone; pale: all samples." } else { "" };
        ui.label(RichText::new(format!("{}{of}", sentence(view))).size(SMALL).color(palette.weak));
    });
}

/// What the view would show, and for which effects.
fn sentence(view: View) -> String {
    match view {
        View::Over(Quantity::Load) => {
            "A cone that opens with the load is friction that grows with it; a tilted line is a wrong torque constant."
        }
        View::Over(Quantity::Time) => {
            "A slope or a step is something that changed while recording, such as temperature."
        }
        View::Over(x) => return fingerprints(x),
        View::Map => "Stripes along one axis: an effect of that state alone. Patches: one that needs both.",
        View::Loop => {
            "A line is an effect of velocity alone; an open loop is a lag, a hysteresis, or an elastic drive."
        }
        View::Of(Curve::Power) => {
            "A peak is a vibration or a resonance; a fall from the left is slow drift; flat is noise."
        }
        View::Of(Curve::Orders) => "A peak at a whole order is ripple: cogging of the motor, teeth of the gear.",
        View::Of(Curve::Correlation) => {
            "Noise falls to 0 at once; a slow fall means that something systematic is left."
        }
    }
    .to_owned()
}

/// What the effects that show best over a state look like, from their own files.
fn fingerprints(x: Quantity) -> String {
    let here: Vec<&Effect> = registry::ALL.iter().copied().filter(|effect| Quantity::from(effect.axis) == x).collect();
    let texts: Vec<String> = here
        .iter()
        .take(MOST_NAMED)
        .map(|effect| format!("{}: {}", widgets::sentence_case(effect.name), look(effect.fingerprint)))
        .collect();
    texts.join(" ")
}

/// The part of a fingerprint after the name of the view, which is this view.
fn look(fingerprint: &str) -> &str {
    match fingerprint.split_once(": ") {
        Some((view, look)) if view.starts_with("Residual against") => look,
        _ => fingerprint,
    }
}

/// Draws a view whose region can be marked.
fn with_brush(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, [x, y]: [Quantity; 2], panel: Panel, height: f32) {
    let own = looking.brush.filter(|brush| brush.x == x && brush.y == y);
    let before = own.map(|brush| brush.region);
    let mut region = before;
    let view = PanelView::new(panel).height(height).brush(&mut region);
    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
    if region != before {
        looking.brush = region.map(|region| Brush { x, y, region });
    }
}

fn map(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, shown: &Shown, height: f32) {
    let mut states = looking.map;
    ui.horizontal_wrapped(|ui| {
        for (state, name) in states.iter_mut().zip(["→", "↑"]) {
            let label = ui.label(name);
            let chooser = ComboBox::from_id_salt(name).selected_text(state.text(shown.unit).0).width(104.0);
            let chooser = chooser.show_ui(ui, |ui| {
                for quantity in Quantity::STATES {
                    ui.selectable_value(state, quantity, quantity.text(shown.unit).0);
                }
            });
            chooser.response.labelled_by(label.id);
        }
    });
    // What others have over these states is known in the next frame.
    let states = std::mem::replace(&mut looking.map, states);
    let question = MeanMap { table: Arc::clone(shown.table), states };
    let Some(Ok(cells)) = desk.memo.later(ui.ctx(), desk.session, question) else { return };
    let panels = shown.maps(states, &cells);
    // As many beside each other as leave room for the name of each.
    let font = FontId::proportional(SMALL);
    let width =
        |panel: &Panel| ui.painter().layout_no_wrap(panel.heading(), font.clone(), Color32::PLACEHOLDER).size().x;
    let widest = panels.iter().map(width).fold(0.0, f32::max);
    let columns = ((ui.available_width() / (widest + BESIDE_MAP)) as usize).clamp(1, panels.len());
    let height = ((height - 30.0) / panels.len().div_ceil(columns) as f32).max(LEAST_MAP_HEIGHT);
    let mut panels = panels.into_iter();
    while panels.len() > 0 {
        ui.columns(columns, |columns| {
            for (ui, panel) in columns.iter_mut().zip(&mut panels) {
                with_brush(ui, desk, looking, states, panel, height);
            }
        });
    }
}

fn curved(ui: &mut Ui, desk: &mut Desk, curve: Curve, shown: &Shown, height: f32) {
    if shown.spectra.is_none() {
        return;
    }
    match shown.curve(curve) {
        Some(panel) => {
            PanelView::new(panel).height(height).show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
        }
        None => {
            let title = widgets::sentence_case(curve.title());
            widgets::weak(ui, format!("{title}: the data are too short, or the joint hardly moves."));
        }
    }
}
