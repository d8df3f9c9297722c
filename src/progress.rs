//! How long work tells its progress and is told to stop.
//!
//! Every function that may take more than a few milliseconds takes a [`Monitor`]: it reports there what it does and how
//! far it is, and ends with [`Stopped`] as soon as somebody asked for it. Who watches (a progress bar, a window, nobody)
//! is not its concern.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// The work was asked to stop; nothing that it had begun is kept.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("stopped: {reason}")]
pub struct Stopped {
    /// Why, in the words of whoever asked.
    pub reason: String,
}

/// What a watcher sees of running work.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Progress {
    /// How much is done, 0 to 1.
    pub fraction: f32,
    /// What is being done now.
    pub activity: String,
}

/// The line between running work and those who watch it. Clones share one line.
#[derive(Clone, Default)]
pub struct Monitor(Arc<Line>);

/// What happens at a report; an error there ends the work.
type OnReport = dyn Fn(&Progress) -> Result<(), Stopped> + Send + Sync;

#[derive(Default)]
struct Line {
    progress: Mutex<Progress>,
    stop_asked: AtomicBool,
    /// Looked at in inner loops; `paused` is what a pause waits on.
    pause_asked: AtomicBool,
    paused: Mutex<bool>,
    changed: Condvar,
    reason: Mutex<String>,
    on_report: Option<Box<OnReport>>,
}

impl Monitor {
    /// A line that nobody watches yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A line that calls `on_report` after each report, for watchers that have to be woken.
    pub fn waking(on_report: impl Fn() + Send + Sync + 'static) -> Self {
        Self::relaying(move |_| {
            on_report();
            Ok(())
        })
    }

    /// A line for a part of some work: what the part reports is passed on, and where passing it on fails the part ends.
    pub fn relaying(on_report: impl Fn(&Progress) -> Result<(), Stopped> + Send + Sync + 'static) -> Self {
        Self(Arc::new(Line { on_report: Some(Box::new(on_report)), ..Line::default() }))
    }

    /// Says what is being done and how far it is (0 to 1).
    ///
    /// # Errors
    /// [`Stopped`] once a stop was asked for: return it at once.
    pub fn report(&self, fraction: f32, activity: &str) -> Result<(), Stopped> {
        self.check()?;
        {
            let mut progress = self.0.progress.lock().unwrap_or_else(PoisonError::into_inner);
            progress.fraction = fraction.clamp(0.0, 1.0);
            if progress.activity != activity {
                activity.clone_into(&mut progress.activity);
            }
        }
        match &self.0.on_report {
            Some(on_report) => on_report(&self.progress()),
            None => Ok(()),
        }
    }

    /// [`Stopped`] once a stop was asked for; cheap enough for inner loops. Returns only when the work is not paused.
    ///
    /// # Errors
    /// [`Stopped`] once a stop was asked for.
    pub fn check(&self) -> Result<(), Stopped> {
        if self.0.pause_asked.load(Ordering::Relaxed) {
            let paused = self.0.paused.lock().unwrap_or_else(PoisonError::into_inner);
            drop(self.0.changed.wait_while(paused, |paused| *paused));
        }
        if self.0.stop_asked.load(Ordering::Relaxed) {
            let reason = self.0.reason.lock().unwrap_or_else(PoisonError::into_inner).clone();
            return Err(Stopped { reason });
        }
        Ok(())
    }

    /// Asks the work to stop, and says why.
    pub fn stop(&self, reason: &str) {
        reason.clone_into(&mut self.0.reason.lock().unwrap_or_else(PoisonError::into_inner));
        self.0.stop_asked.store(true, Ordering::Relaxed);
        // Paused work has to go on to its end.
        self.pause(false);
    }

    /// Lets the work wait at its next report, or go on.
    pub fn pause(&self, paused: bool) {
        *self.0.paused.lock().unwrap_or_else(PoisonError::into_inner) = paused;
        self.0.pause_asked.store(paused, Ordering::Relaxed);
        self.0.changed.notify_all();
    }

    /// Whether the work waits.
    pub fn is_paused(&self) -> bool {
        self.0.pause_asked.load(Ordering::Relaxed)
    }

    /// The newest report.
    pub fn progress(&self) -> Progress {
        self.0.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_reaches_the_work_with_its_reason() {
        let monitor = Monitor::new();
        monitor.report(0.5, "fitting").unwrap();
        assert_eq!(monitor.progress(), Progress { fraction: 0.5, activity: "fitting".into() });
        monitor.clone().stop("the user closed the file");
        assert_eq!(monitor.report(0.6, "fitting"), Err(Stopped { reason: "the user closed the file".into() }));
    }
}
