//! Torquescope: compare a robot arm's dynamics model with measurements, see where it fails, learn which physical effect is
//! missing, add it, and watch the error fall.
//!
//! The folders follow that argument; a module imports only from floors below its own (`tests/architecture.rs` checks it):
//!
//! | floor | module | what lives there |
//! |---|---|---|
//! | 10 | [`cli`] | the command line; opens the window |
//! | 9 | [`selftest`] | the program tries to break itself, and counts |
//! | 8 | [`app`] | the window |
//! | 7 | [`lesson`] | what is asked of a student, judged by the session alone |
//! | 6 | [`session`], [`work`], [`experiment`], [`trial`], [`export`] | the document and its commands; background jobs; data × models × seeds, resumable; how often the diagnosis is right; models as code, in robot files, as weights; recordings and torques as tables |
//! | 5 | [`simulation`], [`training`], [`diagnosis`] | recordings made from arms and effects; learning; what is missing |
//! | 4 | [`model`] | a model is a sum of torque terms; identification by least squares |
//! | 3 | [`effect`] | one file per physical effect |
//! | 2 | [`recording`] | what was measured: read, map, check, derive, split, write |
//! | 1 | [`arm`], [`network`], [`figure`] | the planar arm in closed form; networks with derivatives; figures as data and as files |
//! | 0 | [`signals`], [`statistics`], [`progress`], [`mod@file`] | one value per joint and sample; ends, medians, noise; what work tells and how it is stopped; files are written whole and read through one door |
//!
//! The way of the data: bytes → [`recording::Recording`] → split → [`model::Model`] → torques by term → screen, file or
//! [`diagnosis`], which names what the model lacks; adding it is one undoable [`session`] command:
//!
//! ```
//! use torquescope::prelude::*;
//!
//! let monitor = Monitor::new();
//! // Or `Command::open(vec!["log.csv".into()], ReadOptions::default(), HoldOut::default())`.
//! let simulate = Command::Simulate(Box::new(Scenario::embedded()));
//! let simulated = simulate.run(&Session::default(), &monitor)?;
//! let diagnosed = Command::Diagnose.run(&simulated, &monitor)?;
//! let report = diagnosed.report.as_ref().expect("it was diagnosed");
//! assert_eq!(report.effects[0].effect.id, "coulomb-friction");
//! # Ok::<(), torquescope::session::SessionError>(())
//! ```

pub mod app;
pub mod arm;
pub mod cli;
pub mod diagnosis;
pub mod effect;
pub mod experiment;
pub mod export;
pub mod figure;
pub mod file;
pub mod lesson;
pub mod model;
pub mod network;
pub mod progress;
pub mod recording;
pub mod selftest;
pub mod session;
pub mod signals;
pub mod simulation;
pub mod statistics;
pub mod training;
pub mod trial;
pub mod work;

/// What most programs that use the library need: `use torquescope::prelude::*;`.
pub mod prelude {
    pub use crate::arm::{Arm, Posture};
    pub use crate::diagnosis::{Report, Verdict};
    pub use crate::model::{Evaluation, Fitted, Model, Preset};
    pub use crate::progress::Monitor;
    pub use crate::recording::hold_out::HoldOut;
    pub use crate::recording::read::ReadOptions;
    pub use crate::recording::split::Split;
    pub use crate::recording::{Recording, joints_text};
    pub use crate::session::{Command, Session};
    pub use crate::simulation::{Excitation, Scenario, simulate};
    pub use crate::training::fit::Plan;
}
