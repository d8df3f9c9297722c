//! A model that was solved for as the code of a controller: one function τ(q, q̇, q̈), and the vectors by which it is tested.
//!
//! The torque is written once, on a `tape` of scalar steps: the rigid body (`body`), then each effect that has a closed form.
//! A `language` prints the tape. What no function of the present motion can give (an effect with a memory, a delay of a reading)
//! is left out, and told.

mod body;
mod language;
mod ros2;
mod tape;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::arm::stated::Resistance;
use crate::effect::own::{Quantity, Writer};
use crate::effect::{NotApplicable, Stage};
use crate::model::{EffectTerm, Fitted, ModelError, Term};
use crate::recording::{Channels, JointKind, Trajectory};
use crate::signals::Signals;
use body::Body;
pub use language::Language;
use tape::{Tape, Value};

/// So many states stand in the test of the generated code.
const TEST_STATES: usize = 12;
/// States are drawn within these bounds of q, q̇, q̈ where no recording says what is usual \[rad or m, per s, per s²\].
const USUAL: [f64; 3] = [1.5, 1.5, 4.0];

/// A file that was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Its name, without a folder.
    pub name: String,
    /// What is in it.
    pub text: String,
}

/// The code of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Code {
    /// The function first, then its test.
    pub files: Vec<Written>,
    /// What is not in it.
    pub left_out: Vec<LeftOut>,
}

/// A term that the code does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its index in the model.
    pub term: usize,
    /// Its name for people.
    pub name: String,
    /// Why.
    pub why: &'static str,
}

/// A model can't be written as code.
#[derive(Debug, thiserror::Error)]
pub enum CodeError {
    /// It has networks.
    #[error(
        "the model has a network ({0}), which is not written as code: `torquescope export network` writes its weights with what \
         computes the torque from them; or export one that is solved for, such as `torquescope train LOG --add coulomb-friction -o \
         model.json`"
    )]
    Learned(String),
    /// It has no term that could be written.
    #[error("nothing of the model can be written as a function of q, q̇ and q̈: {}", names(.0))]
    Nothing(Vec<LeftOut>),
    /// The width can't be.
    #[error("the width of smoothing is {0}, but must be a number above 0, in rad/s or m/s: such as 0.01")]
    Width(f64),
    /// The name can't be one in code.
    #[error("`{0}` can't be the name of a function: begin with a letter; letters, digits and _ may follow")]
    Name(String),
    /// A term can't be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An effect can't be computed.
    #[error(transparent)]
    NotApplicable(#[from] NotApplicable),
}

fn names(left_out: &[LeftOut]) -> String {
    left_out.iter().map(|out| out.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish<'a> {
    /// The name of the function, and the beginning of those of the files.
    pub name: &'a str,
    /// Dry friction turns round within tanh(q̇ / width) \[rad/s or m/s\], or wider where the model says so.
    pub width: f64,
    /// Motion from which the states of the test are taken; without it they are drawn.
    pub motion: Option<&'a Trajectory>,
}

/// The model as code in this language.
///
/// # Errors
/// [`CodeError`] if it has networks, or nothing in it can be written.
pub fn write(fitted: &Fitted, language: Language, wish: &Wish) -> Result<Code, CodeError> {
    check(fitted, wish)?;
    let (tape, kept, left_out) = taken_down(fitted, wish)?;
    let vectors = Vectors::of(&kept, wish)?;
    let sheet = Sheet { name: wish.name, width: wish.width, tape: &tape, kept: &kept, vectors: &vectors };
    Ok(Code { files: language.files(&sheet, &left_out), left_out })
}

/// All that a language prints.
struct Sheet<'a> {
    name: &'a str,
    width: f64,
    tape: &'a Tape,
    kept: &'a Fitted,
    vectors: &'a Vectors,
}

impl Sheet<'_> {
    fn joints(&self) -> usize {
        self.kept.setting().kinds.len()
    }

    /// What a reader must know, a line each.
    fn remarks(&self, left_out: &[LeftOut]) -> Vec<String> {
        let terms: Vec<String> = self.kept.model.terms.iter().map(Term::label).collect();
        let units = self.kept.setting().kinds.iter().map(|kind| match kind {
            JointKind::Revolute => "rad",
            JointKind::Prismatic => "m",
        });
        let mut lines = vec![
            format!("Torque of a robot arm, tau(q, qd, qdd), written by Torquescope {}.", env!("CARGO_PKG_VERSION")),
            format!("In it: {}.", terms.join("; ")),
            format!(
                "q by joint in {}; qd and qdd per s and s^2; tau in N m (N where a joint slides).",
                units.collect::<Vec<_>>().join(", ")
            ),
            format!(
                "Dry friction turns round as tanh(qd / width), width {} or wider where the data asked for it.",
                self.width
            ),
            "For compensation of gravity and friction call it with qdd = 0 and the velocity that is wanted.".to_owned(),
        ];
        lines.extend(left_out.iter().map(|out| format!("LEFT OUT: {}, {}.", out.name, out.why)));
        lines
    }
}

fn check(fitted: &Fitted, wish: &Wish) -> Result<(), CodeError> {
    if let Some(term) = fitted.model.terms.iter().find(|term| matches!(term, Term::Learned(_))) {
        return Err(CodeError::Learned(term.label()));
    }
    if !(wish.width.is_finite() && wish.width > 0.0) {
        return Err(CodeError::Width(wish.width));
    }
    let is_name = wish.name.starts_with(|c: char| c.is_ascii_alphabetic())
        && wish.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if is_name { Ok(()) } else { Err(CodeError::Name(wish.name.to_owned())) }
}

/// The torque on a tape, the model of what is on it, and what is not.
fn taken_down(fitted: &Fitted, wish: &Wish) -> Result<(Tape, Fitted, Vec<LeftOut>), CodeError> {
    let smooth = fitted.with_reversals_of(wish.width);
    let mut body = Body::of(&smooth);
    let mut formulas = Vec::new();
    let mut left_out = Vec::new();
    for (number, term) in smooth.model.terms.iter().enumerate() {
        let Term::Effect(placed) = term else { continue };
        if placed.effect.closed_form().is_some() {
            formulas.push(number);
        } else if !body.take(&smooth, number, placed)? {
            left_out.push(LeftOut { term: number, name: term.label(), why: why_not(placed) });
        }
    }
    let kept = smooth.without(|term| left_out.iter().any(|out| out.term == term));
    if kept.model.terms.is_empty() {
        return Err(CodeError::Nothing(left_out));
    }
    let joints = smooth.setting().kinds.len();
    let mut tape = Tape::default();
    let mut total = body.write(&smooth, &mut tape);
    total.resize(joints, Value::Number(0.0));
    for term in &smooth.model.terms {
        let Term::Resistance(joints) = term else { continue };
        add_resistance(&smooth, joints, &mut tape, &mut total);
    }
    for &number in &formulas {
        let Term::Effect(placed) = &smooth.model.terms[number] else { continue };
        add_effect(&smooth, number, placed, &body, &mut tape, &mut total);
    }
    tape.end(total);
    Ok((tape, kept, left_out))
}

/// Why an effect is no function of the present motion.
fn why_not(placed: &EffectTerm) -> &'static str {
    match placed.effect.stage {
        Stage::Body(_) => "which follows from more than the present motion (time, a memory, or a body in space)",
        Stage::Drive(_) => "which delays the torque: let the controller lead by it",
        Stage::Reading(..) => "which is in the reading and not in the arm",
    }
}

/// Adds the torque of an effect by its formulas.
fn add_effect(fitted: &Fitted, number: usize, placed: &EffectTerm, body: &Body, tape: &mut Tape, total: &mut [Value]) {
    let Some(form) = placed.effect.closed_form() else { return };
    let setting = fitted.setting();
    let joints = setting.kinds.len();
    let own = placed.joint.unwrap_or(0);
    let at = placed.joint.map_or(String::new(), |joint| format!("_{}", joint + 1));
    tape.heading(&format!("{}: {}", Term::Effect(placed.clone()).label(), placed.effect.formula));
    let parameter = |tape: &mut Tape, name: &str, value: f64, unit: &str| {
        tape.constant(&format!("{}_{name}{at}", placed.effect.id.replace('-', "_")), value, unit)
    };
    let specs = placed.effect.parameters.iter();
    let kind = setting.kinds[own];
    let shapes: Vec<Value> = placed
        .effect
        .shapes()
        .zip(&fitted.shapes()[number])
        .map(|((spec, _), value)| parameter(tape, spec.name, *value, spec.dimension.unit(kind)))
        .collect();
    let load = if placed.effect.facts.depends_on_load { body.write_load(fitted, tape) } else { Vec::new() };
    let widths = &setting.reversal_widths;
    let columns = form.write(joints, own, &shapes, tape, |tape, quantity, joint| match quantity {
        Quantity::Direction => {
            let qd = tape.channel(Quantity::Velocity, joint);
            direction(tape, qd, joint, widths[joint])
        }
        Quantity::PairDirection => {
            let (own, before) = (tape.channel(Quantity::Velocity, joint), tape.channel(Quantity::Velocity, joint - 1));
            let sum = tape.add(own, before);
            direction(tape, sum, joint, widths[joint])
        }
        Quantity::Load => load[joint],
        Quantity::Position | Quantity::Velocity | Quantity::Acceleration => tape.channel(quantity, joint),
    });
    let linear = fitted.linear_of(number);
    for ((parts, spec), value) in columns.into_iter().flatten().zip(specs).zip(linear) {
        let factor = parameter(tape, spec.name, value, spec.dimension.unit(kind));
        for (joint, column) in parts {
            let torque = tape.mul(factor, column);
            total[joint] = tape.add(total[joint], torque);
        }
    }
}

/// Adds what is stated to resist each joint.
fn add_resistance(fitted: &Fitted, joints: &[Resistance], tape: &mut Tape, total: &mut [Value]) {
    tape.heading("stated resistance of joints: I_r * qdd + d * qd + tau_c * direction + k * q + tau_0");
    for (joint, Resistance { rotor_inertia, damping, friction, stiffness, preload }) in joints.iter().enumerate() {
        let [q, qd, qdd] = [Quantity::Position, Quantity::Velocity, Quantity::Acceleration]
            .map(|quantity| tape.channel(quantity, joint));
        let turns = direction(tape, qd, joint, fitted.setting().reversal_widths[joint]);
        let parts = [
            ("rotor_inertia", rotor_inertia, qdd),
            ("damping", damping, qd),
            ("friction", friction, turns),
            ("stiffness", stiffness, q),
            ("preload", preload, Value::Number(1.0)),
        ];
        for (name, value, channel) in parts {
            let factor = tape.constant(&format!("stated_{name}_{}", joint + 1), *value, "SI");
            let torque = tape.mul(factor, channel);
            total[joint] = tape.add(total[joint], torque);
        }
    }
}

/// tanh(q̇ / width).
fn direction(tape: &mut Tape, velocity: Value, joint: usize, width: f64) -> Value {
    let width = tape.constant(&format!("width_{}", joint + 1), width, "within which dry friction turns round");
    let share = tape.div(velocity, width);
    tape.of_one("tanh", share)
}

/// States, and the torque of the model there.
struct Vectors {
    states: Trajectory,
    torque: Signals,
}

impl Vectors {
    fn of(kept: &Fitted, wish: &Wish) -> Result<Vectors, CodeError> {
        let states = test_states(kept.setting().kinds.len(), wish.motion);
        let torque = kept.predict(&states)?.total;
        Ok(Vectors { states, torque })
    }
}

/// The states of a test: of a motion, or drawn.
pub(super) fn test_states(joints: usize, motion: Option<&Trajectory>) -> Trajectory {
    motion.map_or_else(|| drawn(joints, USUAL, TEST_STATES, 1), picked)
}

/// States of a motion, evenly over it, as a trajectory of their own.
fn picked(motion: &Trajectory) -> Trajectory {
    let at = |sample: usize| sample * motion.len().saturating_sub(1) / (TEST_STATES - 1);
    let pick = |signal: &Signals| Signals::from_fn(signal.joint_count(), TEST_STATES, |joint, t| signal[joint][at(t)]);
    states([pick(&motion.q), pick(&motion.qd), pick(&motion.qdd)])
}

/// Drawn states within bounds of q, q̇ and q̈.
fn drawn(joints: usize, bounds: [f64; 3], count: usize, seed: u64) -> Trajectory {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    states(bounds.map(|bound| Signals::from_fn(joints, count, |_, _| random.random_range(-bound..bound))))
}

/// States that need not follow from each other.
fn states([q, qd, qdd]: [Signals; 3]) -> Trajectory {
    let (joints, count) = (q.joint_count(), q.sample_count());
    let time = (0..count).map(|t| t as f64).collect();
    let tau = Signals::zeros(joints, count);
    Trajectory::new("states", Channels { time, q, qd, qdd, tau }).expect("as many samples of all channels, time grows")
}

#[cfg(test)]
mod tests;
