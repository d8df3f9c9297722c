//! The models of a session side by side: one table, one name each, drawn over each other on every screen.

use torquescope::figure::mark::Key as LineKey;

use super::*;

/// The names of all models, in the order of the table.
pub(crate) fn names(window: &Window) -> Vec<String> {
    window.state().session().all_models().map(|step| step.name.clone()).collect()
}

/// The repaired arm with two models more, four in all.
pub(crate) fn four() -> Session {
    let add = |session: &Session, effect: &str, joint: usize| {
        run(Command::AddEffect { effect: effect.to_owned(), joints: vec![joint] }, session)
    };
    add(&add(&support::repaired(), "viscous-friction", 0), "torque-offset", 1)
}

/// The same with its table of models open, everything shown.
pub(crate) fn compared(screen: &'static About) -> Window {
    show_all(window(four(), screen, Theme::Light))
}

/// The window with its table of four models open, all of them shown.
pub(crate) fn show_all(mut window: Window) -> Window {
    click(&mut window, "Models (4)");
    for name in ["rigid body", "rigid body + Coulomb 1, 2", "rigid body + Coulomb 1, 2 + viscous 1"] {
        window.get_by_role_and_label(Role::CheckBox, &format!("show {name}")).click();
        window.run_steps(3);
    }
    settle(&mut window);
    window
}

fn is_spoken(window: &Window, label: &str) -> bool {
    window.query_by_label(label).is_some()
}

/// Every model is used, renamed and deleted by the table, and undo takes it back.
#[test]
fn models_are_used_renamed_and_deleted_by_their_table() {
    let mut window = compared(&compare::ABOUT);
    let current = |window: &Window| window.state().session().current().unwrap().name.clone();
    click(&mut window, "Use rigid body");
    assert_eq!((current(&window).as_str(), window.state().session().ladder.len()), ("rigid body", 1));
    let last = "rigid body + Coulomb 1, 2 + viscous 1 + torque offset 2";
    click(&mut window, &format!("Delete {last}"));
    assert_eq!(names(&window).len(), 3);
    click(&mut window, "Undo");
    assert_eq!(names(&window).last().unwrap(), last);
    assert!(!is_enabled(&window, "Redo") || names(&window).len() == 4);
    // A name is written in its place, and stands everywhere then.
    let field = "name of rigid body + Coulomb 1, 2";
    type_into(&mut window, field, "with friction");
    window.key_press(Key::Enter);
    settle(&mut window);
    assert!(is_spoken(&window, "with friction in joint 1: torque") && is_spoken(&window, "show with friction"));
    window.state_mut().order(Order::Show(&ladder::ABOUT));
    settle(&mut window);
    assert!(is_spoken(&window, "bars of with friction"));
    click(&mut window, "bars of with friction");
    assert_eq!(current(&window), "with friction");
    // Two can't have the same name.
    window.state_mut().order(Order::run(Command::Rename { name: "rigid body".into(), to: "with friction".into() }));
    settle(&mut window);
    assert!(window.query_by_label_contains("another model has that name already").is_some());
}

/// Also with three models over the current one, and with all terms: no line is without its name.
#[test]
fn a_legend_names_every_line_that_is_drawn() {
    let mut window = compared(&compare::ABOUT);
    window.get_by_role_and_label(Role::CheckBox, "Terms").click();
    settle(&mut window);
    for name in [
        "measured τ",
        "predicted τ̂",
        "rigid body",
        "rigid body + Coulomb 1, 2",
        "rigid body + Coulomb 1, 2 + viscous 1",
        "term: rigid body",
        "term: Coulomb friction, joint 1",
        "term: viscous friction, joint 1",
    ] {
        assert!(is_spoken(&window, &format!("{name} in joint 1: torque")), "{name}");
    }
    for panel in window.state_mut().figure().panels.iter().filter(|panel| panel.title.ends_with(": torque")) {
        let mut dashes: Vec<&[f32]> = Vec::new();
        for entry in panel.legend() {
            let LineKey::Line(_, dash, ..) = entry.key else { panic!("{} is a line", entry.name) };
            assert!(!dashes.contains(&dash), "{}: {} looks like another on paper", panel.title, entry.name);
            dashes.push(dash);
        }
        assert!(dashes.len() > 5, "{}", panel.title);
    }
}

/// What is ticked is drawn on every screen, in the same way.
#[test]
fn models_are_drawn_over_each_other_on_every_screen() {
    let mut window = compared(&compare::ABOUT);
    let shown = [
        (&compare::ABOUT, "joint 1: residual", " [N m]"),
        (&residuals::ABOUT, "residual against velocity", " [N m]"),
        (&residuals::ABOUT, "residual power by frequency", " [(N m)²/Hz]"),
        (&residuals::ABOUT, "time line", " [N m]"),
        (&extrapolation::ABOUT, "joint 1: torque at this scale", " [N m]"),
    ];
    for (screen, title, unit) in shown {
        window.state_mut().order(Order::Show(screen));
        settle(&mut window);
        window.get_by_label(&format!("plot of {title}{unit}")).scroll_to_me();
        settle(&mut window);
        assert!(is_spoken(&window, &format!("rigid body in {title}")), "{title}");
    }
    // One part of the torque, of all models.
    window.state_mut().order(Order::Show(&compare::ABOUT));
    settle(&mut window);
    window.get_by_role_and_label(Role::CheckBox, "Decompose").click();
    settle(&mut window);
    window.get_by_role_and_label(Role::ComboBox, "Part").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "gravity").click();
    settle(&mut window);
    assert!(is_spoken(&window, "rigid body in joint 1: gravity"));
    // Hidden again, it is nowhere.
    window.get_by_role_and_label(Role::CheckBox, "show rigid body").click();
    settle(&mut window);
    assert!(!is_spoken(&window, "rigid body in joint 1: gravity"));
}

/// Where lines over each other could not be told apart, each model has a chart or a row of its own.
#[test]
fn models_stand_beside_each_other() {
    let mut window = compared(&residuals::ABOUT);
    let chart = window.get_by_label("plot of residual against velocity [N m]").rect();
    drag(&mut window, chart.lerp_inside(egui::vec2(0.02, 0.02)), chart.lerp_inside(egui::vec2(0.98, 0.98)));
    settle(&mut window);
    let of =
        |window: &Window, title: &str| names(window).iter().map(|name| title.replace('*', name)).collect::<Vec<_>>();
    let panels = window.state_mut().figure().panels;
    let titled = |panels: &[torquescope::figure::Panel], part: &str| -> Vec<String> {
        panels.iter().map(|panel| panel.title.clone()).filter(|title| title.contains(part)).collect()
    };
    let sorted = |mut titles: Vec<String>| {
        titles.sort();
        titles
    };
    let maps = of(&window, "*: ↑ velocity");
    assert_eq!(sorted(titled(&panels, ": ↑ velocity")), sorted(maps.clone()));
    let legend = |title: &str| -> Vec<&str> {
        let panel = panels.iter().find(|panel| panel.title == title).unwrap();
        panel.legend().iter().map(|entry| entry.name).collect()
    };
    assert_eq!(legend("residual–velocity loop around the cursor"), names(&window));
    assert_eq!(legend("residual power by frequency: marked region")[1..], names(&window));
    // One scale of colours for all.
    let scales: Vec<Vec<&str>> = maps.iter().map(|title| legend(title)).collect();
    assert!(scales.iter().all(|scale| scale.len() == 1 && *scale == scales[0]), "{scales:?}");
    window.get_by_label(&format!("plot of {} [rad/s]", maps[1])).scroll_to_me();
    settle(&mut window);

    window.state_mut().order(Order::Show(&compare::ABOUT));
    settle(&mut window);
    let panels = window.state_mut().figure().panels;
    assert_eq!(sorted(titled(&panels, "joint 2: τ̂ of")), sorted(of(&window, "joint 2: τ̂ of *")));
    assert!(is_spoken(&window, "What others leave: τ − τ̂ [N m]"));
    click(&mut window, "Errors by trajectory");
    let all = names(&window);
    let rows = [&all[3..], &all[..3]].concat().join("\n");
    assert!(window.query_all_by_label(&rows).count() > 1, "{rows}");
}

/// H, V, g, c, energy, power and the friction of all joints, of every model that is shown.
#[test]
fn models_are_looked_into_over_each_other() {
    let mut window = compared(&model::ABOUT);
    click(&mut window, "Models (4)");
    click(&mut window, "What it has learned");
    let titles =
        ["H(q), diagonal: H11", "eigenvalues of H(q): λ3", "V(q)", "g(q): g2", "c(q, q̇): c3", "energy: kinetic T"];
    let panels = window.state_mut().figure().panels;
    for title in titles {
        let panel = panels.iter().find(|panel| panel.title == title).unwrap();
        let legend: Vec<&str> = panel.legend().iter().map(|entry| entry.name).collect();
        assert_eq!(legend, names(&window), "{title}");
    }
    let tops = [1, 2, 3].map(|joint| {
        let title = format!("joint {joint}: beside inertia and gravity");
        window.get_by_label(&format!("plot of {title} [N m]")).scroll_to_me();
        settle(&mut window);
        assert!(is_spoken(&window, &format!("rigid body in {title}")), "{title}");
        assert!(is_spoken(&window, &format!("measured in {title}")), "{title}");
        window.get_by_label(&format!("plot of {title} [N m]")).rect().top()
    });
    assert!(tops.iter().all(|top| (top - tops[0]).abs() < 40.0), "side by side: {tops:?}");
}

/// A long name goes on in the next line of the table, and is written there as a short one is.
#[test]
fn a_long_name_is_seen_whole() {
    let mut window = compared(&compare::ABOUT);
    let long = "a rigid body with friction of its first joint, my own one";
    let rename = Command::Rename { name: "rigid body".into(), to: long.into() };
    window.state_mut().order(Order::run(rename));
    settle(&mut window);
    let rect =
        |window: &Window, name: &str| window.get_by_role_and_label(Role::TextInput, &format!("name of {name}")).rect();
    let (whole, short) = (rect(&window, long), rect(&window, "rigid body + Coulomb 1, 2"));
    assert!(whole.height() > 1.5 * short.height() && short.height() < 32.0, "{whole:?} {short:?}");
    assert!(whole.width() > 250.0, "{whole:?}");
    assert_eq!(whole.width(), short.width());
}

/// What is ticked to be compared is the next step on Compare; then it is drawn.
#[test]
fn the_next_step_makes_the_models_that_are_ticked() {
    let mut window = window(Session { plan: short_plan(2), ..small() }, &compare::ABOUT, Theme::Dark);
    click(&mut window, "Models (1)");
    for name in ["FF-NN", "stated arm"] {
        window.get_by_role_and_label(Role::CheckBox, name).click();
        window.run_steps(3);
    }
    click(&mut window, "Next: Make stated arm, FF-NN");
    assert_eq!(names(&window), ["rigid body", "stated arm", "FF-NN"]);
    assert_eq!(window.state().session().current().unwrap().name, "rigid body");
    assert!(is_spoken(&window, "FF-NN in joint 1: torque") && is_spoken(&window, "stated arm in joint 1: torque"));
    assert!(window.query_by_label_contains("Next: Make").is_none());
}

/// Five trainings by one click: their mean and band are drawn, the table tells their spread, and all are models.
#[test]
fn a_model_is_trained_from_five_seeds() {
    let mut window = window(Session { plan: short_plan(3), ..support::trained() }, &train::ABOUT, Theme::Dark);
    click(&mut window, "Train five seeds");
    let session = window.state().session();
    assert_eq!(session.seeds_of(session.current().unwrap()).len(), 5);
    assert!(window.query_by_label_contains("Error on held-out data, 5 seeds").is_some());
    let legend = |window: &mut Window| -> Vec<String> {
        let panels = window.state_mut().figure().panels;
        panels[0].legend().iter().map(|entry| entry.name.to_owned()).collect()
    };
    let mean = "held-out nMSE, mean of 5 seeds".to_owned();
    assert!(legend(&mut window).contains(&mean), "{:?}", legend(&mut window));
    window.get_by_role_and_label(Role::CheckBox, "This seed alone").click();
    settle(&mut window);
    assert!(!legend(&mut window).contains(&mean) && legend(&mut window).contains(&"validation nMSE".to_owned()));
}

/// How far the arms run off is asked for by a click, told for each model by joint, and saved with the session.
#[test]
fn the_arms_of_models_are_simulated_by_a_click() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(support::repaired(), &compare::ABOUT, Theme::Light);
    click(&mut window, "Models (2)");
    assert_eq!(window.query_all_by_label("—").count(), 4, "seeds and rollouts");
    click(&mut window, "Simulate");
    assert!(window.query_by_role_and_label(Role::Button, "Simulate").is_none(), "nothing is left to ask");
    let errors = |session: &Session| -> Vec<f64> {
        session.all_models().map(|step| step.rollout.as_ref().unwrap().error[0]).collect()
    };
    let told = errors(window.state().session());
    assert!(told[1] < 0.5 * told[0], "the one with friction stays nearer: {told:?}");
    let path = folder.path().join("mine.torquescope");
    window.state_mut().order(Order::Save(path.clone()));
    settle(&mut window);
    let opened = torquescope::session::file::open(&path, &torquescope::progress::Monitor::new()).unwrap();
    assert_eq!(errors(opened.document.history.current()), told);
    // A model that is new was not simulated yet.
    window.state_mut().order(Order::run(Command::AddEffect { effect: "torque-offset".into(), joints: vec![1] }));
    settle(&mut window);
    assert!(is_enabled(&window, "Simulate"));
}

/// A training that gets stuck begins anew: that is said while it goes on, and stands in the table of models.
#[test]
fn a_training_that_got_stuck_is_told_of() {
    let mut plan = short_plan(20);
    plan.options.rate = 1e-12;
    let mut window = window(small(), &train::ABOUT, Theme::Light);
    let train = Command::TrainPreset { preset: torquescope::model::learned::LearnedPreset::FfNn, plan: Box::new(plan) };
    window.state_mut().order(Order::run(train));
    settle(&mut window);
    assert!(window.query_by_label_contains("The training got stuck").is_some());
    click(&mut window, "Models (2)");
    assert!(window.query_by_label_contains("best of 2 starts").is_some());
}

/// A right click on a table offers to copy it, wherever in the table it is.
#[test]
fn tables_are_copied_for_papers() {
    let mut window = window(support::repaired(), &ladder::ABOUT, Theme::Light);
    let copied = |window: &mut Window, at: &str, format: &str| {
        window.get_all_by_label(at).next().unwrap().click_secondary();
        settle(window);
        window.get_by_label(&format!("Copy as {format}")).click();
        let text = (0..5).find_map(|_| {
            window.step();
            window.output().platform_output.commands.iter().find_map(|command| match command {
                egui::OutputCommand::CopyText(text) => Some(text.clone()),
                _ => None,
            })
        });
        settle(window);
        text.unwrap_or_else(|| panic!("{at} was not copied as {format}"))
    };
    let markdown = copied(&mut window, "95 % interval", "Markdown");
    assert!(markdown.starts_with("| parameter | joint | value | 95 % interval |"), "{markdown}");
    let steps = copied(&mut window, "step", "LaTeX");
    assert!(steps.contains("\\caption{held-out error, step by step}") && steps.contains("\\toprule"), "{steps}");
    click(&mut window, "Models (2)");
    let models = copied(&mut window, "parameters", "CSV");
    assert!(models.starts_with("model,nMSE of joint 1,") && models.lines().count() == 3, "{models}");
    assert!(window.query_by_label("Copy as CSV").is_none(), "the menu is closed");
}

/// What is identified as published values were is the same as on the command line, and changes nothing in the session.
#[test]
fn a_model_is_identified_plainly_too() {
    let session = demonstration();
    let mut window = window(session.clone(), &model::ABOUT, Theme::Light);
    settle(&mut window);
    click(&mut window, "Plain least squares");
    assert!(window.query_by_label("nMSE over all").is_none());
    click(&mut window, "Identify so");
    settle(&mut window);
    assert!(window.query_by_label("nMSE over all").is_some());
    let recording = session.recording.clone().unwrap();
    let model = &session.current().unwrap().fitted.model;
    let plain = torquescope::model::fit_plain(model, &recording, 0.0, &torquescope::progress::Monitor::new()).unwrap();
    let value = plain.parameters.iter().find(|parameter| parameter.identified).unwrap().value;
    let shown = torquescope::figure::ticks::number(value);
    assert!(window.query_all_by_label(&shown).next().is_some(), "{shown}");
    assert_eq!(window.state().session().all_models().count(), session.all_models().count());
}
