//! Panels in the window through `egui_plot`, which nothing else knows: axes, grid, the zoom to a box, and the pointer's line in
//! all linked plots are its own; what a panel shows are its items, drawn by the marks themselves.

use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::rc::Rc;
use std::sync::Arc;

use egui::{Color32, FontId, Id, PointerButton, Rangef, Rect, Response, RichText, Sense, Shape, Ui};
use egui_plot::{
    AxisHints, GridInput, GridMark, Plot, PlotBounds, PlotGeometry, PlotItem, PlotItemBase, PlotTransform,
};

use super::screen::{Screen, area};
use crate::app::theme::SMALL;
use crate::figure::colours::Colours;
use crate::figure::decimate::Decimator;
use crate::figure::lines::in_lines;
use crate::figure::mark::Mark;
use crate::figure::{Axis, Place, Scale};

/// Numbers of a vertical axis are at least so far from each other \[points\].
const LEAST_BETWEEN_TICKS: f64 = 13.0;
/// Numbers of a horizontal axis have about so much room \[points\].
const ROOM_OF_TICK: f32 = 80.0;
/// Lines in which a long name stands below its place; what is too long ends in dots.
const LINES_OF_NAME: usize = 2;
/// Mean width of a letter, as a part of its height.
const LETTER_WIDTH: f32 = 0.56;

/// How a plot is set up, before it is known what is seen.
pub struct Setting<'a> {
    /// Its name among the plots of `ui`.
    pub id: String,
    /// Plots of the same link show the pointer's line of each other.
    pub link: Id,
    /// Where it stands, with the numbers along its axes.
    pub room: Rect,
    /// What the gestures of a plot take.
    pub sense: Sense,
    /// Width of the numbers at its left, and height of those below: `None` for none.
    pub margins: [Option<f32>; 2],
    /// The axes of the panel.
    pub axes: [Axis; 2],
    /// Whether lines stand behind the marks.
    pub has_grid: bool,
    /// Whether the primary button draws a box to zoom to.
    pub zooms_to_box: bool,
    /// Its colours.
    pub colours: Colours,
    /// The colour of the pointer's line.
    pub pointer: Color32,
    /// What thins its lines.
    pub decimator: &'a Rc<RefCell<Decimator>>,
}

/// What is seen of a plot.
pub struct Sight {
    /// The ranges of both axes in their own measure.
    pub ranges: [[f64; 2]; 2],
    /// What is drawn.
    pub marks: Vec<Arc<dyn Mark>>,
}

/// A plot that was drawn.
pub struct Printed {
    /// How it was used.
    pub response: Response,
    /// Where it stands.
    pub plot: Rect,
    /// The box to which it was zoomed, in the axes' own measure.
    pub zoomed: Option<[[f64; 2]; 2]>,
}

/// Draws a plot; `look` sees how it is used and says what is seen in this frame.
pub fn print<'a>(ui: &mut Ui, setting: Setting<'a>, look: impl FnOnce(&Response) -> Sight + 'a) -> Printed {
    let Setting {
        id,
        link,
        room,
        sense,
        margins: [left, below],
        axes,
        has_grid,
        zooms_to_box,
        colours,
        pointer,
        decimator,
    } = setting;
    let show_axes = [below.is_some(), left.is_some()];
    let [across, up] = &axes;
    let plot_size = [room.width() - left.unwrap_or(0.0), room.height() - below.unwrap_or(0.0)];
    let rulings = [Ruling::across(across.clone(), plot_size[0]), Ruling::up(up.clone(), plot_size[1])];
    let [x_hints, y_hints] = [
        hints(AxisHints::new_x(), &rulings[0], below.unwrap_or(0.0), &colours),
        hints(AxisHints::new_y(), &rulings[1], left.unwrap_or(0.0), &colours),
    ];
    let [x_ruling, y_ruling] = rulings;
    let grid = color_of(colours.grid);
    let plot = Plot::new(id)
        .width(room.width())
        .height(room.height())
        .sense(sense)
        .custom_x_axes(vec![x_hints])
        .custom_y_axes(vec![y_hints])
        .show_axes(show_axes)
        .show_background(false)
        .show_grid(has_grid)
        .x_grid_spacer(move |input| x_ruling.marks(&input))
        .y_grid_spacer(move |input| y_ruling.marks(&input))
        .grid_spacing(Rangef::new(0.5, 1.0))
        .grid_color(grid)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .allow_boxed_zoom(zooms_to_box)
        .boxed_zoom_pointer_button(PointerButton::Primary)
        .show_y(false)
        .show_x(sense.senses_drag())
        .cursor_color(pointer)
        .link_cursor(link, [true, false]);
    let shared = Rc::new(Common { axes, colours, decimator: Rc::clone(decimator) });
    let shown = plot.show(ui, move |plot| {
        let Sight { ranges: [x, y], marks } = look(plot.response());
        plot.set_plot_bounds_x(x[0]..=x[1]);
        plot.set_plot_bounds_y(y[0]..=y[1]);
        for mark in marks.into_iter().filter(|mark| !mark.is_behind()) {
            plot.add(Item { base: PlotItemBase::new(String::new()), mark, shared: Rc::clone(&shared) });
        }
        [x, y]
    });
    let bounds = shown.transform.bounds();
    let now = [[bounds.min()[0], bounds.max()[0]], [bounds.min()[1], bounds.max()[1]]];
    Printed { response: shown.response, plot: *shown.transform.frame(), zoomed: (now != shown.inner).then_some(now) }
}

fn color_of([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

fn hints(hints: AxisHints<'static>, ruling: &Ruling, thickness: f32, colours: &Colours) -> AxisHints<'static> {
    let own = ruling.clone();
    let label = RichText::new(own.axis.title()).size(SMALL).color(color_of(colours.weak));
    let label = if own.axis.label.is_empty() { RichText::new("") } else { label };
    hints
        .label(label)
        .min_thickness(thickness)
        .label_spacing(Rangef::new(0.5, 1.0))
        .tick_label_font(FontId::proportional(SMALL - 0.5))
        .tick_label_color(color_of(colours.weak))
        .formatter(move |mark, range| own.text(mark.value, range))
}

/// The numbers along an axis of some length.
#[derive(Clone)]
struct Ruling {
    axis: Axis,
    count: usize,
    length: f64,
    upright: bool,
}

impl Ruling {
    fn across(axis: Axis, length: f32) -> Self {
        let count = (length / ROOM_OF_TICK).clamp(2.0, 12.0) as usize;
        Ruling { axis, count, length: f64::from(length), upright: false }
    }

    fn up(axis: Axis, length: f32) -> Self {
        let count = (length / 15.0).clamp(3.0, 8.0) as usize;
        Ruling { axis, count, length: f64::from(length), upright: true }
    }

    /// Where they stand, and what they say.
    fn ticks(&self, range: [f64; 2]) -> Vec<(f64, String)> {
        let few = self.axis.ticks(range, self.count);
        // One number alone is no scale: rather more of them, but none on another.
        if !self.upright || few.len() > 1 || self.axis.scale != Scale::Linear {
            return few;
        }
        let many = self.axis.ticks(range, 2 * self.count);
        let [(first, _), (second, _), ..] = many.as_slice() else { return few };
        let step = second - first;
        let every = (LEAST_BETWEEN_TICKS / self.length * (range[1] - range[0]) / step).ceil().max(1.0);
        let kept = |(at, _): &&(f64, String)| (at / step).round() % every == 0.0;
        let kept: Vec<(f64, String)> = many.iter().filter(kept).cloned().collect();
        if kept.len() > 1 { kept } else { vec![many[0].clone(), many[many.len() - 1].clone()] }
    }

    fn marks(&self, input: &GridInput) -> Vec<GridMark> {
        let ticks = self.ticks([input.bounds.0, input.bounds.1]);
        let step = ticks.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(f64::INFINITY, f64::min);
        let step_size = if step.is_finite() { step } else { input.bounds.1 - input.bounds.0 };
        ticks.into_iter().map(|(value, _)| GridMark { value, step_size }).collect()
    }

    fn text(&self, value: f64, range: &RangeInclusive<f64>) -> String {
        let range = [*range.start(), *range.end()];
        let text = self.ticks(range).into_iter().find(|(at, _)| *at == value).map(|(_, text)| text).unwrap_or_default();
        match self.axis.scale {
            Scale::Names(_) if !self.upright => {
                let letters = self.length / (range[1] - range[0]) / f64::from(LETTER_WIDTH * SMALL);
                in_lines(&text, letters.floor().max(4.0), LINES_OF_NAME, |text| text.chars().count() as f64).join("\n")
            }
            _ => text,
        }
    }
}

/// What the items of a plot share.
struct Common {
    axes: [Axis; 2],
    colours: Colours,
    decimator: Rc<RefCell<Decimator>>,
}

/// A mark as an item of `egui_plot`.
struct Item {
    base: PlotItemBase,
    mark: Arc<dyn Mark>,
    shared: Rc<Common>,
}

impl PlotItem for Item {
    fn shapes(&self, ui: &Ui, transform: &PlotTransform, shapes: &mut Vec<Shape>) {
        let Common { axes, colours, decimator } = &*self.shared;
        let bounds = transform.bounds();
        let ranges = [0, 1].map(|which| [bounds.min()[which], bounds.max()[which]]);
        let place = Place { plot: area(*transform.frame()), ranges, axes: [&axes[0], &axes[1]] };
        self.mark.draw(&place, &mut Screen::new(ui, colours, decimator, shapes));
    }

    fn initialize(&mut self, _: RangeInclusive<f64>) {}

    fn color(&self) -> Color32 {
        Color32::TRANSPARENT
    }

    fn geometry(&self) -> PlotGeometry<'_> {
        PlotGeometry::None
    }

    /// What is seen is set by the view, not by what there is.
    fn bounds(&self) -> PlotBounds {
        PlotBounds::NOTHING
    }

    fn base(&self) -> &PlotItemBase {
        &self.base
    }

    fn base_mut(&mut self) -> &mut PlotItemBase {
        &mut self.base
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One number alone is no scale.
    #[test]
    fn a_low_plot_has_more_than_one_number() {
        for range in [[-0.9, 1.7], [0.31, 0.69], [-1e-3, 2e-3]] {
            let ticks = Ruling::up(Axis::new("", "N m"), 46.0).ticks(range);
            assert!(ticks.len() > 1, "{range:?}: {ticks:?}");
        }
        let names = Axis::names("", vec!["one".to_owned(), "two".to_owned()]);
        let ruling = Ruling::across(names, 300.0);
        let texts: Vec<String> = [0.0, 1.0, 0.5].map(|at| ruling.text(at, &(-0.5..=1.5))).into();
        assert_eq!(texts, ["one", "two", ""], "between names stands nothing");
    }
}
