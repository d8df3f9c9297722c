//! Whatever changes the session is taken back and done again: by the bar, by keys and by name, on every screen.

use torquescope::arm::Arm;
use torquescope::lesson;
use torquescope::model::Preset;
use torquescope::model::learned::LearnedPreset;
use torquescope::recording::hold_out::HoldOut;
use torquescope::recording::read::ReadOptions;
use torquescope::session::TermEdit;
use torquescope::simulation::extrapolation::Stretch;
use torquescope::simulation::world;

use super::*;

/// A way to undo and redo.
#[derive(Debug, Clone, Copy)]
enum Way {
    Bar,
    Keys,
    Palette,
}

const WAYS: [Way; 3] = [Way::Bar, Way::Keys, Way::Palette];

/// Takes the last change back, or does it again.
fn travel(window: &mut Window, way: Way, back: bool) {
    match way {
        Way::Bar => click(window, if back { "Undo" } else { "Redo" }),
        Way::Keys => window.key_press_modifiers(Modifiers::COMMAND, if back { Key::Z } else { Key::Y }),
        Way::Palette => {
            window.key_press_modifiers(Modifiers::COMMAND, Key::P);
            window.run_steps(3);
            window.event(egui::Event::Text(if back { "undo" } else { "redo" }.to_owned()));
            window.run_steps(3);
            window.key_press(Key::Enter);
        }
    }
    settle(window);
}

/// What of a session a user sees: which recording, models, answers and settings.
fn seen(window: &Window) -> String {
    let session = window.state().session();
    let address = |part: Option<usize>| part.unwrap_or(0);
    let steps: Vec<usize> = session.ladder.iter().map(|step| Arc::as_ptr(step) as usize).collect();
    let parts = [
        session.recording.as_ref().map(|part| Arc::as_ptr(part) as usize),
        session.report.as_ref().map(|part| Arc::as_ptr(part) as usize),
        session.proposals.as_ref().map(|part| Arc::as_ptr(part) as usize),
        session.sweep.as_ref().map(|part| Arc::as_ptr(part) as usize),
        session.truth.as_ref().map(|part| Arc::as_ptr(part) as usize),
    ];
    let terms: Vec<String> = session.set_aside.iter().map(torquescope::model::Term::label).collect();
    let own = &session.own_effects;
    let models: Vec<&String> = session.all_models().map(|step| &step.name).collect();
    let (preset, plan, split) = (session.preset, &session.plan, &session.split);
    format!("{steps:?} {:?} {terms:?} {own:?} {models:?} {preset:?} {plan:?} {split:?}", parts.map(address))
}

fn begin_lesson(number: &str) -> Command {
    lesson::begin(&lesson::catalogue::find(number).unwrap(), 3, 0).unwrap().command
}

/// A world of a moment.
fn small_world() -> world::Scenario {
    let motion = Excitation::PaperPointToPoint { trajectories: 2, duration: 1.0, samples: 100, range: 1.0 };
    let prescribed = Scenario { arm: Arm::uniform(1), motion, effects: Vec::new(), ..Scenario::embedded() };
    world::Scenario { step: 1e-3, ..world::Scenario::of(&prescribed) }
}

/// A session, and every command that changes it; a new command is a new line in the match.
fn commands(folder: &Path) -> Vec<(Session, Command)> {
    let (csv, saved) = (folder.join("swing.csv"), folder.join("saved.torquescope"));
    std::fs::write(&csv, swing()).unwrap();
    let swing = run(Command::open(vec![csv.clone()], ReadOptions::default(), HoldOut::default()), &Session::default());
    let beside = Command::Beside { paths: vec![csv.clone()] };
    let mut writer = window(diagnosed(), &data::ABOUT, Theme::Dark);
    writer.state_mut().order(Order::Save(saved.clone()));
    settle(&mut writer);
    let stopped = trained().current().unwrap().run.clone().unwrap();
    let other = run(Command::ChoosePreset(Preset::RigidBody), &trained());
    let switched_off = run(Command::EditTerms(TermEdit::SwitchOff(1)), &support::repaired());
    let steps = support::repaired().ladder;
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_stribeck.toml");
    let plan = || Box::new(short_plan(2));
    let all = vec![
        (
            demonstration(),
            Command::Open { paths: vec![csv], options: ReadOptions::default(), held_out: HoldOut::default() },
        ),
        (swing, beside),
        (demonstration(), Command::Restore { path: saved }),
        (diagnosed(), Command::SetRight(vec!["sign-torque@1".parse().unwrap()])),
        (support::repaired(), Command::HoldOut(HoldOut::Fifth(2))),
        (diagnosed(), Command::Simulate(Box::new(Scenario { seed: 5, ..Scenario::embedded() }))),
        (diagnosed(), Command::SimulateWorld(Box::new(small_world()))),
        (diagnosed(), Command::DrawMystery { level: Level::Hard, seed: 2 }),
        (diagnosed(), Command::ChoosePreset(Preset::StatedArm)),
        (small(), Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: plan() }),
        (trained(), Command::Train { plan: plan(), warm: false }),
        (trained(), Command::TrainSeeds { begin: None, seeds: 2 }),
        (other.clone(), Command::Resume(stopped)),
        (other.clone(), Command::TakeUp { name: "structured DeLaN".to_owned() }),
        (other.clone(), Command::Rename { name: "structured DeLaN".to_owned(), to: "mine".to_owned() }),
        (other.clone(), Command::Delete { name: "structured DeLaN".to_owned() }),
        (other, Command::Make { presets: vec![Preset::StatedArm] }),
        (support::repaired(), Command::RollOut),
        (diagnosed(), Command::UseModel { model: steps[1].fitted.model.clone() }),
        (demonstration(), Command::Diagnose),
        (diagnosed(), Command::AddEffect { effect: "viscous-friction".to_owned(), joints: vec![0] }),
        (support::repaired(), Command::EditTerms(TermEdit::SwitchOff(1))),
        (support::repaired(), Command::EditTerms(TermEdit::Remove(1))),
        (support::repaired(), Command::EditTerms(TermEdit::Move { from: 1, to: 2 })),
        (switched_off.clone(), Command::EditTerms(TermEdit::SwitchOn(0))),
        (switched_off, Command::EditTerms(TermEdit::Forget(0))),
        (support::repaired(), Command::Extrapolate { steps, stretch: Stretch::Speed }),
        (support::repaired(), Command::GoTo { step: 0 }),
        (diagnosed(), Command::BeginAnew),
        (small(), Command::LoadEffect { path: own }),
        (demonstration(), Command::Propose),
        (run(Command::Propose, &demonstration()), Command::Adopt { proposal: 0 }),
        (demonstration(), begin_lesson("1")),
    ];
    for (_, command) in &all {
        match command {
            Command::Open { .. } | Command::Restore { .. } | Command::Simulate(_) | Command::DrawMystery { .. } => (),
            Command::ChoosePreset(_) | Command::SimulateWorld(_) | Command::BeginAnew => (),
            Command::TrainPreset { .. } | Command::Train { .. } | Command::TrainSeeds { .. } | Command::Resume(_) => (),
            Command::TakeUp { .. } | Command::Rename { .. } | Command::Delete { .. } | Command::Make { .. } => (),
            Command::SetRight(_)
            | Command::HoldOut(_)
            | Command::Beside { .. }
            | Command::UseModel { .. }
            | Command::Diagnose
            | Command::AddEffect { .. }
            | Command::EditTerms(_) => (),
            Command::Extrapolate { .. } | Command::RollOut | Command::GoTo { .. } => (),
            Command::LoadEffect { .. } | Command::Propose | Command::Adopt { .. } | Command::SetUp(_) => (),
            // What was seen or said can't be taken back; `lost.rs` and `lessons.rs` have them.
            Command::OpenSeal | Command::BetFirst(_) | Command::PlaceBet(_) | Command::Learn(_) => (),
        }
    }
    all
}

#[test]
fn every_command_is_undone_and_redone() {
    let folder = tempfile::tempdir().unwrap();
    for (number, (session, command)) in commands(folder.path()).into_iter().enumerate() {
        let mut window = window(session, screens::TABLE[number % screens::TABLE.len()].about, Theme::Dark);
        let title = command.title();
        let before = seen(&window);
        window.state_mut().order(Order::run(command));
        settle(&mut window);
        let after = seen(&window);
        assert_ne!(before, after, "{title} changes something");
        travel(&mut window, WAYS[number % 3], true);
        assert_eq!(seen(&window), before, "{title} is undone");
        travel(&mut window, WAYS[(number + 1) % 3], false);
        assert_eq!(seen(&window), after, "{title} is done again");
    }
}

#[test]
fn every_screen_has_every_way_to_undo_and_redo() {
    let mut window = window(support::repaired(), &data::ABOUT, Theme::Light);
    for screen in screens::all() {
        window.state_mut().order(Order::Show(screen));
        settle(&mut window);
        for way in WAYS {
            window.state_mut().order(Order::run(Command::GoTo { step: 0 }));
            settle(&mut window);
            let ladder = |window: &Window| window.state().session().ladder.len();
            assert_eq!(ladder(&window), 1);
            travel(&mut window, way, true);
            assert_eq!(ladder(&window), 2, "{way:?} undoes on {}", screen.id);
            travel(&mut window, way, false);
            assert_eq!(ladder(&window), 1, "{way:?} does it again on {}", screen.id);
            travel(&mut window, way, true);
            assert_eq!(window.state().screen(), screen, "one stays where one is");
        }
    }
}

/// While a job is at work on the session, the session stays as it is: what the job gives is put behind it, and what can be
/// undone and redone is not lost.
#[test]
fn undo_waits_for_the_job_that_is_at_work() {
    let mut window = window(Session { plan: short_plan(1_000_000), ..small() }, &train::ABOUT, Theme::Dark);
    let add = Command::AddEffect { effect: "viscous-friction".to_owned(), joints: vec![0] };
    window.state_mut().order(Order::run(add));
    settle(&mut window);
    let before = seen(&window);
    window.state_mut().order(Order::Show(&train::ABOUT));
    window.run_steps(2);
    window.get_by_role_and_label(Role::RadioButton, "FF-NN").click();
    window.run_steps(2);
    for ending in ["Throw away", "Stop and keep the best"] {
        window.get_by_role_and_label(Role::Button, "Start training").click();
        wait_for_an_epoch(&mut window);
        assert!(!is_enabled(&window, "Undo"), "the button says that it has to wait");
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(3);
        assert!(window.query_by_label_contains("Undo was not carried out, because “").is_some());
        assert_eq!(seen(&window), before, "the job's session is not taken from under it");
        window.get_by_role_and_label(Role::Button, ending).click();
        settle(&mut window);
        click(&mut window, "Dismiss message 1");
    }
    let trained = seen(&window);
    assert_ne!(trained, before);
    travel(&mut window, Way::Keys, true);
    assert_eq!(seen(&window), before, "first the training is undone");
    travel(&mut window, Way::Keys, true);
    assert_eq!(window.state().session().ladder.len(), 1, "then what was done before it");
    travel(&mut window, Way::Keys, false);
    travel(&mut window, Way::Keys, false);
    assert_eq!(seen(&window), trained, "and all of it is done again");
}

/// What is drawn over the current model is known by a number of its own: a model that is made where another one stood in memory
/// is not that other one.
#[test]
fn a_new_model_is_not_overlaid_because_an_old_one_was() {
    let mut window = window(small(), &compare::ABOUT, Theme::Light);
    // Adds a model and goes back to the one before it; says where in memory it is.
    let add = |window: &mut Window, joint: usize| {
        let add = Command::AddEffect { effect: "viscous-friction".to_owned(), joints: vec![joint] };
        window.state_mut().order(Order::run(add));
        settle(window);
        let address = Arc::as_ptr(window.state().session().current().unwrap()) as usize;
        for order in [Order::run(Command::GoTo { step: 0 }), Order::Show(&compare::ABOUT)] {
            window.state_mut().order(order);
        }
        settle(window);
        address
    };
    let old = add(&mut window, 0);
    click(&mut window, "Models (2)");
    window.get_by_role_and_label(Role::CheckBox, "show rigid body + viscous 1").click();
    window.run_steps(3);
    let is_overlaid = |window: &Window| window.query_by_label_contains("viscous 1 in joint 1: torque").is_some();
    assert!(is_overlaid(&window), "it is in the legend");
    // The model is forgotten and its memory is free; sooner or later another model is made there.
    for round in 0..20 {
        travel(&mut window, Way::Keys, true);
        travel(&mut window, Way::Keys, true);
        let address = add(&mut window, 1);
        assert!(!is_overlaid(&window), "round {round}: nobody chose this model");
        if address == old {
            return;
        }
    }
}
