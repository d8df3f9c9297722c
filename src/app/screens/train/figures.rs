//! Training as figures: errors and learning rate over the epochs.

use std::sync::Arc;

use crate::app::plot::Along;
use crate::figure::colours::PREDICTED_DASH;
use crate::figure::mark::{Band, Line, Points};
use crate::figure::{Axis, Ink, Panel};
use crate::progress::Epoch;
use crate::session::{Spread, Step};
use crate::training::fit::Plan;

/// Most points of the plan that are drawn.
const MOST_PLANNED: u64 = 400;
/// Width of a curve relative to that of other lines.
const CURVE: f64 = 1.8;
/// Size of the point that marks one epoch, relative to that of other points.
const MARKED: f64 = 2.0;
/// How much is seen of what was smoothed.
const RAW: f64 = 0.35;

/// What is plotted of an epoch.
type OfEpoch = fn(&Epoch) -> Option<f64>;

/// Validation and held-out error of a training, smoothed by `share`, with the held-out errors of other models in their inks; and its
/// loss, which is of another measure and has an axis of its own.
pub fn errors(epochs: &[Epoch], share: f64, others: &[(Arc<Step>, Ink)]) -> [Panel; 2] {
    let x: Vec<f64> = epochs.iter().map(|epoch| epoch.epoch as f64).collect();
    let loss: Vec<f64> = epochs.iter().map(|epoch| epoch.loss).collect();
    let validation: Vec<f64> = epochs.iter().map(|epoch| epoch.validation.unwrap_or(f64::NAN)).collect();
    let held_out: Vec<f64> = epochs.iter().map(|epoch| epoch.held_out.unwrap_or(f64::NAN)).collect();
    let ends = others.iter().filter_map(|(step, _)| step.history.last()).chain(epochs.last());
    let last = ends.map(|epoch| epoch.epoch as f64).fold(2.0, f64::max);
    let [mut panel, loss_panel] = panels(last);
    if let Some((epoch, error)) = best(epochs).and_then(|epoch| Some((epoch.epoch as f64, epoch.validation?))) {
        panel.push(Points::new("", vec![[epoch, error]], Ink::Text).radius(MARKED));
    }
    // Trainings of before, and those without held-out data, have no validation part.
    let raw = |name: &'static str, y: &[f64], ink: Ink| {
        let line = || Line::new(format!("{name}, as it is"), x.clone(), y.to_vec(), ink).opacity(RAW);
        (share > 0.0 && y.iter().any(|value| value.is_finite())).then(|| line().together(name))
    };
    let curve = |name: &str, y: &[f64], ink: Ink| {
        let is_there = y.iter().any(|value| value.is_finite());
        is_there.then(|| Line::new(name, x.clone(), smoothed(y, share), ink).width(CURVE))
    };
    let [on_validation, on_held_out, on_train] = ["validation nMSE", "held-out nMSE", "loss on train"];
    let inks = [Ink::Series(1), Ink::Predicted];
    panel = panel.with_all(raw(on_validation, &validation, inks[0])).with_all(raw(on_held_out, &held_out, inks[1]));
    for (step, ink) in others {
        panel = panel.with_all(of_other(step, *ink));
    }
    panel = panel.with_all(curve(on_validation, &validation, inks[0]));
    panel = panel.with_all(curve(on_held_out, &held_out, inks[1]));
    let loss_ink = Ink::Series(0);
    [panel, loss_panel.with_all(raw(on_train, &loss, loss_ink)).with_all(curve(on_train, &loss, loss_ink))]
}

/// Empty panels of the errors and of the loss over so many epochs.
fn panels(last: f64) -> [Panel; 2] {
    [("errors", "nMSE"), ("loss", "loss")]
        .map(|(title, label)| Panel::new(title, [axis("", last), Axis::new(label, "").logarithmic()]))
}

/// The same of trainings that differ by their seed: their mean, and the band between the least and the greatest.
pub fn of_seeds(seeds: &[Arc<Step>], others: &[(Arc<Step>, Ink)]) -> [Panel; 2] {
    let histories: Vec<&[Epoch]> = seeds.iter().map(|step| step.history.as_slice()).collect();
    let last = histories.iter().map(|history| history.len()).max().unwrap_or(0);
    let mut panels = panels(last.max(2) as f64);
    for (step, ink) in others.iter().filter(|(step, _)| seeds.iter().all(|own| own.generation != step.generation)) {
        of_other(step, *ink).into_iter().for_each(|line| panels[0].push(line));
    }
    let kinds: [(&str, usize, OfEpoch, Ink); 3] = [
        ("validation nMSE", 0, |epoch| epoch.validation, Ink::Series(1)),
        ("held-out nMSE", 0, |epoch| epoch.held_out, Ink::Predicted),
        ("loss on train", 1, |epoch| Some(epoch.loss), Ink::Series(0)),
    ];
    for (name, place, value, ink) in kinds {
        let at = |epoch: usize| Spread::of(histories.iter().filter_map(|history| value(history.get(epoch)?)));
        let spreads: Vec<(f64, Spread)> =
            (0..last).filter_map(|epoch| Some(((epoch + 1) as f64, at(epoch)?))).collect();
        if spreads.is_empty() {
            continue;
        }
        let band: Vec<[f64; 3]> =
            spreads.iter().map(|(epoch, spread)| [*epoch, spread.least, spread.greatest]).collect();
        panels[place].push(Band::new("", band, ink));
        let mean = spreads.iter().map(|(epoch, spread)| [*epoch, spread.mean]);
        panels[place].push(Line::through(format!("{name}, mean of {} seeds", seeds.len()), mean, ink).width(CURVE));
    }
    panels
}

/// The held-out error of another model; `None` if nothing was held out of its training.
fn of_other(step: &Step, ink: Ink) -> Option<Line> {
    let points = step.history.iter().filter_map(|epoch| Some([epoch.epoch as f64, epoch.held_out?]));
    let points: Vec<[f64; 2]> = points.collect();
    (!points.is_empty()).then(|| Line::through(&step.name, points, ink).width(CURVE))
}

/// The learning rate: of the whole plan ahead, and of the epochs that are done, the last of which is marked.
pub fn rate(done: &[Epoch], plan: &Plan, batches: u64) -> Panel {
    let options = &plan.options;
    let every = options.epochs.div_ceil(MOST_PLANNED).max(1);
    let planned = (1..=options.epochs).step_by(every as usize).chain([options.epochs]);
    let planned = planned.map(|epoch| [epoch as f64, options.rate_in(epoch, batches)]);
    let planned = Line::through("planned", planned, Ink::Weak).dash(PREDICTED_DASH).width(CURVE);
    let axes = [axis("epoch, to the end of the plan", options.epochs.max(2) as f64), Axis::new("rate", "")];
    let mut panel = Panel::new("learning rate", axes).with(planned);
    if let Some(last) = done.last() {
        let rates = done.iter().map(|epoch| [epoch.epoch as f64, epoch.rate]);
        panel.push(Line::through("done", rates, Ink::Series(4)).width(CURVE));
        panel.push(Points::new("", vec![[last.epoch as f64, last.rate]], Ink::Text).radius(MARKED));
    }
    panel
}

fn axis(label: &str, last: f64) -> Axis {
    Axis::new(label, "").range([1.0, last]).linked(Along::Epoch)
}

/// The running mean of the logarithms, in which each epoch before counts `share` times as much as the next; gaps stay gaps.
fn smoothed(raw: &[f64], share: f64) -> Vec<f64> {
    let (mut sum, mut weight) = (0.0, 0.0);
    let mut mean = |value: &f64| {
        if !(value.is_finite() && *value > 0.0) {
            return f64::NAN;
        }
        (sum, weight) = (share * sum + value.ln(), share * weight + 1.0);
        (sum / weight).exp()
    };
    if share > 0.0 { raw.iter().map(&mut mean).collect() } else { raw.to_vec() }
}

/// The epoch whose weights are kept.
pub fn best(epochs: &[Epoch]) -> Option<&Epoch> {
    epochs.iter().min_by(|one, other| one.deciding_error().total_cmp(&other.deciding_error()))
}
