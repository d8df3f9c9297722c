//! Which masses the links of a file must have, so that the arm needs the torque that was identified for its rigid body.
//!
//! What is identified are sums over links, as many as the motion shows, and nothing asks whether links with such sums can exist. Here
//! the links that can are sought whose torque is as near as possible to it along the recording ([`crate::arm::possible`]); what the
//! torque does not tell is left as the file has it. Links that are fixed to others keep their masses.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::RobotFileError;
use crate::arm::body::Body;
use crate::arm::chain::PER_LINK;
use crate::arm::possible::{Misfit, nearest};
use crate::arm::robot::{Part, SerialArm};
use crate::model::{Fitted, Term};
use crate::recording::Recording;

/// So many states of the recording are enough.
const MOST_STATES: usize = 2000;
/// More of the torque's energy than this can't be missed by noise: joints count otherwise then, or it is another arm.
const MOST_MISSED: f64 = 0.05;
/// Directions of the parameters that the torque tells less of than this share of the most told one.
const UNTOLD: f64 = 1e-12;
/// A link of which the file says nothing is taken to be of this mass \[kg\]; its radius of gyration \[m\] is that of all whose inertia
/// could not be.
const MASS: f64 = 1.0;
const GYRATION: f64 = 0.1;

/// What the links must weigh.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighed {
    /// Those whose masses change.
    pub links: Vec<WeighedLink>,
    /// nMSE of the torque of each joint along the recording, with the identified rigid body and with these links.
    pub cost: Vec<[f64; 2]>,
}

/// One link.
#[derive(Debug, Clone, PartialEq)]
pub struct WeighedLink {
    /// Its name in the file.
    pub name: String,
    /// What the file said, if anything, in the frame of the link.
    pub before: Option<Body>,
    /// What it is now.
    pub now: Body,
}

/// States of the recording with what the torque of the rigid body is there.
struct States {
    /// The file's regressor, all joints of a state after each other.
    rows: DMatrix<f64>,
    /// What was identified for the rigid body.
    wanted: DVector<f64>,
    /// What the model leaves of the measured torque.
    left: DVector<f64>,
    /// Σ τ² of each joint.
    energy: Vec<f64>,
}

/// The links of `arm`, whose joints are those of the model.
pub(super) fn weigh(fitted: &Fitted, recording: &Recording, arm: &SerialArm) -> Result<Weighed, RobotFileError> {
    let states = States::of(fitted, recording, arm)?;
    let joints = arm.joints.len();
    let weight = |row: usize| 1.0 / states.energy[row % joints].max(f64::MIN_POSITIVE);
    let weighted = DMatrix::from_fn(states.rows.nrows(), states.rows.ncols(), |row, column| {
        weight(row) * states.rows[(row, column)]
    });
    let square = weighted.transpose() * &states.rows;
    let product = weighted.transpose() * &states.wanted;
    let wanted = (0..states.wanted.len()).map(|row| weight(row) * states.wanted[row].powi(2)).sum::<f64>();
    let missed = (wanted - told(&square, &product)) / wanted;
    if missed.is_nan() || missed > MOST_MISSED {
        return Err(RobotFileError::OtherArm { percent: 100.0 * missed });
    }

    let bearers: Vec<(usize, &Part)> =
        arm.joints.iter().enumerate().filter_map(|(place, joint)| Some((place, bearer(&joint.parts)?))).collect();
    let mut parameters = DVector::from_vec(arm.stated_parameters());
    for (joint, part) in &bearers {
        let own = part.parameters().unwrap_or_default();
        parameters.as_mut_slice()[joint * PER_LINK..].iter_mut().zip(own).for_each(|(sum, own)| *sum -= own);
    }
    let columns: Vec<usize> = bearers.iter().flat_map(|(joint, _)| joint * PER_LINK..(joint + 1) * PER_LINK).collect();
    let rest = &product - &square * &parameters;
    let misfit =
        Misfit { square: square.select_columns(&columns).select_rows(&columns), product: rest.select_rows(&columns) };
    let expected: Vec<Body> =
        bearers.iter().map(|(_, part)| expected(part.body).seen_from(&part.frame.inverse())).collect();
    let found = nearest(&misfit, &expected).ok_or(RobotFileError::NoBodies)?;
    for ((joint, _), body) in bearers.iter().zip(&found) {
        let own = body.parameters();
        parameters.as_mut_slice()[joint * PER_LINK..].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    let link = |((_, part), body): (&(usize, &Part), &Body)| WeighedLink {
        name: part.name.clone(),
        before: part.body,
        now: body.seen_from(&part.frame),
    };
    Ok(Weighed { links: bearers.iter().zip(&found).map(link).collect(), cost: states.cost(&parameters) })
}

impl States {
    fn of(fitted: &Fitted, recording: &Recording, arm: &SerialArm) -> Result<States, RobotFileError> {
        let joints = arm.joints.len();
        let body = fitted.model.terms.iter().position(|term| matches!(term, Term::RigidBody(_)));
        let body = body.ok_or(RobotFileError::NoRigidBody)?;
        let regressor = arm.regressor(fitted.setting().weightless);
        let every = recording.sample_count().div_ceil(MOST_STATES).max(1);
        let width = joints * PER_LINK;
        let (mut rows, mut wanted, mut left, mut energy) = (Vec::new(), Vec::new(), Vec::new(), vec![0.0; joints]);
        for trajectory in &recording.trajectories {
            let predicted = fitted.predict(trajectory)?;
            for sample in (0..trajectory.len()).step_by(every) {
                let now =
                    [&trajectory.q, &trajectory.qd, &trajectory.qdd].map(|one| one.at(sample).collect::<Vec<_>>());
                let start = rows.len();
                rows.resize(start + joints * width, 0.0);
                regressor.fill(&now[0], &now[1], &now[2], &mut rows[start..]);
                for (joint, energy) in energy.iter_mut().enumerate() {
                    wanted.push(predicted.terms[body][joint][sample]);
                    left.push(trajectory.tau[joint][sample] - predicted.total[joint][sample]);
                    *energy += trajectory.tau[joint][sample].powi(2);
                }
            }
        }
        let rows = DMatrix::from_row_slice(wanted.len(), width, &rows);
        Ok(States { rows, wanted: DVector::from_vec(wanted), left: DVector::from_vec(left), energy })
    }

    /// nMSE of each joint with the identified body, and with these parameters of the file's.
    fn cost(&self, parameters: &DVector<f64>) -> Vec<[f64; 2]> {
        let changed = &self.left + &self.wanted - &self.rows * parameters;
        let joints = self.energy.len();
        let of = |left: &DVector<f64>, joint: usize| {
            left.iter().skip(joint).step_by(joints).map(|left| left * left).sum::<f64>() / self.energy[joint]
        };
        (0..joints).map(|joint| [of(&self.left, joint), of(&changed, joint)]).collect()
    }
}

/// How much of the torque's energy some parameters can give, whether any links have them or not.
fn told(square: &DMatrix<f64>, product: &DVector<f64>) -> f64 {
    let own = square.clone().symmetric_eigen();
    let least = UNTOLD * own.eigenvalues.max();
    let along = own.eigenvectors.transpose() * product;
    along
        .iter()
        .zip(&own.eigenvalues)
        .filter(|(_, value)| **value > least)
        .map(|(along, value)| along * along / value)
        .sum()
}

/// The link that bears the change: the heaviest that moves with the joint, or the nearest where none weighs anything.
fn bearer(parts: &[Part]) -> Option<&Part> {
    let heavy = parts.iter().filter(|part| part.body.is_some_and(|body| body.mass > 0.0));
    let mass = |part: &Part| part.body.map_or(0.0, |body| body.mass);
    heavy.max_by(|one, other| mass(one).total_cmp(&mass(other))).or(parts.first())
}

/// What a link is taken for where no torque tells it.
fn expected(stated: Option<Body>) -> Body {
    if let Some(body) = stated.filter(Body::is_possible) {
        return body;
    }
    let (mass, com) =
        stated.filter(|body| body.mass > 0.0).map_or((MASS, Vector3::zeros()), |body| (body.mass, body.com));
    Body { mass, com, inertia: Matrix3::identity() * (mass * GYRATION * GYRATION) }
}

#[cfg(test)]
mod tests;
