//! What was identified, spliced into the robot's own file (URDF or MJCF): damping, dry friction, and in MJCF armature and springs.
//!
//! Only the values themselves change in the text; blanks, comments and everything else stay as they are. Which parameter is which
//! attribute follows from its column: what is in proportion to q̇ is damping, whatever effect it comes from. What the format can't hold
//! is told.
//! Sources: ROS, URDF XML `joint/dynamics`; MuJoCo, XML reference, `body/joint` (damping, frictionloss, armature, stiffness,
//! springref in degrees unless the compiler says radian).

mod bodies;
mod inertial;
mod property;
mod splice;

use std::collections::BTreeMap;
use std::fmt;

pub use bodies::{Weighed, WeighedLink};
use splice::{Splice, SpliceError};

use super::share;
use crate::arm::robot::{RobotError, SerialArm};
use crate::figure::ticks::number;
use crate::model::property::{Property, plain_columns};
use crate::model::{Fitted, ModelError, Term};
use crate::recording::{JointKind, Recording};

/// Why the rigid body is not in the file.
const MASSES_STAY: &str =
    "its parameters are sums over links, and the masses of the file stay (--inertials writes them, by a --log)";

/// Why a property of a joint is not in the file.
const NO_WORD: &str = "the format has no word for it";

/// What the file has and the model has not.
const STAYS: &str = "the file has it and the model has not; it stays, so that the file's torque has it on top";

/// The robot's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// The Unified Robot Description Format of ROS.
    Urdf,
    /// The format of MuJoCo.
    Mjcf,
}

/// The file with what was identified.
#[derive(Debug, Clone, PartialEq)]
pub struct Spliced {
    /// The whole text.
    pub text: String,
    /// What was written.
    pub written: Vec<Change>,
    /// The masses that were written, if they were asked for.
    pub weighed: Option<Weighed>,
    /// What the format can't hold; and what the file has that the model has not.
    pub not_held: Vec<NotHeld>,
}

/// One value that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The joint, by its name in the file.
    pub joint: String,
    /// The attribute.
    pub attribute: &'static str,
    /// What stood there.
    pub before: Option<String>,
    /// What stands there now, in the units of the file.
    pub value: f64,
}

/// What the format can't hold.
#[derive(Debug, Clone, PartialEq)]
pub struct NotHeld {
    /// The term and its parameter.
    pub what: String,
    /// Its value and unit, if it is a number.
    pub value: Option<(f64, String)>,
    /// Why it was not written.
    pub why: &'static str,
    /// RMS of its torque over that which was measured; `None` without a recording.
    pub share: Option<f64>,
}

impl fmt::Display for NotHeld {
    /// In a line: what, its value, why, and how much of the torque it is where that is known.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.what)?;
        if let Some((value, unit)) = &self.value {
            write!(f, " ({} {unit})", number(*value))?;
        }
        write!(f, ", {}", self.why)?;
        self.share.map_or(Ok(()), |share| write!(f, "; {:.1} % of the torque (RMS)", 100.0 * share))
    }
}

/// The file can't be spliced.
#[derive(Debug, thiserror::Error)]
pub enum RobotFileError {
    /// It is no such file.
    #[error(transparent)]
    Text(#[from] SpliceError),
    /// Its joints are not those of the model.
    #[error(
        "the file has {found} moving joint(s) ({names}), the model {needed}: name those of the model, base first, with --joints"
    )]
    Count {
        /// In the file.
        found: usize,
        /// Their names.
        names: String,
        /// Of the model.
        needed: usize,
    },
    /// A joint that was named is not there.
    #[error("the file has no moving joint `{name}`; it has {names}")]
    NoJoint {
        /// What was asked for.
        name: String,
        /// What there is.
        names: String,
    },
    /// Its axes can't be read, from which masses follow.
    #[error(transparent)]
    Arm(#[from] RobotError),
    /// The names are in another order than the joints.
    #[error("the masses of links follow from joints that are named base first: --joints {0}")]
    Order(String),
    /// Masses were asked for without a motion.
    #[error("the masses of links follow from a motion that shows them: name recordings of the arm with --log")]
    NeedsLog,
    /// There is nothing to weigh links by.
    #[error(
        "the model has no rigid body, from which the masses of links could follow: train one from the preset rigid-body"
    )]
    NoRigidBody,
    /// No masses give the torque.
    #[error(
        "{percent:.0} % of the energy of the torque that was identified for the rigid body are missed with this file's joints, whatever \
         its links weigh: are q = 0, the senses of the joints and their order those of the log?"
    )]
    OtherArm {
        /// How much.
        percent: f64,
    },
    /// Expected bodies can't exist, which are made so that they can.
    #[error("its links have masses that are no numbers; mend them in the file")]
    NoBodies,
    /// A term can't be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// The text of a robot's file with what was identified. `joints` names those of the model in the file, base first; without, the file
/// has as many as the model. With a recording, shares of the torque are measured; and the masses of links can be written, which is done
/// if `inertials` says so.
///
/// # Errors
/// [`RobotFileError`] if it is no such file, or its joints are not those of the model.
pub fn write(
    fitted: &Fitted,
    format: Format,
    text: &str,
    joints: &[String],
    recording: Option<&Recording>,
    inertials: bool,
) -> Result<Spliced, RobotFileError> {
    let mut splice = Splice::of(format, text)?;
    let names = chosen(&splice.joints(), joints, fitted.setting().kinds.len())?;
    let (found, mut not_held) = sorted(fitted, format, recording)?;
    let weighed = if inertials {
        let asked: Vec<String> = names.iter().map(|place| splice.joints()[*place].clone()).collect();
        let weighed = weigh(fitted, recording.ok_or(RobotFileError::NeedsLog)?, text, &asked)?;
        for link in &weighed.links {
            splice.change(inertial::changes(format, text, &link.name, &link.now)?);
        }
        not_held.retain(|one| one.why != MASSES_STAY);
        Some(weighed)
    } else {
        None
    };
    let mut written = Vec::new();
    for ((joint, property), value) in &found {
        let value = match property {
            // MuJoCo states where the spring is at rest.
            Property::Preload => {
                let Some(stiffness) = found.get(&(*joint, Property::Stiffness)) else { continue };
                let turns = fitted.setting().kinds[*joint] == JointKind::Revolute;
                splice.angle(-value / stiffness, turns)
            }
            _ => *value,
        };
        let Some(attribute) = property.attribute(format) else { continue };
        let before = splice.set(names[*joint], attribute, value);
        let joint = splice.joints()[names[*joint]].clone();
        written.push(Change { joint, attribute, before, value });
    }
    not_held.extend(kept(fitted, format, &splice, &names, &found, recording));
    Ok(Spliced { text: splice.text(), written, weighed, not_held })
}

/// What the file has of a joint, and the model nothing of: it stays, since nothing else in the file changes.
fn kept(
    fitted: &Fitted,
    format: Format,
    splice: &Splice,
    names: &[usize],
    found: &BTreeMap<(usize, Property), f64>,
    recording: Option<&Recording>,
) -> Vec<NotHeld> {
    let of_joint = |joint: usize| {
        let properties = [Property::Damping, Property::Friction, Property::Armature, Property::Stiffness];
        properties.into_iter().filter_map(move |property| {
            let attribute = property.attribute(format).filter(|_| !found.contains_key(&(joint, property)))?;
            let value = splice.number(names[joint], attribute).filter(|value| *value != 0.0)?;
            Some(NotHeld {
                what: format!("{attribute} of {}", splice.joints()[names[joint]]),
                value: Some((value, property.dimension().unit(fitted.setting().kinds[joint]).to_owned())),
                why: STAYS,
                share: recording.map(|recording| share::of_property(recording, joint, property, value)),
            })
        })
    };
    (0..names.len()).flat_map(of_joint).collect()
}

/// The masses of the links that these joints move.
fn weigh(fitted: &Fitted, recording: &Recording, text: &str, joints: &[String]) -> Result<Weighed, RobotFileError> {
    let arm = SerialArm::moving_only(text, joints)?;
    let in_order: Vec<String> = arm.joints.iter().map(|joint| joint.name.clone()).collect();
    match in_order == joints {
        true => bodies::weigh(fitted, recording, &arm),
        false => Err(RobotFileError::Order(in_order.join(","))),
    }
}

/// The joints of the model among those of the file.
fn chosen(names: &[String], asked: &[String], needed: usize) -> Result<Vec<usize>, RobotFileError> {
    let all = || names.join(", ");
    let place = |name: &String| {
        let found = names.iter().position(|other| other == name);
        found.ok_or_else(|| RobotFileError::NoJoint { name: name.clone(), names: all() })
    };
    let chosen = match asked {
        [] => (0..names.len()).collect::<Vec<usize>>(),
        asked => asked.iter().map(place).collect::<Result<_, _>>()?,
    };
    match chosen.len() == needed {
        true => Ok(chosen),
        false => Err(RobotFileError::Count { found: chosen.len(), names: all(), needed }),
    }
}

/// Values by joint and property, and what has none in this format.
type Sorted = (BTreeMap<(usize, Property), f64>, Vec<NotHeld>);

fn sorted(fitted: &Fitted, format: Format, recording: Option<&Recording>) -> Result<Sorted, ModelError> {
    let (mut found, mut not_held): Sorted = (BTreeMap::new(), Vec::new());
    let share = |term: usize, parameter: Option<usize>| {
        recording.map(|recording| share::of_torque(fitted, recording, term, parameter)).transpose()
    };
    for (number, term) in fitted.model.terms.iter().enumerate() {
        if let Term::Resistance(joints) = term {
            for (joint, stated) in joints.iter().enumerate() {
                let has_spring = stated.stiffness != 0.0;
                for (property, value) in property::stated(stated).into_iter().filter(|(_, value)| *value != 0.0) {
                    if property.is_held(format, has_spring) {
                        *found.entry((joint, property)).or_default() += value;
                        continue;
                    }
                    not_held.push(NotHeld {
                        what: format!("{}: {}, joint {}", term.label(), property.name(), joint + 1),
                        value: Some((value, property.dimension().unit(fitted.setting().kinds[joint]).to_owned())),
                        why: NO_WORD,
                        share: recording.map(|recording| share::of_property(recording, joint, property, value)),
                    });
                }
            }
            continue;
        }
        let Term::Effect(placed) = term else {
            let why = if matches!(term, Term::RigidBody(_)) { MASSES_STAY } else { "it is a network" };
            not_held.push(NotHeld { what: term.label(), value: None, why, share: share(number, None)? });
            continue;
        };
        let plain = plain_columns(placed, fitted.setting().kinds.len());
        let specs = placed.effect.linear().zip(fitted.linear_of(number));
        for (place, (spec, value)) in specs.enumerate() {
            let property = plain.get(place).copied().flatten();
            let is_possible = (spec.min..=spec.max).contains(&value);
            let has_spring = plain.contains(&Some(Property::Stiffness));
            let why = match (property, placed.joint) {
                (Some(property), Some(joint)) if property.is_held(format, has_spring) && is_possible => {
                    *found.entry((joint, property)).or_default() += value;
                    continue;
                }
                (Some(property), Some(_)) if property.is_held(format, has_spring) => "its value is not possible",
                _ => NO_WORD,
            };
            let kind = fitted.setting().kinds[placed.joint.unwrap_or(0)];
            not_held.push(NotHeld {
                what: format!("{}: {}", term.label(), spec.name),
                value: Some((value, spec.dimension.unit(kind).to_owned())),
                why,
                share: share(number, Some(place))?,
            });
        }
    }
    Ok((found, not_held))
}

#[cfg(test)]
mod tests;
