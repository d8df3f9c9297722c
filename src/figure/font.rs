//! The one font of the program, and how wide its letters are.

use ttf_parser::Face;

/// DejaVu Sans: it has the combining marks that τ̂, q̇ and q̈ need.
pub static DEJAVU_SANS: &[u8] = include_bytes!("../../assets/fonts/DejaVuSans.ttf");

/// Measures texts.
pub struct Ruler(Option<Face<'static>>);

impl Default for Ruler {
    fn default() -> Self {
        Ruler(Face::parse(DEJAVU_SANS, 0).ok())
    }
}

impl Ruler {
    /// Width of a text of this size, in the size's unit.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        let Some(face) = &self.0 else { return 0.6 * size * text.chars().count() as f64 };
        let advance = |letter| face.glyph_index(letter).and_then(|glyph| face.glyph_hor_advance(glyph)).unwrap_or(0);
        let units: f64 = text.chars().map(|letter| f64::from(advance(letter))).sum();
        units * size / f64::from(face.units_per_em())
    }
}
