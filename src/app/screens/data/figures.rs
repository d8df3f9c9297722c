//! What the screen shows, as figures.

use std::sync::Arc;

use crate::app::desk::{held_out_times, time_extent};
use crate::app::plot::series::density;
use crate::app::plot::{Along, series};
use crate::figure::mark::{Cells, Line, Shade};
use crate::figure::{Axis, Ink, Panel};
use crate::recording::{Recording, Trajectory};
use crate::session::Session;

/// Width of a spectrum.
const STRONG: f64 = 1.86;

/// A signal of a joint along a trajectory.
type Of = fn(&Trajectory, usize) -> &[f64];

/// Position, velocity, acceleration and torque of a joint along a trajectory; what is held out is shaded.
pub fn signals(session: &Session, recording: &Arc<Recording>, run: usize, joint: usize) -> Vec<Panel> {
    let [position, velocity, acceleration, torque] = recording.joints[joint].kind.units();
    let effort = format!("{} τ", recording.joints[joint].kind.effort());
    let channels: [(&str, &str, &str, Ink, Of); 4] = [
        ("position q", "q", position, Ink::Series(joint), |run, joint| &run.q[joint]),
        ("velocity q̇", "q̇", velocity, Ink::Series(joint), |run, joint| &run.qd[joint]),
        ("acceleration q̈", "q̈", acceleration, Ink::Series(joint), |run, joint| &run.qdd[joint]),
        (&effort, "τ", torque, Ink::Measured, |run, joint| &run.tau[joint]),
    ];
    let name = &recording.joints[joint].name;
    let extent = time_extent(&recording.trajectories[run].time);
    let panel = |(title, symbol, unit, ink, of): (&str, &str, &str, Ink, Of)| {
        let axes = [Axis::new("time t", "s").range(extent).linked(Along::Time), Axis::new("", unit)];
        let values = series::signal(recording, run, move |run| of(run, joint));
        Panel::new(format!("{name}: {title}"), axes)
            .with_all(held_out_times(session, run).into_iter().map(Shade))
            .with(Line::new(symbol, series::time(recording, run), values, ink).sampled().dash(&[]))
    };
    channels.into_iter().map(panel).collect()
}

/// How often each position and velocity of a joint was recorded.
pub fn coverage(recording: &Recording, joint: usize, cells: &Cells) -> Panel {
    let info = &recording.joints[joint];
    let [position, velocity, ..] = info.kind.units();
    let x = Axis::new("position q", position).range(cells.extent[0]).linked(Along::Position(joint));
    Panel::new(format!("{}: q̇", info.name), [x, Axis::new("", velocity).range(cells.extent[1])]).with(cells.clone())
}

/// Power of a joint's measured torque: frequency \[Hz\] and power. `None` if the trajectory is too short for it.
pub fn spectrum(recording: &Recording, joint: usize, power: &[[f64; 2]]) -> Option<Panel> {
    let extent = [power.first()?[0], power.last()?[0]];
    let x = Axis::new("frequency", "Hz").range(extent).linked(Along::Frequency);
    let title = format!("{}: power of τ, logarithmic", recording.joints[joint].name);
    let line = Line::through("", power.iter().copied(), Ink::Measured).width(STRONG);
    Some(
        Panel::new(title, [x, Axis::new("", density(recording.joints[joint].kind.units()[3])).logarithmic()])
            .with(line),
    )
}
