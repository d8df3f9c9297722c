//! The one font of the program. egui's own drops combining marks, which τ̂, q̇ and q̈ need.

use std::sync::Arc;

use egui::{FontData, FontDefinitions, FontFamily};

use crate::figure::font::DEJAVU_SANS;

/// DejaVu Sans before egui's fonts, for all text: its digits have one width, so that numbers line up.
pub fn definitions() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    fonts.font_data.insert("DejaVu Sans".into(), Arc::new(FontData::from_static(DEJAVU_SANS)));
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.entry(family).or_default().insert(0, "DejaVu Sans".into());
    }
    fonts
}
