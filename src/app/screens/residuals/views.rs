//! The views: each draws the table in one way, and says in a sentence what it would show for which effect.

use std::sync::Arc;

use egui::{ComboBox, RichText, Ui};

use super::moments;
use super::table::{Brush, MeanMap, Quantity, Spectra, Table};
use crate::app::desk::Desk;
use crate::app::plot::{Along, Chart, Decimator, Region};
use crate::app::theme::{PREDICTED_DASH, Palette, SMALL};
use crate::app::widgets;
use crate::effect::{Effect, registry};

/// Seconds before and after the cursor that the loop shows.
const LOOP: f64 = 1.5;
/// Most effects that a sentence names.
const MOST_NAMED: usize = 2;

/// One way to look at the residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// Over a state.
    Over(Quantity),
    /// Its mean over two states, in colours.
    Map,
    /// Against velocity, along time.
    Loop,
    /// Power over frequency.
    Power,
    /// Amplitude over the order of what repeats with position.
    Orders,
    /// With itself some time later.
    Correlation,
}

/// All views, in the order in which they stand.
pub const ALL: [View; 10] = [
    View::Over(Quantity::Velocity),
    View::Over(Quantity::Position),
    View::Over(Quantity::Acceleration),
    View::Map,
    View::Over(Quantity::Load),
    View::Loop,
    View::Orders,
    View::Power,
    View::Correlation,
    View::Over(Quantity::Time),
];

/// What is marked, and of what the map is.
#[derive(Debug)]
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

/// What every view is drawn from.
pub struct Shown<'a> {
    pub table: &'a Arc<Table>,
    /// Rows of the table that are marked.
    pub lit: &'a [usize],
    /// Frequencies and past of all rows; `None` while they are computed.
    pub spectra: Option<&'a Spectra>,
    /// Frequencies and past of the marked rows; `None` if nothing is marked, or while they are computed.
    pub marked: Option<&'a Spectra>,
    /// Units of q, q̇, q̈ and τ.
    pub unit: [&'static str; 4],
}

pub fn show(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, view: View, shown: &Shown, height: f32) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "", |ui| {
        let height = (height - 100.0).max(140.0);
        match view {
            View::Over(x) => over(ui, desk, looking, x, shown, height),
            View::Map => map(ui, desk, looking, shown, height),
            View::Loop => circle(ui, desk, looking, shown, height),
            View::Power => {
                let title = "residual power by frequency";
                let axis = (Along::Frequency, "frequency", "Hz");
                curve(ui, desk, shown, title, "", axis, |spectra| &spectra.power, height);
            }
            View::Orders => {
                // A joint that slides has no turns: its orders count in as many metres as a turn has radians.
                let slides = shown.unit[0] == "m";
                let per = if slides { "order: times in 2π metres" } else { "order: times per turn of the joint" };
                let axis = (Along::Order, per, "");
                curve(
                    ui,
                    desk,
                    shown,
                    "residual amplitude by order",
                    shown.unit[3],
                    axis,
                    |spectra| &spectra.orders,
                    height,
                );
            }
            View::Correlation => {
                let axis = (Along::Lag, "lag", "s");
                curve(ui, desk, shown, "residual autocorrelation", "", axis, |spectra| &spectra.correlation, height);
            }
        }
        let follows = matches!(view, View::Power | View::Orders | View::Correlation) && shown.marked.is_some();
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
        View::Power => "A peak is a vibration or a resonance; a fall from the left is slow drift; flat is noise.",
        View::Orders => "A peak at a whole order is ripple: cogging of the motor, teeth of the gear.",
        View::Correlation => "Noise falls to 0 at once; a slow fall means that something systematic is left.",
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

/// The region of this view, if the brush is in it; and the brush after the view changed the region.
fn with_brush(looking: &mut Looking, x: Quantity, y: Quantity, draw: impl FnOnce(&mut Option<Region>)) {
    let own = looking.brush.filter(|brush| brush.x == x && brush.y == y);
    let before = own.map(|brush| brush.region);
    let mut region = before;
    draw(&mut region);
    if region != before {
        looking.brush = region.map(|region| Brush { x, y, region });
    }
}

fn over(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, x: Quantity, shown: &Shown, height: f32) {
    let palette = Palette::in_ui(ui);
    let Shown { table, lit, unit, .. } = *shown;
    let (name, label, x_unit) = x.text(unit);
    let scatter = table.scatter(x);
    let lit = points(table, lit, x, Quantity::Residual);
    with_brush(looking, x, Quantity::Residual, |region| {
        let color = palette.residual;
        let view = desk.focus.views.of(x.along(desk.focus.joint));
        Chart::new(format!("residual against {name}"), unit[3], scatter.extent)
            .x_axis(label, x_unit)
            .height(height)
            .band(&scatter.band, color.gamma_multiply(0.22))
            .points(&scatter.points, color.gamma_multiply(0.42), 1.1)
            .points(&lit, palette.accent, 1.6)
            .strong_line("mean", &scatter.mean_at, &scatter.mean, (palette.text, &[]))
            .brush(region)
            .show(ui, view, &mut desk.memo.decimator);
    });
}

/// Lit rows as points, not more than can be seen.
fn points(table: &Table, lit: &[usize], x: Quantity, y: Quantity) -> Vec<[f64; 2]> {
    let (x, y) = (table.column(x), table.column(y));
    lit.iter().step_by(lit.len().div_ceil(3000).max(1)).map(|row| [x[*row], y[*row]]).collect()
}

fn map(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, shown: &Shown, height: f32) {
    let palette = Palette::in_ui(ui);
    let Shown { table, lit, unit, .. } = *shown;
    let mut states = looking.map;
    ui.horizontal_wrapped(|ui| {
        for (state, name) in states.iter_mut().zip(["→", "↑"]) {
            let label = ui.label(name);
            let chooser = ComboBox::from_id_salt(name).selected_text(state.text(unit).0).width(104.0);
            let chooser = chooser.show_ui(ui, |ui| {
                for quantity in Quantity::STATES {
                    ui.selectable_value(state, quantity, quantity.text(unit).0);
                }
            });
            chooser.response.labelled_by(label.id);
        }
    });
    looking.map = states;
    let [x, y] = states;
    let question = MeanMap { table: Arc::clone(table), states };
    let Some(Ok(cells)) = desk.memo.later(ui.ctx(), desk.session, question) else { return };
    let (_, label, x_unit) = x.text(unit);
    let (_, _, y_unit) = y.text(unit);
    let lit = points(table, lit, x, y);
    with_brush(looking, x, y, |region| {
        let view = desk.focus.views.of(x.along(desk.focus.joint));
        Chart::new(format!("mean residual, ↑ {}", y.text(unit).0), y_unit, [0.0, 1.0])
            .x_axis(label, x_unit)
            .height(height - 30.0)
            .cells(&cells)
            .points(&lit, palette.accent, 1.2)
            .brush(region)
            .show(ui, view, &mut Decimator::default());
    });
}

/// The residual against velocity, in the order of time, around the cursor.
fn circle(ui: &mut Ui, desk: &mut Desk, looking: &mut Looking, shown: &Shown, height: f32) {
    let palette = Palette::in_ui(ui);
    let Shown { table, lit, unit, .. } = *shown;
    let row = moments::row_at_cursor(desk, table).unwrap_or(0);
    let rows = table.around(row, LOOP);
    let (x, y) = (table.column(Quantity::Velocity), table.column(Quantity::Residual));
    let path: Vec<[f64; 2]> =
        rows.clone().step_by(rows.len().div_ceil(1500).max(1)).map(|row| [x[row], y[row]]).collect();
    let ends = |[low, high]: [f64; 2], point: &[f64; 2]| [low.min(point[0]), high.max(point[0])];
    let extent = path.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    let (_, label, x_unit) = Quantity::Velocity.text(unit);
    let here = [[x[row], y[row]]];
    let lit: Vec<usize> = lit.iter().copied().filter(|row| rows.contains(row)).collect();
    let lit = points(table, &lit, Quantity::Velocity, Quantity::Residual);
    with_brush(looking, Quantity::Velocity, Quantity::Residual, |region| {
        let view = desk.focus.views.of(Along::Velocity(desk.focus.joint));
        Chart::new("residual–velocity loop around the cursor", unit[3], extent)
            .x_axis(label, x_unit)
            .height(height)
            .path(&path, palette.residual)
            .points(&lit, palette.accent, 1.6)
            .points(&here, palette.cursor, 4.0)
            .brush(region)
            .show(ui, view, &mut Decimator::default());
    });
}

/// A curve of all samples, and in front of it that of the marked region.
fn curve(
    ui: &mut Ui,
    desk: &mut Desk,
    shown: &Shown,
    title: &str,
    unit: &str,
    (along, label, x_unit): (Along, &str, &str),
    of: impl Fn(&Spectra) -> &Vec<[f64; 2]>,
    height: f32,
) {
    let palette = Palette::in_ui(ui);
    let Some(all) = shown.spectra.map(&of) else { return };
    if all.is_empty() {
        let text = format!("{}: the data are too short, or the joint hardly moves.", widgets::sentence_case(title));
        widgets::weak(ui, text);
        return;
    }
    let split = |line: &[[f64; 2]]| -> (Vec<f64>, Vec<f64>) { line.iter().map(|[x, y]| (*x, *y)).unzip() };
    let (x, y) = split(all);
    let marked = shown.marked.map(|marked| split(of(marked)));
    let title = match &marked {
        None => title.to_owned(),
        Some((x, _)) if x.is_empty() => format!("{title}: the marked region is too short"),
        Some(_) => format!("{title}: marked region"),
    };
    let mut chart = Chart::new(title, unit, [x[0], x[x.len() - 1]]).x_axis(label, x_unit).height(height);
    if along == Along::Frequency {
        chart = chart.logarithmic();
    }
    let whole = if marked.is_some() { palette.weak.gamma_multiply(0.6) } else { palette.residual };
    chart = chart.curve(if marked.is_some() { "all" } else { "" }, &x, &y, (whole, &[]));
    if let Some((x, y)) = &marked {
        chart = chart.curve("marked", x, y, (palette.residual, PREDICTED_DASH));
    }
    chart.show(ui, desk.focus.views.of(along), &mut Decimator::default());
}
