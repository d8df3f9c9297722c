//! Another recording of the same arm beside the one that models were fitted to. All of it is held out: one trains on the first and
//! looks at the other.

use std::path::PathBuf;
use std::sync::Arc;

use super::error::SessionError;
use super::models::Kept;
use super::name::unique;
use super::{Session, Step};
use crate::model::Evaluation;
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::{self, ReadOptions};
use crate::recording::split::{Segment, Split, unusable};

/// The session with these files as further trajectories, and every model held against them. No model is fitted anew.
pub(super) fn add(session: &Session, paths: &[PathBuf], monitor: &Monitor) -> Result<Session, SessionError> {
    let own = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let import = read::read(paths, &options(session), monitor)?;
    let other = import.recording;
    let kinds = |recording: &Recording| recording.joints.iter().map(|joint| joint.kind.effort()).collect::<Vec<_>>();
    let (has, needs) = (kinds(&other), kinds(own));
    if has != needs {
        return Err(SessionError::OtherJoints { has: has.join(", "), needs: needs.join(", ") });
    }
    let (recording, split) = joined(own, other, &session.split);
    let mut measured: Vec<Arc<Step>> = Vec::new();
    let all = || session.models.iter().flat_map(|kept| &kept.ladder).chain(&session.ladder);
    for step in all() {
        if measured.iter().all(|known| known.generation != step.generation) {
            monitor.check()?;
            let evaluation = Evaluation::of(&step.fitted, &recording, &split)?;
            // Its arm was simulated from other states.
            measured.push(Arc::new(Step { evaluation, rollout: None, ..Step::clone(step) }));
        }
    }
    // The same step stands in several ladders.
    let again = |step: &Arc<Step>| measured.iter().find(|known| known.generation == step.generation).cloned();
    let ladder = |steps: &[Arc<Step>]| steps.iter().filter_map(again).collect::<Vec<_>>();
    let models = session.models.iter().map(|kept| Kept { preset: kept.preset, ladder: ladder(&kept.ladder) }).collect();
    let ladder = ladder(&session.ladder);
    let findings = session.findings.iter().cloned().chain(import.findings).collect();
    let source = session.source.as_deref().and_then(|source| source.beside(paths, held_out(&recording, &split)));
    let source = source.map(Arc::new);
    let recording = Some(Arc::new(recording));
    let (report, proposals, sweep) = (None, None, None);
    let findings = Arc::new(findings);
    Ok(Session { recording, findings, source, split, models, ladder, report, proposals, sweep, ..session.clone() })
}

/// As the first recording was read.
fn options(session: &Session) -> ReadOptions {
    let read = session.source.as_ref().filter(|source| source.files().is_some());
    read.map_or_else(ReadOptions::default, |source| source.options.clone())
}

/// Both recordings as one, of which all of the other is held out as far as its readings are some.
fn joined(own: &Recording, other: Recording, split: &Split) -> (Recording, Split) {
    let first = own.trajectories.len();
    let clear = Split { train: other.runs().collect(), ..Split::default() }.clear_of(&other, &unusable(&other)).train;
    let mut split = split.clone();
    split.held_out.extend(clear.into_iter().map(|part| Segment { trajectory: first + part.trajectory, ..part }));
    let mut recording = own.clone();
    for mut run in other.trajectories {
        run.name = unique(&run.name, recording.trajectories.iter().map(|known| known.name.as_str()));
        recording.trajectories.push(run);
    }
    (recording, split)
}

/// The trajectories of which nothing trains.
pub(super) fn held_out(recording: &Recording, split: &Split) -> HoldOut {
    let trains = |index: usize| split.train.iter().any(|segment| segment.trajectory == index);
    let held_out = (0..recording.trajectories.len()).filter(|index| !trains(*index));
    HoldOut::named(held_out.map(|index| recording.trajectories[index].name.clone()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::write;
    use crate::session::Command;
    use crate::simulation::{Excitation, Scenario, simulate};

    fn scenario(seed: u64, samples: usize) -> Scenario {
        let motion = Excitation::PaperPointToPoint { trajectories: 5, duration: 4.0, samples, range: 2.0 };
        Scenario { motion, seed, ..Scenario::embedded() }
    }

    fn run(command: &Command, session: &Session) -> Result<Session, SessionError> {
        command.run(session, &Monitor::new())
    }

    /// What was fitted stays as it is; the other recording is only looked at.
    #[test]
    fn models_are_held_against_another_recording_and_not_fitted_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("other.npz");
        let other = simulate(&scenario(9, 60), &Monitor::new()).unwrap();
        std::fs::write(&path, write::to_npz_bytes(&other).unwrap()).unwrap();
        let first = run(&Command::Simulate(Box::new(scenario(7, 80))), &Session::default()).unwrap();
        let add = Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0, 1] };
        let first = run(&add, &first).unwrap();
        let both = run(&Command::Beside { paths: vec![path.clone()] }, &first).unwrap();
        let (before, after) = (first.recording.as_ref().unwrap(), both.recording.as_ref().unwrap());
        assert_eq!((before.trajectories.len(), after.trajectories.len()), (5, 10));
        assert_eq!(both.split.train, first.split.train);
        assert!((5..10).all(|run| both.split.held_out.iter().any(|part| part.trajectory == run)));
        let mut names: Vec<&str> = after.trajectories.iter().map(|run| run.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 10, "each has a name of its own: {names:?}");
        for (old, new) in first.ladder.iter().zip(&both.ladder) {
            assert_eq!(
                (&old.fitted, old.generation, &old.evaluation.train),
                (&new.fitted, new.generation, &new.evaluation.train)
            );
            assert_eq!(new.evaluation.predictions.len(), 10);
        }
        assert!(both.all_models().all(|step| step.evaluation.predictions.len() == 10));

        let arm = crate::arm::Arm::uniform(2);
        let small = Scenario { arm, effects: Vec::new(), ..scenario(1, 60) };
        let small = run(&Command::Simulate(Box::new(small)), &Session::default()).unwrap();
        let refused = run(&Command::Beside { paths: vec![path] }, &small).unwrap_err().to_string();
        assert!(refused.contains("torque, torque, torque"), "{refused}");
    }
}
