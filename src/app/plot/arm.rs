//! The arm at the cursor, with measured and predicted torque as arcs about the joints.

use std::f64::consts::TAU;

use crate::arm::Arm;
use crate::figure::mark::{Arrow, Frame, Line, Points, Word};
use crate::figure::{Axis, Ink, Panel};

/// An arc of the largest torque goes this far about its joint \[rad\].
pub(super) const LARGEST_ARC: f64 = 4.5;
/// Points of an arc.
pub(super) const ARC_POINTS: usize = 40;
/// Radii of the arcs of measured and predicted torque, as parts of the arm's reach.
pub(super) const RADII: [f64; 2] = [0.13, 0.18];
/// The drawing reaches so much farther than the arm.
pub(super) const ROOM: f64 = 1.16;
/// Smaller arcs have no arrow \[rad\].
pub(super) const SMALLEST_ARC: f64 = 0.02;

/// What is drawn.
pub struct Pose<'a> {
    /// When \[s\].
    pub time: f64,
    /// Geometry and posture; masses do not matter.
    pub arm: &'a Arm,
    /// Joint positions \[rad\].
    pub q: &'a [f64],
    /// Measured torque by joint \[N m\].
    pub measured: &'a [f64],
    /// Predicted torque by joint \[N m\]; empty without a model.
    pub predicted: &'a [f64],
    /// Largest torque of each joint, which fixes the scale of its arcs \[N m\].
    pub largest: &'a [f64],
    /// Where the tip goes \[m\].
    pub path: &'a [[f64; 2]],
}

/// The arm in metres: the arcs of a joint are as long as its torques, the largest of the trajectory is `LARGEST_ARC`.
pub fn panel(pose: &Pose) -> Panel {
    let reach: f64 = pose.arm.links.iter().map(|link| link.length).sum::<f64>().max(1e-9);
    let axis = |label: &str| Axis::new(label, "m").range([-ROOM * reach, ROOM * reach]);
    let circle = (0..=96).map(|n| TAU * f64::from(n) / 96.0).map(|angle| [reach * angle.cos(), reach * angle.sin()]);
    let base = [[-0.12 * reach, 0.12 * reach], [-0.085 * reach, -0.045 * reach]];
    let mut panel = Panel::new(format!("the arm at t = {:.2} s", pose.time), [axis("x"), axis("z")])
        .aspect(1.0)
        .with(Line::path("", circle, Ink::Weak).opacity(0.3).width(0.7).dash(&[]))
        .with(Line::path("", [[-ROOM * reach, 0.0], [ROOM * reach, 0.0]], Ink::Weak).opacity(0.3).width(0.7).dash(&[]))
        .with(Frame { sides: base, ink: Ink::Weak })
        .with(Line::path("path of the tip", pose.path.to_vec(), Ink::Weak).opacity(0.6).dash(&[]));
    let points = pose.arm.points(pose.q);
    for (link, ends) in points.windows(2).enumerate() {
        let line = Line::path(format!("link {}", link + 1), ends.to_vec(), Ink::Series(link));
        panel.push(line.width(5.0).opacity(0.75).dash(&[]));
    }
    for (joint, center) in points.iter().enumerate().take(pose.q.len()) {
        panel.push(Points::new("", vec![*center], Ink::Series(joint)).radius(2.6));
        let largest = pose.largest.get(joint).copied().unwrap_or(1.0).max(1e-12);
        let kinds = [("measured τ", pose.measured, Ink::Measured), ("predicted τ̂", pose.predicted, Ink::Predicted)];
        for ((name, torques, ink), radius) in kinds.into_iter().zip(RADII) {
            let Some(torque) = torques.get(joint) else { continue };
            let angle = pose.arm.posture.sign() * (torque / largest).clamp(-1.0, 1.0) * LARGEST_ARC;
            panel = arc(panel, Line::path(name, around(*center, radius * reach, angle), ink).width(1.8));
        }
    }
    let below =
        Word { text: "g ↓".to_owned(), at: [-1.05 * reach, -1.08 * reach], room: [0.2 * reach; 2], ink: Ink::Weak };
    panel.with(Points::new("", points[points.len() - 1..].to_vec(), Ink::Text).radius(1.8)).with(below)
}

/// Points from the right of `center`, counter-clockwise for positive angles.
fn around([x, z]: [f64; 2], radius: f64, angle: f64) -> Vec<[f64; 2]> {
    let at = |n: usize| {
        let angle = angle * n as f64 / ARC_POINTS as f64;
        [x + radius * angle.cos(), z + radius * angle.sin()]
    };
    if angle.abs() < SMALLEST_ARC { Vec::new() } else { (0..=ARC_POINTS).map(at).collect() }
}

/// An arc with an arrow at its end, if it is long enough for one.
pub(super) fn arc(panel: Panel, line: Line) -> Panel {
    let (ink, len) = (line.ink, line.x.len());
    let end = |n: usize| [line.x[n], line.y[n]];
    let ends = (len > 1).then(|| [end(len - 2), end(len - 1)]);
    let panel = panel.with(line);
    match ends {
        Some(ends) => panel.with(Arrow { ends, ink }),
        None => panel,
    }
}
