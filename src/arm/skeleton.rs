//! Where the axes of an arm in space are, as it stands: what is drawn of it. Coordinates \[x, y, z\] \[m\] in the frame of its base.

use nalgebra::{Matrix3, Vector3};

use super::chain::{Chain, Convention};

/// A point or a direction in space.
pub type Vector = [f64; 3];

/// An arm in space, as it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Skeleton {
    /// Its joints, base first.
    pub joints: Vec<Pivot>,
    /// The links between them, each a line with corners: the first leads from the base to the first joint, the last to the tip.
    pub links: Vec<Vec<Vector>>,
}

/// A joint in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pivot {
    /// The origin of its frame.
    pub at: Vector,
    /// Its frame as unit vectors: x and y lie across the axis, about or along z it moves.
    pub frame: [Vector; 3],
}

impl Skeleton {
    /// Where the arm ends: behind the last joint by what the axes state, or at that joint.
    pub fn tip(&self) -> Vector {
        self.links.last().and_then(|link| link.last()).copied().unwrap_or_default()
    }
}

impl Chain {
    /// How the arm stands at joint positions `q` \[rad, or m of joints that slide\].
    pub fn skeleton(&self, q: &[f64], sliding: &[bool]) -> Skeleton {
        let (mut rotation, mut at) = (Matrix3::identity(), Vector3::zeros());
        let (mut joints, mut links) = (Vec::new(), Vec::new());
        for (joint, frame) in self.frames().into_iter().enumerate() {
            let position = q.get(joint).copied().unwrap_or(0.0);
            let slides = sliding.get(joint).copied().unwrap_or(false);
            let own = Matrix3::from_fn(|row, column| frame.rotation[row][column]);
            let (axis, offset) = (rotation * own.column(2), rotation * Vector3::from(frame.offset));
            // First along the common normal of both axes, then along the joint's own.
            let along = offset.dot(&axis);
            let corner = at + offset - along * axis;
            let end = at + offset + if slides { position * axis } else { Vector3::zeros() };
            links.push(line([at, corner, end]));
            let turned = if slides { Matrix3::identity() } else { about_z(position) };
            (rotation, at) = (rotation * own * turned, end);
            let column = |which: usize| rotation.column(which).into_owned().into();
            joints.push(Pivot { at: at.into(), frame: [column(0), column(1), column(2)] });
        }
        let behind = match (self.convention, self.axes.last()) {
            (Convention::Standard, Some(last)) => rotation * Vector3::x() * last.a,
            _ => Vector3::zeros(),
        };
        links.push(line([at, at, at + behind]));
        Skeleton { joints, links }
    }

    /// No point of the arm is farther from its base, as long as nothing slides \[m\].
    pub fn reach(&self) -> f64 {
        self.axes.iter().map(|axis| axis.a.hypot(axis.d)).sum()
    }
}

/// A line without steps of no length.
fn line(points: [Vector3<f64>; 3]) -> Vec<Vector> {
    let mut line: Vec<Vector> = points.map(Into::into).to_vec();
    line.dedup_by(|a, b| a.iter().zip(b.iter()).all(|(a, b)| (a - b).abs() < 1e-12));
    line
}

fn about_z(angle: f64) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::arm::chain::Axis;

    fn near(found: Vector, expected: Vector) {
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} is not {expected:?}");
    }

    /// Universal Robots' own axes. By hand: at q = 0 the UR10 is stretched along −x with its wrist to −y; with the shoulder turned
    /// up by −90° it stands upright.
    #[test]
    fn a_ur10_stands_as_its_maker_draws_it() {
        let row = |a: f64, d: f64, alpha: f64| Axis { a, d, alpha, ..Axis::default() };
        let axes = vec![
            row(0.0, 0.1273, FRAC_PI_2),
            row(-0.612, 0.0, 0.0),
            row(-0.5723, 0.0, 0.0),
            row(0.0, 0.163941, FRAC_PI_2),
            row(0.0, 0.1157, -FRAC_PI_2),
            row(0.0, 0.0922, 0.0),
        ];
        let arm = Chain { convention: Convention::Standard, axes, gravity: [0.0, 0.0, -9.81] };
        let stretched = arm.skeleton(&[0.0; 6], &[false; 6]);
        near(stretched.joints[0].at, [0.0, 0.0, 0.1273]);
        near(stretched.joints[2].at, [-0.612, 0.0, 0.1273]);
        near(stretched.tip(), [-0.612 - 0.5723, -0.163941 - 0.0922, 0.1273 - 0.1157]);
        near(stretched.joints[1].frame[2], [0.0, -1.0, 0.0]);
        let upright = arm.skeleton(&[0.0, -FRAC_PI_2, 0.0, 0.0, 0.0, 0.0], &[false; 6]);
        near(upright.joints[2].at, [0.0, 0.0, 0.1273 + 0.612]);
        assert!(upright.tip()[2] > 1.2 && arm.reach() > 1.2);
        // The lengths of links do not depend on how it stands.
        let any = arm.skeleton(&[0.3, -0.7, 1.1, 2.0, -0.4, 0.9], &[false; 6]);
        let length = |line: &Vec<Vector>| -> f64 {
            line.windows(2).map(|ends| (Vector3::from(ends[1]) - Vector3::from(ends[0])).norm()).sum()
        };
        for (one, other) in stretched.links.iter().zip(&any.links) {
            assert!((length(one) - length(other)).abs() < 1e-12);
        }
    }

    #[test]
    fn what_slides_goes_along_its_axis() {
        let axes = vec![Axis::default(), Axis { alpha: FRAC_PI_2, a: 0.5, ..Axis::default() }];
        let arm = Chain { convention: Convention::Modified, axes, gravity: [0.0, 0.0, -9.81] };
        let stands = arm.skeleton(&[FRAC_PI_2, 0.2], &[false, true]);
        // Turned by a quarter: x of the base is y of the arm; the second axis is −y of the arm, now +x.
        near(stands.tip(), [0.2, 0.5, 0.0]);
    }
}
