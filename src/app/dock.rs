//! The panels of a screen: by their tabs they can be dragged beside, above or into each other, by the gaps between them
//! resized, and where they are is kept.

use std::collections::BTreeMap;

use egui::{
    Color32, EventFilter, Id, Key, Modifiers, Rect, Response, ScrollArea, Stroke, StrokeKind, Style, Ui, UiBuilder,
    Visuals, WidgetText, vec2,
};
use egui_tiles::{
    Behavior, Container, Linear, LinearDir, SimplificationOptions, TabState, Tile, TileId, Tiles, Tree, UiResponse,
};

use super::plot::export;
use super::shell::is_narrow;
use super::state::{Desk, Order};
use super::theme::{GAP, RADIUS};
use super::widgets;

/// Draws a panel.
type Draw = fn(&mut Ui, &mut Desk);

/// How a screen is arranged until somebody rearranges it. The numbers are shares of the width or height.
pub enum Part {
    /// A panel and its name, which is its tab.
    Panel(&'static str, Draw),
    /// Behind each other, the first in front.
    Tabs(&'static [Part]),
    /// From left to right.
    Beside(&'static [(f32, Part)]),
    /// From top to bottom.
    Stack(&'static [(f32, Part)]),
}

impl Part {
    fn panels(&self, into: &mut Vec<(&'static str, Draw)>) {
        match self {
            Part::Panel(name, draw) => into.push((name, *draw)),
            Part::Tabs(parts) => parts.iter().for_each(|part| part.panels(into)),
            Part::Beside(parts) | Part::Stack(parts) => parts.iter().for_each(|(_, part)| part.panels(into)),
        }
    }

    fn insert(&self, tiles: &mut Tiles<String>) -> TileId {
        let mut line = |direction, parts: &[(f32, Part)]| {
            let children: Vec<TileId> = parts.iter().map(|(_, part)| part.insert(tiles)).collect();
            let mut linear = Linear::new(direction, children.clone());
            for (child, (share, _)) in children.into_iter().zip(parts) {
                linear.shares.set_share(child, *share);
            }
            tiles.insert_container(linear)
        };
        match self {
            Part::Panel(name, _) => tiles.insert_pane((*name).to_owned()),
            Part::Beside(parts) => line(LinearDir::Horizontal, parts),
            Part::Stack(parts) => line(LinearDir::Vertical, parts),
            Part::Tabs(parts) => {
                let children = parts.iter().map(|part| part.insert(tiles)).collect();
                tiles.insert_tab_tile(children)
            }
        }
    }
}

/// Where the panels of every screen are.
#[derive(Debug, Default)]
pub struct Dock {
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
    Left,
    Right,
    Top,
    Bottom,
}

/// What can be done with a panel without a pointer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// Shows it, in front of the others of its tabs.
    Show,
    Hide,
    /// Moves it to a side of the screen.
    Move(Side),
    /// Moves it behind the same tabs as another panel.
    Join(String),
}

/// Arrangements by screen, as they are kept.
pub type Layouts = BTreeMap<String, Tree<String>>;

impl Dock {
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

/// Draws the panels of a screen over all the room that is left.
pub fn show(ui: &mut Ui, desk: &mut Desk, screen: &str, arrangement: &Part) {
    let mut panels = Vec::new();
    arrangement.panels(&mut panels);
    // Without room for two beside each other they stand behind each other.
    let narrow = is_narrow(ui);
    let key = if narrow { format!("{screen}, narrow") } else { screen.to_owned() };
    let is_whole = |tree: &Tree<String>| {
        panels.iter().all(|(name, _)| tree.tiles.find_pane(&(*name).to_owned()).is_some()) && tree.root().is_some()
    };
    let kept = desk.state.dock.trees.remove(&key).filter(is_whole);
    let mut tree = kept.unwrap_or_else(|| {
        let id = egui::Id::unique(&key);
        if narrow {
            return Tree::new_tabs(id, panels.iter().map(|(name, _)| (*name).to_owned()).collect());
        }
        let mut tiles = Tiles::default();
        let root = arrangement.insert(&mut tiles);
        Tree::new(id, root, tiles)
    });
    let all_hidden = tree.tiles.iter().all(|(id, tile)| tile.is_container() || !tree.is_visible(*id));
    if all_hidden {
        if widgets::empty(
            ui,
            "All panels are hidden",
            "They can be shown again here, or one by one in View.",
            "Show them",
        ) {
            let hidden: Vec<TileId> = tree.tiles.tile_ids().collect();
            hidden.into_iter().for_each(|id| tree.set_visible(id, true));
        }
    } else {
        let room = ui.available_rect_before_wrap();
        let mut drawer = Drawer { panels: &panels, drawn: Vec::new(), tabs: Vec::new(), desk };
        tree.ui(&mut drawer, ui);
        let Drawer { drawn, tabs, .. } = drawer;
        desk.state.dock.tabs = tabs;
        if export::is_collecting(ui.ctx()) {
            describe_hidden(ui, desk, &panels, &drawn, room);
        }
    }
    desk.state.dock.current.clone_from(&key);
    desk.state.dock.names = panels.iter().map(|(name, _)| *name).collect();
    desk.state.dock.trees.insert(key, tree);
}

/// What stands behind another tab is not seen, but its plots belong to the screen.
fn describe_hidden(ui: &mut Ui, desk: &mut Desk, panels: &[(&'static str, Draw)], drawn: &[String], room: Rect) {
    for (name, draw) in panels.iter().filter(|(name, _)| !drawn.iter().any(|other| other == name)) {
        let builder = UiBuilder::new().id_salt(name).max_rect(room).invisible();
        let mut hidden = ui.new_child(builder);
        draw(&mut hidden, desk);
    }
}

/// What the keys ask of the panel whose tab has the focus.
fn by_keys(tab: &Response) -> Option<Change> {
    // The arrows are the tab's while it has the focus; else they would move the focus.
    let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    tab.ctx.memory_mut(|memory| memory.set_focus_lock_filter(tab.id, arrows));
    let sides = [
        (Key::ArrowLeft, Side::Left),
        (Key::ArrowRight, Side::Right),
        (Key::ArrowUp, Side::Top),
        (Key::ArrowDown, Side::Bottom),
    ];
    tab.ctx.input_mut(|input| {
        let pressed = sides.into_iter().find(|(key, _)| input.consume_key(Modifiers::SHIFT, *key));
        let hidden = input.consume_key(Modifiers::NONE, Key::Delete).then_some(Change::Hide);
        pressed.map(|(_, side)| Change::Move(side)).or(hidden)
    })
}

/// Draws panels for the tree that places them.
struct Drawer<'a, 'b> {
    panels: &'a [(&'static str, Draw)],
    drawn: Vec<String>,
    tabs: Vec<Id>,
    desk: &'a mut Desk<'b>,
}

impl Behavior<String> for Drawer<'_, '_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, name: &mut String) -> UiResponse {
        if let Some((_, draw)) = self.panels.iter().find(|(other, _)| other == name) {
            let room = ui.available_rect_before_wrap();
            let inside = Rect::from_min_max(room.min + vec2(0.0, GAP), room.max);
            ui.scope_builder(UiBuilder::new().max_rect(inside), |ui| {
                ScrollArea::vertical().id_salt(&*name).auto_shrink(false).show(ui, |ui| draw(ui, self.desk));
            });
            self.drawn.push(name.clone());
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, name: &String) -> WidgetText {
        name.as_str().into()
    }

    fn retain_pane(&mut self, name: &String) -> bool {
        self.panels.iter().any(|(other, _)| other == name)
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn on_tab_button(&mut self, tiles: &mut Tiles<String>, id: TileId, tab: Response) -> Response {
        self.tabs.push(tab.id);
        if let Some(name) = tiles.get_pane(&id).filter(|_| tab.has_focus()) {
            if let Some(change) = by_keys(&tab) {
                self.desk.orders.push(Order::Panel(name.clone(), change));
            }
            let painter = tab.ctx.layer_painter(tab.layer_id);
            let stroke = tab.ctx.global_style().visuals.selection.stroke;
            painter.rect_stroke(tab.rect.shrink(1.0), RADIUS, stroke, StrokeKind::Inside);
        }
        let keys = "With the keyboard: F6 goes to the next tab, Shift and an arrow moves its panel, Delete hides it.";
        tab.on_hover_text(format!("Drag it to another place; View hides panels and puts them back. {keys}"))
    }

    fn gap_width(&self, _: &Style) -> f32 {
        GAP
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn tab_bar_color(&self, visuals: &Visuals) -> Color32 {
        visuals.panel_fill
    }

    fn tab_bg_color(&self, visuals: &Visuals, _: &Tiles<String>, _: TileId, state: &TabState) -> Color32 {
        if state.active { visuals.window_fill } else { visuals.panel_fill }
    }

    fn tab_outline_stroke(&self, visuals: &Visuals, _: &Tiles<String>, _: TileId, state: &TabState) -> Stroke {
        if state.active { visuals.window_stroke } else { Stroke::NONE }
    }

    fn tab_text_color(&self, visuals: &Visuals, _: &Tiles<String>, _: TileId, state: &TabState) -> Color32 {
        if state.active { visuals.text_color() } else { visuals.weak_text_color() }
    }
}
