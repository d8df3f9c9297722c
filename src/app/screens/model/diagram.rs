//! The structure of a model as a drawing: what goes into each term, the layers of its networks with their sizes, and the sum.

use egui::{Align2, FontId, Painter, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, pos2, vec2};

use crate::app::plot::export;
use crate::app::theme::{Palette, RADIUS, SMALL};
use crate::figure::mark::{Arrow, Frame, Line, Word};
use crate::figure::{Axis, Ink, Panel};
use crate::model::learned::{Layers, LearnedTerm};
use crate::model::{Model, Term};

/// Height of one line of boxes \[points\].
const ROW: f32 = 46.0;
/// Width of the boxes at both ends \[points\].
const END: f32 = 46.0;
/// Between boxes of a line \[points\].
const GAP: f32 = 16.0;
/// Radius of the sum \[points\].
const SUM: f32 = 12.0;
/// Width for which an exported drawing is laid out \[points\].
const EXPORTED: f32 = 760.0;

/// One line from the motion to the sum: boxes with a title and, below it, a size.
struct Lane {
    boxes: Vec<[String; 2]>,
    term: usize,
}

/// A box with lines of text.
struct Node {
    place: Rect,
    lines: Vec<String>,
    ink: Ink,
}

/// Everything with its place, from the corner at the left and top.
struct Drawing {
    size: Vec2,
    nodes: Vec<Node>,
    wires: Vec<[Pos2; 2]>,
    sum: Pos2,
}

impl Drawing {
    fn new(model: &Model, joints: usize, width: f32) -> Self {
        let lanes: Vec<Lane> =
            model.terms.iter().enumerate().flat_map(|(place, term)| lanes(term, place, joints)).collect();
        let height = lanes.len().max(2) as f32 * ROW + 8.0;
        let input = Rect::from_min_size(pos2(0.0, 4.0), vec2(END, height - 8.0));
        let sum = pos2(width - END - 34.0, 0.5 * height);
        let output = Rect::from_center_size(pos2(width - END / 2.0, sum.y), vec2(END, ROW - 10.0));
        let motion = ["q", "q̇", "q̈"].map(str::to_owned).to_vec();
        let mut nodes = vec![Node { place: input, lines: motion, ink: Ink::Text }];
        let mut wires = Vec::new();
        for (number, lane) in lanes.iter().enumerate() {
            let y = 4.0 + ROW * (number as f32 + 0.5) + (height - 8.0 - ROW * lanes.len() as f32) / 2.0;
            let (left, right) = (input.right() + 22.0, sum.x - 46.0);
            let count = lane.boxes.len() as f32;
            let width = (right - left - GAP * (count - 1.0)) / count;
            let mut from = pos2(input.right(), y);
            for (column, [title, size]) in lane.boxes.iter().enumerate() {
                let corner = pos2(left + column as f32 * (width + GAP), y - ROW / 2.0 + 5.0);
                let place = Rect::from_min_size(corner, vec2(width, ROW - 10.0));
                wires.push([from, place.left_center()]);
                let lines = [title, size].into_iter().filter(|line| !line.is_empty()).cloned().collect();
                nodes.push(Node { place, lines, ink: Ink::Series(lane.term) });
                from = place.right_center();
            }
            wires.push([from, sum - (sum - from).normalized() * (SUM + 1.0)]);
        }
        wires.push([sum + vec2(SUM, 0.0), output.left_center()]);
        nodes.push(Node { place: output, lines: vec!["τ̂".to_owned(), joints.to_string()], ink: Ink::Predicted });
        Drawing { size: vec2(width, height), nodes, wires, sum }
    }

    fn paint(&self, painter: &Painter, palette: &Palette, corner: Vec2) {
        let wire = Stroke::new(1.2, palette.weak);
        self.wires.iter().for_each(|[from, to]| arrow(painter, *from + corner, *to + corner, wire));
        self.nodes.iter().for_each(|node| node.paint(painter, palette, corner));
        painter.circle(self.sum + corner, SUM, palette.canvas, Stroke::new(1.4, palette.text));
        let font = FontId::proportional(SMALL + 4.0);
        painter.text(self.sum + corner, Align2::CENTER_CENTER, "+", font, palette.text);
    }

    /// The same as data.
    fn panel(&self) -> Panel {
        let Vec2 { x: width, y: height } = self.size;
        let point = |at: Pos2| [f64::from(at.x), f64::from(height - at.y)];
        // The edges of boxes at the border have a width, too.
        let axis = |size: f32| Axis::default().range([-2.0, f64::from(size) + 2.0]);
        let aspect = f64::from(height / width);
        let mut panel = Panel::new("structure of the model", [axis(width), axis(height)]).aspect(aspect).bare();
        panel = panel.with_all(self.wires.iter().map(|ends| Arrow { ends: ends.map(point), ink: Ink::Text }));
        for Node { place, lines, ink } in &self.nodes {
            let [left, low] = point(place.left_bottom());
            let [right, high] = point(place.right_top());
            panel.push(Frame { sides: [[left, right], [low, high]], ink: *ink });
            let room = right - left - 6.0;
            let words = lines.iter().zip(line_heights(lines.len()));
            panel = panel.with_all(words.map(|(text, down)| {
                let at = point(place.center() + vec2(0.0, down));
                Word { text: text.clone(), at, room, ink: Ink::Text }
            }));
        }
        let around = (0..=48).map(|n| Vec2::angled(std::f32::consts::TAU * n as f32 / 48.0) * SUM);
        panel.push(Line::path("", around.map(|way| point(self.sum + way)), Ink::Measured));
        let (at, room) = (point(self.sum), f64::from(SUM));
        panel.push(Word { text: "+".to_owned(), at, room, ink: Ink::Text });
        panel
    }
}

/// How far below the middle of a box each of its lines stands.
fn line_heights(count: usize) -> impl Iterator<Item = f32> {
    (0..count).map(move |line| 14.0 * (line as f32 - 0.5 * (count as f32 - 1.0)))
}

/// Draws the model over the full width.
pub fn show(ui: &mut Ui, model: &Model, joints: usize) {
    let palette = Palette::in_ui(ui);
    let drawing = Drawing::new(model, joints, ui.available_width());
    let (rect, response) = ui.allocate_exact_size(drawing.size, Sense::click());
    let labels: Vec<String> = model.terms.iter().map(Term::label).collect();
    let spoken = format!("structure of the model: the sum of {}", labels.join(", "));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, &spoken));
    export::offer(ui, &response, || Drawing::new(model, joints, EXPORTED).panel());
    let painter = ui.painter().with_clip_rect(rect.expand(2.0));
    drawing.paint(&painter, palette, rect.min.to_vec2());
    if response.has_focus() {
        painter.rect_stroke(rect, RADIUS, Stroke::new(1.5, palette.accent), StrokeKind::Inside);
    }
}

/// The boxes of a term; a structured Lagrangian has two networks, so two lines.
fn lanes(term: &Term, place: usize, joints: usize) -> Vec<Lane> {
    let lane = |boxes: Vec<[String; 2]>| Lane { boxes, term: place };
    let named = |title: &str, size: String| [title.to_owned(), size];
    let features = |sum: usize, text: &str| named(text, sum.to_string());
    let hidden = |layers: &Layers| {
        let activation = format!("{:?}", layers.activation).to_lowercase();
        layers.hidden.iter().map(move |width| [activation.clone(), width.to_string()]).collect::<Vec<_>>()
    };
    let chain = |first: [String; 2], layers: &Layers, last: Vec<[String; 2]>| {
        lane([first].into_iter().chain(hidden(layers)).chain(last).collect())
    };
    let lagrange = || named("d/dt ∂L/∂q̇ − ∂L/∂q", joints.to_string());
    match term {
        Term::RigidBody(_) | Term::Effect(_) => vec![lane(vec![named(&term.label(), String::new())])],
        Term::Learned(LearnedTerm::StructuredLagrangian { layers, .. }) => {
            let triangle = (joints * (joints + 1) / 2).to_string();
            let mass = vec![named("L", triangle), named("H = L Lᵀ", format!("{joints}×{joints}")), lagrange()];
            let potential = vec![named("V", "1".to_owned()), named("∂V/∂q", joints.to_string())];
            let angles = || features(2 * joints, "cos q, sin q");
            vec![chain(angles(), layers, mass), chain(angles(), layers, potential)]
        }
        Term::Learned(LearnedTerm::BlackBoxLagrangian { layers }) => {
            let last = vec![named("L", "1".to_owned()), lagrange()];
            vec![chain(features(3 * joints, "cos q, sin q, q̇"), layers, last)]
        }
        Term::Learned(LearnedTerm::FeedForward { layers, .. }) => {
            let last = vec![named("τ", joints.to_string())];
            vec![chain(features(4 * joints, "cos q, sin q, q̇, q̈"), layers, last)]
        }
        Term::Learned(LearnedTerm::Friction) => vec![lane(vec![named("friction", format!("4 × {joints}"))])],
        Term::Learned(LearnedTerm::Columns { names }) => {
            vec![lane(vec![named("effects", names.len().to_string())])]
        }
    }
}

impl Node {
    fn paint(&self, painter: &Painter, palette: &Palette, corner: Vec2) {
        let place = self.place.translate(corner);
        painter.rect_filled(place, 4, palette.canvas);
        painter.rect_stroke(place, 4, Stroke::new(1.2, palette.color(self.ink)), StrokeKind::Inside);
        // A box too narrow for its title has a smaller one.
        let fits = |points: &f32| {
            let title = self.lines[0].clone();
            let galley = painter.layout_no_wrap(title, FontId::proportional(*points), palette.text);
            galley.size().x <= place.width() - 4.0
        };
        let points = [SMALL, SMALL - 2.0].into_iter().find(fits).unwrap_or(SMALL - 4.0);
        for (text, down) in self.lines.iter().zip(line_heights(self.lines.len())) {
            let at = place.center() + vec2(0.0, down);
            painter.text(at, Align2::CENTER_CENTER, text, FontId::proportional(points), palette.text);
        }
    }
}

fn arrow(painter: &Painter, from: Pos2, to: Pos2, stroke: Stroke) {
    painter.line_segment([from, to], stroke);
    let along = (to - from).normalized();
    let across = vec2(-along.y, along.x);
    let head = vec![to, to - along * 6.0 + across * 3.0, to - along * 6.0 - across * 3.0];
    painter.add(egui::Shape::convex_polygon(head, stroke.color, Stroke::NONE));
}
