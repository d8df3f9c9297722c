//! Where one looks and what one sees there, said in words instead of clicks: by `figure`, before it draws.

use std::sync::Arc;

use super::desk::{About, Overlaid, time_extent};
use super::plot::{Along, OwnSeries};
use super::{TorquescopeApp, formula, screens};
use crate::figure::colours::MODEL_DASHES;
use crate::progress::Monitor;
use crate::session::{Command, Session, SessionError, Step};

/// What stands for all models.
const ALL: &str = "all";
/// Models that are drawn together: the current one, and as many as can be told apart over it.
const MOST_MODELS: usize = 1 + MODEL_DASHES.len();

/// Where one looks; what is not said is as it is.
#[derive(Debug, Clone, Default)]
pub struct Looking {
    /// The trajectory, by its name or its number from 1.
    pub trajectory: Option<String>,
    /// From when to when \[s\].
    pub range: Option<[f64; 2]>,
    /// These models and no others, by their names or their numbers from 1, with commas between them; the first is the current one.
    pub models: Vec<String>,
    /// The joint, from 1.
    pub joint: Option<usize>,
    /// Lines of one's own over time, in a chart of their own, with semicolons between them.
    pub formula: Option<String>,
    /// Lines of one's own in charts of the screens: what the chart's title contains, and the formula.
    pub lines: Vec<[String; 2]>,
    /// What is shown in another way than at first: `components`, `grid=torque`.
    pub show: Vec<String>,
}

/// Why one can't look there.
#[derive(Debug, thiserror::Error)]
pub enum LookingError {
    /// No trajectory has this name or number.
    #[error("there is no trajectory `{asked}`; there are: {known}")]
    NoTrajectory {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// No model has this name or number.
    #[error("there is no model `{asked}`; there are: {known}")]
    NoModel {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// They would look alike.
    #[error("{asked} models can't be told apart in one figure: name no more than {MOST_MODELS}")]
    TooManyModels {
        /// How many.
        asked: usize,
    },
    /// The arm has fewer joints.
    #[error("there is no joint {asked}: the arm has {joints}")]
    NoJoint {
        /// Which, from 1.
        asked: usize,
        /// How many there are.
        joints: usize,
    },
    /// The trajectory is elsewhere.
    #[error("nothing was recorded from {} to {} s: the trajectory `{name}` goes from {from:.3} to {to:.3} s", .asked[0], .asked[1])]
    NoTime {
        /// What was asked for.
        asked: [f64; 2],
        /// The trajectory.
        name: String,
        /// Its beginning.
        from: f64,
        /// Its end.
        to: f64,
    },
    /// It can't be drawn.
    #[error("the formula `{text}` can't be drawn: {reason}")]
    Formula {
        /// What was written.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// No chart has this title.
    #[error("there is no chart `{asked}` for a line of one's own; there are: {known}")]
    NoChart {
        /// What was asked for.
        asked: String,
        /// Those that can have one.
        known: String,
    },
    /// No screen knows it.
    #[error("nothing is shown by the name `{asked}` here; there {}", listed(.known))]
    NoSwitch {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: Vec<String>,
    },
    /// The model could not be taken up.
    #[error(transparent)]
    Session(#[from] SessionError),
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "is nothing to choose".to_owned() } else { format!("are: {}", names.join(", ")) }
}

/// The place of what is asked for by its name, or by its number from 1.
fn place(names: &[String], asked: &str) -> Option<usize> {
    let by_number = || asked.parse::<usize>().ok()?.checked_sub(1).filter(|place| *place < names.len());
    names.iter().position(|name| name == asked).or_else(by_number)
}

/// Names with their numbers.
fn numbered(names: &[String]) -> String {
    let named = names.iter().enumerate().map(|(place, name)| format!("{} `{name}`", place + 1));
    named.collect::<Vec<_>>().join(", ")
}

impl Looking {
    /// The models that were asked for, in their order; all with the current one first. Empty if none were.
    ///
    /// # Errors
    /// [`LookingError`] if there is no such model.
    pub fn chosen(&self, session: &Session) -> Result<Vec<Arc<Step>>, LookingError> {
        let models: Vec<&Arc<Step>> = session.all_models().collect();
        let names: Vec<String> = models.iter().map(|step| step.name.clone()).collect();
        let mut chosen: Vec<Arc<Step>> = Vec::new();
        for asked in &self.models {
            if asked == ALL {
                let current = session.current().into_iter();
                chosen.extend(current.chain(models.iter().copied()).cloned());
                continue;
            }
            // Names have commas, too: of several readings the one with the longest names is meant.
            let parts: Vec<&str> = asked.split(',').collect();
            let mut from = 0;
            while from < parts.len() {
                let reading = |to: usize| place(&names, parts[from..to].join(",").trim()).map(|model| (model, to));
                let longest = (from + 1..=parts.len()).rev().find_map(reading);
                let (model, to) = longest.ok_or_else(|| LookingError::NoModel {
                    asked: parts[from..].join(",").trim().to_owned(),
                    known: numbered(&names),
                })?;
                chosen.push(Arc::clone(models[model]));
                from = to;
            }
        }
        let mut once: Vec<Arc<Step>> = Vec::new();
        for step in chosen {
            if once.iter().all(|known| known.generation != step.generation) {
                once.push(step);
            }
        }
        Ok(once)
    }

    /// The session with the first of the models that were asked for as its current one.
    ///
    /// # Errors
    /// [`LookingError`] if there is no such model.
    pub fn taken_up(&self, session: &Session) -> Result<Session, LookingError> {
        match self.chosen(session)?.first() {
            Some(first) if session.current().is_none_or(|current| current.generation != first.generation) => {
                Ok(Command::TakeUp { name: first.name.clone() }.run(session, &Monitor::new())?)
            }
            _ => Ok(session.clone()),
        }
    }
}

impl TorquescopeApp {
    /// Looks where it is asked for; what is asked to be shown must be known to one of these screens. Gives the models that were
    /// left out, because no more can be told apart.
    ///
    /// # Errors
    /// [`LookingError`] if there is no such thing here.
    pub fn look_as(&mut self, looking: &Looking, of: impl Fn(&About) -> bool) -> Result<Vec<Arc<Step>>, LookingError> {
        let session = self.history.current().clone();
        let left_out = self.overlay(looking, &session)?;
        let Some(recording) = session.recording.as_deref() else { return Ok(left_out) };
        if let Some(asked) = &looking.trajectory {
            let names: Vec<String> = recording.trajectories.iter().map(|run| run.name.clone()).collect();
            let found = place(&names, asked);
            let no_such = || LookingError::NoTrajectory { asked: asked.clone(), known: numbered(&names) };
            self.focus.show_trajectory(found.ok_or_else(no_such)?);
        }
        if let Some(asked) = looking.joint {
            let joints = recording.joint_count();
            let joint = asked.checked_sub(1).filter(|joint| *joint < joints);
            self.focus.joint = joint.ok_or(LookingError::NoJoint { asked, joints })?;
        }
        if let (Some(asked), Some(run)) = (looking.range, recording.trajectories.get(self.focus.trajectory)) {
            let [from, to] = time_extent(&run.time);
            if asked[1] <= from || asked[0] >= to {
                return Err(LookingError::NoTime { asked, name: run.name.clone(), from, to });
            }
            self.focus.views.of(Along::Time).range = Some(asked);
        }
        if let Some(text) = &looking.formula {
            self.focus.own_series.text.clone_from(text);
            if let Some(reason) = self.at_desk(|_, desk| formula::problem(desk)) {
                return Err(LookingError::Formula { text: text.clone(), reason });
            }
        }
        for asked in &looking.show {
            let turned = self.at_desk(|screens, desk| screens.turn(desk, asked, &of));
            turned.map_err(|known| LookingError::NoSwitch { asked: asked.clone(), known })?;
        }
        for [chart, text] in &looking.lines {
            self.write_line(chart, text, &of)?;
        }
        Ok(left_out)
    }

    /// Writes a line into all charts of these screens whose title contains this.
    fn write_line(&mut self, chart: &str, text: &str, of: impl Fn(&About) -> bool) -> Result<(), LookingError> {
        let (shown, mut known) = (self.screen(), Vec::new());
        for screen in screens::all().filter(|about| of(about)) {
            self.show_screen(screen);
            let mut charts = self.at_desk(|screens, desk| screens.figures(desk));
            charts.retain(|panel| self.focus.views.own.can_be_in(panel));
            known.extend(charts.iter().map(|panel| panel.title.clone()));
            charts.retain(|panel| panel.title.contains(chart));
            let series = OwnSeries { text: text.to_owned(), ..OwnSeries::default() };
            charts.iter().for_each(|panel| self.focus.views.own.add(panel, series.clone()));
            if !charts.is_empty() {
                // Whether it can be drawn is known when it is.
                self.at_desk(|screens, desk| screens.figures(desk));
            }
        }
        self.show_screen(shown);
        if let Some((text, reason)) = self.focus.views.own.problem() {
            return Err(LookingError::Formula { text, reason });
        }
        let is_there = known.iter().any(|title| title.contains(chart));
        let no_such = || LookingError::NoChart { asked: chart.to_owned(), known: known.join(", ") };
        if is_there { Ok(()) } else { Err(no_such()) }
    }

    /// Draws the models that were asked for, and no others.
    fn overlay(&mut self, looking: &Looking, session: &Session) -> Result<Vec<Arc<Step>>, LookingError> {
        let mut chosen = looking.chosen(session)?;
        if chosen.is_empty() {
            return Ok(Vec::new());
        }
        if chosen.len() > MOST_MODELS && !looking.models.iter().any(|asked| asked == ALL) {
            return Err(LookingError::TooManyModels { asked: chosen.len() });
        }
        let left_out = chosen.split_off(chosen.len().min(MOST_MODELS));
        self.focus.overlaid = Overlaid::of(chosen.iter().skip(1).map(|step| step.generation));
        self.focus.hides_ladder = true;
        Ok(left_out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{Excitation, Scenario};

    fn repaired() -> Session {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        let run = |command: &Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
        let simulate = Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }));
        let add = Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0, 1] };
        run(&add, &run(&simulate, &Session::default()))
    }

    fn names(session: &Session, models: &[&str]) -> Result<Vec<String>, String> {
        let looking = Looking { models: models.iter().map(|name| (*name).to_owned()).collect(), ..Looking::default() };
        let chosen = looking.chosen(session).map_err(|error| error.to_string())?;
        Ok(chosen.iter().map(|step| step.name.clone()).collect())
    }

    #[test]
    fn models_are_named_although_their_names_have_commas() {
        let session = repaired();
        let (body, friction) = ("rigid body", "rigid body + Coulomb 1, 2");
        assert_eq!(names(&session, &["rigid body + Coulomb 1, 2,rigid body"]).unwrap(), [friction, body]);
        assert_eq!(names(&session, &["rigid body,rigid body + Coulomb 1, 2"]).unwrap(), [body, friction]);
        assert_eq!(names(&session, &["2,1"]).unwrap(), [friction, body]);
        assert_eq!(names(&session, &["all"]).unwrap(), [friction, body], "the current one is first");
        assert!(names(&session, &[]).unwrap().is_empty());
        let message = names(&session, &["rigid body,DeLaN"]).unwrap_err();
        assert!(message.contains("no model `DeLaN`") && message.contains("2 `rigid body + Coulomb 1, 2`"), "{message}");
    }

    #[test]
    fn the_first_model_that_is_named_is_the_current_one() {
        let looking = Looking { models: vec!["1".to_owned()], ..Looking::default() };
        let session = looking.taken_up(&repaired()).unwrap();
        assert_eq!(session.current().unwrap().name, "rigid body");
    }
}
