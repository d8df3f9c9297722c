//! Export: the plots of the screen, or one of them, as a file.

use egui::{Button, DragValue, Modal, RichText, ScrollArea, TextEdit, Ui, WidgetInfo};

use super::frame::Shell;
use super::primary::primary;
use crate::app::desk::{About, Desk, Drawing, Order};
use crate::app::plot::export;
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::widgets;
use crate::figure::{Figure, Format, Panel, Size, Style, Theme};
use crate::session::Session;

const FORMATS: [(Format, &str, &str); 4] = [
    (Format::Svg, "SVG", "svg"),
    (Format::Pdf, "PDF", "pdf"),
    (Format::Png, "PNG", "png"),
    (Format::Csv, "CSV: the numbers", "csv"),
];
const SIZES: [(Size, &str); 3] =
    [(Size::OneColumn, "one column, 85 mm"), (Size::TwoColumn, "two columns, 175 mm"), (Size::Slide, "slide")];
const THEMES: [(Theme, &str); 3] = [(Theme::Print, "for print"), (Theme::Light, "light"), (Theme::Dark, "dark")];

/// What is exported and how, while it is asked.
#[derive(Debug)]
pub struct Exporting {
    /// Only the plot of this title.
    only: Option<String>,
    /// The plots of the screen, and which are wanted; `None` until all is computed.
    plots: Option<Vec<(Panel, bool)>>,
    format: Format,
    style: Style,
    /// Where to.
    pub path: String,
}

impl Exporting {
    /// Asks about the plots of a screen, or one of them.
    pub fn new(session: &Session, screen: &About, only: Option<String>) -> Self {
        let name = session.recording.as_ref().map_or("torquescope", |recording| &recording.name);
        let plain = |letter: char| if letter.is_alphanumeric() { letter } else { '-' };
        let name: String = name.chars().map(plain).collect();
        let path = format!("{name}-{}.svg", screen.id);
        Exporting { only, plots: None, format: Format::Svg, style: Style::default(), path }
    }
}

/// The dialog, while it is open.
pub fn show(ui: &mut Ui, shell: &mut Shell, exporting: &mut Option<Exporting>) {
    if let Some(title) = export::wanted(ui.ctx()) {
        shell.desk.orders.push(Order::Export(Some(title)));
    }
    // What is still being computed belongs to the plots, too.
    let waits = exporting.as_ref().is_some_and(|open| open.plots.is_none()) && shell.desk.memo.is_busy();
    let Some(mut open) = exporting.take_if(|_| !waits) else { return };
    let Shell { desk, screens, .. } = shell;
    if open.plots.is_none() {
        let panels = screens.figures(desk);
        let is_wanted = |panel: &Panel| open.only.as_ref().is_none_or(|title| *title == panel.title);
        let with_wish = |panel: Panel| {
            let on = is_wanted(&panel);
            (panel, on)
        };
        open.plots = Some(desk.focus.views.seen(panels).into_iter().map(with_wish).collect());
    }
    let room = ui.ctx().content_rect();
    let mut closes = false;
    let modal = Modal::new(egui::Id::unique("export")).show(ui.ctx(), |ui| {
        ui.set_width((room.width() - 80.0).min(520.0));
        closes = ask(ui, desk, screens.shown(), &mut open);
    });
    if !closes && !modal.should_close() {
        *exporting = Some(open);
    }
}

/// The questions, and whether they are answered.
fn ask(ui: &mut Ui, desk: &mut Desk, screen: &About, open: &mut Exporting) -> bool {
    let palette = Palette::in_ui(ui);
    let Exporting { plots, format, style, path, .. } = open;
    let plots = plots.get_or_insert_default();
    ui.heading(format!("Export: {}", screen.title));
    if plots.is_empty() {
        widgets::weak(ui, "This screen shows no plot yet.");
        return ui.button("Close").clicked();
    }
    ui.add_space(GAP);
    // However many there are, what follows stays in sight.
    let height = (ui.ctx().content_rect().height() - 430.0).clamp(70.0, 330.0);
    let list = ScrollArea::vertical().id_salt("plots").max_height(height).min_scrolled_height(height);
    list.show(ui, |ui| {
        for (panel, on) in plots.iter_mut() {
            ui.checkbox(on, &panel.title);
        }
    });
    ui.add_space(GAP);
    ui.horizontal_wrapped(|ui| {
        for (choice, name, ending) in FORMATS {
            if ui.radio_value(format, choice, name).clicked() {
                *path = std::path::Path::new(&*path).with_extension(ending).to_string_lossy().into_owned();
            }
        }
    });
    ui.add_enabled_ui(*format != Format::Csv, |ui| {
        ui.horizontal_wrapped(|ui| {
            for (size, name) in SIZES {
                ui.radio_value(&mut style.size, size, name);
            }
        });
        ui.horizontal_wrapped(|ui| {
            for (theme, name) in THEMES {
                ui.radio_value(&mut style.theme, theme, name);
            }
            ui.add_space(GROUP);
            let label = ui.label("Pixels per inch");
            let dpi = DragValue::new(&mut style.dpi).range(36.0..=1200.0).max_decimals(0);
            ui.add_enabled(*format == Format::Png, dpi).labelled_by(label.id);
        });
    });
    ui.add_space(GAP);
    let label = ui.label("File");
    ui.add(TextEdit::singleline(path).desired_width(f32::INFINITY)).labelled_by(label.id);
    let text = "All samples that are in view, in their full precision; equal plots give equal files.";
    ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    ui.add_space(GAP);
    let chosen = plots.iter().filter(|(_, on)| *on).count();
    let ready = chosen > 0 && !path.trim().is_empty();
    ui.horizontal_wrapped(|ui| {
        let write = primary(ui, ready, "Write the file");
        write.widget_info(|| WidgetInfo::labeled(egui::Role::Button, ready, "Write the file"));
        if write.on_disabled_hover_text("Choose a plot and name a file").clicked() {
            let panels = plots.iter().filter(|(_, on)| *on).map(|(panel, _)| panel.clone()).collect();
            let drawing =
                Drawing { figure: Figure::new(panels), format: *format, style: *style, path: path.trim().into() };
            desk.orders.push(Order::Draw(Box::new(drawing)));
            return true;
        }
        if ui.add(Button::new("Choose a file…")).clicked() {
            desk.orders.push(Order::ExportDialog);
        }
        ui.button("Cancel").clicked()
    })
    .inner
}
