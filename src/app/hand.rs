//! A window without a display in which somebody works: orders, and clicks and keys at random. By it the program tries what a window
//! keeps when it is killed, and what it takes in hours.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use cpu_time::ThreadTime;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use rand::{Rng, RngExt};

use super::desk::Order;
use super::keeper::Locks;
use super::pace::{NO_CLOCK, SIZE, run};
use super::{TorquescopeApp, screens, theme};
use crate::session::{Command, Session};

/// Keys that do something in a window, with Ctrl or without; none of them shows a dialog of the system's.
const KEYS: [(Modifiers, Key); 12] = [
    (Modifiers::NONE, Key::Tab),
    (Modifiers::NONE, Key::Enter),
    (Modifiers::NONE, Key::Space),
    (Modifiers::NONE, Key::ArrowLeft),
    (Modifiers::NONE, Key::ArrowRight),
    (Modifiers::NONE, Key::Escape),
    (Modifiers::NONE, Key::Home),
    (Modifiers::NONE, Key::F6),
    (Modifiers::COMMAND, Key::Z),
    (Modifiers::COMMAND, Key::Y),
    (Modifiers::COMMAND, Key::P),
    (Modifiers::COMMAND, Key::M),
];
/// One turn of the wheel is at most so far \[points\].
const FARTHEST_TURN: f32 = 120.0;

/// Somebody who works in a window.
pub struct Hand {
    ctx: egui::Context,
    app: TorquescopeApp,
    frames: u32,
}

impl Hand {
    /// In an empty window, which keeps its copies in this folder if one is given.
    pub fn new(copies: Option<(PathBuf, Locks)>) -> Self {
        let ctx = egui::Context::default();
        theme::install(&ctx);
        let mut app = TorquescopeApp::new(Session::default());
        if let Some((folder, locks)) = copies {
            app.keep_copies(folder, locks);
        }
        Hand { ctx, app, frames: 0 }
    }

    /// The document as it is.
    pub fn session(&self) -> &Session {
        self.app.session()
    }

    /// Gives an order, as a click would.
    pub fn order(&mut self, order: Order) {
        self.app.order(order);
    }

    /// The epochs of the training at work; `None` if none is.
    pub fn epoch(&self) -> Option<u64> {
        let running = self.app.running.as_ref()?;
        running.plan.as_ref()?;
        Some(running.epochs.last().map_or(0, |epoch| epoch.epoch))
    }

    /// Whether a command is at work, or was ordered and has not begun.
    pub fn is_at_work(&self) -> bool {
        self.app.running.is_some() || !self.app.orders.is_empty()
    }

    /// Whether anything is.
    pub fn is_busy(&self) -> bool {
        self.app.is_busy() || !self.app.orders.is_empty()
    }

    /// What other windows left behind, the newest first.
    pub fn offers(&self) -> Vec<&Path> {
        self.app.keeper.left_behind().iter().map(|copy| copy.path.as_path()).collect()
    }

    /// What other recordings took the place of before it was saved, and undo leads back to.
    pub fn left(&self) -> Vec<Session> {
        let current = self.app.document().history.current().generation;
        self.app.documents_beside(current).map(|(document, _)| document.history.current().clone()).collect()
    }

    /// How many epochs the training has that the window asks to go on with; `None` if it asks nothing of the kind.
    pub fn offered_epoch(&self) -> Option<u64> {
        let choices = self.app.overlays.asking.iter().flat_map(|question| &question.choices);
        choices.into_iter().find_map(|(_, order)| match order {
            Order::Run(command) => match command.as_ref() {
                Command::Resume(run) => Some(run.checkpoint.epoch),
                _ => None,
            },
            _ => None,
        })
    }

    /// A frame without a picture: the CPU time of this thread from input to triangles \[s\].
    ///
    /// # Errors
    /// If the system does not tell that time.
    pub fn frame(&mut self) -> anyhow::Result<f64> {
        self.frame_after(Vec::new())
    }

    fn frame_after(&mut self, events: Vec<Event>) -> anyhow::Result<f64> {
        let own = ThreadTime::try_now().context(NO_CLOCK)?;
        self.frames += 1;
        let mut output = run(&self.ctx, &mut self.app, f64::from(self.frames) / 60.0, events);
        output.textures_delta.clear();
        std::hint::black_box(self.ctx.tessellate(output.shapes, output.pixels_per_point));
        // The file dialog is the system's, and nobody is there to answer it.
        self.app.orders.retain(|order| {
            !matches!(
                order,
                Order::OpenDialog | Order::SaveDialog | Order::ExportDialog | Order::BesideDialog | Order::SaveAgain
            )
        });
        // An experiment computes for hours on all cores, and its models are none of the window's.
        if self.app.screen() == &screens::experiment::ABOUT {
            self.app.show_screen(&screens::data::ABOUT);
        }
        Ok(own.elapsed().as_secs_f64())
    }

    /// Does something at random: a click, a drag, a key, a turn of the wheel, a letter or another screen. The CPU times of the frames
    /// that show it \[s\].
    ///
    /// # Errors
    /// As [`Hand::frame`].
    pub fn fidget(&mut self, random: &mut impl Rng) -> anyhow::Result<Vec<f64>> {
        let [width, height] = SIZE.map(|side| side as f32);
        let mut place = || Pos2::new(random.random_range(0.0..width), random.random_range(0.0..height));
        let (from, to) = (place(), place());
        let button = |pos, pressed| {
            let modifiers = Modifiers::NONE;
            vec![
                Event::PointerMoved(pos),
                Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers },
            ]
        };
        let frames = match random.random_range(0..10) {
            0 | 1 => {
                let (modifiers, key) = KEYS[random.random_range(0..KEYS.len())];
                let event = |pressed| vec![Event::Key { key, physical_key: None, pressed, repeat: false, modifiers }];
                vec![event(true), event(false)]
            }
            2 => {
                let screen = screens::TABLE[random.random_range(0..screens::TABLE.len())].about;
                self.order(Order::Show(screen));
                vec![Vec::new()]
            }
            3 => {
                let far = random.random_range(-FARTHEST_TURN..FARTHEST_TURN);
                vec![vec![Event::PointerMoved(from), wheel(far)]]
            }
            4 => vec![vec![Event::Text("3".to_owned())]],
            5 => vec![button(from, true), vec![Event::PointerMoved(to)], button(to, false)],
            _ => vec![button(from, true), button(from, false)],
        };
        // What it opens is drawn before anything else happens.
        let frames = frames.into_iter().chain([Vec::new(), Vec::new()]);
        frames.map(|events| self.frame_after(events)).collect()
    }
}

fn wheel(far: f32) -> Event {
    let (unit, phase, modifiers) = (egui::MouseWheelUnit::Point, egui::TouchPhase::Move, Modifiers::NONE);
    let source = egui::MouseWheelSource::Unknown;
    Event::MouseWheel { unit, delta: vec2(0.0, far), phase, modifiers, source }
}
