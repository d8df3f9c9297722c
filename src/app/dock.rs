//! The panels of a screen: by their tabs they can be dragged beside, above or into each other, by the gaps between them
//! resized, and where they are is kept.

use egui::{
    Color32, EventFilter, Id, Key, Modifiers, Rect, Response, ScrollArea, Stroke, StrokeKind, Style, Ui, UiBuilder,
    Visuals, WidgetText, vec2,
};
use egui_tiles::{Behavior, Linear, LinearDir, SimplificationOptions, TabState, TileId, Tiles, Tree, UiResponse};

use super::desk::{Change, Desk, Order, Side};
use super::theme::{GAP, RADIUS};
use super::widgets::{self, is_narrow};

/// Draws a panel of a screen.
type Draw<S> = fn(&mut S, &mut Ui, &mut Desk);

/// How a screen is arranged until somebody rearranges it. The numbers are shares of the width or height.
pub enum Part<S: 'static> {
    /// A panel and its name, which is its tab.
    Panel(&'static str, Draw<S>),
    /// Behind each other, the first in front.
    Tabs(&'static [Part<S>]),
    /// From left to right.
    Beside(&'static [(f32, Part<S>)]),
    /// From top to bottom.
    Stack(&'static [(f32, Part<S>)]),
}

impl<S> Part<S> {
    fn panels(&self, into: &mut Vec<(&'static str, Draw<S>)>) {
        match self {
            Part::Panel(name, draw) => into.push((name, *draw)),
            Part::Tabs(parts) => parts.iter().for_each(|part| part.panels(into)),
            Part::Beside(parts) | Part::Stack(parts) => parts.iter().for_each(|(_, part)| part.panels(into)),
        }
    }

    fn insert(&self, tiles: &mut Tiles<String>) -> TileId {
        let mut line = |direction, parts: &[(f32, Part<S>)]| {
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

/// Draws the panels of a screen over all the room that is left. `name` tells its arrangement from those of others.
pub fn show<S>(screen: &mut S, ui: &mut Ui, desk: &mut Desk, name: &str, arrangement: &Part<S>) {
    let mut panels = Vec::new();
    arrangement.panels(&mut panels);
    // Without room for two beside each other they stand behind each other.
    let narrow = is_narrow(ui);
    let key = if narrow { format!("{name}, narrow") } else { name.to_owned() };
    let is_whole = |tree: &Tree<String>| {
        panels.iter().all(|(name, _)| tree.tiles.find_pane(&(*name).to_owned()).is_some()) && tree.root().is_some()
    };
    let kept = desk.panels.take(&key).filter(is_whole);
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
    let mut tabs = None;
    if all_hidden {
        let sentence = "They can be shown again here, or one by one in View.";
        if widgets::empty(ui, "All panels are hidden", sentence, "Show them") {
            let hidden: Vec<TileId> = tree.tiles.tile_ids().collect();
            hidden.into_iter().for_each(|id| tree.set_visible(id, true));
        }
    } else {
        let mut drawer = Drawer { panels: &panels, tabs: Vec::new(), screen, desk };
        tree.ui(&mut drawer, ui);
        tabs = Some(drawer.tabs);
    }
    desk.panels.drawn(key, tree, panels.iter().map(|(name, _)| *name).collect(), tabs);
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
struct Drawer<'a, 'b, S> {
    panels: &'a [(&'static str, Draw<S>)],
    tabs: Vec<Id>,
    screen: &'a mut S,
    desk: &'a mut Desk<'b>,
}

impl<S> Behavior<String> for Drawer<'_, '_, S> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, name: &mut String) -> UiResponse {
        if let Some((_, draw)) = self.panels.iter().find(|(other, _)| other == name) {
            let room = ui.available_rect_before_wrap();
            let inside = Rect::from_min_max(room.min + vec2(0.0, GAP), room.max);
            ui.scope_builder(UiBuilder::new().max_rect(inside), |ui| {
                ScrollArea::vertical()
                    .id_salt(&*name)
                    .auto_shrink(false)
                    .show(ui, |ui| draw(self.screen, ui, self.desk));
            });
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
