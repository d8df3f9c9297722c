//! Which column is which channel: guessed from the names, or said by the user as text or in a session file.
//!
//! A guess prefers measured over plain over filtered over commanded columns. Position and torque must be found; velocity
//! and acceleration are derived where they are missing; a file without time needs a sampling rate.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::JointKind;
use super::transform::Transform;
use crate::arm::chain::Chain;

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

/// What the user says about the mapping. What is `None` is guessed. As text:
/// `q=pos_filt*,qd=vel_filt*,qdd=-,tau=tau_a+tau_b,time=time`.
///
/// Each entry is the name of a column or of an array, or a pattern in which `*` stands for the number (or the name) of
/// the joint; `+` joins several; `-` alone leaves the channel out, so that it is derived. A mapping file
/// ([`MappingSpec::from_toml`]) says more than columns.
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
    /// What the joints do, where the columns do not say it.
    pub kind: Option<JointKind>,
    /// Where the axes of the arm are.
    pub chain: Option<Chain>,
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
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
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
    /// A needed channel was not found.
    #[error(
        "no {} column was recognised among: {}; say which it is, for example `{example}` (`*` stands for the joint number)",
        channel.title(), list(columns)
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

/// Names for a message; a long list is cut, and says so.
fn list(names: &[String]) -> String {
    const MOST: usize = 60;
    let shown = names.iter().take(MOST).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > MOST { format!("{shown} and {} more", names.len() - MOST) } else { shown }
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
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct MappingFile {
    time: Option<Names>,
    rate_hz: Option<f64>,
    low_pass_hz: Option<f64>,
    kind: Option<JointKind>,
    q: Option<ChannelEntry>,
    qd: Option<ChannelEntry>,
    qdd: Option<ChannelEntry>,
    tau: Option<ChannelEntry>,
    arm: Option<Chain>,
}

#[derive(Deserialize)]
struct ChannelEntry {
    columns: Names,
    #[serde(flatten)]
    transform: Transform,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "columns are a name, a pattern with `*`, or a list of them")]
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

impl MappingSpec {
    /// A mapping file: TOML with `time`, `rate-hz`, `low-pass-hz`, `kind` (`revolute`, `prismatic`), a table for each of `q`, `qd`, `qdd`,
    /// `tau` with `columns` and, where the numbers are not in SI units, a [`Transform`], and a table `arm`, a [`Chain`].
    ///
    /// # Errors
    /// [`MappingError::File`] with the line and what is wrong there.
    pub fn from_toml(text: &str) -> Result<MappingSpec, MappingError> {
        let file: MappingFile = toml::from_str(text).map_err(|error| MappingError::File(error.to_string()))?;
        let mut spec = MappingSpec {
            time: file.time.map(Names::into),
            rate_hz: file.rate_hz,
            low_pass_hz: file.low_pass_hz,
            kind: file.kind,
            chain: file.arm,
            ..MappingSpec::default()
        };
        if let Some(chain) = &spec.chain {
            chain.check().map_err(|error| MappingError::File(error.to_string()))?;
        }
        let entries = [
            (Channel::Position, file.q),
            (Channel::Velocity, file.qd),
            (Channel::Acceleration, file.qdd),
            (Channel::Torque, file.tau),
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

impl FromStr for MappingSpec {
    type Err = MappingError;

    fn from_str(text: &str) -> Result<Self, MappingError> {
        let mut spec = MappingSpec::default();
        for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
            let wrong = |problem| MappingError::Text { entry: entry.to_owned(), problem };
            let (key, value) = entry.split_once('=').ok_or_else(|| wrong("has no `=`"))?;
            let channel = Channel::ALL.into_iter().find(|channel| channel.key() == key.trim());
            let channel = channel.ok_or_else(|| wrong("does not begin with time, q, qd, qdd or tau"))?;
            let names: Vec<String> = value.split('+').map(|name| name.trim().to_owned()).collect();
            if names.iter().any(String::is_empty) {
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
        let entries: Vec<String> = said.map(|(key, names)| format!("{key}={}", names.join("+"))).collect();
        f.write_str(&entries.join(","))
    }
}

impl Mapping {
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

    /// Finds the channels among `columns`: what `spec` says, the rest guessed.
    ///
    /// # Errors
    /// [`MappingError`] where position or torque is missing, a name is unknown or ambiguous, or the joints differ.
    pub fn find(columns: &[String], spec: &MappingSpec) -> Result<Mapping, MappingError> {
        let guesses = Guesses::of(columns);
        let position =
            guesses.channel(Channel::Position, spec, None)?.ok_or_else(|| missing(Channel::Position, columns))?;
        let like_position = |channel| guesses.channel(channel, spec, Some(&position));
        let torque = like_position(Channel::Torque)?.ok_or_else(|| missing(Channel::Torque, columns))?;
        let velocity = like_position(Channel::Velocity)?;
        let acceleration = like_position(Channel::Acceleration)?;
        let time = guesses.channel(Channel::Time, spec, None)?;

        let mut mapping = Mapping { joints: position.joint_names(), ..Mapping::default() };
        let found = [Some(&position), Some(&torque), velocity.as_ref(), acceleration.as_ref(), time.as_ref()];
        for choice in found.into_iter().flatten() {
            mapping.alternatives.extend(choice.alternatives.iter().cloned());
            if choice.commanded {
                mapping.commanded.push(choice.channel);
            }
        }
        mapping.q = position.columns;
        mapping.tau = torque.columns;
        mapping.qd = velocity.map(|choice| choice.columns);
        mapping.qdd = acceleration.map(|choice| choice.columns);
        mapping.time = time.and_then(|choice| choice.columns.into_iter().next());
        Ok(mapping)
    }
}

/// What leaves a channel out.
const LEAVE_OUT: &str = "-";

fn missing(channel: Channel, columns: &[String]) -> MappingError {
    let says = |name: &String| read_name(name).map(|reading| reading.channel);
    // What the names say, else columns that say nothing, else names that only show the form.
    let mut silent = columns.iter().filter(|name| says(name).is_none()).map(|name| starred(name)).collect::<Vec<_>>();
    silent.dedup();
    let mut silent = silent.into_iter();
    let mut pattern = |wanted: Channel, otherwise: &str| {
        let said = columns.iter().find(|name| says(name) == Some(wanted)).map(|name| starred(name));
        said.or_else(|| silent.next()).unwrap_or_else(|| otherwise.to_owned())
    };
    let example = format!("q={},tau={}", pattern(Channel::Position, "angle*"), pattern(Channel::Torque, "torque*"));
    MappingError::Missing { channel, columns: columns.to_vec(), example }
}

/// The columns that were chosen for a channel.
struct Choice {
    channel: Channel,
    columns: Vec<String>,
    labels: Vec<Label>,
    alternatives: Vec<String>,
    commanded: bool,
}

impl Choice {
    fn check_unambiguous(&self, all: &[String]) -> Result<(), MappingError> {
        for name in &self.columns {
            let count = all.iter().filter(|other| *other == name).count();
            if count > 1 {
                return Err(MappingError::Ambiguous { channel: self.channel, name: name.clone(), count });
            }
        }
        Ok(())
    }

    /// Puts guessed columns into the order of the joints of `position`; false if they are of other joints.
    fn follow(&mut self, position: &Choice) -> bool {
        if self.labels.len() != position.labels.len() {
            return false;
        }
        if !self.labels.iter().all(|label| matches!(label, Label::Name(_))) {
            return from_one(&self.labels) == from_one(&position.labels);
        }
        let place = |label: &Label| self.labels.iter().position(|own| own == label);
        let Some(order) = position.labels.iter().map(place).collect::<Option<Vec<usize>>>() else { return false };
        self.columns = order.iter().map(|&index| self.columns[index].clone()).collect();
        self.labels = position.labels.clone();
        true
    }

    fn joint_names(&self) -> Vec<String> {
        let labels = from_one(&self.labels);
        let name = |(index, label): (usize, &Label)| match label {
            Label::Number(number) => format!("joint {number}"),
            Label::Name(name) => name.clone(),
            Label::None => format!("joint {}", index + 1),
        };
        labels.iter().enumerate().map(name).collect()
    }
}

/// What tells the joints of one channel apart.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Label {
    None,
    Number(usize),
    Name(String),
}

/// Numbers counted from 1, whether the file counts from 0 or from 1.
fn from_one(labels: &[Label]) -> Vec<Label> {
    let shift = usize::from(labels.contains(&Label::Number(0)));
    let shifted = |label: &Label| match label {
        Label::Number(number) => Label::Number(number + shift),
        other => other.clone(),
    };
    labels.iter().map(shifted).collect()
}

/// What a column's name says about it.
#[derive(Debug, Clone, PartialEq)]
struct Reading {
    channel: Channel,
    label: Label,
    /// How welcome it is; less is better.
    rank: u8,
    /// The words that joints of one group share.
    group: String,
}

struct Group<'a> {
    rank: u8,
    first: usize,
    members: Vec<(Label, &'a String)>,
}

/// Everything that the names of the columns say.
struct Guesses<'a> {
    columns: &'a [String],
    groups: BTreeMap<(Channel, String), Group<'a>>,
}

/// From this rank on values are commanded, not measured.
const COMMANDED: u8 = 5;

impl<'a> Guesses<'a> {
    fn of(columns: &'a [String]) -> Self {
        let mut groups = BTreeMap::new();
        for (first, column) in columns.iter().enumerate() {
            if let Some(Reading { channel, label, rank, group }) = read_name(column) {
                let group =
                    groups.entry((channel, group)).or_insert_with(|| Group { rank, first, members: Vec::new() });
                group.members.push((label, column));
            }
        }
        for group in groups.values_mut() {
            // Joint names keep the order of the file, numbers count.
            if group.members.iter().all(|(label, _)| matches!(label, Label::Number(_))) {
                group.members.sort_by(|a, b| a.0.cmp(&b.0));
            }
        }
        Guesses { columns, groups }
    }

    /// The columns for a channel; with the same joints as `position`, where that is given.
    fn channel(
        &self,
        channel: Channel,
        spec: &MappingSpec,
        position: Option<&Choice>,
    ) -> Result<Option<Choice>, MappingError> {
        let choice = match spec.get(channel) {
            Some([single]) if single == LEAVE_OUT => return Ok(None),
            Some(patterns) => Some(self.said(channel, patterns)?),
            None => self.guessed(channel, position),
        };
        let Some(mut choice) = choice else { return Ok(None) };
        choice.check_unambiguous(self.columns)?;
        if channel == Channel::Time && choice.columns.len() > 1 {
            let (name, count) = (choice.columns.join("`, `"), choice.columns.len());
            return Err(MappingError::Ambiguous { channel, name, count });
        }
        if let Some(position) = position {
            let same_joints = match spec.get(channel) {
                None => choice.follow(position),
                Some(_) => choice.columns.len() == position.columns.len(),
            };
            if !same_joints {
                let (position, other) = (position.columns.clone(), choice.columns);
                return Err(MappingError::JointsDiffer { channel, position, other });
            }
        }
        Ok(Some(choice))
    }

    fn said(&self, channel: Channel, patterns: &[String]) -> Result<Choice, MappingError> {
        let mut found: Vec<(Label, String)> = Vec::new();
        for pattern in patterns {
            let matched = matching(self.columns, pattern);
            if matched.is_empty() {
                let columns = self.columns.to_vec();
                return Err(MappingError::NoSuchColumn { channel, pattern: pattern.clone(), columns });
            }
            found.extend(matched);
        }
        let (labels, columns) = found.into_iter().unzip();
        Ok(Choice { channel, columns, labels, alternatives: Vec::new(), commanded: false })
    }

    fn guessed(&self, channel: Channel, position: Option<&Choice>) -> Option<Choice> {
        let mut groups: Vec<&Group> =
            self.groups.iter().filter(|((other, _), _)| *other == channel).map(|(_, group)| group).collect();
        groups.sort_by_key(|group| {
            let fits = position.is_none_or(|position| group.members.len() == position.columns.len());
            (!fits, group.rank, group.first)
        });
        let (best, others) = groups.split_first()?;
        let (labels, columns) = best.members.iter().map(|(label, name)| (label.clone(), (*name).clone())).unzip();
        let alternatives =
            others.iter().map(|group| format!("{}={}", channel.key(), starred(group.members[0].1))).collect();
        Some(Choice { channel, columns, labels, alternatives, commanded: best.rank >= COMMANDED })
    }
}

/// The name with its joint number replaced by `*`.
fn starred(name: &str) -> String {
    let digits: Vec<usize> = name.char_indices().filter(|(_, c)| c.is_ascii_digit()).map(|(at, _)| at).collect();
    match (digits.first(), digits.last()) {
        (Some(&first), Some(&last)) if last - first + 1 == digits.len() => {
            format!("{}*{}", &name[..first], &name[last + 1..])
        }
        _ => name.to_owned(),
    }
}

/// The columns that a pattern means, in the order of their numbers.
fn matching(columns: &[String], pattern: &str) -> Vec<(Label, String)> {
    if columns.iter().any(|name| name == pattern) {
        return vec![(label_of(pattern), pattern.to_owned())];
    }
    let middle = |name: &str| -> Option<String> {
        let (head, tail) = pattern.split_once('*').unwrap_or((pattern, ""));
        let middle = name.strip_prefix(head)?.strip_suffix(tail)?;
        Some(middle.to_owned())
    };
    let whole_array = !pattern.contains('*');
    let mut numbered = Vec::new();
    let mut named = Vec::new();
    for name in columns {
        let Some(middle) = middle(name) else { continue };
        let bracketed = middle.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
        if whole_array && bracketed.is_none() {
            continue;
        }
        match bracketed.unwrap_or(&middle).parse::<usize>() {
            Ok(number) => numbered.push((Label::Number(number), name.clone())),
            Err(_) if !middle.is_empty() => named.push((Label::Name(middle), name.clone())),
            Err(_) => {}
        }
    }
    numbered.sort_by(|a, b| a.0.cmp(&b.0));
    if numbered.is_empty() { named } else { numbered }
}

fn label_of(name: &str) -> Label {
    read_name(name).map_or(Label::None, |reading| reading.label)
}

const TIME: &[&str] = &["time", "timestamp", "timestamps", "stamp", "t", "secs", "seconds", "zeit"];
const POSITION: &[&str] =
    &["q", "pos", "position", "positions", "angle", "angles", "qp", "theta", "jointpos", "jpos", "qm", "qmeas"];
const VELOCITY: &[&str] = &[
    "qd",
    "dq",
    "qv",
    "vel",
    "velocity",
    "velocities",
    "speed",
    "speeds",
    "omega",
    "qdot",
    "dtheta",
    "thetadot",
    "thetad",
    "jointvel",
    "jvel",
];
const ACCELERATION: &[&str] =
    &["qdd", "ddq", "qa", "acc", "accel", "acceleration", "accelerations", "qddot", "ddtheta", "thetaddot", "thetadd"];
const TORQUE: &[&str] = &["tau", "torque", "torques", "effort", "efforts", "trq", "force", "forces", "τ"];

/// Words about a column, and how welcome they make it. Never wanted: `None`.
fn qualifier(word: &str) -> Option<Option<u8>> {
    Some(match word {
        "meas" | "measured" | "actual" | "act" | "real" | "sensor" | "msr" | "m" => Some(0),
        "filt" | "filtered" | "smooth" | "smoothed" | "lp" => Some(2),
        "raw" | "motor" | "constrained" | "applied" => Some(3),
        "cmd" | "command" | "commanded" | "des" | "desired" | "ref" | "reference" | "target" | "goal" | "setpoint"
        | "sp" | "con" | "control" | "ctrl" | "planned" => Some(COMMANDED),
        "fric" | "friction" | "err" | "error" | "std" | "var" | "limit" | "min" | "max" | "ff" | "model" | "pred"
        | "predicted" | "gravity" | "est" | "estimated" | "external" | "ext" => None,
        _ => return None,
    })
}

/// Words that say nothing.
const FILLER: &[&str] =
    &["joint", "joints", "j", "axis", "link", "state", "states", "data", "robot", "arm", "of", "the"];
/// How welcome a column without any word about it is.
const PLAIN: u8 = 1;
/// How welcome a column with an unknown word is.
const UNKNOWN: u8 = 4;

/// What a name says: `tau_meas2` is measured torque of joint 2. `None` if it says no channel, or nothing wanted.
fn read_name(name: &str) -> Option<Reading> {
    let (bare, _) = split_unit(name);
    let (words, numbers) = words_and_numbers(bare);
    let mut channel = None;
    let mut rank = PLAIN;
    let mut qualifiers = Vec::new();
    let mut unknown = Vec::new();
    for word in &words {
        if let (None, Some(found)) = (channel, channel_of(word)) {
            channel = Some(found);
        } else if let Some(welcome) = qualifier(word) {
            let welcome = welcome?;
            rank = if qualifiers.is_empty() { welcome } else { rank.max(welcome) };
            qualifiers.push(word.as_str());
        } else if !FILLER.contains(&word.as_str()) {
            unknown.push(word.as_str());
        }
    }
    let channel = channel?;
    if channel == Channel::Time && (!numbers.is_empty() || words.len() > 1 && words.iter().any(|w| w == "t")) {
        return None;
    }
    let label = match numbers.as_slice() {
        [] if unknown.is_empty() || channel == Channel::Time => Label::None,
        [] => Label::Name(unknown.join(" ")),
        [.., last] => Label::Number(*last),
    };
    // With a number, unknown words describe the group; without, they are the name of the joint.
    if matches!(label, Label::Number(_)) || channel == Channel::Time {
        if !unknown.is_empty() {
            rank = rank.max(UNKNOWN);
        }
        qualifiers.extend(unknown);
    }
    qualifiers.sort_unstable();
    let outer = numbers.iter().rev().skip(1).map(usize::to_string).collect::<Vec<_>>().join(".");
    Some(Reading { channel, label, rank, group: format!("{} {outer}", qualifiers.join(" ")) })
}

fn channel_of(word: &str) -> Option<Channel> {
    let lists = [
        (Channel::Time, TIME),
        (Channel::Position, POSITION),
        (Channel::Velocity, VELOCITY),
        (Channel::Acceleration, ACCELERATION),
        (Channel::Torque, TORQUE),
    ];
    lists.into_iter().find(|(_, words)| words.contains(&word)).map(|(channel, _)| channel)
}

/// Lower-case words and numbers: cut at signs, between letters and digits, and at capitals where the whole is no word.
fn words_and_numbers(name: &str) -> (Vec<String>, Vec<usize>) {
    let mut words = Vec::new();
    let mut numbers = Vec::new();
    for part in name.split(|c: char| !c.is_alphanumeric()) {
        let mut rest = part;
        while let Some(first) = rest.chars().next() {
            let digits = first.is_ascii_digit();
            let end = rest.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(rest.len());
            let (run, after) = rest.split_at(end);
            rest = after;
            match run.parse() {
                Ok(number) if digits => numbers.push(number),
                _ if channel_of(&run.to_lowercase()).is_some() => words.push(run.to_lowercase()),
                _ => words.extend(at_capitals(run)),
            }
        }
    }
    (words, numbers)
}

fn at_capitals(run: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for letter in run.chars() {
        if letter.is_uppercase() && after_small {
            words.push(String::new());
        }
        after_small = letter.is_lowercase();
        if let Some(word) = words.last_mut() {
            word.extend(letter.to_lowercase());
        }
    }
    words
}

/// A unit that a column's name states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    /// As it stands in the name.
    pub text: &'static str,
    /// The channels it can belong to.
    pub channels: &'static [Channel],
    /// SI value of one unit.
    pub factor: f64,
    /// The kind of joint it tells, where it does.
    pub kind: Option<JointKind>,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn unit(text: &'static str, channels: &'static [Channel], factor: f64, kind: Option<JointKind>) -> Unit {
    Unit { text, channels, factor, kind }
}

/// The longer before the shorter ones that they end with.
const UNITS: &[Unit] = {
    use Channel::{Acceleration, Position, Time, Torque, Velocity};
    use JointKind::{Prismatic, Revolute};
    &[
        unit("deg_per_s2", &[Acceleration], DEGREE, Some(Revolute)),
        unit("deg/s^2", &[Acceleration], DEGREE, Some(Revolute)),
        unit("deg/s2", &[Acceleration], DEGREE, Some(Revolute)),
        unit("deg/s²", &[Acceleration], DEGREE, Some(Revolute)),
        unit("rad/s^2", &[Acceleration], 1.0, Some(Revolute)),
        unit("rad/s2", &[Acceleration], 1.0, Some(Revolute)),
        unit("rad/s²", &[Acceleration], 1.0, Some(Revolute)),
        unit("m/s^2", &[Acceleration], 1.0, Some(Prismatic)),
        unit("m/s2", &[Acceleration], 1.0, Some(Prismatic)),
        unit("m/s²", &[Acceleration], 1.0, Some(Prismatic)),
        unit("deg_per_s", &[Velocity], DEGREE, Some(Revolute)),
        unit("rad_per_s", &[Velocity], 1.0, Some(Revolute)),
        unit("deg/s", &[Velocity], DEGREE, Some(Revolute)),
        unit("rad/s", &[Velocity], 1.0, Some(Revolute)),
        unit("mm/s", &[Velocity], 1e-3, Some(Prismatic)),
        unit("m/s", &[Velocity], 1.0, Some(Prismatic)),
        unit("degrees", &[Position], DEGREE, Some(Revolute)),
        unit("deg", &[Position], DEGREE, Some(Revolute)),
        unit("°", &[Position], DEGREE, Some(Revolute)),
        unit("rad", &[Position], 1.0, Some(Revolute)),
        unit("mm", &[Position], 1e-3, Some(Prismatic)),
        unit("mnm", &[Torque], 1e-3, Some(Revolute)),
        unit("knm", &[Torque], 1e3, Some(Revolute)),
        unit("n·m", &[Torque], 1.0, Some(Revolute)),
        unit("n*m", &[Torque], 1.0, Some(Revolute)),
        unit("n m", &[Torque], 1.0, Some(Revolute)),
        unit("nm", &[Torque], 1.0, Some(Revolute)),
        unit("n", &[Torque], 1.0, Some(Prismatic)),
        unit("msec", &[Time], 1e-3, None),
        unit("usec", &[Time], 1e-6, None),
        unit("nsec", &[Time], 1e-9, None),
        unit("sec", &[Time], 1.0, None),
        unit("ms", &[Time], 1e-3, None),
        unit("us", &[Time], 1e-6, None),
        unit("µs", &[Time], 1e-6, None),
        unit("ns", &[Time], 1e-9, None),
        unit("s", &[Time], 1.0, None),
        unit("m", &[Position], 1.0, Some(Prismatic)),
    ]
};

/// The name without the unit that stands at its end, in brackets or after `_`, and that unit.
pub(super) fn split_unit(name: &str) -> (&str, Option<Unit>) {
    let name = name.trim();
    // `speed_deg_per_s[2]`: the unit stands before the number of the joint.
    if let Some((array, number)) = name.strip_suffix(']').and_then(|start| start.rsplit_once('['))
        && number.parse::<usize>().is_ok()
    {
        return (name, split_unit(array).1);
    }
    for (open, close) in [('[', ']'), ('(', ')')] {
        let inside = name.strip_suffix(close).and_then(|start| start.rsplit_once(open));
        if let Some((bare, text)) = inside {
            return match unit_named(text) {
                Some(unit) => (bare.trim_end(), Some(unit)),
                None => (name, None),
            };
        }
    }
    let lower = name.to_ascii_lowercase();
    for unit in UNITS.iter().filter(|unit| unit.text.len() > 1) {
        if let Some(bare) = lower.strip_suffix(unit.text).and_then(|start| start.strip_suffix('_')) {
            return (&name[..bare.len()], Some(*unit));
        }
    }
    (name, None)
}

/// The unit with this text.
pub(super) fn unit_named(text: &str) -> Option<Unit> {
    let text = text.trim().to_lowercase();
    UNITS.iter().find(|unit| unit.text == text).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    fn guess(text: &str) -> Mapping {
        Mapping::find(&columns(text), &MappingSpec::default()).unwrap()
    }

    #[test]
    fn takes_the_measured_columns_of_a_real_log() {
        let found = guess(
            "time pos_meas1 pos_meas2 vel_meas1 vel_meas2 pos_filt1 pos_filt2 vel_filt1 vel_filt2 pos_des1 pos_des2 \
             tau_con1 tau_con2 tau_fric1 tau_fric2 tau_meas1 tau_meas2",
        );
        assert_eq!(found.time.as_deref(), Some("time"));
        assert_eq!(found.q, ["pos_meas1", "pos_meas2"]);
        assert_eq!(found.qd.as_deref().unwrap(), ["vel_meas1", "vel_meas2"]);
        assert_eq!(found.qdd, None);
        assert_eq!(found.tau, ["tau_meas1", "tau_meas2"]);
        assert_eq!(found.joints, ["joint 1", "joint 2"]);
        assert_eq!(found.alternatives, ["q=pos_filt*", "q=pos_des*", "tau=tau_con*", "qd=vel_filt*"]);
    }

    #[test]
    fn knows_many_ways_to_name_channels() {
        for text in [
            "t q1 q2 qd1 qd2 qdd1 qdd2 tau1 tau2",
            "t q_0 q_1 qd_0 qd_1 qdd_0 qdd_1 tau_0 tau_1",
            "timestamp q[0] q[1] dq[0] dq[1] ddq[0] ddq[1] tau[0] tau[1]",
            "time qp[0] qp[1] qv[0] qv[1] qa[0] qa[1] tau[0] tau[1]",
            "Time position1 position2 velocity1 velocity2 acc1 acc2 effort1 effort2",
            "time joint1_pos joint2_pos joint1_vel joint2_vel joint1_acc joint2_acc joint1_torque joint2_torque",
            "time_ms q1_deg q2_deg qDot1 qDot2 qDDot1 qDDot2 tauMeas1 tauMeas2",
            "Time[s] q1[rad] q2[rad] qd1[rad/s] qd2[rad/s] qdd1[rad/s^2] qdd2[rad/s^2] tau1[Nm] tau2[Nm]",
            "time measured_angles[0] measured_angles[1] measured_velocities[0] measured_velocities[1] \
             measured_accelerations[0] measured_accelerations[1] measured_torques[0] measured_torques[1] \
             constrained_torques[0] constrained_torques[1] desired_torques[0] desired_torques[1]",
        ] {
            let names = columns(text);
            let found = guess(text);
            let ours: Vec<String> = [found.time.clone().unwrap()]
                .into_iter()
                .chain(found.q)
                .chain(found.qd.unwrap())
                .chain(found.qdd.unwrap())
                .chain(found.tau)
                .collect();
            assert_eq!(ours, names[..9]);
            assert_eq!(found.joints, ["joint 1", "joint 2"]);
        }
    }

    #[test]
    fn joints_with_names_keep_them_and_the_order_of_the_file() {
        let found = guess("time shoulder_position elbow_position elbow_effort shoulder_effort");
        assert_eq!(found.joints, ["shoulder", "elbow"]);
        assert_eq!(found.q, ["shoulder_position", "elbow_position"]);
        assert_eq!(found.tau, ["shoulder_effort", "elbow_effort"]);
    }

    #[test]
    fn the_user_overrides_and_may_leave_out() {
        let names = columns("time pos_meas1 pos_meas2 pos_filt1 pos_filt2 vel1 vel2 x[0] x[1]");
        let spec: MappingSpec = "q=pos_filt*, tau=x, qd=-".parse().unwrap();
        let found = Mapping::find(&names, &spec).unwrap();
        assert_eq!(found.q, ["pos_filt1", "pos_filt2"]);
        assert_eq!(found.tau, ["x[0]", "x[1]"]);
        assert_eq!(found.qd, None);
        let again = Mapping::find(&names, &found.to_spec()).unwrap();
        assert_eq!((again.q, again.tau, again.time), (found.q, found.tau, found.time));
        assert_eq!(spec.to_string().parse::<MappingSpec>().unwrap(), spec);
        let explicit: MappingSpec = "q=c2+c1,tau=c3+c4,time=-".parse().unwrap();
        let found = Mapping::find(&columns("c1 c2 c3 c4"), &explicit).unwrap();
        assert_eq!((found.q, found.time), (columns("c2 c1"), None));
    }

    #[test]
    fn what_can_not_be_mapped_is_told_with_columns_and_an_example() {
        let find =
            |text: &str, spec: &str| Mapping::find(&columns(text), &spec.parse().unwrap()).unwrap_err().to_string();
        let error = find("Joint_1 Joint_2", "");
        assert!(error.contains("`Joint_1`, `Joint_2`") && error.contains("q="), "{error}");
        assert!(find("time q1 q2 qd1", "qd=-").contains("no torque"));
        assert!(find("time q1 q2 tau1 tau2", "q=p*").contains("`q=p*` matches no column"));
        let error = find("time q1 q2 qd1 tau1 tau2", "");
        assert!(error.contains("`qd=-`"), "{error}");
        assert!(find("q q tau", "").contains("2 columns"), "{}", find("q q tau", ""));
        for text in ["q", "x=1", "q=", "q=a,q=b", "q=a++b"] {
            assert!(matches!(text.parse::<MappingSpec>(), Err(MappingError::Text { .. })), "{text}");
        }
    }

    #[test]
    fn a_name_that_occurs_twice_is_told_only_where_it_is_needed() {
        let found = Mapping::find(&columns("time q1 tau1 note note"), &MappingSpec::default());
        assert!(found.is_ok());
        let error = Mapping::find(&columns("time q1 q1 tau1"), &MappingSpec::default()).unwrap_err().to_string();
        assert!(error.contains("2 columns are named `q1`"), "{error}");
    }

    #[test]
    fn commanded_torque_is_taken_only_where_there_is_no_other_and_that_is_told() {
        assert_eq!(guess("time q1 tau_cmd1").commanded, [Channel::Torque]);
        assert!(guess("time q1 tau_cmd1 tau1").commanded.is_empty());
        assert!(Mapping::find(&columns("time q1 tau_fric1"), &MappingSpec::default()).is_err());
    }

    #[test]
    fn units_are_read_from_names() {
        for (name, bare, text) in [
            ("q1[deg]", "q1", "deg"),
            ("q1 (deg)", "q1", "deg"),
            ("pos_deg", "pos", "deg"),
            ("vel_deg_per_s", "vel", "deg_per_s"),
            ("time_ms", "time", "ms"),
            ("Zeit [s]", "Zeit", "s"),
            ("tau[mNm]", "tau", "mnm"),
        ] {
            let (rest, unit) = split_unit(name);
            assert_eq!((rest, unit.map(|unit| unit.text)), (bare, Some(text)));
        }
        for name in ["q[0]", "tau_meas1", "pos", "q_m1", "rad"] {
            assert_eq!(split_unit(name), (name, None));
        }
    }
}
