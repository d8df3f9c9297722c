//! The error in other ways: predicted against measured torque, and by joint and trajectory as a table that can be sorted.

use std::sync::Arc;

use egui::{Button, RichText, ScrollArea, Ui, WidgetInfo};

use super::figures;
use crate::app::desk::{Desk, is_held_out};
use crate::app::memo::Question;
use crate::app::plot::{PanelView, ticks};
use crate::app::theme::{GROUP, Palette, SMALL};
use crate::app::widgets;
use crate::session::{Generation, Session, Step};

/// Predicted against measured torque of every joint on held-out data: on the diagonal where the model is right.
pub fn scatter(ui: &mut Ui, desk: &mut Desk) {
    let palette = Palette::in_ui(ui);
    let panels = figures::scatter(desk);
    if panels.is_empty() {
        return;
    }
    widgets::card(ui, "Predicted against measured, held-out data", |ui| {
        let columns = if ui.available_width() > 560.0 { panels.len().clamp(1, 3) } else { 1 };
        for row in panels.chunks(columns) {
            ui.columns(columns, |columns| {
                for (ui, panel) in columns.iter_mut().zip(row) {
                    let view = PanelView::new(panel.clone()).height(200.0);
                    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
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
struct ErrorsByRun {
    model: Generation,
}

impl Question for ErrorsByRun {
    type Answer = Vec<Vec<f64>>;

    fn answer(&self, session: &Session) -> Result<Vec<Vec<f64>>, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.model).ok_or("there is no such model")?;
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
    let Some(current) = desk.session.current().cloned() else { return };
    let all: Vec<Arc<Step>> = [current].into_iter().chain(desk.overlaid().into_iter().map(|(step, _)| step)).collect();
    let mut of_models = Vec::new();
    for step in &all {
        let question = ErrorsByRun { model: step.generation };
        let Some(Ok(errors)) = desk.memo.later(ui.ctx(), desk.session, question) else { return };
        of_models.push(errors);
    }
    // Trajectories are sorted by what the current model leaves.
    let errors = &of_models[0];
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
                if all.len() > 1 {
                    ui.label(RichText::new("model").size(SMALL).color(palette.weak));
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
                    let lines =
                        |text: &dyn Fn(usize) -> String| (0..all.len()).map(text).collect::<Vec<_>>().join("\n");
                    if all.len() > 1 {
                        ui.label(lines(&|model| all[model].name.clone()));
                    }
                    for joint in 0..recording.joint_count() {
                        ui.label(lines(&|model| ticks::percent(of_models[model][run][joint])));
                    }
                    let part = if is_held_out(desk.session, run) { "held out" } else { "train" };
                    ui.label(RichText::new(part).size(SMALL).color(palette.weak));
                    ui.end_row();
                }
            });
        });
    });
}
