//! Work is not lost: neither by closing the window, nor by a crash, nor by another window or program, nor by a defect.

use egui::{ViewportCommand, ViewportEvent, ViewportId};
use torquescope::model::learned::LearnedPreset;

use super::*;

/// Somebody closes the window; it is drawn a few times more, as long as it is not closed.
pub(crate) fn close(window: &mut Window) {
    let viewport = window.input_mut().viewports.entry(ViewportId::ROOT).or_default();
    viewport.events.push(ViewportEvent::Close);
    window.step();
    window.input_mut().viewports.entry(ViewportId::ROOT).or_default().events.clear();
}

/// What the window asked of the system in the last frame.
fn asked(window: &Window) -> &[ViewportCommand] {
    &window.output().viewport_output[&ViewportId::ROOT].commands
}

fn closes(window: &Window) -> bool {
    asked(window).contains(&ViewportCommand::Close)
}

/// Steps until the window closes itself, and ends it as the system does.
fn wait_until_closed(mut window: Window) {
    step_until(&mut window, "the window closes", closes);
    eframe::App::on_exit(window.state_mut(), None);
}

fn press(window: &mut Window, name: &str) {
    window.get_by_role_and_label(Role::Button, name).click();
    // A question is there two frames after its order.
    window.run_steps(4);
}

/// Presses a button that closes the window, and waits until it does.
fn close_by(mut window: Window, name: &str) {
    window.get_by_role_and_label(Role::Button, name).click();
    window.step();
    wait_until_closed(window);
}

/// An empty window that keeps its copies in this folder.
fn empty_window(copies: &Path) -> Window {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    window.state_mut().keep_copies(copies.to_owned(), Locks::default());
    window.run_steps(3);
    window
}

/// The names of the offers to go on with something.
fn offers(window: &Window) -> Vec<String> {
    let buttons = window.root().children_recursive().map(|node| node.accesskit_node());
    let names = buttons.filter(|node| node.role() == Role::Button).filter_map(|node| node.label());
    names.filter(|name| name.starts_with("Go on with ")).collect()
}

/// Takes the first offer.
fn go_on(window: &mut Window) {
    let offer = offers(window).remove(0);
    click(window, &offer);
}

fn fitted(window: &Window) -> torquescope::model::Fitted {
    window.state().session().current().unwrap().fitted.clone()
}

/// A session with work in it, of which a copy is kept.
fn working(copies: &Path) -> Window {
    let mut window = window(diagnosed(), &diagnose::ABOUT, Theme::Dark);
    window.state_mut().keep_copies(copies.to_owned(), Locks::default());
    click(&mut window, "Add Coulomb friction");
    window
}

#[test]
fn closing_asks_and_each_answer_does_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let (copies, mine) = (folder.path().join("copies"), folder.path().join("mine.torquescope"));
    // Nothing is lost with what was only opened; still the next start can go on with it.
    let mut idle = empty_window(&copies);
    click(&mut idle, "Draw a mystery");
    close(&mut idle);
    assert!(!asked(&idle).contains(&ViewportCommand::CancelClose));
    eframe::App::on_exit(idle.state_mut(), None);
    let mut next = empty_window(&copies);
    let offered = offers(&next);
    assert!(offered.len() == 1 && offered[0].starts_with("Go on with mystery 7 ("), "{offered:?}");
    go_on(&mut next);
    assert_eq!(next.state().session().recording.as_ref().unwrap().name, "mystery 7");
    drop(next);

    let mut window = working(&copies);
    let model = fitted(&window);
    close(&mut window);
    assert!(asked(&window).contains(&ViewportCommand::CancelClose));
    window.run_steps(3);
    assert!(window.query_by_label_contains("three-joint demo has changes that are in no file").is_some());
    press(&mut window, "Stay");
    assert!(window.query_by_label("Close Torquescope?").is_none() && !closes(&window));
    // It is saved, and then it closes without a word.
    close(&mut window);
    window.run_steps(2);
    type_into(&mut window, "File to save into", mine.display());
    close_by(window, "Save and close");
    let mut second = empty_window(&copies);
    assert!(!offers(&second).iter().any(|name| name.contains("demo")), "what is in a file needs no copy");
    second.state_mut().order(Order::open(vec![mine.clone()]));
    settle(&mut second);
    assert_eq!(fitted(&second), model);
    close(&mut second);
    assert!(!asked(&second).contains(&ViewportCommand::CancelClose), "it is as its file is");
    drop(second);

    // It is closed without being saved: the next window goes on with it.
    let mut third = working(&copies);
    close(&mut third);
    third.run_steps(3);
    close_by(third, "Close, keep a copy");
    let mut fourth = empty_window(&copies);
    assert!(offers(&fourth)[0].starts_with("Go on with three-joint demo ("), "{:?}", offers(&fourth));
    click(&mut fourth, "Draw a mystery");
    let top = |label: &str| fourth.get_by_label(label).rect().top();
    let height = top("Open a recording") - top("Go on with");
    assert!(height < 220.0, "a copy takes the room of its buttons, not {height}");
    go_on(&mut fourth);
    assert_eq!(fitted(&fourth), model);
    assert_eq!(fourth.state().screen(), &ladder::ABOUT, "one looks where one looked");
}

/// Another recording, another session or the start screen takes the place of work that is in no file: undo leads back to it, so closing
/// asks about it, and the next start offers it.
#[test]
fn what_was_left_for_something_else_is_asked_about() {
    let left = "three-joint demo, to which undo leads back, has changes that are in no file: a copy of it is kept.";
    let folder = tempfile::tempdir().unwrap();
    let (copies, mine, other) =
        (folder.path().join("copies"), folder.path().join("mine.torquescope"), folder.path().join("other.torquescope"));
    let mut window = working(&copies);
    let model = fitted(&window);
    window.state_mut().order(Order::run(Command::BeginAnew));
    settle(&mut window);
    close(&mut window);
    assert!(asked(&window).contains(&ViewportCommand::CancelClose));
    window.run_steps(3);
    assert!(window.query_by_label(left).is_some());
    type_into(&mut window, "File to save into", mine.display());
    close_by(window, "Save and close");
    let mut second = empty_window(&copies);
    second.state_mut().order(Order::open(vec![mine.clone()]));
    settle(&mut second);
    assert_eq!(fitted(&second), model, "what was saved is the work, not the empty start");
    close(&mut second);
    assert!(!asked(&second).contains(&ViewportCommand::CancelClose));
    drop(second);

    // The window crashes; of what undo was led back to there is one copy, not two.
    let back_and_forth = [vec![Order::Undo], vec![Order::Redo]];
    for (number, (orders, copies_left)) in [
        (&[][..], 2),
        (&back_and_forth[..1], 1),
        (&back_and_forth, 2),
        // Before the copy of what undo led to is written.
        (&[vec![Order::Undo, Order::Redo]], 2),
    ]
    .into_iter()
    .enumerate()
    {
        let copies = folder.path().join(format!("crashed-{number}"));
        let mut crashed = working(&copies);
        crashed.state_mut().order(Order::run(Command::DrawMystery { level: Level::Easy, seed: 7 }));
        settle(&mut crashed);
        for at_once in orders {
            at_once.iter().for_each(|order| crashed.state_mut().order(order.clone()));
            settle(&mut crashed);
        }
        drop(crashed);
        let mut next = empty_window(&copies);
        let offered = offers(&next);
        assert_eq!(offered.len(), copies_left, "{orders:?}: {offered:?}");
        click(&mut next, offered.iter().find(|offer| offer.contains("three-joint demo")).unwrap());
        assert_eq!(fitted(&next), model);
    }

    let copies = folder.path().join("others");
    let mut third = working(&copies);
    third.state_mut().order(Order::run(Command::DrawMystery { level: Level::Easy, seed: 7 }));
    settle(&mut third);
    close(&mut third);
    third.run_steps(3);
    assert!(third.query_by_label(left).is_some());
    close_by(third, "Close, keep a copy");
    let mut fourth = empty_window(&copies);
    let offered = offers(&fourth);
    let of = |name: &str| offered.iter().filter(|offer| offer.contains(name)).count();
    assert!(offered.len() == 2 && of("mystery 7") == 1 && of("three-joint demo") == 1, "{offered:?}");
    click(&mut fourth, offered.iter().find(|offer| offer.contains("three-joint demo")).unwrap());
    assert_eq!(fitted(&fourth), model);
    drop(fourth);

    // A session that is in its file takes the place: that it is saved says nothing of what was before it.
    let mut fifth = working(&copies);
    std::fs::copy(&mine, &other).unwrap();
    fifth.state_mut().order(Order::open(vec![other.clone()]));
    settle(&mut fifth);
    close(&mut fifth);
    fifth.run_steps(3);
    assert!(fifth.query_by_label(left).is_some());
}

/// On a file system without locks a window says so, and goes on: whose a copy is is told by the process.
#[test]
fn where_nothing_can_be_locked_that_is_told_and_copies_are_kept() {
    let copies = tempfile::tempdir().unwrap();
    let mut window = window(diagnosed(), &diagnose::ABOUT, Theme::Dark);
    window.state_mut().keep_copies(copies.path().to_owned(), Locks::none());
    window.run_steps(3);
    assert!(window.query_by_label_contains("are where no file can be locked").is_some());
    click(&mut window, "Add Coulomb friction");
    settle(&mut window);
    assert!(newest_copy(copies.path()).is_file());
    let mut second = empty_window(copies.path());
    second.state_mut().keep_copies(copies.path().to_owned(), Locks::none());
    second.run_steps(3);
    assert!(offers(&second).is_empty(), "its owner lives: {:?}", offers(&second));
}

/// A training that runs when the window is closed is ended with its best weights and saved, or goes on in the next window.
#[test]
fn a_training_survives_the_closing_of_its_window() {
    let folder = tempfile::tempdir().unwrap();
    let (copies, mine) = (folder.path().join("copies"), folder.path().join("mine.torquescope"));
    let train = || {
        let mut window = window(Session { plan: short_plan(1_000_000), ..small() }, &train::ABOUT, Theme::Dark);
        window.state_mut().keep_copies(copies.clone(), Locks::default());
        let plan = Box::new(short_plan(1_000_000));
        window.state_mut().order(Order::run(Command::TrainPreset { preset: LearnedPreset::FfNn, plan }));
        window.run_steps(2);
        wait_for_an_epoch(&mut window);
        close(&mut window);
        window.run_steps(3);
        assert!(window.query_by_label_contains("is still at work").is_some());
        window
    };
    let mut first = train();
    first.state_mut().order(Order::Leave(torquescope::app::Parting::Save(mine.clone())));
    wait_until_closed(first);
    let mut second = empty_window(&copies);
    second.state_mut().order(Order::open(vec![mine]));
    settle(&mut second);
    let session = second.state().session();
    assert!(session.current().unwrap().fitted.model.is_learned() && session.models.len() == 2);
    drop(second);

    let third = train();
    close_by(third, "Close, keep a copy");
    let mut fourth = empty_window(&copies);
    go_on(&mut fourth);
    assert!(!fourth.state().session().current().unwrap().fitted.model.is_learned());
    let answer = fourth
        .root()
        .children_recursive()
        .find_map(|node| node.accesskit_node().label().filter(|name| name.starts_with("Go on from epoch ")));
    let answer = answer.expect("the training is offered");
    let done: u64 = answer.trim_start_matches("Go on from epoch ").parse().unwrap();
    fourth.get_by_role_and_label(Role::Button, &answer).click();
    fourth.run_steps(3);
    fourth.state_mut().order(Order::Show(&train::ABOUT));
    wait_for_an_epoch(&mut fourth);
    click(&mut fourth, "Stop and keep the best");
    let step = fourth.state().session().current().unwrap().clone();
    assert!(step.history.len() as u64 >= done.max(1) && step.history[0].epoch == 1, "it is one training");
}

/// A window that is dropped has crashed: it never came to its end.
#[test]
fn copies_have_one_owner_and_stay_until_somebody_decides() {
    let folder = tempfile::tempdir().unwrap();
    let copies = folder.path();
    let first = working(copies);
    let model = fitted(&first);
    let second = empty_window(copies);
    assert!(offers(&second).is_empty(), "its owner lives");
    drop(second);
    drop(first);

    // "Not now", another session and the end of this window decide nothing.
    let mut third = empty_window(copies);
    assert_eq!(offers(&third).len(), 1);
    press(&mut third, "Not now");
    assert!(offers(&third).is_empty());
    click(&mut third, "Draw a mystery");
    close(&mut third);
    eframe::App::on_exit(third.state_mut(), None);
    let mut fourth = empty_window(copies);
    let offered = offers(&fourth);
    assert!(offered.iter().any(|name| name.contains("mystery 7")), "the new session was kept as well: {offered:?}");
    let crashed = offered.iter().find(|name| name.contains("three-joint demo")).unwrap();
    click(&mut fourth, crashed);
    assert_eq!(fitted(&fourth), model);
    assert!(!offers(&fourth).iter().any(|name| name.contains("demo")));
    // Now it is in the copy of this window, and in no other.
    drop(fourth);

    let mut fifth = empty_window(copies);
    assert_eq!(offers(&fifth).len(), 2);
    press(&mut fifth, "Throw three-joint demo away");
    press(&mut fifth, "Keep it");
    assert_eq!(offers(&fifth).len(), 2);
    press(&mut fifth, "Throw three-joint demo away");
    press(&mut fifth, "Throw it away");
    fifth.run_steps(2);
    assert!(matches!(offers(&fifth).as_slice(), [name] if name.contains("mystery 7")));
    drop(fifth);
    assert_eq!(offers(&empty_window(copies)).len(), 1);
}

#[test]
fn a_file_that_somebody_else_changed_is_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine.torquescope");
    let mut window = working(&folder.path().join("copies"));
    window.state_mut().order(Order::Save(mine.clone()));
    settle(&mut window);
    // What is as this window left it is written without a word, by Ctrl+S.
    click(&mut window, "Remove the last step");
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut window);
    assert!(window.query_by_label("Overwrite mine.torquescope?").is_none());
    std::fs::write(&mine, "theirs").unwrap();
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    assert!(window.query_by_label_contains("was changed").is_some());
    press(&mut window, "Cancel");
    assert_eq!(std::fs::read(&mine).unwrap(), b"theirs");
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(3);
    press(&mut window, "Overwrite it");
    settle(&mut window);
    assert!(std::fs::read(&mine).unwrap().starts_with(b"PK"));
    assert_eq!(std::fs::read(folder.path().join("mine.torquescope.bak")).unwrap(), b"theirs");
}

/// A kill between writing and renaming leaves what was saved beside the file: it is opened, told, and one key brings it into its place.
#[test]
fn a_saving_that_was_cut_off_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let [mine, draft] = ["mine.torquescope", "mine.torquescope.17-0.new"].map(|name| folder.path().join(name));
    let mut first = working(&folder.path().join("copies"));
    let model = fitted(&first);
    first.state_mut().order(Order::Save(draft.clone()));
    settle(&mut first);
    click(&mut first, "Remove the last step");
    first.state_mut().order(Order::Save(mine.clone()));
    settle(&mut first);
    let late = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    std::fs::File::options().write(true).open(&draft).unwrap().set_modified(late).unwrap();

    let mut second = window(Session::default(), &data::ABOUT, Theme::Dark);
    second.state_mut().order(Order::open(vec![mine.clone()]));
    settle(&mut second);
    assert!(second.query_by_label_contains("which was cut off").is_some());
    assert_eq!(fitted(&second), model);
    second.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut second);
    assert!(second.query_by_label("Overwrite mine.torquescope?").is_none());
    // What was before is still there, and is a session of no file.
    let old = folder.path().join("mine.torquescope.bak");
    second.state_mut().order(Order::open(vec![old.clone()]));
    settle(&mut second);
    assert_ne!(fitted(&second), model);
    close(&mut second);
    second.run_steps(2);
    assert!(second.query_by_label_contains("has changes that are in no file").is_some());
}

/// A recording that is set right is still in its file, and setting it right is work that is not to be lost.
#[test]
fn setting_a_recording_right_keeps_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine.torquescope");
    let mut window = window(small(), &data::ABOUT, Theme::Dark);
    window.state_mut().order(Order::Save(mine.clone()));
    settle(&mut window);
    window.state_mut().order(Order::run(Command::SetRight(vec!["sign-torque@1".parse().unwrap()])));
    settle(&mut window);
    close(&mut window);
    assert!(asked(&window).contains(&ViewportCommand::CancelClose));
    window.run_steps(3);
    assert!(window.query_by_label_contains("mine has changes that are in no file").is_some());
    press(&mut window, "Stay");
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut window);
    close(&mut window);
    assert!(!asked(&window).contains(&ViewportCommand::CancelClose), "Ctrl+S wrote it into its file");
}

/// The title bar has the name, and a point before it as long as something is in no file.
#[test]
fn the_title_tells_what_is_unsaved() {
    /// Gives an order, and tells what the title bar is set to meanwhile.
    fn title_after(window: &mut Window, order: Order) -> Option<String> {
        window.state_mut().order(order);
        let mut title = None;
        for _ in 0..4 {
            let mut is_busy = true;
            while is_busy {
                window.step();
                let mut titles = asked(window).iter().filter_map(|command| match command {
                    ViewportCommand::Title(title) => Some(title.clone()),
                    _ => None,
                });
                title = titles.next_back().or(title);
                is_busy = window.state().is_busy();
            }
        }
        title
    }
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Session::default(), &data::ABOUT, Theme::Dark);
    let simulate = Order::run(Command::Simulate(Box::new(Scenario::embedded())));
    let add = Order::run(Command::AddEffect { effect: "viscous-friction".to_owned(), joints: vec![0] });
    let (bare, unsaved) = ("three-joint demo — Torquescope", "• three-joint demo — Torquescope");
    let save = Order::Save(folder.path().join("mine.torquescope"));
    let way = [
        (simulate, Some(bare)),
        (add, Some(unsaved)),
        (Order::Undo, Some(bare)),
        (Order::Redo, Some(unsaved)),
        (save, Some("mine — Torquescope")),
        (Order::Show(&compare::ABOUT), None),
        (Order::run(Command::GoTo { step: 0 }), Some("• mine — Torquescope")),
    ];
    for (number, (order, title)) in way.into_iter().enumerate() {
        assert_eq!(title_after(&mut window, order).as_deref(), title, "step {number}");
    }
}

/// Trainings, where one looks, what is drawn over what, where the panels are, and what can be undone come back with the file.
#[test]
fn a_saved_session_is_opened_as_it_was_left() {
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine.torquescope");
    let mut session = trained();
    let train = Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(short_plan(2)) };
    for _ in 0..3 {
        session = run(train.clone(), &session);
    }
    let mut first = window(session, &compare::ABOUT, Theme::Light);
    first.state_mut().order(Order::run(Command::TakeUp { name: "structured DeLaN".to_owned() }));
    settle(&mut first);
    first.state_mut().order(Order::Show(&compare::ABOUT));
    first.run_steps(3);
    click(&mut first, "Models (5)");
    first.get_by_role_and_label(Role::CheckBox, "show FF-NN (2)").click();
    first.run_steps(3);
    click(&mut first, "Close the models");
    assert!(first.query_by_label("FF-NN (2) in joint 1: torque").is_some(), "it is in the legend");
    first.get_by_role_and_label(Role::Button, "At the cursor").focus();
    first.run_steps(2);
    first.key_press(Key::Delete);
    first.run_steps(4);
    first.state_mut().order(Order::Save(mine.clone()));
    settle(&mut first);

    let mut second = window(Session::default(), &data::ABOUT, Theme::Light);
    second.state_mut().order(Order::open(vec![mine]));
    settle(&mut second);
    assert_eq!(second.state().screen(), &compare::ABOUT);
    assert!(second.query_by_label("FF-NN (2) in joint 1: torque").is_some(), "the same model is drawn over it");
    assert!(second.query_by_role_and_label(Role::Button, "At the cursor").is_none(), "the panel is hidden");
    let models = |window: &Window| window.state().session().models.len();
    assert_eq!((models(&second), fitted(&second).parameters), (5, fitted(&first).parameters));
    click(&mut second, "Undo");
    assert_eq!(second.state().session().current().unwrap().history.len(), 2, "the model before it");
    click(&mut second, "Undo");
    assert!(second.state().session().recording.is_none(), "and then what was there before the file");
}

#[test]
fn an_opened_seal_stays_open() {
    let mut window = window(support::repaired(), &ladder::ABOUT, Theme::Dark);
    let is_open = |window: &Window| window.state().session().truth.is_some();
    click(&mut window, "Open the seal");
    click(&mut window, "Leave it shut");
    assert!(!is_open(&window));
    click(&mut window, "Open the seal");
    click(&mut window, "Open it");
    assert!(is_open(&window) && !is_enabled(&window, "Undo"), "it is no step that could be undone");
    click(&mut window, "Remove the last step");
    click(&mut window, "Undo");
    assert!(is_open(&window));
    // The same arm again has the same seal.
    window.state_mut().order(Order::run(Command::Simulate(Box::new(Scenario::embedded()))));
    settle(&mut window);
    assert!(is_open(&window));
}

#[test]
fn a_bet_that_was_placed_stays_placed() {
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine.torquescope");
    let mut first = window(demonstration(), &diagnose::ABOUT, Theme::Light);
    first.get_by_role(Role::CheckBox).click();
    settle(&mut first);
    click(&mut first, "Diagnose");
    // The answer is hidden in the file, too.
    first.state_mut().order(Order::Save(mine.clone()));
    settle(&mut first);
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    window.state_mut().order(Order::open(vec![mine]));
    settle(&mut window);
    assert!(window.query_by_label_contains("place your bet").is_some());
    assert!(window.query_by_label_contains("The model lacks").is_none());
    click(&mut window, "Viscous friction");
    assert!(window.query_by_label("Your bet: viscous friction.").is_some());
    click(&mut window, "Undo");
    window.state_mut().order(Order::Show(&diagnose::ABOUT));
    settle(&mut window);
    if window.state().session().report.is_none() {
        click(&mut window, "Diagnose");
    }
    assert!(window.query_by_label("Your bet: viscous friction.").is_some(), "it can't be placed once more");
}

/// A defect that shows itself in drawing ends the screen, not the window.
#[test]
fn a_screen_that_breaks_takes_nothing_with_it() {
    let mut session = demonstration();
    let mut step = session.current().unwrap().as_ref().clone();
    step.evaluation.predictions.clear();
    session.ladder = vec![Arc::new(step)];
    let mut window = window(session, &compare::ABOUT, Theme::Dark);
    assert!(window.query_by_label("A defect of the program ended this screen").is_some());
    click(&mut window, "Draw it again");
    assert!(window.query_by_label("A defect of the program ended this screen").is_some(), "it is the same session");
    click(&mut window, "Data");
    assert!(window.query_by_label("A defect of the program ended this screen").is_none());
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    settle(&mut window);
    window.key_press(Key::Escape);
    settle(&mut window);
    // With a session that is whole, it is drawn.
    window.state_mut().order(Order::run(Command::ChoosePreset(torquescope::model::Preset::RigidBody)));
    settle(&mut window);
    click(&mut window, "Compare");
    assert!(window.query_by_label("plot of joint 1: torque [N m]").is_some());
}

/// What was opened of late is on the start screen, and is opened by its name.
#[test]
fn the_start_screen_has_what_was_opened_of_late() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("swing.csv");
    std::fs::write(&path, swing()).unwrap();
    let mut first = window(Session::default(), &data::ABOUT, Theme::Dark);
    first.state_mut().order(Order::open(vec![path]));
    settle(&mut first);
    first.state_mut().order(Order::Save(folder.path().join("mine.torquescope")));
    settle(&mut first);
    let kept = serde_json::to_string(&first.state().settings(&first.ctx)).unwrap();
    let mut second = window(Session::default(), &data::ABOUT, Theme::Dark);
    let ctx = second.ctx.clone();
    second.state_mut().restore(serde_json::from_str(&kept).unwrap(), &ctx);
    second.run_steps(3);
    assert!(second.query_by_role_and_label(Role::Button, "mine.torquescope").is_some());
    click(&mut second, "swing.csv");
    assert_eq!(second.state().session().recording.as_ref().unwrap().sample_count(), 2000);
}

/// What a session is looked at like is in its file: all that was set up is there again. What somebody sets up later is unsaved, and
/// in the copy.
#[test]
fn a_session_keeps_what_was_set_up_to_be_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let (copies, mine) = (folder.path().join("copies"), folder.path().join("mine.torquescope"));
    let tick = |window: &mut Window, name: &str| {
        window.get_by_role_and_label(Role::CheckBox, name).scroll_to_me();
        window.run_steps(3);
        window.get_by_role_and_label(Role::CheckBox, name).click();
        settle(window);
    };
    let numbers = |window: &mut Window| {
        let seen = [&model::ABOUT, &residuals::ABOUT, &compare::ABOUT].map(|screen| {
            window.state_mut().order(Order::Show(screen));
            settle(window);
            let figure = torquescope::figure::Figure::new(window.state_mut().figure().panels);
            let (csv, style) = (torquescope::figure::Format::Csv, torquescope::figure::Style::default());
            String::from_utf8(torquescope::figure::render(&figure, csv, &style).unwrap()).unwrap()
        });
        seen.join("\n")
    };
    let mut first = models::compared(&model::ABOUT);
    click(&mut first, "Models (4)");
    click(&mut first, "What it has learned");
    tick(&mut first, "Let the arm go at rest in this posture, without motors and friction");
    first.state_mut().order(Order::Show(&residuals::ABOUT));
    settle(&mut first);
    let chart = first.get_by_label("plot of residual against velocity [N m]").rect();
    drag(&mut first, chart.lerp_inside(egui::vec2(0.6, 0.4)), chart.lerp_inside(egui::vec2(0.9, 0.8)));
    first.state_mut().order(Order::Show(&compare::ABOUT));
    settle(&mut first);
    ["Terms", "Decompose"].into_iter().for_each(|name| tick(&mut first, name));
    type_into(&mut first, "formula of channels", "tau1 - predicted1");
    first.get_by_role_and_label(Role::ComboBox, "over it").click();
    first.run_steps(3);
    let other = first.state().session().recording.as_ref().unwrap().trajectories[0].name.clone();
    first.get_by_role_and_label(Role::Button, &other).click();
    settle(&mut first);
    charts::write_line(&mut first, "plot of joint 2: torque [N m]", 1, "4 * qd2");
    first.key_press(Key::Escape);
    settle(&mut first);
    let chart = first.get_by_label("plot of joint 1: torque [N m]").rect();
    first.hover_at(chart.center());
    first.run_steps(2);
    first.event(egui::Event::Zoom(1.6));
    settle(&mut first);
    let before = numbers(&mut first);
    for part in [
        "tau1 - predicted1",
        "4 * qd2",
        "term: viscous friction",
        "samples marked",
        &format!("measured τ, {other}"),
        "let go",
    ] {
        assert!(before.contains(part), "{part}");
    }
    first.state_mut().order(Order::Save(mine.clone()));
    settle(&mut first);

    let mut second = empty_window(&copies);
    second.state_mut().order(Order::open(vec![mine.clone()]));
    settle(&mut second);
    let after = numbers(&mut second);
    let differs = || before.lines().zip(after.lines()).find(|(one, other)| one != other);
    assert!(before == after, "{:?}", differs());
    close(&mut second);
    assert!(!asked(&second).contains(&ViewportCommand::CancelClose), "to look elsewhere is no change");
    // What is set up anew is asked about, and kept.
    type_into(&mut second, "formula of channels", "abs(qd2) * qd2");
    settle(&mut second);
    close(&mut second);
    second.run_steps(3);
    close_by(second, "Close, keep a copy");
    let mut third = empty_window(&copies);
    go_on(&mut third);
    assert!(third.state_mut().figure().panels.iter().any(|panel| panel.title == "abs(qd2) * qd2"));
    // Also without closing: the copy has it at once.
    type_into(&mut third, "formula of channels", "tau2");
    settle(&mut third);
    let kept = torquescope::session::file::open(&newest_copy(&copies), &torquescope::progress::Monitor::new()).unwrap();
    assert_eq!(kept.document.view.setup["own_series"]["text"], "tau2");
}

/// The copy that was written last.
fn newest_copy(copies: &Path) -> PathBuf {
    let files = std::fs::read_dir(copies).unwrap().map(|entry| entry.unwrap().path());
    let sessions = files.filter(|path| path.extension().is_some_and(|ending| ending == "torquescope"));
    sessions.max_by_key(|path| path.metadata().unwrap().modified().unwrap()).unwrap()
}
