//! How the simulated arm is moved: the kind of motion, how much of it, how fast.

use egui::{ComboBox, DragValue, Grid, Ui};

use crate::simulation::{Excitation, Scenario};

pub fn show(ui: &mut Ui, motion: &mut Excitation) {
    let kinds =
        [("sums of sines", Scenario::embedded().motion), ("point to point, as in the paper", few(Excitation::paper()))];
    let same = |one: &Excitation, other: &Excitation| std::mem::discriminant(one) == std::mem::discriminant(other);
    let current = kinds.iter().find(|(_, kind)| same(kind, motion)).map_or("as given", |(name, _)| name);
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Motion");
        let chooser = ComboBox::from_id_salt("motion").selected_text(current).width(190.0).show_ui(ui, |ui| {
            for (name, kind) in &kinds {
                if ui.selectable_label(same(kind, motion), *name).clicked() && !same(kind, motion) {
                    *motion = kind.clone();
                }
            }
        });
        chooser.response.labelled_by(label.id);
    });
    Grid::new("motion").spacing([8.0, 4.0]).show(ui, |ui| match motion {
        Excitation::MultiSine { trajectories, duration, rate, max_position, max_velocity, .. } => {
            count(ui, "Runs", trajectories);
            number(ui, "Seconds of each", duration);
            number(ui, "Samples per second", rate);
            number(ui, "Largest |q| [rad]", max_position);
            number(ui, "Largest |q̇| [rad/s]", max_velocity);
        }
        Excitation::PaperPointToPoint { trajectories, duration, samples, range } => {
            count(ui, "Runs", trajectories);
            number(ui, "Seconds of each", duration);
            count(ui, "Samples of each", samples);
            number(ui, "Largest |q| [rad]", range);
        }
        Excitation::SuperposedSines { trajectories, duration, rate, .. }
        | Excitation::Stops { trajectories, duration, rate, .. } => {
            count(ui, "Runs", trajectories);
            number(ui, "Seconds of each", duration);
            number(ui, "Samples per second", rate);
        }
    });
}

/// The paper's motion with as many runs as a look at it needs.
fn few(motion: Excitation) -> Excitation {
    match motion {
        Excitation::PaperPointToPoint { duration, samples, range, .. } => {
            Excitation::PaperPointToPoint { trajectories: 20, duration, samples, range }
        }
        other => other,
    }
}

fn count(ui: &mut Ui, name: &str, value: &mut usize) {
    let label = ui.label(name);
    ui.add(DragValue::new(value).range(1..=100_000)).labelled_by(label.id);
    ui.end_row();
}

fn number(ui: &mut Ui, name: &str, value: &mut f64) {
    let label = ui.label(name);
    let speed = 0.02 * value.abs().max(0.01);
    ui.add(DragValue::new(value).speed(speed).range(0.001..=1e6).max_decimals(3)).labelled_by(label.id);
    ui.end_row();
}
