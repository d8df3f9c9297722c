//! Dialogs that grow and shrink while they are open hang from the top: what one is about to click stays where it is.

use egui::{Align2, Id, Modal, vec2};

/// Room above them \[points\].
const TOP: f32 = 28.0;

/// A dialog whose first line does not move.
pub fn hanging(name: &'static str) -> Modal {
    let id = Id::unique(name);
    Modal::new(id).area(Modal::default_area(id).anchor(Align2::CENTER_TOP, vec2(0.0, TOP)))
}
