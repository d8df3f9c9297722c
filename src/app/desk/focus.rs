//! Where one looks, on all screens alike.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Stretch;
use super::film::Film;
use super::overlaid::Overlaid;
use crate::app::plot::spatial::Sight;
use crate::app::plot::{Along, OwnLine, OwnLines, OwnSeries, Views};
use crate::model::Preset;
use crate::recording::{Recording, Trajectory};
use crate::session::{Command, Session, Step};

/// What somebody has set up, as a file keeps it.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Setup {
    beside: Option<usize>,
    own_series: OwnSeries,
    own_lines: Vec<OwnLine>,
    marked: Option<Vec<Stretch>>,
}

/// What is in sight, as a file keeps it.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct InSight {
    cursor: Option<f64>,
    views: Views,
    sight: Sight,
}

/// Which trajectory, joint and time all screens show.
#[derive(Debug, Clone)]
pub struct Focus {
    /// Index of the trajectory.
    pub trajectory: usize,
    /// Another trajectory that is drawn over it, if one is.
    pub beside: Option<usize>,
    /// Counted from 0.
    pub joint: usize,
    /// The time cursor \[s\].
    pub cursor: Option<f64>,
    /// Which part of each quantity the charts show.
    pub views: Views,
    /// What is drawn in a chart of its own below those over time.
    pub own_series: OwnSeries,
    /// Models that are drawn over the current one.
    pub overlaid: Overlaid,
    /// Whether steps of the ladder are left out that are not drawn over the current one.
    pub hides_ladder: bool,
    /// Models that are to be made beside the current one.
    pub wanted: Vec<Preset>,
    /// What is marked in state space, in the order of time; `None` if nothing is.
    pub marked: Option<Arc<Vec<Stretch>>>,
    /// Whether time goes on by itself.
    pub is_playing: bool,
    /// How often it is drawn then.
    pub film: Film,
    /// How many times as fast as it was recorded.
    pub speed: f64,
    /// Whether it begins anew at the end.
    pub loops: bool,
    /// Whether the view moves with the time cursor.
    pub follows: bool,
    /// From where an arm in space is looked at.
    pub sight: Sight,
}

impl Default for Focus {
    fn default() -> Self {
        Focus {
            trajectory: 0,
            beside: None,
            joint: 0,
            cursor: None,
            views: Views::default(),
            own_series: OwnSeries::default(),
            overlaid: Overlaid::default(),
            hides_ladder: false,
            wanted: Vec::new(),
            marked: None,
            is_playing: false,
            film: Film::default(),
            speed: 1.0,
            loops: true,
            follows: true,
            sight: Sight::default(),
        }
    }
}

impl Focus {
    /// Follows the session: of another recording one looks at the first trajectory of which something is held out, since the
    /// error is measured there. What was made to be compared is shown.
    pub fn follow(&mut self, before: &Session, after: &Session, by: Option<&Command>) {
        if let Some(Command::Make { .. }) = by {
            let is_new = |model: &&Arc<Step>| before.all_models().all(|old| old.generation != model.generation);
            after.all_models().filter(is_new).for_each(|model| self.overlaid.set(model.generation, true));
            self.wanted.clear();
        }
        self.overlaid.keep(|shown| after.all_models().any(|model| model.generation == shown));
        self.views.fit(Along::Epoch);
        if !before.has_recording_of(after) {
            let before_it = self.trajectory;
            (self.trajectory, self.joint) = (after.split.held_out.first().map_or(0, |segment| segment.trajectory), 0);
            self.views.fit_all();
            (self.cursor, self.beside, self.marked) = (None, None, None);
            // The first of what was added, over the one that was looked at.
            if let (Some(Command::Beside { .. }), Some(recording)) = (by, &before.recording) {
                (self.trajectory, self.beside) = (recording.trajectories.len(), Some(before_it));
            }
        }
    }

    /// What somebody has set up, as a file keeps it.
    pub fn setup(&self) -> Value {
        let Focus { beside, own_series, marked, .. } = self;
        let marked = marked.as_deref().cloned();
        let own_lines = self.views.own.written();
        let setup = Setup { beside: *beside, own_series: own_series.clone(), own_lines, marked };
        serde_json::to_value(setup).unwrap_or_default()
    }

    /// What is in sight, as a file keeps it.
    pub fn in_sight(&self) -> Value {
        let in_sight = InSight { cursor: self.cursor, views: self.views.clone(), sight: self.sight };
        serde_json::to_value(in_sight).unwrap_or_default()
    }

    /// Looks at this recording as a file tells; what another program wrote there is passed over.
    pub fn look_as(&mut self, setup: Value, in_sight: Value, recording: &Recording) {
        let Setup { beside, own_series, own_lines, marked } = serde_json::from_value(setup).unwrap_or_default();
        let count = recording.trajectories.len();
        self.beside = beside.filter(|other| *other < count);
        self.own_series = own_series;
        let is_there = |marked: &Vec<Stretch>| marked.iter().all(|stretch| stretch.trajectory < count);
        self.marked = marked.filter(is_there).map(Arc::new);
        let InSight { cursor, views, sight } = serde_json::from_value(in_sight).unwrap_or_default();
        (self.cursor, self.views, self.sight) = (cursor, views, sight);
        self.views.own = OwnLines::of(own_lines);
    }

    /// What makes the models that are wanted and not there yet; `None` if there are none.
    pub fn make_wanted(&self, session: &Session) -> Option<Command> {
        let presets: Vec<Preset> =
            session.presets_without_model().filter(|preset| self.wanted.contains(preset)).collect();
        (!presets.is_empty()).then_some(Command::Make { presets })
    }

    /// Looks at another trajectory, at all of its time.
    pub fn show_trajectory(&mut self, trajectory: usize) {
        if self.trajectory != trajectory {
            self.trajectory = trajectory;
            self.views.fit(Along::Time);
            self.cursor = None;
        }
    }

    /// Shows a part of a trajectory, from 0 to 1, or all of it, with the cursor at a part of it.
    pub fn look_at(&mut self, run: &Trajectory, part: Option<[f64; 2]>, cursor: f64) {
        let (from, to) = (run.time.first().copied().unwrap_or(0.0), run.time.last().copied().unwrap_or(1.0));
        let at = |share: f64| from + share * (to - from);
        let range = part.map(|part| part.map(at));
        for along in [Along::Time, Along::WholeTime] {
            self.views.of(along).range = range;
        }
        self.cursor = Some(at(cursor));
    }

    /// The shown joint, one that the recording has.
    pub fn joint_of(&mut self, recording: &Recording) -> usize {
        self.joint = self.joint.min(recording.joint_count().saturating_sub(1));
        self.joint
    }
}
