//! An arm in space at the cursor, in lines: seen from afar, so that equal lengths in one direction stay equal. About each axis
//! measured and predicted torque as arcs; beside one that slides, as arrows along it.

use std::f64::consts::TAU;

use egui::{EventFilter, Key, Response, Sense, Ui};
use serde::{Deserialize, Serialize};

use super::arm::{ARC_POINTS, LARGEST_ARC, RADII, ROOM, SMALLEST_ARC, arc};
use crate::arm::chain::Chain;
use crate::arm::skeleton::{Pivot, Vector};
use crate::figure::mark::{Line, Points, Word};
use crate::figure::{Axis, Ink, Panel};

/// How long the drawn piece of an axis is, as a part of the arm's reach.
const AXIS: f64 = 0.07;
/// How long the axes of the base are, as a part of the arm's reach.
const BASE: f64 = 0.3;
/// How far a drag of a point turns an arm, and a press of an arrow key \[rad\].
const TURN_BY_DRAG: f32 = 0.01;
const TURN_BY_KEY: f64 = 0.1;
/// As far as one can look from above or below \[rad\].
const STEEPEST: f64 = 1.5;

/// From where one looks at an arm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sight {
    /// About the vertical, from the x axis of the base \[rad\].
    pub around: f64,
    /// From above \[rad\].
    pub above: f64,
}

impl Default for Sight {
    /// Isometric: the three axes of the base are equally short.
    fn default() -> Self {
        Sight { around: std::f64::consts::FRAC_PI_4, above: (0.5f64).sqrt().atan() }
    }
}

impl Sight {
    /// Turned by so much \[rad\].
    pub fn turned(self, [around, above]: [f64; 2]) -> Self {
        Sight { around: (self.around + around) % TAU, above: (self.above + above).clamp(-STEEPEST, STEEPEST) }
    }
}

/// What is drawn.
pub struct SpatialPose<'a> {
    /// When \[s\].
    pub time: f64,
    /// Where its axes are.
    pub chain: &'a Chain,
    /// Which of its joints slide.
    pub sliding: &'a [bool],
    /// From where it is seen.
    pub sight: Sight,
    /// Joint positions \[rad or m\].
    pub q: &'a [f64],
    /// Measured torque by joint \[N m or N\].
    pub measured: &'a [f64],
    /// Predicted torque by joint; empty without a model.
    pub predicted: &'a [f64],
    /// Largest torque of each joint, which fixes the scale of its arcs.
    pub largest: &'a [f64],
    /// Where the tip goes \[m\].
    pub path: &'a [Vector],
}

/// The arm in metres.
pub fn panel(pose: &SpatialPose) -> Panel {
    let skeleton = pose.chain.skeleton(pose.q, pose.sliding);
    let eye = Eye::new(pose.chain.gravity, pose.sight);
    let far = |point: &Vector| point.iter().map(|value| value * value).sum::<f64>().sqrt();
    let reach = pose.path.iter().map(far).fold(pose.chain.reach(), f64::max).max(1e-9);
    let axis = |label: &str| Axis::new(label, "m").range([-ROOM * reach, ROOM * reach]);
    let path = |points: Vec<Vector>| points.iter().map(|point| eye.sees(point)).collect::<Vec<_>>();
    let pale = |line: Line| line.opacity(0.45).width(0.8).dash(&[]);
    let mut panel = Panel::new(format!("the arm at t = {:.2} s", pose.time), [axis("across"), axis("up")]).aspect(1.0);
    let around = (0..=96).map(|n| TAU * f64::from(n) / 96.0);
    let ground = around.map(|angle| eye.on_ground([0.5 * reach * angle.cos(), 0.5 * reach * angle.sin()])).collect();
    panel.push(pale(Line::path("", path(ground), Ink::Weak)));
    for (which, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut end = [0.0; 3];
        end[which] = BASE * reach;
        panel.push(pale(Line::path("", path(vec![[0.0; 3], end]), Ink::Weak)));
        end[which] *= 1.12;
        let at = eye.sees(&end);
        panel.push(Word { text: name.to_owned(), at, room: [0.1 * reach; 2], ink: Ink::Weak });
    }
    panel.push(Line::path("path of the tip", path(pose.path.to_vec()), Ink::Weak).opacity(0.6).dash(&[]));
    // What is farther away is drawn first.
    let mut links: Vec<(usize, &Vec<Vector>)> = skeleton.links.iter().enumerate().collect();
    let depth = |line: &[Vector]| line.iter().map(|point| eye.depth(point)).sum::<f64>() / line.len().max(1) as f64;
    links.sort_by(|(_, one), (_, other)| depth(one).total_cmp(&depth(other)));
    for (link, line) in links {
        // What stands before the first joint does not move.
        let (name, ink) = match link {
            0 => (String::new(), Ink::Weak),
            _ => (format!("link {link}"), Ink::Series(link - 1)),
        };
        if line.len() > 1 {
            panel.push(Line::path(name, path(line.clone()), ink).width(4.0).opacity(0.75).dash(&[]));
        }
    }
    for (joint, pivot) in skeleton.joints.iter().enumerate() {
        let along = |part: f64| moved(pivot.at, pivot.frame[2], part * reach);
        let piece = Line::path("", path(vec![along(-AXIS), along(AXIS)]), Ink::Series(joint));
        panel.push(piece.width(2.2).dash(&[]));
        panel.push(Points::new("", path(vec![pivot.at]), Ink::Series(joint)).radius(2.0));
        let slides = pose.sliding.get(joint).copied().unwrap_or(false);
        let largest = pose.largest.get(joint).copied().unwrap_or(1.0).max(1e-12);
        let kinds = [("measured τ", pose.measured, Ink::Measured), ("predicted τ̂", pose.predicted, Ink::Predicted)];
        for ((name, torques, ink), radius) in kinds.into_iter().zip(RADII) {
            let Some(torque) = torques.get(joint) else { continue };
            let part = (torque / largest).clamp(-1.0, 1.0);
            let points = if slides { arrow(pivot, part, radius, reach) } else { about(pivot, part, radius * reach) };
            panel = arc(panel, Line::path(name, path(points), ink).width(1.6));
        }
    }
    panel.with(Points::new("", path(vec![skeleton.tip()]), Ink::Text).radius(1.8))
}

/// Lets an arm in space be looked at from elsewhere.
pub fn turn(ui: &Ui, drawn: &Response, sight: &mut Sight) {
    let dragged = ui.interact(drawn.rect, drawn.id.with("turn"), Sense::drag());
    let by = dragged.drag_delta() * TURN_BY_DRAG;
    *sight = sight.turned([f64::from(-by.x), f64::from(by.y)]);
    if drawn.double_clicked() {
        *sight = Sight::default();
    }
    if drawn.has_focus() {
        let keys = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(drawn.id, keys));
        let pressed = |key| ui.input(|input| input.num_presses(key)) as f64 * TURN_BY_KEY;
        let around = pressed(Key::ArrowLeft) - pressed(Key::ArrowRight);
        *sight = sight.turned([around, pressed(Key::ArrowUp) - pressed(Key::ArrowDown)]);
    }
}

/// Points about the axis of a joint, from its x axis.
fn about(pivot: &Pivot, part: f64, radius: f64) -> Vec<Vector> {
    let angle = part * LARGEST_ARC;
    if angle.abs() < SMALLEST_ARC {
        return Vec::new();
    }
    let at = |n: usize| {
        let (sin, cos) = (angle * n as f64 / ARC_POINTS as f64).sin_cos();
        moved(moved(pivot.at, pivot.frame[0], radius * cos), pivot.frame[1], radius * sin)
    };
    (0..=ARC_POINTS).map(at).collect()
}

/// Beside the axis of a joint that slides, along it.
fn arrow(pivot: &Pivot, part: f64, beside: f64, reach: f64) -> Vec<Vector> {
    let from = moved(pivot.at, pivot.frame[0], beside * reach);
    vec![from, moved(from, pivot.frame[2], part * BASE * reach)]
}

fn moved(from: Vector, direction: Vector, distance: f64) -> Vector {
    [0, 1, 2].map(|axis| from[axis] + distance * direction[axis])
}

fn dot(one: &Vector, other: &Vector) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn cross(one: &Vector, other: &Vector) -> Vector {
    [0, 1, 2].map(|axis| {
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        one[next] * other[last] - one[last] * other[next]
    })
}

/// Who looks: directions on the page, in the frame of the base.
struct Eye {
    right: Vector,
    up: Vector,
    /// Towards who looks.
    near: Vector,
    /// Two directions of the ground, at right angles.
    ground: [Vector; 2],
}

impl Eye {
    /// What falls, falls down on the page, however the base is mounted.
    fn new(gravity: Vector, sight: Sight) -> Self {
        let strength = dot(&gravity, &gravity).sqrt();
        let vertical = if strength > 1e-9 { gravity.map(|value| -value / strength) } else { [0.0, 0.0, 1.0] };
        // The x axis of the base as far as it is level; where it is not at all, the y axis.
        let level = |axis: Vector| moved(axis, vertical, -dot(&axis, &vertical));
        let x = [level([1.0, 0.0, 0.0]), level([0.0, 1.0, 0.0])];
        let first = if dot(&x[0], &x[0]) > 1e-6 { x[0] } else { x[1] };
        let length = dot(&first, &first).sqrt();
        let first = first.map(|value| value / length);
        let second = cross(&vertical, &first);
        let ((sin, cos), (high, flat)) = (sight.around.sin_cos(), sight.above.sin_cos());
        let mix =
            |a: f64, b: f64, c: f64| [0, 1, 2].map(|axis| a * first[axis] + b * second[axis] + c * vertical[axis]);
        Eye {
            right: mix(-sin, cos, 0.0),
            up: mix(-high * cos, -high * sin, flat),
            near: mix(flat * cos, flat * sin, high),
            ground: [first, second],
        }
    }

    fn sees(&self, point: &Vector) -> [f64; 2] {
        [dot(point, &self.right), dot(point, &self.up)]
    }

    /// How near a point is; only differences count.
    fn depth(&self, point: &Vector) -> f64 {
        dot(point, &self.near)
    }

    /// A point of the ground in space.
    fn on_ground(&self, [x, y]: [f64; 2]) -> Vector {
        moved(moved([0.0; 3], self.ground[0], x), self.ground[1], y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eye(gravity: Vector, sight: Sight) -> Eye {
        Eye::new(gravity, sight)
    }

    /// An isometric view: three axes of equal length, 120° apart, the vertical one upright; looked at from +x, +y and +z.
    #[test]
    fn the_first_sight_is_isometric() {
        let eye = eye([0.0, 0.0, -9.81], Sight::default());
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let seen = axes.map(|axis| eye.sees(&axis));
        for [x, y] in seen {
            assert!((x.hypot(y) - (2.0f64 / 3.0).sqrt()).abs() < 1e-12, "{seen:?}");
        }
        assert!(seen[2][0].abs() < 1e-12 && seen[2][1] > 0.0 && seen[0][0] < 0.0 && seen[1][0] > 0.0);
        assert!(axes.iter().all(|axis| eye.depth(axis) > 0.5));
    }

    #[test]
    fn what_falls_falls_down_however_the_base_is_mounted() {
        for gravity in [[0.0, 0.0, 9.81], [9.81, 0.0, 0.0], [0.0, -5.0, 5.0], [0.0; 3]] {
            for sight in [Sight::default(), Sight::default().turned([1.0, -0.9])] {
                let eye = eye(gravity, sight);
                let [across, up] = eye.sees(&gravity);
                assert!(across.abs() < 1e-12 && up <= 0.0, "{gravity:?}");
                assert!((dot(&eye.right, &eye.up)).abs() < 1e-12 && (dot(&eye.up, &eye.up) - 1.0).abs() < 1e-12);
                assert!(cross(&eye.right, &eye.up).iter().zip(&eye.near).all(|(a, b)| (a - b).abs() < 1e-12));
            }
        }
        assert_eq!(Sight::default().turned([0.0, 9.0]).above, STEEPEST);
    }
}
