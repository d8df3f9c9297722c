//! One piece of work in a thread of its own.
//!
//! The owner never waits: it polls. A stop frees the owner at once; the abandoned thread ends at its next report, and
//! what it still returns is thrown away, since nobody holds the other end of its channel any more.

use std::any::Any;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use crate::progress::{Event, Monitor, Progress};

/// Work that runs, seen by its owner.
pub struct Job<T> {
    name: String,
    monitor: Monitor,
    end: Receiver<Outcome<T>>,
    stopped: Option<String>,
}

/// How a job ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome<T> {
    /// It gave its result.
    Done(T),
    /// It could not be done; the message says why.
    Failed(String),
    /// It was stopped, for this reason.
    Stopped(String),
    /// It broke: a defect of the program, with the panic's message.
    Panicked(String),
}

impl<T: Send + 'static> Job<T> {
    /// Runs `work` in a new thread. `wake` is called after each event and at the end, so that a window repaints.
    pub fn spawn<E: Display>(
        name: impl Into<String>,
        wake: impl Fn() + Send + Sync + 'static,
        work: impl FnOnce(&Monitor) -> Result<T, E> + Send + 'static,
    ) -> Self {
        let name = name.into();
        let wake = Arc::new(wake);
        let monitor = Monitor::waking({
            let wake = Arc::clone(&wake);
            move || wake()
        });
        let (sender, end) = channel();
        let (line, failed) = (monitor.clone(), sender.clone());
        let body = move || {
            let outcome = match catch_unwind(AssertUnwindSafe(|| work(&line))) {
                Ok(Ok(result)) => Outcome::Done(result),
                Ok(Err(error)) => Outcome::Failed(error.to_string()),
                Err(panic) => Outcome::Panicked(message_of(panic.as_ref())),
            };
            // Nobody listens any more after a stop: then the result is not wanted.
            let _ = sender.send(outcome);
            wake();
        };
        if let Err(error) = thread::Builder::new().name(name.clone()).spawn(body) {
            let _ = failed.send(Outcome::Failed(format!("the system gave no thread for it: {error}")));
        }
        Job { name, monitor, end, stopped: None }
    }

    /// The outcome, once there is one; it is given only once.
    pub fn poll(&mut self) -> Option<Outcome<T>> {
        if let Some(reason) = self.stopped.take() {
            return Some(Outcome::Stopped(reason));
        }
        match self.end.try_recv() {
            Ok(outcome) => Some(outcome),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Outcome::Panicked("it ended without a result".into())),
        }
    }

    /// Asks the work to stop; the next [`Job::poll`] answers [`Outcome::Stopped`] whether or not the thread has ended.
    pub fn stop(&mut self, reason: &str) {
        self.monitor.stop(reason);
        self.stopped = Some(reason.to_owned());
    }

    /// Asks the work to end early with what it has; the next polls wait for that result.
    pub fn finish(&self, reason: &str) {
        self.monitor.stop(reason);
    }

    /// Lets the work wait at its next report, or go on.
    pub fn pause(&self, paused: bool) {
        self.monitor.pause(paused);
    }

    /// Whether the work waits.
    pub fn is_paused(&self) -> bool {
        self.monitor.is_paused()
    }

    /// What it does, in words for people.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The newest report.
    pub fn progress(&self) -> Progress {
        self.monitor.progress()
    }

    /// All that it told since this was called last, in its order.
    pub fn events(&self) -> Vec<Event> {
        self.monitor.take_events()
    }
}

/// What somebody who panicked said.
pub fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    use super::*;

    /// A guard against work that never ends, out of reach of a machine that is merely busy.
    const PATIENCE: Duration = Duration::from_secs(1800);

    fn outcome<T: Send + 'static>(job: &mut Job<T>) -> Outcome<T> {
        let begin = Instant::now();
        loop {
            if let Some(outcome) = job.poll() {
                return outcome;
            }
            assert!(begin.elapsed() < PATIENCE, "the job never ended");
            thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn gives_its_result_and_wakes_the_owner() {
        let woken = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&woken);
        let wake = move || {
            count.fetch_add(1, Ordering::SeqCst);
        };
        let mut job = Job::spawn("adding", wake, |monitor| {
            monitor.report(0.5, "one and one").map_err(|stopped| stopped.to_string())?;
            Ok::<_, String>(2)
        });
        assert_eq!(outcome(&mut job), Outcome::Done(2));
        assert_eq!(job.progress().activity, "one and one");
        assert!(woken.load(Ordering::SeqCst) >= 1);
    }

    #[test]
    fn a_failure_is_a_message() {
        let mut job = Job::spawn("reading", || (), |_| Err::<(), _>("line 3 is not a number"));
        assert_eq!(outcome(&mut job), Outcome::Failed("line 3 is not a number".into()));
    }

    #[test]
    fn a_panic_is_a_message() {
        let mut job = Job::spawn("breaking", || (), |_| -> Result<(), String> { panic!("index {} of 3", 7) });
        assert_eq!(outcome(&mut job), Outcome::Panicked("index 7 of 3".into()));
    }

    #[test]
    fn a_stop_answers_at_once_even_if_the_work_does_not() {
        let (awake, asleep) = channel::<()>();
        let mut job = Job::spawn(
            "sleeping",
            || (),
            move |_| {
                // As long as the owner does not let it go.
                let _ = asleep.recv();
                Ok::<_, String>(())
            },
        );
        job.stop("the user pressed Stop");
        assert_eq!(job.poll(), Some(Outcome::Stopped("the user pressed Stop".into())));
        drop(awake);
    }

    #[test]
    fn paused_work_waits_until_it_goes_on_or_is_stopped() {
        let steps = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&steps);
        let mut job = Job::spawn(
            "counting",
            || (),
            move |monitor| {
                while monitor.check().is_ok() {
                    count.fetch_add(1, Ordering::SeqCst);
                    thread::sleep(Duration::from_millis(1));
                }
                Ok::<_, String>(count.load(Ordering::SeqCst))
            },
        );
        let wait_for = |steps_then: usize| {
            let begin = Instant::now();
            while steps.load(Ordering::SeqCst) < steps_then {
                assert!(begin.elapsed() < PATIENCE, "the work does not go on");
                thread::sleep(Duration::from_millis(1));
            }
        };
        wait_for(1);
        job.pause(true);
        thread::sleep(Duration::from_millis(50));
        let at_rest = steps.load(Ordering::SeqCst);
        thread::sleep(Duration::from_millis(50));
        assert!(job.is_paused() && steps.load(Ordering::SeqCst) == at_rest);
        job.pause(false);
        wait_for(at_rest + 2);
        job.pause(true);
        job.finish("enough");
        assert!(matches!(outcome(&mut job), Outcome::Done(_)), "a finish ends the pause too");
    }

    #[test]
    fn stopped_work_hears_of_it() {
        let ended = Arc::new(AtomicUsize::new(0));
        let flag = Arc::clone(&ended);
        let mut job = Job::spawn(
            "looping",
            || (),
            move |monitor| {
                while monitor.check().is_ok() {
                    thread::sleep(Duration::from_millis(1));
                }
                flag.store(1, Ordering::SeqCst);
                Ok::<_, String>(())
            },
        );
        job.stop("enough");
        let begin = Instant::now();
        while ended.load(Ordering::SeqCst) == 0 {
            assert!(begin.elapsed() < PATIENCE, "the work was not told to stop");
            thread::sleep(Duration::from_millis(1));
        }
    }
}
