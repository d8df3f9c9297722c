//! What the window has to say: notices that stay until they are dismissed, and toasts that pass.

use super::order::Order;
use crate::file;

/// How long a toast is shown \[s\].
const TOAST: f64 = 5.0;

/// How serious a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Good to know.
    Info,
    /// Something is not as one may think.
    Warning,
    /// Something could not be done.
    Error,
}

/// A message that stays until it is dismissed.
#[derive(Debug, Clone)]
pub struct Notice {
    /// How serious it is.
    pub tone: Tone,
    /// What happened.
    pub text: String,
    /// How to mend it; empty if there is nothing to mend.
    pub remedy: String,
    /// What a button beside it does, with its name.
    pub offer: Option<(String, Box<Order>)>,
}

impl Notice {
    /// A message.
    pub fn new(tone: Tone, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Notice { tone, text: text.into(), remedy: remedy.into(), offer: None }
    }
}

/// What was just done; it passes.
#[derive(Debug, Clone)]
pub struct Toast {
    /// Whether it went as one hopes.
    pub tone: Tone,
    /// What was done.
    pub text: String,
    /// When it goes \[s, in the window's time\].
    pub until: f64,
}

/// Everything that is said at the moment.
#[derive(Debug, Default)]
pub struct Messages {
    /// Oldest first.
    pub notices: Vec<Notice>,
    /// Oldest first.
    pub toasts: Vec<Toast>,
}

impl Messages {
    /// Says something that stays.
    pub fn tell(&mut self, tone: Tone, text: impl Into<String>, remedy: impl Into<String>) {
        let text = file::without_number(&text.into());
        self.notices.push(Notice::new(tone, text, remedy));
    }

    /// Offers something beside what was said last.
    pub fn offer(&mut self, name: &str, order: Order) {
        if let Some(notice) = self.notices.last_mut() {
            notice.offer = Some((name.to_owned(), Box::new(order)));
        }
    }

    /// Says what was just done.
    pub fn toast(&mut self, tone: Tone, text: String, ctx: &egui::Context) {
        self.toasts.push(Toast { tone, text, until: ctx.input(|input| input.time) + TOAST });
    }

    /// Removes a notice; nothing happens if it is gone already.
    pub fn dismiss(&mut self, notice: usize) {
        if notice < self.notices.len() {
            self.notices.remove(notice);
        }
    }

    /// Removes what only was good to know.
    pub fn forget_what_is_past(&mut self) {
        self.notices.retain(|notice| notice.tone != Tone::Info);
    }
}
