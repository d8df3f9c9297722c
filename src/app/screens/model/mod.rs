//! Model: its terms as cards, each with its formula, its parameters and its share of the torque; and how they are wired.

mod diagram;
mod figures;
mod inside;
mod plain;
mod share;

use egui::{Align, Button, CollapsingHeader, ComboBox, Layout, RadioButton, RichText, Ui, WidgetInfo};

use serde_json::Value;

use share::{Share, Shares};

use super::train;
use crate::app::desk::{About, Desk, Needs, Order};
use crate::app::dock::{self, Part};
use crate::app::plot::{PanelView, ticks};
use crate::app::screen::{Screen, Switch};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::{glossary, math, tables, widgets};
use crate::arm::stated::StatedArm;
use crate::effect::{Effect, Scope, registry};
use crate::figure::Panel;
use crate::model::learned::LearnedTerm;
use crate::model::{Model, Parameter, Preset, RigidBody, Term};
use crate::progress::Progress;
use crate::recording::{JointKind, Recording};
use crate::session::{Command, Session, Step, TermEdit};

/// With more parameters than this, a card shows them only when asked.
const MOST_PARAMETERS: usize = 6;

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "model",
    title: "Model",
    purpose: "What the model adds up, and with which parameters",
    needs: Needs::Model,
    on_the_way: true,
};

const PANELS: Part<Terms> = Part::Beside(&[
    (
        2.9,
        Part::Tabs(&[
            Part::Panel("Terms", |_, ui, desk| terms(ui, desk)),
            Part::Panel("What it has learned", |screen, ui, desk| screen.inside.show(ui, desk)),
            Part::Panel("Plain least squares", |screen, ui, desk| screen.plain.show(ui, desk)),
        ]),
    ),
    (1.0, Part::Panel("Change the model", Terms::change)),
]);

/// The screen of the model: which effect is to be added, as set in its panel.
#[derive(Default)]
pub struct Terms {
    /// Index into what can be added.
    effect: usize,
    joints: Vec<bool>,
    /// What of its inside is looked at.
    inside: inside::Wish,
    /// Identification as published values have it.
    plain: plain::Plain,
    /// Whether somebody has looked at this recording here.
    was_seen: bool,
}

impl Screen for Terms {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        self.was_seen = true;
        let Some(step) = desk.session.current().cloned() else { return };
        let terms: Vec<String> = step.fitted.model.terms.iter().map(Term::label).collect();
        let effort = desk.session.recording.as_deref().map_or("torque", Recording::effort);
        let sentence = format!("The {effort} is the sum of {}: {}.", terms_text(terms.len()), terms.join(" + "));
        widgets::headline(ui, &widgets::sentence_case(&step.name), &sentence);
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let (Some(recording), Some(step)) = (&desk.session.recording, desk.session.current()) else {
            return Vec::new();
        };
        let Ok(shares) = desk.memo.now(desk.session, Shares) else { return Vec::new() };
        let mut panels = figures::figures(recording, step, &shares);
        panels.extend(self.inside.figures(desk));
        panels
    }

    fn switches<'a>(&'a mut self, _: &mut Desk) -> Vec<Switch<'a>> {
        vec![Switch::on("let-go", &mut self.inside.falls)]
    }

    fn copy(&self) -> Box<dyn Screen> {
        let Terms { effect, joints, inside, plain: _, was_seen } = self;
        let (joints, inside) = (joints.clone(), inside.clone());
        Box::new(Terms { effect: *effect, joints, inside, plain: plain::Plain::default(), was_seen: *was_seen })
    }

    fn is_done(&self, session: &Session) -> bool {
        self.was_seen && session.current().is_some()
    }

    fn follow(&mut self, before: &Session, after: &Session, _: Option<&Command>) {
        self.was_seen &= before.has_recording_of(after);
        self.plain.follow(before, after);
    }

    fn poll(&mut self) {
        self.plain.poll();
    }

    fn is_busy(&self) -> bool {
        self.plain.at_work().is_some()
    }

    fn at_work(&self) -> Option<(&str, Progress)> {
        self.plain.at_work()
    }

    fn stop(&mut self) {
        self.plain.stop("you pressed Stop");
    }

    fn setup(&self) -> Value {
        serde_json::to_value(&self.inside).unwrap_or_default()
    }

    fn set_up(&mut self, setup: Value) {
        self.inside = serde_json::from_value(setup).unwrap_or_default();
    }
}

fn terms(ui: &mut Ui, desk: &mut Desk) {
    let (Some(recording), Some(step)) = (desk.session.recording.clone(), desk.session.current().cloned()) else {
        return;
    };
    widgets::card(ui, "How it is wired", |ui| wiring(ui, desk, &step.fitted.model, recording.joint_count()));
    let shares = desk.memo.later(ui.ctx(), desk.session, Shares).and_then(Result::ok);
    for (place, term) in step.fitted.model.terms.iter().enumerate() {
        let shares = shares.as_ref().map_or(&[][..], |shares| &shares[place]);
        card(ui, desk, &recording, &step, place, term, shares);
    }
    for (place, term) in desk.session.set_aside.iter().enumerate() {
        set_aside(ui, desk.orders, desk.busy.is_none(), place, term);
    }
}

/// The structure of the model over the full width.
fn wiring(ui: &mut Ui, desk: &mut Desk, model: &Model, joints: usize) {
    let width = f64::from(ui.available_width());
    let panel = diagram::figure(model, joints, width);
    let labels: Vec<String> = model.terms.iter().map(Term::label).collect();
    let spoken = format!("structure of the model: the sum of {}", labels.join(", "));
    let view = PanelView::new(panel).height(diagram::height(model, joints, width) as f32).spoken(spoken);
    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
}

fn terms_text(count: usize) -> String {
    if count == 1 { "one term".to_owned() } else { format!("{count} terms") }
}

/// One term: what it is, what it carries, its parameters, and what can be done with it.
fn card(ui: &mut Ui, desk: &mut Desk, recording: &Recording, step: &Step, place: usize, term: &Term, shares: &[Share]) {
    let palette = Palette::in_ui(ui);
    let label = term.label();
    let count = step.fitted.model.terms.len();
    widgets::card(ui, "", |ui| {
        ui.horizontal_wrapped(|ui| {
            let (color, _) = palette.nth(place);
            ui.label(RichText::new(format!("{}  {label}", place + 1)).size(crate::app::theme::TITLE).color(color));
            ui.add_space(GAP);
            let (idle, fixed) = (desk.busy.is_none(), step.fitted.model.is_learned());
            let mut edit = |ui: &mut Ui, possible: bool, text: &str, what: &str, edit: TermEdit| {
                let button = ui.add_enabled(possible && idle, Button::new(text).small());
                let spoken = format!("{what}: {label}");
                button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, possible && idle, &spoken));
                if button.on_hover_text(what).clicked() {
                    desk.orders.push(Order::run(Command::EditTerms(edit)));
                }
            };
            let up = TermEdit::Move { from: place, to: place.saturating_sub(1) };
            edit(ui, place > 0 && !fixed, "↑", "Move up", up);
            edit(ui, place + 1 < count && !fixed, "↓", "Move down", TermEdit::Move { from: place, to: place + 1 });
            if matches!(term, Term::Effect(_)) {
                edit(ui, true, "Switch off", "Switch off", TermEdit::SwitchOff(place));
                edit(ui, true, "Remove", "Remove", TermEdit::Remove(place));
            }
        });
        let Told { tex, plain, text } = told(term, recording);
        math::show(ui, &tex, &plain, palette.accent);
        widgets::weak(ui, text);
        ui.add_space(2.0);
        for (joint, share) in shares.iter().enumerate().filter(|(_, share)| share.rms > 0.0) {
            ui.horizontal(|ui| {
                ui.label(&recording.joints[joint].name);
                widgets::share_bar(ui, share.part, 120.0, palette.nth(place).0);
                let unit = recording.joints[joint].kind.units()[3];
                let text = format!(
                    "{} of the {}, {} {unit} RMS",
                    ticks::percent(share.part),
                    recording.joints[joint].kind.effort(),
                    ticks::number(share.rms)
                );
                ui.label(RichText::new(text).size(SMALL).color(palette.weak));
            });
        }
        let own: Vec<&Parameter> = step.fitted.parameters.iter().filter(|parameter| parameter.term == place).collect();
        let parameters = |ui: &mut Ui| {
            tables::parameters(ui, &format!("parameters of term {place}"), "95 % interval", own.iter().copied());
            if let (Term::RigidBody(_), Some(text)) = (term, step.fitted.beside_stated()) {
                widgets::weak(ui, text);
            }
        };
        match own.len() {
            0 => (),
            1..=MOST_PARAMETERS => parameters(ui),
            many => {
                let header = CollapsingHeader::new(format!("{many} parameters")).id_salt(("parameters", place));
                header.show(ui, parameters);
            }
        }
    });
}

/// What is told of a term.
struct Told {
    /// Its formula in TeX.
    tex: String,
    /// The same in plain letters.
    plain: String,
    /// What it means.
    text: String,
}

/// H(q), c and g of any rigid body.
const BODY: [&str; 2] = [r"\tau = H(q)\,\ddot q + c(q, \dot q) + g(q)", "τ = H(q) q̈ + c(q, q̇) + g(q)"];

fn told(term: &Term, recording: &Recording) -> Told {
    let of = |[tex, plain]: [&str; 2], text: &str| Told { tex: tex.into(), plain: plain.into(), text: text.into() };
    match term {
        Term::RigidBody(RigidBody::Identified) => {
            let slides = recording.joints.iter().all(|joint| joint.kind == JointKind::Prismatic);
            match (recording.spatial(), slides) {
                (None, true) => {
                    of([r"\tau = M_1\,\ddot q", "τ = M1 q̈"], "A mass that slides; it is identified from the data.")
                }
                (None, false) => of(BODY, "Planar links; their base parameters are identified from the data."),
                (Some(_), _) => of(
                    BODY,
                    "Links about the axes that are stated; their base parameters are identified from the data.",
                ),
            }
        }
        Term::RigidBody(RigidBody::Stated(StatedArm::Planar(_))) => {
            of(BODY, "Planar links with the masses and lengths that the maker states.")
        }
        Term::RigidBody(RigidBody::Stated(StatedArm::Spatial(_))) => {
            of(BODY, "Links about the axes that are stated, with the masses that the maker states.")
        }
        Term::Resistance(_) => of(
            [
                r"\tau = I_r\,\ddot q + d\,\dot q + \tau_c\,\mathrm{sign}(\dot q) + k\,q + \tau_0",
                "τ = I_r q̈ + d q̇ + τ_c sign(q̇) + k q + τ₀",
            ],
            "Rotor inertia, damping, dry friction and spring of each joint as the maker states them.",
        ),
        Term::Effect(term) => {
            of([term.effect.typeset, &widgets::formula(term.effect.formula)], term.effect.description)
        }
        Term::Learned(LearnedTerm::StructuredLagrangian { positive: None, .. }) => of(
            [
                r"\tau = \frac{\mathrm d}{\mathrm dt}\frac{\partial \mathcal L}{\partial \dot q} - \frac{\partial \mathcal L}{\partial q},\quad \mathcal L = \tfrac12\,\dot q^{\mathsf T} H(q)\,\dot q - V(q),\quad H = C + C^{\mathsf T}",
                "τ = d/dt ∂ℒ/∂q̇ − ∂ℒ/∂q,  ℒ = ½ q̇ᵀ H(q) q̇ − V(q),  H = C + Cᵀ",
            ],
            "Two networks: a mass matrix that nothing keeps positive, and the potential energy.",
        ),
        // The Cholesky factor is C: L is the Lagrangian.
        Term::Learned(LearnedTerm::StructuredLagrangian { .. }) => of(
            [
                r"\tau = \frac{\mathrm d}{\mathrm dt}\frac{\partial \mathcal L}{\partial \dot q} - \frac{\partial \mathcal L}{\partial q},\quad \mathcal L = \tfrac12\,\dot q^{\mathsf T} H(q)\,\dot q - V(q),\quad H = C\,C^{\mathsf T}",
                "τ = d/dt ∂ℒ/∂q̇ − ∂ℒ/∂q,  ℒ = ½ q̇ᵀ H(q) q̇ − V(q),  H = C Cᵀ",
            ],
            "Two networks: the lower triangle C of the mass matrix, and the potential energy.",
        ),
        Term::Learned(LearnedTerm::BlackBoxLagrangian { .. }) => of(
            [
                r"\tau = \frac{\mathrm d}{\mathrm dt}\frac{\partial \mathcal L}{\partial \dot q} - \frac{\partial \mathcal L}{\partial q}",
                "τ = d/dt ∂ℒ/∂q̇ − ∂ℒ/∂q",
            ],
            "One network for the Lagrangian ℒ(q, q̇).",
        ),
        Term::Learned(LearnedTerm::FeedForward { penalty, .. }) if *penalty > 0.0 => Told {
            tex: format!(
                r"\tau = \varepsilon(q, \dot q, \ddot q),\quad \mathrm{{loss}} + {penalty}\,\|\varepsilon\|^2"
            ),
            plain: format!("τ = ε(q, q̇, q̈), loss + {penalty} ‖ε‖²"),
            text: "A network for what the rest can't explain.".to_owned(),
        },
        Term::Learned(LearnedTerm::FeedForward { .. }) => of(
            [r"\tau = f(q, \dot q, \ddot q)", "τ = f(q, q̇, q̈)"],
            "One network from motion to torque, without physics.",
        ),
        Term::Learned(LearnedTerm::Friction) => of(
            [
                r"\tau = \left(\tau_C + \tau_S\, e^{-(\dot q/v_s)^2}\right)\mathrm{sign}(\dot q) + d\,\dot q",
                "τ = (τ_C + τ_S exp(−(q̇/v_s)²)) sign(q̇) + d q̇",
            ],
            "Stribeck friction of each joint; its coefficients are trained.",
        ),
        Term::Learned(LearnedTerm::Columns { .. }) => {
            of([r"\tau = \sum_k \theta_k\,\varphi_k", "τ = Σ θ φ"], "Effects with trained factors.")
        }
    }
}

fn set_aside(ui: &mut Ui, orders: &mut Vec<Order>, idle: bool, place: usize, term: &Term) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "", |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(term.label()).color(palette.weak));
            widgets::chip(ui, "switched off", palette.weak);
            for (text, edit) in [("Switch on", TermEdit::SwitchOn(place)), ("Forget", TermEdit::Forget(place))] {
                let button = ui.add_enabled(idle, Button::new(text).small());
                let spoken = format!("{text}: {}", term.label());
                button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, idle, &spoken));
                if button.clicked() {
                    orders.push(Order::run(Command::EditTerms(edit)));
                }
            }
        });
    });
}

impl Terms {
    fn change(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        self.add(ui, desk, &recording);
        presets(ui, desk, &recording);
    }

    /// Any effect that is a term can be added by hand, whatever the diagnosis says.
    fn add(&mut self, ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
        widgets::card(ui, "Add a term", |ui| {
            let effects: Vec<&Effect> = registry::addable().chain(desk.session.own_effects.iter().copied()).collect();
            self.effect = self.effect.min(effects.len() - 1);
            self.joints.resize(recording.joint_count(), true);
            let name = |index: usize| effects[index].name;
            let label = ui.label("Effect");
            let chooser = ComboBox::from_id_salt("effect to add").selected_text(name(self.effect)).width(200.0);
            let chooser = chooser.show_ui(ui, |ui| {
                for index in 0..effects.len() {
                    ui.selectable_value(&mut self.effect, index, name(index));
                }
            });
            chooser.response.labelled_by(label.id);
            let spec = effects[self.effect];
            // The later joint of a pair names it.
            let first = usize::from(spec.scope == Scope::Pair);
            if spec.scope != Scope::Arm {
                ui.horizontal_wrapped(|ui| {
                    for (on, joint) in self.joints.iter_mut().zip(&recording.joints).skip(first) {
                        ui.checkbox(on, &joint.name);
                    }
                });
            }
            let joints: Vec<usize> = (first..self.joints.len()).filter(|joint| self.joints[*joint]).collect();
            let possible = desk.busy.is_none() && (spec.scope == Scope::Arm || !joints.is_empty());
            let accent = Palette::in_ui(ui).accent;
            math::show(ui, spec.typeset, &widgets::formula(spec.formula), accent);
            widgets::weak(ui, spec.description);
            let button = ui.add_enabled(possible, Button::new("Add this term"));
            if button.on_disabled_hover_text("Choose a joint").clicked() {
                desk.run(Command::AddEffect { effect: spec.id.to_owned(), joints });
            }
        });
    }
}

fn presets(ui: &mut Ui, desk: &mut Desk, recording: &Recording) {
    widgets::card(ui, "Start from another model", |ui| {
        for preset in Preset::ALL {
            let possible = preset != Preset::StatedArm || recording.states_arm();
            let chosen = desk.session.preset == preset;
            let radio = ui.add_enabled(possible && desk.busy.is_none(), RadioButton::new(chosen, preset.title()));
            let radio = glossary::radio(radio, preset).on_disabled_hover_text("The recording states no arm.");
            if radio.clicked() && !chosen {
                match preset {
                    Preset::Learned(_) => {
                        desk.orders.extend([Order::PlanTraining(preset), Order::Show(&train::ABOUT)]);
                    }
                    _ => desk.run(Command::ChoosePreset(preset)),
                }
            }
        }
        ui.with_layout(Layout::top_down(Align::Min), |ui| {
            let text = "Models with networks are trained on the next screen.";
            ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
        });
    });
}
