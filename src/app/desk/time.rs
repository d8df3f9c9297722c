//! Where a trajectory begins and ends, and what of it is held out.

use crate::session::Session;

/// First and last time \[s\].
pub fn time_extent(time: &[f64]) -> [f64; 2] {
    [time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(1.0)]
}

/// Whether any of a trajectory is held out and nothing of it trains.
pub fn is_held_out(session: &Session, trajectory: usize) -> bool {
    session.split.held_out.iter().any(|segment| segment.trajectory == trajectory)
        && session.split.train.iter().all(|segment| segment.trajectory != trajectory)
}

/// The held-out stretches of a trajectory \[s\].
pub fn held_out_times(session: &Session, trajectory: usize) -> Vec<[f64; 2]> {
    let Some(data) = session.recording.as_deref().and_then(|recording| recording.trajectories.get(trajectory)) else {
        return Vec::new();
    };
    let of_trajectory = session.split.held_out.iter().filter(|segment| segment.trajectory == trajectory);
    of_trajectory
        .filter_map(|segment| {
            let (first, last) = (segment.samples.start, segment.samples.end.checked_sub(1)?);
            Some([*data.time.get(first)?, *data.time.get(last)?])
        })
        .collect()
}
