//! The figures of an experiment, made out of what was run: the paper's, for any models and data.
//!
//! | name | what it shows | in the paper |
//! |---|---|---|
//! | `trajectories` | ways of the tip of a simulated arm | figure 3 |
//! | `torques-SET` | torque and its parts along the first runs of a test set | figures 4, A1, A2 |
//! | `curve-NAME` | error along a curve of test sets | figure 5 |
//! | `motions` | positions and velocities of the training data and of each test set | figure 6 |
//! | `errors` | error of each model on each test set | figures 7, 8 |

use std::path::Path;

use super::cell::Cell;
use super::file::{Source, TestSet};
use super::metrics::{mean, parts_of, torque};
use super::run::{exact_arm, load, trained_members};
use super::store::Store;
use super::summary::{Row, curves, summarise};
use super::{Experiment, ExperimentError, cell, plan};
use crate::figure::mark::{Band, Bars, Line, Points};
use crate::figure::{Axis, Figure, Ink, Panel, Shared};
use crate::model::Fitted;
use crate::progress::Monitor;
use crate::recording::{Recording, Trajectory};
use crate::signals::Signals;
use crate::statistics::ends;

/// Runs of a test set that are drawn, as in the paper.
const RUNS: usize = 3;
/// Points of the motion of a test set that are drawn for each joint.
const MOTION_POINTS: usize = 2_000;
/// Errors this much below the largest are rounding errors: they would only stretch the axis.
const SMALLEST: f64 = 1e-10;
/// The part of a run's duration that is left free between two runs on one axis.
const PAUSE: f64 = 0.08;

/// A figure and its name, which is that of its file.
#[derive(Debug, Clone)]
pub struct NamedFigure {
    /// As in the table above.
    pub name: String,
    /// What is drawn.
    pub figure: Figure,
}

/// All figures for which there are results; `only` keeps those whose name contains it.
///
/// # Errors
/// [`ExperimentError`] if data or store can't be read, or it was stopped.
pub fn figures(
    experiment: &Experiment,
    store: &Store,
    data: Option<&Path>,
    only: Option<&str>,
    monitor: &Monitor,
) -> Result<Vec<NamedFigure>, ExperimentError> {
    let cells = plan(experiment, data)?;
    let rows = summarise(experiment, &cells, store)?;
    let wanted = |name: &str| only.is_none_or(|only| name.contains(only));
    let mut figures = Vec::new();
    let mut add = |name: String, figure: Figure| {
        if !figure.panels.is_empty() && wanted(&name) {
            figures.push(NamedFigure { name, figure });
        }
    };
    let sets = cells.first().map_or(&[][..], |cell| &cell.tests);
    let sets: Vec<&TestSet> = sets.iter().map(|(set, _)| set).filter(|set| set.point.is_none()).collect();
    let torques_wanted = sets.iter().any(|set| wanted(&torques_name(set)));
    if torques_wanted || wanted("trajectories") || wanted("motions") {
        let shown = shown_sets(&sets, data, monitor)?;
        add("trajectories".to_owned(), trajectories(&shown));
        if wanted("motions")
            && let Some(cell) = cells.first()
        {
            let training = load(&cell.inputs.source, data, monitor)?;
            add("motions".to_owned(), motions(&training, &shown));
        }
        if torques_wanted {
            let members = members(experiment, &cells, store)?;
            for (index, (set, recording)) in shown.iter().enumerate() {
                let name = torques_name(set);
                monitor.report(index as f32 / shown.len() as f32, &name)?;
                if wanted(&name) && !members.is_empty() {
                    add(name, torques(set, recording, &members)?);
                }
            }
        }
    }
    for (name, figure) in curve_figures(experiment, &rows) {
        add(name, figure);
    }
    add("errors".to_owned(), errors(experiment, &sets, &rows));
    Ok(figures)
}

fn torques_name(set: &TestSet) -> String {
    format!("torques-{}", file_name(&set.name))
}

/// `non-iid-0, 3 runs` as `non-iid-0-3-runs`.
fn file_name(text: &str) -> String {
    let words = text.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

/// The first runs of each test set; of sets that begin with the same runs only the first.
fn shown_sets<'a>(
    sets: &[&'a TestSet],
    data: Option<&Path>,
    monitor: &Monitor,
) -> Result<Vec<(&'a TestSet, Recording)>, ExperimentError> {
    let mut shown: Vec<(&TestSet, Recording)> = Vec::new();
    for set in sets {
        let mut recording = load(&set.source, data, monitor)?;
        recording.trajectories.truncate(RUNS);
        if shown.iter().all(|(_, other)| other.trajectories != recording.trajectories) {
            shown.push((set, recording));
        }
    }
    Ok(shown)
}

/// Ways of the tip; of sets that go the same ways, such as a faster one, only the first.
fn trajectories(sets: &[(&TestSet, Recording)]) -> Figure {
    let (mut panels, mut seen): (Vec<Panel>, Vec<&Recording>) = (Vec::new(), Vec::new());
    for (set, recording) in sets {
        let Source::Simulated(scenarios) = &set.source else { continue };
        let Some(arm) = scenarios.first().map(|scenario| &scenario.arm) else { continue };
        let reach: f64 = arm.links.iter().map(|link| link.length).sum();
        let axis = |label: &str| Axis::new(label, "m").range([-1.05 * reach, 1.05 * reach]);
        let mut panel = Panel::new(&set.name, [axis("x"), axis("z")]).aspect(1.0);
        for (number, run) in recording.trajectories.iter().enumerate() {
            let state = |sample: usize| -> Vec<f64> { run.q.iter().map(|joint| joint[sample]).collect() };
            let tip = (0..run.len()).map(|sample| arm.tip(&state(sample)));
            panel = panel.with(Line::path(format!("run {}", number + 1), tip, Ink::Series(number)));
            let last = arm.points(&state(run.len() - 1));
            panel = panel.with(Line::path("", last.clone(), Ink::Text)).with(Points::new("", last, Ink::Text));
        }
        if !seen.iter().any(|other| same_ways(other, recording)) {
            seen.push(recording);
            panels.push(panel);
        }
    }
    Figure { columns: panels.len().clamp(1, 2), panels }
}

/// Whether two recordings pass through the same positions, at any speed.
fn same_ways(one: &Recording, other: &Recording) -> bool {
    let positions = |recording: &Recording| -> Vec<f64> {
        recording.trajectories.iter().flat_map(|run| run.q.values().to_vec()).collect()
    };
    let (one, other) = (positions(one), positions(other));
    one.len() == other.len() && one.iter().zip(&other).all(|(one, other)| (one - other).abs() < 1e-9)
}

/// What each data set holds: velocity over position, all joints.
fn motions(training: &Recording, sets: &[(&TestSet, Recording)]) -> Figure {
    let named = std::iter::once(("training".to_owned(), training))
        .chain(sets.iter().map(|(set, recording)| (set.name.clone(), recording)));
    let mut panels = Vec::new();
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for (name, recording) in named {
        let [angle, speed, ..] = recording.joints.first().map_or([""; 4], |joint| joint.kind.units());
        let mut panel = Panel::new(name, [Axis::new("q", angle), Axis::new("q̇", speed)]).aspect(0.8);
        let every = (recording.sample_count() / MOTION_POINTS).max(1);
        for joint in 0..recording.joint_count() {
            let states = recording.trajectories.iter().flat_map(|run| run.q[joint].iter().zip(&run.qd[joint]));
            let points: Vec<[f64; 2]> = states.step_by(every).map(|(q, qd)| [*q, *qd]).collect();
            for (axis, ends) in range.iter_mut().enumerate() {
                let values = points.iter().map(|point| point[axis]);
                *ends = values.fold(*ends, |[low, high], value| [low.min(value), high.max(value)]);
            }
            let points = Points::new(&recording.joints[joint].name, points, Ink::Series(joint));
            panel = panel.with(points.radius(0.45).opacity(0.5));
        }
        panels.push(panel);
    }
    for panel in &mut panels {
        panel.x.range = Some(with_margin(range[0]));
        panel.y.range = Some(with_margin(range[1]));
    }
    Figure { columns: panels.len().clamp(1, 3), panels }
}

fn with_margin([low, high]: [f64; 2]) -> [f64; 2] {
    let margin = 0.04 * (high - low).max(1e-9);
    [low - margin, high + margin]
}

/// The trained networks of a model: for each seed its members.
struct Trained {
    model: String,
    seeds: Vec<Vec<Fitted>>,
}

fn members(experiment: &Experiment, cells: &[Cell], store: &Store) -> Result<Vec<Trained>, ExperimentError> {
    let mut all = Vec::new();
    for model in &experiment.models {
        let own = cell::of_model(cells, &model.name).into_iter();
        let seeds = own.map(|cell| trained_members(cell, store)).collect::<Result<Vec<_>, _>>()?;
        let seeds: Vec<Vec<Fitted>> = seeds.into_iter().flatten().collect();
        if !seeds.is_empty() {
            all.push(Trained { model: model.title(), seeds });
        }
    }
    Ok(all)
}

/// Torque, and its parts where they are known: what is true, and the mean over the seeds with a band from least to most.
fn torques(set: &TestSet, recording: &Recording, models: &[Trained]) -> Result<Figure, ExperimentError> {
    let arm = exact_arm(set);
    let titles: &[&str] = if arm.is_some() { &["torque", "inertial", "Coriolis", "gravity"] } else { &["torque"] };
    let joints = recording.joint_count();
    let time = Shared::from(joined_times(&recording.trajectories));
    let mut panels = Vec::new();
    for joint in 0..joints {
        for title in titles {
            let axes = [Axis::new("time", "s"), Axis::new("", recording.joints[joint].kind.units()[3])];
            panels.push(Panel::new(format!("{}: {title}", recording.joints[joint].name), axes).aspect(0.7));
        }
    }
    let place = |quantity: usize, joint: usize| joint * titles.len() + quantity;
    let line = |name: &str, values: Vec<f64>, ink: Ink| Line::new(name, time.clone(), values, ink).sampled();
    for (number, Trained { model, seeds }) in models.iter().enumerate() {
        let ink = Ink::Series(number);
        let estimates = seeds
            .iter()
            .map(|members| estimate(members, recording, arm.is_some()))
            .collect::<Result<Vec<Vec<Signals>>, _>>()?;
        for quantity in 0..titles.len() {
            for joint in 0..joints {
                let of_seeds: Vec<&[f64]> = estimates.iter().map(|seed| &seed[quantity][joint]).collect();
                let at = |sample: usize| of_seeds.iter().map(move |seed| seed[sample]);
                let middle: Vec<f64> =
                    (0..time.len()).map(|sample| at(sample).sum::<f64>() / of_seeds.len() as f64).collect();
                let panel = &mut panels[place(quantity, joint)];
                panel.push(line(model, middle, ink));
                if of_seeds.len() > 1 {
                    let band = |sample: usize| {
                        let least = at(sample).fold(f64::INFINITY, f64::min);
                        [time[sample], least, at(sample).fold(f64::NEG_INFINITY, f64::max)]
                    };
                    let points: Vec<[f64; 3]> = (0..time.len()).map(band).collect();
                    panel.push(Band::new(model.as_str(), points, ink));
                }
            }
        }
    }
    let joined = |of_run: &dyn Fn(&Trajectory) -> Vec<f64>| -> Vec<f64> {
        recording.trajectories.iter().flat_map(of_run).collect()
    };
    let word = if arm.is_some() { "exact" } else { "measured" };
    let mut add_truth = |quantity: usize, joint: usize, truth: Vec<f64>| {
        let panel = &mut panels[place(quantity, joint)];
        panel.y.range = Some(with_room(&truth));
        panel.push(line(word, truth, Ink::Measured));
    };
    for joint in 0..joints {
        add_truth(0, joint, joined(&|run| run.tau[joint].to_vec()));
        let Some(arm) = arm else { continue };
        for quantity in 1..titles.len() {
            let part = joined(&|run| {
                let exact = arm.components_along(&run.q, &run.qd, &run.qdd);
                let all = [exact.inertial, exact.coriolis, exact.gravity];
                all[quantity - 1][joint].to_vec()
            });
            add_truth(quantity, joint, part);
        }
    }
    Ok(Figure { panels, columns: titles.len() })
}

/// What is true decides the range: a model that explodes leaves the picture, and is seen to.
fn with_room(truth: &[f64]) -> [f64; 2] {
    let [low, high] = ends(truth.iter().copied());
    let margin = 0.25 * (high - low).max(1e-9);
    [low - margin, high + margin]
}

/// Torque of a model, and its three parts if asked for, along all runs: `[quantity][joint][sample]`.
fn estimate(members: &[Fitted], recording: &Recording, parts: bool) -> Result<Vec<Signals>, ExperimentError> {
    let mut all = vec![Vec::new(); if parts { 4 } else { 1 }];
    for run in &recording.trajectories {
        let torques = members.iter().map(|member| torque(member, run)).collect::<Result<Vec<_>, _>>()?;
        let mut quantities = vec![mean(&torques)];
        if parts {
            let own = members.iter().map(|member| parts_of(member, run)).collect::<Result<Vec<_>, _>>()?;
            quantities.extend((0..3).map(|part| {
                let of_members: Vec<Signals> = own.iter().map(|parts| parts[part].clone()).collect();
                mean(&of_members)
            }));
        }
        for (whole, quantity) in all.iter_mut().zip(quantities) {
            whole.push(quantity);
        }
    }
    Ok(all.iter().map(|runs| Signals::joined(runs)).collect::<Result<_, _>>()?)
}

/// The time of runs one after another, with a pause between them.
fn joined_times(runs: &[Trajectory]) -> Vec<f64> {
    let mut times = Vec::new();
    let mut begin = 0.0;
    for run in runs {
        let (Some(first), Some(last)) = (run.time.first(), run.time.last()) else { continue };
        times.extend(run.time.iter().map(|time| begin + time - first));
        begin += (1.0 + PAUSE) * (last - first);
    }
    times
}

/// One figure for each curve: means over the seeds, bands from the least to the largest.
fn curve_figures(experiment: &Experiment, rows: &[Row]) -> Vec<(String, Figure)> {
    let curves = curves(rows);
    let mut figures: Vec<(String, Figure)> = Vec::new();
    let largest = curves.iter().flat_map(|curve| &curve.points).map(|point| point[1]).fold(0.0, f64::max);
    for curve in &curves {
        let name = format!("curve-{}", file_name(&curve.curve));
        let own = figures.iter().position(|(other, _)| *other == name).unwrap_or_else(|| {
            let axes = [Axis::new(&curve.axis, ""), Axis::new("nMSE of the torque", "").logarithmic()];
            figures.push((name, Figure::new(vec![Panel::new(&experiment.title, axes)])));
            figures.len() - 1
        });
        let shown = curve.points.iter().filter(|point| point[1] > SMALLEST * largest);
        let points: Vec<[f64; 4]> = shown.copied().collect();
        let (title, number) = experiment.called(&curve.model);
        let ink = Ink::Series(number);
        let line: Vec<[f64; 2]> = points.iter().map(|[x, mean, ..]| [*x, *mean]).collect();
        let band: Vec<[f64; 3]> = points.iter().map(|[x, _, least, most]| [*x, *least, *most]).collect();
        let panel = &mut figures[own].1.panels[0];
        panel.push(Line::through(&title, line.clone(), ink));
        panel.push(Band::new(title, band, ink));
        panel.push(Points::new("", line, ink));
    }
    figures
}

/// Bars of the mean squared error with its interval, side by side for each test set, and the paper's values as points.
fn errors(experiment: &Experiment, sets: &[&TestSet], rows: &[Row]) -> Figure {
    let largest = rows.iter().filter(|row| row.point.is_none()).map(Row::mse).fold(0.0, f64::max);
    let shown = |row: &&Row| row.point.is_none() && row.mse() > SMALLEST * largest;
    let models: Vec<&str> = experiment
        .models
        .iter()
        .map(|model| model.name.as_str())
        .filter(|name| rows.iter().filter(shown).any(|row| row.model == *name))
        .collect();
    if models.is_empty() {
        return Figure::default();
    }
    let names = sets.iter().map(|set| set.name.clone()).collect();
    let unit = rows.first().map_or("", |row| row.mse_unit);
    let axes = [Axis::names("", names), Axis::new("mean squared error", unit).logarithmic()];
    let mut panel = Panel::new(&experiment.title, axes);
    let width = 0.84 / models.len() as f64;
    let mut published = Vec::new();
    for (number, model) in models.iter().enumerate() {
        let mut bars = Vec::new();
        for row in rows.iter().filter(shown).filter(|row| row.model == *model) {
            let Some(set) = sets.iter().position(|set| set.name == row.test_set) else { continue };
            let x = set as f64 + width * (number as f64 - 0.5 * (models.len() as f64 - 1.0));
            let [low, high] = row.mse_interval().unwrap_or([f64::NAN; 2]);
            bars.push([x, row.mse(), low, high]);
            published.extend(row.published_mse().map(|mse| [x, mse]));
        }
        let (name, ink) = (experiment.called(model).0, Ink::Series(number));
        panel.push(Bars { name, bars, width: 0.9 * width, ink, written: None });
    }
    if !published.is_empty() {
        panel.push(Points::new("the paper", published, Ink::Text));
    }
    Figure::new(vec![panel])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;

    #[test]
    fn names_of_files_hold_only_letters_and_dashes() {
        assert_eq!(file_name("non-iid-0, 3 runs"), "non-iid-0-3-runs");
        assert_eq!(file_name("Run B"), "run-b");
    }

    #[test]
    fn runs_follow_each_other_with_a_pause() {
        let signal = || Signals::zeros(0, 3);
        let (time, q, qd, qdd, tau) = (vec![5.0, 6.0, 7.0], signal(), signal(), signal(), signal());
        let run = Trajectory::new("", Channels { time, q, qd, qdd, tau }).unwrap();
        let times = joined_times(&[run.clone(), run]);
        assert_eq!(times[..3], [0.0, 1.0, 2.0]);
        assert!(times[3] > 2.1 && times[3] < 2.5 && times[5] == times[3] + 2.0, "{times:?}");
    }
}
