//! The plots of a screen as figures: what is drawn while somebody collects is also described as [`Panel`].

use std::sync::Arc;

use egui::mutex::Mutex;
use egui::{Context, Id, Ui};

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

/// From now on plots are described, too.
pub fn begin(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(key(), Shared::default()));
}

/// The plots of the last frame, in the order in which they were drawn.
pub fn panels(ctx: &Context) -> Vec<Panel> {
    let shared = ctx.data(|data| data.get_temp::<Shared>(key()));
    shared.map(|shared| shared.lock().panels.clone()).unwrap_or_default()
}

/// Describes a plot, if somebody collects.
pub fn offer(ui: &Ui, describe: impl FnOnce() -> Panel) {
    let Some(shared) = ui.data(|data| data.get_temp::<Shared>(key())) else { return };
    let frame = ui.ctx().cumulative_pass_nr();
    let mut collected = shared.lock();
    if collected.frame != frame {
        *collected = Collected { frame, panels: Vec::new() };
    }
    collected.panels.push(describe());
}
