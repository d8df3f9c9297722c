//! The plots of a screen as figures: what is drawn while somebody collects is also described as [`Panel`].

use std::sync::Arc;

use egui::mutex::Mutex;
use egui::{Context, Id, Key, Response, Ui};

use crate::figure::Panel;

/// The panels of the newest frame.
#[derive(Default)]
struct Collected {
    frame: u64,
    panels: Vec<Panel>,
}

type Shared = Arc<Mutex<Collected>>;

fn key() -> Id {
    Id::unique("collected plots")
}

fn wish() -> Id {
    Id::unique("plot that asks to be exported")
}

/// From now on plots are described, too.
pub fn begin(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(key(), Shared::default()));
}

/// The plots of the last frame, in the order in which they were drawn.
pub fn panels(ctx: &Context) -> Vec<Panel> {
    let shared = ctx.data(|data| data.get_temp::<Shared>(key()));
    shared.map(|shared| shared.lock().panels.clone()).unwrap_or_default()
}

/// Plots are no longer described, which would cost every frame a copy of their numbers.
pub fn end(ctx: &Context) {
    ctx.data_mut(|data| data.remove_temp::<Shared>(key()));
}

/// Lets the user export a plot by its own menu or key, and describes it if somebody collects.
pub fn offer(ui: &Ui, response: &Response, describe: impl FnOnce() -> Panel) {
    let mut wanted = response.has_focus() && ui.input(|input| input.key_pressed(Key::E));
    response.context_menu(|ui| wanted |= ui.button("Export this plot… (E)").clicked());
    if wanted {
        let title = describe().title;
        ui.data_mut(|data| data.insert_temp(wish(), title));
    } else {
        add(ui, describe);
    }
}

/// Describes what is drawn otherwise than as a plot, if somebody collects.
pub fn add(ui: &Ui, describe: impl FnOnce() -> Panel) {
    let Some(shared) = ui.data(|data| data.get_temp::<Shared>(key())) else { return };
    let frame = ui.ctx().cumulative_pass_nr();
    let mut collected = shared.lock();
    if collected.frame != frame {
        *collected = Collected { frame, panels: Vec::new() };
    }
    collected.panels.push(describe());
}

/// The title of the plot that the user wants to export, given once.
pub fn wanted(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(wish()))
}

/// Whether somebody collects.
pub fn is_collecting(ctx: &Context) -> bool {
    ctx.data(|data| data.get_temp::<Shared>(key()).is_some())
}
