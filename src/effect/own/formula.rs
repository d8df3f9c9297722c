//! Formulas in the channels of a motion, as the columns of an effect.

use std::borrow::Cow;

use super::expression::{Expression, Input, Mistake, Writer};
use crate::arm::MOST_JOINTS;
use crate::effect::{AddsTorque, ClosedForm, Column, Lack, Motion, Scope};

/// What a channel measures, by the beginning of its name.
const QUANTITIES: [(&str, Quantity); 6] = [
    ("q", Quantity::Position),
    ("qd", Quantity::Velocity),
    ("qdd", Quantity::Acceleration),
    ("direction", Quantity::Direction),
    (PAIR_DIRECTION, Quantity::PairDirection),
    ("tau_load", Quantity::Load),
];

/// The channel that only an effect of a pair has.
const PAIR_DIRECTION: &str = "pair_direction";

/// Each column of an effect: formulas, and where each acts.
pub(super) struct Formulas {
    pub(super) scope: Scope,
    pub(super) columns: Vec<Vec<(Of, Formula)>>,
}

/// A formula in the channels of a motion.
#[derive(Debug, Clone)]
pub struct Formula {
    expression: Expression,
    /// What its names stand for.
    pub(super) sources: Vec<Source>,
}

/// Which joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// The effect's own.
    Own,
    /// The one before it.
    Before,
    /// This one, counted from 0.
    Joint(usize),
}

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Channel(Quantity, Of),
    /// From the start of the trajectory.
    Time,
    /// The shape parameter at this place.
    Shape(usize),
}

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// q
    Position,
    /// q̇
    Velocity,
    /// q̈
    Acceleration,
    /// Of dry friction: the sign of the velocity, smooth where friction turns round.
    Direction,
    /// The same of the sum of the velocities of the joint and the one before it.
    PairDirection,
    /// The torque that the rigid body needs.
    Load,
}

impl Source {
    /// The channel of this name, in an effect of this scope.
    pub(super) fn named(name: &str, scope: Scope) -> Option<Source> {
        if name == "t" {
            return Some(Source::Time);
        }
        QUANTITIES.iter().find_map(|&(word, quantity)| {
            let of = match name.strip_prefix(word)? {
                number if quantity == Quantity::PairDirection => return pair_direction(number, scope),
                "" if scope != Scope::Arm => Of::Own,
                "_before" if scope == Scope::Pair => Of::Before,
                number => Of::Joint(joint_number(number)?),
            };
            Some(Source::Channel(quantity, of))
        })
    }

    /// The names of all channels that an effect of this scope can have, in words.
    pub(super) fn names(scope: Scope) -> String {
        let own: &[&str] = match scope {
            Scope::Joint => &["q, qd, qdd, t, direction and tau_load of its joint"],
            Scope::Pair => &[
                "q, qd, qdd, t, direction and tau_load of its joint",
                "q_before … tau_load_before of the one before",
                "pair_direction of the sum of both velocities",
            ],
            Scope::Arm => &["t"],
        };
        let all = ["q1, qd1, qdd1, direction1, tau_load1, q2 … of all joints", "shape parameters", "pi"];
        own.iter().chain(&all).copied().collect::<Vec<_>>().join("; ")
    }
}

/// The direction of friction between the two joints of an effect's pair.
fn pair_direction(rest: &str, scope: Scope) -> Option<Source> {
    (rest.is_empty() && scope == Scope::Pair).then_some(Source::Channel(Quantity::PairDirection, Of::Own))
}

/// A joint as people count them, from 1, in one way of writing; counted from 0.
pub(super) fn joint_number(text: &str) -> Option<usize> {
    let is_plain = text.chars().all(|c| c.is_ascii_digit()) && !text.starts_with('0');
    text.parse().ok().filter(|number| is_plain && (1..=MOST_JOINTS).contains(number)).map(|number| number - 1)
}

impl AddsTorque for Formulas {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Result<Vec<Column>, Lack> {
        if self.scope == Scope::Pair {
            motion.pair(joint)?;
        }
        let column = |parts: &Vec<(Of, Formula)>| {
            let part = |(acts_on, formula): &(Of, Formula)| {
                Ok((acts_on.joint(motion, joint)?, formula.values(motion, joint, shape)?))
            };
            Ok(Column { parts: parts.iter().map(part).collect::<Result<_, _>>()? })
        };
        self.columns.iter().map(column).collect()
    }

    fn closed_form(&self) -> Option<ClosedForm> {
        ClosedForm::of(self.columns.clone())
    }
}

impl Of {
    /// The joint, from 0, of an effect on `own`, among so many.
    pub(crate) fn among(self, joints: usize, own: usize) -> Option<usize> {
        let joint = match self {
            Of::Own => own,
            Of::Before => own.checked_sub(1)?,
            Of::Joint(joint) => joint,
        };
        (joint < joints).then_some(joint)
    }

    /// The joint, from 0, of an effect on `own`.
    fn joint(self, motion: &Motion, own: usize) -> Result<usize, Lack> {
        let joints = motion.trajectory.joint_count();
        match self {
            Of::Own => Ok(own),
            Of::Before => own.checked_sub(1).ok_or(Lack::Pair),
            Of::Joint(joint) if joint < joints => Ok(joint),
            Of::Joint(joint) => Err(Lack::NoJoint { joint: joint + 1, joints }),
        }
    }
}

impl Formula {
    /// Reads a formula in the channels that an effect of this scope has, and in shape parameters of these names.
    ///
    /// # Errors
    /// [`Mistake`] says where it stands and how to mend it.
    pub fn parse(text: &str, scope: Scope, shapes: &[&str]) -> Result<Formula, Mistake> {
        let expression = Expression::parse(text)?;
        let source = |(name, at): &(String, usize)| {
            let shape = shapes.iter().position(|shape| shape == name).map(Source::Shape);
            shape.or_else(|| Source::named(name, scope)).ok_or_else(|| {
                let what = format!("there is no channel `{name}`; there are {}", Source::names(scope));
                Mistake { at: *at, what }
            })
        };
        let sources = expression.names().iter().map(source).collect::<Result<_, _>>()?;
        Ok(Formula { expression, sources })
    }

    /// Whether it speaks of the time.
    pub(crate) fn knows_time(&self) -> bool {
        self.sources.contains(&Source::Time)
    }

    /// Hands it to a writer: with its channels on an arm of so many joints, in an effect on the joint `own` (from 0), and with
    /// the shape parameters. `None` if it speaks of the time, or of a joint or shape that is not there.
    pub(crate) fn write<W: Writer>(
        &self,
        joints: usize,
        own: usize,
        shape: &[W::Value],
        writer: &mut W,
        channel: &mut impl FnMut(&mut W, Quantity, usize) -> W::Value,
    ) -> Option<W::Value> {
        let mut inputs = Vec::with_capacity(self.sources.len());
        for source in &self.sources {
            inputs.push(match *source {
                Source::Channel(quantity, of) => channel(writer, quantity, of.among(joints, own)?),
                Source::Shape(place) => shape.get(place)?.clone(),
                Source::Time => return None,
            });
        }
        self.expression.write(&inputs, writer)
    }

    /// Its value at each sample of a motion, on the joint `own` (from 0); `shape` holds the shape parameters.
    ///
    /// # Errors
    /// [`Lack`] if the motion lacks a channel, or a value is no finite number.
    pub fn values(&self, motion: &Motion, own: usize, shape: &[f64]) -> Result<Vec<f64>, Lack> {
        let inputs =
            self.sources.iter().map(|source| source.input(motion, own, shape)).collect::<Result<Vec<_>, _>>()?;
        let values = self.expression.values(&inputs, motion.trajectory.len());
        match values.iter().position(|value| !value.is_finite()) {
            Some(sample) => Err(Lack::NotFinite { sample: sample + 1 }),
            None => Ok(values),
        }
    }
}

impl Source {
    /// What it is along a motion, in an effect on the joint `own`.
    fn input<'a>(self, motion: &'a Motion, own: usize, shape: &[f64]) -> Result<Input<'a>, Lack> {
        let run = motion.trajectory;
        Ok(match self {
            Source::Channel(quantity, of) => {
                let joint = of.joint(motion, own)?;
                let qd = &run.qd[joint];
                if quantity == Quantity::Direction {
                    return Ok(Input::Series(qd.iter().map(|&qd| motion.direction(joint, qd)).collect()));
                }
                if quantity == Quantity::PairDirection {
                    let before = run.qd[Of::Before.joint(motion, joint)?].iter();
                    let of_both = qd.iter().zip(before).map(|(qd, before)| motion.direction(joint, qd + before));
                    return Ok(Input::Series(of_both.collect()));
                }
                Input::Series(Cow::Borrowed(match quantity {
                    Quantity::Position => &run.q[joint],
                    Quantity::Velocity | Quantity::Direction | Quantity::PairDirection => qd,
                    Quantity::Acceleration => &run.qdd[joint],
                    Quantity::Load => &motion.load()?.torque[joint],
                }))
            }
            Source::Time => Input::Series(run.since_start().collect()),
            Source::Shape(place) => Input::Constant(shape[place]),
        })
    }
}
