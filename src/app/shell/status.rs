//! The bar at the bottom: what is loaded, which model, its error, and what is at work.

use egui::{Align, Button, Label, Layout, RichText, Ui};

use super::frame::Shell;
use crate::app::desk::Order;
use crate::app::glossary;
use crate::app::plot::ticks::percent;
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets::{self, is_narrow, thousands};
use crate::model::Term;
use crate::progress::Progress;

pub fn show(ui: &mut Ui, shell: &mut Shell) {
    let Shell { desk, aside, .. } = shell;
    let palette = Palette::in_ui(ui);
    ui.horizontal(|ui| {
        ui.set_min_height(22.0);
        let small = |text: String| RichText::new(text).size(SMALL).color(palette.weak);
        if let Some(busy) = desk.busy {
            let name = if busy.paused { format!("paused: {}", busy.name) } else { busy.name.to_owned() };
            return at_work(ui, desk.orders, &name, busy.progress);
        }
        if let Some((name, progress)) = aside {
            return at_work(ui, desk.orders, name, progress);
        }
        match desk.session.recording.as_deref() {
            None => drop(ui.label(small("no recording".into()))),
            Some(recording) => {
                let joints = recording.joint_count();
                let joints = if joints == 1 { "1 joint".to_owned() } else { format!("{joints} joints") };
                let samples = thousands(recording.sample_count());
                ui.add(Label::new(small(format!("{} · {joints} · {samples} samples", recording.name))).truncate());
            }
        }
        if let Some(step) = desk.session.current().filter(|_| !is_narrow(ui)) {
            ui.separator();
            let terms: Vec<String> = step.fitted.model.terms.iter().map(Term::label).collect();
            ui.label(small(format!("model: {}", step.name))).on_hover_text(terms.join(" + "));
            ui.separator();
            let errors: Vec<String> = step.evaluation.held_out_nmse().into_iter().map(percent).collect();
            let text = format!("held-out error by joint (nMSE): {}", errors.join(" · "));
            let meaning = glossary::meanings(&text);
            ui.label(small(text)).on_hover_text(meaning);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(small("ready".into())));
    });
}

fn at_work(ui: &mut Ui, orders: &mut Vec<Order>, name: &str, progress: &Progress) {
    let palette = Palette::in_ui(ui);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        if ui.add(Button::new("Stop").small()).on_hover_text("Stop this; the session is not changed (Esc)").clicked() {
            orders.push(Order::Stop);
        }
        widgets::progress(ui, progress.fraction, 160.0);
        let activity =
            if progress.activity.is_empty() { name.to_owned() } else { format!("{name}: {}", progress.activity) };
        ui.add(Label::new(RichText::new(activity).size(SMALL).color(palette.text)).truncate());
    });
}
