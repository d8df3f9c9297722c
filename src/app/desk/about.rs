//! What is known of a screen without drawing it.

/// What a screen can't be without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// It always has something to show.
    Nothing,
    /// Something that was measured.
    Recording,
    /// A model that was fitted.
    Model,
}

/// A screen's names and place. Two screens are the same if their ids are.
#[derive(Debug)]
pub struct About {
    /// Its name on the command line.
    pub id: &'static str,
    /// Its name in the window.
    pub title: &'static str,
    /// What it is for.
    pub purpose: &'static str,
    /// What it can't be without.
    pub needs: Needs,
    /// Whether the way to a repaired model leads through it; else it stands beside the way.
    pub on_the_way: bool,
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for About {}
