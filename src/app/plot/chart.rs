//! The chart: lines and points over a shared, zoomable horizontal axis, with a cursor that all charts share.
//!
//! The wheel zooms about the pointer, Shift or the right button drags the view, a double click shows everything again.
//! A click or drag puts the cursor; with the keyboard the arrow keys move it, F shows everything. Alt and drag measure
//! between two cursors. Where a brush is asked for, a drag marks a region instead. The legend stands above the plot, never on
//! the data, and shows the values at the cursor, or mean and RMS between the two.

use egui::epaint::{Mesh, Shape, Vertex};
use egui::{
    Align2, Color32, CursorIcon, EventFilter, FontId, Key, Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui,
    WidgetInfo, pos2, vec2,
};

use super::decimate::Decimator;
use super::gestures::Region;
use super::linked::Window;
use super::ticks;
use crate::app::theme::{Dash, Palette, RADIUS, SMALL};
use crate::figure::mark::{self, Band, Course, Points, Shade, Shades};
use crate::figure::{Axis, Panel};

/// Room for the labels left of the plot \[points\]; the same in all charts, so that stacked charts are aligned.
const LEFT: f32 = 54.0;
/// Height of the title and legend above the plot \[points\].
const TOP: f32 = 20.0;
/// Height of tick labels below the plot \[points\].
const TICKS: f32 = 16.0;
/// Height of the axis label below the ticks \[points\].
const LABEL: f32 = 15.0;
/// Numbers of the vertical axis are at least so far from each other \[points\].
const LEAST_BETWEEN_TICKS: f32 = 13.0;
/// The part of the whole that stays in view at the deepest zoom.
const DEEPEST_ZOOM: f64 = 1e-5;

/// Values over a rectangle, drawn in colours.
pub struct Cells {
    /// How many columns and rows.
    pub size: [usize; 2],
    /// The ends of the horizontal and of the vertical axis.
    pub extent: Region,
    /// Row by row from below; NaN where there is nothing.
    pub values: Vec<f64>,
    /// Whether 0 is in the middle of the colours; else it is at their beginning.
    pub signed: bool,
}

/// A line over ascending x.
struct Line<'a> {
    name: &'a str,
    x: &'a [f64],
    y: &'a [f64],
    color: Color32,
    dash: Dash,
    width: f32,
    gaps: bool,
}

/// Points in no order.
struct Cloud<'a> {
    points: &'a [[f64; 2]],
    color: Color32,
    radius: f32,
}

/// A chart, drawn by [`Chart::show`].
#[must_use]
pub struct Chart<'a> {
    title: String,
    unit: &'a str,
    x_label: &'a str,
    x_unit: &'a str,
    height: f32,
    extent: [f64; 2],
    lines: Vec<Line<'a>>,
    clouds: Vec<Cloud<'a>>,
    paths: Vec<(&'a [[f64; 2]], Color32)>,
    shades: Vec<[f64; 2]>,
    lit: Vec<[f64; 2]>,
    bands: Vec<(&'a [[f64; 3]], Color32)>,
    ticks_shown: bool,
    logarithmic: bool,
    cursor: Option<&'a mut Option<f64>>,
    brush: Option<&'a mut Option<Region>>,
    cells: Option<&'a Cells>,
}

impl<'a> Chart<'a> {
    /// A chart over `extent` of the horizontal axis.
    pub fn new(title: impl Into<String>, unit: &'a str, extent: [f64; 2]) -> Self {
        let extent = if extent[1] > extent[0] { extent } else { [extent[0] - 0.5, extent[0] + 0.5] };
        Chart {
            title: title.into(),
            unit,
            x_label: "",
            x_unit: "",
            height: 140.0,
            extent,
            lines: Vec::new(),
            clouds: Vec::new(),
            paths: Vec::new(),
            shades: Vec::new(),
            lit: Vec::new(),
            bands: Vec::new(),
            ticks_shown: true,
            logarithmic: false,
            cursor: None,
            brush: None,
            cells: None,
        }
    }

    /// Label of the horizontal axis; without it only numbers stand there.
    pub fn x_axis(mut self, label: &'a str, unit: &'a str) -> Self {
        (self.x_label, self.x_unit) = (label, unit);
        self
    }

    /// Draws no numbers under the plot, because the chart below it does.
    pub fn without_ticks(mut self) -> Self {
        self.ticks_shown = false;
        self
    }

    /// Says that all values are decimal logarithms, of which axis and legend show the numbers.
    pub fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// Height of the whole widget \[points\].
    pub fn height(mut self, height: f32) -> Self {
        self.height = height;
        self
    }

    /// Adds a line.
    pub fn line(mut self, name: &'a str, x: &'a [f64], y: &'a [f64], (color, dash): (Color32, Dash)) -> Self {
        self.lines.push(Line { name, x, y, color, dash, width: 1.4, gaps: true });
        self
    }

    /// Adds a line that is seen under another one.
    pub fn under_line(mut self, name: &'a str, x: &'a [f64], y: &'a [f64], (color, dash): (Color32, Dash)) -> Self {
        self.lines.push(Line { name, x, y, color, dash, width: 1.9, gaps: true });
        self
    }

    /// Adds a thick line.
    pub fn strong_line(mut self, name: &'a str, x: &'a [f64], y: &'a [f64], (color, dash): (Color32, Dash)) -> Self {
        self.lines.push(Line { name, x, y, color, dash, width: 2.6, gaps: true });
        self
    }

    /// Adds a thick line whose points may lie at any distance from each other.
    pub fn curve(mut self, name: &'a str, x: &'a [f64], y: &'a [f64], (color, dash): (Color32, Dash)) -> Self {
        self.lines.push(Line { name, x, y, color, dash, width: 2.6, gaps: false });
        self
    }

    /// Adds points.
    pub fn points(mut self, points: &'a [[f64; 2]], color: Color32, radius: f32) -> Self {
        self.clouds.push(Cloud { points, color, radius });
        self
    }

    /// Adds points that are joined in their order.
    pub fn path(mut self, points: &'a [[f64; 2]], color: Color32) -> Self {
        self.paths.push((points, color));
        self
    }

    /// Marks stretches of the horizontal axis as lit by a brush.
    pub fn lit(mut self, stretches: Vec<[f64; 2]>) -> Self {
        self.lit = stretches;
        self
    }

    /// Adds a band: x, lower, upper.
    pub fn band(mut self, band: &'a [[f64; 3]], color: Color32) -> Self {
        self.bands.push((band, color));
        self
    }

    /// Marks stretches of the horizontal axis as held out.
    pub fn shaded(mut self, stretches: impl IntoIterator<Item = [f64; 2]>) -> Self {
        self.shades.extend(stretches);
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

    /// Draws values as colours, over the whole of both axes.
    pub fn cells(mut self, cells: &'a Cells) -> Self {
        self.extent = cells.extent[0];
        self.cells = Some(cells);
        self
    }

    /// Draws the chart over the full width.
    pub fn show(mut self, ui: &mut Ui, window: &mut Window, decimator: &mut Decimator) -> Response {
        let palette = Palette::in_ui(ui);
        let (outer, response) =
            ui.allocate_exact_size(vec2(ui.available_width(), self.height), Sense::click_and_drag());
        let spoken = format!("plot of {}", with_unit(&self.title, self.unit));
        response.widget_info(|| WidgetInfo::labeled(egui::Role::GraphicsObject, true, &spoken));
        let bottom = if self.ticks_shown { TICKS } else { 4.0 } + if self.x_label.is_empty() { 0.0 } else { LABEL };
        let plot = Rect::from_min_max(outer.min + vec2(LEFT, TOP), outer.max - vec2(8.0, bottom));
        super::export::offer(ui, &response, || self.panel(palette, window));
        if !ui.is_rect_visible(outer) || plot.width() < 10.0 || plot.height() < 10.0 {
            return response;
        }
        self.navigate(ui, &response, plot, window);
        let x_range = window.range.unwrap_or(self.extent);
        let columns = plot.width() as usize;
        let pieces: Vec<_> =
            self.lines.iter().map(|line| decimator.pieces(line.x, line.y, x_range, columns, line.gaps)).collect();
        let y_range = self.y_range(&pieces, x_range);
        let place = Place { plot, x_range, y_range };

        let painter = ui.painter();
        painter.rect_filled(plot, 0, palette.canvas);
        let lit = palette.accent.gamma_multiply(0.45);
        let marked = self.shades.iter().map(|stretch| (stretch, palette.held_out, 0.0));
        for ([from, to], color, least) in marked.chain(self.lit.iter().map(|stretch| (stretch, lit, 1.0))) {
            let (from, to) = (place.x(*from).max(plot.left()), place.x(*to).min(plot.right()));
            if from < to {
                let stretch = Rect::from_x_y_ranges(from..=to.max(from + least), plot.y_range());
                painter.rect_filled(stretch, 0, color);
            }
        }
        self.draw_grid(ui, &place, outer);
        let clipped = painter.with_clip_rect(plot);
        if let Some(cells) = self.cells {
            clipped.add(cells_shape(cells, &place, palette));
        }
        for (band, color) in &self.bands {
            clipped.add(band_shape(band, &place, *color));
        }
        for (points, color) in &self.paths {
            let points: Vec<Pos2> = points.iter().map(|point| place.point(*point)).collect();
            clipped.add(Shape::line(points, Stroke::new(1.4, *color)));
        }
        for cloud in &self.clouds {
            clipped.add(cloud_shape(cloud, &place));
        }
        for (line, pieces) in self.lines.iter().zip(&pieces) {
            for piece in pieces.iter() {
                let points: Vec<Pos2> = piece.iter().map(|point| place.point(*point)).collect();
                match points.as_slice() {
                    [only] => drop(clipped.circle_filled(*only, line.width, line.color)),
                    _ => add_line(&clipped, points, line),
                }
            }
        }
        let at = self.cursor.as_deref().copied().flatten();
        if let Some(at) = at.filter(|at| (x_range[0]..=x_range[1]).contains(at)) {
            clipped.vline(place.x(at), plot.y_range(), Stroke::new(1.0, palette.cursor));
            for line in &self.lines {
                if let Some(value) = value_at(line, at) {
                    clipped.circle(place.point([at, value]), 3.0, line.color, Stroke::new(1.0, palette.canvas));
                }
            }
        }
        if let Some([from, to]) = window.measured {
            let stretch = Rect::from_x_y_ranges(place.x(from)..=place.x(to), plot.y_range());
            clipped.rect_filled(stretch, 0, palette.cursor.gamma_multiply(0.10));
            for at in [from, to] {
                let line = [pos2(place.x(at), plot.top()), pos2(place.x(at), plot.bottom())];
                clipped.extend(Shape::dashed_line(&line, Stroke::new(1.2, palette.cursor), 5.0, 3.0));
            }
        }
        if let Some(brush) = self.brush.as_deref_mut() {
            mark(ui, &response, &place, brush);
            if let Some([[left, right], [low, high]]) = *brush {
                let corners = [place.point([left, high]), place.point([right, low])];
                let region = Rect::from_two_pos(corners[0], corners[1]);
                clipped.rect_filled(region, 0, palette.accent.gamma_multiply(0.12));
                clipped.rect_stroke(region, 0, Stroke::new(1.2, palette.accent), StrokeKind::Inside);
            }
        }
        painter.rect_stroke(plot, 0, Stroke::new(1.0, palette.border), StrokeKind::Outside);
        if response.has_focus() {
            painter.rect_stroke(plot.expand(2.0), RADIUS, Stroke::new(1.5, palette.accent), StrokeKind::Outside);
        }
        self.draw_header(
            ui,
            outer,
            plot,
            at,
            window.measured,
            response.hover_pos().filter(|_| self.cursor.is_none()).map(|at| place.value(at)),
        );
        let beside_cursor = response.hover_pos().filter(|at| self.cursor.is_some() && plot.contains(*at));
        if let Some(pointer) = beside_cursor.filter(|_| !response.dragged()) {
            self.draw_values(&clipped, palette, &place, pointer);
        }
        response
    }

    /// The values under the pointer, beside it.
    fn draw_values(&self, painter: &egui::Painter, palette: &Palette, place: &Place, pointer: Pos2) {
        let [x, _] = place.value(pointer);
        let of_line = |line: &Line| {
            let value = value_at(line, x)?;
            Some(format!("{} {} {}", line.name, self.number(value), self.unit).trim().to_owned())
        };
        let texts: Vec<String> = self.lines.iter().filter_map(of_line).collect();
        if texts.is_empty() {
            return;
        }
        let galley = painter.layout_no_wrap(texts.join("\n"), FontId::proportional(SMALL), palette.text);
        let size = galley.size() + vec2(10.0, 6.0);
        // At the other side of the pointer where there is no room.
        let right = pointer.x + 12.0 + size.x < place.plot.right();
        let left = if right { pointer.x + 12.0 } else { pointer.x - 12.0 - size.x };
        let top =
            (pointer.y - 0.5 * size.y).clamp(place.plot.top(), (place.plot.bottom() - size.y).max(place.plot.top()));
        let around = Rect::from_min_size(pos2(left, top), size);
        painter.rect(around, 4, palette.card, Stroke::new(1.0, palette.border), StrokeKind::Inside);
        painter.galley(around.min + vec2(5.0, 3.0), galley, palette.text);
    }

    /// The same as data: all samples of what is shown.
    fn panel(&self, palette: &Palette, window: &Window) -> Panel {
        let value = |y: f64| if self.logarithmic { 10f64.powf(y) } else { y };
        let mut x = Axis::new(self.x_label, self.x_unit).range(window.range.unwrap_or(self.extent));
        if x.label.is_empty() {
            x.unit.clear();
        }
        let mut y = Axis::new("", self.unit);
        if self.logarithmic {
            y = y.logarithmic();
        }
        let mut panel = Panel::new(self.title.clone(), [x, y]);
        panel = panel.with_all(self.shades.iter().map(|stretch| Shade(*stretch)));
        if let Some(cells) = self.cells {
            panel.y.range = Some(cells.extent[1]);
            let shades = if cells.signed { Shades::Signed } else { Shades::Amount };
            panel.push(mark::Cells {
                size: cells.size,
                extent: cells.extent,
                values: cells.values.clone().into(),
                shades,
            });
        }
        for (band, color) in &self.bands {
            let points: Vec<[f64; 3]> = band.iter().map(|[x, low, high]| [*x, value(*low), value(*high)]).collect();
            panel.push(Band::new("", points, palette.ink(*color)));
        }
        for Cloud { points, color, radius } in &self.clouds {
            let points: Vec<[f64; 2]> = points.iter().map(|[x, y]| [*x, value(*y)]).collect();
            let opacity = f64::from(color.a()) / 255.0;
            panel.push(Points::new("", points, palette.ink(*color)).radius(f64::from(*radius) / 2.2).opacity(opacity));
        }
        for (points, color) in &self.paths {
            let points = points.iter().map(|[x, y]| [*x, value(*y)]);
            panel.push(mark::Line::path("", points, palette.ink(*color)));
        }
        for line in &self.lines {
            let points = line.x.iter().zip(line.y).map(|(x, y)| [*x, value(*y)]);
            let course = if line.gaps { Course::Sampled } else { Course::Ascending };
            let own =
                mark::Line::through(line.name, points, palette.ink(line.color)).width(f64::from(line.width) / 1.4);
            panel.push(mark::Line { course, ..own });
        }
        panel
    }

    /// Wheel, drag, double click and keys.
    fn navigate(&mut self, ui: &Ui, response: &Response, plot: Rect, window: &mut Window) {
        let shown = window.range.unwrap_or(self.extent);
        let span = shown[1] - shown[0];
        let at = |x: f32| shown[0] + f64::from((x - plot.left()) / plot.width()) * span;
        if response.double_clicked() || (response.has_focus() && ui.input(|input| input.key_pressed(Key::F))) {
            *window = Window::default();
            return;
        }
        let measuring = self.cursor.is_some() && ui.input(|input| input.modifiers.alt);
        if measuring && (response.drag_started() || response.dragged()) {
            let begin = ui.input(|input| input.pointer.press_origin());
            if let (Some(begin), Some(end)) = (begin, response.interact_pointer_pos()) {
                let [from, to] = [begin.x.min(end.x), begin.x.max(end.x)];
                window.measured = Some([from, to].map(|x| at(x).clamp(self.extent[0], self.extent[1])));
            }
            return;
        }
        let panning = response.dragged_by(egui::PointerButton::Secondary)
            || response.dragged_by(egui::PointerButton::Middle)
            || (response.dragged() && ui.input(|input| input.modifiers.shift));
        if panning {
            let shift = -f64::from(response.drag_delta().x / plot.width()) * span;
            window.range = Some(self.kept_inside([shown[0] + shift, shown[1] + shift]));
        } else if let (Some(cursor), Some(pointer)) = (self.cursor.as_deref_mut(), response.interact_pointer_pos()) {
            *cursor = Some(at(pointer.x).clamp(self.extent[0], self.extent[1]));
        }
        if let Some(pointer) = response.hover_pos().filter(|pointer| plot.contains(*pointer)) {
            if self.cursor.is_some() {
                ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
            }
            let (zoom, wheel) = ui.input(|input| (input.zoom_delta(), input.smooth_scroll_delta()));
            // Only with Ctrl or a pinch, so that the page still scrolls under the wheel.
            let factor = f64::from(1.0 / zoom);
            if factor != 1.0 {
                let pivot = at(pointer.x);
                let range = [pivot + (shown[0] - pivot) * factor, pivot + (shown[1] - pivot) * factor];
                window.range = Some(self.kept_inside(range));
            } else if wheel.x != 0.0 {
                let shift = -f64::from(wheel.x / plot.width()) * span;
                window.range = Some(self.kept_inside([shown[0] + shift, shown[1] + shift]));
            }
        }
        if response.has_focus()
            && let Some(cursor) = self.cursor.as_deref_mut()
        {
            // The arrows are ours while the chart has the focus; else they would move the focus.
            let arrows = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
            let pressed = |key| ui.input(|input| input.num_presses(key)) as f64;
            let steps = pressed(Key::ArrowRight) - pressed(Key::ArrowLeft);
            if steps != 0.0 {
                let from = cursor.unwrap_or(shown[0]);
                *cursor = Some((from + steps * span / 200.0).clamp(self.extent[0], self.extent[1]));
            }
        }
    }

    fn kept_inside(&self, range: [f64; 2]) -> [f64; 2] {
        let whole = self.extent[1] - self.extent[0];
        let span = (range[1] - range[0]).clamp(whole * DEEPEST_ZOOM, whole);
        let from = range[0].clamp(self.extent[0], self.extent[1] - span);
        [from, from + span]
    }

    /// The smallest range that holds everything in view, with a margin.
    fn y_range(&self, pieces: &[super::decimate::Pieces], x_range: [f64; 2]) -> [f64; 2] {
        if let Some(cells) = self.cells {
            return cells.extent[1];
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut take = |value: f64| {
            if value.is_finite() {
                (low, high) = (low.min(value), high.max(value));
            }
        };
        pieces.iter().flat_map(|pieces| pieces.iter().flatten()).for_each(|point| take(point[1]));
        let bands = self.bands.iter().flat_map(|(band, _)| band.iter());
        bands
            .filter(|[x, ..]| (x_range[0]..=x_range[1]).contains(x))
            .flat_map(|[_, low, high]| [*low, *high])
            .for_each(&mut take);
        let clouds = self.clouds.iter().flat_map(|cloud| cloud.points);
        let clouds = clouds.chain(self.paths.iter().flat_map(|(points, _)| points.iter()));
        clouds.filter(|point| (x_range[0]..=x_range[1]).contains(&point[0])).for_each(|point| take(point[1]));
        if low > high {
            return [-1.0, 1.0];
        }
        let margin = if high > low { 0.08 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        [low - margin, high + margin]
    }

    fn draw_grid(&self, ui: &Ui, place: &Place, outer: Rect) {
        let palette = Palette::in_ui(ui);
        let painter = ui.painter();
        let font = FontId::proportional(SMALL - 0.5);
        let plot = place.plot;
        let line = Stroke::new(1.0, palette.grid);
        let count = (plot.height() / 15.0).clamp(3.0, 8.0) as usize;
        let y_ticks = if self.logarithmic {
            ticks::logarithmic(place.y_range, count)
        } else {
            let ticks = readable_ticks(place.y_range, count, plot.height());
            ticks.iter().copied().zip(ticks::labels(&ticks)).collect()
        };
        for (tick, text) in y_ticks {
            let y = place.y(tick).round() + 0.5;
            painter.hline(
                plot.x_range(),
                y,
                if tick == 0.0 && !self.logarithmic { Stroke::new(1.0, palette.border) } else { line },
            );
            painter.text(pos2(plot.left() - 5.0, y), Align2::RIGHT_CENTER, text, font.clone(), palette.weak);
        }
        let x_ticks = ticks::linear(place.x_range, (plot.width() / 80.0).clamp(2.0, 12.0) as usize);
        for (tick, text) in x_ticks.iter().zip(ticks::labels(&x_ticks)) {
            let x = place.x(*tick).round() + 0.5;
            painter.vline(x, plot.y_range(), line);
            if self.ticks_shown {
                painter.text(pos2(x, plot.bottom() + 3.0), Align2::CENTER_TOP, text, font.clone(), palette.weak);
            }
        }
        if !self.x_label.is_empty() {
            let text = with_unit(self.x_label, self.x_unit);
            let at = pos2(plot.center().x, outer.bottom() - 1.0);
            painter.text(at, Align2::CENTER_BOTTOM, text, FontId::proportional(SMALL), palette.weak);
        }
    }

    fn number(&self, value: f64) -> String {
        ticks::number(if self.logarithmic { 10f64.powf(value) } else { value })
    }

    /// Title on the left; legend with values at the cursor on the right.
    fn draw_header(
        &self,
        ui: &Ui,
        outer: Rect,
        plot: Rect,
        cursor: Option<f64>,
        measured: Option<[f64; 2]>,
        hovered: Option<[f64; 2]>,
    ) {
        let palette = Palette::in_ui(ui);
        let painter = ui.painter().with_clip_rect(outer);
        let y = outer.top() + TOP / 2.0 - 1.0;
        let mut title = with_unit(&self.title, self.unit);
        if let Some([from, to]) = measured {
            title = format!("{title}   Δ {} {}", ticks::number(to - from), self.x_unit);
        }
        let title = painter.text(
            pos2(plot.left(), y),
            Align2::LEFT_CENTER,
            title,
            FontId::proportional(SMALL + 0.5),
            palette.text,
        );
        let font = FontId::proportional(SMALL);
        let mut right = plot.right();
        if let Some([x, value]) = hovered {
            let text = format!("{} {}, {} {}", ticks::number(x), self.x_unit, self.number(value), self.unit);
            painter.text(pos2(right, y), Align2::RIGHT_CENTER, text, font, palette.weak);
            return;
        }
        for line in self.lines.iter().rev().filter(|line| !line.name.is_empty()) {
            let value = cursor.and_then(|at| value_at(line, at));
            let between = measured.and_then(|stretch| mean_and_rms(line, stretch));
            let text = match value {
                _ if let Some([mean, rms]) = between => {
                    format!("{} mean {}, RMS {}", line.name, self.number(mean), self.number(rms))
                }
                Some(value) => format!("{} {}", line.name, self.number(value)),
                None => line.name.to_owned(),
            };
            let galley = painter.layout_no_wrap(text, font.clone(), palette.weak);
            let left = right - galley.size().x - 26.0;
            if left < title.right() + 8.0 {
                break;
            }
            let size = galley.size();
            painter.galley(pos2(right - size.x, y - size.y / 2.0), galley, palette.weak);
            add_line(&painter, vec![pos2(left, y), pos2(left + 20.0, y)], line);
            right = left - 12.0;
        }
    }
}

/// Numbers of a vertical axis: more than one, since one alone is no scale, and none on another.
fn readable_ticks(range: [f64; 2], count: usize, height: f32) -> Vec<f64> {
    let few = ticks::linear(range, count);
    if few.len() > 1 {
        return few;
    }
    let many = ticks::linear(range, 2 * count);
    let [first, second, ..] = many.as_slice() else { return few };
    let step = second - first;
    let every = (f64::from(LEAST_BETWEEN_TICKS / height) * (range[1] - range[0]) / step).ceil().max(1.0);
    let kept: Vec<f64> = many.iter().copied().filter(|tick| ((tick / step).round() % every) == 0.0).collect();
    if kept.len() > 1 { kept } else { vec![many[0], many[many.len() - 1]] }
}

/// `torque [N m]`.
fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// From values to the screen.
struct Place {
    plot: Rect,
    x_range: [f64; 2],
    y_range: [f64; 2],
}

impl Place {
    fn x(&self, x: f64) -> f32 {
        self.plot.left() + ((x - self.x_range[0]) / (self.x_range[1] - self.x_range[0])) as f32 * self.plot.width()
    }

    fn y(&self, y: f64) -> f32 {
        self.plot.bottom() - ((y - self.y_range[0]) / (self.y_range[1] - self.y_range[0])) as f32 * self.plot.height()
    }

    fn point(&self, [x, y]: [f64; 2]) -> Pos2 {
        pos2(self.x(x), self.y(y))
    }

    fn value(&self, at: Pos2) -> [f64; 2] {
        let share = |value: f32, from: f32, size: f32| f64::from((value - from) / size);
        let [x, y] =
            [share(at.x, self.plot.left(), self.plot.width()), share(at.y, self.plot.bottom(), -self.plot.height())];
        [
            self.x_range[0] + x * (self.x_range[1] - self.x_range[0]),
            self.y_range[0] + y * (self.y_range[1] - self.y_range[0]),
        ]
    }
}

/// A drag marks a region of at least some points, a click removes it.
fn mark(ui: &Ui, response: &Response, place: &Place, brush: &mut Option<Region>) {
    let modified = ui.input(|input| input.modifiers.shift);
    if response.clicked() {
        *brush = None;
    } else if response.dragged_by(egui::PointerButton::Primary) && !modified {
        let begin = ui.input(|input| input.pointer.press_origin());
        if let (Some(begin), Some(end)) = (begin, response.interact_pointer_pos())
            && (end - begin).length() > 4.0
        {
            let inside = |at: Pos2| place.value(place.plot.clamp(at));
            let (one, other) = (inside(begin), inside(end));
            *brush = Some([0, 1].map(|axis| [one[axis].min(other[axis]), one[axis].max(other[axis])]));
        }
    }
}

/// Mean and root mean square of what a line shows of a stretch; `None` if that is nothing.
fn mean_and_rms(line: &Line, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let len = line.x.len().min(line.y.len());
    let samples = line.x[..len].partition_point(|x| *x < from)..line.x[..len].partition_point(|x| *x <= to);
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for value in line.y[samples].iter().filter(|value| value.is_finite()) {
        (count, sum, squares) = (count + 1.0, sum + value, squares + value * value);
    }
    (count > 0.0).then(|| [sum / count, (squares / count).sqrt()])
}

pub use crate::figure::mark::nearest;

fn value_at(line: &Line, at: f64) -> Option<f64> {
    line.y.get(nearest(line.x, at)).copied().filter(|value| value.is_finite())
}

fn add_line(painter: &egui::Painter, points: Vec<Pos2>, line: &Line) {
    let stroke = Stroke::new(line.width, line.color);
    // Where a line goes up and down in every pixel column, a dash can't be seen, but costs thousands of pieces.
    let width = points.last().map_or(0.0, |last| last.x - points[0].x);
    if line.dash.is_empty() || points.len() as f32 > 1.5 * width.max(40.0) {
        painter.add(Shape::line(points, stroke));
    } else {
        let (ink, gaps): (Vec<f32>, Vec<f32>) = line.dash.chunks(2).map(|pair| (pair[0], pair[pair.len() - 1])).unzip();
        painter.extend(Shape::dashed_line_with_offset(&points, stroke, &ink, &gaps, 0.0));
    }
}

/// All points in one mesh of squares: thousands of circles would be slow.
fn cloud_shape(cloud: &Cloud, place: &Place) -> Shape {
    let mut mesh = Mesh::default();
    mesh.reserve_vertices(4 * cloud.points.len());
    mesh.reserve_triangles(2 * cloud.points.len());
    let inside = place.plot.expand(cloud.radius);
    for point in cloud.points {
        let at = place.point(*point);
        if inside.contains(at) {
            mesh.add_colored_rect(Rect::from_center_size(at, egui::Vec2::splat(2.0 * cloud.radius)), cloud.color);
        }
    }
    Shape::mesh(mesh)
}

/// All cells in one mesh.
fn cells_shape(cells: &Cells, place: &Place, palette: &Palette) -> Shape {
    let [columns, rows] = cells.size;
    let most =
        cells.values.iter().filter(|value| value.is_finite()).fold(0.0, |most: f64, value| most.max(value.abs()));
    let [[left, right], [low, high]] = cells.extent;
    let corner = |column: usize, row: usize| {
        let share = |index: usize, count: usize| index as f64 / count as f64;
        place.point([left + (right - left) * share(column, columns), low + (high - low) * share(row, rows)])
    };
    let mut mesh = Mesh::default();
    for (index, value) in cells.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let share = (value / most.max(1e-300)) as f32;
        let share = f64::from(share);
        let colours = palette.colours();
        let own = if cells.signed { colours.signed(share) } else { colours.amount(share) };
        let color = super::screen::color(own, 1.0);
        let (column, row) = (index % columns, index / columns);
        mesh.add_colored_rect(Rect::from_two_pos(corner(column, row), corner(column + 1, row + 1)), color);
    }
    Shape::mesh(mesh)
}

fn band_shape(band: &[[f64; 3]], place: &Place, color: Color32) -> Shape {
    let mut mesh = Mesh::default();
    for [x, low, high] in band {
        for y in [low, high] {
            mesh.vertices.push(Vertex { pos: place.point([*x, *y]), uv: egui::epaint::WHITE_UV, color });
        }
    }
    for column in 1..band.len() as u32 {
        let first = 2 * (column - 1);
        mesh.indices.extend([first, first + 1, first + 2, first + 1, first + 2, first + 3]);
    }
    Shape::mesh(mesh)
}
