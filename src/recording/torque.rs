//! What the torque of a log is, as whoever recorded it states it: where it was taken, and what had been taken out of it before.
//!
//! Nothing of that can be seen in the numbers, yet it decides what they can show. Gravity that a controller has compensated is no
//! part of the model; friction that it has compensated, or that lies before the sensor, can't be missed in the torque, and that
//! none is found there says nothing of the joint.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

/// One thing that can be said of a torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TorqueFact {
    /// It is that behind the gear, as a sensor at the link sees it: drive and gear are before it.
    Link,
    /// It is that of the motor, before the gear.
    Motor,
    /// A sensor, or the motor's current, says what it was.
    Measured,
    /// It is what the drive was told to do.
    Commanded,
    /// The controller's gravity compensation is not in it.
    WithoutGravity,
    /// The controller's friction compensation is not in it.
    WithoutFriction,
}

impl TorqueFact {
    /// All of them.
    pub const ALL: [TorqueFact; 6] = [
        TorqueFact::Link,
        TorqueFact::Motor,
        TorqueFact::Measured,
        TorqueFact::Commanded,
        TorqueFact::WithoutGravity,
        TorqueFact::WithoutFriction,
    ];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            TorqueFact::Link => "link",
            TorqueFact::Motor => "motor",
            TorqueFact::Measured => "measured",
            TorqueFact::Commanded => "commanded",
            TorqueFact::WithoutGravity => "without-gravity",
            TorqueFact::WithoutFriction => "without-friction",
        }
    }

    /// What it says, as words that follow "the torque is".
    pub fn about(self) -> &'static str {
        match self {
            TorqueFact::Link => "that behind the gear, at the link",
            TorqueFact::Motor => "that of the motor, before the gear",
            TorqueFact::Measured => "measured",
            TorqueFact::Commanded => "commanded",
            TorqueFact::WithoutGravity => "without gravity, which the controller compensates",
            TorqueFact::WithoutFriction => "without friction, which the controller compensates",
        }
    }

    /// The fact that can't hold beside it.
    pub fn opposite(self) -> Option<TorqueFact> {
        match self {
            TorqueFact::Link => Some(TorqueFact::Motor),
            TorqueFact::Motor => Some(TorqueFact::Link),
            TorqueFact::Measured => Some(TorqueFact::Commanded),
            TorqueFact::Commanded => Some(TorqueFact::Measured),
            TorqueFact::WithoutGravity | TorqueFact::WithoutFriction => None,
        }
    }

    /// What the torque can't show because of it, as a clause without its full stop; `None` where it hides nothing.
    pub fn hides(self) -> Option<&'static str> {
        match self {
            TorqueFact::Link => Some(
                "what rubs and turns before the sensor (friction and rotor inertia of the drives), since the torque is that behind the \
                 gear: that none is found is no sign that none is there",
            ),
            TorqueFact::WithoutFriction => Some(
                "how much friction the joints have, since it was taken out of the torque before the log: that none is found is no sign \
                 that none is there, and what is found is what the compensation left",
            ),
            TorqueFact::WithoutGravity => Some(
                "what the links weigh, since gravity was taken out of the torque before the log: what its compensation did not know \
                 (a tool, a load) is left as torque over position",
            ),
            TorqueFact::Commanded => Some(
                "what the drive made of its command, since the torque is commanded: lag, gain and limits of the drive are in what is \
                 explained here",
            ),
            TorqueFact::Motor | TorqueFact::Measured => None,
        }
    }
}

/// All that is stated of a torque; empty where nothing is. In files a list of names.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "Vec<TorqueFact>", into = "Vec<TorqueFact>")]
pub struct TorqueFacts(BTreeSet<TorqueFact>);

/// Two facts that can't both hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a torque can't be both `{}` and `{}`; state one of them", .0.name(), .1.name())]
pub struct Contradiction(pub TorqueFact, pub TorqueFact);

impl TorqueFacts {
    /// These facts.
    ///
    /// # Errors
    /// [`Contradiction`] if two of them can't both hold.
    pub fn new(facts: impl IntoIterator<Item = TorqueFact>) -> Result<TorqueFacts, Contradiction> {
        let facts: BTreeSet<TorqueFact> = facts.into_iter().collect();
        let contradicted =
            facts.iter().find_map(|fact| Some((*fact, fact.opposite().filter(|it| facts.contains(it))?)));
        match contradicted {
            Some((one, other)) => Err(Contradiction(one, other)),
            None => Ok(TorqueFacts(facts)),
        }
    }

    /// Whether this is stated.
    pub fn has(&self, fact: TorqueFact) -> bool {
        self.0.contains(&fact)
    }

    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All that is stated.
    pub fn iter(&self) -> impl Iterator<Item = TorqueFact> + '_ {
        self.0.iter().copied()
    }

    /// States this, in place of its opposite.
    pub fn state(&mut self, fact: TorqueFact) {
        fact.opposite().iter().for_each(|opposite| self.retract(*opposite));
        self.0.insert(fact);
    }

    /// States this no more.
    pub fn retract(&mut self, fact: TorqueFact) {
        self.0.remove(&fact);
    }

    /// In words, beside its name.
    pub fn text(&self) -> String {
        if self.is_empty() {
            return "nothing is stated; it is taken for all that the joints feel".to_owned();
        }
        self.iter().map(TorqueFact::about).collect::<Vec<_>>().join("; ")
    }
}

impl TryFrom<Vec<TorqueFact>> for TorqueFacts {
    type Error = Contradiction;

    fn try_from(facts: Vec<TorqueFact>) -> Result<Self, Contradiction> {
        TorqueFacts::new(facts)
    }
}

impl From<TorqueFacts> for Vec<TorqueFact> {
    fn from(facts: TorqueFacts) -> Self {
        facts.iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_one_name_everywhere_and_contradictions_are_refused() {
        for fact in TorqueFact::ALL {
            assert_eq!(serde_json::to_value(fact).unwrap(), fact.name());
            assert_eq!(fact.opposite().and_then(TorqueFact::opposite), fact.opposite().map(|_| fact));
        }
        let both = serde_json::from_str::<TorqueFacts>(r#"["motor", "without-gravity", "link"]"#).unwrap_err();
        assert!(both.to_string().contains("both `link` and `motor`"), "{both}");
        let mut facts: TorqueFacts = serde_json::from_str(r#"["motor", "without-gravity"]"#).unwrap();
        facts.state(TorqueFact::Link);
        assert_eq!(serde_json::to_string(&facts).unwrap(), r#"["link","without-gravity"]"#);
    }

    #[test]
    fn facts_are_told_in_words() {
        assert!(TorqueFacts::default().text().starts_with("nothing is stated"));
        let facts: TorqueFacts = serde_json::from_str(r#"["motor", "without-gravity"]"#).unwrap();
        let words = facts.text();
        assert!(facts.iter().all(|fact| !fact.about().is_empty() && words.contains(fact.about())), "{words}");
        assert_eq!(words.matches("; ").count(), 1, "{words}");
    }

    /// Whoever states a fact of which something is hidden learns what; a motor's torque that was measured hides nothing.
    #[test]
    fn a_fact_says_what_it_hides() {
        let hides = |fact: TorqueFact| fact.hides().unwrap_or_default();
        assert!(hides(TorqueFact::Link).contains("friction and rotor inertia"));
        assert!(hides(TorqueFact::WithoutFriction).starts_with("how much friction"));
        assert!(hides(TorqueFact::WithoutGravity).starts_with("what the links weigh"));
        assert!(hides(TorqueFact::Commanded).starts_with("what the drive made of its command"));
        assert_eq!((TorqueFact::Motor.hides(), TorqueFact::Measured.hides()), (None, None));
    }
}
