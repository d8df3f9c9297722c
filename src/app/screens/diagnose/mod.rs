//! What is missing: the verdict in plain words, the evidence for each effect, and the button that adds it.

mod bet;
mod figures;
mod remainder;
mod sure;

use std::sync::Arc;

use egui::{Align, Button, CollapsingHeader, Layout, RichText, Ui, WidgetText};

use serde_json::{Value, json};

pub use figures::evidence;
use sure::Sure;

use crate::app::desk::{About, Busy, Desk, Focus, Needs, Order};
use crate::app::dock::{self, Part};
use crate::app::plot::{PanelView, ticks};
use crate::app::screen::{Next, NextStep, Screen, Switch};
use crate::app::screens::{ladder, residuals};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::{glossary, math, tables, widgets};
use crate::diagnosis::presence::LIKELY;
use crate::diagnosis::{Alternative, Candidate, MissingEffect, NotKnown, Note, Presence, Report, Verdict};
use crate::effect::Scope;
use crate::figure::Panel;
use crate::progress::Progress;
use crate::recording::finding::Severity;
use crate::recording::{Recording, joints_text};
use crate::session::{Command, Session};

/// The screen's names and place.
pub static ABOUT: About = About {
    id: "diagnose",
    title: "What is missing",
    purpose: "Which physical effect the model lacks",
    needs: Needs::Model,
    on_the_way: true,
};

const PANELS: Part<Diagnose> = Part::Beside(&[
    (2.1, Part::Panel("Evidence", Diagnose::evidence)),
    (1.0, Part::Panel("Candidates", Diagnose::ranking)),
]);

/// The screen of the diagnosis.
#[derive(Default)]
pub struct Diagnose {
    /// The effect of the report whose evidence is shown.
    chosen: usize,
    /// Whether evidence is shown with the effect in the model.
    after: bool,
    sure: Sure,
}

impl Screen for Diagnose {
    fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(recording) = desk.session.recording.clone() else { return };
        let Some(report) = desk.session.report.clone() else { return self.unasked(ui, desk) };
        if self.withholds(desk.session) {
            return bet::place(ui, desk, &report);
        }
        doubts(ui, desk.session);
        headline(ui, &report, &recording);
        bet::outcome(ui, desk, &report);
        dock::show(self, ui, desk, ABOUT.id, &PANELS);
    }

    fn figures(&self, desk: &mut Desk) -> Vec<Panel> {
        let (Some(recording), Some(report)) = (&desk.session.recording, &desk.session.report) else {
            return Vec::new();
        };
        if self.withholds(desk.session) {
            return Vec::new();
        }
        figures::evidence(report, self.chosen, self.after, recording)
    }

    fn switches<'a>(&'a mut self, desk: &mut Desk) -> Vec<Switch<'a>> {
        let report = desk.session.report.clone();
        let ids: Vec<&str> = report.iter().flat_map(|report| &report.effects).map(|found| found.effect.id).collect();
        let (chosen, known) = (&mut self.chosen, ids.clone());
        let choose = move |asked: Option<&str>| {
            *chosen = known.iter().position(|id| asked == Some(id)).unwrap_or(*chosen);
        };
        vec![Switch::one_of("effect", ids, choose), Switch::on("after", &mut self.after)]
    }

    fn copy(&self) -> Box<dyn Screen> {
        Box::new(Diagnose { chosen: self.chosen, after: self.after, sure: Sure::default() })
    }

    fn is_done(&self, session: &Session) -> bool {
        session.report.is_some() || session.ladder.len() > 1
    }

    fn next(&self, session: &Session, _: &Focus) -> Next {
        let Some(report) = &session.report else {
            let why = "Lay every known effect beside the model";
            return Next::Step(NextStep::run("Diagnose", why, Command::Diagnose));
        };
        let held_out = session.source.as_ref().map(|source| &source.held_out);
        if let Some(other) = held_out.and_then(|now| report.hold_out_next(now, session.recording.as_deref()?)) {
            let why = "What acts in the held-out part alone is learned once that trains; the model is identified anew";
            return Next::Step(NextStep::run("Hold out another part", why, Command::HoldOut(other)));
        }
        let Some(effect) = report.effects.iter().find(|effect| effect.effect.check_addable().is_ok()) else {
            return Next::OnTheWay;
        };
        let name = effect.effect.name;
        let add = Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() };
        Next::Step(NextStep::run(format!("Add {name}"), "Add it and identify all parameters anew", add))
    }

    fn withholds(&self, session: &Session) -> bool {
        session.withholds_answer()
    }

    fn answers(&self, command: &Command) -> bool {
        matches!(command, Command::Diagnose | Command::Propose)
    }

    fn follow(&mut self, before: &Session, after: &Session, _: Option<&Command>) {
        self.chosen = 0;
        self.sure.follow(before, after);
    }

    fn setup(&self) -> Value {
        json!({ "chosen": self.chosen, "after": self.after, "sure": self.sure.kept() })
    }

    fn set_up(&mut self, mut setup: Value) {
        self.chosen = setup["chosen"].as_u64().map_or(0, |chosen| chosen as usize);
        self.after = setup["after"] == true;
        self.sure.keep(setup["sure"].take());
    }

    fn poll(&mut self) {
        self.sure.poll();
    }

    fn is_busy(&self) -> bool {
        self.sure.is_busy()
    }

    fn at_work(&self) -> Option<(&str, Progress)> {
        self.sure.at_work()
    }

    fn stop(&mut self) {
        self.sure.stop();
    }
}

impl Diagnose {
    /// What is shown before there is a report.
    fn unasked(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let sentence = if desk.session.current().is_some_and(|step| step.fitted.model.is_learned()) {
            "Every known effect is laid beside the rigid body that the network stands for, and judged on data that it has not \
             seen."
        } else {
            "Every known effect is laid beside the model and judged on data that it has not seen."
        };
        if let Some(Busy { name, progress, found, .. }) = desk.busy {
            let is_diagnosis = *name == Command::Diagnose.title();
            let title = if is_diagnosis { "Looking for what is missing…" } else { "Something else is at work…" };
            let activity = if progress.activity.is_empty() { name } else { progress.activity.as_str() };
            let so_far = if found.is_empty() { String::new() } else { format!("\nSo far: {}.", found.join("; ")) };
            widgets::empty(ui, title, &format!("{activity}{so_far}"), "");
        } else {
            if widgets::empty(ui, "What does the model lack?", sentence, "Diagnose") {
                desk.run(Command::Diagnose);
            }
            bet::offer(ui, desk);
            if desk.session.proposals.is_some() {
                remainder::card(ui, desk);
            }
        }
    }

    fn evidence(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let (Some(recording), Some(report)) = (desk.session.recording.clone(), desk.session.report.clone()) else {
            return;
        };
        if report.effects.is_empty() {
            return without_effect(ui, desk, &report, &recording);
        }
        chooser(ui, &mut self.chosen, &report);
        let chosen = self.chosen.min(report.effects.len() - 1);
        effect(ui, desk, &mut self.after, &report, chosen, &recording);
    }

    fn ranking(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some(report) = desk.session.report.clone() else { return };
        widgets::card(ui, "What to do", |ui| advice(ui, &report));
        presence(ui, &report);
        completeness(ui, &report);
        if !report.unexplained_joints.is_empty() || desk.session.proposals.is_some() {
            remainder::card(ui, desk);
        }
        self.sure.card(ui, desk);
        candidates(ui, desk, &report);
    }
}

/// The advice, a line for each sentence. What follows from what is stated of the torque is told to all, what else can't be judged to
/// those who ask.
fn advice(ui: &mut Ui, report: &Report) {
    for note in &report.notes {
        ui.label(note.sentence());
    }
    let is_stated = |unknown: &&NotKnown| matches!(unknown, NotKnown::NotInTorque { .. });
    let (stated, others): (Vec<&NotKnown>, Vec<&NotKnown>) = report.not_known.iter().partition(is_stated);
    for unknown in stated {
        ui.label(format!("Not known: {}.", unknown.text()));
    }
    if !others.is_empty() {
        let title = format!("What these data can't answer ({})", others.len());
        CollapsingHeader::new(title).id_salt("not known").show(ui, |ui| {
            for unknown in others {
                widgets::weak(ui, widgets::sentence_case(&format!("{}.", unknown.text())));
            }
        });
    }
}

/// How likely each kind of physics is there, by joint.
fn presence(ui: &mut Ui, report: &Report) {
    if report.presence.is_empty() {
        return;
    }
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "What is there, and how sure", |ui| {
        let text =
            "Probability that something of this kind is there, as evidence like it was right where the truth is known.";
        widgets::weak(ui, text);
        if report.asks_held_out() {
            widgets::weak(ui, "Held-out data were asked about what was in doubt: point at it to see what they say.");
        }
        ui.add_space(4.0);
        for one in &report.presence {
            let is_likely = one.probability >= LIKELY;
            let color = if is_likely { palette.text } else { palette.weak };
            ui.horizontal_wrapped(|ui| {
                let bar = if is_likely { palette.accent } else { palette.weak };
                widgets::share_bar(ui, one.probability, 60.0, bar);
                ui.label(RichText::new(format!("{:.0} %", 100.0 * one.probability)).color(color));
                ui.label(RichText::new(format!("{}: {}", one.place(), one.effect.name)).color(color));
            })
            .response
            .on_hover_text(hint(one));
        }
    });
}

/// What more is known of how likely it is there.
fn hint(one: &Presence) -> String {
    let what = format!("It {}; {:.1} % of what was measured.", one.likelihood(), 100.0 * one.share);
    match one.held_out {
        Some(held_out) => format!("{what} Held-out data were asked: {}.", held_out.text()),
        None => what,
    }
}

/// How complete the answer is, by joint.
fn completeness(ui: &mut Ui, report: &Report) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "How complete", |ui| {
        for one in &report.completeness {
            let color = if one.complete { palette.text } else { palette.warning };
            ui.label(RichText::new(format!("{}.", widgets::sentence_case(&one.text()))).size(SMALL).color(color));
        }
    });
}

/// What makes the report wrong, whatever it says.
fn doubts(ui: &mut Ui, session: &Session) {
    let color = Palette::in_ui(ui).error;
    for finding in session.findings.iter().filter(|finding| finding.severity == Severity::Error) {
        ui.horizontal_wrapped(|ui| {
            widgets::chip(ui, finding.severity.word(), color);
            ui.label(&finding.what);
        });
    }
}

/// The verdict as one sentence.
fn headline(ui: &mut Ui, report: &Report, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    let named: Vec<String> = report.effects.iter().map(|effect| effect_text(effect, recording)).collect();
    let named = widgets::in_a_sentence(&named);
    let (word, color, text) = match report.verdict {
        Verdict::Missing => ("missing", palette.accent, format!("The model lacks {named}.")),
        Verdict::Ambiguous => ("ambiguous", palette.warning, format!("The model lacks {named}, or something like it.")),
        Verdict::NothingMissing if report.is_of_a_part() => {
            ("nothing missing", palette.good, report.headline().to_owned())
        }
        Verdict::NothingMissing => {
            ("nothing missing", palette.good, "Nothing is missing that these data could show.".to_owned())
        }
        Verdict::UnknownEffect => {
            let also = if named.is_empty() { String::new() } else { format!("; it also lacks {named}") };
            (
                "unknown effect",
                palette.warning,
                format!("The model lacks something that no known effect explains{also}."),
            )
        }
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(text).size(crate::app::theme::HEADLINE).color(palette.text));
        widgets::chip(ui, word, color);
    });
    let errors = report.held_out_nmse.iter().copied().map(ticks::percent).collect::<Vec<_>>().join(" · ");
    let floor = match &report.noise_floor_nmse {
        Some(floor) => format!(
            "noise alone would leave {}",
            floor.iter().copied().map(ticks::percent).collect::<Vec<_>>().join(" · ")
        ),
        None => "how much of it is noise can't be told".to_owned(),
    };
    glossary::weak(ui, format!("Held-out error by joint (nMSE): {errors}; {floor}."));
    ui.add_space(GAP);
}

fn effect_text(effect: &MissingEffect, recording: &Recording) -> String {
    let name = effect.effect.name;
    if effect.effect.scope == Scope::Arm {
        name.to_owned()
    } else if effect.joints.len() == recording.joint_count() && effect.joints.len() > 1 {
        format!("{name} on all joints")
    } else {
        format!("{name} on {}", joints_text(&effect.joints))
    }
}

fn chooser(ui: &mut Ui, chosen: &mut usize, report: &Report) {
    if report.effects.len() < 2 {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        for (number, effect) in report.effects.iter().enumerate() {
            let name = effect.effect.name;
            let text = format!("{}. {name} · {:.0} %", number + 1, 100.0 * effect.presence);
            ui.selectable_value(chosen, number, text);
        }
    });
    ui.add_space(4.0);
}

fn effect(ui: &mut Ui, desk: &mut Desk, after: &mut bool, report: &Arc<Report>, chosen: usize, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    let effect = &report.effects[chosen];
    let text = effect_text(effect, recording);
    widgets::card(ui, &text, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("There {:.0} %", 100.0 * effect.presence));
            widgets::share_bar(ui, effect.presence, 90.0, palette.accent);
            ui.add_space(GAP);
            ui.label(format!("in this form {:.0} %", 100.0 * effect.form));
            widgets::share_bar(ui, effect.form, 60.0, palette.weak);
        });
        ui.horizontal_wrapped(|ui| {
            let best = effect
                .nmse_before
                .iter()
                .zip(&effect.nmse_after)
                .map(|(before, after)| before / after)
                .fold(1.0, f64::max);
            if best < 1.05 {
                ui.label(RichText::new("held-out error does not fall").color(palette.warning));
            } else {
                ui.label(format!("held-out error falls up to {best:.*}×", usize::from(best < 10.0)));
            }
            if effect.effect.check_addable().is_err() {
                return;
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let name = effect.effect.name;
                if ui.add_enabled(desk.busy.is_none(), Button::new(format!("Add {name}"))).clicked() {
                    desk.run(Command::AddEffect { effect: effect.effect.id.to_owned(), joints: effect.joints.clone() });
                }
            });
        });
        if !effect.alternatives.is_empty() {
            let others = Alternative::texts(&effect.alternatives).join(", ");
            let text = format!("These data can hardly tell it from {others}.");
            ui.label(RichText::new(text).color(palette.warning));
        }
        ui.horizontal_wrapped(|ui| {
            ui.label("Torque left");
            ui.radio_value(after, false, "without it");
            ui.radio_value(after, true, "with it");
        });
        let panels = figures::evidence(report, chosen, *after, recording);
        let height = if panels.len() > 2 { 190.0 } else { 250.0 };
        let columns = panels.len().clamp(1, 2);
        for row in panels.chunks(columns) {
            ui.columns(columns, |columns| {
                for (ui, panel) in columns.iter_mut().zip(row) {
                    let view = PanelView::new(panel.clone()).height(height);
                    view.show(ui, &mut desk.focus.views, &mut desk.memo.decimator);
                }
            });
        }
        let text = "Points: what the rest of the model leaves on held-out data. Line: the effect as fitted.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    });
    widgets::card(ui, "Parameters, with 95 % intervals", |ui| {
        tables::parameters(ui, "parameters", "interval", effect.parameters.iter());
    });
    widgets::card(ui, "Held-out error before and after", |ui| {
        let rows: Vec<Vec<WidgetText>> = (0..effect.nmse_before.len())
            .map(|joint| {
                vec![
                    recording.joints[joint].name.clone().into(),
                    ticks::percent(effect.nmse_before[joint]).into(),
                    ticks::percent(effect.nmse_after[joint]).into(),
                ]
            })
            .collect();
        widgets::table(ui, "before and after", &["", "nMSE before", "nMSE after"], &rows);
    });
    let about = effect.effect;
    widgets::card(ui, "About this effect", |ui| {
        math::show(ui, about.typeset, &widgets::formula(about.formula), palette.accent);
        ui.label(about.description);
        widgets::weak(ui, format!("Looks like: {}", about.fingerprint));
        widgets::weak(ui, format!("What hides it: {}", about.absorbed));
        widgets::weak(ui, format!("Source: {}", about.source));
    });
}

/// The page for "nothing" and "unknown": answers too, not failures.
fn without_effect(ui: &mut Ui, desk: &mut Desk, report: &Report, recording: &Recording) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "Held-out error beside the noise", |ui| {
        let rows: Vec<Vec<WidgetText>> = (0..report.held_out_nmse.len())
            .map(|joint| {
                let floor = report.noise_floor_nmse.as_ref().map(|floor| floor[joint]);
                let structure =
                    if report.unexplained_joints.contains(&joint) { "more than noise" } else { "noise only" };
                vec![
                    recording.joints[joint].name.clone().into(),
                    ticks::percent(report.held_out_nmse[joint]).into(),
                    floor.map_or("—".to_owned(), ticks::percent).into(),
                    structure.into(),
                ]
            })
            .collect();
        widgets::table(ui, "beside the noise", &["", "held-out nMSE", "noise floor", "what is left is"], &rows);
    });
    let fits_in_training =
        report.fails_on_held_out() && !report.notes.iter().any(|note| matches!(note, Note::NoneExplains { .. }));
    let (text, screen) = if report.verdict == Verdict::NothingMissing {
        (
            "The model explains these measurements as well as their noise allows. That is no proof that it is complete: an \
             effect that this motion does not excite leaves no trace. Look at the ladder for what was gained so far.",
            &ladder::ABOUT,
        )
    } else if fits_in_training {
        (
            "The model explains what it learned from, but not what was held out. Look where it fails: the moment at which that \
             begins, and the state then, say what acts there.",
            &residuals::ABOUT,
        )
    } else {
        (
            "The residual has structure, but no effect of the catalogue explains it on data that it has not seen. Look where it \
             fails: the state over which it has a shape says what kind of effect it is.",
            &residuals::ABOUT,
        )
    };
    widgets::card(ui, "What this means", |ui| {
        ui.label(RichText::new(text).color(palette.text));
        if ui.button(format!("Go to: {}", screen.title)).clicked() {
            desk.orders.push(Order::Show(screen));
        }
    });
}

/// All candidates with their cross-validated drop.
fn candidates(ui: &mut Ui, desk: &mut Desk, report: &Report) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, "All candidates", |ui| {
        let text = "By how much each effect, added alone, divides the squared residual in cross-validation. Effects that look \
                    alike all divide it: this is no probability.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
        ui.add_space(4.0);
        for candidate in &report.ranking {
            row(ui, desk, candidate);
        }
    });
}

fn row(ui: &mut Ui, desk: &mut Desk, candidate: &Candidate) {
    let palette = Palette::in_ui(ui);
    let name = candidate.effect.name;
    let place = candidate.joint.map_or("arm".to_owned(), |joint| format!("joint {}", joint + 1));
    let color = if candidate.accepted() { palette.accent } else { palette.weak };
    let mark = if candidate.accepted() { "✔" } else { "·" };
    let response = ui.horizontal(|ui| {
        ui.label(RichText::new(mark).color(color));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let add = ui.add_enabled(desk.busy.is_none(), egui::Button::new("+").small());
            let spoken = format!("Add {name}, {place}");
            add.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &spoken));
            if add.on_hover_text(format!("{spoken}, whatever the diagnosis says")).clicked() {
                desk.run(Command::AddEffect {
                    effect: candidate.effect.id.to_owned(),
                    joints: candidate.joint.into_iter().collect(),
                });
            }
            ui.label(RichText::new(candidate.divides()).color(color));
            if !candidate.accepted() {
                ui.label(RichText::new("refused").size(SMALL).color(color));
            }
            let name_color = if candidate.accepted() { palette.text } else { palette.weak };
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let text = RichText::new(format!("{name}, {place}")).color(name_color);
                ui.add(egui::Label::new(text).wrap());
            });
        });
    });
    response.response.on_hover_text(candidate.reason());
    if candidate.accepted() {
        ui.label(RichText::new(candidate.reason()).size(SMALL).color(palette.weak));
    }
}
