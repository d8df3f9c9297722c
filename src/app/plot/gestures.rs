//! How a plot is used: wheel, drag, double click and keys.

use egui::{Context, CursorIcon, EventFilter, Key, PointerButton, Pos2, Response, Ui};

use super::linked::Window;
use crate::figure::Place;

/// A marked region: its smallest and largest x, and its lowest and highest y.
pub type Region = [[f64; 2]; 2];

/// The part of the whole that stays in view at the deepest zoom.
const DEEPEST_ZOOM: f64 = 1e-5;
/// A shorter drag marks nothing \[points\].
const SHORTEST_DRAG: f32 = 4.0;
/// Steps of the arrow keys over the whole view.
const STEPS: f64 = 200.0;

/// What gestures move.
pub struct Gestures<'a> {
    /// Of the plot.
    pub title: &'a str,
    /// The whole horizontal axis, in its own measure.
    pub extent: [f64; 2],
    /// The view.
    pub window: &'a mut Window,
    /// The cursor, if there is one.
    pub cursor: Option<&'a mut Option<f64>>,
    /// Whether a drag draws a box to zoom to.
    pub zooms_to_box: bool,
}

impl Gestures<'_> {
    /// Wheel, drag, double click and keys. `place` is what was seen last.
    pub fn take(&mut self, ctx: &Context, response: &Response, place: &Place) {
        let plot = place.plot;
        let shown = place.ranges[0];
        let span = shown[1] - shown[0];
        let at = |x: f32| shown[0] + (f64::from(x) - plot.left) / plot.width * span;
        if response.double_clicked() || (response.has_focus() && ctx.input(|input| input.key_pressed(Key::F))) {
            *self.window = Window::default();
            return;
        }
        if is_measuring(ctx) && (response.drag_started() || response.dragged()) {
            let begin = ctx.input(|input| input.pointer.press_origin());
            if let (Some(begin), Some(end)) = (begin, response.interact_pointer_pos()) {
                let [from, to] = [begin.x.min(end.x), begin.x.max(end.x)];
                self.window.measured = Some([from, to].map(|x| at(x).clamp(self.extent[0], self.extent[1])));
            }
            return;
        }
        let panning = response.dragged_by(PointerButton::Secondary)
            || response.dragged_by(PointerButton::Middle)
            || (response.dragged() && ctx.input(|input| input.modifiers.shift));
        if panning {
            let moved = response.drag_delta();
            let shift = -f64::from(moved.x) / plot.width * span;
            self.show([shown[0] + shift, shown[1] + shift], place);
            self.lift(f64::from(moved.y) / plot.height);
        } else if !(self.zooms_to_box || ctx.input(|input| input.modifiers.shift))
            && let (Some(cursor), Some(pointer)) = (&mut self.cursor, response.interact_pointer_pos())
        {
            **cursor = Some(at(pointer.x).clamp(self.extent[0], self.extent[1]));
        }
        let inside = |pointer: &Pos2| super::screen::is_inside(*pointer, &plot);
        if let Some(pointer) = response.hover_pos().filter(inside) {
            if self.cursor.is_some() {
                ctx.set_cursor_icon(CursorIcon::Crosshair);
            }
            let (zoom, wheel) = ctx.input(|input| (input.zoom_delta(), input.smooth_scroll_delta()));
            // Only with Ctrl or a pinch, so that the page still scrolls under the wheel.
            let factor = f64::from(1.0 / zoom);
            if factor != 1.0 && ctx.input(|input| input.modifiers.shift) {
                self.stretch(factor, pointer, place);
            } else if factor != 1.0 {
                let pivot = at(pointer.x);
                self.show([pivot + (shown[0] - pivot) * factor, pivot + (shown[1] - pivot) * factor], place);
            } else if wheel.x != 0.0 {
                let shift = -f64::from(wheel.x) / plot.width * span;
                self.show([shown[0] + shift, shown[1] + shift], place);
            }
        }
        if response.has_focus()
            && let Some(cursor) = &mut self.cursor
        {
            // The arrows are ours while the plot has the focus; else they would move the focus.
            let arrows = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
            ctx.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
            let pressed = |key| ctx.input(|input| input.num_presses(key)) as f64;
            let steps = pressed(Key::ArrowRight) - pressed(Key::ArrowLeft);
            if steps != 0.0 {
                let from = cursor.unwrap_or(shown[0]);
                **cursor = Some((from + steps * span / STEPS).clamp(self.extent[0], self.extent[1]));
            }
        }
    }

    /// Zooms the heights about the pointer, in and out of what is there.
    fn stretch(&mut self, factor: f64, pointer: Pos2, place: &Place) {
        let [low, high] = place.ranges[1];
        let share = (f64::from(pointer.y) - place.plot.top) / place.plot.height;
        let pivot = high - share * (high - low);
        let heights = [low, high].map(|end| pivot + (end - pivot) * factor);
        if heights[1] > heights[0] && heights.iter().all(|end| end.is_finite()) {
            self.window.heights.insert(self.title.to_owned(), heights);
        }
    }

    /// Moves the heights, once they were zoomed: up by this share of what is seen.
    fn lift(&mut self, share: f64) {
        if let Some([low, high]) = self.window.heights.get_mut(self.title) {
            let shift = share * (*high - *low);
            (*low, *high) = (*low + shift, *high + shift);
        }
    }

    /// Shows a part of the horizontal axis, inside the whole.
    pub fn show(&mut self, range: [f64; 2], place: &Place) {
        let whole = self.extent[1] - self.extent[0];
        let span = (range[1] - range[0]).clamp(whole * DEEPEST_ZOOM, whole);
        let from = range[0].clamp(self.extent[0], (self.extent[1] - span).max(self.extent[0]));
        self.window.range = Some([from, from + span].map(|end| place.axes[0].value(end)));
    }
}

/// Whether a drag measures. Window managers take Alt and a drag for themselves.
fn is_measuring(ctx: &Context) -> bool {
    let (alt, m) = ctx.input(|input| (input.modifiers.alt, input.key_down(Key::M)));
    alt || (m && !ctx.text_edit_focused())
}

/// A drag marks a region of at least some points, a click removes it.
pub fn brush(ui: &Ui, response: &Response, place: &Place, brush: &mut Option<Region>) {
    let modified = ui.input(|input| input.modifiers.shift || input.modifiers.command) || is_measuring(ui.ctx());
    if response.clicked() {
        *brush = None;
    } else if response.dragged_by(PointerButton::Primary) && !modified {
        let begin = ui.input(|input| input.pointer.press_origin());
        if let (Some(begin), Some(end)) = (begin, response.interact_pointer_pos())
            && (end - begin).length() > SHORTEST_DRAG
        {
            let (one, other) = (super::screen::value(place, begin), super::screen::value(place, end));
            *brush = Some([0, 1].map(|axis| [one[axis].min(other[axis]), one[axis].max(other[axis])]));
        }
    }
}
