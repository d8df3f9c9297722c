//! Everything that changes a session, as values: the window and the command line send the same ones. What each does is in
//! `carry_out`.

use std::path::PathBuf;
use std::sync::Arc;

use super::study::{Lock, Note, SetUp};
use super::terms::{self, TermEdit};
use super::{Guess, Origin, Session, Source, Step, Study, default_name, file};
use crate::effect::registry;
use crate::model::learned::LearnedPreset;
use crate::model::{Model, Preset};
use crate::recording::correction::Correction;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::ReadOptions;
use crate::simulation::extrapolation::Stretch;
use crate::simulation::{Level, Scenario, world};
use crate::training::fit::{Plan, SavedRun};

/// A change of the session.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "there is one command at a time, so its size does not matter")]
pub enum Command {
    /// Reads files as one recording and fits the preset.
    Open {
        /// One or more files; each is a trajectory, or holds several.
        paths: Vec<PathBuf>,
        /// How to read them.
        options: ReadOptions,
        /// What to hold out.
        held_out: HoldOut,
    },
    /// Reads files as further trajectories of the recording, all held out, and holds every model against them; none is fitted anew.
    Beside {
        /// One or more files, read as the first were.
        paths: Vec<PathBuf>,
    },
    /// Sets right how the recording is set up, and fits the preset anew.
    SetRight(Vec<Correction>),
    /// Holds out another part of the recording, and identifies or trains the ladder anew.
    HoldOut(HoldOut),
    /// Opens a session that was saved.
    Restore {
        /// The file.
        path: PathBuf,
    },
    /// Puts everything away, as if nothing had been opened.
    BeginAnew,
    /// Simulates a recording and fits the preset.
    Simulate(Box<Scenario>),
    /// Lets a world of rigid bodies happen, and fits the preset to what was logged there.
    SimulateWorld(Box<world::Scenario>),
    /// Draws a mystery, simulates it and fits the preset.
    DrawMystery {
        /// How hard it is.
        level: Level,
        /// By which all of it is drawn.
        seed: u64,
    },
    /// Starts the ladder anew from another preset.
    ChoosePreset(Preset),
    /// Starts the ladder anew from a model with networks, trained by this plan.
    TrainPreset {
        /// Which.
        preset: LearnedPreset,
        /// How.
        plan: Box<Plan>,
    },
    /// Trains the current model anew, or on from where it is, by another plan.
    Train {
        /// How.
        plan: Box<Plan>,
        /// Whether the weights of the current model are where it begins.
        warm: bool,
    },
    /// Trains one model from several seeds; all are kept, the one with the smallest validation error is the current model then.
    TrainSeeds {
        /// What trains the first of them; without it, that is the current model.
        begin: Option<Box<Command>>,
        /// How many.
        seeds: u64,
    },
    /// Goes on with a training that was stopped, as if it had never been.
    Resume(Arc<SavedRun>),
    /// Makes one of the session's models the current one, with the ladder that led to it.
    TakeUp {
        /// Its name.
        name: String,
    },
    /// Gives one of the session's models another name.
    Rename {
        /// Its name.
        name: String,
        /// Its new name.
        to: String,
    },
    /// Takes a model out of the session.
    Delete {
        /// Its name.
        name: String,
    },
    /// Simulates the arm of every model of which that was not asked yet, and measures how far it runs from the recording.
    RollOut,
    /// Makes models beside the current one, to be compared with it.
    Make {
        /// Which.
        presets: Vec<Preset>,
    },
    /// Starts the ladder anew from a given model, its parameters identified from this recording.
    UseModel {
        /// The terms.
        model: Model,
    },
    /// Reads an effect of one's own, which is sought and offered from then on.
    LoadEffect {
        /// The file.
        path: PathBuf,
    },
    /// Asks what the current model lacks.
    Diagnose,
    /// Asks on what the remainder of the current model depends, and by which formula.
    Propose,
    /// Makes a proposal an effect of one's own and adds it.
    Adopt {
        /// Index into the proposals.
        proposal: usize,
    },
    /// Adds an effect and identifies all parameters anew.
    AddEffect {
        /// Its id in the registry.
        effect: String,
        /// The joints, counted from 0; ignored by effects of the whole arm.
        joints: Vec<usize>,
    },
    /// Takes a term out of the current model, switches it off or on, or moves it in the list.
    EditTerms(TermEdit),
    /// Computes how the error of these models grows outside the data.
    Extrapolate {
        /// The models.
        steps: Vec<Arc<Step>>,
        /// Faster or wider.
        stretch: Stretch,
    },
    /// Goes back to a step of the ladder; the later ones are dropped (undo brings them back).
    GoTo {
        /// Index into [`Session::ladder`].
        step: usize,
    },
    /// Shows the hidden truth.
    OpenSeal,
    /// Hides the answer of the diagnosis until one has guessed, or not.
    BetFirst(bool),
    /// Says what the current model lacks, before the answer is shown.
    PlaceBet(Guess),
    /// Begins a lesson, or goes on in it with another recording.
    SetUp(Box<SetUp>),
    /// Writes down what was done in the lesson.
    Learn(Vec<Note>),
}

impl Command {
    /// Opens these files as one recording, or a saved session if that is what they are.
    ///
    /// ```
    /// use torquescope::prelude::*;
    ///
    /// let log = Command::open(vec!["run-1.csv".into(), "run-2.csv".into()], ReadOptions::default(), HoldOut::default());
    /// assert_eq!(log.title(), "open run-1.csv and 1 more");
    /// let session = Command::open(vec!["mine.torquescope".into()], ReadOptions::default(), HoldOut::default());
    /// assert!(matches!(session, Command::Restore { .. }));
    /// ```
    pub fn open(mut paths: Vec<PathBuf>, options: ReadOptions, held_out: HoldOut) -> Self {
        if paths.len() == 1 && file::is_session(&paths[0]) {
            return Command::Restore { path: paths.remove(0) };
        }
        Command::Open { paths, options, held_out }
    }

    /// Where it takes its recording from; `None` if it brings none, or one of several.
    pub(super) fn source(&self) -> Option<Source> {
        let made = |origin| Source { origin, options: ReadOptions::default(), held_out: HoldOut::default() };
        match self {
            Command::Open { paths, options, held_out } => Some(Source {
                origin: Origin::Files(paths.clone()),
                options: options.clone(),
                held_out: held_out.clone(),
            }),
            Command::Simulate(scenario) => Some(made(Origin::Simulated(scenario.clone()))),
            Command::SimulateWorld(scenario) => Some(made(Origin::World(scenario.clone()))),
            Command::DrawMystery { level, seed } => Some(made(Origin::Mystery { level: *level, seed: *seed })),
            _ => None,
        }
    }

    /// What reads the files of a recording in another way, with the same held out; `None` if it was not read from any.
    pub fn read_again(source: &Source, options: ReadOptions) -> Option<Self> {
        let paths = source.files()?.to_vec();
        Some(Command::Open { paths, options, held_out: source.held_out.clone() })
    }

    /// What of a lesson keeps it from being carried out.
    pub fn locked_by(&self, study: &Study) -> Option<Lock> {
        let is_on = |lock: &Lock| match lock {
            Lock::Seal => matches!(self, Command::OpenSeal),
            Lock::Diagnosis => matches!(self, Command::Diagnose | Command::Propose),
            Lock::Effects => matches!(self, Command::AddEffect { .. } | Command::Adopt { .. }),
            Lock::Recordings => {
                let opens = matches!(self, Command::Open { .. } | Command::Beside { .. } | Command::HoldOut(_));
                let makes = matches!(self, Command::Simulate(_) | Command::SimulateWorld(_) | Command::BeginAnew);
                opens || makes || matches!(self, Command::DrawMystery { .. })
            }
        };
        study.locks().iter().copied().find(is_on)
    }

    /// What it does, for undo and for the status line.
    pub fn title(&self) -> String {
        match self {
            Command::Open { paths, .. } => {
                let name = paths.first().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
                if paths.len() > 1 {
                    format!("open {name} and {} more", paths.len() - 1)
                } else {
                    format!("open {name}")
                }
            }
            Command::Beside { paths } => {
                let name = paths.first().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
                format!("look at {name} beside it")
            }
            Command::SetRight(corrections) => {
                let texts: Vec<String> = corrections.iter().map(Correction::to_string).collect();
                format!("set right {}", texts.join(" "))
            }
            Command::HoldOut(HoldOut::Fifth(turn)) => format!("hold out fifth {}", turn + 1),
            Command::HoldOut(HoldOut::Trajectories(names)) => format!("hold out {}", names.join(", ")),
            Command::Restore { path } => {
                format!("open the session {}", path.file_name().unwrap_or_default().to_string_lossy())
            }
            Command::BeginAnew => "begin anew".to_owned(),
            Command::Simulate(_) => "simulate a recording".to_owned(),
            Command::SimulateWorld(_) => "simulate a world of rigid bodies".to_owned(),
            Command::DrawMystery { .. } => "draw a mystery".to_owned(),
            Command::ChoosePreset(preset) => format!("start from {}", preset.title()),
            Command::TrainPreset { preset, .. } => format!("train {}", preset.title()),
            Command::Train { warm, .. } => if *warm { "train on" } else { "train anew" }.to_owned(),
            Command::TrainSeeds { seeds, .. } => format!("train {seeds} seeds"),
            Command::Resume(_) => "resume training".to_owned(),
            Command::TakeUp { name } => format!("use {name}"),
            Command::Rename { name, to } => format!("rename {name} to {}", to.trim()),
            Command::Delete { name } => format!("delete {name}"),
            Command::RollOut => "simulate the models".to_owned(),
            Command::Make { presets } => {
                let names: Vec<&str> = presets.iter().map(|preset| preset.title()).collect();
                format!("make {}", names.join(", "))
            }
            Command::UseModel { model } => format!("start from {}", default_name(model)),
            Command::LoadEffect { path } => {
                format!("load the effect {}", path.file_name().unwrap_or_default().to_string_lossy())
            }
            Command::Diagnose => "diagnose".to_owned(),
            Command::Propose => "propose formulas".to_owned(),
            Command::Adopt { proposal } => format!("adopt proposal {}", proposal + 1),
            Command::AddEffect { effect, joints } => {
                let name = registry::find(effect).map_or(effect.clone(), |effect| terms::effect_text(effect, joints));
                format!("add {name}")
            }
            Command::EditTerms(edit) => edit.title().to_owned(),
            Command::Extrapolate { .. } => "extrapolate".to_owned(),
            Command::GoTo { step } => format!("go back to step {}", step + 1),
            Command::OpenSeal => "open the seal".to_owned(),
            Command::BetFirst(_) => "bet first".to_owned(),
            Command::PlaceBet(_) => "place a bet".to_owned(),
            Command::SetUp(wanted) => wanted.title(),
            Command::Learn(_) => "write into the lesson's journal".to_owned(),
        }
    }

    /// Whether what it gives is another document, which is in no file yet. A recording that is set right is still that recording.
    pub fn begins_anew(&self) -> bool {
        match self {
            Command::Open { .. } | Command::BeginAnew | Command::DrawMystery { .. } => true,
            Command::Simulate(_) | Command::SimulateWorld(_) => true,
            Command::SetUp(wanted) => wanted.begins.is_some(),
            _ => false,
        }
    }

    /// Whether undo can't take it back: what was seen was seen, and what was said was said.
    pub fn is_final(&self) -> bool {
        matches!(self, Command::OpenSeal | Command::BetFirst(_) | Command::PlaceBet(_) | Command::Learn(_))
    }

    /// Whether it trains networks, of whose epochs it then tells.
    pub fn trains(&self, session: &Session) -> bool {
        match self {
            Command::ChoosePreset(preset) => matches!(preset, Preset::Learned(_)),
            Command::TrainPreset { .. } | Command::Train { .. } | Command::TrainSeeds { .. } | Command::Resume(_) => {
                true
            }
            Command::Make { presets } => presets.iter().any(|preset| matches!(preset, Preset::Learned(_))),
            Command::UseModel { model } => model.is_learned(),
            Command::AddEffect { .. } | Command::Adopt { .. } | Command::EditTerms(_) | Command::HoldOut(_) => {
                session.current().is_some_and(|step| step.fitted.model.is_learned())
            }
            _ => false,
        }
    }

    /// The plan of the training that it begins, if it does.
    pub fn plan<'a>(&'a self, session: &'a Session) -> Option<&'a Plan> {
        match self {
            Command::TrainPreset { plan, .. } | Command::Train { plan, .. } => Some(plan),
            Command::TrainSeeds { begin: Some(begin), .. } => begin.plan(session),
            Command::Resume(run) => Some(&run.plan),
            _ => self.trains(session).then_some(&session.plan),
        }
    }

    /// Whether it takes less than a few milliseconds, so that no job is needed.
    pub fn is_quick(&self) -> bool {
        let is_of_models = matches!(self, Command::TakeUp { .. } | Command::Rename { .. } | Command::Delete { .. });
        let is_small = matches!(self, Command::BeginAnew | Command::GoTo { .. } | Command::LoadEffect { .. });
        self.is_final() || is_of_models || is_small
    }
}
