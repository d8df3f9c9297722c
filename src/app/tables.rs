//! Tables that several screens have: parameters with their intervals, and errors by joint.

use std::sync::Arc;

use egui::{RichText, Ui, WidgetText};

use super::plot::ticks;
use super::theme::{Palette, SMALL};
use super::{glossary, widgets};
use crate::model::Parameter;
use crate::recording::Recording;
use crate::session::{Spread, Step};
use crate::training::Recipe;
use crate::training::fit::Plan;

/// Parameters with their intervals, which are called so, and what is stated of them where something is.
pub fn parameters<'a>(ui: &mut Ui, id: &str, intervals: &str, parameters: impl Iterator<Item = &'a Parameter> + Clone) {
    let is_stated = parameters.clone().any(|parameter| parameter.stated.is_some());
    let mut header = vec!["parameter", "joint", "value", intervals, "as stated", "unit"];
    let mut rows: Vec<Vec<WidgetText>> =
        parameters.map(|parameter| parameter_row(parameter, Palette::in_ui(ui))).collect();
    if !is_stated {
        header.remove(STATED);
        rows.iter_mut().for_each(|row| drop(row.remove(STATED)));
    }
    widgets::table(ui, id, &header, &rows);
}

/// The column of what is stated.
const STATED: usize = 4;

fn parameter_row(parameter: &Parameter, palette: &Palette) -> Vec<WidgetText> {
    let interval = match parameter.interval {
        Some([low, high]) => format!("{} … {}", ticks::number(low), ticks::number(high)),
        None => "not shown by the data".to_owned(),
    };
    let name = parameter.name.replace('_', " ");
    let name = if name == parameter.symbol { name } else { format!("{}  ({name})", parameter.symbol) };
    vec![
        name.into(),
        parameter.joint.map_or("arm".to_owned(), |joint| (joint + 1).to_string()).into(),
        ticks::number(parameter.value).into(),
        interval.into(),
        match (parameter.stated, parameter.contradicts_stated()) {
            (None, _) => "".into(),
            (Some(stated), Some(true)) => RichText::new(ticks::number(stated)).color(palette.warning).into(),
            (Some(stated), _) => ticks::number(stated).into(),
        },
        parameter.unit.clone().into(),
    ]
}

/// The error of each joint.
pub fn errors(ui: &mut Ui, recording: &Recording, step: &Step) {
    widgets::card(ui, "Error on held-out data", |ui| {
        let rows: Vec<Vec<WidgetText>> = step
            .evaluation
            .held_out
            .iter()
            .zip(&step.evaluation.train)
            .enumerate()
            .map(|(joint, (held_out, train))| {
                vec![
                    recording.joints[joint].name.clone().into(),
                    ticks::percent(held_out.nmse).into(),
                    ticks::percent(train.nmse).into(),
                    ticks::number(held_out.mse.sqrt()).into(),
                ]
            })
            .collect();
        let [.., unit] = recording.units();
        widgets::table(ui, "errors", &["", "nMSE", "on train", &format!("RMS [{unit}]")], &rows);
        let text = "nMSE: squared error over squared measurement; 0 % is perfect.";
        let label = ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
        glossary::explained(label, glossary::Word::Nmse);
    });
}

/// The error of each joint over several trainings of one model.
pub fn errors_of_seeds(ui: &mut Ui, recording: &Recording, seeds: &[Arc<Step>]) {
    widgets::card(ui, &format!("Error on held-out data, {} seeds", seeds.len()), |ui| {
        let row = |joint: usize| {
            let errors = seeds.iter().map(|step| step.evaluation.held_out[joint].nmse);
            let numbers = Spread::of(errors).map(|spread| [spread.mean, spread.least, spread.greatest]);
            let name = WidgetText::from(recording.joints[joint].name.clone());
            [name]
                .into_iter()
                .chain(numbers.into_iter().flatten().map(|number| ticks::percent(number).into()))
                .collect()
        };
        let rows: Vec<Vec<WidgetText>> = (0..recording.joint_count()).map(row).collect();
        widgets::table(ui, "errors of seeds", &["", "mean nMSE", "least", "greatest"], &rows);
        let text = "The current model is the seed with the smallest validation error; all are in the table of models (Ctrl+M).";
        ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
    });
}

/// The settings of a training in a line.
pub fn plan_text(plan: &Plan) -> String {
    let options = &plan.options;
    let hidden: Vec<String> = plan.layers.hidden.iter().map(usize::to_string).collect();
    format!(
        "{}, {} {}, {} epochs, batch {}, rate {}, seed {}",
        recipe_name(plan.recipe),
        hidden.join(" × "),
        format!("{:?}", plan.layers.activation).to_lowercase(),
        options.epochs,
        options.batch,
        options.rate,
        options.seed
    )
}

/// What a recipe is called.
pub fn recipe_name(recipe: Recipe) -> &'static str {
    match recipe {
        Recipe::Ours => "ours",
        Recipe::Thorough => "thorough",
        Recipe::Paper => "the paper's",
    }
}
