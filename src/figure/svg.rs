//! A figure as SVG: the one place where it is laid out. Lengths are points of 1/72 inch.

use std::fmt::Write as _;

use base64::Engine as _;

use super::colours::{Colours, Dash, Rgb};
use super::font::{DEJAVU_SANS, Ruler};
use super::{Axis, Course, Figure, Ink, Mark, Panel, Scale, Size, Style, decimate, ticks};

/// Pixel columns of a point at which lines are thinned: finer than any printer shows.
const COLUMNS_PER_POINT: f64 = 16.0;
/// Height of a slide \[points\].
const SLIDE_HEIGHT: f64 = 405.0;
/// Panels below each other on a slide, before a second column is begun.
const MOST_ROWS_OF_SLIDE: usize = 3;
/// Room that is left of the range on either side.
const MARGIN: f64 = 0.06;

/// How the letters come into the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Letters {
    /// The font stands in the file.
    Embedded,
    /// Only its name does; the reader has it.
    Named,
}

/// The whole figure.
pub fn draw(figure: &Figure, style: &Style, letters: Letters) -> String {
    let (width, letter) = match style.size {
        Size::OneColumn => (241.0, 7.0),
        Size::TwoColumn => (496.0, 8.0),
        Size::Slide => (720.0, 12.0),
    };
    let columns = match style.size {
        Size::Slide => figure.columns.max(figure.panels.len().div_ceil(MOST_ROWS_OF_SLIDE)),
        _ => figure.columns,
    };
    let columns = columns.clamp(1, figure.panels.len().max(1));
    let mut canvas = Canvas { out: String::new(), colours: style.theme.colours(), letter, ruler: Ruler::default() };
    let gap = letter;
    let cell = (width - gap * (columns + 1) as f64) / columns as f64;
    // Panels that all show the same series have one legend together, above them.
    let shared = shared_keys(figure);
    let legend = if shared.is_empty() { Vec::new() } else { wrapped(&shared, 0.0, width - 2.0 * gap, &canvas) };
    let of_panel = |panel| View::of(panel, if shared.is_empty() { keys(panel) } else { Vec::new() }, cell, &canvas);
    let views: Vec<View> = figure.panels.iter().map(of_panel).collect();
    // Panels below each other have their plots exactly below each other.
    let left =
        |column: usize| views.iter().skip(column).step_by(columns).fold(0.0, |most: f64, view| most.max(view.left));
    let rows: Vec<&[View]> = views.chunks(columns).collect();
    let mut top = gap;
    canvas.legend(&legend, width - gap, top + 1.1 * letter);
    top += 1.6 * letter * legend.len() as f64;
    let slide = (SLIDE_HEIGHT - top) / rows.len().max(1) as f64 - gap;
    for row in rows.iter().enumerate() {
        let (number, row) = row;
        let above = row.iter().fold(0.0, |most: f64, view| most.max(view.above));
        let below = row.iter().fold(0.0, |most: f64, view| most.max(view.below));
        let usual = if style.size == Size::OneColumn || columns > 1 { 0.62 } else { 0.3 };
        let plot_height = row.iter().enumerate().fold(0.0, |most: f64, (column, view)| {
            let plot_width = cell - left(column) - letter;
            most.max(plot_width * view.panel.aspect.unwrap_or(usual))
        });
        let plot_height = if style.size == Size::Slide { (slide - above - below).max(10.0) } else { plot_height };
        for (column, view) in row.iter().enumerate() {
            let from = gap + column as f64 * (cell + gap);
            let mut plot = Area {
                left: from + left(column),
                top: top + above,
                width: cell - left(column) - letter,
                height: plot_height,
            };
            if let (Size::Slide, Some(aspect)) = (style.size, view.panel.aspect) {
                plot.width = plot.width.min(plot.height / aspect);
            }
            canvas.panel(view, &plot, number * columns + column);
        }
        top += above + plot_height + below + gap;
    }
    let height = if style.size == Size::Slide { SLIDE_HEIGHT } else { top };
    let font = match letters {
        Letters::Named => String::new(),
        Letters::Embedded => {
            let data = base64::engine::general_purpose::STANDARD.encode(DEJAVU_SANS);
            let source = format!("url(data:font/ttf;base64,{data})");
            format!("<style>@font-face{{font-family:\"DejaVu Sans\";src:{source}}}</style>\n")
        }
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height:.2}pt\" \
         viewBox=\"0 0 {width} {height:.2}\" font-family=\"DejaVu Sans\" font-size=\"{letter}\">\n{font}\
         <rect width=\"{width}\" height=\"{height:.2}\" fill=\"{}\"/>\n{}</svg>\n",
        hex(canvas.colours.ground),
        canvas.out
    )
}

/// A rectangle of the page.
struct Area {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

/// A panel with what its layout needs to know.
struct View<'a> {
    panel: &'a Panel,
    /// Ranges in the axes' own measure: logarithms on logarithmic axes.
    ranges: [[f64; 2]; 2],
    y_ticks: Vec<(f64, String)>,
    /// Rows of the legend: from which entry to which.
    legend: Vec<Vec<(&'a str, Key)>>,
    left: f64,
    above: f64,
    below: f64,
    /// Names below the plot stand upright because they are too long.
    upright: bool,
}

/// How an entry of the legend looks.
#[derive(Clone, Copy, PartialEq)]
enum Key {
    Line(Ink, f64),
    Patch(Ink),
    Dot(Ink),
}

impl<'a> View<'a> {
    fn of(panel: &'a Panel, keys: Vec<(&'a str, Key)>, cell: f64, canvas: &Canvas) -> Self {
        let letter = canvas.letter;
        let y_range = range(panel, 1);
        let ranges = [range(panel, 0), y_range];
        let y_ticks = if panel.bare { Vec::new() } else { axis_ticks(&panel.y, y_range, 6) };
        let longest_number =
            y_ticks.iter().fold(0.0, |most: f64, (_, text)| most.max(canvas.ruler.width(text, letter)));
        let label = if panel.y.label.is_empty() { 0.0 } else { 1.5 * letter };
        let left = if panel.bare { 0.0 } else { longest_number + 0.6 * letter + label };
        let x_ticks = axis_ticks(&panel.x, ranges[0], 6);
        let longest = x_ticks.iter().fold(0.0, |most: f64, (_, text)| most.max(canvas.ruler.width(text, letter)));
        let named = matches!(panel.x.scale, Scale::Names(_));
        let upright = named && longest > 0.95 * (cell - left) / x_ticks.len().max(1) as f64;
        let numbers = match upright {
            _ if panel.bare => 0.0,
            true => longest + 0.6 * letter,
            false => 1.5 * letter,
        };
        let below = numbers + if panel.x.label.is_empty() { 0.0 } else { 1.5 * letter };
        let title = canvas.ruler.width(&title(panel), 1.1 * letter);
        let legend = wrapped(&keys, title + letter, cell - left, canvas);
        let above = 1.6 * letter * legend.len() as f64 + 0.2 * letter;
        View { panel, ranges, y_ticks, legend, left, above, below, upright }
    }
}

/// Entries of a legend in rows of this width, of whose first some is used.
fn wrapped<'a>(keys: &[(&'a str, Key)], used: f64, room: f64, canvas: &Canvas) -> Vec<Vec<(&'a str, Key)>> {
    let mut rows = vec![Vec::new()];
    let mut used = used;
    for (name, key) in keys {
        let needed = canvas.entry(name);
        if used + needed > room && used > 0.0 {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += needed;
        if let Some(row) = rows.last_mut() {
            row.push((*name, *key));
        }
    }
    rows
}

/// The legend of all panels, if several have the same.
fn shared_keys(figure: &Figure) -> Vec<(&str, Key)> {
    let mut all = figure.panels.iter().map(keys);
    let Some(first) = all.next().filter(|_| figure.panels.len() > 1) else { return Vec::new() };
    if all.all(|other| other == first) { first } else { Vec::new() }
}

/// What stands in the legend: each name once.
fn keys(panel: &Panel) -> Vec<(&str, Key)> {
    let mut keys: Vec<(&str, Key)> = Vec::new();
    for mark in &panel.marks {
        let (name, key) = match mark {
            Mark::Line { name, ink, width, .. } => (name, Key::Line(*ink, *width)),
            Mark::Points { name, ink, .. } => (name, Key::Dot(*ink)),
            Mark::Bars { name, ink, .. } | Mark::Boxes { name, ink, .. } | Mark::Band { name, ink, .. } => {
                (name, Key::Patch(*ink))
            }
            Mark::Cells { .. } | Mark::Shade(_) | Mark::Frame { .. } | Mark::Arrow { .. } | Mark::Word { .. } => {
                continue;
            }
        };
        if !name.is_empty() && !keys.iter().any(|(known, _)| known == name) {
            keys.push((name, key));
        }
    }
    keys
}

/// A title names the unit of the values, unless their axis does.
fn title(panel: &Panel) -> String {
    if panel.y.label.is_empty() { with_unit(&panel.title, &panel.y.unit) } else { panel.title.clone() }
}

fn with_unit(label: &str, unit: &str) -> String {
    if unit.is_empty() { label.to_owned() } else { format!("{label} [{unit}]") }
}

/// A value in the axis' own measure.
fn measure(axis: &Axis, value: f64) -> f64 {
    match axis.scale {
        Scale::Logarithmic if value > 0.0 => value.log10(),
        Scale::Logarithmic => f64::NAN,
        Scale::Linear | Scale::Names(_) => value,
    }
}

/// The shown range of one of the two axes.
fn range(panel: &Panel, which: usize) -> [f64; 2] {
    let axis = if which == 0 { &panel.x } else { &panel.y };
    if let Some(range) = axis.range {
        let range = range.map(|end| measure(axis, end));
        if range[1] > range[0] {
            return range;
        }
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut take = |value: f64| {
        let value = measure(axis, value);
        if value.is_finite() {
            (low, high) = (low.min(value), high.max(value));
        }
    };
    let mut zero = false;
    // Of a panel with a given horizontal range only what is in it counts.
    let seen = |x: f64| which == 0 || panel.x.range.is_none_or(|[from, to]| (from..=to).contains(&x));
    for mark in &panel.marks {
        match mark {
            Mark::Line { points, .. } | Mark::Points { points, .. } => {
                points.iter().filter(|point| seen(point[0])).for_each(|point| take(point[which]));
            }
            Mark::Band { points, .. } => {
                for [x, below, above] in points.iter().filter(|point| seen(point[0])) {
                    if which == 0 { take(*x) } else { [*below, *above].into_iter().for_each(&mut take) }
                }
            }
            Mark::Bars { bars, width, .. } => {
                zero |= which == 1 && axis.scale == Scale::Linear;
                for [x, ends @ ..] in bars {
                    if which == 0 {
                        [x - width, x + width].into_iter().for_each(&mut take);
                    } else {
                        ends.iter().copied().for_each(&mut take);
                    }
                }
            }
            Mark::Boxes { boxes, width, .. } => {
                for [x, ends @ ..] in boxes {
                    if which == 0 {
                        [x - width, x + width].into_iter().for_each(&mut take);
                    } else {
                        ends.iter().copied().for_each(&mut take);
                    }
                }
            }
            Mark::Cells { extent, .. } => extent[which].into_iter().for_each(&mut take),
            Mark::Frame { sides, .. } => sides[which].into_iter().for_each(&mut take),
            Mark::Arrow { ends, .. } => ends.iter().for_each(|end| take(end[which])),
            Mark::Word { at, .. } => take(at[which]),
            Mark::Shade(_) => (),
        }
    }
    if zero {
        (low, high) = (low.min(0.0), high.max(0.0));
    }
    if low > high {
        return [0.0, 1.0];
    }
    let cells = panel.marks.iter().any(|mark| matches!(mark, Mark::Cells { .. }));
    let margin = match high > low {
        _ if cells => 0.0,
        true => MARGIN * (high - low),
        false => 0.5 * high.abs().max(1.0),
    };
    let margins =
        if which == 0 && !panel.marks.iter().any(|mark| matches!(mark, Mark::Points { .. })) { 0.0 } else { margin };
    let margins = if high > low { margins } else { margin };
    [if zero && low == 0.0 { 0.0 } else { low - margins }, high + margins]
}

fn axis_ticks(axis: &Axis, range: [f64; 2], count: usize) -> Vec<(f64, String)> {
    match &axis.scale {
        Scale::Linear => {
            let ticks = ticks::linear(range, count);
            let labels = ticks::labels(&ticks);
            ticks.into_iter().zip(labels).collect()
        }
        Scale::Logarithmic => ticks::logarithmic(range, count),
        Scale::Names(names) => names.iter().enumerate().map(|(at, name)| (at as f64, name.clone())).collect(),
    }
}

fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(text: &str) -> String {
    // XML has no letters below the space but line breaks and tabs.
    let text: String = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Where a text is held.
#[derive(Clone, Copy)]
enum Hold {
    Start,
    Middle,
    End,
}

struct Canvas {
    out: String,
    colours: &'static Colours,
    letter: f64,
    ruler: Ruler,
}

/// Writes a piece of SVG; a string takes everything.
macro_rules! put {
    ($canvas:expr, $($part:tt)*) => { let _ = writeln!($canvas.out, $($part)*); };
}

impl Canvas {
    /// Width of a legend's entry, with the distance to the next.
    fn entry(&self, name: &str) -> f64 {
        self.ruler.width(name, self.letter) + 3.6 * self.letter
    }

    fn text(&mut self, [x, y]: [f64; 2], text: &str, size: f64, color: Rgb, hold: Hold) {
        let anchor = match hold {
            Hold::Start => "start",
            Hold::Middle => "middle",
            Hold::End => "end",
        };
        let (color, text) = (hex(color), escaped(text));
        put!(
            self,
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size:.2}\" fill=\"{color}\" text-anchor=\"{anchor}\">{text}</text>"
        );
    }

    /// A text that reads upward.
    fn upward(&mut self, [x, y]: [f64; 2], text: &str, color: Rgb, hold: Hold) {
        put!(self, "<g transform=\"translate({x:.2} {y:.2}) rotate(-90)\">");
        self.text([0.0, 0.0], text, self.letter, color, hold);
        put!(self, "</g>");
    }

    fn rule(&mut self, [from, to]: [[f64; 2]; 2], color: Rgb, width: f64) {
        let ([x1, y1], [x2, y2]) = (from, to);
        put!(
            self,
            "<path d=\"M{x1:.2} {y1:.2}L{x2:.2} {y2:.2}\" stroke=\"{}\" stroke-width=\"{width:.2}\"/>",
            hex(color)
        );
    }

    /// Width of a line of usual width.
    fn usual(&self) -> f64 {
        self.letter / 8.0
    }

    fn dashes(&self, dash: Dash) -> String {
        if dash.is_empty() {
            return String::new();
        }
        let lengths: Vec<String> =
            dash.iter().map(|length| format!("{:.2}", f64::from(*length) * self.letter / 11.0)).collect();
        format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
    }

    fn panel(&mut self, view: &View, plot: &Area, number: usize) {
        let (letter, colours, panel) = (self.letter, self.colours, view.panel);
        let place = Place { plot, ranges: view.ranges, axes: [&panel.x, &panel.y] };
        let (right, bottom) = (plot.left + plot.width, plot.top + plot.height);
        let rectangle = format!(
            "x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\"",
            plot.left, plot.top, plot.width, plot.height
        );
        put!(self, "<clipPath id=\"plot{number}\"><rect {rectangle}/></clipPath>");
        if !panel.bare {
            put!(self, "<rect {rectangle} fill=\"{}\"/>", hex(colours.canvas));
        }
        put!(self, "<g clip-path=\"url(#plot{number})\" fill=\"none\">");
        for mark in &panel.marks {
            if let Mark::Shade([from, to]) = mark {
                self.fill(&place, [*from, *to], panel.y.range, colours.held_out, 1.0);
            }
        }
        let grid = !panel.bare && !panel.marks.iter().any(|mark| matches!(mark, Mark::Cells { .. }));
        for (at, _) in view.y_ticks.iter().filter(|_| grid) {
            let y = place.along(1, *at);
            self.rule([[plot.left, y], [right, y]], colours.grid, 0.5);
        }
        let count = (plot.width / (7.0 * letter)).clamp(2.0, 12.0) as usize;
        let x_ticks = if panel.bare { Vec::new() } else { axis_ticks(&panel.x, view.ranges[0], count) };
        for (at, _) in x_ticks.iter().filter(|_| grid) {
            let x = place.along(0, *at);
            self.rule([[x, plot.top], [x, bottom]], colours.grid, 0.5);
        }
        for mark in &panel.marks {
            self.mark(mark, &place);
        }
        put!(self, "</g>");
        if !panel.bare {
            put!(self, "<rect {rectangle} fill=\"none\" stroke=\"{}\" stroke-width=\"0.6\"/>", hex(colours.border));
        }
        for (at, text) in &view.y_ticks {
            let at = [plot.left - 0.4 * letter, place.along(1, *at) + 0.35 * letter];
            self.text(at, text, letter, colours.weak, Hold::End);
        }
        for (at, text) in &x_ticks {
            let x = place.along(0, *at);
            if view.upright {
                self.upward([x + 0.35 * letter, bottom + 0.4 * letter], text, colours.weak, Hold::End);
            } else {
                self.text([x, bottom + 1.2 * letter], text, letter, colours.weak, Hold::Middle);
            }
        }
        if !panel.x.label.is_empty() {
            let label = with_unit(&panel.x.label, &panel.x.unit);
            let at = [plot.left + plot.width / 2.0, bottom + view.below - 0.3 * letter];
            self.text(at, &label, letter, colours.weak, Hold::Middle);
        }
        if !panel.y.label.is_empty() {
            let label = with_unit(&panel.y.label, &panel.y.unit);
            let at = [plot.left - view.left + 0.9 * letter, plot.top + plot.height / 2.0];
            self.upward(at, &label, colours.weak, Hold::Middle);
        }
        let first = plot.top - view.above + 1.1 * letter;
        self.text([plot.left, first], &title(panel), 1.1 * letter, colours.text, Hold::Start);
        self.legend(&view.legend, right, first);
    }

    /// Rows of a legend that end at `right`, the first of them with its letters on the line `first`.
    fn legend(&mut self, rows: &[Vec<(&str, Key)>], right: f64, first: f64) {
        let letter = self.letter;
        for (row, entries) in rows.iter().enumerate() {
            let width: f64 = entries.iter().map(|(name, _)| self.entry(name)).sum();
            let mut x = right - width + 0.8 * letter;
            for (name, key) in entries {
                self.entry_of_legend([x, first + 1.6 * letter * row as f64], name, *key);
                x += self.entry(name);
            }
        }
    }

    fn entry_of_legend(&mut self, [x, y]: [f64; 2], name: &str, key: Key) {
        let letter = self.letter;
        let middle = y - 0.35 * letter;
        match key {
            Key::Line(ink, width) => {
                let (color, dash) = (hex(self.colours.of(ink)), self.dashes(ink.dash()));
                let (to, width) = (x + 2.3 * letter, width * self.usual());
                put!(
                    self,
                    "<path d=\"M{x:.2} {middle:.2}L{to:.2} {middle:.2}\" stroke=\"{color}\" stroke-width=\"{width:.2}\"{dash}/>"
                );
            }
            Key::Patch(ink) => {
                let color = hex(self.colours.of(ink));
                let (left, top, side) = (x + 1.2 * letter, middle - 0.35 * letter, 0.7 * letter);
                put!(
                    self,
                    "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{side:.2}\" fill=\"{color}\" fill-opacity=\"0.35\" stroke=\"{color}\" stroke-width=\"0.6\"/>",
                    1.1 * letter
                );
            }
            Key::Dot(ink) => {
                let (color, x, radius) = (hex(self.colours.of(ink)), x + 1.8 * letter, 0.25 * letter);
                put!(self, "<circle cx=\"{x:.2}\" cy=\"{middle:.2}\" r=\"{radius:.2}\" fill=\"{color}\"/>");
            }
        }
        self.text([x + 2.6 * letter, y], name, letter, self.colours.weak, Hold::Start);
    }

    /// A rectangle given by its range over x, and that over y or the whole height.
    fn fill(&mut self, place: &Place, x: [f64; 2], y: Option<[f64; 2]>, color: Rgb, opacity: f64) {
        let [left, right] = x.map(|x| place.at(0, x));
        let [low, high] = match y {
            Some(y) => y.map(|y| place.at(1, y)),
            None => [place.plot.top + place.plot.height, place.plot.top],
        };
        if ![left, right, low, high].iter().all(|end| end.is_finite()) {
            return;
        }
        let (width, height) = ((right - left).abs(), (low - high).abs());
        put!(
            self,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{}\" fill-opacity=\"{opacity:.2}\"/>",
            left.min(right),
            low.min(high),
            hex(color)
        );
    }

    fn mark(&mut self, mark: &Mark, place: &Place) {
        let colours = self.colours;
        match mark {
            Mark::Shade(_) => (),
            Mark::Line { points, ink, width, course, .. } => {
                let (color, dash) = (hex(colours.of(*ink)), self.dashes(ink.dash()));
                let width = width * self.usual();
                for piece in pieces(points, *course, place) {
                    if let [[x, y]] = piece.as_slice() {
                        put!(self, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{width:.2}\" fill=\"{color}\"/>");
                        continue;
                    }
                    let path = outline(&piece);
                    put!(
                        self,
                        "<path d=\"{path}\" stroke=\"{color}\" stroke-width=\"{width:.2}\" stroke-linejoin=\"round\"{dash}/>"
                    );
                }
            }
            Mark::Band { points, ink, .. } => {
                let at = |x: f64, y: f64| [place.at(0, x), place.at(1, y)];
                let shown = || points.iter().filter(|point| point.iter().all(|number| number.is_finite()));
                let lower = shown().map(|[x, low, _]| at(*x, *low));
                let upper = shown().rev().map(|[x, _, high]| at(*x, *high));
                let edge: Vec<[f64; 2]> = lower.chain(upper).filter(finite).collect();
                if edge.len() > 2 {
                    let color = hex(colours.of(*ink));
                    put!(self, "<path d=\"{}Z\" fill=\"{color}\" fill-opacity=\"0.2\"/>", outline(&edge));
                }
            }
            Mark::Points { points, ink, radius, opacity, .. } => {
                let (color, radius) = (hex(colours.of(*ink)), radius * self.letter / 5.0);
                put!(self, "<g fill=\"{color}\" fill-opacity=\"{opacity:.2}\">");
                for [x, y] in points.iter().map(|point| place.point(*point)).filter(finite) {
                    put!(self, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"/>");
                }
                put!(self, "</g>");
            }
            Mark::Bars { bars, width, ink, .. } => {
                let base = if place.axes[1].scale == Scale::Logarithmic {
                    place.plot.top + place.plot.height
                } else {
                    place.along(1, 0.0f64.clamp(place.ranges[1][0], place.ranges[1][1]))
                };
                let color = hex(colours.of(*ink));
                for [x, value, low, high] in bars {
                    let (from, to, y) =
                        (place.at(0, x - width / 2.0), place.at(0, x + width / 2.0), place.at(1, *value));
                    if y.is_finite() {
                        let (top, height) = (y.min(base), (y - base).abs());
                        put!(
                            self,
                            "<rect x=\"{from:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{height:.2}\" fill=\"{color}\" fill-opacity=\"0.35\" stroke=\"{color}\" stroke-width=\"0.6\"/>",
                            to - from
                        );
                    }
                    let ends = [[*x, *low], [*x, *high]].map(|end| place.point(end));
                    if ends.iter().all(finite) {
                        self.rule(ends, colours.text, 0.8);
                    }
                }
            }
            Mark::Boxes { boxes, width, ink, .. } => {
                for [x, least, low, median, high, most] in boxes {
                    let color = colours.of(*ink);
                    let end = |y: f64| place.point([*x, y]);
                    for ends in [[end(*least), end(*low)], [end(*high), end(*most)]] {
                        if ends.iter().all(finite) {
                            self.rule(ends, color, 0.8);
                        }
                    }
                    let sides = [x - width / 2.0, x + width / 2.0];
                    self.fill(place, sides, Some([*low, *high]), color, 0.35);
                    let middle = sides.map(|x| place.point([x, *median]));
                    if middle.iter().all(finite) {
                        self.rule(middle, color, 1.6);
                    }
                }
            }
            Mark::Cells { size, extent, values, signed, written } => {
                self.cells(place, *size, extent, values, *signed, *written);
            }
            Mark::Frame { sides: [[left, right], [low, high]], ink } => {
                let ([x, bottom], [end, top]) = (place.point([*left, *low]), place.point([*right, *high]));
                put!(
                    self,
                    "<rect x=\"{x:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{:.2}\" rx=\"{:.2}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{:.2}\"/>",
                    end - x,
                    bottom - top,
                    0.3 * self.letter,
                    hex(colours.canvas),
                    hex(colours.of(*ink)),
                    self.usual()
                );
            }
            Mark::Arrow { ends, ink } => {
                let [from, to] = ends.map(|end| place.point(end));
                self.rule([from, to], colours.of(*ink), self.usual());
                let length = (to[0] - from[0]).hypot(to[1] - from[1]).max(1e-9);
                let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
                let (long, wide) = (0.6 * self.letter, 0.3 * self.letter);
                let side = |sign: f64| {
                    [to[0] - along[0] * long - sign * along[1] * wide, to[1] - along[1] * long + sign * along[0] * wide]
                };
                let head = outline(&[to, side(1.0), side(-1.0)]);
                put!(self, "<path d=\"{head}Z\" fill=\"{}\"/>", hex(colours.of(*ink)));
            }
            Mark::Word { text, at, room, ink } => {
                let [x, y] = place.point(*at);
                let room = place.at(0, at[0] + room) - x;
                let size = self.letter * (room / self.ruler.width(text, self.letter).max(1e-9)).min(1.0);
                self.text([x, y + 0.35 * size], text, size, colours.of(*ink), Hold::Middle);
            }
        }
    }

    fn cells(
        &mut self,
        place: &Place,
        [columns, rows]: [usize; 2],
        extent: &[[f64; 2]; 2],
        values: &[f64],
        signed: bool,
        written: bool,
    ) {
        let side = |which: usize, at: usize, count: usize| {
            let [from, to] = extent[which];
            let end = |at: usize| from + (to - from) * at as f64 / count as f64;
            [end(at), end(at + 1)]
        };
        let most = values.iter().filter(|value| value.is_finite()).fold(0.0, |most: f64, value| most.max(value.abs()));
        for row in 0..rows {
            let line = &values[(row * columns).min(values.len())..((row + 1) * columns).min(values.len())];
            // Written counts are compared within a row.
            let most = if written { line.iter().fold(0.0, |most: f64, value| most.max(value.abs())) } else { most };
            for (column, value) in line.iter().enumerate().filter(|(_, value)| value.is_finite()) {
                let share = if most > 0.0 { value / most } else { 0.0 };
                let color = self.colours.share(if signed { share } else { share.abs() });
                let (x, y) = (side(0, column, columns), side(1, row, rows));
                self.fill(place, x, Some(y), color, 1.0);
                if written && *value != 0.0 {
                    let [x, y] = place.point([(x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0]);
                    let ink = if bright(color) { [0, 0, 0] } else { [0xff, 0xff, 0xff] };
                    let at = [x, y + 0.35 * self.letter];
                    self.text(at, &ticks::short(*value), self.letter, ink, Hold::Middle);
                }
            }
        }
    }
}

/// Whether black is easier to read on it than white.
fn bright([red, green, blue]: Rgb) -> bool {
    0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue) > 140.0
}

fn finite(point: &[f64; 2]) -> bool {
    point.iter().all(|number| number.is_finite())
}

fn outline(points: &[[f64; 2]]) -> String {
    let mut path = String::with_capacity(points.len() * 14);
    for (number, [x, y]) in points.iter().enumerate() {
        let _ = write!(path, "{}{x:.2} {y:.2}", if number == 0 { 'M' } else { 'L' });
    }
    path
}

/// Where values lie on the page.
struct Place<'a> {
    plot: &'a Area,
    ranges: [[f64; 2]; 2],
    axes: [&'a Axis; 2],
}

impl Place<'_> {
    /// Of a value in the axis' own measure.
    fn along(&self, which: usize, measured: f64) -> f64 {
        let [from, to] = self.ranges[which];
        let part = (measured - from) / (to - from);
        match which {
            0 => self.plot.left + part * self.plot.width,
            _ => self.plot.top + (1.0 - part) * self.plot.height,
        }
    }

    fn at(&self, which: usize, value: f64) -> f64 {
        self.along(which, measure(self.axes[which], value))
    }

    fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.at(0, x), self.at(1, y)]
    }
}

/// A line on the page, split at its holes and thinned to what can be seen.
fn pieces(points: &[[f64; 2]], course: Course, place: &Place) -> Vec<Vec<[f64; 2]>> {
    let on_page = |[x, y]: [f64; 2]| [place.along(0, x), place.along(1, y)];
    let own = points.iter().map(|[x, y]| [measure(place.axes[0], *x), measure(place.axes[1], *y)]);
    if course == Course::Free {
        let own: Vec<[f64; 2]> = own.collect();
        let runs = own.split(|point| !finite(point)).filter(|run| !run.is_empty());
        return runs.map(|run| run.iter().map(|point| on_page(*point)).collect()).collect();
    }
    let (x, y): (Vec<f64>, Vec<f64>) = own.filter(|point| point[0].is_finite()).map(|[x, y]| (x, y)).unzip();
    let columns = (place.plot.width * COLUMNS_PER_POINT) as usize;
    let kept = decimate::pieces(&x, &y, place.ranges[0], columns, course == Course::Sampled);
    kept.into_iter().map(|piece| piece.into_iter().map(on_page).collect()).collect()
}
