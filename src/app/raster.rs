//! Draws egui's triangles on the CPU: no display, no GPU, no library of the system.
//!
//! Screenshots and snapshot tests go this way, so that a picture is the same on every machine. Colours are multiplied and
//! blended in gamma space with premultiplied alpha, as egui's own renderers do.

use std::collections::HashMap;

use egui::epaint::textures::TexturesDelta;
use egui::epaint::{ClippedPrimitive, Primitive, Vertex};
use egui::{Color32, ImageData, Rect, TextureId};

/// A picture: four bytes a pixel, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Red, green, blue, alpha.
    pub rgba: Vec<u8>,
}

/// Keeps the textures that egui hands out and paints with them.
#[derive(Default)]
pub struct Raster {
    textures: HashMap<TextureId, Texture>,
}

struct Texture {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

impl Picture {
    /// The picture as a PNG file, as small as it can be: windows are even areas and lines, which filters only disturb, and nothing
    /// shines through them.
    ///
    /// # Errors
    /// What the encoder says, such as a picture without pixels.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::NoFilter);
        let rgb: Vec<u8> = self.rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}

impl Raster {
    /// Takes over what changed in the textures, and empties `delta`.
    pub fn update_textures(&mut self, delta: &mut TexturesDelta) {
        for (id, changes) in delta.set.drain() {
            for change in changes {
                let ImageData::Color(image) = &change.image;
                let [width, height] = image.size;
                let texels = image.pixels.iter().map(|color| color.to_array().map(f32::from));
                match (change.pos, self.textures.get_mut(&id)) {
                    (Some([left, top]), Some(texture)) => {
                        for (index, texel) in texels.enumerate() {
                            let (x, y) = (left + index % width, top + index / width);
                            if x < texture.width && y < texture.height {
                                texture.texels[y * texture.width + x] = texel;
                            }
                        }
                    }
                    _ => {
                        self.textures.insert(id, Texture { width, height, texels: texels.collect() });
                    }
                }
            }
        }
        for id in delta.free.drain() {
            self.textures.remove(&id);
        }
    }

    /// Paints on `background`. `scale` is pixels per point.
    pub fn paint(&self, primitives: &[ClippedPrimitive], size: [usize; 2], scale: f32, background: Color32) -> Picture {
        let [width, height] = size;
        let mut picture = Picture { width, height, rgba: background.to_array().repeat(width * height) };
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            // Callbacks draw with a GPU; the program has none.
            let Primitive::Mesh(mesh) = primitive else { continue };
            let Some(texture) = self.textures.get(&mesh.texture_id) else { continue };
            let clip = Clip::new(*clip_rect, scale, size);
            for corners in mesh.indices.chunks_exact(3) {
                let triangle = [0, 1, 2].map(|corner| {
                    let mut vertex = mesh.vertices[corners[corner] as usize];
                    vertex.pos = (vertex.pos.to_vec2() * scale).to_pos2();
                    vertex
                });
                fill(&mut picture, &clip, texture, triangle);
            }
        }
        picture
    }
}

/// The pixels that may be touched: from the first to before the second.
struct Clip {
    x: [i32; 2],
    y: [i32; 2],
}

impl Clip {
    fn new(rect: Rect, scale: f32, [width, height]: [usize; 2]) -> Self {
        let pixel = |points: f32, most: usize| ((points * scale).round() as i32).clamp(0, most as i32);
        Clip {
            x: [pixel(rect.min.x, width), pixel(rect.max.x, width)],
            y: [pixel(rect.min.y, height), pixel(rect.max.y, height)],
        }
    }
}

/// First pixel whose centre is at or right of (below) the coordinate. Neighbours that share an edge agree on it, so no
/// pixel is painted twice or left out.
fn first_pixel(coordinate: f32) -> i32 {
    (coordinate - 0.5).ceil() as i32
}

fn fill(picture: &mut Picture, clip: &Clip, texture: &Texture, mut corners: [Vertex; 3]) {
    corners.sort_by(|a, b| a.pos.y.total_cmp(&b.pos.y));
    let [top, middle, bottom] = corners;
    let rows = first_pixel(top.pos.y).max(clip.y[0])..first_pixel(bottom.pos.y).min(clip.y[1]);
    if rows.is_empty() {
        return;
    }
    let Some(ink) = Ink::new(texture, &corners) else { return };
    let crossing =
        |a: &Vertex, b: &Vertex, y: f32| a.pos.x + (b.pos.x - a.pos.x) * ((y - a.pos.y) / (b.pos.y - a.pos.y));
    for row in rows {
        let y = row as f32 + 0.5;
        let short = if y < middle.pos.y { crossing(&top, &middle, y) } else { crossing(&middle, &bottom, y) };
        let long = crossing(&top, &bottom, y);
        let from = first_pixel(short.min(long)).max(clip.x[0]);
        let to = first_pixel(short.max(long)).min(clip.x[1]);
        if from < to {
            let start = row as usize * picture.width;
            let span = &mut picture.rgba[4 * (start + from as usize)..4 * (start + to as usize)];
            ink.fill(span, from as f32 + 0.5, y);
        }
    }
}

/// What a triangle is painted with.
enum Ink<'a> {
    /// One colour everywhere.
    Flat([f32; 4]),
    /// A colour that changes over the triangle.
    Shaded(Plane<4>),
    /// A colour times a texture.
    Textured { texture: &'a Texture, color: Plane<4>, uv: Plane<2> },
}

/// Values that grow linearly over the picture.
struct Plane<const N: usize> {
    base: [f32; N],
    by_x: [f32; N],
    by_y: [f32; N],
    origin: [f32; 2],
}

impl<const N: usize> Plane<N> {
    /// `None` for a triangle without area.
    fn new(corners: &[Vertex; 3], value: impl Fn(&Vertex) -> [f32; N]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| corner.pos);
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let [base, second, third] = corners.each_ref().map(value);
        let (mut by_x, mut by_y) = ([0.0; N], [0.0; N]);
        for n in 0..N {
            let (to_b, to_c) = (second[n] - base[n], third[n] - base[n]);
            by_x[n] = (to_b * (c.y - a.y) - to_c * (b.y - a.y)) / area;
            by_y[n] = (to_c * (b.x - a.x) - to_b * (c.x - a.x)) / area;
        }
        Some(Plane { base, by_x, by_y, origin: [a.x, a.y] })
    }

    fn at(&self, x: f32, y: f32) -> [f32; N] {
        let (x, y) = (x - self.origin[0], y - self.origin[1]);
        std::array::from_fn(|n| self.base[n] + x * self.by_x[n] + y * self.by_y[n])
    }
}

impl<'a> Ink<'a> {
    fn new(texture: &'a Texture, corners: &[Vertex; 3]) -> Option<Self> {
        let [first, second, third] = corners;
        let one_color = first.color == second.color && second.color == third.color;
        if first.uv == second.uv && second.uv == third.uv {
            let texel = texture.sample(first.uv.x, first.uv.y).map(|value| value / 255.0);
            if one_color {
                return Some(Ink::Flat(times(first.color.to_array().map(f32::from), texel)));
            }
            let color = Plane::new(corners, |corner| times(corner.color.to_array().map(f32::from), texel))?;
            return Some(Ink::Shaded(color));
        }
        let color = Plane::new(corners, |corner| corner.color.to_array().map(|value| f32::from(value) / 255.0))?;
        let uv = Plane::new(corners, |corner| [corner.uv.x, corner.uv.y])?;
        Some(Ink::Textured { texture, color, uv })
    }

    fn fill(&self, span: &mut [u8], x: f32, y: f32) {
        let (pixels, _) = span.as_chunks_mut::<4>();
        match self {
            Ink::Flat(color) if color[3] >= 255.0 => pixels.fill(color.map(round)),
            Ink::Flat(color) => pixels.iter_mut().for_each(|pixel| blend(pixel, *color)),
            Ink::Shaded(color) => {
                let mut value = color.at(x, y);
                for pixel in pixels {
                    blend(pixel, value);
                    value = plus(value, color.by_x);
                }
            }
            Ink::Textured { texture, color, uv } => {
                for (index, pixel) in pixels.iter_mut().enumerate() {
                    let x = x + index as f32;
                    let [u, v] = uv.at(x, y);
                    let texel = texture.sample(u, v);
                    if texel != [0.0; 4] {
                        blend(pixel, times(color.at(x, y), texel));
                    }
                }
            }
        }
    }
}

impl Texture {
    /// Bilinear, clamped to the edge.
    fn sample(&self, u: f32, v: f32) -> [f32; 4] {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right_share, bottom_share) = (x - left, y - top);
        let texel = |x: f32, y: f32| {
            let column = (x.max(0.0) as usize).min(self.width.saturating_sub(1));
            let row = (y.max(0.0) as usize).min(self.height.saturating_sub(1));
            self.texels.get(row * self.width + column).copied().unwrap_or([0.0; 4])
        };
        let between = |a: [f32; 4], b: [f32; 4], share: f32| std::array::from_fn(|n| a[n] + (b[n] - a[n]) * share);
        let upper = between(texel(left, top), texel(left + 1.0, top), right_share);
        let lower = between(texel(left, top + 1.0), texel(left + 1.0, top + 1.0), right_share);
        between(upper, lower, bottom_share)
    }
}

fn times(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|n| a[n] * b[n])
}

fn plus(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|n| a[n] + b[n])
}

fn round(value: f32) -> u8 {
    (value + 0.5) as u8
}

/// Puts a premultiplied colour over a pixel.
fn blend(pixel: &mut [u8; 4], color: [f32; 4]) {
    let rest = 1.0 - color[3] / 255.0;
    for n in 0..4 {
        pixel[n] = round(color[n] + f32::from(pixel[n]) * rest);
    }
}

#[cfg(test)]
mod tests {
    use egui::epaint::{Mesh, textures::TexturesDelta};
    use egui::{ColorImage, TextureOptions, pos2, vec2};

    use super::*;

    fn white() -> Raster {
        let mut delta = TexturesDelta::default();
        let image = ColorImage::filled([1, 1], Color32::WHITE);
        delta.push(TextureId::default(), egui::epaint::ImageDelta::full(image, TextureOptions::LINEAR));
        let mut raster = Raster::default();
        raster.update_textures(&mut delta);
        raster
    }

    fn paint(mesh: Mesh, clip: Rect) -> Picture {
        let primitives = [ClippedPrimitive { clip_rect: clip, primitive: Primitive::Mesh(mesh) }];
        white().paint(&primitives, [10, 10], 1.0, Color32::BLACK)
    }

    #[test]
    fn two_triangles_cover_a_rectangle_once() {
        let mut mesh = Mesh::default();
        mesh.add_colored_rect(Rect::from_min_size(pos2(2.0, 3.0), vec2(5.0, 4.0)), Color32::from_white_alpha(100));
        let picture = paint(mesh, Rect::EVERYTHING);
        for (index, pixel) in picture.rgba.chunks(4).enumerate() {
            let inside = (2..7).contains(&(index % 10)) && (3..7).contains(&(index / 10));
            assert_eq!(pixel[0], if inside { 100 } else { 0 }, "pixel {index}");
        }
    }

    #[test]
    fn nothing_outside_the_clip_rectangle() {
        let mut mesh = Mesh::default();
        mesh.add_colored_rect(Rect::from_min_size(pos2(-5.0, -5.0), vec2(50.0, 50.0)), Color32::WHITE);
        let picture = paint(mesh, Rect::from_min_max(pos2(4.0, 4.0), pos2(6.0, 6.0)));
        assert_eq!(picture.rgba.chunks(4).filter(|pixel| pixel[0] == 255).count(), 4);
    }

    #[test]
    fn a_png_begins_as_a_png() {
        let picture = white().paint(&[], [3, 2], 1.0, Color32::RED);
        assert!(picture.png().unwrap().starts_with(b"\x89PNG"));
    }
}
