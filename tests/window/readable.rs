//! Every control has a name and can be reached by Tab, and every text can be read: on every screen and in every dialog, from
//! the smallest text to the largest.

use std::collections::{BTreeMap, BTreeSet};

use torquescope::diagnosis::{Alternative, Exciting, NotKnown, Note, TellingMotion, Verdict};
use torquescope::effect::registry;

use super::*;

/// The sizes of text between which nothing may be cut off.
const SCALES: [f32; 3] = [0.8, 1.0, 2.0];

/// Roles that a user operates.
const CONTROLS: [Role; 7] =
    [Role::Button, Role::RadioButton, Role::CheckBox, Role::Slider, Role::SpinButton, Role::TextInput, Role::ComboBox];

/// Something that opens over a screen.
struct Dialog {
    name: &'static str,
    screen: &'static About,
    open: fn(&mut Window),
    /// Whether nothing else can be reached while it is open.
    modal: bool,
    /// A control that must be wholly inside the window, or can be scrolled there: the way out.
    exit: &'static str,
}

/// Everything that opens over a screen.
const DIALOGS: [Dialog; 15] = [
    Dialog {
        modal: true,
        name: "import assistant",
        screen: &data::ABOUT,
        open: |window| window.state_mut().order(Order::Import(vec!["gallery/nameless-logger".into()], Box::default())),
        exit: "Cancel",
    },
    Dialog {
        modal: true,
        name: "export",
        screen: &compare::ABOUT,
        open: |window| window.key_press_modifiers(Modifiers::COMMAND, Key::E),
        exit: "Write the file",
    },
    Dialog {
        modal: true,
        name: "export of a model",
        screen: &compare::ABOUT,
        open: |window| outgoing::ask(window, ExportPage::Model, "URDF"),
        exit: "Write the file",
    },
    Dialog {
        modal: true,
        name: "export of data",
        screen: &compare::ABOUT,
        open: |window| outgoing::ask(window, ExportPage::Data, "Torques of a model"),
        exit: "Write the file",
    },
    Dialog {
        modal: true,
        name: "palette",
        screen: &model::ABOUT,
        open: |window| window.key_press_modifiers(Modifiers::COMMAND, Key::P),
        exit: "Next: Compare",
    },
    Dialog {
        modal: false,
        name: "models",
        screen: &compare::ABOUT,
        open: |window| window.key_press_modifiers(Modifiers::COMMAND, Key::M),
        exit: "Close the models",
    },
    Dialog {
        modal: true,
        name: "key list",
        screen: &data::ABOUT,
        open: |window| window.key_press(Key::F1),
        exit: "Close",
    },
    Dialog { modal: true, name: "closing", screen: &data::ABOUT, open: lost::close, exit: "Close, keep a copy" },
    Dialog {
        modal: true,
        name: "seal",
        screen: &ladder::ABOUT,
        open: |window| window.state_mut().order(torquescope::app::desk::Question::open_seal()),
        exit: "Leave it shut",
    },
    Dialog {
        modal: false,
        name: "arm editor",
        screen: &data::ABOUT,
        open: |window| {
            click(window, "Simulate your own");
            window.get_by_label("The arm: 3 links").click_accesskit();
        },
        exit: "Remove the last link",
    },
    Dialog {
        modal: false,
        name: "hidden effect",
        screen: &data::ABOUT,
        open: |window| click(window, "Simulate your own"),
        exit: "Simulate",
    },
    Dialog {
        modal: false,
        name: "mystery",
        screen: &data::ABOUT,
        open: |window| {
            click(window, "Sources");
            window.get_by_role_and_label(Role::SpinButton, "Seed").scroll_to_me();
        },
        exit: "Draw a mystery",
    },
    Dialog {
        modal: false,
        name: "view",
        screen: &compare::ABOUT,
        open: |window| click(window, "View"),
        exit: "Keyboard shortcuts (F1)",
    },
    Dialog {
        modal: false,
        name: "all settings of a training",
        screen: &train::ABOUT,
        open: |window| {
            click(window, "Model and settings");
            window.get_by_role_and_label(Role::RadioButton, "structured DeLaN").click_accesskit();
            window.run_steps(3);
            window.get_by_label("More settings").click_accesskit();
        },
        exit: "Start training",
    },
    Dialog {
        modal: false,
        name: "placed bet",
        screen: &diagnose::ABOUT,
        open: |window| window.get_by_role(Role::CheckBox).click_accesskit(),
        exit: "Diagnose",
    },
];

/// The window with a dialog open.
fn opened(dialog: &Dialog, scale: f32) -> Window {
    let mut window = window(support::demonstration(), dialog.screen, Theme::Light);
    window.ctx.set_zoom_factor(scale);
    window.run_steps(4);
    (dialog.open)(&mut window);
    // What it reads of files comes while it is drawn, with controls of its own.
    support::settle(&mut window);
    window
}

/// The sessions between which screens differ.
fn sessions() -> [Session; 6] {
    let opened = run(Command::OpenSeal, &support::extrapolated());
    [Session::default(), demonstration(), diagnosed(), wordy(), opened, trained()]
}

/// A diagnosis with much to say: several effects, each with others that are like it, and long advice.
fn wordy() -> Session {
    let session = diagnosed();
    let mut report = session.report.as_deref().unwrap().clone();
    let find = |id| registry::find(id).unwrap();
    let other = Alternative { effect: find("bouc-wen-hysteresis"), elsewhere: None, joints: vec![0] };
    let telling = TellingMotion { motion: Exciting::Speed { factor: 2.5 }, against: other.effect, gain: 3.0 };
    for id in ["viscous-friction", "asymmetric-friction", "position-friction"] {
        let mut effect = report.effects[0].clone();
        (effect.effect, effect.alternatives) = (find(id), vec![other.clone(); 5]);
        report.notes.push(Note::HardlyTold { effect: find(id), from: vec![other.clone(); 5], telling: Some(telling) });
        report.effects.push(effect);
    }
    report.verdict = Verdict::Ambiguous;
    report.not_known = vec![NotKnown::AbsorbedByBody { effect: find("rotor-inertia"), joint: Some(0) }; 9];
    Session { report: Some(Arc::new(report)), ..session }
}

/// Goes to a screen, as its button does.
fn show(window: &mut Window, screen: &'static About) {
    window.state_mut().order(Order::Show(screen));
    window.run_steps(5);
}

/// A control that a screen reader can't announce.
fn unnamed(window: &Window) -> Option<String> {
    let found = window.root().children_recursive().find(|node| {
        let node = node.accesskit_node();
        CONTROLS.contains(&node.role())
            && node.label().is_none_or(|name| name.trim().is_empty())
            && node.labelled_by().next().is_none()
    });
    found.map(|node| format!("{node:?}"))
}

/// What a screen reader would announce as a control has a name, on every screen and in every dialog.
#[test]
fn every_control_has_a_name() {
    for (number, session) in sessions().into_iter().enumerate() {
        let mut window = window(session, &data::ABOUT, Theme::Light);
        for screen in screens::all() {
            show(&mut window, screen);
            let found = unnamed(&window);
            assert!(found.is_none(), "session {number}, screen {}: {found:?}", screen.id);
        }
    }
    for dialog in DIALOGS {
        let found = unnamed(&opened(&dialog, 1.0));
        assert!(found.is_none(), "{}: {found:?}", dialog.name);
    }
}

/// Texts that are cut off at the left or right by what holds them.
fn cut_texts(window: &Window) -> Vec<String> {
    fn visit(shape: &egui::Shape, clip: egui::Rect, all: &mut usize, cut: &mut Vec<String>) {
        match shape {
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| visit(shape, clip, all, cut)),
            egui::Shape::Text(text) => {
                *all += 1;
                let rect = text.visual_bounding_rect();
                let seen = clip.y_range().intersects(rect.y_range()) && rect.width() > 0.0 && clip.width() > 0.0;
                if seen && (rect.left() < clip.left() - 1.5 || rect.right() > clip.right() + 1.5) {
                    cut.push(text.galley.text().to_owned());
                }
            }
            _ => (),
        }
    }
    let (mut all, mut cut) = (0, Vec::new());
    for clipped in &window.output().shapes {
        visit(&clipped.shape, clipped.clip_rect, &mut all, &mut cut);
    }
    assert!(all > 20, "only {all} texts were drawn");
    cut
}

/// Where a row of text is seen, and what it says.
type Row = (egui::Rect, String);

/// The rows of text of the window that nothing lies over, in the order in which they are drawn.
fn rows_of_text(window: &Window) -> Vec<Row> {
    /// A ground of at least this area, such as that of a dialog, hides what was drawn before \[points²\].
    const COVER: f32 = 20_000.0;
    fn visit(shape: &egui::Shape, clip: egui::Rect, rows: &mut Vec<Row>) {
        match shape {
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| visit(shape, clip, rows)),
            egui::Shape::Rect(ground) if ground.fill.a() > 60 => {
                let rect = ground.rect.intersect(clip);
                if rect.is_positive() && rect.area() > COVER {
                    rows.retain(|(row, _)| !rect.intersects(*row));
                }
            }
            egui::Shape::Text(text) => {
                // The name of a vertical axis is turned about its beginning.
                let turned = egui::emath::Rot2::from_angle(text.angle);
                for row in text.galley.rows.iter().filter(|row| !row.text().trim().is_empty()) {
                    let rect = row.rect_without_leading_space().rotate_bb(turned);
                    let rect = rect.translate(text.pos.to_vec2()).intersect(clip);
                    rows.push((rect.shrink(2.0), row.text()));
                }
            }
            _ => (),
        }
    }
    let mut rows = Vec::new();
    for clipped in &window.output().shapes {
        visit(&clipped.shape, clipped.clip_rect, &mut rows);
    }
    rows
}

/// Pairs of texts of which one is written over the other.
fn texts_on_each_other(window: &Window) -> Vec<[String; 2]> {
    let rows = rows_of_text(window);
    let pairs =
        rows.iter().enumerate().flat_map(|(number, one)| rows[number + 1..].iter().map(move |other| (one, other)));
    pairs
        .filter(|(one, other)| one.0.intersect(other.0).is_positive())
        .map(|(one, other)| [one.1.clone(), other.1.clone()])
        .collect()
}

/// What can't be read in a window.
fn unreadable(window: &Window) -> Option<String> {
    let (cut, over) = (cut_texts(window), texts_on_each_other(window));
    (!cut.is_empty() || !over.is_empty()).then(|| format!("cut {cut:?}, over {over:?}"))
}

/// At 1280x800 no text is cut off or written over another, from the smallest text to the largest.
#[test]
fn no_text_is_cut_off() {
    let mut problems = Vec::new();
    for (number, session) in sessions().into_iter().enumerate() {
        let mut window = window(session, &data::ABOUT, Theme::Light);
        for scale in SCALES {
            window.ctx.set_zoom_factor(scale);
            for screen in screens::all() {
                show(&mut window, screen);
                let found = unreadable(&window);
                problems.extend(found.map(|found| format!("session {number}, {} at {scale}: {found}", screen.id)));
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// Neither is one in a dialog, and its way out is in sight or can be scrolled there.
#[test]
fn no_text_of_a_dialog_is_cut_off() {
    let mut problems = Vec::new();
    for dialog in DIALOGS {
        for scale in SCALES {
            let mut window = opened(&dialog, scale);
            let found = unreadable(&window);
            problems.extend(found.map(|found| format!("{} at {scale}: {found}", dialog.name)));
            let Some(exit) = window.query_all_by_role_and_label(Role::Button, dialog.exit).last() else {
                problems.push(format!("{} at {scale}: there is no “{}”", dialog.name, dialog.exit));
                continue;
            };
            exit.scroll_to_me();
            window.run_steps(4);
            let exit = window.query_all_by_role_and_label(Role::Button, dialog.exit).last().unwrap().rect();
            let seen = window.ctx.content_rect();
            if !seen.contains_rect(exit) {
                problems.push(format!("{} at {scale}: “{}” is at {exit:?} of {seen:?}", dialog.name, dialog.exit));
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// With nothing but Tab every control of a screen is reached.
#[test]
fn tab_reaches_every_control() {
    let mut problems = Vec::new();
    for session in [Session::default(), run(Command::OpenSeal, &support::extrapolated()), trained()] {
        let mut window = window(session, &data::ABOUT, Theme::Dark);
        for screen in screens::all() {
            show(&mut window, screen);
            problems.extend(missed_by_tab(&mut window, None).map(|missed| format!("{}: {missed}", screen.id)));
        }
    }
    // In the palette the arrows choose, and a menu closes when the focus leaves it.
    for dialog in DIALOGS.into_iter().filter(|dialog| !["palette", "view"].contains(&dialog.name)) {
        let mut window = opened(&dialog, 1.0);
        let missed = missed_by_tab(&mut window, dialog.modal.then_some(dialog.exit));
        problems.extend(missed.map(|missed| format!("{}: {missed}", dialog.name)));
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The controls that a full round of Tab does not reach; of all, or of those with a name.
fn missed_by_tab(window: &mut Window, name: Option<&str>) -> Option<String> {
    let controls: BTreeMap<String, String> = window
        .root()
        .children_recursive()
        .map(|node| node.accesskit_node())
        .filter(|node| CONTROLS.contains(&node.role()) && !node.is_disabled())
        .filter(|node| name.is_none() || node.label().as_deref() == name)
        .map(|node| (format!("{:?}", node.id()), format!("{:?} {:?}", node.role(), node.label())))
        .collect();
    let mut reached = BTreeSet::new();
    // There are texts and plots that take the focus, too.
    for _ in 0..2 * controls.len() + 60 {
        window.key_press(Key::Tab);
        window.step();
        let focused = window.root().children_recursive().find(|node| node.is_focused());
        reached.extend(focused.map(|node| format!("{:?}", node.accesskit_node().id())));
    }
    let missed: Vec<&String> = controls.iter().filter(|(id, _)| !reached.contains(*id)).map(|(_, name)| name).collect();
    (!missed.is_empty()).then(|| format!("{missed:?}"))
}
