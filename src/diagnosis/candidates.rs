//! What could be missing: each effect on each joint, for each start value of its shape, as columns beside the model's own.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use super::report::NotKnown;
use crate::effect::{Effect, NotApplicable, Scope, Way};
use crate::model::design::Design;
use crate::model::equations::{Equations, PreparedColumn};
use crate::model::terms::{Alteration, Found, OperatingPoint};
use crate::model::{EffectTerm, Fitted, Model, ModelError, reversal};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::encoders::Side;
use crate::signals::Signals;

/// Share of a column's squared length that prices its factor where all candidates explain at once.
const DAMPING: f64 = 1e-7;

/// The model's columns and those of all candidates, with their normal equations.
pub struct Library<'a> {
    /// The model that lacks something.
    fitted: Fitted,
    /// The prepared data.
    pub design: Design<'a>,
    /// How many columns belong to the model itself and to its reversals, beside every candidate.
    pub base: usize,
    /// The candidates.
    pub groups: Vec<Group>,
    /// Normal equations of all columns.
    pub equations: Equations,
    /// All columns, prepared.
    pub columns: Vec<PreparedColumn>,
    /// Torque that the model's known part leaves.
    pub torque: Vec<Signals>,
}

/// One candidate: an effect at a place with a shape. It enters or stays out as a whole.
#[derive(Debug, Clone)]
pub struct Group {
    /// The effect.
    pub effect: &'static Effect,
    /// The joint, from 0; `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// Shape parameters.
    pub shape: Vec<f64>,
    /// The way of its joint.
    pub way: Way,
    /// Its columns in the library.
    pub columns: Range<usize>,
}

impl Group {
    /// Price of the candidate in parameters: linear ones, and one more for each shape parameter that was searched.
    pub fn parameter_count(&self) -> usize {
        self.effect.parameters.len()
    }

    /// Whether the other one is the same effect at the same place, perhaps with another shape.
    pub fn same_place_and_effect(&self, other: &Group) -> bool {
        self.effect == other.effect && self.joint == other.joint
    }

    /// Whether its wave, if it is one, repeats along the way of its joint.
    pub fn repeats(&self) -> bool {
        self.effect.repeats_along(self.way, &self.shape)
    }

    /// Whether this one has all that `other` has and more (Stribeck has Coulomb).
    pub fn includes(&self, other: &Group) -> bool {
        self.joint == other.joint && self.effect.contains(other.effect)
    }

    /// Whether both describe the same thing in two ways (Dahl and LuGre), so that only one of them can be there.
    pub fn is_another_form_of(&self, other: &Group) -> bool {
        self.joint == other.joint && (self.effect.looks_like(other.effect) || self.contradicts(other))
    }

    /// Whether only one of them can be there.
    pub fn excludes(&self, other: &Group) -> bool {
        self.is_another_form_of(other) || self.contradicts(other)
    }

    /// Whether one takes the encoders of the arm to be on the links and the other on the motors.
    fn contradicts(&self, other: &Group) -> bool {
        let sides = self.effect.facts.encoder.zip(other.effect.facts.encoder);
        sides.is_some_and(|(one, other)| one != other)
    }

    /// Whether it is about what is soft or loose in another joint, which all joints feel a little.
    fn is_seen_from_elsewhere(&self, joint: usize) -> bool {
        self.effect.facts.encoder == Some(Side::Motor) && self.joint != Some(joint)
    }

    /// The joints on which it makes torque; `None` for all.
    fn joints(&self) -> Option<std::ops::RangeInclusive<usize>> {
        let joint = self.joint?;
        Some(if self.effect.scope == Scope::Pair { joint - 1..=joint } else { joint..=joint })
    }

    /// Whether both make torque on a common joint.
    pub fn meets(&self, other: &Group) -> bool {
        match (self.joints(), other.joints()) {
            (Some(here), Some(there)) => here.start() <= there.end() && there.start() <= here.end(),
            _ => true,
        }
    }

    /// The model term that it stands for.
    pub fn term(&self) -> EffectTerm {
        EffectTerm { effect: self.effect, joint: self.joint }
    }
}

impl<'a> Library<'a> {
    /// Collects all candidates among `effects`, in whatever order they come, that the model does not have yet. Effects that can't be computed for these data are left
    /// out; their reasons come back beside the library.
    ///
    /// # Errors
    /// [`ModelError`] if the model itself can't be computed, or the work was stopped.
    pub fn new(
        fitted: &Fitted,
        design: Design<'a>,
        effects: &[&'static Effect],
        monitor: &Monitor,
    ) -> Result<(Library<'a>, Vec<NotKnown>), ModelError> {
        let model = &fitted.model;
        let (body, alterations) = (design.point().body.clone(), fitted.setting().alterations.clone());
        let design = design.at(OperatingPoint { body, effects: fitted.effects(), alterations });
        let mut columns = design.columns(model, fitted.shapes())?;
        columns.extend(reversal::companions(&design)?);
        let base = columns.len();
        monitor.report(0.15, "computing candidate effects")?;
        let mut places: Vec<Group> = Vec::new();
        let (mut effects, mut impossible) = among(effects, design.recording());
        effects.sort_by_key(|effect| effect.id);
        for effect in effects {
            for joint in effect.places(0..design.joint_count()) {
                if is_covered(model, effect, joint) {
                    continue;
                }
                let way = design.way(joint);
                let least_shape = effect.least_shape(way);
                let seen = |shape: &Vec<f64>| shape.iter().zip(&least_shape).all(|(value, least)| value >= least);
                let shapes = start_shapes(effect, way).into_iter().filter(seen);
                let group = |shape| Group { effect, joint, shape, way, columns: 0..0 };
                places.extend(shapes.map(group));
            }
        }
        let prepare = |group: &Group| {
            monitor.check()?;
            design.effect_columns(&group.term(), &group.shape)
        };
        let prepared: Vec<Result<Vec<PreparedColumn>, ModelError>> = places.par_iter().map(prepare).collect();
        let mut groups = Vec::new();
        for (group, prepared) in places.into_iter().zip(prepared) {
            match prepared {
                Ok(prepared) => {
                    let first = columns.len();
                    columns.extend(prepared);
                    groups.push(Group { columns: first..columns.len(), ..group });
                }
                Err(ModelError::NotApplicable(NotApplicable { lack, .. })) => {
                    let unknown = NotKnown::NotComputed { effect: group.effect, lack };
                    if !impossible.contains(&unknown) {
                        impossible.push(unknown);
                    }
                }
                Err(error) => return Err(error),
            }
        }
        monitor.report(0.4, "normal equations of all candidates")?;
        let torque = design.unexplained_torque(model)?;
        let equations = design.equations(&columns, &torque);
        Ok((Library { design, fitted: fitted.clone(), base, groups, equations, columns, torque }, impossible))
    }

    /// The first group of each effect at each of its places; the others are further shapes of it.
    pub fn firsts(&self) -> Vec<usize> {
        let groups = &self.groups;
        let is_first =
            |&group: &usize| groups[..group].iter().all(|other| !other.same_place_and_effect(&groups[group]));
        (0..groups.len()).filter(is_first).collect()
    }

    /// Whether the model's body is identified, so that it absorbs what it can.
    pub fn is_body_free(&self) -> bool {
        !self.fitted.model.is_pinned()
    }

    /// What one squared unit of a joint's residual says: 1 / variance of what all candidates together can't explain of its
    /// torque. If that is not white, neighbouring samples say the same again and count as one.
    pub fn certainty(&self, joint: usize) -> f64 {
        let (acting, equations) = self.equations.of_joint(joint);
        let elsewhere = self.groups.iter().filter(|group| group.is_seen_from_elsewhere(joint));
        let elsewhere: Vec<usize> = elsewhere.flat_map(|group| group.columns.clone()).collect();
        let kept: Vec<usize> = (0..acting.len()).filter(|&place| !elsewhere.contains(&acting[place])).collect();
        let solution = equations.select(&kept).damped(DAMPING).solve();
        let mut factors = DVector::zeros(self.columns.len());
        for (&place, &factor) in kept.iter().zip(&solution.factors) {
            factors[acting[place]] = factor;
        }
        self.certainty_beside(joint, &factors, solution.rank())
    }

    /// The same for what these factors of all columns leave, of which `rank` were fitted.
    pub fn certainty_beside(&self, joint: usize, factors: &DVector<f64>, rank: usize) -> f64 {
        let free = self.design.sample_count(joint).saturating_sub(rank).max(1) as f64;
        let blocks = 0..self.equations.block_count();
        let left: f64 = blocks.map(|block| self.equations.residual_energy(block, joint, factors)).sum();
        // An exact fit has no error to weigh by: rounding would decide.
        let energy = left.max(1e-20 * self.design.energy(joint));
        let correlation = self.equations.correlation(&self.columns, factors, &self.torque, joint);
        if energy > 0.0 { free / (energy * correlation) } else { 0.0 }
    }

    /// Takes the load from other factors of the model, and what alters other effects from it and from what was `found` beside it,
    /// and computes anew every column that depends on them. Whether any does;
    /// none if the model identifies no rigid body.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn reload(&mut self, factors: &[f64], found: Vec<Found>) -> Result<bool, ModelError> {
        let Some(body) = self.fitted.body_among(factors) else { return Ok(false) };
        let now = &self.design.point().alterations;
        let mut point = OperatingPoint::new(Some(body), self.all_effects(factors, found.clone()));
        let is_altered = !Alteration::are_alike(&point.alterations, now);
        if !is_altered {
            point.alterations.clone_from(now);
        }
        let design = self.design.at(point);
        if !is_altered && !design.has_other_loads_than(&self.design) {
            return self.pass(factors, found);
        }
        self.design = design;
        let own_change = self.fitted.model.depends_on_load() || is_altered;
        self.renew(own_change, |group| is_altered || group.effect.facts.depends_on_load)
    }

    /// Whether the columns take account of just those effects that change others which the model has or which were `found` beside it.
    pub fn is_altered_by(&self, found: &[Found]) -> bool {
        let (own, now) = (&self.fitted.setting().alterations, &self.design.point().alterations);
        let mut found = OperatingPoint::new(None, found.to_vec()).alterations;
        found.extend(own.iter().cloned());
        found.len() == now.len() && found.iter().all(|one| now.iter().any(|other| other.term == one.term))
    }

    /// Lets what was `found` pass through the candidates that change what others do (friction comes before a lag), and computes
    /// their columns anew. Whether there are any.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn pass(&mut self, factors: &[f64], found: Vec<Found>) -> Result<bool, ModelError> {
        let effects = self.all_effects(factors, found);
        self.design = self.design.at(OperatingPoint { effects, ..self.design.point().clone() });
        self.renew(!self.fitted.setting().alterations.is_empty(), |group| group.effect.changes_others())
    }

    /// The effects of the model, and those that were `found` beside it.
    fn all_effects(&self, factors: &[f64], found: Vec<Found>) -> Vec<Found> {
        let mut effects = self.fitted.effects_among(factors);
        effects.extend(found);
        effects
    }

    /// Computes the columns of these candidates anew, and the model's own if they change, too; whether any did.
    fn renew(&mut self, own_change: bool, concerns: impl Fn(&Group) -> bool) -> Result<bool, ModelError> {
        let mut changed = Vec::new();
        if own_change {
            let own = self.design.columns(&self.fitted.model, self.fitted.shapes())?;
            changed.extend(0..own.len());
            self.columns.splice(0..own.len(), own);
        }
        let concerned: Vec<&Group> = self.groups.iter().filter(|group| concerns(group)).collect();
        let prepare = |group: &&Group| self.design.effect_columns(&group.term(), &group.shape);
        let prepared = concerned.par_iter().map(prepare).collect::<Result<Vec<_>, ModelError>>()?;
        for (group, prepared) in concerned.into_iter().zip(prepared) {
            self.columns.splice(group.columns.clone(), prepared);
            changed.extend(group.columns.clone());
        }
        self.equations.update(&self.columns, &changed, &self.torque);
        let torque = self.design.unexplained_torque(&self.fitted.model)?;
        if torque != self.torque {
            self.torque = torque;
            self.equations.replace_torque(&self.columns, &self.torque);
            return Ok(true);
        }
        Ok(!changed.is_empty())
    }

    /// Gives a candidate another shape.
    ///
    /// # Errors
    /// [`ModelError`] if the effect can't be computed with it.
    pub fn reshape(&mut self, group: usize, shape: Vec<f64>) -> Result<(), ModelError> {
        let range = self.groups[group].columns.clone();
        let prepared = self.design.effect_columns(&self.groups[group].term(), &shape)?;
        self.columns.splice(range.clone(), prepared);
        self.equations.update(&self.columns, &range.collect::<Vec<_>>(), &self.torque);
        self.groups[group].shape = shape;
        Ok(())
    }
}

/// Those of these effects whose formula may hold in a recording like this, and why the others may not.
fn among(effects: &[&'static Effect], recording: &Recording) -> (Vec<&'static Effect>, Vec<NotKnown>) {
    let kept = effects.iter().copied().filter(|effect| effect.lack_in(recording).is_none()).collect();
    let not_known =
        |&effect: &&'static Effect| Some(NotKnown::NotComputed { effect, lack: effect.lack_in(recording)? });
    (kept, effects.iter().filter_map(not_known).collect())
}

/// Whether the model has the effect there, by itself or inside another one.
fn is_covered(model: &Model, effect: &Effect, joint: Option<usize>) -> bool {
    model.effects().any(|term| term.joint == joint && (term.effect == effect || term.effect.contains(effect)))
}

/// All combinations of the start values of the shape parameters; one empty combination for effects without shape.
fn start_shapes(effect: &Effect, way: Way) -> Vec<Vec<f64>> {
    effect.shapes().fold(vec![Vec::new()], |shapes, (_, starts)| {
        let values = starts.values(way);
        let extended = shapes.iter().flat_map(|shape| {
            values.iter().map(move |&value| {
                let mut longer = shape.clone();
                longer.push(value);
                longer
            })
        });
        extended.collect()
    })
}
