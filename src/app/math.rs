//! Formulas as they are printed: TeX is laid out and drawn once, in white, and shown in the colour that the text has.

use egui::{Color32, ColorImage, Id, Image, Response, RichText, TextureHandle, TextureOptions, Ui, WidgetInfo};
use ratex_layout::{LayoutOptions, layout, to_display_list, validate_layout};
use ratex_parser::parser::parse;
use ratex_svg::{SvgColorSyntax, SvgOptions, render_to_svg_with_color_syntax};
use ratex_types::color::Color;
use ratex_types::math_style::MathStyle;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Height of a letter \[points\]: formulas want to be a little larger than the text about them.
const LETTER: f32 = 16.0;
/// Thickness of lines, as a share of the letter.
const LINE: f64 = 0.04;

/// Shows a formula, no wider than there is room. `plain` is the same without TeX: it is read aloud, and stands there if the TeX
/// can't be understood, as that of an effect of one's own may be.
pub fn show(ui: &mut Ui, tex: &str, plain: &str, color: Color32) -> Response {
    let scale = ui.ctx().pixels_per_point();
    let Some(texture) = texture(ui, tex, scale) else { return ui.label(RichText::new(plain).monospace().color(color)) };
    let size = texture.size_vec2() / scale;
    let shrink = (ui.available_width() / size.x).min(1.0);
    let response = ui.add(Image::new((texture.id(), size * shrink)).tint(color));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Label, true, plain));
    response
}

/// The picture of a formula at so many pixels in a point, drawn when it is first wanted; `None` if it can't be.
fn texture(ui: &Ui, tex: &str, scale: f32) -> Option<TextureHandle> {
    let id = Id::unique(("formula", tex, scale.to_bits()));
    if let Some(known) = ui.ctx().data(|data| data.get_temp::<Option<TextureHandle>>(id)) {
        return known;
    }
    let drawn = picture(tex, LETTER * scale).map(|image| ui.ctx().load_texture(tex, image, TextureOptions::LINEAR));
    ui.ctx().data_mut(|data| data.insert_temp(id, drawn.clone()));
    drawn
}

/// A formula in white on nothing, with letters of this height \[pixels\].
fn picture(tex: &str, letter: f32) -> Option<ColorImage> {
    let options = LayoutOptions::default().with_style(MathStyle::Display).with_color(Color::WHITE);
    let formula = layout(&parse(tex).ok()?, &options);
    validate_layout(&formula).ok()?;
    let letter = f64::from(letter);
    let page = SvgOptions {
        font_size: letter,
        padding: 1.0,
        stroke_width: LINE * letter,
        embed_glyphs: true,
        font_dir: String::new(),
    };
    let svg = render_to_svg_with_color_syntax(&to_display_list(&formula), &page, SvgColorSyntax::Rgb);
    let tree = Tree::from_str(&svg, &Options::default()).ok()?;
    let size = tree.size().to_int_size();
    let mut pixels = Pixmap::new(size.width(), size.height())?;
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    Some(ColorImage::from_rgba_premultiplied([size.width() as usize, size.height() as usize], pixels.data()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::registry;

    /// Share of the pixels that are not empty.
    fn ink(image: &ColorImage) -> f64 {
        let inked = image.pixels.iter().filter(|pixel| pixel.a() > 127).count();
        inked as f64 / image.pixels.len() as f64
    }

    #[test]
    fn the_formula_of_every_effect_is_drawn() {
        for effect in registry::ALL {
            let image = picture(effect.typeset, 32.0).unwrap_or_else(|| panic!("{}: {}", effect.id, effect.typeset));
            assert!((0.02..0.5).contains(&ink(&image)), "{}: {} of it is ink", effect.id, ink(&image));
            assert!(image.size[0] > image.size[1], "{}: {:?}", effect.id, image.size);
        }
    }

    #[test]
    fn letters_grow_with_the_screen_and_what_is_no_formula_is_none() {
        let [small, large] = [16.0, 32.0].map(|letter| picture(r"\frac{a}{b}", letter).unwrap().size[1] as f64);
        assert!((1.7..2.2).contains(&(large / small)), "{small} and {large}");
        assert!(picture(r"\frac{a}{", 16.0).is_none());
    }
}
