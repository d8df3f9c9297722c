//! The axes of a chain of joints in rows of Denavit and Hartenberg.
//!
//! The frame of the base of the chain is that of its first axis; gravity is turned into it.
//! Source: Craig, Introduction to Robotics (2005), ch. 3 (how frames are attached to axes).

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};

use crate::arm::chain::{Axis, Chain, Convention};

/// Axes that point along each other within this angle \[rad\] are parallel.
const PARALLEL: f64 = 1e-9;

/// An axis at q = 0, in the frame of the base of the file.
struct Line {
    point: Vector3<f64>,
    direction: Vector3<f64>,
}

impl Line {
    /// The z axis of a frame.
    fn of(frame: &Isometry3<f64>) -> Line {
        Line { point: frame.translation.vector, direction: frame.rotation * Vector3::z() }
    }
}

/// A frame on an axis: its origin and its x axis; z is the axis.
struct Frame {
    origin: Vector3<f64>,
    x: Vector3<f64>,
}

impl Frame {
    fn on(&self, line: &Line) -> Isometry3<f64> {
        let z = &line.direction;
        let turn = Rotation3::from_basis_unchecked(&[self.x, z.cross(&self.x), *z]);
        Isometry3::from_parts(self.origin.into(), UnitQuaternion::from_rotation_matrix(&turn))
    }
}

/// The axes in modified rows; each is the z axis of one of these frames, of which there is at least one. Beside it the frame of each
/// row at q = 0, in the base of the file.
pub(super) fn chain(frames: &[Isometry3<f64>], gravity: Vector3<f64>) -> (Chain, Vec<Isometry3<f64>>) {
    let lines: Vec<Line> = frames.iter().map(Line::of).collect();
    let mut frames: Vec<Frame> = Vec::new();
    // Where the common normal of an axis and the one before meets it.
    let mut feet: Vec<Vector3<f64>> = vec![lines[0].point];
    for (index, own) in lines.iter().enumerate() {
        match lines.get(index + 1) {
            Some(next) => {
                let before = frames.last().map(|frame| frame.x);
                let (frame, foot) = common_normal(own, next, before);
                frames.push(frame);
                feet.push(foot);
            }
            None => {
                let x = frames.last().map_or_else(|| across(&own.direction), |frame| frame.x);
                frames.push(Frame { origin: feet[index], x });
            }
        }
    }
    let gravity = frames[0].on(&lines[0]).rotation.inverse() * gravity;
    let mut axes = vec![Axis::default()];
    for index in 1..lines.len() {
        let (before, own, x) = (&lines[index - 1].direction, &lines[index].direction, &frames[index - 1].x);
        axes.push(Axis {
            a: (feet[index] - frames[index - 1].origin).dot(x),
            alpha: angle(before, own, x),
            d: (frames[index].origin - feet[index]).dot(own),
            theta: angle(x, &frames[index].x, own),
            stated: None,
        });
    }
    let placed = lines.iter().zip(&frames).map(|(line, frame)| frame.on(line)).collect();
    (Chain { convention: Convention::Modified, axes, gravity: gravity.into() }, placed)
}

/// The angle from one vector to another about an axis.
fn angle(from: &Vector3<f64>, to: &Vector3<f64>, about: &Vector3<f64>) -> f64 {
    from.cross(to).dot(about).atan2(from.dot(to))
}

/// Some direction across this one.
fn across(direction: &Vector3<f64>) -> Vector3<f64> {
    let other = if direction.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    (other - direction * direction.dot(&other)).normalize()
}

/// The frame on an axis whose x points along the common normal to the next, and where that meets the next. If they are one line,
/// x stays as it was before.
fn common_normal(own: &Line, next: &Line, before: Option<Vector3<f64>>) -> (Frame, Vector3<f64>) {
    let between = next.point - own.point;
    let normal = own.direction.cross(&next.direction);
    if normal.norm() > PARALLEL {
        let x = normal.normalize();
        // The point of each line that is nearest to the other.
        let along = |one: &Line, other: &Line, gap: &Vector3<f64>| {
            let side = other.direction.cross(&normal);
            one.point + one.direction * (gap.dot(&side) / one.direction.dot(&side))
        };
        let (origin, foot) = (along(own, next, &between), along(next, own, &-between));
        return (Frame { origin, x }, foot);
    }
    let apart = between - own.direction * own.direction.dot(&between);
    let kept = before.map(|x| x - own.direction * own.direction.dot(&x)).filter(|x| x.norm() > 0.1);
    let x = match apart.norm() > PARALLEL {
        true => apart.normalize(),
        false => kept.map_or_else(|| across(&own.direction), |x| x.normalize()),
    };
    (Frame { origin: own.point, x }, own.point + apart)
}
