//! The rigid body on a tape: the planar arm in its lumped parameters, an arm in space by Newton and Euler, a sliding mass.
//!
//! A planar body may lean: beside Kᵢⱼ cos(θᵢ − θⱼ) stands a part Sᵢⱼ sin(θᵢ − θⱼ), beside Gᵢ sin θᵢ a part −Dᵢ cos θᵢ,
//!
//! ```text
//! fᵢ = Σⱼ Kᵢⱼ [cos Δ θ̈ⱼ + sin Δ θ̇ⱼ²] ± Sᵢⱼ [sin Δ θ̈ⱼ ∓ cos Δ θ̇ⱼ²] + g (Gᵢ cos θᵢ + Dᵢ sin θᵢ),   Δ = θᵢ − θⱼ
//! ```
//!
//! so that every effect that is itself the torque of a body (a payload, a tilted base, a centre of mass beside its link) is
//! only another value of these parameters. Whether one is, its own torque at drawn states tells.

use nalgebra::{DMatrix, DVector};

use super::tape::{Tape, Value};
use super::{TEST_STATES, USUAL, drawn};
use crate::arm::chain::{Chain, Frame, PER_LINK};
use crate::arm::{Arm, Posture, regressor};
use crate::effect::own::{Quantity, Writer};
use crate::model::{EffectTerm, Fitted, ModelError, RigidBody, Term};
use crate::recording::{JointKind, Trajectory};

/// An effect is a body's torque if the parameters of one leave no more than this share of it.
const EXACT: f64 = 1e-9;

/// What the rigid body is made of.
pub(super) enum Body {
    /// A mass on a slide \[kg\].
    Slide(f64),
    /// A planar arm: K, G (the lumped parameters), then S and D in the same order.
    Planar(Vec<f64>),
    /// An arm in space: ten parameters a link.
    Spatial(Vec<f64>),
}

/// How the state enters a planar arm.
struct Angles {
    theta: Vec<Value>,
    squared: Vec<Value>,
    acceleration: Vec<Value>,
}

impl Body {
    /// The rigid body of a model; of nothing if it has none.
    pub(super) fn of(fitted: &Fitted) -> Body {
        let mut bodies = fitted.model.terms.iter().filter_map(|term| match term {
            Term::RigidBody(RigidBody::Stated(arm)) => Some(arm.parameters()),
            Term::RigidBody(RigidBody::Identified) => fitted.body(),
            _ => None,
        });
        Body::with(fitted, bodies.next_back())
    }

    /// The body of a model's setting with these parameters, or of nothing.
    fn with(fitted: &Fitted, parameters: Option<Vec<f64>>) -> Body {
        let setting = fitted.setting();
        let joints = setting.kinds.len();
        if setting.chain.is_some() {
            Body::Spatial(parameters.unwrap_or_else(|| vec![0.0; PER_LINK * joints]))
        } else if setting.kinds == [JointKind::Prismatic] {
            Body::Slide(parameters.map_or(0.0, |mass| mass[0]))
        } else {
            let count = regressor::parameter_count(joints);
            let mut parameters = parameters.unwrap_or_else(|| vec![0.0; count]);
            parameters.resize(2 * count, 0.0);
            Body::Planar(parameters)
        }
    }

    /// Takes an effect into the parameters of the body, if it is the torque of one.
    ///
    /// # Errors
    /// [`ModelError`] if the effect can't be computed.
    pub(super) fn take(&mut self, fitted: &Fitted, number: usize, placed: &EffectTerm) -> Result<bool, ModelError> {
        let Body::Planar(parameters) = self else { return Ok(false) };
        if placed.effect.changes_others() {
            return Ok(false);
        }
        let setting = fitted.setting();
        let joints = setting.kinds.len();
        let states = drawn(joints, USUAL, TEST_STATES + parameters.len(), 2);
        let load = setting.load(&states);
        let columns = placed.columns(setting, &states, load.as_ref(), &fitted.shapes()[number])?;
        let mut torque = DVector::zeros(joints * states.len());
        for (column, factor) in columns.iter().zip(fitted.linear_of(number)) {
            for (joint, values) in &column.parts {
                values.iter().enumerate().for_each(|(t, value)| torque[joint * states.len() + t] += factor * value);
            }
        }
        let basis = planar_columns(setting.posture, setting.gravity(), &states, parameters.len());
        let Ok(found) = basis.clone().svd(true, true).solve(&torque, 1e-12) else { return Ok(false) };
        // What is nothing at these states may be something at others.
        let is_nothing = fitted.linear_of(number).iter().all(|factor| *factor == 0.0);
        let is_seen = torque.norm() > 0.0;
        let is_body = is_nothing || is_seen && (&basis * &found - &torque).norm() <= EXACT * torque.norm();
        if is_body {
            parameters.iter_mut().zip(&found).for_each(|(own, more)| *own += rounded(*more, found.amax()));
        }
        Ok(is_body)
    }

    /// Writes the torque of the body that the load of other effects comes from.
    pub(super) fn write_load(&self, fitted: &Fitted, tape: &mut Tape) -> Vec<Value> {
        let setting = fitted.setting();
        let known = setting.body.clone().or_else(|| setting.arm.as_ref().map(Arm::lumped_parameters));
        let load = Body::with(fitted, known);
        // The body itself serves, where it is the same.
        let prefix = if load.parameters() == self.parameters() { "" } else { "load_" };
        load.write_as(fitted, tape, prefix)
    }

    /// Writes the torque of each joint.
    pub(super) fn write(&self, fitted: &Fitted, tape: &mut Tape) -> Vec<Value> {
        tape.heading("rigid body");
        self.write_as(fitted, tape, "")
    }

    fn parameters(&self) -> &[f64] {
        match self {
            Body::Slide(mass) => std::slice::from_ref(mass),
            Body::Planar(parameters) | Body::Spatial(parameters) => parameters,
        }
    }

    fn write_as(&self, fitted: &Fitted, tape: &mut Tape, prefix: &str) -> Vec<Value> {
        let setting = fitted.setting();
        match self {
            Body::Slide(mass) => {
                let mass = tape.constant(&format!("{prefix}M1"), *mass, "kg");
                let qdd = tape.channel(Quantity::Acceleration, 0);
                vec![tape.mul(mass, qdd)]
            }
            Body::Planar(parameters) => write_planar(setting.posture, setting.gravity(), parameters, tape, prefix),
            Body::Spatial(parameters) => match &setting.chain {
                Some(chain) => write_spatial(chain, &setting.kinds, parameters, tape, prefix),
                None => Vec::new(),
            },
        }
    }
}

/// What is only rounding is nothing.
fn rounded(value: f64, largest: f64) -> f64 {
    if value.abs() < 1e-12 * largest { 0.0 } else { value }
}

/// The torque of each of the parameters of a leaning planar body at these states, one column each.
fn planar_columns(posture: Posture, gravity: f64, states: &Trajectory, width: usize) -> DMatrix<f64> {
    let joints = states.joint_count();
    let mut columns = DMatrix::zeros(joints * states.len(), width);
    for t in 0..states.len() {
        let [q, qd, qdd] = [&states.q, &states.qd, &states.qdd].map(|signal| signal.at(t).collect::<Vec<f64>>());
        let mut upright = vec![0.0; joints * width / 2];
        regressor::fill(posture, gravity, &q, &qd, &qdd, &mut upright);
        let leaning = leaning_row(posture, gravity, &q, &qd, &qdd);
        for joint in 0..joints {
            for column in 0..width / 2 {
                columns[(joint * states.len() + t, column)] = upright[joint * width / 2 + column];
                columns[(joint * states.len() + t, width / 2 + column)] = leaning[column][joint];
            }
        }
    }
    columns
}

/// By parameter S, then D: the torque on each joint.
fn leaning_row(posture: Posture, gravity: f64, q: &[f64], qd: &[f64], qdd: &[f64]) -> Vec<Vec<f64>> {
    let joints = q.len();
    let sign = posture.sign();
    let sums = |values: &[f64], start: f64| {
        let mut sum = start;
        values
            .iter()
            .map(|value| {
                sum += sign * value;
                sum
            })
            .collect::<Vec<f64>>()
    };
    let (theta, rate, acceleration) = (sums(q, posture.zero_angle), sums(qd, 0.0), sums(qdd, 0.0));
    let mut rows = Vec::new();
    let felt = |forces: &[(usize, f64)]| {
        let on = |joint: usize| forces.iter().filter(|(angle, _)| *angle >= joint).map(|(_, force)| sign * force).sum();
        (0..joints).map(on).collect::<Vec<f64>>()
    };
    for i in 0..joints {
        rows.push(vec![0.0; joints]);
        for j in i + 1..joints {
            let (sin, cos) = (theta[i] - theta[j]).sin_cos();
            rows.push(felt(&[
                (i, sin * acceleration[j] - cos * rate[j].powi(2)),
                (j, sin * acceleration[i] + cos * rate[i].powi(2)),
            ]));
        }
    }
    rows.extend((0..joints).map(|i| felt(&[(i, gravity * theta[i].sin())])));
    rows
}

/// The torque of a leaning planar body.
fn write_planar(posture: Posture, gravity: f64, parameters: &[f64], tape: &mut Tape, prefix: &str) -> Vec<Value> {
    let (upright, leaning) = parameters.split_at(parameters.len() / 2);
    // n (n + 3) / 2 parameters
    let joints = (0..).find(|&n| regressor::parameter_count(n) >= upright.len()).unwrap_or(0);
    let names = regressor::parameter_names(joints);
    let constant = |tape: &mut Tape, place: usize, is_leaning: bool| {
        let (name, values) = (&names[place], if is_leaning { leaning } else { upright });
        let letter = match (is_leaning, name.starts_with('K')) {
            (false, _) => name.clone(),
            (true, true) => name.replacen('K', "S", 1),
            (true, false) => name.replacen('G', "D", 1),
        };
        tape.constant(&format!("{prefix}{letter}"), values[place], regressor::parameter_unit(joints, place))
    };
    let Angles { theta, squared, acceleration } = angles(posture, joints, tape);
    let mut forces = vec![Value::Number(0.0); joints];
    let mut place = 0;
    for i in 0..joints {
        let own = constant(tape, place, false);
        let torque = tape.mul(own, acceleration[i]);
        forces[i] = tape.add(forces[i], torque);
        place += 1;
        for j in i + 1..joints {
            let [with, across] = [false, true].map(|is_leaning| constant(tape, place, is_leaning));
            let between = tape.sub(theta[i], theta[j]);
            let (sin, cos) = (tape.of_one("sin", between), tape.of_one("cos", between));
            // [K cos Δ + S sin Δ] θ̈ and [K sin Δ − S cos Δ] θ̇², the latter with the other sign on the later angle.
            let [kc, ss, ks, sc] =
                [(with, cos), (across, sin), (with, sin), (across, cos)].map(|(factor, wave)| tape.mul(factor, wave));
            let (inertial, centrifugal) = (tape.add(kc, ss), tape.sub(ks, sc));
            let on_earlier = [tape.mul(inertial, acceleration[j]), tape.mul(centrifugal, squared[j])];
            let on_later = [tape.mul(inertial, acceleration[i]), tape.mul(centrifugal, squared[i])];
            forces[i] = tape.add(forces[i], on_earlier[0]);
            forces[i] = tape.add(forces[i], on_earlier[1]);
            forces[j] = tape.add(forces[j], on_later[0]);
            forces[j] = tape.sub(forces[j], on_later[1]);
            place += 1;
        }
    }
    let weight = tape.constant("gravity", gravity, "m/s^2");
    for i in 0..joints {
        let [down, aside] = [false, true].map(|is_leaning| constant(tape, place, is_leaning));
        let (cos, sin) = (tape.of_one("cos", theta[i]), tape.of_one("sin", theta[i]));
        let (down, aside) = (tape.mul(down, cos), tape.mul(aside, sin));
        let moment = tape.add(down, aside);
        let torque = tape.mul(weight, moment);
        forces[i] = tape.add(forces[i], torque);
        place += 1;
    }
    felt_by_joints(posture, forces, tape)
}

/// Joint k feels every absolute angle from k outwards.
fn felt_by_joints(posture: Posture, mut forces: Vec<Value>, tape: &mut Tape) -> Vec<Value> {
    for joint in (0..forces.len().saturating_sub(1)).rev() {
        forces[joint] = tape.add(forces[joint], forces[joint + 1]);
    }
    forces.into_iter().map(|force| tape.mul(Value::Number(posture.sign()), force)).collect()
}

/// The absolute angles, the squares of their rates, their accelerations.
fn angles(posture: Posture, joints: usize, tape: &mut Tape) -> Angles {
    let sign = Value::Number(posture.sign());
    let sums = |start: Value, quantity: Quantity, tape: &mut Tape| {
        let mut sum = start;
        let mut next = |joint: usize| {
            let channel = tape.channel(quantity, joint);
            let signed = tape.mul(sign, channel);
            sum = tape.add(sum, signed);
            sum
        };
        (0..joints).map(&mut next).collect::<Vec<Value>>()
    };
    let zero = Value::Number(0.0);
    let start = tape.constant("zero_angle", posture.zero_angle, "rad, of the first link at q = 0");
    let theta = sums(start, Quantity::Position, tape);
    let rates = sums(zero, Quantity::Velocity, tape);
    let acceleration = sums(zero, Quantity::Acceleration, tape);
    let squared = rates.into_iter().map(|rate| tape.mul(rate, rate)).collect();
    Angles { theta, squared, acceleration }
}

/// The recursive Newton–Euler algorithm of [`crate::arm::chain`], step by step.
fn write_spatial(chain: &Chain, kinds: &[JointKind], parameters: &[f64], tape: &mut Tape, prefix: &str) -> Vec<Value> {
    let named = chain.parameter_names();
    let mut constants = Vec::new();
    for (index, (name, value)) in named.iter().zip(parameters).enumerate() {
        constants.push(tape.constant(&format!("{prefix}{name}"), *value, Chain::parameter_unit(index)));
    }
    let frames = chain.frames();
    let mut moved: Vec<LinkMotion> = Vec::new();
    for (joint, frame) in frames.iter().enumerate() {
        moved.push(LinkMotion::after(moved.last(), chain.gravity, frame, kinds[joint], joint, tape));
    }
    let mut torque = vec![Value::Number(0.0); kinds.len()];
    let (mut force, mut moment) = (NOTHING, NOTHING);
    for (joint, motion) in moved.iter().enumerate().rev() {
        let [own_force, own_moment] = motion.wrench(&constants[joint * PER_LINK..][..PER_LINK], tape);
        force = plus(tape, force, own_force);
        moment = plus(tape, moment, own_moment);
        torque[joint] = if kinds[joint] == JointKind::Prismatic { force[2] } else { moment[2] };
        force = motion.outward(force, tape);
        let lever = cross(tape, motion.offset, force);
        moment = motion.outward(moment, tape);
        moment = plus(tape, moment, lever);
    }
    torque
}

type Vector = [Value; 3];
const NOTHING: Vector = [Value::Number(0.0); 3];

fn plus(tape: &mut Tape, a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| tape.add(a[axis], b[axis]))
}

fn scaled(tape: &mut Tape, factor: Value, a: Vector) -> Vector {
    a.map(|value| tape.mul(factor, value))
}

fn cross(tape: &mut Tape, a: Vector, b: Vector) -> Vector {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let (one, other) = (tape.mul(a[i], b[j]), tape.mul(a[j], b[i]));
        tape.sub(one, other)
    })
}

fn dot(tape: &mut Tape, a: Vector, b: Vector) -> Value {
    let mut sum = Value::Number(0.0);
    for (a, b) in a.into_iter().zip(b) {
        let product = tape.mul(a, b);
        sum = tape.add(sum, product);
    }
    sum
}

/// ω × (ω × a).
fn swung(tape: &mut Tape, omega: Vector, a: Vector) -> Vector {
    let once = cross(tape, omega, a);
    cross(tape, omega, once)
}

/// How a link moves, in its own frame.
struct LinkMotion {
    /// The rotation out of its frame into the one before is this one after that by `turn` about z.
    fixed: [[f64; 3]; 3],
    turn: Option<[Value; 2]>,
    offset: Vector,
    omega: Vector,
    alpha: Vector,
    /// Of its origin, gravity taken off.
    acceleration: Vector,
}

impl LinkMotion {
    fn after(
        before: Option<&LinkMotion>,
        gravity: [f64; 3],
        frame: &Frame,
        kind: JointKind,
        joint: usize,
        tape: &mut Tape,
    ) -> LinkMotion {
        let [q, qd, qdd] = [Quantity::Position, Quantity::Velocity, Quantity::Acceleration]
            .map(|quantity| tape.channel(quantity, joint));
        let (omega, alpha, acceleration) = before.map_or_else(
            || (NOTHING, NOTHING, gravity.map(|value| Value::Number(-value))),
            |link| (link.omega, link.alpha, link.acceleration),
        );
        let mut offset = frame.offset.map(Value::Number);
        let slides = kind == JointKind::Prismatic;
        if slides {
            let along = scaled(tape, q, frame.rotation.map(|row| Value::Number(row[2])));
            offset = plus(tape, offset, along);
        }
        let turn = (!slides).then(|| [tape.of_one("cos", q), tape.of_one("sin", q)]);
        let mut link = LinkMotion { fixed: frame.rotation, turn, offset, omega, alpha, acceleration };
        let (tangential, normal) = (cross(tape, alpha, offset), swung(tape, omega, offset));
        let carried = plus(tape, acceleration, tangential);
        let carried = plus(tape, carried, normal);
        let [turned_omega, turned_alpha, carried] = [omega, alpha, carried].map(|vector| link.inward(vector, tape));
        let along = |value: Value| [Value::Number(0.0), Value::Number(0.0), value];
        let gyration = cross(tape, turned_omega, along(qd));
        if slides {
            let coriolis = scaled(tape, Value::Number(2.0), gyration);
            let carried = plus(tape, carried, coriolis);
            link.acceleration = plus(tape, carried, along(qdd));
            (link.omega, link.alpha) = (turned_omega, turned_alpha);
        } else {
            link.acceleration = carried;
            link.omega = plus(tape, turned_omega, along(qd));
            let alpha = plus(tape, turned_alpha, gyration);
            link.alpha = plus(tape, alpha, along(qdd));
        }
        link
    }

    /// Force and moment about its origin that move a link of these ten parameters.
    fn wrench(&self, own: &[Value], tape: &mut Tape) -> [Vector; 2] {
        let first = [own[1], own[2], own[3]];
        let rows = [[own[4], own[5], own[6]], [own[5], own[7], own[8]], [own[6], own[8], own[9]]];
        let weight = scaled(tape, own[0], self.acceleration);
        let tangential = cross(tape, self.alpha, first);
        let normal = swung(tape, self.omega, first);
        let force = plus(tape, weight, tangential);
        let force = plus(tape, force, normal);
        let lever = cross(tape, first, self.acceleration);
        let inertial = rows.map(|row| dot(tape, row, self.alpha));
        let spin = rows.map(|row| dot(tape, row, self.omega));
        let gyroscopic = cross(tape, self.omega, spin);
        let moment = plus(tape, lever, inertial);
        [force, plus(tape, moment, gyroscopic)]
    }

    /// From the frame before into its own.
    fn inward(&self, vector: Vector, tape: &mut Tape) -> Vector {
        let column = |axis: usize| self.fixed.map(|row| Value::Number(row[axis]));
        let [x, y, z] = [0, 1, 2].map(|axis| dot(tape, column(axis), vector));
        let Some([cos, sin]) = self.turn else { return [x, y, z] };
        let [xc, ys, xs, yc] = [(cos, x), (sin, y), (sin, x), (cos, y)].map(|(wave, value)| tape.mul(wave, value));
        [tape.add(xc, ys), tape.sub(yc, xs), z]
    }

    /// From its own frame into the one before.
    fn outward(&self, [x, y, z]: Vector, tape: &mut Tape) -> Vector {
        let turned = match self.turn {
            None => [x, y, z],
            Some([cos, sin]) => {
                let [xc, ys, xs, yc] =
                    [(cos, x), (sin, y), (sin, x), (cos, y)].map(|(wave, value)| tape.mul(wave, value));
                [tape.sub(xc, ys), tape.add(xs, yc), z]
            }
        };
        self.fixed.map(|row| dot(tape, row.map(Value::Number), turned))
    }
}
