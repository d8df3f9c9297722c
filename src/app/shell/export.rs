//! Export: the plots of the screen, or one of them, a report of the session, a model, or data, as files.

use std::path::Path;

use egui::{Button, ComboBox, DragValue, RichText, ScrollArea, Ui, WidgetInfo, vec2};

use super::data_out::{self, AskedData};
use super::ending;
use super::frame::Shell;
use super::hanging::hanging;
use super::model_out::{self, AskedModel};
use super::preview::Preview;
use super::primary::primary;
use super::reporting::{self, Report};
use crate::app::desk::{About, Desk, Drawing, ExportPage, Order};
use crate::app::plot::export;
use crate::app::theme::{GAP, GROUP, Palette, SMALL};
use crate::app::widgets;
use crate::figure::{Family, Figure, Format, Legend, Panel, Size, Style, Theme};
use crate::session::Session;

const FORMATS: [(Format, &str, &str); 4] = [
    (Format::Svg, "SVG", "svg"),
    (Format::Pdf, "PDF", "pdf"),
    (Format::Png, "PNG", "png"),
    (Format::Csv, "CSV: the numbers", "csv"),
];
const THEMES: [(Theme, &str); 4] =
    [(Theme::Print, "for print"), (Theme::Grey, "grey"), (Theme::Light, "light"), (Theme::Dark, "dark")];
/// Plots beside each other, as far as they can be told apart.
const COLUMNS: std::ops::RangeInclusive<usize> = 1..=4;
/// Width of the questions, and room of the picture beside them \[points\].
const QUESTIONS: f32 = 470.0;
const PICTURE: f32 = 430.0;

/// A plot that can be exported.
struct Plot {
    panel: Panel,
    /// Its place on the screen.
    number: usize,
    is_wanted: bool,
}

/// What is exported and how, while it is asked.
pub struct Exporting {
    page: ExportPage,
    report: Report,
    model: AskedModel,
    data: AskedData,
    /// Only the plot of this title.
    only: Option<String>,
    /// The plots of the screen in the order in which they are drawn; `None` until all is computed.
    plots: Option<Vec<Plot>>,
    /// How many of them stand beside each other where nobody says.
    columns: usize,
    format: Format,
    style: Style,
    /// Whether the plots of every screen are written, a file for each.
    all: bool,
    preview: Preview,
    /// Where to.
    path: String,
}

impl Exporting {
    /// Asks about the plots of a screen, or one of them.
    pub fn new(session: &Session, screen: &About, only: Option<String>) -> Self {
        let name = session.recording.as_ref().map_or("torquescope", |recording| &recording.name);
        let plain = |letter: char| if letter.is_alphanumeric() { letter } else { '-' };
        let name: String = name.chars().map(plain).collect();
        Exporting {
            page: ExportPage::Plots,
            report: Report::new(&name),
            model: AskedModel::new(&name, session),
            data: AskedData::new(&name),
            only,
            plots: None,
            columns: 1,
            format: Format::Svg,
            style: Style::default(),
            all: false,
            preview: Preview::default(),
            path: format!("{name}-{}.svg", screen.id),
        }
    }

    /// Asks about this page first.
    pub fn at(page: ExportPage, session: &Session, screen: &About) -> Self {
        Exporting { page, ..Exporting::new(session, screen, None) }
    }

    /// Where it goes, as it is typed.
    pub fn path(&self) -> &str {
        match self.page {
            ExportPage::Plots => &self.path,
            ExportPage::Report => &self.report.path,
            ExportPage::Model => &self.model.path,
            ExportPage::Data => &self.data.path,
        }
    }

    /// It goes into this file.
    pub fn set_path(&mut self, path: &Path) {
        let path = path.display().to_string();
        match self.page {
            ExportPage::Plots => {
                ending::follow(&FORMATS, &mut self.format, &path);
                self.path = path;
            }
            ExportPage::Report => self.report.set_path(path),
            ExportPage::Model => self.model.set_path(path),
            ExportPage::Data => self.data.set_path(path),
        }
    }

    /// The model goes into the file of this robot.
    pub fn set_robot(&mut self, path: &Path) {
        self.model.into = path.display().to_string();
    }

    /// This session stands beside the present one.
    pub fn set_beside(&mut self, path: &Path) {
        self.report.beside = Some(path.display().to_string());
    }

    /// Whether its picture is being drawn.
    pub fn is_busy(&self) -> bool {
        self.preview.is_busy()
    }

    /// The plots that are wanted, in their order.
    fn wanted(&self) -> impl Iterator<Item = &Plot> {
        self.plots.iter().flatten().filter(|plot| plot.is_wanted)
    }

    fn figure(&self) -> Figure {
        Figure { panels: self.wanted().map(|plot| plot.panel.clone()).collect(), columns: self.columns }
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
        let plot = |(number, panel): (usize, Panel)| Plot { number, is_wanted: is_wanted(&panel), panel };
        open.plots = Some(desk.focus.views.seen(panels).into_iter().enumerate().map(plot).collect());
        open.columns = screens.columns(desk);
    }
    let room = ui.ctx().content_rect();
    let mut closes = false;
    let modal = hanging("export").show(ui.ctx(), |ui| {
        let width = (room.width() - 80.0).min(QUESTIONS + PICTURE);
        ui.set_width(width);
        ui.horizontal_top(|ui| {
            let has_plots =
                open.page == ExportPage::Plots && open.plots.as_ref().is_some_and(|plots| !plots.is_empty());
            let questions = if has_plots && width > QUESTIONS + PICTURE / 2.0 { QUESTIONS } else { width };
            ui.allocate_ui(vec2(questions, 0.0), |ui| {
                ui.vertical(|ui| {
                    let height = room.height() - 60.0;
                    let area =
                        ScrollArea::vertical().id_salt("questions").max_height(height).min_scrolled_height(height);
                    area.show(ui, |ui| {
                        ui.set_width(questions - GAP);
                        ui.heading("Export");
                        ui.horizontal_wrapped(|ui| {
                            let plots = format!("Plots of {}", screens.shown().title);
                            ui.selectable_value(&mut open.page, ExportPage::Plots, plots);
                            ui.selectable_value(&mut open.page, ExportPage::Report, "Report");
                            ui.selectable_value(&mut open.page, ExportPage::Model, "A model");
                            ui.selectable_value(&mut open.page, ExportPage::Data, "Recording or torques");
                        });
                        ui.add_space(GAP);
                        closes = match open.page {
                            ExportPage::Plots => ask(ui, desk, &mut open),
                            ExportPage::Report => reporting::ask(ui, desk, &mut open.report),
                            ExportPage::Model => model_out::ask(ui, desk, &mut open.model),
                            ExportPage::Data => data_out::ask(ui, desk, &mut open.data),
                        };
                    });
                });
            });
            if questions < width {
                let picture = vec2(width - questions - GAP, room.height() - 120.0);
                ui.vertical(|ui| preview(ui, &mut open, picture));
            }
        });
    });
    if !closes && !modal.should_close() {
        *exporting = Some(open);
    }
}

/// What the file would show.
fn preview(ui: &mut Ui, open: &mut Exporting, room: egui::Vec2) {
    let mut drawn = std::mem::take(&mut open.preview);
    let chosen = open.wanted().map(|plot| plot.number).collect();
    drawn.show(ui, chosen, &open.style, || open.figure(), room);
    open.preview = drawn;
}

/// Which plots are wanted, and in which order.
fn list(ui: &mut Ui, plots: &mut [Plot]) {
    let (mut moved, last) = (None, plots.len() - 1);
    for (place, plot) in plots.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            for (sign, way, to, can) in
                [("↑", "up", place.wrapping_sub(1), place > 0), ("↓", "down", place + 1, place < last)]
            {
                let button = ui.add_enabled(can, Button::new(sign).small());
                let spoken = format!("move {way}: {}", plot.panel.title);
                button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, can, &spoken));
                if button.on_hover_text("The order in which the plots are drawn").clicked() {
                    moved = Some((place, to));
                }
            }
            ui.checkbox(&mut plot.is_wanted, &plot.panel.title);
        });
    }
    if let Some((from, to)) = moved {
        plots.swap(from, to);
    }
}

/// How the page is laid out, of a figure that has so many columns where nobody says.
fn layout(ui: &mut Ui, style: &mut Style, usual: usize) {
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Columns");
        let mut columns = style.columns.unwrap_or(usual);
        let range = *COLUMNS.start()..=usual.max(*COLUMNS.end());
        if ui.add(DragValue::new(&mut columns).range(range)).labelled_by(label.id).changed() {
            style.columns = Some(columns);
        }
        maybe(ui, "Height of a plot", " mm", &mut style.height, [10.0, 300.0, 40.0]);
        maybe(ui, "Letters", " pt", &mut style.letter, [4.0, 30.0, 8.0]);
    });
    ui.horizontal_wrapped(|ui| {
        for (family, name) in [(Family::Sans, "sans serif"), (Family::Serif, "serif")] {
            ui.radio_value(&mut style.family, family, name);
        }
        ui.add_space(GROUP);
        ui.checkbox(&mut style.lettered, "(a) (b)").on_hover_text("Calls the plots by letters");
        ui.checkbox(&mut style.shaded, "Shade").on_hover_text("Behind what is held out");
        let mut is_shared = style.legend == Legend::Shared;
        if ui.checkbox(&mut is_shared, "One legend").on_hover_text("Above all plots, for all of them").changed() {
            style.legend = if is_shared { Legend::Shared } else { Legend::Own };
        }
    });
}

/// A number that is as the figure has it until somebody says otherwise.
fn maybe(ui: &mut Ui, name: &str, unit: &str, value: &mut Option<f64>, [least, most, usual]: [f64; 3]) {
    let mut own = value.is_some();
    if ui.checkbox(&mut own, name).changed() {
        *value = own.then_some(usual);
    }
    if let Some(value) = value {
        let drag = ui.add(DragValue::new(value).range(least..=most).max_decimals(1).suffix(unit));
        drag.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, name));
    }
}

/// The questions, and whether they are answered.
fn ask(ui: &mut Ui, desk: &mut Desk, open: &mut Exporting) -> bool {
    let palette = Palette::in_ui(ui);
    let figure = open.figure();
    let Exporting { plots, columns, format, style, all, path, .. } = open;
    let plots = plots.get_or_insert_default();
    if plots.is_empty() {
        widgets::weak(ui, "This screen shows no plot yet.");
        return ui.button("Close").clicked();
    }
    // However many there are, what follows stays in sight.
    let height = (ui.ctx().content_rect().height() - 560.0).clamp(70.0, 330.0);
    let area = ScrollArea::vertical().id_salt("plots").max_height(height).min_scrolled_height(height);
    area.show(ui, |ui| list(ui, plots));
    ui.add_space(GAP);
    ending::choose(ui, &FORMATS, format, path);
    ui.add_enabled_ui(*format != Format::Csv, |ui| {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Size");
            let chooser =
                ComboBox::from_id_salt("size").selected_text(style.size.about()).width(260.0).show_ui(ui, |ui| {
                    for size in Size::ALL {
                        ui.selectable_value(&mut style.size, size, size.about());
                    }
                });
            chooser.response.labelled_by(label.id);
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
        layout(ui, style, *columns);
    });
    ui.add_space(GAP);
    ending::ask(ui, &FORMATS, format, path, *all);
    ui.checkbox(all, "Every screen, a file for each in a folder of this name");
    let text = match all {
        true => "Every screen as it is now, with its zoom; what was never computed is left out.",
        false => "All samples that are in view, in their full precision; equal plots give equal files.",
    };
    ui.label(RichText::new(text).size(SMALL).color(palette.weak));
    ui.add_space(GAP);
    let has_plots = !figure.panels.is_empty();
    let ready = if *all { !path.trim().is_empty() } else { has_plots && ending::is_named(&FORMATS, path) };
    ui.horizontal_wrapped(|ui| {
        let write = primary(ui, ready, "Write the file");
        write.widget_info(|| WidgetInfo::labeled(egui::Role::Button, ready, "Write the file"));
        if write.on_disabled_hover_text("Choose a plot and name a file").clicked() {
            let file = std::path::PathBuf::from(path.trim());
            let (figure, path) = match all {
                true => (None, file.with_extension("")),
                false => (Some(figure), file),
            };
            let drawing = Drawing { figure, format: *format, style: *style, path };
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
