//! What drawing asks for but a frame has no time for: a thread computes it, the window goes on.

use std::sync::Arc;

use crate::work::{Job, Outcome};

/// The newest value, of the newest question.
pub struct Deferred<K, T> {
    key: Option<K>,
    job: Option<Job<T>>,
    answer: Option<Result<Arc<T>, String>>,
}

impl<K, T> Default for Deferred<K, T> {
    fn default() -> Self {
        Deferred { key: None, job: None, answer: None }
    }
}

impl<K: PartialEq, T: Send + 'static> Deferred<K, T> {
    /// The answer to a question; `None` until it is known. `compute` runs only for a new question.
    pub fn get(
        &mut self,
        ctx: &egui::Context,
        key: K,
        compute: impl FnOnce() -> Result<T, String> + Send + 'static,
    ) -> Option<Result<Arc<T>, String>> {
        if self.key.as_ref() != Some(&key) {
            let context = ctx.clone();
            let wake = move || context.request_repaint();
            let job = Job::spawn("derive", wake, move |_| compute());
            *self = Deferred { key: Some(key), job: Some(job), answer: None };
        }
        self.poll();
        self.answer.clone()
    }

    /// Receives the answer, also while nobody asks for it.
    pub fn poll(&mut self) {
        if let Some(outcome) = self.job.as_mut().and_then(Job::poll) {
            self.job = None;
            self.answer = Some(match outcome {
                Outcome::Done(value) => Ok(Arc::new(value)),
                Outcome::Failed(reason) | Outcome::Stopped(reason) | Outcome::Panicked(reason) => Err(reason),
            });
        }
    }

    /// Whether the thread is at work.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }
}
