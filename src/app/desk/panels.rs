//! Where the panels of every screen are, and what can be done with them without a pointer.

use std::collections::BTreeMap;

use egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tile, Tree};

/// Where the panels of every screen are.
#[derive(Debug, Default)]
pub struct Panels {
    trees: BTreeMap<String, Tree<String>>,
    /// The arrangement that was drawn last.
    current: String,
    /// Its panels.
    names: Vec<&'static str>,
    /// The tabs that were drawn last, and by which id they take the focus.
    tabs: Vec<Id>,
}

/// A side of the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The left side.
    Left,
    /// The right side.
    Right,
    /// Above all others.
    Top,
    /// Below all others.
    Bottom,
}

/// What can be done with a panel without a pointer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// Shows it, in front of the others of its tabs.
    Show,
    /// Hides it.
    Hide,
    /// Moves it to a side of the screen.
    Move(Side),
    /// Moves it behind the same tabs as another panel.
    Join(String),
}

/// Arrangements by screen, as they are kept.
pub type Layouts = BTreeMap<String, Tree<String>>;

impl Panels {
    /// As they are kept.
    pub fn layouts(&self) -> Layouts {
        self.trees.clone()
    }

    /// As somebody left them.
    pub fn restore(&mut self, layouts: Layouts) {
        self.trees = layouts;
    }

    /// The panels of the shown screen stand again where they stood at first.
    pub fn reset(&mut self) {
        self.trees.remove(&self.current);
    }

    /// The arrangement of this name, to be drawn; [`Panels::drawn`] gives it back.
    pub fn take(&mut self, name: &str) -> Option<Tree<String>> {
        self.trees.remove(name)
    }

    /// The arrangement that is shown now: its tree, its panels, and its tabs unless none were drawn.
    pub fn drawn(&mut self, name: String, tree: Tree<String>, panels: Vec<&'static str>, tabs: Option<Vec<Id>>) {
        self.current.clone_from(&name);
        self.names = panels;
        self.tabs = tabs.unwrap_or_else(|| std::mem::take(&mut self.tabs));
        self.trees.insert(name, tree);
    }

    /// The names of the panels of the shown screen, and whether they are shown.
    pub fn panels(&self) -> Vec<(&'static str, bool)> {
        let Some(tree) = self.trees.get(&self.current) else { return Vec::new() };
        let is_shown = |name: &str| tree.tiles.find_pane(&name.to_owned()).is_some_and(|id| tree.is_visible(id));
        self.names.iter().map(|name| (*name, is_shown(name))).collect()
    }

    /// Changes where a panel of the shown screen is.
    pub fn change(&mut self, name: &str, change: &Change) {
        match change {
            Change::Show => self.set_shown(name, true),
            Change::Hide => self.set_shown(name, false),
            Change::Move(side) => self.move_to(name, *side),
            Change::Join(other) => self.join(name, other),
        }
    }

    fn move_to(&mut self, name: &str, side: Side) {
        let Some(tree) = self.trees.get_mut(&self.current) else { return };
        let (Some(id), Some(root)) = (tree.tiles.find_pane(&name.to_owned()), tree.root()) else { return };
        let direction = match side {
            Side::Left | Side::Right => LinearDir::Horizontal,
            Side::Top | Side::Bottom => LinearDir::Vertical,
        };
        let fits =
            |tile: &Tile<String>| matches!(tile, Tile::Container(Container::Linear(line)) if line.dir == direction);
        let line = match tree.tiles.get(root).is_some_and(fits) {
            true => root,
            false => {
                let around = tree.tiles.insert_container(Linear::new(direction, vec![root]));
                tree.root = Some(around);
                around
            }
        };
        let place = if matches!(side, Side::Left | Side::Top) { 0 } else { usize::MAX };
        tree.move_tile_to_container(id, line, place, true);
        self.set_shown(name, true);
    }

    fn join(&mut self, name: &str, other: &str) {
        let Some(tree) = self.trees.get_mut(&self.current) else { return };
        let (id, other) = (tree.tiles.find_pane(&name.to_owned()), tree.tiles.find_pane(&other.to_owned()));
        if let (Some(id), Some(tabs)) = (id, other.and_then(|other| tree.tiles.parent_of(other))) {
            tree.move_tile_to_container(id, tabs, usize::MAX, true);
            self.set_shown(name, true);
        }
    }

    /// Whether two panels stand behind the same tabs.
    pub fn is_beside(&self, name: &str, other: &str) -> bool {
        let Some(tree) = self.trees.get(&self.current) else { return false };
        let [one, other] = [name, other].map(|name| tree.tiles.parent_of(tree.tiles.find_pane(&name.to_owned())?));
        one.is_some() && one == other
    }

    /// The focus goes to the tab of the next panel.
    pub fn focus_next(&self, ctx: &egui::Context) {
        let focused = ctx.memory(|memory| memory.focused());
        let place = self.tabs.iter().position(|tab| Some(*tab) == focused);
        let next = place.map_or(0, |place| (place + 1) % self.tabs.len());
        if let Some(tab) = self.tabs.get(next) {
            ctx.memory_mut(|memory| memory.request_focus(*tab));
        }
    }

    /// Shows or hides a panel of the shown screen.
    pub fn set_shown(&mut self, name: &str, shown: bool) {
        let Some(tree) = self.trees.get_mut(&self.current) else { return };
        if let Some(id) = tree.tiles.find_pane(&name.to_owned()) {
            tree.set_visible(id, shown);
            if shown {
                tree.make_active(|other, _| other == id);
            }
        }
    }
}
