//! Effects that the base parameters absorb, found by holding the identified parameters against the stated ones.
//!
//! A payload that never changes moves the base parameters and leaves no residual. Where the recording states its arm, the
//! difference can be seen: with the rigid body held at the stated parameters the error is larger than with free ones, and
//! an absorbed effect is named if it alone explains that difference.

use super::candidates::Library;
use super::search::{MARGIN, Search};
use crate::arm::stated::{Resistance, StatedArm};
use crate::model::least_squares::NormalEquations;
use crate::model::property::{Property, plain_columns};
use crate::model::{Model, RigidBody, Term};

/// Smallest share of the torque (RMS) by which the two must differ: less is what filters and encoders make.
const LEAST_SHARE: f64 = 0.005;
/// Share of the difference that may remain unexplained.
const REMAINDER: f64 = 0.05;

/// What the comparison with the stated arm says.
#[derive(Debug, Clone, PartialEq)]
pub enum Comparison {
    /// There is no stated arm, or the model does not identify a rigid body.
    NotPossible,
    /// Identified and stated parameters agree within their errors.
    Agrees,
    /// These groups explain the difference.
    Explained(Vec<usize>),
    /// No absorbed effect explains the difference.
    Differs,
}

/// What a stated arm says of the columns of a search: in the plane or in space, the links, and the inertia of rotors where that can't
/// be told from a link's.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedBody {
    arm: StatedArm,
    /// What is stated to resist joints whose rotor the links take up: its inertia alone, as friction is found beside either.
    rotors: Vec<Resistance>,
    /// The columns of links and of these rotors, with what is stated of them.
    factors: Vec<(usize, f64)>,
    /// How many of them are of the links; in the library they are the first.
    of_links: usize,
}

impl StatedBody {
    /// Of the arm that the recording states, beside a model that identifies a rigid body.
    pub fn of(search: &Search, model: &Model) -> Option<StatedBody> {
        let setting = search.library.design.setting();
        let identifies = model.terms.first() == Some(&Term::RigidBody(RigidBody::Identified));
        let arm = setting.stated_arm().filter(|_| identifies)?;
        let parameters = arm.parameters();
        let of_links = parameters.len();
        if of_links > search.library.base {
            return None;
        }
        let mut factors: Vec<(usize, f64)> = parameters.into_iter().enumerate().collect();
        let joints = search.library.design.joint_count();
        let mut rotors = vec![Resistance::default(); joints];
        for group in search.absorbed.iter().map(|&group| &search.library.groups[group]) {
            let resistance = group.joint.and_then(|joint| setting.resistances.get(joint));
            let (Some(joint), Some(resistance)) = (group.joint, resistance) else { continue };
            let is_rotor = plain_columns(&group.term(), joints) == [Some(Property::Armature)];
            if is_rotor && resistance.rotor_inertia != 0.0 {
                factors.push((group.columns.start, resistance.rotor_inertia));
                rotors[joint].rotor_inertia = resistance.rotor_inertia;
            }
        }
        Some(StatedBody { arm, rotors, factors, of_links })
    }

    /// The model with its rigid body held at what is stated.
    pub fn held(&self, model: &Model) -> Model {
        let mut model = model.pinned_to(&self.arm);
        if self.rotors.iter().any(|rotor| !rotor.is_none()) {
            model.terms.insert(1, Term::Resistance(self.rotors.clone()));
        }
        model
    }
}

/// Compares identified and stated base parameters, beside the effects found so far.
pub fn compare(search: &Search, stated: Option<&StatedBody>) -> Comparison {
    let Some(stated) = stated else { return Comparison::NotPossible };
    let free = search.cost(&search.active);
    let pinned = |extra: &[usize]| pinned_cost(search, stated, extra);
    let difference = pinned(&[]) - free;
    let mut found: Vec<usize> = Vec::new();
    let mut cost = pinned(&[]);
    let share = (difference.max(0.0) / search.equations_of(&[]).energy.max(f64::MIN_POSITIVE)).sqrt();
    if difference < MARGIN * search.price || share < LEAST_SHARE {
        return Comparison::Agrees;
    }
    while found.len() < search.absorbed.len() {
        let open = search.absorbed.iter().copied().filter(|group| !found.contains(group));
        let with = |group: usize| {
            let mut groups = found.clone();
            groups.push(group);
            groups
        };
        let best = open
            .filter(|&group| is_physical(search, stated, &with(group)))
            .map(|group| (group, pinned(&with(group))))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((group, better)) = best else { break };
        let price = search.library.groups[group].parameter_count() as f64 * search.price;
        // The same for each further one: what is less is as well an error of the body that was found.
        if cost - better < MARGIN * price || (!found.is_empty() && cost - better < REMAINDER * difference) {
            break;
        }
        found.push(group);
        cost = better;
    }
    let remainder = cost - free;
    let price = stated.of_links as f64 * search.price;
    if remainder > REMAINDER * difference && remainder > MARGIN * price {
        return Comparison::Differs;
    }
    if found.is_empty() { Comparison::Agrees } else { Comparison::Explained(found) }
}

/// How much worse it gets if `rival` stands for `group` beside the stated arm.
pub fn rival_cost(search: &Search, stated: &StatedBody, found: &[usize], group: usize, rival: usize) -> f64 {
    let swapped: Vec<usize> = found.iter().map(|&other| if other == group { rival } else { other }).collect();
    pinned_cost(search, stated, &swapped) - pinned_cost(search, stated, found)
}

/// Weighted squared error with the rigid body held at the stated parameters, beside the effects found and `extra`.
fn pinned_cost(search: &Search, stated: &StatedBody, extra: &[usize]) -> f64 {
    pinned_equations(search, stated, extra).solve().residual_energy
}

fn is_physical(search: &Search, stated: &StatedBody, extra: &[usize]) -> bool {
    let solution = pinned_equations(search, stated, extra).solve();
    let Library { groups, .. } = &search.library;
    let mut factors = solution.factors.iter().rev();
    extra.iter().rev().all(|&group| {
        let parameters: Vec<_> = groups[group].effect.linear().collect();
        parameters
            .iter()
            .rev()
            .zip(factors.by_ref())
            .all(|(parameter, &value)| (parameter.min..=parameter.max).contains(&value))
    })
}

/// The equations of everything but the rigid body, whose torque is taken as known: y − Yβ stands for y.
fn pinned_equations(search: &Search, stated: &StatedBody, extra: &[usize]) -> NormalEquations {
    let mut groups = search.active.clone();
    groups.extend(extra);
    let rest = search.columns(&groups).split_off(stated.of_links);
    let (known, values): (Vec<usize>, Vec<f64>) = stated.factors.iter().copied().unzip();
    let (beta, count) = (nalgebra::DVector::from_vec(values), known.len());
    let all = search.whole_of(&[known, rest].concat());
    let rest: Vec<usize> = (count..all.moment.len()).collect();
    let mut pinned = all.select(&rest);
    let known = all.gram.view((0, 0), (count, count)) * &beta;
    pinned.energy += beta.dot(&known) - 2.0 * beta.dot(&all.moment.rows(0, count));
    pinned.moment -= all.gram.view((count, 0), (rest.len(), count)) * &beta;
    pinned
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::diagnosis::excerpt::Excerpt;
    use crate::diagnosis::presence::Judged;
    use crate::diagnosis::presence::calibration::Calibration;
    use crate::diagnosis::{Searched, naming};
    use crate::effect::registry;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::seal::HiddenEffect;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// What the comparison says of an arm of one link with a load of 0.5 kg, or none, among these candidates.
    fn compared(mass: f64, candidates: &[&str], look: impl Fn(&mut Search, &StatedBody, Comparison)) {
        let motion = Excitation::PaperPointToPoint { trajectories: 8, duration: 4.0, samples: 100, range: 2.0 };
        let load = HiddenEffect { effect: "tip-payload".to_owned(), joint: None, parameters: vec![mass] };
        let effects = if mass > 0.0 { vec![load] } else { Vec::new() };
        let arm = crate::arm::Arm::uniform(1);
        let recording = simulate(&Scenario { motion, arm, effects, ..Scenario::embedded() }, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let model = Preset::RigidBody.model(&recording).unwrap();
        let body = model::fit(&model, &recording, &split, &Monitor::new()).unwrap();
        let effects: Vec<_> = candidates.iter().map(|id| registry::find(id).unwrap()).collect();
        let excerpt = Excerpt::of(&recording, &split);
        let mut searched = Searched::new(&effects, &body, &excerpt, &Monitor::new()).unwrap();
        let stated = StatedBody::of(&searched.search, &model).unwrap();
        let comparison = compare(&searched.search, Some(&stated));
        look(&mut searched.search, &stated, comparison);
        assert_eq!(compare(&searched.search, None), Comparison::NotPossible);
        let pinned = stated.held(&model);
        assert!(pinned.is_pinned() && StatedBody::of(&searched.search, &pinned).is_none(), "it identifies no body");
    }

    /// A load moves the base parameters as the inertia of a rotor can't: it has weight.
    #[test]
    fn a_load_that_the_base_parameters_absorb_is_named_beside_the_stated_arm() {
        compared(0.5, &["tip-payload", "rotor-inertia"], |search, stated, comparison| {
            let group_of = |id: &str| search.library.groups.iter().position(|group| group.effect.id == id).unwrap();
            let [load, rotor] = ["tip-payload", "rotor-inertia"].map(group_of);
            assert_eq!(comparison, Comparison::Explained(vec![load]));
            let worse = rival_cost(search, stated, &[load], load, rotor);
            assert!(worse > 100.0, "{worse}");
            assert!((rival_cost(search, stated, &[load], load, load)).abs() < 1e-6);
            let judged = Judged::of(search, Calibration::learned()).unwrap();
            let named = naming::name_effects(search, &[], &comparison, Some(stated), &judged);
            let [named] = &named[..] else { panic!("one effect") };
            assert_eq!((named.effect.id, &*named.joints, named.pins), ("tip-payload", &[0][..], true));
            assert!(named.alternatives.is_empty() && named.presence > 0.97 && named.form() > 0.97);
        });
    }

    #[test]
    fn an_arm_that_is_as_stated_agrees_and_one_that_nothing_explains_differs() {
        compared(0.0, &["tip-payload", "rotor-inertia"], |_, _, comparison| assert_eq!(comparison, Comparison::Agrees));
        compared(0.5, &["rotor-inertia"], |_, _, comparison| assert_eq!(comparison, Comparison::Differs));
    }
}
