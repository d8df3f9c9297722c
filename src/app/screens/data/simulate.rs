//! The panel that simulates: arm, motion, hidden effects, noise, encoders.

use std::ops::RangeInclusive;

use egui::{Button, CollapsingHeader, ComboBox, DragValue, Grid, RichText, Slider, Ui, WidgetInfo};

use super::{arm_editor, motion};
use crate::app::desk::{Desk, Notice, Order, Tone};
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::arm::{Arm, Link, MOST_JOINTS, Posture};
use crate::effect::{Effect, Scope, registry};
use crate::session::Command;
use crate::simulation::{Excitation, Level, Scenario, SimulationError};

/// A link that is added.
const NEW_LINK: Link = Link { mass: 1.0, length: 0.3, com: 0.15, inertia: 0.0075 };

/// Most effects that are hidden at a time.
const MOST_HIDDEN: usize = 6;

/// What to simulate, as set in the panel.
pub struct Simulator {
    pub seed: u64,
    hidden: Vec<Hidden>,
    /// How hard the mysteries are that it draws.
    pub level: Level,
    arm: Arm,
    motion: Excitation,
    /// Steps of the encoders in a turn; 0 for exact positions.
    encoder_steps: u32,
    noise_percent: f64,
}

/// An effect that is hidden.
struct Hidden {
    /// Index into the registry.
    effect: usize,
    joints: Vec<bool>,
    strength_percent: f64,
}

impl Default for Hidden {
    fn default() -> Self {
        Hidden { effect: 1, joints: vec![true, false, false], strength_percent: 10.0 }
    }
}

impl Default for Simulator {
    fn default() -> Self {
        let Scenario { arm, motion, .. } = Scenario::embedded();
        let hidden = vec![Hidden::default()];
        Simulator { seed: 7, level: Level::default(), hidden, arm, motion, encoder_steps: 0, noise_percent: 2.0 }
    }
}

impl Simulator {
    /// The panel.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        widgets::card(ui, "Arm, motion and what is hidden", |ui| own(ui, desk, self));
    }

    /// Simulates an arm in which something is hidden by level and seed; the next time it is another one.
    pub fn draw_mystery(&mut self) -> Order {
        let seed = self.seed;
        self.seed += 1;
        Order::run(Command::DrawMystery { level: self.level, seed })
    }
}

fn failed(error: &SimulationError) -> Order {
    Order::Tell(Notice::new(Tone::Error, format!("Nothing was simulated: {error}."), ""))
}

fn own(ui: &mut Ui, desk: &mut Desk, wish: &mut Simulator) {
    arm_editor::show(ui, &mut wish.arm);
    arm(ui, wish);
    posture(ui, &mut wish.arm);
    motion::show(ui, &mut wish.motion);
    let joints = wish.arm.joint_count();
    let mut number = 0;
    wish.hidden.retain_mut(|hidden| {
        number += 1;
        ui.push_id(number, |ui| hide(ui, hidden, number, joints)).inner
    });
    let more = Button::new(if wish.hidden.is_empty() { "Hide an effect" } else { "Hide another effect" });
    if ui.add_enabled(wish.hidden.len() < MOST_HIDDEN, more.small()).clicked() {
        wish.hidden.push(Hidden::default());
    }
    ui.add(percent(&mut wish.noise_percent, 0.0..=20.0, "torque noise"));
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Encoder steps in a turn");
        ui.add(DragValue::new(&mut wish.encoder_steps).speed(64).range(0..=10_000_000)).labelled_by(label.id);
        if wish.encoder_steps == 0 {
            ui.label(RichText::new("0: exact").size(SMALL).color(Palette::in_ui(ui).weak));
        }
    });
    if ui.button("Simulate").clicked() {
        desk.orders.push(match scenario(wish) {
            Ok(scenario) => Order::run(Command::Simulate(Box::new(scenario))),
            Err(error) => failed(&error),
        });
    }
}

fn percent<'a>(value: &'a mut f64, range: RangeInclusive<f64>, text: &str) -> Slider<'a> {
    Slider::new(value, range).suffix(" %").max_decimals(1).text(text.to_owned())
}

/// One hidden effect: which, where, how strong; whether it stays.
fn hide(ui: &mut Ui, hidden: &mut Hidden, number: usize, joints: usize) -> bool {
    let mut stays = true;
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Hidden effect");
        let name = registry::ALL[hidden.effect].name;
        let chooser = ComboBox::from_id_salt("hidden effect").selected_text(name).width(170.0).show_ui(ui, |ui| {
            for (index, effect) in registry::ALL.iter().enumerate() {
                ui.selectable_value(&mut hidden.effect, index, effect.name);
            }
        });
        chooser.response.labelled_by(label.id);
        let remove = ui.add(Button::new("×").small());
        let spoken = format!("hide no {name} ({number})");
        remove.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &spoken));
        stays = !remove.on_hover_text("Hide it no more").clicked();
    });
    let effect = registry::ALL[hidden.effect];
    hidden.joints.resize(joints, false);
    if effect.scope != Scope::Arm {
        ui.horizontal_wrapped(|ui| {
            for (joint, on) in hidden.joints.iter_mut().enumerate().skip(first_joint(effect)) {
                ui.checkbox(on, format!("joint {}", joint + 1));
            }
        });
    }
    ui.add(percent(&mut hidden.strength_percent, 1.0..=40.0, "of the torque"));
    widgets::weak(ui, effect.description);
    stays
}

/// The later joint of a pair names it.
fn first_joint(effect: &Effect) -> usize {
    usize::from(effect.scope == Scope::Pair)
}

/// Where the arm points at q = 0.
fn posture(ui: &mut Ui, arm: &mut Arm) {
    ui.horizontal_wrapped(|ui| {
        ui.label("At q = 0 it points");
        for (name, zero) in [("right", Posture::RIGHT), ("up", Posture::UP), ("down", Posture::DOWN)] {
            let is_so = (arm.posture.zero_angle - zero.zero_angle).abs() < 1e-6;
            if ui.selectable_label(is_so, name).clicked() {
                arm.posture = Posture { sense: arm.posture.sense, ..zero };
            }
        }
    });
}

/// Masses and lengths of the links, and how many there are.
fn arm(ui: &mut Ui, wish: &mut Simulator) {
    let count = wish.arm.joint_count();
    let header = CollapsingHeader::new(format!("The arm: {count} link{}", if count == 1 { "" } else { "s" }));
    header.id_salt("arm editor").show(ui, |ui| {
        ui.scope(|ui| {
            ui.spacing_mut().button_padding.x = 4.0;
            ui.spacing_mut().interact_size.x = 30.0;
            Grid::new("arm editor").spacing([6.0, 4.0]).show(ui, |ui| {
                for title in ["", "mass\nkg", "length\nm", "centre\nm", "inertia\nkg m²"] {
                    ui.label(RichText::new(title).size(SMALL).color(Palette::in_ui(ui).weak));
                }
                ui.end_row();
                for (number, link) in wish.arm.links.iter_mut().enumerate() {
                    ui.label((number + 1).to_string());
                    let fields = [
                        ("mass", &mut link.mass, 0.01..=1000.0),
                        ("length", &mut link.length, 0.01..=100.0),
                        ("centre of mass", &mut link.com, -100.0..=100.0),
                        ("inertia", &mut link.inertia, 0.0..=1000.0),
                    ];
                    for (name, value, range) in fields {
                        let now = *value;
                        let field = ui
                            .add(DragValue::new(value).speed(0.01 * now.abs().max(0.01)).range(range).max_decimals(4));
                        let spoken = format!("{name} of link {}", number + 1);
                        field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, true, &spoken));
                    }
                    ui.end_row();
                }
            });
        });
        ui.horizontal(|ui| {
            if ui.add_enabled(count < MOST_JOINTS, Button::new("Add a link").small()).clicked() {
                wish.arm.links.push(NEW_LINK);
            }
            if ui.add_enabled(count > 1, Button::new("Remove the last link").small()).clicked() {
                wish.arm.links.pop();
            }
        });
    });
}

fn scenario(wish: &Simulator) -> Result<Scenario, SimulationError> {
    let encoder_resolution = (wish.encoder_steps > 0).then(|| std::f64::consts::TAU / f64::from(wish.encoder_steps));
    let bare = Scenario {
        name: "simulated arm".to_owned(),
        arm: wish.arm.clone(),
        motion: wish.motion.clone(),
        torque_noise: wish.noise_percent / 100.0,
        seed: wish.seed,
        encoder_resolution,
        effects: Vec::new(),
        ..Scenario::embedded()
    };
    let mut effects = Vec::new();
    for Hidden { effect, joints, strength_percent } in &wish.hidden {
        let effect = registry::ALL[*effect];
        let joints: Vec<usize> = (first_joint(effect)..joints.len()).filter(|joint| joints[*joint]).collect();
        effects.extend(bare.hide_by_strength(effect.id, &joints, strength_percent / 100.0)?);
    }
    Ok(Scenario { effects, ..bare })
}
