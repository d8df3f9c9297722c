//! Work with a progress bar on standard error, if that is a terminal.

use std::time::Duration;

use anyhow::bail;
use indicatif::{ProgressBar, ProgressStyle};

use crate::progress::Monitor;
use crate::session::{Command, Session};
use crate::work::{Job, Outcome};

/// How often the bar is drawn.
const TICK: Duration = Duration::from_millis(20);

/// Runs `work` as a job and shows its progress until it ends.
pub fn watch<T: Send + 'static, E: std::fmt::Display>(
    name: &str,
    work: impl FnOnce(&Monitor) -> Result<T, E> + Send + 'static,
) -> anyhow::Result<T> {
    // Hidden by itself where standard error is no terminal.
    let bar = ProgressBar::new(1000).with_style(
        ProgressStyle::with_template("{bar:30} {percent:>3} % {msg}").unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let caller = std::thread::current();
    let mut job = Job::spawn(name, move || caller.unpark(), work);
    let outcome = loop {
        if let Some(outcome) = job.poll() {
            break outcome;
        }
        let progress = job.progress();
        bar.set_position((progress.fraction * 1000.0) as u64);
        bar.set_message(progress.activity);
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

/// Runs a session command and shows its progress.
pub fn run(command: Command, session: &Session) -> anyhow::Result<Session> {
    let session = session.clone();
    watch(&command.title(), move |monitor| command.run(&session, monitor))
}
