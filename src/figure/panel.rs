//! A figure is a grid of panels; a panel has two axes and marks.

use std::fmt;
use std::sync::Arc;

use super::axis::{Axis, Scale, with_unit};
use super::decimate::Decimator;
use super::mark::{Edges, Entry, Mark, Reach};

/// Room that is left of the range on either side, as a part of it.
const MARGIN: f64 = 0.06;

/// Values that differ by a smaller part of themselves are taken as the same.
const ROUNDING: f64 = 1e-10;

/// Panels, drawn row by row.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// What is drawn.
    pub panels: Vec<Panel>,
    /// How many panels stand beside each other.
    pub columns: usize,
}

impl Figure {
    /// Panels below each other.
    pub fn new(panels: Vec<Panel>) -> Self {
        Figure { panels, columns: 1 }
    }

    /// The legend that several panels have, if they all have the same.
    pub(super) fn common_legend(&self) -> Vec<Entry<'_>> {
        let mut all = self.panels.iter().map(Panel::legend);
        let Some(first) = all.next().filter(|_| self.panels.len() > 1) else { return Vec::new() };
        if all.all(|other| other == first) { first } else { Vec::new() }
    }
}

/// Marks over two axes. Its data are shared, so that a copy costs little.
#[derive(Debug, Clone)]
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, from back to front.
    pub marks: Vec<Arc<dyn Mark>>,
    /// Height of the plot as a part of its width; `None` takes what suits the size of the figure.
    pub aspect: Option<f64>,
    /// Whether it is a drawing: without numbers, grid and frame.
    pub bare: bool,
    /// How it is laid out anew where it has another width; `None` for what is only made larger and smaller.
    pub layout: Option<Layout>,
}

/// Lays out a drawing for a width in letters.
#[derive(Clone)]
pub struct Layout(Arc<dyn Fn(f64) -> Panel + Send + Sync>);

impl fmt::Debug for Layout {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("Layout")
    }
}

impl Panel {
    /// A panel without marks.
    pub fn new(title: impl Into<String>, [x, y]: [Axis; 2]) -> Self {
        Panel { title: title.into(), x, y, marks: Vec::new(), aspect: None, bare: false, layout: None }
    }

    /// Adds a mark in front of the others.
    #[must_use]
    pub fn with(mut self, mark: impl Mark + 'static) -> Self {
        self.push(mark);
        self
    }

    /// Adds marks in front of the others.
    #[must_use]
    pub fn with_all<M: Mark + 'static>(mut self, marks: impl IntoIterator<Item = M>) -> Self {
        marks.into_iter().for_each(|mark| self.push(mark));
        self
    }

    /// Adds a mark in front of the others.
    pub fn push(&mut self, mark: impl Mark + 'static) {
        self.marks.push(Arc::new(mark));
    }

    /// A drawing, without numbers, grid and frame.
    #[must_use]
    pub fn bare(mut self) -> Self {
        self.bare = true;
        self
    }

    /// The same, laid out anew by `layout` for the width that it gets on paper, in letters.
    #[must_use]
    pub fn laid_out_by(mut self, layout: impl Fn(f64) -> Panel + Send + Sync + 'static) -> Self {
        self.layout = Some(Layout(Arc::new(layout)));
        self
    }

    /// As it is on so many letters of width.
    pub(super) fn fitted(&self, letters: f64) -> Panel {
        match &self.layout {
            Some(Layout(layout)) => Panel { title: self.title.clone(), ..layout(letters) },
            None => self.clone(),
        }
    }

    /// Sets the height of the plot as a part of its width: 1 for a square.
    #[must_use]
    pub fn aspect(mut self, aspect: f64) -> Self {
        self.aspect = Some(aspect);
        self
    }

    /// What is said above it: a title names the unit of the values, unless their axis does.
    pub fn heading(&self) -> String {
        if self.y.label.is_empty() { with_unit(&self.title, &self.y.unit) } else { self.title.clone() }
    }

    /// What stands in the legend: each name once.
    pub fn legend(&self) -> Vec<Entry<'_>> {
        let mut entries: Vec<Entry> = Vec::new();
        for entry in self.marks.iter().filter_map(|mark| mark.entry()) {
            if !entry.name.is_empty() && !entries.iter().any(|known| known.name == entry.name) {
                entries.push(entry);
            }
        }
        entries
    }

    /// The shown ranges of both axes in their own measure, on so many pixel columns.
    pub fn ranges(&self, columns: usize, decimator: &mut Decimator) -> [[f64; 2]; 2] {
        let x = self.range(0, None, columns, decimator);
        // Of a panel with a given horizontal range only what is in it counts.
        [x, self.range(1, self.x.range, columns, decimator)]
    }

    fn range(&self, which: usize, seen: Option<[f64; 2]>, columns: usize, decimator: &mut Decimator) -> [f64; 2] {
        let axis = [&self.x, &self.y][which];
        if let Some(range) = axis.range {
            let range = range.map(|end| axis.measure(end));
            if range[1] > range[0] {
                return range;
            }
        }
        let mut reach = Reach::new(which, [&self.x, &self.y], seen, columns, decimator);
        self.marks.iter().for_each(|mark| mark.reach(&mut reach));
        let [mut low, mut high] = reach.ends();
        let has = |edges: Edges| self.marks.iter().any(|mark| mark.edges() == edges);
        let stands = which == 1 && axis.scale == Scale::Linear && has(Edges::OnZero);
        if stands {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        if low > high {
            return [0.0, 1.0];
        }
        // What differs by rounding alone is one value.
        let margin = match high - low > ROUNDING * low.abs().max(high.abs()) {
            _ if has(Edges::Filled) => 0.0,
            false => 0.5 * high.abs().max(1.0),
            true if which == 1 || has(Edges::Loose) => MARGIN * (high - low),
            true => 0.0,
        };
        [if stands && low == 0.0 { 0.0 } else { low - margin }, high + margin]
    }
}
