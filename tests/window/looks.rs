//! Where one looks: linked views, marked regions, panels that keys and names move, and drawings that are exported.

use torquescope::model::learned::LearnedPreset;

use super::*;

/// The numbers of the plots of the shown screen: title, series, x and y.
fn numbers(window: &mut Window) -> Vec<(String, String, [f64; 2])> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plots.csv");
    window.key_press_modifiers(Modifiers::COMMAND, Key::E);
    window.run_steps(4);
    export_to(window, &path, "CSV: the numbers");
    let number = |text: &str| text.parse().unwrap_or(f64::NAN);
    let row = |row: csv::StringRecord| (row[0].to_owned(), row[2].to_owned(), [number(&row[3]), number(&row[4])]);
    csv::Reader::from_path(path).unwrap().into_records().map(|record| row(record.unwrap())).collect()
}

/// The points of a series of a plot.
fn series(window: &mut Window, title: &str, name: &str) -> Vec<[f64; 2]> {
    let rows = numbers(window).into_iter();
    rows.filter(|(own, series, _)| own == title && series == name).map(|(.., point)| point).collect()
}

/// The smallest and largest x of a plot.
fn extent(window: &mut Window, title: &str) -> [f64; 2] {
    let rows = numbers(window);
    let x = rows.iter().filter(|(own, ..)| own == title).map(|(.., [x, _])| *x).filter(|x| x.is_finite());
    x.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// Zooms about the middle of a plot by a pinch, or Ctrl and the wheel.
fn zoom(window: &mut Window, plot: &str, factor: f32) {
    let plot = format!("plot of {plot}");
    window.get_by_label(&plot).scroll_to_me();
    window.run_steps(3);
    window.hover_at(window.get_by_label(&plot).rect().center());
    window.run_steps(2);
    window.event(egui::Event::Zoom(factor));
    window.run_steps(4);
}

/// Charts of the same quantity of the same joint zoom together, on every screen, and show everything again together.
#[test]
fn charts_of_the_same_quantity_are_linked() {
    let mut window = window(diagnosed(), &residuals::ABOUT, Theme::Dark);
    window.run_steps(3);
    let width = |[low, high]: [f64; 2]| high - low;
    let velocity = |window: &mut Window| extent(window, "residual against velocity");
    let position = |window: &mut Window| extent(window, "residual against position");
    let (whole, everywhere) = (velocity(&mut window), position(&mut window));
    zoom(&mut window, "residual–velocity loop around the cursor [N m]", 4.0);
    let seen = velocity(&mut window);
    assert!(width(seen) < 0.5 * width(whole), "{whole:?} -> {seen:?}");
    assert_eq!(position(&mut window), everywhere, "another quantity stays");
    click(&mut window, "joint 2");
    let other = velocity(&mut window);
    assert!(width(other) > 2.0 * width(seen), "another joint stays: {other:?}");
    click(&mut window, "What is missing");
    let title = "joint 1: torque left against velocity";
    let near = extent(&mut window, title);
    assert!(seen[0] - 0.2 < near[0] && near[1] < seen[1] + 0.2, "{near:?} is in {seen:?}");
    window.key_press(Key::Home);
    window.run_steps(3);
    let all = extent(&mut window, title);
    assert!(width(all) > 2.0 * width(near), "{near:?} -> {all:?}");
    click(&mut window, "Where it fails");
    click(&mut window, "joint 1");
    assert_eq!(velocity(&mut window), whole);

    // Frequencies of the torque and of what is left of it.
    zoom(&mut window, "residual power by frequency [(N m)²/Hz]", 8.0);
    zoom(&mut window, "residual against position [N m]", 4.0);
    let near = position(&mut window);
    let power = "joint 1: power of τ, logarithmic";
    click(&mut window, "Data");
    click(&mut window, "Coverage and spectrum");
    let few = extent(&mut window, power);
    click(&mut window, "Recording");
    click(&mut window, "Fit");
    let many = extent(&mut window, power);
    assert!(width(few) < 0.2 * width(many), "{few:?} of {many:?} Hz are seen");
    click(&mut window, "Where it fails");
    let all = position(&mut window);
    assert!(width(near) < 0.5 * width(all) && all == everywhere, "{near:?} -> {all:?}");
}

/// Marks a region of a plot, given by its corners as shares of the plot.
fn mark(window: &mut Window, plot: &str, from: [f32; 2], to: [f32; 2]) {
    let plot = format!("plot of {plot}");
    window.get_by_label(&plot).scroll_to_me();
    window.run_steps(3);
    let rect = window.get_by_label(&plot).rect();
    let at = |[x, y]: [f32; 2]| rect.min + egui::vec2(x, y) * rect.size();
    drag(window, at(from), at(to));
    settle(window);
}

/// Spectra and autocorrelation are those of the marked region, and say so; the other views light it.
#[test]
fn spectra_follow_the_marked_region() {
    let mut window = window(demonstration(), &residuals::ABOUT, Theme::Light);
    let titles = ["residual power by frequency", "residual amplitude by order", "residual autocorrelation"];
    let whole = titles.map(|title| series(&mut window, title, ""));
    assert!(whole.iter().all(|curve| curve.len() > 10));
    mark(&mut window, "residual against time [N m]", [0.3, 0.1], [0.6, 0.8]);
    assert!(window.query_by_label_contains("samples marked").is_some(), "the time line lights it");
    for (title, whole) in titles.into_iter().zip(&whole) {
        let own = format!("{title}: marked region");
        assert!(window.query_by_label_contains(&format!("plot of {own}")).is_some(), "{own}");
        let marked = series(&mut window, &own, "marked");
        assert!(marked.len() > 10, "{own}");
        assert_ne!(&marked, whole, "{title} is of the marked region");
        assert_eq!(&series(&mut window, &own, "all"), whole, "{title} of all samples stays behind it");
    }
    assert_eq!(window.query_all_by_label_contains("the marked region alone").count(), 3, "the sentences say so");
    let past = format!("{}: marked region", titles[2]);
    let first = series(&mut window, &past, "marked");
    mark(&mut window, "residual against time [N m]", [0.65, 0.1], [0.9, 0.8]);
    assert_ne!(series(&mut window, &past, "marked"), first, "another region, another past");
    mark(&mut window, "residual against time [N m]", [0.5, 0.1], [0.52, 0.3]);
    assert!(window.query_all_by_label_contains("the marked region is too short").count() > 0);
    click(&mut window, "Unmark");
    assert_eq!(series(&mut window, titles[0], ""), whole[0]);
}

fn tab(window: &Window, name: &str) -> egui::Rect {
    window.get_by_role_and_label(Role::Button, name).rect()
}

/// Does what a command of the palette does.
fn by_name(window: &mut Window, name: &str) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.event(egui::Event::Text(name.to_owned()));
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(5);
}

/// Panels are chosen, moved, hidden and put back by name.
#[test]
fn panels_are_moved_by_name() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    window.run_steps(2);
    let before = tab(&window, "At the cursor");
    by_name(&mut window, "Panel At the cursor: move to the left");
    assert!(tab(&window, "At the cursor").left() < tab(&window, "Torques").left());
    by_name(&mut window, "Panel At the cursor: move into the tabs of Torques");
    assert_eq!(tab(&window, "At the cursor").top(), tab(&window, "Torques").top());
    by_name(&mut window, "Panel Errors by trajectory: move to the bottom");
    assert!(tab(&window, "Errors by trajectory").top() > tab(&window, "Torques").top() + 100.0);
    by_name(&mut window, "Reset the layout of this screen");
    assert_eq!(tab(&window, "At the cursor"), before);
    by_name(&mut window, "Panel Errors by trajectory: show in front");
    assert!(window.query_by_role_and_label(Role::Button, "sort by the error of joint 2").is_some());
    by_name(&mut window, "Panel Errors by trajectory: hide");
    assert!(window.query_by_role_and_label(Role::Button, "Errors by trajectory").is_none());
    by_name(&mut window, "Panel Errors by trajectory: show in front");
    assert!(window.query_by_role_and_label(Role::Button, "Errors by trajectory").is_some());
}

/// The same by keys: F6 goes from tab to tab, Shift and an arrow moves the panel, Delete hides it.
#[test]
fn panels_are_moved_by_keys() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    window.run_steps(2);
    let focus = |window: &mut Window, name: &str| {
        for _ in 0..8 {
            window.key_press(Key::F6);
            window.run_steps(3);
            if window.get_by_role_and_label(Role::Button, name).is_focused() {
                return;
            }
        }
        panic!("F6 does not reach {name}");
    };
    focus(&mut window, "Torques");
    focus(&mut window, "At the cursor");
    window.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
    window.run_steps(5);
    assert!(tab(&window, "At the cursor").left() < tab(&window, "Torques").left());
    focus(&mut window, "Errors by trajectory");
    window.key_press(Key::Enter);
    // Its table is computed beside the window.
    let is_there =
        |window: &Window| window.query_by_role_and_label(Role::Button, "sort by the error of joint 2").is_some();
    step_until(&mut window, "the table is there", is_there);
    focus(&mut window, "At the cursor");
    window.key_press(Key::Delete);
    window.run_steps(4);
    assert!(window.query_by_role_and_label(Role::Button, "At the cursor").is_none());
    by_name(&mut window, "Panel At the cursor: show in front");
    assert!(window.query_by_role_and_label(Role::Button, "At the cursor").is_some());
}

/// The schedule is drawn before a training and ahead of it, and is what the training does.
#[test]
fn the_schedule_is_drawn_ahead() {
    let mut before = window(small(), &train::ABOUT, Theme::Light);
    assert!(before.query_by_label("plot of learning rate").is_none(), "a rigid body has no schedule");
    before.get_by_role_and_label(Role::RadioButton, "structured DeLaN").click();
    before.run_steps(3);
    let planned = series(&mut before, "learning rate", "planned");
    assert_eq!(planned.last().unwrap()[0], Session::default().plan.options.epochs as f64);

    let plan = Box::new(short_plan(60));
    let mut window = window(small(), &train::ABOUT, Theme::Light);
    window.state_mut().order(Order::run(Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan }));
    window.run_steps(2);
    wait_for_an_epoch(&mut window);
    window.get_by_role_and_label(Role::Button, "Stop and keep the best").click();
    settle(&mut window);
    let [planned, done] = ["planned", "done"].map(|name| series(&mut window, "learning rate", name));
    assert!(!done.is_empty() && planned.iter().any(|[epoch, _]| *epoch == 60.0), "{planned:?}");
    for [epoch, rate] in done {
        let [_, ahead] = planned.iter().find(|[at, _]| *at == epoch).unwrap();
        assert!((ahead / rate - 1.0).abs() < 1e-9, "epoch {epoch}: {rate}, but {ahead} was planned");
    }
}

/// Drawings are exported as plots are.
#[test]
fn drawings_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    for (screen, session, drawing, word) in [
        (&model::ABOUT, trained(), "structure of the model: the sum of", "H = C Cᵀ"),
        (&compare::ABOUT, demonstration(), "the arm at the time cursor", "path of the tip"),
    ] {
        let mut window = window(session, screen, Theme::Dark);
        window.run_steps(2);
        window.get_by_label_contains(drawing).focus();
        window.run_steps(2);
        window.key_press(Key::E);
        window.run_steps(4);
        let path = folder.path().join("drawing.svg");
        export_to(&mut window, &path, "SVG");
        let svg = std::fs::read_to_string(path).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains(word), "{drawing}");
    }
}
