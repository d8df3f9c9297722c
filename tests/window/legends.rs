//! What a reader of a chart, also of a grey print, has to go by: the legend, and how each line looks.

use torquescope::figure::mark::Key as LineKey;
use torquescope::figure::{Ink, Panel, Theme as Paper};
use torquescope::simulation::extrapolation::Stretch;

use super::*;

/// Shades of grey that are nearer to each other than this look the same on paper.
const SAME_GREY: f64 = 16.0;
/// So do widths that differ by less than this factor.
const SAME_WIDTH: f64 = 1.2;

/// What is wrong with the lines of a panel: they have no name although there are several, or two look alike without colours.
fn mistakes(panel: &Panel) -> Vec<String> {
    let entries = panel.marks.iter().filter_map(|mark| Some((mark.name(), mark.entry()?)));
    let lines: Vec<_> = entries
        .filter_map(|(name, entry)| match entry.key {
            LineKey::Line(ink, dash, opacity, width) => {
                let grey = 255.0 - opacity * (255.0 - f64::from(Paper::Grey.colours().of(ink)[0]));
                Some((name, entry.name, ink, (dash, grey, width)))
            }
            _ => None,
        })
        .collect();
    let mut mistakes = Vec::new();
    for (number, (name, in_legend, ink, (dash, grey, width))) in lines.iter().enumerate() {
        // A diagonal says by itself what it is.
        if in_legend.is_empty() && lines.len() > 1 && *ink != Ink::Weak {
            mistakes.push(format!("{}: line {number} has no name", panel.title));
        }
        for (other, .., (other_dash, other_grey, other_width)) in &lines[..number] {
            let factor = (width / other_width).max(other_width / width);
            // What is drawn in pieces has one name.
            let is_another = name != other;
            if is_another && dash == other_dash && (grey - other_grey).abs() < SAME_GREY && factor < SAME_WIDTH {
                mistakes.push(format!("{}: {other:?} and {name:?} look alike", panel.title));
            }
        }
    }
    mistakes
}

/// The mistakes on all screens as they are set up.
pub fn mistakes_on_screens(window: &mut Window, screens: &[&'static About]) -> Vec<String> {
    let mut found = Vec::new();
    for screen in screens {
        window.state_mut().order(Order::Show(screen));
        settle(window);
        let panels = window.state_mut().figure().panels;
        assert!(panels.iter().any(|panel| !panel.legend().is_empty()), "{} shows lines", screen.id);
        let own = panels.iter().filter(|panel| !panel.bare).flat_map(mistakes);
        found.extend(own.map(|mistake| format!("{}: {mistake}", screen.id)));
    }
    found
}

/// On every screen, of one model and of several over each other, with the truth.
#[test]
fn every_line_has_a_name_and_a_look_of_its_own() {
    let session = run(Command::OpenSeal, &models::four());
    let models = session.models.iter().filter_map(|kept| kept.step().cloned()).collect();
    let session = run(Command::Extrapolate { steps: models, stretch: Stretch::Speed }, &session);
    let charts = [&compare::ABOUT, &model::ABOUT, &residuals::ABOUT, &extrapolation::ABOUT];
    let tick = |window: &mut Window, name: &str| {
        window.get_by_role_and_label(Role::CheckBox, name).scroll_to_me();
        window.run_steps(3);
        window.get_by_role_and_label(Role::CheckBox, name).click();
        settle(window);
    };
    let mut alone = window(session.clone(), &model::ABOUT, Theme::Light);
    click(&mut alone, "What it has learned");
    tick(&mut alone, "Let the arm go at rest in this posture, without motors and friction");
    let mut found = mistakes_on_screens(&mut alone, &charts);
    let mut compared = models::show_all(alone);
    found.extend(mistakes_on_screens(&mut compared, &charts));
    compared.state_mut().order(Order::Show(&compare::ABOUT));
    settle(&mut compared);
    for name in ["Terms", "Decompose"] {
        tick(&mut compared, name);
    }
    found.extend(mistakes_on_screens(&mut compared, &charts[..1]));
    let mut trained = window(trained(), &train::ABOUT, Theme::Light);
    found.extend(mistakes_on_screens(&mut trained, &[&train::ABOUT]));
    let mut experiment = window(Session::default(), &experiment::ABOUT, Theme::Light);
    experiment.state_mut().order(Order::Experiment(support::experiment()));
    found.extend(mistakes_on_screens(&mut experiment, &[&experiment::ABOUT]));
    let panels = experiment.state_mut().figure().panels;
    let names: Vec<&str> = panels[0].legend().iter().map(|entry| entry.name).collect();
    assert_eq!(names, ["rigid body", "with-friction"], "a preset has its short name here, too");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// One name in the legend stands for the truth of all components, which hides all of it; a component is hidden by its own.
#[test]
fn a_name_hides_all_lines_that_it_stands_for() {
    let mut window = window(run(Command::OpenSeal, &support::repaired()), &model::ABOUT, Theme::Light);
    click(&mut window, "What it has learned");
    let drawn = |window: &mut Window| -> Vec<String> {
        let panels = window.state_mut().figure().panels;
        let panel = panels.iter().find(|panel| panel.title == "H(q), diagonal").unwrap();
        panel.marks.iter().map(|mark| mark.name().to_owned()).collect()
    };
    let truths = ["truth of H11", "truth of H22", "truth of H33"];
    let own = ["H11", "H22", "H33"];
    assert_eq!(drawn(&mut window), [truths, own].concat());
    window.get_by_role_and_label(Role::CheckBox, "truth in H(q), diagonal").click();
    settle(&mut window);
    assert_eq!(drawn(&mut window), own);
}
