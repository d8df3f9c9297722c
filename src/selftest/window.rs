//! Works in the window, which has no display, in a process of its own: one that can be killed, and whose memory is its own.
//!
//! The process writes what it does line by line; who started it reads them, after its death if need be.

use std::io::Write;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{SelftestError, memory, seeds};
use crate::app::hand::Hand;
use crate::app::{Locks, Order};
use crate::effect::registry;
use crate::file;
use crate::model::learned::{Layers, LearnedPreset};
use crate::progress::Monitor;
use crate::session::{self, Command, Session, Step};
use crate::training::Options;
use crate::training::fit::Plan;
use crate::work;

/// What is done in the window.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Task {
    /// A session is worked on, with copies in a folder, until the process is killed.
    Work {
        /// Where the copies are.
        copies: Copies,
        /// Of what is done.
        seed: u64,
    },
    /// What a killed window left is taken up.
    GoOn {
        /// Where the copies are.
        copies: Copies,
    },
    /// A recording is opened, worked on and clicked through at random, over and over, until the process is killed.
    Endure {
        /// The recording.
        log: PathBuf,
        /// Of what is done.
        seed: u64,
    },
}

/// Where recovery copies are.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Copies {
    /// The folder.
    pub folder: PathBuf,
    /// Whether files can be locked there.
    pub can_lock: bool,
}

impl FromStr for Task {
    type Err = serde_json::Error;

    fn from_str(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }
}

/// What the process says, a line each; times are of the clock \[s since 1970\].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Said {
    /// The session is another one since then.
    State {
        /// When.
        at: f64,
        /// Which: the same session has the same words.
        state: String,
        /// Those that other recordings took the place of before they were saved.
        left: Vec<String>,
    },
    /// A frame is over; what came to be in it is said.
    Frame {
        /// When.
        at: f64,
    },
    /// A training is so far.
    Epoch {
        /// When.
        at: f64,
        /// So many epochs are done.
        epoch: u64,
    },
    /// A killed window was taken up.
    WentOn {
        /// So many copies were offered.
        offers: usize,
        /// What the newest holds.
        state: Option<String>,
        /// What the others hold.
        others: Vec<String>,
        /// When that was written.
        written: Option<f64>,
        /// So many epochs has the training that can go on.
        epoch: Option<u64>,
    },
    /// A recording was opened, worked on and clicked through.
    Round {
        /// CPU time of the window's thread in each frame \[ms\].
        frames_ms: Vec<f32>,
        /// Resident memory \[bytes\], where the system tells.
        memory: Option<u64>,
        /// Panics since the process began.
        panics: usize,
    },
}

/// What the clock says \[s since 1970\].
pub fn clock() -> f64 {
    since_1970(SystemTime::now())
}

fn since_1970(time: SystemTime) -> f64 {
    time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}

fn say(said: &Said) -> Result<(), SelftestError> {
    let mut output = std::io::stdout().lock();
    writeln!(output, "{}", serde_json::to_string(said).map_err(std::io::Error::from)?)?;
    Ok(output.flush()?)
}

/// Is that process.
///
/// # Errors
/// If the window can't be worked in, or nobody listens any more.
pub fn serve(task: &Task) -> Result<(), SelftestError> {
    match task {
        Task::Work { copies, seed } => toil(copies, *seed),
        Task::GoOn { copies } => go_on(copies),
        Task::Endure { log, seed } => endure(log, *seed),
    }
}

impl Said {
    /// What was offered beside the newest copy.
    pub fn others(&self) -> &[String] {
        if let Said::WentOn { others, .. } = self { others } else { &[] }
    }
}

/// What a session is, in a few letters: its recording, its models and what was found.
fn state(session: &Session) -> String {
    let name = session.recording.as_ref().map(|recording| &recording.name);
    // An interval without an end is none in a file.
    let values = |step: &Step| step.fitted.parameters.iter().map(|found| found.value).collect::<Vec<f64>>();
    let ladder: Vec<_> = session.ladder.iter().map(|step| (&step.name, values(step))).collect();
    let found = session.report.as_ref().map(|report| report.effects.len());
    let text = format!("{:?}", (name, ladder, session.models.len(), found));
    Sha256::digest(text.as_bytes()).iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

fn plan(epochs: u64) -> Box<Plan> {
    let options = Options { epochs, batch: 32, ..Options::ours() };
    Box::new(Plan { options, layers: Layers { hidden: vec![8], ..Layers::default() }, ..Plan::default() })
}

/// A window in which every frame is drawn that somebody would see.
struct Window {
    hand: Hand,
    random: ChaCha8Rng,
}

impl Window {
    fn new(copies: Option<&Copies>, seed: u64) -> Self {
        let locks = |can_lock: bool| if can_lock { Locks::default() } else { Locks::none() };
        let copies = copies.map(|copies| (copies.folder.clone(), locks(copies.can_lock)));
        Window { hand: Hand::new(copies), random: ChaCha8Rng::seed_from_u64(seed) }
    }

    fn frame(&mut self) -> Result<f64, SelftestError> {
        self.hand.frame().map_err(|error| SelftestError::Window(format!("{error:#}")))
    }

    /// Frames until something is so.
    fn until(&mut self, is_so: impl Fn(&Hand) -> bool) -> Result<(), SelftestError> {
        loop {
            self.frame()?;
            if is_so(&self.hand) {
                return Ok(());
            }
            work::pause();
        }
    }

    /// What somebody may do next with a session.
    fn whim(&mut self) -> Order {
        let joints = self.hand.session().recording.as_ref().map_or(1, |recording| recording.joint_count());
        let effects: Vec<_> = registry::addable().collect();
        let effect = effects.choose(&mut self.random).map_or(String::new(), |effect| effect.id.to_owned());
        match self.random.random_range(0..10) {
            0..4 => Order::run(Command::AddEffect { effect, joints: vec![self.random.random_range(0..joints)] }),
            4 => Order::Undo,
            5 => Order::Redo,
            6 => Order::run(Command::Diagnose),
            7 => Order::run(Command::TrainPreset { preset: LearnedPreset::FfNn, plan: plan(20) }),
            // Longer than the window lives.
            8 => Order::run(Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: plan(1_000_000) }),
            _ => Order::run(Command::Simulate(Box::new(seeds::scenario(self.random.random_range(0..1000))))),
        }
    }
}

/// How often a training says how far it is \[s\].
const EVERY_S: f64 = 0.1;
/// So long somebody thinks at most before the next order.
const THINKS: Duration = Duration::from_millis(500);

/// Works until this process is killed, and says each session that there is from then on.
fn toil(copies: &Copies, seed: u64) -> Result<(), SelftestError> {
    let mut window = Window::new(Some(copies), seed);
    window.hand.order(Order::run(Command::Simulate(Box::new(seeds::scenario(seed)))));
    let (mut generation, mut last_epoch) = (window.hand.session().generation, (0, 0.0));
    let mut next = Instant::now();
    loop {
        window.frame()?;
        if window.hand.session().generation != generation {
            generation = window.hand.session().generation;
            // Of an empty window nothing is kept, and nothing is lost.
            if window.hand.session().recording.is_some() {
                let left = window.hand.left().iter().map(state).collect();
                say(&Said::State { at: clock(), state: state(window.hand.session()), left })?;
            }
        }
        match window.hand.epoch() {
            Some(epoch) if epoch != last_epoch.0 && clock() - last_epoch.1 > EVERY_S => {
                last_epoch = (epoch, clock());
                say(&Said::Epoch { at: last_epoch.1, epoch })?;
            }
            _ => (),
        }
        say(&Said::Frame { at: clock() })?;
        if window.hand.is_at_work() {
            next = Instant::now() + THINKS.mul_f64(window.random.random_range(0.0..1.0));
        } else if Instant::now() >= next {
            let is_empty = window.hand.session().recording.is_none();
            let order = if is_empty { Order::Redo } else { window.whim() };
            window.hand.order(order);
        }
        work::pause();
    }
}

/// Takes up the newest of what was left.
fn go_on(copies: &Copies) -> Result<(), SelftestError> {
    let mut window = Window::new(Some(copies), 0);
    window.frame()?;
    let offers: Vec<PathBuf> = window.hand.offers().into_iter().map(PathBuf::from).collect();
    let written = offers.first().and_then(|newest| file::written(newest)).map(since_1970);
    if let Some(newest) = offers.first() {
        window.hand.order(Order::Recover(newest.clone()));
        window.until(|hand| !hand.is_busy())?;
    }
    let session = window.hand.session();
    let newest = session.recording.is_some().then(|| state(session));
    // What can't be opened is told like a session that never was.
    let holds = |path: &PathBuf| match session::file::open(path, &Monitor::new()) {
        Ok(opened) => state(opened.document.history.current()),
        Err(error) => error.to_string(),
    };
    let others = offers.iter().skip(1).map(holds).collect();
    say(&Said::WentOn { offers: offers.len(), state: newest, others, written, epoch: window.hand.offered_epoch() })
}

/// So often somebody clicks at random before the recording is opened anew.
const FIDGETS: usize = 60;

/// Rounds until this process is killed: a recording is opened, gets an effect and networks, and is clicked through meanwhile.
fn endure(log: &std::path::Path, seed: u64) -> Result<(), SelftestError> {
    let panics = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&panics);
    std::panic::set_hook(Box::new(move |panic| {
        count.fetch_add(1, Ordering::Relaxed);
        // Who measures shows it.
        eprintln!("{panic}");
    }));
    let mut window = Window::new(None, seed);
    loop {
        let mut frames = Vec::new();
        for order in [
            Order::open(vec![log.to_owned()]),
            Order::run(Command::AddEffect { effect: first_effect(), joints: vec![0] }),
            Order::run(Command::TrainPreset { preset: LearnedPreset::StructuredDelan, plan: plan(4) }),
        ] {
            window.hand.order(order);
            for _ in 0..FIDGETS {
                let shown = window.hand.fidget(&mut window.random);
                frames.extend(shown.map_err(|error| SelftestError::Window(format!("{error:#}")))?);
            }
            // What was begun by a click may take hours.
            window.hand.order(Order::Stop);
            window.until(|hand| !hand.is_at_work())?;
        }
        let frames_ms = frames.into_iter().map(|seconds| 1e3 * seconds as f32).collect();
        say(&Said::Round { frames_ms, memory: memory::now(), panics: panics.load(Ordering::Relaxed) })?;
    }
}

fn first_effect() -> String {
    registry::addable().next().map_or(String::new(), |effect| effect.id.to_owned())
}
