//! The worst moments as a list, and the cursor that jumps there.

use egui::{RichText, Ui, WidgetInfo};

use super::table::{Place, Quantity, Table};
use crate::app::desk::{Desk, Order};
use crate::app::plot::ticks;
use crate::app::screens::compare;
use crate::app::theme::{Palette, SMALL};
use crate::app::widgets;
use crate::figure::mark::nearest;
use crate::recording::Recording;

pub fn show(ui: &mut Ui, desk: &mut Desk, recording: &Recording, table: &Table, unit: &str) {
    let palette = Palette::in_ui(ui);
    widgets::card(ui, &format!("Worst moments [{unit}]"), |ui| {
        let text = "A click puts the time cursor there, in every screen.";
        ui.label(RichText::new(text).size(SMALL).color(palette.weak));
        if ui.button("See it in Compare").clicked() {
            desk.orders.push(Order::Show(&compare::ABOUT));
        }
        let current = row_at_cursor(desk, table);
        for (number, row) in table.worst().iter().enumerate() {
            let place = table.place(*row);
            let run = &recording.trajectories[place.trajectory];
            let value = ticks::short((100.0 * table.column(Quantity::Residual)[*row]).round() / 100.0);
            let text = format!("{}.  {value}  at {:.2} s, {}", number + 1, run.time[place.sample], run.name);
            let here = current == Some(*row);
            let button = ui.add(egui::Button::selectable(here, RichText::new(&text).size(SMALL + 0.5)).truncate());
            let spoken = format!("worst moment {}", number + 1);
            button.widget_info(|| WidgetInfo::selected(egui::Role::Button, true, here, &spoken));
            if button.on_hover_text(text).clicked() {
                jump(desk, table, *row);
            }
        }
    });
}

/// Puts the shared cursor on a row.
pub fn jump(desk: &mut Desk, table: &Table, row: usize) {
    let place = table.place(row);
    let Some(run) = desk.session.recording.as_ref().and_then(|recording| recording.trajectories.get(place.trajectory))
    else {
        return;
    };
    desk.focus.show_trajectory(place.trajectory);
    desk.focus.cursor = run.time.get(place.sample).copied();
}

/// The row under the shared cursor; `None` if its trajectory is not in the table.
pub fn row_at_cursor(desk: &Desk, table: &Table) -> Option<usize> {
    let trajectory = desk.focus.trajectory;
    let run = desk.session.recording.as_ref()?.trajectories.get(trajectory)?;
    let sample = desk.focus.cursor.map_or(0, |at| nearest(&run.time, at));
    table.row(Place { trajectory, sample })
}
