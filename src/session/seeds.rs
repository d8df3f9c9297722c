//! One model trained from several seeds: how much of its error is chance.

use std::sync::Arc;

use super::error::SessionError;
use super::step::step;
use super::{Command, Kept, Session, Step};
use crate::progress::{Epoch, Event, Monitor, Progress};
use crate::training::Ending;
use crate::training::fit::Plan;

/// Mean, least and greatest of a number over several trainings.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Least.
    pub least: f64,
    /// Greatest.
    pub greatest: f64,
}

impl Spread {
    /// Of numbers; `None` of nothing.
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Option<Self> {
        let numbers: Vec<f64> = numbers.into_iter().collect();
        let [least, greatest] = crate::statistics::ends(numbers.iter().copied());
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        (!numbers.is_empty()).then_some(Spread { mean, least, greatest })
    }
}

impl Session {
    /// The trainings that differ from that of a model in nothing but their seed, the model itself among them, in the order in
    /// which they were made. None if it was not trained.
    pub fn seeds_of(&self, step: &Step) -> Vec<&Arc<Step>> {
        let Some(own) = &step.run else { return Vec::new() };
        let is_of_them = |other: &&Arc<Step>| other.run.as_ref().is_some_and(|run| run.differs_by_seed_only(own));
        self.all_models().filter(is_of_them).collect()
    }
}

/// Trains the current model (or the one that `begin` trains) from so many seeds, one after the other. All are kept as models; the
/// one with the smallest validation error becomes the current one. A stop keeps those that are done.
pub(super) fn train(
    session: &Session,
    begin: Option<&Command>,
    seeds: u64,
    monitor: &Monitor,
) -> Result<Session, SessionError> {
    let first = match begin {
        Some(begin) => begin.run(session, &share(monitor, 0, seeds))?,
        None => session.clone(),
    };
    let trained = first.current().filter(|step| step.run.is_some()).ok_or(SessionError::NothingToTrain)?.clone();
    let before = &first.ladder[..first.ladder.len() - 1];
    let mut best = Arc::clone(&trained);
    let mut models = first.models.clone();
    for number in 1..seeds {
        let plan = seeded(&first.plan, number);
        let planned = Session { plan, checkpoint_file: None, ..first.clone() };
        let mut next = match step(trained.fitted.model.clone(), None, &planned, &share(monitor, number, seeds)) {
            // Stopped before the first epoch of this one.
            Err(error) if monitor.check().is_err() => {
                monitor.tell(Event::Warning(format!("only {number} of {seeds} seeds were trained: {error}")));
                break;
            }
            next => next?,
        };
        if matches!(next.ending, Some(Ending::Stopped(_))) {
            monitor.tell(Event::Warning(format!("only {number} of {seeds} seeds were trained: it was stopped")));
            break;
        }
        let taken = models.iter().filter_map(Kept::step).map(|step| step.name.as_str());
        Arc::make_mut(&mut next).name = super::name::unique(&format!("{}, seed {number}", trained.name), taken);
        models.push(Kept { preset: first.preset, ladder: [before, &[Arc::clone(&next)]].concat() });
        if deciding(&next) < deciding(&best) {
            best = next;
        }
    }
    let ladder = [before, &[best]].concat();
    Ok(Session { models, ladder, report: None, proposals: None, ..first })
}

/// The same plan from a later seed.
fn seeded(plan: &Plan, number: u64) -> Plan {
    let mut plan = plan.clone();
    plan.options.seed += number;
    plan
}

fn deciding(step: &Step) -> f64 {
    step.history.iter().map(Epoch::deciding_error).fold(f64::INFINITY, f64::min)
}

/// The line of one of several trainings: all that it tells is passed on, its progress as a share of the whole.
fn share(monitor: &Monitor, number: u64, of: u64) -> Monitor {
    let whole = monitor.clone();
    monitor.of_part(move |event| match event {
        Event::Progress(Progress { fraction, activity }) => {
            let activity = format!("seed {} of {of}, {activity}", number + 1);
            whole.report((number as f32 + fraction) / of as f32, &activity)
        }
        other => {
            whole.tell(other.clone());
            Ok(())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::learned::{Layers, LearnedPreset};
    use crate::simulation::{Excitation, Scenario};
    use crate::training::Options;

    fn plan(epochs: u64) -> Box<Plan> {
        let options = Options { epochs, batch: 20, ..Options::ours() };
        Box::new(Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() })
    }

    #[test]
    fn several_seeds_are_models_of_which_the_best_by_validation_is_the_current_one() {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        let simulate = Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }));
        let monitor = Monitor::new();
        let session = simulate.run(&Session::default(), &monitor).unwrap();
        let begin = |epochs| Command::TrainPreset { preset: LearnedPreset::FfNn, plan: plan(epochs) };
        let other = begin(1).run(&session, &monitor).unwrap();
        let seeds = Command::TrainSeeds { begin: Some(Box::new(begin(2))), seeds: 3 };
        let trained = seeds.run(&other, &monitor).unwrap();
        let current = trained.current().unwrap();
        let own = trained.seeds_of(current);
        let numbers: Vec<u64> = own.iter().map(|step| step.run.as_ref().unwrap().plan.options.seed).collect();
        assert_eq!(numbers, [0, 1, 2], "the one of another plan is none of them");
        assert!(own.iter().all(|step| deciding(current) <= deciding(step)));
        let names: Vec<&str> = trained.all_models().map(|step| step.name.as_str()).collect();
        assert_eq!(names, ["rigid body", "FF-NN", "FF-NN (2)", "FF-NN (2), seed 1", "FF-NN (2), seed 2"]);
        let spread = Spread::of(own.iter().map(|step| step.evaluation.held_out[0].nmse)).unwrap();
        assert!(spread.least < spread.mean && spread.mean < spread.greatest);
        assert_eq!(Spread::of([]), None);
        let message = Command::TrainSeeds { begin: None, seeds: 2 }.run(&session, &monitor).unwrap_err().to_string();
        assert!(message.contains("nothing to train"), "{message}");
    }
}
