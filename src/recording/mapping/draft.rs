//! A mapping on its way: what each column is taken for and why, to be changed column by column by whoever knows better.

use super::choosing::{Guesses, missing};
use super::spec::LEAVE_OUT;
use super::units::{Unit, choices, split_unit, unit_named};
use super::words::{COMMANDED, read_name, why};
use super::{Channel, Mapping, MappingError, MappingSpec};
use crate::recording::JointKind;
use crate::recording::drive::Drive;
use crate::recording::transform::{Factor, Transform};

/// What each column of a log is taken for.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// In the order of the file.
    pub columns: Vec<Role>,
    /// Sampling rate \[Hz\], where no column is a clock.
    pub rate_hz: Option<f64>,
    /// The law of the drive, where the columns of the torque hold its command.
    pub drive: Option<Drive>,
}

/// What a column is taken for.
#[derive(Debug, Clone, PartialEq)]
pub struct Role {
    /// Its name in the file.
    pub name: String,
    /// Its channel; `None` where it is not used.
    pub channel: Option<Channel>,
    /// The channel in whose units its numbers are: a command has those of what it commands, and volts have none.
    pub measures: Option<Channel>,
    /// Its joint, counted from 0; of no meaning for time.
    pub joint: usize,
    /// In which unit its numbers are, one of [`Role::units`].
    pub unit: &'static str,
    /// Whether its sign is turned.
    pub turned: bool,
    /// Why it was guessed so, as a sentence.
    pub why: String,
}

impl Draft {
    /// What the names say by themselves; of several groups of columns that would do the best is taken.
    pub fn guess(names: &[String]) -> Draft {
        let guesses = Guesses::of(names);
        let chosen = guesses.each();
        let role = |name: &String| {
            let found = chosen
                .iter()
                .find_map(|(channel, columns)| Some((*channel, columns.iter().position(|it| it == name)?)));
            let (channel, joint) = found.map_or((None, 0), |(channel, joint)| (Some(channel), joint));
            let why = why(name, channel.is_some());
            Role { name: name.clone(), channel, measures: channel, joint, unit: "", turned: false, why }
                .in_likely_unit()
        };
        Draft { columns: names.iter().map(role).collect(), rate_hz: None, drive: None }
    }

    /// Takes a column for something else: of the first joint that has none there, and in SI units unless its name says others.
    pub fn take_for(&mut self, column: usize, channel: Option<Channel>) {
        let is_taken = |joint: &usize| {
            let mut others =
                self.columns.iter().enumerate().filter(|(other, role)| *other != column && role.channel == channel);
            others.any(|(_, role)| role.joint == *joint)
        };
        let joint = (0..).find(|joint| !is_taken(joint)).unwrap_or(0);
        let measures = self.measured(channel);
        let Some(role) = self.columns.get_mut(column) else { return };
        let (name, why) = (role.name.clone(), "you say so".to_owned());
        *role = Role { name, channel, measures, joint, unit: "", turned: false, why }.in_likely_unit();
    }

    /// States the law by which the torque follows from a command, or that it is logged. A law takes the columns whose names say that they
    /// are its command, where none is taken for one yet.
    pub fn state_drive(&mut self, drive: Option<Drive>) {
        self.drive = drive;
        let measures = self.measured(Some(Channel::Torque));
        for role in self.columns.iter_mut().filter(|role| role.channel == Some(Channel::Torque)) {
            *role = Role { measures, ..role.clone() }.in_likely_unit();
        }
        let commanded = self.drive.as_ref().and_then(Drive::command);
        if commanded.is_none() || self.columns.iter().any(|role| role.channel == Some(Channel::Torque)) {
            return;
        }
        let is_command = |role: &Role| {
            let read = read_name(&role.name);
            role.channel.is_none() && read.is_some_and(|read| Some(read.channel) == commanded && read.rank >= COMMANDED)
        };
        let commands: Vec<usize> =
            (0..self.columns.len()).filter(|column| is_command(&self.columns[*column])).collect();
        for column in commands {
            self.take_for(column, Some(Channel::Torque));
            self.columns[column].why = why(&self.columns[column].name, true);
        }
    }

    /// States a law whose command is in columns that a mapping names, joint after joint.
    pub fn state_command(&mut self, drive: Drive, columns: &[String]) {
        self.state_drive(Some(drive));
        for column in 0..self.columns.len() {
            let joint = columns.iter().position(|name| *name == self.columns[column].name);
            let was_taken = self.columns[column].channel == Some(Channel::Torque);
            if was_taken || joint.is_some() {
                self.take_for(column, joint.map(|_| Channel::Torque));
                self.columns[column].joint = joint.unwrap_or(0);
            }
        }
    }

    /// In the units of which channel numbers are that are taken for one.
    fn measured(&self, channel: Option<Channel>) -> Option<Channel> {
        match (&self.drive, channel) {
            (Some(drive), Some(Channel::Torque)) => drive.command(),
            _ => channel,
        }
    }

    /// The mapping that it makes, every channel stated.
    ///
    /// # Errors
    /// [`MappingError`] if position or torque has no column, or a joint of a channel has none or several.
    pub fn spec(&self) -> Result<MappingSpec, MappingError> {
        let (rate_hz, drive) = (self.rate_hz, self.drive.clone());
        let mut spec = MappingSpec { rate_hz, kind: self.kind(), drive, ..MappingSpec::default() };
        for channel in Channel::ALL {
            let mut roles: Vec<&Role> = self.columns.iter().filter(|role| role.channel == Some(channel)).collect();
            roles.sort_by_key(|role| role.joint);
            self.check(channel, &roles)?;
            if roles.is_empty() {
                spec.set(channel, vec![LEAVE_OUT.to_owned()]);
                continue;
            }
            spec.set(channel, roles.iter().map(|role| role.name.clone()).collect());
            let factors: Vec<f64> = roles.iter().map(|role| role.factor()).collect();
            if channel != Channel::Time && factors.iter().any(|factor| *factor != 1.0) {
                let factor = match factors.windows(2).all(|pair| pair[0] == pair[1]) {
                    true => Factor::Number(factors[0]),
                    false => Factor::PerJoint(factors),
                };
                spec.transforms.insert(channel, Transform { factor: Some(factor), ..Transform::default() });
            }
        }
        // What is said of joints has to fit; names that stand twice are told too.
        let names: Vec<String> = self.columns.iter().map(|role| role.name.clone()).collect();
        let found = Mapping::find(&names, &spec)?;
        if let Some(drive) = &self.drive {
            drive.check_for(found.q.len())?;
        }
        Ok(spec)
    }

    /// What all joints do, where the units of position say that they slide.
    fn kind(&self) -> Option<JointKind> {
        let positions = self.columns.iter().filter(|role| role.channel == Some(Channel::Position));
        let mut kinds = positions.map(|role| unit_named(role.unit).and_then(|unit| unit.kind));
        kinds.all(|kind| kind == Some(JointKind::Prismatic)).then_some(JointKind::Prismatic)
    }

    fn check(&self, channel: Channel, roles: &[&Role]) -> Result<(), MappingError> {
        let is_needed = [Channel::Position, Channel::Torque].contains(&channel);
        if roles.is_empty() && is_needed {
            let names: Vec<String> = self.columns.iter().map(|role| role.name.clone()).collect();
            return Err(missing(channel, &names));
        }
        if channel == Channel::Time {
            return Ok(());
        }
        let joints = roles.iter().map(|role| role.joint + 1).max().unwrap_or(0);
        for joint in 0..joints {
            let count = roles.iter().filter(|role| role.joint == joint).count();
            if count != 1 {
                return Err(MappingError::Joint { channel, joint: joint + 1, count });
            }
        }
        Ok(())
    }
}

impl Role {
    /// In the unit that its name states, or else in SI units.
    fn in_likely_unit(self) -> Role {
        let stated = self.stated();
        let is_it = |text: &&&str| {
            let unit = unit_named(text);
            stated
                .is_none_or(|stated| unit.is_some_and(|unit| unit.factor == stated.factor && unit.kind == stated.kind))
        };
        let unit = self.units().iter().find(is_it).copied().unwrap_or_default();
        Role { unit, ..self }
    }

    /// Its joint, counted from 0; `None` for time, and where it is not used.
    pub fn of_joint(&self) -> Option<usize> {
        self.channel.filter(|channel| *channel != Channel::Time).map(|_| self.joint)
    }

    /// Units that its numbers may be in, SI first; none where it is not used, and of volts.
    pub fn units(&self) -> &'static [&'static str] {
        self.measures.map_or(&[], choices)
    }

    /// The unit that its name states, if that is one of its channel.
    fn stated(&self) -> Option<Unit> {
        split_unit(&self.name).1.filter(|unit| self.measures.is_some_and(|channel| unit.channels.contains(&channel)))
    }

    /// From the numbers of the file to SI units.
    pub fn to_si(&self) -> f64 {
        let stated = self.stated().map_or(1.0, |unit| unit.factor);
        stated * self.factor()
    }

    /// The same beside what its name states, which is applied anyway.
    fn factor(&self) -> f64 {
        let chosen = unit_named(self.unit).map_or(1.0, |unit| unit.factor);
        let stated = self.stated().map_or(1.0, |unit| unit.factor);
        let sign = if self.turned { -1.0 } else { 1.0 };
        sign * chosen / stated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn a_guess_says_why_and_makes_the_mapping_that_reading_makes() {
        let names = names(
            "time_ms pos_meas1 pos_meas2 pos_des1 pos_des2 vel1[deg/s] vel2[deg/s] tau_fric1 tau1 tau2 motor_current1 note",
        );
        let draft = Draft::guess(&names);
        let why = |name: &str| draft.columns.iter().find(|role| role.name == name).unwrap().why.clone();
        assert_eq!(why("pos_meas2"), "`pos` in its name says position, measured");
        assert_eq!(why("pos_des1"), "`pos` in its name says position, commanded; another fits better");
        assert_eq!(why("vel1[deg/s]"), "`vel` in its name says velocity, and its unit");
        assert_eq!(why("tau_fric1"), "`fric` in its name says that it is not what a joint measured");
        assert!(why("motor_current1").contains("no torque by itself"));
        assert_eq!(why("note"), "its name says no channel");
        let spec = draft.spec().unwrap();
        let read = Mapping::find(&names, &MappingSpec::default()).unwrap();
        let drafted = Mapping::find(&names, &spec).unwrap();
        assert_eq!((drafted.time, drafted.q, drafted.qd, drafted.tau), (read.time, read.q, read.qd, read.tau));
        // What the name states is applied anyway.
        assert!(spec.transforms.is_empty());
        assert!((draft.columns[5].to_si() - 1f64.to_radians()).abs() < 1e-15);
    }

    /// A log of a servo: its command is found by its name, in degrees, and the template says the law.
    #[test]
    fn a_law_takes_the_columns_that_command() {
        let mut draft = Draft::guess(&names("time q1 q2 q_cmd1[deg] q_cmd2[deg] u1 u2"));
        assert!(matches!(draft.spec(), Err(MappingError::Missing { channel: Channel::Torque, .. })));
        let [(_, position), (_, velocity), (_, voltage)] = Drive::laws();
        draft.state_drive(Some(velocity));
        assert!(matches!(draft.spec(), Err(MappingError::Missing { .. })), "nothing commands a velocity");
        draft.state_drive(Some(position));
        let taken: Vec<(&str, usize, &str)> = draft
            .columns
            .iter()
            .filter(|role| role.channel == Some(Channel::Torque))
            .map(|role| (role.name.as_str(), role.joint, role.unit))
            .collect();
        assert_eq!(taken, [("q_cmd1[deg]", 0, "deg"), ("q_cmd2[deg]", 1, "deg")]);
        let told = draft.spec().unwrap_err().to_string();
        assert!(told.contains("`kp` of the drive is NaN on joint 1"), "{told}");
        if let Some(Drive::Position { kp, .. }) = &mut draft.drive {
            *kp = "20, 15".parse().unwrap();
        }
        let spec = draft.spec().unwrap();
        let text = spec.to_toml().unwrap();
        assert!(text.contains("[command]") && text.contains("law = \"position\""), "{text}");
        assert_eq!(MappingSpec::from_toml(&text).unwrap(), spec);
        // What was opened so is so again; volts have no unit to be chosen.
        let mut again = Draft::guess(&names("time q1 q2 q_cmd1[deg] q_cmd2[deg] u1 u2"));
        again.state_command(voltage, &["u1".to_owned(), "u2".to_owned()]);
        assert_eq!((again.columns[6].joint, again.columns[6].units().len()), (1, 0));
        assert_eq!(again.columns[3].channel, None);
    }

    /// Every choice stands in the template, which reads back as what it was.
    #[test]
    fn what_is_changed_stands_in_the_template() {
        let mut draft = Draft::guess(&names("when a b c d"));
        assert!(matches!(draft.spec(), Err(MappingError::Missing { channel: Channel::Position, .. })));
        draft.take_for(0, Some(Channel::Time));
        [1, 2].into_iter().for_each(|column| draft.take_for(column, Some(Channel::Position)));
        [3, 4].into_iter().for_each(|column| draft.take_for(column, Some(Channel::Torque)));
        assert_eq!(draft.columns.iter().map(|role| role.joint).collect::<Vec<_>>(), [0, 0, 1, 0, 1]);
        draft.columns[1].unit = "deg";
        draft.columns[2].unit = "deg";
        draft.columns[4].turned = true;
        (draft.columns[3].joint, draft.columns[4].joint) = (1, 0);
        let spec = draft.spec().unwrap();
        assert_eq!(spec.tau.as_deref().unwrap(), ["d", "c"]);
        let text = spec.to_toml().unwrap();
        assert_eq!(MappingSpec::from_toml(&text).unwrap(), spec, "{text}");
        assert!(text.contains("factor = [-1.0, 1.0]") && text.contains("factor = 0.0174"), "{text}");
        draft.columns[3].joint = 0;
        assert_eq!(draft.spec().unwrap_err(), MappingError::Joint { channel: Channel::Torque, joint: 1, count: 2 });
    }
}
