//! What happens outside the data, as figures.

use std::sync::Arc;

use crate::app::desk::{Desk, time_extent};
use crate::app::plot::Along;
use crate::figure::mark::{Band, Line};
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::recording::Recording;
use crate::session::{Session, Step};
use crate::simulation::extrapolation::{Curve, Point, Replay, Sweep};

/// Width of a curve relative to that of other lines.
const CURVE: f64 = 1.8;
/// Width of a line that is seen under another one.
const UNDER: f64 = 1.36;
/// How much of a band is seen.
const FAINT: f64 = 0.16;

/// The error of every model over the scale, of one joint or of all together. What is hidden is left out, as far as the ladder does
/// not need it.
pub fn errors(desk: &Desk, recording: &Recording, sweep: &Sweep, joint: Option<usize>) -> Panel {
    let joint = joint.filter(|joint| *joint < recording.joint_count());
    let scales = || sweep.curves.iter().flat_map(|curve| &curve.points).map(|point| point.scale);
    let extent = [scales().fold(f64::INFINITY, f64::min), scales().fold(f64::NEG_INFINITY, f64::max)];
    let x = Axis::new(format!("times the {}", sweep.stretch.name()), "").range(extent).linked(Along::Stretch);
    let mut panel = Panel::new("error (nMSE), logarithmic", [x, Axis::default().logarithmic()]);
    for (number, group) in trainings(desk.session, &sweep.curves).iter().enumerate() {
        let Some(ink) = group.iter().find_map(|curve| ink_of(desk, curve, number)) else { continue };
        let Drawn { name, line, band } = Drawn::of(group, joint);
        panel.push(Band { opacity: FAINT, ..Band::new("", band, ink) });
        panel.push(Line::through(name, line, ink).width(CURVE));
    }
    panel
}

/// The ink of a model: as on all screens, or by its place if it is drawn for the ladder's sake; `None` if it is hidden.
fn ink_of(desk: &Desk, curve: &Curve, number: usize) -> Option<Ink> {
    // What was deleted since is shown as it was computed.
    let Some(step) = desk.session.model(&curve.model) else { return Some(Ink::Series(number)) };
    let is_current = desk.session.current().is_some_and(|current| current.generation == step.generation);
    let own = if is_current { Some(Ink::Predicted) } else { desk.focus.overlaid.ink(step.generation) };
    let is_on_ladder = || desk.session.has_on_ladder(step) && !desk.focus.hides_ladder;
    own.or_else(|| is_on_ladder().then_some(Ink::Series(number)))
}

/// Torque and velocity of one joint along a replay, with the torque of other models.
pub fn replay(
    recording: &Recording,
    replay: &Arc<Replay>,
    others: &[(Arc<Step>, Ink, Arc<Replay>)],
    joint: usize,
) -> [Panel; 2] {
    let info = &recording.joints[joint];
    let [_, velocity, _, torque] = info.kind.units();
    let time = Shared::of(replay, |replay| &replay.motion.time);
    let x = || Axis::new("time t", "s").range(time_extent(&time)).linked(Along::ReplayTime);
    let of = |title: &str, unit| Panel::new(format!("{}: {title}", info.name), [x(), Axis::new("", unit)]);
    let mut torques = of(&format!("{} at this scale", info.kind.effort()), torque);
    if replay.exact {
        let word = if recording.seal.is_some() { "exact τ" } else { "measured τ" };
        let exact = Shared::of(replay, move |replay| &replay.motion.tau[joint]);
        torques.push(Line::new(word, time.clone(), exact, Ink::Measured).sampled().width(UNDER));
    }
    for (step, ink, replay) in others {
        let predicted = Shared::of(replay, move |replay| &replay.predicted[joint]);
        torques.push(Line::new(&step.name, time.clone(), predicted, *ink).sampled());
    }
    let predicted = Shared::of(replay, move |replay| &replay.predicted[joint]);
    torques.push(Line::new("predicted τ̂", time.clone(), predicted, Ink::Predicted).sampled());
    let speed = Shared::of(replay, move |replay| &replay.motion.qd[joint]);
    let line = Line::new("q̇", time.clone(), speed, Ink::Series(joint)).sampled();
    [torques, of("velocity q̇", velocity).with(line)]
}

/// Curves of trainings that differ in nothing but their seed belong together.
fn trainings<'a>(session: &Session, curves: &'a [Curve]) -> Vec<Vec<&'a Curve>> {
    let run = |curve: &Curve| session.model(&curve.model)?.run.as_deref();
    let mut groups: Vec<Vec<&Curve>> = Vec::new();
    for curve in curves {
        let is_sister = |group: &&mut Vec<&Curve>| match (run(curve), run(group[0])) {
            (Some(own), Some(first)) => {
                own.differs_by_seed_only(first) && own.plan.options.seed != first.plan.options.seed
            }
            _ => false,
        };
        match groups.iter_mut().find(is_sister) {
            Some(group) => group.push(curve),
            None => groups.push(vec![curve]),
        }
    }
    groups
}

/// A curve ready to be drawn.
struct Drawn {
    name: String,
    line: Vec<[f64; 2]>,
    band: Vec<[f64; 3]>,
}

impl Drawn {
    /// Of one joint or of all together. One model has the band of its blocks, if of all joints; several have that from the best
    /// to the worst, around their median, the geometric mean of the two in the middle.
    fn of(curves: &[&Curve], joint: Option<usize>) -> Self {
        let error = |point: &Point| joint.map_or(point.overall, |joint| point.joints[joint]);
        // Of trainings of one model the first is named after it, the others by their seeds, too.
        let names = curves.iter().map(|curve| &curve.model);
        let name = names.min_by_key(|name| name.chars().count()).cloned().unwrap_or_default();
        let first = &curves[0].points;
        let within = |band: &[f64; 3]| band.iter().all(|value| value.is_finite() && *value > 0.0);
        if curves.len() == 1 {
            let of_blocks = |point: &Point| [point.scale, point.band[0], point.band[1]];
            let line = first.iter().map(|point| [point.scale, error(point)]).collect();
            let band = first.iter().filter(|_| joint.is_none()).map(of_blocks).filter(within).collect();
            return Drawn { name, line, band };
        }
        let mut drawn =
            Drawn { name: format!("{name}, {} trainings", curves.len()), line: Vec::new(), band: Vec::new() };
        for (number, point) in first.iter().enumerate() {
            let mut errors: Vec<f64> = curves.iter().filter_map(|curve| curve.points.get(number)).map(error).collect();
            errors.sort_by(f64::total_cmp);
            let (least, most) = (errors[0], errors[errors.len() - 1]);
            let median = (errors[(errors.len() - 1) / 2] * errors[errors.len() / 2]).sqrt();
            drawn.line.push([point.scale, median]);
            drawn.band.push([point.scale, least, most]);
        }
        drawn.band.retain(within);
        drawn
    }
}
