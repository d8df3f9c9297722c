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

/// A noise floor this much below the smallest error is not drawn: bars that reach down to it would all look alike.
const FLOOR_IN_SIGHT: f64 = 0.01;

/// Held-out error of every joint by model, down from 100 % on a logarithmic axis; a line marks the noise floor where it is near. Empty
/// where nothing is held out.
pub fn figures(session: &Session, models: &[Arc<Step>]) -> Vec<Panel> {
    let Some(recording) = session.recording.as_deref() else { return Vec::new() };
    let errors: Vec<Vec<f64>> = models.iter().map(|step| step.evaluation.held_out_nmse()).collect();
    let [smallest, _] = ends(errors.iter().flatten().copied().filter(|error| *error > 0.0));
    let floor = session.current().and_then(|step| step.evaluation.noise_floor_nmse.clone());
    let seen = |noise: &f64| *noise >= FLOOR_IN_SIGHT * smallest;
    let floors = floor.iter().flatten().copied().filter(seen);
    let Some(range) = decades(errors.iter().flatten().copied().chain(floors)) else { return Vec::new() };
    let names = models.iter().map(|step| step.name.clone()).collect();
    let y = Axis::new("held-out nMSE", "").logarithmic().range(range);
    let mut panel = Panel::new("held-out error by step", [Axis::names("", names), y]);
    for (joint, info) in recording.joints.iter().enumerate() {
        let heights: Vec<[f64; 3]> = errors.iter().map(|errors| [errors[joint], f64::NAN, f64::NAN]).collect();
        let place = [joint, recording.joint_count()];
        let bars = Bars::beside(&info.name, place, &heights, Ink::Series(joint)).written(ticks::percent);
        let sides = bars.bars.iter().map(|[x, ..]| [x - bars.width / 2.0, x + bars.width / 2.0]).collect::<Vec<_>>();
        panel.push(bars);
        if let Some(noise) = floor.as_ref().map(|floor| floor[joint]).filter(seen) {
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

#[cfg(test)]
mod tests {
    use super::*;

    use crate::progress::Monitor;
    use crate::session::Command;
    use crate::simulation::Scenario;

    /// The range of errors, and how many lines of noise are drawn, if the noise floor of all joints is this share of the smallest error.
    fn drawn(share: f64) -> ([f64; 2], usize) {
        let simulate = Command::Simulate(Box::new(Scenario::embedded()));
        let mut session = simulate.run(&Session::default(), &Monitor::new()).unwrap();
        let mut step = session.ladder[0].as_ref().clone();
        let errors = step.evaluation.held_out_nmse();
        let [smallest, largest] = ends(errors.iter().copied());
        step.evaluation.noise_floor_nmse = Some(vec![share * smallest; errors.len()]);
        session.ladder = vec![Arc::new(step)];
        let panel = figures(&session, &session.ladder).pop().unwrap();
        let range = panel.y.range.unwrap();
        assert!(range[0] < smallest && range[1] > largest, "{range:?} holds all errors");
        (range, panel.marks.len() - session.recording.as_ref().unwrap().joint_count())
    }

    #[test]
    fn a_noise_floor_far_below_all_errors_does_not_squeeze_them() {
        let ([near, _], lines) = drawn(0.1);
        assert_eq!(lines, 3, "one for each joint of one model");
        let ([far, _], lines) = drawn(1e-9);
        assert_eq!(lines, 0);
        assert!(far >= near);
    }
}
