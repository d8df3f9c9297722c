//! Opens files in a process of its own: what hangs, dies or takes too much memory there is counted, and not suffered.
//!
//! The process reads one request a line and answers with one line. It watches itself: a file that takes too long ends it.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};

use super::logs::Difference;
use super::memory;
use crate::arm::Arm;
use crate::arm::robot::SerialArm;
use crate::experiment::catalogue;
use crate::file;
use crate::model::Evaluation;
use crate::progress::{Event, Monitor, Stopped};
use crate::recording::Recording;
use crate::recording::mapping::MappingSpec;
use crate::recording::read::{Import, ReadOptions, read};
use crate::recording::split::Split;
use crate::session;
use crate::training::fit;
use crate::work::{self, Job, Outcome};

/// Longest that opening a file may take \[s of computing\].
pub const LONGEST_S: f64 = 5.0;
/// Whoever waits for something that never comes computes nothing: a guard out of reach of a machine that is merely busy.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a file is opened as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// A recording.
    Log,
    /// A saved session.
    Session,
    /// A model that `train` saved; it is evaluated, too.
    Model,
    /// A training that can be resumed; an epoch of it is done, too.
    Checkpoint,
    /// An experiment.
    Experiment,
    /// A mapping.
    Mapping,
    /// An arm.
    Arm,
    /// A robot's own file, URDF or MJCF.
    Robot,
}

/// A file to be opened.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Request {
    /// As what.
    pub kind: Kind,
    /// Which file.
    pub path: PathBuf,
    /// A clean recording: what a log should be, or what models are asked about.
    pub clean: Option<PathBuf>,
}

/// What became of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Opened {
    /// It was accepted, and differs so from the clean one.
    Accepted(Difference),
    /// It was refused, with this message.
    Refused(String),
    /// A defect: a panic, or something that does not keep its promises.
    Broke(String),
    /// It took too long; the process has ended.
    Hung,
    /// The process died.
    Died,
}

/// What opening a file was like.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Answer {
    /// What became of it.
    pub opened: Opened,
    /// How long it computed \[s\].
    pub seconds: f64,
    /// The most memory that it took beyond what was there before \[bytes\]; `None` where the system does not tell.
    pub memory: Option<u64>,
}

/// The process that opens files, seen from the one that asks.
pub struct Opener {
    program: PathBuf,
    process: Option<(Child, ChildStdin, BufReader<ChildStdout>)>,
}

impl Opener {
    /// Asks this program.
    pub fn new(program: &Path) -> Self {
        Opener { program: program.to_owned(), process: None }
    }

    /// Opens a file.
    ///
    /// # Errors
    /// If no process can be started.
    pub fn open(&mut self, request: &Request) -> std::io::Result<Answer> {
        let (_, input, output) = match &mut self.process {
            Some(process) => process,
            None => self.process.insert(start(&self.program)?),
        };
        let mut line = String::new();
        let asked = writeln!(input, "{}", serde_json::to_string(request)?).and_then(|()| output.read_line(&mut line));
        let died = Answer { opened: Opened::Died, seconds: 0.0, memory: None };
        let answer = asked.ok().and_then(|_| serde_json::from_str(&line).ok()).unwrap_or(died);
        if matches!(answer.opened, Opened::Hung | Opened::Died) {
            self.end();
        }
        Ok(answer)
    }

    /// Opens a file in a new process, whose memory nothing else has filled.
    ///
    /// # Errors
    /// As [`Opener::open`].
    pub fn open_alone(&mut self, request: &Request) -> std::io::Result<Answer> {
        self.end();
        self.open(request)
    }

    fn end(&mut self) {
        if let Some((mut child, input, _)) = self.process.take() {
            drop(input);
            // It may have ended already.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Drop for Opener {
    fn drop(&mut self) {
        self.end();
    }
}

fn start(program: &Path) -> std::io::Result<(Child, ChildStdin, BufReader<ChildStdout>)> {
    let mut command = Command::new(program);
    command.args(["selftest", "--opener"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn()?;
    match (child.stdin.take(), child.stdout.take()) {
        (Some(input), Some(output)) => Ok((child, input, BufReader::new(output))),
        _ => Err(std::io::Error::other("the process has no pipes")),
    }
}

/// Is that process: answers requests until there are no more.
///
/// # Errors
/// What the system says of the pipes.
pub fn serve() -> std::io::Result<()> {
    for line in std::io::stdin().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let answer = answered(request);
        let mut output = std::io::stdout().lock();
        writeln!(output, "{}", serde_json::to_string(&answer)?)?;
        output.flush()?;
        if matches!(answer.opened, Opened::Hung) {
            // The thread that hangs ends with the process.
            return Ok(());
        }
    }
    Ok(())
}

fn answered(request: Request) -> Answer {
    let before = memory::start();
    let (computed, begun) = (ProcessTime::now(), Instant::now());
    let mut job = Job::spawn("open", || (), move |_| open(&request));
    let opened = loop {
        match job.poll() {
            Some(Outcome::Done(opened)) => break opened,
            Some(Outcome::Failed(message) | Outcome::Stopped(message)) => break Opened::Refused(message),
            Some(Outcome::Panicked(message)) => break Opened::Broke(message),
            None if computed.elapsed().as_secs_f64() > LONGEST_S || begun.elapsed() > PATIENCE => break Opened::Hung,
            None => work::pause(),
        }
    };
    let memory = before.and_then(|before| Some(memory::most()?.saturating_sub(before)));
    Answer { opened, seconds: computed.elapsed().as_secs_f64(), memory }
}

/// Clean recordings that were read, by their paths: many files are held against one.
static CLEAN: Mutex<Vec<(PathBuf, Import)>> = Mutex::new(Vec::new());

fn clean(path: &Path) -> Result<Import, String> {
    let mut known = CLEAN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some((_, import)) = known.iter().find(|(other, _)| other == path) {
        return Ok(import.clone());
    }
    let import = log(path)?;
    known.push((path.to_owned(), import.clone()));
    Ok(import)
}

fn log(path: &Path) -> Result<Import, String> {
    read(&[path.to_owned()], &ReadOptions::default(), &Monitor::new()).map_err(|error| error.to_string())
}

/// Opens a file in this process as the commands do, and uses what it holds.
///
/// # Errors
/// Why it was refused.
pub fn open(request: &Request) -> Result<Opened, String> {
    let Request { kind, path, clean: other } = request;
    let other = other.as_deref().map(clean).transpose()?;
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let text = || file::read_text(path).map_err(|error| said(&error));
    match (kind, other) {
        (Kind::Log, other) => {
            let import = log(path)?;
            if let Err(error) = import.recording.verify() {
                return Ok(Opened::Broke(format!("it was accepted, but {error}")));
            }
            let difference = other.map_or(Difference::None, |clean| Difference::between(&clean, &import));
            return Ok(Opened::Accepted(difference));
        }
        (Kind::Session, _) => {
            let opened = session::file::open(path, &Monitor::new()).map_err(|error| said(&error))?;
            if let Err(error) = session::file::to_bytes(&opened.document) {
                return Ok(Opened::Broke(format!("it was opened, but can't be saved again: {error}")));
            }
        }
        (Kind::Model, other) => {
            let bytes = file::read(path, file::LARGEST_MODEL).map_err(|error| said(&error))?;
            let fitted = fit::from_bytes(&bytes).map_err(|error| said(&error))?;
            if let Some(Import { recording, .. }) = other {
                Evaluation::of(&fitted, &recording, &Split::automatic(&recording)).map_err(|error| said(&error))?;
            }
        }
        (Kind::Checkpoint, other) => {
            let run = session::runs::load(path).map_err(|error| said(&error))?;
            other.map_or(Ok(()), |clean| resume(&run, &clean.recording))?;
        }
        (Kind::Experiment, _) => drop(catalogue::open(&path.to_string_lossy()).map_err(|error| said(&error))?),
        (Kind::Mapping, _) => drop(MappingSpec::from_toml(&text()?).map_err(|error| said(&error))?),
        (Kind::Arm, _) => {
            let arm: Arm = serde_json::from_str(&text()?).map_err(|error| said(&error))?;
            arm.check().map_err(|error| said(&error))?;
        }
        (Kind::Robot, _) => {
            let arm = SerialArm::parse(&text()?).map_err(|error| said(&error))?;
            drop(arm.chain());
            if !arm.stated_parameters().iter().all(|value| value.is_finite()) {
                return Ok(Opened::Broke("it was accepted, but states parameters that are no numbers".to_owned()));
            }
        }
    }
    Ok(Opened::Accepted(Difference::None))
}

/// One more epoch of a training.
fn resume(run: &fit::SavedRun, recording: &Recording) -> Result<(), String> {
    let ended = || Err(Stopped { reason: "an epoch is enough".to_owned() });
    let monitor = Monitor::relaying(move |event| if matches!(event, Event::Epoch(_)) { ended() } else { Ok(()) });
    let split = Split::automatic(recording);
    fit::resume(run, recording, &split, &monitor, &mut |_| ()).map(drop).map_err(|error| error.to_string())
}
