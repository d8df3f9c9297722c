//! The file of an effect that the program itself writes: a formula that was adopted.

use std::fmt::Write;

/// An effect of one joint, to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// Its id.
    pub id: String,
    /// Name for people.
    pub name: String,
    /// What it is, a sentence or two.
    pub description: String,
    /// Where it comes from.
    pub source: String,
    /// Its linear parameters.
    pub columns: Vec<DraftColumn>,
}

/// A linear parameter of it.
#[derive(Debug, Clone, PartialEq)]
pub struct DraftColumn {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The torque that a value of 1 makes.
    pub formula: String,
}

impl Draft {
    /// The file, to be read by [`super::load`].
    pub fn to_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let mut text = String::from("# An effect of one's own: see \"Effects of your own\" in MANUAL.md.\n");
        let fields =
            [("id", &self.id), ("name", &self.name), ("description", &self.description), ("source", &self.source)];
        for (key, value) in fields {
            // Writing into a text never fails.
            let _ = writeln!(text, "{key} = {}", quoted(value));
        }
        text.push_str("scope = \"joint\"\n");
        for DraftColumn { name, unit, formula } in &self.columns {
            let [name, unit, formula] = [name, unit, formula].map(|value| quoted(value));
            let _ = write!(text, "\n[[linear]]\nname = {name}\nunit = {unit}\ncolumn = {formula}\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_can_be_read() {
        let draft = Draft {
            id: "own-draft".into(),
            name: "a \"draft\"".into(),
            description: "Two lines\nof text.".into(),
            source: "C:\\logs\\arm.npz".into(),
            columns: vec![DraftColumn {
                name: "c".into(),
                unit: "N m s²/rad²".into(),
                formula: "sin(q1) * qd^2".into(),
            }],
        };
        let effect = super::super::load(&draft.to_toml()).unwrap();
        assert_eq!((effect.name, effect.source), (draft.name.as_str(), draft.source.as_str()));
        assert_eq!((effect.description, effect.formula), ("Two lines\nof text.", "tau = c * sin(q1) * qd^2"));
    }
}
