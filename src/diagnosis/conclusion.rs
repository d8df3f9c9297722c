//! The answer in a word, and what to do next or to doubt.

use super::report::{MissingEffect, Note, Verdict};
use super::search::FEWEST_BLOCKS;
use super::stated_arm::Comparison;
use crate::effect::EncoderSide;

/// Below this confidence the verdict is "ambiguous".
const SURE: f64 = 0.8;
/// The highest on joints whose residual is still more than noise: what was named may stand in for what is really there.
pub const HIGHEST_BESIDE_UNKNOWN: f64 = 0.45;

/// The answer in a word.
pub fn verdict(effects: &[MissingEffect], unexplained: &[usize], comparison: &Comparison) -> Verdict {
    let doubted =
        |effect: &MissingEffect| effect.confidence <= HIGHEST_BESIDE_UNKNOWN && effect.alternatives.is_empty();
    if effects.is_empty() {
        let is_known = unexplained.is_empty() && *comparison != Comparison::Differs;
        return if is_known { Verdict::NothingMissing } else { Verdict::UnknownEffect };
    }
    if effects.iter().all(doubted) {
        return Verdict::UnknownEffect;
    }
    if effects.iter().any(|effect| effect.confidence < SURE && !effect.alternatives.is_empty()) {
        return Verdict::Ambiguous;
    }
    Verdict::Missing
}

/// What to do next, and what to doubt; the search had so many `blocks` to leave out.
pub fn notes(
    verdict: Verdict,
    effects: &[MissingEffect],
    unexplained: &[usize],
    comparison: &Comparison,
    blocks: usize,
) -> Vec<Note> {
    let mut notes = Vec::new();
    match (verdict, effects.first()) {
        (Verdict::Missing | Verdict::Ambiguous, Some(first)) => {
            notes.push(Note::AddFirst { effect: first.effect, joints: first.joints.clone() });
            if verdict == Verdict::Ambiguous {
                notes.extend(effects.iter().filter_map(hardly_told));
            }
            let on_link = effects.iter().filter(|named| named.effect.facts.encoder == EncoderSide::Link);
            notes.extend(on_link.map(|named| Note::NeedsLinkEncoder { effect: named.effect }));
            if !unexplained.is_empty() {
                notes.push(Note::MoreThanNoise { joints: unexplained.to_vec() });
            }
        }
        (Verdict::UnknownEffect, Some(_)) => notes.push(Note::MayStandIn),
        (Verdict::UnknownEffect, None) => notes.push(Note::NoneExplains { joints: unexplained.to_vec() }),
        _ => notes.push(Note::NothingShown),
    }
    if blocks < FEWEST_BLOCKS && !effects.is_empty() {
        notes.push(Note::NotConfirmable { blocks });
    }
    if *comparison == Comparison::Differs {
        notes.push(Note::StatedArmDiffers);
    }
    notes
}

fn hardly_told(named: &MissingEffect) -> Option<Note> {
    let (effect, from, telling) = (named.effect, named.alternatives.clone(), named.telling_motion);
    (!from.is_empty()).then_some(Note::HardlyTold { effect, from, telling })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::registry;

    fn named(id: &str) -> MissingEffect {
        MissingEffect {
            effect: registry::find(id).unwrap(),
            joints: vec![0],
            confidence: 0.9,
            parameters: Vec::new(),
            nmse_before: Vec::new(),
            nmse_after: Vec::new(),
            alternatives: Vec::new(),
            telling_motion: None,
            evidence: Vec::new(),
        }
    }

    /// With one block or two nothing can be left out, so nothing is confirmed; the gates let pass what they can't judge.
    #[test]
    fn too_few_blocks_are_noted() {
        let notes = |blocks| notes(Verdict::Missing, &[named("coulomb-friction")], &[], &Comparison::Agrees, blocks);
        for blocks in [1, 2] {
            assert!(notes(blocks).contains(&Note::NotConfirmable { blocks }), "{blocks}");
        }
        assert_eq!(notes(3), [Note::AddFirst { effect: named("coulomb-friction").effect, joints: vec![0] }]);
    }

    #[test]
    fn an_effect_between_motor_and_link_says_where_its_encoder_is() {
        let notes = notes(Verdict::Missing, &[named("joint-elasticity")], &[], &Comparison::Agrees, 16);
        assert_eq!(notes[1], Note::NeedsLinkEncoder { effect: named("joint-elasticity").effect });
    }
}
