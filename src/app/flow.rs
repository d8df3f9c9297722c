//! The way through the screens: which steps are behind, and the one step that comes next.
//!
//! Whoever does nothing but take the next step arrives at a repaired model, whatever the recording holds.

use super::screens::Screen;
use super::state::{Order, State};
use crate::diagnosis::Verdict;
use crate::effect::registry;
use crate::model::Preset;
use crate::session::{Command, Session};
use crate::simulation::Scenario;
use crate::simulation::extrapolation::Stretch;

/// What to do next, as the highlighted button says it.
pub struct NextStep {
    /// A few words.
    pub label: String,
    /// Why, for the tool tip.
    pub why: &'static str,
    /// What the click does.
    pub order: Order,
}

impl NextStep {
    fn show(screen: Screen) -> Self {
        NextStep { label: screen.title().to_owned(), why: screen.purpose(), order: Order::Show(screen) }
    }

    fn run(label: impl Into<String>, why: &'static str, command: Command) -> Self {
        NextStep { label: label.into(), why, order: Order::run(command) }
    }
}

/// The next step from the screen that is shown; `None` at the end of the way.
pub fn next(session: &Session, state: &State) -> Option<NextStep> {
    if session.recording.is_none() {
        let demonstration = Command::Simulate(Box::new(Scenario::embedded()));
        return Some(NextStep::run("Demonstration arm", "Simulate an arm with a hidden effect", demonstration));
    }
    if session.current().is_none() {
        let why = "Identify the arm's base parameters from the data";
        return Some(NextStep::run("Fit a rigid body", why, Command::ChoosePreset(Preset::RigidBody)));
    }
    Some(match state.screen {
        Screen::Data => NextStep::show(Screen::Model),
        // Beside the way: it leads back to its beginning.
        Screen::Experiment => NextStep::show(Screen::Data),
        // A rigid body is solved for at once, so the way leads past the training.
        Screen::Model | Screen::Train => NextStep::show(Screen::Compare),
        Screen::Compare => NextStep::show(Screen::Residuals),
        Screen::Residuals => NextStep::show(Screen::Diagnose),
        Screen::Diagnose => match &session.report {
            None => NextStep::run("Diagnose", "Lay every known effect beside the model", Command::Diagnose),
            Some(report) => match report.effects.first() {
                Some(effect) => {
                    let name = registry::find(&effect.effect).map_or(effect.effect.as_str(), |known| known.name);
                    let add = Command::AddEffect { effect: effect.effect.clone(), joints: effect.joints.clone() };
                    NextStep::run(format!("Add {name}"), "Add it and identify all parameters anew", add)
                }
                None => NextStep::show(Screen::Ladder),
            },
        },
        Screen::Ladder => after_the_ladder(session),
        Screen::Extrapolation => {
            if session.sweep.is_some() {
                let why = "Take the plots of any screen with you";
                let export = NextStep { label: "Export".to_owned(), why, order: Order::Export(None) };
                return (!state.exported).then_some(export);
            }
            let why = "Test the models at up to three times the speed";
            let sweep = Command::Extrapolate { steps: session.ladder.clone(), stretch: Stretch::Speed };
            NextStep::run("Go faster", why, sweep)
        }
    })
}

fn after_the_ladder(session: &Session) -> NextStep {
    let sealed =
        session.truth.is_none() && session.recording.as_ref().is_some_and(|recording| recording.seal.is_some());
    match &session.report {
        None if session.ladder.len() > 1 => {
            NextStep::run("Diagnose again", "Ask what the current model still lacks", Command::Diagnose)
        }
        None if session.ladder.len() == 1 => NextStep::show(Screen::Diagnose),
        Some(report) if sealed && report.verdict == Verdict::NothingMissing => {
            NextStep::run("Open the seal", "Compare what was found with what was hidden", Command::OpenSeal)
        }
        _ => NextStep::show(Screen::Extrapolation),
    }
}

/// Whether the work of a screen is behind.
pub fn is_done(session: &Session, screen: Screen) -> bool {
    let fitted = session.current().is_some();
    match screen {
        Screen::Data => session.recording.is_some(),
        Screen::Model | Screen::Compare | Screen::Residuals => fitted,
        Screen::Train => session.current().is_some_and(|step| !step.history.is_empty()),
        Screen::Diagnose => session.report.is_some() || session.ladder.len() > 1,
        Screen::Ladder => session.ladder.len() > 1,
        Screen::Extrapolation => session.sweep.is_some(),
        Screen::Experiment => false,
    }
}
