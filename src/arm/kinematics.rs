//! Where the arm is: absolute angles, joints, tip and centres of mass. Coordinates \[x, z\] \[m\], base at \[0, 0\].
//!
//! As in all of [`crate::arm`], states have one value per link, and there are at most [`MOST_JOINTS`] links.

use super::{Arm, MOST_JOINTS, Posture};

/// One value per link; those beyond the last link are not used.
pub(super) type PerLink = [f64; MOST_JOINTS];

/// What the links do in absolute angles: θ \[rad\], θ̇ \[rad/s\], θ̈ \[rad/s²\].
pub(super) struct Absolute {
    pub(super) angle: PerLink,
    pub(super) velocity: PerLink,
    pub(super) acceleration: PerLink,
}

impl Absolute {
    /// From the joints' position, velocity and acceleration, base first.
    pub(super) fn of(
        posture: Posture,
        q: impl Iterator<Item = f64>,
        qd: impl Iterator<Item = f64>,
        qdd: impl Iterator<Item = f64>,
    ) -> Self {
        let sign = posture.sign();
        Absolute {
            angle: running_sum(posture.zero_angle, sign, q),
            velocity: running_sum(0.0, sign, qd),
            acceleration: running_sum(0.0, sign, qdd),
        }
    }
}

fn running_sum(start: f64, sign: f64, joints: impl Iterator<Item = f64>) -> PerLink {
    let mut sums = [0.0; MOST_JOINTS];
    let mut sum = start;
    for (place, joint) in sums.iter_mut().zip(joints) {
        sum += sign * joint;
        *place = sum;
    }
    sums
}

impl Arm {
    /// The joints from the base to the tip, n + 1 points, at joint positions `q` \[rad\].
    pub fn points(&self, q: &[f64]) -> Vec<[f64; 2]> {
        let mut point = [0.0, 0.0];
        let mut points = vec![point];
        for (link, direction) in self.links.iter().zip(self.directions(q)) {
            point = along(point, direction, link.length);
            points.push(point);
        }
        points
    }

    /// The end of the last link at joint positions `q` \[rad\].
    pub fn tip(&self, q: &[f64]) -> [f64; 2] {
        let links = self.links.iter().zip(self.directions(q));
        links.fold([0.0, 0.0], |point, (link, direction)| along(point, direction, link.length))
    }

    /// The centre of mass of each link, n points, at joint positions `q` \[rad\].
    pub fn centres_of_mass(&self, q: &[f64]) -> Vec<[f64; 2]> {
        let links = self.links.iter().zip(self.directions(q));
        let joints = self.points(q);
        links.zip(joints).map(|((link, direction), joint)| along(joint, direction, link.com)).collect()
    }

    /// Unit vectors along the links.
    fn directions(&self, q: &[f64]) -> impl Iterator<Item = [f64; 2]> {
        let angles = running_sum(self.posture.zero_angle, self.posture.sign(), q.iter().copied());
        angles.into_iter().map(|angle| [angle.cos(), angle.sin()])
    }
}

fn along(from: [f64; 2], direction: [f64; 2], distance: f64) -> [f64; 2] {
    [from[0] + distance * direction[0], from[1] + distance * direction[1]]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::arm::Sense;

    fn assert_near(found: &[[f64; 2]], expected: &[[f64; 2]]) {
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn the_posture_says_where_zero_points_and_which_way_q_grows() {
        let mut arm = Arm::uniform(2);
        let q = [0.0, FRAC_PI_2];
        assert_near(&arm.points(&q), &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        arm.posture.sense = Sense::Clockwise;
        assert_near(&arm.points(&q), &[[0.0, 0.0], [1.0, 0.0], [1.0, -1.0]]);
        arm.posture = Posture::UP;
        assert_near(&arm.points(&q), &[[0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]]);
        arm.posture = Posture::DOWN;
        assert_near(&arm.points(&q), &[[0.0, 0.0], [0.0, -1.0], [1.0, -1.0]]);
    }

    #[test]
    fn tip_and_centres_lie_on_the_links() {
        let arm = Arm::uniform(3);
        let q = [0.3, -0.7, 1.1];
        let points = arm.points(&q);
        assert_near(&[arm.tip(&q)], &points[3..]);
        let middles: Vec<_> =
            points.windows(2).map(|ends| [0, 1].map(|axis| 0.5 * (ends[0][axis] + ends[1][axis]))).collect();
        assert_near(&arm.centres_of_mass(&q), &middles);
    }
}
