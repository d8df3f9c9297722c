//! An arm in space whose axes are known and whose masses are not: its torque as a linear function of ten parameters a link.
//!
//! Each link has a mass, three first moments and six moments of inertia about its own frame, which is fixed to it and whose
//! z axis is the axis of its joint. Along a motion the recursive Newton–Euler equations give the force and moment that each
//! parameter causes, and the axes hand them down to the base. Which combinations a recording can show (the base parameters)
//! is found by the rank of these columns, as for the planar arm.
//! Sources: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), ch. 9; Craig, Introduction to
//! Robotics (2005), ch. 3 (the two conventions for axes).

use nalgebra::{Isometry3, Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

use super::MOST_JOINTS;
use super::stated::{Limits, Resistance, Stated};

/// Where the axes of a serial arm are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    /// How `axes` is to be read.
    pub convention: Convention,
    /// One row a joint, base first.
    pub axes: Vec<Axis>,
    /// Acceleration of free fall in the frame of the base \[m/s²\]; along −z if absent.
    #[serde(default = "down")]
    pub gravity: [f64; 3],
}

/// The two ways to write Denavit and Hartenberg's parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Convention {
    /// The row of joint i leads from its axis to the next: Rot_z(q + theta) Trans_z(d) Trans_x(a) Rot_x(alpha).
    Standard,
    /// The row of joint i leads from the axis before to its own: Rot_x(alpha) Trans_x(a) Rot_z(q + theta) Trans_z(d).
    Modified,
}

/// Four numbers that place one axis against its neighbour, each 0 if absent; and what is stated of its joint.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Axis {
    /// Distance along x \[m\].
    pub a: f64,
    /// Angle about x \[rad\].
    pub alpha: f64,
    /// Distance along z \[m\]; a sliding joint adds its q.
    pub d: f64,
    /// Angle about z at q = 0 \[rad\]; a turning joint adds its q.
    pub theta: f64,
    /// What is stated of its joint and of what moves with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stated: Option<Stated>,
}

/// The axes can't be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChainError {
    /// Another number of joints than the data, or than is supported.
    #[error("they are {axes}, but the recording has {joints} joints (1 to {MOST_JOINTS} are supported)")]
    Count {
        /// How many axes.
        axes: usize,
        /// How many joints.
        joints: usize,
    },
    /// A number is NaN or infinite.
    #[error("a number of axis {0} is not finite")]
    NotFinite(usize),
    /// Gravity is NaN or infinite.
    #[error("gravity is not finite")]
    Gravity,
}

fn down() -> [f64; 3] {
    [0.0, 0.0, -super::GRAVITY]
}

/// An element of the regressor that is so small beside the largest one of the same state is what rounding left of terms that cancel.
/// A column of such elements must be none: scaled to the length of the others it would be noise that a fit can use.
const ROUNDING: f64 = 1e-13;

/// Parameters of one link.
pub const PER_LINK: usize = 10;
const NAMES: [&str; PER_LINK] = ["m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

/// How the frame of a link stands in the one before, at q = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Out of this frame into the one before, row after row.
    pub rotation: [[f64; 3]; 3],
    /// Its origin, in the one before \[m\].
    pub offset: [f64; 3],
}

/// How one frame stands in the one before.
#[derive(Clone, Copy)]
struct Step {
    rotation: Matrix3<f64>,
    offset: Vector3<f64>,
}

impl Step {
    fn then(self, next: Step) -> Step {
        Step { rotation: self.rotation * next.rotation, offset: self.offset + self.rotation * next.offset }
    }

    fn about_x(axis: &Axis) -> Step {
        let rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), axis.alpha).into_inner();
        Step { rotation, offset: Vector3::x() * axis.a }
    }

    fn about_z(theta: f64, d: f64) -> Step {
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), theta).into_inner();
        Step { rotation, offset: Vector3::z() * d }
    }

    /// What is only rounding in it is 0: the cosine of a right angle is not 6e-17.
    fn cleaned(self) -> Step {
        let clean = |value: f64| if value.abs() < 1e-15 { 0.0 } else { value };
        Step { rotation: self.rotation.map(clean), offset: self.offset.map(clean) }
    }

    /// This step, then a turn about z.
    fn turned(&self, angle: f64) -> Step {
        let (sin, cos) = angle.sin_cos();
        let [x, y, z] = [0, 1, 2].map(|column| self.rotation.column(column));
        let rotation = Matrix3::from_columns(&[x * cos + y * sin, y * cos - x * sin, z.into()]);
        Step { rotation, offset: self.offset }
    }

    /// This step, then one along z.
    fn slid(&self, by: f64) -> Step {
        Step { offset: self.offset + self.rotation.column(2) * by, ..*self }
    }
}

impl Chain {
    /// Checks that all numbers are finite.
    ///
    /// # Errors
    /// [`ChainError`].
    pub fn check(&self) -> Result<(), ChainError> {
        self.check_for(self.axes.len())
    }

    /// Checks it for an arm of so many joints.
    ///
    /// # Errors
    /// [`ChainError`].
    pub fn check_for(&self, joints: usize) -> Result<(), ChainError> {
        let axes = self.axes.len();
        if axes != joints || !(1..=MOST_JOINTS).contains(&axes) {
            return Err(ChainError::Count { axes, joints });
        }
        let finite = |axis: &Axis| {
            let is_placed = [axis.a, axis.alpha, axis.d, axis.theta].iter().all(|value| value.is_finite());
            is_placed && axis.stated.as_ref().is_none_or(Stated::is_finite)
        };
        if let Some(number) = self.axes.iter().position(|axis| !finite(axis)) {
            return Err(ChainError::NotFinite(number + 1));
        }
        if self.gravity.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(ChainError::Gravity) }
    }

    /// Names of all parameters, link after link: `m1`, `mx1`, …, `Izz1`, `m2`, …
    pub fn parameter_names(&self) -> Vec<String> {
        let names = |link: usize| NAMES.iter().map(move |name| format!("{name}{link}"));
        (1..=self.axes.len()).flat_map(names).collect()
    }

    /// Unit of the parameter with this index.
    pub fn parameter_unit(index: usize) -> &'static str {
        match index % PER_LINK {
            0 => "kg",
            1..=3 => "kg m",
            _ => "kg m²",
        }
    }

    /// Whether it states what its links weigh, at least one of them.
    pub fn states_links(&self) -> bool {
        self.stated().any(|stated| stated.link.is_some())
    }

    /// The parameters that it states for its links, ten each in the order of [`Chain::parameter_names`]; a link of which it says nothing
    /// weighs nothing.
    pub fn stated_parameters(&self) -> Vec<f64> {
        self.stated().flat_map(|stated| stated.link.unwrap_or_default()).collect()
    }

    /// What it states to resist each joint; empty if nothing does.
    pub fn resistances(&self) -> Vec<Resistance> {
        let all: Vec<Resistance> = self.stated().map(|stated| stated.resistance).collect();
        if all.iter().all(Resistance::is_none) { Vec::new() } else { all }
    }

    /// The limits that it states for this joint.
    pub fn limits(&self, joint: usize) -> Limits {
        self.axes.get(joint).and_then(|axis| axis.stated).unwrap_or_default().limits
    }

    fn stated(&self) -> impl Iterator<Item = Stated> {
        self.axes.iter().map(|axis| axis.stated.unwrap_or_default())
    }

    /// This chain with gravity turned by a quarter about the y axis of the base.
    pub fn turned(&self) -> Chain {
        let [x, y, z] = self.gravity;
        Chain { gravity: [-z, y, x], ..self.clone() }
    }

    /// The steps from frame to frame at q = 0; in each frame the joint's axis is z.
    fn steps(&self) -> Vec<Step> {
        let mut before = Step { rotation: Matrix3::identity(), offset: Vector3::zeros() };
        let step = |axis: &Axis| {
            let along_z = Step::about_z(axis.theta, axis.d);
            match self.convention {
                Convention::Modified => Step::about_x(axis).then(along_z),
                Convention::Standard => {
                    let step = before.then(along_z);
                    before = Step::about_x(axis);
                    step
                }
            }
        };
        self.axes.iter().map(step).map(Step::cleaned).collect()
    }

    /// How the frame of each link stands in the one before, at q = 0; what is only rounding in it is 0. The joint's axis is z.
    pub fn frames(&self) -> Vec<Frame> {
        let frame = |step: Step| Frame {
            rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| step.rotation[(row, column)])),
            offset: [0, 1, 2].map(|row| step.offset[row]),
        };
        self.steps().into_iter().map(frame).collect()
    }

    /// What computes the regressor of one state after another. `sliding[joint]`: whether the joint slides.
    pub fn regressor(&self, sliding: &[bool]) -> Regressor {
        Regressor { steps: self.steps(), sliding: sliding.to_vec(), gravity: Vector3::from(self.gravity) }
    }
}

/// Computes the regressor of a [`Chain`], or of an arm whose frames are known otherwise.
pub struct Regressor {
    steps: Vec<Step>,
    sliding: Vec<bool>,
    gravity: Vector3<f64>,
}

impl Regressor {
    /// Of joints whose frames stand so in each other at q = 0, the first in the base; the axis of each is its z.
    pub(super) fn of_frames(frames: &[Isometry3<f64>], sliding: &[bool], gravity: Vector3<f64>) -> Self {
        let step = |frame: &Isometry3<f64>| Step {
            rotation: frame.rotation.to_rotation_matrix().into_inner(),
            offset: frame.translation.vector,
        };
        Regressor { steps: frames.iter().map(step).map(Step::cleaned).collect(), sliding: sliding.to_vec(), gravity }
    }

    /// Fills the regressor of one state: `rows[joint][parameter]`, n × 10 n, row after row.
    ///
    /// What a parameter asks of a joint is the power of its force and moment while the joint alone moves at unit speed.
    ///
    /// # Panics
    /// If `rows` does not have n · 10 n elements.
    pub fn fill(&self, q: &[f64], qd: &[f64], qdd: &[f64], rows: &mut [f64]) {
        let n = self.steps.len();
        let width = n * PER_LINK;
        assert_eq!(rows.len(), n * width, "the regressor of {n} joints has {n} × {width} elements");
        rows.fill(0.0);
        let moved = &self.moved(q, qd, qdd)[..n];
        let mut asked = [[(Vector3::zeros(), Vector3::zeros()); PER_LINK]; MOST_JOINTS];
        for (asked, LinkMotion { omega, alpha, acceleration, .. }) in asked.iter_mut().zip(moved) {
            *asked = wrenches(omega, alpha, acceleration);
        }
        for (joint, row) in rows.chunks_exact_mut(width).enumerate() {
            // How fast the link and its origin move while the joint does.
            let axis = Vector3::z();
            let (mut turning, mut moving) =
                if self.sliding[joint] { (Vector3::zeros(), axis) } else { (axis, Vector3::zeros()) };
            for link in joint..n {
                if link > joint {
                    let step = &moved[link].step;
                    moving = step.rotation.tr_mul(&(moving + turning.cross(&step.offset)));
                    turning = step.rotation.tr_mul(&turning);
                }
                let places = row[link * PER_LINK..(link + 1) * PER_LINK].iter_mut();
                for (place, (force, moment)) in places.zip(&asked[link]) {
                    *place = moving.dot(force) + turning.dot(moment);
                }
            }
        }
        let rounding = ROUNDING * rows.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        rows.iter_mut().filter(|value| value.abs() <= rounding).for_each(|value| *value = 0.0);
    }

    /// The torque of one state with these parameters (ten for each link, in the order of the regressor's columns): what the regressor
    /// times them is, a link at a time. Source: the recursive Newton-Euler algorithm of Luh, Walker and Paul, J. Dyn. Sys. Meas.
    /// Control 102 (1980) 69.
    ///
    /// # Panics
    /// If there are fewer than 10 n parameters, or fewer than n places for the torque.
    pub fn torque(&self, q: &[f64], qd: &[f64], qdd: &[f64], parameters: &[f64], torque: &mut [f64]) {
        let moved = &self.moved(q, qd, qdd)[..self.steps.len()];
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (link, LinkMotion { step, omega, alpha, acceleration }) in moved.iter().enumerate().rev() {
            let own = &parameters[link * PER_LINK..(link + 1) * PER_LINK];
            let first = Vector3::new(own[1], own[2], own[3]);
            let inertia = Matrix3::new(own[4], own[5], own[6], own[5], own[7], own[8], own[6], own[8], own[9]);
            force += own[0] * acceleration + alpha.cross(&first) + omega.cross(&omega.cross(&first));
            moment += first.cross(acceleration) + inertia * alpha + omega.cross(&(inertia * omega));
            torque[link] = if self.sliding[link] { force.z } else { moment.z };
            force = step.rotation * force;
            moment = step.rotation * moment + step.offset.cross(&force);
        }
    }

    /// How each link moves, in its own frame; what is beyond the last link is at rest.
    fn moved(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> [LinkMotion; MOST_JOINTS] {
        let z = Vector3::z();
        let (mut omega, mut alpha, mut acceleration) = (Vector3::zeros(), Vector3::zeros(), -self.gravity);
        let mut moved = [LinkMotion::REST; MOST_JOINTS];
        for (link, (from, moved)) in self.steps.iter().zip(&mut moved).enumerate() {
            let slides = self.sliding[link];
            let step = if slides { from.slid(q[link]) } else { from.turned(q[link]) };
            let carried = acceleration + alpha.cross(&step.offset) + omega.cross(&omega.cross(&step.offset));
            let (before, turned) = (step.rotation.tr_mul(&omega), step.rotation.tr_mul(&alpha));
            // Its product with z.
            let across = Vector3::new(before.y, -before.x, 0.0);
            acceleration = step.rotation.tr_mul(&carried);
            if slides {
                acceleration += 2.0 * across * qd[link] + z * qdd[link];
                (omega, alpha) = (before, turned);
            } else {
                omega = before + z * qd[link];
                alpha = turned + across * qd[link] + z * qdd[link];
            }
            *moved = LinkMotion { step, omega, alpha, acceleration };
        }
        moved
    }
}

/// How a link moves, in its own frame.
#[derive(Clone, Copy)]
struct LinkMotion {
    /// From the frame before it.
    step: Step,
    omega: Vector3<f64>,
    alpha: Vector3<f64>,
    /// Of its origin, gravity taken off.
    acceleration: Vector3<f64>,
}

impl LinkMotion {
    const REST: LinkMotion = {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        let step = Step { rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), offset: zero };
        LinkMotion { step, omega: zero, alpha: zero, acceleration: zero }
    };
}

/// Force and moment about the origin of the link's frame that one unit of each parameter needs.
fn wrenches(
    omega: &Vector3<f64>,
    alpha: &Vector3<f64>,
    acceleration: &Vector3<f64>,
) -> [(Vector3<f64>, Vector3<f64>); PER_LINK] {
    let none = Vector3::zeros();
    let mut wrenches = [(none, none); PER_LINK];
    wrenches[0] = (*acceleration, none);
    for (axis, unit) in [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().enumerate() {
        let force = alpha.cross(&unit) + omega.cross(&omega.cross(&unit));
        wrenches[1 + axis] = (force, unit.cross(acceleration));
    }
    let mut parameter = 4;
    for row in 0..3 {
        for column in row..3 {
            let times = |vector: &Vector3<f64>| {
                let mut product = none;
                product[row] = vector[column];
                product[column] = vector[row];
                product
            };
            wrenches[parameter] = (none, times(alpha) + omega.cross(&times(omega)));
            parameter += 1;
        }
    }
    wrenches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{Arm, Link, Posture};
    use crate::signals::Signals;

    /// Revolute and sliding joints, every parameter: the torque is the regressor times the parameters.
    #[test]
    fn the_torque_is_the_regressor_times_the_parameters() {
        let axis = |alpha: f64, a: f64, d: f64| Axis { alpha, a, d, ..Axis::default() };
        let axes = vec![axis(0.4, 0.1, 0.3), axis(-1.2, 0.5, 0.0), axis(0.7, 0.2, -0.1)];
        let chain = Chain { convention: Convention::Modified, axes, gravity: [0.5, -1.0, -9.7] };
        let (q, qd, qdd) = ([0.3, -0.7, 1.1], [1.0, -2.0, 0.5], [3.0, 1.0, -4.0]);
        let parameters: Vec<f64> = (0..30).map(|number| (1.0 + f64::from(number)).sin()).collect();
        for sliding in [[false; 3], [false, true, false]] {
            let regressor = chain.regressor(&sliding);
            let mut rows = vec![0.0; 90];
            regressor.fill(&q, &qd, &qdd, &mut rows);
            let mut torque = [0.0; 3];
            regressor.torque(&q, &qd, &qdd, &parameters, &mut torque);
            for (joint, torque) in torque.iter().enumerate() {
                let expected: f64 = rows[joint * 30..][..30].iter().zip(&parameters).map(|(a, b)| a * b).sum();
                assert!((torque - expected).abs() < 1e-12 * expected.abs().max(1.0), "{torque} is not {expected}");
            }
        }
    }

    /// The axes of an arm stand at right angles and its first one is vertical, so many parameters do nothing on a joint. Rounding
    /// must not let them.
    #[test]
    fn what_a_parameter_does_not_do_is_zero() {
        let half = std::f64::consts::FRAC_PI_2;
        let axis = |a: f64, alpha: f64, d: f64| Axis { a, alpha, d, theta: 0.1, ..Axis::default() };
        let axes = vec![axis(0.0, half, 0.13), axis(-0.61, 0.0, 0.0), axis(-0.57, 0.0, 0.0), axis(0.0, half, 0.16)];
        let chain = Chain { convention: Convention::Standard, axes, gravity: down() };
        let regressor = chain.regressor(&[false; 4]);
        let mut most = [0.0f64; 160];
        for state in 0..200 {
            let signal = |phase: f64| [0, 1, 2, 3].map(|joint| (f64::from(state * (joint + 3)) * 0.37 + phase).sin());
            let mut rows = [0.0; 160];
            regressor.fill(&signal(0.0), &signal(1.0), &signal(2.0), &mut rows);
            most.iter_mut().zip(rows).for_each(|(most, value)| *most = most.max(value.abs()));
        }
        assert!(most.iter().all(|&most| most == 0.0 || most > 1e-3), "{most:?}");
        // Of the first link only the inertia about its axis counts.
        let first: Vec<usize> = (0..PER_LINK).filter(|&parameter| most[parameter] > 0.0).collect();
        assert_eq!(first, [9]);
    }

    #[test]
    fn a_planar_arm_in_space_has_the_torque_of_the_closed_form() {
        let link = |mass, length, com, inertia| Link { mass, length, com, inertia };
        let links = vec![link(2.0, 0.8, 0.3, 0.05), link(1.5, 0.5, 0.2, 0.02), link(0.7, 0.3, 0.1, 0.01)];
        let arm = Arm { links: links.clone(), gravity: 9.81, posture: Posture::RIGHT };
        let axis = |a| Axis { a, ..Axis::default() };
        // The arm's plane is x–z and it turns from x to z: with y up, z of the chain is its axis.
        let gravity = [0.0, -9.81, 0.0];
        let standard =
            Chain { convention: Convention::Standard, axes: links.iter().map(|l| axis(l.length)).collect(), gravity };
        let modified = Chain {
            convention: Convention::Modified,
            axes: vec![axis(0.0), axis(links[0].length), axis(links[1].length)],
            gravity,
        };
        let (q, qd, qdd) = ([0.3, -0.7, 1.1], [1.0, -2.0, 0.5], [3.0, 1.0, -4.0]);
        let signal = |values: [f64; 3]| Signals::from_samples(3, &values);
        let expected = arm.inverse_dynamics_along(&signal(q), &signal(qd), &signal(qdd));
        for chain in [standard, modified] {
            let mut rows = vec![0.0; 3 * 30];
            chain.regressor(&[false; 3]).fill(&q, &qd, &qdd, &mut rows);
            for joint in 0..3 {
                let mut torque = 0.0;
                for (number, link) in links.iter().enumerate() {
                    let row = &rows[joint * 30 + number * 10..][..10];
                    torque += link.mass * row[0]
                        + link.mass * link.com * row[1]
                        + (link.inertia + link.mass * link.com.powi(2)) * row[9];
                }
                assert!((torque - expected[joint][0]).abs() < 1e-12, "{torque} {}", expected[joint][0]);
            }
        }
    }

    /// Power = change of energy, with all parameters, a sliding joint and axes that point everywhere.
    #[test]
    fn work_becomes_energy() {
        let axes = vec![
            Axis { a: 0.1, alpha: 0.3, d: 0.4, theta: 0.2, stated: None },
            Axis { a: 0.5, alpha: -1.2, d: -0.1, theta: 0.7, stated: None },
            Axis { a: -0.2, alpha: 1.5, d: 0.3, theta: -0.4, stated: None },
            Axis { a: 0.3, alpha: 0.8, d: 0.2, theta: 1.1, stated: None },
        ];
        let sliding = [false, false, true, false];
        let parameters: Vec<f64> = (0..40).map(|index| 1.0 + (index as f64 * 1.7).sin()).collect();
        for convention in [Convention::Standard, Convention::Modified] {
            let chain = Chain { convention, axes: axes.clone(), gravity: [1.0, -2.0, -9.0] };
            let torque = |chain: &Chain, state: [[f64; 4]; 3]| {
                let mut rows = vec![0.0; 4 * 40];
                chain.regressor(&sliding).fill(&state[0], &state[1], &state[2], &mut rows);
                std::array::from_fn::<f64, 4, _>(|joint| {
                    rows[joint * 40..][..40].iter().zip(&parameters).map(|(row, value)| row * value).sum()
                })
            };
            let weightless = Chain { gravity: [0.0; 3], ..chain.clone() };
            let motion = |t: f64| {
                let phase = |joint: usize| t * (1.0 + joint as f64 * 0.3) + joint as f64;
                let rate = |joint: usize| 1.0 + joint as f64 * 0.3;
                [
                    std::array::from_fn(|joint| phase(joint).sin()),
                    std::array::from_fn(|joint| rate(joint) * phase(joint).cos()),
                    std::array::from_fn(|joint| -rate(joint).powi(2) * phase(joint).sin()),
                ]
            };
            let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            // Kinetic energy: ½ q̇ᵀ M q̇, where M q̇ is the torque of the acceleration q̇ at rest without weight.
            let kinetic = |t: f64| {
                let [q, qd, _] = motion(t);
                0.5 * dot(qd, torque(&weightless, [q, [0.0; 4], qd]))
            };
            let (t, h) = (0.37, 1e-5);
            let state = motion(t);
            let inertial = dot(state[1], torque(&weightless, state));
            let change = (kinetic(t + h) - kinetic(t - h)) / (2.0 * h);
            assert!((inertial - change).abs() < 1e-6 * change.abs().max(1.0), "{inertial} {change}");
            // Gravity does no work on a closed path: its torque is the gradient of a potential.
            let gravity = |q: [f64; 4]| torque(&chain, [q, [0.0; 4], [0.0; 4]]);
            for (i, j) in [(0, 1), (1, 2), (2, 3), (0, 3)] {
                let slope = |along: usize, of: usize| {
                    let shifted = |by: f64| {
                        let mut q = state[0];
                        q[along] += by;
                        gravity(q)[of]
                    };
                    (shifted(h) - shifted(-h)) / (2.0 * h)
                };
                assert!((slope(i, j) - slope(j, i)).abs() < 1e-6, "{i} {j}");
            }
        }
    }

    #[test]
    fn impossible_axes_are_refused() {
        let axes = vec![Axis { a: f64::NAN, ..Axis::default() }];
        let chain = Chain { convention: Convention::Modified, axes, gravity: down() };
        assert_eq!(chain.check(), Err(ChainError::NotFinite(1)));
        assert!(chain.check_for(2).unwrap_err().to_string().contains("2 joints"));
    }
}
