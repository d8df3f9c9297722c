//! Charts of the same quantity have the same view: who zooms or moves one of them does so with all, on every screen.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use serde::{Deserialize, Serialize};

use super::along::Along;
use super::own::OwnLines;
use crate::figure::Panel;

/// What is in view of charts that are linked.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Window {
    /// The part of the horizontal axis; `None` shows everything.
    pub range: Option<[f64; 2]>,
    /// The two cursors of a measurement.
    pub measured: Option<[f64; 2]>,
    /// The part of the vertical axis by the title of a chart, where a box was zoomed, in the axis' own measure.
    pub heights: BTreeMap<String, [f64; 2]>,
    /// Names in the legend that are not drawn.
    pub hidden: BTreeSet<String>,
}

impl Window {
    /// A panel as it is in view.
    pub fn of(&self, panel: &Panel) -> Panel {
        let mut seen = panel.clone();
        seen.x.range = self.range.or(panel.x.range);
        if let Some(height) = self.heights.get(&panel.title) {
            seen.y.range = Some(height.map(|end| panel.y.value(end)));
        }
        seen.marks.retain(|mark| mark.entry().is_none_or(|entry| !self.hidden.contains(entry.name)));
        seen
    }
}

/// The view of every quantity, and the lines that somebody adds to charts.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Views {
    windows: HashMap<String, Window>,
    /// Lines of one's own.
    #[serde(skip)]
    pub own: OwnLines,
}

impl Views {
    /// The view of all charts of a quantity.
    pub fn of(&mut self, along: Along) -> &mut Window {
        self.windows.entry(along.to_string()).or_default()
    }

    /// The view of a panel, that of its link or its own, and the lines that may be added to it.
    pub fn of_panel(&mut self, panel: &Panel) -> (&mut Window, &mut OwnLines) {
        let window = self.windows.entry(panel.x.link.clone().unwrap_or_else(|| panel.title.clone()));
        (window.or_default(), &mut self.own)
    }

    /// Panels as they are in view.
    pub fn seen(&self, panels: Vec<Panel>) -> Vec<Panel> {
        let seen = |panel: Panel| {
            let panel = self.own.onto(panel);
            let window = self.windows.get(panel.x.link.as_ref().unwrap_or(&panel.title));
            window.map_or_else(|| panel.clone(), |window| window.of(&panel))
        };
        panels.into_iter().map(seen).collect()
    }

    /// Charts of this quantity show everything.
    pub fn fit(&mut self, along: Along) {
        self.windows.remove(&along.to_string());
    }

    /// All charts show everything.
    pub fn fit_all(&mut self) {
        self.windows.clear();
    }
}
