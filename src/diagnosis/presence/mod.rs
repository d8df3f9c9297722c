//! Is it there? For each family of effects on each joint, how the evidence of it compares with everything else that may be there.
//!
//! A [`Sighting`] is what the data say of one family at one place once the search has spoken: how much torque it carries, how
//! much of that nothing else explains, how steady it is from block to block, in how many halves of the data it is found again
//! (`halves`), whether the other joints have it too if it is what nearly every joint has, and how much is left beside it. Each clue is a ratio, so none has a unit. A posterior of the same data would be too sure of itself wherever the residual is not the noise that
//! it assumes, which is on every real robot; so the clues pass a small map that was learned where the truth is known
//! ([`calibration`]).
//!
//! Source of the clues: the Wald statistic with a covariance that is robust to blocks (Liang and Zeger, Biometrika 73 (1986) 13),
//! the von Neumann ratio (Ann. Math. Stat. 12 (1941) 367).

pub mod calibration;
mod halves;
mod judged;

pub(super) use judged::Judged;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use super::flexible;
use super::search::{MARGIN, Search, gates};
use crate::effect::{Effect, Family, registry};
use crate::model::ModelError;
use crate::model::fit::{ALONG_A_COLUMN, unseen};
use crate::model::least_squares::NormalEquations;

/// From this presence on a family is named. Of what that names more than 0.75 does, 17 of 23 were right on planted logs (KR 300 and DFKI,
/// seeds 1 and 2 of `torquescope bench planted`) and 5 of 5 in the worlds of seeds 2001 to 2072; weak effects of real
/// logs, which stand near either, are lost less often (2026-11-26).
pub const LIKELY: f64 = 0.65;
/// From this presence on a family is likelier there than not.
pub const EVEN: f64 = 0.5;
/// From this presence on the held-out part is asked about a family: what is there on a real robot often stands between this and [`EVEN`]
/// (viscous friction of joint 3 of the KR 300, the offset of EMPS that is published); to ask about more costs time and names what is not
/// there (a spring in recording 37 of the forty, from 0.3 on).
pub const WORTH_ASKING: f64 = 0.4;
/// From this presence on, once the held-out part was asked, what not nearly every joint has is named where the answer leaves something
/// unknown on any joint: it may stand in for that. Of such names between [`LIKELY`] and this 6 of 31 were right on planted real logs (seeds 1000
/// and 10000 of `torquescope bench planted`, all on arms that leave something unknown), and 10 of 11 in worlds and the forty, of which one
/// leaves anything (2026-11-29).
pub const BESIDE_THE_UNKNOWN: f64 = 0.8;
/// From this presence on it is said to be there.
pub const SURE: f64 = 0.9;

/// Names of the clues, in their order.
pub const CLUES: [&str; 13] = [
    "ln(1 + Wald)",
    "ln(share / 2 %)",
    "ln(unique share / 1 %)",
    "ln(unique share / rest of its joint)",
    "ln(unique share / worst rest)",
    "ln(worst rest / 1 %)",
    "ln(whiteness)",
    "what a flexible basis predicts of the rest",
    "ln(share / unique share)",
    "ln(1 + families for each joint)",
    "share of the halves that find it",
    "the same on the other joints, of what nearly every joint has",
    "asinh(evidence over its price)",
];
/// What share of a joint's torque (RMS) may act there unseen, as it was when the map of `assets/presence.json` was learned.
const UNSEEN: f64 = 0.001;
/// What is left has a law if a flexible basis predicts this share of it on left-out blocks, and that is this share of the torque (RMS).
/// On the draws and worlds that the map was learned on, one complete answer of 184 is called incomplete by that alone.
const MOSTLY: f64 = 0.5;
const WORTH_A_THOUGHT: f64 = 0.01;
/// Shares below this are taken for it: an exact fit leaves rounding only.
const LEAST_SHARE: f64 = 1e-4;

/// What the data say of one family at one place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sighting {
    /// The family.
    pub family: Family,
    /// Its joint, from 0; `None` for the whole arm.
    pub joint: Option<usize>,
    /// The form in which it explains most: the one that was found, or the best candidate.
    pub effect: &'static Effect,
    /// Whether the search found it.
    pub found: bool,
    /// Whether that form may be it: its parameters lie within their bounds, a wave repeats along the way, and no formula of what was found
    /// leaves it.
    pub possible: bool,
    /// RMS of its torque over that of the measured torque, on the joint where it is largest.
    pub share: f64,
    /// The same of what nothing else explains.
    pub unique: f64,
    /// The clues, in the order of [`CLUES`].
    pub clues: [f64; CLUES.len()],
}

impl Sighting {
    /// Whether it acts on this joint.
    pub fn acts_on(&self, joint: usize) -> bool {
        self.joint.is_none_or(|own| own == joint)
    }

    /// Whether the evidence speaks for it, and yet it is not likely with this presence.
    pub fn is_doubtful(&self, presence: f64) -> bool {
        presence < EVEN && self.found
    }
}

/// What is left of each joint with the effects found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rest {
    /// RMS over that of the measured torque, by joint.
    pub share: Vec<f64>,
    /// The same without any effect that was found.
    pub before: Vec<f64>,
    /// 1 for noise that was white before it was filtered, near 0 for what moves as slowly as the arm, from ρ₁ of the residual, by joint.
    pub whiteness: Vec<f64>,
    /// Share of the residual that a flexible basis predicts on left-out blocks, by joint.
    pub predicted: Vec<f64>,
}

impl Rest {
    /// Of the effects that the search has found, and of what their formulas leave.
    fn of(search: &Search) -> Result<Rest, ModelError> {
        let explained = gates::with_what_is_left(search);
        let [before, factors] = [&[], explained.as_slice()].map(|set| search.factors(set));
        let joints = 0..search.weights.len();
        let energies = Energies::new(search);
        let left = |joint: usize, factors: &DVector<f64>| energies.left(joint, factors).sqrt().max(LEAST_SHARE);
        Ok(Rest {
            share: joints.clone().map(|joint| left(joint, &factors)).collect(),
            before: joints.clone().map(|joint| left(joint, &before)).collect(),
            whiteness: joints.map(|joint| 1.0 - search.structure(joint, &factors)).collect(),
            predicted: flexible::predicted(search, &explained)?,
        })
    }

    /// Whether a flexible basis predicts most of what is left on a joint: little it may be, but it has a law.
    pub fn has_law(&self, joint: usize) -> bool {
        let predicted = self.predicted[joint].max(0.0);
        predicted > MOSTLY && self.share[joint] * predicted.sqrt() > WORTH_A_THOUGHT
    }
}

/// Every family at every place that the data can show, once the search has spoken, and what is left.
///
/// # Errors
/// [`ModelError`] if a column of the flexible basis can't be computed.
pub(super) fn look(search: &Search) -> Result<(Vec<Sighting>, Rest), ModelError> {
    let rest = Rest::of(search)?;
    let groups = &search.library.groups;
    let mut places: Vec<(Family, Option<usize>)> =
        groups.iter().map(|group| (group.effect.family, group.joint)).collect();
    places.sort_unstable();
    places.dedup();
    let energies = Energies::new(search);
    let beside = energies.beside(search, &rest);
    let seen: Vec<Seen> = places.into_par_iter().filter_map(|place| Seen::of(search, place)).collect();
    let groups: Vec<Vec<usize>> = seen.iter().map(|seen| seen.groups.clone()).collect();
    let steady = halves::steadiness(search, &groups);
    let elsewhere = elsewhere(&seen, &steady);
    let sight = |(seen, steady): (Seen, [f64; 2])| sighting(search, &rest, &energies, beside, seen, steady);
    let steady: Vec<[f64; 2]> = steady.into_iter().zip(elsewhere).map(<[f64; 2]>::from).collect();
    let sightings = seen.into_par_iter().zip(steady).filter_map(sight).collect();
    Ok((sightings, rest))
}

/// How steady each of these is on the other joints of the arm, on which motors and gears are mostly of one make. 0 for what not
/// nearly every joint has, and for what is of the whole arm.
fn elsewhere(seen: &[Seen], steady: &[f64]) -> Vec<f64> {
    let is_everyday =
        |family: Family| registry::sought().iter().any(|effect| effect.family == family && effect.facts.everyday);
    let of_one = |one: &Seen| {
        let is_other = |(other, _): &(&Seen, &f64)| other.family == one.family && other.joint != one.joint;
        let others: Vec<f64> = seen.iter().zip(steady).filter(is_other).map(|(_, steady)| *steady).collect();
        let counts = one.joint.is_some() && !others.is_empty() && is_everyday(one.family);
        if counts { others.iter().sum::<f64>() / others.len() as f64 } else { 0.0 }
    };
    seen.iter().map(of_one).collect()
}

/// A family at a place, in the form in which it explains most.
struct Seen {
    family: Family,
    joint: Option<usize>,
    /// Whether the search found it.
    found: bool,
    /// What of it was found, or its best candidate.
    groups: Vec<usize>,
    /// What else was found.
    others: Vec<usize>,
}

impl Seen {
    fn of(search: &Search, (family, joint): (Family, Option<usize>)) -> Option<Seen> {
        let all = &search.library.groups;
        let is_it = |&group: &usize| all[group].effect.family == family && all[group].joint == joint;
        let (mut groups, others): (Vec<usize>, Vec<usize>) = search.active.iter().copied().partition(is_it);
        let found = !groups.is_empty();
        if !found {
            let seen = (0..all.len()).filter(|group| is_it(group) && !search.absorbed.contains(group));
            groups = vec![search.best_beside(&others, seen)?];
        }
        Some(Seen { family, joint, found, groups, others })
    }
}

/// The squared length of each joint's torque and its normal equations over all blocks.
struct Energies {
    joints: Vec<(Vec<usize>, NormalEquations)>,
}

impl Energies {
    fn new(search: &Search) -> Self {
        let of_joint = |joint: usize| {
            let (acting, equations) = search.library.equations.of_joint(joint);
            (acting.to_vec(), equations)
        };
        Energies { joints: (0..search.weights.len()).map(of_joint).collect() }
    }

    /// Share of the joint's energy that these factors of all columns leave.
    fn left(&self, joint: usize, factors: &DVector<f64>) -> f64 {
        let (acting, equations) = &self.joints[joint];
        let here = DVector::from_fn(acting.len(), |i, _| factors[acting[i]]);
        equations.residual_energy(&here) / equations.energy.max(f64::MIN_POSITIVE)
    }

    /// Weighted energy of what is not noise beside the effects found: what is left and not white, and what may act unseen.
    fn beside(&self, search: &Search, rest: &Rest) -> f64 {
        let factors = search.factors(&search.active);
        let of_joint = |joint: usize| {
            let energy = self.joints[joint].1.energy;
            let left = self.left(joint, &factors) * energy;
            search.weights[joint] * (left * (1.0 - rest.whiteness[joint]) + unseen(UNSEEN, energy, left))
        };
        (0..self.joints.len()).map(of_joint).sum()
    }

    /// Share of the joint's energy that these columns carry.
    fn carried(&self, joint: usize, columns: &[usize], factors: &DVector<f64>) -> f64 {
        let (acting, equations) = &self.joints[joint];
        let here =
            DVector::from_fn(acting.len(), |i, _| if columns.contains(&acting[i]) { factors[acting[i]] } else { 0.0 });
        here.dot(&(&equations.gram * &here)) / equations.energy.max(f64::MIN_POSITIVE)
    }
}

fn sighting(
    search: &Search,
    rest: &Rest,
    energies: &Energies,
    beside: f64,
    seen: Seen,
    [steady, elsewhere]: [f64; 2],
) -> Option<Sighting> {
    let groups = &search.library.groups;
    let Seen { family, joint: place, found, groups: mine, others } = seen;
    let with: Vec<usize> = others.iter().chain(&mine).copied().collect();
    let (before, after) = (search.factors(&others), search.factors(&with));
    let columns: Vec<usize> = mine.iter().flat_map(|&group| groups[group].columns.clone()).collect();
    let shown = |joint: usize| energies.carried(joint, &columns, &after);
    let on = (0..search.weights.len()).max_by(|&a, &b| shown(a).total_cmp(&shown(b)))?;
    let share = shown(on).sqrt();
    let gain = search.cost(&others) - search.cost(&with);
    let count: usize = mine.iter().map(|&group| groups[group].parameter_count()).sum();
    let price: f64 = mine.iter().map(|&group| search.price_of(group)).sum();
    let wald = (gain / count as f64).min(robust_wald(search, &with, &mine, beside)?).max(0.0);
    let unique = (energies.left(on, &before) - energies.left(on, &after)).max(0.0).sqrt().max(LEAST_SHARE);
    let own_rest = energies.left(on, &after).sqrt().max(LEAST_SHARE);
    let worst = rest.share.iter().copied().fold(LEAST_SHARE, f64::max);
    let felt: Vec<usize> = place.map_or((0..search.weights.len()).collect(), |_| vec![on]);
    let least = |values: &[f64]| felt.iter().map(|&joint| values[joint]).fold(f64::INFINITY, f64::min);
    let most = |values: &[f64]| felt.iter().map(|&joint| values[joint]).fold(0.0, f64::max);
    let families = search.active.len() as f64 / search.weights.len() as f64;
    let clues = [
        wald.ln_1p(),
        (share.max(1e-5) / 0.02).ln(),
        (unique / 0.01).ln().max(-3.0),
        (unique / own_rest).ln(),
        (unique / worst).ln(),
        (worst / 0.01).ln(),
        (least(&rest.whiteness) + 0.02).ln(),
        most(&rest.predicted),
        (share / unique).max(1.0).ln(),
        families.ln_1p(),
        steady,
        elsewhere,
        (gain / (MARGIN * price)).asinh(),
    ];
    let main = mine.iter().copied().max_by(|&a, &b| {
        let carried = |group: usize| energies.carried(on, &groups[group].columns.clone().collect::<Vec<_>>(), &after);
        carried(a).total_cmp(&carried(b))
    })?;
    Some(Sighting {
        family,
        joint: place,
        effect: groups[main].effect,
        found,
        possible: gates::is_physical(search, &with, main)
            && groups[main].repeats()
            && gates::leaves_it(search, &with, main).is_none(),
        share,
        unique,
        clues,
    })
}

/// θᵀV⁻¹θ for each column of these groups beside all of the set; `None` if the data can't show each of them. A column that two
/// have (Coulomb friction, in forms of dry friction) counts once. V is from the sums of scores over
/// blocks, and from the energy of what acts `beside` them, which may lie along the columns in every block alike.
fn robust_wald(search: &Search, set: &[usize], mine: &[usize], beside: f64) -> Option<f64> {
    let all = search.columns(set);
    let solution = search.solve(set);
    let kept: Vec<usize> = (0..all.len()).filter(|&place| solution.identified[place]).collect();
    let shown: Vec<usize> = kept.iter().map(|&place| all[place]).collect();
    let mut own: Vec<usize> = Vec::new();
    for &group in mine {
        let columns = search.library.groups[group].columns.clone();
        // What is alone must be shown whole.
        let least = if mine.len() > 1 { 1 } else { columns.len() };
        let here: Vec<usize> = columns.filter_map(|column| shown.iter().position(|other| *other == column)).collect();
        if here.len() < least {
            return None;
        }
        own.extend(here);
    }
    let theta = DVector::from_fn(kept.len(), |i, _| solution.factors[kept[i]]);
    let gram = search.equations_of(set).select(&kept).gram;
    let scale = DVector::from_fn(kept.len(), |i, _| 1.0 / gram[(i, i)].max(f64::MIN_POSITIVE).sqrt());
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |i, j| gram[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    let count = own.len();
    let mut spread = DMatrix::<f64>::zeros(count, count);
    let blocks = search.library.equations.block_count();
    for block in 0..blocks {
        let of_block = search.block_equations(block, &shown);
        let score = (of_block.moment - of_block.gram * &theta).component_mul(&scale);
        let step = DVector::from_fn(count, |i, _| inverse.row(own[i]).transpose().dot(&score) * scale[own[i]]);
        spread += &step * step.transpose();
    }
    spread *= blocks as f64 / (blocks as f64 - 1.0 - count as f64).max(1.0);
    let along = ALONG_A_COLUMN.powi(2) * beside;
    spread += along * DMatrix::from_fn(count, count, |i, j| inverse[(own[i], own[j])] * scale[own[i]] * scale[own[j]]);
    let ridge = 1e-9 * spread.trace() / count as f64 + f64::MIN_POSITIVE;
    for i in 0..count {
        spread[(i, i)] += ridge;
    }
    let mine = DVector::from_fn(count, |i, _| theta[own[i]]);
    Some(mine.dot(&spread.cholesky()?.solve(&mine)) / count as f64)
}
