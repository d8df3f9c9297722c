//! Lessons: *puzzle → predict → act → reveal → say why → changed case*, on the same screens that real work is done on.
//!
//! A lesson is data: a file says its steps and what they ask, another one, beside it and in one language, what is read ([`mod@file`]).
//! What a student has is drawn by a seed (`case`). What a step asks for is one of a small closed set: a choice, a number, a state of
//! the arm, or [`Wish`]es that the session has to fulfil, which look at the session alone and never at what was clicked. [`act()`] says
//! by which [`Command`](crate::session::Command) the lesson goes on; the journal in the session ([`crate::session::study`]) is all that
//! is kept, and a [`Course`] is that journal read again. So is the [`grade`]: nobody types it, and free text is never judged.

mod act;
mod case;
pub mod catalogue;
mod course;
pub mod file;
pub mod grade;
mod number;
mod pose;
#[cfg(test)]
mod tests;
mod wish;

pub use act::{Act, Acted, LessonError, act, begin, right_answer};
pub use course::{Course, Progress, Revealed};
pub use file::{Asked, Choice, Lesson, LessonFileError, Offer, Right, Stage, Step, StepText, Task};
pub use number::Number;
pub use pose::{Parts, PoseWish};
pub use wish::Wish;
