//! On which side of the gears the encoders are, as whoever recorded a log states it.
//!
//! It can't be seen in the numbers, yet it decides which formula of a soft or loose gear holds: an encoder on the link sees the
//! twist, one on the motor does not, and all joints carry an arm that is a bit elsewhere.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A side of a gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// After the gear.
    Link,
    /// Before the gear, told in coordinates of the joint.
    Motor,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Side {
    /// Both of them.
    pub const ALL: [Side; 2] = [Side::Link, Side::Motor];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Side::Link => "link",
            Side::Motor => "motor",
        }
    }

    /// Where encoders of this side are, as words that follow "the encoders are".
    pub fn about(self) -> &'static str {
        match self {
            Side::Link => "on the links, behind the gears",
            Side::Motor => "on the motors, before the gears",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_named_as_it_is_written() {
        for side in Side::ALL {
            assert_eq!(serde_json::to_value(side).unwrap(), side.name());
            assert_eq!(side.to_string(), side.name());
        }
        assert!(Side::Link.about().starts_with("on the links") && Side::Motor.about().starts_with("on the motors"));
    }
}
