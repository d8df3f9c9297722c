//! What to do next, in plain words.

use super::report::{MissingEffect, Verdict};
use super::stated_arm::Comparison;
use crate::effect::registry;
use crate::model::Preset;
use crate::recording::joints_text;

/// What can't be told apart, and what would tell.
fn doubt(effect: &MissingEffect) -> Option<String> {
    let name = |id: &str| registry::find(id).map_or(id.to_owned(), |effect| effect.name.to_owned());
    let others: Vec<String> = effect.alternatives.iter().map(|id| name(id)).collect();
    let open = format!("These data hardly tell {} from {}", name(&effect.effect), others.join(" or "));
    match (&effect.telling_motion, others.is_empty()) {
        (_, true) => None,
        (Some(telling), _) => Some(format!(
            "{open}; record {}, which gives {} the evidence against {}.",
            telling.motion,
            telling.times(),
            name(&telling.against)
        )),
        (None, _) => Some(format!("{open}, and no other motion would do it better.")),
    }
}

/// What to do next, in plain words.
pub fn advice(
    verdict: Verdict,
    effects: &[MissingEffect],
    unexplained: &[usize],
    comparison: &Comparison,
    impossible: &[String],
) -> String {
    let mut sentences = Vec::new();
    match (verdict, effects.first()) {
        (Verdict::Missing | Verdict::Ambiguous, Some(first)) => {
            let name = registry::find(&first.effect).map_or(first.effect.as_str(), |effect| effect.name);
            sentences.push(format!("Add {name} on {} first.", joints_text(&first.joints)));
            if verdict == Verdict::Ambiguous {
                sentences.extend(effects.iter().filter_map(doubt));
            }
            if !unexplained.is_empty() {
                let joints = joints_text(unexplained);
                sentences.push(format!(
                    "The residual of {joints} is still more than noise: no effect of the catalogue explains the rest."
                ));
            }
        }
        (Verdict::UnknownEffect, Some(_)) => sentences.push(
            "What was named may only stand in for something that is not in the catalogue: look at the residual views before \
             you add it."
                .to_owned(),
        ),
        (Verdict::UnknownEffect, None) => sentences.push(format!(
            "The residual of {} is not noise, but no effect of the catalogue explains it: look at it in the residual \
             views.",
            joints_text(unexplained)
        )),
        _ => sentences.push("Nothing is missing that these data could show.".to_owned()),
    }
    if *comparison == Comparison::Differs {
        sentences.push(format!(
            "The identified base parameters differ from the stated arm, and no single effect explains how: check the stated \
             masses and lengths, or keep the preset `{}`.",
            Preset::RigidBody.id()
        ));
    }
    let mut impossible: Vec<&String> = impossible.iter().collect();
    impossible.sort();
    impossible.dedup();
    sentences.extend(impossible.into_iter().map(|reason| format!("Not known: {reason}.")));
    sentences.join(" ")
}
