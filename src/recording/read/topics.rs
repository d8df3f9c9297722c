//! The topics of a log of messages, in whatever container they come: the one or the two with positions and torques become columns.
//!
//! A message may name its joints, in another order each time, and several arms may speak on one topic. So a number belongs to the joint
//! that it is named for, not to the place where it stands.

use std::cmp::Reverse;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::budget::{Budget, TooMuch};
use super::clocks::{self, Clock, Told};
use super::messages::{Definition, JOINT_STATE, Message, Named, Shape};
use super::table::{Column, Table};
use crate::recording::mapping::{Mapping, MappingSpec};

/// No table can be made of the topics of a log.
#[derive(Debug, thiserror::Error)]
pub enum TopicError {
    /// No topic has what is needed.
    #[error(
        "no topic of the log has positions and torques{}; record /joint_states or /dynamic_joint_states, or name the topic and \
         its columns (`topic=…,q=…,tau=…`)",
        only(there)
    )]
    NoStates {
        /// All topics.
        there: Vec<String>,
        /// The one with most numbers, which may be mapped by hand.
        fullest: Option<String>,
    },
    /// The topic that was asked for is not there, or none of its messages can be read.
    #[error("no topic `{asked}` with numbers is in the log; it has {}", there.join("; "))]
    NoTopic {
        /// What was asked for.
        asked: String,
        /// All topics.
        there: Vec<String>,
    },
    /// Neither one topic nor two.
    #[error("`topic` names {}; name one topic, or two different ones that stand side by side", .0.join(", "))]
    Asked(Vec<String>),
    /// Two topics tell of different joints.
    #[error(
        "the messages of `{}` are of the joints {}, those of `{}` of {}; name two topics with joints in common (`topic=…+…`)",
        topics[0], joints[0], topics[1], joints[1]
    )]
    OtherJoints {
        /// The topics.
        topics: [String; 2],
        /// The joints of each.
        joints: [String; 2],
    },
    /// A message that is cut or lies about its sizes.
    #[error("message {number} of `{topic}` is damaged: {problem}; copy or record the log again")]
    Message {
        /// Counted from 1.
        number: usize,
        /// Its topic.
        topic: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// It would take too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
}

fn only(topics: &[String]) -> String {
    if topics.is_empty() { String::new() } else { format!(", only {}", topics.join("; ")) }
}

/// A topic of a log of messages, for one to be chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SeenTopic {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    pub kind: String,
    /// How many messages it has.
    pub messages: usize,
    /// Whether columns were made of it: as the first, which gives the times (0), or beside it (1).
    pub taken: Option<usize>,
}

/// The topics of a log, by the numbers that the log gives them.
pub(super) struct Topics<'a> {
    /// Those that are to be read; where none are, all.
    asked: &'a [String],
    topics: BTreeMap<i64, Topic>,
}

/// The topics that a table is made of.
enum Chosen {
    One(usize),
    Two(usize, usize),
}

impl<'a> Topics<'a> {
    /// Of a log of which these are asked for.
    pub fn asked_for(asked: &'a [String]) -> Self {
        Topics { asked, topics: BTreeMap::new() }
    }

    /// A topic with messages of a kind, and how they are read, or why not. A log may tell of a topic in each of its parts: the first time
    /// counts.
    pub fn add(
        &mut self,
        id: i64,
        name: &str,
        kind: &str,
        definition: impl FnOnce() -> Result<Definition, String>,
        budget: &mut Budget,
    ) -> Result<(), TooMuch> {
        let Entry::Vacant(entry) = self.topics.entry(id) else { return Ok(()) };
        let definition = definition();
        budget.text(name)?;
        budget.text(kind)?;
        budget.hold(size_of::<Topic>() as u64)?;
        budget.hold(definition.as_ref().map_or(0, Definition::size))?;
        let is_read = self.asked.is_empty() || self.asked.iter().any(|asked| asked == name);
        entry.insert(Topic::new(name, kind, definition, is_read));
        Ok(())
    }

    /// A message of a topic, which the log received at this time \[ns\]; false if there is no such topic.
    pub fn take(&mut self, id: i64, received: i64, data: &[u8], budget: &mut Budget) -> Result<bool, TopicError> {
        let Some(topic) = self.topics.get_mut(&id) else { return Ok(false) };
        topic.take(received, data, budget)?;
        Ok(true)
    }

    /// The table of what is asked for; else of the topic with positions and torques that has the most numbers; else of two that have them
    /// together.
    pub fn table(self, budget: &mut Budget) -> Result<Table, TopicError> {
        let mut topics: Vec<Topic> = self.topics.into_values().collect();
        topics.sort_by_key(|topic| Reverse(topic.values()));
        let chosen = match self.asked {
            [] => choose(&topics)?,
            [one] => Chosen::One(place(&topics, one)?),
            [first, other] if first != other => Chosen::Two(place(&topics, first)?, place(&topics, other)?),
            _ => return Err(TopicError::Asked(self.asked.to_vec())),
        };
        let is_chosen = |index: usize| match chosen {
            Chosen::One(one) => index == one,
            Chosen::Two(first, other) => index == first || index == other,
        };
        let others = topics.iter().enumerate().filter(|(index, _)| !is_chosen(*index));
        let mut passed_over: Vec<String> = others.map(|(_, topic)| topic.told()).collect();
        let seen = seen(&topics, &chosen, budget)?;
        let table = match chosen {
            Chosen::One(one) => topics[one].side(&mut passed_over).alone(passed_over),
            Chosen::Two(first, other) => {
                let [side, other] = [first, other].map(|index| topics[index].side(&mut passed_over));
                side.beside(other, passed_over, budget)?
            }
        };
        Ok(Table { topics: seen, ..table })
    }
}

/// The topics that one can choose from, by their names: those whose messages can be read.
fn seen(topics: &[Topic], chosen: &Chosen, budget: &mut Budget) -> Result<Vec<SeenTopic>, TooMuch> {
    let place = |index: usize| match *chosen {
        Chosen::One(first) => (index == first).then_some(0),
        Chosen::Two(first, other) => [first, other].iter().position(|taken| *taken == index),
    };
    let mut seen = Vec::new();
    for (index, topic) in topics.iter().enumerate().filter(|(_, topic)| topic.definition.is_ok() && topic.count > 0) {
        budget.text(&topic.name)?;
        budget.text(&topic.kind)?;
        let Topic { name, kind, count, .. } = topic;
        seen.push(SeenTopic { name: name.clone(), kind: kind.clone(), messages: *count, taken: place(index) });
    }
    seen.sort_by(|one, other| one.name.cmp(&other.name));
    Ok(seen)
}

/// Where the topic that is asked for stands.
fn place(topics: &[Topic], asked: &str) -> Result<usize, TopicError> {
    let is_it = |topic: &Topic| topic.name == asked && topic.values() > 0;
    topics.iter().position(is_it).ok_or_else(|| TopicError::NoTopic { asked: asked.to_owned(), there: told(topics) })
}

/// More topics are not told: nobody would read them.
const MOST_TOLD: usize = 40;

/// What is said of the topics; of a long list its beginning.
fn told(topics: &[Topic]) -> Vec<String> {
    let others = topics.len().saturating_sub(MOST_TOLD);
    let more = (others > 0).then(|| format!("and {others} more"));
    topics.iter().take(MOST_TOLD).map(Topic::told).chain(more).collect()
}

/// The first topic with positions and torques, else a pair that has them together.
fn choose(topics: &[Topic]) -> Result<Chosen, TopicError> {
    let complete = topics.iter().position(Topic::has_states).map(Chosen::One);
    let chosen = complete.or_else(|| pair(topics).map(|(first, other)| Chosen::Two(first, other)));
    let fullest = || topics.iter().find(|topic| topic.values() > 0).map(|topic| topic.name.clone());
    chosen.ok_or_else(|| TopicError::NoStates { there: told(topics), fullest: fullest() })
}

/// More topics are not paired: each pair is looked at.
const MOST_PAIRED: usize = 64;

/// Of topics none of which has all, two which have it together: that with the positions first.
fn pair(topics: &[Topic]) -> Option<(usize, usize)> {
    let usable: Vec<(usize, &Group)> = topics
        .iter()
        .take(MOST_PAIRED)
        .enumerate()
        .filter_map(|(index, topic)| Some((index, topic.usual().filter(|group| group.is_of_several())?)))
        .collect();
    let mut best: Option<(usize, usize, usize)> = None;
    for (first, own) in &usable {
        for (other, beside) in usable.iter().filter(|(other, _)| other != first) {
            let values = own.values().min(beside.values());
            if best.is_none_or(|(most, ..)| values > most) && own.is_completed_by(beside) {
                best = Some((values, *first, *other));
            }
        }
    }
    best.map(|(_, first, other)| (first, other))
}

/// The messages of a topic.
struct Topic {
    name: String,
    kind: String,
    /// How its messages are read, or why not.
    definition: Result<Definition, String>,
    is_read: bool,
    count: usize,
    /// Where the numbers of messages of a shape go.
    ways: HashMap<Shape, Way>,
    groups: Vec<Group>,
    /// The places of the groups, by what their numbers are.
    known: HashMap<Vec<String>, usize>,
}

/// Where the numbers of a message go: to which group, and to which column there each.
struct Way {
    group: usize,
    columns: Vec<usize>,
}

impl Topic {
    fn new(name: &str, kind: &str, definition: Result<Definition, String>, is_read: bool) -> Topic {
        let (ways, groups, known) = Default::default();
        Topic { name: name.to_owned(), kind: kind.to_owned(), definition, is_read, count: 0, ways, groups, known }
    }

    fn take(&mut self, received: i64, data: &[u8], budget: &mut Budget) -> Result<(), TopicError> {
        self.count += 1;
        let Some(definition) = self.definition.as_ref().ok().filter(|_| self.is_read) else { return Ok(()) };
        let Message { shape, values } = definition.decode(data).map_err(|problem| self.damaged(problem))?;
        budget.unpack((values.len() as u64 + 1) * size_of::<f64>() as u64)?;
        let way = match self.ways.get(&shape) {
            Some(way) => way,
            None => {
                if self.kind == JOINT_STATE && !shape.has_a_value_for_each_joint() {
                    return Err(self.damaged("it has another number of values than of joints"));
                }
                let way = self.way(&shape, budget)?;
                self.ways.entry(shape).or_insert(way)
            }
        };
        let group = &mut self.groups[way.group];
        group.received.push(received);
        way.columns.iter().zip(values).for_each(|(column, value)| group.columns[*column].push(value));
        Ok(())
    }

    fn damaged(&self, problem: &'static str) -> TopicError {
        TopicError::Message { number: self.count, topic: self.name.clone(), problem }
    }

    /// Where the numbers of messages of a new shape go: to a group of the same numbers of the same joints, in whatever order.
    fn way(&mut self, shape: &Shape, budget: &mut Budget) -> Result<Way, TooMuch> {
        shape.texts().try_for_each(|text| budget.text(text))?;
        let named = shape.named();
        let labels: Vec<String> = named.iter().map(Named::label).collect();
        let mut order: Vec<usize> = (0..labels.len()).collect();
        order.sort_by_key(|index| &labels[*index]);
        let key: Vec<String> = order.iter().map(|index| labels[*index].clone()).collect();
        key.iter().try_for_each(|label| budget.text(label))?;
        let group = match self.known.get(&key) {
            Some(group) => *group,
            None => {
                labels.iter().try_for_each(|label| budget.name(label))?;
                self.known.insert(key, self.groups.len());
                self.groups.push(Group::of(named, order.clone()));
                self.groups.len() - 1
            }
        };
        let mut columns = vec![0; order.len()];
        order.iter().zip(&self.groups[group].order).for_each(|(index, column)| columns[*index] = *column);
        Ok(Way { group, columns })
    }

    /// The group with the most numbers, of several the one that came first.
    fn usual(&self) -> Option<&Group> {
        self.groups.iter().rev().max_by_key(|group| group.values())
    }

    /// How many numbers it gives.
    fn values(&self) -> usize {
        self.usual().map_or(0, Group::values)
    }

    /// Whether it has what a recording needs.
    fn has_states(&self) -> bool {
        self.usual().is_some_and(|group| {
            group.is_of_several() && Mapping::find(&group.names(), &MappingSpec::default()).is_ok()
        })
    }

    fn told(&self) -> String {
        let kind = (!self.kind.is_empty()).then(|| self.kind.clone());
        let why = self.definition.as_ref().err().cloned();
        let about: Vec<String> = kind.into_iter().chain([format!("{} messages", self.count)]).chain(why).collect();
        format!("topic `{}` ({})", self.name, about.join(", "))
    }

    /// Takes out what it gives: the numbers of its usual group.
    fn side(&mut self, passed_over: &mut Vec<String>) -> Side {
        let groups = std::mem::take(&mut self.groups).into_iter();
        let group = groups.rev().max_by_key(Group::values).unwrap_or_default().in_order();
        let others = self.count - group.received.len();
        if others > 0 {
            let joints = match group.joints.as_slice() {
                [] => String::new(),
                joints => format!("of other joints than {} or ", joints.join(", ")),
            };
            passed_over.push(format!("{others} messages of `{}` {joints}with other values", self.name));
        }
        let clock = Clock { stamps: group.stamps(), received: group.received };
        let numbers =
            group.named.into_iter().zip(group.columns).filter(|(named, _)| !named.is_of_the_clock()).collect();
        Side { topic: self.name.clone(), numbers, clock, joints: group.joints }
    }
}

/// Messages that hold the same numbers of the same joints.
#[derive(Default)]
struct Group {
    /// What its columns are, in the order of the first message.
    named: Vec<Named>,
    /// The columns in the order of what they are.
    order: Vec<usize>,
    joints: Vec<String>,
    /// When the log received each message \[ns\].
    received: Vec<i64>,
    columns: Vec<Vec<f64>>,
}

impl Group {
    fn of(named: Vec<Named>, order: Vec<usize>) -> Group {
        let mut known = BTreeSet::new();
        let joints = named.iter().filter_map(Named::joint).filter(|joint| known.insert(*joint));
        let joints = joints.map(str::to_owned).collect();
        Group { columns: vec![Vec::new(); named.len()], named, order, joints, received: Vec::new() }
    }

    fn values(&self) -> usize {
        self.columns.len() * self.received.len()
    }

    /// Whether it has more than one message: a single one is no log, even if a whole trajectory stands in it, which was commanded.
    fn is_of_several(&self) -> bool {
        self.received.len() > 1
    }

    fn names(&self) -> Vec<String> {
        self.named.iter().map(Named::name).collect()
    }

    /// Whether it has the positions and another one the torques, of joints that both have.
    fn is_completed_by(&self, other: &Group) -> bool {
        let joints = common(&self.joints, &other.joints);
        let names = |group: &Group| {
            let mut named = group.named.clone();
            if let Some(joints) = &joints {
                let places = places(joints);
                named.retain_mut(|named| named.follow(&places));
            }
            named.iter().map(Named::name).collect::<Vec<String>>()
        };
        let (own, others) = (names(self), names(other));
        let together: Vec<String> =
            own.iter().chain(others.iter().filter(|name| !own.contains(name))).cloned().collect();
        Mapping::find(&together, &MappingSpec::default()).is_ok_and(|mapping| {
            mapping.q.iter().all(|name| own.contains(name)) && !mapping.tau.iter().any(|name| own.contains(name))
        })
    }

    /// The same with its messages in the order in which they were received.
    fn in_order(mut self) -> Group {
        if !self.received.is_sorted() {
            let mut order: Vec<usize> = (0..self.received.len()).collect();
            order.sort_by_key(|message| self.received[*message]);
            self.received = order.iter().map(|message| self.received[*message]).collect();
            for column in &mut self.columns {
                *column = order.iter().map(|message| column[*message]).collect();
            }
        }
        self
    }

    /// When the messages were measured \[ns\]; empty where they do not say it.
    fn stamps(&self) -> Vec<i64> {
        let column = |wanted: &str| {
            let place = self.named.iter().position(|named| named.name() == wanted);
            place.map_or(&[][..], |place| self.columns[place].as_slice())
        };
        let whole =
            |(sec, nanosec): (&f64, &f64)| (*sec as i64).saturating_mul(1_000_000_000).saturating_add(*nanosec as i64);
        column("header.stamp.sec").iter().zip(column("header.stamp.nanosec")).map(whole).collect()
    }
}

/// The joints that both have, in the order of the first; `None` where one of them names none.
fn common(own: &[String], other: &[String]) -> Option<Vec<String>> {
    let others: BTreeSet<&String> = other.iter().collect();
    let both = own.iter().filter(|joint| others.contains(joint)).cloned().collect();
    (!own.is_empty() && !other.is_empty()).then_some(both)
}

fn places(joints: &[String]) -> HashMap<&str, usize> {
    joints.iter().enumerate().map(|(place, joint)| (joint.as_str(), place)).collect()
}

/// What a topic gives.
struct Side {
    topic: String,
    numbers: Vec<(Named, Vec<f64>)>,
    clock: Clock,
    joints: Vec<String>,
}

impl Side {
    /// Its table; time is that of the measurement, unless nobody stamped it.
    fn alone(self, passed_over: Vec<String>) -> Table {
        let told = self.clock.told(&self.topic);
        table(columns(self.numbers), &self.clock, self.joints, told, passed_over)
    }

    /// The table of both at its own times, joint by joint; of what both have, its own is taken.
    fn beside(
        mut self,
        mut other: Side,
        mut passed_over: Vec<String>,
        budget: &mut Budget,
    ) -> Result<Table, TopicError> {
        self.agree(&mut other, &mut passed_over)?;
        let mut own = columns(self.numbers);
        let mut others = columns(other.numbers);
        others.retain(|column| own.iter().all(|own| own.name != column.name));
        let topics = [self.topic.as_str(), other.topic.as_str()];
        let (others, told) = clocks::beside(&self.clock, &other.clock, topics, others, budget)?;
        own.extend(others);
        Ok(table(own, &self.clock, self.joints, Some(told), passed_over))
    }

    /// Leaves both the joints that both have, in the same order.
    fn agree(&mut self, other: &mut Side, passed_over: &mut Vec<String>) -> Result<(), TopicError> {
        match common(&self.joints, &other.joints) {
            Some(joints) if joints.is_empty() => {
                let topics = [&self.topic, &other.topic].map(String::clone);
                let joints = [&self.joints, &other.joints].map(|joints| joints.join(", "));
                return Err(TopicError::OtherJoints { topics, joints });
            }
            Some(joints) => {
                passed_over.extend(self.follow(&joints));
                passed_over.extend(other.follow(&joints));
            }
            None if self.joints.is_empty() && other.joints.is_empty() => {}
            None => {
                let (named, unnamed) = if self.joints.is_empty() { (&*other, &*self) } else { (&*self, &*other) };
                passed_over.push(format!(
                    "the order of the joints of `{}`: its messages name none, so that of `{}` was taken",
                    unnamed.topic, named.topic
                ));
                self.joints.append(&mut other.joints);
            }
        }
        Ok(())
    }

    /// Keeps the numbers of these joints, in their order, and what is of no joint; tells which joints it leaves out.
    fn follow(&mut self, joints: &[String]) -> Option<String> {
        let places = places(joints);
        self.numbers.retain_mut(|(named, _)| named.follow(&places));
        self.joints.retain(|joint| !places.contains_key(joint.as_str()));
        let left_out = std::mem::replace(&mut self.joints, joints.to_vec());
        let told = || format!("joints {}, which only `{}` has", left_out.join(", "), self.topic);
        (!left_out.is_empty()).then(told)
    }
}

fn columns(numbers: Vec<(Named, Vec<f64>)>) -> Vec<Column> {
    numbers.into_iter().map(|(named, values)| Column { name: named.name(), values, text: None }).collect()
}

fn table(
    mut columns: Vec<Column>,
    clock: &Clock,
    joints: Vec<String>,
    told: Option<Told>,
    passed_over: Vec<String>,
) -> Table {
    columns.insert(0, Column { name: "time".to_owned(), values: clock.seconds(), text: None });
    let runs = std::iter::once(0..clock.received.len()).collect();
    let joints = (!joints.is_empty()).then_some(joints);
    Table { columns, runs, joints, clocks: told.into_iter().collect(), passed_over, ..Table::default() }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::progress::Monitor;
    use crate::recording::read::bytes::Bytes;
    use crate::recording::read::npz::Content;
    use crate::recording::read::{ReadOptions, decode};

    #[test]
    fn a_file_without_topics_says_that_none_was_read() {
        let options = ReadOptions::default().by("topic=/pos+/eff".parse().unwrap());
        let bytes = Bytes::InMemory(b"t,q1,tau1\n0,1,2\n1,2,3\n");
        let content = decode(&bytes, Path::new("log.csv"), &options, &Monitor::new()).unwrap();
        let Content::Table(table) = content else { panic!("a table") };
        assert!(table.passed_over[0].contains("/pos, /eff of the mapping"), "{:?}", table.passed_over);
    }
}
