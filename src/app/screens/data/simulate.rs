//! The panel that simulates: arm, motion, hidden effect, noise, encoders.

use egui::{Button, CollapsingHeader, ComboBox, DragValue, Grid, RichText, Slider, Ui};

use super::{arm_editor, motion};
use crate::app::desk::{Desk, Notice, Order, Tone};
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::arm::{Arm, Link, MOST_JOINTS};
use crate::effect::{Scope, registry};
use crate::session::Command;
use crate::simulation::{Excitation, Level, Scenario, SimulationError};

/// A link that is added.
const NEW_LINK: Link = Link { mass: 1.0, length: 0.3, com: 0.15, inertia: 0.0075 };

/// What to simulate, as set in the panel.
pub struct Simulator {
    pub seed: u64,
    /// How hard the mysteries are that it draws.
    pub level: Level,
    /// Index into the registry; `None` hides nothing.
    effect: Option<usize>,
    joints: Vec<bool>,
    arm: Arm,
    motion: Excitation,
    /// Steps of the encoders in a turn; 0 for exact positions.
    encoder_steps: u32,
    strength_percent: f64,
    noise_percent: f64,
}

impl Default for Simulator {
    fn default() -> Self {
        let Scenario { arm, motion, .. } = Scenario::embedded();
        Simulator {
            seed: 7,
            level: Level::default(),
            effect: Some(1),
            joints: vec![true, false, false],
            arm,
            motion,
            encoder_steps: 0,
            strength_percent: 10.0,
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
    motion::show(ui, &mut wish.motion);
    let name = |effect: Option<usize>| effect.map_or("nothing", |index| registry::ALL[index].name);
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Hidden effect");
        let chooser = ComboBox::from_id_salt("hidden effect").selected_text(name(wish.effect)).width(170.0);
        let chooser = chooser.show_ui(ui, |ui| {
            ui.selectable_value(&mut wish.effect, None, name(None));
            for index in 0..registry::ALL.len() {
                ui.selectable_value(&mut wish.effect, Some(index), name(Some(index)));
            }
        });
        chooser.response.labelled_by(label.id);
    });
    let spec = wish.effect.map(|index| registry::ALL[index]);
    if let Some(spec) = spec.filter(|spec| spec.scope != Scope::Arm) {
        // The later joint of a pair names it.
        let first = usize::from(spec.scope == Scope::Pair);
        ui.horizontal_wrapped(|ui| {
            for (joint, on) in wish.joints.iter_mut().enumerate().skip(first) {
                ui.checkbox(on, format!("joint {}", joint + 1));
            }
        });
    }
    let slider =
        |value, range, text: &str| Slider::new(value, range).suffix(" %").max_decimals(1).text(text.to_owned());
    ui.add_enabled(spec.is_some(), slider(&mut wish.strength_percent, 1.0..=40.0, "of the torque"));
    ui.add(slider(&mut wish.noise_percent, 0.0..=20.0, "torque noise"));
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Encoder steps in a turn");
        ui.add(DragValue::new(&mut wish.encoder_steps).speed(64).range(0..=10_000_000)).labelled_by(label.id);
        if wish.encoder_steps == 0 {
            ui.label(RichText::new("0: exact").size(SMALL).color(Palette::in_ui(ui).weak));
        }
    });
    if let Some(spec) = spec {
        widgets::weak(ui, spec.description);
    }
    if ui.button("Simulate").clicked() {
        desk.orders.push(match scenario(wish) {
            Ok(scenario) => Order::run(Command::Simulate(Box::new(scenario))),
            Err(error) => failed(&error),
        });
    }
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
    wish.joints.resize(wish.arm.joint_count(), false);
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
    let Some(index) = wish.effect else { return Ok(bare) };
    let spec = registry::ALL[index];
    let first = usize::from(spec.scope == Scope::Pair);
    let joints: Vec<usize> = (first..wish.joints.len()).filter(|&joint| wish.joints[joint]).collect();
    let effects = bare.hide_by_strength(spec.id, &joints, wish.strength_percent / 100.0)?;
    Ok(Scenario { effects, ..bare })
}
