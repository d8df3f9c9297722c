//! The arm at the cursor, with measured and predicted torque as arcs about the joints.

use egui::{Align2, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2};

use super::export;
use crate::app::theme::{MEASURED_DASH, PREDICTED_DASH, Palette, RADIUS, SMALL};
use crate::arm::Arm;
use crate::figure::mark::{Arrow, Line, Points};
use crate::figure::{Axis, Ink, Panel};

/// An arc of the largest torque goes this far about its joint \[rad\].
const LARGEST_ARC: f32 = 4.5;

/// Points of an exported arc.
const ARC_POINTS: usize = 40;

/// What is drawn.
pub struct Pose<'a> {
    /// When \[s\].
    pub time: f64,
    /// Geometry and posture; masses do not matter.
    pub arm: &'a Arm,
    /// Joint positions \[rad\].
    pub q: &'a [f64],
    /// Measured torque by joint \[N m\].
    pub measured: &'a [f64],
    /// Predicted torque by joint \[N m\]; empty without a model.
    pub predicted: &'a [f64],
    /// Largest torque of each joint, which fixes the scale of its arcs \[N m\].
    pub largest: &'a [f64],
    /// Where the tip goes \[m\].
    pub path: &'a [[f64; 2]],
}

/// Draws the arm into a square of this height over the full width.
pub fn show(ui: &mut Ui, pose: &Pose, height: f32) {
    let palette = Palette::in_ui(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
    export::offer(ui, &response, || panel(pose));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, "the arm at the time cursor"));
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 4, palette.canvas);
    if response.has_focus() {
        painter.rect_stroke(rect, RADIUS, Stroke::new(1.5, palette.accent), egui::StrokeKind::Inside);
    }
    let reach: f64 = pose.arm.links.iter().map(|link| link.length).sum();
    let scale = (0.5 * rect.width().min(rect.height()) - 26.0) / reach.max(1e-9) as f32;
    let to_screen = |[x, z]: [f64; 2]| -> Pos2 { rect.center() + vec2(x as f32 * scale, -z as f32 * scale) };
    painter.circle_stroke(rect.center(), reach as f32 * scale, Stroke::new(1.0, palette.grid));
    painter.hline(rect.x_range(), rect.center().y, Stroke::new(1.0, palette.grid));
    let base = Rect::from_center_size(rect.center() + vec2(0.0, 9.0), vec2(30.0, 8.0));
    painter.rect_filled(base, 2, palette.border);

    let path: Vec<Pos2> = pose.path.iter().copied().map(to_screen).collect();
    painter.add(Shape::line(path, Stroke::new(1.0, palette.weak.gamma_multiply(0.5))));
    let points: Vec<Pos2> = pose.arm.points(pose.q).into_iter().map(to_screen).collect();
    for (link, ends) in points.windows(2).enumerate() {
        let (color, _) = palette.nth(link);
        painter.line_segment([ends[0], ends[1]], Stroke::new(7.0, palette.card.lerp_to_gamma(color, 0.75)));
    }
    let sign = pose.arm.posture.sign() as f32;
    for (joint, at) in points.iter().enumerate().take(pose.q.len()) {
        painter.circle(*at, 6.0, palette.card, Stroke::new(2.0, palette.nth(joint).0));
        let largest = pose.largest.get(joint).copied().unwrap_or(1.0).max(1e-12);
        let arc = |torques: &[f64], radius: f32, color, dash: &[f32]| {
            if let Some(torque) = torques.get(joint) {
                let angle = sign * (torque / largest).clamp(-1.0, 1.0) as f32 * LARGEST_ARC;
                draw_arc(&painter, *at, radius, angle, Stroke::new(2.5, color), dash);
            }
        };
        arc(pose.measured, 13.0, palette.measured, MEASURED_DASH);
        arc(pose.predicted, 18.0, palette.predicted, PREDICTED_DASH);
    }
    if let Some(tip) = points.last() {
        painter.circle_filled(*tip, 4.0, palette.text);
    }
    let font = FontId::proportional(SMALL);
    painter.text(rect.left_bottom() + vec2(8.0, -6.0), Align2::LEFT_BOTTOM, "g ↓", font, palette.weak);
}

/// The same as data, in metres: the arcs of a joint are as long as its torques, the largest of the trajectory is
/// [`LARGEST_ARC`].
fn panel(pose: &Pose) -> Panel {
    let reach: f64 = pose.arm.links.iter().map(|link| link.length).sum::<f64>().max(1e-9);
    let axis = |label: &str| Axis::new(label, "m").range([-1.12 * reach, 1.12 * reach]);
    let title = format!("the arm at t = {:.2} s", pose.time);
    let mut panel = Panel::new(title, [axis("x"), axis("z")]).aspect(1.0);
    panel.push(Line::path("path of the tip", pose.path.to_vec(), Ink::Text));
    let points = pose.arm.points(pose.q);
    for (link, ends) in points.windows(2).enumerate() {
        panel.push(Line::path(format!("link {}", link + 1), ends.to_vec(), Ink::Series(link)).width(5.0));
    }
    let sign = pose.arm.posture.sign();
    for (joint, [x, z]) in points.iter().copied().enumerate().take(pose.q.len()) {
        let largest = pose.largest.get(joint).copied().unwrap_or(1.0).max(1e-12);
        let arcs =
            [("measured τ", pose.measured, 0.09, Ink::Measured), ("predicted τ̂", pose.predicted, 0.13, Ink::Predicted)];
        for (name, torques, radius, ink) in arcs {
            let Some(torque) = torques.get(joint) else { continue };
            let whole = sign * (torque / largest).clamp(-1.0, 1.0) * f64::from(LARGEST_ARC);
            let at = |n: usize| {
                let angle = whole * n as f64 / ARC_POINTS as f64;
                [x + radius * reach * angle.cos(), z + radius * reach * angle.sin()]
            };
            panel.push(Line::path(name, (0..=ARC_POINTS).map(at), ink));
            panel.push(Arrow { ends: [at(ARC_POINTS - 1), at(ARC_POINTS)], ink });
        }
    }
    panel.with(Points::new("", points, Ink::Text))
}

/// An arc that begins at the right of `center`, counter-clockwise for positive angles, with an arrow head at its end.
fn draw_arc(painter: &egui::Painter, center: Pos2, radius: f32, angle: f32, stroke: Stroke, dash: &[f32]) {
    if angle.abs() < 0.02 {
        return;
    }
    let count = 4 + (angle.abs() * 10.0) as usize;
    let on_arc = |angle: f32| center + radius * vec2(angle.cos(), -angle.sin());
    let points: Vec<Pos2> = (0..=count).map(|n| on_arc(angle * n as f32 / count as f32)).collect();
    match dash {
        [ink, gap, ..] => painter.extend(Shape::dashed_line(&points, stroke, *ink, *gap)),
        _ => drop(painter.line(points, stroke)),
    }
    let tip = on_arc(angle);
    let along = Vec2::new(-angle.sin(), -angle.cos()) * angle.signum();
    let across = pos2(-along.y, along.x).to_vec2();
    let head = vec![tip + along * 5.0, tip + across * 3.5, tip - across * 3.5];
    painter.add(Shape::convex_polygon(head, stroke.color, Stroke::NONE));
}
