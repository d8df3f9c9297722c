//! An SVG as PDF or as pixels.

use std::sync::Arc;

use krilla_svg::{SurfaceExt as _, SvgSettings};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};

use super::FigureError;
use super::font::Family;

/// Points of an inch, which are the units of our SVG.
const POINTS_PER_INCH: f64 = 72.0;
/// Largest side of a picture \[pixels\].
pub const LARGEST_SIDE: f64 = 16384.0;

fn failed(format: &'static str, reason: impl ToString) -> FigureError {
    FigureError::Conversion { format, reason: reason.to_string() }
}

fn parse(svg: &str, family: Family, format: &'static str) -> Result<Tree, FigureError> {
    let mut fonts = Database::new();
    fonts.load_font_data(family.bytes().to_vec());
    let (fontdb, font_family) = (Arc::new(fonts), family.name().to_owned());
    let options = Options { fontdb, font_family, dpi: POINTS_PER_INCH as f32, ..Options::default() };
    Tree::from_str(svg, &options).map_err(|error| failed(format, error))
}

/// Pages of the size of each SVG; of the font they hold the letters that are used.
pub fn pdf(pages: &[String], family: Family) -> Result<Vec<u8>, FigureError> {
    let no_page = || failed("PDF", "its page has no size");
    let mut document = krilla::Document::new();
    for svg in pages {
        let tree = parse(svg, family, "PDF")?;
        let (width, height) = (tree.size().width(), tree.size().height());
        let settings = krilla::page::PageSettings::from_wh(width, height).ok_or_else(no_page)?;
        let size = krilla::geom::Size::from_wh(width, height).ok_or_else(no_page)?;
        let mut page = document.start_page_with(settings);
        let mut surface = page.surface();
        surface.draw_svg(&tree, size, SvgSettings::default()).ok_or_else(no_page)?;
        surface.finish();
        page.finish();
    }
    document.finish().map_err(|error| failed("PDF", format!("{error:?}")))
}

/// Pixels at a resolution.
pub fn png(svg: &str, family: Family, dpi: f64) -> Result<Vec<u8>, FigureError> {
    pixels(svg, family, dpi)?.encode_png().map_err(|error| failed("PNG", error))
}

/// The same as they are.
pub fn pixels(svg: &str, family: Family, dpi: f64) -> Result<Pixmap, FigureError> {
    let tree = parse(svg, family, "PNG")?;
    let scale = dpi / POINTS_PER_INCH;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| (f64::from(side) * scale).round());
    let fits = |side: f64| (1.0..=LARGEST_SIDE).contains(&side);
    let pixmap = if fits(width) && fits(height) { Pixmap::new(width as u32, height as u32) } else { None };
    let mut pixmap = pixmap.ok_or(FigureError::Pixels { width, height })?;
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixmap.as_mut());
    Ok(pixmap)
}
