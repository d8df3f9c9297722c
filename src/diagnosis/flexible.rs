//! Whether what is left of a joint's torque follows from the arm's state at all.
//!
//! A basis that is flexible enough for nearly any physics, and names none, is asked to predict blocks that were left out. What
//! it can predict is not noise: something is missing that is not among the candidates, or was named wrongly.

use rayon::prelude::*;

use super::search::Search;
use crate::effect::{Column, sign};
use crate::model::ModelError;
use crate::model::equations::PreparedColumn;
use crate::model::least_squares::NormalEquations;
use crate::recording::Trajectory;
use crate::signals::Signals;

/// Share of a column's squared length that prices its factor, so that the basis does not chase noise.
const DAMPING: f64 = 1e-3;
/// A block where the basis has to guess beyond its data counts no worse than so many times the error without it.
const WORST: f64 = 1.5;
/// Speeds and torques below these shares of the largest count as near zero, in two widths.
const NEAR: [f64; 2] = [0.04, 0.15];
/// Distances over which a friction builds up after a reversal, as shares of the joint's range.
const BREAKAWAY: [f64; 2] = [0.02, 0.1];
/// Distances since the last reversal within which a slack is passed, as shares of the joint's range.
const SLACKS: [f64; 2] = [0.005, 0.03];
/// Waves over the joint's range.
const WAVES: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// The share of what a set of groups leaves of each joint that a flexible basis predicts on left-out blocks; 0 where that is noise.
///
/// # Errors
/// [`ModelError`] if a column can't be computed.
pub fn predicted(search: &Search, set: &[usize]) -> Result<Vec<f64>, ModelError> {
    (0..search.weights.len()).into_par_iter().map(|joint| predicted_of(search, set, joint)).collect()
}

/// The same of one joint.
fn predicted_of(search: &Search, set: &[usize], joint: usize) -> Result<f64, ModelError> {
    let library = &search.library;
    let design = &library.design;
    let known = search.columns(set);
    let mut columns: Vec<PreparedColumn> = known.iter().map(|&column| library.columns[column].clone()).collect();
    let largest = |signal: fn(&Trajectory) -> &Signals| -> Vec<f64> {
        let of_joint = |joint: usize| {
            let sizes = design.recording().trajectories.iter().flat_map(|trajectory| &signal(trajectory)[joint]);
            sizes.fold(0.0, |most: f64, value| most.max(value.abs())).max(f64::MIN_POSITIVE)
        };
        (0..design.joint_count()).map(of_joint).collect()
    };
    let scale = Scale {
        q: largest(|trajectory| &trajectory.q),
        qd: largest(|trajectory| &trajectory.qd),
        qdd: largest(|trajectory| &trajectory.qdd),
        load: largest(|trajectory| &trajectory.tau)[joint],
    };
    columns.extend(design.prepare(|trajectory, load| {
        let load = load.map(|load| &load.torque[joint]);
        Ok(basis(trajectory, load, joint, &scale))
    })?);
    let equations = design.equations(&columns, &library.torque);
    let blocks: Vec<NormalEquations> =
        (0..equations.block_count()).map(|block| equations.total(&search.weights, |other| other == block)).collect();
    let mut whole = NormalEquations::empty(columns.len());
    blocks.iter().for_each(|block| whole.add(block, 1.0));
    let all: Vec<usize> = (0..columns.len()).collect();
    let own: Vec<usize> = (0..known.len()).collect();
    let (mut before, mut after) = (0.0, 0.0);
    for (number, block) in blocks.iter().enumerate() {
        let mut rest = whole.without(block);
        let left = equations.select(number, joint, &own).residual_energy(&rest.select(&own).solve().factors);
        for column in known.len()..columns.len() {
            rest.gram[(column, column)] *= 1.0 + DAMPING;
        }
        let with_basis = equations.select(number, joint, &all).residual_energy(&rest.solve().factors);
        before += left;
        after += with_basis.min(WORST * left);
    }
    Ok(if before > 0.0 { (1.0 - after / before).max(0.0) } else { 0.0 })
}

/// Largest size of each signal, so that the basis works on numbers between -1 and 1.
struct Scale {
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
    load: f64,
}

/// The basis of one joint along one trajectory.
fn basis(trajectory: &Trajectory, load: Option<&[f64]>, joint: usize, scale: &Scale) -> Vec<Column> {
    let count = trajectory.len();
    let duration = trajectory.time.last().zip(trajectory.time.first()).map_or(1.0, |(end, start)| end - start);
    let mut values: Vec<Vec<f64>> = Vec::new();
    let mut hysteresis = BREAKAWAY.map(|_| 0.0f64);
    let (mut direction, mut since_reversal) = (0.0, 0.0f64);
    for t in 0..count {
        let scaled = |signal: &Signals, scale: &[f64], joint: usize| signal[joint][t] / scale[joint];
        let q = scaled(&trajectory.q, &scale.q, joint);
        let qd = scaled(&trajectory.qd, &scale.qd, joint);
        let qdd = scaled(&trajectory.qdd, &scale.qdd, joint);
        let load_at = |t: usize| load.map_or(0.0, |load| load[t] / scale.load);
        let (load_now, load_rate) = (load_at(t), load_at((t + 1).min(count - 1)) - load_at(t.saturating_sub(1)));
        let time = (trajectory.time[t] - trajectory.time[0]) / duration.max(f64::MIN_POSITIVE);
        let sign_qd = sign(qd);
        let travel = q - trajectory.q[joint][t.saturating_sub(1)] / scale.q[joint];
        for (state, distance) in hysteresis.iter_mut().zip(BREAKAWAY) {
            let limit = if travel == 0.0 { *state } else { travel.signum() };
            *state = limit + (*state - limit) * (-travel.abs() / distance).exp();
        }
        if travel != 0.0 {
            since_reversal = if travel.signum() == direction { since_reversal + travel.abs() } else { travel.abs() };
            direction = travel.signum();
        }
        let mut row = Vec::with_capacity(values.len());
        let powers = |x: f64, count: i32| (1..=count).map(move |power| x.powi(power));
        row.push(1.0);
        row.extend(powers(q, 5));
        row.extend(powers(qd, 5));
        row.extend(powers(qdd, 3));
        row.extend(powers(load_now, 3));
        row.extend(powers(time, 2));
        row.extend([
            sign_qd,
            sign_qd * qd * qd,
            sign_qd * load_now.abs(),
            sign_qd * time,
            load_now.abs(),
            load_rate,
            qdd * qdd.abs(),
        ]);
        row.extend(powers(q, 4).map(|q| sign_qd * q));
        row.extend(powers(q, 2).flat_map(|q| [qd * q, qdd * q, load_now * q]));
        row.extend(NEAR.map(|near| sign_qd * (-(qd / near).powi(2)).exp()));
        row.extend(NEAR.map(|near| (load_now / near).tanh()));
        row.extend(hysteresis);
        row.extend(
            SLACKS
                .map(|slack| (-since_reversal / slack).exp())
                .into_iter()
                .flat_map(|near| [near * direction, near * load_now, near * load_now.abs() * direction, near * qdd]),
        );
        row.extend(WAVES.iter().flat_map(|wave| [(wave * q).cos(), (wave * q).sin()]));
        for other in [joint.checked_sub(1), Some(joint + 1).filter(|&other| other < trajectory.joint_count())] {
            let Some(other) = other else { continue };
            let qd = scaled(&trajectory.qd, &scale.qd, other);
            row.extend([scaled(&trajectory.q, &scale.q, other), qd, sign(qd)]);
            row.push(scaled(&trajectory.qdd, &scale.qdd, other));
        }
        if values.is_empty() {
            values = vec![Vec::with_capacity(count); row.len()];
        }
        values.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
    values.into_iter().map(|values| Column { parts: vec![(joint, values)] }).collect()
}
