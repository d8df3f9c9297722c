//! The planar arm in closed form: n revolute joints (1 to 7) in a vertical plane, f64.
//!
//! # Convention
//! The plane has axes x (to the right) and z (up). Link i has the absolute angle
//!
//! ```text
//! θᵢ = φ₀ + s · (q₁ + … + qᵢ)
//! ```
//!
//! measured from +x towards +z, with φ₀ the [`Posture::zero_angle`] and s = ±1 the [`Posture::sense`]. The default is φ₀ = 0,
//! s = +1: at q = 0 the arm points to the right, q grows counter-clockwise.
//!
//! Everything follows from the lumped parameters K (kg m²) and G (kg m), with mᵢ, lᵢ, rᵢ, Iᵢ the mass, length, distance of
//! the centre of mass from the joint and inertia about the centre of mass of link i, and Mⱼ = mⱼ₊₁ + … + mₙ:
//!
//! ```text
//! Kᵢᵢ = Iᵢ + mᵢ rᵢ² + lᵢ² Mᵢ        Kᵢⱼ = lᵢ (mⱼ rⱼ + lⱼ Mⱼ)  for i < j        Gᵢ = mᵢ rᵢ + lᵢ Mᵢ
//! T = ½ Σᵢⱼ Kᵢⱼ cos(θᵢ − θⱼ) θ̇ᵢ θ̇ⱼ        V = g Σᵢ Gᵢ sin θᵢ
//! ```
//!
//! [`dynamics`] holds H, c, g, energies, inverse and forward dynamics; [`kinematics`] the points of the arm; [`regressor`] the
//! torque as a linear function of K and G, and the base parameters. Arms in space are in [`chain`] (their regressor), [`robot`] (from a
//! URDF or an MJCF), [`body`] and [`possible`] (masses that can exist); what makers state of either is in [`stated`].

pub mod body;
pub mod chain;
pub mod dynamics;
pub mod kinematics;
pub mod planar;
pub mod possible;
pub mod regressor;
pub mod robot;
pub mod skeleton;
pub mod stated;

use serde::{Deserialize, Serialize};

/// Most joints that an arm may have.
pub const MOST_JOINTS: usize = 7;
/// Standard gravity as used throughout \[m/s²\].
pub const GRAVITY: f64 = 9.81;

/// A planar arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Links, base first.
    pub links: Vec<Link>,
    /// Gravity \[m/s²\], along −z.
    #[serde(default = "standard_gravity")]
    pub gravity: f64,
    /// Where q = 0 points and which way q grows.
    #[serde(default)]
    pub posture: Posture,
}

/// One link.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Mass \[kg\].
    pub mass: f64,
    /// Distance from its joint to the next \[m\].
    pub length: f64,
    /// Distance from its joint to its centre of mass, along the link \[m\].
    pub com: f64,
    /// Moment of inertia about the centre of mass \[kg m²\].
    pub inertia: f64,
}

/// Where q = 0 points and which way q grows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Posture {
    /// Angle of the first link at q = 0, from +x towards +z \[rad\]: 0 right, π/2 up, −π/2 down.
    pub zero_angle: f64,
    /// Which way q grows.
    #[serde(default)]
    pub sense: Sense,
}

/// Sense of rotation, seen with x to the right and z up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sense {
    /// From +x towards +z.
    #[default]
    CounterClockwise,
    /// From +z towards +x.
    Clockwise,
}

/// The arm is not one that can exist.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArmError {
    /// Too few or too many links.
    #[error("an arm needs 1 to {MOST_JOINTS} links, this one has {0}")]
    LinkCount(usize),
    /// A value out of its range.
    #[error("link {link}: {quantity} is {value}, but must be {must}")]
    Link {
        /// Counted from 1.
        link: usize,
        /// Which quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        must: &'static str,
    },
    /// Gravity is not a finite number.
    #[error("gravity is {0}, but must be a finite number of m/s²")]
    Gravity(f64),
    /// The angle at q = 0 is not a finite number.
    #[error("the zero angle of the posture is {0}, but must be a finite number of rad")]
    ZeroAngle(f64),
}

impl Default for Posture {
    fn default() -> Self {
        Posture::RIGHT
    }
}

impl Posture {
    /// At q = 0 the arm points along +x.
    pub const RIGHT: Posture = Posture { zero_angle: 0.0, sense: Sense::CounterClockwise };
    /// At q = 0 the arm points along +z.
    pub const UP: Posture = Posture { zero_angle: std::f64::consts::FRAC_PI_2, sense: Sense::CounterClockwise };
    /// At q = 0 the arm points along −x.
    pub const LEFT: Posture = Posture { zero_angle: std::f64::consts::PI, sense: Sense::CounterClockwise };
    /// At q = 0 the arm hangs along −z.
    pub const DOWN: Posture = Posture { zero_angle: -std::f64::consts::FRAC_PI_2, sense: Sense::CounterClockwise };

    /// +1 or −1.
    pub fn sign(&self) -> f64 {
        match self.sense {
            Sense::CounterClockwise => 1.0,
            Sense::Clockwise => -1.0,
        }
    }
}

impl Arm {
    /// The arm of the paper's simulation: n uniform rods of 1 m and 1 kg, pointing right at q = 0.
    pub fn uniform(joints: usize) -> Self {
        let rod = Link { mass: 1.0, length: 1.0, com: 0.5, inertia: 1.0 / 12.0 };
        Arm { links: vec![rod; joints], gravity: GRAVITY, posture: Posture::RIGHT }
    }

    /// How many joints it has.
    pub fn joint_count(&self) -> usize {
        self.links.len()
    }

    /// Checks that the arm can exist.
    ///
    /// # Errors
    /// [`ArmError`] names the first link and quantity that can't be.
    pub fn check(&self) -> Result<(), ArmError> {
        if !(1..=MOST_JOINTS).contains(&self.links.len()) {
            return Err(ArmError::LinkCount(self.links.len()));
        }
        if !self.gravity.is_finite() {
            return Err(ArmError::Gravity(self.gravity));
        }
        if !self.posture.zero_angle.is_finite() {
            return Err(ArmError::ZeroAngle(self.posture.zero_angle));
        }
        for (index, link) in self.links.iter().enumerate() {
            let demands = [
                ("mass", link.mass, link.mass > 0.0, "more than 0 kg"),
                ("length", link.length, link.length > 0.0, "more than 0 m"),
                ("com", link.com, link.com.is_finite(), "a finite number of m"),
                ("inertia", link.inertia, link.inertia >= 0.0, "0 kg m² or more"),
            ];
            for (quantity, value, met, must) in demands {
                if !met || !value.is_finite() {
                    return Err(ArmError::Link { link: index + 1, quantity, value, must });
                }
            }
        }
        Ok(())
    }
}

fn standard_gravity() -> f64 {
    GRAVITY
}

#[cfg(test)]
pub(crate) mod testing {
    //! Random arms and states for property tests.

    use proptest::prelude::*;
    use proptest::test_runner::TestCaseError;

    use super::*;

    /// An arm of 1 to 4 links in any posture, with q, q̇ and q̈.
    pub(crate) fn arm_and_state() -> impl Strategy<Value = (Arm, [Vec<f64>; 3])> {
        (1..=4usize).prop_flat_map(|joints| {
            let state = |scale: f64| prop::collection::vec(-scale..scale, joints);
            (arm(joints), state(3.0), state(3.0), state(5.0)).prop_map(|(arm, q, qd, qdd)| (arm, [q, qd, qdd]))
        })
    }

    fn arm(joints: usize) -> impl Strategy<Value = Arm> {
        let link = (0.2..3.0, 0.2..1.0, 0.05..0.9, 0.005..0.1).prop_map(|(mass, length, share, inertia)| Link {
            mass,
            length,
            com: share * length,
            inertia,
        });
        let sense = prop_oneof![Just(Sense::Clockwise), Just(Sense::CounterClockwise)];
        let posture = (-3.0..3.0, sense).prop_map(|(zero_angle, sense)| Posture { zero_angle, sense });
        (prop::collection::vec(link, joints), -5.0..15.0, posture).prop_map(|(links, gravity, posture)| Arm {
            links,
            gravity,
            posture,
        })
    }

    /// Whether two vectors agree to `tolerance`, relative to their largest element (at least 1).
    pub(crate) fn close(found: &[f64], expected: &[f64], tolerance: f64) -> Result<(), TestCaseError> {
        let largest = expected.iter().fold(1.0_f64, |largest, value| largest.max(value.abs()));
        for (a, b) in found.iter().zip(expected) {
            prop_assert!((a - b).abs() <= tolerance * largest, "{found:?} is not {expected:?}");
        }
        prop_assert_eq!(found.len(), expected.len());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_not_be_is_named() {
        let message = |change: fn(&mut Arm)| {
            let mut arm = Arm::uniform(2);
            change(&mut arm);
            arm.check().unwrap_err().to_string()
        };
        assert!(Arm::uniform(7).check().is_ok());
        assert_eq!(message(|arm| arm.links.clear()), "an arm needs 1 to 7 links, this one has 0");
        assert_eq!(message(|arm| arm.links[1].mass = -1.0), "link 2: mass is -1, but must be more than 0 kg");
        assert_eq!(message(|arm| arm.links[0].length = f64::NAN), "link 1: length is NaN, but must be more than 0 m");
        assert_eq!(message(|arm| arm.gravity = f64::INFINITY), "gravity is inf, but must be a finite number of m/s²");
        assert!(message(|arm| arm.posture.zero_angle = f64::NAN).contains("zero angle"));
    }

    #[test]
    fn a_file_needs_the_links_only() {
        let arm: Arm = serde_json::from_str(r#"{"links":[{"mass":1,"length":1,"com":0.5,"inertia":0.1}]}"#).unwrap();
        assert_eq!((arm.gravity, arm.posture), (GRAVITY, Posture::RIGHT));
        assert!(serde_json::from_str::<Arm>(r#"{"links":[],"colour":1}"#).is_err());
    }
}
