//! What the bars around the screens work with.

use super::flow;
use crate::app::desk::{Desk, Messages};
use crate::app::filed::Filed;
use crate::app::screen::NextStep;
use crate::app::screens::Screens;
use crate::progress::Progress;

/// The desk with what only the bars see.
pub struct Shell<'a> {
    /// What the screens work with.
    pub desk: Desk<'a>,
    /// The screens.
    pub screens: &'a mut Screens,
    /// What is said at the moment.
    pub messages: &'a mut Messages,
    /// Whether something of this recording was exported.
    pub exported: bool,
    /// What undo would take back.
    pub undo: Option<&'a str>,
    /// What redo would do again.
    pub redo: Option<&'a str>,
    /// Whether nobody wants to hear of what other windows left behind.
    pub copies_hidden: bool,
    /// Which file the document is in.
    pub filed: &'a Filed,
    /// Whether the table of the models is open.
    pub has_models_open: bool,
    /// What work somebody would lose if the window closed now, in words.
    pub unsaved: &'a [String],
    /// What is at work beside the session, and how far it is: a file that is written, an experiment.
    pub aside: Option<(String, Progress)>,
    /// What is at work, in words.
    pub at_work: Option<String>,
    /// Whether a dialog lies over the screens, whose answer comes next.
    pub is_covered: bool,
    /// Whether the window is being closed.
    pub is_leaving: bool,
}

impl Shell<'_> {
    /// The next step on the way.
    pub fn next(&self) -> Option<NextStep> {
        flow::next(self.desk.session, self.desk.focus, self.screens, self.exported)
    }
}
