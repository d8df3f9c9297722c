//! What the window knows beside the session: where one looks, and what was derived for drawing.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::{Arc, Weak};

use super::deferred::Deferred;
use super::dock::{Change, Dock};
use super::plot::{Along, Cells, Decimator, Views};
use super::screens::Screen;
use super::screens::TorquePart;
use super::screens::experiment::{Shown, Trials};
use super::screens::residuals::{Brush, Looking, Quantity, Spectra, Table};
use super::shell::{CommandPalette, Exporting};
use crate::arm::Arm;
use crate::figure::{Figure, Format, Style};
use crate::model::Preset;
use crate::progress::Progress;
use crate::recording::read::ReadOptions;
use crate::recording::{Recording, spectrum};
use crate::session::{Command, Session, Step, file};
use crate::signals::Signals;
use crate::simulation::extrapolation::{Replay, Stretch};
use crate::simulation::{Excitation, Scenario};
use crate::training::Epoch;
use crate::training::fit::Plan;

/// What a click asks for; carried out before the next frame.
#[derive(Debug, Clone)]
pub enum Order {
    /// Change the session.
    Run(Box<Command>),
    /// Show a screen.
    Show(Screen),
    /// Take back the last change.
    Undo,
    /// Do it again.
    Redo,
    /// Stop the running job; nothing of it is kept.
    Stop,
    /// Let the running job end with what it has.
    Finish,
    /// Let the running job wait, or go on.
    Pause(bool),
    /// Between light and dark.
    ToggleTheme,
    /// Simulate an arm whose hidden effect is drawn by the next seed.
    DrawMystery,
    /// Save the session into this file.
    Save(PathBuf),
    /// Let the user choose where to save.
    SaveDialog,
    /// Open the copy that another run left behind, or leave it.
    Recover(bool),
    /// Let the user choose files.
    OpenDialog,
    /// More contrast, or as usual.
    HighContrast(bool),
    /// Between high and usual contrast.
    ToggleContrast,
    /// Size of text and everything else, 0.8 to 2.
    TextScale(f32),
    /// Open or close the command palette.
    Palette(bool),
    /// Open or close the list of shortcuts.
    KeyList(bool),
    /// Look at the results of an experiment.
    Experiment(Shown),
    /// Ask how to export the plots of the screen, or the one of this title.
    Export(Option<String>),
    /// Let the user choose where to export.
    ExportDialog,
    /// Write plots into a file.
    Draw(Box<Drawing>),
    /// Show, hide or move a panel of the screen.
    Panel(String, Change),
    /// The focus goes to the next panel.
    NextPanel,
    /// Put the panels of the screen back where they stood at first.
    ResetPanels,
    /// All charts show everything.
    FitAll,
    /// Remove a message.
    Dismiss(usize),
}

/// Plots, and the file that shows them.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// What is drawn.
    pub figure: Figure,
    /// As what.
    pub format: Format,
    /// How.
    pub style: Style,
    /// Where.
    pub path: PathBuf,
}

impl Order {
    /// Change the session.
    pub fn run(command: Command) -> Self {
        Order::Run(Box::new(command))
    }

    /// Open these files as one recording, or a saved session.
    pub fn open(mut paths: Vec<PathBuf>) -> Self {
        if paths.len() == 1 && paths[0].extension().is_some_and(|ending| ending == file::ENDING) {
            return Order::run(Command::Restore { path: paths.remove(0) });
        }
        Order::run(Command::Open { paths, options: ReadOptions::default(), held_out: Vec::new() })
    }
}

/// How serious a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tone {
    Info,
    Warning,
    Error,
}

/// A message that stays until it is dismissed.
#[derive(Debug, Clone)]
pub(super) struct Notice {
    pub tone: Tone,
    pub text: String,
    pub remedy: String,
}

impl Notice {
    pub fn new(tone: Tone, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Notice { tone, text: text.into(), remedy: remedy.into() }
    }
}

/// What was just done; it passes.
#[derive(Debug, Clone)]
pub(super) struct Toast {
    pub text: String,
    /// When it goes \[s, in the window's time\].
    pub until: f64,
}

/// Which effect is to be added, as set in the panel of the model.
#[derive(Debug, Clone, Default)]
pub(super) struct Addition {
    /// Index into the registry.
    pub effect: usize,
    pub joints: Vec<bool>,
}

/// Where one stands on the screen of extrapolation.
#[derive(Debug, Clone, Default)]
pub(super) struct Outside {
    pub stretch: Stretch,
    /// The shown joint; `None` for all together.
    pub joint: Option<usize>,
    /// The scale of the replay; the cursor of the curves.
    pub scale: Option<f64>,
    /// Titles of models that are not to be computed.
    pub left_out: Vec<usize>,
    pub cursor: Option<f64>,
    /// The newest replay, and what it is of.
    pub replay: Option<(ReplayKey, Arc<Replay>)>,
}

/// Trajectory, stretch, scale as bits, and the address of the model.
pub(super) type ReplayKey = (usize, Stretch, u64, usize);

/// How much of the torque a term carries on one joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Share {
    /// Its root mean square \[N m\].
    pub rms: f64,
    /// The same as a part of that of the measured torque.
    pub part: f64,
}

/// What to simulate, as set in the panel.
#[derive(Debug, Clone)]
pub(super) struct Wish {
    pub seed: u64,
    /// Index into the registry; `None` hides nothing.
    pub effect: Option<usize>,
    pub joints: Vec<bool>,
    pub arm: Arm,
    pub motion: Excitation,
    /// Steps of the encoders in a turn; 0 for exact positions.
    pub encoder_steps: u32,
    pub strength_percent: f64,
    pub noise_percent: f64,
}

/// What to train and how, as set in the panel.
#[derive(Debug, Clone, Default)]
pub(super) struct Training {
    pub preset: Preset,
    pub plan: Plan,
    /// The epoch whose values are shown.
    pub cursor: Option<f64>,
    /// How much of the smoothed curves is from earlier epochs, 0 for none.
    pub smoothing: f64,
    /// Earlier trainings whose curves are not drawn.
    pub unseen: HashSet<usize>,
}

/// What the views of the residual are drawn from, for one joint in the held-out part or not.
type TableKey = (usize, bool);

/// The rows that a brush lights, and in which table.
type Lit = (TableKey, Brush, Arc<Vec<usize>>);

/// Points of the way of the arm's tip.
const TIP_POINTS: usize = 400;

/// A guess before the answer is shown.
#[derive(Debug, Clone, Default)]
pub(super) struct Bet {
    /// Whether the answer is hidden until one has guessed.
    pub first: bool,
    /// What was guessed: the id of an effect, or [`Bet::NOTHING`] or [`Bet::UNKNOWN`].
    pub guess: Option<String>,
}

impl Bet {
    /// "Nothing is missing".
    pub const NOTHING: &'static str = "nothing";
    /// "None of these".
    pub const UNKNOWN: &'static str = "unknown";
}

/// What drawing asks of a trajectory in every frame, computed once.
pub(super) struct Facts {
    /// Largest torque of each joint.
    pub largest: Vec<f64>,
    /// Whether a term of the model acts on a joint at all: `acts[term][joint]`.
    pub acts: Vec<Vec<bool>>,
    /// Where the tip of the arm goes \[m\].
    pub tip: Vec<[f64; 2]>,
}

/// Where one looks.
pub struct State {
    pub(super) screen: Screen,
    pub(super) trajectory: usize,
    pub(super) joint: usize,
    pub(super) dock: Dock,
    /// Which part of each quantity the charts show.
    pub(super) views: Views,
    pub(super) cursor: Option<f64>,
    pub(super) show_terms: bool,
    /// Whether the parts of the torque are shown in place of the residual.
    pub(super) show_parts: bool,
    /// The parts of the torque, of a model along a trajectory, with the truth or without.
    pub(super) parts: Deferred<(usize, usize, bool), Vec<TorquePart>>,
    /// Whether time goes on by itself.
    pub(super) is_playing: bool,
    /// Whether the view moves with the time cursor.
    pub(super) follows: bool,
    pub(super) held_out_only: bool,
    pub(super) chosen_effect: usize,
    pub(super) path: String,
    pub(super) save_path: String,
    /// How recordings were opened, to open them again in another way.
    opened: Vec<(Weak<Recording>, Command)>,
    pub(super) wish: Wish,
    pub(super) training: Training,
    pub(super) addition: Addition,
    pub(super) outside: Outside,
    pub(super) trials: Trials,
    pub(super) notices: Vec<Notice>,
    pub(super) toasts: Vec<Toast>,
    pub(super) palette: Option<CommandPalette>,
    pub(super) key_list: bool,
    pub(super) exporting: Option<Exporting>,
    /// Whether something of this recording was exported, which is the end of the way.
    pub(super) exported: bool,
    shares: Option<Arc<Vec<Vec<Share>>>>,
    /// Addresses of the models that are drawn over the current one.
    pub(super) overlaid: Vec<usize>,
    /// The joint by whose error trajectories are sorted, and whether the largest comes first.
    pub(super) error_order: Option<(usize, bool)>,
    run_errors: Option<Arc<Vec<Vec<f64>>>>,
    coverage: HashMap<usize, Arc<Cells>>,
    spectra: HashMap<(usize, usize), Arc<Vec<[f64; 2]>>>,
    pub(super) bet: Bet,
    /// Whether evidence is shown with the effect in the model.
    pub(super) evidence_after: bool,
    pub(super) decimator: Decimator,
    residuals: HashMap<usize, Arc<Signals>>,
    facts: HashMap<usize, Arc<Facts>>,
    time_steps: Option<Arc<Vec<f64>>>,
    pub(super) looking: Looking,
    tables: HashMap<TableKey, Arc<Table>>,
    lit: Option<Lit>,
    /// Frequencies and past of the marked region.
    marked: Deferred<(TableKey, Brush), Spectra>,
    maps: HashMap<(TableKey, [Quantity; 2]), Arc<Cells>>,
}

impl Default for State {
    fn default() -> Self {
        State {
            screen: Screen::Data,
            trajectory: 0,
            joint: 0,
            dock: Dock::default(),
            views: Views::default(),
            cursor: None,
            show_terms: false,
            show_parts: false,
            parts: Deferred::default(),
            is_playing: false,
            follows: true,
            held_out_only: true,
            chosen_effect: 0,
            path: String::new(),
            save_path: String::new(),
            opened: Vec::new(),
            wish: Wish {
                seed: 7,
                effect: Some(1),
                joints: vec![true, false, false],
                arm: Scenario::embedded().arm,
                motion: Scenario::embedded().motion,
                encoder_steps: 0,
                strength_percent: 10.0,
                noise_percent: 2.0,
            },
            training: Training::default(),
            addition: Addition::default(),
            outside: Outside::default(),
            trials: Trials::default(),
            notices: Vec::new(),
            toasts: Vec::new(),
            palette: None,
            key_list: false,
            exporting: None,
            exported: false,
            shares: None,
            overlaid: Vec::new(),
            error_order: None,
            run_errors: None,
            coverage: HashMap::new(),
            spectra: HashMap::new(),
            bet: Bet::default(),
            evidence_after: false,
            decimator: Decimator::default(),
            residuals: HashMap::new(),
            facts: HashMap::new(),
            time_steps: None,
            looking: Looking::default(),
            tables: HashMap::new(),
            lit: None,
            marked: Deferred::default(),
            maps: HashMap::new(),
        }
    }
}

impl State {
    /// Forgets what was derived from the old session.
    pub(super) fn data_changed(&mut self) {
        self.decimator.clear();
        self.residuals.clear();
        self.facts.clear();
        self.time_steps = None;
        self.tables.clear();
        self.maps.clear();
        self.lit = None;
        self.shares = None;
        self.run_errors = None;
        self.coverage.clear();
        self.spectra.clear();
        self.chosen_effect = 0;
        self.parts = Deferred::default();
        self.marked = Deferred::default();
    }

    /// Receives what was computed for drawing.
    pub(super) fn poll(&mut self) {
        self.parts.poll();
        self.marked.poll();
    }

    /// Whether something that is drawn is still being computed.
    pub(super) fn is_computing(&self) -> bool {
        self.parts.is_busy() || self.marked.is_busy()
    }

    /// Remembers how the session's recording was opened.
    pub(super) fn remember(&mut self, session: &Session, command: &Command) {
        self.opened.retain(|(recording, _)| recording.strong_count() > 0);
        if let Some(recording) = &session.recording {
            self.opened.push((Arc::downgrade(recording), command.clone()));
        }
    }

    /// The command that opened the session's recording; `None` if it was not opened in this window.
    pub(super) fn opened(&self, session: &Session) -> Option<Command> {
        let current = Arc::downgrade(session.recording.as_ref()?);
        self.opened.iter().find(|(recording, _)| recording.ptr_eq(&current)).map(|(_, command)| command.clone())
    }

    /// What the panel of training says follows the session where that changed; what was only set there stays.
    pub(super) fn follow(&mut self, before: &Session, after: &Session) {
        if before.preset != after.preset {
            self.training.preset = after.preset;
        }
        if before.plan != after.plan {
            self.training.plan = after.plan.clone();
        }
        self.views.fit(Along::Epoch);
        self.training.cursor = None;
    }

    /// Looks at another recording: at the first trajectory of which something is held out, since the error is measured there.
    pub(super) fn recording_changed(&mut self, session: &Session) {
        (self.trajectory, self.joint) = (session.split.held_out.first().map_or(0, |segment| segment.trajectory), 0);
        self.views.fit_all();
        self.cursor = None;
        self.exported = false;
        self.looking.brush = None;
        self.outside = Outside { stretch: self.outside.stretch, ..Outside::default() };
    }

    /// Median time step of each trajectory \[s\].
    pub(super) fn time_steps(&mut self, session: &Session) -> Arc<Vec<f64>> {
        let compute = || {
            let runs = session.recording.iter().flat_map(|recording| &recording.trajectories);
            Arc::new(runs.map(|run| run.time_step()).collect())
        };
        Arc::clone(self.time_steps.get_or_insert_with(compute))
    }

    /// Looks at another trajectory, at all of its time.
    pub(super) fn show_trajectory(&mut self, trajectory: usize) {
        if self.trajectory != trajectory {
            self.trajectory = trajectory;
            self.views.fit(Along::Time);
            self.cursor = None;
        }
    }

    /// What drawing asks of one trajectory; `None` without a model.
    pub(super) fn facts(&mut self, session: &Session, trajectory: usize) -> Option<Arc<Facts>> {
        let (recording, step) = (session.recording.as_deref()?, session.current()?);
        let run = recording.trajectories.get(trajectory)?;
        let prediction = step.evaluation.predictions.get(trajectory)?;
        let compute = || {
            let largest = |torque: &[f64]| torque.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let acts = |torque: &[f64]| torque.iter().any(|value| *value != 0.0);
            let mut arm = recording.stated_arm.clone().unwrap_or_else(|| Arm::uniform(recording.joint_count()));
            arm.posture = recording.posture.unwrap_or(arm.posture);
            let tip = |sample: usize| {
                let q: Vec<f64> = run.q.at(sample).collect();
                arm.points(&q).last().copied()
            };
            Arc::new(Facts {
                tip: (0..run.len()).step_by(run.len().div_ceil(TIP_POINTS).max(1)).filter_map(tip).collect(),
                largest: run.tau.iter().map(largest).collect(),
                acts: prediction.terms.iter().map(|term| term.iter().map(acts).collect()).collect(),
            })
        };
        Some(Arc::clone(self.facts.entry(trajectory).or_insert_with(compute)))
    }

    /// What the views of the residual are drawn from, for the chosen joint and part.
    pub(super) fn table(&mut self, session: &Session) -> Arc<Table> {
        let key = (self.joint, self.held_out_only);
        Arc::clone(self.tables.entry(key).or_insert_with(|| Arc::new(Table::new(session, key.0, key.1))))
    }

    /// The rows of the table that the brush lights.
    pub(super) fn lit(&mut self, table: &Table) -> Arc<Vec<usize>> {
        let (key, brush) = ((self.joint, self.held_out_only), self.looking.brush);
        let Some(brush) = brush else { return Arc::default() };
        match &self.lit {
            Some((known, same, rows)) if *known == key && *same == brush => Arc::clone(rows),
            _ => {
                let rows = Arc::new(table.lit(&brush));
                self.lit = Some((key, brush, Arc::clone(&rows)));
                rows
            }
        }
    }

    /// Frequencies and past of the marked region; `None` without one, while it is drawn, and until they are known.
    pub(super) fn marked(&mut self, ctx: &egui::Context, table: &Arc<Table>) -> Option<Arc<Spectra>> {
        let brush = self.looking.brush?;
        if ctx.input(|input| input.pointer.any_down()) {
            return None;
        }
        let (rows, table) = (self.lit(table), Arc::clone(table));
        let key = ((self.joint, self.held_out_only), brush);
        self.marked.get(ctx, key, move || Ok(table.spectra_of(&rows)))?.ok()
    }

    /// The mean residual over two states.
    pub(super) fn map(&mut self, table: &Table, x: Quantity, y: Quantity) -> Arc<Cells> {
        let key = ((self.joint, self.held_out_only), [x, y]);
        Arc::clone(self.maps.entry(key).or_insert_with(|| Arc::new(table.map(x, y))))
    }

    /// nMSE of each trajectory and joint: `errors[trajectory][joint]`.
    pub(super) fn errors_by_run(&mut self, recording: &Recording, step: &Step) -> Arc<Vec<Vec<f64>>> {
        let compute = || {
            let error = |run: usize, joint: usize| {
                let (tau, model) =
                    (&recording.trajectories[run].tau[joint], &step.evaluation.predictions[run].total[joint]);
                let squares: f64 = tau.iter().zip(model).map(|(tau, model)| (tau - model).powi(2)).sum();
                squares / tau.iter().map(|tau| tau * tau).sum::<f64>()
            };
            let joints = recording.joint_count();
            let runs = 0..recording.trajectories.len();
            Arc::new(runs.map(|run| (0..joints).map(|joint| error(run, joint)).collect()).collect())
        };
        Arc::clone(self.run_errors.get_or_insert_with(compute))
    }

    /// How many training samples each place of position and velocity of a joint has.
    pub(super) fn coverage(&mut self, session: &Session, joint: usize) -> Option<Arc<Cells>> {
        let recording = session.recording.as_deref()?;
        let compute = || Arc::new(super::screens::covered(recording, &session.split, joint));
        Some(Arc::clone(self.coverage.entry(joint).or_insert_with(compute)))
    }

    /// Frequency and decimal logarithm of the power of the measured torque.
    pub(super) fn spectrum(
        &mut self,
        session: &Session,
        trajectory: usize,
        joint: usize,
    ) -> Option<Arc<Vec<[f64; 2]>>> {
        let run = session.recording.as_deref()?.trajectories.get(trajectory)?;
        let compute = || {
            let power = spectrum::power(&[&run.tau[joint]], run.time_step());
            Arc::new(power.into_iter().map(|[frequency, power]| [frequency, power.max(1e-300).log10()]).collect())
        };
        Some(Arc::clone(self.spectra.entry((trajectory, joint)).or_insert_with(compute)))
    }

    /// Whether the report is hidden until a guess is made.
    pub(super) fn is_betting(&self, session: &Session) -> bool {
        self.bet.first && self.bet.guess.is_none() && session.report.is_some()
    }

    /// How much each term carries on each joint, over all of the recording: `shares[term][joint]`; `None` without a model.
    pub(super) fn shares(&mut self, session: &Session) -> Option<Arc<Vec<Vec<Share>>>> {
        let (recording, step) = (session.recording.as_deref()?, session.current()?);
        let compute = || {
            let square = |torque: &[f64]| torque.iter().map(|value| value * value).sum::<f64>();
            let samples = recording.sample_count().max(1) as f64;
            let share = |term: usize, joint: usize| {
                let of_term =
                    step.evaluation.predictions.iter().map(|run| square(&run.terms[term][joint])).sum::<f64>();
                let measured = recording.trajectories.iter().map(|run| square(&run.tau[joint])).sum::<f64>();
                Share { rms: (of_term / samples).sqrt(), part: (of_term / measured).sqrt() }
            };
            let joints = recording.joint_count();
            let terms = 0..step.fitted.model.terms.len();
            Arc::new(terms.map(|term| (0..joints).map(|joint| share(term, joint)).collect()).collect())
        };
        Some(Arc::clone(self.shares.get_or_insert_with(compute)))
    }

    /// Measured minus predicted torque of one trajectory; `None` without a model.
    pub(super) fn residual(&mut self, session: &Session, trajectory: usize) -> Option<Arc<Signals>> {
        let (recording, step) = (session.recording.as_deref()?, session.current()?);
        if trajectory >= recording.trajectories.len() {
            return None;
        }
        let compute = || Arc::new(step.evaluation.residual(recording, trajectory));
        Some(Arc::clone(self.residuals.entry(trajectory).or_insert_with(compute)))
    }
}

/// The running job, as this frame shows it.
pub(super) struct Busy {
    pub name: String,
    pub progress: Progress,
    pub paused: bool,
    /// Whether it was asked to end with what it has.
    pub finishing: bool,
    /// The epochs so far, if networks are trained.
    pub epochs: Option<Vec<Epoch>>,
    /// By which plan they are trained.
    pub plan: Option<Plan>,
}

/// What a screen works with: it reads the session and gives orders.
pub struct Desk<'a> {
    pub(super) session: &'a Session,
    pub(super) state: &'a mut State,
    pub(super) orders: &'a mut Vec<Order>,
    pub(super) busy: Option<&'a Busy>,
    /// Every model that this recording was given, oldest first.
    pub(super) models: Vec<Arc<Step>>,
    pub(super) undo: Option<&'a str>,
    pub(super) redo: Option<&'a str>,
    /// Whether a copy of another run's session waits for a decision.
    pub(super) left_behind: bool,
}

impl Desk<'_> {
    /// Gives an order to change the session.
    pub(super) fn run(&mut self, command: Command) {
        self.orders.push(Order::run(command));
    }
}
