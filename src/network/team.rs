//! Work on all cores: a few tasks, again and again, thousands of times a second.
//!
//! In each round every task runs once. A thread begins with its own tasks (so that their memory stays in its cache) and then takes
//! what others have not begun: a core that is busy elsewhere simply does less, and a crowded machine falls back to one
//! thread by itself. What a task computes never depends on who does it; so results are the same for any number of threads.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// How long a helper looks for the next round before it sleeps: longer than the pauses within training, shorter than anybody
/// notices.
const PATIENCE: Duration = Duration::from_micros(60);

/// What runs: it is given the numbers of the task and of the thread.
type Task<'a> = &'a (dyn Fn(usize, usize) + Sync);

struct Shared {
    round: AtomicU64,
    /// The last round in which each task was taken.
    taken: Vec<AtomicU64>,
    finished: AtomicUsize,
    is_over: AtomicBool,
    has_failed: AtomicBool,
    asleep: Vec<AtomicBool>,
    threads: usize,
}

/// The leader's handle on its helpers.
pub struct Team<'a> {
    shared: &'a Shared,
    helpers: Vec<Thread>,
    task: Task<'a>,
}

/// How many threads training takes by itself: the cores of this machine, at most 8.
pub fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from).min(8)
}

/// Gives `lead` a team of `threads` threads (the caller's own, number 0, included) that runs the tasks 0 … `tasks` − 1 in rounds.
///
/// # Panics
/// If a task panics, in the leader's next round.
pub fn with_team<R>(threads: usize, tasks: usize, task: Task, lead: impl FnOnce(&mut Team) -> R) -> R {
    let helpers = threads.min(tasks).saturating_sub(1);
    let shared = Shared {
        round: AtomicU64::new(0),
        taken: (0..tasks).map(|_| AtomicU64::new(0)).collect(),
        finished: AtomicUsize::new(0),
        is_over: AtomicBool::new(false),
        has_failed: AtomicBool::new(false),
        asleep: (0..helpers).map(|_| AtomicBool::new(false)).collect(),
        threads: helpers + 1,
    };
    std::thread::scope(|scope| {
        let shared = &shared;
        let handles: Vec<_> = (0..helpers).map(|helper| scope.spawn(move || help(shared, helper, task))).collect();
        let helpers = handles.iter().map(|handle| handle.thread().clone()).collect();
        // Dropping the team, even by a panic, ends the helpers; otherwise the scope would wait for them forever.
        lead(&mut Team { shared, helpers, task })
    })
}

impl Team<'_> {
    /// Runs every task once and returns when all are done.
    pub fn run(&mut self) {
        self.shared.finished.store(0, Ordering::Relaxed);
        // Sequentially consistent, against a helper that falls asleep at this very moment.
        let round = self.shared.round.fetch_add(1, Ordering::SeqCst) + 1;
        for (asleep, thread) in self.shared.asleep.iter().zip(&self.helpers) {
            if asleep.load(Ordering::SeqCst) {
                thread.unpark();
            }
        }
        self.shared.take_tasks(round, 0, self.task);
        let mut spins = 0_u32;
        while self.shared.finished.load(Ordering::Acquire) < self.shared.taken.len() {
            spins += 1;
            if spins.is_multiple_of(1024) { std::thread::yield_now() } else { std::hint::spin_loop() }
        }
        assert!(!self.shared.has_failed.load(Ordering::Relaxed), "a task of the team panicked");
    }
}

impl Drop for Team<'_> {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::SeqCst);
        self.helpers.iter().for_each(Thread::unpark);
    }
}

impl Shared {
    /// Takes tasks of a round until none is left: first every `threads`-th, then those of the others.
    fn take_tasks(&self, round: u64, thread: usize, task: Task) {
        for shift in 0..self.threads {
            let owner = (thread + shift) % self.threads;
            for index in (owner..self.taken.len()).step_by(self.threads) {
                let taken = &self.taken[index];
                // Fails if somebody has it, or if this thread comes so late that the round is over.
                if taken.compare_exchange(round - 1, round, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
                    let guard = Finished(self);
                    task(index, thread);
                    drop(guard);
                }
            }
        }
    }
}

/// Counts a task as finished, even if it panics.
struct Finished<'a>(&'a Shared);

impl Drop for Finished<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.has_failed.store(true, Ordering::Relaxed);
        }
        self.0.finished.fetch_add(1, Ordering::Release);
    }
}

fn help(shared: &Shared, helper: usize, task: Task) {
    let mut done = 0;
    let mut waiting_since: Option<Instant> = None;
    while !shared.is_over.load(Ordering::Relaxed) {
        let round = shared.round.load(Ordering::Acquire);
        if round != done {
            shared.take_tasks(round, helper + 1, task);
            done = round;
            waiting_since = None;
            continue;
        }
        let since = *waiting_since.get_or_insert_with(Instant::now);
        if since.elapsed() < PATIENCE {
            (0..4).for_each(|_| std::hint::spin_loop());
            continue;
        }
        shared.asleep[helper].store(true, Ordering::SeqCst);
        if shared.round.load(Ordering::SeqCst) == done && !shared.is_over.load(Ordering::SeqCst) {
            std::thread::park();
        }
        shared.asleep[helper].store(false, Ordering::SeqCst);
        waiting_since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_runs_once_a_round() {
        for threads in [1, 2, 3] {
            let counts: Vec<AtomicUsize> = (0..8).map(|_| AtomicUsize::new(0)).collect();
            let task = |index: usize, _| _ = counts[index].fetch_add(1, Ordering::Relaxed);
            with_team(threads, counts.len(), &task, |team| {
                for round in 0..300 {
                    team.run();
                    if round % 100 == 0 {
                        std::thread::sleep(2 * PATIENCE);
                    }
                }
            });
            assert!(counts.iter().all(|count| count.load(Ordering::Relaxed) == 300));
        }
    }

    #[test]
    fn a_panicking_task_ends_in_a_panic_of_the_leader() {
        let task = |index: usize, _| assert!(index != 3);
        let result = std::panic::catch_unwind(|| with_team(2, 4, &task, |team| team.run()));
        assert!(result.is_err());
    }
}
