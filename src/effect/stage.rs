//! The chain in which effects act: **body → drive → reading**.
//!
//! To move, the arm needs the torque of its rigid body and of every effect of the *body*: friction, springs, a payload, which
//! add up. That torque passes through the *drive* of each joint, which delays it. What is *read* of it, and of the motion, may
//! differ from the truth: a velocity that comes late, a torque that is cut off.
//!
//! A stage acts on all that the stages before it made, and within a stage the order does not matter. So no list of effects
//! has an order that changes a result.

use super::{ClosedForm, Column, Effect, Lack, Motion, NotApplicable};
use crate::recording::Trajectory;
use crate::recording::fault::FaultKind;
use crate::signals::Signals;

/// Where in the chain an effect stands, and what it does there.
#[derive(Clone, Copy)]
pub enum Stage {
    /// It adds torque to that of the rigid body.
    Body(&'static dyn AddsTorque),
    /// The torque of its joint passes through it.
    Drive(&'static dyn ChangesTorque),
    /// What is read is not what is there; and what can be done about it.
    Reading(&'static dyn ChangesReading, Remedy),
}

/// What can be done about a wrong reading.
#[derive(Clone, Copy)]
pub enum Remedy {
    /// The motion that was read can be set right, so a model can have the effect.
    SetRight(&'static dyn SetsRight),
    /// The readings show the fault by themselves. They are left out of every fit and every error: there is nothing to add.
    LeaveOut(FaultKind),
}

/// What an effect of the body does.
pub trait AddsTorque: Sync {
    /// One column per linear parameter, in the order of the specification: the torque that the parameter's unit value causes.
    ///
    /// `joint` counts from 0 and is ignored by effects of the whole arm. `shape` holds the shape parameters in the order
    /// of the specification.
    ///
    /// # Errors
    /// [`Lack`] if the motion lacks what the formula needs.
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack>;

    /// The same columns as formulas, so that they can be written in another language; `None` if what acts now follows from more
    /// than what moves now, or from the whole body.
    fn closed_form(&self) -> Option<ClosedForm> {
        None
    }
}

/// What an effect of a drive does. It has one linear parameter.
pub trait ChangesTorque: Sync {
    /// What becomes of the torque of its joint \[N m\] at these times \[s\], with this parameter.
    fn pass(&self, torque: &mut [f64], time: &[f64], parameter: f64);

    /// What a unit of the parameter makes of the rigid body's torque, at the value of the parameter that was found so far (0
    /// before one was found).
    ///
    /// # Errors
    /// [`Lack`] if the motion lacks what the formula needs.
    fn column(&self, motion: &Motion, joint: usize, found: f64) -> Result<Column, Lack>;
}

/// What an effect of a reading does.
pub trait ChangesReading: Sync {
    /// What it makes of the readings of all sensors, noise included.
    fn misread(&self, reading: &mut Trajectory, joint: usize, parameters: &[f64]);
}

/// How a motion that was read wrongly is set right. The effect has one linear parameter.
pub trait SetsRight: Sync {
    /// Makes the motion that was read the true one.
    fn set_right(&self, motion: &mut Trajectory, parameter: f64);

    /// What the rigid body's torque along the motion that was read lacks per unit of the parameter, at the value of the
    /// parameter that was found so far (0 before one was found).
    ///
    /// # Errors
    /// [`Lack`] if the motion lacks what the formula needs.
    fn column(&self, motion: &Motion, found: f64) -> Result<Column, Lack>;
}

/// The effect is a fault of the torque readings, so no model can have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "{effect} is a fault of the readings: where they show it they are left out of every fit and every error, so there is \
     nothing to add to a model"
)]
pub struct NotAddable {
    /// Name of the effect.
    pub effect: &'static str,
}

impl Stage {
    /// Counted along the chain, from 0.
    pub fn number(self) -> usize {
        match self {
            Stage::Body(_) => 0,
            Stage::Drive(_) => 1,
            Stage::Reading(..) => 2,
        }
    }
}

impl Effect {
    /// One column per linear parameter, in the order of the specification: the torque that the parameter's unit value causes.
    ///
    /// `joint` counts from 0 and is ignored by effects of the whole arm. `shape` holds the shape parameters in the order of the
    /// specification. The torque of an effect that changes what others do is not quite in proportion to its parameter: its
    /// column is taken at the value found so far, the only entry of `shape` once there is one.
    ///
    /// # Errors
    /// [`NotApplicable`] if the motion lacks what the formula needs, or if it is a fault of the readings.
    pub fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, NotApplicable> {
        let found = || self.parameters[0].bounded(shape.first().copied().unwrap_or(0.0));
        let columns = match self.stage {
            Stage::Body(body) => body.columns(motion, joint, shape),
            Stage::Drive(drive) => drive.column(motion, joint, found()).map(|column| vec![column]),
            Stage::Reading(_, Remedy::SetRight(reading)) => reading.column(motion, found()).map(|column| vec![column]),
            Stage::Reading(_, Remedy::LeaveOut(_)) => Err(Lack::InReadings),
        };
        columns.map_err(|lack| NotApplicable { effect: self.name, lack })
    }

    /// Its columns as formulas in what moves now; `None` if they are none, or if it adds no torque but changes it.
    pub fn closed_form(&self) -> Option<ClosedForm> {
        match self.stage {
            Stage::Body(body) => body.closed_form(),
            Stage::Drive(_) | Stage::Reading(..) => None,
        }
    }

    /// The torque of the effect by its formula, with given parameters (in the order of the specification): Σ θₖ φₖ, for all
    /// joints.
    ///
    /// # Errors
    /// [`NotApplicable`] as [`Effect::columns`], and if there are too few or too many parameters.
    pub fn torque(&self, motion: &Motion, joint: usize, parameters: &[f64]) -> Result<Signals, NotApplicable> {
        let mut torque = Signals::zeros(motion.trajectory.joint_count(), motion.trajectory.len());
        self.add_columns(motion, joint, parameters, &mut torque)?;
        Ok(torque)
    }

    /// What it does in truth to the `torque` of the arm and of all stages before its own: a formula that is a first order acts
    /// as what it stands for. An effect of a reading leaves the torque as it is.
    ///
    /// # Errors
    /// [`NotApplicable`] as [`Effect::torque`].
    pub fn act(
        &self,
        motion: &Motion,
        joint: usize,
        parameters: &[f64],
        torque: &mut Signals,
    ) -> Result<(), NotApplicable> {
        match self.stage {
            Stage::Body(_) => self.add_columns(motion, joint, parameters, torque)?,
            Stage::Drive(_) => {
                let [linear, _] = self.parted(parameters)?;
                self.pass(&mut torque[joint], &motion.trajectory.time, linear);
            }
            Stage::Reading(..) => {}
        }
        Ok(())
    }

    /// What becomes, on its joint, of the torque of the stages before its own, where it has these linear parameters. Nothing,
    /// unless it stands in the drive.
    pub fn pass(&self, torque: &mut [f64], time: &[f64], linear: &[f64]) {
        if let (Stage::Drive(drive), &[parameter]) = (self.stage, linear) {
            drive.pass(torque, time, parameter);
        }
    }

    /// Makes the motion that is read the true one, where it has these linear parameters. An effect that changes no reading of the
    /// motion leaves it as it is.
    pub fn set_right(&self, motion: &mut Trajectory, linear: &[f64]) {
        if let (Stage::Reading(_, Remedy::SetRight(reading)), &[parameter]) = (self.stage, linear) {
            reading.set_right(motion, parameter);
        }
    }

    /// What it makes of the readings of all sensors, noise included. Nothing, unless it is an effect of a reading.
    pub fn misread(&self, reading: &mut Trajectory, joint: usize, parameters: &[f64]) {
        if let Stage::Reading(effect, _) = self.stage {
            effect.misread(reading, joint, parameters);
        }
    }

    /// Whether it, as a term of a model, changes what other terms do: friction that passes a lag arrives late.
    pub fn changes_others(&self) -> bool {
        matches!(self.stage, Stage::Drive(_) | Stage::Reading(_, Remedy::SetRight(_)))
    }

    /// Whether it acts on what the other one made.
    pub fn acts_after(&self, other: &Effect) -> bool {
        self.stage.number() > other.stage.number()
    }

    /// The fault of the torque readings that it is, if it is one.
    pub fn fault(&self) -> Option<FaultKind> {
        match self.stage {
            Stage::Reading(_, Remedy::LeaveOut(kind)) => Some(kind),
            _ => None,
        }
    }

    /// Checks that a model can have it.
    ///
    /// # Errors
    /// [`NotAddable`] if it is a fault of the readings.
    pub fn check_addable(&self) -> Result<(), NotAddable> {
        match self.fault() {
            None => Ok(()),
            Some(_) => Err(NotAddable { effect: self.name }),
        }
    }

    fn add_columns(
        &self,
        motion: &Motion,
        joint: usize,
        parameters: &[f64],
        torque: &mut Signals,
    ) -> Result<(), NotApplicable> {
        let [linear, shape] = self.parted(parameters)?;
        for (column, factor) in self.columns(motion, joint, shape)?.iter().zip(linear) {
            column.add_to(torque, *factor);
        }
        Ok(())
    }
}
