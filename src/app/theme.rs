//! Design tokens: every colour, size and distance of the window stands here.
//!
//! A quantity has the same colour and dash in every screen. The colours have the hues of Okabe and Ito, which people with a
//! colour vision deficiency can tell apart; dash and label tell the same without colour.

use egui::style::{Selection, WidgetVisuals, Widgets};
use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, TextStyle, Theme, Visuals, vec2};

use crate::figure::Ink;
use crate::figure::colours::{self, Colours, Rgb};
pub use crate::figure::colours::{Dash, MEASURED_DASH, PREDICTED_DASH};

/// Distance between things that belong together \[points\].
pub const GAP: f32 = 8.0;
/// Distance between groups \[points\].
pub const GROUP: f32 = 16.0;
/// Rounding of cards and buttons \[points\].
pub const RADIUS: u8 = 6;

/// How much of its colour a chip has as its ground.
pub const CHIP: f32 = 0.08;

/// Size of a screen's headline \[points\].
pub const HEADLINE: f32 = 20.0;
/// Size of a card's title \[points\].
pub const TITLE: f32 = 14.5;
/// Size of running text \[points\].
pub const BODY: f32 = 13.0;
/// Size of axis labels and captions \[points\].
pub const SMALL: f32 = 11.0;

/// The colours of one theme.
#[derive(Debug, Clone, Copy)]
pub struct Palette {
    /// Behind everything.
    pub background: Color32,
    /// Behind groups of content.
    pub card: Color32,
    /// Behind plots.
    pub canvas: Color32,
    /// Borders of cards and plots.
    pub border: Color32,
    /// Lines of the grid of plots.
    pub grid: Color32,
    /// Text.
    pub text: Color32,
    /// Text of less weight.
    pub weak: Color32,
    /// The next step, links, selection.
    pub accent: Color32,
    /// Behind what is selected.
    pub accent_soft: Color32,
    /// Text on the accent colour.
    pub on_accent: Color32,
    /// Good news.
    pub good: Color32,
    /// What needs care.
    pub warning: Color32,
    /// What failed.
    pub error: Color32,
    /// Measured signals.
    pub measured: Color32,
    /// Predicted signals.
    pub predicted: Color32,
    /// Measured minus predicted.
    pub residual: Color32,
    /// Behind stretches that are held out.
    pub held_out: Color32,
    /// The shared cursor.
    pub cursor: Color32,
    series: [Color32; 7],
}

const fn ink([red, green, blue]: Rgb) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

const fn inks(series: [Rgb; 7]) -> [Color32; 7] {
    let [a, b, c, d, e, f, g] = series;
    [ink(a), ink(b), ink(c), ink(d), ink(e), ink(f), ink(g)]
}

const DARK: Palette = Palette {
    background: Color32::from_rgb(0x10, 0x12, 0x16),
    card: Color32::from_rgb(0x17, 0x1a, 0x20),
    canvas: ink(colours::DARK.canvas),
    border: ink(colours::DARK.border),
    grid: ink(colours::DARK.grid),
    text: ink(colours::DARK.text),
    weak: ink(colours::DARK.weak),
    accent: ink(colours::DARK.marked),
    accent_soft: Color32::from_rgb(0x1d, 0x30, 0x48),
    on_accent: Color32::from_rgb(0x0a, 0x14, 0x20),
    good: Color32::from_rgb(0x3f, 0xcf, 0xa0),
    warning: Color32::from_rgb(0xf0, 0xb4, 0x3c),
    error: Color32::from_rgb(0xff, 0x7b, 0x6b),
    measured: ink(colours::DARK.measured),
    predicted: ink(colours::DARK.predicted),
    residual: ink(colours::DARK.residual),
    held_out: ink(colours::DARK.held_out),
    cursor: ink(colours::DARK.cursor),
    series: inks(colours::DARK.series),
};

const LIGHT: Palette = Palette {
    background: Color32::from_rgb(0xf4, 0xf5, 0xf7),
    card: Color32::from_rgb(0xff, 0xff, 0xff),
    canvas: ink(colours::LIGHT.canvas),
    border: ink(colours::LIGHT.border),
    grid: ink(colours::LIGHT.grid),
    text: ink(colours::LIGHT.text),
    weak: ink(colours::LIGHT.weak),
    accent: ink(colours::LIGHT.marked),
    accent_soft: Color32::from_rgb(0xeb, 0xf3, 0xfd),
    on_accent: Color32::from_rgb(0xff, 0xff, 0xff),
    good: Color32::from_rgb(0x0b, 0x7a, 0x58),
    warning: Color32::from_rgb(0x96, 0x5f, 0x01),
    error: Color32::from_rgb(0xb8, 0x2c, 0x1c),
    measured: ink(colours::LIGHT.measured),
    predicted: ink(colours::LIGHT.predicted),
    residual: ink(colours::LIGHT.residual),
    held_out: ink(colours::LIGHT.held_out),
    cursor: ink(colours::LIGHT.cursor),
    series: inks(colours::LIGHT.series),
};

/// Dark, with more contrast.
const DARK_HIGH: Palette = Palette {
    background: Color32::from_rgb(0x00, 0x00, 0x00),
    card: Color32::from_rgb(0x06, 0x07, 0x09),
    canvas: Color32::from_rgb(0x00, 0x00, 0x00),
    border: Color32::from_rgb(0x9a, 0xa4, 0xb4),
    grid: Color32::from_rgb(0x3c, 0x43, 0x50),
    text: Color32::from_rgb(0xff, 0xff, 0xff),
    weak: Color32::from_rgb(0xd6, 0xdc, 0xe6),
    accent: Color32::from_rgb(0x8c, 0xc8, 0xff),
    accent_soft: Color32::from_rgb(0x10, 0x30, 0x55),
    on_accent: Color32::from_rgb(0x00, 0x00, 0x00),
    error: Color32::from_rgb(0xff, 0x99, 0x8b),
    measured: Color32::from_rgb(0xe2, 0xe7, 0xef),
    residual: Color32::from_rgb(0xeb, 0x9c, 0xc8),
    series: inks([
        [0x60, 0xbe, 0xf3],
        [0x3d, 0xca, 0x9b],
        [0xee, 0xa7, 0x1a],
        [0xf0, 0x9a, 0xc9],
        [0x98, 0xb2, 0xff],
        [0xfe, 0x9b, 0x71],
        [0xe8, 0xdf, 0x5e],
    ]),
    ..DARK
};

/// Light, with more contrast.
const LIGHT_HIGH: Palette = Palette {
    background: Color32::from_rgb(0xff, 0xff, 0xff),
    card: Color32::from_rgb(0xfe, 0xfe, 0xfe),
    canvas: Color32::from_rgb(0xff, 0xff, 0xff),
    border: Color32::from_rgb(0x3c, 0x42, 0x4e),
    grid: Color32::from_rgb(0xc4, 0xca, 0xd4),
    text: Color32::from_rgb(0x00, 0x00, 0x00),
    weak: Color32::from_rgb(0x2c, 0x32, 0x3c),
    accent: Color32::from_rgb(0x00, 0x42, 0x9a),
    good: Color32::from_rgb(0x00, 0x56, 0x3c),
    warning: Color32::from_rgb(0x70, 0x44, 0x00),
    error: Color32::from_rgb(0x96, 0x12, 0x06),
    measured: Color32::from_rgb(0x00, 0x00, 0x00),
    predicted: Color32::from_rgb(0x83, 0x37, 0x00),
    residual: Color32::from_rgb(0x8b, 0x23, 0x63),
    cursor: Color32::from_rgb(0x64, 0x4a, 0x00),
    series: inks([
        [0x00, 0x52, 0x83],
        [0x00, 0x5a, 0x41],
        [0x71, 0x43, 0x00],
        [0x89, 0x27, 0x63],
        [0x39, 0x3f, 0xb0],
        [0x83, 0x37, 0x00],
        [0x56, 0x4f, 0x00],
    ]),
    ..LIGHT
};

impl Palette {
    /// The colours of a theme.
    pub fn of(theme: Theme) -> &'static Palette {
        match theme {
            Theme::Dark => &DARK,
            Theme::Light => &LIGHT,
        }
    }

    /// The colours of the theme in which `ui` is drawn.
    pub fn in_ui(ui: &egui::Ui) -> &'static Palette {
        let visuals = ui.visuals();
        match (visuals.dark_mode, is_high(visuals)) {
            (true, false) => &DARK,
            (true, true) => &DARK_HIGH,
            (false, false) => &LIGHT,
            (false, true) => &LIGHT_HIGH,
        }
    }

    /// The same colours for figures.
    pub fn colours(&self) -> Colours {
        let rgb = |color: Color32| [color.r(), color.g(), color.b()];
        Colours {
            ground: rgb(self.card),
            canvas: rgb(self.canvas),
            border: rgb(self.border),
            grid: rgb(self.grid),
            text: rgb(self.text),
            weak: rgb(self.weak),
            measured: rgb(self.measured),
            predicted: rgb(self.predicted),
            residual: rgb(self.residual),
            held_out: rgb(self.held_out),
            marked: rgb(self.accent),
            cursor: rgb(self.cursor),
            series: self.series.map(rgb),
        }
    }

    /// The colour of an ink.
    pub fn color(&self, which: Ink) -> Color32 {
        match which {
            Ink::Measured => self.measured,
            Ink::Predicted => self.predicted,
            Ink::Residual => self.residual,
            Ink::Text => self.text,
            Ink::Weak => self.weak,
            Ink::Marked => self.accent,
            Ink::Cursor => self.cursor,
            Ink::Series(n) => self.nth(n).0,
            Ink::Model(_) => ink(self.colours().of(which)),
        }
    }

    /// Colour and dash of the n-th joint, effect or term.
    pub fn nth(&self, n: usize) -> (Color32, Dash) {
        (self.series[n % self.series.len()], Ink::Series(n).dash())
    }
}

/// The high contrast of a context is known by its ground, so that it is stored in one place only.
fn is_high(visuals: &Visuals) -> bool {
    visuals.panel_fill == if visuals.dark_mode { DARK_HIGH.background } else { LIGHT_HIGH.background }
}

/// Whether the context shows the high contrast.
pub fn is_high_contrast(ctx: &egui::Context) -> bool {
    is_high(&ctx.style_of(ctx.theme()).visuals)
}

/// High contrast for both themes, or the usual one.
pub fn set_contrast(ctx: &egui::Context, high: bool) {
    for (theme, usual, strong) in [(Theme::Dark, &DARK, &DARK_HIGH), (Theme::Light, &LIGHT, &LIGHT_HIGH)] {
        ctx.style_mut_of(theme, |style| style.visuals = visuals(theme, if high { strong } else { usual }));
    }
}

/// Gives the context both themes, the fonts and the sizes.
pub fn install(ctx: &egui::Context) {
    ctx.set_fonts(super::fonts::definitions());
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            style.visuals = visuals(theme, Palette::of(theme));
            let font = |size| FontId::new(size, FontFamily::Proportional);
            style.text_styles = [
                (TextStyle::Heading, font(HEADLINE)),
                (TextStyle::Body, font(BODY)),
                (TextStyle::Button, font(BODY)),
                (TextStyle::Small, font(SMALL)),
                (TextStyle::Monospace, font(BODY - 0.5)),
            ]
            .into();
            style.spacing.item_spacing = vec2(GAP, 6.0);
            style.spacing.button_padding = vec2(10.0, 5.0);
            style.spacing.interact_size = vec2(40.0, 26.0);
            style.spacing.menu_margin = Margin::same(6);
            style.spacing.window_margin = Margin::same(12);
            style.spacing.scroll.floating = false;
            style.spacing.scroll.foreground_color = false;
            style.spacing.scroll.bar_width = 6.0;
            style.spacing.scroll.bar_inner_margin = 6.0;
            style.interaction.selectable_labels = false;
            style.animation_time = 0.08;
        });
    }
}

fn visuals(theme: Theme, palette: &Palette) -> Visuals {
    let dark = theme == Theme::Dark;
    let mut visuals = if dark { Visuals::dark() } else { Visuals::light() };
    let towards_text = |share: f32| palette.card.lerp_to_gamma(palette.text, share);
    // Handles of sliders and scroll bars take `bg_fill`, buttons `weak_bg_fill`.
    let widget = |fill: Color32, border: Color32, text: Color32| WidgetVisuals {
        bg_fill: fill.lerp_to_gamma(palette.text, if dark { 0.12 } else { 0.08 }),
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, border),
        corner_radius: CornerRadius::same(RADIUS),
        fg_stroke: Stroke::new(1.0, text),
        expansion: 0.0,
    };
    visuals.widgets = Widgets {
        noninteractive: widget(palette.card, palette.border, palette.text),
        inactive: widget(towards_text(0.06), palette.border, palette.text),
        hovered: widget(towards_text(0.12), palette.weak, palette.text),
        active: widget(towards_text(0.18), palette.accent, palette.text),
        open: widget(towards_text(0.1), palette.border, palette.text),
    };
    visuals.selection = Selection { bg_fill: palette.accent_soft, stroke: Stroke::new(1.0, palette.accent) };
    visuals.panel_fill = palette.background;
    visuals.window_fill = palette.card;
    visuals.window_stroke = Stroke::new(1.0, palette.border);
    visuals.window_corner_radius = CornerRadius::same(RADIUS + 2);
    visuals.menu_corner_radius = CornerRadius::same(RADIUS);
    let shadow =
        Shadow { offset: [0, 4], blur: 16, spread: 0, color: Color32::from_black_alpha(if dark { 110 } else { 40 }) };
    visuals.window_shadow = shadow;
    visuals.popup_shadow = shadow;
    visuals.extreme_bg_color = palette.canvas;
    visuals.faint_bg_color = towards_text(0.03);
    visuals.code_bg_color = towards_text(0.06);
    visuals.hyperlink_color = palette.accent;
    visuals.warn_fg_color = palette.warning;
    visuals.error_fg_color = palette.error;
    visuals.weak_text_color = Some(palette.weak);
    visuals.slider_trailing_fill = true;
    visuals
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(color: Color32) -> f32 {
        let rgba = egui::Rgba::from(color);
        0.2126 * rgba.r() + 0.7152 * rgba.g() + 0.0722 * rgba.b()
    }

    /// Contrast ratio of the Web Content Accessibility Guidelines.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        a.max(b) / a.min(b)
    }

    /// Texts and marks stand out from every ground on which they are drawn, twice as much as asked for by the guidelines of
    /// high contrast where that is chosen.
    #[test]
    fn texts_and_marks_stand_out_from_their_ground_in_every_theme() {
        for (theme, palette, least) in [
            ("dark", &DARK, 4.5),
            ("light", &LIGHT, 4.5),
            ("dark high", &DARK_HIGH, 7.0),
            ("light high", &LIGHT_HIGH, 7.0),
        ] {
            let stands_out = |ink: Color32, ground: Color32, what: &str| {
                let ratio = contrast(ink, ground);
                assert!(ratio >= least, "{theme}: {what} {ink:?} on {ground:?} has only {ratio:.2}");
            };
            let inks = [palette.text, palette.weak, palette.accent, palette.good, palette.warning, palette.error];
            let marks = [palette.measured, palette.predicted, palette.residual, palette.cursor];
            let marks = || palette.series.iter().copied().chain(marks);
            for ground in [palette.background, palette.card, palette.canvas] {
                inks.into_iter().for_each(|ink| stands_out(ink, ground, "text"));
                marks().for_each(|mark| stands_out(mark, ground, "mark"));
            }
            marks().for_each(|mark| stands_out(mark, palette.held_out, "held-out mark"));
            for ink in inks.into_iter().chain(marks()) {
                stands_out(ink, palette.card.lerp_to_gamma(ink, CHIP), "chip");
            }
            stands_out(palette.on_accent, palette.accent, "next step");
            let own = visuals(if theme.starts_with("dark") { Theme::Dark } else { Theme::Light }, palette);
            for widget in [&own.widgets.inactive, &own.widgets.hovered, &own.widgets.active, &own.widgets.open] {
                stands_out(widget.fg_stroke.color, widget.weak_bg_fill, "button");
            }
            stands_out(palette.accent, palette.accent_soft, "selection");
            stands_out(palette.text, palette.accent_soft, "selection");
        }
    }
}
