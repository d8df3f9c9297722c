//! Every plot can be exported by its own menu or key.

use egui::{Context, Id, Ui};

fn wish() -> Id {
    Id::unique("plot that asks to be exported")
}

/// Asks for the export of the plot of this title.
pub fn ask(ui: &Ui, title: &str) {
    ui.data_mut(|data| data.insert_temp(wish(), title.to_owned()));
}

/// The title of the plot that the user wants to export, given once.
pub fn wanted(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(wish()))
}
