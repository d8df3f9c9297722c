//! The structure of a model as a drawing: what goes into each term, the layers of its networks with their sizes, and the sum.

use egui::{Align2, FontId, Painter, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};

use crate::app::theme::{Palette, SMALL};
use crate::model::learned::{Layers, LearnedTerm};
use crate::model::{Model, Term};

/// Height of one line of boxes \[points\].
const ROW: f32 = 46.0;
/// Width of the boxes at both ends \[points\].
const END: f32 = 46.0;

/// One line from the motion to the sum: boxes with a title and, below it, a size.
struct Lane {
    boxes: Vec<[String; 2]>,
    term: usize,
}

/// Draws the model over the full width.
pub fn show(ui: &mut Ui, model: &Model, joints: usize) {
    let palette = Palette::in_ui(ui);
    let lanes: Vec<Lane> =
        model.terms.iter().enumerate().flat_map(|(place, term)| lanes(term, place, joints)).collect();
    let height = lanes.len().max(2) as f32 * ROW + 8.0;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    let labels: Vec<String> = model.terms.iter().map(Term::label).collect();
    let spoken = format!("structure of the model: the sum of {}", labels.join(", "));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, &spoken));
    let painter = ui.painter().with_clip_rect(rect);
    let wire = Stroke::new(1.2, palette.weak);
    let input = Rect::from_min_size(rect.min + vec2(0.0, 4.0), vec2(END, height - 8.0));
    node(&painter, palette, input, "q\nq̇\nq̈", "", palette.text);
    let sum = pos2(rect.right() - END - 34.0, rect.center().y);
    let output = Rect::from_center_size(pos2(rect.right() - END / 2.0, sum.y), vec2(END, ROW - 10.0));
    for (number, lane) in lanes.iter().enumerate() {
        let y = rect.top() + 4.0 + ROW * (number as f32 + 0.5) + (height - 8.0 - ROW * lanes.len() as f32) / 2.0;
        let (left, right) = (input.right() + 22.0, sum.x - 46.0);
        let count = lane.boxes.len() as f32;
        let width = (right - left - 16.0 * (count - 1.0)) / count;
        let mut from = pos2(input.right(), y);
        for (column, [title, size]) in lane.boxes.iter().enumerate() {
            let corner = pos2(left + column as f32 * (width + 16.0), y - ROW / 2.0 + 5.0);
            let place = Rect::from_min_size(corner, vec2(width, ROW - 10.0));
            arrow(&painter, from, place.left_center(), wire);
            node(&painter, palette, place, title, size, palette.nth(lane.term).0);
            from = place.right_center();
        }
        let direction = (sum - from).normalized();
        arrow(&painter, from, sum - direction * 13.0, wire);
    }
    painter.circle(sum, 12.0, palette.canvas, Stroke::new(1.4, palette.text));
    painter.text(sum, Align2::CENTER_CENTER, "+", FontId::proportional(SMALL + 4.0), palette.text);
    arrow(&painter, sum + vec2(12.0, 0.0), output.left_center(), wire);
    node(&painter, palette, output, "τ̂", &joints.to_string(), palette.predicted);
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

fn node(painter: &Painter, palette: &Palette, rect: Rect, title: &str, size: &str, color: egui::Color32) {
    painter.rect_filled(rect, 4, palette.canvas);
    painter.rect_stroke(rect, 4, Stroke::new(1.2, color), StrokeKind::Inside);
    // A box too narrow for its title has a smaller one.
    let fits = |points: &f32| {
        let galley = painter.layout_no_wrap(title.to_owned(), FontId::proportional(*points), palette.text);
        galley.size().x <= rect.width() - 4.0
    };
    let points = [SMALL, SMALL - 2.0].into_iter().find(fits).unwrap_or(SMALL - 4.0);
    let font = || FontId::proportional(points);
    let line = if size.is_empty() { 0.0 } else { 7.0 };
    painter.text(rect.center() - vec2(0.0, line), Align2::CENTER_CENTER, title, font(), palette.text);
    if !size.is_empty() {
        painter.text(rect.center() + vec2(0.0, line), Align2::CENTER_CENTER, size, font(), palette.weak);
    }
}

fn arrow(painter: &Painter, from: Pos2, to: Pos2, stroke: Stroke) {
    painter.line_segment([from, to], stroke);
    let along = (to - from).normalized();
    let across = vec2(-along.y, along.x);
    let head = vec![to, to - along * 6.0 + across * 3.0, to - along * 6.0 - across * 3.0];
    painter.add(egui::Shape::convex_polygon(head, stroke.color, Stroke::NONE));
}
