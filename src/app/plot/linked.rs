//! Charts of the same quantity have the same view: who zooms or moves one of them does so with all, on every screen.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::figure::Panel;

/// What stands along the horizontal axis of a chart; joints are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Along {
    /// Time of the chosen trajectory.
    Time,
    /// Time of all trajectories, end to end.
    WholeTime,
    /// Time of the replay outside the data.
    ReplayTime,
    /// Position of a joint.
    Position(usize),
    /// Velocity of a joint.
    Velocity(usize),
    /// Acceleration of a joint.
    Acceleration(usize),
    /// Measured torque of a joint.
    Load(usize),
    /// What the model leaves of it.
    Residual(usize),
    /// Frequency.
    Frequency,
    /// How often something repeats in a turn.
    Order,
    /// Time between a value and the one it is compared with.
    Lag,
    /// Epoch of a training.
    Epoch,
    /// Position of the joint that goes while the others stand.
    Slice,
    /// How much faster or wider than the data.
    Stretch,
}

/// Its name as a link of axes.
impl fmt::Display for Along {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{self:?}")
    }
}

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

/// The view of every quantity.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Views(HashMap<String, Window>);

impl Views {
    /// The view of all charts of a quantity.
    pub fn of(&mut self, along: Along) -> &mut Window {
        self.0.entry(along.to_string()).or_default()
    }

    /// The view of a panel: that of its link, or its own.
    pub fn of_panel(&mut self, panel: &Panel) -> &mut Window {
        self.0.entry(panel.x.link.clone().unwrap_or_else(|| panel.title.clone())).or_default()
    }

    /// Panels as they are in view.
    pub fn seen(&self, panels: Vec<Panel>) -> Vec<Panel> {
        let own = |panel: &Panel| self.0.get(panel.x.link.as_ref().unwrap_or(&panel.title));
        panels.into_iter().map(|panel| own(&panel).map_or_else(|| panel.clone(), |view| view.of(&panel))).collect()
    }

    /// Charts of this quantity show everything.
    pub fn fit(&mut self, along: Along) {
        self.0.remove(&along.to_string());
    }

    /// All charts show everything.
    pub fn fit_all(&mut self) {
        self.0.clear();
    }
}
