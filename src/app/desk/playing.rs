//! Which time is played, and how it goes on.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Focus;
use super::time::time_extent;
use crate::app::plot::Along;
use crate::recording::Recording;

/// A stretch of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Index of the trajectory.
    pub trajectory: usize,
    /// From when until when \[s\].
    pub times: [f64; 2],
}

impl Stretch {
    /// Whether that time is in it; its end is not, so that two in a row have no time in common.
    fn has(&self, trajectory: usize, time: f64) -> bool {
        self.trajectory == trajectory && (self.times[0]..self.times[1]).contains(&time)
    }
}

impl Focus {
    /// What of a trajectory is marked in state space \[s\].
    pub fn marked_of(&self, trajectory: usize) -> Vec<[f64; 2]> {
        let marked = self.marked.iter().flat_map(|marked| marked.iter());
        marked.filter(|stretch| stretch.trajectory == trajectory).map(|stretch| stretch.times).collect()
    }

    /// What is played, in order: what is marked between two cursors, else what is marked in state space, else all of the shown
    /// trajectory.
    fn played(&mut self, recording: &Recording) -> Arc<Vec<Stretch>> {
        let [first, last] = recording.trajectories.get(self.trajectory).map_or([0.0; 2], |run| time_extent(&run.time));
        let whole = |times| Arc::new(vec![Stretch { trajectory: self.trajectory, times }]);
        match (self.views.of(Along::Time).measured, &self.marked) {
            (Some([from, to]), _) if from < last && to > first => whole([from.max(first), to.min(last)]),
            (_, Some(marked)) if !marked.is_empty() => Arc::clone(marked),
            _ => whole([first, last]),
        }
    }

    /// Time goes on after so many seconds at the desk, and a view that follows with it. After each stretch comes the next; after
    /// the last it begins anew, or stands. Of each at least its beginning is seen.
    pub fn play(&mut self, recording: &Recording, passed: f64) {
        if !self.is_playing {
            return;
        }
        let played = self.played(recording);
        let now = self.cursor.unwrap_or(f64::NEG_INFINITY);
        let then = now + self.speed * passed;
        match played.iter().position(|stretch| stretch.has(self.trajectory, now)) {
            Some(here) if then < played[here].times[1] => self.cursor = Some(then),
            Some(here) if here + 1 < played.len() => self.begin(played[here + 1]),
            Some(here) if !self.loops => {
                self.is_playing = false;
                self.cursor = Some(played[here].times[1]);
            }
            _ => self.begin(played[0]),
        }
        if let Some(run) = recording.trajectories.get(self.trajectory) {
            self.follow_cursor(time_extent(&run.time));
        }
    }

    fn begin(&mut self, stretch: Stretch) {
        self.show_trajectory(stretch.trajectory);
        self.cursor = Some(stretch.times[0]);
    }

    /// A zoomed view has the cursor in its middle, as far as there is something to be seen.
    fn follow_cursor(&mut self, [first, last]: [f64; 2]) {
        let range = &mut self.views.of(Along::Time).range;
        if let (Some([from, to]), Some(cursor)) = (range.filter(|_| self.follows), self.cursor) {
            let half = 0.5 * (to - from);
            let middle = cursor.clamp(first + half, (last - half).max(first + half));
            *range = Some([middle - half, middle + half]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    /// The moments that are seen in so many frames of a tenth of a second.
    fn seen(focus: &mut Focus, recording: &Recording, frames: usize) -> Vec<(usize, f64)> {
        let mut seen = Vec::new();
        for _ in 0..frames {
            focus.play(recording, 0.1);
            seen.push((focus.trajectory, focus.cursor.unwrap()));
        }
        seen
    }

    #[test]
    fn what_is_marked_is_played_stretch_by_stretch_over_trajectories() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let stretch = |trajectory, times| Stretch { trajectory, times };
        // The second is shorter than a frame, and seen all the same.
        let marked = vec![stretch(1, [1.0, 1.25]), stretch(1, [3.0, 3.01]), stretch(2, [0.5, 0.65])];
        let mut focus =
            Focus { marked: Some(Arc::new(marked)), cursor: Some(5.0), is_playing: true, ..Focus::default() };
        let round = [(1, 1.0), (1, 1.1), (1, 1.2), (1, 3.0), (2, 0.5), (2, 0.6)];
        for _ in 0..2 {
            for ((trajectory, time), (own, at)) in round.into_iter().zip(seen(&mut focus, &recording, 6)) {
                assert!(trajectory == own && (time - at).abs() < 1e-9, "{own} at {at} s, not {trajectory} at {time} s");
            }
        }
        focus.loops = false;
        seen(&mut focus, &recording, 7);
        assert!(!focus.is_playing && focus.trajectory == 2 && focus.cursor == Some(0.65), "{focus:?}");
        // What is marked between two cursors goes first, and nothing marked is everything.
        focus.views.of(Along::Time).measured = Some([2.0, 2.3]);
        (focus.is_playing, focus.loops) = (true, true);
        assert!(seen(&mut focus, &recording, 9).iter().all(|(run, at)| *run == 2 && (2.0..2.3).contains(at)));
        focus.views.fit_all();
        focus.marked = None;
        focus.cursor = Some(4.0);
        assert_eq!(seen(&mut focus, &recording, 1), [(2, 4.1)]);
    }
}
