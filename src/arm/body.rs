//! What a rigid body weighs and how it resists turning: ten parameters in a frame that is fixed to it, and whether anything could
//! have them.
//!
//! Mass m, first moment h = m c and inertia I about the origin of the frame are possible if and only if the pseudo-inertia
//!
//! ```text
//! J = [ Σ  h ]        Σ = ½ tr(I) 1 − I
//!     [ hᵀ m ]
//! ```
//!
//! is positive definite: then the mass is positive, and each principal moment is less than the sum of the two others.
//! Source: Wensing, Kim and Slotine, IEEE Robotics and Automation Letters 3 (2018) 60.

use nalgebra::{Isometry3, Matrix3, Matrix4, Vector3};

use super::chain::PER_LINK;

/// A rigid body in a frame that is fixed to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub com: Vector3<f64>,
    /// Inertia about the centre of mass, along the axes of the frame \[kg m²\].
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// The parameters of a link of a [`super::chain::Chain`]: m, m c, and the inertia about the origin of the frame.
    pub fn parameters(&self) -> [f64; PER_LINK] {
        let Body { mass, com, inertia } = self;
        let i = inertia + *mass * (Matrix3::identity() * com.norm_squared() - com * com.transpose());
        let h = *mass * com;
        [*mass, h.x, h.y, h.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
    }

    /// The same body in a frame that stands so in this one.
    pub fn seen_from(&self, frame: &Isometry3<f64>) -> Body {
        let turn = frame.rotation.to_rotation_matrix();
        let com = frame.inverse_transform_point(&self.com.into()).coords;
        Body { mass: self.mass, com, inertia: turn.transpose() * self.inertia * turn }
    }

    /// Its pseudo-inertia.
    pub fn pseudo_inertia(&self) -> Matrix4<f64> {
        let about_com = Matrix3::identity() * (0.5 * self.inertia.trace()) - self.inertia;
        let sigma = about_com + self.mass * self.com * self.com.transpose();
        let mut pseudo = Matrix4::zeros();
        pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&sigma);
        for axis in 0..3 {
            pseudo[(axis, 3)] = self.mass * self.com[axis];
            pseudo[(3, axis)] = pseudo[(axis, 3)];
        }
        pseudo[(3, 3)] = self.mass;
        pseudo
    }

    /// The body with this pseudo-inertia, whose mass is not 0.
    pub fn of_pseudo_inertia(pseudo: &Matrix4<f64>) -> Body {
        let mass = pseudo[(3, 3)];
        let com = Vector3::new(pseudo[(0, 3)], pseudo[(1, 3)], pseudo[(2, 3)]) / mass;
        let about_com = pseudo.fixed_view::<3, 3>(0, 0) - mass * com * com.transpose();
        Body { mass, com, inertia: Matrix3::identity() * about_com.trace() - about_com }
    }

    /// Whether something could weigh so and turn so.
    pub fn is_possible(&self) -> bool {
        self.mass > 0.0 && self.pseudo_inertia().cholesky().is_some()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    /// A box of these edges \[m\], turned and off the origin.
    pub(crate) fn brick(mass: f64, [a, b, c]: [f64; 3], at: [f64; 3]) -> Body {
        let moment = |one: f64, two: f64| mass / 12.0 * (one * one + two * two);
        let turn = UnitQuaternion::from_euler_angles(0.3 * a, 1.0, -0.4).to_rotation_matrix();
        let own = Matrix3::from_diagonal(&Vector3::new(moment(b, c), moment(a, c), moment(a, b)));
        Body { mass, com: at.into(), inertia: turn * own * turn.transpose() }
    }

    #[test]
    fn a_body_is_the_same_by_its_pseudo_inertia_and_in_another_frame() {
        let body = brick(2.0, [0.3, 0.1, 0.6], [0.1, -0.2, 0.4]);
        let back = Body::of_pseudo_inertia(&body.pseudo_inertia());
        assert!((back.inertia - body.inertia).norm() < 1e-14 && (back.com - body.com).norm() < 1e-15);
        // A mass at a point of its own frame, by Steiner: about z through the origin m (x² + y²) more.
        let steiner = body.parameters()[9] - body.inertia[(2, 2)];
        assert!((steiner - 2.0 * (0.01 + 0.04)).abs() < 1e-14);
        let frame = Isometry3::new(Vector3::new(0.5, 0.1, -0.3), Vector3::new(0.2, -0.9, 0.4));
        let moved = body.seen_from(&frame);
        assert!((frame * nalgebra::Point3::from(moved.com) - nalgebra::Point3::from(body.com)).norm() < 1e-14);
        assert!((moved.seen_from(&frame.inverse()).inertia - body.inertia).norm() < 1e-14);
    }

    #[test]
    fn what_breaks_the_triangle_inequality_is_not_possible() {
        let body = |moments: [f64; 3], mass: f64| Body {
            mass,
            com: Vector3::new(0.1, 0.2, 0.3),
            inertia: Matrix3::from_diagonal(&moments.into()),
        };
        assert!(body([0.1, 0.2, 0.29], 1.0).is_possible());
        assert!(!body([0.1, 0.2, 0.31], 1.0).is_possible());
        assert!(!body([0.1, 0.2, 0.29], -1.0).is_possible());
        assert!(!body([-0.1, 0.2, 0.25], 1.0).is_possible());
    }
}
