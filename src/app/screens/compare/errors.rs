//! The error in other ways: predicted against measured torque, and by joint and trajectory as a table that can be sorted.

use egui::{Button, RichText, ScrollArea, Ui, WidgetInfo};

use crate::app::desk::{Desk, is_held_out};
use crate::app::memo::Question;
use crate::app::plot::{Along, Chart, Decimator, ticks};
use crate::app::theme::{GROUP, Palette, SMALL};
use crate::app::widgets;
use crate::session::Session;

/// Most points of one plot.
const MOST_POINTS: usize = 2500;

/// Predicted against measured torque of every joint on held-out data: on the diagonal where the model is right.
pub fn scatter(ui: &mut Ui, desk: &mut Desk) {
    let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
        return;
    };
    let palette = Palette::in_ui(ui);
    let samples: usize = desk.session.split.held_out.iter().map(|segment| segment.samples.len()).sum();
    if samples == 0 {
        return;
    }
    let every = samples.div_ceil(MOST_POINTS).max(1);
    widgets::card(ui, "Predicted against measured, held-out data", |ui| {
        let joints: Vec<usize> = (0..recording.joint_count()).collect();
        let columns = if ui.available_width() > 560.0 { joints.len().clamp(1, 3) } else { 1 };
        for row in joints.chunks(columns) {
            ui.columns(columns, |columns| {
                for (ui, &joint) in columns.iter_mut().zip(row) {
                    let mut points = Vec::with_capacity(MOST_POINTS);
                    for segment in &desk.session.split.held_out {
                        let measured = &recording.trajectories[segment.trajectory].tau[joint];
                        let predicted = &step.evaluation.predictions[segment.trajectory].total[joint];
                        points.extend(segment.samples.clone().step_by(every).map(|n| [measured[n], predicted[n]]));
                    }
                    let ends = |[low, high]: [f64; 2], point: &[f64; 2]| [low.min(point[0]), high.max(point[0])];
                    let extent = points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
                    let unit = recording.joints[joint].kind.units()[3];
                    Chart::new(format!("{}: τ̂", recording.joints[joint].name), unit, extent)
                        .x_axis("measured τ", unit)
                        .height(200.0)
                        .curve("", &extent, &extent, (palette.weak, &[3.0, 3.0]))
                        .points(&points, palette.predicted.gamma_multiply(0.6), 1.2)
                        .show(ui, desk.focus.views.of(Along::Load(joint)), &mut Decimator::default());
                }
            });
        }
        let text =
            "Dotted: perfect. A cloud beside the line is an offset, another slope a wrong size, two clouds a friction.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
}

/// nMSE of each trajectory and joint: `errors[trajectory][joint]`.
#[derive(Clone, PartialEq)]
struct ErrorsByRun;

impl Question for ErrorsByRun {
    type Answer = Vec<Vec<f64>>;

    fn answer(&self, session: &Session) -> Result<Vec<Vec<f64>>, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.current().ok_or("there is no model")?;
        let error = |run: usize, joint: usize| {
            let (tau, model) =
                (&recording.trajectories[run].tau[joint], &step.evaluation.predictions[run].total[joint]);
            let squares: f64 = tau.iter().zip(model).map(|(tau, model)| (tau - model).powi(2)).sum();
            squares / tau.iter().map(|tau| tau * tau).sum::<f64>()
        };
        let joints = recording.joint_count();
        let runs = 0..recording.trajectories.len();
        Ok(runs.map(|run| (0..joints).map(|joint| error(run, joint)).collect()).collect())
    }
}

/// The joint by whose error trajectories are sorted, and whether the largest comes first; `None` leaves them as recorded.
pub type Sorting = Option<(usize, bool)>;

/// nMSE by trajectory and joint; a click on a head sorts, on a name shows that trajectory.
pub fn by_trajectory(ui: &mut Ui, desk: &mut Desk, sorting: &mut Sorting) {
    let Some(recording) = desk.session.recording.clone() else { return };
    let palette = Palette::in_ui(ui);
    let Some(Ok(errors)) = desk.memo.later(ui.ctx(), desk.session, ErrorsByRun) else { return };
    widgets::card(ui, "Error by trajectory and joint (nMSE)", |ui| {
        let mut order: Vec<usize> = (0..errors.len()).collect();
        if let Some((joint, down)) = *sorting {
            let error = |run: usize| errors[run].get(joint).copied().unwrap_or(f64::NAN);
            order.sort_by(|one, other| error(*one).total_cmp(&error(*other)));
            if down {
                order.reverse();
            }
        }
        ScrollArea::horizontal().id_salt("errors by trajectory").show(ui, |ui| {
            egui::Grid::new("errors by trajectory").striped(true).spacing([GROUP, 4.0]).show(ui, |ui| {
                if ui.add(Button::new("trajectory").small()).on_hover_text("In the order of the recording").clicked() {
                    *sorting = None;
                }
                for (joint, info) in recording.joints.iter().enumerate() {
                    let mark = match *sorting {
                        Some((own, down)) if own == joint => {
                            if down {
                                " ↓"
                            } else {
                                " ↑"
                            }
                        }
                        _ => "",
                    };
                    let head = ui.add(Button::new(format!("{}{mark}", info.name)).small());
                    let spoken = format!("sort by the error of {}", info.name);
                    head.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &spoken));
                    if head.on_hover_text(&spoken).clicked() {
                        let down = sorting.is_none_or(|(own, down)| own != joint || !down);
                        *sorting = Some((joint, down));
                    }
                }
                ui.label(RichText::new("part").size(SMALL).color(palette.weak));
                ui.end_row();
                for run in order {
                    let name = &recording.trajectories[run].name;
                    if ui.selectable_label(desk.focus.trajectory == run, name).clicked() {
                        desk.focus.show_trajectory(run);
                    }
                    for error in &errors[run] {
                        ui.label(ticks::percent(*error));
                    }
                    let part = if is_held_out(desk.session, run) { "held out" } else { "train" };
                    ui.label(RichText::new(part).size(SMALL).color(palette.weak));
                    ui.end_row();
                }
            });
        });
    });
}
