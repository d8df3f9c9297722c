//! A question before something that can't be taken back.

use super::order::Order;
use crate::app::keeper::Copy;
use crate::session::Command;

/// A question before something that can't be taken back.
#[derive(Debug, Clone)]
pub struct Question {
    /// In a few words.
    pub title: String,
    /// What it means.
    pub text: String,
    /// What can be done, the safest last.
    pub choices: Vec<(String, Order)>,
    /// To do nothing.
    pub otherwise: String,
}

impl Question {
    /// Before a copy is thrown away that another window left.
    pub fn throw_away(copy: &Copy) -> Order {
        let Copy { note, path, .. } = copy;
        Order::Ask(Box::new(Question {
            title: format!("Throw {} away?", note.name),
            text: format!("What is in no file of {} is lost then.", copy.label()),
            choices: vec![("Throw it away".to_owned(), Order::ThrowAway(path.clone()))],
            otherwise: "Keep it".to_owned(),
        }))
    }

    /// Before the seal is opened.
    pub fn open_seal() -> Order {
        Order::Ask(Box::new(Question {
            title: "Open the seal?".to_owned(),
            text: "It shows what was hidden, and it stays open: undo does not shut it, and the saved session remembers it. Then \
                   nothing is left to find in this recording."
                .to_owned(),
            choices: vec![("Open it".to_owned(), Order::run(Command::OpenSeal))],
            otherwise: "Leave it shut".to_owned(),
        }))
    }
}
