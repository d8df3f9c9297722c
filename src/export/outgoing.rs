//! A model as files of any kind, with what they can't hold: the one way of the command and the window.

use std::io;
use std::path::{Path, PathBuf};

use super::controller::{self, CodeError, Language, LeftOut};
use super::files::Files;
use super::kind::Kind;
use super::network::{self, NetworkError};
use super::robot::{self, Change, Format, NotHeld, RobotFileError, Spliced, Weighed};
use super::share;
use crate::file;
use crate::model::{Fitted, ModelError};
use crate::recording::{Recording, Trajectory};

/// The name of the function where a folder is named.
const FUNCTION: &str = "torque_model";
/// The speed within which dry friction turns round where nothing else is said \[rad/s or m/s\].
pub const SMOOTH: f64 = 0.01;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// As what.
    pub kind: Kind,
    /// Of code the file, whose name is that of the function, or a folder; of a network the folder; of a robot's file where the changed one
    /// goes: without, it takes the place of `into`.
    pub output: Option<PathBuf>,
    /// The robot's own file.
    pub into: Option<PathBuf>,
    /// The model's joints by their names there, base first; none for those that move.
    pub joints: Vec<String>,
    /// Whether masses of links are written into it, too.
    pub inertials: bool,
    /// The speed within which dry friction turns round \[rad/s or m/s\].
    pub smooth: f64,
}

/// A model out of the house.
#[derive(Debug, Clone, PartialEq)]
pub struct Outgoing {
    /// Its files.
    pub files: Files,
    /// What was changed in a robot's file.
    pub changes: Vec<Change>,
    /// The masses that were written there, if they were asked for.
    pub weighed: Option<Weighed>,
    /// What the files don't hold.
    pub not_held: Vec<NotHeld>,
}

/// The model can't be written.
#[derive(Debug, thiserror::Error)]
pub enum OutgoingError {
    /// Nobody said where.
    #[error("say with -o where the code goes: a file, or a folder")]
    NoOutput,
    /// The path of code is none of a file.
    #[error("-o names no file")]
    NoName,
    /// A network goes into a folder.
    #[error("name the folder into which the network goes with -o, such as -o network")]
    NoFolder,
    /// Values go into a file that is there.
    #[error("name the robot's own file with --into, such as --into robot.urdf")]
    NoRobot,
    /// It can't be read.
    #[error("can't read {path}: {problem}", path = path.display())]
    Unread {
        /// Which.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// It can't be spliced.
    #[error("{path}: {problem}", path = path.display())]
    Robot {
        /// Which.
        path: PathBuf,
        /// Why.
        problem: Box<RobotFileError>,
    },
    /// It can't be written as code.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// Its network can't be written.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A term can't be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// The files of a model. States of their tests are taken from the recording, and shares of the torque are measured there, if there is
/// one.
///
/// # Errors
/// [`OutgoingError`] if something that it needs was not said, or the model can't be written so.
pub fn outgoing(fitted: &Fitted, wish: &Wish, recording: Option<&Recording>) -> Result<Outgoing, OutgoingError> {
    match wish.kind {
        Kind::Code(language) => code(fitted, language, wish, recording),
        Kind::Robot(format) => spliced(fitted, format, wish, recording),
        Kind::Network => weights(fitted, wish, recording),
    }
}

fn code(
    fitted: &Fitted,
    language: Language,
    wish: &Wish,
    recording: Option<&Recording>,
) -> Result<Outgoing, OutgoingError> {
    let (folder, name) = place(wish.output.as_deref().ok_or(OutgoingError::NoOutput)?)?;
    let asked = controller::Wish { name: &name, width: wish.smooth, motion: motion(recording) };
    let code = controller::write(fitted, language, &asked)?;
    let files = code.files.into_iter().map(|file| (file.name, file.text.into_bytes()));
    without_terms(Files::within(&folder, files), &code.left_out, fitted, recording)
}

fn weights(fitted: &Fitted, wish: &Wish, recording: Option<&Recording>) -> Result<Outgoing, OutgoingError> {
    let folder = wish.output.as_deref().filter(|output| !output.is_file()).ok_or(OutgoingError::NoFolder)?;
    let package = network::write(fitted, wish.smooth, motion(recording))?;
    without_terms(Files::within(folder, package.files), &package.left_out, fitted, recording)
}

fn spliced(
    fitted: &Fitted,
    format: Format,
    wish: &Wish,
    recording: Option<&Recording>,
) -> Result<Outgoing, OutgoingError> {
    let path = wish.into.as_deref().ok_or(OutgoingError::NoRobot)?;
    let text = file::read_text(path).map_err(|problem| OutgoingError::Unread { path: path.to_owned(), problem })?;
    let spliced = robot::write(fitted, format, &text, &wish.joints, recording, wish.inertials);
    let Spliced { text, written, weighed, not_held } =
        spliced.map_err(|problem| OutgoingError::Robot { path: path.to_owned(), problem: Box::new(problem) })?;
    let output = wish.output.as_deref().unwrap_or(path);
    // The robot's own file is never lost.
    let keep_old = output == path || file::is_same(output, path);
    let files = Files { keep_old, ..Files::one(output, text.into_bytes()) };
    Ok(Outgoing { files, changes: written, weighed, not_held })
}

/// Files that have all but these terms.
fn without_terms(
    files: Files,
    left_out: &[LeftOut],
    fitted: &Fitted,
    recording: Option<&Recording>,
) -> Result<Outgoing, OutgoingError> {
    let mut not_held = Vec::new();
    for LeftOut { term, name, why } in left_out {
        let share = recording.map(|recording| share::of_torque(fitted, recording, *term, None)).transpose()?;
        not_held.push(NotHeld { what: name.clone(), value: None, why, share });
    }
    Ok(Outgoing { files, changes: Vec::new(), weighed: None, not_held })
}

/// The folder of code, and the name of its function.
fn place(output: &Path) -> Result<(PathBuf, String), OutgoingError> {
    if output.is_dir() || output.extension().is_none() {
        return Ok((output.to_owned(), FUNCTION.to_owned()));
    }
    let stem = output.file_stem().ok_or(OutgoingError::NoName)?;
    Ok((output.parent().unwrap_or(Path::new("")).to_owned(), stem.to_string_lossy().into_owned()))
}

/// The motion from which the states of a test are taken.
fn motion(recording: Option<&Recording>) -> Option<&Trajectory> {
    recording.and_then(|recording| recording.trajectories.first())
}
