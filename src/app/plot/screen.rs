//! The window as a canvas: what marks draw becomes shapes.

use std::cell::RefCell;
use std::rc::Rc;

use egui::epaint::{Mesh, Shape, Vertex, WHITE_UV};
use egui::{Align2, Color32, FontId, Pos2, Rect, StrokeKind, Ui, pos2};

use crate::app::theme::SMALL;
use crate::figure::canvas::{Canvas, Fill, Hold, Stroke};
use crate::figure::colours::{Colours, Rgb};
use crate::figure::decimate::Decimator;
use crate::figure::{Area, Place};

/// Shapes of a plot.
pub struct Screen<'a> {
    pub shapes: &'a mut Vec<Shape>,
    ui: &'a Ui,
    colours: &'a Colours,
    decimator: std::cell::RefMut<'a, Decimator>,
}

impl<'a> Screen<'a> {
    pub fn new(
        ui: &'a Ui,
        colours: &'a Colours,
        decimator: &'a Rc<RefCell<Decimator>>,
        shapes: &'a mut Vec<Shape>,
    ) -> Self {
        Screen { shapes, ui, colours, decimator: decimator.borrow_mut() }
    }
}

pub fn color([red, green, blue]: Rgb, opacity: f64) -> Color32 {
    Color32::from_rgb(red, green, blue).gamma_multiply(opacity as f32)
}

/// A rectangle of the window as one of a page.
pub fn area(rect: Rect) -> Area {
    let [left, top, width, height] = [rect.left(), rect.top(), rect.width(), rect.height()].map(f64::from);
    Area { left, top, width, height }
}

pub fn position([x, y]: [f64; 2]) -> Pos2 {
    pos2(x as f32, y as f32)
}

pub fn rect([[left, right], [top, bottom]]: [[f64; 2]; 2]) -> Rect {
    Rect::from_two_pos(position([left, top]), position([right, bottom]))
}

fn paint(fill: &Fill) -> Color32 {
    color(fill.color, fill.opacity)
}

impl Canvas for Screen<'_> {
    fn colours(&self) -> &Colours {
        self.colours
    }

    fn letter(&self) -> f64 {
        f64::from(SMALL)
    }

    fn fineness(&self) -> f64 {
        1.0
    }

    fn decimator(&mut self) -> &mut Decimator {
        &mut self.decimator
    }

    fn width_of(&self, text: &str, size: f64) -> f64 {
        let font = FontId::proportional(size as f32);
        f64::from(self.ui.painter().layout_no_wrap(text.to_owned(), font, Color32::PLACEHOLDER).size().x)
    }

    fn polyline(&mut self, points: &[[f64; 2]], stroke: &Stroke) {
        let points: Vec<Pos2> = points.iter().copied().map(position).collect();
        let own = egui::Stroke::new(stroke.width as f32, color(stroke.color, stroke.opacity));
        // Where a line goes up and down in every pixel column, a dash can't be seen, but costs thousands of pieces.
        let width = points.last().map_or(0.0, |last| (last.x - points[0].x).abs());
        if stroke.dash.is_empty() || points.len() as f32 > 1.5 * width.max(40.0) {
            self.shapes.push(Shape::line(points, own));
        } else {
            let pairs = stroke.dash.chunks(2).map(|pair| (pair[0], pair[pair.len() - 1]));
            let (ink, gaps): (Vec<f32>, Vec<f32>) = pairs.unzip();
            self.shapes.extend(Shape::dashed_line_with_offset(&points, own, &ink, &gaps, 0.0));
        }
    }

    fn polygon(&mut self, corners: &[[f64; 2]], fill: &Fill) {
        let corners = corners.iter().copied().map(position).collect();
        self.shapes.push(Shape::convex_polygon(corners, paint(fill), egui::Stroke::NONE));
    }

    fn ribbon(&mut self, lower: &[[f64; 2]], upper: &[[f64; 2]], fill: &Fill) {
        let color = paint(fill);
        let mut mesh = Mesh::default();
        for at in lower.iter().zip(upper).flat_map(|(low, high)| [*low, *high]) {
            mesh.vertices.push(Vertex { pos: position(at), uv: WHITE_UV, color });
        }
        for column in 1..lower.len().min(upper.len()) as u32 {
            let first = 2 * (column - 1);
            mesh.indices.extend([first, first + 1, first + 2, first + 1, first + 2, first + 3]);
        }
        self.shapes.push(Shape::mesh(mesh));
    }

    fn rectangle(&mut self, sides: [[f64; 2]; 2], fill: &Fill, edge: Option<&Stroke>, rounding: f64) {
        let (rect, rounding) = (rect(sides), rounding as f32);
        self.shapes.push(Shape::rect_filled(rect, rounding, paint(fill)));
        if let Some(edge) = edge {
            // A line of less than a pixel would be a pale one.
            let stroke = egui::Stroke::new((edge.width as f32).max(1.0), color(edge.color, edge.opacity));
            self.shapes.push(Shape::rect_stroke(rect, rounding, stroke, StrokeKind::Inside));
        }
    }

    /// Few points are circles; of many a square is drawn each, all in one mesh, since thousands of circles would be slow.
    fn dots(&mut self, centres: &[[f64; 2]], radius: f64, fill: &Fill) {
        const MOST_CIRCLES: usize = 60;
        let (color, radius) = (paint(fill), radius as f32);
        if centres.len() <= MOST_CIRCLES {
            self.shapes.extend(centres.iter().map(|at| Shape::circle_filled(position(*at), radius, color)));
            return;
        }
        let mut mesh = Mesh::default();
        mesh.reserve_vertices(4 * centres.len());
        mesh.reserve_triangles(2 * centres.len());
        for at in centres {
            mesh.add_colored_rect(Rect::from_center_size(position(*at), egui::Vec2::splat(2.0 * radius)), color);
        }
        self.shapes.push(Shape::mesh(mesh));
    }

    fn cells(&mut self, cells: &[([[f64; 2]; 2], Rgb)]) {
        let mut mesh = Mesh::default();
        mesh.reserve_vertices(4 * cells.len());
        mesh.reserve_triangles(2 * cells.len());
        for (sides, own) in cells {
            mesh.add_colored_rect(rect(*sides), color(*own, 1.0));
        }
        self.shapes.push(Shape::mesh(mesh));
    }

    fn text(&mut self, at: [f64; 2], text: &str, size: f64, ink: Rgb, hold: Hold) {
        let anchor = match hold {
            Hold::Start => Align2::LEFT_CENTER,
            Hold::Middle => Align2::CENTER_CENTER,
            Hold::End => Align2::RIGHT_CENTER,
        };
        let middle = position([at[0], at[1] - 0.35 * size]);
        let font = FontId::proportional(size as f32);
        let galley = self.ui.painter().layout_no_wrap(text.to_owned(), font, color(ink, 1.0));
        let corner = anchor.anchor_size(middle, galley.size()).min;
        self.shapes.push(Shape::galley(corner, galley, Color32::PLACEHOLDER));
    }
}

pub fn is_inside(at: Pos2, plot: &Area) -> bool {
    let (x, y) = (f64::from(at.x), f64::from(at.y));
    (plot.left..=plot.right()).contains(&x) && (plot.top..=plot.bottom()).contains(&y)
}

/// The values at a place of the window, or at the nearest one in the plot.
pub fn value(place: &Place, at: Pos2) -> [f64; 2] {
    let Area { left, top, .. } = place.plot;
    let x = f64::from(at.x).clamp(left, place.plot.right());
    place.value([x, f64::from(at.y).clamp(top, place.plot.bottom())])
}
