//! How a line looks, beside its name in a table.

use std::cell::RefCell;
use std::rc::Rc;

use egui::{Sense, Ui, vec2};

use super::screen::Screen;
use crate::app::theme::{Palette, SMALL};
use crate::figure::Ink;
use crate::figure::mark::Key;

/// A piece of a line of this ink; without one the room stays empty.
pub fn key_of(ui: &mut Ui, ink: Option<Ink>) {
    let (rect, _) = ui.allocate_exact_size(vec2(Key::WIDTH as f32 * SMALL, SMALL), Sense::hover());
    let Some(ink) = ink else { return };
    let (colours, decimator) = (Palette::in_ui(ui).colours(), Rc::new(RefCell::default()));
    let mut shapes = Vec::new();
    let mut screen = Screen::new(ui, &colours, &decimator, &mut shapes);
    let key = Key::Line(ink, ink.dash(), 1.0, 1.6);
    key.draw(&mut screen, [f64::from(rect.left()), f64::from(rect.center().y)]);
    drop(screen);
    ui.painter().extend(shapes);
}
