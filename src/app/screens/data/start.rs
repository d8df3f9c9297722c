//! What stands here before anything was recorded: three ways to begin, what one can go on with, and the gallery.

use std::f64::consts::FRAC_PI_2;

use egui::{Align, Layout, Ui};

use super::{gallery, recent};
use crate::app::desk::{Desk, Order};
use crate::app::plot::{PanelView, arm};
use crate::app::widgets;
use crate::figure::Panel;
use crate::recording::read::READABLE;
use crate::session::Command;
use crate::simulation::Scenario;

/// Least width of a card \[points\]; where there is no room for three beside each other they stand below each other.
const LEAST_CARD: f32 = 190.0;
/// Least height of a card beside others, without its title \[points\].
const CARD: f32 = 290.0;
/// Height of the drawing of the arm \[points\].
const DRAWING: f32 = 150.0;
/// How far the joints of the arm are turned \[rad\], so that all links are seen.
const TURNED: [f64; 3] = [0.35 * FRAC_PI_2, 0.5 * FRAC_PI_2, -0.6 * FRAC_PI_2];

/// A way to begin: its title, and its card.
type Way = (&'static str, fn(&mut Ui, &mut Desk));

const WAYS: [Way; 3] = [("Find what hides in this arm", mystery), ("Open your log", log), ("Learn", lessons)];

/// Three ways to begin; below them what was opened of late, and recordings to try.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let sentence = "A robot arm's model against its measurements: see where it fails, and learn what is missing.";
    widgets::headline(ui, "Where do you want to begin?", sentence);
    let has_room = ui.available_width() > WAYS.len() as f32 * LEAST_CARD;
    ui.columns(if has_room { WAYS.len() } else { 1 }, |columns| {
        let count = columns.len();
        for (number, (title, way)) in WAYS.iter().enumerate() {
            let column = &mut columns[number % count];
            widgets::card(column, title, |ui| {
                // Side by side they are equally high; their texts keep the gaps of a text.
                ui.set_min_height(if has_room { CARD } else { 0.0 });
                ui.with_layout(Layout::top_down(Align::Min), |ui| way(ui, desk));
            });
        }
    });
    recent::show(ui, desk);
    gallery::cards(ui, desk);
}

fn mystery(ui: &mut Ui, desk: &mut Desk) {
    let view = PanelView::new(drawing()).drawing().spoken("the arm of the demonstration").height(DRAWING);
    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
    widgets::weak(
        ui,
        "Three joints, simulated, with an effect that no model of them knows, and a seal over the answer. The highlighted button \
         leads to its name, step by step.",
    );
    ui.add_space(4.0);
    if ui.button("Simulate the demonstration arm").clicked() {
        desk.run(Command::Simulate(Box::new(Scenario::embedded())));
    }
    if ui.button("Another effect, drawn by chance").clicked() {
        desk.orders.push(Order::DrawMystery);
    }
}

fn log(ui: &mut Ui, desk: &mut Desk) {
    widgets::weak(
        ui,
        format!(
            "{READABLE}: position and torque of each joint, velocity and acceleration if they were measured. What is odd about \
             it is told first; nothing is mended in silence."
        ),
    );
    ui.add_space(4.0);
    if ui.button("Open a log…").clicked() {
        desk.orders.push(Order::OpenDialog);
    }
    widgets::weak(ui, "Or drop it anywhere on this window.");
}

fn lessons(ui: &mut Ui, desk: &mut Desk) {
    widgets::weak(
        ui,
        "Short lessons on these same screens: a puzzle, a prediction that is locked in, an act, and why it came out so. Each \
         student has an arm of their own.",
    );
    ui.add_space(4.0);
    if ui.button("Choose a lesson").clicked() {
        desk.orders.push(Order::Lessons(true));
    }
}

/// The arm of the demonstration, without torques.
fn drawing() -> Panel {
    let Scenario { arm, .. } = Scenario::embedded();
    let pose = arm::Pose { time: 0.0, arm: &arm, q: &TURNED, measured: &[], predicted: &[], largest: &[], path: &[] };
    arm::panel(&pose)
}
