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

#[cfg(test)]
pub(crate) mod embedded {
    //! Whether a PDF brings its fonts along, as printers and publishers want it: every font that is named in it has its letters in it.
    //!
    //! Reads the PDF that this program writes, whose objects stand in plain text. Source: ISO 32000-1, 9.6 to 9.9 (a font of type 0 has a
    //! descendant; any but one of type 3 has a descriptor, which has the file of the font).

    use std::collections::BTreeMap;
    use std::process::Command;

    /// The fonts of a PDF by name; a panic if the letters of one are not in it.
    pub(crate) fn fonts(pdf: &[u8]) -> Vec<String> {
        let objects = objects(pdf);
        let mut names = Vec::new();
        for (number, text) in &objects {
            if !has_type(text, "Font") {
                continue;
            }
            let name = name(text, "/BaseFont").unwrap_or("(unnamed)");
            if self::name(text, "/Subtype") == Some("Type3") {
                continue;
            }
            let own = match reference(text, "/DescendantFonts") {
                Some(descendant) => {
                    objects.get(&descendant).unwrap_or_else(|| panic!("font {number} has no descendant"))
                }
                None => text,
            };
            let descriptor = reference(own, "/FontDescriptor").and_then(|descriptor| objects.get(&descriptor));
            let descriptor = descriptor.unwrap_or_else(|| panic!("font {name} has no descriptor: it is not embedded"));
            let file =
                ["/FontFile ", "/FontFile2", "/FontFile3"].into_iter().find_map(|key| reference(descriptor, key));
            let file = file.and_then(|file| objects.get(&file));
            assert!(file.is_some_and(|file| file.contains("stream")), "font {name} is not embedded");
            names.push(name.to_owned());
        }
        names.sort();
        names.dedup();
        names
    }

    /// The same asked of `pdffonts`, if it is there.
    pub(crate) fn pdffonts_agrees(pdf: &[u8]) {
        if Command::new("pdffonts").arg("-v").output().is_err() {
            eprintln!("left out: pdffonts is not asked about the fonts of a PDF, because it is not here");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.pdf");
        std::fs::write(&path, pdf).unwrap();
        let output = Command::new("pdffonts").arg(&path).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{said}");
        let fonts: Vec<&str> = said.lines().skip(2).collect();
        assert!(!fonts.is_empty(), "{said}");
        for font in fonts {
            // From the right: generation, object, unicode, subset, embedded.
            assert_eq!(font.split_whitespace().rev().nth(4), Some("yes"), "{said}");
        }
    }

    /// The text of each object by its number; what is no text in it is replaced.
    fn objects(pdf: &[u8]) -> BTreeMap<usize, String> {
        let text = String::from_utf8_lossy(pdf);
        let mut objects = BTreeMap::new();
        for part in text.split("endobj") {
            let Some((head, body)) = part.split_once(" 0 obj") else { continue };
            let number =
                head.rsplit(|letter: char| !letter.is_ascii_digit()).next().and_then(|number| number.parse().ok());
            objects.extend(number.map(|number| (number, body.to_owned())));
        }
        objects
    }

    fn has_type(text: &str, kind: &str) -> bool {
        name(text, "/Type") == Some(kind)
    }

    /// The name behind a key.
    fn name<'a>(text: &'a str, key: &str) -> Option<&'a str> {
        let behind = text.match_indices(key).map(|(at, _)| &text[at + key.len()..]);
        let named = behind.filter_map(|behind| behind.trim_start().strip_prefix('/'));
        named
            .filter_map(|name| name.split(|letter: char| letter.is_whitespace() || "/<>[]()".contains(letter)).next())
            .next()
    }

    /// The number of the object that a key refers to, the first of a list.
    fn reference(text: &str, key: &str) -> Option<usize> {
        let (_, behind) = text.split_once(key)?;
        behind.trim_start_matches([' ', '\n', '\r', '[']).split_whitespace().next()?.parse().ok()
    }

    #[test]
    fn a_font_without_its_letters_is_seen() {
        let font = |rest: &str| {
            format!("%PDF-1.7\n1 0 obj\n<< /Type /Font /Subtype /TrueType /BaseFont /Own {rest} >>\nendobj\n")
        };
        let whole = font("/FontDescriptor 2 0 R")
            + "2 0 obj\n<< /Type /FontDescriptor /FontFile2 3 0 R >>\nendobj\n3 0 obj\n<< /Length 3 >>\nstream\nabc\nendstream\nendobj\n";
        assert_eq!(fonts(whole.as_bytes()), ["Own"]);
        let refused = |pdf: String| std::panic::catch_unwind(|| fonts(pdf.as_bytes())).is_err();
        assert!(refused(font("")) && refused(font("/FontDescriptor 2 0 R")));
        assert!(refused(whole.replace("/FontFile2 3 0 R", "")));
    }
}
