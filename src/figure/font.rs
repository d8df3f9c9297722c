//! The fonts of the program: how wide their letters are, and a font of those letters alone that a figure has.

use std::collections::BTreeSet;

use allsorts::binary::read::ReadScope;
use allsorts::font_data::FontData;
use allsorts::subset::{CmapTarget, SubsetProfile, subset};
use ttf_parser::Face;

/// DejaVu Sans: it has the combining marks that τ̂, q̇ and q̈ need.
pub static DEJAVU_SANS: &[u8] = include_bytes!("../../assets/fonts/DejaVuSans.ttf");
/// Its sister with serifs.
static DEJAVU_SERIF: &[u8] = include_bytes!("../../assets/fonts/DejaVuSerif.ttf");

/// The letters of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Family {
    /// Without serifs.
    #[default]
    Sans,
    /// With serifs, as the text of most papers.
    Serif,
}

impl Family {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Family::Sans => "DejaVu Sans",
            Family::Serif => "DejaVu Serif",
        }
    }

    /// The whole font.
    pub fn bytes(self) -> &'static [u8] {
        match self {
            Family::Sans => DEJAVU_SANS,
            Family::Serif => DEJAVU_SERIF,
        }
    }

    /// A font of these letters alone, some kilobytes; the whole one if it can't be cut.
    pub fn of_letters(self, letters: &BTreeSet<char>) -> Vec<u8> {
        self.cut(letters).unwrap_or_else(|| self.bytes().to_vec())
    }

    fn cut(self, letters: &BTreeSet<char>) -> Option<Vec<u8>> {
        let face = Face::parse(self.bytes(), 0).ok()?;
        // The first is drawn for letters that the font lacks.
        let glyphs = letters.iter().filter_map(|letter| face.glyph_index(*letter)).map(|glyph| glyph.0);
        let glyphs: BTreeSet<u16> = glyphs.chain([0]).collect();
        let glyphs: Vec<u16> = glyphs.into_iter().collect();
        let font = ReadScope::new(self.bytes()).read::<FontData>().ok()?;
        let tables = font.table_provider(0).ok()?;
        subset(&tables, &glyphs, &SubsetProfile::Minimal, CmapTarget::Unicode).ok()
    }
}

/// Measures texts.
pub struct Ruler(Option<Face<'static>>);

impl Ruler {
    /// For the letters of a font.
    pub fn of(family: Family) -> Self {
        Ruler(Face::parse(family.bytes(), 0).ok())
    }

    /// Width of a text of this size, in the size's unit.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        let Some(face) = &self.0 else { return 0.6 * size * text.chars().count() as f64 };
        let advance = |letter| face.glyph_index(letter).and_then(|glyph| face.glyph_hor_advance(glyph)).unwrap_or(0);
        let units: f64 = text.chars().map(|letter| f64::from(advance(letter))).sum();
        units * size / f64::from(face.units_per_em())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_font_of_some_letters_has_them_as_they_were_and_is_small() {
        let letters: BTreeSet<char> = "joint 1: τ̂ q̇ [N m]".chars().collect();
        for family in [Family::Sans, Family::Serif] {
            let cut = family.of_letters(&letters);
            assert!(cut.len() < 20_000, "{} bytes", cut.len());
            let (own, whole) = (Face::parse(&cut, 0).unwrap(), Face::parse(family.bytes(), 0).unwrap());
            for letter in &letters {
                let width = |face: &Face| face.glyph_index(*letter).and_then(|glyph| face.glyph_hor_advance(glyph));
                assert!(width(&own).is_some() && width(&own) == width(&whole), "{letter}");
            }
            assert_eq!(own.glyph_index('Z'), None, "what is not used is left out");
        }
    }
}
