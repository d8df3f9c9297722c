//! Where an effect is to act, as people write it on the command line and in files: `coulomb-friction@1,3`.

use std::fmt;
use std::str::FromStr;

use super::Effect;
use super::registry::{self, UnknownEffect};
use crate::recording::joints_in;

/// An effect and the joints that it is to act on. People count joints from 1, the program counts them from 0.
///
/// ```
/// use torquescope::effect::place::Place;
///
/// let place: Place = "coulomb-friction@1,3".parse()?;
/// assert_eq!((place.effect.name, place.joints(3)?), ("Coulomb friction", vec![0, 2]));
/// # Ok::<(), torquescope::effect::place::PlaceError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The effect.
    pub effect: &'static Effect,
    /// Joints, counted from 0; `None` where none were named, which stands for all of them, or for the whole arm.
    pub joints: Option<Vec<usize>>,
}

/// A text names no effect, or no joints.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// No effect has this id.
    #[error(transparent)]
    UnknownEffect(#[from] UnknownEffect),
    /// What stands behind the `@` is no list of joints.
    #[error("`{number}` in `{text}` is not a joint: joints are counted from 1, such as `{effect}@1,2`")]
    NotAJoint {
        /// What stands for the joint.
        number: String,
        /// All of it.
        text: String,
        /// Id of the effect.
        effect: &'static str,
    },
    /// The arm has fewer joints.
    #[error("{effect} is to act on joint {joint}, but the arm has {joints}: choose a joint from 1 to {joints}")]
    NoSuchJoint {
        /// Name of the effect.
        effect: &'static str,
        /// Counted from 1.
        joint: usize,
        /// How many there are.
        joints: usize,
    },
}

impl Place {
    /// Its joints, counted from 0, on an arm of `count` joints.
    ///
    /// # Errors
    /// [`PlaceError::NoSuchJoint`] for the first that the arm has not.
    pub fn joints(&self, count: usize) -> Result<Vec<usize>, PlaceError> {
        let Some(joints) = &self.joints else { return Ok((0..count).collect()) };
        match joints.iter().find(|joint| **joint >= count) {
            Some(joint) => Err(PlaceError::NoSuchJoint { effect: self.effect.name, joint: joint + 1, joints: count }),
            None => Ok(joints.clone()),
        }
    }
}

impl FromStr for Place {
    type Err = PlaceError;

    fn from_str(text: &str) -> Result<Self, PlaceError> {
        let (id, list) = text.split_once('@').map_or((text, None), |(id, list)| (id, Some(list)));
        let effect = registry::find(id.trim())?;
        let not_a_joint = |number: &str| {
            let (number, text) = (number.to_owned(), text.to_owned());
            PlaceError::NotAJoint { number, text, effect: effect.id }
        };
        let joints = list.map(joints_in).transpose().map_err(not_a_joint)?;
        Ok(Place { effect, joints })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.effect.id)?;
        for (index, joint) in self.joints.iter().flatten().enumerate() {
            write!(f, "{}{}", if index == 0 { '@' } else { ',' }, joint + 1)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_are_counted_from_one() {
        let place: Place = "coulomb-friction@1,3".parse().unwrap();
        assert_eq!((place.effect.id, place.joints.as_deref()), ("coulomb-friction", Some([0, 2].as_slice())));
        assert_eq!((place.to_string().as_str(), place.joints(3).unwrap()), ("coulomb-friction@1,3", vec![0, 2]));
        let whole: Place = "tip-payload".parse().unwrap();
        assert_eq!((whole.to_string().as_str(), whole.joints(2).unwrap()), ("tip-payload", vec![0, 1]));
    }

    #[test]
    fn mistakes_are_told_with_what_there_is() {
        let problem = |text: &str| text.parse::<Place>().unwrap_err().to_string();
        assert!(problem("friction@1").contains("no effect `friction`; known effects: viscous-friction"));
        for text in ["viscous-friction@0", "viscous-friction@x", "viscous-friction@", "viscous-friction@1,-2"] {
            assert!(problem(text).contains("joints are counted from 1"), "{}", problem(text));
        }
        let missing = "viscous-friction@4".parse::<Place>().unwrap().joints(3).unwrap_err().to_string();
        assert_eq!(missing, "viscous friction is to act on joint 4, but the arm has 3: choose a joint from 1 to 3");
    }
}
