//! A panel of a figure in the window, with everything that one can do with it.
//!
//! Ctrl and the wheel zoom about the pointer, with Shift the heights, Ctrl and a drag zoom to a box, Shift or the right button drags
//! the view, a right click or L asks for its limits as numbers, a double click shows everything again. A click or drag puts the cursor; with the keyboard the arrow keys move it, F shows everything.
//! M (or Alt) and drag measure between two cursors. Where a brush is asked for, a drag marks a region instead. The legend stands above
//! the plot, never on the data, and shows the values at the cursor, or mean and RMS between the two.

use std::cell::RefCell;
use std::mem;
use std::rc::Rc;

use egui::epaint::Shape;
use egui::{FontId, Id, Rect, Response, Role, Sense, Stroke, StrokeKind, Ui, UiBuilder, WidgetInfo, pos2, vec2};

use super::adapter::{self, Printed, Setting, Sight};
use super::gestures::{self, Gestures, Region};
use super::header::{self, Header, with_value};
use super::linked::{Views, Window};
use super::menu;
use super::screen::{Screen, area, position, value};
use crate::app::theme::{Palette, RADIUS, SMALL};
use crate::figure::colours::Colours;
use crate::figure::decimate::Decimator;
use crate::figure::mark::Edges;
use crate::figure::{Panel, Place, Scale, ticks};

/// Room for the numbers left of the plot \[points\]; the same in all charts, so that stacked charts are aligned.
const LEFT: f32 = 54.0;
/// Room for the name of the vertical axis, where it has one \[points\].
const NAME: f32 = 16.0;
/// Height of the title and of the first row of the legend above the plot \[points\].
pub(super) const TOP: f32 = 20.0;
/// Height of the numbers below the plot \[points\].
const TICKS: f32 = 16.0;
/// Height of the axis label below the numbers \[points\].
const LABEL: f32 = 15.0;
/// Room right of the plot \[points\].
const RIGHT: f32 = 8.0;
/// Least height of a plot under a legend of several rows \[points\].
const LEAST_PLOT: f32 = 60.0;
/// Room below a plot without numbers \[points\].
const BELOW: f32 = 4.0;

/// What plots are drawn with.
pub struct Tools {
    pub palette: &'static Palette,
    pub colours: Colours,
    pub decimator: Rc<RefCell<Decimator>>,
}

/// A panel in the window, drawn by [`PanelView::show`].
#[must_use]
pub struct PanelView<'a> {
    pub(super) panel: Panel,
    height: f32,
    /// Height of the title and legend.
    top: f32,
    ticks_shown: bool,
    spoken: Option<String>,
    lit: Vec<[f64; 2]>,
    cursor: Option<&'a mut Option<f64>>,
    brush: Option<&'a mut Option<Region>>,
}

/// A panel that was drawn.
pub struct Shown {
    /// How it was used.
    pub response: Response,
    /// What was seen.
    pub panel: Panel,
    /// Where the plot stands.
    pub plot: Rect,
    /// The shown ranges, in the axes' own measure.
    pub ranges: [[f64; 2]; 2],
}

impl Shown {
    /// From values to the window.
    pub fn place(&self) -> Place<'_> {
        Place { plot: area(self.plot), ranges: self.ranges, axes: [&self.panel.x, &self.panel.y] }
    }
}

impl<'a> PanelView<'a> {
    /// A panel of usual height.
    pub fn new(panel: Panel) -> Self {
        let (lit, cursor, brush, spoken) = (Vec::new(), None, None, None);
        PanelView { panel, height: 140.0, top: TOP, ticks_shown: true, spoken, lit, cursor, brush }
    }

    /// Height of the whole widget \[points\].
    pub fn height(mut self, height: f32) -> Self {
        self.height = height;
        self
    }

    /// Draws no numbers under the plot, because the chart below it does.
    pub fn without_ticks(mut self) -> Self {
        self.ticks_shown = false;
        self
    }

    /// Draws it without numbers, grid and frame, and a unit as long in both directions.
    pub fn drawing(mut self) -> Self {
        self.panel.bare = true;
        self
    }

    /// What is spoken of it in place of "plot of" and its title.
    pub fn spoken(mut self, text: impl Into<String>) -> Self {
        self.spoken = Some(text.into());
        self
    }

    /// Marks stretches of the horizontal axis as lit by a brush.
    pub fn lit(mut self, stretches: Vec<[f64; 2]>) -> Self {
        self.lit = stretches;
        self
    }

    /// Shows and moves this cursor.
    pub fn cursor(mut self, cursor: &'a mut Option<f64>) -> Self {
        self.cursor = Some(cursor);
        self
    }

    /// A drag marks a region, a click removes it.
    pub fn brush(mut self, region: &'a mut Option<Region>) -> Self {
        self.brush = Some(region);
        self
    }

    /// Draws it over the full width.
    pub fn show(mut self, ui: &mut Ui, views: &mut Views, decimator: &mut Decimator) -> Shown {
        let palette = Palette::in_ui(ui);
        self.panel = views.own.onto(self.panel);
        let (window, own) = views.of_panel(&self.panel);
        let [left, below] = self.margins().map(|margin| margin.unwrap_or(0.0));
        if !self.panel.bare {
            let more = header::more_rows(ui, &self.panel, window, ui.available_width() - RIGHT - left);
            self.top = TOP + more;
            // A long legend takes of the plot, but not most of it.
            if more > 0.0 {
                self.height = self.height.max(self.top + below + LEAST_PLOT);
            }
        }
        let (outer, _) = ui.allocate_exact_size(vec2(ui.available_width(), self.height), Sense::hover());
        let room = self.room(outer);
        let id = Id::unique(("plot", ui.scope_id(), &self.panel.title));
        let tools =
            Tools { palette, colours: palette.colours(), decimator: Rc::new(RefCell::new(mem::take(decimator))) };
        let mut inside = ui.new_child(UiBuilder::new().id_salt(&self.panel.title).max_rect(room));
        let shown = if ui.is_rect_visible(outer) {
            self.print(&mut inside, &tools, window, room, id)
        } else {
            self.unseen(&mut inside, room)
        };
        let spoken = self.spoken.take().unwrap_or_else(|| format!("plot of {}", self.panel.heading()));
        let role = if self.panel.bare { Role::Image } else { Role::GraphicsObject };
        shown.response.widget_info(|| WidgetInfo::labeled(role, true, &spoken));
        let cursor = self.cursor.as_deref().copied();
        menu::show(ui, &shown, window, own, cursor);
        if ui.is_rect_visible(outer) {
            self.overlay(ui, &tools, window, &shown);
            if !self.panel.bare {
                self.head(ui, &tools, window, outer, &shown);
            }
        }
        *decimator = tools.decimator.take();
        shown
    }

    /// Where the plot stands with the numbers along its axes.
    fn room(&self, outer: Rect) -> Rect {
        if self.panel.bare {
            return outer;
        }
        let below = if self.ticks_shown { 0.0 } else { BELOW };
        Rect::from_min_max(outer.min + vec2(0.0, self.top), outer.max - vec2(RIGHT, below))
    }

    /// Room for the numbers left of the plot and below it.
    fn margins(&self) -> [Option<f32>; 2] {
        if self.panel.bare {
            return [None; 2];
        }
        let name = if self.panel.y.label.is_empty() { 0.0 } else { NAME };
        let lines = if matches!(self.panel.x.scale, Scale::Names(_)) { 2.0 } else { 1.0 };
        let label = if self.panel.x.label.is_empty() { 0.0 } else { LABEL };
        [Some(LEFT + name), self.ticks_shown.then_some(lines * TICKS + label)]
    }

    fn sense(&self) -> Sense {
        if self.panel.bare { Sense::click() } else { Sense::click_and_drag() }
    }

    /// What is out of sight can be asked for by name, and takes the focus, all the same.
    fn unseen(&self, ui: &mut Ui, room: Rect) -> Shown {
        // The same steps as of the plot, so that it has the same identity.
        ui.allocate_space(room.size());
        let response = ui.allocate_rect(room, self.sense());
        Shown { response, panel: self.panel.clone(), plot: room, ranges: [[0.0, 1.0]; 2] }
    }

    fn print(&mut self, ui: &mut Ui, tools: &Tools, window: &mut Window, room: Rect, id: Id) -> Shown {
        let behind = ui.painter().add(Shape::Noop);
        let margins = self.margins();
        let plot = Rect::from_min_max(
            room.min + vec2(margins[0].unwrap_or(0.0), 0.0),
            room.max - vec2(0.0, margins[1].unwrap_or(0.0)),
        );
        let zooms_to_box = zooms_to_box(ui, id);
        let setting = Setting {
            id: self.panel.title.clone(),
            link: Id::unique(("pointer", self.panel.x.link.as_ref().unwrap_or(&self.panel.title))),
            room,
            sense: self.sense(),
            margins,
            axes: [self.panel.x.clone(), self.panel.y.clone()],
            has_grid: !self.panel.bare && !self.panel.marks.iter().any(|mark| mark.edges() == Edges::Filled),
            zooms_to_box,
            colours: tools.colours,
            pointer: tools.palette.weak.gamma_multiply(0.5),
            decimator: &tools.decimator,
        };
        let (panel, cursor) = (&self.panel, &mut self.cursor);
        let mut seen = (panel.clone(), [[0.0, 1.0]; 2]);
        let (told, view, context) = (&mut seen, &mut *window, ui.ctx().clone());
        let Printed { response, plot, zoomed } = adapter::print(ui, setting, |response: &Response| {
            let columns = plot.width() as usize;
            let mut decimator = tools.decimator.borrow_mut();
            let extent = whole(panel, columns, &mut decimator);
            if !panel.bare {
                let ranges = ranges(&view.of(panel), plot, columns, &mut decimator);
                let place = Place { plot: area(plot), ranges, axes: [&panel.x, &panel.y] };
                let cursor = cursor.as_deref_mut();
                Gestures { title: &panel.title, extent, window: view, cursor, zooms_to_box }
                    .take(&context, response, &place);
            }
            let now = view.of(panel);
            let ranges = ranges(&now, plot, columns, &mut decimator);
            let marks = now.marks.clone();
            *told = (now, ranges);
            Sight { ranges, marks }
        });
        let (mut panel, ranges) = seen;
        if let Some([x, y]) = zoomed {
            let extent = whole(&self.panel, plot.width() as usize, &mut tools.decimator.borrow_mut());
            let place = Place { plot: area(plot), ranges, axes: [&self.panel.x, &self.panel.y] };
            Gestures { title: &self.panel.title, extent, window, cursor: None, zooms_to_box }.show(x, &place);
            window.heights.insert(self.panel.title.clone(), y);
            panel = window.of(&self.panel);
            context.request_repaint();
        }
        let shown = Shown { response, panel, plot, ranges };
        let ground = self.ground(ui, tools, &shown);
        ui.painter().set(behind, Shape::Vec(ground));
        shown
    }

    /// What lies behind the grid.
    fn ground(&self, ui: &Ui, tools: &Tools, shown: &Shown) -> Vec<Shape> {
        let mut shapes = Vec::new();
        if !self.panel.bare {
            shapes.push(Shape::rect_filled(shown.plot, 0, tools.palette.canvas));
        }
        let place = shown.place();
        let mut screen = Screen::new(ui, &tools.colours, &tools.decimator, &mut shapes);
        for mark in shown.panel.marks.iter().filter(|mark| mark.is_behind()) {
            mark.draw(&place, &mut screen);
        }
        let plot = shown.plot;
        for stretch in &self.lit {
            let [from, to] = stretch.map(|x| place.at(0, x) as f32);
            let (from, to) = (from.max(plot.left()), to.min(plot.right()));
            if from < to {
                let rect = Rect::from_x_y_ranges(from..=to.max(from + 1.0), plot.y_range());
                screen.shapes.push(Shape::rect_filled(rect, 0, tools.palette.accent.gamma_multiply(0.45)));
            }
        }
        drop(screen);
        shapes
    }

    /// Cursor, measurement, brush, focus, and the values under the pointer.
    fn overlay(&mut self, ui: &Ui, tools: &Tools, window: &Window, shown: &Shown) {
        let (palette, plot, place) = (tools.palette, shown.plot, shown.place());
        let (painter, response) = (ui.painter(), &shown.response);
        let clipped = painter.with_clip_rect(plot.intersect(ui.clip_rect()));
        if let Some(at) = self.cursor_in_sight(shown) {
            clipped.vline(place.at(0, at) as f32, plot.y_range(), Stroke::new(1.0, palette.cursor));
            for mark in &shown.panel.marks {
                let (Some(value), Some(entry)) = (mark.value_at(at), mark.entry()) else { continue };
                let color = palette.color(entry.key.ink());
                clipped.circle(position(place.point([at, value])), 3.0, color, Stroke::new(1.0, palette.canvas));
            }
        }
        if let Some(ends) = window.measured.map(|ends| ends.map(|x| place.at(0, x) as f32)) {
            let stretch = Rect::from_x_y_ranges(ends[0]..=ends[1], plot.y_range());
            clipped.rect_filled(stretch, 0, palette.cursor.gamma_multiply(0.10));
            for x in ends {
                let line = [pos2(x, plot.top()), pos2(x, plot.bottom())];
                clipped.extend(Shape::dashed_line(&line, Stroke::new(1.2, palette.cursor), 5.0, 3.0));
            }
        }
        if let Some(brush) = self.brush.as_deref_mut() {
            gestures::brush(ui, response, &place, brush);
            if let Some([[left, right], [low, high]]) = *brush {
                let corners = [[left, high], [right, low]].map(|corner| position(place.point(corner)));
                let region = Rect::from_two_pos(corners[0], corners[1]);
                clipped.rect_filled(region, 0, palette.accent.gamma_multiply(0.12));
                clipped.rect_stroke(region, 0, Stroke::new(1.2, palette.accent), StrokeKind::Inside);
            }
        }
        if !self.panel.bare {
            painter.rect_stroke(plot, 0, Stroke::new(1.0, palette.border), StrokeKind::Outside);
        }
        if response.has_focus() {
            let ring = if self.panel.bare { plot } else { plot.expand(2.0) };
            painter.rect_stroke(ring, RADIUS, Stroke::new(1.5, palette.accent), StrokeKind::Outside);
        }
        let pointer = response.hover_pos().filter(|at| !self.panel.bare && plot.contains(*at));
        if let Some(pointer) = pointer.filter(|_| !response.dragged()) {
            let at = value(&place, pointer);
            let texts =
                if self.cursor.is_some() { values_at(&shown.panel, at[0]) } else { values_in(&shown.panel, at) };
            values_beside(&clipped, palette, plot, pointer, &texts);
        }
    }

    fn cursor_in_sight(&self, shown: &Shown) -> Option<f64> {
        let at = self.cursor.as_deref().copied().flatten()?;
        let [from, to] = shown.ranges[0];
        (from..=to).contains(&shown.panel.x.measure(at)).then_some(at)
    }

    fn head(&self, ui: &mut Ui, tools: &Tools, window: &mut Window, outer: Rect, shown: &Shown) {
        let room = Rect::from_min_size(outer.min, vec2(outer.width(), self.top));
        let cursor = self.cursor.as_deref().copied().flatten();
        Header { room, plot: shown.plot, cursor, of: self }.show(ui, tools, window);
    }
}

/// Whether the drag at work draws a box; it does so to its end if it began with Ctrl.
fn zooms_to_box(ui: &Ui, id: Id) -> bool {
    let (command, down) = ui.input(|input| (input.modifiers.command, input.pointer.primary_down()));
    let released = ui.input(|input| input.pointer.primary_released());
    let before = ui.data(|data| data.get_temp(id)).unwrap_or(false);
    let now =
        if down || released { before || (command && ui.input(|input| input.pointer.primary_pressed())) } else { false };
    ui.data_mut(|data| data.insert_temp(id, now));
    now
}

/// The whole horizontal axis, in its own measure.
fn whole(panel: &Panel, columns: usize, decimator: &mut Decimator) -> [f64; 2] {
    panel.ranges(columns, decimator)[0]
}

/// What a panel shows in this room; a unit is as long in both directions where the panel has a shape of its own.
fn ranges(panel: &Panel, plot: Rect, columns: usize, decimator: &mut Decimator) -> [[f64; 2]; 2] {
    let mut ranges = panel.ranges(columns, decimator);
    let Some(aspect) = panel.aspect.filter(|_| panel.bare) else { return ranges };
    let stretch = f64::from(plot.height() / plot.width()) / aspect;
    let which = usize::from(stretch > 1.0);
    let [from, to] = ranges[which];
    let more = 0.5 * (to - from) * (stretch.max(1.0 / stretch) - 1.0);
    ranges[which] = [from - more, to + more];
    ranges
}

/// Where it is, and the values of all lines there; empty if none has one.
pub(super) fn values_at(panel: &Panel, x: f64) -> Vec<String> {
    let text = |mark: &std::sync::Arc<dyn crate::figure::mark::Mark>| {
        let value = with_value(&panel.y, mark.value_at(x)?);
        Some(format!("{} {value}", mark.name()).trim().to_owned())
    };
    let values: Vec<String> = panel.marks.iter().filter_map(text).collect();
    let place = (!values.is_empty()).then(|| with_value(&panel.x, x));
    place.into_iter().chain(values).collect()
}

/// The place, what is shown right there, and the values of all lines at its x.
pub(super) fn values_in(panel: &Panel, [x, y]: [f64; 2]) -> Vec<String> {
    let place = [with_value(&panel.x, x), with_value(&panel.y, y)];
    let place = place.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join(", ");
    let inside = panel.marks.iter().find_map(|mark| mark.value_in([x, y]));
    let inside = inside.map(|(inside, unit)| format!("{} {unit}", ticks::number(inside)).trim().to_owned());
    let lines = values_at(panel, x).into_iter().skip(1);
    std::iter::once(place).chain(inside).chain(lines).collect()
}

/// The values under the pointer, beside it.
fn values_beside(painter: &egui::Painter, palette: &Palette, plot: Rect, pointer: egui::Pos2, texts: &[String]) {
    if texts.is_empty() {
        return;
    }
    let galley = painter.layout_no_wrap(texts.join("\n"), FontId::proportional(SMALL), palette.text);
    let size = galley.size() + vec2(10.0, 6.0);
    // At the other side of the pointer where there is no room.
    let right = pointer.x + 12.0 + size.x < plot.right();
    let left = if right { pointer.x + 12.0 } else { pointer.x - 12.0 - size.x };
    let top = (pointer.y - 0.5 * size.y).clamp(plot.top(), (plot.bottom() - size.y).max(plot.top()));
    let around = Rect::from_min_size(pos2(left, top), size);
    painter.rect(around, 4, palette.card, Stroke::new(1.0, palette.border), StrokeKind::Inside);
    painter.galley(around.min + vec2(5.0, 3.0), galley, palette.text);
}
