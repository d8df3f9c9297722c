//! What the window remembers from one start to the next: how it looks, where its panels are, what was opened of late, and how logs were mapped.

use egui::{Context, ThemePreference};
use serde::{Deserialize, Serialize};

use super::desk::{Layouts, Recents, Templates};
use super::theme;

/// The user's choices.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    theme: ThemePreference,
    high_contrast: bool,
    text_scale: f32,
    pub(super) layouts: Layouts,
    pub(super) recent: Recents,
    pub(super) templates: Templates,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            theme: ThemePreference::default(),
            high_contrast: false,
            text_scale: 1.0,
            layouts: Layouts::default(),
            recent: Recents::default(),
            templates: Templates::default(),
        }
    }
}

impl Settings {
    /// As the window looks now.
    pub(super) fn of(ctx: &Context, layouts: Layouts, recent: Recents, templates: Templates) -> Self {
        Settings {
            theme: ctx.options(|options| options.theme_preference),
            high_contrast: theme::is_high_contrast(ctx),
            text_scale: ctx.zoom_factor(),
            layouts,
            recent,
            templates,
        }
    }

    /// Lets the window look so.
    pub(super) fn apply(&self, ctx: &Context) {
        ctx.set_theme(self.theme);
        theme::set_contrast(ctx, self.high_contrast);
        ctx.set_zoom_factor(self.text_scale);
    }
}
