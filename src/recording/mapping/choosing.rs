//! The columns for each channel: those that the user names, else the best group of those whose names say it.

use std::collections::BTreeMap;

use super::spec::LEAVE_OUT;
use super::words::{COMMANDED, Label, Reading, from_one, read_name};
use super::{Channel, Mapping, MappingError, MappingSpec};

impl Mapping {
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

pub(super) fn missing(channel: Channel, columns: &[String]) -> MappingError {
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

    /// Whether to take what was commanded for a derivative of what was measured: the measured one can be computed.
    fn is_better_than_derived(&self, position: Option<&Choice>) -> bool {
        let is_derivative = matches!(self.channel, Channel::Velocity | Channel::Acceleration);
        !(is_derivative && self.commanded && position.is_some_and(|position| !position.commanded))
    }
}

struct Group<'a> {
    rank: u8,
    first: usize,
    members: Vec<(Label, &'a String)>,
}

/// Everything that the names of the columns say.
pub(super) struct Guesses<'a> {
    columns: &'a [String],
    groups: BTreeMap<(Channel, String), Group<'a>>,
}

impl<'a> Guesses<'a> {
    pub(super) fn of(columns: &'a [String]) -> Self {
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

    /// The columns that fit each channel best, in the order of the joints; channels for which none do are left out.
    pub(super) fn each(&self) -> Vec<(Channel, Vec<String>)> {
        let position = self.guessed(Channel::Position, None);
        let of = |channel| {
            let mut choice = self.guessed(channel, position.as_ref())?;
            if let Some(position) = &position {
                // Where they are of other joints they keep their own order.
                let _ = choice.follow(position);
            }
            let most = if channel == Channel::Time { 1 } else { usize::MAX };
            Some((channel, choice.columns.into_iter().take(most).collect()))
        };
        Channel::ALL.into_iter().filter_map(of).collect()
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
            None => self.guessed(channel, position).filter(|choice| choice.is_better_than_derived(position)),
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

/// The columns that a pattern means, in the order of their numbers; those of a range such as `c2..c7` in the order of the file.
fn matching(columns: &[String], pattern: &str) -> Vec<(Label, String)> {
    if columns.iter().any(|name| name == pattern) {
        return vec![(label_of(pattern), pattern.to_owned())];
    }
    if let Some((first, last)) = pattern.split_once("..") {
        let place = |wanted: &str| columns.iter().position(|name| name == wanted);
        let range = place(first).zip(place(last)).map_or(0..0, |(first, last)| first..last + 1);
        return columns.get(range).unwrap_or_default().iter().map(|name| (label_of(name), name.clone())).collect();
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
            "log.t log.q[0] log.q[1] log.qd[0] log.qd[1] log.qdd[0] log.qdd[1] log.tau[0] log.tau[1]",
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

    /// As libfranka writes them.
    #[test]
    fn what_is_desired_is_not_taken_for_measured() {
        let measured = guess(
            "time q[0] q[1] q_d[0] q_d[1] dq[0] dq[1] dq_d[0] dq_d[1] ddq_d[0] ddq_d[1] tau_J[0] tau_J[1] \
             tau_J_d[0] tau_J_d[1]",
        );
        let taken = (&measured.q[0], &measured.qd.as_ref().unwrap()[0], &measured.tau[0]);
        assert_eq!(taken, (&"q[0]".to_owned(), &"dq[0]".to_owned(), &"tau_J[0]".to_owned()));
        assert_eq!((measured.qdd, measured.commanded), (None, Vec::new()), "it is derived from what was measured");
        let desired = guess("time q_d[0] q_d[1] ddq_d[0] ddq_d[1] tau_J_d[0] tau_J_d[1]");
        assert_eq!(desired.commanded, [Channel::Position, Channel::Torque, Channel::Acceleration]);
        assert_eq!(desired.qdd.unwrap(), ["ddq_d[0]", "ddq_d[1]"]);
    }

    #[test]
    fn a_clock_stands_behind_a_path_with_numbers_too() {
        for (clock, rest) in
            [("robot1.time", "robot1.q[0] robot1.tau[0]"), ("data.demo_0.time", "data.demo_0.q1 data.demo_0.tau1")]
        {
            assert_eq!(guess(&format!("{clock} {rest}")).time.as_deref(), Some(clock));
        }
        assert_eq!(guess("time1 time q1 tau1").time.as_deref(), Some("time"));
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
        let ranges: MappingSpec = "q=c2..c3,qd=c4..c5+c1,tau=c6..c8,time=-".parse().unwrap();
        let names = columns("c1 c2 c3 c4 c5 c6 c7 c8");
        let found = Mapping::find(&names, &"q=c2..c4,tau=c6..c8,time=-".parse().unwrap()).unwrap();
        assert_eq!((found.q, found.tau), (columns("c2 c3 c4"), columns("c6 c7 c8")));
        let error = Mapping::find(&names, &ranges).unwrap_err().to_string();
        assert!(error.contains("position has 2 joints"), "{error}");
        let error = Mapping::find(&names, &"q=c2..c9,tau=c6".parse().unwrap()).unwrap_err().to_string();
        assert!(error.contains("`q=c2..c9` matches no column"), "{error}");
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
}
