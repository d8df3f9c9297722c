//! The search for the shape of an effect beside the others: by Brent's method between the neighbours of its start value.

use rayon::prelude::*;

use super::state::Search;
use crate::diagnosis::candidates::Library;
use crate::model::ModelError;
use crate::model::ending::Ending;
use crate::model::line_search::{FINE, minimum};

/// Steps of a search for a shape that is to be compared with others, not yet kept.
pub(super) const COARSE: usize = 6;
/// Rounds over the shape parameters of an effect that has several.
const SHAPE_ROUNDS: usize = 2;

impl Search<'_> {
    /// Refines the shapes of what was found, each beside the others, and takes out what then is superfluous.
    pub(super) fn refine_found(&mut self) -> Result<(), ModelError> {
        for group in self.active.clone() {
            if let Some(shape) = self.best_shape(group, FINE)? {
                self.reshape(group, shape)?;
            }
        }
        self.prune();
        Ok(())
    }

    /// Gives the other forms of what was found their best shapes, so that a swap compares each at its best.
    pub fn refine_other_forms(&mut self) -> Result<(), ModelError> {
        let groups = &self.library.groups;
        let mut best: Vec<(usize, f64)> = Vec::new();
        for form in 0..groups.len() {
            let is_found = self.active.iter().any(|&found| groups[found].same_place_and_effect(&groups[form]));
            if is_found || !self.active.iter().any(|&found| groups[form].is_another_form_of(&groups[found])) {
                continue;
            }
            let cost = self.cost(&self.with(form));
            match best.iter_mut().find(|(other, _)| groups[*other].same_place_and_effect(&groups[form])) {
                Some(known) if cost < known.1 => *known = (form, cost),
                Some(_) => {}
                None => best.push((form, cost)),
            }
        }
        let shapes =
            best.par_iter().map(|&(form, _)| self.best_shape(form, FINE)).collect::<Result<Vec<_>, ModelError>>()?;
        for ((form, _), shape) in best.into_iter().zip(shapes) {
            shape.map_or(Ok(()), |shape| self.reshape(form, shape))?;
        }
        Ok(())
    }

    /// The best shape of a group beside the active ones, between the neighbours of its start value; `None`
    /// if there is none or it has it.
    pub(super) fn best_shape(&self, group: usize, steps: usize) -> Result<Option<Vec<f64>>, ModelError> {
        if self.library.groups[group].effect.shapes().next().is_none() {
            return Ok(None);
        }
        let candidate = self.library.groups[group].clone();
        // The group's own columns come last, so that a trial changes only the end of the equations.
        let mut groups = self.with(group);
        groups.retain(|&other| other != group);
        let others = self.columns(&groups);
        groups.push(group);
        let Library { design, torque, equations, columns, .. } = &self.library;
        let kept = others.iter().map(|&column| &columns[column]).collect();
        let mut ending = Ending::new(equations, kept, self.equations_of(&groups), torque, &self.weights);
        let mut cost = |shape: &[f64]| -> Result<f64, ModelError> {
            Ok(ending.residual_energy(&design.effect_columns(&candidate.term(), shape)?))
        };
        let least_shape = candidate.effect.least_shape(candidate.way);
        let mut shape = candidate.shape.clone();
        let start = cost(&shape)?;
        let mut least = start;
        // Several shape parameters influence each other.
        let rounds = if steps == COARSE { 1 } else { candidate.shape.len().min(SHAPE_ROUNDS) };
        for (number, (parameter, starts)) in (0..rounds).flat_map(|_| candidate.effect.shapes().enumerate()) {
            let value = shape[number];
            let [below, above] = starts.around(&starts.values(candidate.way), value);
            let below = below.max(least_shape[number]);
            let above = above.min(parameter.max);
            let mut trial = shape.clone();
            let (best, found) = minimum(starts.place(below), starts.place(above), steps, |place| {
                trial[number] = starts.value(place);
                cost(&trial)
            })?;
            if found < least {
                (shape[number], least) = (starts.value(best), found);
            }
        }
        Ok((least < start).then_some(shape))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::testing::{found, searched};
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    /// Along the way of joint 1 the torque bows, or it rises and falls two and a half times. Whatever wave comes nearest to a bow, it is none.
    #[test]
    fn a_torque_that_does_not_repeat_along_the_way_is_no_wave() {
        let found_with = |periods: f64| {
            let scenario = Scenario { effects: Vec::new(), torque_noise: 1e-3, ..Scenario::embedded() };
            let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
            let [low, high] = recording.way(0);
            for run in &mut recording.trajectories {
                let q = run.q[0].to_vec();
                let mut run = run.channels_mut();
                let wave = |q: f64| 0.5 * (TAU * periods * (q - low) / (high - low)).sin();
                run.tau[0].iter_mut().zip(q).for_each(|(tau, q)| *tau += wave(q));
            }
            found(&searched(&recording, &["cogging"]))
        };
        assert_eq!(found_with(0.8), []);
        assert_eq!(found_with(2.5), [("cogging", Some(0))]);
    }
}
