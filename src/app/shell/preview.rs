//! What a file would show, drawn beside the questions of the export while they are answered.

use egui::{ColorImage, RichText, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, vec2};

use crate::app::theme::{Palette, SMALL};
use crate::figure::{self, Figure, FigureError, Pixels, Style};
use crate::work::{Job, Outcome};

/// Pixels per inch of the picture: as many as a screen shows.
const DPI: f64 = 110.0;

/// Largest side of the picture \[pixels\]: what every graphics card takes.
const LARGEST: f64 = 2000.0;

/// The picture of what is chosen, as soon as it is drawn; the one before it meanwhile.
#[derive(Default)]
pub struct Preview {
    /// What is drawn or was drawn last: which plots in which order, and how.
    asked: Option<(Vec<usize>, Style)>,
    job: Option<Job<Pixels>>,
    shown: Option<Result<TextureHandle, String>>,
}

impl Preview {
    /// Whether it is being drawn.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Draws the figure of these choices within this room.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        chosen: Vec<usize>,
        style: &Style,
        figure: impl FnOnce() -> Figure,
        room: Vec2,
    ) {
        let style = Style { dpi: DPI, ..*style };
        let asks = (chosen, style);
        if self.asked.as_ref() != Some(&asks) {
            let (context, figure, style) = (ui.ctx().clone(), figure(), asks.1);
            let wake = move || context.request_repaint();
            self.job = Some(Job::spawn("preview", wake, move |_| drawn(&figure, &style)));
            self.asked = Some(asks);
        }
        if let Some(outcome) = self.job.as_mut().and_then(Job::poll) {
            self.job = None;
            self.shown = Some(match outcome {
                Outcome::Done(Pixels { size, rgba }) => {
                    let image = ColorImage::from_rgba_premultiplied(size, &rgba);
                    Ok(ui.ctx().load_texture("preview", image, TextureOptions::LINEAR))
                }
                Outcome::Failed(reason) | Outcome::Stopped(reason) | Outcome::Panicked(reason) => Err(reason),
            });
        }
        match &self.shown {
            Some(Ok(texture)) => {
                let size = texture.size_vec2();
                let scale = (room.x / size.x).min(room.y / size.y).min(1.0);
                let image = ui.add(egui::Image::new((texture.id(), vec2(size.x, size.y) * scale)));
                image.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, "preview of the figure"));
            }
            Some(Err(reason)) => {
                ui.label(RichText::new(format!("{reason}.")).size(SMALL).color(Palette::in_ui(ui).weak));
            }
            None => {
                ui.label(RichText::new("The figure is being drawn…").size(SMALL).color(Palette::in_ui(ui).weak));
            }
        }
    }
}

/// The pixels of a figure, of a long one fewer.
fn drawn(figure: &Figure, style: &Style) -> Result<Pixels, FigureError> {
    let pixels = figure::pixels(figure, style)?;
    let side = pixels.size[0].max(pixels.size[1]) as f64;
    if side <= LARGEST {
        return Ok(pixels);
    }
    figure::pixels(figure, &Style { dpi: style.dpi * LARGEST / side, ..*style })
}
