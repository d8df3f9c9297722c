//! The ladder as a figure.

use std::sync::Arc;

use crate::app::desk::Desk;
use crate::figure::mark::{Bars, Line};
use crate::figure::{Axis, Ink, Panel, ticks};
use crate::session::{Session, Step};
use crate::statistics::ends;

/// The models whose errors are shown: the steps of the ladder, and behind them what is drawn over the current model.
pub fn models(desk: &Desk) -> Vec<Arc<Step>> {
    if desk.focus.hides_ladder {
        return desk.shown_models();
    }
    let others = desk.overlaid().into_iter().map(|(step, _)| step).filter(|step| !desk.session.has_on_ladder(step));
    desk.session.ladder.iter().cloned().chain(others).collect()
}

/// Held-out error of every joint by model, down from 100 % on a logarithmic axis; a line marks the noise floor. Empty where nothing
/// is held out.
pub fn figures(session: &Session, models: &[Arc<Step>]) -> Vec<Panel> {
    let Some(recording) = session.recording.as_deref() else { return Vec::new() };
    let floor = session.current().and_then(|step| step.evaluation.noise_floor_nmse.clone());
    let errors: Vec<Vec<f64>> = models.iter().map(|step| step.evaluation.held_out_nmse()).collect();
    let Some(range) = decades(errors.iter().chain(&floor).flatten().copied()) else { return Vec::new() };
    let names = models.iter().map(|step| step.name.clone()).collect();
    let y = Axis::new("held-out nMSE", "").logarithmic().range(range);
    let mut panel = Panel::new("held-out error by step", [Axis::names("", names), y]);
    for (joint, info) in recording.joints.iter().enumerate() {
        let heights: Vec<[f64; 3]> = errors.iter().map(|errors| [errors[joint], f64::NAN, f64::NAN]).collect();
        let place = [joint, recording.joint_count()];
        let bars = Bars::beside(&info.name, place, &heights, Ink::Series(joint)).written(ticks::percent);
        let sides = bars.bars.iter().map(|[x, ..]| [x - bars.width / 2.0, x + bars.width / 2.0]).collect::<Vec<_>>();
        panel.push(bars);
        if let Some(noise) = floor.as_ref().map(|floor| floor[joint]) {
            let over = |sides: [f64; 2]| Line::through("noise floor", sides.map(|x| [x, noise]), Ink::Text);
            panel = panel.with_all(sides.into_iter().map(over));
        }
    }
    vec![panel]
}

/// From the power of ten below the smallest error to that above what is written over the largest; `None` if there is none above 0.
fn decades(errors: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let [low, high] = ends(errors.filter(|error| error.is_finite() && *error > 0.0));
    let decade = |error: f64| 10f64.powf(error);
    (low <= high).then(|| [decade((0.7 * low).log10().floor()), decade((2.5 * high).log10().ceil())])
}
