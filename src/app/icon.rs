//! The window's icon, drawn from `assets/icon.svg`.

use egui::IconData;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Width and height \[pixels\].
const SIDE: u32 = 128;

/// The icon; `None` if the drawing can't be used, which a test excludes.
pub fn icon() -> Option<IconData> {
    let tree = Tree::from_str(include_str!("../../assets/icon.svg"), &Options::default()).ok()?;
    let mut pixels = Pixmap::new(SIDE, SIDE)?;
    let scale = SIDE as f32 / tree.size().width();
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Some(IconData { rgba: pixels.take_demultiplied(), width: SIDE, height: SIDE })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_icon_is_drawn_on_a_round_ground() {
        let icon = icon().unwrap();
        let alpha = |x: u32, y: u32| icon.rgba[4 * (y * SIDE + x) as usize + 3];
        assert_eq!((alpha(0, 0), alpha(SIDE / 2, SIDE / 2)), (0, 255));
        let mut colours: Vec<&[u8]> = icon.rgba.chunks_exact(4).filter(|pixel| pixel[3] == 255).collect();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() > 3, "it is one spot of {colours:?}");
    }
}
