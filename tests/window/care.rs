//! Small things that were seen once, and are not to come back.

use torquescope::session::TermEdit;

use super::*;

/// Whether a step of the way has its check mark.
fn has_mark(window: &Window, screen: &About) -> bool {
    let button = window.get_by_role_and_label(Role::Button, screen.title);
    button.accesskit_node().value().is_some_and(|value| value == "done")
}

#[test]
fn a_screen_has_its_mark_once_somebody_was_there() {
    let mut window = window(demonstration(), &data::ABOUT, Theme::Dark);
    assert!(!has_mark(&window, &model::ABOUT) && !has_mark(&window, &compare::ABOUT));
    click(&mut window, "Compare");
    click(&mut window, "Data");
    assert!(has_mark(&window, &compare::ABOUT) && !has_mark(&window, &model::ABOUT));
    // Of another recording nobody has seen anything yet.
    window.state_mut().order(Order::run(Command::Simulate(Box::new(Scenario { seed: 5, ..Scenario::embedded() }))));
    settle(&mut window);
    assert!(!has_mark(&window, &compare::ABOUT));
}

/// The names of all steps stand in the bar of a small window, in two lines if need be, and so does the next step.
#[test]
fn the_way_keeps_its_names_in_a_small_window() {
    let mut window = window(diagnosed(), &diagnose::ABOUT, Theme::Dark);
    for [width, height] in [[1000.0, 700.0], [960.0, 640.0], [640.0, 640.0]] {
        window.set_size(egui::vec2(width, height));
        window.run_steps(4);
        let mut rects: Vec<egui::Rect> = Vec::new();
        for name in screens::all().map(|screen| screen.title).chain(["Export", "Next: Add Coulomb friction"]) {
            let rect = window.get_by_role_and_label(Role::Button, name).rect();
            let least = 4.5 * name.len().min(8) as f32;
            assert!(rect.width() > least && rect.right() <= width, "{name} in {width}: {rect:?}");
            assert!(!rects.iter().any(|other| other.intersects(rect.shrink(1.0))), "{name} in {width}: {rect:?}");
            rects.push(rect);
        }
    }
}

/// What is typed is found in sight, wherever one had scrolled to; and networks are trained by name.
#[test]
fn the_palette_keeps_its_choice_in_sight_and_trains() {
    let mut window = window(Session { plan: short_plan(2), ..small() }, &data::ABOUT, Theme::Dark);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    for _ in 0..60 {
        window.key_press(Key::ArrowDown);
        window.step();
    }
    window.run_steps(10);
    window.event(egui::Event::Text("add".to_owned()));
    window.run_steps(10);
    let field = window.get_by_role_and_label(Role::TextInput, "Command").rect();
    let lines = window.root().children_recursive().filter(|node| {
        let node = node.accesskit_node();
        node.role() == Role::Button && node.label().is_some_and(|name| name.starts_with("Add "))
    });
    let first = lines.map(|line| line.rect()).min_by(|one, other| one.top().total_cmp(&other.top())).unwrap();
    assert!(first.top() >= field.bottom(), "{first:?} below {field:?}");
    window.key_press(Key::Escape);
    window.run_steps(3);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.event(egui::Event::Text("train structured".to_owned()));
    window.run_steps(3);
    window.key_press(Key::Enter);
    settle(&mut window);
    assert_eq!(window.state().session().current().unwrap().name, "structured DeLaN");
}

/// What a dialog covers is out of reach of keys, too.
#[test]
fn dialogs_let_no_shortcut_through() {
    let mut window = window(support::repaired(), &ladder::ABOUT, Theme::Dark);
    click(&mut window, "Remove the last step");
    let opened: [(Modifiers, Key, &str); 3] = [
        (Modifiers::COMMAND, Key::E, "Write the file"),
        (Modifiers::NONE, Key::F1, "Keyboard and mouse"),
        (Modifiers::COMMAND, Key::P, "Command"),
    ];
    for (modifiers, key, name) in opened {
        window.key_press_modifiers(modifiers, key);
        window.run_steps(4);
        assert!(window.query_by_label(name).is_some(), "{name} is open");
        // The palette has a line of that name.
        let is_alone = name != "Command";
        assert!(!is_alone || !is_enabled(&window, "Next: What is missing"), "the answer to {name} comes next");
        for key in [Key::Z, Key::Num1, Key::Enter, Key::T] {
            window.key_press_modifiers(Modifiers::COMMAND, key);
            window.run_steps(3);
        }
        assert_eq!((window.state().session().ladder.len(), window.state().screen()), (1, &ladder::ABOUT), "{name}");
        assert_eq!(window.ctx.theme(), Theme::Dark, "{name}");
        window.key_press(Key::Escape);
        window.run_steps(3);
        assert!(window.query_by_label(name).is_none(), "{name} is shut");
    }
}

/// Everything of the arm is in its drawing, whatever its links are.
#[test]
fn the_arm_that_is_edited_is_seen_whole() {
    let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
    click(&mut window, "Simulate your own");
    let is_whole = |window: &Window| {
        let drawing = window.get_by_role_and_label(Role::Image, "the arm to be simulated").rect();
        let handles = window.root().children_recursive().filter(|node| {
            node.accesskit_node().role() == Role::Slider
                && node.accesskit_node().label().is_some_and(|name| name.starts_with("drag the "))
        });
        let handles: Vec<egui::Rect> = handles.map(|node| node.rect()).collect();
        assert!(
            handles.len() >= 2 && handles.iter().all(|handle| drawing.contains_rect(*handle)),
            "{drawing:?}: {handles:?}"
        );
    };
    is_whole(&window);
    window.get_by_label("The arm: 3 links").click();
    settle(&mut window);
    for (button, times) in [("Remove the last link", 2), ("Add a link", 5)] {
        (0..times).for_each(|_| click(&mut window, button));
        window.get_by_role_and_label(Role::Image, "the arm to be simulated").scroll_to_me();
        settle(&mut window);
        is_whole(&window);
    }
}

/// An error that rose is told without the mark of success.
#[test]
fn an_error_that_rose_is_no_success() {
    let mut window = window(support::repaired(), &model::ABOUT, Theme::Light);
    window.state_mut().order(Order::run(Command::EditTerms(TermEdit::Remove(1))));
    settle(&mut window);
    assert!(window.query_by_label_contains("✔ Remove a term").is_none());
    assert!(window.query_by_label_contains("Remove a term: mean held-out error rose").is_some());
    window.state_mut().order(Order::Undo);
    window.state_mut().order(Order::run(Command::AddEffect { effect: "viscous-friction".into(), joints: vec![0] }));
    settle(&mut window);
    assert!(window.query_all_by_label_contains("rigid body + Coulomb").count() > 0, "the model is told by its name");
}

/// Who points at a word of the trade is told what it means.
#[test]
fn words_are_explained_to_those_who_point_at_them() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    let status = window.get_by_label_contains("held-out error by joint (nMSE)").rect();
    window.hover_at(status.center());
    window.run_steps(60);
    assert!(window.query_by_label_contains("squared error over squared torque. 0 % is perfect").is_some());
    assert!(window.query_by_label_contains("kept from the fit").is_some());
}

/// The colours of the map say what they stand for.
#[test]
fn the_map_of_the_residual_has_a_scale() {
    let mut window = window(demonstration(), &residuals::ABOUT, Theme::Light);
    let figures = window.state_mut().figure().panels;
    let map = figures.iter().find(|panel| panel.title.starts_with("mean residual")).unwrap();
    let scale = map.legend()[0].name;
    assert!(scale.starts_with('−') && scale.ends_with("N m"), "{scale}");
}
