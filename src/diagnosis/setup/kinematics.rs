//! Derivatives that contradict each other need no rigid body to be seen: q̇ is a tenth of dq/dt, q̈ comes late behind dq̇/dt.
//!
//! Which of the channels is the wrong one follows from which pairs agree; where that leaves a choice, the torque decides.

use std::f64::consts::PI;

use crate::recording::Pick;
use crate::recording::check::Comparison;
use crate::recording::correction::{Correction, Part};
use crate::recording::finding::{Finding, FindingKind};
use crate::recording::{Origin, Recording};

/// Share of a derivative's power that the other channel must explain, for a factor or a delay between them to be clean.
const CLEAN: f64 = 0.9;
/// A factor further from 1 than this is another unit, not a badly scaled sensor.
const OTHER_UNIT: f64 = 1.4;
/// Factors are taken for one of these where they are nearly that.
const KNOWN: [f64; 9] = [-1.0, 180.0 / PI, PI / 180.0, 60.0 / (2.0 * PI), 2.0 * PI / 60.0, 10.0, 0.1, 1000.0, 0.001];
const NEARLY: f64 = 0.04;
/// Joints whose factors differ by more than this are not wrong in one way.
const ALIKE: f64 = 0.1;

/// How the two derivatives of a joint relate to what they are of: q̇ to dq/dt, q̈ to dq̇/dt. 1 and 0 where nothing is wrong, or
/// where the channel was derived.
struct Relation {
    joint: usize,
    factors: [f64; 2],
    lags: [f64; 2],
}

/// What may set right that derivatives contradict each other; empty where they do not, or in no clean way.
pub(super) fn corrections(pieces: &Recording, found: &[Finding]) -> Vec<Correction> {
    let mismatch = [FindingKind::VelocityMismatch, FindingKind::AccelerationMismatch];
    if !found.iter().any(|finding| mismatch.contains(&finding.kind)) {
        return Vec::new();
    }
    let relations: Option<Vec<Relation>> = (0..pieces.joint_count()).map(|joint| Relation::of(pieces, joint)).collect();
    let Some(relations) = relations else { return Vec::new() };
    let is_derived = pieces.provenance.acceleration != Origin::Measured;
    let scaled: Vec<&Relation> = relations.iter().filter(|relation| relation.is_scaled()).collect();
    let late: Vec<&Relation> = relations.iter().filter(|relation| relation.lags != [0.0; 2]).collect();
    match (scaled.is_empty(), late.is_empty()) {
        (false, true) => factors(&scaled, is_derived),
        (true, false) => delays(&late, is_derived),
        _ => Vec::new(),
    }
}

fn factors(scaled: &[&Relation], is_derived: bool) -> Vec<Correction> {
    let joints: Vec<usize> = scaled.iter().map(|relation| relation.joint).collect();
    let by = |part, factor: &dyn Fn(&Relation) -> f64| {
        let factors = scaled.iter().map(|relation| known(factor(relation))).collect();
        Correction::Factor { part, joints: joints.clone(), factors }
    };
    let is_one = |factor: f64| (factor - 1.0).abs() < ALIKE;
    let all = |holds: &dyn Fn([f64; 2]) -> bool| scaled.iter().all(|relation| holds(relation.factors));
    if all(&|[velocity, acceleration]| is_one(velocity) && !is_one(acceleration)) {
        return vec![by(Part::Acceleration, &|relation| 1.0 / relation.factors[1])];
    }
    if !is_derived && all(&|[velocity, acceleration]| !is_one(velocity) && is_one(velocity * acceleration)) {
        return vec![by(Part::Velocity, &|relation| 1.0 / relation.factors[0])];
    }
    if all(&|[velocity, acceleration]| !is_one(velocity) && is_one(acceleration)) {
        let rates = by(Part::Rates, &|relation| 1.0 / relation.factors[0]);
        return vec![rates, by(Part::Position, &|relation| relation.factors[0])];
    }
    Vec::new()
}

fn delays(late: &[&Relation], is_derived: bool) -> Vec<Correction> {
    let mean = |which: usize| late.iter().map(|relation| relation.lags[which]).sum::<f64>() / late.len() as f64;
    let delay = |part, seconds: f64| Correction::Delay { part, seconds };
    let all = |holds: &dyn Fn([f64; 2]) -> bool| late.iter().all(|relation| holds(relation.lags));
    if all(&|[velocity, acceleration]| velocity == 0.0 && acceleration != 0.0) {
        return vec![delay(Part::Acceleration, mean(1))];
    }
    if !is_derived && all(&|[velocity, acceleration]| velocity * acceleration < 0.0) {
        return vec![delay(Part::Velocity, mean(0))];
    }
    if all(&|[velocity, acceleration]| velocity != 0.0 && acceleration == 0.0) {
        return vec![delay(Part::Rates, mean(0)), delay(Part::Position, -mean(0))];
    }
    Vec::new()
}

/// A factor that is nearly a known one is that.
fn known(factor: f64) -> f64 {
    KNOWN.into_iter().find(|known| (factor / known - 1.0).abs() < NEARLY).unwrap_or(factor)
}

impl Relation {
    /// `None` where a pair is related in no clean way.
    fn of(pieces: &Recording, joint: usize) -> Option<Relation> {
        let provenance = &pieces.provenance;
        let pairs: [(&Origin, Pick, Pick); 2] = [
            (&provenance.velocity, |run| &run.q, |run| &run.qd),
            (&provenance.acceleration, |run| &run.qd, |run| &run.qdd),
        ];
        let (mut factors, mut lags) = ([1.0; 2], [0.0; 2]);
        for (which, (origin, signal, stated)) in pairs.into_iter().enumerate() {
            if *origin != Origin::Measured {
                continue;
            }
            // A joint that does not move has nothing to contradict.
            let Some(found) = Comparison::of(pieces, joint, signal, stated) else { continue };
            if found.agreement < CLEAN {
                return None;
            }
            factors[which] = found.factor;
            lags[which] = if found.is_late() { found.lag_seconds } else { 0.0 };
        }
        Some(Relation { joint, factors, lags })
    }

    fn is_scaled(&self) -> bool {
        self.factors.iter().any(|factor| *factor < 0.0 || factor.ln().abs() > OTHER_UNIT.ln())
    }
}
