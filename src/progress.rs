//! The one line between long work and those who watch it: what it tells, and how it is told to stop.
//!
//! Every function that may take more than a few milliseconds takes a [`Monitor`]: it tells there what it does, how far it is
//! and what it has so far, and ends with [`Stopped`] as soon as somebody asked for it. Who watches (a progress bar, a window,
//! nobody) is not its concern: it never waits for them. Those who are slow find all [`Event`]s in their order; only progress
//! that is out of date is left out.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

/// The work was asked to stop; nothing that it had begun is kept.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("stopped: {reason}")]
pub struct Stopped {
    /// Why, in the words of whoever asked.
    pub reason: String,
}

/// Something that running work tells.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// What it does and how far it is.
    Progress(Progress),
    /// An epoch of a training is done.
    Epoch(Epoch),
    /// A part that stands for itself is done and can be looked at, such as a cell of an experiment.
    Done(String),
    /// A search took a step: all that it now takes to be there, such as `Coulomb friction on joint 2`.
    Found(Vec<String>),
    /// Something did not succeed, or is left out; the work goes on.
    Warning(String),
}

/// How far work is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Progress {
    /// How much is done, 0 to 1.
    pub fraction: f32,
    /// What is being done now.
    pub activity: String,
}

/// What is known after an epoch of a training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// How many epochs are done.
    pub epoch: u64,
    /// How many there will be.
    pub epochs: u64,
    /// Mean loss over the epoch.
    pub loss: f64,
    /// nMSE of the validation samples, by which the best epoch is chosen.
    #[serde(default)]
    pub validation: Option<f64>,
    /// nMSE of the held-out samples, which decides nothing.
    pub held_out: Option<f64>,
    /// Learning rate of the last step.
    pub rate: f64,
    /// Samples a second.
    pub samples_per_s: f64,
    /// Since the run began \[s\].
    pub elapsed_s: f64,
    /// Until its end, by the speed so far \[s\].
    pub remaining_s: f64,
}

impl Epoch {
    /// The error by which the best epoch is chosen: of the validation samples, or the loss where there are none.
    pub fn deciding_error(&self) -> f64 {
        self.validation.unwrap_or(self.loss)
    }
}

/// The line between running work and those who watch it. Clones share one line.
#[derive(Clone, Default)]
pub struct Monitor(Arc<Line>);

/// Where a part of some work passes its events on; an error there ends the part.
type PassOn = dyn Fn(&Event) -> Result<(), Stopped> + Send + Sync;

#[derive(Default)]
struct Line {
    told: Mutex<Told>,
    stop_asked: AtomicBool,
    /// Looked at in inner loops; `paused` is what a pause waits on.
    pause_asked: AtomicBool,
    paused: Mutex<bool>,
    changed: Condvar,
    reason: Mutex<String>,
    wake: Option<Box<dyn Fn() + Send + Sync>>,
    pass_on: Option<Box<PassOn>>,
    /// What this is the line of a part of: a stop or a pause there counts here.
    whole: Option<Monitor>,
}

/// What was told.
#[derive(Default)]
struct Told {
    progress: Progress,
    /// What nobody has taken yet, in its order.
    events: Vec<Event>,
}

impl Told {
    fn add(&mut self, event: Event) {
        if let Event::Progress(progress) = &event {
            self.progress.clone_from(progress);
            if let Some(last @ Event::Progress(_)) = self.events.last_mut() {
                *last = event;
                return;
            }
        }
        self.events.push(event);
    }
}

impl Monitor {
    /// A line that nobody watches yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A line that calls `wake` after each event, for watchers that sleep.
    pub fn waking(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Arc::new(Line { wake: Some(Box::new(wake)), ..Line::default() }))
    }

    /// A line for a part of some work: what the part tells is passed on instead of being kept, and where passing it on fails
    /// the part ends.
    pub fn relaying(pass_on: impl Fn(&Event) -> Result<(), Stopped> + Send + Sync + 'static) -> Self {
        Self(Arc::new(Line { pass_on: Some(Box::new(pass_on)), ..Line::default() }))
    }

    /// The line of a part of this work that goes from one share of the whole (0 to 1) to another. Of what the part tells only its
    /// progress is passed on.
    pub fn part(&self, share: Range<f32>) -> Self {
        let whole = self.clone();
        self.of_part(move |event| match event {
            Event::Progress(Progress { fraction, activity }) => {
                whole.report(share.start + (share.end - share.start) * fraction, activity)
            }
            _ => Ok(()),
        })
    }

    /// The line of parts that run side by side: nothing that they tell is passed on.
    pub fn quiet(&self) -> Self {
        self.of_part(|_| Ok(()))
    }

    /// The line of a part of this work: what it tells is passed on instead of being kept, and a stop or a pause of the whole counts
    /// there at once.
    pub fn of_part(&self, pass_on: impl Fn(&Event) -> Result<(), Stopped> + Send + Sync + 'static) -> Self {
        Self(Arc::new(Line { pass_on: Some(Box::new(pass_on)), whole: Some(self.clone()), ..Line::default() }))
    }

    /// Says what is being done and how far it is (0 to 1).
    ///
    /// # Errors
    /// [`Stopped`] once a stop was asked for: return it at once.
    pub fn report(&self, fraction: f32, activity: &str) -> Result<(), Stopped> {
        self.check()?;
        self.send(Event::Progress(Progress { fraction: fraction.clamp(0.0, 1.0), activity: activity.to_owned() }))
    }

    /// Says what the work has so far. It goes on at once: a stop or a pause counts from its next report on.
    pub fn tell(&self, event: Event) {
        // A part whose events can't be passed on any more hears of it at its next report.
        let _ = self.send(event);
    }

    fn send(&self, event: Event) -> Result<(), Stopped> {
        if let Some(pass_on) = &self.0.pass_on {
            return pass_on(&event);
        }
        self.told().add(event);
        if let Some(wake) = &self.0.wake {
            wake();
        }
        Ok(())
    }

    fn told(&self) -> MutexGuard<'_, Told> {
        self.0.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// All that was told since this was called last, in its order. Of progress only the newest between two other events is
    /// there. For the one who watches: what is taken is gone.
    pub fn take_events(&self) -> Vec<Event> {
        std::mem::take(&mut self.told().events)
    }

    /// [`Stopped`] once a stop was asked for; cheap enough for inner loops. Returns only when the work is not paused.
    ///
    /// # Errors
    /// [`Stopped`] once a stop was asked for.
    pub fn check(&self) -> Result<(), Stopped> {
        if let Some(whole) = &self.0.whole {
            whole.check()?;
        }
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
        self.told().progress.clone()
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

    fn epoch(epoch: u64) -> Event {
        let (loss, validation, held_out, rate) = (1.0 / epoch as f64, None, None, 1e-3);
        Event::Epoch(Epoch {
            epoch,
            epochs: 1000,
            loss,
            validation,
            held_out,
            rate,
            samples_per_s: 1.0,
            elapsed_s: 1.0,
            remaining_s: 1.0,
        })
    }

    #[test]
    fn a_slow_watcher_misses_nothing_but_progress_that_is_out_of_date() {
        let monitor = Monitor::new();
        for number in 1..=1000 {
            monitor.report(0.0, "begun").unwrap();
            monitor.report(number as f32 / 1000.0, "training").unwrap();
            monitor.tell(epoch(number));
        }
        let (progress, others): (Vec<Event>, Vec<Event>) =
            monitor.take_events().into_iter().partition(|event| matches!(event, Event::Progress(_)));
        assert_eq!(others, (1..=1000).map(epoch).collect::<Vec<_>>());
        assert_eq!(progress.len(), 1000);
        assert!(
            progress
                .iter()
                .all(|event| *event != Event::Progress(Progress { fraction: 0.0, activity: "begun".into() }))
        );
        assert_eq!((monitor.take_events(), monitor.progress().fraction), (Vec::new(), 1.0));
    }

    #[test]
    fn what_a_part_tells_goes_to_the_whole_and_a_stop_comes_back() {
        let whole = Monitor::new();
        let part = Monitor::relaying({
            let whole = whole.clone();
            move |event| match event {
                Event::Progress(progress) => whole.report(0.5 * progress.fraction, &progress.activity),
                other => {
                    whole.tell(other.clone());
                    Ok(())
                }
            }
        });
        part.report(1.0, "first half").unwrap();
        part.tell(epoch(1));
        assert_eq!(whole.take_events()[1..], [epoch(1)]);
        assert_eq!(whole.progress().fraction, 0.5);
        whole.stop("enough");
        part.tell(epoch(2));
        assert_eq!(part.report(1.0, "second half"), Err(Stopped { reason: "enough".into() }));
    }

    #[test]
    fn a_part_reports_its_share_and_keeps_what_it_has_to_itself() {
        let whole = Monitor::new();
        let part = whole.part(0.5..0.75);
        part.report(0.5, "third quarter").unwrap();
        part.tell(Event::Found(vec!["friction".into()]));
        assert_eq!(whole.progress(), Progress { fraction: 0.625, activity: "third quarter".into() });
        assert_eq!(whole.take_events().len(), 1);
        let quiet = part.quiet();
        quiet.report(0.1, "beside another").unwrap();
        assert_eq!(whole.progress().activity, "third quarter");
        whole.stop("enough");
        let stopped = Err(Stopped { reason: "enough".into() });
        assert_eq!(part.report(1.0, "third quarter"), stopped);
        // In the middle of inner loops, too, and in parts of parts.
        assert_eq!([part.check(), quiet.check()], [stopped.clone(), stopped]);
    }
}
