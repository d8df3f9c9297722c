//! The error in other ways: predicted against measured torque, and by joint and trajectory as a table that can be sorted.

use egui::{Button, RichText, ScrollArea, Ui, WidgetInfo};

use crate::app::plot::{Along, Chart, Decimator, ticks};
use crate::app::state::Desk;
use crate::app::theme::{GROUP, Palette, SMALL};
use crate::app::widgets;

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
                        .show(ui, desk.state.views.of(Along::Load(joint)), &mut Decimator::default());
                }
            });
        }
        let text =
            "Dotted: perfect. A cloud beside the line is an offset, another slope a wrong size, two clouds a friction.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
}

/// nMSE by trajectory and joint; a click on a head sorts, on a name shows that trajectory.
pub fn by_trajectory(ui: &mut Ui, desk: &mut Desk) {
    let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
        return;
    };
    let palette = Palette::in_ui(ui);
    let errors = desk.state.errors_by_run(&recording, &step);
    widgets::card(ui, "Error by trajectory and joint (nMSE)", |ui| {
        let mut order: Vec<usize> = (0..errors.len()).collect();
        if let Some((joint, down)) = desk.state.error_order {
            let error = |run: usize| errors[run].get(joint).copied().unwrap_or(f64::NAN);
            order.sort_by(|one, other| error(*one).total_cmp(&error(*other)));
            if down {
                order.reverse();
            }
        }
        ScrollArea::horizontal().id_salt("errors by trajectory").show(ui, |ui| {
            egui::Grid::new("errors by trajectory").striped(true).spacing([GROUP, 4.0]).show(ui, |ui| {
                if ui.add(Button::new("trajectory").small()).on_hover_text("In the order of the recording").clicked() {
                    desk.state.error_order = None;
                }
                for (joint, info) in recording.joints.iter().enumerate() {
                    let mark = match desk.state.error_order {
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
                        let down = desk.state.error_order.is_none_or(|(own, down)| own != joint || !down);
                        desk.state.error_order = Some((joint, down));
                    }
                }
                ui.label(RichText::new("part").size(SMALL).color(palette.weak));
                ui.end_row();
                for run in order {
                    let name = &recording.trajectories[run].name;
                    if ui.selectable_label(desk.state.trajectory == run, name).clicked() {
                        desk.state.show_trajectory(run);
                    }
                    for error in &errors[run] {
                        ui.label(ticks::percent(*error));
                    }
                    let part = if crate::app::screens::is_held_out(desk.session, run) { "held out" } else { "train" };
                    ui.label(RichText::new(part).size(SMALL).color(palette.weak));
                    ui.end_row();
                }
            });
        });
    });
}
