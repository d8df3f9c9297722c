//! What the screen of experiments knows: which one is shown, what its folder holds, and the run that is at work.

use std::collections::HashSet;
use std::sync::Arc;

use crate::app::desk::Shown;
use crate::experiment::run::{State, state};
use crate::experiment::summary::{Curve, curves};
use crate::experiment::{Experiment, ExperimentError, Report, Row, Shard, plan, run, summarise};
use crate::progress::{Event, Monitor, Progress};
use crate::work::{Job, Outcome};

/// What the folder holds of an experiment.
pub struct Joined {
    /// The experiment.
    pub experiment: Experiment,
    /// State of each cell: model, seed, where it stands.
    pub cells: Vec<(String, u64, State)>,
    /// Means over the seeds that are done.
    pub rows: Vec<Row>,
    /// The curves among them.
    pub curves: Vec<Curve>,
}

/// Reads the folder.
pub fn join(shown: &Shown) -> Result<Joined, ExperimentError> {
    let experiment = shown.open()?;
    let store = shown.store();
    // Without its recordings an experiment can still be described.
    let planned = match plan(&experiment, shown.data().as_deref()) {
        Err(ExperimentError::NoData { .. }) => Vec::new(),
        planned => planned?,
    };
    let where_it_stands = |cell| -> Result<State, ExperimentError> { state(&store, cell) };
    let cells = planned
        .iter()
        .map(|cell| Ok((cell.model.name.clone(), cell.seed, where_it_stands(cell)?)))
        .collect::<Result<Vec<_>, ExperimentError>>()?;
    let rows = summarise(&experiment, &planned, &store)?;
    Ok(Joined { curves: curves(&rows), experiment, cells, rows })
}

/// What became of the last run.
pub enum Said {
    /// Good news, or neither.
    Plain(String),
    /// It failed.
    Failed(String),
}

/// The screen's memory.
#[derive(Default)]
pub struct Trials {
    /// What the controls say.
    pub shown: Shown,
    /// Models that are left out of a run and of the pictures.
    pub left_out: HashSet<String>,
    /// Which quantity the table shows, as an index.
    pub quantity: usize,
    /// Which curve is drawn.
    pub curve: usize,
    /// Where on it one looks.
    pub cursor: Option<f64>,
    /// The newest reading.
    pub joined: Option<Arc<Joined>>,
    /// Why there is none, or what became of the last run.
    pub said: Option<Said>,
    /// What the newest reading is of: the choice, and how many cells were done.
    read: Option<(Shown, usize)>,
    /// Whether the folder is to be read although nothing of that changed.
    again: bool,
    reading: Option<Job<Joined>>,
    running: Option<Running>,
    /// Counts the cells that were done since the window was opened.
    done: usize,
}

struct Running {
    job: Job<Report>,
    stopping: bool,
}

impl Trials {
    /// The same without what is at work.
    pub fn without_jobs(&self) -> Self {
        let (shown, left_out, joined) = (self.shown.clone(), self.left_out.clone(), self.joined.clone());
        Trials { shown, left_out, quantity: self.quantity, curve: self.curve, joined, ..Trials::default() }
    }

    /// Whether a run or a reading is at work.
    pub fn is_busy(&self) -> bool {
        self.reading.is_some() || self.running.is_some()
    }

    /// Progress of the run, and whether it was asked to stop.
    pub fn progress(&self) -> Option<(Progress, bool)> {
        self.running.as_ref().map(|running| (running.job.progress(), running.stopping))
    }

    /// Reads the folder anew if it is not what is shown.
    pub fn look(&mut self, ctx: &egui::Context) {
        let wanted = (self.shown.clone(), self.done);
        if self.reading.is_some() || (self.read.as_ref() == Some(&wanted) && !self.again) {
            return;
        }
        if self.read.as_ref().is_none_or(|(shown, _)| *shown != wanted.0) {
            // What was said, left out and looked at there concerns another experiment.
            (self.joined, self.cursor, self.said, self.curve) = (None, None, None, 0);
            self.left_out.clear();
        }
        let (shown, context) = (wanted.0.clone(), ctx.clone());
        (self.read, self.again) = (Some(wanted), false);
        let wake = move || context.request_repaint();
        self.reading = Some(Job::spawn("read results", wake, move |_: &Monitor| join(&shown)));
    }

    /// Reads the folder anew, since other processes may have written there.
    pub fn look_again(&mut self) {
        self.again = true;
    }

    /// Runs what the folder lacks, as `experiment run` does.
    pub fn run(&mut self, ctx: &egui::Context) {
        let Some(joined) = self.joined.clone().filter(|_| self.running.is_none()) else { return };
        let all = joined.experiment.models.iter().map(|model| model.name.clone());
        let chosen: Vec<String> = all.filter(|name| !self.left_out.contains(name)).collect();
        let (experiment, store, data) = (joined.experiment.clone(), self.shown.store(), self.shown.data());
        let context = ctx.clone();
        let wake = move || context.request_repaint();
        let job = Job::spawn("experiment", wake, move |monitor| {
            run(&experiment.only(&chosen)?, &store, data.as_deref(), Shard::default(), monitor)
        });
        self.said = None;
        self.running = Some(Running { job, stopping: false });
    }

    /// Asks the run to stop; what is done stays, and the next run goes on from there.
    pub fn stop(&mut self) {
        if let Some(running) = &mut self.running {
            running.job.finish("you pressed Stop");
            running.stopping = true;
        }
    }

    /// Receives what the jobs have.
    pub fn poll(&mut self) {
        if let Some(outcome) = self.reading.as_mut().and_then(Job::poll) {
            self.reading = None;
            match outcome {
                Outcome::Done(joined) => self.joined = Some(Arc::new(joined)),
                Outcome::Stopped(_) => (),
                Outcome::Failed(message) | Outcome::Panicked(message) => self.said = Some(Said::Failed(message)),
            }
        }
        let Some(running) = &mut self.running else { return };
        let is_cell = |event: &Event| matches!(event, Event::Done(_));
        self.done += running.job.events().iter().filter(|event| is_cell(event)).count();
        let Some(outcome) = running.job.poll() else { return };
        let stopping = self.running.take().is_some_and(|running| running.stopping);
        self.look_again();
        self.said = Some(match outcome {
            Outcome::Done(report) => told(&report),
            Outcome::Failed(_) | Outcome::Stopped(_) if stopping => {
                Said::Plain("Stopped. Cells that are done stay; Run goes on with the others.".to_owned())
            }
            Outcome::Failed(message) | Outcome::Stopped(message) => Said::Failed(message),
            Outcome::Panicked(message) => Said::Failed(format!("a defect of the program ended the run: {message}")),
        });
    }
}

fn told(report: &Report) -> Said {
    let Report { found, done, elsewhere, failed, damaged } = report;
    let mut text = format!("{done} cells done, {found} were there before");
    if let Some(first) = damaged.first() {
        text += &format!(", {} damaged files were done again; the first: {first}", damaged.len());
    }
    if *elsewhere > 0 {
        text += &format!(", {elsewhere} are being done by another process");
    }
    match failed.first() {
        None => Said::Plain(text + "."),
        Some((model, seed, reason)) => {
            let count = failed.len();
            Said::Failed(format!("{text}, {count} could not be done; the first: {model}, seed {}: {reason}", seed + 1))
        }
    }
}
