//! Editing the list of terms: every edit identifies the parameters anew, so the errors are always those of the model shown.

use std::path::Path;

use super::Session;
use super::error::SessionError;
use super::step::step;
use crate::effect::{Effect, Scope, own, registry};
use crate::file;
use crate::model::{Model, Term};
use crate::progress::Monitor;
use crate::recording::{JointKind, joints_text};

/// A change of the list of terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TermEdit {
    /// Takes an effect out of the model: its place in the list.
    Remove(usize),
    /// The same, but keeps it at hand.
    SwitchOff(usize),
    /// Puts back what was switched off: its place in [`Session::set_aside`].
    SwitchOn(usize),
    /// Forgets what was switched off: its place in [`Session::set_aside`].
    Forget(usize),
    /// Moves a term to another place of the list; nothing but the order changes.
    Move {
        /// Where it is.
        from: usize,
        /// Where it goes.
        to: usize,
    },
}

impl TermEdit {
    pub(super) fn title(self) -> &'static str {
        match self {
            TermEdit::Remove(_) => "remove a term",
            TermEdit::SwitchOff(_) => "switch a term off",
            TermEdit::SwitchOn(_) => "switch a term on",
            TermEdit::Forget(_) => "forget a term",
            TermEdit::Move { .. } => "move a term",
        }
    }
}

pub(super) fn edit(session: &Session, edit: TermEdit, monitor: &Monitor) -> Result<Session, SessionError> {
    let current = session.current().ok_or(SessionError::NoModel)?;
    let mut terms = current.fitted.model.terms.clone();
    let mut set_aside = session.set_aside.clone();
    match edit {
        TermEdit::Remove(place) | TermEdit::SwitchOff(place) => {
            let term = terms.get(place).ok_or(SessionError::NoSuchTerm { count: terms.len() })?;
            if !matches!(term, Term::Effect(_)) {
                return Err(SessionError::Base(term.label()));
            }
            let term = terms.remove(place);
            if matches!(edit, TermEdit::SwitchOff(_)) {
                set_aside.push(term);
            }
        }
        TermEdit::SwitchOn(place) | TermEdit::Forget(place) => {
            if place >= set_aside.len() {
                return Err(SessionError::NoSuchTerm { count: set_aside.len() });
            }
            let term = set_aside.remove(place);
            if matches!(edit, TermEdit::Forget(_)) {
                return Ok(Session { set_aside, ..session.clone() });
            }
            if terms.contains(&term) {
                return Err(SessionError::AlreadyThere(term.label()));
            }
            terms.push(term);
        }
        TermEdit::Move { from, to } => {
            if from >= terms.len() || to >= terms.len() {
                return Err(SessionError::NoSuchTerm { count: terms.len() });
            }
            if current.fitted.model.is_learned() {
                return Err(SessionError::FixedOrder);
            }
            let term = terms.remove(from);
            terms.insert(to, term);
            return with_order(session, Model { terms }, monitor);
        }
    }
    let model = Model { terms };
    let mut ladder = session.ladder.clone();
    // Taking out what was added last goes back to the step before it.
    let before = ladder.len().checked_sub(2).map(|before| &ladder[before]);
    if before.is_some_and(|before| before.fitted.model == model) {
        ladder.pop();
    } else {
        ladder.push(step(model, Some(&current.fitted), session, monitor)?);
    }
    Ok(Session { ladder, set_aside, report: None, proposals: None, ..session.clone() })
}

/// The current step with its terms in another order.
fn with_order(session: &Session, model: Model, monitor: &Monitor) -> Result<Session, SessionError> {
    let mut ladder = session.ladder.clone();
    let old = ladder.pop();
    ladder.push(step(model, None, session, monitor)?);
    // It takes the place of what it was before: the same model is not two.
    let mut models = session.models.clone();
    models.retain(|kept| kept.step().map(|step| step.generation) != old.as_ref().map(|old| old.generation));
    Ok(Session { ladder, models, ..session.clone() })
}

/// Reads an effect of one's own.
pub(super) fn load(session: &Session, path: &Path) -> Result<Session, SessionError> {
    let text = file::read_text(path).map_err(|problem| SessionError::EffectFile { path: path.to_owned(), problem })?;
    let effect = own::load(&text).map_err(|problem| SessionError::OwnEffect { path: path.to_owned(), problem })?;
    Ok(with_own(session, effect))
}

/// The session with an effect of one's own more; a report that was made without it is gone.
fn with_own(session: &Session, effect: &'static Effect) -> Session {
    let mut session = session.clone();
    if !session.own_effects.contains(&effect) {
        session.own_effects.push(effect);
        session.report = None;
    }
    session
}

/// Makes a proposal an effect of one's own, unless the catalogue has it, and adds it.
pub(super) fn adopt(session: &Session, number: usize, monitor: &Monitor) -> Result<Session, SessionError> {
    let proposals = session.proposals.as_ref().map_or(&[][..], |proposals| &proposals.formulas);
    let count = proposals.len();
    let proposal = proposals.get(number).ok_or(SessionError::NoSuchProposal { number: number + 1, count })?;
    if let Some(known) = proposal.known {
        return add(session, known.id, &[proposal.joint], monitor);
    }
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let kind = recording.joints.get(proposal.joint).map_or(JointKind::Revolute, |joint| joint.kind);
    let effect = own::load(&proposal.draft(kind).to_toml()).map_err(SessionError::Adoption)?;
    add(&with_own(session, effect), effect.id, &[proposal.joint], monitor)
}

/// Adds an effect and identifies all parameters anew.
pub(super) fn add(session: &Session, id: &str, joints: &[usize], monitor: &Monitor) -> Result<Session, SessionError> {
    let current = session.current().ok_or(SessionError::NoModel)?;
    let effect = registry::find(id)?;
    if effect.scope != Scope::Arm && joints.is_empty() {
        return Err(SessionError::NoJoint(effect.name.to_owned()));
    }
    let old = &current.fitted.model;
    let model = old.with_effect(effect, joints)?;
    if model == *old {
        return Err(SessionError::AlreadyThere(effect_text(effect, joints)));
    }
    let mut ladder = session.ladder.clone();
    let added = step(model.clone(), Some(&current.fitted), session, monitor)?;
    let absorbed = added
        .fitted
        .parameters
        .iter()
        .any(|parameter| !parameter.identified && is_of(&model.terms[parameter.term], effect));
    if !absorbed {
        ladder.push(added);
        return Ok(Session { ladder, report: None, proposals: None, ..session.clone() });
    }
    // Beside free base parameters the effect can't be seen, so the rigid body is held at the stated arm first, as a step of
    // its own: what the effect gains is then the difference between the last two steps.
    let stated = current.fitted.setting().stated_arm();
    let arm = match &stated {
        Some(arm) if !old.is_pinned() => arm,
        _ => return Err(SessionError::Absorbed(effect_text(effect, joints))),
    };
    ladder.push(step(old.pinned_to(arm), None, session, monitor)?);
    ladder.push(step(model.pinned_to(arm), None, session, monitor)?);
    Ok(Session { ladder, report: None, proposals: None, ..session.clone() })
}

/// `Coulomb friction on joints 1, 2`.
pub(super) fn effect_text(effect: &Effect, joints: &[usize]) -> String {
    match effect.scope {
        Scope::Arm => effect.name.to_owned(),
        Scope::Joint | Scope::Pair => format!("{} on {}", effect.name, joints_text(joints)),
    }
}

fn is_of(term: &Term, effect: &Effect) -> bool {
    matches!(term, Term::Effect(term) if term.effect == effect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Command;
    use crate::simulation::{Excitation, Scenario};

    fn with_friction() -> Session {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        let simulate = Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }));
        let session = simulate.run(&Session::default(), &Monitor::new()).unwrap();
        let add = Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0, 1] };
        add.run(&session, &Monitor::new()).unwrap()
    }

    fn run(session: &Session, edit: TermEdit) -> Result<Session, SessionError> {
        Command::EditTerms(edit).run(session, &Monitor::new())
    }

    fn labels(session: &Session) -> Vec<String> {
        session.current().unwrap().fitted.model.terms.iter().map(Term::label).collect()
    }

    #[test]
    fn a_term_is_switched_off_and_on_again_with_its_old_error() {
        let session = with_friction();
        let errors = |session: &Session| session.current().unwrap().evaluation.held_out_nmse();
        let off = run(&session, TermEdit::SwitchOff(2)).unwrap();
        assert_eq!((labels(&off).len(), off.set_aside.len(), off.ladder.len()), (2, 1, 3));
        assert!(errors(&off)[1] > 10.0 * errors(&session)[1]);
        let on = run(&off, TermEdit::SwitchOn(0)).unwrap();
        assert!(on.set_aside.is_empty() && on.ladder.len() == 2, "it is back at the step before");
        assert_eq!((labels(&on), errors(&on)), (labels(&session), errors(&session)));
        assert!(run(&off, TermEdit::Forget(0)).unwrap().set_aside.is_empty());
    }

    #[test]
    fn the_order_changes_nothing_but_the_order() {
        let session = with_friction();
        let moved = run(&session, TermEdit::Move { from: 2, to: 0 }).unwrap();
        assert_eq!(labels(&moved)[0], "Coulomb friction, joint 2");
        assert_eq!(moved.ladder.len(), session.ladder.len());
        let [before, after] = [&session, &moved].map(|session| session.current().unwrap().evaluation.held_out[1].nmse);
        assert!((before - after).abs() < 1e-9 * before);
    }

    #[test]
    fn what_can_not_be_edited_is_said() {
        let session = with_friction();
        let message = |edit| run(&session, edit).unwrap_err().to_string();
        assert!(message(TermEdit::Remove(0)).contains("choose another preset"));
        assert!(message(TermEdit::Remove(9)).contains("one of its 3"));
        assert!(message(TermEdit::SwitchOn(0)).contains("no such term"));
    }
}
