//! Where it fails: the residual of one joint over time, position, velocity and acceleration.

use std::sync::Arc;

use egui::{Align, Color32, Layout, RichText, ScrollArea, Ui, vec2};

use super::data::units;
use crate::app::plot::{Chart, Window};
use crate::app::shell::thousands;
use crate::app::state::Desk;
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::widgets;
use crate::diagnosis::evidence;
use crate::effect::{Axis, Spec, registry};
use crate::recording::Recording;
use crate::recording::split::Segment;
use crate::session::Session;

/// Most points that one plot draws; the text says how many there are.
const MOST_POINTS: usize = 4000;
/// Columns in which mean and spread are computed.
const COLUMNS: usize = 48;
/// Columns with fewer samples than this show no mean.
const FEWEST_IN_COLUMN: usize = 8;

/// A residual over a state, ready to be drawn.
pub struct Scatter {
    points: Vec<[f64; 2]>,
    samples: usize,
    extent: [f64; 2],
    mean_at: Vec<f64>,
    mean: Vec<f64>,
    band: Vec<[f64; 3]>,
}

pub(super) fn show(ui: &mut Ui, desk: &mut Desk) {
    let Some(recording) = desk.session.recording.clone() else { return };
    let palette = Palette::in_ui(ui);
    widgets::headline(
        ui,
        "Where the model fails",
        "What is left of the torque, measured minus predicted. Noise looks the same everywhere; a missing effect has a shape.",
    );
    ui.horizontal_wrapped(|ui| {
        desk.state.joint = desk.state.joint.min(recording.joint_count().saturating_sub(1));
        for (joint, info) in recording.joints.iter().enumerate() {
            ui.selectable_value(&mut desk.state.joint, joint, &info.name);
        }
        ui.add_space(GROUP);
        ui.selectable_value(&mut desk.state.held_out_only, true, "Held-out data");
        ui.selectable_value(&mut desk.state.held_out_only, false, "Training data");
        ui.add_space(GROUP);
        let text = "Line: mean by column. Band: ± one standard deviation. Points: samples.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
    ui.add_space(4.0);
    ScrollArea::vertical().id_salt("residuals").auto_shrink(false).show(ui, |ui| {
        let (width, height) = (ui.available_width(), ui.available_height());
        let size = vec2((width - GROUP) / 2.0, ((height - GAP * 3.0) / 2.0).max(270.0));
        for pair in [[Axis::Velocity, Axis::Position], [Axis::Acceleration, Axis::Time]] {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GROUP;
                for axis in pair {
                    ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
                        view(ui, desk, &recording, axis, size.y)
                    });
                }
            });
        }
    });
}

fn view(ui: &mut Ui, desk: &mut Desk, recording: &Recording, axis: Axis, height: f32) {
    let palette = Palette::in_ui(ui);
    let joint = desk.state.joint;
    let key = (joint, axis, desk.state.held_out_only);
    let scatter = match desk.state.scatters.get(&key) {
        Some(scatter) => Arc::clone(scatter),
        None => {
            let scatter = Arc::new(Scatter::new(desk.session, recording, key));
            desk.state.scatters.insert(key, Arc::clone(&scatter));
            scatter
        }
    };
    let unit = units(recording.joints[joint].kind);
    let (name, label, x_unit) = axis_text(axis, unit);
    widgets::card(ui, "", |ui| {
        if scatter.samples == 0 {
            widgets::weak(ui, "No samples in this part of the data.");
            return;
        }
        let color = palette.residual;
        let chart =
            Chart::new(format!("{}: residual against {name}", recording.joints[joint].name), unit[3], scatter.extent)
                .x_axis(label, x_unit)
                .height((height - 74.0).max(170.0))
                .band(&scatter.band, color.gamma_multiply(0.22))
                .points(&scatter.points, color.gamma_multiply(0.42), 1.1)
                .strong_line("mean", &scatter.mean_at, &scatter.mean, (palette.text, &[]));
        chart.show(ui, &mut Window::default(), &mut desk.state.decimator);
        let shown = if scatter.points.len() < scatter.samples {
            format!("{} of {} samples drawn. ", thousands(scatter.points.len()), thousands(scatter.samples))
        } else {
            String::new()
        };
        let text = format!("{shown}{}", fingerprints(axis));
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
}

/// Name, label and unit of an axis.
pub(super) fn axis_text(axis: Axis, unit: [&'static str; 4]) -> (&'static str, &'static str, &'static str) {
    match axis {
        Axis::Time => ("time", "time t, all trajectories end to end", "s"),
        Axis::Position => ("position", "position q", unit[0]),
        Axis::Velocity => ("velocity", "velocity q̇", unit[1]),
        Axis::Acceleration => ("acceleration", "acceleration q̈", unit[2]),
    }
}

/// What the effects that show best here look like, from their own files.
fn fingerprints(axis: Axis) -> String {
    let here: Vec<&Spec> = registry::ALL.iter().map(|effect| effect.spec()).filter(|spec| spec.axis == axis).collect();
    let texts: Vec<String> =
        here.iter().map(|spec| format!("{}: {}", sentence_case(spec.name), look(spec.fingerprint))).collect();
    if texts.is_empty() {
        return "A drift or a step would show here: something that changed during the recording, such as temperature."
            .to_owned();
    }
    texts.join(" ")
}

/// The part of a fingerprint after the name of the view, which is this view.
fn look(fingerprint: &str) -> &str {
    match fingerprint.split_once(": ") {
        Some((view, look)) if view.starts_with("Residual against") => look,
        _ => fingerprint,
    }
}

fn sentence_case(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

impl Scatter {
    fn new(session: &Session, recording: &Recording, (joint, axis, held_out): (usize, Axis, bool)) -> Self {
        let segments = if held_out { &session.split.held_out } else { &session.split.train };
        let points = residual_over(session, recording, segments, joint, axis);
        let every = points.len().div_ceil(MOST_POINTS).max(1);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for [x, _] in &points {
            (low, high) = (low.min(*x), high.max(*x));
        }
        let width = (high - low) / COLUMNS as f64;
        let mut sums = vec![[0.0; 3]; COLUMNS];
        for [x, residual] in &points {
            let column = (((x - low) / width.max(1e-300)) as usize).min(COLUMNS - 1);
            let sum = &mut sums[column];
            *sum = [sum[0] + 1.0, sum[1] + residual, sum[2] + residual * residual];
        }
        let (mut mean_at, mut means, mut band) = (Vec::new(), Vec::new(), Vec::new());
        for (column, [count, sum, squares]) in sums.into_iter().enumerate() {
            if count < FEWEST_IN_COLUMN as f64 {
                continue;
            }
            let (x, mean) = (low + (column as f64 + 0.5) * width, sum / count);
            let spread = (squares / count - mean * mean).max(0.0).sqrt();
            mean_at.push(x);
            means.push(mean);
            band.push([x, mean - spread, mean + spread]);
        }
        let samples = points.len();
        let points = points.into_iter().step_by(every).collect();
        Scatter {
            points,
            samples,
            extent: if samples == 0 { [0.0, 1.0] } else { [low, high] },
            mean_at,
            mean: means,
            band,
        }
    }
}

/// Residual of one joint over a state, of all finite samples in `segments`. Times go on from one trajectory to the next.
fn residual_over(
    session: &Session,
    recording: &Recording,
    segments: &[Segment],
    joint: usize,
    axis: Axis,
) -> Vec<[f64; 2]> {
    let Some(step) = session.current() else { return Vec::new() };
    let mut points = Vec::new();
    let mut elapsed = 0.0;
    for segment in segments {
        let (Some(run), Some(prediction)) =
            (recording.trajectories.get(segment.trajectory), step.evaluation.predictions.get(segment.trajectory))
        else {
            continue;
        };
        let state = evidence::state(run, axis, joint);
        let start = run.time.get(segment.samples.start).copied().unwrap_or(0.0);
        for sample in segment.samples.clone() {
            let x = if axis == Axis::Time { elapsed + run.time[sample] - start } else { state[sample] };
            let residual = run.tau[joint][sample] - prediction.total[joint][sample];
            if x.is_finite() && residual.is_finite() {
                points.push([x, residual]);
            }
        }
        let last = segment.samples.end.saturating_sub(1);
        elapsed += run.time.get(last).map_or(0.0, |time| time - start);
    }
    points
}

/// A colour for points, thin enough to see their density.
pub(super) fn point_color(color: Color32) -> Color32 {
    color.gamma_multiply(0.5)
}
