//! Work with a progress bar on standard error, if that is a terminal; and remarks beside the result.

use std::fmt::Display;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::bail;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::failure::OrUsage;
use super::terminal::harmless;
use crate::experiment::run::duration_text;
use crate::progress::{Event, Monitor, Progress};
use crate::recording::split::SplitError;
use crate::session::{Command, Session, SessionError};
use crate::work::{Job, Outcome};

/// How often the bar is drawn.
const TICK: Duration = Duration::from_millis(20);

/// Whether the user asked for results and errors only: a matter of the whole process.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From here on there are no progress bars and no remarks.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Says something beside the result, on standard error.
pub fn remark(text: impl Display) {
    if !is_quiet() {
        eprintln!("{text}");
    }
}

/// Says what was written, on standard output.
pub fn told(text: impl Display) {
    if !is_quiet() {
        println!("{text}");
    }
}

/// Runs `work` as a job and shows its progress until it ends.
pub fn watch<T: Send + 'static, E: std::fmt::Display>(
    name: &str,
    work: impl FnOnce(&Monitor) -> Result<T, E> + Send + 'static,
) -> anyhow::Result<T> {
    // Hidden by itself where standard error is no terminal.
    let bar = ProgressBar::new(1000).with_style(
        ProgressStyle::with_template("{bar:30} {percent:>3} % {msg}").unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    if is_quiet() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    let caller = std::thread::current();
    let mut job = Job::spawn(name, move || caller.unpark(), work);
    let (mut progress, mut so_far) = (Progress::default(), String::new());
    let outcome = loop {
        // The outcome first: what was told just before it is still to be heard.
        let outcome = job.poll();
        for event in job.events() {
            match event {
                Event::Warning(warning) => bar.suspend(|| remark(format_args!("warning: {warning}"))),
                event => hear(event, &mut progress, &mut so_far),
            }
        }
        if let Some(outcome) = outcome {
            break outcome;
        }
        bar.set_position((progress.fraction * 1000.0) as u64);
        bar.set_message(harmless(&format_args!("{}{so_far}", progress.activity)));
        std::thread::park_timeout(TICK);
    };
    bar.finish_and_clear();
    match outcome {
        Outcome::Done(result) => Ok(result),
        Outcome::Failed(message) => bail!("{message}"),
        Outcome::Stopped(reason) => bail!("stopped: {reason}"),
        Outcome::Panicked(message) => bail!("{name} broke, which is a defect of this program: {message}"),
    }
}

/// Takes an event into what the bar shows: how far the work is, and in words what it has so far.
fn hear(event: Event, progress: &mut Progress, so_far: &mut String) {
    match event {
        Event::Progress(newer) => *progress = newer,
        Event::Done(_) => so_far.clear(),
        Event::Epoch(epoch) => *so_far = format!(", {} left", duration_text(epoch.remaining_s)),
        Event::Found(found) if found.is_empty() => so_far.clear(),
        Event::Found(found) => *so_far = format!(", so far: {}", found.join("; ")),
        Event::Warning(_) => {}
    }
}

/// Runs a session command and shows its progress.
pub fn run(command: Command, session: &Session) -> anyhow::Result<Session> {
    let session = session.clone();
    watch(&command.title(), move |monitor| as_asked(command.run(&session, monitor)))?.or_usage()
}

/// Opens what a session command opens, identifies nothing from it, and shows its progress.
pub fn open(command: Command, session: &Session) -> anyhow::Result<Session> {
    let session = session.clone();
    watch(&command.title(), move |monitor| as_asked(command.opened(&session, monitor)))?.or_usage()
}

/// What an option asks to hold out shows to be missing only once the log is read, and is wrong usage all the same.
fn as_asked(outcome: Result<Session, SessionError>) -> Result<Result<Session, SplitError>, SessionError> {
    match outcome {
        Err(SessionError::Split(error)) => Ok(Err(error)),
        other => other.map(Ok),
    }
}
