//! What is derived from the session for drawing: computed when somebody asks for it, kept while the session stays as it is.
//!
//! A question is a small value that says what is asked and how it is answered. What takes more than a few milliseconds is
//! answered by a thread, and the window goes on meanwhile.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::Arc;

use super::plot::Decimator;
use crate::session::{Generation, Session};
use crate::work::{Job, Outcome};

/// What can be asked of a session.
pub trait Question: Clone + PartialEq + Send + 'static {
    /// What is drawn.
    type Answer: Send + Sync + 'static;
    /// How many answers are kept; the newest are.
    const KEPT: usize = 64;

    /// The answer.
    ///
    /// # Errors
    /// Why there is none, in words for people.
    fn answer(&self, session: &Session) -> Result<Self::Answer, String>;
}

/// What a question was answered with.
pub type Answer<Q> = Result<Arc<<Q as Question>::Answer>, String>;

/// All answers of one generation of the session.
#[derive(Default)]
pub struct Memo {
    generation: Option<Generation>,
    /// By the type of the question: [`Asked`] of that type.
    asked: HashMap<TypeId, Box<dyn Pending>>,
    /// Lines as they were thinned for the screen.
    pub decimator: Decimator,
}

/// The questions of one type, newest last.
struct Asked<Q: Question>(Vec<(Q, State<Q>)>);

enum State<Q: Question> {
    Working(Job<Q::Answer>),
    Known(Answer<Q>),
}

impl Memo {
    /// Keeps to a session: what was derived from another one is forgotten.
    pub fn keep_to(&mut self, session: &Session) {
        if self.generation != Some(session.generation) {
            *self = Memo { generation: Some(session.generation), ..Memo::default() };
        }
    }

    /// The answer to a question that takes no longer than a few milliseconds.
    pub fn now<Q: Question>(&mut self, session: &Session, question: Q) -> Answer<Q> {
        self.of_type(session, |asked: &mut Asked<Q>| {
            if let Some(State::Known(answer)) = asked.state_of(&question) {
                return answer.clone();
            }
            let answer = question.answer(session).map(Arc::new);
            asked.put(question, State::Known(answer.clone()));
            answer
        })
    }

    /// The answer to a question that may take longer; `None` until a thread has it.
    pub fn later<Q: Question>(&mut self, ctx: &egui::Context, session: &Session, question: Q) -> Option<Answer<Q>> {
        self.of_type(session, |asked: &mut Asked<Q>| match asked.state_of(&question) {
            Some(State::Known(answer)) => Some(answer.clone()),
            Some(State::Working(_)) => None,
            None => {
                let (context, session, own) = (ctx.clone(), session.clone(), question.clone());
                let wake = move || context.request_repaint();
                let job = Job::spawn("derive", wake, move |_| own.answer(&session));
                asked.put(question, State::Working(job));
                None
            }
        })
    }

    /// Receives what the threads have, also while nobody asks for it.
    pub fn poll(&mut self) {
        self.asked.values_mut().for_each(|asked| asked.poll());
    }

    /// Whether a thread is at work.
    pub fn is_busy(&self) -> bool {
        self.asked.values().any(|asked| asked.is_busy())
    }

    /// Works with the questions of one type.
    fn of_type<Q: Question, T>(&mut self, session: &Session, work: impl FnOnce(&mut Asked<Q>) -> T) -> T {
        self.keep_to(session);
        let kept = self.asked.remove(&TypeId::of::<Q>());
        let kept = kept.and_then(|kept| (kept as Box<dyn Any>).downcast::<Asked<Q>>().ok());
        let mut asked = kept.unwrap_or_else(|| Box::new(Asked(Vec::new())));
        let result = work(&mut asked);
        self.asked.insert(TypeId::of::<Q>(), asked);
        result
    }
}

impl<Q: Question> Asked<Q> {
    fn state_of(&self, question: &Q) -> Option<&State<Q>> {
        self.0.iter().find(|(known, _)| known == question).map(|(_, state)| state)
    }

    fn put(&mut self, question: Q, state: State<Q>) {
        self.0.retain(|(known, _)| *known != question);
        let spare = (self.0.len() + 1).saturating_sub(Q::KEPT);
        self.0.drain(..spare);
        self.0.push((question, state));
    }
}

/// Questions of any type.
trait Pending: Any {
    fn poll(&mut self);
    fn is_busy(&self) -> bool;
}

impl<Q: Question> Pending for Asked<Q> {
    fn poll(&mut self) {
        for (_, state) in &mut self.0 {
            if let State::Working(job) = state
                && let Some(outcome) = job.poll()
            {
                *state = State::Known(match outcome {
                    Outcome::Done(value) => Ok(Arc::new(value)),
                    Outcome::Failed(reason) | Outcome::Stopped(reason) | Outcome::Panicked(reason) => Err(reason),
                });
            }
        }
    }

    fn is_busy(&self) -> bool {
        self.0.iter().any(|(_, state)| matches!(state, State::Working(_)))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    use super::*;

    static ANSWERED: AtomicUsize = AtomicUsize::new(0);

    #[derive(Clone, PartialEq)]
    struct Square(u64);

    impl Question for Square {
        type Answer = u64;
        const KEPT: usize = 2;

        fn answer(&self, _: &Session) -> Result<u64, String> {
            ANSWERED.fetch_add(1, Ordering::SeqCst);
            Ok(self.0 * self.0)
        }
    }

    #[derive(Clone, PartialEq)]
    struct Riddle;

    impl Question for Riddle {
        type Answer = u64;

        fn answer(&self, _: &Session) -> Result<u64, String> {
            Err("nobody knows".to_owned())
        }
    }

    #[derive(Clone, PartialEq)]
    struct Title;

    impl Question for Title {
        type Answer = String;

        fn answer(&self, session: &Session) -> Result<String, String> {
            Ok(format!("{:?}", session.generation))
        }
    }

    fn wait<Q: Question>(memo: &mut Memo, session: &Session, question: Q) -> Answer<Q> {
        let (ctx, begin) = (egui::Context::default(), Instant::now());
        loop {
            if let Some(answer) = memo.later(&ctx, session, question.clone()) {
                return answer;
            }
            assert!(begin.elapsed() < Duration::from_secs(10), "the thread never ended");
            crate::work::pause();
            memo.poll();
        }
    }

    #[test]
    fn an_answer_is_computed_once_for_each_generation() {
        let (mut memo, session) = (Memo::default(), Session::default());
        let asked = |memo: &mut Memo, session: &Session| {
            let before = ANSWERED.load(Ordering::SeqCst);
            assert_eq!(memo.now(session, Square(3)).as_deref(), Ok(&9));
            ANSWERED.load(Ordering::SeqCst) - before
        };
        assert_eq!([asked(&mut memo, &session), asked(&mut memo, &session)], [1, 0]);
        let same = session.clone();
        assert_eq!(asked(&mut memo, &same), 0, "a copy of a session is that session");
        let changed = Session::default();
        assert_eq!([asked(&mut memo, &changed), asked(&mut memo, &session)], [1, 1], "each change forgets");
        // Only the newest two are kept.
        assert_eq!(memo.now(&session, Square(4)).as_deref(), Ok(&16));
        assert_eq!(memo.now(&session, Square(5)).as_deref(), Ok(&25));
        assert_eq!(asked(&mut memo, &session), 1);
    }

    #[test]
    fn a_thread_answers_and_says_why_if_it_can_not() {
        let (mut memo, session) = (Memo::default(), Session::default());
        assert_eq!(wait(&mut memo, &session, Title).as_deref(), Ok(&format!("{:?}", session.generation)));
        let other = Session::default();
        assert_eq!(wait(&mut memo, &other, Title).as_deref(), Ok(&format!("{:?}", other.generation)));
        assert_eq!(wait(&mut memo, &other, Riddle), Err("nobody knows".to_owned()));
        assert!(!memo.is_busy());
    }
}
