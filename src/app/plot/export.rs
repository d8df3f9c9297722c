//! Every plot can be exported by its own menu or key.

use egui::{Context, Id, Key, Response, Ui};

fn wish() -> Id {
    Id::unique("plot that asks to be exported")
}

/// Lets the user export the plot of this title.
pub fn offer(ui: &Ui, response: &Response, title: &str) {
    let mut wanted = response.has_focus() && ui.input(|input| input.key_pressed(Key::E));
    response.context_menu(|ui| wanted |= ui.button("Export this plot… (E)").clicked());
    if wanted {
        ui.data_mut(|data| data.insert_temp(wish(), title.to_owned()));
    }
}

/// The title of the plot that the user wants to export, given once.
pub fn wanted(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(wish()))
}
