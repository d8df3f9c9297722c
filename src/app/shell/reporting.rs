//! What the dialog of exports asks about a report: of this session, or of two side by side on one page.

use std::path::Path;

use egui::{RichText, TextEdit, Ui, WidgetInfo};

use super::ending;
use super::primary::primary;
use crate::app::desk::{Desk, Order, ReportFormat, Reporting};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;

/// A report, while it is asked about.
pub struct Report {
    format: ReportFormat,
    /// Where to, as it is typed.
    pub path: String,
    /// The saved session that stands beside this one, as it is typed; `None` if none does.
    pub beside: Option<String>,
}

impl Report {
    /// The report of a recording of this name, beside whatever is there already.
    pub fn new(name: &str) -> Self {
        let numbered = (2..).map(|number| format!("{name}-report-{number}.html"));
        let mut paths = std::iter::once(format!("{name}-report.html")).chain(numbered);
        let path = paths.find(|path| !Path::new(path).exists()).unwrap_or_default();
        Report { format: ReportFormat::Html, path, beside: None }
    }

    /// It goes into this file.
    pub fn set_path(&mut self, path: String) {
        ending::follow(&ReportFormat::ALL, &mut self.format, &path);
        self.path = path;
    }
}

/// The questions, and whether they are answered.
pub fn ask(ui: &mut Ui, desk: &mut Desk, report: &mut Report) -> bool {
    let Report { format, path, beside } = report;
    if desk.session.recording.is_none() {
        widgets::weak(ui, "There is no recording yet that a report could be about.");
        return ui.button("Close").clicked();
    }
    ending::choose(ui, &ReportFormat::ALL, format, path);
    ui.add_space(GAP);
    let mut compares = beside.is_some();
    if ui.checkbox(&mut compares, "Beside another session that was saved").changed() {
        *beside = compares.then(String::new);
    }
    if let Some(other) = beside {
        let label = ui.label("The other session");
        let edit = TextEdit::singleline(other).hint_text("path/to/other.torquescope").desired_width(f32::INFINITY);
        ui.add(edit).labelled_by(label.id);
        if ui.button("Choose a session…").clicked() {
            desk.orders.push(Order::BesideDialog);
        }
    }
    ui.add_space(GAP);
    ending::ask(ui, &ReportFormat::ALL, format, path, false);
    let text = match beside {
        Some(_) => "What both are and found in one table each, then their reports, section beside section.",
        None => {
            "Data, findings and model; what is missing, its evidence and what is not known, once it was diagnosed. The file needs \
             no other, and no network."
        }
    };
    ui.label(RichText::new(text).size(SMALL).color(Palette::in_ui(ui).weak));
    ui.add_space(GAP);
    let ready =
        ending::is_named(&ReportFormat::ALL, path) && beside.as_ref().is_none_or(|other| !other.trim().is_empty());
    ui.horizontal_wrapped(|ui| {
        let write = primary(ui, ready, "Write the file");
        write.widget_info(|| WidgetInfo::labeled(egui::Role::Button, ready, "Write the file"));
        if write.on_disabled_hover_text("Name a file, and the other session").clicked() {
            let beside = beside.as_ref().map(|other| other.trim().into());
            let reporting = Reporting { format: *format, path: path.trim().into(), beside };
            desk.orders.push(Order::Report(Box::new(reporting)));
            return true;
        }
        if ui.button("Choose a file…").clicked() {
            desk.orders.push(Order::ExportDialog);
        }
        ui.button("Cancel").clicked()
    })
    .inner
}
