//! A panic in every kind of job: its owner lives, is told, still has the session, and can do the same again.

use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::model::Preset;
use crate::model::learned::{Layers, LearnedPreset};
use crate::progress::Monitor;
use crate::session::{Command, Session};
use crate::simulation::extrapolation::Stretch;
use crate::training::Options;
use crate::training::fit::{self, Plan};
use crate::work::{self, Job, Outcome};

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "jobs",
    promise: "a panic at the first, a middle and the last report of every kind of job: its owner is told, and the same job then \
              gives what it gave before (screens: `cargo test --test window lost::`)",
    take,
};

const INJECTED: &str = "injected by the selftest";

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let monitor = Monitor::new();
    let failed = |error: &dyn std::fmt::Display| SelftestError::making("a session")(error);
    let simulate = Command::Simulate(Box::new(seeds::scenario(bench.effort.seed)));
    let session = simulate.run(&Session::default(), &monitor).map_err(|error| failed(&error))?;
    let mut score = Score::default();
    let commands = commands(&session, simulate);
    let commands = &commands[..bench.cases(commands.len(), commands.len())];
    let hook = std::panic::take_hook();
    // What is injected need not be told on the terminal.
    std::panic::set_hook(Box::new(|_| ()));
    let tried = commands.iter().enumerate().try_for_each(|(number, command)| {
        bench.report(number, commands.len(), "panics in jobs")?;
        broken_by_panics(&mut score, command, &session)
    });
    std::panic::set_hook(hook);
    tried.map(|()| score)
}

/// One of every kind that takes a while.
fn commands(session: &Session, simulate: Command) -> Vec<Command> {
    let options = Options { epochs: 3, batch: 64, ..Options::ours() };
    let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
    let effect = crate::simulation::Scenario::embedded().effects.swap_remove(0).effect;
    vec![
        simulate,
        Command::ChoosePreset(Preset::RigidBody),
        Command::AddEffect { effect, joints: vec![0] },
        Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(plan) },
        Command::Extrapolate { steps: session.ladder.clone(), stretch: Stretch::Speed },
        Command::Make { presets: vec![Preset::StatedArm] },
        Command::Diagnose,
        Command::Propose,
    ]
}

fn broken_by_panics(score: &mut Score, command: &Command, session: &Session) -> Result<(), SelftestError> {
    let title = command.title();
    let (whole, reports) = done(command, session, None);
    let Outcome::Done(whole) = whole else {
        return Err(SelftestError::making(&title)(&"it fails without a panic too"));
    };
    let mut moments = vec![0, reports / 2, reports.saturating_sub(1)];
    moments.dedup();
    for moment in moments {
        score.cases += 1;
        let (outcome, _) = done(command, session, Some(moment));
        let is_told = matches!(&outcome, Outcome::Panicked(message) if message.contains(INJECTED));
        score.count(if is_told { "told" } else { "not told" });
        score.demand(is_told, || format!("{title}, report {moment} of {reports}: the panic came out as another end"));
        let (again, _) = done(command, session, None);
        let is_same = matches!(&again, Outcome::Done(again) if *again == whole);
        score.count(if is_same { "the same afterwards" } else { "another result afterwards" });
        score.demand(is_same, || format!("{title}, report {moment} of {reports}: afterwards it gives another result"));
    }
    Ok(())
}

/// What a command gives, as bytes, and how often it reports; at one of its reports it may panic.
fn done(command: &Command, session: &Session, panics_at: Option<usize>) -> (Outcome<Vec<u8>>, usize) {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};
    let reports = Arc::new(AtomicUsize::new(0));
    let (command, session, count) = (command.clone(), session.clone(), Arc::clone(&reports));
    let mut job = Job::spawn(
        "panic",
        || (),
        move |_| {
            let monitor = Monitor::relaying(move |_| {
                if Some(count.fetch_add(1, Ordering::Relaxed)) == panics_at {
                    panic!("{INJECTED}");
                }
                Ok(())
            });
            command.run(&session, &monitor).map(|session| bytes(&session))
        },
    );
    loop {
        if let Some(outcome) = job.poll() {
            return (outcome, reports.load(Ordering::Relaxed));
        }
        work::pause();
    }
}

/// What there is to compare of a session: its models, its report and its curves.
fn bytes(session: &Session) -> Vec<u8> {
    let mut all = Vec::new();
    for step in &session.ladder {
        all.extend(fit::to_bytes(&step.fitted).unwrap_or_default());
    }
    all.extend(serde_json::to_vec(&session.report).unwrap_or_default());
    all.extend(serde_json::to_vec(&session.sweep).unwrap_or_default());
    all.extend(serde_json::to_vec(&session.proposals).unwrap_or_default());
    all.extend(session.models.len().to_le_bytes());
    all
}
