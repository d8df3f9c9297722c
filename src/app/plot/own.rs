//! Lines of one's own: formulas of channels that somebody writes into the menu of a chart, drawn over what it shows.

use std::collections::BTreeSet;

use egui::{Button, DragValue, RichText, Role, TextEdit, Ui, WidgetInfo};
use serde::{Deserialize, Serialize};

use super::along::Along;
use crate::app::theme::{Palette, SMALL};
use crate::figure::mark::{Key, Line};
use crate::figure::{Ink, Panel, ticks};

/// Width of the field of a formula \[points\].
const FIELD: f32 = 130.0;
/// What a name of a channel can begin with; the joint stands behind it, counted from 1.
pub const CHANNELS: &str = "q1, qd1, qdd1, tau1, predicted1, residual1 (and so on by joint), and t";
/// So many colours and dashes are there, in pairs that look different.
const INKS: usize = 49;

/// A series of one's own, as it is written.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnSeries {
    /// A formula of channels; blank for none.
    pub text: String,
    /// Cut-off of its low-pass \[Hz\]; 0 lets everything pass.
    pub cutoff_hz: f64,
}

impl OwnSeries {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// What the low-pass is called; `None` if everything passes.
    pub fn filter(&self) -> Option<String> {
        (self.cutoff_hz > 0.0).then(|| format!("low-pass {} Hz", ticks::short(self.cutoff_hz)))
    }

    /// Where the formula and its low-pass are written.
    pub fn edit(&mut self, ui: &mut Ui, spoken: &str, hint: &str) {
        let edit = ui.add(TextEdit::singleline(&mut self.text).desired_width(FIELD).hint_text("tau1 - predicted1"));
        edit.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, spoken));
        edit.on_hover_text(format!("{hint}, of {CHANNELS}; abs, sign, sin, max …"));
        if !self.is_empty() {
            let cutoff = DragValue::new(&mut self.cutoff_hz).range(0.0..=1e5).speed(0.1).max_decimals(2).suffix(" Hz");
            let label = ui.label("low-pass");
            let drag = ui.add(cutoff).labelled_by(label.id);
            drag.on_hover_text("Cut-off of a fourth-order Butterworth filter run forward and backward; 0 for none");
        }
    }
}

/// A line without name and colour, or why there is none; `None` until it is known.
pub type Drawn = Option<Result<Line, String>>;

/// A line of one's own in a chart.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct OwnLine {
    /// What stands along the chart.
    link: String,
    /// The title of the chart.
    chart: String,
    series: OwnSeries,
    #[serde(skip)]
    drawn: Drawn,
}

impl OwnLine {
    fn is_in(&self, panel: &Panel) -> bool {
        self.chart == panel.title && Some(&self.link) == panel.x.link.as_ref()
    }

    fn name(&self) -> String {
        let text = self.series.text.trim();
        self.series.filter().map_or_else(|| text.to_owned(), |filter| format!("{text}, {filter}"))
    }
}

/// All lines of one's own, in all charts.
#[derive(Debug, Clone, Default)]
pub struct OwnLines {
    lines: Vec<OwnLine>,
    /// Along what the charts stand that are drawn now and can have some.
    offered: BTreeSet<String>,
}

impl OwnLines {
    /// Lines as a file tells of them.
    pub fn of(lines: Vec<OwnLine>) -> Self {
        OwnLines { lines, ..OwnLines::default() }
    }

    /// Those that are written.
    pub fn written(&self) -> Vec<OwnLine> {
        self.lines.iter().filter(|line| !line.series.is_empty()).cloned().collect()
    }

    /// Before anything is drawn no chart can have one.
    pub fn begin(&mut self) {
        self.offered.clear();
    }

    /// The charts along this can have lines, which are drawn so.
    pub fn draw(&mut self, along: Along, mut draw: impl FnMut(&OwnSeries) -> Drawn) {
        let link = along.to_string();
        for line in self.lines.iter_mut().filter(|line| line.link == link) {
            let series = OwnSeries { text: line.series.text.trim().to_owned(), ..line.series };
            line.drawn = if series.is_empty() { None } else { draw(&series) };
        }
        self.offered.insert(link);
    }

    /// Whether a chart can have lines.
    pub fn can_be_in(&self, panel: &Panel) -> bool {
        panel.x.link.as_ref().is_some_and(|link| self.offered.contains(link))
    }

    /// Writes a line into a chart that can have one.
    pub fn add(&mut self, panel: &Panel, series: OwnSeries) {
        if let Some(link) = panel.x.link.clone() {
            self.lines.push(OwnLine { link, chart: panel.title.clone(), series, drawn: None });
        }
    }

    /// A chart with its lines over it, each with a look of its own.
    pub fn onto(&self, mut panel: Panel) -> Panel {
        for line in self.lines.iter().filter(|line| line.is_in(&panel)).cloned().collect::<Vec<_>>() {
            let name = line.name();
            if let Some(Ok(drawn)) = line.drawn {
                let ink = free_ink(&panel);
                panel.push(Line { name, ..drawn.ink(ink) });
            }
        }
        panel
    }

    /// What is wrong with a line, if something is: its formula, and why.
    pub fn problem(&self) -> Option<(String, String)> {
        let problem = |line: &OwnLine| Some((line.series.text.clone(), line.drawn.as_ref()?.as_ref().err()?.clone()));
        self.lines.iter().find_map(problem)
    }

    /// Where the lines of a chart are written.
    pub fn edit(&mut self, ui: &mut Ui, panel: &Panel) {
        if !self.can_be_in(panel) {
            return;
        }
        ui.label("Lines of your own");
        let mut gone = None;
        let here = self.lines.iter_mut().enumerate().filter(|(_, line)| line.is_in(panel));
        for (count, (place, line)) in here.enumerate() {
            ui.horizontal(|ui| {
                line.series.edit(ui, &format!("line of your own {}", count + 1), "A line in this chart");
                let remove = ui.add(Button::new("✖").small());
                remove.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Remove line {}", count + 1)));
                if remove.on_hover_text("Remove this line").clicked() {
                    gone = Some(place);
                }
            });
            if let Some(Err(problem)) = &line.drawn {
                ui.label(RichText::new(format!("{problem}.")).size(SMALL).color(Palette::in_ui(ui).error));
            }
        }
        if let Some(place) = gone {
            self.lines.remove(place);
        }
        if ui.button("Add a line").clicked() {
            self.add(panel, OwnSeries::default());
        }
        ui.separator();
    }
}

/// An ink that no line of the panel looks like: with a dash of its own as long as there is one.
fn free_ink(panel: &Panel) -> Ink {
    let used: Vec<_> = panel.marks.iter().filter_map(|mark| mark.entry()).map(|entry| entry.key).collect();
    let is_free = |ink: &Ink| !used.iter().any(|key| matches!(key, Key::Line(_, dash, ..) if *dash == ink.dash()));
    let is_other = |ink: &Ink| !used.iter().any(|key| key.ink() == *ink);
    let inks = || (0..INKS).map(Ink::Series);
    inks().find(is_free).or_else(|| inks().find(is_other)).unwrap_or(Ink::Text)
}
