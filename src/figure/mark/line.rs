//! A line through samples: of a clock, of a curve, or anywhere in the plane.

use super::{Entry, Key, Mark, Reach, Row};
use crate::figure::axis::{Axis, Scale};
use crate::figure::canvas::{Canvas, Fill, Stroke};
use crate::figure::colours::{Dash, Ink};
use crate::figure::decimate::{self, Sight};
use crate::figure::place::{Place, is_finite};
use crate::figure::shared::Shared;
use crate::figure::tex::{Drawn, Paper, coordinates};

/// Width of what lies wide and pale under other lines, and how much of its colour it has.
const WIDE: f64 = 2.4;
const PALE: f64 = 0.4;

/// A line.
#[derive(Debug, Clone)]
pub struct Line {
    /// In tables, and in the legend.
    pub name: String,
    /// Where.
    pub x: Shared<f64>,
    /// How high.
    pub y: Shared<f64>,
    /// Colour.
    pub ink: Ink,
    /// How it is broken.
    pub dash: Dash,
    /// Width relative to the usual.
    pub width: f64,
    /// Between 0 and 1.
    pub opacity: f64,
    /// How its points follow each other.
    pub course: Course,
    /// The name in the legend that it shares with others; its own if `None`.
    pub together: Option<&'static str>,
}

/// How the points of a line follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Course {
    /// Samples of a clock: x ascends, a jump of it is a gap.
    Sampled,
    /// x ascends, at any distances.
    #[default]
    Ascending,
    /// Anywhere, such as the path of a tool.
    Free,
}

impl Line {
    /// A line of usual width over ascending x, at any distances.
    pub fn new(name: impl Into<String>, x: impl Into<Shared<f64>>, y: impl Into<Shared<f64>>, ink: Ink) -> Self {
        let (x, y, course) = (x.into(), y.into(), Course::Ascending);
        Line { name: name.into(), x, y, ink, dash: ink.dash(), width: 1.0, opacity: 1.0, course, together: None }
    }

    /// A line through points of ascending x.
    pub fn through(name: impl Into<String>, points: impl IntoIterator<Item = [f64; 2]>, ink: Ink) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().map(|[x, y]| (x, y)).unzip();
        Line::new(name, x, y, ink)
    }

    /// A path through the plane, such as that of a tool.
    pub fn path(name: impl Into<String>, points: impl IntoIterator<Item = [f64; 2]>, ink: Ink) -> Self {
        Line { course: Course::Free, ..Line::through(name, points, ink) }
    }

    /// The same as samples of a clock.
    #[must_use]
    pub fn sampled(mut self) -> Self {
        self.course = Course::Sampled;
        self
    }

    /// The same, so much wider than usual.
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    /// The same, so much of its colour: 1 for all.
    #[must_use]
    pub fn opacity(mut self, opacity: f64) -> Self {
        self.opacity = opacity;
        self
    }

    /// The same with another dash.
    #[must_use]
    pub fn dash(mut self, dash: Dash) -> Self {
        self.dash = dash;
        self
    }

    /// The same in another ink, broken as that is.
    #[must_use]
    pub fn ink(mut self, ink: Ink) -> Self {
        (self.ink, self.dash) = (ink, ink.dash());
        self
    }

    /// The same, wide and pale: the truth, under what a model has of it.
    #[must_use]
    pub fn wide_and_pale(self) -> Self {
        self.width(WIDE).opacity(PALE)
    }

    /// The same in the legend under a name for several lines, which are hidden and shown together.
    #[must_use]
    pub fn together(mut self, name: &'static str) -> Self {
        self.together = Some(name);
        self
    }

    fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.x.iter().zip(self.y.iter()).map(|(x, y)| [*x, *y])
    }

    /// On the page, split at its holes and thinned to what can be seen.
    fn pieces(&self, place: &Place, canvas: &mut dyn Canvas) -> Vec<Vec<[f64; 2]>> {
        let columns = (place.plot.width * canvas.fineness()) as usize;
        let gaps = self.course == Course::Sampled;
        let [across, up] = place.axes;
        match (self.course, &across.scale) {
            (Course::Free, _) => {
                let points: Vec<[f64; 2]> = self.points().map(|point| place.point(point)).collect();
                points.split(|point| !is_finite(point)).filter(|run| !run.is_empty()).map(<[_]>::to_vec).collect()
            }
            (_, Scale::Logarithmic) => {
                let points = self.points().map(|[x, y]| (across.measure(x), up.measure(y)));
                let (x, y): (Vec<f64>, Vec<f64>) = points.filter(|(x, _)| x.is_finite()).unzip();
                let sight = Sight { range: place.ranges[0], columns, gaps, positive: false };
                let on_page = |[x, y]: [f64; 2]| [place.along(0, x), place.along(1, y)];
                decimate::pieces(&x, &y, sight)
                    .into_iter()
                    .map(|piece| piece.into_iter().map(on_page).collect())
                    .collect()
            }
            _ => {
                let positive = up.scale == Scale::Logarithmic;
                let sight = Sight { range: place.ranges[0], columns, gaps, positive };
                let pieces = canvas.decimator().line(&self.x, &self.y, sight);
                let on_page = |piece: &Vec<[f64; 2]>| piece.iter().map(|point| place.point(*point)).collect();
                pieces.iter().map(on_page).collect()
            }
        }
    }
}

impl Mark for Line {
    fn reach(&self, reach: &mut Reach) {
        match (self.course, reach.which) {
            (Course::Free, _) => {
                let points: Vec<[f64; 2]> = self.points().collect();
                reach.take_points(&points);
            }
            (_, 0) => reach.take_all(self.x.first().into_iter().chain(self.x.last()).copied()),
            (course, _) => {
                let pieces = reach.pieces(&self.x, &self.y, course == Course::Sampled);
                reach.take_all(pieces.iter().flatten().map(|[_, y]| *y));
            }
        }
    }

    fn entry(&self) -> Option<Entry<'_>> {
        let name = self.together.unwrap_or(&self.name);
        Some(Entry { name, key: Key::Line(self.ink, self.dash, self.opacity, self.width) })
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn draw(&self, place: &Place, canvas: &mut dyn Canvas) {
        let color = canvas.colours().of(self.ink);
        let stroke = Stroke { color, opacity: self.opacity, width: self.width * canvas.usual(), dash: self.dash };
        for piece in self.pieces(place, canvas) {
            match piece.as_slice() {
                [_] => canvas.dots(&piece, stroke.width, &Fill { color, opacity: self.opacity }),
                _ => canvas.polyline(&piece, &stroke),
            }
        }
    }

    fn kind(&self) -> &'static str {
        "line"
    }

    fn rows(&self, x: &Axis, write: &mut dyn FnMut(Row)) {
        let shown = |point: &[f64; 2]| x.range.is_none_or(|[from, to]| (from..=to).contains(&point[0]));
        self.points().filter(shown).for_each(|point| write(Row::point(&self.name, point)));
    }

    fn pgfplots(&self, rows: &[Row], paper: &Paper) -> Drawn {
        let points: Vec<[f64; 2]> = rows.iter().map(|row| [row.x, row.y]).collect();
        // Dashes are told for lines of the screen; on paper they are half as long.
        let pairs = self.dash.chunks_exact(2).map(|pair| format!("on {}pt off {}pt", pair[0] / 2.0, pair[1] / 2.0));
        let pattern = pairs.collect::<Vec<_>>().join(" ");
        let dashed = if pattern.is_empty() { String::new() } else { format!(", dash pattern={pattern}") };
        let stroke = format!("line width={:.2}pt, opacity={}{dashed}", 0.7 * self.width, self.opacity);
        Drawn::Plot(stroke, coordinates(&paper.thinned(&points)))
    }

    fn matplotlib(&self) -> &'static str {
        "ax.plot(x, y, label=name or None, linewidth=LINE)"
    }

    fn value_at(&self, x: f64) -> Option<f64> {
        let on_line = self.course != Course::Free;
        on_line.then(|| self.y.get(nearest(&self.x, x)).copied()).flatten().filter(|value| value.is_finite())
    }

    fn mean_and_rms(&self, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let len = self.x.len().min(self.y.len());
        let x = &self.x[..len];
        let samples = x.partition_point(|x| *x < from)..x.partition_point(|x| *x <= to);
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for value in self.y.get(samples)?.iter().filter(|value| value.is_finite()) {
            (count, sum, squares) = (count + 1.0, sum + value, squares + value * value);
        }
        (count > 0.0 && self.course != Course::Free).then(|| [sum / count, (squares / count).sqrt()])
    }
}

/// The sample of ascending `x` that is nearest to `at`; 0 if there is none.
pub fn nearest(x: &[f64], at: f64) -> usize {
    let after = x.partition_point(|x| *x < at);
    let before = after.saturating_sub(1);
    let distance = |sample: usize| x.get(sample).map_or(f64::INFINITY, |x| (x - at).abs());
    if distance(before) <= distance(after) { before } else { after }
}
