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
/// Width of the truth, and how much of its colour it has.
const STRONG: f64 = 2.4;
const PALE: f64 = 0.4;
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

/// Mass matrix, its eigenvalues, V, g and c over the position of one joint, each beside the truth and what other models have.
pub fn over_slice(
    recording: &Arc<Recording>,
    joint: usize,
    slice: &Arc<OverSlice>,
    others: &[Other<OverSlice>],
) -> Vec<Panel> {
    let n = recording.joint_count();
    let (info, mass) = (&recording.joints[joint], unit_of_mass(recording));
    let [position, _, _, torque] = info.kind.units();
    let panel = |title: &str, unit: &str| {
        let x = Axis::new(format!("position of {}", info.name), position).linked(Along::Slice);
        Panel::new(title, [x, Axis::new("", unit)])
    };
    let draw = |mut panel: Panel, lines: Vec<(String, usize)>, of: Of<Inside>| {
        let places = |which: fn(&OverSlice) -> Option<&Inside>| {
            Shared::of(slice, move |slice| which(slice).map_or(&[][..], |inside| &inside.places))
        };
        for (number, (_, index)) in lines.iter().enumerate().filter(|_| slice.truth.is_some()) {
            let index = *index;
            let truth = Shared::of(slice, move |slice| slice.truth.as_ref().map_or(&[][..], |truth| of(truth, index)));
            let name = if number == 0 { "truth" } else { "" };
            let line = Line::new(name, places(|slice| slice.truth.as_ref()), truth, Ink::Series(number));
            panel.push(line.width(STRONG).opacity(PALE).dash(&[]));
        }
        for Other { name, ink, of: other } in others {
            for (number, (_, index)) in lines.iter().enumerate() {
                let index = *index;
                let name = if number == 0 { name.as_str() } else { "" };
                let values = Shared::of(other, move |slice| of(&slice.own, index));
                panel.push(Line::new(name, Shared::of(other, |slice| &slice.own.places[..]), values, *ink));
            }
        }
        for (number, (name, index)) in lines.into_iter().enumerate() {
            let own = Shared::of(slice, move |slice| of(&slice.own, index));
            panel.push(Line::new(name, places(|slice| Some(&slice.own)), own, Ink::Series(number)));
        }
        panel
    };
    let named = |letter: &str| (0..n).map(|joint| (format!("{letter}{}", joint + 1), joint)).collect::<Vec<_>>();
    let entry = |row: usize, column: usize| (format!("H{}{}", row + 1, column + 1), row * n + column);
    let beside: Vec<_> = (0..n)
        .flat_map(|row| (row + 1..n).map(move |column| (row, column)))
        .filter(|(row, column)| n <= MOST_JOINTS || [row, column].contains(&&joint))
        .map(|(row, column)| entry(row, column))
        .collect();
    let mut panels = vec![draw(
        panel("H(q), diagonal", mass),
        (0..n).map(|joint| entry(joint, joint)).collect(),
        |inside, entry| &inside.mass[entry],
    )];
    if !beside.is_empty() {
        panels.push(draw(panel("H(q), beside the diagonal", mass), beside, |inside, entry| &inside.mass[entry]));
    }
    panels.push(draw(panel("eigenvalues of H(q)", mass), named("λ"), |inside, index| &inside.eigenvalues[index]));
    panels.push(draw(panel("V(q)", "J"), vec![("V".to_owned(), 0)], |inside, _| &inside.potential));
    panels.push(draw(panel("g(q)", torque), named("g"), |inside, joint| &inside.gravity[joint]));
    panels.push(draw(panel("c(q, q̇)", torque), named("c"), |inside, joint| &inside.coriolis[joint]));
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
            panel.push(curve("truth", own, of_truth, Ink::Series(0)).width(STRONG).opacity(PALE).dash(&[]));
        }
        panel.push(curve("measured", own, |of, joint| &of.curves[joint].measured, Ink::Measured));
        for Other { name, ink, of } in others {
            // What was measured depends on what the model takes to be inertia and gravity.
            panel.push(band("", of, |curve| &curve.interval, *ink));
            panel.push(curve("", of, |of, joint| &of.curves[joint].measured, *ink).width(THIN).dash(&[]));
            panel.push(curve(name, of, |of, joint| &of.curves[joint].model, *ink));
        }
        panel.with(curve(&step.name, own, |of, joint| &of.curves[joint].model, Ink::Predicted))
    };
    recording.joints.iter().enumerate().map(panel).collect()
}

/// Positions of an arm that was let go, each beside the truth.
pub fn falling(recording: &Arc<Recording>, falls: &Falls) -> Panel {
    let [unit, ..] = recording.units();
    let mut panel = Panel::new("let go", [Axis::new("time since then", "s"), Axis::new("position", &unit)]);
    let line = |fall: &Fall, joint: usize, name: &str| {
        Line::new(name, Shared::from(fall.time.clone()), Shared::from(fall.q[joint].to_vec()), Ink::Series(joint))
    };
    for joint in 0..recording.joint_count() {
        if let Some(truth) = &falls.truth {
            let name = if joint == 0 { "truth" } else { "" };
            panel.push(line(truth, joint, name).width(STRONG).opacity(PALE).dash(&[]));
        }
    }
    for (joint, info) in recording.joints.iter().enumerate() {
        panel.push(line(&falls.own, joint, &info.name));
    }
    panel
}

/// Energy over time, and where the power goes, each beside the truth and what other models have.
pub fn along_run(
    recording: &Arc<Recording>,
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
    let truth = |panel: &mut Panel, name: &str, of: OverTime, ink: Ink| {
        if balance.truth.is_some() {
            let values = Shared::of(balance, move |run| run.truth.as_ref().map_or(&[][..], of));
            panel.push(line(name, values, ink).width(STRONG).opacity(PALE).dash(&[]));
        }
    };
    let mut energy = panel("energy", "J");
    let kinds: [(&str, OverTime); 2] =
        [("kinetic T", |balance| &balance.kinetic), ("potential V", |balance| &balance.potential)];
    for (number, (_, of)) in kinds.into_iter().enumerate() {
        truth(&mut energy, if number == 0 { "truth" } else { "" }, of, Ink::Series(number));
    }
    for Other { name, ink, of: other } in others {
        for (number, (_, of)) in kinds.into_iter().enumerate() {
            let name = if number == 0 { name.as_str() } else { "" };
            energy.push(line(name, Shared::of(other, move |run| of(&run.own)), *ink));
        }
    }
    for (number, (name, of)) in kinds.into_iter().enumerate() {
        energy.push(line(name, Shared::of(balance, move |run| of(&run.own)), Ink::Series(number)));
    }
    let lost: Vec<f64> = balance.own.lost(&balance.power[0], &recording.trajectories[run].time);
    energy.push(line("lost so far: ∫ τ q̇ dt − T − V", lost.into(), Ink::Measured));
    let mut power = panel("power", "W");
    truth(&mut power, "truth of d(T + V)/dt", |balance| &balance.change, Ink::Series(0));
    for Other { name, ink, of } in others {
        power.push(line(&format!("d(T + V)/dt of {name}"), Shared::of(of, |run| &run.own.change[..]), *ink));
    }
    power.push(line("measured τ q̇", Shared::of(balance, |run| &run.power[0]), Ink::Measured));
    power.push(line("predicted τ̂ q̇", Shared::of(balance, |run| &run.power[1]), Ink::Predicted));
    power.push(line("into energy: d(T + V)/dt", Shared::of(balance, |run| &run.own.change), Ink::Series(0)));
    let lost =
        balance.power[1].iter().zip(&balance.own.change).map(|(power, change)| power - change).collect::<Vec<f64>>();
    power.push(line("into friction and the rest", lost.into(), Ink::Series(2)));
    vec![energy, power]
}
