//! Which column is which channel: guessed from the names, or said by the user as text or in a session file.
//!
//! names of columns → `words` (what a name says, without its `units`) → `choosing` (the best group for each channel, or what the
//! `spec` of the user says) → [`Mapping`].
//!
//! A guess prefers measured over plain over filtered over commanded columns. Position and torque must be found; velocity
//! and acceleration are derived where they are missing; a file without time needs a sampling rate.

mod choosing;
mod draft;
mod spec;
mod units;
mod words;

use serde::{Deserialize, Serialize};

use super::drive::DriveError;
pub use draft::{Draft, Role};
pub use spec::MappingSpec;
pub(super) use units::{Unit, split_unit, unit_named};
pub(super) use words::is_current;

/// One of the five things that a recording holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Channel {
    /// Time stamps \[s\].
    Time,
    /// Joint position \[rad or m\].
    Position,
    /// Joint velocity \[rad/s or m/s\].
    Velocity,
    /// Joint acceleration \[rad/s² or m/s²\].
    Acceleration,
    /// Joint torque \[N m or N\].
    Torque,
}

impl Channel {
    /// All five.
    pub const ALL: [Channel; 5] =
        [Channel::Time, Channel::Position, Channel::Velocity, Channel::Acceleration, Channel::Torque];

    /// Its key in a mapping text.
    pub fn key(self) -> &'static str {
        match self {
            Channel::Time => "time",
            Channel::Position => "q",
            Channel::Velocity => "qd",
            Channel::Acceleration => "qdd",
            Channel::Torque => "tau",
        }
    }

    /// Its name in messages.
    pub fn title(self) -> &'static str {
        match self {
            Channel::Time => "time",
            Channel::Position => "position",
            Channel::Velocity => "velocity",
            Channel::Acceleration => "acceleration",
            Channel::Torque => "torque",
        }
    }
}

/// The mapping that was used: names of columns, one a joint, base first.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Mapping {
    /// Time stamps; `None` where the file has none and the sampling rate was given.
    pub time: Option<String>,
    /// Joint position.
    pub q: Vec<String>,
    /// Joint velocity; `None` where it is derived.
    pub qd: Option<Vec<String>>,
    /// Joint acceleration; `None` where it is derived.
    pub qdd: Option<Vec<String>>,
    /// Joint torque.
    pub tau: Vec<String>,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Columns that could have been taken instead, as mapping entries such as `qd=vel_filt*`.
    pub alternatives: Vec<String>,
    /// Channels for which nothing but commanded values was found.
    pub commanded: Vec<Channel>,
}

/// The columns can't be mapped.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MappingError {
    /// The text is not a mapping.
    #[error("the mapping has `{entry}`, which {problem}; write it like `q=pos*,tau=torque*,time=t`")]
    Text {
        /// The part that is wrong.
        entry: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// The mapping file can't be read.
    #[error("the mapping file: {0}")]
    File(String),
    /// An arm of which nobody says which joints slide.
    #[error(
        "the arm has sliding and turning joints: state its axes in a mapping file, and name the columns with their units"
    )]
    MixedJoints,
    /// A needed channel was not found.
    #[error(
        "no {} column was recognised among: {}; say which it is, for example `{example}` (`*` stands for the joint number){}",
        channel.title(), list(columns), amperes(*channel, columns)
    )]
    Missing {
        /// The channel.
        channel: Channel,
        /// All columns there are.
        columns: Vec<String>,
        /// A mapping made of columns that exist.
        example: String,
    },
    /// Something that the user named does not exist.
    #[error("`{}={pattern}` matches no column; the file has: {}", channel.key(), list(columns))]
    NoSuchColumn {
        /// The channel.
        channel: Channel,
        /// What was asked for.
        pattern: String,
        /// All columns there are.
        columns: Vec<String>,
    },
    /// Several columns have the name that is needed.
    #[error("{count} columns are named `{name}`, so it is not clear which one holds the {}; rename them", channel.title())]
    Ambiguous {
        /// The channel.
        channel: Channel,
        /// The name.
        name: String,
        /// How often it occurs.
        count: usize,
    },
    /// A joint of a channel has no column, or several.
    #[error("{} columns are taken for the {} of joint {joint}; take one for each joint from 1 on", if *count == 0 { "no".to_owned() } else { count.to_string() }, channel.title())]
    Joint {
        /// The channel.
        channel: Channel,
        /// Counted from 1.
        joint: usize,
        /// How many columns.
        count: usize,
    },
    /// A constant of the drive can't be.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// Two channels have different joints.
    #[error(
        "position has {} joints ({}), but {} has {} ({}); map both for the same joints{}",
        position.len(), list(position), channel.title(), other.len(), list(other),
        if *channel == Channel::Torque { String::new() } else { format!(", or derive it with `{}=-`", channel.key()) }
    )]
    JointsDiffer {
        /// The channel that differs from position.
        channel: Channel,
        /// Columns of position.
        position: Vec<String>,
        /// Columns of the other.
        other: Vec<String>,
    },
}

/// What is to be said of currents where a torque was looked for.
fn amperes(channel: Channel, columns: &[String]) -> String {
    match columns.iter().find(|name| channel == Channel::Torque && words::is_current(name)) {
        Some(name) => format!(
            ". `{name}` is a current: it is a torque only times the motor's constant and the gear's ratio, which a mapping file \
             states: tau = {{ columns = [\"…\"], factor = … }}"
        ),
        None => String::new(),
    }
}

/// Names for a message; a long list is cut, and says so.
fn list(names: &[String]) -> String {
    const MOST: usize = 60;
    let shown = names.iter().take(MOST).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > MOST { format!("{shown} and {} more", names.len() - MOST) } else { shown }
}
