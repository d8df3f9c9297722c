//! What the name of a column says: words for channels, words about them, and the number or name of a joint.

use super::Channel;
use super::units::split_unit;

/// What tells the joints of one channel apart.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Label {
    None,
    Number(usize),
    Name(String),
}

/// Numbers counted from 1, whether the file counts from 0 or from 1.
pub(super) fn from_one(labels: &[Label]) -> Vec<Label> {
    let shift = usize::from(labels.contains(&Label::Number(0)));
    let shifted = |label: &Label| match label {
        Label::Number(number) => Label::Number(number + shift),
        other => other.clone(),
    };
    labels.iter().map(shifted).collect()
}

/// What a column's name says about it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Reading {
    pub channel: Channel,
    pub label: Label,
    /// How welcome it is; less is better.
    pub rank: u8,
    /// The words that joints of one group share.
    pub group: String,
}

/// From this rank on values are commanded, not measured.
pub(super) const COMMANDED: u8 = 5;

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
const TORQUE: &[&str] =
    &["tau", "torque", "torques", "moment", "moments", "effort", "efforts", "trq", "force", "forces", "τ"];
/// Words for the current of a motor, which is no torque.
const CURRENT: &[&str] = &["current", "currents", "amp", "amps", "ampere", "amperes"];

/// Words about a column, and how welcome they make it. Never wanted: `None`. Some say it only behind the word for its channel.
fn qualifier(word: &str, is_behind: bool) -> Option<Option<u8>> {
    Some(match word {
        // What libfranka and many papers call what is desired: `q_d`, `tau_J_d`.
        "d" if is_behind => Some(COMMANDED),
        "meas" | "measured" | "actual" | "act" | "real" | "sensor" | "msr" | "m" => Some(0),
        "filt" | "filtered" | "smooth" | "smoothed" | "lp" => Some(2),
        "raw" | "motor" | "constrained" | "applied" => Some(3),
        "cmd" | "command" | "commanded" | "des" | "desired" | "ref" | "reference" | "target" | "goal" | "setpoint"
        | "sp" | "con" | "control" | "ctrl" | "planned" | "action" => Some(COMMANDED),
        "fric" | "friction" | "err" | "error" | "std" | "var" | "limit" | "min" | "max" | "ff" | "model" | "pred"
        | "predicted" | "gravity" | "est" | "estimated" | "external" | "ext" | "tcp" | "tool" | "cartesian" => None,
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

/// Whether a name is that of the current of a motor.
pub(in crate::recording) fn is_current(name: &str) -> bool {
    let (words, _) = words_and_numbers(split_unit(name).0);
    words.iter().any(|word| CURRENT.contains(&word.as_str()))
}

/// What a name says: `tau_meas2` is measured torque of joint 2. `None` if it says no channel, or nothing wanted.
pub(super) fn read_name(name: &str) -> Option<Reading> {
    let (bare, _) = split_unit(name);
    let (words, numbers) = words_and_numbers(bare);
    let mut channel = None;
    let mut rank = PLAIN;
    let mut qualifiers = Vec::new();
    let mut unknown = Vec::new();
    for word in &words {
        if let (None, Some(found)) = (channel, channel_of(word)) {
            channel = Some(found);
        } else if let Some(welcome) = qualifier(word, channel.is_some()) {
            let welcome = welcome?;
            rank = if qualifiers.is_empty() { welcome } else { rank.max(welcome) };
            qualifiers.push(word.as_str());
        } else if !FILLER.contains(&word.as_str()) {
            unknown.push(word.as_str());
        }
    }
    let is_position = is_axis_of_kuka(bare) || is_of_lerobot(&words);
    let channel = channel.or_else(|| is_position.then_some(Channel::Position))?;
    // `t_motor` is hardly a clock, but the field `t` of a struct `log` is one.
    let is_vague = words.len() > 1 && words.iter().any(|word| word == "t") && !bare.ends_with(".t");
    // The second clock of a log is none; that of the second robot is.
    let is_numbered = !words_and_numbers(bare.rsplit(['.', '/']).next().unwrap_or(bare)).1.is_empty();
    if channel == Channel::Time && (is_numbered || is_vague) {
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

/// Whether it is one of KUKA's own names of axis angles, which have no word for what they are: the variables `$AXIS_ACT` and
/// `$AXIS_ACT_MEAS`, and `AIPos` of its Robot Sensor Interface; the axes are A1, A2, …
pub(super) fn is_axis_of_kuka(name: &str) -> bool {
    let (words, _) = words_and_numbers(name);
    let words: Vec<&str> = words.iter().map(String::as_str).filter(|word| *word != "a").collect();
    matches!(words.as_slice(), ["axis", "act"] | ["axis", "act", "meas"] | ["aipos"])
}

/// Whether it is one of LeRobot's names of positions: `observation.state`, and `action` for those that are commanded.
fn is_of_lerobot(words: &[String]) -> bool {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    matches!(words.as_slice(), ["observation", "state"] | ["action"])
}

/// Why a name is taken for a channel, or for none; as a sentence.
pub(super) fn why(name: &str, is_taken: bool) -> String {
    let (bare, unit) = split_unit(name);
    let (words, _) = words_and_numbers(bare);
    let of_channel = words.iter().find_map(|word| Some((word, channel_of(word)?)));
    let place = words.iter().position(|word| channel_of(word).is_some()).unwrap_or(words.len());
    let unwanted = words.iter().find(|word| qualifier(word, false) == Some(None));
    let about: Vec<&str> = words.iter().enumerate().filter_map(|(at, word)| welcome(word, at > place)).collect();
    let mut text = match (of_channel, unwanted) {
        _ if is_current(name) => "its name is that of a motor's current, which is no torque by itself".to_owned(),
        (_, Some(word)) => format!("`{word}` in its name says that it is not what a joint measured"),
        (None, None) if is_axis_of_kuka(bare) => "its name is KUKA's for the angle of an axis".to_owned(),
        (None, None) if is_of_lerobot(&words) => "its name is LeRobot's for positions".to_owned(),
        (None, None) => "its name says no channel".to_owned(),
        (Some((word, channel)), None) => format!("`{word}` in its name says {}", channel.title()),
    };
    about.iter().for_each(|words| text += &format!(", {words}"));
    text += if unit.is_some() { ", and its unit" } else { "" };
    let is_passed_over = !is_taken && read_name(name).is_some();
    text + if is_passed_over { "; another fits better" } else { "" }
}

/// What a word about a column says, in words.
fn welcome(word: &str, is_behind: bool) -> Option<&'static str> {
    Some(match qualifier(word, is_behind)?? {
        0 => "measured",
        2 => "filtered",
        COMMANDED => "commanded",
        _ => "raw or of the motor",
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_lerobot_and_kuka_are_whole_names() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for (text, is_it) in [
            ("observation state", true),
            ("action", true),
            ("state", false),
            ("observation", false),
            ("action state", false),
        ] {
            assert_eq!(is_of_lerobot(&words(text)), is_it, "{text}");
        }
        for (text, is_it) in
            [("axis act", true), ("axis act meas a", true), ("aipos", true), ("axis", false), ("act", false)]
        {
            assert_eq!(is_axis_of_kuka(text), is_it, "{text}");
        }
    }
}
