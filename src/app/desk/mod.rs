//! What every screen works with: it reads the session, looks where the others look, asks for what is derived, and gives
//! orders. Nothing here knows a screen.

mod about;
mod export_page;
mod film;
mod focus;
mod notice;
mod order;
mod overlaid;
mod panels;
mod paper;
mod playing;
mod question;
mod recent;
mod shown;
mod templates;
mod time;

use std::sync::Arc;

pub use about::{About, Needs};
pub use export_page::ExportPage;
pub use focus::Focus;
pub use notice::{Messages, Notice, Toast, Tone};
pub use order::{DataOut, Drawing, ModelOut, Order, Parting, Reporting};
pub use overlaid::Overlaid;
pub use panels::{Change, Layouts, Panels, Side};
pub use paper::ReportFormat;
pub use playing::Stretch;
pub use question::Question;
pub use recent::{Recent, Recents};
pub use shown::Shown;
pub use templates::Templates;
pub use time::{held_out_times, is_held_out, time_extent};

use super::keeper::Copy;
use super::memo::Memo;
use crate::figure::Ink;
use crate::progress::{Epoch, Progress};
use crate::session::{Command, Session, Step};
use crate::training::fit::Plan;

/// The running job, as this frame shows it.
pub struct Busy<'a> {
    /// What it does.
    pub name: &'a str,
    /// The newest report.
    pub progress: &'a Progress,
    /// Whether it waits.
    pub paused: bool,
    /// Whether it was asked to end with what it has.
    pub finishing: bool,
    /// By which plan networks are trained, if they are.
    pub plan: Option<&'a Plan>,
    /// The epochs so far.
    pub epochs: &'a [Epoch],
    /// What a diagnosis takes to be missing so far.
    pub found: &'a [String],
}

/// What a screen works with.
pub struct Desk<'a> {
    /// The document.
    pub session: &'a Session,
    /// Where one looks.
    pub focus: &'a mut Focus,
    /// What is derived from the session.
    pub memo: &'a mut Memo,
    /// Where the panels are.
    pub panels: &'a mut Panels,
    /// What the screen asks for.
    pub orders: &'a mut Vec<Order>,
    /// What is at work.
    pub busy: Option<&'a Busy<'a>>,
    /// What other windows left behind, the newest first.
    pub copies: &'a [Copy],
    /// What was opened and saved of late, the newest first.
    pub recent: &'a [Recent],
    /// Mapping files for logs that are like those which were seen.
    pub templates: &'a Templates,
}

impl Desk<'_> {
    /// The models that are drawn over the current one, in the order in which they were made, each with its ink.
    pub fn overlaid(&self) -> Vec<(Arc<Step>, Ink)> {
        let current = self.session.current().map(|step| step.generation);
        let others = self.session.all_models().filter(|step| Some(step.generation) != current);
        others.filter_map(|step| Some((Arc::clone(step), self.focus.overlaid.ink(step.generation)?))).collect()
    }

    /// All models that are drawn, the current one among them, in the order in which they were made.
    pub fn shown_models(&self) -> Vec<Arc<Step>> {
        let current = self.session.current().map(|step| step.generation);
        let is_shown =
            |step: &&Arc<Step>| Some(step.generation) == current || self.focus.overlaid.ink(step.generation).is_some();
        self.session.all_models().filter(is_shown).cloned().collect()
    }

    /// Gives an order to change the session.
    pub fn run(&mut self, command: Command) {
        self.orders.push(Order::run(command));
    }
}
