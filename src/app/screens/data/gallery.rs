//! The recordings that come with the program: cards with a picture to begin with, and the story of the one that is open.

use std::sync::OnceLock;

use egui::{Align, Button, Frame, Layout, Margin, Pos2, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::app::desk::{Desk, Order};
use crate::app::memo::Question;
use crate::app::theme::{GAP, Palette, RADIUS, SMALL};
use crate::app::widgets;
use crate::progress::Monitor;
use crate::recording::gallery::{self, Sample};
use crate::recording::read::{ReadOptions, read};
use crate::recording::{Recording, Trajectory};
use crate::session::Session;

/// Least width of a card \[points\].
const LEAST_CARD: f32 = 168.0;
/// Height of its picture, and least height of what is in it \[points\].
const PICTURE: f32 = 54.0;
const CARD: f32 = 118.0;
/// How much of a recording a picture shows \[s\], with so many points a joint.
const SHOWN: f64 = 12.0;
const POINTS: usize = 160;

/// A card for each sample; a click opens it.
pub fn cards(ui: &mut Ui, desk: &mut Desk) {
    let pictures = desk.memo.later(ui.ctx(), desk.session, Pictures).and_then(Result::ok);
    widgets::card(ui, "Recordings to try", |ui| {
        widgets::weak(
            ui,
            "Small logs of arms that were simulated, each with a story and something to find, or nothing.",
        );
        ui.add_space(4.0);
        let count = ((ui.available_width() / LEAST_CARD) as usize).max(1);
        for (row, samples) in gallery::all().chunks(count).enumerate() {
            ui.columns(count, |columns| {
                for (column, sample) in samples.iter().enumerate() {
                    let picture = pictures.as_ref().map(|all| &all[row * count + column]);
                    card(&mut columns[column], desk, sample, picture);
                }
            });
        }
    });
}

fn card(ui: &mut Ui, desk: &mut Desk, sample: &Sample, picture: Option<&Picture>) {
    let palette = Palette::in_ui(ui);
    let frame = Frame::new()
        .fill(palette.canvas)
        .stroke(Stroke::new(1.0, palette.border))
        .corner_radius(RADIUS)
        .inner_margin(Margin::same(8));
    // Columns would pull short lines apart.
    let content = |ui: &mut Ui| {
        ui.set_min_height(CARD);
        // With keys one gets to the button alone.
        let (rect, drawing) = ui.allocate_exact_size(vec2(ui.available_width(), PICTURE), Sense::CLICK);
        for (joint, line) in picture.into_iter().flatten().enumerate() {
            let at = |[x, y]: &[f32; 2]| -> Pos2 {
                pos2(rect.left() + x * rect.width(), rect.center().y - 0.46 * y * rect.height())
            };
            let stroke = Stroke::new(1.2, palette.nth(joint).0);
            ui.painter().add(Shape::line(line.iter().map(at).collect(), stroke));
        }
        let title = Button::new(sample.told.title.as_str()).wrap().min_size(vec2(ui.available_width(), 0.0));
        let open = ui.add_enabled(desk.busy.is_none(), title).on_hover_text(&sample.told.story);
        ui.label(RichText::new(&sample.told.format).size(SMALL).color(palette.weak));
        if open.clicked() || (drawing.clicked() && desk.busy.is_none()) {
            desk.orders.push(Order::open(vec![sample.path()]));
        }
    };
    frame.show(ui, |ui| ui.with_layout(Layout::top_down(Align::Min), content));
    ui.add_space(GAP);
}

/// What is told of the recording, if it is a sample.
pub fn story(ui: &mut Ui, recording: &Recording) {
    let Some(sample) = gallery::of(recording) else { return };
    widgets::card(ui, "The story", |ui| {
        ui.label(&sample.told.story);
        widgets::weak(ui, format!("What to learn from it: {}", sample.told.teaches));
        let note = format!("{}, simulated; what is hidden is sealed. {}", sample.told.format, sample.path().display());
        ui.label(RichText::new(note).size(SMALL).color(Palette::in_ui(ui).weak));
    });
}

/// The torques of each joint, from 0 to 1 over time and from -1 to 1 in height.
type Picture = Vec<Vec<[f32; 2]>>;

/// A picture of each sample.
#[derive(Clone, PartialEq)]
struct Pictures;

impl Question for Pictures {
    type Answer = &'static [Picture];

    fn answer(&self, _: &Session) -> Result<Self::Answer, String> {
        // They are the same for every session.
        static DRAWN: OnceLock<Vec<Picture>> = OnceLock::new();
        Ok(DRAWN.get_or_init(|| gallery::all().iter().map(drawn).collect()))
    }
}

fn drawn(sample: &Sample) -> Picture {
    let import = read(&[sample.path()], &ReadOptions::default(), &Monitor::new()).ok();
    import.map_or_else(Vec::new, |import| torques(&import.recording.trajectories[0]))
}

fn torques(run: &Trajectory) -> Picture {
    let shown = run.time.iter().take_while(|time| **time - run.time[0] <= SHOWN).count();
    let largest = run.tau.values().iter().fold(1e-12, |largest: f64, value| largest.max(value.abs()));
    let step = (shown / POINTS).max(1);
    let line = |values: &[f64]| {
        let points = values[..shown].iter().step_by(step).enumerate();
        points.map(|(n, value)| [(n * step) as f32 / shown as f32, (value / largest) as f32]).collect()
    };
    run.tau.iter().map(line).collect()
}
