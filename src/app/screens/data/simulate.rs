//! The panel that simulates: arm, motion, what moves it, what is hidden, noise, encoders.

use egui::{Button, CollapsingHeader, DragValue, Grid, RichText, Ui};

use super::hiding::{Hiding, percent};
use super::{arm_editor, motion};
use crate::app::desk::{Desk, Notice, Order, Tone};
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::arm::{Arm, Link, MOST_JOINTS, Posture};
use crate::effect::registry;
use crate::recording::encoders::Side;
use crate::session::Command;
use crate::simulation::world::{self, Kind, LoggedTorque, Sensors};
use crate::simulation::{Excitation, Level, Scenario, SimulationError};

/// A link that is added.
const NEW_LINK: Link = Link { mass: 1.0, length: 0.3, com: 0.15, inertia: 0.0075 };

/// What to simulate, as set in the panel.
pub struct Simulator {
    pub seed: u64,
    engine: Engine,
    effects: Hiding,
    parts: Hiding,
    /// On which side of their gears the rigid bodies have their encoders, and which torque they log.
    side: Side,
    torque: LoggedTorque,
    /// How hard the mysteries are that it draws.
    pub level: Level,
    arm: Arm,
    motion: Excitation,
    /// Steps of the encoders in a turn; 0 for exact positions.
    encoder_steps: u32,
    noise_percent: f64,
}

/// What gives the arm its motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Engine {
    /// The motion is prescribed, and the torque that it needs computed.
    Formulas,
    /// A servo moves rigid bodies.
    Bodies,
}

impl Default for Simulator {
    fn default() -> Self {
        let Scenario { arm, motion, .. } = Scenario::embedded();
        Simulator {
            seed: 7,
            engine: Engine::Formulas,
            effects: Hiding::effects(),
            parts: Hiding::parts(),
            side: Side::Link,
            torque: LoggedTorque::default(),
            level: Level::default(),
            arm,
            motion,
            encoder_steps: 0,
            noise_percent: 2.0,
        }
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
    engine(ui, wish);
    let joints = wish.arm.joint_count();
    match wish.engine {
        Engine::Formulas => wish.effects.show(ui, joints),
        Engine::Bodies => wish.parts.show(ui, joints),
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
        desk.orders.push(wish.command().map_or_else(|error| failed(&error), Order::run));
    }
}

/// What moves the arm, and what only that has.
fn engine(ui: &mut Ui, wish: &mut Simulator) {
    ui.horizontal_wrapped(|ui| {
        ui.label("Moved by");
        let formulas = ui.radio_value(&mut wish.engine, Engine::Formulas, "formulas");
        formulas.on_hover_text("The motion is prescribed, and the torque that it needs computed: exact, at once");
        let bodies = ui.radio_value(&mut wish.engine, Engine::Bodies, "rigid bodies");
        bodies.on_hover_text(
            "A servo moves an arm in another engine, which knows none of the formulas that a diagnosis searches: with all that no \
             formula says, in some seconds",
        );
    });
    if wish.engine == Engine::Formulas {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Encoders");
        ui.radio_value(&mut wish.side, Side::Link, "behind the gears");
        ui.radio_value(&mut wish.side, Side::Motor, "on the motors");
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("Torque");
        ui.radio_value(&mut wish.torque, LoggedTorque::Commanded, "as commanded");
        ui.radio_value(&mut wish.torque, LoggedTorque::Measured, "by the current");
    });
}

/// Where the arm points at q = 0.
fn posture(ui: &mut Ui, arm: &mut Arm) {
    ui.horizontal_wrapped(|ui| {
        ui.label("At q = 0 it points");
        let before = arm.posture.zero_angle.to_degrees();
        let mut degrees = before;
        let named = [("right", Posture::RIGHT), ("up", Posture::UP), ("left", Posture::LEFT), ("down", Posture::DOWN)];
        for (name, zero) in named {
            let is_so = (degrees - zero.zero_angle.to_degrees()).abs() < 1e-3;
            if ui.selectable_label(is_so, name).clicked() {
                degrees = zero.zero_angle.to_degrees();
            }
        }
        let angle = ui.add(DragValue::new(&mut degrees).range(-180.0..=180.0).max_decimals(1).suffix("°"));
        angle.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, true, "angle at q = 0"));
        angle.on_hover_text("From the right, counter-clockwise");
        if degrees != before {
            arm.posture.zero_angle = degrees.to_radians();
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

impl Simulator {
    /// What simulates it.
    fn command(&self) -> Result<Command, SimulationError> {
        match self.engine {
            Engine::Formulas => self.scenario().map(|scenario| Command::Simulate(Box::new(scenario))),
            Engine::Bodies => self.world().map(|world| Command::SimulateWorld(Box::new(world))),
        }
    }

    /// Without anything that is hidden.
    fn bare(&self) -> Scenario {
        let steps = (self.encoder_steps > 0).then_some(f64::from(self.encoder_steps));
        Scenario {
            name: "simulated arm".to_owned(),
            arm: self.arm.clone(),
            motion: self.motion.clone(),
            torque_noise: self.noise_percent / 100.0,
            seed: self.seed,
            encoder_resolution: steps.map(|steps| std::f64::consts::TAU / steps),
            effects: Vec::new(),
            ..Scenario::embedded()
        }
    }

    fn scenario(&self) -> Result<Scenario, SimulationError> {
        let bare = self.bare();
        let mut effects = Vec::new();
        for wish in self.effects.wishes() {
            effects.extend(bare.hide_by_strength(registry::ALL[wish.what].id, &wish.joints, wish.share)?);
        }
        Ok(Scenario { effects, ..bare })
    }

    fn world(&self) -> Result<world::Scenario, SimulationError> {
        let mut world = world::Scenario::of(&self.bare());
        world.sensors = Sensors { side: self.side, torque: self.torque, ..world.sensors };
        for wish in self.parts.wishes() {
            world.hide_by_strength(&Kind::ALL[wish.what], &wish.joints, wish.share)?;
        }
        world.check()?;
        Ok(world)
    }
}
