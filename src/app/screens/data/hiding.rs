//! What is to be hidden in the simulated arm: a row for each, with where and how strong.

use std::ops::RangeInclusive;

use egui::{Button, ComboBox, Role, Slider, Ui, WidgetInfo};

use crate::app::widgets;
use crate::effect::{Effect, Scope, registry};
use crate::simulation::world::{Kind, Rank};

/// Most that is hidden at a time.
const MOST_HIDDEN: usize = 6;

/// Something that can be hidden.
struct Offer {
    name: &'static str,
    about: &'static str,
    /// The first joint on which it can be, counted from 0; `None` for the whole arm.
    first_joint: Option<usize>,
}

impl From<&'static Effect> for Offer {
    fn from(effect: &'static Effect) -> Self {
        let first_joint = match effect.scope {
            Scope::Arm => None,
            // The later joint of a pair names it.
            Scope::Pair => Some(1),
            Scope::Joint => Some(0),
        };
        Offer { name: effect.name, about: effect.description, first_joint }
    }
}

impl From<&'static Kind> for Offer {
    fn from(kind: &'static Kind) -> Self {
        let about = match kind.rank {
            Rank::Common => "Every robot has a little of it.",
            Rank::Findable => "",
            Rank::Outside => "The catalogue of effects has no name for it.",
        };
        Offer { name: kind.name, about, first_joint: kind.first_joint }
    }
}

/// What is hidden of a list of offers.
pub struct Hiding {
    /// What one of them is called.
    word: &'static str,
    offers: Vec<Offer>,
    rows: Vec<Row>,
    /// What another one is at first.
    usual: usize,
}

struct Row {
    /// Index into the offers.
    what: usize,
    joints: Vec<bool>,
    strength_percent: f64,
}

/// What somebody wants to be hidden.
pub struct Wish {
    /// Index into the list of what can be hidden.
    pub what: usize,
    /// Counted from 0.
    pub joints: Vec<usize>,
    /// RMS of what it does over that of the torque.
    pub share: f64,
}

impl Hiding {
    /// Effects of the registry; one at first.
    pub fn effects() -> Self {
        Hiding::of("effect", registry::ALL.iter().copied().map(Offer::from).collect(), 1)
    }

    /// Parts of a world; one at first.
    pub fn parts() -> Self {
        let usual = Kind::ALL.iter().position(|kind| kind.id == "elastic-gear").unwrap_or(0);
        Hiding::of("part", Kind::ALL.iter().map(Offer::from).collect(), usual)
    }

    fn of(word: &'static str, offers: Vec<Offer>, usual: usize) -> Self {
        Hiding { word, offers, rows: vec![Row::usual(usual)], usual }
    }

    /// The rows, for an arm of so many joints.
    pub fn show(&mut self, ui: &mut Ui, joints: usize) {
        let Hiding { word, offers, rows, usual } = self;
        let mut number = 0;
        rows.retain_mut(|row| {
            number += 1;
            ui.push_id((&word, number), |ui| row.show(ui, word, offers, number, joints)).inner
        });
        let more = match (rows.is_empty(), &**word) {
            (true, "effect") => "Hide an effect".to_owned(),
            (true, word) => format!("Hide a {word}"),
            (false, word) => format!("Hide another {word}"),
        };
        if ui.add_enabled(rows.len() < MOST_HIDDEN, Button::new(more).small()).clicked() {
            rows.push(Row::usual(*usual));
        }
    }

    /// What is wanted, on joints that can have it.
    pub fn wishes(&self) -> impl Iterator<Item = Wish> {
        self.rows.iter().map(|row| {
            let first = self.offers[row.what].first_joint;
            let joints = first.map_or(0..0, |first| first..row.joints.len()).filter(|joint| row.joints[*joint]);
            Wish { what: row.what, joints: joints.collect(), share: row.strength_percent / 100.0 }
        })
    }
}

impl Row {
    fn usual(what: usize) -> Self {
        Row { what, joints: vec![true, false, false], strength_percent: 10.0 }
    }

    /// Which, where, how strong; whether it stays.
    fn show(&mut self, ui: &mut Ui, word: &str, offers: &[Offer], number: usize, joints: usize) -> bool {
        let mut stays = true;
        ui.horizontal_wrapped(|ui| {
            let label = ui.label(format!("Hidden {word}"));
            let name = offers[self.what].name;
            let chooser = ComboBox::from_id_salt("hidden").selected_text(name).width(170.0).show_ui(ui, |ui| {
                for (index, offer) in offers.iter().enumerate() {
                    ui.selectable_value(&mut self.what, index, offer.name);
                }
            });
            chooser.response.labelled_by(label.id);
            let remove = ui.add(Button::new("×").small());
            let spoken = format!("hide no {name} ({number})");
            remove.widget_info(|| WidgetInfo::labeled(Role::Button, true, &spoken));
            stays = !remove.on_hover_text("Hide it no more").clicked();
        });
        let offer = &offers[self.what];
        self.joints.resize(joints, false);
        if let Some(first) = offer.first_joint {
            ui.horizontal_wrapped(|ui| {
                for (joint, on) in self.joints.iter_mut().enumerate().skip(first) {
                    ui.checkbox(on, format!("joint {}", joint + 1));
                }
            });
        }
        ui.add(percent(&mut self.strength_percent, 1.0..=40.0, "of the torque"));
        if !offer.about.is_empty() {
            widgets::weak(ui, offer.about);
        }
        stays
    }
}

/// A share in percent.
pub fn percent<'a>(value: &'a mut f64, range: RangeInclusive<f64>, text: &str) -> Slider<'a> {
    Slider::new(value, range).suffix(" %").max_decimals(1).text(text.to_owned())
}
