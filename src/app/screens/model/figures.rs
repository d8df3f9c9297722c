//! The model as figures.

use std::sync::Arc;

use super::diagram;
use super::inside::{AlongRun, Falls, Other, OverSlice, OverVelocity, unit_of_mass};
use super::share::Share;
use crate::app::desk::time_extent;
use crate::app::plot::{Along, series};
use crate::figure::mark::{Band, Bars, Line};
use crate::figure::{Axis, Ink, Panel, Shared};
use crate::model::Term;
use crate::recording::{Joint, Recording};
use crate::session::Step;
use crate::training::friction::FrictionCurve;
use crate::training::inside::{Balance, Fall, Inside};

/// What the bands of friction are.
const SAMPLES: &str = "80 % of samples";
const INTERVAL: &str = "95 % interval of the mean";
/// How much is seen of the band of samples.
const FAINT: f64 = 0.13;
/// Width of what was measured, as another model takes it.
const THIN: f64 = 0.6;
/// With more joints than this only those entries of H are drawn that the joint which goes has.
const MOST_JOINTS: usize = 4;

/// How the model is wired, and what each of its terms carries: the root mean square of its torque over that of the measured one.
pub fn figures(recording: &Recording, step: &Step, shares: &[Vec<Share>]) -> Vec<Panel> {
    let (model, joints) = (&step.fitted.model, recording.joint_count());
    let terms = model.terms.iter().map(Term::label).collect();
    let axes = [Axis::names("", terms), Axis::new(format!("RMS over that of the measured {}", recording.effort()), "")];
    let mut carried = Panel::new("what each term carries", axes);
    for (joint, info) in recording.joints.iter().enumerate() {
        let heights: Vec<[f64; 3]> = shares.iter().map(|shares| [shares[joint].part, f64::NAN, f64::NAN]).collect();
        carried.push(Bars::beside(&info.name, [joint, joints], &heights, Ink::Series(joint)));
    }
    vec![diagram::for_paper(model, joints), carried]
}

/// A band of a friction curve.
type OfCurve = fn(&FrictionCurve) -> &[[f64; 3]];

/// One value of a model at each place.
type Of<T> = fn(&T, usize) -> &[f64];

/// One of the curves of a run's balance.
type OverTime = fn(&Balance) -> &[f64];

/// A component of what a chart shows: what the current model has of it, the truth, and what others have.
struct Component {
    own: Line,
    truth: Option<Line>,
    others: Vec<Line>,
}

/// All components in one chart, told apart by colour and dash. With other models over it each has a chart of its own: there colour
/// and dash tell whose a line is, as on all screens.
fn charts(panel: &Panel, model: &str, components: Vec<Component>) -> Vec<Panel> {
    if components.iter().all(|component| component.others.is_empty()) {
        let inked = |(number, component): (usize, &Component)| {
            let of_truth = |truth: Line| truth.ink(Ink::Series(number)).wide_and_pale().together("truth");
            (component.truth.clone().map(of_truth), component.own.clone().ink(Ink::Series(number)))
        };
        let (truths, own): (Vec<_>, Vec<_>) = components.iter().enumerate().map(inked).unzip();
        return vec![panel.clone().with_all(truths.into_iter().flatten()).with_all(own)];
    }
    let is_one = components.len() == 1;
    let chart = |Component { own, truth, others }: Component| {
        let title = if is_one { panel.title.clone() } else { format!("{}: {}", panel.title, own.name) };
        let of_truth = |truth: Line| truth.ink(Ink::Series(0)).wide_and_pale().together("truth");
        let own = Line { name: model.to_owned(), ..own.ink(Ink::Predicted) };
        Panel { title, ..panel.clone() }.with_all(truth.map(of_truth)).with_all(others).with(own)
    };
    components.into_iter().map(chart).collect()
}

/// Mass matrix, its eigenvalues, V, g and c over the position of one joint, each beside the truth and what other models have.
pub fn over_slice(
    recording: &Arc<Recording>,
    step: &Step,
    joint: usize,
    slice: &Arc<OverSlice>,
    others: &[Other<OverSlice>],
) -> Vec<Panel> {
    let n = recording.joint_count();
    let (info, mass) = (&recording.joints[joint], unit_of_mass(recording));
    let [position, _, _, torque] = info.kind.units();
    let draw = |title: &str, unit: &str, components: Vec<(String, usize)>, of: Of<Inside>| {
        let x = Axis::new(format!("position of {}", info.name), position).linked(Along::Slice);
        let component = |(name, index): (String, usize)| {
            let own = |name: &str, slice: &Arc<OverSlice>, ink: Ink| {
                let places = Shared::of(slice, |slice| &slice.own.places[..]);
                Line::new(name, places, Shared::of(slice, move |slice| of(&slice.own, index)), ink)
            };
            let truth = slice.truth.is_some().then(|| {
                let of_truth = move |of: Of<Inside>| {
                    Shared::of(slice, move |slice| slice.truth.as_ref().map_or(&[][..], |truth| of(truth, index)))
                };
                Line::new(format!("truth of {name}"), of_truth(|truth, _| &truth.places), of_truth(of), Ink::Text)
            });
            let others = others.iter().map(|Other { name, ink, of }| own(name, of, *ink)).collect();
            Component { own: own(&name, slice, Ink::Predicted), truth, others }
        };
        let components = components.into_iter().map(component).collect();
        charts(&Panel::new(title, [x, Axis::new("", unit)]), &step.name, components)
    };
    let named = |letter: &str| (0..n).map(|joint| (format!("{letter}{}", joint + 1), joint)).collect::<Vec<_>>();
    let entry = |row: usize, column: usize| (format!("H{}{}", row + 1, column + 1), row * n + column);
    let beside: Vec<_> = (0..n)
        .flat_map(|row| (row + 1..n).map(move |column| (row, column)))
        .filter(|(row, column)| n <= MOST_JOINTS || [row, column].contains(&&joint))
        .map(|(row, column)| entry(row, column))
        .collect();
    let diagonal = (0..n).map(|joint| entry(joint, joint)).collect();
    let mut panels = draw("H(q), diagonal", mass, diagonal, |inside, entry| &inside.mass[entry]);
    if !beside.is_empty() {
        panels.extend(draw("H(q), beside the diagonal", mass, beside, |inside, entry| &inside.mass[entry]));
    }
    panels.extend(draw("eigenvalues of H(q)", mass, named("λ"), |inside, index| &inside.eigenvalues[index]));
    panels.extend(draw("V(q)", "J", vec![("V".to_owned(), 0)], |inside, _| &inside.potential));
    panels.extend(draw("g(q)", torque, named("g"), |inside, joint| &inside.gravity[joint]));
    panels.extend(draw("c(q, q̇)", torque, named("c"), |inside, joint| &inside.coriolis[joint]));
    panels
}

/// What of each joint's torque is neither inertia nor gravity, over its velocity: measured, of the model, of others, and the truth.
pub fn friction(
    recording: &Recording,
    step: &Step,
    own: &Arc<OverVelocity>,
    others: &[Other<OverVelocity>],
) -> Vec<Panel> {
    let panel = |(joint, info): (usize, &Joint)| {
        let [_, velocity, _, torque] = info.kind.units();
        let x = Axis::new("velocity q̇", velocity).linked(Along::Velocity(joint));
        let curve = |name: &str, of: &Arc<OverVelocity>, values: fn(&OverVelocity, usize) -> &[f64], ink: Ink| {
            let speeds = Shared::of(of, move |of| &of.curves[joint].velocity[..]);
            Line::new(name, speeds, Shared::of(of, move |of| values(of, joint)), ink)
        };
        let title = format!("{}: beside inertia and gravity", info.name);
        let band = |name: &str, of: &Arc<OverVelocity>, band: OfCurve, ink: Ink| {
            Band::new(name, Shared::of(of, move |of| band(&of.curves[joint])), ink)
        };
        let mut panel = Panel::new(title, [x, Axis::new("", torque)]);
        if others.is_empty() {
            panel.push(Band { opacity: FAINT, ..band(SAMPLES, own, |curve| &curve.band, Ink::Weak) });
        }
        panel.push(band(INTERVAL, own, |curve| &curve.interval, Ink::Measured));
        if own.truth.is_some() {
            let of_truth: fn(&OverVelocity, usize) -> &[f64] =
                |of, joint| of.truth.as_ref().map_or(&[][..], |truth| &truth[joint]);
            panel.push(curve("truth", own, of_truth, Ink::Series(0)).wide_and_pale());
        }
        panel.push(curve("measured", own, |of, joint| &of.curves[joint].measured, Ink::Measured));
        for Other { name, ink, of } in others {
            // What was measured depends on what the model takes to be inertia and gravity, so it goes by its name, too.
            panel.push(curve(name, of, |of, joint| &of.curves[joint].model, *ink));
            panel.push(band(name, of, |curve| &curve.interval, *ink));
            panel.push(curve(name, of, |of, joint| &of.curves[joint].measured, *ink).width(THIN).dash(&[]));
        }
        panel.with(curve(&step.name, own, |of, joint| &of.curves[joint].model, Ink::Predicted))
    };
    recording.joints.iter().enumerate().map(panel).collect()
}

/// Positions of an arm that was let go, each beside the truth and where other models have it fall.
pub fn falling(recording: &Arc<Recording>, step: &Step, falls: &Falls, others: &[Other<Falls>]) -> Vec<Panel> {
    let [unit, ..] = recording.units();
    let line = |fall: &Fall, joint: usize, name: &str, ink: Ink| {
        Line::new(name, Shared::from(fall.time.clone()), Shared::from(fall.q[joint].to_vec()), ink)
    };
    let component = |(joint, info): (usize, &Joint)| Component {
        own: line(&falls.own, joint, &info.name, Ink::Predicted),
        truth: falls.truth.as_ref().map(|truth| line(truth, joint, &format!("truth of {}", info.name), Ink::Text)),
        others: others.iter().map(|other| line(&other.of.own, joint, &other.name, other.ink)).collect(),
    };
    let panel = Panel::new("let go", [Axis::new("time since then", "s"), Axis::new("position", &unit)]);
    charts(&panel, &step.name, recording.joints.iter().enumerate().map(component).collect())
}

/// Energy over time, and where the power goes, each beside the truth and what other models have.
pub fn along_run(
    recording: &Arc<Recording>,
    step: &Step,
    run: usize,
    balance: &Arc<AlongRun>,
    others: &[Other<AlongRun>],
) -> Vec<Panel> {
    let time = series::time(recording, run);
    let panel = |title: &str, unit: &str| {
        let x = Axis::new("time t", "s").range(time_extent(&recording.trajectories[run].time)).linked(Along::Time);
        Panel::new(title, [x, Axis::new("", unit)])
    };
    let line = |name: &str, values: Shared<f64>, ink: Ink| Line::new(name, time.clone(), values, ink).sampled();
    let truth = |name: &str, of: OverTime| {
        let values = || Shared::of(balance, move |run| run.truth.as_ref().map_or(&[][..], of));
        balance.truth.is_some().then(|| line(&format!("truth of {name}"), values(), Ink::Text))
    };
    let kinds: [(&str, OverTime); 2] =
        [("kinetic T", |balance| &balance.kinetic), ("potential V", |balance| &balance.potential)];
    let mut energies: Vec<Component> = Vec::new();
    for (name, of) in kinds {
        let own = |name: &str, run: &Arc<AlongRun>, ink: Ink| line(name, Shared::of(run, move |run| of(&run.own)), ink);
        let others = others.iter().map(|other| own(&other.name, &other.of, other.ink)).collect();
        energies.push(Component { own: own(name, balance, Ink::Predicted), truth: truth(name, of), others });
    }
    let lost = |name: &str, energy: &Balance, ink: Ink| {
        line(name, energy.lost(&balance.power[0], &recording.trajectories[run].time).into(), ink)
    };
    let name = "lost so far: ∫ τ q̇ dt − T − V";
    energies.push(Component {
        own: lost(name, &balance.own, Ink::Predicted),
        truth: balance.truth.as_ref().map(|truth| lost(&format!("truth of {name}"), truth, Ink::Text)),
        others: others.iter().map(|other| lost(&other.name, &other.of.own, other.ink)).collect(),
    });
    let mut power = panel("power", "W");
    let change = "d(T + V)/dt";
    power =
        power.with_all(truth(change, |balance| &balance.change).map(|line| line.ink(Ink::Series(1)).wide_and_pale()));
    for Other { name, ink, of } in others {
        power.push(line(&format!("{change} of {name}"), Shared::of(of, |run| &run.own.change[..]), *ink));
    }
    power.push(line("measured τ q̇", Shared::of(balance, |run| &run.power[0]), Ink::Measured));
    power.push(line("predicted τ̂ q̇", Shared::of(balance, |run| &run.power[1]), Ink::Predicted));
    power.push(line(&format!("into energy: {change}"), Shared::of(balance, |run| &run.own.change), Ink::Series(1)));
    let lost =
        balance.power[1].iter().zip(&balance.own.change).map(|(power, change)| power - change).collect::<Vec<f64>>();
    power.push(line("into friction and the rest", lost.into(), Ink::Series(2)));
    let mut panels = charts(&panel("energy", "J"), &step.name, energies);
    panels.push(power);
    panels
}
