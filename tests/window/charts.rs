//! What charts are asked for: a formula of one's own, what a model has learned, time that goes on, a figure for a paper.

use torquescope::app::desk::Drawing;
use torquescope::figure::{Figure, Format, Size, Style};
use torquescope::recording::hold_out::HoldOut;
use torquescope::recording::read::ReadOptions;

use super::*;

fn titles(window: &mut Window) -> Vec<String> {
    window.state_mut().figure().panels.into_iter().map(|panel| panel.title).collect()
}

fn write_into(window: &mut Window, field: &str, text: &str) {
    type_into(window, field, text);
    settle(window);
}

/// A formula of channels is one more chart, and a figure; a mistake is told with its place.
#[test]
fn a_formula_of_channels_is_drawn() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    write_into(&mut window, "formula of channels", "tau1 - predicted1");
    assert!(window.query_by_label_contains("plot of tau1 - predicted1").is_some());
    let panels = window.state_mut().figure().panels;
    let rows = |title: &str| {
        let panel = panels.iter().find(|panel| panel.title == title).unwrap();
        let mut rows: Vec<f64> = Vec::new();
        let line = panel.marks.iter().rfind(|mark| mark.entry().is_some()).unwrap();
        line.rows(&panel.x, &mut |row| rows.push(row.y));
        rows
    };
    assert_eq!(rows("tau1 - predicted1"), rows("joint 1: residual"));
    write_into(&mut window, "formula of channels", "2 * tua1");
    assert!(window.query_by_label_contains("column 5: there is no channel `tua1`; there are q1").is_some());
    write_into(&mut window, "formula of channels", "qd9");
    assert!(window.query_by_label_contains("there is no channel `qd9`").is_some(), "there are three joints");
}

/// The same formula stands on every screen with charts over time; behind a low-pass it is drawn over what it was.
#[test]
fn a_formula_passes_a_low_pass_on_every_screen() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    let legend = |window: &mut Window| -> Vec<String> {
        let panels = window.state_mut().figure().panels;
        let panel = panels.iter().find(|panel| panel.title == "tau1 * qd1").unwrap();
        panel.legend().iter().map(|entry| entry.name.to_owned()).collect()
    };
    assert!(window.query_by_label("low-pass").is_none(), "there is nothing to filter yet");
    write_into(&mut window, "formula of channels", "tau1 * qd1");
    assert!(legend(&mut window).is_empty());
    enter(&mut window, "low-pass", "5");
    settle(&mut window);
    assert_eq!(legend(&mut window), ["as it is", "low-pass 5 Hz"]);
    for screen in [&data::ABOUT, &model::ABOUT] {
        window.state_mut().order(Order::Show(screen));
        settle(&mut window);
        assert_eq!(legend(&mut window), ["as it is", "low-pass 5 Hz"], "{}", screen.id);
    }
    window.state_mut().order(Order::Show(&compare::ABOUT));
    settle(&mut window);
    enter(&mut window, "low-pass", "5000");
    settle(&mut window);
    assert!(window.query_by_label_contains("half the sampling rate").is_some());
}

/// Several formulas stand in one chart, each with a name and a look of its own.
#[test]
fn formulas_are_drawn_over_each_other() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    write_into(&mut window, "formula of channels", "tau1; 2 * tau1");
    let panels = window.state_mut().figure().panels;
    let panel = panels.iter().find(|panel| panel.title == "tau1; 2 * tau1").unwrap();
    assert_eq!(panel.legend().iter().map(|entry| entry.name).collect::<Vec<_>>(), ["tau1", "2 * tau1"]);
    write_into(&mut window, "formula of channels", "tau1; tau9");
    assert!(window.query_by_label_contains("there is no channel `tau9`").is_some());
    assert!(window.query_by_label_contains("plot of tau1; tau9").is_some(), "what can be drawn is");
}

/// Opens the menu of a chart, and writes a line of one's own into it, the n-th there.
pub fn write_line(window: &mut Window, chart: &str, number: usize, text: &str) {
    let plot = window.get_by_label(chart);
    plot.scroll_to_me();
    plot.focus();
    window.run_steps(4);
    window.key_press(Key::L);
    window.run_steps(4);
    click(window, "Add a line");
    write_into(window, &format!("line of your own {number}"), text);
}

/// The numbers of a line of a chart.
fn line_of(window: &mut Window, chart: &str, name: &str) -> Vec<[f64; 2]> {
    let panels = window.state_mut().figure().panels;
    let panel = panels.iter().find(|panel| panel.title == chart).unwrap_or_else(|| panic!("no chart {chart}"));
    let line = panel.marks.iter().find(|mark| mark.name() == name);
    let line = line.unwrap_or_else(|| panic!("{chart} has {:?}", panel.legend()));
    let mut points = Vec::new();
    line.rows(&panel.x, &mut |row| points.push([row.x, row.y]));
    points
}

/// A line of one's own stands in a chart of any screen: over time, over a state as its mean, and where the arm moves faster. It is
/// drawn over what is there, told if it can't be, kept in the session and on paper, and taken away again.
#[test]
fn lines_of_ones_own_stand_in_any_chart() {
    let mut window = window(support::extrapolated(), &compare::ABOUT, Theme::Light);
    let residual = "joint 1: residual";
    write_line(&mut window, "plot of joint 1: residual [N m]", 1, "tau1 - predicted1");
    assert_eq!(line_of(&mut window, residual, "tau1 - predicted1"), line_of(&mut window, residual, "τ − τ̂"));
    click(&mut window, "Add a line");
    write_into(&mut window, "line of your own 2", "tau1 - wrong");
    assert!(window.query_by_label_contains("column 8: there is no channel `wrong`").is_some());
    write_into(&mut window, "line of your own 2", "3 * qd1");
    enter(&mut window, "x from", "1");
    assert_eq!(legends::mistakes_on_screens(&mut window, &[&compare::ABOUT]), [""; 0]);
    assert!(line_of(&mut window, residual, "3 * qd1").len() > 100);
    click(&mut window, "Remove line 1");
    settle(&mut window);
    let panels = window.state_mut().figure().panels;
    let names = |title: &str| {
        let panel = panels.iter().find(|panel| panel.title == title).unwrap();
        panel.legend().iter().map(|entry| entry.name.to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(residual), ["τ − τ̂", "3 * qd1"]);
    assert_eq!(names("joint 2: residual"), ["τ − τ̂"]);

    window.state_mut().order(Order::Show(&residuals::ABOUT));
    settle(&mut window);
    let velocity = "residual against velocity";
    write_line(&mut window, "plot of residual against velocity [N m]", 1, "residual1");
    assert_eq!(line_of(&mut window, velocity, "residual1"), line_of(&mut window, velocity, "mean"));
    window.key_press(Key::Escape);
    settle(&mut window);
    write_line(&mut window, "plot of time line [N m]", 1, "residual1");
    assert_eq!(line_of(&mut window, "time line", "residual1"), line_of(&mut window, "time line", "τ − τ̂"));

    window.state_mut().order(Order::Show(&extrapolation::ABOUT));
    settle(&mut window);
    let replay = "joint 1: torque at this scale";
    write_line(&mut window, "plot of joint 1: torque at this scale [N m]", 1, "predicted1");
    assert_eq!(line_of(&mut window, replay, "predicted1"), line_of(&mut window, replay, "predicted τ̂"));
}

/// Where no cursor stands the values under the pointer are told beside it, and copied.
#[test]
fn values_under_the_pointer_are_copied_where_no_cursor_is() {
    let mut window = window(demonstration(), &residuals::ABOUT, Theme::Light);
    for (chart, unit) in [("residual against velocity [N m]", " N m"), ("mean residual, ↑ velocity [rad/s]", " rad/s")]
    {
        let spoken = format!("plot of {chart}");
        let plot = window.get_by_label(&spoken);
        plot.scroll_to_me();
        plot.focus();
        window.run_steps(4);
        let place = window.get_by_label(&spoken).rect();
        // Not everywhere in the map there is something.
        let copied = (3..8).find_map(|tenth| {
            window.hover_at(place.lerp_inside(egui::vec2(0.1 * tenth as f32, 0.4)));
            window.run_steps(3);
            copied(&mut window).filter(|lines| lines.len() == 3)
        });
        let lines = copied.unwrap_or_else(|| panic!("no value anywhere in {chart}"));
        assert_eq!(lines[0], chart);
        assert!(lines[1].contains(", ") && lines[1].ends_with(unit), "{lines:?}");
        assert!(lines[2].ends_with(" N m"), "the mean there: {lines:?}");
    }
}

/// What C copies of the chart that has the focus.
fn copied(window: &mut Window) -> Option<Vec<String>> {
    window.key_down(Key::C);
    window.step();
    let copied = window.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.lines().map(str::to_owned).collect()),
        _ => None,
    });
    window.key_up(Key::C);
    window.step();
    copied
}

/// From where to where a chart is seen can be typed; F shows everything again.
#[test]
fn limits_of_axes_are_typed() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    let seen = |window: &mut Window, title: &str| {
        let panels = window.state_mut().figure().panels;
        let panel = panels.iter().find(|panel| panel.title == title).unwrap();
        [panel.x.range, panel.y.range]
    };
    let before = seen(&mut window, "joint 1: torque");
    window.get_by_label("plot of joint 1: torque [N m]").focus();
    window.run_steps(2);
    window.key_press(Key::L);
    window.run_steps(4);
    for (field, limit) in [("x from", "1.5"), ("x to", "2.5"), ("y from", "-3"), ("y to", "7")] {
        enter(&mut window, field, limit);
    }
    assert_eq!(seen(&mut window, "joint 1: torque"), [Some([1.5, 2.5]), Some([-3.0, 7.0])]);
    assert_eq!(
        seen(&mut window, "joint 2: torque"),
        [Some([1.5, 2.5]), None],
        "time is the same in all, heights are not"
    );
    click(&mut window, "Show everything (F)");
    assert_eq!(seen(&mut window, "joint 1: torque"), before);
}

/// The values at the cursor are copied, with their place and units.
#[test]
fn values_at_the_cursor_are_copied() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    window.get_by_label("plot of joint 1: torque [N m]").focus();
    window.run_steps(2);
    let lines = copied(&mut window).unwrap();
    assert_eq!(lines[0], "joint 1: torque [N m]");
    assert!(lines[2].starts_with("measured τ ") && lines[2].ends_with(" N m"), "{lines:?}");
    assert_eq!(lines.len(), 4, "the time, and two lines: {lines:?}");
}

/// H, V, g, c, energy and power of any model; the truth beside them once the seal is open.
#[test]
fn what_a_model_has_learned_is_looked_into() {
    let mut window = window(support::repaired(), &model::ABOUT, Theme::Light);
    click(&mut window, "What it has learned");
    for title in ["H(q), diagonal", "eigenvalues of H(q)", "V(q)", "g(q)", "c(q, q̇)", "energy", "power"] {
        assert!(titles(&mut window).iter().any(|own| own == title), "{title}");
    }
    assert!(window.query_by_label_contains("plot of H(q), diagonal").is_some());
    let names = |window: &mut Window| -> Vec<String> {
        let panels = window.state_mut().figure().panels;
        let panel = panels.iter().find(|panel| panel.title == "g(q)").unwrap();
        panel.legend().iter().map(|entry| entry.name.to_owned()).collect()
    };
    assert_eq!(names(&mut window), ["g1", "g2", "g3"]);
    assert!(window.query_by_label_contains("Once the seal is open").is_some());
    window.state_mut().order(Order::run(Command::OpenSeal));
    settle(&mut window);
    assert_eq!(names(&mut window), ["truth", "g1", "g2", "g3"]);
}

/// Time goes on as fast as is asked, and stops at the end where it is not to begin anew.
#[test]
fn playing_has_a_speed_and_an_end() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    window.get_by_role_and_label(Role::ComboBox, "speed: 1 ×").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "4 ×").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::CheckBox, "Loop").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "▶ Play").click();
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::Button, "Pause").is_some());
    step_until(&mut window, "it is at its end", |window| {
        window.query_by_role_and_label(Role::Button, "▶ Play").is_some()
    });
}

/// The torque is written as the sum of its parts, and pointing at one changes how the others are drawn.
#[test]
fn a_symbol_of_the_formula_lights_its_line() {
    let mut window = window(support::repaired(), &compare::ABOUT, Theme::Light);
    window.get_by_role_and_label(Role::CheckBox, "Decompose").click();
    settle(&mut window);
    let symbol = window.get_by_label("c(q, q̇)").rect().center();
    let below = window.get_by_label("plot of joint 1: decomposition [N m]").rect();
    let picture = |window: &mut Window| {
        let picture = window.render().unwrap();
        let [x, y] = [below.left() as u32 + 60, below.top() as u32 + 20];
        image::imageops::crop_imm(&picture, x, y, below.width() as u32 - 80, below.height() as u32 - 30).to_image()
    };
    let before = picture(&mut window);
    window.hover_at(symbol);
    window.run_steps(3);
    let lit = picture(&mut window);
    let changed = before.pixels().zip(lit.pixels()).filter(|(one, other)| one != other).count();
    assert!(changed > 300, "{changed} pixels changed");
    window.hover_at(symbol + egui::vec2(0.0, -60.0));
    window.run_steps(3);
    assert!(picture(&mut window) == before);
}

/// What is marked between two cursors is played alone, again and again.
#[test]
fn a_marked_region_is_played_in_a_loop() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Dark);
    let time = |window: &Window| {
        let slider = window.get_by_role_and_label(Role::Slider, "time cursor");
        slider.accesskit_node().numeric_value().unwrap()
    };
    let chart = window.get_by_label("plot of joint 1: torque [N m]").rect();
    let marked = [0.0, 30.0].map(|right| chart.center() + egui::vec2(right, 0.0));
    window.key_down(Key::M);
    drag(&mut window, marked[0], marked[1]);
    window.key_up(Key::M);
    click(&mut window, "▶ Play");
    let mut times = Vec::new();
    for _ in 0..60 {
        window.step();
        times.push(time(&window));
    }
    let [least, most] = [f64::min, f64::max].map(|end: fn(f64, f64) -> f64| times.iter().copied().reduce(end).unwrap());
    let back = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
    let run = &window.state().session().recording.as_ref().unwrap().trajectories[0];
    let whole = run.time[run.len() - 1] - run.time[0];
    assert!(back >= 1 && most - least < 0.1 * whole, "{least} s to {most} s, {back} times back");
}

/// What is marked in state space is played alone, one stretch after the other over all trajectories, also where the arm is seen.
#[test]
fn a_region_of_state_space_is_played() {
    let mut window = window(demonstration(), &residuals::ABOUT, Theme::Dark);
    let chart = window.get_by_label("plot of residual against velocity [N m]").rect();
    let at = |x: f32, y: f32| chart.center() + egui::vec2(x * chart.width(), y * chart.height());
    // The fastest tenth.
    drag(&mut window, at(0.3, -0.45), at(0.49, 0.45));
    click(&mut window, "▶ Play what is marked");
    assert!(window.query_by_role_and_label(Role::Button, "Pause").is_some());
    click(&mut window, "See it in Compare");
    let session = window.state().session().clone();
    let recording = session.recording.clone().unwrap();
    let mut seen = Vec::new();
    for _ in 0..200 {
        window.step();
        // Of a trajectory that is shown for the first time, the arm is computed first.
        let Some(slider) = window.query_by_role_and_label(Role::Slider, "time cursor") else { continue };
        let time = slider.accesskit_node().numeric_value().unwrap();
        let name = window.get_by_role_and_label(Role::ComboBox, "Trajectory").accesskit_node().value().unwrap();
        let run = recording.trajectories.iter().position(|run| name == format!("{} (held out)", run.name)).unwrap();
        let sample = ((time / 0.01).round() as usize).min(recording.trajectories[run].len() - 1);
        seen.push((run, recording.trajectories[run].qd[0][sample]));
    }
    let most = session.split.held_out.iter().flat_map(|part| &recording.trajectories[part.trajectory].qd[0]);
    let most = most.fold(0.0, |most: f64, speed| most.max(*speed));
    assert!(seen.len() > 100 && seen.iter().all(|(_, speed)| *speed > 0.3 * most), "{most}: {seen:?}");
    let runs: std::collections::BTreeSet<usize> = seen.iter().map(|(run, _)| *run).collect();
    assert!(runs.len() > 1, "{runs:?}");
    click(&mut window, "Unmark");
    assert!(window.query_by_label_contains("Marked in “Where it fails”").is_none());
}

/// An export tells how far it is and can be stopped; then nothing of it is there.
#[test]
fn an_export_is_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(support::repaired(), &compare::ABOUT, Theme::Light);
    window.state_mut().order(Order::Export(None));
    settle(&mut window);
    window.get_by_role_and_label(Role::CheckBox, "Every screen, a file for each in a folder of this name").click();
    window.run_steps(2);
    type_into(&mut window, "File", folder.path().join("paper.png").display());
    window.get_by_role_and_label(Role::Button, "Write the file").click();
    window.run_steps(3);
    assert!(window.query_by_role(Role::ProgressIndicator).is_some() && window.query_by_label("ready").is_none());
    window.get_by_role_and_label(Role::Button, "Stop").click();
    settle(&mut window);
    assert!(window.query_by_label_contains("Nothing was exported, because you pressed Stop").is_some());
    assert!(!folder.path().join("paper").exists());
}

/// Where plots have more pixels than a picture can hold, it has as many as fit, and that is told.
#[test]
fn a_picture_that_is_too_tall_tells_its_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tall.png");
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    let panels = window.state_mut().figure().panels.into_iter().cycle().take(3).collect();
    let style = Style { size: Size::Slide, height: None, dpi: 4000.0, ..Style::default() };
    let drawing = Drawing { figure: Some(Figure::new(panels)), format: Format::Png, style, path: path.clone() };
    window.state_mut().order(Order::Draw(Box::new(drawing)));
    settle(&mut window);
    assert!(std::fs::read(path).unwrap().starts_with(b"\x89PNG"));
    assert!(window.query_by_label_contains("tall.png has 1").is_some(), "of 16384 pixels");
    assert!(window.query_by_label_contains("pixels an inch: more would be too many").is_some());
}

/// The report is where exports are, as a page and as paper, and two sessions stand side by side; it can be stopped.
#[test]
fn a_report_is_written_from_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let saved = folder.path().join("before.torquescope");
    let mut before = window(demonstration(), &compare::ABOUT, Theme::Light);
    before.state_mut().order(Order::Save(saved.clone()));
    settle(&mut before);
    let mut window = window(diagnosed(), &compare::ABOUT, Theme::Light);
    // What was found is told, although a step that is added makes it out of date.
    let add = Command::AddEffect { effect: "coulomb-friction".to_owned(), joints: vec![0] };
    window.state_mut().order(Order::run(add));
    settle(&mut window);
    let report = |window: &mut Window, format: &str, beside: Option<&Path>, to: &Path| {
        click(window, "Export");
        settle(window);
        click(window, "Report");
        window.get_by_role_and_label(Role::RadioButton, format).click();
        window.run_steps(2);
        if let Some(other) = beside {
            window.get_by_role_and_label(Role::CheckBox, "Beside another session that was saved").click();
            window.run_steps(2);
            write_into(window, "The other session", &other.display().to_string());
        }
        write_into(window, "File", &to.display().to_string());
        window.get_by_role_and_label(Role::Button, "Write the file").click();
        window.run_steps(3);
    };
    let [page, paper, both] = ["report.html", "report.pdf", "both.html"].map(|name| folder.path().join(name));
    report(&mut window, "HTML: one page", None, &page);
    window.get_by_role_and_label(Role::Button, "Stop").click();
    settle(&mut window);
    assert!(window.query_by_label_contains("Nothing was exported, because you pressed Stop").is_some());
    assert!(!page.exists());
    for (format, beside, to) in
        [("HTML: one page", None, &page), ("PDF", None, &paper), ("HTML: one page", Some(&*saved), &both)]
    {
        report(&mut window, format, beside, to);
        settle(&mut window);
    }
    let text = |path: &Path| String::from_utf8(std::fs::read(path).unwrap()).unwrap();
    assert!(text(&page).contains("What was ruled out") && text(&page).contains("<svg"));
    let again = ["simulate --embedded -o three-joint-demo.npz", "train three-joint-demo.npz --add coulomb-friction@1"];
    assert!(again.iter().all(|line| text(&page).contains(line)), "the commands that lead to it");
    assert!(std::fs::read(&paper).unwrap().starts_with(b"%PDF"));
    assert!(text(&both).contains("before") && text(&both).contains("beside"));
}

/// The choice of a format and the ending of the path say the same, whichever is changed; what names no format is not written.
#[test]
fn a_format_and_the_ending_of_its_file_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    let is_on = |window: &Window, name: &str| {
        let toggled = window.get_by_role_and_label(Role::RadioButton, name).accesskit_node().toggled();
        format!("{toggled:?}").contains("True")
    };
    for (plots, typed, format) in [(true, "a.PDF", "PDF"), (true, "a.png", "PNG"), (false, "a.md", "Markdown")] {
        click(&mut window, "Export");
        settle(&mut window);
        if !plots {
            click(&mut window, "Report");
            settle(&mut window);
        }
        assert!(!is_on(&window, format));
        write_into(&mut window, "File", &folder.path().join("a.doc").display().to_string());
        assert!(window.query_by_label_contains("names no format: end it with .").is_some());
        assert!(window.get_by_role_and_label(Role::Button, "Write the file").accesskit_node().is_disabled());
        write_into(&mut window, "File", &folder.path().join(typed).display().to_string());
        assert!(is_on(&window, format) && window.query_by_label_contains("names no format").is_none());
        window.get_by_role_and_label(Role::Button, "Write the file").click();
        settle(&mut window);
    }
    let begins = |name: &str, bytes: &[u8]| std::fs::read(folder.path().join(name)).unwrap().starts_with(bytes);
    assert!(begins("a.PDF", b"%PDF") && begins("a.png", b"\x89PNG") && begins("a.md", b"# What a model"));
}

/// An arm in space stands at the cursor in lines, in the window as in its figure, and a drag turns it.
#[test]
fn an_arm_in_space_is_drawn_and_turned() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("swing.csv");
    let row = |sample: u32| {
        let t = 0.02 * f64::from(sample);
        let [a, b] = [(2.0 * t).sin(), 0.7 * (3.1 * t).cos()];
        format!("{t},{a},{b},{},{}\n", -3.0 * a, 2.0 * b.cos())
    };
    let rows: String = (0..600).map(row).collect();
    std::fs::write(&log, format!("time,q1,q2,tau1,tau2\n{rows}")).unwrap();
    let axes = "[arm]\nconvention = \"standard\"\naxes = [{ d = 0.3, alpha = 1.5707963267948966 }, { a = 0.5 }]";
    let mapping = Some(torquescope::recording::mapping::MappingSpec::from_toml(axes).unwrap());
    let options = ReadOptions { mapping, ..ReadOptions::default() };
    let session = run(Command::open(vec![log], options, HoldOut::default()), &Session::default());
    let mut window = window(session, &compare::ABOUT, Theme::Light);
    settle(&mut window);
    // Where the second link is seen to begin and end, in metres of the page.
    let link = |window: &mut Window| -> Vec<[f64; 2]> {
        let panel =
            window.state_mut().figure().panels.into_iter().find(|panel| panel.title.starts_with("the arm at")).unwrap();
        let mut ends = Vec::new();
        for mark in panel.marks.iter().filter(|mark| mark.entry().is_some_and(|entry| entry.name == "link 2")) {
            mark.rows(&panel.x, &mut |row| ends.push([row.x, row.y]));
        }
        ends
    };
    let before = link(&mut window);
    let length = |ends: &[[f64; 2]]| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]);
    // The first joint stands 0.3 m above the base: that is 0.3 √⅔ in an isometric view.
    assert!((before[0][1] - 0.3 * (2.0f64 / 3.0).sqrt()).abs() < 1e-9 && before[0][0].abs() < 1e-9, "{before:?}");
    assert!(length(&before) <= 0.5 + 1e-9 && length(&before) > 0.0);
    let image =
        |window: &Window| window.get_by_role_and_label(Role::Image, "the arm at the time cursor").rect().center();
    let from = image(&window);
    window.drag_at(from);
    window.run_steps(2);
    window.hover_at(from + egui::vec2(60.0, 0.0));
    window.run_steps(2);
    window.drop_at(from + egui::vec2(60.0, 0.0));
    window.run_steps(2);
    let turned = link(&mut window);
    // About the vertical: heights stay, all else is seen from elsewhere.
    assert!((turned[0][1] - before[0][1]).abs() < 1e-9 && (turned[1][0] - before[1][0]).abs() > 0.01, "{turned:?}");
    window.get_by_role_and_label(Role::Image, "the arm at the time cursor").focus();
    window.run_steps(2);
    window.key_press(egui::Key::ArrowUp);
    window.run_steps(2);
    let higher = link(&mut window);
    assert!(higher[0][1] < turned[0][1], "seen from above, what stands upright is shorter: {higher:?}");
}

/// The dialog shows what the file will be, and how it is laid out can be chosen there.
#[test]
fn an_export_shows_a_preview() {
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    window.state_mut().order(Order::Export(None));
    settle(&mut window);
    let size = |window: &Window| window.get_by_role_and_label(Role::Image, "preview of the figure").rect().size();
    let before = size(&window);
    assert!(before.x > 100.0 && before.y > 100.0, "{before:?}");
    window.get_by_role_and_label(Role::CheckBox, "(a) (b)").click();
    window.get_by_label("serif").click();
    window.get_by_role_and_label(Role::CheckBox, "Height of a plot").click();
    settle(&mut window);
    assert_ne!(size(&window), before, "the plots have another height");
}

/// The plots of all screens are written in one go, a file for each in a folder.
#[test]
fn every_screen_is_exported_in_one_go() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    window.state_mut().order(Order::Export(None));
    settle(&mut window);
    window.get_by_role_and_label(Role::CheckBox, "Every screen, a file for each in a folder of this name").click();
    window.run_steps(2);
    export_to(&mut window, &folder.path().join("paper.csv"), "CSV: the numbers");
    let files = std::fs::read_dir(folder.path().join("paper")).unwrap().map(|entry| entry.unwrap().file_name());
    let files: Vec<String> = files.map(|name| name.to_string_lossy().into_owned()).collect();
    for screen in ["data.csv", "model.csv", "compare.csv", "residuals.csv", "ladder.csv"] {
        assert!(files.contains(&screen.to_owned()), "{screen}: {files:?}");
    }
}

/// Every screen is exported as it is: what is shown in place of the residual, and the zoom.
#[test]
fn every_screen_is_exported_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    settle(&mut window);
    window.get_by_role_and_label(Role::CheckBox, "Decompose").click();
    settle(&mut window);
    let plot = window.get_by_label("plot of joint 1: torque [N m]").rect();
    window.hover_at(plot.center());
    window.run_steps(2);
    for _ in 0..6 {
        window.event(egui::Event::Zoom(1.3));
        window.run_steps(2);
    }
    settle(&mut window);
    window.state_mut().order(Order::Show(&data::ABOUT));
    window.state_mut().order(Order::Export(None));
    settle(&mut window);
    window.get_by_role_and_label(Role::CheckBox, "Every screen, a file for each in a folder of this name").click();
    window.run_steps(2);
    export_to(&mut window, &folder.path().join("paper.csv"), "CSV: the numbers");
    let compare = std::fs::read_to_string(folder.path().join("paper/compare.csv")).unwrap();
    assert!(compare.contains("joint 1: decomposition") && !compare.contains("joint 1: residual"));
    let measured = compare.lines().filter(|line| line.contains("joint 1: torque") && line.contains("measured")).count();
    assert!((10..700).contains(&measured), "{measured} of 800 samples are in view");
    assert_eq!(window.state_mut().screen().id, "data", "the window stays where it is");
}

/// Plots are drawn in the order that is chosen in the dialog, also in the file.
#[test]
fn plots_are_exported_in_the_chosen_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("order.csv");
    let mut window = window(demonstration(), &compare::ABOUT, Theme::Light);
    window.state_mut().order(Order::Export(None));
    settle(&mut window);
    let top = |window: &Window, title: &str| window.get_by_role_and_label(Role::CheckBox, title).rect().top();
    let (torque, residual) = ("joint 1: torque", "joint 1: residual");
    assert!(top(&window, torque) < top(&window, residual));
    click(&mut window, "move down: joint 1: torque");
    settle(&mut window);
    assert!(top(&window, torque) > top(&window, residual));
    assert!(window.query_by_role_and_label(Role::Image, "preview of the figure").is_some());
    export_to(&mut window, &path, "CSV: the numbers");
    let table = std::fs::read_to_string(&path).unwrap();
    assert!(table.find(residual) < table.find(torque), "{}", &table[..300]);
}

/// A row for each joint, a column for each model that is shown: in the window, and as a figure.
#[test]
fn joints_and_models_stand_in_a_grid() {
    let mut window = models::compared(&compare::ABOUT);
    window.get_by_role_and_label(Role::ComboBox, "Grid").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "residual").click();
    settle(&mut window);
    let titles = ["rigid body", "rigid body + Coulomb 1, 2"].map(|model| format!("plot of joint 1: {model} [N m]"));
    let [one, other] = titles.map(|title| window.get_by_label(&title).rect());
    assert!((one.top() - other.top()).abs() < 1.0 && one.right() <= other.left(), "{one:?} {other:?}");
    let figure = window.state_mut().figure();
    let limits: Vec<Option<[f64; 2]>> = figure.panels.iter().map(|panel| panel.y.range).collect();
    assert_eq!((figure.columns, figure.panels.len()), (4, 12));
    assert!(limits[0].is_some() && limits[0] == limits[3] && limits[0] != limits[4], "{limits:?}");
}

/// What is printed of a saved session has the models that were drawn over each other when it was saved.
#[test]
fn a_saved_session_is_printed_as_one_looked_at_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.torquescope");
    let mut writer = models::compared(&compare::ABOUT);
    writer.state_mut().order(Order::Save(path.clone()));
    settle(&mut writer);
    let document = torquescope::session::file::open(&path, &torquescope::progress::Monitor::new()).unwrap().document;
    let panels = torquescope::app::plots(document.history.current().clone(), document.view.clone(), &compare::ABOUT);
    let torque = panels.iter().find(|panel| panel.title == "joint 1: torque").unwrap();
    let names: Vec<&str> = torque.legend().iter().map(|entry| entry.name).collect();
    assert!(names.contains(&"rigid body") && names.contains(&"rigid body + Coulomb 1, 2"), "{names:?}");
}
