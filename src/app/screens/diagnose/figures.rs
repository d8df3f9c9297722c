//! What the screen shows, as figures: the evidence for an effect.

use std::sync::Arc;

use crate::app::plot::Along;
use crate::app::screens::residuals::table::Quantity;
use crate::diagnosis::{Evidence, Report};
use crate::effect;
use crate::figure::mark::{Line, Points};
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::recording::Recording;

/// Width of what is explained.
const STRONG: f64 = 1.86;
/// Radius of points.
const SMALL: f64 = 0.6;

/// The evidence for the effect `chosen` of a report, without it in the model or with it: what is left of the torque over the
/// state on which the effect depends.
pub fn evidence(report: &Arc<Report>, chosen: usize, after: bool, recording: &Recording) -> Vec<Panel> {
    let Some(effect) = report.effects.get(chosen) else { return Vec::new() };
    let panel = |place: usize| panel(report, [chosen, place], after, recording);
    (0..effect.evidence.len()).map(panel).collect()
}

fn panel(report: &Arc<Report>, [chosen, place]: [usize; 2], after: bool, recording: &Recording) -> Panel {
    let evidence = &report.effects[chosen].evidence[place];
    let joint = &recording.joints[evidence.joint];
    let unit = joint.kind.units();
    let (name, label, x_unit, along) = match evidence.axis {
        effect::Axis::Time => ("time", "time t of each trajectory", "s", Along::Time),
        axis => {
            let quantity = Quantity::from(axis);
            let (name, label, x_unit) = quantity.text(unit);
            (name, label, x_unit, quantity.along(evidence.joint))
        }
    };
    let ends = [evidence.explained.first(), evidence.explained.last()];
    let extent = [ends[0].map_or(0.0, |point| point[0]), ends[1].map_or(1.0, |point| point[0])];
    let axes = [Axis::new(label, x_unit).range(extent).linked(along), Axis::new("", unit[3])];
    let panel = Panel::new(format!("{}: {} left against {name}", joint.name, joint.kind.effort()), axes);
    if after {
        return panel
            .with(Points::new("", left_after(evidence), Ink::Residual).radius(SMALL).opacity(0.5))
            .with(Line::through("", extent.map(|x| [x, 0.0]), Ink::Text).width(STRONG).dash(&[]));
    }
    let of = |part: fn(&Evidence) -> &[[f64; 2]]| {
        Shared::of(report, move |report| part(&report.effects[chosen].evidence[place]))
    };
    let explained = of(|evidence| &evidence.explained);
    let panel =
        panel.with(Points::new("", of(|evidence| &evidence.residual), Ink::Residual).radius(SMALL).opacity(0.5));
    if is_curve(&explained) {
        let line = Line::through("explained", explained.iter().copied(), Ink::Predicted).width(STRONG).dash(&[]);
        // Over time there is nothing between two parts that are held out.
        panel.with(if evidence.axis == effect::Axis::Time { line.sampled() } else { line })
    } else {
        panel.with(Points::new("", explained, Ink::Predicted).radius(SMALL))
    }
}

/// What is left once the effect is in the model: both lists are of the same samples, the explained one sorted by state.
fn left_after(evidence: &Evidence) -> Vec<[f64; 2]> {
    let mut left = evidence.residual.clone();
    left.sort_by(|one, other| one[0].total_cmp(&other[0]));
    for (left, explained) in left.iter_mut().zip(&evidence.explained) {
        left[1] -= explained[1];
    }
    left
}

/// Whether the points, sorted along the axis, are a function of it. A payload's torque, say, is none of one state: as a line
/// it would be a scribble.
fn is_curve(points: &[[f64; 2]]) -> bool {
    let values = || points.iter().map(|point| point[1]);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let steps: f64 = points.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs()).sum();
    // A curve goes up and down a few times; a cloud jumps about a third of its height at every sample.
    steps < 8.0 * (high - low)
}
