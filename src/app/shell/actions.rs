//! Everything that can be done now, by name: what the command palette offers.

use super::frame::Shell;
use crate::app::desk::{Change, Desk, ExportPage, Order, Question, Side};
use crate::app::screens::{self, train};
use crate::effect::{Scope, registry};
use crate::model::Preset;
use crate::model::learned::LearnedPreset;
use crate::recording::gallery;
use crate::session::Command;
use crate::simulation::Scenario;
use crate::simulation::extrapolation::Stretch;

/// What leads back to the first screen.
pub const BEGIN_ANEW: &str = "Begin anew: with your log, a recording to try, or a lesson";

/// Something that can be done.
pub struct Action {
    /// What is searched and shown.
    pub name: String,
    /// The keys that do the same, if any.
    pub keys: &'static str,
    /// What it does.
    pub order: Order,
}

/// All actions that make sense now.
pub fn all(shell: &Shell) -> Vec<Action> {
    let desk = &shell.desk;
    let mut actions = Vec::new();
    let mut add = |name: String, keys: &'static str, order: Order| actions.push(Action { name, keys, order });
    if let Some(next) = shell.next() {
        add(format!("Next: {}", next.label), "Ctrl+Enter", next.order);
    }
    for screen in screens::all() {
        add(format!("Go to {}", screen.title), "", Order::Show(screen));
    }
    if shell.undo.is_some() {
        add("Undo".into(), "Ctrl+Z", Order::Undo);
    }
    if shell.redo.is_some() {
        add("Redo".into(), "Ctrl+Y", Order::Redo);
    }
    if desk.session.recording.is_some() {
        add("Save the session".into(), "Ctrl+S", Order::SaveAgain);
        add("Save the session into another file…".into(), "", Order::SaveDialog);
        add("Export the plots of this screen…".into(), "Ctrl+E", Order::Export(None));
        let report = "Write a report of this session, or of two side by side…";
        add(report.into(), "", Order::AskExport(ExportPage::Report));
        add(
            "Export the recording, a part of it, or torques of a model…".into(),
            "",
            Order::AskExport(ExportPage::Data),
        );
    }
    if desk.session.current().is_some() {
        add("Models of the session".into(), "Ctrl+M", Order::Models(true));
        add("Export a model: code, robot's file, weights…".into(), "", Order::AskExport(ExportPage::Model));
    }
    if desk.busy.is_some() || shell.aside.is_some() {
        add("Stop".into(), "Esc", Order::Stop);
    }
    add("Open recordings, a session or an effect…".into(), "Ctrl+O", Order::OpenDialog);
    for recent in desk.recent {
        add(format!("Open {}", recent.name()), "", Order::run(recent.open()));
    }
    for copy in desk.copies {
        add(format!("Go on with {}", copy.label()), "", Order::Recover(copy.path.clone()));
    }
    if desk.session.recording.is_some() {
        add(BEGIN_ANEW.into(), "", Order::run(Command::BeginAnew));
    }
    add("Simulate the demonstration arm".into(), "", Order::run(Command::Simulate(Box::new(Scenario::embedded()))));
    add("Draw a mystery".into(), "", Order::DrawMystery);
    for sample in gallery::all() {
        add(format!("Try {}", sample.told.title), "", Order::open(vec![sample.path()]));
    }
    add("Lessons…".into(), "", Order::Lessons(true));
    if let Some(recording) = &desk.session.recording {
        add("Start from the rigid body".into(), "", Order::run(Command::ChoosePreset(Preset::RigidBody)));
        if recording.states_arm() {
            add("Start from the stated arm".into(), "", Order::run(Command::ChoosePreset(Preset::StatedArm)));
        }
        let plan = || Box::new(desk.session.plan.clone());
        for preset in LearnedPreset::ALL {
            let train = Command::TrainPreset { preset, plan: plan() };
            add(format!("Train {}", preset.title()), "", Order::run(train));
        }
        if desk.session.current().is_some_and(|step| step.fitted.model.is_learned()) {
            add("Train on".into(), "", Order::run(Command::Train { plan: plan(), warm: true }));
            add("Train five seeds".into(), "", Order::run(Command::TrainSeeds { begin: None, seeds: train::SEEDS }));
        }
        if recording.seal.is_some() && desk.session.truth.is_none() {
            add("Open the seal".into(), "", Question::open_seal());
        }
    }
    if desk.session.current().is_some() {
        add("Diagnose".into(), "", Order::run(Command::Diagnose));
        add("Ask what the remainder depends on".into(), "", Order::run(Command::Propose));
        for stretch in Stretch::ALL {
            let steps = desk.session.ladder.clone();
            add(format!("Extrapolate in {}", stretch.name()), "", Order::run(Command::Extrapolate { steps, stretch }));
        }
        let joints = desk.session.recording.as_ref().map_or(0, |recording| recording.joint_count());
        for effect in registry::addable().chain(desk.session.own_effects.iter().copied()) {
            let mut offer = |name: String, joints: Vec<usize>| {
                add(name, "", Order::run(Command::AddEffect { effect: effect.id.to_owned(), joints }));
            };
            if effect.scope == Scope::Arm {
                offer(format!("Add {}", effect.name), Vec::new());
                continue;
            }
            // The later joint of a pair names it.
            let first = usize::from(effect.scope == Scope::Pair);
            offer(format!("Add {} on all joints", effect.name), (first..joints).collect());
            for joint in first..joints {
                offer(format!("Add {}", effect.placed(Some(joint))), vec![joint]);
            }
        }
    }
    add("Show everything in all charts".into(), "Home", Order::FitAll);
    panels(desk, &mut add);
    add("Reset the layout of this screen".into(), "", Order::ResetPanels);
    add("Change between light and dark".into(), "Ctrl+T", Order::ToggleTheme);
    add("Change the contrast".into(), "", Order::ToggleContrast);
    for percent in [80, 100, 125, 150, 200] {
        add(format!("Size of text {percent} %"), "", Order::TextScale(percent as f32 / 100.0));
    }
    add("Keyboard shortcuts".into(), "F1", Order::KeyList(true));
    actions
}

/// What can be done with the panels of the screen.
fn panels(desk: &Desk, add: &mut impl FnMut(String, &'static str, Order)) {
    let panels = desk.panels.panels();
    for (name, shown) in &panels {
        let mut offer = |what: String, keys, change| {
            add(format!("Panel {name}: {what}"), keys, Order::Panel((*name).to_owned(), change));
        };
        offer("show in front".to_owned(), "", Change::Show);
        if !shown {
            continue;
        }
        offer("hide".to_owned(), "Delete on its tab", Change::Hide);
        let sides = [
            ("left", "Shift+← on its tab", Side::Left),
            ("right", "Shift+→ on its tab", Side::Right),
            ("top", "Shift+↑ on its tab", Side::Top),
            ("bottom", "Shift+↓ on its tab", Side::Bottom),
        ];
        for (word, keys, side) in sides {
            offer(format!("move to the {word}"), keys, Change::Move(side));
        }
        for (other, _) in panels.iter().filter(|(other, shown)| *shown && !desk.panels.is_beside(name, other)) {
            offer(format!("move into the tabs of {other}"), "", Change::Join((*other).to_owned()));
        }
    }
}
