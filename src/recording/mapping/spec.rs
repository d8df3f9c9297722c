//! What the user says: a text on the command line, or a TOML file.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize};

use super::{Channel, Mapping, MappingError};
use crate::arm::chain::Chain;
use crate::arm::robot::SerialArm;
use crate::recording::JointKind;
use crate::recording::drive::Drive;
use crate::recording::encoders::Side;
use crate::recording::torque::TorqueFacts;
use crate::recording::transform::Transform;

/// What leaves a channel out.
pub(super) const LEAVE_OUT: &str = "-";
/// The key of the topic in a mapping text.
const TOPIC: &str = "topic";

/// What the user says about the mapping. What is `None` is guessed. As text:
/// `q=pos_filt*,qd=vel_filt*,qdd=-,tau=tau_a+tau_b,time=time`.
///
/// Each entry is the name of a column or of an array, or a pattern in which `*` stands for the number (or the name) of
/// the joint; `c2..c7` is all columns of the file from one to another; `+` joins several; `-` alone leaves the channel out, so
/// that it is derived. `topic=/joint_states` says which topic of a log of messages is read, `topic=/positions+/torques` which two stand side
/// by side, at the times of the first. A mapping file ([`MappingSpec::from_toml`]) says more than columns.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MappingSpec {
    /// Time stamps.
    pub time: Option<Vec<String>>,
    /// Joint position.
    pub q: Option<Vec<String>>,
    /// Joint velocity.
    pub qd: Option<Vec<String>>,
    /// Joint acceleration.
    pub qdd: Option<Vec<String>>,
    /// Joint torque.
    pub tau: Option<Vec<String>>,
    /// How the numbers of these columns become SI units.
    pub transforms: BTreeMap<Channel, Transform>,
    /// Sampling rate \[Hz\] of files without a time column.
    pub rate_hz: Option<f64>,
    /// Cut-off of the filter for derived channels \[Hz\].
    pub low_pass_hz: Option<f64>,
    /// Width \[samples\] of the Gaussian that smooths derived channels instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gaussian_samples: Option<f64>,
    /// What the joints do, where the columns do not say it.
    pub kind: Option<JointKind>,
    /// Where the axes of the arm are.
    pub chain: Option<Chain>,
    /// Which topic of a log of messages is read, or which two.
    #[serde(deserialize_with = "one_or_several")]
    pub topic: Option<Vec<String>>,
    /// What the torque is; empty where nothing is said.
    pub torque: TorqueFacts,
    /// On which side of the gears the encoders are; `None` where nothing is said.
    pub encoders: Option<Side>,
    /// The law by which the torque follows from the columns that `tau` names, where these hold the command of a drive.
    pub drive: Option<Drive>,
}

impl MappingSpec {
    /// What was said about a channel.
    pub fn get(&self, channel: Channel) -> Option<&[String]> {
        match channel {
            Channel::Time => self.time.as_deref(),
            Channel::Position => self.q.as_deref(),
            Channel::Velocity => self.qd.as_deref(),
            Channel::Acceleration => self.qdd.as_deref(),
            Channel::Torque => self.tau.as_deref(),
        }
    }

    /// Says which columns a channel has.
    pub fn set(&mut self, channel: Channel, columns: Vec<String>) {
        *self.get_mut(channel) = Some(columns);
    }

    fn get_mut(&mut self, channel: Channel) -> &mut Option<Vec<String>> {
        match channel {
            Channel::Time => &mut self.time,
            Channel::Position => &mut self.q,
            Channel::Velocity => &mut self.qd,
            Channel::Acceleration => &mut self.qdd,
            Channel::Torque => &mut self.tau,
        }
    }
}

/// A mapping file, as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct MappingFile {
    time: Option<Names>,
    rate_hz: Option<f64>,
    low_pass_hz: Option<f64>,
    gaussian_samples: Option<f64>,
    kind: Option<JointKind>,
    topic: Option<Names>,
    #[serde(default, skip_serializing_if = "TorqueFacts::is_empty")]
    torque: TorqueFacts,
    encoders: Option<Side>,
    q: Option<ChannelEntry>,
    qd: Option<ChannelEntry>,
    qdd: Option<ChannelEntry>,
    tau: Option<ChannelEntry>,
    command: Option<ChannelEntry>,
    drive: Option<Drive>,
    arm: Option<Chain>,
}

#[derive(Serialize, Deserialize)]
struct ChannelEntry {
    columns: Names,
    #[serde(flatten)]
    transform: Transform,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "it must be a name, a pattern with `*`, or a list of them")]
enum Names {
    One(String),
    Several(Vec<String>),
}

impl From<Names> for Vec<String> {
    fn from(names: Names) -> Self {
        match names {
            Names::One(name) => vec![name],
            Names::Several(names) => names,
        }
    }
}

/// A session of before topics could be two has one name.
fn one_or_several<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<String>>, D::Error> {
    Ok(Option::<Names>::deserialize(deserializer)?.map(Names::into))
}

impl MappingSpec {
    /// The same with the axes of an arm, and what its joints do.
    ///
    /// # Errors
    /// [`MappingError::MixedJoints`] if some slide and others turn, and nobody says which do what.
    pub fn with_axes_of(self, arm: &SerialArm) -> Result<Self, MappingError> {
        let sliding = arm.sliding();
        let kind = match (sliding.contains(&true), sliding.contains(&false)) {
            (true, true) if self.kind.is_none() => return Err(MappingError::MixedJoints),
            (true, false) => Some(JointKind::Prismatic),
            _ => self.kind,
        };
        Ok(MappingSpec { chain: Some(arm.chain()), kind, ..self })
    }

    /// Whether a text in TOML is meant to be a mapping: it says where positions, torques or commands are, or how the log is read.
    pub fn is_meant_by(text: &str) -> bool {
        let keys = ["q", "tau", "command", "time", "topic", "rate-hz"];
        text.parse::<toml::Table>().is_ok_and(|file| keys.iter().any(|key| file.contains_key(*key)))
    }

    /// A mapping file: TOML with `time`, `rate-hz`, `low-pass-hz` or `gaussian-samples`, `kind` (`revolute`, `prismatic`), `topic`,
    /// `torque` (a list of what it is, [`TorqueFact`](crate::recording::torque::TorqueFact)), `encoders` (`link`, `motor`), a table for each of `q`, `qd`, `qdd`,
    /// `tau` with `columns` and, where the numbers are not in SI units, a [`Transform`], and a table `arm`, a [`Chain`]. Where there is no
    /// torque, a table `command` like those in place of `tau`, and a table `drive`, a [`Drive`].
    ///
    /// # Errors
    /// [`MappingError::File`] with the line and what is wrong there.
    pub fn from_toml(text: &str) -> Result<MappingSpec, MappingError> {
        let file: MappingFile = toml::from_str(text).map_err(|error| MappingError::File(error.to_string()))?;
        let mut spec = MappingSpec {
            time: file.time.map(Names::into),
            rate_hz: file.rate_hz,
            low_pass_hz: file.low_pass_hz,
            gaussian_samples: file.gaussian_samples,
            kind: file.kind,
            chain: file.arm,
            topic: file.topic.map(Names::into),
            torque: file.torque,
            encoders: file.encoders,
            drive: file.drive,
            ..MappingSpec::default()
        };
        let tau = torque_or_command(file.tau, file.command, spec.drive.is_some())?;
        if let Some(chain) = &spec.chain {
            chain.check().map_err(|error| MappingError::File(error.to_string()))?;
        }
        let entries = [
            (Channel::Position, file.q),
            (Channel::Velocity, file.qd),
            (Channel::Acceleration, file.qdd),
            (Channel::Torque, tau),
        ];
        for (channel, entry) in entries {
            let Some(ChannelEntry { columns, transform }) = entry else { continue };
            *spec.get_mut(channel) = Some(columns.into());
            if transform != Transform::default() {
                spec.transforms.insert(channel, transform);
            }
        }
        Ok(spec)
    }
}

/// The columns that hold the torque, or the command that it follows from.
fn torque_or_command(
    tau: Option<ChannelEntry>,
    command: Option<ChannelEntry>,
    has_law: bool,
) -> Result<Option<ChannelEntry>, MappingError> {
    let wrong = |problem: &str| Err(MappingError::File(problem.to_owned()));
    match (tau, command) {
        (Some(_), Some(_)) => wrong("it has both `tau` and `command`; a torque that is logged needs no command"),
        (_, Some(_)) if !has_law => wrong(
            "`command` lacks the law by which the torque follows from it: a table `drive` with `law` (position, velocity, voltage) \
             and its constants",
        ),
        (_, None) if has_law => {
            wrong("`drive` states a law, but no table `command` says which columns hold the command")
        }
        (tau, command) => Ok(tau.or(command)),
    }
}

impl MappingSpec {
    /// The mapping file that says the same; [`MappingSpec::from_toml`] reads it.
    ///
    /// # Errors
    /// [`MappingError::File`] if a number of it can't be written.
    pub fn to_toml(&self) -> Result<String, MappingError> {
        let entry = |channel| {
            let columns = Names::Several(self.get(channel)?.to_vec());
            let transform = self.transforms.get(&channel).cloned().unwrap_or_default();
            Some(ChannelEntry { columns, transform })
        };
        let file = MappingFile {
            time: self.time.clone().map(Names::Several),
            rate_hz: self.rate_hz,
            low_pass_hz: self.low_pass_hz,
            gaussian_samples: self.gaussian_samples,
            kind: self.kind,
            topic: self.topic.clone().map(Names::Several),
            torque: self.torque.clone(),
            encoders: self.encoders,
            q: entry(Channel::Position),
            qd: entry(Channel::Velocity),
            qdd: entry(Channel::Acceleration),
            tau: entry(Channel::Torque).filter(|_| self.drive.is_none()),
            command: entry(Channel::Torque).filter(|_| self.drive.is_some()),
            drive: self.drive.clone(),
            arm: self.chain.clone(),
        };
        toml::to_string(&file).map_err(|error| MappingError::File(error.to_string()))
    }
}

impl FromStr for MappingSpec {
    type Err = MappingError;

    fn from_str(text: &str) -> Result<Self, MappingError> {
        let mut spec = MappingSpec::default();
        for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
            let wrong = |problem| MappingError::Text { entry: entry.to_owned(), problem };
            let (key, value) = entry.split_once('=').ok_or_else(|| wrong("has no `=`"))?;
            let names: Vec<String> = value.split('+').map(|name| name.trim().to_owned()).collect();
            let is_empty = names.iter().any(String::is_empty);
            if key.trim() == TOPIC {
                match spec.topic.replace(names) {
                    _ if is_empty => return Err(wrong("names no topic")),
                    Some(_) => return Err(wrong("names topics for the second time; two stand in one entry, with `+`")),
                    None => continue,
                }
            }
            let channel = Channel::ALL.into_iter().find(|channel| channel.key() == key.trim());
            let channel = channel.ok_or_else(|| wrong("does not begin with time, q, qd, qdd, tau or topic"))?;
            if is_empty {
                return Err(wrong("names no column"));
            }
            if spec.get_mut(channel).replace(names).is_some() {
                return Err(wrong("maps a channel for the second time"));
            }
        }
        Ok(spec)
    }
}

impl fmt::Display for MappingSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = Channel::ALL.into_iter().filter_map(|channel| Some((channel.key(), self.get(channel)?)));
        let columns = said.map(|(key, names)| format!("{key}={}", names.join("+")));
        let topic = self.topic.iter().map(|topics| format!("{TOPIC}={}", topics.join("+")));
        let entries: Vec<String> = columns.chain(topic).collect();
        f.write_str(&entries.join(","))
    }
}

impl Mapping {
    /// The names of all columns that are used, those that are used twice twice.
    pub fn used(&self) -> impl Iterator<Item = &String> {
        let derivatives = [&self.qd, &self.qdd].into_iter().flatten().flatten();
        self.time.iter().chain(&self.q).chain(&self.tau).chain(derivatives)
    }

    /// The same as what a user would say: a template for the next file of this kind.
    pub fn to_spec(&self) -> MappingSpec {
        let leave_out = || vec![LEAVE_OUT.to_owned()];
        MappingSpec {
            time: Some(self.time.clone().map_or_else(leave_out, |name| vec![name])),
            q: Some(self.q.clone()),
            qd: Some(self.qd.clone().unwrap_or_else(leave_out)),
            qdd: Some(self.qdd.clone().unwrap_or_else(leave_out)),
            tau: Some(self.tau.clone()),
            ..MappingSpec::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mapping_names_one_topic_or_two_in_each_way_of_writing_it() {
        let topics = |names: &[&str]| Some(names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
        let text: MappingSpec = "topic=/pos + /eff,qd=-".parse().unwrap();
        assert_eq!(text.topic, topics(&["/pos", "/eff"]));
        assert_eq!(text.to_string().parse::<MappingSpec>().unwrap(), text);
        for (file, names) in [("topic = \"/pos\"", &["/pos"][..]), ("topic = [\"/pos\", \"/eff\"]", &["/pos", "/eff"])]
        {
            let spec = MappingSpec::from_toml(file).unwrap();
            assert_eq!(spec.topic, topics(names));
            assert_eq!(MappingSpec::from_toml(&spec.to_toml().unwrap()).unwrap(), spec);
            let stored = serde_json::to_string(&spec).unwrap();
            assert_eq!(serde_json::from_str::<MappingSpec>(&stored).unwrap(), spec);
        }
        for (stored, names) in [("{}", None), (r#"{"topic":null}"#, None), (r#"{"topic":"/pos"}"#, topics(&["/pos"]))] {
            assert_eq!(serde_json::from_str::<MappingSpec>(stored).unwrap().topic, names);
        }
        for wrong in ["topic=", "topic=/pos+", "topic=/pos,topic=/eff"] {
            assert!(matches!(wrong.parse::<MappingSpec>(), Err(MappingError::Text { .. })), "{wrong}");
        }
    }

    #[test]
    fn a_text_that_says_where_channels_are_is_meant_to_be_a_mapping() {
        for text in ["[q]\ncolumns = [\"a\"]", "rate-hz = 100", "topic = \"x\"", "[command]"] {
            assert!(MappingSpec::is_meant_by(text), "{text}");
        }
        for text in ["", "name = \"arm\"", "q1,tau1\n0,1", "[motion]\nq = 1"] {
            assert!(!MappingSpec::is_meant_by(text), "{text}");
        }
    }
}
