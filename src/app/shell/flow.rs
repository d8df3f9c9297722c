//! The way through the screens: the one step that comes next.
//!
//! Whoever does nothing but take the next step arrives at a repaired model, whatever the recording holds.

use crate::app::desk::{Focus, Order};
use crate::app::screen::{Next, NextStep};
use crate::app::screens::Screens;
use crate::app::widgets;
use crate::model::Preset;
use crate::recording::correction::Correction;
use crate::session::{Command, Session};
use crate::simulation::Scenario;

/// The next step from the screen that is shown; `None` at the end of the way, while it would tell an answer that a screen
/// keeps back, and while a lesson keeps it locked. `exported` says whether something of this recording was exported, which is that end.
pub fn next(session: &Session, focus: &Focus, screens: &Screens, exported: bool) -> Option<NextStep> {
    if screens.withhold(session) {
        return None;
    }
    let is_locked = |order: &Order| match (order, &session.study) {
        (Order::Run(command), Some(study)) => command.locked_by(study).is_some(),
        _ => false,
    };
    on_the_way(session, focus, screens, exported).filter(|next| !is_locked(&next.order))
}

fn on_the_way(session: &Session, focus: &Focus, screens: &Screens, exported: bool) -> Option<NextStep> {
    if session.recording.is_none() {
        let demonstration = Command::Simulate(Box::new(Scenario::embedded()));
        return Some(NextStep::run("Demonstration arm", "Simulate an arm with a hidden effect", demonstration));
    }
    if let Some(corrections) = session.findings.iter().map(|finding| &finding.set_right).find(|them| !them.is_empty()) {
        let faults: Vec<String> = corrections.iter().map(Correction::fault).collect();
        let why = "The log contradicts how it is set up; this sets it right, and undo takes it back";
        let label = format!("Set right: {}", widgets::in_a_sentence(&faults));
        return Some(NextStep::run(label, why, Command::SetRight(corrections.clone())));
    }
    if session.current().is_none() {
        let why = "Identify the arm's base parameters from the data";
        return Some(NextStep::run("Fit a rigid body", why, Command::ChoosePreset(Preset::RigidBody)));
    }
    match screens.current().next(session, focus) {
        Next::OnTheWay => Some(NextStep::show(screens.next_on_the_way())),
        Next::Step(step) => Some(step),
        Next::Export => {
            let why = "Take the plots of any screen with you";
            (!exported).then(|| NextStep { label: "Export".to_owned(), why, order: Order::Export(None) })
        }
    }
}
