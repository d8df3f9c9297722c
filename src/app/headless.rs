//! The same window without a display: frames until it is settled, then a picture.

use std::str::FromStr;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use egui::{FullOutput, Pos2, RawInput, Rect, ViewportId, vec2};

use super::desk::{Change, ExportPage};
use super::raster::{Picture, Raster};
use super::theme;
use super::{About, Order, Shown, TorquescopeApp, screens};
use crate::figure::Panel;
use crate::session::{Session, View};

/// Frames that are drawn when nothing is at work any more, since egui measures in one what it uses in the next.
const FEWEST_FRAMES: usize = 4;
/// Longest wait for jobs: a guard against those that never end, out of reach of a machine that is merely busy.
pub(super) const PATIENCE: Duration = Duration::from_secs(1800);
/// Largest side of a picture \[pixels\].
const LARGEST_SIDE: f32 = 16384.0;

/// Light or dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Look {
    /// Dark text on light ground.
    Light,
    /// Light text on dark ground.
    #[default]
    Dark,
}

impl FromStr for Look {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "light" => Ok(Look::Light),
            "dark" => Ok(Look::Dark),
            other => Err(format!("there is no theme `{other}`: choose light or dark")),
        }
    }
}

impl From<Look> for egui::Theme {
    fn from(look: Look) -> Self {
        match look {
            Look::Light => egui::Theme::Light,
            Look::Dark => egui::Theme::Dark,
        }
    }
}

/// What a screenshot shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenshotOptions {
    /// Name of the screen, one of [`screens::all`].
    pub screen: String,
    /// Light or dark.
    pub theme: Look,
    /// Size of the window \[points at a text scale of 1\].
    pub size: [f32; 2],
    /// Pixels per point.
    pub scale: f32,
    /// Size of text and everything else, 0.8 to 2.
    pub text_scale: f32,
    /// Which experiment the screen of experiments shows.
    pub experiment: Option<Shown>,
    /// Whether it has more contrast.
    pub contrast: bool,
    /// Which panel of the screen stands in front of its tabs; `None` as it is.
    pub panel: Option<String>,
    /// What lies over the screen.
    pub over: Option<Over>,
}

/// What can lie over a screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// How plots are exported.
    Export,
    /// How a report is written.
    Report,
    /// How a model is exported.
    ModelOut,
    /// How data are exported.
    DataOut,
    /// All models of the session.
    Models,
    /// All lessons.
    Lessons,
    /// Every command by its name.
    Commands,
    /// What the columns of the log are.
    Columns,
}

impl Over {
    fn order(self, session: &Session) -> anyhow::Result<Order> {
        Ok(match self {
            Over::Export => Order::Export(None),
            Over::Report => Order::AskExport(ExportPage::Report),
            Over::ModelOut => Order::AskExport(ExportPage::Model),
            Over::DataOut => Order::AskExport(ExportPage::Data),
            Over::Models => Order::Models(true),
            Over::Lessons => Order::Lessons(true),
            Over::Commands => Order::Palette(true),
            Over::Columns => match session.source.as_deref().map(|source| (source.files(), &source.options)) {
                Some((Some(paths), options)) => Order::Import(paths.to_vec(), Box::new(options.clone())),
                _ => bail!("only a log that was read from a file has columns: name one"),
            },
        })
    }
}

impl Default for ScreenshotOptions {
    fn default() -> Self {
        ScreenshotOptions {
            screen: "data".to_owned(),
            theme: Look::default(),
            size: [1600.0, 1000.0],
            scale: 1.0,
            text_scale: 1.0,
            experiment: None,
            contrast: false,
            panel: None,
            over: None,
        }
    }
}

/// A picture of one screen as PNG, as somebody looked at it.
///
/// # Errors
/// If there is no such screen, the size can't be, or the window does not settle.
pub fn screenshot(session: Session, view: View, options: &ScreenshotOptions) -> anyhow::Result<Vec<u8>> {
    let mut app = TorquescopeApp::looking_at(session, view);
    let screen = screens::find(&options.screen)?;
    if let Some(shown) = &options.experiment {
        app.order(Order::Experiment(shown.clone()));
    }
    app.order(Order::Show(screen));
    app.order(Order::HighContrast(options.contrast));
    let picture = render(&mut app, options)?;
    picture.png().context("the picture can't be written as PNG")
}

/// The plots of one screen with all samples in view, of the trajectory and the models that somebody looked at.
pub fn plots(session: Session, view: View, screen: &About) -> Vec<Panel> {
    let mut app = TorquescopeApp::looking_at(session, view);
    app.show_screen(screen);
    app.figure().panels
}

impl TorquescopeApp {
    /// The window without a display, as somebody looked at the session.
    pub fn looking_at(session: Session, view: View) -> Self {
        let mut app = TorquescopeApp::new(session);
        app.look(view);
        app
    }
}

/// Runs an app until nothing moves any more and draws its last frame.
///
/// # Errors
/// If the size can't be, or the window does not settle.
pub fn render(app: &mut TorquescopeApp, options: &ScreenshotOptions) -> anyhow::Result<Picture> {
    let ScreenshotOptions { size: [width, height], scale, .. } = *options;
    let fits = |side: f32| (64.0..=LARGEST_SIDE).contains(&(side * scale));
    if !(fits(width) && fits(height) && scale > 0.0) {
        bail!(
            "a picture of {width}x{height} at scale {scale} can't be drawn: each side needs 64 to {LARGEST_SIDE} pixels"
        );
    }
    let ctx = egui::Context::default();
    let mut raster = Raster::default();
    let output = settle(&ctx, app, options, |output| raster.update_textures(&mut output.textures_delta))?;
    let primitives = ctx.tessellate(output.shapes, output.pixels_per_point);
    let pixels = [width, height].map(|side| (side * scale).round() as usize);
    let ground = ctx.global_style().visuals.panel_fill;
    Ok(raster.paint(&primitives, pixels, output.pixels_per_point, ground))
}

/// What brings the panel that is asked for in front of its tabs.
fn in_front(app: &TorquescopeApp, options: &ScreenshotOptions) -> anyhow::Result<Option<Order>> {
    let Some(name) = &options.panel else { return Ok(None) };
    let known: Vec<&str> = app.panels.panels().into_iter().map(|(known, _)| known).collect();
    if !known.contains(&name.as_str()) {
        bail!("the screen {} has no panel `{name}`; it has: {}", options.screen, known.join(", "));
    }
    Ok(Some(Order::Panel(name.clone(), Change::Show)))
}

/// Frames until nothing moves any more; of each the output is seen, the last is given.
fn settle(
    ctx: &egui::Context,
    app: &mut TorquescopeApp,
    options: &ScreenshotOptions,
    mut see: impl FnMut(&mut FullOutput),
) -> anyhow::Result<FullOutput> {
    let ScreenshotOptions { theme, size: [width, height], scale, text_scale, .. } = *options;
    theme::install(ctx);
    ctx.set_theme(egui::Theme::from(theme));
    ctx.set_zoom_factor(text_scale);
    ctx.all_styles_mut(|style| style.animation_time = 0.0);
    let begin = Instant::now();
    let mut at_rest = 0;
    for frame in 0.. {
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height) / text_scale)),
            time: Some(frame as f64 / 60.0),
            ..RawInput::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(scale);
        }
        let mut output = ctx.run_ui(input, |ui| {
            app.receive(ui.ctx());
            app.draw(ui);
        });
        see(&mut output);
        // Panels can be moved once they were drawn.
        if frame == 0 {
            let over = options.over.map(|over| over.order(app.session())).transpose()?;
            app.orders.extend(in_front(app, options)?.into_iter().chain(over));
        }
        at_rest = if app.is_busy() || !app.orders.is_empty() { 0 } else { at_rest + 1 };
        if at_rest >= FEWEST_FRAMES {
            return Ok(output);
        }
        if begin.elapsed() > PATIENCE {
            bail!("the window did not settle within {} s", PATIENCE.as_secs());
        }
        if app.is_busy() {
            crate::work::pause();
        }
    }
    bail!("no frame was drawn")
}
