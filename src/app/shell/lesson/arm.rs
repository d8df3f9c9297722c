//! The arm in a state that one makes: its joints are dragged, speeds and accelerations are typed or slid, and the three parts of the
//! torque that it needs are bars.

use egui::{DragValue, Grid, Pos2, Rect, RichText, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};

use crate::app::plot::ticks;
use crate::app::theme::{GAP, Palette, SMALL};
use crate::arm::Arm;
use crate::lesson::Parts;
use crate::session::Session;
use crate::session::study::Pose;

/// Height of the drawing and of a bar \[points\].
const HEIGHT: f32 = 190.0;
const BAR: f32 = 9.0;
/// Where the arm begins, so that nothing is asked for that is there already.
const FIRST: [f64; 3] = [0.5, -0.9, 0.6];
/// Fastest and hardest that can be entered \[rad/s, rad/s²\].
const MOST: [f64; 2] = [12.0, 60.0];

pub fn show(ui: &mut Ui, session: &Session, pose: &mut Pose) {
    let Some(arm) = session.recording.as_ref().and_then(|recording| recording.stated_arm.as_ref()) else { return };
    let joints = arm.joint_count();
    if pose.q.len() != joints {
        *pose = first(joints);
    }
    drawing(ui, arm, pose);
    entries(ui, pose);
    if let Some(parts) = Parts::of(arm, pose) {
        bars(ui, &parts);
    }
    ui.add_space(GAP);
}

fn first(joints: usize) -> Pose {
    let q = FIRST.iter().copied().chain(std::iter::repeat(0.0)).take(joints).collect();
    Pose { q, qd: vec![0.0; joints], qdd: vec![0.0; joints] }
}

/// The arm, whose joints turn as their links are dragged.
fn drawing(ui: &mut Ui, arm: &Arm, pose: &mut Pose) {
    let palette = Palette::in_ui(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, "the arm that you pose"));
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 4, palette.canvas);
    let reach: f64 = arm.links.iter().map(|link| link.length).sum();
    let scale = 0.46 * HEIGHT / reach as f32;
    let at = |point: [f64; 2]| rect.center() + vec2(point[0] as f32, -point[1] as f32) * scale;
    painter.hline(rect.x_range(), rect.center().y, Stroke::new(1.0, palette.grid));
    let points = arm.points(&pose.q);
    for (link, ends) in points.windows(2).enumerate() {
        let (color, _) = palette.nth(link);
        painter.line_segment([at(ends[0]), at(ends[1])], Stroke::new(6.0, palette.card.lerp_to_gamma(color, 0.75)));
        painter.circle(at(ends[0]), 4.5, palette.card, Stroke::new(2.0, color));
    }
    for link in 0..arm.joint_count() {
        let (pivot, tip) = (at(points[link]), at(points[link + 1]));
        if let Some(turned) = handle(ui, link, pivot, tip) {
            let angle = pose.q[link] + arm.posture.sign() * turned;
            pose.q[link] = wrapped(angle);
        }
    }
}

/// The end of a link, and by how much it was turned about its pivot in this frame, counter-clockwise \[rad\].
fn handle(ui: &Ui, link: usize, pivot: Pos2, tip: Pos2) -> Option<f64> {
    let palette = Palette::in_ui(ui);
    let area = Rect::from_center_size(tip, Vec2::splat(18.0));
    let response = ui.interact(area, ui.scope_id().with(("turn", link)), Sense::drag());
    let spoken = format!("turn joint {}", link + 1);
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Slider, true, &spoken));
    let lit = response.hovered() || response.dragged();
    let fill = if lit { palette.accent } else { palette.text };
    ui.painter().circle(tip, 6.0, fill, Stroke::new(1.5, palette.card));
    let moved = response.dragged().then(|| response.drag_delta());
    response.on_hover_text("Drag it about its joint");
    let (before, after) = (tip - pivot, tip + moved? - pivot);
    // Up is negative on the screen.
    Some(f64::from(-wrapped_f32(after.angle() - before.angle())))
}

fn wrapped_f32(angle: f32) -> f32 {
    wrapped(f64::from(angle)) as f32
}

/// Between −π and π.
fn wrapped(angle: f64) -> f64 {
    (angle + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}

fn entries(ui: &mut Ui, pose: &mut Pose) {
    let weak = Palette::in_ui(ui).weak;
    Grid::new("pose").spacing([8.0, 4.0]).show(ui, |ui| {
        for title in ["", "q [rad]", "q̇ [rad/s]", "q̈ [rad/s²]"] {
            ui.label(RichText::new(title).size(SMALL).color(weak));
        }
        ui.end_row();
        for joint in 0..pose.q.len() {
            ui.label(format!("joint {}", joint + 1));
            let fields = [
                ("position", &mut pose.q[joint], std::f64::consts::PI, 0.01),
                ("speed", &mut pose.qd[joint], MOST[0], 0.05),
                ("acceleration", &mut pose.qdd[joint], MOST[1], 0.1),
            ];
            for (name, value, most, speed) in fields {
                let field = ui.add(DragValue::new(value).speed(speed).range(-most..=most).max_decimals(2));
                let spoken = format!("{name} of joint {}", joint + 1);
                field.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, &spoken));
            }
            ui.end_row();
        }
    });
    ui.horizontal_wrapped(|ui| {
        let mut scale =
            |factor: f64| pose.qd.iter_mut().for_each(|speed| *speed = (*speed * factor).clamp(-MOST[0], MOST[0]));
        if ui.small_button("Double all speeds").clicked() {
            scale(2.0);
        }
        if ui.small_button("Halve them").clicked() {
            scale(0.5);
        }
        if ui.small_button("At rest").clicked() {
            pose.qd.fill(0.0);
            pose.qdd.fill(0.0);
        }
    });
    ui.add_space(4.0);
}

/// Inertial, Coriolis and gravity torque of each joint, in the colours that they have wherever torque is taken apart.
fn bars(ui: &mut Ui, parts: &Parts) {
    let palette = Palette::in_ui(ui);
    let all = [("inertial", &parts.inertial), ("Coriolis", &parts.coriolis), ("gravity", &parts.gravity)];
    let largest =
        all.iter().flat_map(|(_, part)| part.iter()).fold(1.0, |largest: f64, value| largest.max(value.abs()));
    ui.horizontal_wrapped(|ui| {
        for (number, (name, _)) in all.iter().enumerate() {
            ui.label(RichText::new(format!("■ {name}")).size(SMALL).color(palette.nth(number).0));
        }
        ui.label(RichText::new("torque [N m]").size(SMALL).color(palette.weak));
    });
    for joint in 0..parts.gravity.len() {
        ui.horizontal(|ui| {
            ui.label(format!("joint {}", joint + 1));
            ui.vertical(|ui| {
                ui.spacing_mut().item_spacing.y = 1.0;
                for (number, (name, part)) in all.iter().enumerate() {
                    bar(
                        ui,
                        &format!("{name} torque of joint {}", joint + 1),
                        part[joint],
                        largest,
                        palette.nth(number).0,
                    );
                }
            });
        });
    }
}

/// A bar to the right for what is positive, and to the left for what is negative, with its number.
fn bar(ui: &mut Ui, name: &str, value: f64, largest: f64, color: egui::Color32) {
    let palette = Palette::in_ui(ui);
    ui.horizontal(|ui| {
        let width = (ui.available_width() - 62.0).max(60.0);
        let (rect, response) = ui.allocate_exact_size(vec2(width, BAR), Sense::hover());
        let middle = rect.center().x;
        let end = middle + 0.5 * width * (value / largest) as f32;
        ui.painter().rect_filled(rect, 2, palette.grid);
        let filled = Rect::from_two_pos(Pos2::new(middle, rect.top()), Pos2::new(end, rect.bottom()));
        ui.painter().rect_filled(filled, 2, color);
        let number = ticks::number(value);
        response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, format!("{name}: {number} N m")));
        ui.label(RichText::new(number).size(SMALL));
    });
}
