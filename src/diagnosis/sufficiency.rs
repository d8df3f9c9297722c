//! Whether data can show an effect at all: asked when the truth is known, to judge a diagnosis by what it could have found.

use super::candidates::Library;
use super::search::{MARGIN, Search};
use crate::effect::registry;
use crate::model::design::Design;
use crate::model::{Fitted, ModelError};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;

/// An effect that is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// Its id in the registry.
    pub effect: String,
    /// The joint (from 0); `None` for an effect of the whole arm.
    pub joint: Option<usize>,
    /// Its shape parameters.
    pub shape: Vec<f64>,
}

/// How clearly the data show these effects beside `fitted`: at least 1 where the evidence suffices.
///
/// The true set, with its true shapes, is laid against each set that lacks one of its effects or has another one in its place, and for
/// an odd form two everyday effects with no more parameters (Coulomb and viscous friction for a power of the speed). The smallest evidence for the truth (drop of the weighted squared error, less the price of the parameters) counts, in units
/// of the evidence that a name needs. Effects that the base parameters absorb count where the arm is stated.
///
/// # Errors
/// [`ModelError`] if a column can't be computed, or the work was stopped.
pub fn sufficiency(
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    suspects: &[Suspect],
    monitor: &Monitor,
) -> Result<f64, ModelError> {
    let (library, _) = Library::new(fitted, Design::new(recording, split)?, &registry::sought(), monitor)?;
    let mut search = Search::new(library);
    let mut groups = Vec::new();
    for suspect in suspects {
        let is_it =
            |group: &super::candidates::Group| group.effect.id == suspect.effect && group.joint == suspect.joint;
        let Some(group) = search.library.groups.iter().position(is_it) else { return Ok(0.0) };
        search.reshape(group, suspect.shape.clone())?;
        groups.push(group);
    }
    search.find_absorbed();
    search.active = groups.clone();
    search.reload()?;
    search.refine_other_forms()?;
    let truth = search.priced_cost(&groups);
    let mut least = f64::INFINITY;
    for &group in &groups {
        if search.absorbed.contains(&group) {
            least = if recording.states_arm() { least } else { 0.0 };
            continue;
        }
        let without: Vec<usize> = groups.iter().copied().filter(|&other| other != group).collect();
        let price = search.price_of(group);
        least = least.min((search.priced_cost(&without) - truth) / (MARGIN * price));
        let rivals = search.rivals(group);
        if !search.library.groups[group].effect.facts.everyday {
            for set in search.simpler_than(group, &rivals) {
                least = least.min((search.priced_cost(&set) - truth) / (MARGIN * search.price));
            }
        }
        for rival in rivals {
            // What contains the effect explains as much for a higher price.
            if search.library.groups[rival.group].includes(&search.library.groups[group]) {
                continue;
            }
            let priced = rival.cost + search.price_of_all(&rival.set);
            least = least.min((priced - truth) / (MARGIN * search.price));
        }
    }
    Ok(least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Preset;
    use crate::simulation::{Excitation, Scenario, simulate};

    fn of(strength: f64, suspects: &[Suspect]) -> f64 {
        let mut scenario = Scenario { seed: 3, stated: false, effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut scenario.motion {
            (*trajectories, *duration, *rate) = (6, 5.0, 60.0);
        }
        scenario.effects = scenario.hide_by_strength("viscous-friction", &[1], strength).unwrap();
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let model = Preset::RigidBody.model(&recording).unwrap();
        let body = crate::model::fit(&model, &recording, &split, &Monitor::new()).unwrap();
        sufficiency(&body, &recording, &split, suspects, &Monitor::new()).unwrap()
    }

    fn suspect(effect: &str, joint: usize) -> Suspect {
        Suspect { effect: effect.to_owned(), joint: Some(joint), shape: Vec::new() }
    }

    /// Evidence grows with the square of the strength; for what is not there, beside what is, there is none.
    #[test]
    fn evidence_is_that_of_what_is_there() {
        let friction = suspect("viscous-friction", 1);
        let [weak, strong] = [0.01, 0.1].map(|strength| of(strength, std::slice::from_ref(&friction)));
        assert!(strong > 1.0 && weak > 0.0 && strong > 5.0 * weak, "{weak}, {strong}");
        assert!(of(0.1, &[friction.clone(), suspect("viscous-friction", 2)]) < 1.0);
        assert!(of(0.1, &[suspect("viscous-friction", 0)]) < 1.0, "the friction is on another joint");
        assert!(of(0.1, &[suspect("tip-payload", 0)]) <= 0.0, "no joint has a payload");
        assert_eq!(of(0.1, &[]), f64::INFINITY, "nothing has to be shown");
    }
}
