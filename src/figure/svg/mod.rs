//! A figure as SVG: the one place where a page is laid out. Lengths are points of 1/72 inch.

mod canvas;

use std::fmt::Write as _;

use base64::Engine as _;

use super::canvas::{Canvas, Fill, Hold, Stroke};
use super::lines::{has_room_for_words, in_lines, title_in_lines};
use super::mark::{Edges, Entry, Key};
use super::size::POINTS_PER_MILLIMETRE;
use super::{Area, Figure, Legend, Panel, Place, Scale, Size, Style};
pub use canvas::escaped;
use canvas::{COLUMNS_PER_POINT, Paper, hex, put, rectangle};

/// Height of a slide \[points\].
const SLIDE_HEIGHT: f64 = 405.0;
/// Panels below each other on a slide, before a second column is begun.
const MOST_ROWS_OF_SLIDE: usize = 3;
/// Height of a title's letters, in letters.
const TITLE: f64 = 1.1;
/// From line to line of a name or a title, in letters.
const LINE: f64 = 1.2;
/// Lines that a title may have.
const MOST_LINES_OF_TITLE: usize = 7;
/// Numbers at the left have so much room from one to the next, in letters, and there are no more than so many.
const ROOM_OF_NUMBER: f64 = 1.3;
const MOST_NUMBERS: usize = 6;
/// Between the names of neighbours, in letters.
const BETWEEN_NAMES: f64 = 0.8;
/// A plot with names below it is at least so many times as high as what stands around it.
const LEAST_OF_NAMED: f64 = 1.6;

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
    let columns = match style.size {
        _ if style.columns.is_some() => style.columns.unwrap_or(1),
        Size::Slide => figure.columns.max(figure.panels.len().div_ceil(MOST_ROWS_OF_SLIDE)),
        _ => figure.columns,
    };
    let columns = columns.clamp(1, figure.panels.len().max(1));
    let letter = letter(style);
    let room = cell(style, columns) - letter;
    let fitted = figure.panels.iter().map(|panel| panel.fitted(room / letter)).collect();
    laid_out(&named_below(Figure { panels: fitted, ..*figure }, columns), columns, style, letters)
}

/// Height of the letters \[points\].
fn letter(style: &Style) -> f64 {
    style.letter.unwrap_or(style.size.letter())
}

/// Width of a panel with all that stands around it, of so many columns \[points\].
fn cell(style: &Style, columns: usize) -> f64 {
    (style.size.width() - letter(style) * (columns + 1) as f64) / columns as f64
}

/// The figure, in which of plots below each other over the same axis only the last one names it.
fn named_below(figure: Figure, columns: usize) -> Figure {
    let Figure { mut panels, columns: own } = figure;
    for number in 0..panels.len().saturating_sub(columns) {
        if panels[number].x.link.is_some() && panels[number].x == panels[number + columns].x {
            panels[number].x.label.clear();
            panels[number].x.unit.clear();
        }
    }
    Figure { panels, columns: own }
}

/// The figure in so many columns.
fn laid_out<'f>(figure: &'f Figure, columns: usize, style: &Style, letters: Letters) -> String {
    let width = style.size.width();
    let letter = letter(style);
    let mut paper = Paper::new(style.theme.colours(), letter, style.family);
    let gap = letter;
    let cell = cell(style, columns);
    // Panels that all show the same series have one legend together, above them.
    let shared = shared_legend(figure, style.legend);
    let legend = if shared.is_empty() { Vec::new() } else { wrapped(&shared, 0.0, width - 2.0 * gap, &paper) };
    let mut of_panel = |(number, panel): (usize, &'f Panel)| {
        let own = if shared.is_empty() { Panel::legend(panel) } else { Vec::new() };
        let heading =
            if style.lettered { format!("({}) {}", letter_of(number), panel.heading()) } else { panel.heading() };
        View::of(panel, heading, own, cell, &mut paper)
    };
    let views: Vec<View> = figure.panels.iter().enumerate().map(&mut of_panel).collect();
    // Panels below each other have their plots exactly below each other.
    let left =
        |column: usize| views.iter().skip(column).step_by(columns).fold(0.0, |most: f64, view| most.max(view.left));
    let rows: Vec<&[View]> = views.chunks(columns).collect();
    let mut top = gap;
    paper.legend(&legend, width - gap, top + 1.1 * letter);
    top += 1.6 * letter * legend.len() as f64;
    let slide = (SLIDE_HEIGHT - top) / rows.len().max(1) as f64 - gap;
    for row in rows.iter().enumerate() {
        let (number, row) = row;
        let above = row.iter().fold(0.0, |most: f64, view| most.max(view.above));
        let below = row.iter().fold(0.0, |most: f64, view| most.max(view.below));
        let usual = if style.size.is_narrow() || columns > 1 { 0.62 } else { 0.3 };
        let plot_height = row.iter().enumerate().fold(0.0, |most: f64, (column, view)| {
            let plot_width = cell - left(column) - letter;
            let least = if view.names.is_some() && view.panel.aspect.is_none() {
                LEAST_OF_NAMED * (above + below + 2.0 * gap)
            } else {
                0.0
            };
            most.max(plot_width * view.panel.aspect.unwrap_or(usual)).max(least)
        });
        let plot_height = style.height.map_or(plot_height, |millimetres| millimetres * POINTS_PER_MILLIMETRE);
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
            paper.panel(view, plot, above, number * columns + column, style);
        }
        top += above + plot_height + below + gap;
    }
    let height = if style.size == Size::Slide { SLIDE_HEIGHT } else { top };
    let font = match letters {
        Letters::Named => String::new(),
        Letters::Embedded => {
            let data = base64::engine::general_purpose::STANDARD.encode(style.family.of_letters(&paper.letters));
            let source = format!("url(data:font/ttf;base64,{data})");
            format!("<style>@font-face{{font-family:\"{}\";src:{source}}}</style>\n", style.family.name())
        }
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height:.2}pt\" \
         viewBox=\"0 0 {width} {height:.2}\" font-family=\"{}\" font-size=\"{letter}\">\n{font}\
         <rect width=\"{width}\" height=\"{height:.2}\" fill=\"{}\"/>\n{}</svg>\n",
        style.family.name(),
        hex(paper.colours().ground),
        paper.out
    )
}

/// A panel with what its layout needs to know.
struct View<'a> {
    panel: &'a Panel,
    /// The title in lines.
    heading: Vec<String>,
    /// Ranges in the axes' own measure: logarithms on logarithmic axes.
    ranges: [[f64; 2]; 2],
    /// As many numbers at the left as there can be; a low plot has fewer.
    y_ticks: Vec<(f64, String)>,
    /// Rows of the legend: from which entry to which.
    legend: Vec<Vec<Entry<'a>>>,
    left: f64,
    above: f64,
    below: f64,
    /// What stands below the plot, if it is names.
    names: Option<Names>,
}

/// Names below a plot.
struct Names {
    /// Each in lines.
    lines: Vec<Vec<String>>,
    /// Whether they read upward, because their words have no room beside each other.
    upright: bool,
    /// How high they are.
    height: f64,
}

impl Names {
    /// Names of which each has so much room from side to side.
    fn of(names: &[String], room: f64, paper: &Paper) -> Self {
        let letter = paper.letter();
        let width = |text: &str| paper.width_of(text, letter);
        let upright = !names.iter().all(|name| has_room_for_words(name, room, width));
        let of_length = |length: f64| -> Vec<Vec<String>> {
            names.iter().map(|name| in_lines(name, length, usize::MAX, width)).collect()
        };
        let most = |lines: &[Vec<String>]| lines.iter().map(Vec::len).max().unwrap_or(0);
        if !upright {
            let lines = of_length(room);
            let height = LINE * letter * most(&lines) as f64;
            return Names { lines, upright, height };
        }
        // As short as they can be in as many lines as stand beside each other.
        let beside = ((room + BETWEEN_NAMES * letter) / (LINE * letter)).max(1.0) as usize;
        let words = names.iter().flat_map(|name| name.split_whitespace()).map(width);
        let whole = names.iter().map(|name| width(name)).fold(0.0, f64::max);
        let mut height = words.fold(whole / beside as f64, f64::max);
        let mut lines = of_length(height);
        while most(&lines) > beside && height < whole {
            height = (1.05 * height).min(whole);
            lines = of_length(height);
        }
        Names { lines, upright, height }
    }
}

impl<'a> View<'a> {
    /// A panel of this width.
    fn of(panel: &'a Panel, heading: String, legend: Vec<Entry<'a>>, cell: f64, paper: &mut Paper) -> Self {
        let letter = paper.letter();
        let ranges = panel.ranges((cell * COLUMNS_PER_POINT) as usize, paper.decimator());
        let longest = |ticks: &[(f64, String)]| {
            ticks.iter().fold(0.0, |most: f64, (_, text)| most.max(paper.width_of(text, letter)))
        };
        let y_ticks = if panel.bare { Vec::new() } else { panel.y.ticks(ranges[1], MOST_NUMBERS) };
        let label = if panel.y.label.is_empty() { 0.0 } else { 1.5 * letter };
        let left = if panel.bare { 0.0 } else { longest(&y_ticks) + 0.6 * letter + label };
        let names = match &panel.x.scale {
            Scale::Names(names) if !panel.bare => {
                let room = (cell - left - letter) / names.len().max(1) as f64 - BETWEEN_NAMES * letter;
                Some(Names::of(names, room, paper))
            }
            _ => None,
        };
        let numbers = match &names {
            _ if panel.bare => 0.0,
            Some(names) => names.height + 0.6 * letter,
            None => 1.5 * letter,
        };
        let below = numbers + if panel.x.label.is_empty() { 0.0 } else { 1.5 * letter };
        let title = |text: &str| paper.width_of(text, TITLE * letter);
        let heading = title_in_lines(&heading, cell - left - letter, MOST_LINES_OF_TITLE, title);
        let last = heading.last().map_or(0.0, |line| title(line));
        let legend = wrapped(&legend, last + letter, cell - left, paper);
        let more = LINE * TITLE * heading.len().saturating_sub(1) as f64;
        let above = (1.6 * legend.len() as f64 + 0.2 + more) * letter;
        View { panel, heading, ranges, y_ticks, legend, left, above, below, names }
    }

    /// The numbers at the left that have room below each other; one alone would be no scale.
    fn y_ticks_in(&self, place: &Place, letter: f64) -> Vec<(f64, String)> {
        let room = |pair: &[(f64, String)]| (place.along(1, pair[0].0) - place.along(1, pair[1].0)).abs();
        let fit = |ticks: &Vec<(f64, String)>| {
            ticks.len() > 1 && ticks.windows(2).all(|pair| room(pair) >= ROOM_OF_NUMBER * letter)
        };
        let fewer = (2..MOST_NUMBERS).rev().map(|count| self.panel.y.ticks(self.ranges[1], count));
        // Every name is needed, a number is not.
        if matches!(self.panel.y.scale, Scale::Names(_)) || self.y_ticks.len() < 2 || fit(&self.y_ticks) {
            return self.y_ticks.clone();
        }
        let ends = || self.y_ticks.iter().step_by(self.y_ticks.len() - 1).cloned().collect();
        fewer.into_iter().find(fit).unwrap_or_else(ends)
    }
}

/// Entries of a legend in rows of this width, of whose first some is used.
fn wrapped<'a>(entries: &[Entry<'a>], used: f64, room: f64, paper: &Paper) -> Vec<Vec<Entry<'a>>> {
    let mut rows = vec![Vec::new()];
    let mut used = used;
    for entry in entries {
        let needed = paper.entry(entry);
        if used + needed > room && used > 0.0 {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += needed;
        if let Some(row) = rows.last_mut() {
            row.push(*entry);
        }
    }
    rows
}

/// An attribute that tells which values lie where along an axis: from which place of the page to which, and from which value to which
/// in the axis' own measure.
fn values(key: &str, which: usize, place: &Place) -> String {
    let (axis, [from, to]) = (place.axes[which], place.ranges[which]);
    let names = if let Scale::Names(names) = &axis.scale { Some(names) } else { None };
    let told = serde_json::json!({
        "low": place.along(which, from), "high": place.along(which, to), "from": from, "to": to,
        "log": axis.scale == Scale::Logarithmic, "names": names, "label": axis.label, "unit": axis.unit,
    });
    format!(" data-{key}=\"{}\"", escaped(&told.to_string()))
}

/// What the n-th panel is called: a, b, …, z, aa, ab, …
fn letter_of(number: usize) -> String {
    let letter = char::from(b'a' + (number % 26) as u8).to_string();
    if number < 26 { letter } else { letter_of(number / 26 - 1) + &letter }
}

/// The legend of all panels: if several have the same, or one for all is asked for.
fn shared_legend(figure: &Figure, legend: Legend) -> Vec<Entry<'_>> {
    if legend == Legend::Shared {
        let mut entries: Vec<Entry> = Vec::new();
        for entry in figure.panels.iter().flat_map(Panel::legend) {
            if !entries.contains(&entry) {
                entries.push(entry);
            }
        }
        return entries;
    }
    figure.common_legend()
}

impl Paper {
    /// Width of a legend's entry, with the distance to the next.
    fn entry(&self, entry: &Entry) -> f64 {
        self.width_of(entry.name, self.letter()) + (entry.key.width() + 1.3) * self.letter()
    }

    /// A panel with its title so far above the plot that those of a row stand beside each other.
    fn panel(&mut self, view: &View, plot: Area, above: f64, number: usize, style: &Style) {
        let (letter, colours, panel) = (self.letter(), *self.colours(), view.panel);
        let place = Place { plot, ranges: view.ranges, axes: [&panel.x, &panel.y] };
        let sides = [[plot.left, plot.right()], [plot.top, plot.bottom()]];
        put!(self, "<clipPath id=\"plot{number}\"><rect {}/></clipPath>", rectangle(sides));
        if !panel.bare {
            self.rectangle(sides, &Fill { color: colours.canvas, opacity: 1.0 }, None, 0.0);
        }
        // Who reads the file on a screen can be told the values at the pointer.
        let values = if panel.bare {
            String::new()
        } else {
            [("x", 0), ("y", 1)].map(|(key, which)| values(key, which, &place)).concat()
        };
        put!(self, "<g clip-path=\"url(#plot{number})\"{values}>");
        for mark in panel.marks.iter().filter(|mark| style.shaded && mark.is_behind()) {
            mark.draw(&place, self);
        }
        let count = (plot.width / (7.0 * letter)).clamp(2.0, 12.0) as usize;
        let x_ticks = if panel.bare { Vec::new() } else { panel.x.ticks(view.ranges[0], count) };
        let y_ticks = view.y_ticks_in(&place, letter);
        let is_filled = panel.marks.iter().any(|mark| mark.edges() == Edges::Filled);
        if !panel.bare && !is_filled && style.size.has_grid() {
            for (at, _) in &y_ticks {
                let y = place.along(1, *at);
                self.rule([[plot.left, y], [plot.right(), y]], colours.grid, 0.5);
            }
            for (at, _) in &x_ticks {
                let x = place.along(0, *at);
                self.rule([[x, plot.top], [x, plot.bottom()]], colours.grid, 0.5);
            }
        }
        for mark in panel.marks.iter().filter(|mark| !mark.is_behind()) {
            // Colours stand for values that no line of the drawing has.
            let entry = mark.entry().filter(|entry| !matches!(entry.key, Key::Scale(_)));
            let name = entry.map_or("", |entry| entry.name);
            put!(self, "<g data-series=\"{}\">", escaped(name));
            mark.draw(&place, self);
            put!(self, "</g>");
        }
        put!(self, "</g>");
        let edge = Stroke::new(colours.border, 0.6);
        if !panel.bare {
            self.rectangle(sides, &Fill { color: colours.canvas, opacity: 0.0 }, Some(&edge), 0.0);
        }
        if !style.size.has_grid() {
            self.tick_marks(&place, [&x_ticks, &y_ticks], &edge);
        }
        self.numbers(view, &place, [&x_ticks, &y_ticks]);
        let mut line = plot.top - above + TITLE * letter;
        for (number, text) in view.heading.iter().enumerate() {
            line += if number == 0 { 0.0 } else { LINE * TITLE * letter };
            self.text([plot.left, line], text, TITLE * letter, colours.text, Hold::Start);
        }
        self.legend(&view.legend, plot.right(), line);
    }

    /// Short marks at the axes, inwards.
    fn tick_marks(&mut self, place: &Place, ticks: [&[(f64, String)]; 2], edge: &Stroke) {
        let (plot, length) = (place.plot, 0.4 * self.letter());
        for (at, _) in ticks[0] {
            let x = place.along(0, *at);
            self.rule([[x, plot.bottom()], [x, plot.bottom() - length]], edge.color, edge.width);
        }
        for (at, _) in ticks[1] {
            let y = place.along(1, *at);
            self.rule([[plot.left, y], [plot.left + length, y]], edge.color, edge.width);
        }
    }

    /// What stands along the axes.
    fn numbers(&mut self, view: &View, place: &Place, [x_ticks, y_ticks]: [&[(f64, String)]; 2]) {
        let (letter, color, plot, panel) = (self.letter(), self.colours().weak, place.plot, view.panel);
        for (at, text) in y_ticks {
            let at = [plot.left - 0.4 * letter, place.along(1, *at) + 0.35 * letter];
            self.text(at, text, letter, color, Hold::End);
        }
        for (number, (at, text)) in x_ticks.iter().enumerate() {
            let x = place.along(0, *at);
            let Some(names) = &view.names else {
                self.text([x, plot.bottom() + 1.2 * letter], text, letter, color, Hold::Middle);
                continue;
            };
            let lines = &names.lines[number];
            for (line, text) in lines.iter().enumerate() {
                let line = LINE * letter * line as f64;
                if names.upright {
                    let first = x + 0.35 * letter - 0.5 * LINE * letter * lines.len().saturating_sub(1) as f64;
                    self.upward([first + line, plot.bottom() + 0.4 * letter], text, color, Hold::End);
                } else {
                    self.text([x, plot.bottom() + 1.2 * letter + line], text, letter, color, Hold::Middle);
                }
            }
        }
        if !panel.x.label.is_empty() {
            let at = [plot.left + plot.width / 2.0, plot.bottom() + view.below - 0.3 * letter];
            self.text(at, &panel.x.title(), letter, color, Hold::Middle);
        }
        if !panel.y.label.is_empty() {
            let at = [plot.left - view.left + 0.9 * letter, plot.top + plot.height / 2.0];
            self.upward(at, &panel.y.title(), color, Hold::Middle);
        }
    }

    /// Rows of a legend that end at `right`, the first of them with its letters on the line `first`.
    fn legend(&mut self, rows: &[Vec<Entry>], right: f64, first: f64) {
        let (letter, color) = (self.letter(), self.colours().weak);
        for (row, entries) in rows.iter().enumerate() {
            let width: f64 = entries.iter().map(|entry| self.entry(entry)).sum();
            let mut x = right - width + 0.8 * letter;
            let y = first + 1.6 * letter * row as f64;
            for entry in entries {
                entry.key.draw(self, [x, y - 0.35 * letter]);
                self.text([x + (entry.key.width() + 0.3) * letter, y], entry.name, letter, color, Hold::Start);
                x += self.entry(entry);
            }
        }
    }
}
