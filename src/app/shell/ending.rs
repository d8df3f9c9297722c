//! A file, and what it is written as: the choice and the ending of the path always say the same, whichever of them is changed.

use std::path::Path;

use egui::{RichText, TextEdit, Ui};

use crate::app::theme::{Palette, SMALL};
use crate::file::ending::{Choices, listed, named};

/// What it is written as; another choice changes the ending of the path.
pub fn choose<T: Copy + PartialEq>(ui: &mut Ui, choices: &Choices<T>, format: &mut T, path: &mut String) {
    ui.horizontal_wrapped(|ui| {
        for (choice, name, ending) in choices {
            if ui.radio_value(format, *choice, *name).clicked() {
                *path = Path::new(&*path).with_extension(ending).to_string_lossy().into_owned();
            }
        }
    });
}

/// Where it goes; another ending changes the choice. What is wrong with the path is said below it, unless it is to be a folder.
pub fn ask<T: Copy>(ui: &mut Ui, choices: &Choices<T>, format: &mut T, path: &mut String, is_folder: bool) {
    let label = ui.label("File");
    if ui.add(TextEdit::singleline(path).desired_width(f32::INFINITY)).labelled_by(label.id).changed() {
        follow(choices, format, path);
    }
    if !is_folder && !path.trim().is_empty() && !is_named(choices, path) {
        let text = format!("Its ending names no format: end it with {}.", listed(choices));
        ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).warning));
    }
}

/// The choice that the ending of the path names, if it names one.
pub fn follow<T: Copy>(choices: &Choices<T>, format: &mut T, path: &str) {
    *format = named(choices, Path::new(path.trim())).unwrap_or(*format);
}

/// Whether the path says what is written.
pub fn is_named<T: Copy>(choices: &Choices<T>, path: &str) -> bool {
    named(choices, Path::new(path.trim())).is_some()
}
