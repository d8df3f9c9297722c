//! The arm as a drawing that is edited by hand: the end of a link drags its length, its disc drags its mass. Its first link points
//! where it does at q = 0.

use egui::{Align2, EventFilter, FontId, Id, Key, Pos2, Rect, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};

use crate::app::theme::{Palette, SMALL};
use crate::arm::Arm;

/// Height of the drawing \[points\].
const HEIGHT: f32 = 190.0;
/// How far each link is turned from the one before \[rad\], so that all are seen.
const BEND: f64 = -0.45;
/// Room around the arm for its discs, and below it for the hint \[points\].
const AROUND: f32 = 22.0;
const BELOW: f32 = 16.0;
/// Shortest and longest link \[m\].
const LENGTHS: std::ops::RangeInclusive<f64> = 0.01..=100.0;
/// Lightest and heaviest link \[kg\].
const MASSES: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
/// A mass grows e-fold over so many points.
const MASS_DRAG: f32 = 60.0;

/// How far a key drags \[points\].
const KEY_DRAG: f32 = 4.0;

pub fn show(ui: &mut Ui, arm: &mut Arm) {
    let palette = Palette::in_ui(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, "the arm to be simulated"));
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 4, palette.canvas);
    let (scale, base) = fitted(ui, rect, arm);
    let heaviest = arm.links.iter().map(|link| link.mass).fold(0.0, f64::max).max(1e-9);
    let mut from = base;
    let mut angle = arm.posture.zero_angle;
    for number in 0..arm.links.len() {
        let along = Vec2::angled(-angle as f32);
        let link = &arm.links[number];
        let tip = from + along * (link.length as f32 * scale);
        let centre = from + along * (link.com as f32 * scale);
        let (color, _) = palette.nth(number);
        painter.line_segment([from, tip], Stroke::new(6.0, palette.card.lerp_to_gamma(color, 0.75)));
        painter.circle(from, 5.0, palette.card, Stroke::new(2.0, color));
        let radius = 5.0 + 9.0 * (link.mass / heaviest).cbrt() as f32;
        let (mass, length) = (link.mass, link.length);
        let spoken = format!("drag the mass of link {}", number + 1);
        let hint = format!("{mass:.3} kg: drag up for more, down for less, or press ↑ ↓");
        let more = vec2(0.0, -KEY_DRAG);
        if let Some(moved) = handle(ui, (number, "mass"), centre, radius, color, more, (&spoken, &hint)) {
            arm.links[number].mass = round(mass * f64::from(-moved.y / MASS_DRAG).exp(), MASSES);
        }
        let spoken = format!("drag the length of link {}", number + 1);
        let hint = format!("{length:.3} m: drag along the link, or press ↑ ↓");
        let more = along * KEY_DRAG;
        if let Some(moved) = handle(ui, (number, "length"), tip, 6.0, palette.text, more, (&spoken, &hint)) {
            let longer = round(length + f64::from(moved.dot(along) / scale), LENGTHS);
            stretch(arm, number, longer);
        }
        from = tip;
        angle += BEND;
    }
    let font = FontId::proportional(SMALL);
    let text = "Drag: an end for the length, a disc for the mass";
    painter.text(rect.left_bottom() + vec2(8.0, -5.0), Align2::LEFT_BOTTOM, text, font.clone(), palette.weak);
    painter.text(rect.right_top() + vec2(-8.0, 5.0), Align2::RIGHT_TOP, "g ↓", font, palette.weak);
}

/// Points of a metre and where the base stands, so that all of the arm is seen. While something is dragged they stay as they were,
/// else the pointer would run away from what it holds.
fn fitted(ui: &Ui, rect: Rect, arm: &Arm) -> (f32, Pos2) {
    let id = Id::unique("place of the arm in the editor");
    let is_held = ui.input(|input| input.pointer.any_down());
    if let Some((scale, base)) = ui.data(|data| data.get_temp::<(f32, Vec2)>(id)).filter(|_| is_held) {
        return (scale, rect.min + base);
    }
    let (mut tip, mut angle) = (Pos2::ZERO, arm.posture.zero_angle);
    let mut around = Rect::from_min_max(tip, tip);
    for link in &arm.links {
        let along = Vec2::angled(-angle as f32);
        around.extend_with(tip + along * link.com as f32);
        tip += along * link.length as f32;
        around.extend_with(tip);
        angle += BEND;
    }
    let room = rect.shrink(AROUND);
    let room = Rect::from_min_max(room.min, room.max - vec2(0.0, BELOW));
    let scale = (room.size() / around.size().max(Vec2::splat(1e-6))).min_elem();
    let base = room.center() - around.center().to_vec2() * scale;
    ui.data_mut(|data| data.insert_temp(id, (scale, base - rect.min)));
    (scale, base)
}

/// Something to be dragged, and how far it was in this frame; the arrow keys drag it towards `more`, or back.
fn handle(
    ui: &Ui,
    key: (usize, &str),
    at: Pos2,
    radius: f32,
    color: egui::Color32,
    more: Vec2,
    (spoken, hint): (&str, &str),
) -> Option<Vec2> {
    let palette = Palette::in_ui(ui);
    let area = Rect::from_center_size(at, Vec2::splat(2.0 * radius.max(8.0)));
    let response = ui.interact(area, ui.scope_id().with(key), Sense::drag() | Sense::focusable_noninteractive());
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Slider, true, spoken));
    let lit = response.hovered() || response.dragged() || response.has_focus();
    let fill = if lit { palette.accent } else { color.gamma_multiply(0.85) };
    ui.painter().circle(at, radius, fill, Stroke::new(1.5, palette.card));
    let mut moved = response.dragged().then(|| response.drag_delta());
    if response.has_focus() {
        // The arrows are the handle's while it has the focus; else they would move the focus.
        let arrows = EventFilter { vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        let pressed = |key| ui.input(|input| input.num_presses(key)) as f32;
        let steps = pressed(Key::ArrowUp) - pressed(Key::ArrowDown);
        moved = moved.or((steps != 0.0).then_some(more * steps));
    }
    response.on_hover_text(hint);
    moved
}

/// Another length; centre of mass and inertia follow as those of the same body, stretched.
fn stretch(arm: &mut Arm, link: usize, length: f64) {
    let link = &mut arm.links[link];
    let factor = length / link.length;
    (link.length, link.com, link.inertia) = (length, link.com * factor, link.inertia * factor * factor);
}

/// Within the range, to three digits.
fn round(value: f64, range: std::ops::RangeInclusive<f64>) -> f64 {
    let unit = 10f64.powf(value.abs().max(1e-9).log10().floor() - 2.0);
    ((value / unit).round() * unit).clamp(*range.start(), *range.end())
}
